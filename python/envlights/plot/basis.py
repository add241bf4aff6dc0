"""Pictures of the basis of a transfer model, and of the energy of its directions."""

from __future__ import annotations

import math

import numpy as np
from matplotlib import rcParams
from matplotlib.figure import Figure
from numpy.typing import NDArray

from envlights._common.check import count
from envlights._common.words import percent
from envlights.plot.figure import check_is, hide_frame
from envlights.plot.page import Placement, Unpack, open_page, placed_picture
from envlights.transfer import TransferModel

#: Images per row.
_COLUMNS = 8
#: Fraction of the texels within the colour range.
_RANGE = 0.998
#: Fractions of the energy for which the number of directions is marked.
SHARES = (0.9, 0.95, 0.99)


@placed_picture
def basis_picture(
    model: TransferModel, *, directions: int = 16, **where: Unpack[Placement]
) -> Figure:
    """Draw the first directions of the basis as images, with a common scale around zero.

    The first is like a mean image; later ones move light between parts of the scene, red where they
    add light and blue where they remove it. Each image has the norm 1; the titles hold the shares
    of the energy.

    Parameters
    ----------
    model : TransferModel
        The model.
    directions : int
        Largest number of directions.
    **where
        `ax`: axes, one for each panel; `figsize`, `dpi`, `transparent`: see `envlights.plot`.

    Examples
    --------
    >>> import envlights as el
    >>> room = el.synthetic.room(12, width=16)
    >>> figure = basis_picture(el.TransferModel.fit(room.direct, room.indirect), directions=4)
    >>> len([axes for axes in figure.axes if axes.images])
    4
    """
    check_is("model", model, TransferModel)
    images = model.directions(count("directions", directions, least=1))
    columns = min(_COLUMNS, len(images))
    rows = math.ceil(len(images) / columns)
    cells = np.arange(rows * columns)
    cells[len(images) :] = -1
    size = 1.5 * columns + 0.7, 1.75 * rows + 0.5
    page = open_page(where, cells.reshape(rows, columns), size)
    fraction = energy_shares(model)
    limit = max(float(np.quantile(np.abs(images), _RANGE)), np.finfo(float).tiny)
    for number, (axes, image) in enumerate(zip(page.panels, images, strict=True)):
        drawn = axes.imshow(image, cmap="RdBu_r", vmin=-limit, vmax=limit)
        axes.set_title(f"{number + 1}: {percent(fraction[number], 2)}", fontsize="small")
        hide_frame(axes)
    page.figure.colorbar(drawn, ax=page.panels, label="light of a texel", extend="both", shrink=0.8)
    page.entitle("directions of the basis, and their energy")
    return page.figure


@placed_picture
def spectrum_picture(model: TransferModel, **where: Unpack[Placement]) -> Figure:
    """Draw the energy outside the basis against its number of directions.

    Lines mark how many directions hold 90, 95 and 99 % of the energy of the images.

    Parameters
    ----------
    model : TransferModel
        The model.
    **where
        `ax`, `figsize`, `dpi` and `transparent`; see `envlights.plot`.

    Examples
    --------
    >>> import envlights as el
    >>> room = el.synthetic.room(12, width=16)
    >>> figure = spectrum_picture(el.TransferModel.fit(room.direct, room.indirect))
    >>> [text.get_text().split(":")[0] for text in figure.axes[0].get_legend().get_texts()]
    ['90 %', '95 %', '99 %']
    """
    check_is("model", model, TransferModel)
    held = np.cumsum(energy_shares(model))
    page = open_page(where, [[0]], (7, 4.4))
    (axes,) = page.panels
    left = 100 * np.maximum(1 - held, 1e-9)
    axes.plot(np.arange(1, len(held) + 1), left, ".-", color=rcParams["text.color"])
    for number, fraction in enumerate(SHARES):
        needed = int(np.searchsorted(held, fraction)) + 1
        is_reached = needed <= len(held)
        words = f"{needed} directions" if is_reached else f"more than {len(held)} directions"
        axes.plot(
            *([needed if is_reached else len(held)] * 2, [100 * (1 - fraction), left.min()]),
            color=f"C{number}",
            ls="--" if is_reached else ":",
            label=f"{100 * fraction:g} %: {words}",
        )
    axes.set(xlabel="directions", ylabel="residual energy (%)", yscale="log")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.grid(which="both", alpha=0.25)
    axes.legend(title="energy in the basis")
    return page.figure


def energy_shares(model: TransferModel) -> NDArray[np.float64]:
    """Fraction of the energy of the pairs in each direction, (rank,)."""
    learnt = model.learnt
    inside = np.sum(learnt.coefficients**2, axis=(0, 1))
    left = np.trace(learnt.outside, axis1=1, axis2=2).sum()
    shares: NDArray[np.float64] = inside / (inside.sum() + left)
    return shares
