#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A gallery: paintings on the walls, displaced sculptures on pedestals, a parquet floor that shines a little, and 20
lights: 4 panels in the ceiling, 10 spots on the works of art, 6 small lamps along the walls."""
import math
import os
import random
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from ribwriter import Rib, fractal, smooth_noise, target_folder, texture  # noqa: E402

W, H, D = 4.0, 3.8, 10.0  # half the width, height and depth of the hall
LAMP = 0.35  # from the wall
PLASTER = "Color [.78 .76 .72]"
# Place of each sculpture: x, z, height of its pedestal.
PEDESTALS = ((-2.2, 3.4, 0.95), (2.1, 3.6, 0.8), (-1.1, 5.6, 0.7), (1.7, 6.2, 1.0), (-2.4, 7.6, 0.85))
# Paintings: wall, place along it, width, height, texture.
PAINTINGS = (("left", 3.2, 1.7, 1.2, "dunes.ppm"), ("left", 6.4, 1.3, 1.6, "squares.ppm"),
             ("right", 4.6, 1.9, 1.2, "waves.ppm"), ("back", -1.6, 1.5, 1.8, "clouds.ppm"),
             ("back", 1.4, 2.0, 1.3, "dunes.ppm"))


def textures(folder):
    def mix(a, b, w):
        return tuple(x + (y - x) * w for x, y in zip(a, b))

    def parquet(s, t):  # herringbone of 8 x 8 staves
        i, j = math.floor(s * 8), math.floor(t * 8)
        across = (i + j) % 2 == 0
        u, v = (s * 8 % 1, t * 8 % 1) if across else (t * 8 % 1, s * 8 % 1)
        stave = math.floor(u * 4)
        grain = fractal(v * 3 + 7 * stave + 5 * i, u * 40, 3, j)
        tone = 0.7 + 0.25 * smooth_noise(stave * 3.7 + i * 5.1, j * 7.3, 9) + 0.25 * grain
        joint = 0.45 if min(u * 4 % 1, 1 - u * 4 % 1) < 0.06 or min(v, 1 - v) < 0.015 else 1
        return tuple(c * tone * joint for c in (0.42, 0.25, 0.13))

    def dunes(s, t):
        ridge = 0.45 + 0.2 * math.sin(5 * s + 1) + 0.1 * (fractal(4 * s, 1, 3) - 0.5)
        if t < ridge:
            return mix((0.1, 0.2, 0.45), (0.85, 0.5, 0.25), t / ridge)
        return mix((0.75, 0.45, 0.15), (0.3, 0.12, 0.05), min(1, (t - ridge) * 2 * (0.6 + fractal(6 * s, 20 * t, 3))))

    def squares(s, t):
        i, j = math.floor(s * 5), math.floor(t * 6)
        if min(s * 5 % 1, t * 6 % 1) < 0.06:
            return (0.03, 0.03, 0.03)
        return ((0.8, 0.78, 0.7), (0.7, 0.08, 0.05), (0.08, 0.15, 0.5), (0.85, 0.65, 0.05))[(i * 7 + j * 3 + i * j) % 4]

    def waves(s, t):
        w = 0.5 + 0.5 * math.sin(30 * t + 5 * fractal(4 * s, 4 * t, 4, 2) + 3 * s)
        return mix((0.03, 0.12, 0.25), (0.55, 0.75, 0.7), w * (0.3 + 0.7 * t))

    def clouds(s, t):
        return mix((0.2, 0.35, 0.6), (0.9, 0.85, 0.8), max(0, min(1, 2.5 * (fractal(5 * s, 7 * t, 5, 4) - 0.3))))

    def marble(s, t):
        vein = abs(math.sin(12 * s + 9 * fractal(5 * s, 5 * t, 5, 8)))
        return mix((0.25, 0.24, 0.26), (0.82, 0.8, 0.77), vein ** 0.4)

    texture(folder, "parquet.ppm", 256, 256, parquet)
    texture(folder, "dunes.ppm", 128, 96, dunes)
    texture(folder, "squares.ppm", 120, 144, squares)
    texture(folder, "waves.ppm", 160, 96, waves)
    texture(folder, "clouds.ppm", 96, 120, clouds)
    texture(folder, "marble.ppm", 128, 128, marble)
    texture(folder, "relief.ppm", 128, 128, lambda s, t: (fractal(8 * s, 8 * t, 5, 3),) * 3)


def painting_frame(wall, along):
    """The coordinate system of a painting: x along the wall, y up, z into the room."""
    if wall == "left":
        return f"Translate {-W} 1.7 {along}", "Rotate 90 0 1 0"
    if wall == "right":
        return f"Translate {W} 1.7 {along}", "Rotate -90 0 1 0"
    return f"Translate {along} 1.75 {D}", "Rotate 180 0 1 0"


def lights(r):
    for x in (-1.6, 1.6):
        for z in (3.0, 6.6):
            r.panel(x - 0.5, x + 0.5, H - 0.02, z - 0.3, z + 0.3, (5, 4.8, 4.4))
    for k, (x, z, h) in enumerate(PEDESTALS):
        source = (x * 0.45, H - 0.25, z - 1.1)
        color = ((1, .9, .75), (.85, .92, 1))[k % 2]
        r.light("spotlight", f'"float intensity" [9] "color lightcolor" [{color[0]} {color[1]} {color[2]}] '
                f'"point from" [{source[0]:.3f} {source[1]:.3f} {source[2]:.3f}] "point to" [{x} {h + .3} {z}] '
                '"float coneangle" [.3] "float conedeltaangle" [.12] "float beamdistribution" [2]')
    for wall, along, _, _, _ in PAINTINGS:
        at = {"left": (-W, 1.7, along), "right": (W, 1.7, along), "back": (along, 1.75, D)}[wall]
        source = {"left": (-W + 1.4, H - 0.2, along), "right": (W - 1.4, H - 0.2, along),
                  "back": (along, H - 0.2, D - 1.4)}[wall]
        r.light("spotlight", '"float intensity" [7] "color lightcolor" [1 .92 .8] '
                f'"point from" [{source[0]} {source[1]} {source[2]}] "point to" [{at[0]} {at[1]} {at[2]}] '
                '"float coneangle" [.5] "float conedeltaangle" [.25] "float beamdistribution" [3]')
    for x in (-W + LAMP, W - LAMP):
        for z in (1.6, 5.0, 8.4):
            r.light("pointlight", f'"float intensity" [.4] "color lightcolor" [1 .7 .42] "point from" [{x} 2.75 {z}]')


def hall(r):
    with r.block('Surface "paintedplastic" "float Ka" [0] "float Kd" [.9] "float Ks" [.12] "float roughness" [.08] '
                 '"string texturename" ["parquet.ppm"]'):
        r.quad((-W, 0, D), (W, 0, D), (W, 0, 0), (-W, 0, 0), (8, 10))
    with r.block(PLASTER):
        r.quad((-W, H, 0), (-W, H, D), (-W, 0, D), (-W, 0, 0))
        r.quad((W, H, D), (W, H, 0), (W, 0, 0), (W, 0, D))
        r("Color [.5 .14 .1]")
        r.quad((-W, H, D), (W, H, D), (W, 0, D), (-W, 0, D))
        r(PLASTER)
        r.quad((W, H, 0), (-W, H, 0), (-W, 0, 0), (W, 0, 0))
        r.quad((-W, H, D), (W, H, D), (W, H, 0), (-W, H, 0))
        r("Color [.6 .58 .54]")
        for z in (1.2, 4.8, 8.4):  # beams
            r.box(-W, W, H - 0.22, H, z - 0.12, z + 0.12)
        for x in (-W, W - 0.03):
            r.box(x, x + 0.03, 0, 0.16, 0, D)
        r.box(-W, W, 0, 0.16, D - 0.03, D)
    for x in (-W + LAMP, W - LAMP):  # shades of the lamps, open above and below
        for z in (1.6, 5.0, 8.4):
            with r.block("Color [.2 .17 .12]", f"Translate {x} 2.75 {z}", "Rotate -90 1 0 0"):
                r("Cylinder 0.2 -0.12 0.12 360", f"Rotate 90 0 {'-' if x < 0 else ''}1 0", f"Cylinder 0.012 0.2 {LAMP} 360")
    for (x, z, h) in PEDESTALS:  # the lamps of the spots
        with r.block("Color [.1 .1 .1]", f"Translate {x * .45:.3f} {H - .22} {z - 1.1:.3f}", "Rotate -90 1 0 0"):
            r("Cylinder 0.05 0.02 0.22 360")


def paintings(r):
    for wall, along, w, h, name in PAINTINGS:
        with r.block(*painting_frame(wall, along)):
            with r.block('Surface "plastic" "float Ka" [0] "float Kd" [.8] "float Ks" [.2] "float roughness" [.1]',
                         "Color [.45 .33 .1]"):
                b = 0.09
                for x0, x1, y0, y1 in ((-w / 2 - b, w / 2 + b, h / 2, h / 2 + b), (-w / 2 - b, w / 2 + b, -h / 2 - b, -h / 2),
                                       (-w / 2 - b, -w / 2, -h / 2, h / 2), (w / 2, w / 2 + b, -h / 2, h / 2)):
                    r.cushion(x0, x1, y0, y1, 0, 0.07, 0.02)
            # Canvas with the relief of the paint.
            with r.block('Surface "paintedplastic" "float Ka" [0] "float Kd" [1] "float Ks" [0] '
                         f'"string texturename" ["{name}"]', "Color [1 1 1]",
                         'Attribute "displacementbound" "float sphere" [0.012]',
                         'Displacement "bumpy" "float Km" [0.012] "string texturename" ["relief.ppm"]'):
                r.quad((-w / 2, h / 2, 0.03), (w / 2, h / 2, 0.03), (w / 2, -h / 2, 0.03), (-w / 2, -h / 2, 0.03))


def sculptures(r):
    rng = random.Random(8)
    for x, z, h in PEDESTALS:
        with r.block('Surface "paintedplastic" "float Ka" [0] "float Kd" [1] "float Ks" [.1] "float roughness" [.1] '
                     '"string texturename" ["marble.ppm"]', "Color [1 1 1]", f"Translate {x} 0 {z}",
                     f"Rotate {rng.uniform(-30, 30):.1f} 0 1 0"):
            a = 0.27
            for turn in (0, 90, 180, 270):
                with r.block(f"Rotate {turn} 0 1 0"):
                    r.quad((-a, h, -a), (a, h, -a), (a, 0, -a), (-a, 0, -a))
            r.quad((-a, h, a), (a, h, a), (a, h, -a), (-a, h, -a))

    def on(k):
        x, z, h = PEDESTALS[k]
        return f"Translate {x} {h} {z}"

    with r.block(on(0), "Translate 0 0.36 0", 'Surface "plastic" "float Ka" [0] "float Kd" [.9] "float Ks" [.15]',
                 "Color [.75 .42 .3]", 'Attribute "displacementbound" "float sphere" [0.3]',
                 'Displacement "dented" "float Km" [.45] "float frequency" [2.6]'):
        r("Rotate -90 1 0 0", "Sphere 0.38 -0.38 0.38 360")
    with r.block(on(1), "Translate 0 0.34 0", "Rotate 25 0 1 0", "Color [.35 .5 .55]",
                 'Surface "plastic" "float Ka" [0] "float Kd" [.85] "float Ks" [.2] "float roughness" [.05]',
                 'Attribute "displacementbound" "float sphere" [0.04]',
                 'Displacement "waves" "float amplitude" [.035] "float sfrequency" [14] "float tfrequency" [4]'):
        r("Torus 0.24 0.1 0 360 360")
    with r.block(on(2), "Color [.8 .78 .72]", 'Attribute "displacementbound" "float sphere" [0.05]',
                 'Displacement "dented" "float Km" [.05] "float frequency" [9]'):  # a vase
        r.lathe([(0.001, 0), (0.12, 0), (0.13, 0.03), (0.1, 0.08), (0.2, 0.3), (0.24, 0.5), (0.16, 0.72), (0.08, 0.84),
                 (0.13, 0.95), (0.12, 0.95), (0.06, 0.84), (0.001, 0.8)], 24)
    with r.block(on(3), "Rotate 205 0 1 0", "Rotate -90 1 0 0", "Scale .15 .15 .15", "Color [.55 .6 .65]",
                 'Surface "plastic" "float Ka" [0] "float Kd" [.6] "float Ks" [.5] "float roughness" [.05]'):
        r('Geometry "teapot"')
    with r.block(on(4), "Color [.3 .42 .24]", 'Attribute "displacementbound" "float sphere" [0.1]',
                 'Displacement "dented" "float Km" [.12] "float frequency" [5]'):  # a knot of rods
        for k in range(14):
            with r.block("Translate 0 0.4 0", f"Rotate {rng.uniform(0, 360):.1f} 0 1 0",
                         f"Rotate {rng.uniform(0, 180):.1f} 1 0 0"):
                r.lathe([(0.001, -0.36), (0.06, -0.34), (0.05, -0.1), (0.07, 0), (0.05, 0.1), (0.06, 0.34), (0.001, 0.36)], 8)
    with r.block("Translate 0.25 0 4.1", "Rotate 8 0 1 0", "Color [.16 .1 .07]",
                 'Surface "plastic" "float Ka" [0] "float Kd" [.9] "float Ks" [.1]'):  # a bench with a cushion
        for x in (-0.6, 0.6):
            r.box(x - 0.03, x + 0.03, 0, 0.38, -0.2, 0.2)
        r.cushion(-0.75, 0.75, 0.38, 0.42, -0.24, 0.24, 0.01)
        with r.block("Color [.5 .1 .08]", 'Surface "matte" "float Ka" [0] "float Kd" [1]'):
            r.cushion(-0.74, 0.74, 0.42, 0.5, -0.23, 0.23, 0.035, 0.02)


def main():
    folder = target_folder()
    textures(folder)
    r = Rib()
    r("##Scene gallery_lights")
    r.camera("gallery_lights", (256, 192), 58, (0.7, 1.65, 0.3), (-0.25, 1.32, 6))
    r('Attribute "trace" "int maxdiffusedepth" [3] "int maxspeculardepth" [2]',
      'Surface "matte" "float Ka" [0] "float Kd" [1]')
    lights(r)
    hall(r)
    r("ShadingRate 0.2")  # displacement shows
    paintings(r)
    sculptures(r)
    r("WorldEnd")
    r.save(folder)


main()
