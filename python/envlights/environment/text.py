"""Text for a map: one line, a paragraph, and HTML."""

from __future__ import annotations

import numpy as np

from envlights._common import html
from envlights._common.blocks import in_blocks
from envlights._common.units import in_nits
from envlights._common.words import percent
from envlights.environment.pixels import PROJECTION, MapPixels
from envlights.kernels import thumbnails
from envlights.kernels.image import LUMINANCE


def line(pixels: MapPixels, name: str) -> str:
    """Name of a map followed by its size, layout, units, clipped part and notes in brackets."""
    notes = f", notes: {'; '.join(pixels.notes)}" if pixels.notes else ""
    unit = in_nits(pixels.units)
    units = f",{unit}" if unit else ""
    return f"{name}({_layout(pixels, '')}{units}{_clipped(pixels)}{notes})"


def paragraph(pixels: MapPixels) -> str:
    """Lines on the layout, the luminance, the clip level and the notes."""
    radiance, weights = pixels.radiance, LUMINANCE.astype(np.float32)
    luminance = in_blocks(radiance.shape, lambda rows: radiance[rows] @ weights)
    level = pixels.clip_level
    lines = [
        _layout(pixels, " pixels,"),
        f"luminance{in_nits(pixels.units)}: median {np.median(luminance):.3g},"
        f" largest {luminance.max():.3g}",
        f"clip level {level:g}{_clipped(pixels)}" if level else "",
        *(f"note: {note}" for note in pixels.notes),
    ]
    return "\n".join(filter(None, lines))


def block(pixels: MapPixels, name: str) -> str:
    """Thumbnail and paragraph as HTML."""
    picture = html.picture(thumbnails.of_map(pixels.radiance), "the map")
    return html.block(name, "", picture, html.lines(paragraph(pixels)))


def _layout(pixels: MapPixels, of_size: str) -> str:
    height, width, _ = pixels.radiance.shape
    return f"{width}x{height}{of_size} {PROJECTION}, {pixels.registration}"


def _clipped(pixels: MapPixels) -> str:
    """Clipped fractions of the sphere and of the flux; empty for a map without clip level."""
    if pixels.clip_level is None or not pixels.clipped_fractions[0]:
        return ""
    fraction, of_flux = pixels.clipped_fractions
    return (
        f", {percent(fraction, 2)} of the sphere is clipped and holds"
        f" {percent(of_flux, 2)} of the flux"
    )
