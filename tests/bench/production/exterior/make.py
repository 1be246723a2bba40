#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A farmhouse in the evening: terrain, walls, tiles, cobbles and timber, all displaced and with textures, under the production
shader; thousands of instances of grass, weeds, flowers, bushes and twigs, whose leaves are cut out by alpha; sun and a
painted sky. What the wind moves is blurred, as are the wheel of a wind pump and, by the camera's way, all of it."""
import math
import os
import random
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import synthesis  # noqa: E402
from stage import Stage, arguments, fmt, fractal  # noqa: E402
from synthesis import (blend, cells, contrast, coordinates, courses, fbm, save_color, save_data, save_hdr,  # noqa: E402
                       save_mottled, save_wood, shade)

HOUSE, TURN = (3.9, 6.5), -30  # where its front's middle stands, and how it is turned about y
WIDE, DEEP, EAVES, RIDGE = 4.0, 6.0, 3.5, 6.3  # half its width, depth, heights
EYE, AT = (-1.2, 1.75, -11.0), (0.9, 2.35, 5.0)


def textures(folder, seed):
    size = synthesis.SIZE
    grain, broad = fbm(size, 32, 5, seed), fbm(size, 4, 6, seed + 1)
    edge, own = courses(size, 5, 8, seed + 2, wobble=0.35)  # walls of rough stones
    stone = contrast(edge, 0.03, 0.22)
    tone = 0.62 + 0.45 * own + 0.5 * (grain - 0.5) + 0.3 * (broad - 0.5)
    save_color(folder, "stones.png", blend(shade((0.5, 0.44, 0.36), 0.7 + 0.4 * grain),
                                           shade((0.46, 0.4, 0.33), tone) * (1 + 0.25 * np.sin(9 * own)[..., None] *
                                                                             np.array((1, 0, -0.9), np.float32)), stone))
    save_data(folder, "stones_height.png", stone * (0.6 + 0.25 * own) + 0.15 * grain)
    s, t = coordinates(size)
    edge, own = courses(size, 16, 12, seed + 3, shift=0.0)  # tiles of clay, each row over the next one
    x, y = s * 16 % 1, t * 12 % 1
    tile = np.abs(np.sin(np.pi * x)) ** 0.6
    save_color(folder, "tiles.png", shade((0.5, 0.2, 0.11), (0.5 + 0.7 * own) * (0.55 + 0.45 * contrast(y, 0, 0.12)) *
                                          (0.6 + 0.6 * grain)))
    save_data(folder, "tiles_height.png", 0.65 * tile + 0.3 * y + 0.05 * grain)
    first, second, own = cells(size, 7, 7, seed + 4)  # cobbles
    gap = second - first
    cobble = 1 - (1 - contrast(gap, 0.02, 0.4)) ** 1.5
    save_color(folder, "cobbles.png", blend((0.12, 0.13, 0.05), shade((0.42, 0.38, 0.33), 0.65 + 0.5 * own + 0.4 * (grain - 0.5)),
                                            contrast(gap, 0.03, 0.14)))
    save_data(folder, "cobbles_height.png", 0.85 * cobble + 0.15 * grain)
    pebble, _, own = cells(size, 28, 28, seed + 5)  # soil
    some = contrast(own, 0.55, 0.6) * contrast(0.36 - pebble, 0, 0.05)
    soil = blend(shade((0.2, 0.15, 0.09), 0.6 + 0.7 * grain), (0.15, 0.19, 0.06), contrast(broad, 0.42, 0.58))
    save_color(folder, "soil.png", blend(soil, shade((0.4, 0.36, 0.3), 0.6 + 0.5 * own), some))
    save_data(folder, "soil_height.png", 0.55 * broad + 0.25 * grain + 0.2 * some * np.sqrt(np.clip(1 - pebble / 0.36, 0, 1)))
    ridges = 1 - np.abs(2 * fbm(size, (20, 3), 5, seed + 6) - 1)
    save_color(folder, "bark.png", blend((0.07, 0.05, 0.035), shade((0.3, 0.24, 0.18), 0.6 + 0.7 * grain), ridges ** 2))
    save_data(folder, "bark_height.png", ridges ** 1.5 * 0.85 + 0.15 * grain)
    save_wood(folder, "timber", seed + 7, (0.42, 0.33, 0.23), (0.2, 0.14, 0.09), planks=5)
    save_mottled(folder, "iron", seed + 8, (0.3, 0.3, 0.31), (0.24, 0.15, 0.1))
    leaves(folder)
    sky(folder, seed)


def leaves(folder):
    """Alphas: base at t = 0, tip at t = 1."""
    size = 256
    s, t = coordinates(size)
    x = np.abs(s - 0.5)
    rim = 2.5 / size

    def save(name, inside):
        alpha = np.clip(0.5 + inside / rim, 0, 1)[..., None]
        save_color(folder, name, np.concatenate([np.ones((size, size, 3), np.float32), alpha], axis=-1))

    whole = 0.42 * np.sin(np.pi * np.clip((t - 0.1) / 0.9, 0, 1) ** 0.8) * (1 + 0.13 * (np.abs((t * 14 % 1) - 0.5) - 0.25))
    save("broad.png", np.maximum(whole - x, np.minimum(0.02 - x, 0.15 - t)))
    reach = 0.47 * np.clip(np.sin(np.pi * np.clip(0.06 + 0.94 * t, 0, 1)), 0, 1) ** 0.7
    row = np.abs(((t - 0.4 * x) * 13) % 1 - 0.5)
    save("fern.png", np.maximum(np.minimum(0.4 * (1 - x / np.maximum(reach, 1e-3)) - row, (reach - x) * 3) / 6, 0.012 - x))


def sky(folder, seed):
    """Radiance by direction, z up: rows from above down, the sun's half brighter."""
    height, width = 256, 512
    theta = (np.arange(height) + 0.5) / height * math.pi
    up = np.cos(theta)[:, None]
    haze = np.exp(-np.maximum(up, 0) * 4)
    clear = np.asarray((0.16, 0.3, 0.62))[None, None] * (1 - haze[..., None]) + np.asarray((0.72, 0.7, 0.66)) * haze[..., None]
    clear = np.broadcast_to(clear, (height, width, 3))
    noise = fbm(512, (6, 12), 6, seed + 30)
    clouds = contrast(noise[:height] + 0.1 * haze, 0.5, 0.68) * contrast(up, 0.02, 0.25)
    lit = np.asarray((1.25, 1.12, 0.98)) * (0.55 + 0.6 * noise[:height, :, None])
    picture = clear + (lit - clear) * (0.85 * clouds)[..., None]
    ground = np.asarray((0.14, 0.12, 0.08))
    below = contrast(-up, 0, 0.02)[..., None]
    save_hdr(folder, "sky.hdr", picture * (1 - below) + ground * below)


def ground(x, z):
    """Height of the terrain."""
    hills = max(0, min(1, (z - 16) / 70))
    rough = 0.55 * (fractal(x / 7 + 90, z / 7 + 90, 3, 4) - 0.5)
    flat = max(0, min(1, (math.hypot(x - HOUSE[0], z - HOUSE[1] - 2) - 5) / 8))
    return rough * flat + hills * hills * (7 + 16 * (fractal(x / 42 + 50, z / 42 + 50, 3, 9) - 0.4))


def path(v):
    """The middle of the way, from before the camera to the door."""
    return -2.6 + 5.55 * v ** 1.6 + 0.5 * math.sin(3 * v), -13 + 18.9 * v


PATH = [path(k / 40) for k in range(41)]


def clear_of(x, z, reach):
    """Whether nothing is built there."""
    a = math.radians(-TURN)
    dx, dz = x - HOUSE[0], z - HOUSE[1]
    u, w = dx * math.cos(a) + dz * math.sin(a), dz * math.cos(a) - dx * math.sin(a)
    if abs(u) < WIDE + 0.2 + reach and -0.2 - reach < w < DEEP + 0.2 + reach:
        return False
    return min((x - px) ** 2 + (z - pz) ** 2 for px, pz in PATH) > (0.75 + reach) ** 2


def weathered(r, name, height, repeat=None, solid=0, **values):
    """The production shader with a texture, displaced by its heights; or, where s and t jump from face to face, by dents in
    space, of frequency `solid`."""
    given = dict(paintcolor=(0.9, 0.9, 0.9), paintmap=name + ".tx", wear=0, rust=0, scratches=0.1, gloss=0.15, roughness=0.6,
                 dirt=0.25, dust=0.1, streaks=0.4, frequency=0.7)
    given.update(values)
    r.production(**given)
    if solid:
        r.dents(height, solid)
    else:
        r.displace(name + "_height.tx", height)
    if repeat:
        r.repeat(*repeat)


def terrain(r):
    n, m = 56, 72
    points, st = [], []
    for j in range(m + 1):
        v = j / m
        z = -15 + 30 * v + 125 * v ** 3
        for i in range(n + 1):
            x = (2 * i / n - 1) * (14 + 0.95 * (z + 15))
            points.append((x, ground(x, z), z))
            st.append((x / 5, z / 5))
    with r.block():
        weathered(r, "soil", 0.16, dust=0, streaks=0, gloss=0.05)
        at = lambda i, j: j * (n + 1) + i
        r.mesh(points, [(at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)) for j in range(m) for i in range(n)], st)
    with r.block():
        weathered(r, "cobbles", 0.07, dirt=0.3, gloss=0.4, roughness=0.35)

        def way(u, v):
            x, z = path(v)
            x, z = x + (u - 0.5) * 1.5, z + 0.25 * (u - 0.5)
            return x, ground(x, z) + 0.07 - 0.12 * (2 * u - 1) ** 4, z
        r.grid(6, 40, way, (1, 13))


def wall(r, x0, x1, height, openings):
    """Along x, its front at z = 0, with holes (x, y, width, height), one to a column; with reveals."""
    def part(a, b, low, high):
        if b - a < 1e-6 or high - low < 1e-6:
            return
        st = [c / 2.2 for c in (a, -high, b, -high, b, -low, a, -low)]
        r(f'Polygon "P" [{fmt((a, high, 0, b, high, 0, b, low, 0, a, low, 0))}] "st" [{fmt(st)}]')
    edge = x0
    for x, y, w, h in sorted(openings):
        a, b = x - w / 2, x + w / 2
        part(edge, a, 0, height)
        part(a, b, 0, y)
        part(a, b, y + h, height)
        edge = b
        for p, q in (((a, y), (a, y + h)), ((b, y + h), (b, y)), ((a, y + h), (b, y + h)), ((b, y), (a, y))):
            r.quad((*p, 0), (*q, 0), (*q, 0.35), (*p, 0.35), (0.16, 0.6))
    part(edge, x1, 0, height)


def window(r, x, y, w, h):
    with r.block(f"Translate {x} {y} 0"):
        with r.block('Surface "principled" "color basecolor" [.03 .04 .05] "float roughness" [.08] "float specular" [1]'):
            r.quad((-w / 2, h, 0.24), (w / 2, h, 0.24), (w / 2, 0, 0.24), (-w / 2, 0, 0.24))
        with r.block():
            weathered(r, "timber", 0.006, solid=14, paintcolor=(0.75, 0.73, 0.68), paintmap="", wear=0.35, frequency=3)
            for k in (-w / 2, -0.03, w / 2 - 0.06):
                r.cushion(k, k + 0.06, 0, h, 0.16, 0.22, 0.008)
            for k in (0, h * 0.62, h - 0.06):
                r.cushion(-w / 2, w / 2, k, k + 0.06, 0.17, 0.21, 0.008)
        with r.block():
            weathered(r, "stones", 0.04, (0.5, 0.2), solid=5)
            r.cushion(-w / 2 - 0.15, w / 2 + 0.15, -0.14, 0, -0.12, 0.3, 0.03)
            r.cushion(-w / 2 - 0.18, w / 2 + 0.18, h, h + 0.2, -0.05, 0.3, 0.03)
        with r.block():
            weathered(r, "timber", 0.015, (0.6, 1.1), solid=8, paintcolor=(0.2, 0.42, 0.4), wear=0.5, frequency=2.5)
            for side in (-1, 1):
                x0 = side * (w * 0.75 + 0.05)
                r.cushion(x0 - w / 4, x0 + w / 4, 0, h, -0.06, -0.02, 0.01)
                for k in (0.12, h - 0.22):
                    r.cushion(x0 - w / 4 + 0.03, x0 + w / 4 - 0.03, k, k + 0.1, -0.085, -0.05, 0.008)


def house(r):
    with r.block(f"Translate {HOUSE[0]} 0 {HOUSE[1]}", f"Rotate {TURN} 0 1 0"):
        windows = [(-2.9, 1.0, 0.95, 1.35), (0.75, 1.0, 0.95, 1.35), (2.75, 1.0, 0.95, 1.35)]
        door = (-1.1, 0.02, 1.1, 2.15)
        with r.block('Surface "matte" "float Kd" [.04] "float Ka" [0]'):  # what is seen through cracks
            r.box(-WIDE + 0.4, WIDE - 0.4, 0, EAVES, 0.4, DEEP - 0.4)
        with r.block():
            weathered(r, "stones", 0.09)
            wall(r, -WIDE, WIDE, EAVES, windows + [door])
            side = [(3.0, 1.0, 0.95, 1.35)]
            for where, turn in (((-WIDE, DEEP), 90), ((WIDE, 0), -90)):
                with r.block(f"Translate {where[0]} 0 {where[1]}", f"Rotate {turn} 0 1 0"):
                    wall(r, 0, DEEP, EAVES, side)
                    st = [c / 2.2 for c in (0, -EAVES, DEEP / 2, -RIDGE, DEEP, -EAVES)]
                    r(f'Polygon "P" [{fmt((0, EAVES, 0, DEEP / 2, RIDGE, 0, DEEP, EAVES, 0))}] "st" [{fmt(st)}]')
            with r.block(f"Translate {WIDE} 0 {DEEP}", "Rotate 180 0 1 0"):
                wall(r, 0, 2 * WIDE, EAVES, [])
        with r.block(f"Translate {-WIDE} 0 {DEEP}", "Rotate 90 0 1 0"):
            window(r, *side[0])
        for opening in windows:
            window(r, *opening)
        with r.block():  # quoins
            weathered(r, "stones", 0.05, (0.4, 0.2), solid=5, paintcolor=(1, 0.98, 0.94))
            rng = random.Random(4)
            for x in (-WIDE, WIDE):
                y, k = 0.0, 0
                while y < EAVES - 0.2:
                    h, long = rng.uniform(0.26, 0.36), 0.34 if k % 2 else 0.2
                    r.cushion(x - (0.06 if x < 0 else long), x + (long if x < 0 else 0.06), y, y + h - 0.015, -0.06,
                              0.54 - long, 0.03)
                    y, k = y + h, k + 1
        with r.block():
            weathered(r, "tiles", 0.06, streaks=0.5, dirt=0.4, dust=0.2)
            over, slope = 0.45, (RIDGE - EAVES) / (DEEP / 2)
            low, y = -over, EAVES - over * slope + 0.14
            x0, x1 = -WIDE - 0.35, WIDE + 0.35
            r.sheet((x0, RIDGE + 0.14, DEEP / 2), (x1, RIDGE + 0.14, DEEP / 2), (x1, y, low), (x0, y, low), (3, 2.4))
            r.sheet((x1, RIDGE + 0.14, DEEP / 2), (x0, RIDGE + 0.14, DEEP / 2), (x0, y, DEEP + over), (x1, y, DEEP + over), (3, 2.4))
            with r.block(f"Translate 0 {RIDGE + 0.1} {DEEP / 2}", "Rotate 90 0 0 1", "Rotate 180 0 1 0"):
                r.lathe([(0.001, x0), (0.13, x0), (0.13, x1), (0.001, x1)], 12, (1, 3))
        with r.block():
            weathered(r, "timber", 0.015, (3, 0.3), solid=6, wear=0.2)
            for z in (-0.42, DEEP + 0.36):
                r.cushion(x0, x1, y - 0.1, y - 0.02, z, z + 0.06, 0.01)
            for x in (x0, x1 - 0.05):  # barge boards
                for z0, z1 in ((low, DEEP / 2), (DEEP + over, DEEP / 2)):
                    r.sheet((x, y - 0.02, z0), (x, RIDGE + 0.12, z1), (x, RIDGE - 0.12, z1), (x, y - 0.26, z0), (3, 0.2))
        with r.block():  # the door, and steps before it
            weathered(r, "timber", 0.02, (1, 1), paintcolor=(0.55, 0.2, 0.13), wear=0.45, frequency=2.5)
            r.sheet((door[0] - 0.55, 2.17, 0.2), (door[0] + 0.55, 2.17, 0.2), (door[0] + 0.55, 0.02, 0.2), (door[0] - 0.55, 0.02, 0.2))
        with r.block():
            weathered(r, "stones", 0.05, (0.6, 0.3), solid=4)
            r.cushion(door[0] - 0.85, door[0] + 0.85, 2.17, 2.42, -0.06, 0.3, 0.03)
            r.cushion(door[0] - 0.9, door[0] + 0.9, -0.2, 0.1, -0.7, 0.3, 0.03)
            r.cushion(2.1, 2.85, EAVES + 1.4, RIDGE + 0.9, 2.0, 2.75, 0.05)  # the chimney
            r.cushion(2.0, 2.95, RIDGE + 0.9, RIDGE + 1.05, 1.9, 2.85, 0.04)
        yard(r, door)


def yard(r, door):
    """A bench, a barrel, pots beside the door, a water pipe."""
    with r.block("Translate 1.75 0 -0.5"):
        weathered(r, "timber", 0.015, (1.4, 0.3), solid=9, wear=0.3)
        for k in range(3):
            r.cushion(-0.75, 0.75, 0.42, 0.465, -0.25 + k * 0.16, -0.11 + k * 0.16, 0.012)
        for x in (-0.62, 0.52):
            r.cushion(x, x + 0.1, 0, 0.43, -0.2, 0.2, 0.015)
    with r.block("Translate -3.6 0 -0.6"):
        weathered(r, "timber", 0.02, wear=0.2)
        r.lathe([(0.001, 0), (0.3, 0), (0.32, 0.05), (0.39, 0.45), (0.32, 0.88), (0.3, 0.92), (0.27, 0.9), (0.27, 0.8),
                 (0.001, 0.78)], 24, (1, 1))
        weathered(r, "iron", 0.006, rust=0.8, wear=1)
        for y, radius in ((0.16, 0.355), (0.7, 0.37)):
            with r.block(f"Translate 0 {y} 0", "Rotate -90 1 0 0"):
                r(f"Torus {radius} 0.025 0 360 360")
    rng = random.Random(6)
    for x, z, size in ((door[0] - 1.05, -0.45, 1), (door[0] + 1.0, -0.5, 0.85), (door[0] + 1.4, -0.75, 0.6), (3.6, -0.4, 1.1)):
        with r.block(f"Translate {x} 0 {z}", f"Scale {size} {size} {size}"):
            with r.block():
                weathered(r, "iron", 0.012, paintcolor=(0.6, 0.27, 0.15), paintmap="", wear=0.1)
                r.nurbs_lathe([(0.001, 0), (0.2, 0), (0.24, 0.15), (0.34, 0.42), (0.36, 0.5), (0.3, 0.5), (0.28, 0.42), (0.001, 0.4)])
            for kind in ("weed", "flower", "flower", "flower"):
                with r.block(f"Translate {rng.uniform(-.12, .12):.3f} 0.4 {rng.uniform(-.12, .12):.3f}",
                             f"Rotate {rng.uniform(0, 360):.1f} 0 1 0", "Scale 1.3 1.3 1.3"):
                    r(f'ObjectInstance "{kind}{rng.randrange(3)}"')


def card(r, width, length, bend, color, tip):
    """A bent leaf from the origin along y: s across, t from base to tip."""
    points = [((k / 3 - 0.5) * width, length * (f - 0.12 * f * f), bend * f * f - 0.12 * width * (1 - abs(2 * k / 3 - 1)))
              for f in (0, 1 / 3, 2 / 3, 1) for k in range(4)]
    r(f'Patch "bicubic" "P" [{fmt(c for p in points for c in p)}] "Cs" [{fmt((*color, *color, *tip, *tip))}]')


def plants(r, rng):
    """Objects, three kinds of each."""
    def cut(name, through):
        r(f'Surface "leaf" "float Ka" [0] "float Kd" [.62] "float Kt" [.3] "color transmitcolor" [{fmt(through)}] '
          f'"string texturename" ["{name}"]', 'Basis "bezier" 3 "bezier" 3')

    def cards(count, size, lift, spread, color, tip):
        for k in range(count):
            tone = rng.uniform(0.75, 1.25)
            w, h = size
            turn = 360 * (k + rng.random()) / count
            with r.block(f"Rotate {turn:.1f} 0 1 0", f"Translate 0 {rng.uniform(0, lift):.3f} {rng.uniform(0, spread):.3f}",
                         f"Rotate {rng.uniform(5, 55):.1f} 1 0 0"):
                card(r, w * rng.uniform(0.8, 1.2), h * rng.uniform(0.7, 1.2), h * rng.uniform(0.1, 0.6),
                     [c * tone * 0.7 for c in color], [c * tone for c in tip])

    def blades(count, color):
        points, colors = [], []
        for _ in range(count):
            a, d = rng.uniform(0, 2 * math.pi), rng.uniform(0, 0.13)
            x, z, h, lean = d * math.cos(a), d * math.sin(a), rng.uniform(0.18, 0.36), rng.uniform(0.02, 0.16)
            b = a + rng.uniform(-1, 1)
            for f in (0, 0.33, 0.67, 1):
                points += [x + lean * f * f * math.cos(b), h * (f - 0.12 * f * f), z + lean * f * f * math.sin(b)]
            tone = rng.uniform(0.7, 1.25)
            colors += [c * tone for c in color]
        r('Surface "matte" "float Ka" [0] "float Kd" [1]', 'Basis "bezier" 3 "bezier" 3',
          f'Curves "cubic" [{" ".join(["4"] * count)}] "nonperiodic" "P" [{fmt(points)}] '
          f'"varying float width" [{" ".join(["0.011 0.002"] * count)}] "uniform color Cs" [{fmt(colors)}]')

    for k in range(3):
        dry = (0.0, 0.35, 0.12)[k]
        green = [a + (b - a) * dry for a, b in zip((0.2, 0.34, 0.08), (0.55, 0.47, 0.2))]
        with r.object(f"grass{k}"):
            blades(16, green)
        with r.object(f"weed{k}"):
            cut(("broad.tx", "fern.tx", "broad.tx")[k], (0.8, 1, 0.35))
            cards(12, ((0.13, 0.24), (0.2, 0.5), (0.2, 0.2))[k], 0.12, 0.04, (0.13, 0.26, 0.07), (0.24, 0.36, 0.1))
        with r.object(f"flower{k}"):
            cut("fern.tx", (0.8, 1, 0.35))
            cards(5, (0.1, 0.22), 0.05, 0.03, (0.14, 0.28, 0.07), (0.22, 0.36, 0.1))
            petal = ((0.75, 0.1, 0.07), (0.8, 0.62, 0.1), (0.55, 0.42, 0.75))[k]
            for _ in range(4):
                x, z, h = rng.uniform(-.08, .08), rng.uniform(-.08, .08), rng.uniform(0.24, 0.42)
                with r.block("Color [.16 .3 .08]", 'Surface "matte" "float Ka" [0] "float Kd" [1]'):
                    r(f'Curves "cubic" [4] "nonperiodic" "P" [{fmt((0, 0, 0, x, h * .3, z, x, h * .7, z, 1.5 * x, h, 1.5 * z))}] '
                      '"constantwidth" [.008]')
                cut("broad.tx", petal)
                for turn in range(0, 360, 72):
                    with r.block(f"Translate {1.5 * x:.3f} {h:.3f} {1.5 * z:.3f}", f"Rotate {turn} 0 1 0", "Rotate 62 1 0 0"):
                        card(r, 0.045, 0.055, -0.012, [c * 0.6 for c in petal], petal)
        with r.object(f"twig{k}"):
            r.repeat(1, 1)
            cut("broad.tx", (0.85, 1, 0.35))
            for _ in range(20):
                along, tone = rng.uniform(0.08, 0.8), rng.uniform(0.7, 1.25)
                color = [c * tone for c in (0.16, 0.29, 0.07)]
                with r.block(f"Translate 0 {along:.3f} 0", f"Rotate {rng.uniform(0, 360):.1f} 0 1 0",
                             f"Rotate {rng.uniform(25, 95):.1f} 1 0 0"):
                    card(r, rng.uniform(0.12, 0.17), rng.uniform(0.18, 0.28), -0.06, color, [c * 1.3 for c in color])
            with r.block("Color [.22 .16 .1]", 'Surface "matte" "float Ka" [0] "float Kd" [1]', "Rotate -90 1 0 0"):
                r("Cone 0.85 0.012 360")
        with r.object(f"bush{k}"):
            cut("broad.tx", (0.8, 1, 0.35))
            for _ in range(80):
                a, c = rng.uniform(0, 2 * math.pi), rng.uniform(-0.1, 1)
                d, s = rng.uniform(0.6, 1) ** 0.5, math.sqrt(1 - c * c)
                tone = rng.uniform(0.5, 1.1) * (0.5 + 0.5 * d)
                color = [x * tone for x in ((0.14, 0.25, 0.07), (0.19, 0.27, 0.06), (0.12, 0.22, 0.09))[k]]
                with r.block(f"Translate {0.6 * d * s * math.cos(a):.3f} {0.75 * d * c + 0.1:.3f} {0.6 * d * s * math.sin(a):.3f}",
                             f"Rotate {90 - math.degrees(a):.1f} 0 1 0", f"Rotate {rng.uniform(20, 100):.1f} 1 0 0"):
                    card(r, rng.uniform(0.16, 0.24), rng.uniform(0.2, 0.32), -0.08, color, [x * 1.25 for x in color])


def scatter(r, rng, kind, count, near, far, size, sway, reach):
    """Instances over the ground between two distances from the camera, denser near it; one in three sways."""
    placed = tries = 0
    while placed < count and tries < 20 * count:
        tries += 1
        d = near * (far / near) ** (rng.random() ** 0.85)
        a = math.radians(rng.uniform(-36, 40))
        x, z = EYE[0] + d * math.sin(a), EYE[2] + d * math.cos(a)
        patchy = fractal(x / 3 + 20, z / 3 + 30, 2, hash_of(kind))
        if patchy < 0.4 + 0.2 * rng.random() - (0.2 if kind == "grass" else 0) or not clear_of(x, z, reach):
            continue
        h = rng.uniform(*size)
        lines = (f"Translate {x:.3f} {ground(x, z) - 0.02:.3f} {z:.3f}", f"Rotate {rng.uniform(0, 360):.0f} 0 1 0",
                 f"Scale {h:.2f} {h * rng.uniform(.8, 1.2):.2f} {h:.2f}")
        if sway and placed % 3 == 0:
            with r.block(lines[0], "MotionBegin [0 1]", f"Rotate {rng.uniform(-2, 2):.2f} 0 0 1",
                         f"Rotate {rng.uniform(1, 2) * sway:.2f} 0 0 -1", "MotionEnd", *lines[1:]):
                r(f'ObjectInstance "{kind}{rng.randrange(3)}"')
        else:
            with r.block(*lines):
                r(f'ObjectInstance "{kind}{rng.randrange(3)}"')
        placed += 1


def hash_of(kind):
    return sum(map(ord, kind))


def tree(r, rng, x, z, height, twigs):
    with r.block(f"Translate {x} {ground(x, z) - 0.1:.3f} {z}"):
        top = (0.25, height * 0.48, 0.1)
        ends = []
        with r.block():
            weathered(r, "bark", 0.05, paintcolor=(1, 1, 1))
            r.tube([(0, 0, 0), (0.08, height * 0.16, -0.06), (-0.02, height * 0.33, 0.05), top], [0.42, 0.27, 0.23, 0.17], 12, (1, 2))
            for k in range(9):
                a, lift = k * 2.4 + rng.uniform(-.3, .3), rng.uniform(0.7, 1.02)
                end = (math.cos(a) * rng.uniform(0.9, 1.9), height * lift, math.sin(a) * rng.uniform(0.9, 1.9))
                start = [t * (0.62 + 0.04 * k) for t in top] if k % 2 else list(top)
                middle = [(p + q) / 2 + rng.uniform(-.2, .2) for p, q in zip(start, end)]
                r.tube([start, middle, end], [0.11, 0.07, 0.03], 8, (0.5, 1.5))
                ends.append(end)
        for k in range(twigs):
            a, c = rng.uniform(0, 2 * math.pi), rng.uniform(-0.6, 1)
            s, d = math.sqrt(1 - c * c), rng.uniform(0.3, 1) ** 0.45
            at = (top[0] + 2.3 * d * s * math.cos(a), height * 0.86 + height * 0.27 * d * c, top[2] + 2.3 * d * s * math.sin(a))
            with r.block(f"Translate {fmt(at)}", "MotionBegin [0 1]", f"Rotate {rng.uniform(-1, 1):.2f} 1 0 0",
                         f"Rotate {rng.uniform(2, 5):.2f} 1 0 .3", "MotionEnd", f"Rotate {-math.degrees(a):.1f} 0 1 0",
                         f"Rotate {-math.degrees(math.acos(c)) * .85:.1f} 0 0 1", f"Rotate {rng.uniform(0, 360):.1f} 0 1 0"):
                r(f'ObjectInstance "twig{rng.randrange(3)}"')


def wind_pump(r, x, z):
    high = 8.5
    with r.block(f"Translate {x} {ground(x, z):.3f} {z}"):
        weathered(r, "iron", 0.01, solid=8, rust=0.6, wear=0.6)
        for sx, sz in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            r.tube([(sx * 1.1, -0.3, sz * 1.1), (sx * 0.12, high, sz * 0.12)], [0.05, 0.035], 8)
        for k in range(1, 6):
            f, g = k / 6, (k + 1) / 6
            a, b = 1.1 - 0.98 * f, 1.1 - 0.98 * g
            for sx, sz, tx, tz in ((-1, -1, 1, -1), (1, -1, 1, 1), (1, 1, -1, 1), (-1, 1, -1, -1)):
                r.tube([(sx * a, high * f, sz * a), (tx * a, high * f, tz * a)], [0.025, 0.025], 6)
                r.tube([(sx * a, high * f, sz * a), (tx * b, high * g, tz * b)], [0.015, 0.015], 6)
        with r.block(f"Translate 0 {high + 0.2} 0", "Rotate 25 0 1 0"):
            r.tube([(0, 0, -0.5), (0, 0, 1.7)], [0.05, 0.03], 8)
            r.sheet((0, 0.5, 1.2), (0, 0.75, 2.3), (0, -0.75, 2.3), (0, -0.5, 1.2))
            with r.block("Translate 0 0 -0.5"), r.moving("Rotate 0 0 0 1", "Rotate 22 0 0 1", "Rotate 44 0 0 1"):
                weathered(r, "iron", 0.008, paintcolor=(0.62, 0.62, 0.6), rust=0.5, wear=0.7)
                for k in range(14):
                    with r.block(f"Rotate {k * 360 / 14:.2f} 0 0 1"):
                        r.sheet((-0.06, 0.55, 0.04), (0.06, 0.55, -0.04), (0.26, 1.6, -0.14), (-0.26, 1.6, 0.14))
                with r.block():
                    r("Torus 1.15 0.02 0 360 360")


def low_wall(r):
    """Dry stones along the yard, of subdivision surfaces one by one."""
    rng = random.Random(12)
    for k in range(52):
        f = k / 52
        for row in range(3):
            x, z = 4.4 + 5.2 * f + 0.05 * (row % 2), -1.6 + 4.6 * f
            with r.block(f"Translate {x:.3f} {ground(x, z) + 0.09 + row * 0.17:.3f} {z:.3f}", f"Rotate {-41 + rng.uniform(-8, 8):.1f} 0 1 0"):
                weathered(r, "stones", 0.09, (0.25, 0.2), solid=4, paintcolor=[rng.uniform(0.75, 1)] * 3)
                w, h, d = rng.uniform(0.12, 0.2), rng.uniform(0.085, 0.11), rng.uniform(0.15, 0.2)
                r.cushion(-w, w, -h, h, -d, d, 0.05)


def main():
    args = arguments(__doc__, 11)
    textures(args.folder, args.seed)
    rng = random.Random(args.seed)
    r = Stage("exterior")
    r.make_textures(args.folder)
    r.film(38, EYE, AT, (0.05, 0.01, 0.12), 2, 2)
    r.light("distantlight", '"float intensity" [2.3] "color lightcolor" [1 .84 .62] "point from" [-5 5.6 -9] '
            '"point to" [0 0 0] "float angle" [.53]')
    r("TransformBegin", "Rotate -90 1 0 0")
    r.light("envlight", '"float intensity" [.6] "string texturename" ["sky.hdr"]')
    r("TransformEnd")
    plants(r, rng)
    terrain(r)
    house(r)
    low_wall(r)
    wind_pump(r, -6.5, 26)
    count = lambda n: max(1, round(n * args.density))
    tree(r, rng, -5.3, 0.2, 6.4, count(1300))
    scatter(r, rng, "grass", count(8000), 3.2, 45, (0.6, 1.3), 4, 0)
    scatter(r, rng, "weed", count(1400), 3.5, 30, (0.6, 1.5), 4, 0.1)
    scatter(r, rng, "flower", count(700), 4, 22, (0.8, 1.4), 6, 0.1)
    scatter(r, rng, "bush", count(60), 12, 34, (0.7, 1.5), 0, 1.0)
    scatter(r, rng, "bush", count(260), 40, 130, (2.5, 6), 0, 0)
    r("WorldEnd")
    r.save(args.folder)


main()
