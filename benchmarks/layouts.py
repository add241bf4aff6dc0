"""Layouts of maps beside py360convert, skylibs and OpenCV: suns, flux, time and memory.

Usage: python benchmarks/layouts.py [--suns] [--time] [--width N]

Suns: a cube of 64 with a sun of one pixel over an even world, one picture for each sun, to a map of
256x128 pixels, and such a map to a cube. `direction` is the distance of its light from its pixel,
in sides of the pixel: median and worst. `flux` is that of a sun over its own, `lost` counts those
below a hundredth, `whole` is the change of the flux of the even world with all suns.
Time: processor time over that of `EnvMap.rotated` of a map of the same size, the median of rounds
in one process; py360convert caches its coordinates. Memory: the peak of opening a cube over the
bytes of the cube and its map.

The peers are optional: py360convert is of the extra `peers`; skylibs is LGPL and installed by hand.
"""

import argparse
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from stopwatch import all_seconds, processor_seconds

import envlights as el
from envlights import _native
from envlights.environment.layouts.picture_layout import cube, equirectangular

sys.path.insert(0, str(Path(__file__).parents[1]))
from tests.layouts import suns
from tests.layouts.worlds import upright_directions

FACE, WIDTH = 64, 256
#: Radiance of a sun over a world of 1.
SUN = 5e4
TURN = [[0.36, 0.48, -0.8], [-0.8, 0.6, 0], [0.48, 0.64, 0.6]]
#: Cube of the programs that are compared.
CUBE = el.io.Layout.cube(faces="py360convert", registration="cell-centred")


def ours_in(stack, width):
    """Map of a stack of six upright faces."""
    env = el.EnvMap(
        stack.reshape(6, -1, stack.shape[1], 3),
        layout=CUBE,
        width=width,
    )
    return env.radiance


def ours_out(radiance, n):
    """Stack of six upright faces of a map."""
    return el.EnvMap(radiance).to(CUBE, width=n).array


def py360convert_in(stack, width):
    import py360convert

    faces = stack.reshape(6, -1, stack.shape[1], 3).astype(np.float32)
    return py360convert.c2e(list(faces), width // 2, width, cube_format="list")


def py360convert_out(radiance, n):
    import py360convert

    return np.concatenate(py360convert.e2c(radiance, n, cube_format="list"))


def skylibs_in(stack, width):
    from envmap import EnvironmentMap

    cross = _cross(stack)
    return EnvironmentMap(cross.astype(np.float32), "cube").convertTo("latlong", width // 2).data


def skylibs_out(radiance, n):
    from envmap import EnvironmentMap

    cross = EnvironmentMap(radiance, "latlong").convertTo("cube", 4 * n).data
    return np.concatenate(
        [face[::-1, ::-1] if turned else face for face, turned in _faces_of_cross(cross, n)]
    )


def _cross(stack):
    """Vertical cross of a stack, its back face turned by 180 degrees."""
    n = stack.shape[1]
    cross = np.zeros((4 * n, 3 * n, 3), stack.dtype)
    for (place, turned), face in zip(_PLACES, stack.reshape(6, n, n, 3), strict=True):
        row, column = place
        cross[row * n : (row + 1) * n, column * n : (column + 1) * n] = (
            face[::-1, ::-1] if turned else face
        )
    return cross


#: Row and column of front, right, back, left, up and down, and True for the one that is turned.
_PLACES = (
    ((1, 1), False),
    ((1, 2), False),
    ((3, 1), True),
    ((1, 0), False),
    ((0, 1), False),
    ((2, 1), False),
)


def _faces_of_cross(cross, n):
    for (row, column), turned in _PLACES:
        yield cross[row * n : (row + 1) * n, column * n : (column + 1) * n], turned


def remap_in(stack, width):
    """Bilinear look-up of OpenCV; each face is a picture of its own with copied borders."""
    import cv2

    places, faces = _places_in_cube(stack.shape[1], width)
    new = np.zeros((width // 2, width, 3), np.float32)
    for face, picture in enumerate(stack.reshape(6, stack.shape[1], stack.shape[1], 3)):
        inside = faces == face
        x, y = (np.where(inside, values, 0).astype(np.float32) for values in places)
        sampled = cv2.remap(picture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        new[inside] = sampled[inside]
    return new


def _places_in_cube(n, width):
    """Pixel coordinates in its face of each cell of a map, and the number of the face."""
    from envlights.kernels import pixel_directions

    directions = pixel_directions(width // 2, width).reshape(-1, 3)
    places = _native.projection_places(cube(n), directions)
    faces = np.minimum(places[:, 1] // n, 5).astype(int)
    x, y = places[:, 0] - 0.5, places[:, 1] - faces * n - 0.5
    shape = (width // 2, width)
    return (x.reshape(shape), y.reshape(shape)), faces.reshape(shape)


def remap_out(radiance, n):
    """Bilinear look-up of OpenCV, across the seam."""
    import cv2

    height, width, _ = radiance.shape
    x, y, z = np.moveaxis(upright_directions(n).reshape(6 * n, n, 3), -1, 0)
    u = (np.arctan2(x, -z) % (2 * np.pi)) / (2 * np.pi) * width - 0.5
    v = np.arccos(y) / np.pi * height - 0.5
    wide = np.concatenate([radiance[:, -1:], radiance, radiance[:, :1]], axis=1)
    return cv2.remap(
        wide,
        (u + 1).astype(np.float32),
        v.astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )


WAYS = {
    "envlights": (ours_in, ours_out, "envlights"),
    "py360convert": (py360convert_in, py360convert_out, "py360convert"),
    "skylibs": (skylibs_in, skylibs_out, "envmap"),
    "cv2.remap": (remap_in, remap_out, "cv2"),
}


def table_of_suns():
    """Print what each converter makes of suns, into the map and out of it."""
    maps = equirectangular(WIDTH // 2)
    for title, source, grid, which in (
        (f"cube {FACE} to map {WIDTH}", cube(FACE), suns.grid_of_map(WIDTH), 0),
        (f"map {WIDTH} to cube {FACE}", maps, suns.grid_of(cube(FACE)), 1),
    ):
        some = sample_of_suns(source)
        print(f"\n{title}, {len(some)} suns")
        print(f"{'':<16}{'direction':>18}{'flux of a sun':>20}{'lost':>6}{'whole':>9}")
        for name, ways in WAYS.items():
            if find_spec(ways[2]) is None:
                print(f"{name:<16}{'not installed':>18}")
                continue
            size = WIDTH if which == 0 else FACE
            print(f"{name:<16}{row(ways[which], size, source, some, grid)}", flush=True)


def row(convert, size, source, some, grid):
    """Columns of one converter."""
    angles = _native.projection_solid_angles(source)
    even = np.ones((source.height, source.width, 3), np.float32)
    before = np.asarray(convert(even, size), float)
    offsets, fluxes = [], []
    for first in range(0, len(some), 3):
        picture = even.copy()
        for channel, sun in enumerate(some[first : first + 3]):
            picture[sun.pixel][channel] += SUN
        new = np.asarray(convert(picture, size), float) - before
        for channel, sun in enumerate(some[first : first + 3]):
            light = np.where(np.abs(new[..., channel]) > 1e-4, new[..., channel], 0).clip(0)
            found = suns.measure(light, grid, sun, SUN * angles[sun.pixel])
            fluxes.append(found.flux)
            offsets.append(found.offset)
    offsets, fluxes = np.array(offsets), np.array(fluxes)
    held = offsets[fluxes >= 0.01]
    picture = even[..., 0].copy()
    for sun in some:
        picture[sun.pixel] += SUN
    own = (picture * angles).sum()
    whole = np.asarray(convert(np.repeat(picture[..., None], 3, axis=2), size), float)[..., 0]
    change = (whole * grid.solid_angles).sum() / own - 1
    return (
        f"{np.median(held):>9.3f}{held.max():>9.3f}{fluxes.min():>11.3f} ..{fluxes.max():>6.3f}"
        f"{int((fluxes < 0.01).sum()):>6}{change:>+9.1e}"
    )


def sample_of_suns(source):
    """150 random pixels of a layout, and seven on edges, corners and poles."""
    rng = np.random.default_rng(4)
    pixels = list(
        zip(rng.integers(0, source.height, 150), rng.integers(0, source.width, 150), strict=True)
    )
    if source.kind == "cube":
        n = source.width
        special = [(0, 0), (0, n // 2), (n // 2, n - 1), (2 * n - 1, 0), (4 * n, 5)]
        pixels += [*special, (4 * n + n // 2, n // 2), (6 * n - 1, n - 1)]
    else:
        h, w = source.height, source.width
        pixels += [
            (0, 0),
            (0, w // 3),
            (h - 1, 7),
            (1, w - 1),
            (h // 2, 0),
            (h // 2, w - 1),
            (5, 9),
        ]
    return [suns.sun_of(source, tuple(map(int, pixel))) for pixel in pixels]


def table_of_times(width, rounds):
    """Print processor time over that of a rotation."""
    n = width // 4
    rng = np.random.default_rng(0)
    radiance = rng.gamma(0.5, 1, (width // 2, width, 3)).astype(np.float32)
    stack = rng.gamma(0.5, 1, (6 * n, n, 3)).astype(np.float32)
    env = el.EnvMap(radiance)
    work = {"EnvMap.rotated": lambda: env.rotated(TURN)}
    work["envlights, cube to map"] = lambda: ours_in(stack, width)
    work["envlights, map to cube"] = lambda: env.to(CUBE, width=n)
    for name in ("py360convert", "skylibs", "cv2.remap"):
        into, out, module = WAYS[name]
        if find_spec(module) is not None:
            work[f"{name}, cube to map"] = lambda into=into: into(stack, width)
            work[f"{name}, map to cube"] = lambda out=out: out(radiance, n)
    seconds = all_seconds(work, rounds, patience=1e9, clock=processor_seconds, fewest=rounds)
    base = np.array(seconds["EnvMap.rotated"])
    print(f"\n{width}x{width // 2} pixels and a cube of {n}: processor time over EnvMap.rotated")
    for name, each in seconds.items():
        print(f"  {name:<30}{np.median(np.array(each) / base):>7.2f} x{np.median(each):>9.2f} s")


def peak_of_opening(path):
    """Peak memory of opening a cube, in bytes."""
    from memory import peak

    return peak(lambda: el.EnvMap.open(path))


def table_of_memory(width):
    """Print the peak of opening a file, over picture and map."""
    from memory import alone

    n = width // 4
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cube.exr"
        picture = el.EnvMap(np.ones((64, 128, 3))).to(el.io.Layout.cube(faces="openexr"), width=n)
        picture.save(path, compression="none")
        used = alone(peak_of_opening, path)
    sizes = 12 * (picture.array.size // 3 + width * width // 2)
    print(f"\nopening a cube of {n}: {used / 1e6:.0f} MB, {used / sizes:.2f} times cube and map")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--suns", action="store_true", help="only suns")
    parser.add_argument("--time", action="store_true", help="only time and memory")
    parser.add_argument("--width", type=int, default=4096, help="columns of the map to time")
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    if not options.time:
        table_of_suns()
    if not options.suns:
        table_of_times(options.width, options.rounds)
        table_of_memory(options.width)


if __name__ == "__main__":
    main()
