"""The courtyard under a rig as Mitsuba renders it: a sensor above each texel."""

import mitsuba as mi
import numpy as np

import envlights as el
from envlights.kernels import harmonic_radiance
from envlights.scene.mitsuba.renderer import mitsuba


def relative(image, truth):
    """Norm of the difference over the norm of the truth."""
    return np.linalg.norm(image - truth) / np.linalg.norm(truth)


def film(width):
    box = {"type": "box"}
    return {"type": "hdrfilm", "width": width, "height": 1, "pixel_format": "rgb", "rfilter": box}


def sky(coefficients, height=128):
    """Spherical harmonics as an environment map of Mitsuba: first and last row lie on the poles."""
    phi = 2 * np.pi * (np.arange(2 * height) + 0.5) / (2 * height)
    theta = np.pi * np.arange(height)[:, None] / (height - 1)
    x, z = np.sin(phi) * np.sin(theta), -np.cos(phi) * np.sin(theta)
    y = np.broadcast_to(np.cos(theta), x.shape)
    radiance = harmonic_radiance(np.stack([x, y, z], axis=-1).reshape(-1, 3)) @ coefficients
    return mi.Bitmap(radiance.reshape(height, 2 * height, 3).astype(np.float32))


def rgb(values):
    return {"type": "rgb", "value": list(values)}


def each_emitter(rig):
    """Yield each emitter of a rig, and the samples that it needs.

    Mitsuba draws one emitter for each sample; one emitter alone leaves no noise of that draw.
    """
    if rig.ambient.ndim == 2:
        yield {"type": "envmap", "bitmap": sky(rig.ambient)}, 16
    else:
        yield {"type": "constant", "radiance": rgb(rig.ambient)}, 16
    lights = rig.lights
    rows = zip(lights.direction, lights.irradiance, lights.angular_radius, strict=True)
    for direction, irradiance, radius in rows:
        if radius:
            yield far_sphere(direction, irradiance, radius), 16
            continue
        light = {"type": "directional", "direction": list(-direction)}
        yield {**light, "irradiance": rgb(irradiance)}, 1


def far_sphere(direction, irradiance, radius, distance=1e5):
    """A disc as a sphere so far away that it looks the same from everywhere in the courtyard."""
    sine = np.sin(radius)
    return {
        "type": "sphere",
        "center": list(distance * direction),
        "radius": float(distance * sine),
        "bsdf": {"type": "diffuse", "reflectance": rgb([0, 0, 0])},
        "emitter": {"type": "area", "radiance": rgb(irradiance / (np.pi * sine**2))},
    }


def sensors_above(surface):
    """Return a sensor a centimetre above each texel that looks at it."""
    points, normals = surface.position[surface.covered], surface.normal[surface.covered]
    small = mi.load_dict(film(1))
    sensors = {
        f"sensor_{k:06}": {
            "type": "radiancemeter",
            "origin": list(point + 0.01 * normal),
            "direction": list(-normal),
            "film": small,
        }
        for k, (point, normal) in enumerate(zip(points, normals, strict=True))
    }
    batch = {"type": "batch", "film": film(len(sensors)), "sampler": {"type": "independent"}}
    return mi.load_dict({**batch, **sensors})


def texels_by_mitsuba(surface, rigs, depth, effort=1, seeds=(1, 2)):
    """Yield the texels that Mitsuba renders under each of the rigs, (seeds, H, W, 3)."""
    with mitsuba():
        sensors = sensors_above(surface)
        path = mi.load_dict({"type": "path", "max_depth": depth})
        for rig in rigs:
            images = np.zeros((len(seeds), *surface.albedo.shape))
            for emitter, samples in each_emitter(rig):
                scene = mi.load_dict({**el.synthetic.courtyard(), "emitter": emitter})
                spp = effort * samples
                for image, seed in zip(images, seeds, strict=True):
                    rendered = mi.render(scene, sensor=sensors, integrator=path, spp=spp, seed=seed)
                    image[surface.covered] += np.array(rendered)[0]
            yield images


def noise_of(one, two):
    """Noise of the mean of two images, relative to it."""
    return np.linalg.norm(one - two) / np.linalg.norm(one + two)
