# SPDX-License-Identifier: Apache-2.0
"""Textures made of noise, for the scripts below this folder: square arrays of numpy that repeat without a seam. Row 0 is
t = 0. Numbers come from RandomState, whose sequences never change: the same bytes each time."""
import os
import struct
import zlib

import numpy as np

SIZE = 1024  # pixels along an edge; stage.arguments() sets it


def lattice(size, frequency, seed):
    """Value noise in [0, 1] with frequency = (along s, along t) lattice points."""
    fx, fy = frequency
    values = np.random.RandomState(seed * 7919 + fx * 31 + fy).random_sample((fy, fx)).astype(np.float32)

    def spans(f):
        x = np.arange(size, dtype=np.float32) * (f / size)
        i = x.astype(int)
        u = x - i
        return i % f, (i + 1) % f, u * u * (3 - 2 * u)

    a, b, u = spans(fx)
    rows = values[:, a] * (1 - u) + values[:, b] * u
    a, b, v = spans(fy)
    return rows[a] * (1 - v)[:, None] + rows[b] * v[:, None]


def fbm(size, frequency, octaves, seed, gain=0.5):
    """Octaves of lattice() in [0, 1]; `frequency` of the first one, a number or one along s and one along t."""
    fx, fy = frequency if isinstance(frequency, tuple) else (frequency, frequency)
    total, weight, most = 0, 1, 0
    for k in range(octaves):
        if k and max(fx, fy) << k > size:
            break
        total = total + weight * lattice(size, (fx << k, fy << k), seed + k)
        most += weight
        weight *= gain
    return total / most


def contrast(x, low, high):
    """From 0 at `low` to 1 at `high`, smoothly."""
    x = np.clip((x - low) / (high - low), 0, 1)
    return x * x * (3 - 2 * x)


def coordinates(size):
    """s, t at the middles of pixels."""
    x = (np.arange(size, dtype=np.float32) + 0.5) / size
    return np.broadcast_to(x, (size, size)), np.broadcast_to(x[:, None], (size, size))


def cells(size, columns, rows, seed, jitter=0.85):
    """Worley's cells: distance to the nearest point, to the second nearest (1 = a column's width), the nearest one's
    random number."""
    rng = np.random.RandomState(seed)
    px, py = (0.5 + jitter * (rng.random_sample((2, rows, columns)) - 0.5)).astype(np.float32)
    own = rng.random_sample((rows, columns)).astype(np.float32)
    s, t = coordinates(size)
    x, y = s * columns, t * rows
    i, j = x.astype(int), y.astype(int)
    first, second = np.full((size, size), 9, np.float32), np.full((size, size), 9, np.float32)
    number = np.zeros((size, size), np.float32)
    for dj in (-1, 0, 1):
        for di in (-1, 0, 1):
            a, b = (j + dj) % rows, (i + di) % columns
            d = np.hypot(i + di + px[a, b] - x, j + dj + py[a, b] - y)
            nearer = d < first
            second = np.where(nearer, first, np.minimum(second, d))
            number = np.where(nearer, own[a, b], number)
            first = np.where(nearer, d, first)
    return first, second, number


def courses(size, columns, rows, seed, wobble=0.0, shift=0.5):
    """A running bond: distance from the nearest joint (1 = the height of a course), each stone's random number."""
    s, t = coordinates(size)
    if wobble:
        s = s + wobble / columns * (fbm(size, 4 * columns, 3, seed + 50) - 0.5)
        t = t + wobble / rows * (fbm(size, 4 * columns, 3, seed + 60) - 0.5)
    y = t * rows
    row = np.floor(y).astype(int) % rows
    x = s * columns + shift * (row % 2)
    column = np.floor(x).astype(int) % columns
    u, v = x - np.floor(x), y - np.floor(y)
    edge = np.minimum(np.minimum(u, 1 - u) * (rows / columns), np.minimum(v, 1 - v))
    own = np.random.RandomState(seed).random_sample((rows, columns)).astype(np.float32)
    return edge, own[row, column]


def blend(a, b, w):
    """Between colours (or pictures) a and b: w per pixel."""
    a, b = np.asarray(a, np.float32), np.asarray(b, np.float32)
    return a + (b - a) * w[..., None]


def shade(color, tone):
    return np.asarray(color, np.float32) * tone[..., None]


def save_png(path, pixels):
    """uint8 or uint16 with 1, 3 or 4 channels: height x width (x channels)."""
    pixels = pixels[..., None] if pixels.ndim == 2 else pixels
    height, width, channels = pixels.shape
    deep = pixels.dtype == np.uint16
    rows = pixels.astype(">u2" if deep else np.uint8).tobytes()
    stride = len(rows) // height
    data = b"".join(b"\0" + rows[k * stride:(k + 1) * stride] for k in range(height))

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = struct.pack(">IIBBBBB", width, height, 16 if deep else 8, {1: 0, 3: 2, 4: 6}[channels], 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(data, 1)) +
                   chunk(b"IEND", b""))


def save_color(folder, name, pixels):
    """Linear colours in [0, 1] as an sRGB PNG; a fourth channel stays as it is."""
    x = np.clip(pixels, 0, 1)
    x = np.concatenate([np.where(x[..., :3] < 0.0031308, 12.92 * x[..., :3], 1.055 * x[..., :3] ** (1 / 2.4) - 0.055),
                        x[..., 3:]], axis=-1)
    save_png(os.path.join(folder, name), np.round(255 * x).astype(np.uint8))


def save_data(folder, name, values):
    """Heights or masks in [0, 1], 16 bits: eight would make steps."""
    save_png(os.path.join(folder, name), np.round(65535 * np.clip(values, 0, 1)).astype(np.uint16))


def save_hdr(folder, name, pixels):
    """Radiance's RGBE, not compressed."""
    most = np.maximum(pixels.max(axis=-1), 1e-30)
    exponent = np.floor(np.log2(most)).astype(int) + 1
    scaled = pixels * (256 / np.exp2(exponent))[..., None]
    data = np.concatenate([np.clip(scaled, 0, 255).astype(np.uint8), (exponent + 128).astype(np.uint8)[..., None]], axis=-1)
    with open(os.path.join(folder, name), "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n")
        file.write(f"-Y {pixels.shape[0]} +X {pixels.shape[1]}\n".encode())
        file.write(data.tobytes())


def save_wood(folder, name, seed, light, dark, planks=6):
    """Planks along s: name.png, name_height.png."""
    size = SIZE
    s, t = coordinates(size)
    row = np.floor(t * planks)
    v = t * planks - row
    own = np.random.RandomState(seed).random_sample(planks).astype(np.float32)[row.astype(int)]
    grain = fbm(size, (4, 64), 4, seed + 1)
    rings = 0.5 + 0.5 * np.sin(40 * (t * planks + 0.35 * fbm(size, (3, 8), 4, seed + 2) + 3 * own))
    joint = contrast(np.minimum(v, 1 - v), 0.015, 0.05)
    tone = (0.75 + 0.35 * own) * (0.55 + 0.45 * joint)
    save_color(folder, name + ".png", blend(dark, light, 0.25 + 0.45 * grain + 0.3 * rings) * tone[..., None])
    save_data(folder, name + "_height.png", joint * (0.55 + 0.3 * grain + 0.1 * rings + 0.05 * own))


def save_mottled(folder, name, seed, first, second, frequency=6):
    """Clouds and specks of two colours, for what has no texture of its own: name.png, name_height.png."""
    size = SIZE
    clouds, specks = fbm(size, frequency, 7, seed), fbm(size, 16 * frequency, 3, seed + 20)
    save_color(folder, name + ".png", blend(first, second, contrast(0.75 * clouds + 0.25 * specks, 0.35, 0.65)))
    save_data(folder, name + "_height.png", 0.7 * clouds + 0.3 * specks)


def save_weave(folder, name, seed, colors, threads=48):
    """Cloth of crossing threads in stripes of colours."""
    size = SIZE
    s, t = coordinates(size)
    over = (np.floor(s * threads) + np.floor(t * threads)) % 2
    along, across = np.where(over > 0, t, s), np.where(over > 0, s, t)
    profile = np.abs(np.sin(np.pi * threads * across)) * (0.5 + 0.5 * np.abs(np.sin(np.pi * threads * along)))
    stripe = (np.floor(np.where(over > 0, s, t) * threads / 6) % len(colors)).astype(int)
    tone = (0.45 + 0.55 * profile) * (0.8 + 0.4 * fbm(size, 8, 5, seed))
    save_color(folder, name + ".png", np.asarray(colors, np.float32)[stripe] * tone[..., None])
    save_data(folder, name + "_height.png", 0.8 * profile + 0.2 * fbm(size, 6, 4, seed + 9))
