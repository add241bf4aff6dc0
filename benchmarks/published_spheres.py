"""Materials of `stylelight` against published images: two spheres predicted from the third.

Usage: python benchmarks/published_spheres.py FOLDER

FOLDER is `example/ground_truth/stylelight` of the repository DiffusionLight-evaluation, with an
image of the mirror, the matte and the diffuse ball under one map. The mirror shows all directions
but a cone behind the ball, so it is turned into a map; the other two balls are computed from that
map, and compared with their images where the incidence is below 60 degrees. docs/lab/compare.md
has the result.
"""

import argparse
from pathlib import Path

import numpy as np
from scipy.ndimage import distance_transform_edt

import envlights as el
from envlights.comparison import Camera
from envlights.comparison.rays import of_camera

ROWS = 128
#: Alternatives of the material of each ball.
MATERIALS = {
    "matte_silver": {"as in the code": (0.0, 0.8, 0.3271), "alpha = roughness": (0.0, 0.8, 0.572)},
    "diffuse": {"with its coat": (0.8, 0.04, 0.364), "Lambertian": (0.8, 0.0, 0.364)},
}


def pixels_of(path):
    """Pixels of the ball in a picture, in the order of the rays of a camera."""
    picture = el.io.read_image(path).pixels[..., :3]
    middle, size = np.array(picture.shape[:2]) / 2, Camera().size
    places = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(places, places)
    inside = x * x + y * y < 1
    rows, columns = (
        (c + size / 2 * place[inside]).astype(int) for c, place in zip(middle, (y, x), strict=True)
    )
    return picture[rows, columns].astype(float)


def map_of_mirror(colours, points):
    """Map that a mirror shows; directions behind it get the colour of the nearest one."""
    cosine = (points.normals * points.views).sum(axis=1)
    radiance = colours / (0.8 + 0.2 * (1 - cosine) ** 5)[:, None]
    mirrored = points.mirrored()
    mirrored /= np.linalg.norm(mirrored, axis=1, keepdims=True)
    u, v = el.kernels.direction_to_uv(mirrored).T
    cell = np.minimum((v * ROWS).astype(int), ROWS - 1) * 2 * ROWS + (u * 2 * ROWS).astype(int)
    counts = np.bincount(cell, minlength=2 * ROWS * ROWS).reshape(ROWS, -1)
    sums = [np.bincount(cell, channel, 2 * ROWS * ROWS) for channel in radiance.T]
    cells = np.stack(sums, axis=-1).reshape(ROWS, -1, 3) / np.maximum(counts, 1)[..., None]
    # Repeat the columns, so that the nearest direction may lie across the seam.
    empty = np.tile(counts == 0, 3)
    nearest = distance_transform_edt(empty, return_distances=False, return_indices=True)
    filled = np.tile(cells, (1, 3, 1))[tuple(nearest)]
    return np.float32(np.maximum(filled[:, 2 * ROWS : 4 * ROWS], 0))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    points = of_camera(Camera(rough_size=Camera().size), is_mirror=False)
    paths = {name: next((folder / name).glob("*.exr")) for name in ("mirror", *MATERIALS)}
    world = map_of_mirror(pixels_of(paths["mirror"]), points)
    some = np.flatnonzero((points.normals * points.views).sum(axis=1) > 0.5)[::13]
    normals, views = points.normals[some], points.views[some]
    for name, materials in MATERIALS.items():
        truth = pixels_of(paths[name])[some]
        for what, (base, specular, roughness) in materials.items():
            image = base / np.pi * el.EnvMap(world).probe(normals)
            if specular:
                surface = {"roughness": roughness, "specular": specular}
                image = image + el.kernels.rough_reflection(world, normals, views, **surface)
            error = np.sqrt(((image - truth) ** 2).mean() / (truth**2).mean())
            print(f"{name}, {what}: {error:.2%}")


if __name__ == "__main__":
    main()
