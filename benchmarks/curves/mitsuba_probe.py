"""A white probe at any normals, rendered by Mitsuba."""

import numpy as np
from tests.reference.mitsuba_images import film, rgb

from envlights.scene.mitsuba.renderer import mitsuba

#: Distance and size of the white squares, one for each normal: they hide nothing of each other.
_APART, _SIDE = 100.0, 0.01


class Probe:
    """The squares under one map, and a sensor that looks at each; `render` is what is timed."""

    def __init__(self, radiance, normals, threads):
        with mitsuba() as mi:
            import drjit

            drjit.set_thread_count(threads)
            places = _APART * np.arange(len(normals))[:, None] * [1.0, 0.0, 0.0]
            sky = {"type": "envmap", "bitmap": mi.Bitmap(on_the_poles(radiance))}
            rows = enumerate(zip(places, normals, strict=True))
            squares = {f"square_{k:04}": _square(mi, *row) for k, row in rows}
            self.scene = mi.load_dict({"type": "scene", "sky": sky, **squares})
            rows = enumerate(zip(places, normals, strict=True))
            sensors = {f"sensor_{k:04}": _sensor(*row) for k, row in rows}
            batch = {
                "type": "batch",
                "film": film(len(normals)),
                "sampler": {"type": "independent"},
            }
            self.sensor = mi.load_dict({**batch, **sensors})
            integrator = {"type": "direct", "emitter_samples": 1, "bsdf_samples": 1}
            self.integrator = mi.load_dict(integrator)

    def render(self, samples, seed=0):
        """Irradiance at each normal, (n, 3): pi times the radiance of a white square."""
        with mitsuba() as mi:
            image = mi.render(
                self.scene, sensor=self.sensor, integrator=self.integrator, spp=samples, seed=seed
            )
            (row,) = np.array(image, float)
        return np.pi * row


def _square(mi, place, normal):
    frame = mi.ScalarTransform4f().look_at(
        origin=list(place), target=list(place + normal), up=_across(normal)
    )
    white = {"type": "diffuse", "reflectance": rgb([1.0, 1.0, 1.0])}
    return {
        "type": "rectangle",
        "to_world": frame @ mi.ScalarTransform4f().scale(_SIDE),
        "b": white,
    }


def _sensor(place, normal):
    origin = list(place + _SIDE * normal)
    return {"type": "radiancemeter", "origin": origin, "direction": list(-normal), "film": film(1)}


def _across(normal):
    """A direction that is not along the normal."""
    return list(np.eye(3)[np.abs(normal).argmin()])


def on_the_poles(radiance):
    """The map with its first and last row on the poles, as Mitsuba reads one; flux is kept."""
    height = len(radiance)
    cells = np.cos(np.pi * np.arange(height + 1) / height)
    samples = np.cos(np.pi * np.clip((np.arange(height + 1) - 0.5) / (height - 1), 0, 1))
    top = np.minimum(samples[:-1, None], cells[:-1])
    bottom = np.maximum(samples[1:, None], cells[1:])
    shares = np.maximum(top - bottom, 0)
    shares /= shares.sum(axis=1, keepdims=True)
    return np.einsum("ij,jxc->ixc", shares, radiance).astype(np.float32)
