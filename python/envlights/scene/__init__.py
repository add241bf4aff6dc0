"""Direct and indirect light of a scene under rigs.

| step                                              | file               |
|---------------------------------------------------|--------------------|
| the surfaces of a scene as a lightmap             | `surface.py`       |
| the visible part of an ambient term               | `sky.py`           |
| the visible part of a light                       | `disc.py`          |
| direct light of any rig, with shadows             | `direct.py`        |
| pairs to learn from                               | `bake.py`          |
| with Mitsuba: a scene under the light of rigs     | `mitsuba_scene.py` |
| its shapes as charts in a lightmap                | `charts.py`        |
| a rig as its emitters                             | `emitters.py`      |
| a sensor on each texel                            | `meters.py`        |
| a ball and a box on a floor, as an image          | `still_life.py`    |
| Mitsuba, imported when it is needed               | `renderer.py`      |

Images hold the radiance that a surface reflects, albedo / pi times irradiance. So direct and
indirect light add up to the radiance of a diffuse surface.
"""

from envlights.scene.bake import BakedPairs, bake
from envlights.scene.direct import DirectLight
from envlights.scene.mitsuba_scene import MitsubaScene, Rendering
from envlights.scene.surface import Surface

__all__ = ["BakedPairs", "DirectLight", "MitsubaScene", "Rendering", "Surface", "bake"]


def __dir__() -> list[str]:
    return sorted(__all__)
