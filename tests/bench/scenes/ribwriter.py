# SPDX-License-Identifier: Apache-2.0
"""What the scripts beside this file write scenes with. Metres; x to the right, y up, z away from the camera. Every
script is called with the folder to write to, where scene.rib and the textures it names then lie side by side; the
same bytes come out each time."""
import contextlib
import math
import os
import sys


def fmt(values):
    return " ".join(f"{v:.5g}" for v in values)


class Rib:
    """Lines of a RIB. Points are (x, y, z)."""

    def __init__(self):
        self.lines = ["##RenderMan RIB-Structure 1.1", "version 3.04"]
        self.lights = 0

    def __call__(self, *lines):
        self.lines.extend(lines)

    def save(self, folder, name="scene.rib"):
        with open(os.path.join(folder, name), "w", encoding="ascii", newline="\n") as file:
            file.write("\n".join(self.lines) + "\n")

    @contextlib.contextmanager
    def block(self, *lines):
        """AttributeBegin ... AttributeEnd."""
        self("AttributeBegin", *lines)
        yield
        self("AttributeEnd")

    @contextlib.contextmanager
    def object(self, handle):
        self(f'ObjectBegin "{handle}"')
        yield
        self("ObjectEnd")

    def camera(self, name, size, fov, eye, at):
        """Up to WorldBegin; looks from `eye` at `at`, y stays up. `fov` in degrees."""
        d = [a - e for a, e in zip(at, eye)]
        yaw = math.degrees(math.atan2(d[0], d[2]))
        pitch = math.degrees(math.atan2(d[1], math.hypot(d[0], d[2])))
        self(f'Display "{name}.exr" "openexr" "rgb"', f"Format {size[0]} {size[1]} 1", 'PixelFilter "box" 1 1',
             "PixelSamples 4 4", "ShadingRate 1", f'Projection "perspective" "float fov" [{fov}]',
             f"Rotate {pitch:.5g} 1 0 0", f"Rotate {-yaw:.5g} 0 1 0", f"Translate {fmt(-e for e in eye)}", "WorldBegin")

    def light(self, shader, parameters):
        self.lights += 1
        self(f'LightSource "{shader}" "l{self.lights}" {parameters}')

    def panel(self, x0, x1, y, z0, z1, radiance):
        """A rectangle that lights what is below it."""
        self.lights += 1
        self("AttributeBegin", 'Surface "matte" "float Kd" [0] "float Ka" [0]',
             f'AreaLightSource "arealight" "l{self.lights}" "float intensity" [1] "color lightcolor" [{fmt(radiance)}]',
             f'Polygon "P" [{fmt((x0, y, z0, x1, y, z0, x1, y, z1, x0, y, z1))}]', "AttributeEnd",
             f'Illuminate "l{self.lights}" 1')

    def soft_box(self, place, at, width, height, radiance):
        """A rectangle about `place` that lights what lies towards `at`; its width is level."""
        d = [b - a for a, b in zip(place, at)]
        size = math.sqrt(sum(c * c for c in d))
        d = [c / size for c in d]
        level = math.hypot(d[0], d[2])
        u = (d[2] / level, 0, -d[0] / level)
        v = (d[1] * u[2] - d[2] * u[1], d[2] * u[0] - d[0] * u[2], d[0] * u[1] - d[1] * u[0])
        corners = [[p + a * width / 2 * x + b * height / 2 * y for p, x, y in zip(place, u, v)]
                   for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        self.lights += 1
        self("AttributeBegin", 'Surface "matte" "float Kd" [0] "float Ka" [0]',
             f'AreaLightSource "arealight" "l{self.lights}" "float intensity" [1] "color lightcolor" [{fmt(radiance)}]',
             f'Polygon "P" [{fmt(c for p in corners for c in p)}]', "AttributeEnd", f'Illuminate "l{self.lights}" 1')

    def quad(self, a, b, c, d, repeat=(1, 1)):
        """s from a to b, t from d to a: the top row of a texture lies at t = 0."""
        s, t = repeat
        self(f'Polygon "P" [{fmt((*a, *b, *c, *d))}] "st" [{fmt((0, 0, s, 0, s, t, 0, t))}]')

    def box(self, x0, x1, y0, y1, z0, z1):
        p = [(x, y, z) for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)]
        self("PointsPolygons [4 4 4 4 4 4] [0 2 3 1 4 5 7 6 0 1 5 4 2 6 7 3 0 4 6 2 1 3 7 5] "
             f'"P" [{fmt(v for q in p for v in q)}]')

    def mesh(self, points, faces, st=None, scheme="catmull-clark"):
        """A subdivision mesh with edges kept; `st` per point."""
        self(f'SubdivisionMesh "{scheme}" [{" ".join(str(len(f)) for f in faces)}] '
             f'[{" ".join(str(i) for f in faces for i in f)}] ["interpolateboundary"] [0 0] [] [] '
             f'"P" [{fmt(v for p in points for v in p)}]' +
             (f' "vertex float[2] st" [{fmt(v for p in st for v in p)}]' if st else ""))

    def grid(self, nu, nv, point, repeat=(1, 1)):
        """A mesh of nu x nv faces over the unit square: point(u, v)."""
        uv = [(i / nu, j / nv) for j in range(nv + 1) for i in range(nu + 1)]
        at = lambda i, j: j * (nu + 1) + i
        self.mesh([point(u, v) for u, v in uv],
                  [(at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)) for j in range(nv) for i in range(nu)],
                  [(u * repeat[0], v * repeat[1]) for u, v in uv])

    def lathe(self, profile, n=16, repeat=None):
        """Profile of (radius, y), from below, turned about y; a closed ring of n faces, with st if `repeat`."""
        rows = len(profile)
        points = [(r * math.cos(2 * math.pi * i / n), y, r * math.sin(2 * math.pi * i / n))
                  for r, y in profile for i in range(n)]
        faces = [(j * n + i, (j + 1) * n + i, (j + 1) * n + (i + 1) % n, j * n + (i + 1) % n)
                 for j in range(rows - 1) for i in range(n)]
        st = None
        if repeat:  # forth and back around, as the ring has no seam
            st = [(repeat[0] * 2 * min(i, n - i) / n, repeat[1] * (1 - j / (rows - 1)))
                  for j in range(rows) for i in range(n)]
        self.mesh(points, faces, st)

    def cushion(self, x0, x1, y0, y1, z0, z1, r, puff=0.0):
        """A box with edges rounded by about `r`, whose top and bottom bulge by `puff`."""
        def ticks(a, b):
            return (a, a + r, b - r, b)
        tx, ty, tz = ticks(x0, x1), ticks(y0, y1), ticks(z0, z1)
        index, points = {}, []
        def point(i, j, k):
            if (i, j, k) not in index:
                index[i, j, k] = len(points)
                y = ty[j]
                if i in (1, 2) and k in (1, 2) and j in (0, 3):
                    y += puff if j == 3 else -puff
                points.append((tx[i], y, tz[k]))
            return index[i, j, k]
        faces = []
        for a in range(3):
            for b in range(3):
                c, d = a + 1, b + 1
                for s in (0, 3):
                    loops = (((a, b, s), (a, d, s), (c, d, s), (c, b, s)), ((s, a, b), (s, a, d), (s, c, d), (s, c, b)),
                             ((a, s, b), (c, s, b), (c, s, d), (a, s, d)))
                    for loop in loops:
                        order = loop if s == 0 else loop[::-1]
                        faces.append([point(*p) for p in order])
        self.mesh(points, faces)


def smooth_noise(x, y, seed=0):
    """Value noise in [0, 1] with period 256 along each axis."""
    def lattice(i, j):
        h = (i % 256 * 374761393 + j % 256 * 668265263 + seed * 974711) & 0xffffffff
        h = (h ^ h >> 13) * 1274126177 & 0xffffffff
        return (h ^ h >> 16) / 0xffffffff
    i, j = math.floor(x), math.floor(y)
    u, v = x - i, y - j
    u, v = u * u * (3 - 2 * u), v * v * (3 - 2 * v)
    a = lattice(i, j) * (1 - u) + lattice(i + 1, j) * u
    b = lattice(i, j + 1) * (1 - u) + lattice(i + 1, j + 1) * u
    return a * (1 - v) + b * v


def fractal(x, y, octaves=4, seed=0):
    total = sum(smooth_noise(x * 2**k, y * 2**k, seed + k) / 2**k for k in range(octaves))
    return total / (2 - 2 / 2**octaves)


def texture(folder, name, width, height, color):
    """A PPM of color(s, t) -> (r, g, b), linear, with t = 0 at the top."""
    with open(os.path.join(folder, name), "wb") as file:
        file.write(f"P6 {width} {height} 255\n".encode())
        for j in range(height):
            for i in range(width):
                rgb = color((i + 0.5) / width, (j + 0.5) / height)
                file.write(bytes(max(0, min(255, round(255 * c))) for c in rgb))


def target_folder():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        raise SystemExit(f"usage: {sys.argv[0]} FOLDER")
    os.makedirs(sys.argv[1], exist_ok=True)
    return sys.argv[1]
