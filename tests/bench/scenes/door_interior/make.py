#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A furnished living room without a lamp that is on: all light comes through a door that stands ajar to a lit corridor.
Everything is diffuse."""
import math
import os
import random
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from ribwriter import Rib, fractal, target_folder  # noqa: E402

H, W, D = 2.6, 2.5, 5.0  # height, half the width, depth of the room
DOOR = (-1.75, -0.8, 2.05)  # from, to, height
WALL, OAK, WALNUT, CREAM, BRASS = ("Color [.75 .72 .66]", "Color [.52 .34 .18]", "Color [.3 .18 .1]",
                                   "Color [.8 .77 .7]", "Color [.6 .5 .25]")


def room(r):
    x0, x1, top = DOOR
    with r.block(WALL):
        r.quad((-W, H, 0), (-W, H, D), (-W, 0, D), (-W, 0, 0))
        r.quad((W, H, D), (W, H, 0), (W, 0, 0), (W, 0, D))
        r.quad((W, H, 0), (-W, H, 0), (-W, 0, 0), (W, 0, 0))
        # The wall with the door, 12 cm thick.
        r.box(-4, x0, 0, H, D, D + 0.12)
        r.box(x1, 4, 0, H, D, D + 0.12)
        r.box(x0, x1, top, H, D, D + 0.12)
        r("Color [.8 .8 .78]")
        r.quad((-W, H, D), (W, H, D), (W, H, 0), (-W, H, 0))
    with r.block(CREAM):  # skirting and architrave
        r.box(-W, -W + 0.02, 0, 0.1, 0, D)
        r.box(W - 0.02, W, 0, 0.1, 0, D)
        r.box(x1 + 0.08, W, 0, 0.1, D - 0.02, D)
        r.box(-W, x0 - 0.08, 0, 0.1, D - 0.02, D)
        r.box(x0 - 0.08, x0, 0, top + 0.08, D - 0.025, D)
        r.box(x1, x1 + 0.08, 0, top + 0.08, D - 0.025, D)
        r.box(x0, x1, top, top + 0.08, D - 0.025, D)
    rng = random.Random(3)
    with r.block("# floor of planks"):
        width = 0.125
        for k in range(40):
            x, z = -W + k * width, 0.0
            while z < D + 0.12:
                end = min(z + rng.uniform(0.9, 1.9), D + 0.12)
                tone = rng.uniform(0.75, 1.15)
                r(f"Color [{.42 * tone:.3f} {.27 * tone:.3f} {.15 * tone:.3f}]")
                r.quad((x, 0, end), (x + width, 0, end), (x + width, 0, z), (x, 0, z))
                z = end


def corridor(r):
    z0, z1, h = D + 0.12, 6.7, 2.5
    with r.block("Color [.82 .76 .62]"):
        r.quad((-4, h, z1), (4, h, z1), (4, 0, z1), (-4, 0, z1))
        r.quad((-4, h, z0), (-4, h, z1), (-4, 0, z1), (-4, 0, z0))
        r.quad((4, h, z1), (4, h, z0), (4, 0, z0), (4, 0, z1))
        r("Color [.8 .8 .8]")
        r.quad((-4, h, z0), (4, h, z0), (4, h, z1), (-4, h, z1))
        r("Color [.5 .45 .4]")
        r.quad((-4, 0, z1), (4, 0, z1), (4, 0, z0), (-4, 0, z0))


def lamps(r):
    """In the corridor; what follows is lit by them."""
    r.panel(-2.0, -0.9, 2.48, 5.6, 6.2, (260, 222, 166))
    r.panel(1.2, 2.3, 2.48, 5.6, 6.2, (104, 89, 67))


def door(r):
    """Hinged at the left of the frame, 34 degrees open into the room."""
    x0, x1, top = DOOR
    w = x1 - x0 - 0.01
    with r.block(f"Translate {x0} 0 {D}", "Rotate 34 0 1 0", CREAM):
        r.box(0, 0.11, 0.01, top - 0.01, -0.04, 0)  # stiles and rails, and three panels set back
        r.box(w - 0.11, w, 0.01, top - 0.01, -0.04, 0)
        for low, high in ((0.01, 0.2), (0.75, 0.87), (1.4, 1.5), (top - 0.13, top - 0.01)):
            r.box(0.11, w - 0.11, low, high, -0.04, 0)
        r.box(0.11, w - 0.11, 0.2, top - 0.13, -0.028, -0.012)
        r(BRASS)
        for z in (-0.085, 0.045):
            with r.block(f"Translate {w - 0.055:.3f} 1.02 {z}"):
                r("Sphere 0.028 -0.028 0.028 360")
        with r.block(f"Translate {w - 0.055:.3f} 1.02 -0.09"):
            r("Cylinder 0.009 0 0.14 360")


def table(r):
    with r.block("Translate -0.55 0 2.75", "Rotate 12 0 1 0", WALNUT):
        r.cushion(-0.7, 0.7, 0.7, 0.74, -0.4, 0.4, 0.012)
        r.box(-0.6, 0.6, 0.61, 0.7, -0.33, -0.31)
        r.box(-0.6, 0.6, 0.61, 0.7, 0.31, 0.33)
        r.box(-0.62, -0.6, 0.61, 0.7, -0.3, 0.3)
        r.box(0.6, 0.62, 0.61, 0.7, -0.3, 0.3)
        for x in (-0.6, 0.6):
            for z in (-0.31, 0.31):
                with r.block(f"Translate {x} 0 {z}"):
                    r.lathe([(0.001, 0), (0.02, 0.01), (0.028, 0.1), (0.02, 0.16), (0.035, 0.35), (0.024, 0.52),
                             (0.04, 0.58), (0.04, 0.7)], 12)
        with r.block("Color [.72 .74 .78]", "Translate -0.18 0.74 0.02", "Rotate -90 1 0 0", "Rotate 140 0 0 1",
                     "Scale 0.055 0.055 0.055"):
            r('Geometry "teapot"')
        for x, z, turn in ((0.2, -0.15, 20), (0.35, 0.15, 70), (-0.5, -0.2, -40)):
            with r.block("Color [.78 .76 .72]", f"Translate {x} 0.74 {z}", f"Rotate {turn} 0 1 0"):
                r.lathe([(0.001, 0.004), (0.05, 0.004), (0.075, 0.014), (0.078, 0.018), (0.05, 0.01), (0.001, 0.01)], 20)
                r("Translate 0 0.01 0")
                r.lathe([(0.001, 0), (0.022, 0), (0.036, 0.03), (0.04, 0.065), (0.037, 0.065), (0.033, 0.03), (0.018, 0.006),
                         (0.001, 0.006)], 20)
                with r.block("Translate 0.045 0.035 0", "Scale 1 1.3 0.6"):
                    r("Torus 0.015 0.004 0 360 360")
        with r.block("Translate 0.52 0.74 -0.05"):  # a bowl with oranges
            r("Color [.35 .45 .5]")
            r.lathe([(0.001, 0), (0.05, 0), (0.055, 0.015), (0.11, 0.05), (0.14, 0.085), (0.134, 0.086), (0.1, 0.056),
                     (0.05, 0.025), (0.001, 0.022)], 24)
            r("Color [.85 .4 .06]")
            for x, y, z in ((0.05, 0.075, 0.02), (-0.045, 0.075, 0.03), (0, 0.075, -0.055), (0.005, 0.13, 0)):
                with r.block(f"Translate {x} {y} {z}"):
                    r("Sphere 0.04 -0.04 0.04 360")


def chair(r, x, z, turn):
    with r.block(f"Translate {x} 0 {z}", f"Rotate {turn} 0 1 0", OAK):
        for cx in (-0.19, 0.19):
            r.box(cx - 0.02, cx + 0.02, 0, 0.44, -0.2, -0.16)
            r.cushion(cx - 0.02, cx + 0.02, 0, 0.95, 0.16, 0.2, 0.008)
        r.cushion(-0.22, 0.22, 0.44, 0.475, -0.22, 0.21, 0.012)
        for y in (0.6, 0.72, 0.84):
            r.cushion(-0.19, 0.19, y, y + 0.06, 0.165, 0.185, 0.006)
        r.box(-0.19, 0.19, 0.2, 0.23, -0.19, -0.17)


def sofa(r):
    with r.block("Translate 1.95 0 2.6", "Rotate 90 0 1 0", "Color [.2 .33 .38]"):
        # Seen from its front: width along x, back at high z.
        r.cushion(-0.95, 0.95, 0.1, 0.28, -0.4, 0.42, 0.03)
        r.cushion(-1.05, -0.85, 0.08, 0.62, -0.42, 0.45, 0.06)
        r.cushion(0.85, 1.05, 0.08, 0.62, -0.42, 0.45, 0.06)
        r.cushion(-1.0, 1.0, 0.12, 0.85, 0.3, 0.48, 0.06)
        for x in (-0.84, 0.005):
            r.cushion(x, x + 0.835, 0.28, 0.42, -0.43, 0.3, 0.05, 0.03)
        for x, turn, color in ((-0.6, 12, ".75 .55 .2"), (0.55, -14, ".6 .2 .15"), (0.25, 5, ".7 .68 .6")):
            with r.block(f"Translate {x} 0.62 0.17", f"Rotate {turn} 0 0 1", "Rotate 72 1 0 0", f"Color [{color}]"):
                r.cushion(-0.2, 0.2, -0.03, 0.03, -0.2, 0.2, 0.05, 0.07)


def bookshelf(r):
    rng = random.Random(11)
    x0, x1, z0, z1, top = -W, -W + 0.3, 1.1, 2.7, 2.1
    with r.block(OAK):
        r.box(x0, x1, 0, top, z0, z0 + 0.03)
        r.box(x0, x1, 0, top, z1 - 0.03, z1)
        r.box(x0, x0 + 0.01, 0, top, z0, z1)
        for k in range(6):
            y = 0.08 + k * (top - 0.11) / 5
            r.box(x0, x1, y, y + 0.03, z0, z1)
    palette = ((.5, .1, .08), (.1, .2, .4), (.1, .3, .15), (.6, .5, .3), (.25, .15, .1), (.7, .68, .6), (.15, .15, .17),
               (.6, .3, .1))
    for k in range(5):
        y = 0.11 + k * (top - 0.11) / 5
        z = z0 + 0.05
        while z < z1 - 0.12:
            if rng.random() < 0.08:
                z += rng.uniform(0.05, 0.2)
                continue
            thick, height, depth = rng.uniform(0.015, 0.045), rng.uniform(0.2, 0.32), rng.uniform(0.16, 0.23)
            color = [c * rng.uniform(0.7, 1.2) for c in palette[rng.randrange(len(palette))]]
            with r.block(f"Color [{color[0]:.3f} {color[1]:.3f} {color[2]:.3f}]"):
                r.box(x0 + 0.02, x0 + 0.02 + depth, y, y + height, z, z + thick)
            with r.block("Color [.75 .72 .62]"):  # pages
                r.box(x0 + 0.02, x0 + depth, y + height, y + height + 0.002, z + 0.003, z + thick - 0.003)
            z += thick + 0.002


def rug(r):
    """Thick pile: a mesh with bumps, and more of them by displacement."""
    with r.block("Color [.5 .16 .12]", 'Attribute "displacementbound" "float sphere" [0.012]',
                 'Displacement "dented" "float Km" [0.02] "float frequency" [40]'):
        r.grid(60, 44, lambda u, v: (-1.75 + 2.6 * u, 0.014 + 0.012 * fractal(40 * u, 30 * v, 2), 1.7 + 1.9 * v))


def lamp_and_plant(r):
    with r.block("Translate 2.1 0 4.45"):
        r(BRASS)
        r.lathe([(0.001, 0), (0.14, 0), (0.14, 0.02), (0.03, 0.03), (0.012, 0.08), (0.012, 1.45), (0.001, 1.45)], 16)
        r("Color [.8 .74 .6]")
        r.lathe([(0.2, 1.35), (0.13, 1.68)], 24)
    rng = random.Random(5)
    with r.block("Translate 0.55 0 4.5"):
        r("Color [.65 .33 .2]")
        r.lathe([(0.001, 0), (0.13, 0), (0.15, 0.05), (0.19, 0.3), (0.2, 0.34), (0.17, 0.34), (0.16, 0.28), (0.001, 0.28)], 20)
        for _ in range(46):
            turn, tilt, length = rng.uniform(0, 360), rng.uniform(8, 62), rng.uniform(0.45, 0.95)
            green = rng.uniform(0.8, 1.2)
            with r.block("Translate 0 0.28 0", f"Rotate {turn:.1f} 0 1 0", f"Rotate {tilt:.1f} 1 0 0",
                         f"Color [{.13 * green:.3f} {.35 * green:.3f} {.09 * green:.3f}]"):
                bend = rng.uniform(0.2, 0.5)
                r.grid(2, 8, lambda u, v: ((u - 0.5) * 0.09 * math.sin(math.pi * (0.06 + 0.92 * v)),
                                           length * v - 0.35 * bend * length * v * v + 0.02 * abs(2 * u - 1),
                                           bend * length * v * v))


def pictures(r):
    for z, y, w, h, color in ((3.35, 1.6, 0.5, 0.36, ".2 .3 .45"), (4.1, 1.6, 0.36, 0.5, ".6 .45 .2")):
        with r.block(WALNUT):
            x = -W
            r.box(x, x + 0.03, y - h, y - h + 0.04, z - w / 2, z + w / 2)
            r.box(x, x + 0.03, y + 0.0, y + 0.04, z - w / 2, z + w / 2)
            r.box(x, x + 0.03, y - h, y + 0.04, z - w / 2, z - w / 2 + 0.04)
            r.box(x, x + 0.03, y - h, y + 0.04, z + w / 2 - 0.04, z + w / 2)
            r(f"Color [{color}]")
            r.box(x, x + 0.015, y - h, y, z - w / 2, z + w / 2)
    with r.block("Translate 0.75 1.75 4.99", "Color [.75 .75 .72]"):  # a clock
        r("Rotate 180 0 1 0", "Disk 0.005 0.17 360", WALNUT, "Torus 0.175 0.018 0 360 360")
    with r.block("Color [.7 .7 .66]"):  # curtains before a dark window, at the left of the camera
        r.grid(40, 4, lambda u, v: (-W + 0.1 + 0.04 * math.sin(44 * u), 0.05 + 2.3 * v, 0.15 + 0.8 * u))


def main():
    folder = target_folder()
    r = Rib()
    r("##Scene door_interior")
    r.camera("door_interior", (256, 192), 50, (1.75, 1.55, 0.25), (-0.55, 0.93, 4))
    r('Attribute "trace" "int maxdiffusedepth" [10] "int maxspeculardepth" [0]')
    r('Surface "matte" "float Ka" [0] "float Kd" [1]')
    lamps(r)
    corridor(r)
    room(r)
    door(r)
    table(r)
    chair(r, -0.75, 3.5, 192)
    chair(r, 0.05, 2.05, 25)
    chair(r, -1.05, 2.05, -20)
    sofa(r)
    bookshelf(r)
    rug(r)
    lamp_and_plant(r)
    pictures(r)
    r("WorldEnd")
    r.save(folder)


main()
