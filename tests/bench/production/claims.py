#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the scenes of this folder small, renders them in a few pixels, and checks by the statistics that they hold what they
are there for, and that nothing is said of their RIB. Exit status 1 if not. The test bench.production_scenes."""
import argparse
import os
import subprocess
import sys
import tempfile

from runs import count, default_patina, render, shader_points

HERE = os.path.dirname(os.path.abspath(__file__))
# Lights; least numbers of primitives, displaced surfaces, instances, moving placements, and shaders that must have been run.
CLAIMS = {
    "exterior": (2, 100, 60, 150, 20, ("production radiosity", "production view", "leaf radiosity", "displace displacement",
                                      "dented displacement", "distantlight light", "envlight light")),
    "interior": (20, 900, 500, 0, 10, ("production radiosity", "production view", "displace displacement", "dented displacement",
                                       "spotlight light", "arealight light")),
    "workshop": (20, 120, 40, 0, 3, ("production radiosity", "production view", "displace displacement", "dielectric view",
                                     "conductor view", "spotlight light", "arealight light")),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--patina", default=default_patina())
    args = parser.parse_args()
    wrong = []
    for scene, (lights, primitives, displaced, instances, moving, shaders) in CLAIMS.items():
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, "-B", os.path.join(HERE, scene, "make.py"), folder, "--density", "0.1", "--texture-size", "64"],
                           check=True)
            rib = os.path.join(folder, "scene.rib")
            with open(rib, encoding="ascii") as file:
                text = file.read()
            found = text.count('LightSource "')  # AreaLightSource among them
            if found != lights:
                wrong.append(f"{scene}: {found} lights, not {lights}")
            run = render(os.path.abspath(args.patina), rib, ["--mode", "path", "--res", "48x27", "--samples", 1, "-t", 1, "-o", "p.exr"],
                         check=False)
            if run["status"] != 0 or run["messages"].strip():
                wrong.append(f"{scene}: status {run['status']}: {run['messages'].strip()}")
            stats = run["stats"]
            for least, names in ((primitives, ("Geometry", "primitives")), (displaced, ("Displacement", "surfaces")),
                                 (instances, ("Geometry", "instances")), (moving, ("Motion", "moving placements")),
                                 (5, ("Textures", "made"))):
                if count(stats, *names) < least:
                    wrong.append(f"{scene}: {' '.join(names)} {count(stats, *names):g}, fewer than {least}")
            if count(stats, "Displacement", "surfaces without a bound"):
                wrong.append(f"{scene}: displaced surfaces without a bound")
            by_shader = shader_points(stats)[1]
            wrong += [f"{scene}: no points of {shader}" for shader in shaders if not by_shader.get(shader)]
    for message in wrong:
        print(message, file=sys.stderr)
    raise SystemExit(1 if wrong else 0)


if __name__ == "__main__":
    main()
