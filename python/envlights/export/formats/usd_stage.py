"""Frame of a stage of OpenUSD: its up axis, its unit of length, and its head."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import check_choice, positive
from envlights.export.formats.usd_text import string
from envlights.export.panels import Panel
from envlights.frames import FRAMES

#: Frame of a stage by its up axis.
_AXES = {"y": FRAMES["usd"], "z": FRAMES["usd-z"]}
_QUANTITIES = "Lights: irradiance at normal incidence; dome: radiance; linear Rec.709 RGB; "
#: The turn of a dome, whose own pole is +y in every stage; `OrientToStageUpAxis` adds no other.
_DOME_TURN = [
    "float xformOp:rotateX:orientToStageUpAxis = 90",
    'uniform token[] xformOpOrder = ["xformOp:rotateX:orientToStageUpAxis"]',
]


class Stage(NamedTuple):
    """Up axis and unit of length of a stage."""

    up: str = "y"
    metres_per_unit: float = 1.0

    def checked(self) -> Stage:
        """Check the axis and the unit, or refuse what no stage has."""
        check_choice("up", self.up, tuple(_AXES))
        return Stage(self.up, positive("metres_per_unit", self.metres_per_unit))

    def text(self, prims: list[str], statement: str, **times: float) -> str:
        """The stage of these prims; `times` are more fields of its head, such as endTimeCode."""
        fields = {
            "defaultPrim": string("rig"),
            "doc": string(f"{_QUANTITIES}{statement}"),
            "metersPerUnit": f"{self.metres_per_unit:.17g}",
            "upAxis": string(self.up.upper()),
            **{name: repr(value) for name, value in times.items()},
        }
        head = "".join(f"    {name} = {fields[name]}\n" for name in sorted(fields))
        body = "\n".join(prims)
        return f'#usda 1.0\n(\n{head})\n\ndef Xform "rig"\n{{\n{body}}}\n'

    def turned(self, directions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Directions or points, (n, 3), in the frame of the stage."""
        return _AXES[self.up].to_target(directions)

    def placed(self, panels: tuple[Panel, ...]) -> tuple[Panel, ...]:
        """Panels in the frame and the unit of the stage."""
        turn = np.asarray(_AXES[self.up].matrix) / self.metres_per_unit
        return tuple(panel._replace(matrix=turn @ panel.matrix) for panel in panels)

    def light_matrix(self, direction: NDArray[np.float64]) -> str:
        """Rotation of a light with its local +z towards `direction`, as a literal."""
        z = self.turned(direction)
        # The rotation about the light's own axis is arbitrary.
        x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0], z)
        x /= np.linalg.norm(x)
        rows = [(*axis.tolist(), 0.0) for axis in (x, np.cross(z, x), z)]
        return f"( {', '.join(map(repr, [*rows, (0.0, 0.0, 0.0, 1.0)]))} )"

    @property
    def dome_turn(self) -> list[str]:
        """Lines that turn the texture of a dome from +y up to the up axis."""
        return _DOME_TURN if self.up == "z" else []
