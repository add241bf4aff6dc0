"""Adapters for array libraries: constants, loops, explicit derivatives, work on the CPU."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from envlights._native import EnvLightsError

try:
    from array_api_compat import array_namespace, is_cupy_array, is_jax_array, is_torch_array
except ModuleNotFoundError:
    raise EnvLightsError(
        "layers need array-api-compat: pip install 'envlights[layers]', or array-api-compat"
    ) from None

#: Array of NumPy, JAX, torch or CuPy.
Array = Any


def namespace(*arrays: Array) -> Any:
    """Array API namespace of the given arrays."""
    try:
        return array_namespace(*arrays)
    except TypeError as error:
        raise EnvLightsError(f"lights must be arrays of one library; {error}") from None


def constant(values: Any, like: Array) -> Array:
    """Array of the library, type and device of `like`."""
    if is_torch_array(like):
        import torch

        return torch.as_tensor(values, dtype=like.dtype, device=like.device)
    return namespace(like).asarray(values, dtype=like.dtype)


def scan(step: Callable[..., Any], first: Any, rows: tuple[Any, ...], like: Array) -> list[Array]:
    """Stacked outputs of ``state, outputs = step(state, row)`` over rows, compiled once by JAX."""
    rows = tuple(constant(each, like) for each in rows)
    if is_jax_array(like):
        import jax

        return list(jax.lax.scan(step, first, rows)[1])
    outputs, state = [], first
    for row in zip(*rows, strict=True):
        state, output = step(state, row)
        outputs.append(output)
    return [namespace(like).stack(each) for each in zip(*outputs, strict=True)]


def with_derivatives(function: Callable[..., Any], *arrays: Array) -> Array:
    """Value of ``value, derivatives = function(xp, *arrays)``, with these explicit derivatives."""
    if is_torch_array(arrays[0]):
        return _for_torch(function).apply(*arrays)
    xp = namespace(*arrays)
    if not is_jax_array(arrays[0]):
        return function(xp, *arrays)[0]
    import jax

    value = jax.custom_jvp(lambda *arrays: function(xp, *arrays)[0])

    @value.defjvp
    def derivative(arrays: Any, tangents: Any) -> Any:
        out, slopes = function(xp, *arrays)
        return out, sum(slope * change for slope, change in zip(slopes, tangents, strict=True))

    return value(*arrays)


@lru_cache
def _for_torch(function: Callable[..., Any]) -> Any:
    import torch

    class Function(torch.autograd.Function):  # type: ignore[misc, unused-ignore]
        @staticmethod
        def forward(context: Any, *arrays: Array) -> Array:
            out, slopes = function(namespace(*arrays), *arrays)
            context.save_for_backward(*slopes)
            context.shapes = [array.shape for array in arrays]
            return out

        @staticmethod
        def backward(context: Any, outer: Array) -> Any:
            pairs = zip(context.saved_tensors, context.shapes, strict=True)
            return tuple((outer * slope).sum_to_size(shape) for slope, shape in pairs)

    return Function


def on_host(function: Callable[..., Any], shape: tuple[int, ...], *arrays: Array) -> Array:
    """Result of a NumPy function without derivatives; works under `jax.jit`."""
    if not is_jax_array(arrays[0]):
        return constant(function(*map(to_numpy, arrays)), arrays[0])
    import jax

    kind = arrays[0].dtype
    out: Any = jax.ShapeDtypeStruct(shape, kind)  # type: ignore[no-untyped-call, unused-ignore]
    fixed = map(jax.lax.stop_gradient, arrays)
    call = lambda *values: function(*map(np.asarray, values)).astype(kind)  # noqa: E731
    return jax.pure_callback(call, out, *fixed, vmap_method="broadcast_all")


def to_numpy(array: Array) -> Any:
    """NumPy array of the same values."""
    if is_torch_array(array):
        array = array.detach().cpu()
    return np.asarray(array.get() if is_cupy_array(array) else array)
