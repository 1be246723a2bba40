#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A laid table in a photographer's studio: a wine glass, a tumbler, a bottle and a carafe of glass, balls of rough metal,
porcelain that shines. Two soft boxes and a dim studio around: all lights are large, so that caustics converge."""
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from ribwriter import Rib, fractal, smooth_noise, target_folder, texture  # noqa: E402

CLEAR = 'Surface "dielectric" "float ior" [1.5]'


def textures(folder):
    def boards(s, t):
        board = math.floor(t * 6)
        v = t * 6 % 1
        grain = fractal(s * 6 + 9.1 * board, v * 24 + 40 * board, 4, 3)
        ring = 0.5 + 0.5 * math.sin(26 * v + 9 * fractal(s * 3, v * 2 + 7 * board, 3, 5))
        tone = (0.75 + 0.2 * smooth_noise(board * 3.3, 1, 2)) * (0.7 + 0.3 * grain + 0.12 * ring)
        joint = 0.35 if min(v, 1 - v) < 0.012 else 1
        return tuple(c * tone * joint for c in (0.5, 0.29, 0.15))

    def studio(s, t):  # latitude and longitude: dim walls, a strip window, a darker floor
        if t > 0.55:
            return (0.16, 0.14, 0.12)
        glow = math.exp(-((s - 0.3) / 0.05) ** 2) * math.exp(-((t - 0.38) / 0.1) ** 2)
        return tuple(0.22 + 0.2 * (0.55 - t) + c * glow for c in (0.72, 0.78, 0.85))

    texture(folder, "boards.ppm", 256, 192, boards)
    texture(folder, "studio.ppm", 96, 48, studio)


def vessel(r, outside, inside, n=24):
    """Glass with a wall: the outer profile from the axis up, the inner one from the rim down to the axis."""
    r.lathe(outside + inside, n)


def glasses(r):
    with r.block(CLEAR, "Translate -0.34 0 0.02"):  # a wine glass
        vessel(r, [(0.001, 0), (0.17, 0), (0.185, 0.008), (0.17, 0.016), (0.05, 0.03), (0.022, 0.07), (0.018, 0.2),
                   (0.03, 0.29), (0.1, 0.34), (0.16, 0.44), (0.165, 0.56), (0.13, 0.69)],
               [(0.127, 0.695), (0.122, 0.69), (0.156, 0.56), (0.151, 0.445), (0.095, 0.352), (0.04, 0.315), (0.001, 0.308)])
    with r.block(CLEAR, "Translate 0.5 0 -0.3"):  # a tumbler with a heavy bottom
        vessel(r, [(0.001, 0), (0.115, 0), (0.125, 0.01), (0.13, 0.1), (0.142, 0.3)],
               [(0.139, 0.305), (0.134, 0.3), (0.121, 0.1), (0.11, 0.065), (0.001, 0.055)])
    with r.block('Surface "dielectric" "float ior" [1.52] "color transmittance" [.55 .86 .6]',
                 "Translate 0.12 0 0.62"):  # a green bottle, light is tinted at each of four passages
        vessel(r, [(0.001, 0.03), (0.1, 0.015), (0.14, 0), (0.165, 0.02), (0.168, 0.12), (0.166, 0.56), (0.15, 0.66),
                   (0.075, 0.78), (0.052, 0.86), (0.05, 1.04), (0.064, 1.05), (0.064, 1.09)],
               [(0.06, 1.1), (0.05, 1.09), (0.038, 1.04), (0.04, 0.86), (0.062, 0.775), (0.138, 0.655), (0.154, 0.56),
                (0.155, 0.12), (0.13, 0.035), (0.001, 0.06)])
    with r.block('Surface "dielectric" "float ior" [1.5] "float alpha" [.22] "color transmittance" [.97 .93 .88]',
                 "Translate -0.78 0 0.55"):  # a frosted carafe
        vessel(r, [(0.001, 0), (0.16, 0), (0.19, 0.02), (0.24, 0.16), (0.22, 0.3), (0.12, 0.45), (0.085, 0.56), (0.11, 0.68)],
               [(0.106, 0.686), (0.1, 0.68), (0.074, 0.56), (0.108, 0.445), (0.206, 0.295), (0.226, 0.16), (0.178, 0.035),
                (0.001, 0.025)])


def metals(r):
    # Gold, copper, steel, iron: from nearly a mirror to satin.
    for x, z, radius, color, alpha in ((0.02, -0.42, 0.14, (1, .78, .34), 0.04), (-0.62, -0.34, 0.12, (.95, .64, .54), 0.15),
                                       (0.86, 0.12, 0.19, (.75, .75, .77), 0.3), (-1.05, 0.05, 0.16, (.56, .57, .58), 0.5)):
        with r.block(f'Surface "conductor" "color reflectance" [{color[0]} {color[1]} {color[2]}] "float alpha" [{alpha}]',
                     f"Translate {x} {radius} {z}"):
            r(f"Sphere {radius} {-radius} {radius} 360")
    with r.block('Surface "conductor" "color reflectance" [.9 .88 .85] "float alpha" [.08]', "Translate -0.2 0.012 -0.66",
                 "Rotate 14 0 1 0"):  # a knife
        r.cushion(-0.5, 0.02, 0, 0.012, -0.03, 0.03, 0.005)
        r.cushion(0.02, 0.34, -0.006, 0.022, -0.022, 0.022, 0.01)


def porcelain(r):
    glazed = 'Surface "plastic" "float Ka" [0] "float Kd" [.92] "float Ks" [.08] "float roughness" [.02]'
    with r.block(glazed, "Color [.7 .12 .08]", "Translate 0.62 0 0.6", "Rotate 215 0 1 0", "Rotate -90 1 0 0",
                 "Scale .105 .105 .105"):
        r('Geometry "teapot"')
    with r.block(glazed, "Color [.8 .79 .75]", "Translate 0.16 0 0.04"):  # a bowl
        r.lathe([(0.001, 0), (0.08, 0), (0.085, 0.02), (0.15, 0.08), (0.19, 0.15), (0.187, 0.155), (0.18, 0.15), (0.14, 0.09),
                 (0.07, 0.035), (0.001, 0.03)], 24)
    for k, (x, y, z) in enumerate(((0.11, 0.1, 0.0), (0.22, 0.1, 0.06), (0.16, 0.17, 0.05), (0.17, 0.1, -0.08))):
        with r.block('Surface "plastic" "float Ka" [0] "float Kd" [.9] "float Ks" [.1] "float roughness" [.1]',
                     f"Color [{(.75, .6, .8, .35)[k]} {(.35, .07, .55, .5)[k]} {(.04, .05, .06, .08)[k]}]",
                     f"Translate {x} {y} {z}"):
            r("Sphere 0.06 -0.06 0.06 360")


def main():
    folder = target_folder()
    textures(folder)
    r = Rib()
    r("##Scene glass_table")
    r.camera("glass_table", (256, 192), 34, (0.15, 1.15, -3.1), (-0.05, 0.32, 0.1))
    r('Attribute "trace" "int maxdiffusedepth" [3] "int maxspeculardepth" [6]')
    with r.block("Rotate -90 1 0 0"):  # +z of the picture is up
        r.light("envlight", '"float intensity" [2.6] "string texturename" ["studio.ppm"]')
    r.panel(-1.7, 0.9, 2.4, -1.1, 1.1, (5.5, 5.2, 4.8))
    r.soft_box((2.9, 1.5, -0.6), (0, 0.3, 0), 2.2, 1.8, (2.8, 3.3, 4))
    with r.block('Surface "paintedplastic" "float Ka" [0] "float Kd" [.9] "float Ks" [.1] "float roughness" [.05] '
                 '"string texturename" ["boards.ppm"]'):
        r.quad((-1.9, 0, 1.15), (1.9, 0, 1.15), (1.9, 0, -1.6), (-1.9, 0, -1.6))
    with r.block('Surface "matte" "float Ka" [0] "float Kd" [1]', "Color [.6 .62 .66]"):  # backdrop, bent at its foot
        r.grid(1, 12, lambda u, v: (-6 + 12 * u, -1 + 3.6 * max(0, v - 0.3) / 0.7,
                                    -2 + 6 * min(v / 0.3, 1) + 0.4 * max(0, v - 0.3)))
    porcelain(r)
    metals(r)
    glasses(r)
    r("WorldEnd")
    r.save(folder)


main()
