"""The steps of Loghin (2021) as the article means them, slow and plain: no NumPy in the loops."""

from __future__ import annotations

import math

import numpy as np


def reduce_bilinear(luminance, width):
    """Step 1: each new pixel is mixed from the four whose centres are around its own."""
    height = round(len(luminance) * width / luminance.shape[1])
    rows, down = _between(height, len(luminance))
    columns, across = _between(width, luminance.shape[1])
    upper, lower = (luminance[np.minimum(rows + i, len(luminance) - 1)] for i in (0, 1))
    column = (1 - down)[:, None] * upper + down[:, None] * lower
    left, right = (column[:, np.minimum(columns + i, luminance.shape[1] - 1)] for i in (0, 1))
    return (1 - across) * left + across * right


def _between(new, old):
    """The pixel before each new one, and how far that lies towards the next."""
    at = np.clip((np.arange(new) + 0.5) * old / new - 0.5, 0, old - 1)
    before = at.astype(int)
    return before, at - before


def blur(image, sigma):
    """Step 2: a Gaussian out to three standard deviations; columns meet, rows end."""
    reach = math.ceil(3 * sigma)
    offsets = range(-reach, reach + 1)
    weights = [math.exp(-0.5 * (offset / sigma) ** 2) for offset in offsets]
    across = sum(w * np.roll(image, -o, axis=1) for w, o in zip(weights, offsets, strict=True))
    rows = np.arange(len(image))
    down = (across[np.clip(rows + offset, 0, len(image) - 1)] for offset in offsets)
    return sum(w * row for w, row in zip(weights, down, strict=True)) / sum(weights) ** 2


def radical_inverse(i: int) -> float:
    """Van der Corput's sequence by reversing 32 bits."""
    return int(f"{i:032b}"[::-1], 2) / 2**32


def inverse_of_thirds(i: int) -> float:
    """Digits of `i` in base 3, behind the point in reverse order."""
    value, unit = 0.0, 1 / 3
    while i:
        i, digit = divmod(i, 3)
        value, unit = value + digit * unit, unit / 3
    return value


def samples(n: int, height: int, width: int, sampling: str) -> list[tuple[int, int]]:
    """Steps 3 and 4: pixels of n points on the sphere, in the frame of the package."""
    pixels = []
    for i in range(n):
        u, v = i / n, radical_inverse(i)
        if sampling == "halton":
            u, v = radical_inverse(i), inverse_of_thirds(i)
        cosine, phi = 1 - 2 * u, 2 * math.pi * v
        sine = math.sqrt(max(1 - cosine * cosine, 0))
        x, y, z = sine * math.sin(phi), cosine, -sine * math.cos(phi)
        u = math.atan2(x, -z) / (2 * math.pi) % 1.0
        v = math.atan2(math.hypot(x, z), y) / math.pi
        # The points lie on the very borders of pixels, where rounding would toss a coin.
        row, column = int(v * height + 1e-9), int(u * width + 1e-9)
        pixels.append((min(row, height - 1), min(column, width - 1)))
    return pixels


def direction(pixel, height, width):
    """Unit vector towards the centre of a pixel, which may lie between pixels."""
    theta, phi = math.pi * (pixel[0] + 0.5) / height, 2 * math.pi * (pixel[1] + 0.5) / width
    sine = math.sin(theta)
    return sine * math.sin(phi), math.cos(theta), -sine * math.cos(phi)


def columns_around(row, column, reach, height, width, sphere):
    """Columns of one row of a window: cut at the border, or as wide as an angle on the sphere."""
    if not sphere:
        return range(max(column - reach, 0), min(column + reach, width - 1) + 1)
    reach = int(reach / math.sin(math.pi * (row + 0.5) / height))
    if 2 * reach >= width:
        return range(width)
    return [x % width for x in range(column - reach, column + reach + 1)]


def brightest_around(luminance, pixel, reach, sphere=False):
    """Step 5: value and place of the maximum of a window."""
    height, width = luminance.shape
    best, place = -math.inf, pixel
    for row in range(max(pixel[0] - reach, 0), min(pixel[0] + reach, height - 1) + 1):
        for column in columns_around(row, pixel[1], reach, height, width, sphere):
            if luminance[row, column] > best:
                best, place = luminance[row, column], (row, column)
    return best, place


def distance(one, other, size, sphere):
    """Between two pixels: in pixels, or in degrees on the sphere."""
    if not sphere:
        return math.dist(one, other)
    a, b = direction(one, *size), direction(other, *size)
    return math.degrees(
        2 * math.atan2(math.dist(a, b), math.hypot(*map(sum, zip(a, b, strict=True))))
    )


def suppress(pixels, is_near):
    """Step 7: from the brightest on, each survivor takes what is near and not taken yet."""
    label = [-1] * len(pixels)
    for i, pixel in enumerate(pixels):
        if label[i] == -1:
            label[i] = i
            for j in range(i + 1, len(pixels)):
                if label[j] == -1 and is_near(pixel, pixels[j]):
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


def is_bright(luminance, start, end, unit=1.0, sphere=False):
    """Step 8: the running mean stays close to the start's luminance, or is 1 and more."""
    width = luminance.shape[1]
    if sphere and abs(end[1] - start[1]) > width // 2:
        end = (end[0], end[1] - width if end[1] > start[1] else end[1] + width)
    tolerance, ceiling, bright = (np.float32(unit * level) for level in (0.15, 1.25, 1.0))
    total = np.float32(0)
    for count, (row, column) in enumerate(line(start, end)[1:], start=1):
        total += min(luminance[row, column % width], ceiling)
        mean = total / np.float32(count)
        if abs(mean - luminance[tuple(start)]) > tolerance and mean < bright:
            return False
    return True


def merge(pixels, belongs):
    """Step 8: each survivor that is left takes those that belong to it."""
    label = [-1] * len(pixels)
    for i, start in enumerate(pixels):
        if label[i] == -1:
            label[i] = i
            for j in range(i + 1, len(pixels)):
                if label[j] == -1 and belongs(start, pixels[j]):
                    label[j] = i
    return label


def position(luminance, pixels, sphere):
    """Step 9: the mean, weighted by luminance, of pixels or of unit vectors; as a direction."""
    weights = [float(luminance[pixel]) for pixel in pixels]
    points = [direction(pixel, *luminance.shape) if sphere else pixel for pixel in pixels]
    mean = [
        sum(w * x for w, x in zip(weights, axis, strict=True)) for axis in zip(*points, strict=True)
    ]
    mean = [total / sum(weights) for total in mean]
    if not sphere:
        return direction(mean, *luminance.shape)
    return tuple(x / math.hypot(*mean) for x in mean)


def detect(
    luminance,
    *,
    unit=1.0,
    move_to_maximum=False,
    sphere=False,
    merge_cap_deg=None,
    sampling="hammersley",
):
    """All steps: pixels of the samples that passed, their lights, and the lights' directions.

    `unit` is the luminance that corresponds to the article's 1.
    """
    height, width = luminance.shape
    reach = int(12 * width / 1024) // 2
    per_degree = 1 if sphere else width / 360

    def apart(one, other):
        return distance(one, other, luminance.shape, sphere)

    def belongs(one, other):
        within = merge_cap_deg is None or apart(one, other) <= merge_cap_deg * per_degree
        return within and is_bright(luminance, one, other, unit, sphere)

    kept = []
    for pixel in samples(int(0.006 * width * height), height, width, sampling):
        brightest, place = brightest_around(luminance, pixel, reach, sphere)
        if brightest > unit * 0.8:
            kept.append(place if move_to_maximum else pixel)
    kept.sort(key=lambda pixel: -luminance[pixel])  # stable
    survivor = suppress(kept, lambda one, other: apart(one, other) < 5.0 * per_degree)
    survivors = sorted(set(survivor))
    merged = merge([kept[i] for i in survivors], belongs)
    light_of = {s: survivors[m] for s, m in zip(survivors, merged, strict=True)}
    members = {home: [s for s in survivors if light_of[s] == home] for home in light_of.values()}
    directions = {
        home: position(luminance, [kept[s] for s in parts], sphere)
        for home, parts in members.items()
    }
    return kept, [light_of[s] for s in survivor], directions
