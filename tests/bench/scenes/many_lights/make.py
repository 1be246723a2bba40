#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Twelve rooms in a row, joined by wide doorways, each with 20 lights: a chandelier of 12 bulbs, 6 lamps along the
walls and 2 spots. Rooms are painted and lit in different colours and strengths."""
import math
import os
import random
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from ribwriter import Rib, target_folder  # noqa: E402

ROOMS = 12
W, H, L = 2.6, 3.0, 5.0  # half the width, height and length of a room
DOOR, LINTEL, WALL = 1.5, 2.5, 0.1  # half the width and height of the doorways; half the thickness of walls
PAINTS = ((.78, .72, .6), (.45, .6, .7), (.72, .42, .35), (.5, .65, .45), (.75, .65, .72), (.7, .6, .35))
BULBS = ((1, .8, .55), (1, .9, .75), (.75, .87, 1))
MATTE = 'Surface "matte" "float Ka" [0] "float Kd" [1]'


def color(c):
    return "Color [" + " ".join(f"{v:.3g}" for v in c) + "]"


def lights(r, room, rng):
    z, bulb, strength = (room + 0.5) * L, BULBS[room % 3], rng.uniform(0.5, 1.5)
    for k in range(12):  # the chandelier: bulbs on two rings
        ring, angle = k % 2, 2 * math.pi * k / 12
        radius, y = (0.42, 2.2) if ring else (0.24, 2.35)
        r.lights += 1
        with r.block('Surface "matte" "float Kd" [0] "float Ka" [0]',
                     f'AreaLightSource "arealight" "l{r.lights}" "float intensity" [{12 * strength:.3f}] '
                     f'"color lightcolor" [{bulb[0]} {bulb[1]} {bulb[2]}]',
                     f"Translate {radius * math.cos(angle):.4f} {y} {z + radius * math.sin(angle):.4f}"):
            r("Sphere 0.045 -0.045 0.045 360")
        r(f'Illuminate "l{r.lights}" 1')
    for side in (-1, 1):  # lamps along the walls
        for k in (-1, 0, 1):
            r.light("pointlight", f'"float intensity" [{rng.uniform(.05, .15):.4f}] "color lightcolor" [1 .72 .45] '
                    f'"point from" [{side * (W - .25)} 1.7 {z + 1.5 * k}]')
    for side in (-1, 1):  # spots on the busts
        r.light("spotlight", f'"float intensity" [{rng.uniform(1, 3):.3f}] "color lightcolor" [1 .95 .88] '
                f'"point from" [{side * .8} 2.9 {z - 1.2}] "point to" [{side * 1.9} 1 {z + .75}] '
                '"float coneangle" [.4] "float conedeltaangle" [.15]')


def walls(r, room, rng):
    z0, z1 = room * L, (room + 1) * L
    with r.block(color(PAINTS[room % len(PAINTS)])):
        r.quad((-W, H, z0), (-W, H, z1), (-W, 0, z1), (-W, 0, z0))
        r.quad((W, H, z1), (W, H, z0), (W, 0, z0), (W, 0, z1))
        r("Color [.8 .79 .76]")
        r.quad((W, H, z0), (-W, H, z0), (-W, H, z1), (W, H, z1))
        if room + 1 == ROOMS:
            r.quad((-W, H, z1), (W, H, z1), (W, 0, z1), (-W, 0, z1))
        else:  # the wall to the next room
            r(color(PAINTS[room % len(PAINTS)]))
            r.box(-W, -DOOR, 0, H, z1 - WALL, z1 + WALL)
            r.box(DOOR, W, 0, H, z1 - WALL, z1 + WALL)
            r.box(-DOOR, DOOR, LINTEL, H, z1 - WALL, z1 + WALL)
    with r.block('Surface "paintedplastic" "float Ka" [0] "float Kd" [.85] "float Ks" [.15] "float roughness" [.1]',
                 "Color [.36 .24 .15]"):
        r.quad((-W, 0, z1), (W, 0, z1), (W, 0, z0), (-W, 0, z0))


def furniture(r, room, rng):
    z = (room + 0.5) * L
    for side in (-1, 1):
        x = side * 1.9
        with r.block("Color [.7 .7 .68]"):
            r.box(x - .22, x + .22, 0, .9, z + .53, z + .97)
        with r.block(color([rng.uniform(.3, .8) for _ in range(3)]),
                     'Surface "plastic" "float Ka" [0] "float Kd" [.7] "float Ks" [.3] "float roughness" [.08]',
                     f"Translate {x} 1.16 {z + .75:.3f}"):
            r("Sphere 0.25 -0.25 0.25 360")
    with r.block(color([rng.uniform(.2, .5) for _ in range(3)]), f"Translate {rng.uniform(-.9, .9):.3f} 0 {z:.3f}",
                 f"Rotate {rng.uniform(0, 90):.1f} 0 1 0"):
        r.cushion(-.5, .5, .05, .42, -.25, .25, .05, .03)


def main():
    folder = target_folder()
    rng = random.Random(12)
    r = Rib()
    r("##Scene many_lights")
    r.camera("many_lights", (256, 192), 62, (-0.7, 1.6, 0.4), (0.35, 1.25, 6))
    r('Attribute "trace" "int maxdiffusedepth" [3] "int maxspeculardepth" [2]', MATTE)
    for room in range(ROOMS):
        lights(r, room, rng)
    r("Color [.6 .58 .55]")
    r.quad((W, H, 0), (-W, H, 0), (-W, 0, 0), (W, 0, 0))  # behind the camera
    for room in range(ROOMS):
        walls(r, room, rng)
        furniture(r, room, rng)
    r("WorldEnd")
    r.save(folder)


main()
