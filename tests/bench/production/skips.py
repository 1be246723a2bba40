#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Unused is unpaid: pairs of scenes with and without a feature. In the one without all counters of the feature are zero, in the
one with it they are not, so that the counters do count; where a scene can have the feature but make nothing of it (a light
that is off, a displacement of no height, an archive that no ray meets) the one without is such a scene.

    skips.py --counters            # the counters only: exit status 1 if one is wrong (this is the test bench.skips)
    skips.py -o skips.md           # also medians of wall time and peak memory, and what starting takes
"""
import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time

from runs import default_patina, render

# Name, what the scene without has, what the one with has, counters (a * stands for all names).
# Of each: requests before the camera, in the world, and arguments.
PLAIN = ("", "", [])
LEAF = 'Surface "cutout" "frequency" [6]'
PAIRS = [
    ("displacement", ("", 'Displacement "noisebump" "Km" [0]', []), ("", 'Displacement "noisebump"', []),
     ["Displacement/surfaces", "Displacement/vertices", "Shaders/noisebump/displacement/points"]),
    ("textures", ("", 'Surface "paintedplastic"', []), ("", 'Surface "paintedplastic" "texturename" ["t.ppm"]', []),
     ["Textures/texture systems started", "Textures/files opened", "Textures/look-ups"]),
    ("MakeTexture", PLAIN, ('MakeTexture "t.ppm" "t.tx" "periodic" "periodic" "box" 1 1', "", []), ["Textures/made"]),
    ("motion of transformations", ("Shutter 0 1", "", []),
     ("Shutter 0 1", "MotionBegin [0 1] Translate 0 0 0 Translate 0.2 0 0 MotionEnd", []),
     ["Motion/moving placements", "Motion/time segments of places", "Rays/with a time"]),
    ("motion of shapes", ("Shutter 0 1", "Sphere 0.3 -0.3 0.3 360", []),
     ("Shutter 0 1", "MotionBegin [0 1] Sphere 0.3 -0.3 0.3 360 Sphere 0.5 -0.5 0.5 360 MotionEnd", []),
     ["Motion/deforming surfaces", "Motion/Embree geometries with time steps", "Rays/with a time"]),
    ("opacity", ("", 'Surface "cutout" "radius" [0]', []), ("", LEAF, []),
     ["Shading/opacity look-ups", "Opacity cache/points shaded", "Opacity cache/bytes reserved"]),
    ("OpenColorIO", ("", "", ["-o", "p.tif"]), ("", "", ["-o", "p.png", "--display-view", "ACES sRGB"]),
     ["Film/OpenColorIO views applied"]),
    ("files other than EXR", PLAIN, ("", "", ["-o", "p.png"]), ["Film/image module loads"]),
    ("instances", PLAIN, ("", 'ObjectBegin "a" Sphere 0.3 -0.3 0.3 360 ObjectEnd ObjectInstance "a"', []), ["Geometry/instances"]),
    ("archives", ("", 'AttributeBegin Translate 900 0 0 Procedural "DelayedReadArchive" ["a.rib"] [-1 1 -1 1 -1 1] AttributeEnd', []),
     ("", 'Procedural "DelayedReadArchive" ["a.rib"] [-1 1 -1 1 -1 1]', []), ["Delayed archives/read", "Delayed archives/bytes read"]),
    ("indirect light", ('Attribute "trace" "int maxdiffusedepth" [0]', "", []), PLAIN, ["Radiosity/gather rays"]),
    ("second bounce", ('Attribute "trace" "int maxdiffusedepth" [1]', "", []), ('Attribute "trace" "int maxdiffusedepth" [2]', "", []),
     ["Radiosity cache/*/depth 2/look-ups", "Radiosity cache/*/depth 2/misses"]),
    ("radiosity cache", ("", "", ["--mode", "distribution"]), PLAIN, ["Radiosity cache/bytes reserved", "Radiosity/batches of fills"]),
    ("specular rays", ("", 'Surface "plastic" "Ks" [0]', []), ("", 'Surface "conductor"', []),
     ["Rays/specular", "Shaders/*/view/points"]),
    ("shadows", ('Attribute "light" "string shadows" ["off"] Attribute "trace" "int maxdiffusedepth" [0]', "", []),
     ('Attribute "trace" "int maxdiffusedepth" [0]', "", []), ["Rays/transmission"]),
    ("entry point displacement", ("", 'Displacement "dented" "Km" [0]', []), ("", 'Displacement "dented" "Km" [.1]', []),
     ["Shaders/dented/displacement/calls"]),
    ("entry point view", ("", 'Surface "plastic" "Ks" [0]', []), ("", 'Surface "plastic" "Ks" [.5]', []), ["Shaders/plastic/view/calls"]),
    ("entry point radiosity", ("", 'Surface "conductor"', []), ("", 'Surface "matte"', []), ["Shaders/*/radiosity/calls"]),
    ("entry point light", ("", 'LightSource "pointlight" 2 "intensity" [0]', []),
     ("", 'LightSource "pointlight" 2 "intensity" [1] "from" [0 0 -3]', []), ["Shaders/pointlight/light/calls"]),
    ("custom lobes", ("", 'Surface "plastic"', []), ("", 'Surface "principled" "sheen" [1]', []),
     ["Shaders/custom lobes/evaluations"]),
    ("atmosphere", PLAIN, ("", 'Atmosphere "fog"', []), ["Atmosphere/segments"]),
    ("solids", PLAIN, ("", 'SolidBegin "difference" SolidBegin "primitive" Sphere 0.9 -0.9 0.9 360 SolidEnd '
     'SolidBegin "primitive" Translate 0 0 -.9 Sphere 0.5 -0.5 0.5 360 SolidEnd SolidEnd', []), ["Solids/solids", "Solids/operands"]),
    ("adaptive sampling", PLAIN, ("PixelVariance 0.01", "", ["--samples", "16"]), ["Adaptive sampling/pixels"]),
    ("points", PLAIN, ("", "", ["--mode", "points"]), ["Points/surfels", "Points/rasters drawn"]),
]
LAMPS = {"pointlight": '"from" [0 0 -3]', "spotlight": '"from" [0 0 -3] "to" [0 0 0]', "ieslight": '"from" [0 0 -3] "to" [0 0 0]'}
SKIES = {"distantlight": '"float angle" [1]', "envlight": "", "sunsky": ""}
AREA = ('AttributeBegin AreaLightSource "arealight" 2 Polygon "P" [-1 3 -1  1 3 -1  1 3 1  -1 3 1] AttributeEnd')
PAIRS += [(f"light {name}", ("", f'LightSource "{name}" 2 {values} Illuminate 2 0', []), ("", f'LightSource "{name}" 2 {values}', []),
           [f"Shaders/{name}/light/points"]) for name, values in LAMPS.items()]
PAIRS += [("light arealight", ("", AREA, []), ("", AREA + " Illuminate 2 1", []), ["Shaders/arealight/light/points"])]
# Skies are seen, and how bright they are is measured, whether they illuminate anything or not; but not when they are black.
PAIRS += [(f"light {name}", ("", f'LightSource "{name}" 2 {values} "float intensity" [0]', []), ("", f'LightSource "{name}" 2 {values}', []),
           [f"Shaders/{name}/light/points"]) for name, values in SKIES.items()]


def scene(before, body, lamp):
    """A ball on a floor, under what `body` says."""
    ball = "Sphere 0.8 -0.8 0.8 360\nPolygon \"P\" [-3 -1 3  3 -1 3  3 -1 -2  -3 -1 -2]\n"
    return (f'Format 24 24 1\nProjection "perspective" "fov" [40]\n{before}\nTranslate 0 0 4\nWorldBegin\n'
            f'LightSource "{lamp}" 1 "from" [1 1 -1] "to" [0 0 0]\nSurface "matte"\n{body}\n{ball}WorldEnd\n')


def total(stats, path):
    """The sum of the counters that a path with * names."""
    def add(node, names):
        if not names:
            return node if isinstance(node, (int, float)) else 0
        if not isinstance(node, dict):
            return 0
        return sum(add(child, names[1:]) for key, child in node.items() if names[0] in (key, "*"))
    return add(stats, path.split("/"))


def side(patina, folder, name, what, lamp):
    """One scene of a pair: a function that renders it."""
    before, body, arguments = what
    rib = os.path.join(folder, name.replace(" ", "_") + ".rib")
    with open(rib, "w", encoding="ascii") as file:
        file.write(scene(before, body, lamp))
    output = [] if "-o" in arguments or "Display" in before else ["-o", "p.exr"]
    return lambda: render(patina, rib, ["-t", 1, "--rays", 16, *output, *arguments], folder)


def start_up(patina, folder, repeat):
    """Milliseconds from the start of a process to its end: medians."""
    with open(os.path.join(folder, "empty.rib"), "w", encoding="ascii") as file:
        file.write('Format 64 64 1\nProjection "perspective" "fov" [40]\nWorldBegin\nWorldEnd\n')
    with open(os.path.join(folder, "sphere.rib"), "w", encoding="ascii") as file:
        file.write('Format 64 64 1\nProjection "perspective" "fov" [40]\nTranslate 0 0 4\nWorldBegin\nLightSource "pointlight" 1 '
                   '"from" [2 2 -2] "intensity" [8]\nSurface "matte"\nSphere 1 -1 1 360\nWorldEnd\n')
    commands = {"true": ["/bin/true"], "patina --version": [patina, "--version"],
                "an empty scene, 64x64": [patina, "-q", "-o", "e.exr", "empty.rib"],
                "a sphere, 64x64": [patina, "-q", "-o", "s.exr", "sphere.rib"],
                "a sphere, 64x64, mode direct": [patina, "-q", "--mode", "direct", "-o", "s.exr", "sphere.rib"]}
    times = {name: [] for name in commands}
    for _ in range(repeat):
        for name, command in commands.items():
            begin = time.perf_counter()
            subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            times[name].append(1000 * (time.perf_counter() - begin))
    return {name: (statistics.median(t), min(t)) for name, t in times.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--patina", default=default_patina())
    parser.add_argument("--counters", action="store_true", help="each scene once, counters only")
    parser.add_argument("--only", nargs="+", help="names of features")
    parser.add_argument("--repeat", type=int, default=15)
    parser.add_argument("-o", "--output", help="Markdown")
    args = parser.parse_args()
    patina = os.path.abspath(args.patina)
    wrong, lines = [], []
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "t.ppm"), "wb") as file:
            file.write(b"P6 2 2 255\n" + bytes(range(12)))
        with open(os.path.join(folder, "a.rib"), "w", encoding="ascii") as file:
            file.write("Sphere 0.5 -0.5 0.5 360\n")
        known = [name for name, *_ in PAIRS]
        for name in args.only or ():
            if name not in known:
                parser.error(f"there is no feature {name}; known are {', '.join(known)}")
        for name, without, having, counters in PAIRS:
            if args.only and name not in args.only:
                continue
            lamp = "pointlight" if name == "light distantlight" else "distantlight"
            pair = [side(patina, folder, f"{name} {which}", what, lamp) for which, what in (("without", without), ("with", having))]
            first = [run() for run in pair]
            for counter in counters:
                less, more = (total(run["stats"], counter) for run in first)
                if less != 0:
                    wrong.append(f"{name}: {counter} is {less:g} in the scene without it, not 0")
                if not more > 0:
                    wrong.append(f"{name}: {counter} is {more:g} in the scene with it: it does not count")
            if args.counters:
                continue
            walls, memory = ([], []), ([], [])
            for _ in range(args.repeat):
                for k, run in enumerate(pair):
                    found = run()
                    walls[k].append(1000 * found["wall"])
                    memory[k].append(found["MB"])
            lines.append(f"| {name} | " + " | ".join(f"{statistics.median(x):.1f}" for x in (*walls, *memory)) + " |")
            print(lines[-1], flush=True)
        if not args.counters:
            head = ["| feature | ms without | ms with | MB without | MB with |", "| --- | ---: | ---: | ---: | ---: |"]
            starts = ["", "| process, start to end | median ms | least ms |", "| --- | ---: | ---: |"]
            starts += [f"| {name} | {a:.1f} | {b:.1f} |" for name, (a, b) in start_up(patina, folder, 2 * args.repeat).items()]
            text = "\n".join(head + lines + starts) + "\n"
            if args.output:
                with open(args.output, "w", encoding="utf-8") as file:
                    file.write(text)
            print("\n".join(starts))
    for message in wrong:
        print(message, file=sys.stderr)
    raise SystemExit(1 if wrong else 0)


if __name__ == "__main__":
    main()
