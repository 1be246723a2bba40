#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The corner of a walled garden: a NURBS floor displaced to cobbles, patch meshes displaced to a wall of bricks, a rock and a
column of subdivision surfaces, a NURBS vase and a bicubic teapot with waves; every surface has a texture of its own. A low
soft key light and the sky."""
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from ribwriter import Rib, fmt, fractal, smooth_noise, target_folder, texture  # noqa: E402


def cobble(s, t):
    """Distance from the nearest joint of a running bond of 6 x 8 rounded stones, 0 to 1, and the stone's number."""
    row = math.floor(t * 8)
    u, v = (s * 6 + 0.5 * (row % 2)) % 6, t * 8 % 1
    wobble = 0.07 * (smooth_noise(s * 24, t * 24, 5) - 0.5)
    edge = min(u % 1 + wobble, 1 - u % 1 - wobble, (v + wobble) * 0.75, (1 - v - wobble) * 0.75)
    return max(0, min(1, edge / 0.3)), math.floor(u) + 6 * (row % 8)


def brick(s, t):
    row = math.floor(t * 10)
    u, v = (s * 4 + 0.5 * (row % 2)) % 4, t * 10 % 1
    edge = min((u % 1) * 2.4, (1 - u % 1) * 2.4, v, 1 - v) - 0.05
    return max(0, min(1, edge / 0.1)), math.floor(u) + 4 * row


def textures(folder):
    def stone_color(s, t):
        height, number = cobble(s, t)
        tone = 0.6 + 0.5 * smooth_noise(number * 3.7, 2, 1) + 0.3 * (fractal(s * 40, t * 40, 3) - 0.5)
        moss = (1 - height) ** 2 * 0.9
        return tuple(c * tone * (1 - moss) + m * moss for c, m in zip((0.43, 0.4, 0.37), (0.1, 0.13, 0.04)))

    def stone_height(s, t):
        height, number = cobble(s, t)
        return (0.75 * (1 - (1 - height) ** 2.5) + 0.15 * smooth_noise(number * 5.1, 1, 3) + 0.1 * fractal(s * 30, t * 30, 3),) * 3

    def brick_color(s, t):
        height, number = brick(s, t)
        tone = 0.65 + 0.5 * smooth_noise(number * 4.3, 7, 2) + 0.35 * (fractal(s * 32, t * 32, 4) - 0.5)
        a, b = (0.5, 0.19, 0.11), (0.5, 0.46, 0.4)
        return tuple((x * height + y * (1 - height)) * tone for x, y in zip(a, b))

    def brick_height(s, t):
        height, number = brick(s, t)
        return (0.7 * height + 0.15 * smooth_noise(number * 2.9, 3, 4) + 0.15 * fractal(s * 40, t * 40, 4),) * 3

    def glaze(s, t):  # bands of blue on white
        band = math.sin(2 * math.pi * (9 * t + 0.12 * math.sin(2 * math.pi * 6 * s)))
        return (0.07, 0.16, 0.42) if band > 0.35 else (0.78, 0.76, 0.7)

    def checks(s, t):
        return (0.75, 0.55, 0.1) if (math.floor(s * 8) + math.floor(t * 8)) % 2 else (0.55, 0.1, 0.06)

    def lichen(s, t):
        spots = max(0, min(1, 6 * (fractal(s * 10, t * 10, 4, 9) - 0.52)))
        tone = 0.7 + 0.5 * fractal(s * 24, t * 24, 4, 6)
        return tuple(c * tone * (1 - spots) + m * spots for c, m in zip((0.44, 0.42, 0.4), (0.52, 0.5, 0.16)))

    texture(folder, "cobbles.ppm", 192, 192, stone_color)
    texture(folder, "cobbles_height.ppm", 192, 192, stone_height)
    texture(folder, "bricks.ppm", 192, 192, brick_color)
    texture(folder, "bricks_height.ppm", 192, 192, brick_height)
    texture(folder, "glaze.ppm", 96, 96, glaze)
    texture(folder, "checks.ppm", 64, 64, checks)
    texture(folder, "lichen.ppm", 160, 160, lichen)


def painted(name, gloss=0.0, roughness=0.1):
    return (f'Surface "paintedplastic" "float Ka" [0] "float Kd" [{1 - gloss:g}] "float Ks" [{gloss:g}] '
            f'"float roughness" [{roughness:g}] "string texturename" ["{name}"]')


def displaced(bound, shader):
    return f'Attribute "displacementbound" "float sphere" [{bound}]', f"Displacement {shader}"


def repeat(s, t):
    return f"TextureCoordinates 0 0 {s} 0 0 {t} {s} {t}"


def knots(n, order):
    return [0] * order + [k / (n - order + 1) for k in range(1, n - order + 1)] + [1] * order


def nurbs(r, nu, nv, points, order=(4, 4), uknots=None):
    """A NURBS patch over the unit square; points (x, y, z) or (x, y, z, w), weighted, u fastest."""
    name = "Pw" if len(points[0]) == 4 else "P"
    r(f'NuPatch {nu} {order[0]} [{fmt(uknots or knots(nu, order[0]))}] 0 1 {nv} {order[1]} [{fmt(knots(nv, order[1]))}] 0 1 '
      f'"{name}" [{fmt(v for p in points for v in p)}]')


def ground(r):
    with r.block(painted("cobbles.ppm", 0.06, 0.2), *displaced(0.07, '"bumpy" "float Km" [.07] "string texturename" '
                                                               '["cobbles_height.ppm"]'), repeat(3.5, 2.6)):
        n = 7  # gently uneven
        nurbs(r, n, n, [(-4 + 8 * i / (n - 1), 0.12 * (smooth_noise(i * 0.9, j * 0.9, 8) - 0.5), 2.5 - 6.5 * j / (n - 1))
                        for j in range(n) for i in range(n)])


def walls(r):
    relief = displaced(0.06, '"bumpy" "float Km" [.06] "string texturename" ["bricks_height.ppm"]')
    # At the back a bicubic patch mesh that leans a little, on the right a bilinear one.
    with r.block(painted("bricks.ppm"), *relief, repeat(3, 1.6), 'Basis "bezier" 3 "bezier" 3'):
        points = [(-4 + 8 * i / 6, 3.4 - 3.6 * j / 3, 2.3 + 0.08 * math.sin(i * 1.3) + 0.05 * math.sin(j * 2 + i))
                  for j in range(4) for i in range(7)]
        r(f'PatchMesh "bicubic" 7 "nonperiodic" 4 "nonperiodic" "P" [{fmt(v for p in points for v in p)}]')
    with r.block(painted("bricks.ppm"), *relief, repeat(2.4, 1.1)):
        points = [(2.55, 2.2 - 2.3 * j / 2, 2.4 - 6.4 * i / 4) for j in range(3) for i in range(5)]
        r(f'PatchMesh "bilinear" 5 "nonperiodic" 3 "nonperiodic" "P" [{fmt(v for p in points for v in p)}]')
    with r.block(painted("lichen.ppm"), *displaced(0.03, '"dented" "float Km" [.03] "float frequency" [7]')):  # its coping
        st = r.cushion
        with r.block('Surface "matte" "float Ka" [0] "float Kd" [1]', "Color [.5 .48 .44]"):
            for k in range(6):
                st(2.42, 2.95, 2.16, 2.32, -4 + k * 1.06, -2.98 + k * 1.06, 0.03)


def things(r):
    cube = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    with r.block(painted("lichen.ppm"), *displaced(0.7, '"dented" "float Km" [1.8] "float frequency" [1.6]'),
                 "Translate -1.45 0.5 0.75", "Rotate 20 0 1 0", "Scale 1.1 .85 1"):  # a rock: a cube of Catmull and Clark
        r.mesh(cube, faces, [(0.5 + 0.35 * x + 0.1 * z, 0.5 - 0.35 * y + 0.1 * z) for x, y, z in cube])
    with r.block(painted("lichen.ppm"), "Translate 1.35 0 1.2"):  # a fluted column, broken off
        with r.block(*displaced(0.05, '"waves" "float amplitude" [.022] "float sfrequency" [9] "float tfrequency" [0]')):
            r.lathe([(0.3, 0.2), (0.3, 0.35), (0.285, 0.8), (0.27, 1.3), (0.25, 1.75), (0.25, 1.8)], 24, (2, 1))
        with r.block(*displaced(0.12, '"dented" "float Km" [.14] "float frequency" [3]')):
            r.lathe([(0.25, 1.75), (0.2, 1.86), (0.1, 1.88), (0.001, 1.84)], 24, (1, 1))
        r.cushion(-0.42, 0.42, 0, 0.22, -0.42, 0.42, 0.03)
    # A vase: a profile turned about y, an exact surface of revolution of rational quadratics.
    profile = [(0.16, 0), (0.24, 0.04), (0.46, 0.3), (0.42, 0.66), (0.14, 0.78), (0.13, 0.94), (0.26, 1.02)]
    h = math.sqrt(0.5)
    ring = [(1, 0, 1), (1, 1, h), (0, 1, 1), (-1, 1, h), (-1, 0, 1), (-1, -1, h), (0, -1, 1), (1, -1, h), (1, 0, 1)]
    quarters = [0, 0, 0, .25, .25, .5, .5, .75, .75, 1, 1, 1]
    with r.block(painted("glaze.ppm", 0.12, 0.03), "Translate 0.38 0.08 -0.35", "Rotate 100 0 1 0",
                 *displaced(0.02, '"waves" "float amplitude" [.012] "float sfrequency" [24] "float tfrequency" [8]')):
        nurbs(r, 9, len(profile), [(x * a * w, y * w, z * a * w, w) for a, y in profile for x, z, w in ring], (3, 4), quarters)
    with r.block(painted("checks.ppm", 0.1, 0.05), "Translate -0.55 0.06 -0.75", "Rotate 150 0 1 0", "Rotate -90 1 0 0",
                 "Scale .17 .17 .17", *displaced(0.06, '"waves" "float amplitude" [.012] "float sfrequency" [5] '
                                                 '"float tfrequency" [5]')):
        r('Geometry "teapot"')


def main():
    folder = target_folder()
    textures(folder)
    r = Rib()
    r("##Scene displaced_textured")
    r.camera("displaced_textured", (256, 192), 44, (0.15, 1.5, -3.9), (0.05, 0.72, 0.4))
    r('Attribute "trace" "int maxdiffusedepth" [3] "int maxspeculardepth" [2]', "ShadingRate 0.25")
    r.light("envlight", '"float intensity" [1] "color lightcolor" [.42 .55 .8]')
    r.soft_box((-5, 3.6, -3.6), (0, 0.5, 0.5), 1.6, 1.6, (38, 32, 23))
    ground(r)
    walls(r)
    things(r)
    r("WorldEnd")
    r.save(folder)


main()
