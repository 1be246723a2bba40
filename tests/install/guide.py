# SPDX-License-Identifier: Apache-2.0
"""Follows shaderapi/README.md to the letter: its fenced blocks of `sh` are run in their order in one shell, its files are
written where they stand, and the pictures that come out are judged.

    guide.py GUIDE BUILD-FOLDER WORK-FOLDER

The shell's home is WORK-FOLDER; it begins in a folder that has no more of the sources than build/release.
"""
import itertools
import math
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import zlib


def script_of(markdown):
    """The guide as one shell script. A fence says what is in it: `sh`, or a language and the name of a file."""
    lines = ["set -euxo pipefail"]
    for language, name, text in re.findall(r"^```(\w+)(?: +(\S+))?\n(.*?)^```$", markdown, re.MULTILINE | re.DOTALL):
        if name:
            lines.append(f"cat > {name} <<'END OF FILE'\n{text}END OF FILE")
        elif language == "sh":
            lines.append(text)
    return "\n".join(lines) + "\n"


class Picture:
    """A PNG of 8 bits, with or without alpha, which is left out."""

    def __init__(self, path):
        data = path.read_bytes()
        assert data[:8] == b"\x89PNG\r\n\x1a\n", f"{path} is no PNG"
        at, packed = 8, b""
        while at < len(data):
            size, kind = struct.unpack(">I4s", data[at:at + 8])
            body = data[at + 8:at + 8 + size]
            if kind == b"IHDR":
                self.width, self.height, *form = struct.unpack(">IIBBBBB", body)
                assert form in ([8, 2, 0, 0, 0], [8, 6, 0, 0, 0]), f"{path}: not 8 bits of colour, but {form}"
                n = self.channels = 3 if form[1] == 2 else 4
            elif kind == b"IDAT":
                packed += body
            at += 12 + size
        raw, stride = zlib.decompress(packed), n * self.width
        self.rows = [bytearray(stride)]  # the row above the first
        for y in range(self.height):
            kind, *row = raw[y * (stride + 1):(y + 1) * (stride + 1)]
            above = self.rows[-1]
            for i, value in enumerate(row):  # PNG (2nd edition), section 9
                a, b, c = (row[i - n], above[i], above[i - n]) if i >= n else (0, above[i], 0)
                p = a + b - c
                paeth = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
                row[i] = value + (0, a, b, (a + b) // 2, paeth)[kind] & 255
            self.rows.append(bytearray(row))
        del self.rows[0]

    def __getitem__(self, place):
        x, y = place
        return tuple(self.rows[y][self.channels * x:self.channels * x + 3])

    def mean(self, x0, y0, x1, y1):
        pixels = [self[x, y] for y in range(y0, y1) for x in range(x0, x1)]
        return tuple(sum(channel) / len(pixels) for channel in zip(*pixels))


def srgb(linear):
    """IEC 61966-2-1, 0 to 255."""
    return 255 * (12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055)


def linear(byte):
    """The inverse."""
    value = byte / 255
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def near(found, expected, tolerance, what):
    print(f"{what}: {found}, expected {expected} within {tolerance}")
    assert all(abs(f - e) <= tolerance for f, e in zip(found, expected)), what


def main(guide, build, work):
    shutil.rmtree(work, ignore_errors=True)
    sources = work / "src"
    (sources / "build").mkdir(parents=True)
    (sources / "build" / "release").symlink_to(build)
    script = script_of(guide.read_text(encoding="utf-8"))
    (work / "guide.sh").write_text(script, encoding="utf-8")
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PATINA")}
    environment["HOME"] = str(work)
    subprocess.run(["bash", str(work / "guide.sh")], cwd=sources, env=environment, check=True)

    # The stripes: orange and blue in turn, the light's 1 times the colours of the RIB; 1 is the rounding to 8 bits.
    project = work / "myshaders"
    stripes = Picture(project / "stripes.png")
    for x, color in ((8, (0.8, 0.5, 0.1)), (24, (0.05, 0.1, 0.4)), (40, (0.8, 0.5, 0.1)), (56, (0.05, 0.1, 0.4))):
        near(stripes.mean(x - 4, 8, x + 4, 56), [srgb(c) for c in color], 1, f"stripe at {x}")

    # The material, and what it is without each of its three parts: each must be seen to do something.
    glazed = Picture(project / "glaze.png")

    def without(old, new):
        scene = (project / "glaze.rib").read_text(encoding="utf-8")
        assert scene.count(old) == 1, f"glaze.rib has no {old}"
        (project / "without.rib").write_text(scene.replace(old, new), encoding="utf-8")
        subprocess.run([work / "patina/bin/patina", "--shader-path", "build", "-o", "without.png", "without.rib"],
                       cwd=project, env=environment, check=True)
        return Picture(project / "without.png")

    judge(glazed, without('["tile.exr"]', '[""]'), without('"float height" [0.1]', '"float height" [0]'),
          without('"float gloss" [1]', '"float gloss" [0]'))

    # Plain C: dots and ground in their colours.
    dots = Picture(work / "dots" / "dots.png")
    for x, y in ((16, 16), (48, 16), (16, 48), (48, 48)):
        near(dots.mean(x - 4, y - 4, x + 4, y + 4), [srgb(c) for c in (0.9, 0.2, 0.1)], 1, f"dot at {x}, {y}")
    for x, y in ((32, 16), (16, 32), (32, 32), (48, 32), (32, 48)):
        near(dots.mean(x - 4, y - 4, x + 4, y + 4), [srgb(c) for c in (0.1, 0.3, 0.6)], 1, f"ground at {x}, {y}")


def judge(glazed, plain, smooth, dull):
    """The ball with all of the material, and without its texture, displacement and gloss."""
    # All light is white: without gloss the ball shows the proportions of the tile's colours, whatever light there is.
    for x, y, color in ((80, 75, (0.03, 0.12, 0.5)), (91, 68, (0.75, 0.3, 0.03)), (120, 75, (0.75, 0.7, 0.6))):
        light = [linear(c) for c in dull.mean(x - 1, y - 1, x + 2, y + 2)]
        near([c / max(light) for c in light], [c / max(color) for c in color], 0.02, f"proportions at {x}, {y}")
    # A sphere of radius 1 at a distance of 4.2, seen by a lens of 36 degrees over 180 pixels: a circle of 68 pixels. What
    # is displaced leaves it, by no more than the height of 0.1, that is 7 pixels.
    scale = 90 / math.tan(math.radians(18))
    radius, reach = scale / math.sqrt(4.2 ** 2 - 1), 0.1 * scale / 4.2

    def off(picture):
        seen = [(x, y) for y in range(80) for x in range(picture.width) if max(picture[x, y]) > 8]
        return [max(math.dist((x + 0.5, y + 0.5), (120, 90 - 0.05 * scale / 4.2)) for x, y in row) - radius
                for _, row in itertools.groupby(seen, key=lambda place: place[1])]

    print("the outline lies off the circle's, round:", min(off(smooth)), "to", max(off(smooth)), "displaced:",
          min(off(glazed)), "to", max(off(glazed)), "reach:", reach)
    filtered = 2  # pixels that filtering makes the edge wider, and rounding
    assert max(map(abs, off(smooth))) < filtered, "without displacement the ball is not round"
    assert max(map(abs, off(glazed))) < reach + filtered, "the ball is displaced beyond the bound"
    assert max(off(glazed)) > filtered + 1, "displacement does nothing"
    # The glaze reflects the lamp, white whatever lies beneath. The lamp's 60 times 0.04 would be beyond white if bumps did
    # not show it in parts.
    bright = sum(min(a - b for a, b in zip(glazed[x, y], dull[x, y])) > 40
                 for y in range(glazed.height) for x in range(glazed.width))
    print("pixels of highlights:", bright)
    assert bright > 20, "there are no highlights"
    # Texture: the plain ball is grey.
    assert max(max(plain[x, y]) - min(plain[x, y]) for y in range(40, 80) for x in range(60, 180)) <= 3


if __name__ == "__main__":
    main(*(pathlib.Path(argument).absolute() for argument in sys.argv[1:4]))
