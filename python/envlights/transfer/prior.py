"""Indirect light of a diffuse scene from its geometry, without training pairs.

With the form factors G from texels of the lightmap to direct texels, F among direct texels, the
fraction v of each direct texel that is not inside a solid, and the albedo rho of both,

    y = rho G V (I - rho_s F V)^-1 x,    V = diag(1 / v),

since a direct image averages hidden parts as black. For images of irradiance instead of reflected
radiance, y = G V (I - rho_s F V)^-1 rho_s x.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import count, flag
from envlights._common.result import Result
from envlights._native import EnvLightsError
from envlights.transfer.consistency import check_array, pixels_of
from envlights.transfer.expand import check_range
from envlights.transfer.files import npz_file
from envlights.transfer.files.npz_file import Kind
from envlights.transfer.pairs import image_stack, pairs_of, rgb_rows

#: Largest number of rays per texel, because a count has two bytes.
MOST_RAYS = 65535
#: Number of texels whose form factors are held as floats at once.
_BLOCK = 4096
#: Arrays in a file.
_ARRAYS = ("hits", "between", "visible", "albedo", "covered", "direct_albedo")
_KIND = Kind("prior", "envlights transfer prior", 1, (1,), (*_ARRAYS, "rays", "size", "irradiance"))
#: Relative rounding error of sums of fractions.
_ROUNDING = 1e-9
#: Assumptions of every prior.
_ASSUMED = "diffuse surfaces, the same light over each direct texel"


@dataclass(frozen=True, eq=False, repr=False)
class TransferPrior(Result):
    """Indirect light of a diffuse scene, from form factors (see `MitsubaScene.gather`).

    It holds for surfaces that reflect all light diffusely, with an albedo below 1, and takes the
    light as the same over each texel of the direct image. `TransferModel.fit` learns the remainder
    from pairs.
    """

    _is_headed = True

    hits: NDArray[np.uint16]
    """Number of rays from each texel of `covered` that hit each direct texel, (texels, h * w)."""

    rays: int
    """Number of rays per texel."""

    between: NDArray[np.float64]
    """Form factors between direct texels, (h * w, h * w): the fraction of the rays from each row
    that hit each column."""

    visible: NDArray[np.float64]
    """Fraction of each direct texel that is not inside a solid, (h * w,)."""

    albedo: NDArray[np.float64]
    """Reflectance of the texels of the indirect images, (H, W, 3)."""

    covered: NDArray[np.bool_]
    """Texels with a surface, (H, W); all other texels are predicted black."""

    direct_albedo: NDArray[np.float64]
    """Reflectance of the direct texels, (h * w, 3)."""

    size: tuple[int, int]
    """Height and width of the direct images."""

    irradiance: bool = False
    """True if the images hold irradiance instead of reflected radiance."""

    def __post_init__(self) -> None:
        count("rays", self.rays, least=1, most=MOST_RAYS)
        flag("irradiance", self.irradiance)
        pixels, shape = pixels_of(self.size), np.shape(self.covered)
        check_array("covered", self.covered, (*shape, 1, 1)[:2], ("bool",))
        texels = int(np.count_nonzero(self.covered))
        check_array("hits", self.hits, (texels, pixels), ("uint16",))
        for name, wanted in {
            "between": (pixels, pixels),
            "visible": (pixels,),
            "albedo": (*shape, 3),
            "direct_albedo": (pixels, 3),
        }.items():
            check_array(name, getattr(self, name), wanted, ("float64",))
        _check_albedo(self.albedo)
        _check_albedo(self.direct_albedo)
        _check_fractions("visible", self.visible)
        _check_fractions("between", self.between)
        _check_fractions("the sum of a row of between", self.between.sum(axis=1))
        hits = self.hits.sum(axis=1, dtype=np.int64) / self.rays
        _check_fractions("the sum of a row of hits over rays", hits)

    @cached_property
    def leaving(self) -> NDArray[np.float64]:
        """Matrix from direct light to the light that leaves each direct texel after all bounces.

        One matrix for each channel, (3, h * w, h * w). Light is that of the visible part, for
        direct images averaged with hidden parts.
        """
        fraction = np.divide(
            1.0, self.visible, out=np.zeros_like(self.visible), where=self.visible > 0
        )
        reflected = self.direct_albedo.T[:, :, None]
        bounced = _sum_of_bounces(reflected * (self.between * fraction))
        shown: NDArray[np.float64] = fraction[:, None] * bounced
        return shown * self.direct_albedo.T[:, None] if self.irradiance else shown

    def factors(self, texels: slice) -> NDArray[np.float32]:
        """Form factors of a slice of the covered texels, (texels, h * w)."""
        return np.asarray(self.hits[texels] / np.float32(self.rays), np.float32)

    @cached_property
    def strength(self) -> NDArray[np.float64]:
        """Norm of the indirect image that each direct texel causes, by channel, (3, h * w).

        Light that leaves several direct texels adds up in squares, as if their images were at right
        angles.
        """
        squares = np.zeros((3, len(self.visible)))
        for first in range(0, len(self.hits), _BLOCK):
            some = slice(first, first + _BLOCK)
            squares += self.reflectance[some].T ** 2 @ self.factors(some) ** 2
        return np.asarray(np.sqrt(np.einsum("cl,cls->cs", squares, self.leaving**2)))

    @cached_property
    def reflectance(self) -> NDArray[np.float32]:
        """Factor from gathered light to image values in the covered texels, (texels, 3)."""
        albedo = self.albedo[self.covered].astype(np.float32)
        return np.ones_like(albedo) if self.irradiance else albedo

    def gathered(self, light: NDArray[np.float64], texels: slice) -> NDArray[np.float32]:
        """Indirect light of a slice of the covered texels, (n, texels, 3).

        `light`: that leaves the direct texels, (n, 3, h * w).
        """
        n, _, pixels = light.shape
        seen = self.factors(texels) @ light.reshape(3 * n, pixels).astype(np.float32).T
        return seen.reshape(-1, n, 3).swapaxes(0, 1) * self.reflectance[texels]

    def bounces(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """Light that leaves the direct texels, for direct images (n, 3, h * w)."""
        light: NDArray[np.float64] = rows.swapaxes(0, 1) @ self.leaving.swapaxes(1, 2)
        return light.swapaxes(0, 1)

    def predict(self, direct: ArrayLike) -> NDArray[np.float32]:
        """Indirect light under new direct light, without training pairs.

        Parameters
        ----------
        direct : array_like, shape (h, w, 3 or 4) or (n, h, w, 3 or 4)
            One image or several, of the size of the direct images.

        Returns
        -------
        ndarray, shape (H, W, 3) or (n, H, W, 3)
            Linear RGB.
        """
        stack, is_one = image_stack("direct", direct, self.size, "prior")
        with np.errstate(over="ignore", invalid="ignore"):  # refused below
            light = self.bounces(rgb_rows(stack))
        # No texel is brighter than the brightest light, because factors and albedo are fractions.
        check_range(float(np.abs(light).max()), np.float32, "prior")
        out = np.zeros((len(stack), self.covered.size, 3), np.float32)
        places = np.flatnonzero(self.covered)
        for first in range(0, len(places), _BLOCK):
            some = slice(first, first + _BLOCK)
            out[:, places[some]] = self.gathered(light, some)
        images = out.reshape(len(stack), *self.covered.shape, 3)
        return images[0] if is_one else images

    def errors(self, direct: ArrayLike, indirect: ArrayLike) -> NDArray[np.float64]:
        """Relative error of the prior for each of the given pairs, without training on them.

        Parameters
        ----------
        direct : array_like, shape (k, h, w, 3 or 4)
            Direct light.
        indirect : array_like, shape (k, H, W, 3 or 4)
            Indirect light.

        Returns
        -------
        ndarray, shape (k,)
            Norm of the difference over that of the image; 0 for a black one.
        """
        pairs = pairs_of(direct, indirect)
        truth = image_stack("indirect", pairs.indirect, self.covered.shape, "prior")[0]
        seen = self.predict(direct)
        missed, norm = (
            np.linalg.norm(each.reshape(len(truth), -1), axis=1) for each in (seen - truth, truth)
        )
        errors: NDArray[np.float64] = np.divide(
            missed, norm, out=np.zeros(len(truth)), where=norm > 0
        )
        return errors

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the prior as one .npz file with a version; a failure leaves no file behind."""
        npz_file.write(path, _KIND, {name: np.asarray(vars(self)[name]) for name in _KIND.names})

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> TransferPrior:
        """Read a prior that `save` wrote; raises an error for another kind or version of file."""
        return npz_file.load(path, _KIND, _from_file)

    def in_short(self) -> str:
        """Sizes of the images, and number of rays."""
        (rows, columns), (height, width) = self.size, self.covered.shape
        return f"{columns}x{rows} to {width}x{height} pixels by {self.rays} rays a texel"

    def _lines(self) -> list[str]:
        light = "irradiance" if self.irradiance else "reflected radiance"
        hidden = np.count_nonzero(self.visible < 1)
        note = f"note: {hidden} direct texels are partly or wholly hidden or empty"
        return [f"images of {light}", f"assumed: {_ASSUMED}", *([note] if hidden else [])]


def _check_fractions(name: str, values: NDArray[np.float64]) -> None:
    """Refuse fractions below 0 or above 1, up to rounding, and NaN."""
    least, most = values.min(initial=0), values.max(initial=0)
    if not (least >= 0 and most <= 1 + _ROUNDING):
        raise EnvLightsError(
            f"{name} must be from 0 to 1, because it is a fraction; it is from {least:.6g} to"
            f" {most:.6g}; gather the prior again"
        )


def _check_albedo(albedo: NDArray[np.float64]) -> None:
    least, most = albedo.min(initial=0), albedo.max(initial=0)
    if not (least >= 0 and most < 1):
        raise EnvLightsError(
            f"albedo must be from 0 to below 1, or light would not fade; it is from {least:.6g}"
            f" to {most:.6g}; divide the albedo of the scene by a scale"
        )


def _sum_of_bounces(reflected: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sum of all bounces; raises an error if the light does not decay.

    The inverse is that sum, without negative numbers, if and only if it converges.
    """
    try:
        bounced = np.linalg.inv(np.eye(reflected.shape[-1]) - reflected)
    except np.linalg.LinAlgError:
        bounced = np.full_like(reflected, np.nan)
    least, most = bounced.min(initial=0), bounced.max(initial=0)
    if not (least >= -_ROUNDING * most and most < 1 / _ROUNDING):
        raise EnvLightsError(
            "light among the direct texels would not fade: `between` divided by `visible`, times"
            " the albedo, reflects more than it gets; gather the prior again"
        )
    return np.asarray(bounced)


def _from_file(data: Mapping[str, NDArray[Any]]) -> TransferPrior:
    return TransferPrior(
        **{name: data[name] for name in _ARRAYS},
        rays=int(data["rays"]),
        size=tuple(data["size"].tolist()),
        irradiance=bool(data["irradiance"]),
    )
