"""A scene under a rig: the bridge from lights to direct light to indirect light.

| step                                              | file               |
|---------------------------------------------------|--------------------|
| the surfaces as a lightmap                        | `surface.py`       |
| what they see of an ambient term                  | `sky.py`           |
| direct light of any rig, behind shadows           | `direct.py`        |
| pairs to learn from                               | `bake.py`          |
| with Mitsuba: a scene that rigs light             | `mitsuba_scene.py` |
| its shapes side by side                           | `charts.py`        |
| a rig as its emitters                             | `emitters.py`      |
| a sensor on each texel                            | `meters.py`        |
| the renderer itself, imported when it is needed   | `renderer.py`      |

Images hold the radiance that a surface reflects, albedo / pi times irradiance, so that direct and
indirect light add up to what is seen.
"""

from envlights.scene.bake import BakedPairs, bake
from envlights.scene.direct import DirectLight
from envlights.scene.mitsuba_scene import MitsubaScene, Rendered
from envlights.scene.surface import Surface

__all__ = ["BakedPairs", "DirectLight", "MitsubaScene", "Rendered", "Surface", "bake"]
