"""Protocols of a comparison: tone curve, camera, sphere materials, and means."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import amount, check_choice, count, describe, reals
from envlights._native import EnvLightsError
from envlights.kernels.gloss import LEAST_ROUGHNESS


@dataclass(frozen=True)
class Material:
    """Surface of a sphere.

    Examples
    --------
    >>> Material(base=0.8, specular=0.04, roughness=0.364)
    Material(base=0.8, specular=0.04, roughness=0.364)
    """

    base: float = 0.0
    """Albedo of a Lambertian base, from 0 to 1."""

    specular: float = 0.0
    """Reflectance of the microfacets at normal incidence, from 0 to 1; 0 for none."""

    roughness: float = 0.0
    """Roughness of the microfacets, the root of their alpha; 0 is a mirror."""

    def __post_init__(self) -> None:
        for name in ("base", "specular", "roughness"):
            object.__setattr__(self, name, amount(name, getattr(self, name), most=1))
        if 0 < self.roughness < LEAST_ROUGHNESS:
            raise EnvLightsError(
                f"roughness must be 0, or {LEAST_ROUGHNESS:g} to 1, because narrower lobes"
                f" depend on degrees above 100; got {self.roughness:g}"
            )
        if self.base and self.specular and not self.roughness:
            raise EnvLightsError("a material with a base needs rough microfacets, or none")


@dataclass(frozen=True)
class Camera:
    """Camera that looks at the centre of a ball of radius 1."""

    position: tuple[float, float, float] = (-16.0, 2.0, 0.0)
    """Position in the frame of `EnvMap`, y up, in radii of the ball."""

    size: int = 280
    """Diameter of a mirror ball in pixels."""

    rough_size: int = 64
    """Diameter in pixels for other materials, whose images are smooth and take longer."""

    coverage: float = 0.1185
    """Fraction of the whole picture that the ball covers, for percentiles over the picture."""

    def __post_init__(self) -> None:
        place = reals("position", self.position, 1)
        if place.shape != (3,) or not np.linalg.norm(place) > 1:
            raise EnvLightsError(
                "position must be three numbers outside of the ball of radius 1;"
                f" got {describe(self.position)}"
            )
        object.__setattr__(self, "position", tuple(place.tolist()))
        count("size", self.size, 8, 2048)
        count("rough_size", self.rough_size, 8, 512)
        amount("coverage", self.coverage, 1e-3, 1)


#: Lambertian, rough metal and mirror spheres with reflectance 1.
_WHITE: Mapping[str, Material] = {
    "diffuse": Material(base=1.0),
    "matte": Material(specular=1.0, roughness=0.3271),
    "mirror": Material(specular=1.0),
}
#: Spheres of the StyleLight code; its "diffuse" sphere has a coating.
_STYLELIGHT: Mapping[str, Material] = {
    "diffuse": Material(base=0.8, specular=0.04, roughness=0.364),
    "matte": Material(specular=0.8, roughness=0.3271),
    "mirror": Material(specular=0.8),
}


@dataclass(frozen=True)
class Protocol:
    """Rules of a comparison; change one by `dataclasses.replace`.

    Examples
    --------
    StyleLight's spheres and tone, with the usual mean over channels:

    >>> from dataclasses import replace
    >>> import envlights as el
    >>> replace(el.comparison.Protocol.named("stylelight"), channels="mean").camera.size
    280
    """

    name: str = "exact"
    """Name for tables and notes."""

    gamma: float | None = None
    """Exponent of the tone curve: samples are raised to 1 / gamma. None keeps them linear."""

    median: float | None = None
    """Median to which each map is scaled after the exponent; None for no scaling."""

    rows: int | None = None
    """Number of rows to which larger maps are reduced; None for the rows of the smaller map."""

    camera: Camera | None = None
    """Camera for images; None for exact means over all views, without brighter rims."""

    materials: Mapping[str, Material] = field(default_factory=lambda: _WHITE)
    """Material of each sphere."""

    channels: str = "mean"
    """"mean" averages over pixels and channels; "sum" averages the sum of channels."""

    black: str = "left out"
    """Angle for pixels that are black in the truth or the guess: "left out", or "perfect" (0)."""

    normalised: bool = False
    """True if the RMSE is also computed for pictures divided by their own 99.9 % percentile."""

    def __post_init__(self) -> None:
        check_choice("channels", self.channels, ("mean", "sum"))
        check_choice("black", self.black, ("left out", "perfect"))
        if self.gamma is not None:
            amount("gamma", self.gamma, 0.1, 10)
        if self.median is not None:
            amount("median", self.median, 1e-6, 1e6)
        if self.rows is not None:
            count("rows", self.rows, 2, 4096)
        self._check_parts()

    def _check_parts(self) -> None:
        """Raise an error for a camera, spheres or normalisation of the wrong type."""
        if self.camera is not None and not isinstance(self.camera, Camera):
            raise EnvLightsError(f"camera must be a Camera or None; got {describe(self.camera)}")
        is_mapping = isinstance(self.materials, Mapping) and len(self.materials) > 0
        if not is_mapping or not all(isinstance(m, Material) for m in self.materials.values()):
            raise EnvLightsError("materials must be a mapping from names to Material")
        if self.normalised and self.camera is None:
            raise EnvLightsError("normalised needs a camera, because percentiles are of pictures")

    @classmethod
    def named(cls, name: str) -> Protocol:
        """Protocol by name; raises an error for unknown names.

        Parameters
        ----------
        name : {"exact", "stylelight", "diffusionlight"}
            "exact": linear maps, white spheres seen from all sides. The others follow the published
            code of StyleLight (Wang et al. 2022) and DiffusionLight (Phongthawee et al. 2024).

        Raises
        ------
        EnvLightsError
            For other names. For protocols that cannot be reproduced, it says what is missing.
        """
        key = name.lower() if isinstance(name, str) else ""
        if key in _REFUSED:
            raise EnvLightsError(f"there is no protocol '{name}': {_REFUSED[key]}")
        check_choice("protocol", key or name, tuple(PROTOCOLS))
        return PROTOCOLS[key]


_OF_STYLELIGHT = Protocol(
    "stylelight",
    gamma=2.4,
    median=0.5,
    rows=128,
    camera=Camera(),
    materials=_STYLELIGHT,
    channels="sum",
    black="perfect",
)
#: Protocols by name.
PROTOCOLS = {
    "exact": Protocol(),
    "stylelight": _OF_STYLELIGHT,
    "diffusionlight": replace(_OF_STYLELIGHT, name="diffusionlight", normalised=True),
}
#: Protocols that cannot be reproduced, with the missing facts.
_REFUSED = {
    "emlight": "the materials and the camera of its spheres were never published; use"
    " protocol='exact', or `image_errors` on images that you rendered",
    "envmapnet": "its angle uses the blue channel alone and knows no seam, so that it depends on"
    " the yaw of a map; c.lights of protocol='exact' has angles between lights",
    "gardner": "no code of its evaluation was published; use protocol='exact'",
    "editableindoor": "its spheres are a file of Blender; use `image_errors` on images that you"
    " rendered with it",
}


def as_protocol(protocol: object) -> Protocol:
    """Protocol by name; a `Protocol` is returned unchanged."""
    return protocol if isinstance(protocol, Protocol) else Protocol.named(protocol)  # type: ignore[arg-type]


def tone(radiance: NDArray[np.float32], protocol: Protocol) -> tuple[NDArray[np.float32], float]:
    """Map after the tone curve, and the scale factor applied after the exponent.

    The factor brings the median of the samples above 0 to `Protocol.median`, as in the code of
    StyleLight.
    """
    values = np.maximum(radiance, 0).astype(np.float64)
    if protocol.gamma is not None:
        values **= 1 / protocol.gamma
    factor = 1.0
    if protocol.median is not None and (values > 0).any():
        factor = protocol.median / float(np.median(values[values > 0]))
    return (factor * values).astype(np.float32), factor
