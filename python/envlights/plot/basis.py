"""Basis of a transfer model, and the energy of its directions."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from envlights._check import count
from envlights.plot.figure import Picture, check_is, hide_frame
from envlights.transfer import TransferModel

#: Images in a row.
_COLUMNS = 8
#: Fractions of the energy for which the number of directions is marked.
SHARES = (0.9, 0.95, 0.99)


def basis_picture(model: TransferModel, directions: int = 16) -> Picture:
    """Draw the first directions of the basis as images, each around zero.

    The first is like a mean image; later ones move light between parts of the scene, red where they
    add light and blue where they remove it.

    Parameters
    ----------
    model : TransferModel
        The model.
    directions : int
        Largest number of directions.

    Returns
    -------
    matplotlib.figure.Figure

    Examples
    --------
    >>> import envlights as el
    >>> room = el.synthetic.room(12, width=16)
    >>> figure = basis_picture(el.TransferModel.fit(room.direct, room.indirect), 4)
    >>> len([axes for axes in figure.axes if axes.images])
    4
    """
    check_is("model", model, TransferModel)
    images = model.directions(count("directions", directions, least=1))
    columns = min(_COLUMNS, len(images))
    rows = math.ceil(len(images) / columns)
    figure = Picture(figsize=(1.5 * columns, 1.75 * rows + 0.5))
    share = energy_shares(model)
    for number, axes in enumerate(figure.subplots(rows, columns, squeeze=False).flat):
        hide_frame(axes)
        if number < len(images):
            limit = float(np.abs(images[number]).max())
            axes.imshow(images[number], cmap="RdBu_r", vmin=-limit, vmax=limit)
            axes.set_title(f"{number + 1}: {100 * share[number]:.2g} %", fontsize="small")
    figure.suptitle("directions of the basis, and the energy of each")
    return figure


def spectrum_picture(model: TransferModel) -> Picture:
    """Draw the energy outside the basis against the number of its directions.

    Lines mark how many directions hold 90, 95 and 99 % of the energy of the images.

    Parameters
    ----------
    model : TransferModel
        The model.

    Returns
    -------
    matplotlib.figure.Figure

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
    figure = Picture(figsize=(7, 4.4))
    axes = figure.add_subplot()
    left = 100 * np.maximum(1 - held, 1e-9)
    axes.plot(np.arange(1, len(held) + 1), left, ".-", color="black")
    for number, share in enumerate(SHARES):
        needed = int(np.searchsorted(held, share)) + 1
        is_reached = needed <= len(held)
        words = f"{needed} directions" if is_reached else f"more than {len(held)} directions"
        axes.plot(
            *([needed if is_reached else len(held)] * 2, [100 * (1 - share), left.min()]),
            color=f"C{number}",
            ls="--" if is_reached else ":",
            label=f"{100 * share:g} %: {words}",
        )
    axes.set(xlabel="directions", ylabel="residual energy (%)", yscale="log")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.grid(which="both", alpha=0.25)
    axes.legend(title="energy in the basis")
    return figure


def energy_shares(model: TransferModel) -> NDArray[np.float64]:
    """Fraction of the energy of the pairs in each direction, (rank,)."""
    learnt = model.learnt
    inside = np.sum(learnt.coefficients**2, axis=(0, 1))
    left = np.trace(learnt.outside, axis1=1, axis2=2).sum()
    shares: NDArray[np.float64] = inside / (inside.sum() + left)
    return shares
