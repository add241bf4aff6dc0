"""Picture of the shadows of solids on a floor, and of blending errors."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from envlights._common.srgb import encode_srgb
from envlights._native import EnvLightsError
from envlights.plot.figure import check_is, hide_frame
from envlights.plot.page import Placement, Unpack, grid, open_page, placed_picture
from envlights.plot.wording import entitle
from envlights.scene.overlay import BLENDINGS, ShadowOverlay

#: Largest number of lights whose shadows are drawn separately, brightest first.
_LIGHTS = 3


@placed_picture
def overlay_picture(overlay: ShadowOverlay, **where: Unpack[Placement]) -> Figure:
    """Draw the shadows on a floor, in total and for each source, and the blending errors.

    Above: the floor with all shadows, with the contact shadow of the ambient term, and with those
    of the three brightest lights. Below: the largest error of a channel in 8-bit sRGB codes, for
    each way of blending; points under a solid are left out.

    Parameters
    ----------
    overlay : ShadowOverlay
        The result of `shadow_overlay` for a picture.
    **where
        `ax`: axes, one for each panel: two rows of five; `figsize`, `dpi`, `transparent`: see
        `envlights.plot`.

    Raises
    ------
    EnvLightsError
        If the points of the overlay are not a picture.

    Examples
    --------
    >>> import envlights as el
    >>> rig = el.fit(el.synthetic.hall(64).radiance, lights=2, floor=True)
    >>> overlay = el.scene.shadow_overlay(rig, el.scene.Ball((0, 0.5, 0), 0.5), columns=64)
    >>> overlay_picture(overlay).axes[0].get_title()
    'all shadows'
    """
    check_is("overlay", overlay, ShadowOverlay)
    if overlay.ratio.ndim != 3:
        raise EnvLightsError(
            "only the overlay of a picture can be drawn, with points of the shape"
            f" (height, width, 3); got {overlay.points.shape}"
        )
    columns = len(BLENDINGS)
    page = open_page(where, grid(2, columns), (15, 6.4))
    _draw_floors(page.panels[:columns], overlay)
    _draw_errors(page.figure, page.panels[columns:], overlay)
    for axes in page.panels:
        hide_frame(axes)
    page.entitle(overlay.in_short())
    return page.figure


def _draw_floors(axes: list[Axes], overlay: ShadowOverlay) -> None:
    """Draw the floor with all shadows, and with those of each source separately."""
    white = overlay.radiance.max() or 1.0
    lights = overlay.single[1 : 1 + _LIGHTS]
    names = ("all shadows", "ambient alone", *(f"light {k + 1} alone" for k in range(len(lights))))
    ratios = (overlay.ratio, overlay.single[0], *lights)
    for axis, name, ratio in zip(axes, names, ratios, strict=False):
        axis.imshow(encode_srgb(overlay.radiance * ratio / white))
        entitle(axis, name)


def _draw_errors(figure: Figure, axes: list[Axes], overlay: ShadowOverlay) -> None:
    """Draw the error of each blending mode, with a common scale."""
    white = overlay.radiance.max() or 1.0
    exact = encode_srgb(overlay.over() / white)
    errors = {}
    for name in BLENDINGS:
        difference = np.abs(encode_srgb(overlay.over(blending=name) / white) - exact)
        errors[name] = np.where(overlay.covered, 0, 255 * difference.max(axis=-1))
    limit = max(float(np.max(list(errors.values()))), 1.0)
    for axis, (name, error) in zip(axes, errors.items(), strict=True):
        image = axis.imshow(error, cmap="inferno", vmin=0, vmax=limit)
        entitle(axis, f"{name}: largest error {error.max():.1f}")
    figure.colorbar(image, ax=axes, label="8-bit codes", shrink=0.8)
