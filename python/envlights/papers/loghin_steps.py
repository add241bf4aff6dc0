"""Steps 3 to 9 of Loghin (2021) on a luminance image, of a map or of a photograph."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import amount, check_choice, count, flag
from envlights._common.srgb import encode_srgb
from envlights._native import EnvLightsError
from envlights.detection import wording
from envlights.kernels import image as images
from envlights.kernels import loghin, sampling

#: Functions that generate points in the unit square, by the name of the sequence.
SAMPLINGS: dict[str, Callable[[int], NDArray[np.float64]]] = {
    "hammersley": sampling.hammersley,
    "halton": sampling.halton,
}
#: Columns of the image to which lengths in pixels refer.
REFERENCE_PX = 1024
#: Default ratio of window width to sample spacing; 1 would leave gaps.
_WINDOW_OVER_SPACING = 1.3
#: Largest value of each numeric setting.
_MOST = dict.fromkeys(("blur_px", "threshold", "rise", "tolerance", "tolerance_stops"), math.inf)
_MOST |= dict.fromkeys(("ceiling", "suppression_px", "merge_cap_px"), math.inf)
_MOST |= {"samples_per_pixel": 1.0, "suppression_deg": 180.0, "merge_cap_deg": 180.0}
_FLAGS = ("relative", "move_to_maximum", "sphere")


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Settings of the steps, for `papers.loghin.detect` and `detect_photograph`.

    The defaults are those of the article, for maps. `papers.loghin.PHOTOGRAPH` holds those of
    photographs; ``dataclasses.replace`` changes some of them.

    Examples
    --------
    >>> from dataclasses import replace
    >>> replace(PHOTOGRAPH, blur_px=1.0).sampling
    'halton'
    """

    reduction: str = "bilinear"
    """Reduction of the picture: "bilinear", which skips pixels, as in the article, or "area"."""

    blur_px: float = 0.0
    """Standard deviation of a blur in the reduced picture; optional in the article, with 1 to 2."""

    sampling: str = "hammersley"
    """Sequence of points, "hammersley" or "halton". On maps they have equal solid angles."""

    samples_per_pixel: float = 0.006
    """Ratio of the number of samples to the number of pixels in the reduced picture."""

    window_px: int | None = 12
    """Width of the window around a sample, minus one, in a picture of 1024 pixels.

    None: 1.3 times the distance between samples, for pictures of any size."""

    relative: bool = False
    """True if levels follow the exposure. In the article all levels are absolute.

    Maps have the threshold of `detect`, and the levels of the line check are relative to it.
    Photographs have one by the same rule, with equal weights of all pixels, and lines are checked
    in stops; in a clipped photograph, levels are relative to the clip level."""

    threshold: float = 0.8
    """Luminance that the brightest pixel of a window must exceed.

    It is linear: pictures of 8 bits are decoded from sRGB, so 0.8 is the code 231 of 255. Relative
    levels of photographs that are not clipped do not use it."""

    rise: float = 2.0
    """Photographs: smallest ratio of the maximum of a light to the relative threshold."""

    suppression_deg: float = 5.0
    """Maps: samples within this angle of a brighter sample are suppressed.

    The article gives no number; the default is 1.5 times the distance between samples."""

    suppression_px: float = 10.0
    """Photographs: distance below which a brighter sample suppresses, for 1024 pixels."""

    tolerance: float = 0.15
    """Largest luminance difference in the line check; see `kernels.merge_along_lines`."""

    tolerance_stops: float = 1.5
    """Photographs: largest difference in the relative line check, in stops (powers of two).

    It is the largest difference of the mean of a line from its start."""

    ceiling: float = 1.25
    """Luminance to which pixels are limited in the mean of a line."""

    merge_cap_deg: float | None = None
    """Maps: samples farther apart than this angle are not merged. The article has no such limit."""

    merge_cap_px: float | None = None
    """Photographs: samples farther apart than this are not merged, in a picture of 1024 pixels."""

    move_to_maximum: bool = False
    """True if samples move to the brightest pixel of their window. In the article they do not move.

    In photographs they climb from window to window, and the position of a light is the mean over
    these maxima and over the samples on the light."""

    sphere: bool = False
    """Maps: True if windows, distances, lines and means are computed on the sphere, across the
    seam.

    In the article they are those on the image."""

    def __post_init__(self) -> None:
        check_choice("reduction", self.reduction, ("bilinear", "area"))
        check_choice("sampling", self.sampling, tuple(SAMPLINGS))
        checked: dict[str, object] = {name: flag(name, getattr(self, name)) for name in _FLAGS}
        for name, most in _MOST.items():
            value = getattr(self, name)
            if value is not None or not name.startswith("merge_cap"):
                checked[name] = amount(name, value, most=most)
        if self.window_px is not None:
            checked["window_px"] = count("window_px", self.window_px)
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def points(self, size: int) -> NDArray[np.float64]:
        """Points in the unit square for an image of `size` pixels, (n, 2) (step 3)."""
        return SAMPLINGS[self.sampling](int(self.samples_per_pixel * size))

    def reach(self, side: int) -> int:
        """Pixels from a sample to the edge of its window; `side` is the longer image side."""
        if self.window_px is not None:
            return int(self.window_px * side / REFERENCE_PX) // 2
        per_pixel = self.samples_per_pixel
        spacing = 1 / math.sqrt(per_pixel) if per_pixel > 0 else 0.0
        return round(_WINDOW_OVER_SPACING / 2 * min(spacing, REFERENCE_PX))


def check_settings(settings: object, unused: tuple[str, ...], picture: str) -> None:
    """Raise an error for invalid settings, or for settings that this kind of picture ignores."""
    if not isinstance(settings, Settings):
        raise EnvLightsError(
            f"settings must be papers.loghin.Settings; got {type(settings).__name__}"
        )
    plain = {each.name: each.default for each in fields(settings)}
    if changed := [name for name in unused if getattr(settings, name) != plain[name]]:
        raise EnvLightsError(f"{', '.join(changed)} cannot be set for a {picture}")


#: Default settings for photographs: relative levels, moving samples, and the article's Halton
#: points.
PHOTOGRAPH = Settings(
    sampling="halton",
    samples_per_pixel=0.012,
    window_px=None,
    relative=True,
    move_to_maximum=True,
)


@dataclass(frozen=True)
class BrightSamples:
    """Samples near a bright pixel, brightest first."""

    pixel: NDArray[np.int64]
    """Row and column of each sample, (k, 2)."""

    luminance: NDArray[np.float32]
    """Luminance at each sample's pixel, (k,)."""

    first: NDArray[np.int64]
    """Pixel of each sample before it moved to a maximum, (k, 2)."""

    maximum: NDArray[np.int64]
    """Brightest pixel in the window of each sample, (k, 2)."""

    def of(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> BrightSamples:
        """Subset of the samples, selected by a mask or by indices."""
        return BrightSamples(
            self.pixel[rows], self.luminance[rows], self.first[rows], self.maximum[rows]
        )


class MergeRule(NamedTuple):
    """Options of steps 7 and 8."""

    apart: float
    """Distance below which a brighter sample suppresses another."""

    farthest: float
    """Distance above which samples are not merged."""

    tolerance: float
    """Largest difference between the mean of a line and the luminance at its start."""

    ceiling: float
    """Luminance to which pixels are limited in the mean of a line."""

    bright: float
    """Mean of a line above which samples are always merged."""


@dataclass(frozen=True)
class MergedSamples:
    """Lights as groups of merged samples."""

    means: NDArray[np.float64]
    """Luminance-weighted mean of the points of each light, (n, d)."""

    peak: NDArray[np.int64]
    """Pixel of the brightest sample of each light, (n, 2)."""

    light: NDArray[np.int64]
    """Index of the light of each sample, (k,)."""

    survivor: NDArray[np.int64]
    """Index of the sample that suppresses each sample, or its own index, (k,)."""

    def sums(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Sum of the rows of `values`, (k, d), over each light, (n, d)."""
        lights = len(self.means)
        columns = [np.bincount(self.light, column, minlength=lights) for column in values.T]
        return np.stack(columns, axis=1)

    def flux(
        self,
        radiance: NDArray[np.float64],
        weight: NDArray[np.float64],
        direction: NDArray[np.float64],
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Weighted sum of radiance over each light, (n, 3), and length of its vector sum, (n,).

        The vector is that of luminance along `direction`, (k, 3): its length over the luminance of
        the flux is the mean cosine towards a surface that faces the light.
        """
        luminance = (radiance @ images.LUMINANCE * weight)[:, None]
        vectors = self.sums(luminance * direction)
        return self.sums(radiance * weight[:, None]), np.linalg.norm(vectors, axis=1)


@dataclass(frozen=True)
class Steps:
    """Results of the steps for a luminance image."""

    image: NDArray[np.float32]
    """Reduced luminance, (height, width)."""

    points: NDArray[np.float64]
    """Points of all samples, in the unit square of the image, (n, 2)."""

    samples: BrightSamples
    """Samples near a bright pixel."""

    merged: MergedSamples
    """Samples merged to lights."""

    reach: int
    """Pixels from a sample to the edge of its window."""

    threshold: float
    """Luminance above which a pixel is bright."""

    @property
    def size(self) -> tuple[int, int]:
        """Height and width of the image."""
        return self.image.shape[0], self.image.shape[1]

    @property
    def details(self) -> tuple[str, ...]:
        """Line for the report on dark samples."""
        total = len(self.points)
        return (f"{total - len(self.samples.pixel)} of {total} samples are dark",)

    @property
    def first_luminance(self) -> NDArray[np.float32]:
        """Luminance of each bright sample at its first position, (k,)."""
        row, column = self.samples.first.T
        return np.asarray(self.image[row, column])

    @property
    def peak_luminance(self) -> NDArray[np.float64]:
        """Luminance of the brightest sample of each light, (n,)."""
        row, column = self.merged.peak.T
        return np.asarray(self.image[row, column], np.float64)

    def reach_in(self, shape: tuple[int, ...]) -> int:
        """`reach` in an image of another size, rounded up."""
        lengths = (shape[axis] / self.size[axis] for axis in (0, 1))
        return math.ceil((self.reach + 0.5) * max(lengths))

    def pixels_in(self, shape: tuple[int, ...]) -> NDArray[np.int64]:
        """Pixels of an image of another size at the brightest sample of each light, (n, 2)."""
        return images.uv_to_pixel(self.uv(self.merged.peak), shape[0], shape[1])

    def uv(self, pixel: NDArray[np.integer] | NDArray[np.floating]) -> NDArray[np.float64]:
        """Centres of pixels in the unit square, (n, 2)."""
        centres: NDArray[np.float64] = (pixel[:, ::-1] + 0.5) / self.size[::-1]
        return centres


def blur(image: NDArray[np.float32], settings: Settings, wrap: bool) -> NDArray[np.float32]:
    """Step 2: a blur, if the settings ask for one."""
    return images.blur(image, settings.blur_px, wrap=wrap) if settings.blur_px > 0 else image


def threshold_reason(rule: str, level: float, clip_level: float | None) -> str:
    """Rule that set a threshold of luminance, with its code in a clipped picture."""
    fraction = 0.0 if clip_level is None else min(level / clip_level, 1.0)
    code = 255 * float(encode_srgb(np.array(fraction)))
    return wording.reason_of_article(rule, level, clip_level, code)


def bright_samples(
    image: NDArray[np.float32],
    pixel: NDArray[np.int64],
    reach: int,
    threshold: float,
    settings: Settings,
) -> BrightSamples:
    """Steps 5 and 6: samples whose window holds a pixel above the threshold, brightest first."""
    brightest, place = loghin.neighbour_maximum(image, pixel, reach, sphere=settings.sphere)
    is_bright = brightest > threshold
    first, place = pixel[is_bright], place[is_bright]
    moved = place if settings.move_to_maximum else first
    luminance = image[moved[:, 0], moved[:, 1]]
    order = np.argsort(-luminance, kind="stable")
    return BrightSamples(moved, luminance, first, place).of(order)


def climb(
    image: NDArray[np.float32], samples: BrightSamples, reach: int, least: float
) -> BrightSamples:
    """Samples moved to local maxima of at least `least`.

    Windows that end on the slope of a lamp would each report a maximum of their own.
    """
    pixel, luminance = samples.pixel, samples.luminance
    is_lower = np.ones(len(pixel), bool)
    while is_lower.any():
        brightest, place = loghin.neighbour_maximum(image, pixel, reach)
        is_lower = brightest > luminance
        pixel = np.where(is_lower[:, None], place, pixel)
        luminance = np.where(is_lower, brightest, luminance)
    rows = np.argsort(-luminance, kind="stable")
    rows = rows[luminance[rows] >= least]
    return replace(samples, pixel=pixel, luminance=luminance, maximum=pixel).of(rows)


def merged_samples(
    image: NDArray[np.float32],
    samples: BrightSamples,
    points: NDArray[np.float64],
    rule: MergeRule,
    sphere: bool,
) -> MergedSamples:
    """Steps 7 to 9: suppress samples near brighter ones, merge along lines, take means.

    `points` are the positions of the samples, in a plane or on the sphere.
    """
    survivor_of = loghin.suppress(points, rule.apart)
    survivors = np.unique(survivor_of)
    merged_into = loghin.merge_along_lines(
        image,
        samples.pixel[survivors],
        tolerance=rule.tolerance,
        ceiling=rule.ceiling,
        bright=rule.bright,
        points=points[survivors],
        farthest=rule.farthest,
        sphere=sphere,
    )
    means = loghin.weighted_means(points[survivors], samples.luminance[survivors], merged_into)
    peaks, light = np.unique(merged_into, return_inverse=True)
    return MergedSamples(
        means=means,
        peak=samples.pixel[survivors[peaks]],
        light=light[np.searchsorted(survivors, survivor_of)],
        survivor=survivor_of,
    )
