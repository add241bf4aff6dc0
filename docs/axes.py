"""Draw the pictures of axes.md: `python docs/axes.py`, with the extra `bake`."""

from pathlib import Path

import mitsuba as mi
import numpy as np

import envlights as el

HERE = Path(__file__).parent
SIZE = (360, 180)


def three_lights() -> el.Lights:
    """Red from +x, green from +y, blue from +z."""
    return el.Lights(np.eye(3), 2.5 * np.eye(3))


def three_spots() -> el.EnvMap:
    """A dim map with the same colours in the same places."""
    discs = el.Lights(np.eye(3), 0.2 * np.eye(3), [0.25] * 3)
    return el.Rig([0.05, 0.05, 0.05], discs, 0.0).to_map(256)


def balls() -> np.ndarray:
    """A matt ball under the lights and a mirror ball under the map, seen from (1, 1, 1)."""
    place = mi.ScalarTransform4f()
    aside = 1.1 * np.array([1, 0, -1]) / np.sqrt(2)
    white = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.8] * 3}}
    scene = {
        "type": "scene",
        **el.export.mitsuba(three_lights(), three_spots()),
        "matt": {"type": "sphere", "to_world": place.translate(-aside), "bsdf": white},
        "mirror": {
            "type": "sphere",
            "to_world": place.translate(aside),
            "bsdf": {"type": "conductor", "specular_reflectance": {"type": "rgb", "value": 0.4}},
        },
        "eye": {
            "type": "perspective",
            "fov": 25,
            "to_world": place.look_at([6, 6, 6], [0, 0, 0], [0, 1, 0]),
            "film": {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1]},
        },
        "integrator": {"type": "path"},
    }
    return np.array(mi.render(mi.load_dict(scene), spp=256))[..., :3]


def main() -> None:
    """Draw both pictures."""
    mi.set_variant("scalar_rgb")
    el.plot.save(el.plot.axes_picture(), HERE / "axes.png")
    mi.util.write_bitmap(str(HERE / "axes_mitsuba.png"), balls(), write_async=False)


if __name__ == "__main__":
    main()
