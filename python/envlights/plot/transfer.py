"""Picture of a transfer model: a predicted frame beside the reference."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from envlights._common.srgb import encode_srgb
from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.kernels.image import LUMINANCE
from envlights.plot.figure import check_is, hide_frame
from envlights.plot.page import Placement, Unpack, grid, open_page, placed_picture
from envlights.plot.wording import entitle
from envlights.transfer import TransferModel
from envlights.transfer.pairs import image_stack

#: Width of an image in inches.
_WIDTH = 2.9
#: Percentile that determines the white level and the limits of the difference.
_PERCENTILE = 99.0


@placed_picture
def transfer_picture(
    model: TransferModel, direct: ArrayLike, indirect: ArrayLike, **where: Unpack[Placement]
) -> Figure:
    """Draw a frame: direct light, then true, predicted and projected indirect light.

    The five images are the direct light (the input), the true indirect light, the transfer (the
    prediction), the projection and the difference. The projection is the best that the basis of the
    model can do; any further error of the transfer comes from the regression. The titles hold
    relative errors: the norm of the difference to the reference over the norm of the reference. The
    three images of indirect light have the same exposure; the difference is of luminance, in
    percent of the mean of the reference. All frames share one scale of the difference.

    Parameters
    ----------
    model : TransferModel
        The model.
    direct : array_like, shape (h, w, 3 or 4) or (n, h, w, 3 or 4)
        Direct light of one frame or of several, drawn one below the other.
    indirect : array_like, shape (H, W, 3 or 4) or (n, H, W, 3 or 4)
        The true indirect light.
    **where
        `ax`: axes, five for each frame; `figsize`, `dpi`, `transparent`: see `envlights.plot`.

    Raises
    ------
    EnvLightsError
        If the images are not of the sizes of the model, not as many, or hold NaN or infinities.

    Examples
    --------
    >>> import envlights as el
    >>> room = el.synthetic.room(24, width=32)
    >>> model = el.TransferModel.fit(room.direct[:23], room.indirect[:23], rank=16)
    >>> figure = transfer_picture(model, room.direct[23], room.indirect[23])
    >>> [axes.get_title().split(":")[0] for axes in figure.axes[:4]]
    ['direct', 'reference', 'transfer', 'projection']
    """
    check_is("model", model, TransferModel)
    height, width = model.lit.shape
    reference, _ = image_stack("indirect", indirect, (height, width))
    lights, _ = image_stack("direct", direct, model.size)
    if len(lights) != len(reference):
        raise EnvLightsError(
            "direct and indirect must hold the same number of images;"
            f" got {len(lights)} and {len(reference)}"
        )
    rows = zip(reference, model.predict(lights), _project(model, lights, reference), strict=True)
    size = (5 * _WIDTH + 1.2, len(reference) * (_WIDTH * height / width + 0.4) + 0.4)
    page = open_page(where, grid(len(reference), 5), size)
    panels = [page.panels[first : first + 5] for first in range(0, len(page.panels), 5)]
    differences = []
    for (first, *row), light, (truth, predicted, projected) in zip(
        panels, lights, rows, strict=True
    ):
        _draw_direct(first, light)
        _draw_images(row[:3], truth, predicted, projected)
        differences.append(_percent_of_mean(truth, predicted, model.lit))
    _draw_differences(page.figure, [row[4] for row in panels], differences, model.lit)
    report = model.report
    page.entitle(
        f"rank {report.rank} from {report.pairs} pairs;"
        f" unseen lights, leave-one-out: median {percent(report.error)}"
    )
    return page.figure


def _project(model: TransferModel, lights: NDArray[Any], images: NDArray[Any]) -> NDArray[Any]:
    """Projection of each image onto the basis, scaled like the pairs of the model."""
    norm = np.linalg.norm(lights.reshape(len(lights), -1), axis=1)
    scale = np.where(norm > 0, norm, 1)[:, None, None, None]
    projected: NDArray[Any] = model.project(images / scale) * scale
    return projected


def _draw_direct(axes: Axes, light: NDArray[Any]) -> None:
    """Draw the direct image texel by texel, at its own exposure."""
    white = max(float(np.percentile(light, _PERCENTILE)), np.finfo(float).tiny)
    axes.imshow(encode_srgb(light / white), interpolation="nearest")
    entitle(axes, f"direct: {light.shape[1]}x{light.shape[0]} texels")
    hide_frame(axes)


def _draw_images(
    row: list[Axes], truth: NDArray[Any], predicted: NDArray[Any], projected: NDArray[Any]
) -> None:
    """Draw reference, prediction and projection at a common exposure."""
    white = max(float(np.percentile(truth, _PERCENTILE)), np.finfo(float).tiny)
    titles = (
        "reference",
        f"transfer: {_error(predicted, truth)}",
        f"projection: {_error(projected, truth)}",
    )
    for axes, title, image in zip(row, titles, (truth, predicted, projected), strict=True):
        axes.imshow(encode_srgb(image / white))
        entitle(axes, title)
        hide_frame(axes)


def _percent_of_mean(
    truth: NDArray[Any], predicted: NDArray[Any], lit: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Luminance difference in percent of the mean of the reference."""
    wanted = truth.astype(np.float64) @ LUMINANCE
    mean = max(float(wanted[lit].mean()), np.finfo(float).tiny)
    percent: NDArray[np.float64] = 100 * (predicted.astype(np.float64) @ LUMINANCE - wanted) / mean
    return percent


def _draw_differences(
    figure: Figure,
    axes: list[Axes],
    percents: list[NDArray[np.float64]],
    lit: NDArray[np.bool_],
) -> None:
    """Draw the differences of all frames with a common colour scale."""
    values = np.abs([percent[lit] for percent in percents])
    limit = max(float(np.percentile(values, _PERCENTILE)), 0.1)
    # Show texels that are black in all images as grey; white means no difference.
    colours = colormaps["RdBu_r"].with_extremes(bad="0.6")
    for axis, difference in zip(axes, percents, strict=True):
        drawn = np.where(lit, difference, np.nan)
        image = axis.imshow(drawn, cmap=colours, vmin=-limit, vmax=limit)
        entitle(axis, "transfer minus reference")
        hide_frame(axis)
    figure.colorbar(image, ax=axes, label="% of the mean", shrink=0.85, extend="both")


def _error(image: NDArray[Any], truth: NDArray[Any]) -> str:
    """Relative error in percent, as text; says so for a black reference."""
    length = float(np.linalg.norm(truth.astype(np.float64)))
    if length == 0:
        return "reference is black"
    return percent(float(np.linalg.norm(image.astype(np.float64) - truth)) / length)
