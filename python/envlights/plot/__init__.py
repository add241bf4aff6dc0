"""Pictures: maps, lights, probes, scenes and indirect light.

| picture                                                        | file          |
|----------------------------------------------------------------|---------------|
| a map alone, with a rig, or with detected lights               | `maps.py`     |
| a map, its lights, and the map without them                    | `split.py`    |
| cards on a map, their textures, and mirror balls               | `cards.py`    |
| the sun of a clipped map, and its shadows                      | `sun.py`      |
| several rigs of a map; the errors of the search for each        | `compare.py`  |
| errors of shading, shadows and metal, by number of lights      | `curve.py`    |
| white balls under a map and under rigs                         | `probes.py`   |
| clipped regions of a map, and the lights in them               | `plateau.py`  |
| a photograph with its lights, and the steps that lead to them  | `photograph.py` |
| lights on the sphere                                           | `globe.py`    |
| the steps of Loghin (2021)                                     | `loghin.py`   |
| a scene under a map and under rigs, with Mitsuba               | `scene.py`    |
| shadows on a floor as overlays, and errors of blending         | `overlay.py`  |
| a predicted frame beside the truth                             | `transfer.py` |
| a lightmap of the synthetic room, and the position of its parts| `room.py`     |
| our axes in other programs                                     | `axes.py`     |
| the basis of a transfer model and its spectrum                 | `basis.py`    |

They share `page.py` (figures and axes), `figure.py` (files), `wording.py` (titles that fit),
`ground.py` (the exposed map), `markers.py` (lights on it), `steps.py` (samples and their links),
`outlines.py`, `ball.py` and `probe.py`.

Every picture takes what it draws, then its own options by name, and then these, by name:

`ax`
    Axes of yours to draw in, one for each panel of the default picture, from left to right and from
    top to bottom: an axes, a sequence, or an array as `plt.subplots` returns. The title over the
    whole figure is left out then; those of panels stay.
`figsize`
    Width and height of a new figure in inches; files get exactly that size.
`dpi`
    Dots in an inch of a new figure, by default ``rcParams["figure.dpi"]``.
`transparent`
    True: a new figure without ground. By default ``rcParams["savefig.transparent"]`` decides when
    it is saved.

Fonts, colours of text and lines, and the ground are those of the style (`rcParams`) at the time of
the call, and nothing global is changed. `save` and `Picture.savefig` embed fonts of Type 42.
"""

import sys

from envlights._common.files import NO_MATPLOTLIB, can_draw
from envlights._common.former import former
from envlights._native import EnvLightsError

__all__ = [
    "Picture",
    "axes_picture",
    "basis_picture",
    "card_balls",
    "card_textures",
    "cards",
    "detection_picture",
    "error_curve",
    "error_picture",
    "loghin_picture",
    "map_picture",
    "overlay_picture",
    "photograph",
    "picture",
    "plateau_picture",
    "probes",
    "rigs_picture",
    "room_picture",
    "save",
    "scene",
    "spectrum_picture",
    "sphere_picture",
    "split_picture",
    "sun",
    "transfer_picture",
]

#: Former names; each warns. For version 0.1 only.
_RENAMED = {"article_picture": "loghin_picture"}

if can_draw():
    from envlights.plot.axes import axes_picture
    from envlights.plot.basis import basis_picture, spectrum_picture
    from envlights.plot.cards import card_balls, card_textures, cards
    from envlights.plot.compare import error_picture, rigs_picture
    from envlights.plot.curve import error_curve
    from envlights.plot.figure import Picture, save
    from envlights.plot.globe import sphere_picture
    from envlights.plot.loghin import loghin_picture
    from envlights.plot.maps import detection_picture, map_picture, picture
    from envlights.plot.overlay import overlay_picture
    from envlights.plot.photograph import photograph
    from envlights.plot.plateau import plateau_picture
    from envlights.plot.probes import probes
    from envlights.plot.room import room_picture
    from envlights.plot.scene import scene
    from envlights.plot.split import split_picture
    from envlights.plot.sun import sun
    from envlights.plot.transfer import transfer_picture


def __getattr__(name: str) -> object:
    if name in __all__:
        raise EnvLightsError(f"plot.{name} {NO_MATPLOTLIB}")
    if name in _RENAMED:
        return former(
            f"plot.{name}", f"plot.{_RENAMED[name]}", sys.modules[__name__], _RENAMED[name], 2
        )
    raise AttributeError(f"module '{__name__}' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted(__all__)
