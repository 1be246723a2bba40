#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How time and memory grow with lights, instances, micropolygons, bounces, resolution, samples and threads: one SVG each, measured
values as dots and lines, what theory expects dashed. Writes OUT/growth.json and OUT/growth-*.svg; what is measured already is
not measured again.

    growth.py -o OUT                 # ranges that two processors measure in minutes
    growth.py -o OUT --full          # 1 to 1000 lights, to a million instances, to 1e8 micropolygons, 1 to 256 samples
"""
import argparse
import json
import math
import os
import time

from runs import count, default_patina, machine, render, save, shader_points

COLOURS = {"seconds": "#1b6ca8", "memory": "#2e8b57", "other": "#c0392b"}


def room(before="", world="", lights=None):
    """A box of four metres with balls in it, seen from its open side."""
    lights = lights if lights is not None else 'LightSource "pointlight" 1 "intensity" [5] "from" [0 3.4 2]\n'
    walls = ((-2, 0, 4, 2, 0, 4, 2, 0, 0, -2, 0, 0), (-2, 4, 0, 2, 4, 0, 2, 4, 4, -2, 4, 4), (-2, 4, 4, 2, 4, 4, 2, 0, 4, -2, 0, 4),
             (-2, 4, 0, -2, 4, 4, -2, 0, 4, -2, 0, 0), (2, 4, 4, 2, 4, 0, 2, 0, 0, 2, 0, 4))
    text = (f'Projection "perspective" "fov" [50]\n{before}\nTranslate 0 -2 5\nWorldBegin\n{lights}Surface "matte" "Ka" [0]\n'
            'Color [.7 .68 .62]\n')
    text += "".join(f'Polygon "P" [{" ".join(map(str, w))}]\n' for w in walls)
    for k in range(9):
        text += f"AttributeBegin Translate {-1.4 + 1.4 * (k % 3)} {0.5} {0.7 + 1.2 * (k // 3)} Sphere 0.45 -0.45 0.45 360 AttributeEnd\n"
    return text + world + "WorldEnd\n"


def many_lights(n):
    """n small lamps in a jittered grid under the ceiling, together as bright as one."""
    side = math.ceil(math.sqrt(n))
    text = ""
    for k in range(n):
        i, j = k % side, k // side
        x = -1.8 + 3.6 * (i + 0.5 + 0.3 * math.sin(7 * k)) / side
        z = 0.2 + 3.6 * (j + 0.5 + 0.3 * math.cos(5 * k)) / side
        text += f'LightSource "pointlight" {k + 1} "intensity" [{5 / n:.6g}] "from" [{x:.4f} {3.2 + 0.3 * math.sin(3 * k):.4f} {z:.4f}]\n'
    return room(lights=text)


def many_instances(n):
    """n instances of a bumpy mesh of 200 faces on a plain, all sizes such that they cover as much of it."""
    rows, columns = 10, 20
    points = [((1 + .2 * math.sin(5 * a) * math.sin(4 * b)) * math.sin(b) * math.cos(a), -math.cos(b),
               (1 + .2 * math.sin(5 * a) * math.sin(4 * b)) * math.sin(b) * math.sin(a))
              for b in (0.02 + (math.pi - 0.04) * j / rows for j in range(rows + 1)) for a in (2 * math.pi * i / columns for i in range(columns))]
    faces = [(j * columns + i, (j + 1) * columns + i, (j + 1) * columns + (i + 1) % columns, j * columns + (i + 1) % columns)
             for j in range(rows) for i in range(columns)]
    text = ['Projection "perspective" "fov" [50]', "Rotate -24 1 0 0", "Translate 0 -4 5", "WorldBegin",
            'LightSource "distantlight" 1 "from" [1 2 -1] "to" [0 0 0]', 'LightSource "envlight" 2 "intensity" [.4]', 'Surface "matte" "Ka" [0]',
            'ObjectBegin "a"', f'PointsPolygons [{" ".join("4" for _ in faces)}] [{" ".join(str(i) for f in faces for i in f)}] '
            f'"P" [{" ".join(f"{c:.4f}" for p in points for c in p)}]', "ObjectEnd", 'Polygon "P" [-20 0 20  20 0 20  20 0 -6  -20 0 -6]']
    side = math.ceil(math.sqrt(n))
    size = 0.4 * 10 / side
    for k in range(n):
        x, z = -5 + 10 * (k % side + 0.5) / side, -1 + 10 * (k // side + 0.5) / side
        text.append(f'TransformBegin ConcatTransform [{size:.5g} 0 0 0 0 {size:.5g} 0 0 0 0 {size:.5g} 0 {x:.5g} {size:.5g} {z:.5g} 1] '
                    'ObjectInstance "a" TransformEnd')
    return "\n".join(text + ["WorldEnd", ""])


def displaced(n, pixels):
    """A dented wall that fills the picture, of about n micropolygons."""
    return (f'Projection "perspective" "fov" [50]\nShadingRate {pixels / n:.6g}\nTranslate 0 0 4\nWorldBegin\n'
            'LightSource "distantlight" 1 "from" [1 1 -1] "to" [0 0 0]\nSurface "matte" "Ka" [0]\n'
            'Attribute "displacementbound" "float sphere" [.1]\nDisplacement "dented" "Km" [.1] "frequency" [2]\n'
            'Patch "bilinear" "P" [-3 2 0  3 2 0  -3 -2 0  3 -2 0]\nWorldEnd\n')


def per_ray(run):
    """Microseconds of a thread for each ray."""
    s = run["stats"]
    rays = sum(count(s, "Rays", kind) for kind in ("camera", "diffuse", "specular", "transmission"))
    return 1e6 * count(s, "Time of threads", "rays s") / max(rays, 1)


def shading_points(run):
    return max(shader_points(run["stats"])[0].get("radiosity", 0), 1)


def micropolygons(run):
    return max(count(run["stats"], "Displacement", "vertices"), 1)


def flat(x, x0):
    return 1


def linear(x, x0):
    return x / x0


def logarithmic(x, x0):
    return math.log2(x + 1) / math.log2(x0 + 1)


# Name, title, values (small, full), RIB of a value, arguments of a value, third measure (title, function), and what is expected
# of seconds, memory and the third, from the value at which the dashed lines meet the measured ones.
SERIES = [
    ("lights", "lights", ([1, 4, 20, 64, 256, 1000], [1, 2, 4, 8, 20, 32, 64, 128, 256, 512, 1000]), many_lights,
     lambda n: ["--res", "96x64", "--samples", 4, "--rays", 64], ("CPU s for each light", lambda r, n: r["cpu"] / n),
     (logarithmic, flat, lambda x, x0: logarithmic(x, x0) * x0 / x), 20),
    ("instances", "instances", ([1, 10, 100, 1000, 10000, 100000], [1, 10, 100, 1000, 10000, 100000, 1000000]), many_instances,
     lambda n: ["--res", "96x64", "--samples", 4, "--rays", 64], ("microseconds of a thread for each ray", lambda r, n: per_ray(r)),
     (linear, linear, logarithmic), 100),
    ("micropolygons", "micropolygons asked for", ([10**4, 10**5, 10**6], [10**4, 10**5, 10**6, 10**7, 10**8]),
     lambda n: displaced(n, 96 * 64), lambda n: ["--res", "96x64", "--samples", 4, "--rays", 16],
     ("vertices displaced", lambda r, n: micropolygons(r)), (linear, linear, linear), 10**5),
    ("bounces", "diffuse bounces", ([0, 1, 2, 4, 8, 32], [0, 1, 2, 3, 4, 6, 8, 16, 32]),
     lambda n: room(f'Attribute "trace" "int maxdiffusedepth" [{n}]'), lambda n: ["--res", "96x64", "--samples", 4, "--rays", 128],
     ("points shaded", lambda r, n: shading_points(r)), (flat, flat, flat), 4),
    ("resolution", "pixels", ([32 * 32, 64 * 64, 128 * 128, 256 * 256], [32 * 32, 64 * 64, 128 * 128, 256 * 256, 512 * 512, 1024 * 1024]),
     lambda n: room(), lambda n: ["--res", f"{math.isqrt(n)}x{math.isqrt(n)}", "--samples", 4, "--rays", 64],
     ("points shaded", lambda r, n: shading_points(r)), (linear, flat, linear), 64 * 64),
    ("samples", "samples of a pixel", ([1, 4, 16, 64], [1, 4, 16, 64, 256]), lambda n: room(),
     lambda n: ["--res", "96x96", "--samples", n, "--rays", 64], ("points shaded", lambda r, n: shading_points(r)), (linear, flat, flat), 16),
    ("threads", "threads", ([1, 2], [1, 2]), lambda n: room(), lambda n: ["--res", "192x192", "--samples", 16, "--rays", 128, "-t", n],
     ("wall seconds", lambda r, n: r["wall"]), (flat, flat, lambda x, x0: x0 / x), 1),
]


def measured(args, series, data):
    """Values by measure: [(x, y)]."""
    name, _, ranges, rib_of, arguments_of, (_, third), _, _ = series
    points = {"seconds": [], "memory": [], "other": []}
    folder = os.path.abspath(os.path.join(args.output, "growth-scenes"))
    os.makedirs(folder, exist_ok=True)
    for x in ranges[1 if args.full else 0]:
        key = f"{name} {x} {args.threads}"
        if key not in data["runs"]:
            rib = os.path.join(folder, f"{name}-{x}.rib")
            with open(rib, "w", encoding="ascii") as file:
                file.write(rib_of(x))
            print(f"{time.strftime('%H:%M:%S')} {key}", flush=True)
            threads = [] if name == "threads" else ["-t", args.threads]
            data["runs"][key] = render(args.patina, rib, [*arguments_of(x), *threads, "-o", f"{name}-{x}.exr"], folder)
            save(data, os.path.join(args.output, "growth.json"))
            os.remove(rib)
        run = data["runs"][key]
        for measure, y in (("seconds", run["cpu"]), ("memory", run["MB"]), ("other", third(run, x))):
            points[measure].append((x, y))
    return points


def draw(series, points, path):
    """Three panels beside each other, logarithmic both ways; 0 has the place of a half."""
    _, title, _, _, _, (third, _), expected, anchor = series
    names = {"seconds": "CPU seconds", "memory": "peak MB", "other": third}
    wide, high, left, top = 250, 190, 62, 30
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{3 * (wide + left) + 16}" height="{top + high + 48}" font-family="sans-serif" '
           'font-size="11">', '<rect width="100%" height="100%" fill="white"/>']
    place = lambda x: math.log10(x if x > 0 else 0.5)
    for k, (measure, theory) in enumerate(zip(names, expected)):
        dots = [(x, max(y, 1e-9)) for x, y in points[measure]]
        base = dict(dots).get(anchor, dots[0][1])
        start = anchor if anchor in dict(dots) else dots[0][0]
        line = [(x, base * theory(x, start)) for x, _ in dots]
        xs = [place(x) for x, _ in dots]
        ys = [math.log10(y) for _, y in dots + line if y > 0]
        x0, y0 = left + k * (wide + left), top
        low, most = math.floor(min(ys) * 2) / 2, math.ceil(max(ys) * 2 + 1e-9) / 2
        low, most = (low, most) if most > low else (low - 0.5, most + 0.5)
        first, span = min(xs), (max(xs) - min(xs)) or 1
        at = lambda x, y: f"{x0 + wide * (place(x) - first) / span:.1f},{y0 + high * (1 - (min(max(math.log10(y), low), most) - low) / (most - low)):.1f}"
        out.append(f'<rect x="{x0}" y="{y0}" width="{wide}" height="{high}" fill="none" stroke="#999"/>')
        out.append(f'<text x="{x0}" y="{y0 - 8}">{names[measure]}</text>')
        step = 1 if most - low <= 5 else 2
        for tick in range(math.ceil(low), math.floor(most) + 1, step):
            y = y0 + high * (1 - (tick - low) / (most - low))
            out.append(f'<line x1="{x0}" x2="{x0 + wide}" y1="{y:.1f}" y2="{y:.1f}" stroke="#e5e5e5"/>')
            out.append(f'<text x="{x0 - 5}" y="{y + 4:.1f}" text-anchor="end">{10.0 ** tick:g}</text>')
        for x, _ in dots:
            out.append(f'<text x="{at(x, 1).split(",")[0]}" y="{y0 + high + 14}" text-anchor="middle" font-size="9">{short(x)}</text>')
        out.append(f'<polyline points="{" ".join(at(x, y) for x, y in line)}" fill="none" stroke="#888" stroke-dasharray="5 4"/>')
        out.append(f'<polyline points="{" ".join(at(x, y) for x, y in dots)}" fill="none" stroke="{COLOURS[measure]}" stroke-width="1.5"/>')
        for x, y in dots:
            px, py = at(x, y).split(",")
            out.append(f'<circle cx="{px}" cy="{py}" r="2.6" fill="{COLOURS[measure]}"/>')
        out.append(f'<text x="{x0 + wide / 2}" y="{y0 + high + 32}" text-anchor="middle">{title}</text>')
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(out + ["</svg>", ""]))


def short(x):
    return f"{x / 1e6:g}M" if x >= 1e6 else f"{x / 1e3:g}k" if x >= 10000 else f"{x:g}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", default="production-results")
    parser.add_argument("--patina", default=default_patina())
    parser.add_argument("--full", action="store_true")
    parser.add_argument("--threads", type=int, default=1, help="of all series but that of threads")
    parser.add_argument("--only", nargs="+", choices=[s[0] for s in SERIES])
    args = parser.parse_args()
    args.patina = os.path.abspath(args.patina)
    os.makedirs(args.output, exist_ok=True)
    path, data = os.path.join(args.output, "growth.json"), {"runs": {}}
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
    data["machine"] = machine(args.patina)
    print("| series | value | CPU s | peak MB | other |\n| --- | ---: | ---: | ---: | ---: |")
    for series in SERIES:
        if args.only and series[0] not in args.only:
            continue
        points = measured(args, series, data)
        draw(series, points, os.path.join(args.output, f"growth-{series[0]}.svg"))
        for (x, a), (_, b), (_, c) in zip(*points.values()):
            print(f"| {series[0]} | {short(x)} | {a:.3g} | {b:.4g} | {c:.4g} |", flush=True)


if __name__ == "__main__":
    main()
