#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A sculpture as a scanner would give it: a knotted tube of a million triangles, carved and rough, in a white hall that
is lit by a wide window. The faces are smaller than pixels, and most of their light has bounced off them already."""
import array
import math
import os
import struct
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from ribwriter import Rib, target_folder  # noqa: E402

ALONG, AROUND = 1600, 320  # cells of the tube, of two triangles each: 1 024 000


def knot(a):
    """Centre line of a trefoil: on a torus, three times around the tube while twice around the axis."""
    r = 0.72 + 0.3 * math.cos(3 * a)
    return (r * math.cos(2 * a), r * math.sin(2 * a), 0.36 * math.sin(3 * a))


def frame(a):
    """The centre and two directions across the tube. Both turn with the knot, so that the tube closes."""
    e = 1e-4
    p, q = knot(a - e), knot(a + e)
    t = [y - x for x, y in zip(p, q)]
    size = math.sqrt(sum(c * c for c in t))
    t = [c / size for c in t]
    out = (math.cos(2 * a), math.sin(2 * a), 0)
    along = sum(x * y for x, y in zip(t, out))
    u = [x - along * y for x, y in zip(out, t)]
    size = math.sqrt(sum(c * c for c in u))
    u = [c / size for c in u]
    return knot(a), u, (t[1] * u[2] - t[2] * u[1], t[2] * u[0] - t[0] * u[2], t[0] * u[1] - t[1] * u[0])


def sculpture(path):
    """Binary RIB: 17 bytes for each triangle. Trigonometry repeats around the tube, so it is put in tables."""
    sin, cos = math.sin, math.cos
    around = [2 * math.pi * j / AROUND for j in range(AROUND)]
    ring = [(cos(b), sin(b)) for b in around]
    fine = [0.0035 * sin(41 * b + 1) for b in around]
    points = array.array("f")
    for i in range(ALONG):
        a = 2 * math.pi * i / ALONG
        c, u, v = frame(a)
        chisel = 0.006 * sin(211 * a) + 0.004 * sin(347 * a + 2)  # rough, as hewn
        swell = 0.2 + 0.03 * sin(5 * a)
        for (x, y), b, f in zip(ring, around, fine):
            # Ropes that wind around, with a groove between each two of them.
            radius = swell - 0.035 * (1 - abs(sin(2.5 * b + 12 * a))) ** 3 + f * sin(173 * a + 3 * x) + chisel * (0.6 + 0.4 * y)
            x, y = x * radius, y * radius
            points.extend((c[0] + x * u[0] + y * v[0], c[1] + x * u[1] + y * v[1], c[2] + x * u[2] + y * v[2]))
    indices = array.array("f")
    for i in range(ALONG):
        p, q = i * AROUND, (i + 1) % ALONG * AROUND
        for j in range(AROUND):
            k = (j + 1) % AROUND
            indices.extend((p + j, q + j, q + k, p + j, q + k, p + k))

    def floats(values):
        if sys.byteorder == "little":
            values.byteswap()
        return b"\313" + struct.pack(">I", len(values)) + values.tobytes()

    counts = array.array("f", [3]) * (len(indices) // 3)
    with open(path, "wb") as file:
        file.write(b"PointsPolygons " + floats(counts) + floats(indices) + b' "P" ' + floats(points) + b"\n")


def hall(r):
    with r.block("Color [.42 .38 .33]"):
        r.quad((-3, 0, 3), (3, 0, 3), (3, 0, -4), (-3, 0, -4))
    with r.block("Color [.78 .77 .74]"):
        r.quad((-3, 3.6, 3), (3, 3.6, 3), (3, 0, 3), (-3, 0, 3))
        r.quad((-3, 3.6, -4), (3, 3.6, -4), (3, 3.6, 3), (-3, 3.6, 3))
        r.quad((3, 3.6, 3), (3, 3.6, -4), (3, 0, -4), (3, 0, 3))
        r.quad((-3, 0, -4), (3, 0, -4), (3, 3.6, -4), (-3, 3.6, -4))
        # On the left a window in its wall, three panes of sky.
        for y0, y1, z0, z1 in ((0, 0.7, -4, 3), (3.1, 3.6, -4, 3), (0.7, 3.1, -4, -2.6), (0.7, 3.1, 1.6, 3),
                               (0.7, 3.1, -1.3, -1.1), (0.7, 3.1, 0.1, 0.3)):
            r.box(-3.25, -3, y0, y1, z0, z1)
    with r.block("Color [.55 .2 .13]"):  # a warm screen, for its light
        r.box(1.9, 1.98, 0, 2.3, -0.4, 2.2)
    with r.block("Color [.62 .6 .57]"):
        r.cushion(-0.62, 0.62, 0, 0.42, -0.5, 0.5, 0.03)
        r.cushion(-0.55, 0.55, 0.42, 0.5, -0.43, 0.43, 0.03)


def main():
    folder = target_folder()
    sculpture(os.path.join(folder, "sculpture.rib"))
    r = Rib()
    r("##Scene dense_mesh",
      'Option "limits" "int geocachememory" [524288]')  # what a million faces take while they are traced, and room
    r.camera("dense_mesh", (256, 192), 40, (0.35, 1.7, -3.85), (-0.02, 1.42, 0))
    r('Attribute "trace" "int maxdiffusedepth" [5]', 'Surface "matte" "float Ka" [0] "float Kd" [1]')
    r.soft_box((-3.3, 1.95, -0.5), (0, 1.2, -0.5), 4.3, 2.5, (5.6, 6.1, 6.9))
    hall(r)
    with r.block("Color [.72 .66 .56]", "Translate 0 1.66 0", "Rotate 18 0 1 0", "Rotate 30 0 0 1"):
        r('ReadArchive "sculpture.rib"')
    r("WorldEnd")
    r.save(folder)


main()
