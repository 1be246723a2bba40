#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A furry creature in a meadow: 36 000 hairs and 15 000 blades of grass, cubic curves that taper to points, each of a
colour of its own. The sky and a low soft light from behind, which rims the fur."""
import math
import os
import random
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from ribwriter import Rib, fmt, fractal, smooth_noise, target_folder  # noqa: E402


def unit(v):
    size = math.sqrt(sum(c * c for c in v))
    return [c / size for c in v]


def curves(r, hairs, root, tip):
    """Bezier curves of one segment: hairs are (four points, colour); `root` and `tip`: widths."""
    r('Basis "bezier" 3 "bezier" 3',
      f'Curves "cubic" [{" ".join(["4"] * len(hairs))}] "nonperiodic" "P" '
      f'[{" ".join(f"{c:.4g}" for points, _ in hairs for p in points for c in p)}] '
      f'"varying float width" [{" ".join([f"{root:g} {tip:g}"] * len(hairs))}] '
      f'"uniform color Cs" [{" ".join(f"{c:.3g}" for _, color in hairs for c in color)}]')


def fur(rng, centre, radius, count, length, color, bald):
    """Hairs spread evenly over a ball (a spiral of Fibonacci), combed down and back in locks; none where bald(n)."""
    hairs = []
    for k in range(count):
        y = 1 - 2 * (k + 0.5) / count
        s, a = math.sqrt(1 - y * y), k * 2.399963
        n = (s * math.cos(a), y, s * math.sin(a))
        if bald(n):
            continue
        lock = (fractal(3 * n[0] + 9, 3 * n[1] + 5, 2, 1) - 0.5, fractal(3 * n[1] + 7, 3 * n[2] + 8, 2, 2) - 0.5)
        comb = (1.1 * lock[0] + rng.gauss(0, 0.1), -0.75 + rng.gauss(0, 0.1), 0.45 + 1.1 * lock[1] + rng.gauss(0, 0.1))
        across = sum(x * y for x, y in zip(comb, n))
        comb = [c - across * m for c, m in zip(comb, n)]
        reach = length * rng.uniform(0.7, 1.1)
        points = []
        for f in (0, 0.33, 0.67, 1):
            lift, bend = reach * (f - 0.25 * f * f), reach * 0.85 * f * f
            points.append([c + m * (radius - 0.01 + lift) + b * bend for c, m, b in zip(centre, n, comb)])
        tone = rng.uniform(0.7, 1.15) * (0.7 + 0.6 * smooth_noise(4 * n[0] + 9, 4 * n[1] + 4 * n[2] + 20, 6))
        hairs.append((points, [min(1, c * tone) for c in color]))
    return hairs


def grass(rng, count, clear):
    """Blades that lean; fewer and smaller ones farther away do, as those are seen from the side."""
    blades = []
    while len(blades) < count:
        z = -2.6 + 7.5 * rng.random() ** 1.4
        x = rng.uniform(-1, 1) * (1.6 + 0.55 * (z + 2.8))
        if clear(x, z):
            continue
        height = rng.uniform(0.12, 0.3) * (0.5 + fractal(0.8 * x + 20, 0.8 * z + 20, 3, 4))
        a, lean = rng.uniform(0, 2 * math.pi), height * rng.uniform(0.1, 0.7)
        dx, dz = lean * math.cos(a), lean * math.sin(a)
        points = [(x + dx * f * f, height * (f - 0.15 * f * f), z + dz * f * f) for f in (0, 0.33, 0.67, 1)]
        tone, dry = rng.uniform(0.6, 1.2), max(0, rng.gauss(0.1, 0.2))
        blades.append((points, [min(1, tone * (g + (d - g) * dry)) for g, d in zip((.16, .34, .06), (.55, .45, .2))]))
    return blades


def eyes_and_nose(r, centre, radius):
    shiny = 'Surface "plastic" "float Ka" [0] "float Kd" [.6] "float Ks" [.4] "float roughness" [.02]'
    for x, y, size, color in ((-0.36, 0.3, 0.17, ".85 .84 .8"), (0.36, 0.3, 0.17, ".85 .84 .8"), (0, 0.04, 0.1, ".08 .05 .05")):
        n = unit((x, y, -1))
        place = [c + radius * m for c, m in zip(centre, n)]
        with r.block(shiny, f"Color [{color}]", f"Translate {fmt(place)}"):
            r(f"Sphere {size} {-size} {size} 360")
        if y > 0.1:
            pupil = [p + size * 0.62 * m for p, m in zip(place, unit((0.12 - 0.3 * x, -0.12, -1)))]
            with r.block(shiny, "Color [.03 .03 .04]", f"Translate {fmt(pupil)}"):
                r("Sphere 0.088 -0.088 0.088 360")


def main():
    folder = target_folder()
    rng = random.Random(5)
    body, radius = (0, 0.98, 0), 0.9
    r = Rib()
    r("##Scene hair")
    r.camera("hair", (256, 192), 42, (0.9, 1.35, -3.7), (0.04, 0.92, 0))
    r('Attribute "trace" "int maxdiffusedepth" [3] "int maxspeculardepth" [1]',
      'Surface "matte" "float Ka" [0] "float Kd" [1]')
    r.light("envlight", '"float intensity" [1] "color lightcolor" [.55 .68 .9]')
    r.soft_box((-4.6, 4.6, 2.6), (0, 0.8, 0), 2.2, 2.2, (34, 29, 21))
    with r.block("Color [.1 .13 .04]"):
        r.quad((-60, 0, 90), (60, 0, 90), (60, 0, -8), (-60, 0, -8))
    with r.block("Color [.35 .2 .1]", f"Translate {fmt(body)}"):
        r(f"Sphere {radius} {-radius} {radius} 360")
    sockets = [unit(v) for v in ((-0.36, 0.3, -1), (0.36, 0.3, -1))]
    nose = unit((0, 0.04, -1))

    def bald(n):
        return (any(sum(a * b for a, b in zip(n, s)) > 0.988 for s in sockets) or
                sum(a * b for a, b in zip(n, nose)) > 0.996)

    with r.block('Surface "plastic" "float Ka" [0] "float Kd" [.9] "float Ks" [.1] "float roughness" [.15]'):
        curves(r, fur(rng, body, radius, 36000, 0.26, (.74, .4, .14), bald), 0.011, 0.002)
    eyes_and_nose(r, body, radius + 0.02)
    for x in (-0.34, 0.34):  # feet
        with r.block("Color [.6 .3 .1]", f"Translate {x} 0.08 -0.55", "Scale 1 .55 1.5"):
            r("Sphere 0.2 -0.2 0.2 360")
    curves(r, grass(rng, 15000, lambda x, z: x * x + z * z < 0.3), 0.02, 0.003)
    r("WorldEnd")
    r.save(folder)


main()
