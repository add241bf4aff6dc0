"""Maps after any rotation, in NumPy, slow and plain."""

import numpy as np

from envlights.kernels import sphere

#: Samples along each side of a cell, and of one that holds a part of a bright cell.
_SIDE, _FINE_SIDE = 3, 16
#: A cell with more than this share of the flux of any channel, and this many times the mean
#: radiance, is bright: it keeps its own flux.
_BRIGHT_SHARE, _BRIGHT_CONTRAST = 1e-4, 10
#: Fewer hits do not tell the area of a cell: it is smaller than the new ones.
_ENOUGH_HITS = 64
#: Samples that are turned at once.
_BLOCK = 2**18


def rotate(radiance, matrix):
    """A map of cells after any rotation: what was in the direction d is then in matrix @ d.

    Each new cell is the mean over a grid of samples. Bright cells, which small lights are made of,
    are sampled more finely and scaled so that each keeps its flux; then all the rest is.
    """
    areas = sphere.pixel_solid_angles(*radiance.shape[:2])[..., None]
    flux = (radiance * areas).sum(axis=(0, 1))
    most = np.maximum(_BRIGHT_SHARE / areas, _BRIGHT_CONTRAST / (4 * np.pi)) * flux
    is_bright = np.any(radiance > most, axis=2)
    rest = np.where(is_bright[..., None], 0, radiance).astype(np.float64)
    new = _sample_means(rest, matrix)
    seen, wanted = (new * areas).sum(axis=(0, 1)), (rest * areas).sum(axis=(0, 1))
    new *= wanted / np.where(seen > 0, seen, 1)
    _add_bright(new, radiance, is_bright, matrix)
    return new.astype(np.float32)


def _sample_means(radiance, matrix):
    """Means of the turned map over each new cell, from a grid of samples."""
    height, width, _ = radiance.shape
    new = np.empty((height * width, 3))
    flat = radiance.reshape(-1, 3)
    step = max(_BLOCK // _SIDE**2, 1)
    for start in range(0, height * width, step):
        places = np.arange(start, min(start + step, height * width))
        old = _old_cells(places, matrix, height, width, _SIDE)
        new[places] = flat[old].mean(axis=1)
    return new.reshape(radiance.shape)


def _old_cells(places, matrix, height, width, side):
    """Cells of the map before the turn, (n, side * side), below samples of cells after it.

    The samples of a cell stand for equal solid angles: even in the cosine and in the azimuth.
    """
    within = (np.arange(side) + 0.5) / side
    row, column = places // width, places % width
    top, bottom = np.cos(np.pi * row / height), np.cos(np.pi * (row + 1) / height)
    cosine = top[:, None] + (bottom - top)[:, None] * within
    phi = 2 * np.pi * (column[:, None] + within) / width
    sine = np.sqrt(np.maximum(1 - cosine**2, 0))
    x, z = (sine[:, :, None] * each(phi)[:, None] for each in (np.sin, np.cos))
    y = np.broadcast_to(cosine[:, :, None], x.shape)
    # Rows of a rotation are columns of its inverse.
    x, y, z = (x * m[0] + y * m[1] - z * m[2] for m in matrix.T)
    old_row = np.arccos(np.clip(y, -1, 1)) * (height / np.pi)
    old_column = np.arctan2(x, -z) * (width / (2 * np.pi))
    rows = np.clip(old_row.astype(np.int64), 0, height - 1)
    columns = np.floor(old_column).astype(np.int64) % width
    old = rows * width + columns
    return old.reshape(len(places), side * side)


def _add_bright(
    new,
    radiance,
    is_bright,
    matrix,
):
    """Add the bright cells to the turned map, each with its flux."""
    if not is_bright.any():
        return
    height, width, _ = radiance.shape
    areas = sphere.pixel_solid_angles(height, width).ravel()
    places = _places_of(is_bright, matrix)
    step = max(_BLOCK // _FINE_SIDE**2, 1)
    blocks = [places[start : start + step] for start in range(0, len(places), step)]
    # Measure how often each bright cell is met, and over what solid angle.
    number = np.full(height * width, -1)
    cells = np.flatnonzero(is_bright)
    number[cells] = np.arange(len(cells))
    hits, seen = np.zeros(len(cells)), np.zeros(len(cells))
    met = []
    for block in blocks:
        old = number[_old_cells(block, matrix, height, width, _FINE_SIDE)]
        sample, _ = np.nonzero(old >= 0)
        cell = old[old >= 0]
        hits += np.bincount(cell, minlength=len(cells))
        seen += np.bincount(cell, areas[block[sample]] / _FINE_SIDE**2, minlength=len(cells))
        met.append((block[sample], cell))
    # Scale the cells to their flux; those that were hardly met are dropped in from where they were.
    is_met = hits >= _ENOUGH_HITS
    factors = np.where(is_met, areas[cells] / np.where(is_met, seen, 1), 0)
    colours = radiance.reshape(-1, 3)[cells] * factors[:, None] / _FINE_SIDE**2
    flat = new.reshape(-1, 3)
    for block, cell in met:
        _scatter(flat, block, colours[cell])
    few = cells[~is_met]
    back = _old_cells(few, matrix.T, height, width, _FINE_SIDE)
    flux = radiance.reshape(-1, 3)[few] * areas[few, None] / _FINE_SIDE**2
    _scatter(flat, back.ravel(), flux.repeat(_FINE_SIDE**2, axis=0) / areas[back.ravel(), None])


def _scatter(flat, places, colours):
    """Add colours to cells, where a cell may come more than once."""
    for channel in range(3):
        flat[:, channel] += np.bincount(places, colours[:, channel], minlength=len(flat))


def _places_of(is_bright, matrix):
    """New cells that may hold a part of a bright cell: those around the turned corners."""
    height, width = is_bright.shape
    row, column = np.nonzero(is_bright)
    marked = np.zeros((height, width), bool)
    for down, across in np.ndindex(3, 3):
        uv = np.stack([(column + across / 2) / width, (row + down / 2) / height], axis=1)
        turned = sphere.uv_to_direction(uv) @ matrix.T
        turned /= np.linalg.norm(turned, axis=1, keepdims=True)
        u, v = sphere.direction_to_uv(turned).T
        _mark(marked, v * height, u * width)
    return np.flatnonzero(marked)


def _mark(marked, row, column):
    """Mark the cells within one row of each place, and as far along the rows."""
    height, width = marked.shape
    for step in (-1, 0, 1):
        rows = np.clip(row.astype(np.int64) + step, 0, height - 1)
        # Cells of a row are as narrow as its sine: of rows at the poles, all are near.
        reach = np.ceil(1.5 / np.sin(np.pi * (rows + 0.5) / height)).astype(np.int64)
        for each in np.unique(rows):
            own = rows == each
            wide = min(int(reach[own][0]), width // 2)
            offsets = np.arange(-wide, wide + 1)
            columns = np.unique(column[own].astype(np.int64))[:, None] + offsets
            marked[each, columns.ravel() % width] = True
