"""Maps after any rotation, in NumPy, slow and plain."""

import numpy as np
from scipy.optimize import minimize

from envlights.kernels import sphere

#: Samples along each side of a cell.
_SIDE = 3
#: Least and largest number of places along each side of a bright cell.
_LEAST_PLACES, _MOST_PLACES = 4, 64
#: A cell with more than this share of the flux of any channel, and this many times the mean
#: radiance, is bright: it keeps its own flux.
_BRIGHT_SHARE, _BRIGHT_CONTRAST = 1e-4, 10
#: Samples that are turned at once.
_BLOCK = 2**18


def rotate(radiance, matrix):
    """A map of cells after any rotation: what was in the direction d is then in matrix @ d.

    Each new cell is the mean over a grid of samples, and the whole is scaled to its flux. Bright
    cells, which small lights are made of, are left out at first. Then each is distributed
    bilinearly, with weights that are tilted so that its centroid is right.
    """
    areas = sphere.pixel_solid_angles(*radiance.shape[:2])[..., None]
    flux = (radiance * areas).sum(axis=(0, 1))
    most = np.maximum(_BRIGHT_SHARE / areas, _BRIGHT_CONTRAST / (4 * np.pi)) * flux
    is_bright = np.any(radiance > most, axis=2)
    rest = np.where(is_bright[..., None], 0, radiance).astype(np.float64)
    new = _sample_means(rest, matrix)
    seen, wanted = (new * areas).sum(axis=(0, 1)), (rest * areas).sum(axis=(0, 1))
    new *= wanted / np.where(seen > 0, seen, 1)
    for row, column in np.argwhere(is_bright):
        _add_bright(new, radiance, row, column, matrix)
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


def _add_bright(new, radiance, row, column, matrix):
    """Add one bright cell with its flux."""
    height, width, _ = radiance.shape
    areas = sphere.pixel_solid_angles(height, width)
    centre = matrix @ moment(row, column, height, width)
    centre /= np.linalg.norm(centre)
    near = _narrow_side(_place(centre, height, width).astype(int), height, width)
    side = int(np.clip(np.ceil(2 * np.sqrt(areas[row, 0]) / near), _LEAST_PLACES, _MOST_PLACES))
    weights = _bilinear(row, column, matrix, height, width, side)
    cells = np.argwhere(weights > 0)
    weights = weights[weights > 0]
    weights = weights * _tilt(cells, weights, centre, height, width, areas)
    for (y, x), weight in zip(cells, weights / weights.sum(), strict=True):
        new[y, x] += radiance[row, column] * weight * areas[row, 0] / areas[y, 0]


def _place(direction, height, width):
    """Row and column of a direction, as real numbers."""
    theta = np.arctan2(np.hypot(direction[0], direction[2]), direction[1])
    phi = np.arctan2(direction[0], -direction[2]) % (2 * np.pi)
    return np.minimum(
        [theta * height / np.pi, phi * width / (2 * np.pi)], [height - 1e-9, width - 1e-9]
    )


def _bilinear(row, column, matrix, height, width, side):
    """Fraction of a cell in each new cell: even places, each in the four nearest cells."""
    weights = np.zeros((height, width))
    for down, across in np.ndindex(side, side):
        theta = np.pi * (row + (down + 0.5) / side) / height
        phi = 2 * np.pi * (column + (across + 0.5) / side) / width
        old = [np.sin(phi) * np.sin(theta), np.cos(theta), -np.cos(phi) * np.sin(theta)]
        y, x = _place(matrix @ old, height, width) - 0.5
        top, left = int(np.floor(y)), int(np.floor(x))
        for i, j in np.ndindex(2, 2):
            share = (1 - abs(y - top - i)) * (1 - abs(x - left - j))
            cell_row, cell_column = top + i, left + j
            if not 0 <= cell_row < height:  # beyond a pole
                cell_row, cell_column = (-1 - cell_row) % height, cell_column + width // 2
            weights[cell_row, cell_column % width] += share * np.sin(theta)
    return weights / weights.sum()


def moment(row, column, height, width):
    """Integral of the direction over a cell, by a fine grid."""
    theta = np.pi * (row + (np.arange(200) + 0.5) / 200)[:, None] / height
    phi = 2 * np.pi * (column + (np.arange(200) + 0.5) / 200) / width
    x, z = np.sin(phi) * np.sin(theta) ** 2, -np.cos(phi) * np.sin(theta) ** 2
    y = np.cos(theta) * np.sin(theta) + 0 * phi
    step = np.pi / height * 2 * np.pi / width / 200**2
    return np.array([x.sum(), y.sum(), z.sum()]) * step


def _tilt(cells, weights, centre, height, width, areas):
    """Factors of the weights of cells, with which their centroid is `centre`."""
    moments = np.array([moment(y, x, height, width) / areas[y, 0] for y, x in cells])
    first = np.cross(centre, [1, 0, 0] if abs(centre[0]) < 0.9 else [0, 1, 0])
    first /= np.linalg.norm(first)
    offsets = moments @ np.stack([first, np.cross(centre, first)], axis=1)
    scale = np.linalg.norm(offsets, axis=1).max()
    offsets = offsets / scale

    def cost(g):
        return np.log(weights @ np.exp(offsets @ g))

    found = minimize(cost, np.zeros(2), method="BFGS", options={"gtol": 1e-9})
    return np.exp(offsets @ found.x) if np.linalg.norm(found.jac) < 1e-6 else np.ones(len(weights))


def _narrow_side(place, height, width):
    """Distance of a cell to the nearer of its neighbours below and to the right."""
    row, column = place
    areas = sphere.pixel_solid_angles(height, width)
    below = (row + 1, column) if row + 1 < height else (row, (column + width // 2) % width)
    units = [
        moment(y, x, height, width) for y, x in ((row, column), below, (row, (column + 1) % width))
    ]
    own, *others = [unit / np.linalg.norm(unit) for unit in units]
    return min(np.sqrt(areas[row, 0]), *(np.linalg.norm(own - other) for other in others))
