"""The component tree with prominence, pixel by pixel, without tiles."""

from __future__ import annotations

import numpy as np


def neighbours(row, column, height, width):
    """Eight around a pixel; columns meet at the seam, all pixels of a pole row touch."""
    for y in range(max(row - 1, 0), min(row + 2, height)):
        for x in (column - 1, column, column + 1):
            yield y, x % width
    if row in (0, height - 1):
        for x in range(width):
            yield row, x


def lights(luminance, threshold, prominence, lowest_peak):
    """Sets of pixels: what each light holds above the threshold."""
    height, width = luminance.shape
    bright = np.argwhere(luminance > threshold)
    order = sorted(map(tuple, bright), key=lambda pixel: -luminance[pixel])
    island, peak_of, absorbed_by = {}, {}, {}

    def find(pixel):
        while island[pixel] != pixel:
            pixel = island[pixel]
        return pixel

    for pixel in order:
        island[pixel] = pixel
        higher = [n for n in set(neighbours(*pixel, height, width)) if n in island and n != pixel]
        higher.sort(key=lambda n: -luminance[n])
        # Uphill, to the brightest neighbour: the basin that the pixel belongs to.
        peak_of[pixel] = peak_of[higher[0]] if higher else pixel
        for other in higher:
            one, two = find(pixel), find(other)
            if one == two:
                continue
            if one == pixel:  # the pixel itself is no island yet
                island[pixel] = two
                continue
            high, low = (one, two) if luminance[one] >= luminance[two] else (two, one)
            island[low] = high
            if luminance[low] < prominence * luminance[pixel]:
                absorbed_by[low] = high
    groups = {}
    for pixel in order:
        peak = peak_of[pixel]
        while peak in absorbed_by:
            peak = absorbed_by[peak]
        if luminance[peak] >= lowest_peak:
            groups.setdefault(peak, set()).add(pixel)
    return list(groups.values())
