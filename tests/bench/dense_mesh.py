#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the RIB of a dense mesh: a blob of N small triangles (a cube's lattice on a sphere, displaced) on a floor.

dense_mesh.py [--triangles N] [--request points|general] [--shuffle] [--colors] [--degenerate K] [--bumps A]
              [--mesh-only] OUT.rib

Binary RIB: indices are floats, which is exact up to 2^24 points (33 million triangles).
"""
import argparse
import struct

import numpy as np


def cube_sphere(n):
    """Points and quads of a cube's surface with n x n cells per side, welded; the points on the unit sphere."""
    j, i = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
    corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
    codes = []
    side = n + 1
    for axis in range(3):
        for high in (0, 1):
            quad = []
            for a, b in corners if high else corners[::-1]:
                lattice = [None] * 3
                lattice[axis], lattice[(axis + 1) % 3], lattice[(axis + 2) % 3] = np.full_like(a, high * n), a, b
                quad.append((lattice[0] * side + lattice[1]) * side + lattice[2])
            codes.append(np.stack([q.ravel() for q in quad], axis=1))
    codes = np.concatenate(codes).astype(np.int64)
    unique, index = np.unique(codes, return_inverse=True)
    points = np.stack([unique // (side * side), unique // side % side, unique % side], axis=1)
    points = np.tan((points / n * 2 - 1) * (np.pi / 4))  # cells of like solid angle
    return points / np.linalg.norm(points, axis=1, keepdims=True), index.reshape(-1, 4)


def blob(triangles, bumps):
    n = max(1, round((triangles / 12) ** 0.5))
    points, quads = cube_sphere(n)
    x, y, z = points.T
    r = 1 + bumps * (np.sin(5 * x + 1) * np.sin(4 * y) * np.sin(6 * z + 2) + 0.3 * np.sin(23 * x) * np.sin(29 * y) *
                     np.sin(31 * z) + 0.06 * np.sin(171 * x + 3 * y) * np.sin(163 * y) * np.sin(181 * z))
    # Both halves of a quad turn the way the quad turns.
    return points * r[:, None], np.concatenate([quads[:, [0, 1, 2]], quads[:, [2, 3, 0]]], axis=1).reshape(-1, 3)


def floats(values):
    values = np.asarray(values)
    count = values.size
    return bytes([0o310 + 3]) + struct.pack(">I", count) + values.astype(">f4").tobytes()


HEAD = """##RenderMan RIB-Structure 1.1
Display "dense.exr" "openexr" "rgba"
Format 256 256 1
PixelFilter "box" 1 1
PixelSamples 4 4
Projection "perspective" "float fov" [30]
ConcatTransform [1 0 0 0  0 0.96 -0.28 0  0 0.28 0.96 0  0 -0.2 5.2 1]
WorldBegin
Attribute "trace" "int maxdiffusedepth" [1]
LightSource "envlight" 1 "color lightcolor" [0.4 0.5 0.7]
LightSource "distantlight" 2 "float intensity" [2] "point from" [2 4 -3] "point to" [0 0 0]
Surface "matte" "float Kd" [0.8] "float Ka" [0]
AttributeBegin
  Color [0.8 0.5 0.3]
  Polygon "P" [-9 -1.1 -9  -9 -1.1 9  9 -1.1 9  9 -1.1 -9]
AttributeEnd
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out")
    parser.add_argument("--triangles", type=int, default=1000000)
    parser.add_argument("--request", choices=["points", "general"], default="points")
    parser.add_argument("--shuffle", action="store_true", help="faces and points in random order")
    parser.add_argument("--colors", action="store_true", help="a random color for each face")
    parser.add_argument("--degenerate", type=int, default=0, help="so many triangles without area")
    parser.add_argument("--bumps", type=float, default=0.12, help="height of the displacement; 0 = a sphere")
    parser.add_argument("--mesh-only", action="store_true", help="the request alone, to be read as an archive")
    options = parser.parse_args()
    points, faces = blob(options.triangles, options.bumps)
    random = np.random.default_rng(1)
    if options.shuffle:
        order = random.permutation(len(points))
        points = points[np.argsort(order)]
        faces = random.permutation(order[faces])
    if options.degenerate:
        faces[random.integers(len(faces), size=options.degenerate), 2] = faces[0, 0]
        faces[:, 1] = np.where(faces[:, 2] == faces[0, 0], faces[:, 0], faces[:, 1])
    with open(options.out, "wb") as out:
        if not options.mesh_only:
            # What a triangle takes while it is traced, and some room.
            room = f'Option "limits" "int geocachememory" [{max(262144, len(faces) * 64 // 1024)}]\n'
            out.write(HEAD.replace("WorldBegin", room + "WorldBegin").encode())
        general = options.request == "general"
        out.write(b"PointsGeneralPolygons " if general else b"PointsPolygons ")
        if general:
            out.write(floats(np.ones(len(faces))))
        out.write(floats(np.full(len(faces), 3)) + floats(faces) + b' "P" ' + floats(points))
        if options.colors:
            out.write(b' "uniform color Cs" ' + floats(random.random((len(faces), 3))))
        out.write(b"\n" if options.mesh_only else b"\nWorldEnd\n")
    print(f"{options.out}: {len(faces)} triangles, {len(points)} points")


main()
