#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a field of delayed archives of which rays meet one in a hundred, and a scene that holds only those, renders
both by turns, and prints the ratios of time and of peak memory with the counters that say what was never read.

    tests/bench/delayed_field.py [--patina build/release/bin/patina] [--archives 10000] [--files 100] [--content mesh]
                                 [--mode radiosity] [--threads 0] [--repeat 5]
"""
import argparse
import json
import math
import os
import random
import statistics
import subprocess
import tempfile
import time


def mesh(seed):
    """A wavy subdivision mesh of 40 x 40 faces in a box of size 2."""
    n, rng = 40, random.Random(seed)
    a, b = rng.uniform(2, 6), rng.uniform(2, 6)
    points = " ".join(
        f"{2 * i / n - 1:.4f} {0.4 * math.sin(a * i / n) * math.cos(b * j / n):.4f} {2 * j / n - 1:.4f}"
        for j in range(n + 1) for i in range(n + 1))
    faces = " ".join(f"{j * (n + 1) + i} {j * (n + 1) + i + 1} {(j + 1) * (n + 1) + i + 1} {(j + 1) * (n + 1) + i}"
                     for j in range(n) for i in range(n))
    return f'SubdivisionMesh "catmull-clark" [{" ".join(["4"] * (n * n))}] [{faces}] [] [] [] [] "P" [{points}]\n'


def spheres(seed):
    """A hundred spheres in a box of size 2."""
    rng = random.Random(seed)
    text = ""
    for _ in range(100):
        x, y, z = (rng.uniform(-0.85, 0.85) for _ in range(3))
        text += f"AttributeBegin Translate {x:.4f} {y:.4f} {z:.4f} Sphere 0.15 -0.15 0.15 360 AttributeEnd\n"
    return text


def scene(archives, files, side, only):
    """A field of side x side archives, of which one in a hundred stands in a closed room with the camera and a light:
    no ray leaves it. `only`: these alone."""
    half = 2 * math.floor(side / 20) + 0.5 if side >= 20 else side + 0.5
    top, h = 6, half
    walls = [(-h, -2, -h, h, -2, -h, h, -2, h, -h, -2, h), (-h, top, -h, h, top, -h, h, top, h, -h, top, h),
             (-h, -2, -h, h, -2, -h, h, top, -h, -h, top, -h), (-h, -2, h, h, -2, h, h, top, h, -h, top, h),
             (-h, -2, -h, -h, -2, h, -h, top, h, -h, top, -h), (h, -2, -h, h, -2, h, h, top, h, h, top, -h)]
    text = ('Display "field.exr" "openexr" "rgba"\nFormat 128 128 1\nProjection "perspective" "fov" [70]\n'
            f"Rotate -35 1 0 0\nTranslate 0 {-top + 0.5} {h - 0.5}\nWorldBegin\n"
            f'LightSource "pointlight" 1 "intensity" [{20 * h}] "from" [0 {top - 1} 0]\nSurface "matte"\n')
    for wall in walls:
        text += f'Polygon "P" [{" ".join(map(str, wall))}]\n'
    for k in range(archives):
        i, j = k % side, k // side
        x, z = 2 * (i - side // 2) + 1, 2 * (j - side // 2) + 1
        inside = abs(x) + 1 < half and abs(z) + 1 < half
        # The room's walls stand between rows: those of the field give way.
        x, z = (v if inside else v + math.copysign(2, v) for v in (x, z))
        if only and not inside:
            continue
        text += (f"AttributeBegin Translate {x:g} 0 {z:g} Rotate {90 * (k % 4)} 0 1 0 "
                 f'Procedural "DelayedReadArchive" ["a{k % files}.rib"] [-1 1 -1 1 -1 1] AttributeEnd\n')
    return text + "WorldEnd\n"


def run(patina, rib, folder, mode, threads):
    """Wall and CPU seconds, megabytes at most, and statistics of a render."""
    stats = os.path.join(folder, "stats.json")
    command = [patina, "--quiet", "--mode", mode, "--samples", "4", "-t", str(threads), "--stats", stats, rib]
    start = time.monotonic()
    process = subprocess.Popen(command, cwd=folder)
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.monotonic() - start
    if status != 0:
        raise SystemExit(f"{' '.join(command)} failed")
    with open(stats, encoding="utf-8") as file:
        return wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, json.load(file)


def main():
    """Runs the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--patina", default="build/release/bin/patina")
    parser.add_argument("--archives", type=int, default=10000)
    parser.add_argument("--files", type=int, default=100, help="different archive files")
    parser.add_argument("--content", choices=["mesh", "spheres"], default="mesh")
    parser.add_argument("--mode", default="radiosity")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--repeat", type=int, default=5, help="renders of each, by turns; medians count")
    options = parser.parse_args()
    patina = os.path.abspath(options.patina)
    side = math.isqrt(options.archives - 1) + 1
    with tempfile.TemporaryDirectory() as folder:
        for k in range(options.files):
            with open(os.path.join(folder, f"a{k}.rib"), "w", encoding="utf-8") as file:
                file.write({"mesh": mesh, "spheres": spheres}[options.content](k))
        ribs = {}
        for name, only in (("field", False), ("part", True)):
            ribs[name] = os.path.join(folder, name + ".rib")
            with open(ribs[name], "w", encoding="utf-8") as file:
                file.write(scene(options.archives, options.files, side, only))
        runs = {name: [] for name in ribs}
        for _ in range(options.repeat):
            for name, rib in ribs.items():
                runs[name].append(run(patina, rib, folder, options.mode, options.threads))
        print(f"{options.archives} archives of {options.files} files ({options.content}), mode {options.mode}, "
              f"medians of {options.repeat} renders")
        results = {name: [statistics.median(r[k] for r in of) for k in range(3)] for name, of in runs.items()}
        for name, (wall, cpu, megabytes) in results.items():
            counters = runs[name][-1][3]
            delayed, geometry = counters["Delayed archives"], counters["Geometry"]
            shown = {key: geometry.get(key, 0) for key in
                     ("primitives", "surfaces made", "units", "units tessellated", "placements diced")}
            print(f"{name:6} wall {wall:.3f} s, CPU {cpu:.3f} s, {megabytes:.1f} MB; archives asked for "
                  f"{delayed['requests']}, read {delayed['read']} ({delayed['bytes read'] / 1e6:.2f} MB); "
                  + ", ".join(f"{key} {value:g}" for key, value in shown.items()))
        ratios = [a / b for a, b in zip(results["field"], results["part"])]
        print("field/part: wall {:.2f}, CPU {:.2f}, memory {:.2f}".format(*ratios))


if __name__ == "__main__":
    main()
