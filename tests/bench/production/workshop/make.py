#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A collector's table with 20 lights: hundreds of small things, urchins, shells, cones, corals, stones, knots, gears, carved
boxes, pots, each displaced far and finely and with textures, so that a film frame has micropolygons by the million; between
them glass, brass and copper. A top spins, a pendulum swings, a marble rolls and the camera moves."""
import math
import os
import random
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import synthesis  # noqa: E402
from stage import Stage, arguments, fmt  # noqa: E402
from synthesis import (blend, cells, contrast, coordinates, fbm, save_color, save_data, save_mottled, save_weave,  # noqa: E402
                       save_wood, shade)

EYE, AT = (0.35, 1.42, -1.55), (-0.02, 0.9, 0.2)
TOP = 0.75  # height of the table


def textures(folder, seed):
    size = synthesis.SIZE
    save_wood(folder, "bench", seed, (0.5, 0.32, 0.18), (0.22, 0.12, 0.07), planks=5)
    save_mottled(folder, "clay", seed + 1, (0.95, 0.93, 0.9), (0.62, 0.58, 0.54), 5)
    save_weave(folder, "knit", seed + 2, ((0.9, 0.85, 0.75), (0.75, 0.7, 0.62), (0.95, 0.9, 0.84)), 32)
    s, t = coordinates(size)
    grain, fine = fbm(size, 12, 6, seed + 3), fbm(size, 64, 4, seed + 4)
    # Spines of an urchin, in rows that meet at the poles.
    u, v = (s * 20) % 1 - 0.5, (t * 16 + 0.5 * (np.floor(s * 20) % 2)) % 1 - 0.5
    spine = np.clip(1 - np.hypot(u, v) / 0.42, 0, 1) ** 1.4
    save_color(folder, "urchin.png", blend((0.85, 0.7, 0.75), (0.45, 0.16, 0.3), spine) * (0.7 + 0.5 * grain)[..., None])
    save_data(folder, "urchin_height.png", 0.88 * spine + 0.12 * fine)
    # Scales of a cone, each over the next row.
    row = np.floor(t * 14)
    u, v = (s * 13 + 0.5 * (row % 2)) % 1 - 0.5, t * 14 - row
    scale = np.clip(1 - (2 * np.abs(u)) ** 2.2, 0, 1) * v
    save_color(folder, "cone.png", blend((0.16, 0.09, 0.05), (0.62, 0.42, 0.25), contrast(scale, 0.1, 0.9)) * (0.65 + 0.6 * grain)[..., None])
    save_data(folder, "cone_height.png", 0.9 * scale + 0.1 * fine)
    rib = 0.5 + 0.5 * np.cos(2 * np.pi * 26 * t)  # ribs across a shell, and its bands
    save_color(folder, "shell.png", blend((0.92, 0.86, 0.76), (0.62, 0.34, 0.2), contrast(fbm(size, (4, 20), 5, seed + 5), 0.42, 0.6)))
    save_data(folder, "shell_height.png", 0.7 * rib * (0.7 + 0.3 * np.cos(2 * np.pi * 10 * s)) + 0.3 * fine)
    first, second, own = cells(size, 18, 18, seed + 6)
    save_color(folder, "coral.png", blend((0.6, 0.16, 0.1), (0.95, 0.62, 0.45), contrast(first, 0.2, 0.6)) * (0.75 + 0.4 * grain)[..., None])
    save_data(folder, "coral_height.png", contrast(first, 0.1, 0.6) * 0.8 + 0.2 * fine)
    first, second, own = cells(size, 30, 30, seed + 7)
    save_color(folder, "hammered.png", shade((1, 1, 1), 0.75 + 0.25 * own))
    save_data(folder, "hammered_height.png", np.clip(first, 0, 1) ** 2 * 0.9 + 0.1 * fine)
    first, second, own = cells(size, 9, 9, seed + 8)
    crack = contrast(second - first, 0.01, 0.14)
    save_color(folder, "stone.png", blend((0.2, 0.19, 0.18), shade((0.62, 0.6, 0.57), 0.55 + 0.6 * own), crack) * (0.65 + 0.6 * fine)[..., None])
    save_data(folder, "stone_height.png", 0.5 * crack + 0.35 * grain + 0.15 * fine)
    star = np.cos(8 * np.arctan2(t * 4 % 1 - 0.5, s * 4 % 1 - 0.5))  # carving
    far = np.hypot(t * 4 % 1 - 0.5, s * 4 % 1 - 0.5)
    cut = contrast(np.abs(far - 0.32 - 0.07 * star), 0.02, 0.06) * contrast(far, 0.06, 0.1)
    save_color(folder, "carved.png", blend((0.14, 0.07, 0.04), (0.56, 0.34, 0.18), cut * (0.6 + 0.4 * fbm(size, (4, 48), 4, seed + 9))))
    save_data(folder, "carved_height.png", 0.85 * cut + 0.15 * fine)
    knot = np.cos(2 * np.pi * (6 * s + 4 * t))  # strands around a rope
    save_color(folder, "rope.png", shade((0.72, 0.58, 0.38), 0.5 + 0.3 * knot + 0.3 * fine))
    save_data(folder, "rope_height.png", 0.5 + 0.35 * knot + 0.15 * fine)


class Table(Stage):
    def __init__(self, seed):
        super().__init__("workshop")
        self.rng = random.Random(seed)

    def made_of(self, name, height, repeat=None, solid=0, **values):
        """The production shader, displaced `height` metres by the texture's heights, or by dents in space."""
        rng = self.rng
        given = dict(paintcolor=(0.95, 0.95, 0.95), paintmap=name + ".tx", wear=0, rust=0.1, scratches=rng.uniform(0, 0.2),
                     gloss=rng.uniform(0.2, 0.8), roughness=rng.uniform(0.15, 0.5), dirt=rng.uniform(0, 0.15),
                     dust=rng.uniform(0, 0.1), streaks=0.05, frequency=rng.uniform(8, 20))
        given.update(values)
        self.production(**given)
        if solid:
            self.dents(height, solid)
        else:
            self.displace(name + "_height.tx", height, 0)
        if repeat:
            self.repeat(*repeat)


def urchin(r, size):
    r.made_of("urchin", 0.4 * size, paintcolor=[r.rng.uniform(0.4, 1) for _ in range(3)])
    r("Scale 1 .75 1")
    r.ball(0.62 * size, (1, 1))


def cone(r, size):
    r.made_of("cone", 0.17 * size, (1, 1))
    r(f"Rotate {r.rng.uniform(70, 100):.0f} 1 0 0")
    r.nurbs_lathe([(0.001, -0.95 * size), (0.3 * size, -0.9 * size), (0.62 * size, -0.5 * size), (0.5 * size, 0.2 * size),
                   (0.2 * size, 0.8 * size), (0.001, 0.95 * size)])


def shell(r, size):
    """A tube that grows along a spiral."""
    path, radii = [], []
    for k in range(44):
        f = k / 43
        a, g = 2 * math.pi * 2.6 * f, 0.09 + 0.91 * f ** 1.8
        path.append((0.62 * size * g * math.cos(a), size * (0.7 * (1 - g) + 0.02), 0.62 * size * g * math.sin(a)))
        radii.append(0.4 * size * g)
    r.made_of("shell", 0.05 * size, paintcolor=[r.rng.uniform(0.75, 1) for _ in range(3)])
    r("Sides 2")
    r.tube(path, radii, 12, (0.5, 1))


def coral(r, size):
    rng = r.rng
    r.made_of("coral", 0.07 * size, paintcolor=[rng.uniform(0.5, 1), rng.uniform(0.4, 0.9), rng.uniform(0.4, 0.9)])
    for k in range(7):
        a, out = 2.4 * k, rng.uniform(0.25, 0.7) * size
        tip = (out * math.cos(a), rng.uniform(0.6, 1.3) * size, out * math.sin(a))
        r.tube([(0, -0.3 * size, 0), (tip[0] * 0.35, tip[1] * 0.45, tip[2] * 0.35), tip], [0.2 * size, 0.15 * size, 0.11 * size], 8, (0.5, 1))


def stone(r, size):
    r.made_of("stone", 0.16 * size, paintcolor=[r.rng.uniform(0.6, 1)] * 3)
    r(f"Scale {r.rng.uniform(.8, 1.2):.2f} {r.rng.uniform(.55, .85):.2f} {r.rng.uniform(.8, 1.2):.2f}")
    r.ball(0.8 * size, (2, 1))


def knot(r, size):
    """A trefoil of rope."""
    path = [(0.3 * size * (math.sin(a) + 2 * math.sin(2 * a)), 0.22 * size * math.sin(3 * a) + 0.1 * size,
             0.3 * size * (math.cos(a) - 2 * math.cos(2 * a))) for a in (2 * math.pi * k / 48 for k in range(49))]
    r.made_of("rope", 0.05 * size, paintcolor=[r.rng.uniform(0.5, 1) for _ in range(3)])
    r.tube(path, [0.17 * size] * len(path), 12, (1, 10))


def gear(r, size):
    teeth, rng = r.rng.randrange(12, 22), r.rng
    ring = [(1 if k % 4 in (1, 2) else 0.84, 2 * math.pi * (k + 0.0) / (4 * teeth)) for k in range(4 * teeth)]
    n, h = len(ring), 0.13 * size
    rows = [(0.3, -h), (0.95, -h), (1, -0.8 * h), (1, 0.8 * h), (0.95, h), (0.3, h), (0.28, 0.8 * h), (0.28, -0.8 * h)]
    points = [(size * (f if f < 0.5 else f * g) * math.cos(a), y, size * (f if f < 0.5 else f * g) * math.sin(a))
              for f, y in rows for g, a in ring]
    m = len(rows)
    r.made_of("hammered", 0.02 * size, solid=4 / size, wear=rng.uniform(0.6, 1), rust=rng.uniform(0.1, 0.7),
              metalcolor=rng.choice(((0.86, 0.66, 0.32), (0.6, 0.6, 0.62), (0.85, 0.5, 0.35))))
    r.mesh(points, [(j * n + i, (j + 1) % m * n + i, (j + 1) % m * n + (i + 1) % n, j * n + (i + 1) % n)
                    for j in range(m) for i in range(n)])


def box(r, size):
    rng = r.rng
    r.made_of("carved", 0.035 * size, paintcolor=[rng.uniform(0.7, 1) for _ in range(3)])
    w, h, d = (rng.uniform(*v) * size for v in ((0.8, 1.2), (0.45, 0.7), (0.6, 0.9)))
    for a, b, e in (((-w, 2 * h, -d), (w, 2 * h, -d), (-w, 0, -d)), ((w, 2 * h, -d), (w, 2 * h, d), (w, 0, -d)),
                    ((w, 2 * h, d), (-w, 2 * h, d), (w, 0, d)), ((-w, 2 * h, d), (-w, 2 * h, -d), (-w, 0, d)),
                    ((-w, 2 * h, d), (w, 2 * h, d), (-w, 2 * h, -d))):
        c = [y + z - x for x, y, z in zip(a, b, e)]
        r.sheet(a, b, c, e, (0.5, 0.5))
    for x in (-w, w):
        for z in (-d, d):
            r.tube([(x, -0.04 * size, z), (x, 2.05 * h, z)], [0.09 * size, 0.09 * size], 8, (0.3, 0.5))


def pot(r, size):
    rng = r.rng
    a, b, c = (rng.uniform(*v) * size for v in ((0.35, 0.6), (0.6, 0.95), (0.3, 0.5)))
    if rng.random() < 0.5:
        r.made_of("hammered", 0.05 * size, (2, 1), wear=1, rust=0.02, dirt=0.05, metalcolor=rng.choice(((0.95, 0.58, 0.42), (0.9, 0.72, 0.36))))
    else:
        r.made_of(rng.choice(("clay", "shell")), 0.07 * size, (2, 1), paintcolor=[rng.uniform(0.2, 0.95) for _ in range(3)], gloss=1, roughness=0.06)
    r.nurbs_lathe([(0.001, 0), (a, 0), (b, 0.5 * size), (b, 0.9 * size), (c, 1.25 * size), (c * 1.25, 1.5 * size),
                   (c * 1.1, 1.5 * size), (c * 0.85, 1.25 * size), (0.001, 0.9 * size)])


SMALL = (urchin, cone, shell, coral, stone, knot, gear, box, pot)


def clear(r, kind, size):
    """Glass: a ball, a bottle, a bowl; or polished metal."""
    rng = r.rng
    if kind == "metal":
        r(f'Surface "conductor" "color reflectance" [{fmt(rng.choice(((0.95, 0.64, 0.54), (0.98, 0.8, 0.4), (0.92, 0.92, 0.9))))}] '
          f'"float alpha" [{rng.choice((0.03, 0.12, 0.25))}]')
        r.nurbs_lathe([(0.001, 0), (0.5 * size, 0), (0.75 * size, 0.4 * size), (0.6 * size, 1.1 * size), (0.25 * size, 1.3 * size),
                       (0.001, 1.35 * size)])
        return
    tint = rng.choice(((1, 1, 1), (0.8, 0.95, 0.9), (0.95, 0.8, 0.55), (0.65, 0.85, 1)))
    r(f'Surface "dielectric" "float ior" [1.5] "color transmittance" [{fmt(tint)}]')
    if kind == "ball":
        r(f"Translate 0 {size} 0", f"Sphere {size} {-size} {size} 360")
    else:
        w, neck, high = (0.6, 0.2, 2.4) if kind == "bottle" else (0.9, 0.85, 0.8)
        r.nurbs_lathe([(x * size, y * size) for x, y in ((0.001, 0), (w, 0), (w, 0.1), (w, 0.55 * high), (neck, 0.75 * high), (neck, high),
                                                         (neck - 0.06, high), (neck - 0.06, 0.75 * high), (w - 0.08, 0.55 * high),
                                                         (w - 0.08, 0.12), (0.001, 0.12))])


def lights(r):
    for place, at, w, h, radiance in (((-1.9, 2.3, -0.9), (0, TOP, 0.1), 0.8, 0.6, (22, 18.5, 14)), ((1.9, 2.0, 0.7), (0, TOP, 0), 0.5, 0.8, (9, 12, 16)),
                                      ((0.1, 2.6, 1.2), (0, TOP, 0.2), 1.2, 0.3, (10, 9, 7.6)), ((0.8, 2.5, -1.9), (0, TOP, 0), 0.6, 0.4, (7, 6.6, 6))):
        r.soft_box(place, at, w, h, radiance)
    for k in range(10):  # bulbs on a string, before the wall
        f = k / 9
        r.bulb((-1.35 + 2.7 * f, 1.68 - 0.5 * math.sin(math.pi * (3 * f % 1)) * 0.5, 1.02), 0.022, ((60, 34, 14), (60, 44, 24))[k % 2])
    warm = (1, 0.82, 0.6)
    for place, at, power in (((-0.9, 2.1, -0.7), (-0.55, TOP, 0.1), 2.6), ((0.9, 2.1, -0.6), (0.5, TOP, 0.15), 2.4), ((0, 2.2, -0.5), (0, TOP, 0.3), 2.4),
                             ((-0.6, 1.9, 0.9), (-0.3, 1.1, 0.75), 1.2), ((0.7, 1.9, 0.9), (0.4, 1.1, 0.75), 1.2), ((0.2, 2.3, 0.2), (0.1, TOP, -0.35), 2.4)):
        r.spot(place, at, power, warm, 0.35)


def room(r):
    with r.block():  # the table
        r.made_of("bench", 0.008, gloss=0.6, roughness=0.25, scratches=0.5, frequency=5)
        for k in range(4):
            z = -0.62 + 0.31 * k
            r.sheet((-1.25, TOP, z + 0.305), (1.25, TOP, z + 0.305), (1.25, TOP, z), (-1.25, TOP, z), (1.6, 0.2))
        r.sheet((-1.25, TOP, -0.62), (1.25, TOP, -0.62), (1.25, TOP - 0.06, -0.62), (-1.25, TOP - 0.06, -0.62), (1.6, 0.05))
    with r.block():
        r.made_of("stone", 0.03, frequency=2, paintcolor=(0.62, 0.5, 0.42), gloss=0.1)
        r.sheet((-3, 3, 1.15), (3, 3, 1.15), (3, -0.5, 1.15), (-3, -0.5, 1.15), (4, 2.4))
        r.sheet((-3, 3, -3), (-3, 3, 1.15), (-3, -0.5, 1.15), (-3, -0.5, -3), (3, 2.4))
        r.sheet((3, 3, 1.15), (3, 3, -3), (3, -0.5, -3), (3, -0.5, 1.15), (3, 2.4))
        r.sheet((3, 3, -3), (-3, 3, -3), (-3, -0.5, -3), (3, -0.5, -3), (4, 2.4))
    with r.block():
        r.made_of("clay", 0.01, frequency=1)
        r.sheet((-3, 3, -3), (3, 3, -3), (3, 3, 1.15), (-3, 3, 1.15), (4, 3))
        r.made_of("bench", 0.01, frequency=1)
        r.sheet((-3, -0.0, 1.15), (3, 0, 1.15), (3, 0, -3), (-3, 0, -3), (4, 3))
    with r.block():  # shelves at the wall
        r.made_of("bench", 0.01, solid=4, frequency=4)
        for y in (1.12, 1.46):
            r.cushion(-1.4, 1.4, y - 0.03, y, 0.84, 1.15, 0.01)
    with r.block():  # a knitted cloth, thrown on the table
        r.made_of("knit", 0.008, paintcolor=(0.32, 0.42, 0.55), gloss=0.05)
        r("Sides 2")

        def cloth(u, v):
            x, z = -0.95 + 0.75 * u, 0.32 - 0.9 * v
            fall = max(0, -0.6 - z)
            wave = 0.012 * math.sin(9 * u + 4 * v) + 0.01 * math.sin(14 * v - 5 * u)
            return x, TOP + 0.02 + wave - 0.9 * fall, max(z, -0.64) - 0.03 * math.sin(9 * u) * min(1, 8 * fall)
        r.grid(16, 20, lambda u, v: cloth(u, 1 - v), (2.4, 2.9))
    with r.block():  # the string of the bulbs
        r.made_of("rope", 0.002, solid=40)
        r.tube([(-1.5 + 3 * k / 40, 1.7 - 0.25 * math.sin(math.pi * (3 * (-0.05 + 1.1 * k / 40) % 1)), 1.03) for k in range(41)], [0.006] * 41, 6)


def pile(r, density):
    """Things on the table, not one in another, larger ones behind; then on the shelves."""
    rng, placed = r.rng, [(-0.18, -0.02, 0.16), (0.42, -0.33, 0.1), (0.62, 0.2, 0.14)]  # room for what moves
    wanted = round(170 * density) + len(placed)
    shrink = min(1, density ** -0.5)
    for k in range(60 * wanted):
        if len(placed) >= wanted:
            break
        z = rng.uniform(-0.54, 0.62)
        x = rng.uniform(-1.12, 1.12)
        size = shrink * rng.uniform(0.042, 0.085) * (1 + 0.4 * max(0, z))
        if any((x - a) ** 2 + (z - b) ** 2 < (1.15 * (size + c)) ** 2 for a, b, c in placed):
            continue
        placed.append((x, z, size))
        kind = rng.random()
        with r.block(f"Translate {x:.4f} {TOP} {z:.4f}", f"Rotate {rng.uniform(0, 360):.0f} 0 1 0"):
            if kind < 0.1:
                clear(r, rng.choice(("ball", "bottle", "bowl")), size)
            elif kind < 0.17:
                clear(r, "metal", size)
            else:
                thing = SMALL[len(placed) % len(SMALL)]
                lift = {urchin: 0.5, cone: 0.58, coral: 0.2, stone: 0.5, knot: 0.25, gear: 0.15, shell: 0.38}.get(thing, 0)
                with r.block(f"Translate 0 {lift * size:.4f} 0"):
                    thing(r, size)
    for y in (1.12, 1.46):
        x = -1.3
        while x < 1.3:
            size = rng.uniform(0.04, 0.065)
            with r.block(f"Translate {x + size:.4f} {y} {rng.uniform(.92, 1.0):.3f}", f"Rotate {rng.uniform(0, 360):.0f} 0 1 0"):
                kind = rng.random()
                if kind < 0.2:
                    clear(r, "bottle", size)
                else:
                    thing = rng.choice((pot, box, stone, coral, urchin, pot))
                    with r.block(f"Translate 0 {dict([(urchin, .5), (stone, .5), (coral, .3)]).get(thing, 0) * size:.4f} 0"):
                        thing(r, size)
            x += 2.5 * size


def moving_things(r):
    with r.block(f"Translate -.18 {TOP} -.02", "Rotate 12 0 0 1"), r.moving(*(f"Rotate {50 * k} 0 1 0" for k in range(5))):
        r.made_of("carved", 0.006, (3, 1), gloss=0.9, roughness=0.1)  # a top
        r.nurbs_lathe([(0.001, 0), (0.012, 0.01), (0.03, 0.06), (0.12, 0.1), (0.13, 0.13), (0.05, 0.15), (0.012, 0.18), (0.012, 0.25), (0.001, 0.26)])
    with r.moving(f"Translate .36 {TOP} -.33", f"Translate .43 {TOP} -.33"):
        r('Surface "dielectric" "float ior" [1.5] "color transmittance" [.6 .9 .75]', "Translate 0 .045 0", "Sphere .045 -.045 .045 360")
    with r.block(f"Translate .62 {TOP} .2"):  # a pendulum in its frame
        with r.block():
            r('Surface "conductor" "color reflectance" [.98 .8 .4] "float alpha" [.08]')
            r.nurbs_lathe([(0.001, 0), (0.12, 0), (0.12, 0.02), (0.02, 0.03), (0.001, 0.03)])
            r.tube([(-0.1, 0.01, 0), (-0.1, 0.4, 0), (0, 0.43, 0), (0.1, 0.4, 0), (0.1, 0.01, 0)], [0.008] * 5, 8)
        with r.block("Translate 0 .42 0"), r.moving("Rotate -14 1 0 0", "Rotate -5 1 0 0", "Rotate 6 1 0 0"):
            r.made_of("hammered", 0.004, wear=1, rust=0.02, metalcolor=(0.95, 0.58, 0.42))
            r.tube([(0, 0, 0), (0, -0.3, 0)], [0.003, 0.003], 6)
            r("Translate 0 -.32 0")
            r.ball(0.04, (2, 1))


def main():
    args = arguments(__doc__, 8)
    textures(args.folder, args.seed)
    r = Table(args.seed)
    r.make_textures(args.folder)
    r.film(36, EYE, AT, (0.006, 0.002, 0.008), 2, 5)
    lights(r)
    room(r)
    r("ShadingRate 0.25")
    pile(r, args.density)
    moving_things(r)
    r("WorldEnd")
    r.save(args.folder)


main()
