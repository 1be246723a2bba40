#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Error, time and hit rate of the radiosity cache as functions of the constants that choose levels: Markdown, and a chart.

    level_scale.py tests/scenes/cornell/scene.rib,cornell.exr,192x192 door/scene.rib,door.exr,96x72 --svg levels.svg

Each scene is a RIB, a reference and the resolution of both; patina-bench keeps its references under references/. Needs
python3-openimageio.
"""
import argparse
import json
import math
import os
import resource
import subprocess
import tempfile

import numpy
import OpenImageIO as oiio


def read(path):
    pixels = oiio.ImageBuf(path).get_pixels(oiio.FLOAT)
    if pixels.size == 0:
        raise SystemExit(f"{path}: cannot read")
    return pixels[:, :, :3].astype(float)


CONSTANTS = {"levelscale": 0.35, "finescale": 2}
MEASURES = ("relMSE", "mean / reference's", "CPU s", "hits at depth 1 and more %", "rays that found a value %")
PLOTTED = ("relMSE", "CPU s", "hits at depth 1 and more %")  # the first two over those of the default


def render(args, scene, resolution, constants, folder):
    rib, stats = os.path.join(folder, "options.rib"), os.path.join(folder, "stats.json")
    picture = os.path.join(folder, "picture.exr")
    with open(rib, "w") as file:
        for name, value in constants.items():
            file.write(f'Option "patina" "float {name}" [{value}]\n')
        file.write(f'ReadArchive "{os.path.abspath(scene)}"\n')
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([args.patina, "-q", "--mode", "radiosity", "--res", resolution, "--rays", str(args.rays), "--samples",
                    str(args.samples), "--stats", stats, "-o", picture, rib], check=True,
                   cwd=os.path.dirname(os.path.abspath(scene)))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    with open(stats) as file:
        return read(picture), json.load(file), after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def measure(args, scene, resolution, constants, folder, reference):
    picture, stats, seconds = render(args, scene, resolution, constants, folder)
    cache = stats["Radiosity cache"]
    levels = [v for level in ("coarse", "medium", "fine") for depth, v in cache.get(level, {}).items()
              if isinstance(v, dict) and depth != "depth 0"]
    asked, hits = (sum(v.get(key, 0) for v in levels) for key in ("look-ups", "hits"))
    rays = cache["rays"]
    error = ((picture - reference) ** 2 / (reference ** 2 + 0.01)).mean()
    return dict(zip(MEASURES, (error, picture.mean() / reference.mean(), seconds, 100 * hits / max(asked, 1),
                               100 * rays["found their value"] / max(rays["met something"], 1))))


def draw(results, path):
    """A panel for each measure (rows) and constant (columns), a line for each scene; constants of 0 have no place."""
    results = {constant: {scene: {value: {m: found[m] / (1 if m.endswith("%") else base[m]) for m in PLOTTED}
                                  for value, found in points.items() if value > 0}
                          for scene, points in by_scene.items()
                          for base in [points.get(CONSTANTS[constant], next(iter(points.values())))]}
               for constant, by_scene in results.items()}
    wide, high, left, top, gap = 330, 150, 60, 34, 46
    colours = ("#1b6ca8", "#c0392b", "#2e8b57", "#8e44ad", "#b8860b")
    scenes = sorted({scene for constant in results.values() for scene in constant})
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{2 * (wide + left) + 20}" '
           f'height="{top + len(PLOTTED) * (high + gap) + 10}" font-family="sans-serif" font-size="11">',
           '<rect width="100%" height="100%" fill="white"/>']
    for k, scene in enumerate(scenes):
        out.append(f'<text x="{left + 150 * k}" y="16" fill="{colours[k % len(colours)]}">&#9644; {scene}</text>')
    for column, (constant, by_scene) in enumerate(results.items()):
        for line, measure_name in enumerate(PLOTTED):
            x0, y0 = left + column * (wide + left), top + line * (high + gap)
            over = "" if measure_name.endswith("%") else " over that of the default"
            xs = [math.log10(v) for points in by_scene.values() for v in points]
            ys = [m[measure_name] for points in by_scene.values() for m in points.values()]
            pad = 0.05 * (max(ys) - min(ys)) or 1
            low, span = min(ys) - pad, max(ys) - min(ys) + 2 * pad
            first, length = min(xs), (max(xs) - min(xs)) or 1
            at = lambda value, y: (x0 + wide * (math.log10(value) - first) / length, y0 + high * (1 - (y - low) / span))
            out.append(f'<rect x="{x0}" y="{y0}" width="{wide}" height="{high}" fill="none" stroke="#999"/>')
            out.append(f'<text x="{x0}" y="{y0 - 4}">{measure_name}{over} by {constant}</text>')
            for value in sorted({v for points in by_scene.values() for v in points}):
                x = at(value, next(iter(next(iter(by_scene.values())).values()))[measure_name])[0]
                weight = ' font-weight="bold"' if value == CONSTANTS[constant] else ""
                out.append(f'<text x="{x:.1f}" y="{y0 + high + 13}" text-anchor="middle"{weight}>{value:g}</text>')
            for y in (low + pad, low + span / 2, low + span - pad):
                out.append(f'<text x="{x0 - 4}" y="{y0 + high * (1 - (y - low) / span) + 4:.1f}" text-anchor="end">'
                           f'{y:.3g}</text>')
            for scene, points in by_scene.items():
                path_of = " ".join("{:.1f},{:.1f}".format(*at(v, points[v][measure_name])) for v in sorted(points))
                colour = colours[scenes.index(scene) % len(colours)]
                out.append(f'<polyline points="{path_of}" fill="none" stroke="{colour}" stroke-width="1.5"/>')
    with open(path, "w") as file:
        file.write("\n".join(out + ["</svg>", ""]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", metavar="scene.rib,reference.exr,WxH")
    parser.add_argument("--patina", default="build/release/bin/patina")
    parser.add_argument("--rays", type=int, default=128)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--levelscale", type=float, nargs="*", default=[0.1, 0.2, 0.35, 0.7, 1.4, 2.8])
    parser.add_argument("--finescale", type=float, nargs="*", default=[0.25, 0.5, 1, 2, 4, 8])
    parser.add_argument("--svg", help="where to write the chart")
    args = parser.parse_args()
    args.patina = os.path.abspath(args.patina)
    results = {}
    with tempfile.TemporaryDirectory() as folder:
        for entry in args.scenes:
            scene, reference, resolution = entry.split(",")
            name = os.path.basename(reference).split(".")[0].split("-")[0]
            true = read(reference)
            for constant in CONSTANTS:
                values = getattr(args, constant)
                if not values:
                    continue
                print(f"\n| {name}: {constant} | " + " | ".join(MEASURES) + " |\n" + "| ---: " * (len(MEASURES) + 1) + "|",
                      flush=True)
                for value in values:
                    found = measure(args, scene, resolution, {constant: value}, folder, true)
                    results.setdefault(constant, {}).setdefault(name, {})[value] = found
                    cells = " | ".join(f"{found[m]:.4g}" for m in MEASURES)
                    print(f"| {value:g} | {cells} |", flush=True)
    if args.svg:
        draw(results, args.svg)


if __name__ == "__main__":
    main()
