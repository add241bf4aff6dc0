"""The steps of Loghin (2021) as the article means them, slow and plain: no NumPy in the loops."""

from __future__ import annotations

import math

import numpy as np


def radical_inverse(i: int) -> float:
    """Van der Corput's sequence by reversing 32 bits."""
    return int(f"{i:032b}"[::-1], 2) / 2**32


def samples(n: int, height: int, width: int) -> list[tuple[int, int]]:
    """Steps 3 and 4: pixels of n Hammersley points on the sphere, in the frame of the package."""
    pixels = []
    for i in range(n):
        cosine, phi = 1 - 2 * i / n, 2 * math.pi * radical_inverse(i)
        sine = math.sqrt(max(1 - cosine * cosine, 0))
        x, y, z = sine * math.sin(phi), cosine, -sine * math.cos(phi)
        u = math.atan2(x, -z) / (2 * math.pi) % 1.0
        v = math.atan2(math.hypot(x, z), y) / math.pi
        # The points lie on the very borders of pixels, where rounding would toss a coin.
        row, column = int(v * height + 1e-9), int(u * width + 1e-9)
        pixels.append((min(row, height - 1), min(column, width - 1)))
    return pixels


def brightest_around(luminance, pixel, reach):
    """Step 5: value and place of the maximum of a square window, cut at the image's border."""
    height, width = luminance.shape
    best, place = -math.inf, pixel
    for row in range(max(pixel[0] - reach, 0), min(pixel[0] + reach, height - 1) + 1):
        for column in range(max(pixel[1] - reach, 0), min(pixel[1] + reach, width - 1) + 1):
            if luminance[row, column] > best:
                best, place = luminance[row, column], (row, column)
    return best, place


def suppress(pixels, distance):
    """Step 7: from the brightest on, each survivor takes what is near and not taken yet."""
    label = [-1] * len(pixels)
    for i, (row, column) in enumerate(pixels):
        if label[i] == -1:
            label[i] = i
            for j in range(i + 1, len(pixels)):
                near = math.hypot(pixels[j][0] - row, pixels[j][1] - column) < distance
                if label[j] == -1 and near:
                    label[j] = i
    return label


def line(start, end):
    """Bresenham's line by rounding: half goes forward only on a line in the positive direction."""
    (y0, x0), (y1, x1) = start, end
    rows, columns = y1 - y0, x1 - x0
    along_columns = abs(columns) >= abs(rows)
    length, side = (abs(columns), rows) if along_columns else (abs(rows), columns)
    is_forward = (columns if along_columns else rows) > 0
    pixels = [tuple(start)]
    for step in range(1, length + 1):
        # Distance walked sideways, in 2 length-ths, rounded to whole pixels.
        twice = 2 * abs(side) * step
        whole, rest = divmod(twice, 2 * length)
        moved = whole + (rest > length or (rest == length and is_forward))
        sideways = moved * (1 if side > 0 else -1)
        if along_columns:
            pixels.append((y0 + sideways, x0 + step * (1 if columns > 0 else -1)))
        else:
            pixels.append((y0 + step * (1 if rows > 0 else -1), x0 + sideways))
    return pixels


def is_bright(luminance, start, end, tolerance=0.15, ceiling=1.25):
    """Step 8: the running mean stays close to the start's luminance, or is 1 and more."""
    total = np.float32(0)
    for count, pixel in enumerate(line(start, end)[1:], start=1):
        total += min(luminance[pixel], np.float32(ceiling))
        mean = total / np.float32(count)
        if abs(mean - luminance[tuple(start)]) > np.float32(tolerance) and mean < 1:
            return False
    return True


def merge(luminance, pixels):
    """Step 8: each survivor that is left takes those that a bright line joins to it."""
    label = [-1] * len(pixels)
    for i, start in enumerate(pixels):
        if label[i] == -1:
            label[i] = i
            for j in range(i + 1, len(pixels)):
                if label[j] == -1 and is_bright(luminance, start, pixels[j]):
                    label[j] = i
    return label


def detect(luminance, *, samples_per_pixel=0.006, threshold=0.8, suppression_deg=5.0):
    """All steps: pixels of the samples that passed, their lights, and the lights' mean pixels."""
    height, width = luminance.shape
    reach = int(12 * width / 1024) // 2
    taken = samples(int(samples_per_pixel * width * height), height, width)
    kept = [p for p in taken if brightest_around(luminance, p, reach)[0] > threshold]
    kept.sort(key=lambda pixel: -luminance[pixel])  # stable
    survivor = suppress(kept, suppression_deg * width / 360)
    survivors = sorted(set(survivor))
    merged = merge(luminance, [kept[i] for i in survivors])
    light_of_survivor = {s: survivors[m] for s, m in zip(survivors, merged, strict=True)}
    light = [light_of_survivor[s] for s in survivor]
    means = {}
    for home in sorted(set(light)):
        parts = [s for s in survivors if light_of_survivor[s] == home]
        weights = [float(luminance[kept[s]]) for s in parts]
        means[home] = [
            sum(w * kept[s][axis] for w, s in zip(weights, parts, strict=True)) / sum(weights)
            for axis in (0, 1)
        ]
    return kept, light, means
