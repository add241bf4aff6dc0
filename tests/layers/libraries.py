"""Array libraries under test, and random lights in them."""

import importlib.util

import numpy as np
import pytest

from envlights.layers import Lights


def to_numpy64(values):
    return np.asarray(values, np.float64)


def to_jax(values, dtype="float64"):
    import jax

    jax.config.update("jax_enable_x64", True)
    return jax.numpy.asarray(values, dtype)


def to_torch(values, dtype="float64"):
    import torch

    return torch.as_tensor(np.array(values), dtype=getattr(torch, dtype))


LIBRARIES = {"numpy": to_numpy64, "jax": to_jax, "torch": to_torch}
#: Parametrise over libraries; those that are not installed are skipped.
in_each_library = pytest.mark.parametrize(
    "convert",
    [
        pytest.param(
            convert,
            id=name,
            marks=pytest.mark.skipif(importlib.util.find_spec(name) is None, reason=f"no {name}"),
        )
        for name, convert in LIBRARIES.items()
    ],
)


def in_library(lights, convert):
    """Lights in another library."""
    return Lights(*(each if each is None else convert(each) for each in lights))


def random_lights(seed, lights=6, ambient="constant", batch=()):
    """Discs of 0.06 to 80 degrees in float64, with directions of any length."""
    rng = np.random.default_rng(seed)
    shape = (*batch, lights)
    sky = rng.uniform(0, 1, (*batch, 3))
    if ambient == "sh2":
        sky = 0.1 * rng.normal(size=(*batch, 9, 3))
        sky[..., 0, :] = 3
    return Lights(
        rng.normal(size=(*shape, 3)),
        rng.uniform(0.1, 3, (*shape, 3)),
        np.exp(rng.uniform(np.log(1e-3), np.log(1.4), shape)),
        sky,
    )


def slopes_and_differences(loss, seeds, step):
    """Derivatives of `loss` along random changes of all arrays, beside central differences."""
    import jax

    value, slopes = jax.jit(loss), jax.jit(jax.grad(loss))
    for seed in seeds:
        rng, lights = np.random.default_rng(seed), random_lights(seed)
        radius = lights.angular_radius
        length = np.linalg.norm(lights.direction, axis=-1) * radius
        changes = (
            rng.normal(size=lights.direction.shape) * length[..., None],
            rng.normal(size=lights.irradiance.shape),
            rng.normal(size=radius.shape) * radius,
            rng.normal(size=lights.ambient.shape),
        )
        ends = [
            Lights(*(x + s * y for x, y in zip(lights[:4], changes, strict=True)))
            for s in (step, -step)
        ]
        one, other = (float(value(in_library(end, to_jax))) for end in ends)
        products = (
            np.sum(np.asarray(slope) * change)
            for slope, change in zip(slopes(in_library(lights, to_jax))[:4], changes, strict=True)
        )
        yield sum(products), (one - other) / (2 * step)
