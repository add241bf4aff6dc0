"""Overlay of the shadows of solids on a floor, for blending."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common import html
from envlights._common.arrays import freeze
from envlights._common.check import check_choice, reals
from envlights._common.files import as_path
from envlights._common.result import Result
from envlights._common.srgb import encode_srgb, linear_of
from envlights._native import EnvLightsError
from envlights.environment.files.image_output import write_codes, write_exr

#: Ways to draw the shadow over the picture of a floor, from exact to rough.
BLENDINGS = ("multiply", "alpha", "black", "product", "codes")
_MEANING = {
    "multiply": "linear radiance times the ratio of each channel",
    "alpha": "one alpha and a colour, in linear light",
    "black": "black with one alpha, in linear light",
    "product": "one overlay for each light, in linear light",
    "codes": "sRGB codes times the ratio of each channel",
}
#: Smallest hidden fraction of a pixel that counts as shadow.
_IN_SHADOW = 1e-3
#: Columns of the picture in a notebook.
_COLUMNS = 192


@dataclass(frozen=True, eq=False, repr=False)
class ShadowOverlay(Result):
    r"""Ratios of the radiance of a floor with and without solids on it.

    Examples
    --------
    >>> import envlights as el
    >>> rig = el.Rig([0.1, 0.1, 0.1], el.Lights([[0.6, 0.8, 0]], [[2, 2, 2]]), error=0.0)
    >>> ball = el.scene.Ball((0, 0.5, 0), 0.5)
    >>> el.scene.shadow_overlay(rig, ball, [[0, 0, 0], [1, 0, 0]]).ratio.round(4)
    array([[0.    , 0.    , 0.    ],
           [0.9853, 0.9853, 0.9853]])
    """

    points: NDArray[np.float64]
    """Points of the floor, (..., 3): (n, 3), or (height, width, 3) for a picture."""

    irradiance: NDArray[np.float64]
    """Irradiance of the floor without solids, (3,)."""

    single: NDArray[np.float64]
    """Ratio with one source hidden alone, (1 + m, ..., 3): the ambient term, then each light."""

    ratio: NDArray[np.float64]
    """Ratio with all sources hidden, (..., 3), and with reflected light if it was requested."""

    floor_albedo: NDArray[np.float64]
    """Reflectance of the floor, (3,)."""

    covered: NDArray[np.bool_]
    """Points under a solid, (...), from which no sky is visible."""

    notes: tuple[str, ...] = field(default=())
    """Notes on assumptions."""

    def __post_init__(self) -> None:
        for name in ("points", "irradiance", "single", "ratio", "floor_albedo"):
            object.__setattr__(self, name, freeze(np.asarray(getattr(self, name), np.float64)))
        object.__setattr__(self, "covered", freeze(np.asarray(self.covered, np.bool_)))

    @property
    def radiance(self) -> NDArray[np.float64]:
        """Radiance of the floor without solids, (3,)."""
        return self.floor_albedo / np.pi * self.irradiance

    @property
    def alpha(self) -> NDArray[np.float64]:
        """Alpha for standard blending, (...): 1 minus the smallest ratio of a channel."""
        return np.asarray(1 - np.clip(self.ratio, 0, 1).min(axis=-1))

    @property
    def colour(self) -> NDArray[np.float64]:
        """Colour for standard blending, linear, (..., 3); black where alpha is 0.

        ``alpha * colour + (1 - alpha) * radiance`` is the exact shadow on a floor of `radiance`.
        """
        alpha = self.alpha[..., None]
        return np.divide(
            self.radiance * (self.ratio - 1 + alpha),
            alpha,
            out=np.zeros_like(self.ratio),
            where=alpha > 0,
        )

    def over(
        self, background: ArrayLike | None = None, blending: str = "multiply"
    ) -> NDArray[np.float64]:
        """Draw the shadow over the picture of a floor.

        Parameters
        ----------
        background : array_like, shape (..., 3), optional
            Linear radiance of the floor without solids. Default: `radiance`.
        blending : {"multiply", "alpha", "black", "product", "codes"}
            "multiply" is exact. "alpha" is exact on a floor of `radiance`, and "product" where one
            source is hidden. "black" has the mean over the channels. "codes" multiplies sRGB codes,
            relative to the largest channel of the background.

        Returns
        -------
        ndarray, shape (..., 3)
            Radiance with the shadow.
        """
        check_choice("blending", blending, BLENDINGS)
        floor = self.radiance if background is None else _background(background)
        try:
            floor = np.broadcast_to(floor, self.ratio.shape)
        except ValueError:
            raise EnvLightsError(
                f"background must have the shape of the points, {self.ratio.shape}, or (3,);"
                f" got {floor.shape}"
            ) from None
        return self._blended(floor, blending)

    def _blended(self, floor: NDArray[np.float64], blending: str) -> NDArray[np.float64]:
        if blending == "alpha":
            alpha = self.alpha[..., None]
            return np.asarray(alpha * self.colour + (1 - alpha) * floor)
        if blending == "black":
            return np.asarray(floor * self.ratio.mean(axis=-1, keepdims=True))
        if blending == "product":
            return np.asarray(floor * self.single.prod(axis=0))
        if blending == "codes":
            white = floor.max(initial=0.0) or 1.0
            coded = encode_srgb(floor / white) * np.clip(self.ratio, 0, 1)
            return np.asarray(white * linear_of(coded))
        return np.asarray(floor * self.ratio)

    def code_errors(self, background: ArrayLike | None = None) -> dict[str, tuple[float, float]]:
        """Mean and largest error of each blending in shadow, in 8-bit sRGB codes.

        White is the largest channel of the background. Points under a solid do not count.
        """
        exact = self.over(background)
        floor = self.radiance if background is None else _background(background)
        white = floor.max(initial=0.0) or 1.0
        is_dark = (1 - self.ratio > _IN_SHADOW).any(axis=-1) & ~self.covered
        errors = {}
        for blending in BLENDINGS:
            pair = (encode_srgb(each / white) for each in (self.over(background, blending), exact))
            difference = 255 * np.abs(np.subtract(*pair))[is_dark]
            mean = float(difference.mean()) if difference.size else 0.0
            errors[blending] = mean, float(difference.max(initial=0.0))
        return errors

    def save(self, path: str | os.PathLike[str], blending: str = "alpha") -> None:
        """Write a picture of the overlay as EXR or PNG; a failure leaves no file.

        Parameters
        ----------
        path : path-like
            ``.exr``: linear, 32 bits, colour multiplied by alpha. ``.png``: sRGB, 8 bits, where
            alpha is linear, colour is not multiplied by it, and white is the largest channel of
            `radiance`. Blend in linear light.
        blending : {"alpha", "multiply"}
            "alpha": `colour` and `alpha`, for a floor of `radiance`. "multiply": `ratio`, for a
            floor of any colour.

        Raises
        ------
        EnvLightsError
            If the points are not a picture, or the suffix is another.
        """
        check_choice("blending", blending, BLENDINGS[1::-1])
        suffix = as_path(path).suffix.lower()
        if suffix not in (".exr", ".png"):
            raise EnvLightsError(f"cannot save {path}; the suffix must be .exr or .png")
        if self.ratio.ndim != 3:
            raise EnvLightsError(
                "only a picture can be saved, with points of the shape (height, width, 3);"
                f" got {self.points.shape}"
            )
        colour, alpha = (self.ratio, None) if blending == "multiply" else (self.colour, self.alpha)
        if suffix == ".exr":
            planes = [colour] if alpha is None else [colour * alpha[..., None], alpha[..., None]]
            write_exr(path, np.concatenate(planes, axis=-1).astype(np.float32))
            return
        white = 1.0 if alpha is None else self.radiance.max() or 1.0
        coded = [encode_srgb(colour / white)] + ([] if alpha is None else [alpha[..., None]])
        write_codes(path, np.rint(255 * np.concatenate(coded, axis=-1)).astype(np.uint8))

    def in_short(self) -> str:
        """Number of points, lights and the darkest ratio."""
        size = "x".join(str(side) for side in self.points.shape[-2::-1])
        lights = len(self.single) - 1
        darkest = float(self.ratio.min(initial=1.0))
        names = f"ambient + {lights} light{'' if lights == 1 else 's'}"
        return f"{size} points under {names}, smallest ratio {darkest:.3g}"

    def __str__(self) -> str:
        lines = ["blending    mean error  largest, in 8-bit codes in shadow"]
        for name, (mean, largest) in self.code_errors().items():
            lines.append(f"{name:<10} {mean:>11.2f} {largest:>8.2f}  {_MEANING[name]}")
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    def _html_parts(self) -> Iterable[str]:
        if self.ratio.ndim == 3:
            step = -(-self.ratio.shape[1] // _COLUMNS)
            floor = self.over()[::step, ::step] / (self.radiance.max() or 1.0)
            codes = np.rint(255 * encode_srgb(floor)).astype(np.uint8)
            yield html.picture(codes, "floor with the shadows")
        yield html.lines(str(self))


def _background(values: ArrayLike) -> NDArray[np.float64]:
    """Linear radiance of a floor; raises an error for other values."""
    array = reals("background", values, None)
    if array.shape[-1:] != (3,) or not np.isfinite(array).all() or (array < 0).any():
        raise EnvLightsError(
            "background must be finite radiance, not negative, with three channels;"
            f" got the shape {array.shape}"
        )
    return array
