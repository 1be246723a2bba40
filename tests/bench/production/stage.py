# SPDX-License-Identifier: Apache-2.0
"""What the scripts below this folder share: a RIB at film settings, textures made by MakeTexture, the heavy shader, shapes.
Metres; x to the right, y up, z away from the camera."""
import argparse
import contextlib
import math
import os
import sys

import synthesis

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "scenes"))
from ribwriter import Rib, fmt, fractal, smooth_noise  # noqa: E402, F401 (for the scripts)


def arguments(description, default_seed):
    """Folder (made if it is not there), density (1 = as described) and seed."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("folder", help="where scene.rib and its textures are written")
    parser.add_argument("--density", type=float, default=1, help="how many things there are, over the usual number [1]")
    parser.add_argument("--seed", type=int, default=default_seed, help=f"of where and how they are [{default_seed}]")
    parser.add_argument("--texture-size", type=int, default=synthesis.SIZE, help=f"pixels along an edge [{synthesis.SIZE}]")
    args = parser.parse_args()
    if not 16 <= args.texture_size <= 16384:
        parser.error("--texture-size is from 16 to 16384")
    synthesis.SIZE = args.texture_size
    if not 0 < args.density <= 1000:
        parser.error("--density is above 0 and at most 1000")
    os.makedirs(args.folder, exist_ok=True)
    return args


def words(values):
    """Shader parameters: numbers, colours (three numbers) and strings by name."""
    out = []
    for name, value in values.items():
        if isinstance(value, str):
            out.append(f'"string {name}" ["{value}"]')
        elif isinstance(value, (tuple, list)):
            out.append(f'"color {name}" [{fmt(value)}]')
        else:
            out.append(f'"float {name}" [{value:.5g}]')
    return " ".join(out)


class Stage(Rib):
    """A scene as it would be set up for a final frame; `--res`, `--samples` and `--rays` of patina make less of it."""

    def __init__(self, name):
        super().__init__()
        self(f"##Scene {name}")
        self.name = name

    def make_textures(self, folder):
        """MakeTexture for all pictures of the folder: a.png is a.tx to shaders."""
        for name in sorted(os.listdir(folder)):
            if name.endswith(".png"):
                self(f'MakeTexture "{name}" "{name[:-4]}.tx" "periodic" "periodic" "gaussian" 2 2')

    def film(self, fov, eye, at, moved, bounces, turns):
        """Up to WorldBegin; looks from `eye` at `at`, and moves by `moved` (metres) while the shutter is open. `fov` in
        degrees along y; diffuse bounces and specular turns that are followed. Without caustics, as films were made
        with this cache: diffuse rays see what surfaces scatter diffusely."""
        d = [a - e for a, e in zip(at, eye)]
        yaw = math.degrees(math.atan2(d[0], d[2]))
        pitch = math.degrees(math.atan2(d[1], math.hypot(d[0], d[2])))
        self(f'Display "{self.name}.exr" "openexr" "rgb"', "Format 1920 1080 1", 'PixelFilter "gaussian" 2 2',
             "PixelSamples 8 8", "ShadingRate 1", "Shutter 0 1",
             'Option "limits" "int radiositycachememory" [262144] "int opacitycachememory" [262144]',
             'Option "trace" "int allowcaustics" [0]',
             f'Attribute "trace" "int maxdiffusedepth" [{bounces}] "int maxspeculardepth" [{turns}]',
             f'Projection "perspective" "float fov" [{fov}]', f"Rotate {pitch:.5g} 1 0 0", f"Rotate {-yaw:.5g} 0 1 0",
             "MotionBegin [0 1]", f"Translate {fmt(-e for e in eye)}",
             f"Translate {fmt(-e - m for e, m in zip(eye, moved))}", "MotionEnd", "WorldBegin")

    def shader(self, kind, name, **values):
        """In a shader space with z up."""
        self("TransformBegin", "Rotate -90 1 0 0", f'{kind} "{name}" {words(values)}', "TransformEnd")

    def production(self, **values):
        self.shader("Surface", "production", **values)

    def displace(self, texture, height, middle=0.5):
        """By a texture made by make_textures(): `height` metres from its darkest to its brightest."""
        reach = height * max(middle, 1 - middle)
        self(f'Attribute "displacementbound" "float sphere" [{reach:.5g}]',
             f'Displacement "displace" "float Km" [{height:.5g}] "float middle" [{middle}] "string texturename" ["{texture}"]')

    def dents(self, depth, frequency):
        self(f'Attribute "displacementbound" "float sphere" [{depth:.5g}]',
             f'Displacement "dented" "float Km" [{depth:.5g}] "float frequency" [{frequency:.5g}]')

    def repeat(self, s, t):
        self(f"TextureCoordinates 0 0 {s:.5g} 0 0 {t:.5g} {s:.5g} {t:.5g}")

    @contextlib.contextmanager
    def moving(self, *requests):
        """AttributeBegin with the requests as keys at equal times from the shutter's opening to its closing."""
        times = " ".join(f"{k / (len(requests) - 1):.4g}" for k in range(len(requests)))
        self("AttributeBegin", f"MotionBegin [{times}]", *requests, "MotionEnd")
        yield
        self("AttributeEnd")

    def bulb(self, place, radius, radiance):
        """A ball that is a light."""
        self.lights += 1
        self("AttributeBegin", 'Surface "matte" "float Kd" [0] "float Ka" [0]',
             f'AreaLightSource "arealight" "l{self.lights}" "float intensity" [1] "color lightcolor" [{fmt(radiance)}]',
             f"Translate {fmt(place)}", f"Sphere {radius} {-radius} {radius} 360", "AttributeEnd",
             f'Illuminate "l{self.lights}" 1')

    def spot(self, place, at, intensity, color, cone, soft=0.4):
        self.light("spotlight", f'"float intensity" [{intensity:.5g}] "color lightcolor" [{fmt(color)}] '
                   f'"point from" [{fmt(place)}] "point to" [{fmt(at)}] "float coneangle" [{cone}] '
                   f'"float conedeltaangle" [{cone * soft:.4g}] "float beamdistribution" [2]')

    def sheet(self, a, b, c, d, repeat=(1, 1)):
        """A bilinear patch, as quad() goes: s from a to b, t from a to d."""
        self.repeat(*repeat)
        self(f'Patch "bilinear" "P" [{fmt((*a, *b, *d, *c))}]')

    def bezier(self, points, requests=()):
        """A bicubic patch of 4 x 4 points, u fastest."""
        self('Basis "bezier" 3 "bezier" 3', *requests, f'Patch "bicubic" "P" [{fmt(v for p in points for v in p)}]')

    def nurbs_lathe(self, profile):
        """An exact surface of revolution about y: profile of (radius, y), from below."""
        h = math.sqrt(0.5)
        ring = [(1, 0, 1), (1, -1, h), (0, -1, 1), (-1, -1, h), (-1, 0, 1), (-1, 1, h), (0, 1, 1), (1, 1, h), (1, 0, 1)]
        n, order = len(profile), min(4, len(profile))
        v = [0] * order + [k / (n - order + 1) for k in range(1, n - order + 1)] + [1] * order
        points = [c for r, y in profile for x, z, w in ring for c in (x * r * w, y * w, z * r * w, w)]
        self(f"NuPatch 9 3 [0 0 0 .25 .25 .5 .5 .75 .75 1 1 1] 0 1 {n} {order} [{fmt(v)}] 0 1 " f'"Pw" [{fmt(points)}]')

    def tube(self, path, radii, n=8, repeat=None):
        """A subdivision surface along points; its ends are closed to a point."""
        frames, u = [], None
        for k, p in enumerate(path):
            a, b = path[max(k - 1, 0)], path[min(k + 1, len(path) - 1)]
            d = _unit([y - x for x, y in zip(a, b)])
            side = u if u else ((1, 0, 0) if abs(d[0]) < 0.7 else (0, 0, 1))
            u = _unit([s - sum(x * y for x, y in zip(side, d)) * c for s, c in zip(side, d)])
            frames.append((p, u, _cross(d, u)))
        radii = [max(r, 1e-4) for r in radii]
        frames = [frames[0], *frames, frames[-1]]
        radii = [1e-4, *radii, 1e-4]
        points = [tuple(p[c] + r * (math.cos(2 * math.pi * i / n) * u[c] + math.sin(2 * math.pi * i / n) * v[c])
                        for c in range(3)) for (p, u, v), r in zip(frames, radii) for i in range(n)]
        rows = len(frames)
        st = None
        if repeat:  # forth and back around, as the ring has no seam
            st = [(repeat[0] * 2 * min(i, n - i) / n, repeat[1] * j / (rows - 1)) for j in range(rows) for i in range(n)]
        self.mesh(points, [(j * n + i, j * n + (i + 1) % n, (j + 1) * n + (i + 1) % n, (j + 1) * n + i)
                           for j in range(rows - 1) for i in range(n)], st)

    def ball(self, radius, st_repeat=(2, 1)):
        """A NURBS ball; s goes around it once."""
        a = [math.pi * (k / 8 - 0.5) for k in range(9)]
        self.repeat(*st_repeat)
        self.nurbs_lathe([(max(radius * math.cos(x), 1e-4), radius * math.sin(x)) for x in a])


def _unit(v):
    size = math.sqrt(sum(c * c for c in v)) or 1
    return [c / size for c in v]


def _cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
