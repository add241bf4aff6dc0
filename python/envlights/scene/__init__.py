"""Direct and indirect light of a scene under rigs.

| step                                              | file               |
|---------------------------------------------------|--------------------|
| the surfaces of a scene as a lightmap             | `surface.py`       |
| the visible part of an ambient term, and of a light | `sky.py`         |
| direct light of any rig, with shadows             | `direct.py`        |
| the same for balls, boxes and polyhedra, exact    | `solids.py`        |
| their shadows on a floor                          | `floor_shadow.py`  |
| as an overlay for blending                        | `overlay.py`       |
| form factors between texels, by rays              | `gather.py`        |
| pairs to learn from                               | `bake.py`          |
| with Mitsuba: a scene under the light of rigs     | `mitsuba/scene.py`         |
| its triangles, and the first that each ray hits   | `triangles.py`     |
| its shapes as charts; the texels that rays hit    | `mitsuba/chart_rays.py`    |
| a rig as its emitters                             | `mitsuba/emitters.py`      |
| a camera, and the surfaces that it sees           | `camera.py`        |
| an image of solids on a floor, in closed form     | `closed_form.py`   |
| the same by Mitsuba, with independent noise       | `mitsuba/path_traced.py`   |
| reflectance and picture of the floor of a map     | `panorama_floor.py`|
| solids in a panorama                              | `view_image.py`    |
| a ball and a box on a floor, in both ways         | `still_life.py`    |
| Mitsuba, imported when it is needed               | `mitsuba/renderer.py`      |

Images hold the radiance that a surface reflects, albedo / pi times irradiance. So direct and
indirect light add up to the radiance of a diffuse surface.
"""

from envlights.kernels.solids import Ball, Box, Polyhedron
from envlights.scene.bake import BakedPairs, bake
from envlights.scene.direct import DirectLight
from envlights.scene.floor_shadow import shadow_overlay
from envlights.scene.gather import gather
from envlights.scene.mitsuba.scene import MitsubaScene, Rendering
from envlights.scene.overlay import ShadowOverlay
from envlights.scene.surface import Surface

__all__ = [
    "BakedPairs",
    "Ball",
    "Box",
    "DirectLight",
    "MitsubaScene",
    "Polyhedron",
    "Rendering",
    "ShadowOverlay",
    "Surface",
    "bake",
    "gather",
    "shadow_overlay",
]


def __dir__() -> list[str]:
    return sorted(__all__)
