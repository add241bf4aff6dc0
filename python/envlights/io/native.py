"""Readers of Radiance and PNG in Rust, with what they say in the terms of `raw_image`."""

from __future__ import annotations

from envlights._native import PngFile, RadianceFile

__all__ = ["PngFile", "RadianceFile"]
