"""Priors of rooms of plane charts, by rays of NumPy."""

import numpy as np

import envlights as el
from envlights.synthetic.room import room_charts

#: Charts along a side of a lightmap.
CHARTS = 4


def prior(position, normal, albedo, **options):
    """Prior of a lightmap of 4 by 4 plane, rectangular charts, each (H, W, 3)."""
    faces = [rectangle(chart) for chart in charts(position)]
    normals = [chart[0, 0] for chart in charts(normal)]
    lightmap = el.scene.Surface(position, unit(normal), albedo)
    points = el.scene.Surface(*finer(lightmap, faces, 128))
    size = options.get("size", 16)
    hit = texel_hit(faces, unit(np.array(normals)), size)
    return el.scene.gather(lightmap, points, hit, **options)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def charts(image):
    side = len(image) // CHARTS
    grid = image.reshape(CHARTS, side, CHARTS, side, -1).swapaxes(1, 2)
    return grid.reshape(CHARTS**2, side, side, -1)


def rectangle(chart):
    """Corner, edge along the rows, and edge along the columns, from centres of texels."""
    side = len(chart)
    down, across = ((end - chart[0, 0]) / (side - 1) for end in (chart[-1, 0], chart[0, -1]))
    return chart[0, 0] - (down + across) / 2, side * down, side * across


def finer(lightmap, faces, width):
    """Position, normal and albedo of a lightmap with `width` columns of the same charts."""
    side = width // CHARTS
    flat = (charts(each)[:, :1, :1] for each in (lightmap.normal, lightmap.albedo))
    shape = (CHARTS**2, side, side, 3)
    return [in_charts(faces, width), *(in_rows(np.broadcast_to(each, shape)) for each in flat)]


def texel_hit(faces, normals, size):
    """Ray tracer of rectangles: the nearest one that each ray hits, and the texel in it."""
    side = size // CHARTS

    def hit(origins, directions):
        nearest, answer = np.full(len(origins), np.inf), np.full(len(origins), -1)
        for k, ((corner, down, across), normal) in enumerate(zip(faces, normals, strict=True)):
            cosine = directions @ normal
            with np.errstate(divide="ignore", invalid="ignore"):
                distance = (corner - origins) @ normal / cosine
                ends = origins + distance[:, None] * directions - corner
                row, column = (ends @ edge / (edge @ edge) for edge in (down, across))
                inside = (row >= 0) & (row < 1) & (column >= 0) & (column < 1)
                closer = inside & (distance > 1e-6) & (distance < nearest)
            nearest[closer] = distance[closer]
            texel = (k // CHARTS * side + np.floor(row * side)) * size
            texel += k % CHARTS * side + np.floor(column * side)
            answer[closer] = np.where(cosine < 0, texel, -2)[closer]
        return answer

    return hit


def room_surface(width):
    """Position, normal and albedo of the generated room."""
    faces = room_charts()
    albedo = np.random.default_rng(7).uniform(0.25, 0.75, (len(faces), 3))
    maps = [in_charts([(face.origin, face.rows, face.columns) for face in faces], width)]
    side = width // CHARTS
    for each in (np.array([face.normal for face in faces]), albedo):
        maps.append(in_rows(np.broadcast_to(each[:, None, None], (len(faces), side, side, 3))))
    return maps


def in_charts(faces, width):
    """Centres of the texels of rectangles, (width, width, 3)."""
    steps = (np.arange(width // CHARTS) + 0.5) / (width // CHARTS)
    places = [c + steps[:, None, None] * d + steps[:, None] * a for c, d, a in faces]
    return in_rows(np.stack(places))


def in_rows(maps):
    """Charts (n, side, side, 3) as a lightmap."""
    side = maps.shape[1]
    grid = maps.reshape(CHARTS, CHARTS, side, side, 3).swapaxes(1, 2)
    return grid.reshape(CHARTS * side, CHARTS * side, 3)


def room_prior(width):
    """Prior of the generated room, whose images hold irradiance."""
    return prior(*room_surface(width), irradiance=True)
