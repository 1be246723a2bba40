#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A courtyard in the afternoon: sun and sky, an arcade of instanced columns, brick and plaster walls with windows, trees
of instanced branches, a fountain, flower pots."""
import math
import os
import random
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from ribwriter import Rib, fractal, smooth_noise, target_folder, texture  # noqa: E402

W, D = 9.0, 16.0  # half the width and the depth of the court
STONE, PLASTER = "Color [.68 .62 .52]", "Color [.74 .6 .42]"


def textures(folder):
    def bricks(s, t):
        row = math.floor(t * 16)
        u, v = (s * 8 + 0.5 * (row % 2)) % 8, t * 16 % 1
        if min(u % 1, 1 - u % 1) < 0.035 or v < 0.1:
            tone = 0.8 + 0.3 * smooth_noise(s * 60, t * 60)
            return (0.5 * tone, 0.47 * tone, 0.42 * tone)
        tone = 0.65 + 0.5 * smooth_noise(math.floor(u) * 5.3, row * 3.1, 4) + 0.2 * (fractal(s * 40, t * 40, 3) - 0.5)
        return (0.48 * tone, 0.21 * tone, 0.13 * tone)

    def paving(s, t):
        i, j = math.floor(s * 6), math.floor(t * 6)
        u, v = s * 6 % 1, t * 6 % 1
        tone = 0.75 + 0.35 * smooth_noise(i * 4.7, j * 6.1, 7) + 0.25 * (fractal(s * 30, t * 30, 4) - 0.5)
        if min(u, v, 1 - u, 1 - v) < 0.03:
            tone *= 0.4
        return (0.52 * tone, 0.48 * tone, 0.42 * tone)

    texture(folder, "bricks.ppm", 192, 192, bricks)
    texture(folder, "paving.ppm", 192, 192, paving)


def painted(name):
    return (f'Surface "paintedplastic" "float Ka" [0] "float Kd" [1] "float Ks" [0] "string texturename" ["{name}"]')


def ground(r):
    with r.block(painted("paving.ppm"), "Color [1 1 1]"):
        r.quad((-W, 0, D), (W, 0, D), (W, 0, -6), (-W, 0, -6), (5, 6))
    with r.block("Color [.3 .34 .18]"):  # what lies around
        r.quad((-200, -0.02, 200), (200, -0.02, 200), (200, -0.02, -200), (-200, -0.02, -200))


def window(r, x, y, w, h):
    """In a wall of which the front is at z = 0: reveal, frame, sill, shutters."""
    with r.block(f"Translate {x} {y} 0"):
        with r.block("Color [.06 .08 .1]"):
            r.quad((-w / 2, h, 0.28), (w / 2, h, 0.28), (w / 2, 0, 0.28), (-w / 2, 0, 0.28))
        with r.block("Color [.75 .73 .68]"):
            for k in (-w / 2, -0.025, w / 2 - 0.05):
                r.box(k, k + 0.05, 0, h, 0.2, 0.26)
            for k in (0, h * 0.6, h - 0.05):
                r.box(-w / 2, w / 2, k, k + 0.05, 0.21, 0.25)
        with r.block(STONE):
            r.cushion(-w / 2 - 0.12, w / 2 + 0.12, -0.12, 0, -0.12, 0.3, 0.025)
            r.cushion(-w / 2 - 0.1, w / 2 + 0.1, h, h + 0.18, -0.05, 0.3, 0.025)
        with r.block("Color [.13 .27 .22]"):
            for side in (-1, 1):
                x0 = side * (w / 2 + w / 4 + 0.03)
                r.box(x0 - w / 4, x0 + w / 4, 0, h, -0.05, -0.035)
                for k in range(12):
                    y0 = 0.06 + k * (h - 0.1) / 12
                    r.box(x0 - w / 4 + 0.05, x0 + w / 4 - 0.05, y0, y0 + 0.05, -0.07, -0.05)


def wall(r, x0, x1, h, openings):
    """A wall along x, its front at z = 0, 30 cm thick, with holes (x, y, w, h) that lie in columns."""
    columns = sorted({o[0] for o in openings})
    edge = x0
    for x in columns:
        own = sorted((o for o in openings if o[0] == x), key=lambda o: o[1])
        half = own[0][2] / 2
        plane(r, edge, x - half, 0, h)
        y = 0
        for _, oy, ow, oh in own:
            plane(r, x - half, x + half, y, oy)
            y = oy + oh
            for a, b in (((x - half, oy), (x - half, y)), ((x + half, y), (x + half, oy)), ((x - half, y), (x + half, y)),
                         ((x + half, oy), (x - half, oy))):
                r.quad((*a, 0), (*b, 0), (*b, 0.3), (*a, 0.3), (0.3, 0.3))
        plane(r, x - half, x + half, y, h)
        edge = x + half
    plane(r, edge, x1, 0, h)


def plane(r, x0, x1, y0, y1):
    """Part of a wall; one unit of the texture is 2 m."""
    if x1 - x0 > 1e-6 and y1 - y0 > 1e-6:
        st = (x0 / 2, -y1 / 2, x1 / 2, -y1 / 2, x1 / 2, -y0 / 2, x0 / 2, -y0 / 2)
        r(f'Polygon "P" [{x0:.5g} {y1:.5g} 0 {x1:.5g} {y1:.5g} 0 {x1:.5g} {y0:.5g} 0 {x0:.5g} {y0:.5g} 0] '
          f'"st" [{" ".join(f"{v:.5g}" for v in st)}]')


def cornice(r, x0, x1, h):
    with r.block(STONE):
        r.cushion(x0, x1, h, h + 0.15, -0.2, 0.3, 0.04)
        r.cushion(x0, x1, h + 0.15, h + 0.35, -0.4, 0.3, 0.06)
    with r.block("Color [.5 .22 .14]"):  # the edge of a tiled roof: a rippled slope
        n = int((x1 - x0) / 0.15)
        r.grid(2 * n, 6, lambda u, v: (x0 + (x1 - x0) * u, h + 0.38 + 1.5 * v + 0.05 * math.cos(2 * math.pi * n * u),
                                       -0.6 + 3 * v))


def buildings(r):
    with r.block(f"Translate 0 0 {D}", painted("bricks.ppm"), "Color [1 1 1]"):  # at the back
        holes = [(x, y, 1.1, 1.7) for x in (-6.6, -3.3, 0, 3.3, 6.6) for y in (4.6,)]
        wall(r, -W, W, 7.2, holes)
        with r.block('Surface "matte" "float Ka" [0] "float Kd" [1]'):
            for x, y, w, h in holes:
                window(r, x, y, w, h)
            cornice(r, -W - 0.4, W + 0.4, 7.2)
    # On the left, in the sun, and on the right, in the shade.
    for turn, x, height in ((-90, -W, 6.4), (90, W, 8.2)):
        with r.block(f"Translate {x} 0 {D / 2 - 3}", f"Rotate {turn} 0 1 0", PLASTER if x < 0 else "Color [.7 .66 .6]"):
            holes = [(a, y, 1.2, 1.8) for a in (-8.5, -5.5, -2.5, 0.5, 3.5, 6.5) for y in (1.0, 4.0)]
            if x < 0:
                holes = [(-a, y, w, h) for a, y, w, h in holes]
            wall(r, -11, 11, height, holes)
            for a, y, w, h in holes:
                window(r, a, y, w, h)
            cornice(r, -11, 11, height)


def arcade(r):
    """Arches on columns before the wall at the back, with a terrace above."""
    z, pitch, radius, spring = D - 2.6, 2.2, 0.85, 2.35
    with r.object("column"):
        r.lathe([(0.001, 0), (0.3, 0), (0.3, 0.12), (0.25, 0.16), (0.27, 0.22), (0.19, 0.3), (0.18, 1.2), (0.155, 2.0),
                 (0.2, 2.06), (0.18, 2.1), (0.28, 2.22), (0.28, 2.35), (0.001, 2.35)], 20)
    with r.block(STONE):
        for k in range(9):
            with r.block(f"Translate {-W + 0.2 + k * pitch:.3f} 0 {z}"):
                r('ObjectInstance "column"')
        for k in range(8):
            middle = -W + 0.2 + (k + 0.5) * pitch
            a, n = pitch / 2, 16
            for z0, front in ((z - 0.25, True), (z + 0.25, False)):  # spandrels
                def spandrel(u, v, z0=z0):
                    angle = math.pi * (1 - u)
                    x, y = radius * math.cos(angle), radius * math.sin(angle)
                    edge = (max(-a, min(a, 2.2 * x)), 1.15)
                    if abs(math.cos(angle)) > 0.75:
                        edge = (math.copysign(a, x), 1.15 * min(1, (1 - abs(math.cos(angle))) * 4))
                    return (middle + x + (edge[0] - x) * v, spring + y + (edge[1] - y) * v, z0)
                r.grid(n, 1, spandrel)
            r.grid(n, 1, lambda u, v: (middle - radius * math.cos(math.pi * u), spring + radius * math.sin(math.pi * u),
                                       z - 0.25 + 0.5 * v))
        r.box(-W, W, spring + 1.13, spring + 1.35, z - 0.3, D)
        r.cushion(-W, W, spring + 1.35, spring + 1.5, z - 0.4, z + 0.1, 0.04)
        with r.object("baluster"):
            r.lathe([(0.001, 0), (0.07, 0), (0.07, 0.05), (0.04, 0.08), (0.085, 0.25), (0.035, 0.45), (0.06, 0.52),
                     (0.06, 0.6)], 10)
        for k in range(60):
            with r.block(f"Translate {-W + 0.15 + k * 0.3:.3f} {spring + 1.5} {z - 0.1}"):
                r('ObjectInstance "baluster"')
        r.box(-W, W, spring + 2.1, spring + 2.2, z - 0.22, z + 0.02)


def fountain(r):
    with r.block("Translate 0.4 0 7.2", STONE):
        with r.block('Attribute "displacementbound" "float sphere" [0.03]',
                     'Displacement "dented" "float Km" [.03] "float frequency" [7]'):
            r.lathe([(1.9, 0), (1.95, 0.08), (1.8, 0.14), (1.75, 0.45), (1.92, 0.52), (1.92, 0.6), (1.7, 0.6), (1.6, 0.5),
                     (1.6, 0.1)], 32)
            r.lathe([(0.35, 0), (0.38, 0.15), (0.2, 0.3), (0.16, 0.9), (0.26, 1.1), (0.7, 1.32), (0.95, 1.5), (0.95, 1.55),
                     (0.88, 1.53), (0.6, 1.38), (0.14, 1.3), (0.1, 1.6), (0.14, 1.75), (0.38, 1.92), (0.36, 1.95), (0.1, 1.9),
                     (0.06, 2.05), (0.001, 2.12)], 28)
        with r.block("Color [.1 .2 .2]", 'Surface "plastic" "float Ka" [0] "float Kd" [.6] "float Ks" [.4] '
                     '"float roughness" [.05]', 'Attribute "displacementbound" "float sphere" [0.01]',
                     'Displacement "dented" "float Km" [.02] "float frequency" [4]', "Translate 0 0.44 0",
                     "Rotate -90 1 0 0"):
            r("Disk 0 1.65 360")


def trees(r):
    rng = random.Random(21)
    with r.object("twig"):  # a spray of leaves around a thin branch
        for k in range(26):
            along, turn, tilt = rng.uniform(0.05, 0.7), rng.uniform(0, 360), rng.uniform(25, 95)
            tone = rng.uniform(0.75, 1.25)
            with r.block(f"Color [{.17 * tone:.3f} {.29 * tone:.3f} {.07 * tone:.3f}]", f"Translate 0 {along:.3f} 0",
                         f"Rotate {turn:.1f} 0 1 0", f"Rotate {tilt:.1f} 1 0 0", f"Scale {rng.uniform(.7, 1.3):.3f} 1 1"):
                length = rng.uniform(0.16, 0.26)
                r.grid(2, 4, lambda u, v: ((u - 0.5) * 0.13 * math.sin(math.pi * (0.05 + 0.92 * v)), length * v,
                                           0.03 * math.cos(math.pi * (u - 0.5)) - 0.05 * v * v))
        with r.block("Color [.2 .14 .09]", "Rotate -90 1 0 0"):
            r("Cone 0.75 0.012 360")

    def branch(p, q, r0, r1, bend):
        """A bent tube from p to q."""
        def ring(k, n=10, rows=6):
            f = k / (rows - 1)
            centre = [a + (b - a) * f + w * math.sin(math.pi * f) for a, b, w in zip(p, q, bend)]
            radius = r0 + (r1 - r0) * f
            d = [b - a for a, b in zip(p, q)]
            size = math.sqrt(sum(c * c for c in d))
            d = [c / size for c in d]
            side = (1, 0, 0) if abs(d[0]) < 0.7 else (0, 0, 1)
            u = (d[1] * side[2] - d[2] * side[1], d[2] * side[0] - d[0] * side[2], d[0] * side[1] - d[1] * side[0])
            size = math.sqrt(sum(c * c for c in u))
            u = [c / size for c in u]
            v = (d[1] * u[2] - d[2] * u[1], d[2] * u[0] - d[0] * u[2], d[0] * u[1] - d[1] * u[0])
            return [tuple(centre[c] + radius * (math.cos(2 * math.pi * i / n) * u[c] + math.sin(2 * math.pi * i / n) * v[c])
                          for c in range(3)) for i in range(n)]
        n, rows = 10, 6
        r.mesh([point for k in range(rows) for point in ring(k)],
               [(k * n + i, (k + 1) * n + i, (k + 1) * n + (i + 1) % n, k * n + (i + 1) % n)
                for k in range(rows - 1) for i in range(n)])

    for x, z, height, twigs in ((-5.2, 6.5, 3.4, 330), (5.6, 9.6, 2.8, 260)):
        with r.block(f"Translate {x} 0 {z}"):
            top = (0.1, height * 0.55, 0.05)
            ends = [(math.cos(k * 2.4) * rng.uniform(0.8, 1.2), height * rng.uniform(0.8, 1.05),
                     math.sin(k * 2.4) * rng.uniform(0.8, 1.2)) for k in range(7)]
            with r.block("Color [.25 .18 .12]", 'Attribute "displacementbound" "float sphere" [0.03]',
                         'Displacement "dented" "float Km" [.03] "float frequency" [6]'):
                branch((0, -0.05, 0), top, 0.2, 0.13, (0.08, 0, -0.05))
                for e in ends:
                    branch(top, e, 0.1, 0.03, (rng.uniform(-.1, .1), 0.1, rng.uniform(-.1, .1)))
            for k in range(twigs):
                # In a rounded crown, denser at its surface.
                a, c = rng.uniform(0, 2 * math.pi), rng.uniform(-0.75, 1)
                s, d = math.sqrt(1 - c * c), rng.uniform(0.25, 1) ** 0.4 * height * 0.46
                with r.block(f"Translate {d * s * math.cos(a):.3f} {height * .98 + d * .8 * c:.3f} {d * s * math.sin(a):.3f}",
                             f"Rotate {-math.degrees(a):.1f} 0 1 0", f"Rotate {-math.degrees(math.acos(c)) * .8:.1f} 0 0 1",
                             f"Rotate {rng.uniform(0, 360):.1f} 0 1 0"):
                    r('ObjectInstance "twig"')
            with r.block(STONE):  # a ring of stones
                r.lathe([(0.9, 0), (0.92, 0.2), (0.88, 0.28), (0.72, 0.28), (0.7, 0.12)], 24)
            with r.block("Color [.16 .1 .06]", "Translate 0 0.16 0", "Rotate -90 1 0 0"):
                r("Disk 0 0.72 360")


def pots(r):
    rng = random.Random(2)
    for x, z, size in ((3.0, 4.4, 1.0), (3.75, 4.9, 0.7), (-2.6, 4.0, 0.9), (-7.9, 11.8, 1.1), (7.9, 12.0, 1.1)):
        with r.block(f"Translate {x} 0 {z}", f"Scale {size} {size} {size}", "Color [.62 .3 .18]"):
            r.lathe([(0.001, 0), (0.2, 0), (0.22, 0.04), (0.33, 0.42), (0.37, 0.45), (0.37, 0.53), (0.32, 0.53), (0.3, 0.44),
                     (0.001, 0.44)], 24)
            for _ in range(9):
                with r.block("Translate 0 0.42 0", f"Rotate {rng.uniform(0, 360):.1f} 0 1 0",
                             f"Rotate {rng.uniform(5, 40):.1f} 1 0 0"):
                    r('ObjectInstance "twig"')
            for _ in range(7):
                a, d = rng.uniform(0, 6.28), rng.uniform(0.05, 0.4)
                color = ((.7, .08, .1), (.8, .5, .6), (.85, .75, .2))[rng.randrange(3)]
                with r.block(f"Translate {d * math.cos(a):.3f} {rng.uniform(.8, 1.1):.3f} {d * math.sin(a):.3f}",
                             f"Color [{color[0]} {color[1]} {color[2]}]", "Scale 1 .7 1"):
                    r("Sphere 0.05 -0.05 0.05 360")
    with r.block("Translate -2.9 0 2.9", "Rotate 62 0 1 0", "Color [.36 .24 .14]"):  # a garden bench
        for k in range(4):
            r.cushion(-0.8, 0.8, 0.42, 0.455, -0.24 + k * 0.125, -0.14 + k * 0.125, 0.01)
        for k in range(3):
            r.cushion(-0.8, 0.8, 0.55 + k * 0.13, 0.64 + k * 0.13, 0.27, 0.3, 0.01)
        for x in (-0.7, 0.66):
            r.box(x, x + 0.05, 0, 0.42, -0.22, -0.17)
            r.box(x, x + 0.05, 0, 0.9, 0.3, 0.34)
            r.box(x, x + 0.05, 0.36, 0.42, -0.22, 0.32)


def main():
    folder = target_folder()
    textures(folder)
    r = Rib()
    r("##Scene courtyard")
    r.camera("courtyard", (256, 192), 56, (1.2, 1.7, -3.6), (-0.35, 2.35, 8))
    r('Attribute "trace" "int maxdiffusedepth" [4] "int maxspeculardepth" [2]')
    r.light("distantlight", '"float intensity" [1.9] "color lightcolor" [1 .88 .7] "point from" [7 11 -4] '
            '"point to" [0 0 0] "float angle" [.53]')
    r.light("envlight", '"float intensity" [.45] "color lightcolor" [.55 .75 1]')
    r('Surface "matte" "float Ka" [0] "float Kd" [1]')
    ground(r)
    buildings(r)
    arcade(r)
    fountain(r)
    trees(r)
    pots(r)
    r("WorldEnd")
    r.save(folder)


main()
