#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Hit rates of the radiosity cache by level and depth, for several sizes of it, as Markdown.

    hit_rates.py tests/bench/scenes/door_interior --res 1200x900 --rays 16 --samples 1

Micropolygons are counted by the vertices of the fine level that were made for the camera (depth 0) with room for
everything: neighbours share vertices, so there is about one for each micropolygon that the picture shows.

A miss is an entry that had to be made (one vertex of the fine level, all vertices of the others). Entries that were made
again after they had given way are the misses beyond those with room for everything.
"""
import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time

LEVELS = ("coarse", "medium", "fine")
WHY = {
    "found their value": "value from the cache",
    "shaded, as they are too short": "shaded: shorter than the distance of vertices",
    "shaded, as they are too narrow": "shaded: narrower than the distance of vertices",
    "shaded, as something stands in the cell": "shaded: something stands in the cell",
    "shaded, as they are the last ones and meet small faces": "shaded: last bounce, on small faces",
    "shaded, as the shader is not cacheable": "shaded: not cacheable",
}


def render(args, rib, megabytes, folder):
    stats = os.path.join(folder, "stats.json")
    command = [args.patina, "-q", "--mode", "radiosity", "--res", args.res, "--rays", str(args.rays), "--samples",
               str(args.samples), "-t", str(args.threads), "--cache-memory", str(megabytes), "--stats", stats,
               "-o", os.path.join(folder, f"{megabytes}.exr"), rib]
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    subprocess.run(command, check=True)
    after, wall = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic() - start
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    with open(stats) as file:
        return {"stats": json.load(file), "wall": wall, "cpu": cpu}


def rows(run):
    """(level, depth, {look-ups, hits, misses, evictions}) of what was used at all."""
    cache = run["stats"]["Radiosity cache"]
    for level in LEVELS:
        for depth in range(16):
            values = cache.get(level, {}).get(f"depth {depth}", {})
            if values.get("look-ups", 0) > 0:
                yield level, depth, values


def total(run, name):
    return sum(values.get(name, 0) for _, _, values in rows(run))


def percent(part, whole):
    return f"{100 * part / whole:.2f}" if whole else "-"


def report(runs, whole, out):
    vertices = next((v["misses"] for l, d, v in rows(whole) if (l, d) == ("fine", 0)), 0)
    print(f"{vertices:,.0f} micropolygons.\n", file=out)
    print("| MB | look-ups | hits % | of them at depth 0 % | hits % at depth 1 and more | evictions | made again | wall s | CPU s |",
          file=out)
    print("| ---: " * 9 + "|", file=out)
    for megabytes, run in runs.items():
        camera = next((v for l, d, v in rows(run) if (l, d) == ("fine", 0)), {})
        asked, hits = total(run, "look-ups"), total(run, "hits")
        deep, deep_hits = asked - camera.get("look-ups", 0), hits - camera.get("hits", 0)
        again = total(run, "misses") - total(whole, "misses")
        print(f"| {megabytes:g} | {asked:,.0f} | {percent(hits, asked)} | {percent(camera.get('hits', 0), camera.get('look-ups', 0))} "
              f"| {percent(deep_hits, deep)} | {total(run, 'evictions'):,.0f} | {max(again, 0):,.0f} | {run['wall']:.1f} "
              f"| {run['cpu']:.1f} |", file=out)
    for megabytes, run in runs.items():
        print(f"\n{megabytes:g} MB:\n", file=out)
        print("| level | depth | look-ups | hits % | misses | evictions | made again |", file=out)
        print("| --- " + "| ---: " * 6 + "|", file=out)
        base = {(l, d): v["misses"] for l, d, v in rows(whole)}
        for level, depth, v in rows(run):
            again = max(v["misses"] - base.get((level, depth), 0), 0)
            print(f"| {level} | {depth} | {v['look-ups']:,.0f} | {percent(v['hits'], v['look-ups'])} | {v['misses']:,.0f} "
                  f"| {v.get('evictions', 0):,.0f} | {again:,.0f} |", file=out)
    rays = whole["stats"]["Radiosity cache"].get("rays", {})
    print("\n| of the diffuse rays that met something | % |\n| --- | ---: |", file=out)
    for name, text in WHY.items():
        print(f"| {text} | {percent(rays.get(name, 0), rays.get('met something', 0))} |", file=out)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    parser.add_argument("scene", help="a RIB, or a folder with bench.json and make.py")
    parser.add_argument("--patina", default=os.path.join(root, "build/release/bin/patina"))
    parser.add_argument("--res", default="1200x900")
    parser.add_argument("--rays", type=int, default=128)
    parser.add_argument("--samples", type=int, default=4)
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--memory", type=float, nargs="+", default=[256, 64, 16, 4], help="sizes of the cache, MB")
    parser.add_argument("--room", type=float, default=4096, help="MB that hold everything")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rib = args.scene
        if os.path.isdir(rib):
            with open(os.path.join(rib, "bench.json")) as file:
                make = json.load(file)["make"]
            subprocess.run([sys.executable, os.path.join(rib, make), folder], check=True, stdout=subprocess.DEVNULL)
            rib = os.path.join(folder, "scene.rib")
        whole = render(args, rib, args.room, folder)
        runs = {args.room: whole} | {megabytes: render(args, rib, megabytes, folder) for megabytes in args.memory}
        report(runs, whole, sys.stdout)


if __name__ == "__main__":
    main()
