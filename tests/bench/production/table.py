#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The paper's table on scenes of our own: the three scenes of this folder with the radiosity cache and without it, at the same
settings, and against path mode at equal error. Writes OUT/table.md, OUT/table.json and the pictures.

    table.py -o OUT                        # small pictures: see --res; what is done already is not done again
    table.py -o OUT --res 480x270 --samples 64 --rays 512 --crop 0.4,0.6,0.4,0.6 --no-path

With: --mode radiosity. Without: --mode distribution, which shades every hit of every gather ray: the surface shader's
radiosity, two lights picked by what they are worth there with a shadow ray each, and one ray on while bounces are left. That is the
cheapest way to do without the cache; shaders that ask all lights at each hit cost more, and so would a cache without room, which
shades all vertices of a level for each ray. At the camera both shade the same micropolygon vertices; the cached mode gathers where
irradiance changes and interpolates between, the other one gathers at each: rays and points of both are in the table.

Where --crop is given (x0,x1,y0,y1) both render that part only, and all ratios are of the same pixels. Needs python3-numpy and
python3-openimageio."""
import argparse
import json
import math
import os
import subprocess
import sys
import time

from runs import count, default_patina, machine, picture, relative_error, render, save, shader_points

HERE = os.path.dirname(os.path.abspath(__file__))
SCENES = ("exterior", "interior", "workshop")
PAPER = {"exterior": (33, "13 million points, 2 lights"), "interior": (41, "64 million points, 20 lights"),
         "workshop": (94, "15 million points, 20 lights")}
PHASES = ("rays", "facets and their BVHs, made on demand", "surface shaders", "lights", "look-ups of radiosity", "look-ups of opacity",
          "waiting for values that other threads make", "everything else")


class Session:
    def __init__(self, args):
        self.args = args
        self.path = os.path.join(args.output, "table.json")
        self.data = {"runs": {}}
        os.makedirs(args.output, exist_ok=True)
        if os.path.exists(self.path):
            with open(self.path, encoding="utf-8") as file:
                self.data = json.load(file)
        self.data["machine"] = machine(args.patina)
        self.data["settings"] = {k: v for k, v in vars(args).items() if k != "patina"}

    def scene(self, name):
        """The RIB, made if it is not there, with its textures."""
        args = self.args
        folder = os.path.abspath(os.path.join(args.output, f"{name}-{args.density:g}-{args.seed}"))
        rib = os.path.join(folder, "scene.rib")
        if not os.path.exists(rib):
            seed = ["--seed", str(args.seed)] if args.seed else []
            subprocess.run([sys.executable, "-B", os.path.join(HERE, name, "make.py"), folder, "--density", str(args.density), *seed], check=True)
        if not os.path.exists(os.path.join(folder, "made")):
            # MakeTexture once, and files into memory: no run pays for it.
            render(args.patina, rib, ["--mode", "direct", "--res", "32x18", "--samples", 1, "-o", "made.exr"])
            open(os.path.join(folder, "made"), "w").close()
        return rib

    def run(self, scene, mode, extra=(), samples=None, seed=None):
        """A run and its picture, or what is known of it."""
        args = self.args
        samples = samples or args.samples
        arguments = ["--mode", mode, "--res", args.res, "--samples", samples, "--rays", args.rays, "-t", args.threads, *extra]
        if args.crop:
            arguments += ["--crop", *args.crop.split(",")]
        if seed is not None:
            arguments += ["--seed", seed]
        key = " ".join(map(str, [scene, args.density, args.seed, *arguments]))
        found = self.data["runs"].get(key)
        if found and (not found.get("ended") or found["wall"] >= 0.9 * args.timeout):
            return found
        name = f"{scene}-{mode}-{samples}" + (f"-{seed}" if seed is not None else "") + (f"-{abs(hash_of(key)) % 10000:04d}") + ".exr"
        path = os.path.abspath(os.path.join(args.output, name))
        print(f"{time.strftime('%H:%M:%S')} {key}", flush=True)
        found = render(args.patina, self.scene(scene), [*arguments, "-o", path], timeout=args.timeout)
        found["picture"] = name
        self.data["runs"][key] = found
        save(self.data, self.path)
        return found

    def picture(self, run):
        return picture(os.path.join(self.args.output, run["picture"]))


def hash_of(text):
    value = 0
    for c in text.encode():
        value = (value * 131 + c) & 0xffffffff
    return value


def number(x):
    if x is None:
        return "-"
    if isinstance(x, str):
        return x
    for size, unit in ((1e9, "G"), (1e6, "M"), (1e4, "k")):
        if abs(x) >= size:
            return f"{x / (size if unit != 'k' else 1e3):.3g}{unit}"
    return f"{x:.4g}"


def thread_seconds(stats):
    """Of all threads, by kind of work."""
    return {name.removesuffix(" s"): value for name, value in stats.get("Time of threads", {}).items()}


def rows_of(run):
    """What one run says of itself, by row of the table."""
    s = run["stats"]
    entries, _ = shader_points(s)
    threads = thread_seconds(s)
    of_rays = {name: count(s, "Radiosity cache", "rays", name) for name in ("found their value", "shaded, as they are too short")}
    met = max(count(s, "Radiosity cache", "rays", "met something"), 1)
    return {
        "wall s": run["wall"], "CPU s": run["cpu"], "peak MB": run["MB"],
        "camera samples": count(s, "Camera", "samples"),
        "micropolygon vertices that the camera asked for": count(s, "Camera", "vertices asked for"),
        "points shaded for parts of pixels": count(s, "Camera", "points shaded for parts of pixels"),
        "gather rays": count(s, "Radiosity", "gather rays"),
        "shader points: radiosity": entries.get("radiosity", 0), "shader points: view": entries.get("view", 0),
        "shader points: light": entries.get("light", 0), "shader points: displacement": entries.get("displacement", 0),
        "rays: camera": count(s, "Rays", "camera"), "rays: diffuse": count(s, "Rays", "diffuse"),
        "rays: specular": count(s, "Rays", "specular"), "rays: shadow": count(s, "Rays", "transmission"),
        "% of the rays that met something: value from the cache": 100 * of_rays["found their value"] / met,
        "%: shaded, shorter than the distance of vertices": 100 * of_rays["shaded, as they are too short"] / met,
        "radiosity cache, MB in memory": count(s, "Radiosity cache", "bytes in memory") / 1048576,
        "thread seconds in rays": threads.get("rays", 0), "thread seconds in surface shaders": threads.get("surface shaders", 0),
    }


def seconds_at(points, error):
    """CPU seconds at which the runs of (error, seconds) reach the error, on the line between logarithms of the two nearest; and
    whether that lies beyond them."""
    points = sorted(points)
    if len(points) < 2 or error <= 0:
        return None, True
    for (e0, t0), (e1, t1) in zip(points, points[1:]):
        if e0 <= error <= e1:
            f = (math.log(error) - math.log(e0)) / (math.log(e1) - math.log(e0)) if e1 > e0 else 0
            return math.exp(math.log(t0) + f * (math.log(t1) - math.log(t0))), False
    (e0, t0), (e1, t1) = points[:2] if error < points[0][0] else points[-2:]
    # Beyond: noise falls with the root of the time.
    e, t = (e0, t0) if error < e0 else (e1, t1)
    return t * e / error, True


def judge(session, scene, cached, uncached):
    """Errors of both against path mode, and path mode's seconds at the same error."""
    args = session.args
    if args.no_path:
        return {}
    halves = [session.run(scene, "path", samples=args.reference, seed=1000 + k) for k in range(2)]
    if any(h.get("ended") for h in halves):
        return {"note": f"path mode did not end within {args.timeout:g} s"}
    a, b = (session.picture(h) for h in halves)
    reference = (a + b) / 2
    noise = relative_error(a, b) / 4  # of the mean of the two
    out = {"reference's noise": noise, "reference's mean": float(reference.mean())}

    def error(run):
        x = session.picture(run)
        return max(relative_error(x, reference) - noise, noise / 20), float(x.mean() / reference.mean() - 1)

    out["cached error"], out["cached mean"] = error(cached)
    if uncached and not uncached.get("ended"):
        out["uncached error"], out["uncached mean"] = error(uncached)
    points = []
    for samples in args.path_samples:
        run = session.run(scene, "path", samples=samples, seed=1)
        if not run.get("ended"):
            points.append((error(run)[0], run["cpu"]))
            out[f"path error at {samples}"], out[f"path seconds at {samples}"] = points[-1]
    out["path seconds"], out["path beyond"] = seconds_at(points, out["cached error"])
    return out


def measure(session, scene):
    cached = session.run(scene, "radiosity")
    uncached = session.run(scene, "distribution")
    known = not uncached.get("ended")
    out = {"cached": rows_of(cached), "uncached": rows_of(uncached) if known else {"CPU s": uncached["cpu"], "wall s": uncached["wall"]},
           "ended": not known, "judged": judge(session, scene, cached, uncached)}
    if known:
        x, y = session.picture(cached), session.picture(uncached)
        out["relMSE"], out["mean"] = relative_error(x, y), float(x.mean() / y.mean() - 1)
    threads = thread_seconds(cached["stats"])
    total = sum(threads.values())
    out["phases"] = {k: v / total for k, v in threads.items()} if total else {}
    out["messages"] = cached.get("messages", "")
    return out


def report(session, results):
    args, lines = session.args, []
    lines += ["# The paper's table on Patina's own scenes", "", "| | |", "| --- | --- |"]
    lines += [f"| {k} | {v} |" for k, v in session.data["machine"].items()]
    part = f", the part {args.crop} of the picture only, for both" if args.crop else ""
    lines += [f"| settings | {args.res}, {args.samples} samples per pixel, {args.rays} rays per gather, {args.threads or 'all'} threads, density "
              f"{args.density:g}{part}; all else as the RIBs have it (motion blur, 2 or 3 diffuse bounces, 256 MB cache) |", "",
              "With: `--mode radiosity`. Without: `--mode distribution`, the same settings, every hit of every ray shaded. The paper's ratios are "
              "of its own scenes at 1920x1080.", ""]
    names = list(results)
    lines += ["| | " + " | ".join(f"{n}: with | without | ratio" for n in names) + " |", "| --- |" + " ---: |" * 3 * len(names)]
    for row in rows_of({"stats": {}, "wall": 0, "cpu": 0, "MB": 0}):
        cells = []
        for n in names:
            a, b = results[n]["cached"].get(row), results[n]["uncached"].get(row)
            ended = ">" if results[n]["ended"] and b is not None else ""
            cells += [number(a), ended + number(b), f"{ended}{b / a:.3g}" if a and b else "-"]
        lines.append(f"| {row} | " + " | ".join(cells) + " |")
    lines += ["", "| | " + " | ".join(names) + " |", "| --- |" + " ---: |" * len(names)]

    def line(title, value):
        lines.append(f"| {title} | " + " | ".join(value(results[n], n) for n in names) + " |")

    def judged(key, form):
        return lambda r, _: form(r["judged"][key]) if r["judged"].get(key) is not None else "-"

    def ratio(r, _):
        return ("more than " if r["ended"] else "") + f"{r['uncached']['CPU s'] / r['cached']['CPU s']:.3g}"

    percent, small = (lambda x: f"{100 * x:+.2f} %"), (lambda x: f"{x:.2e}")
    line("**CPU time without over with**", ratio)
    line("in the paper", lambda r, n: f"{PAPER[n][0]} ({PAPER[n][1]})")
    line("mean of the picture, with against without", lambda r, _: percent(r["mean"]) if "mean" in r else "-")
    line("relMSE between the two, noise of both included", lambda r, _: small(r["relMSE"]) if "relMSE" in r else "-")
    if not args.no_path:
        line("relMSE with, against path mode", judged("cached error", small))
        line("relMSE without, against path mode", judged("uncached error", small))
        line("noise of path mode's reference, taken off", judged("reference's noise", small))
        line("mean with, against path mode", judged("cached mean", percent))
        line("mean without, against path mode", judged("uncached mean", percent))
        line("CPU s of path mode at the error of the cached picture", lambda r, _: "-" if not r["judged"].get("path seconds") else
             ("about " if r["judged"]["path beyond"] else "") + f"{r['judged']['path seconds']:.3g}")
        line("... over that of the cached picture", lambda r, _: "-" if not r["judged"].get("path seconds") else
             f"{r['judged']['path seconds'] / r['cached']['CPU s']:.3g}")
    lines += ["", "Where the threads' time goes with the cache:", "", "| | " + " | ".join(names) + " |", "| --- |" + " ---: |" * len(names)]
    for phase in PHASES:
        if any(phase in results[n]["phases"] for n in names):
            lines.append(f"| {phase} | " + " | ".join(f"{100 * results[n]['phases'].get(phase, 0):.1f} %" for n in names) + " |")
    lines += ["", "Shader points by shader and entry point, with and without:", "", "| | " + " | ".join(f"{n}: with | without" for n in names) + " |",
              "| --- |" + " ---: |" * 2 * len(names)]
    points = {n: [shader_points(session.run(n, mode)["stats"])[1] for mode in ("radiosity", "distribution")] for n in names}
    for shader in sorted({k for both in points.values() for one in both for k in one}):
        lines.append(f"| {shader} | " + " | ".join(number(one.get(shader)) for n in names for one in points[n]) + " |")
    with open(os.path.join(args.output, "table.md"), "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    session.data["results"] = results
    save(session.data, session.path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", default="production-results")
    parser.add_argument("--patina", default=default_patina())
    parser.add_argument("--only", nargs="+", choices=SCENES, default=SCENES)
    parser.add_argument("--res", default="96x54")
    parser.add_argument("--samples", type=int, default=16, help="of a pixel")
    parser.add_argument("--rays", type=int, default=256, help="of a gather; the paper has 256 to 1024")
    parser.add_argument("--density", type=float, default=0.25, help="of the scenes [0.25]")
    parser.add_argument("--seed", type=int, default=0, help="of the scenes; 0: their own")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--crop", help="x0,x1,y0,y1 as fractions: both modes render that part")
    parser.add_argument("--timeout", type=float, default=300, help="seconds after which a render is given up")
    parser.add_argument("--no-path", action="store_true", help="no reference, no path mode")
    parser.add_argument("--reference", type=int, default=128, help="samples of each of the reference's two pictures")
    parser.add_argument("--path-samples", type=int, nargs="+", default=[8, 32])
    args = parser.parse_args()
    args.patina = os.path.abspath(args.patina)
    session = Session(args)
    results = {}
    for scene in args.only:
        if session.run(scene, "radiosity").get("ended"):
            print(f"{scene}: with the cache it did not end within {args.timeout:g} s (--timeout); it is left out", file=sys.stderr)
            continue
        results[scene] = measure(session, scene)
        report(session, results)
    if not results:
        raise SystemExit(1)
    with open(os.path.join(args.output, "table.md"), encoding="utf-8") as file:
        print(file.read())


if __name__ == "__main__":
    main()
