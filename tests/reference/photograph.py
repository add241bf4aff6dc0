"""The steps of Loghin (2021) on a plane picture, slow and plain; views of a map by a pinhole."""

from __future__ import annotations

import math

import numpy as np

from tests.reference import loghin


def samples(sequence: str, n: int, height: int, width: int) -> list[tuple[int, int]]:
    """Steps 3 and 4: pixels of n points of the plane."""
    pixels = []
    for i in range(n):
        u, v = i / n, loghin.radical_inverse(i)
        if sequence == "halton":
            u, v = loghin.radical_inverse(i), loghin.inverse_of_thirds(i)
        # Some points lie on the very borders of pixels, where rounding would toss a coin.
        row, column = int(v * height + 1e-9), int(u * width + 1e-9)
        pixels.append((min(row, height - 1), min(column, width - 1)))
    return pixels


def blur(image, sigma):
    """Step 2: a Gaussian out to three standard deviations; outer pixels continue."""
    offsets = range(-math.ceil(3 * sigma), math.ceil(3 * sigma) + 1)
    weights = [math.exp(-0.5 * (offset / sigma) ** 2) for offset in offsets]
    for axis in (0, 1):
        at = np.arange(image.shape[axis])
        parts = (
            weight * image.take(np.clip(at + offset, 0, at[-1]), axis=axis)
            for weight, offset in zip(weights, offsets, strict=True)
        )
        image = sum(parts) / sum(weights)
    return image


def climb(luminance, pixel, reach):
    """Maximum that a sample ends at, from window to window."""
    while True:
        best, place = loghin.brightest_around(luminance, pixel, reach)
        if best <= luminance[pixel]:
            return pixel
        pixel = place


def is_within_stops(stops, start, end, tolerance):
    """Step 8 in stops: the running mean stays close to the start."""
    total = np.float32(0)
    for count, pixel in enumerate(loghin.line(start, end)[1:], start=1):
        total += stops[pixel]
        if abs(total / np.float32(count) - stops[start]) > np.float32(tolerance):
            return False
    return True


def mean_place(weighted):
    """Step 9: sum(w p) / sum(w) of pairs of a pixel and its weight."""
    total = sum(weight for _, weight in weighted)
    return tuple(sum(weight * pixel[axis] for pixel, weight in weighted) / total for axis in (0, 1))


def detect(
    luminance, *, bright=0.8, peak=None, sequence="halton", per_pixel=0.006, apart=20.0, reach=None
):
    """Steps 3 to 9: first and final pixels of the samples, their lights, and the lights' places.

    With a `peak`, samples climb to maxima that reach it and lines are checked in stops; without
    one the steps are those of the article.
    """
    height, width = luminance.shape
    scale = max(height, width) / 1024
    reach = int(12 * scale) // 2 if reach is None else reach
    kept = []
    for pixel in samples(sequence, int(per_pixel * width * height), height, width):
        brightest, place = loghin.brightest_around(luminance, pixel, reach)
        if brightest > bright:
            at = pixel if peak is None else climb(luminance, place, reach)
            kept.append((pixel, at, luminance[place]))
    if peak is not None:
        # Samples are sorted by the first maximum that they see, and then by the last one.
        kept.sort(key=lambda each: -each[2])
        kept = [each for each in kept if luminance[each[1]] >= peak]
    kept.sort(key=lambda each: -luminance[each[1]])  # stable
    first, at = [each[0] for each in kept], [each[1] for each in kept]
    survivor = loghin.suppress(at, lambda one, other: math.dist(one, other) < apart * scale)
    survivors = sorted(set(survivor))
    if peak is None:
        merged = loghin.merge(
            [at[i] for i in survivors], lambda a, b: loghin.is_bright(luminance, a, b)
        )
    else:
        floor = np.float32(bright / 2**2)
        stops = np.log2(np.maximum(luminance, floor) / floor)
        merged = loghin.merge(
            [at[i] for i in survivors], lambda a, b: is_within_stops(stops, a, b, 1.5)
        )
    light_of = {s: survivors[m] for s, m in zip(survivors, merged, strict=True)}
    light = [light_of[s] for s in survivor]
    places = {}
    for home in set(light):
        parts = [(at[s], float(luminance[at[s]])) for s in survivors if light_of[s] == home]
        if peak is not None:
            own = [pixel for pixel, each in zip(first, light, strict=True) if each == home]
            parts += [
                (pixel, float(luminance[pixel])) for pixel in own if luminance[pixel] > bright
            ]
        places[home] = mean_place(parts)
    return first, at, light, places


def axes_of_view(azimuth_deg: float, elevation_deg: float) -> np.ndarray:
    """Matrix from the frame of a photograph to that of the map, for a view towards an angle.

    The azimuth counts from +z over +x.
    """
    azimuth, elevation = np.deg2rad([azimuth_deg, elevation_deg])
    left = [np.cos(azimuth), 0, -np.sin(azimuth)]
    forward = [
        np.sin(azimuth) * np.cos(elevation),
        np.sin(elevation),
        np.cos(azimuth) * np.cos(elevation),
    ]
    return np.stack([left, np.cross(forward, left), forward], axis=1)


def view(radiance, axes, height, width, fov_deg, places=3):
    """View of a map by a pinhole camera: the mean over `places` x `places` places of each pixel."""
    focal = width / 2 / math.tan(math.radians(fov_deg) / 2)
    total = np.zeros((height, width, 3))
    for across in (np.arange(places) + 0.5) / places:
        for down in (np.arange(places) + 0.5) / places:
            x, y = np.meshgrid(np.arange(width) + across, np.arange(height) + down)
            slopes = (width / 2 - x) / focal, (height / 2 - y) / focal, np.ones_like(x)
            d = np.stack(slopes, axis=-1) @ axes.T
            u = np.arctan2(d[..., 0], -d[..., 2]) / (2 * np.pi) % 1
            v = np.arctan2(np.hypot(d[..., 0], d[..., 2]), d[..., 1]) / np.pi
            rows = np.minimum((v * len(radiance)).astype(int), len(radiance) - 1)
            columns = np.minimum((u * radiance.shape[1]).astype(int), radiance.shape[1] - 1)
            total += radiance[rows, columns]
    return (total / places**2).astype(np.float32)


def directions_in_view(lights, axes, height, width, fov_deg, margin_deg=2.0):
    """Directions of lights in the frame of a photograph, and True for those wholly inside of it.

    The border would cut a light nearer than its length, and move the rest of it.
    """
    d = lights.direction @ axes
    half = np.arctan(math.tan(math.radians(fov_deg) / 2) * np.array([1, height / width]))
    radius = lights.angular_radius * np.sqrt(lights.elongation) + math.radians(margin_deg)
    across = np.arctan2(np.abs(d[:, :2]), d[:, 2:])
    return d, (across + radius[:, None] < half).all(axis=1)
