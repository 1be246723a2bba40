#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Error, time and hit rate of the radiosity cache as functions of the constants that choose levels, as Markdown.

    level_scale.py tests/scenes/cornell/scene.rib reference.exr --res 192x192

The reference has the picture's size: patina-bench keeps its own under references/. Needs python3-openimageio.
"""
import argparse
import json
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


def render(args, constants, folder):
    rib, stats = os.path.join(folder, "options.rib"), os.path.join(folder, "stats.json")
    picture = os.path.join(folder, "picture.exr")
    with open(rib, "w") as file:
        for name, value in constants.items():
            file.write(f'Option "patina" "float {name}" [{value}]\n')
        file.write(f'ReadArchive "{os.path.abspath(args.scene)}"\n')
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([args.patina, "-q", "--mode", "radiosity", "--res", args.res, "--rays", str(args.rays), "--samples",
                    str(args.samples), "--stats", stats, "-o", picture, rib], check=True,
                   cwd=os.path.dirname(os.path.abspath(args.scene)))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    with open(stats) as file:
        return read(picture), json.load(file), after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def row(args, name, value, folder, reference):
    picture, stats, seconds = render(args, {name: value}, folder)
    cache = stats["Radiosity cache"]
    levels = [v for level in ("coarse", "medium", "fine") for depth, v in cache.get(level, {}).items()
              if isinstance(v, dict) and depth != "depth 0"]
    asked, hits = (sum(v.get(key, 0) for v in levels) for key in ("look-ups", "hits"))
    rays = cache["rays"]
    error = ((picture - reference) ** 2 / (reference ** 2 + 0.01)).mean()
    return (f"| {value:g} | {error:.3g} | {picture.mean() / reference.mean():.4f} | {seconds:.1f} "
            f"| {100 * hits / max(asked, 1):.2f} "
            f"| {100 * rays['found their value'] / max(rays['met something'], 1):.1f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", help="a RIB")
    parser.add_argument("reference", help="a picture of the same size")
    parser.add_argument("--patina", default="build/release/bin/patina")
    parser.add_argument("--res", required=True)
    parser.add_argument("--rays", type=int, default=128)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--levelscale", type=float, nargs="*", default=[0.1, 0.2, 0.35, 0.5, 0.7, 1, 2, 4])
    parser.add_argument("--finescale", type=float, nargs="*", default=[0, 0.5, 1, 2, 4, 8])
    args = parser.parse_args()
    args.patina = os.path.abspath(args.patina)
    reference = read(args.reference)
    with tempfile.TemporaryDirectory() as folder:
        for name in ("levelscale", "finescale"):
            values = getattr(args, name)
            if not values:
                continue
            print(f"\n| {name} | relMSE | mean / reference's | CPU s | hits at depth 1 and more % "
                  "| rays that found a value % |\n" + "| ---: " * 6 + "|", flush=True)
            for value in values:
                print(row(args, name, value, folder, reference), flush=True)


if __name__ == "__main__":
    main()
