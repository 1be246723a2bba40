#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A study at nightfall with 20 lights: two windows, a skylight, a panel over the desk, six bulbs, ten spots. Hundreds of things,
no two alike: books, vases, furniture, curtains, a rug with its tufts, of subdivision surfaces, NURBS, patches and curves; each
has the production shader with colours, textures and displacement of its own. A fan, a pendulum, a globe and the camera move."""
import math
import os
import random
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import synthesis  # noqa: E402
from stage import Stage, arguments, fmt  # noqa: E402
from synthesis import (blend, contrast, coordinates, fbm, save_color, save_data, save_mottled, save_weave, save_wood,  # noqa: E402
                       shade)

W, H, D = 3.4, 3.1, 7.0  # half the width, height and depth of the room
EYE, AT = (0.9, 1.55, 0.15), (0.05, 1.12, 5.0)
LEATHERS = ((0.5, 0.1, 0.07), (0.1, 0.24, 0.14), (0.08, 0.14, 0.32), (0.48, 0.32, 0.16), (0.3, 0.12, 0.2), (0.62, 0.5, 0.3),
            (0.16, 0.1, 0.07), (0.12, 0.3, 0.33), (0.72, 0.66, 0.54))
BRASS = dict(metalcolor=(0.86, 0.66, 0.32), wear=0.95, rust=0.05, dirt=0.15, dust=0.05)
SHELVES = (0.12, 0.52, 0.92, 1.32, 1.72, 2.12)  # heights of the bookcases' boards
CASES = (1.9, 3.75, 5.6)  # middles of the bookcases along z, at the wall on the left


def textures(folder, seed):
    size = synthesis.SIZE
    save_wood(folder, "oak", seed, (0.62, 0.42, 0.24), (0.3, 0.17, 0.09), planks=8)
    save_wood(folder, "walnut", seed + 1, (0.42, 0.25, 0.14), (0.17, 0.09, 0.05), planks=3)
    save_mottled(folder, "plaster", seed + 2, (0.86, 0.83, 0.76), (0.74, 0.7, 0.62), 5)
    save_mottled(folder, "glaze", seed + 3, (0.95, 0.95, 0.95), (0.7, 0.7, 0.72), 3)
    save_weave(folder, "cloth", seed + 4, ((0.9, 0.86, 0.78), (0.82, 0.78, 0.68)), 64)
    save_weave(folder, "tweed", seed + 5, ((0.8, 0.76, 0.7), (0.55, 0.5, 0.45), (0.95, 0.9, 0.84)), 40)
    s, t = coordinates(size)
    grain, pores = fbm(size, 24, 5, seed + 6), fbm(size, 96, 3, seed + 7)
    save_color(folder, "leather.png", shade((1, 1, 1), 0.55 + 0.35 * grain + 0.3 * pores))
    save_data(folder, "leather_height.png", 0.6 * contrast(pores, 0.2, 0.6) + 0.4 * grain)
    lines = contrast(np.abs(np.sin(np.pi * 40 * t)), 0.0, 0.5)  # leaves of a book, seen from the side
    save_color(folder, "pages.png", shade((0.9, 0.86, 0.74), (0.75 + 0.25 * lines) * (0.85 + 0.2 * grain)))
    save_data(folder, "pages_height.png", lines)
    # A rug: medallions within borders.
    x, y = np.abs(2 * s - 1), np.abs(2 * t - 1)
    rim = np.maximum(x, y)
    ripple = 0.5 + 0.5 * np.cos(18 * np.hypot(x, y) + 3 * np.cos(8 * np.arctan2(y, x + 1e-6)))
    field = blend((0.45, 0.06, 0.06), (0.75, 0.58, 0.3), contrast(ripple, 0.62, 0.72))
    field = blend(field, (0.08, 0.12, 0.28), contrast(np.hypot(x, y), 0.28, 0.27) * contrast(np.hypot(x, y), 0.1, 0.12))
    band = 0.5 + 0.5 * np.sin(np.pi * 26 * np.where(x > y, t, s))
    field = blend(field, blend((0.08, 0.12, 0.28), (0.75, 0.58, 0.3), contrast(band, 0.55, 0.75)), contrast(rim, 0.78, 0.785))
    field = blend(field, (0.3, 0.04, 0.05), contrast(rim, 0.94, 0.945))
    save_color(folder, "rug.png", field * (0.7 + 0.45 * pores)[..., None])
    save_data(folder, "rug_height.png", 0.5 * pores + 0.5 * fbm(size, 64, 3, seed + 8))
    damask = 0.5 + 0.5 * np.cos(2 * np.pi * (6 * s + 0.35 * np.sin(2 * np.pi * 4 * t))) * np.cos(2 * np.pi * 4 * t)
    save_color(folder, "paper.png", blend((0.2, 0.32, 0.3), (0.3, 0.43, 0.38), contrast(damask, 0.45, 0.6)) * (0.9 + 0.2 * grain)[..., None])
    save_data(folder, "paper_height.png", 0.7 * contrast(damask, 0.4, 0.65) + 0.3 * pores)
    for k in range(4):
        painting(folder, f"picture{k}", seed + 20 + 5 * k, k)
    land = fbm(size, 3, 7, seed + 40)
    sea = blend((0.08, 0.2, 0.34), (0.12, 0.32, 0.42), contrast(land, 0.3, 0.5))
    save_color(folder, "map.png", blend(sea, blend((0.5, 0.44, 0.2), (0.3, 0.24, 0.14), contrast(land, 0.58, 0.75)), contrast(land, 0.5, 0.515)))
    save_data(folder, "map_height.png", contrast(land, 0.49, 0.8))


def painting(folder, name, seed, kind):
    size = 512
    s, t = coordinates(size)
    stroke = fbm(size, (10, 40), 5, seed)
    warped = np.clip(t + 0.16 * (fbm(size, 4, 6, seed + 1) - 0.5) * 2, 0, 1)
    above, middle, below = (((0.32, 0.5, 0.72), (0.95, 0.72, 0.42), (0.14, 0.2, 0.1)), ((0.12, 0.14, 0.3), (0.7, 0.3, 0.2), (0.05, 0.05, 0.1)),
                            ((0.72, 0.76, 0.74), (0.5, 0.62, 0.62), (0.2, 0.33, 0.36)), ((0.6, 0.62, 0.5), (0.8, 0.7, 0.3), (0.36, 0.28, 0.1)))[kind]
    picture = blend(blend(above, middle, contrast(warped, 0.1, 0.5)), below, contrast(warped, 0.55, 0.6))
    spots = contrast(fbm(size, 14, 4, seed + 2), 0.6, 0.68) * contrast(t, 0.5, 0.8)
    picture = blend(picture, middle, spots) * (0.75 + 0.5 * stroke)[..., None]
    save_color(folder, name + ".png", picture)
    save_data(folder, name + "_height.png", stroke)


class Study(Stage):
    def __init__(self, seed):
        super().__init__("interior")
        self.rng = random.Random(seed)

    def made_of(self, name, height=0.004, solid=0, repeat=None, map_name=None, **values):
        """The production shader with its own seed of wear; displaced by the texture's heights, or by dents in space where s
        and t jump from face to face."""
        rng = self.rng
        given = dict(paintcolor=(0.9, 0.9, 0.9), paintmap=(map_name or name) + ".tx", wear=rng.uniform(0, 0.12), rust=0.1,
                     scratches=rng.uniform(0.05, 0.3), gloss=rng.uniform(0.3, 0.8), roughness=rng.uniform(0.2, 0.5),
                     dirt=rng.uniform(0.02, 0.15), dust=rng.uniform(0, 0.12), streaks=0.1, frequency=rng.uniform(1.5, 4))
        given.update(values)
        self.production(**given)
        if solid:
            self.dents(height, solid)
        else:
            self.displace(name + "_height.tx", height)
        if repeat:
            self.repeat(*repeat)


def lights(r):
    for z in (2.3, 4.7):  # windows on the right, in the evening
        x = W + 0.18
        r.lights += 1
        corners = (x, 2.5, z - 0.6, x, 0.95, z - 0.6, x, 0.95, z + 0.6, x, 2.5, z + 0.6)
        r("AttributeBegin", 'Surface "matte" "float Kd" [0] "float Ka" [0]',
          f'AreaLightSource "arealight" "l{r.lights}" "float intensity" [1] "color lightcolor" [6 8 12]',
          f'Polygon "P" [{fmt(corners)}]', "AttributeEnd",
          f'Illuminate "l{r.lights}" 1')
    r.panel(-0.5, 0.7, H + 0.1, 3.0, 4.2, (5, 6.2, 8))  # a skylight
    r.panel(-0.65, 0.15, 2.02, 3.62, 3.74, (30, 24, 16))  # over the desk
    warm = (60, 40, 22)
    for place, radius, scale in (((-1.12, 1.27, 3.66), 0.05, 1.4), ((1.75, 1.6, 5.9), 0.06, 1.3), ((-1.75, 1.95, D - 0.25), 0.05, 1.1),
                                 ((1.05, 1.95, D - 0.25), 0.05, 1.1), ((W - 0.25, 1.95, 3.5), 0.05, 1.0), ((0.4, H - 0.53, 5.2), 0.06, 0.8)):
        r.bulb(place, radius, [scale * c for c in warm])
    white = (1, 0.86, 0.66)
    for x in (-1.0, 0.35, 2.15):  # on the pictures at the back, and one beside the windows
        r.spot((x, H - 0.12, D - 1.25), (x, 1.75, D), 6, white, 0.55)
    r.spot((W - 1.2, H - 0.12, 6.1), (W, 1.7, 6.1), 5, white, 0.55)
    for z in CASES:  # along the books
        r.spot((-W + 1.15, H - 0.1, z), (-W, 1.35, z), 9, white, 0.72)
    r.spot((-0.6, H - 0.12, 5.5), (-1.0, 0.4, 5.55), 7, (1, 0.8, 0.55), 0.5)
    r.spot((1.3, H - 0.12, 4.6), (1.5, 0.4, 5.4), 6, (1, 0.8, 0.55), 0.5)
    r.spot((0.9, H - 0.12, 2.5), (0.6, 0, 2.9), 5, (1, 0.85, 0.62), 0.6)


def shell(r):
    with r.block():
        r.made_of("oak", 0.006, gloss=0.7, roughness=0.22, dust=0.05)
        r.sheet((-W, 0, D), (W, 0, D), (W, 0, 0), (-W, 0, 0), (3.5, 3.6))
    with r.block():
        r.made_of("paper", 0.006, gloss=0.15)
        r.sheet((-W, H, 0), (-W, H, D), (-W, 0, D), (-W, 0, 0), (4, 1.9))
        r.sheet((-W, H, D), (W, H, D), (W, 0.95, D), (-W, 0.95, D), (4, 1.3))
        r.sheet((W, H, 0), (-W, H, 0), (-W, 0, 0), (W, 0, 0), (4, 1.9))
        for a, b in ((0, 1.7), (2.9, 4.1), (5.3, D)):  # between the windows
            r.sheet((W, H, b), (W, H, a), (W, 0.95, a), (W, 0.95, b), ((b - a) / 1.7, 1.3))
        for a, b in ((1.7, 2.9), (4.1, 5.3)):
            r.sheet((W, H, b), (W, H, a), (W, 2.5, a), (W, 2.5, b), (0.7, 0.36))
    with r.block():
        r.made_of("plaster", 0.012, gloss=0.05)
        for x0, x1, z0, z1 in ((-W, -0.5, 0, D), (0.7, W, 0, D), (-0.5, 0.7, 0, 3.0), (-0.5, 0.7, 4.2, D)):
            r.sheet((x0, H, z0), (x1, H, z0), (x1, H, z1), (x0, H, z1), ((x1 - x0) / 2, (z1 - z0) / 2))
    with r.block():
        r.made_of("walnut", 0.012, solid=3, repeat=(1, 0.5), gloss=0.6)
        for z in (0.9, 2.6, 4.6, 6.3):  # beams
            r.cushion(-W, W, H - 0.2, H + 0.02, z - 0.1, z + 0.1, 0.02)
        for x in (-0.62, 0.7):
            r.cushion(x, x + 0.1, H - 0.06, H + 0.1, 2.9, 4.3, 0.02)
    panels = [((0, 0, D), 0, [(-W + 0.5 * k, 0.5) for k in range(14)]), ((W, 0, 0), 90, [(-7 + 0.5 * k, 0.5) for k in range(14)])]
    for place, turn, parts in panels:  # wainscot
        for x, w in parts:
            if x + w > (W if turn == 0 else 0) + 0.01:
                w = (W if turn == 0 else 0) - x
            with r.block(f"Translate {fmt(place)}", f"Rotate {turn} 0 1 0"):
                r.made_of("walnut", 0.008, solid=r.rng.uniform(3, 6), gloss=0.55)
                r.cushion(x, x + w, 0, 0.95, -0.03, 0.02, 0.008)
                r.cushion(x + 0.06, x + w - 0.06, 0.2, 0.82, -0.055, -0.02, 0.012)
                r.cushion(x, x + w, 0.9, 0.98, -0.07, 0.02, 0.015)
                r.cushion(x, x + w, 0, 0.14, -0.05, 0.02, 0.01)


def windows(r):
    for z in (2.3, 4.7):
        with r.block(f"Translate {W} 0 {z}", "Rotate 90 0 1 0"):
            with r.block():
                r.made_of("plaster", 0.006, solid=4, paintcolor=(0.95, 0.94, 0.9))
                for k in (-0.62, -0.02, 0.58):
                    r.cushion(k, k + 0.05, 0.95, 2.5, 0.02, 0.08, 0.01)
                for k in (0.93, 1.72, 2.46):
                    r.cushion(-0.62, 0.62, k, k + 0.05, 0.03, 0.075, 0.01)
                r.cushion(-0.75, 0.75, 0.9, 0.95, -0.2, 0.05, 0.015)
            for side in (-1, 1):  # curtains, of bicubic patches; the nearer pair swings
                with r.block():
                    r.made_of("cloth", 0.006, repeat=(5, 8), paintcolor=(0.62, 0.2, 0.14), gloss=0.1, roughness=0.7)
                    r("Sides 2", 'Basis "b-spline" 1 "b-spline" 1')
                    folds, rows = 22, 7

                    def mesh(swing):
                        points = []
                        for j in range(rows):
                            f = j / (rows - 1)
                            for i in range(folds):
                                e = i / (folds - 1)
                                x = side * (0.98 - 0.5 * e * (1 - 0.35 * math.sin(math.pi * f)) + swing * f * f * e)
                                points += [x, 2.72 - 2.66 * f, -0.14 - 0.05 * math.cos(2.1 * i) * (0.7 + 0.3 * f) + 0.4 * swing * f]
                        return (f'PatchMesh "bicubic" {folds} "nonperiodic" {rows} "nonperiodic" "P" [{fmt(points)}]')
                    if z < 3:
                        r("MotionBegin [0 1]", mesh(0), mesh(0.05), "MotionEnd")
                    else:
                        r(mesh(0))
            with r.block("Translate 0 2.72 -.14", "Rotate 90 0 1 0"):
                r.made_of("glaze", 0.002, solid=20, **BRASS)
                r("Cylinder 0.02 -1.05 1.05 360")


def book(r, width, height, depth):
    """Stands at x from 0 to `width`, its back at z = 0."""
    rng = r.rng
    color = [c * rng.uniform(0.75, 1.25) for c in rng.choice(LEATHERS)]
    with r.block():
        r.made_of("leather", 0.0035, solid=rng.uniform(25, 45), paintcolor=[min(c, 1) for c in color], wear=rng.uniform(0, 0.3),
                  frequency=rng.uniform(8, 16), metalcolor=(0.5, 0.4, 0.3), roughness=rng.uniform(0.25, 0.5))
        e = min(0.006, width / 5)
        r.cushion(0, width, 0, height, -0.004, 0.022, min(0.009, width / 3))
        r.cushion(0, e, 0, height, 0, depth, e / 3)
        r.cushion(width - e, width, 0, height, 0, depth, e / 3)
        if rng.random() < 0.6:  # bands on its back
            for k in range(rng.randrange(2, 5)):
                y = height * (0.15 + 0.2 * k)
                r.cushion(-0.001, width + 0.001, y, y + 0.007, -0.008, 0.01, 0.003)
    with r.block():
        r.made_of("pages", 0.002, repeat=(1, 1), gloss=0.05)
        r.sheet((e, height - 0.006, 0.01), (width - e, height - 0.006, 0.01), (width - e, height - 0.006, depth - 0.004),
                (e, height - 0.006, depth - 0.004))


def vase(r, size):
    rng = r.rng
    a, b, c, d = (rng.uniform(*v) for v in ((0.2, 0.45), (0.35, 0.6), (0.1, 0.3), (0.14, 0.34)))
    with r.block(f"Scale {size} {size} {size}"):
        kind = rng.randrange(3)
        color = [rng.uniform(0.15, 0.9) for _ in range(3)]
        if kind == 0:
            r.made_of("glaze", 0.05, repeat=(2, 2), paintcolor=color, gloss=1, roughness=0.06, frequency=3)
        elif kind == 1:
            r.made_of("map", 0.06, repeat=(2, 1), gloss=0.9, roughness=0.1, frequency=3)
        else:
            r.made_of("glaze", 0.05, solid=rng.uniform(2, 6), frequency=4, **BRASS)
        r.nurbs_lathe([(0.001, 0), (a, 0), (b, 0.25), (b, 0.6), (c, 0.8), (c, 0.92), (d, 1), (d - 0.03, 1), (c - 0.03, 0.9),
                       (0.001, 0.7)])


def bookcases(r, density):
    rng = r.rng
    for case, middle in enumerate(CASES):
        z0, z1, x = middle - 0.88, middle + 0.88, -W
        with r.block():
            r.made_of("walnut", 0.008, solid=4, gloss=0.6)
            for z in (z0, z1 - 0.04):
                r.cushion(x, x + 0.34, 0, 2.5, z, z + 0.04, 0.008)
            for y in (*SHELVES, 2.5):
                r.cushion(x, x + 0.33, y - 0.03, y, z0 + 0.03, z1 - 0.03, 0.008)
            r.cushion(x, x + 0.37, 2.5, 2.58, z0 - 0.03, z1 + 0.03, 0.02)
            r.cushion(x, x + 0.36, 0, 0.1, z0 - 0.01, z1 + 0.01, 0.012)
        for shelf, y in enumerate(SHELVES):
            at, stop = z0 + 0.05, z1 - 0.06
            while at < stop - 0.05:
                if rng.random() < 0.045:
                    if at > stop - 0.26:
                        break
                    with r.block(f"Translate {x + .19:.4f} {y} {at + .12:.4f}", f"Rotate {rng.uniform(0, 360):.0f} 0 1 0"):
                        vase(r, rng.uniform(0.2, 0.29))
                    at += 0.25
                    continue
                w = min(rng.uniform(0.022, 0.06) / max(density, 0.2) ** 0.5, stop - at)
                high, deep = rng.uniform(0.2, 0.34), rng.uniform(0.16, 0.25)
                lean = rng.uniform(4, 14) if rng.random() < 0.06 else 0
                with r.block(f"Translate {x + deep + .03:.4f} {y} {at:.4f}", "Rotate -90 0 1 0", f"Rotate {-lean:.1f} 0 0 1"):
                    book(r, w, high, deep)
                at += w + 0.0015 + math.sin(math.radians(lean)) * high


def chair(r, x, z, turn, color):
    with r.block(f"Translate {x} 0 {z}", f"Rotate {turn} 0 1 0"):
        with r.block():
            r.made_of("tweed", 0.012, solid=14, paintcolor=color, gloss=0.05, roughness=0.8)
            r.cushion(-0.32, 0.32, 0.26, 0.46, -0.34, 0.3, 0.08, 0.03)
            r.cushion(-0.46, -0.3, 0.12, 0.66, -0.36, 0.34, 0.07)
            r.cushion(0.3, 0.46, 0.12, 0.66, -0.36, 0.34, 0.07)
            r.cushion(-0.44, 0.44, 0.12, 0.28, -0.34, 0.34, 0.05)
            with r.block("Translate 0 .4 .3", "Rotate 12 1 0 0"):
                r.cushion(-0.4, 0.4, -0.2, 0.66, -0.06, 0.14, 0.08, 0.02)
        with r.block():
            r.made_of("tweed", 0.01, solid=18, paintcolor=(0.75, 0.6, 0.25), gloss=0.05)
            with r.block("Translate .05 .66 .1", "Rotate 20 1 0 0", "Rotate 12 0 0 1"):
                r.cushion(-0.2, 0.2, -0.16, 0.16, -0.06, 0.06, 0.05, 0.02)
        with r.block():
            r.made_of("walnut", 0.006, solid=12)
            for sx in (-0.38, 0.38):
                for sz in (-0.28, 0.28):
                    r.tube([(sx, 0, sz), (sx * 0.95, 0.16, sz * 0.95)], [0.022, 0.035], 8)


def desk(r):
    rng = r.rng
    with r.block("Translate -.25 0 3.68", "Rotate -4 0 1 0"):
        with r.block():
            r.made_of("walnut", 0.006, solid=5, gloss=0.9, roughness=0.18)
            r.cushion(-1.05, 1.05, 0.72, 0.77, -0.5, 0.5, 0.015)
            for x in (-0.98, 0.58):
                r.cushion(x, x + 0.4, 0.06, 0.72, -0.42, 0.42, 0.015)
                for y in (0.1, 0.3, 0.5):
                    r.cushion(x + 0.03, x + 0.37, y, y + 0.18, -0.445, -0.41, 0.012)
            r.cushion(-0.6, 0.6, 0.45, 0.72, 0.35, 0.39, 0.01)
        with r.block():
            r.made_of("glaze", 0.003, solid=30, frequency=6, **BRASS)
            for x in (-0.78, 0.78):
                for y in (0.19, 0.39, 0.59):
                    with r.block(f"Translate {x} {y} -.455"):
                        r("Sphere 0.016 -0.016 0.016 360")
        with r.block():
            r.made_of("leather", 0.004, repeat=(3, 2), paintcolor=(0.1, 0.25, 0.16))
            r.sheet((-0.45, 0.774, 0.3), (0.45, 0.774, 0.3), (0.45, 0.774, -0.4), (-0.45, 0.774, -0.4))
        for k in range(7):  # papers, curled
            with r.block(f"Translate {rng.uniform(-.3, .3):.3f} {0.781 + 0.004 * k} {rng.uniform(-.22, .12):.3f}",
                         f"Rotate {rng.uniform(-40, 40):.0f} 0 1 0"):
                r.made_of("pages", 0.001, repeat=(0.3, 0.3), map_name="plaster", paintcolor=(1, 0.98, 0.9), gloss=0.05)
                curl = rng.uniform(0.005, 0.03)
                r.bezier([(-0.105 + 0.07 * i, curl * (abs(i - 1.5) - 0.5) * (0.3 + j / 3), -0.148 + 0.099 * j) for j in (3, 2, 1, 0) for i in range(4)])
        for k, (x, z, turn) in enumerate(((0.72, 0.05, 20), (0.7, 0.04, 8), (0.73, 0.07, -15), (0.71, 0.06, 30))):  # books that lie
            with r.block(f"Translate {x} {0.775 + 0.042 * k:.3f} {z}", f"Rotate {turn} 0 1 0", "Translate -.12 0.04 -.1", "Rotate -90 0 0 1"):
                book(r, 0.04, 0.25, 0.19)
        with r.block("Translate .74 .945 .1"):  # a teapot of bicubic patches
            r.made_of("glaze", 0.03, solid=3, paintcolor=(0.25, 0.45, 0.5), gloss=1, roughness=0.08)
            r("Scale .055 .055 .055", "Rotate -90 1 0 0", 'Geometry "teapot"')
        for x, z in ((-0.52, 0.24), (0.4, 0.3), (0.25, 0.36)):
            with r.block(f"Translate {x} .775 {z}"):
                vase(r, rng.uniform(0.12, 0.2))
        with r.block("Translate .2 .84 -.1", "Rotate 25 0 1 0"):  # a quill: a curve, and its vane of curves
            r.made_of("cloth", 0.0005, paintcolor=(0.9, 0.88, 0.82))
            barbs, count = [], 0
            for k in range(60):
                f = 0.35 + 0.65 * k / 60
                base = (0.02 * f, 0.3 * f, 0.1 * f * f)
                for side in (-1, 1):
                    barbs += [*base, base[0] + side * 0.02, base[1] + 0.012, base[2], base[0] + side * 0.035, base[1] + 0.035, base[2] - 0.005,
                              base[0] + side * 0.04, base[1] + 0.06, base[2]]
                    count += 1
            r('Basis "bezier" 3 "bezier" 3', f'Curves "cubic" [{" ".join(["4"] * count)}] "nonperiodic" "P" [{fmt(barbs)}] "constantwidth" [.003]',
              'Curves "cubic" [4] "nonperiodic" "P" [0 -.06 0 .005 .1 .005 .012 .2 .04 .02 .3 .1] "constantwidth" [.005]')
        with r.block("Translate -.87 .775 .04"):  # the lamp
            r.made_of("glaze", 0.004, solid=16, frequency=5, **BRASS)
            r.nurbs_lathe([(0.001, 0), (0.1, 0), (0.1, 0.02), (0.02, 0.05), (0.025, 0.2), (0.012, 0.3), (0.012, 0.42)])
            with r.block("Translate 0 .41 0"):
                r.made_of("cloth", 0.003, repeat=(6, 2), paintcolor=(0.16, 0.4, 0.26), gloss=0.6)
                r.nurbs_lathe([(0.17, 0), (0.165, 0.05), (0.13, 0.12), (0.06, 0.16), (0.055, 0.17)])
        globe(r)


def globe(r):
    """Turns by a sixth while the shutter is open."""
    with r.block("Translate -.42 .775 .3"):
        with r.block():
            r.made_of("glaze", 0.003, solid=20, **BRASS)
            r.nurbs_lathe([(0.001, 0), (0.09, 0), (0.09, 0.02), (0.015, 0.04), (0.012, 0.12)])
            with r.block("Translate 0 .27 0", "Rotate 90 0 1 0"):
                r("Torus 0.165 0.008 0 360 360")
        with r.block("Translate 0 .27 0", "Rotate -23 0 0 1"), r.moving("Rotate 0 0 1 0", "Rotate 30 0 1 0", "Rotate 60 0 1 0"):
            r.made_of("map", 0.012, gloss=0.8, roughness=0.15)
            r.ball(0.15, (2, 1))


def pictures(r):
    places = [((x, 1.75, D), 0) for x in (-1.0, 0.35, 2.15)] + [((W, 1.7, 6.1), 90)]
    for k, (place, turn) in enumerate(places):
        w, h = ((0.95, 0.72), (0.7, 0.9), (1.0, 0.8), (0.8, 0.65))[k]
        with r.block(f"Translate {fmt(place)}", f"Rotate {turn} 0 1 0"):
            with r.block():
                r.made_of(f"picture{k}", 0.012, gloss=0.5, roughness=0.3, dirt=0.02)
                r.sheet((-w / 2, h / 2, -0.03), (w / 2, h / 2, -0.03), (w / 2, -h / 2, -0.03), (-w / 2, -h / 2, -0.03))
            b = 0.09
            for x0, x1, y0, y1 in ((-w / 2 - b, w / 2 + b, h / 2, h / 2 + b), (-w / 2 - b, w / 2 + b, -h / 2 - b, -h / 2),
                                   (-w / 2 - b, -w / 2, -h / 2, h / 2), (w / 2, w / 2 + b, -h / 2, h / 2)):
                with r.block():
                    r.made_of("glaze", 0.02, solid=12, frequency=7, **BRASS)
                    r.cushion(x0, x1, y0, y1, -0.08, 0, 0.025)


def rug(r, density):
    rng = r.rng
    x0, x1, z0, z1 = -1.7, 2.1, 1.55, 5.9
    with r.block():
        r.made_of("rug", 0.014, gloss=0.02, roughness=0.9)
        r.sheet((x0, 0.016, z1), (x1, 0.016, z1), (x1, 0.016, z0), (x0, 0.016, z0))
    with r.block():  # tufts and fringe
        r.made_of("cloth", 0.0005, paintcolor=(0.6, 0.45, 0.28), gloss=0.02)
        points, tufts, count = [], [], round(6000 * density)
        for _ in range(count):
            x, z = rng.uniform(x0 + 0.03, x1 - 0.03), rng.uniform(z0 + 0.03, z1 - 0.03)
            dx, dz = rng.uniform(-.012, .012), rng.uniform(-.012, .012)
            tufts += [x, 0.015, z, x, 0.022, z, x + dx, 0.028, z + dz, x + 2 * dx, 0.03, z + 2 * dz]
        n = round(420 * density)
        for side, z in ((-1, z0), (1, z1)):
            for k in range(n):
                x = x0 + (x1 - x0) * (k + rng.random()) / n
                dx = rng.uniform(-.02, .02)
                points += [x, 0.016, z, x, 0.02, z + side * 0.03, x + dx, 0.012, z + side * 0.07, x + dx * 2, 0.006, z + side * 0.11]
        r('Basis "bezier" 3 "bezier" 3', f'Curves "cubic" [{" ".join(["4"] * count)}] "nonperiodic" "P" [{fmt(tufts)}] "constantwidth" [.004]',
          f'Curves "cubic" [{" ".join(["4"] * 2 * n)}] "nonperiodic" "P" [{fmt(points)}] "constantwidth" [.006]')


def fan(r):
    with r.block(f"Translate .4 {H - .28} 5.2"):
        r.made_of("glaze", 0.004, solid=12, **BRASS)
        r.tube([(0, 0.3, 0), (0, 0.02, 0)], [0.02, 0.02], 8)
        r.nurbs_lathe([(0.001, -0.16), (0.08, -0.14), (0.12, -0.02), (0.1, 0.06), (0.001, 0.08)])
        with r.moving(*(f"Rotate {k * 15} 0 1 0" for k in range(5))):
            r.made_of("walnut", 0.006, solid=5)
            for k in range(5):
                with r.block(f"Rotate {72 * k} 0 1 0", "Rotate 9 1 0 0"):
                    r.cushion(0.14, 0.78, -0.006, 0.006, -0.075, 0.075, 0.004)


def clock(r):
    with r.block(f"Translate -2.45 0 {D}"):
        with r.block():
            r.made_of("walnut", 0.01, solid=4)
            for x0, x1, y0, y1, z0 in ((-0.26, 0.26, 0, 0.5, -0.3), (-0.2, -0.15, 0.5, 1.5, -0.26), (0.15, 0.2, 0.5, 1.5, -0.26),
                                       (-0.2, 0.2, 0.5, 1.5, -0.05), (-0.27, 0.27, 1.5, 2.05, -0.3), (-0.3, 0.3, 2.05, 2.13, -0.33)):
                r.cushion(x0, x1, y0, y1, z0, 0 if z0 < -0.1 else -0.02, 0.012)
        with r.block("Translate 0 1.78 -.305", "Rotate 180 0 1 0"):
            r.made_of("glaze", 0.004, paintcolor=(0.95, 0.92, 0.82))
            r("Disk 0 0.21 360")
        with r.block("Translate 0 1.5 -.16"), r.moving("Rotate -7 0 0 1", "Rotate 0 0 0 1", "Rotate 7 0 0 1"):
            r.made_of("glaze", 0.004, solid=9, **BRASS)
            r.tube([(0, 0, 0), (0, -0.75, 0)], [0.008, 0.008], 6)
            with r.block("Translate 0 -.78 0", "Scale 1 1 .3"):
                r.ball(0.1)


def lamps(r):
    """What holds the bulbs: shades open above and below, a standard lamp, brackets."""
    for place, turn in (((-1.75, 1.95, D), 0), ((1.05, 1.95, D), 0), ((W, 1.95, 3.5), 90)):
        with r.block(f"Translate {fmt(place)}", f"Rotate {turn} 0 1 0"):
            with r.block():
                r.made_of("glaze", 0.003, solid=14, **BRASS)
                r.tube([(0, -0.2, 0), (0, -0.24, -0.15), (0, -0.12, -0.25)], [0.012, 0.012, 0.012], 8)
            with r.block("Translate 0 -.1 -.25"):
                r.made_of("cloth", 0.004, repeat=(5, 2), paintcolor=(0.85, 0.74, 0.55), gloss=0.05)
                r.nurbs_lathe([(0.13, 0), (0.12, 0.08), (0.1, 0.14), (0.085, 0.22)])
    with r.block("Translate 1.75 0 5.9"):
        with r.block():
            r.made_of("glaze", 0.004, solid=10, **BRASS)
            r.nurbs_lathe([(0.001, 0), (0.15, 0), (0.15, 0.03), (0.02, 0.06), (0.016, 0.8), (0.016, 1.5)])
        with r.block("Translate 0 1.5 0"):
            r.made_of("cloth", 0.005, repeat=(8, 3), paintcolor=(0.9, 0.76, 0.5), gloss=0.05)
            r.nurbs_lathe([(0.24, 0), (0.22, 0.1), (0.18, 0.2), (0.14, 0.28)])
    with r.block():
        r.made_of("glaze", 0.004, solid=9, **BRASS)
        r.cushion(-0.7, 0.2, 2.03, 2.06, 3.58, 3.78, 0.01)  # the panel's back, and what it hangs from
        for x in (-0.6, 0.1):
            r.tube([(x, 2.05, 3.68), (x, H, 3.68)], [0.006, 0.006], 6)


def greenery(r):
    rng = r.rng
    with r.block("Translate 2.75 0 6.35"):
        with r.block():
            r.made_of("map", 0.02, repeat=(2, 1), paintcolor=(0.6, 0.5, 0.4), gloss=0.8)
            r.nurbs_lathe([(0.001, 0), (0.16, 0), (0.25, 0.2), (0.24, 0.4), (0.2, 0.46), (0.18, 0.44), (0.001, 0.38)])
        for k in range(26):  # leaves of bicubic patches
            with r.block("Translate 0 .4 0", f"Rotate {k * 137.5 % 360:.1f} 0 1 0", f"Rotate {rng.uniform(5, 50):.1f} 1 0 0"):
                tone = rng.uniform(0.7, 1.2)
                r.made_of("leather", 0.004, repeat=(0.3, 1), paintcolor=(0.12 * tone, 0.34 * tone, 0.1 * tone), gloss=0.8, roughness=0.25)
                long, wide = rng.uniform(0.6, 1.1), rng.uniform(0.05, 0.09)
                r.bezier([((i - 1.5) / 1.5 * wide * w, long * (f - 0.2 * f * f), 0.4 * long * f * f - 0.02 * abs(i - 1.5) * w)
                          for f, w in ((0, 0.25), (0.33, 1.2), (0.67, 1), (1, 0.05)) for i in range(4)])


def main():
    args = arguments(__doc__, 5)
    textures(args.folder, args.seed)
    r = Study(args.seed)
    r.make_textures(args.folder)
    r.film(52, EYE, AT, (0.02, 0.004, 0.03), 3, 2)
    lights(r)
    shell(r)
    windows(r)
    bookcases(r, args.density)
    rug(r, args.density)
    r("ShadingRate 0.5")
    desk(r)
    chair(r, -0.95, 5.5, -28, (0.55, 0.16, 0.12))
    chair(r, 1.3, 5.35, 26, (0.2, 0.32, 0.36))
    pictures(r)
    lamps(r)
    greenery(r)
    fan(r)
    clock(r)
    r("WorldEnd")
    r.save(args.folder)


main()
