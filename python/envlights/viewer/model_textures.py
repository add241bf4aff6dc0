"""Textures of a model for the shader: hierarchy, triangles and corners, as unsigned integers."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.srgb import encode_srgb
from envlights._native import EnvLightsError
from envlights.viewer.model import Model

#: Steps of the grid along the longest side of a model: one is 0.015 mm in a metre.
_STEPS = 65535
#: Angle in degrees up to which two triangles at a vertex are one smooth surface.
_CREASE = 40.0
#: Triangles at one vertex that are compared with each other.
_NEIGHBOURS = 32


def textures(model: Model) -> dict[str, Any]:
    """Data of the page: grid, counts, and textures of 32-bit unsigned integers as base64.

    A texel of `nodes` holds a box and a link (see `src/kernels/hierarchy`), one of `triangles`
    three corners of 21 bits, one of `corners` a position in 48 bits, a normal in 32 and sRGB codes.
    """
    lower, step, grid = _on_grid(model)
    corners = grid[model.triangles]
    keep = ~(np.cross(*_sides(corners)) == 0).all(axis=1)
    if not keep.any():
        raise EnvLightsError("each triangle of the model is smaller than 1/65535 of its size")
    corners, albedo = corners[keep], model.albedo[keep]
    records, inverse = np.unique(
        _records(corners, corner_normals(corners), albedo), axis=0, return_inverse=True
    )
    rows: NDArray[np.uint32] = inverse.reshape(-1, 3).astype(np.uint32)
    vertices = np.stack(
        [records[:, 0] & 0xFFFF, records[:, 0] >> 16, records[:, 1] & 0xFFFF], axis=1
    ).astype(np.uint16)
    nodes, order = _native.bounding_volume_hierarchy(vertices, rows)
    return {
        "lower": lower.tolist(),
        "step": step,
        "size": model.size.tolist(),
        "notes": list(model.notes),
        "count": {"nodes": len(nodes), "triangles": len(rows)},
        "nodes": _texture(nodes),
        "triangles": _texture(_packed_rows(rows[order])),
        "corners": _texture(records),
    }


def _on_grid(model: Model) -> tuple[NDArray[np.float64], float, NDArray[np.int64]]:
    """Lower corner and step of a grid in metres, and the vertices in steps, (n, 3)."""
    used = model.vertices[model.triangles.ravel()]
    lower = used.min(axis=0)
    step = float((used.max(axis=0) - lower).max() / _STEPS)
    grid = np.rint((model.vertices - lower) / step).clip(0, _STEPS)
    return lower, step, grid.astype(np.int64)


def _sides(corners: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Two sides of each triangle, from its first corner."""
    return corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]


def corner_normals(corners: NDArray[np.int64]) -> NDArray[np.float64]:
    """Unit normal at each corner, (m, 3, 3): the mean, by area, over smooth neighbours.

    Triangles are neighbours if they share a position; the surface is smooth if their normals are
    within 40 degrees. This replaces the normals of a file, which may be missing or wrong.
    """
    areas = np.cross(*_sides(corners)).astype(np.float64)
    units = areas / np.linalg.norm(areas, axis=1, keepdims=True)
    keys = corners.reshape(-1, 3) @ np.array([1 << 32, 1 << 16, 1])
    order = np.argsort(keys, kind="stable")
    _, starts, counts = np.unique(keys[order], return_index=True, return_counts=True)
    place, valence = np.arange(len(keys)) - np.repeat(starts, counts), np.repeat(counts, counts)
    faces, first = order // 3, np.repeat(starts, counts)
    sums = areas[faces]
    for shift in range(1, min(_NEIGHBOURS, int(counts.max()))):
        some = np.flatnonzero(valence > shift)
        other = faces[first[some] + (place[some] + shift) % valence[some]]
        is_smooth = np.einsum("ij,ij->i", units[faces[some]], units[other]) > np.cos(
            np.radians(_CREASE)
        )
        sums[some[is_smooth]] += areas[other[is_smooth]]
    normals = np.empty_like(sums)
    normals[order] = sums / np.linalg.norm(sums, axis=1, keepdims=True)
    return normals.reshape(-1, 3, 3)


def _records(
    corners: NDArray[np.int64], normals: NDArray[np.float64], albedo: NDArray[np.float64]
) -> NDArray[np.uint32]:
    """One texel for each corner, (3 m, 4)."""
    x, y, z = corners.reshape(-1, 3).T.astype(np.uint32)
    u, v = octahedral(normals.reshape(-1, 3)).T
    red, green, blue = np.rint(255 * encode_srgb(albedo.reshape(-1, 3))).astype(np.uint32).T
    return np.stack(
        [x | y << 16, z | u << 16, v | red << 16 | green << 24, blue], axis=1, dtype=np.uint32
    )


def octahedral(normals: NDArray[np.float64]) -> NDArray[np.uint32]:
    """Unit vectors as two codes of 16 bits (Cigolle et al. 2014, "octahedral"), (n, 2)."""
    flat = normals / np.abs(normals).sum(axis=1, keepdims=True)
    folded = (1 - np.abs(flat[:, 1::-1])) * np.where(flat[:, :2] < 0, -1.0, 1.0)
    square = np.where(flat[:, 2:] < 0, folded, flat[:, :2])
    return np.asarray(np.rint((square * 0.5 + 0.5) * 65535).astype(np.uint32))


def _packed_rows(rows: NDArray[np.uint32]) -> NDArray[np.uint32]:
    """Three numbers of 21 bits in two of 32, (m, 2)."""
    a, b, c = rows.T
    return np.stack([a | b << 21, b >> 11 | c << 10], axis=1, dtype=np.uint32)


def _texture(texels: NDArray[np.uint32]) -> dict[str, Any]:
    """Channels of a texture, and its texels as base64, little-endian."""
    content = base64.b64encode(texels.astype("<u4").tobytes()).decode()
    return {"channels": texels.shape[1], "texels": content}
