"""What Mitsuba itself sees of the courtyard under a rig: eyes above its texels."""

import mitsuba as mi
import numpy as np

import envlights as el
from envlights.kernels import harmonic_radiance
from envlights.scene.renderer import mitsuba


def relative(image, truth):
    return np.linalg.norm(image - truth) / np.linalg.norm(truth)


def film(width):
    box = {"type": "box"}
    return {"type": "hdrfilm", "width": width, "height": 1, "pixel_format": "rgb", "rfilter": box}


def sky(coefficients, height=128):
    """A map of Mitsuba's; its first and last row lie on the poles."""
    phi = 2 * np.pi * (np.arange(2 * height) + 0.5) / (2 * height)
    theta = np.pi * np.arange(height)[:, None] / (height - 1)
    x, z = np.sin(phi) * np.sin(theta), -np.cos(phi) * np.sin(theta)
    y = np.broadcast_to(np.cos(theta), x.shape)
    radiance = harmonic_radiance(np.stack([x, y, z], axis=-1).reshape(-1, 3)) @ coefficients
    return mi.Bitmap(radiance.reshape(height, 2 * height, 3).astype(np.float32))


def rgb(values):
    return {"type": "rgb", "value": list(values)}


def each_emitter(rig):
    """Mitsuba draws one emitter for each sample; each for itself leaves no noise of that draw."""
    if rig.ambient.ndim == 2:
        yield {"type": "envmap", "bitmap": sky(rig.ambient)}, 16
    else:
        yield {"type": "constant", "radiance": rgb(rig.ambient)}, 16
    for direction, irradiance in zip(rig.lights.direction, rig.lights.irradiance, strict=True):
        light = {"type": "directional", "direction": list(-direction)}
        yield {**light, "irradiance": rgb(irradiance)}, 1


def eyes_above(surface):
    """A sensor a centimetre above each texel that looks at it."""
    points, normals = surface.position[surface.covered], surface.normal[surface.covered]
    small = mi.load_dict(film(1))
    eyes = {
        f"eye_{k:06}": {
            "type": "radiancemeter",
            "origin": list(point + 0.01 * normal),
            "direction": list(-normal),
            "film": small,
        }
        for k, (point, normal) in enumerate(zip(points, normals, strict=True))
    }
    sampler = {"type": "independent"}
    return mi.load_dict({"type": "batch", "film": film(len(eyes)), "sampler": sampler, **eyes})


def looked_at(surface, rigs, depth, effort=1, seeds=(1, 2)):
    """What Mitsuba sees of each texel under each of the rigs: (seeds, H, W, 3)."""
    with mitsuba():
        eyes = eyes_above(surface)
        path = mi.load_dict({"type": "path", "max_depth": depth})
        for rig in rigs:
            images = np.zeros((len(seeds), *surface.albedo.shape))
            for emitter, samples in each_emitter(rig):
                scene = mi.load_dict({**el.synthetic.courtyard(), "emitter": emitter})
                spp = effort * samples
                for image, seed in zip(images, seeds, strict=True):
                    seen = mi.render(scene, sensor=eyes, integrator=path, spp=spp, seed=seed)
                    image[surface.covered] += np.array(seen)[0]
            yield images


def noise_of(one, two):
    """Of their mean, relative to it."""
    return np.linalg.norm(one - two) / np.linalg.norm(one + two)
