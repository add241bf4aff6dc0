"""Lights of a room with their positions, and the light of its surfaces."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.check import one_or_more, reals
from envlights._common.notes import Note
from envlights._common.result import Result
from envlights._common.tables import MOST_ROWS, Table
from envlights._common.words import percent, quantity
from envlights._native import EnvLightsError
from envlights.cards import Cards
from envlights.environment import thumbnails
from envlights.environment.envmap import EnvMap, as_envmap
from envlights.fitting.fit import fit_probe
from envlights.kernels.probe import relative_rms, rig_irradiance
from envlights.kernels.sampling import icosphere
from envlights.placing.errors import PointErrors
from envlights.placing.patches import Patches
from envlights.placing.placed_light import PlacedLight
from envlights.placing.reading import Reals
from envlights.placing.seen import cards_from, lights_from
from envlights.placing.warp import warped
from envlights.rigs.lights import rgb_cell, rgb_heading
from envlights.rigs.rig import Rig

#: Lights of a rig at a point up to which large rectangles are cut into four.
_MOST_LIGHTS = 8


@dataclass(frozen=True, eq=False, repr=False)
class PlacedLights(Result):
    """Lights of a room in metres from the camera, and its surfaces, as `place` returns them.

    Nothing hides a light from a point, surfaces are diffuse, and a sphere shines evenly.

    Examples
    --------
    A panel in the ceiling of a room:

    >>> import envlights as el
    >>> lamp = el.synthetic.Rectangle((0, 1, 0), 30.0, 30.0, (9, 9, 9))
    >>> world = el.synthetic.scene(64, background=[0.2] * 3, shapes=[lamp])
    >>> placed = el.place(world.radiance, room=(6, 3, 5))
    >>> placed
    <PlacedLights: 1 plane, and 512 patches>
    >>> placed.irradiance([[0, 0, 0], [0, 1, 0]], [[0, 1, 0]])[..., 0].round(2)
    array([[ 2.69],
           [12.51]])
    """

    lights: tuple[PlacedLight, ...]
    """Lights with positions, in the order of the cards: brightest first."""

    remainder: EnvMap
    """The map without the lights."""

    patches: Patches
    """The remainder as diffuse surfaces in space; empty without depth."""

    depth: Reals | None = None
    """Distance along the ray of each pixel in metres, infinite if unknown; None without depth."""

    notes: tuple[str, ...] = ()
    """Remarks on the depth and on the lights."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "notes", tuple(map(Note, self.notes)))

    def __len__(self) -> int:
        return len(self.lights)

    def __getitem__(self, row: int) -> PlacedLight:
        return self.lights[row]

    def __iter__(self) -> Iterator[PlacedLight]:
        return iter(self.lights)

    @property
    def units(self) -> str:
        """Unit of the radiance; see `Lights`."""
        return self.remainder.units

    def _of_kind(self, kind: str) -> list[PlacedLight]:
        return [light for light in self.lights if light.kind == kind]

    @property
    def cards(self) -> Cards:
        """The planes as cards at their positions, for `Cards.save` and other cards' methods."""
        return cards_from(self.lights, np.zeros(3), self.units)

    def irradiance(self, points: ArrayLike, normals: ArrayLike) -> NDArray[np.float64]:
        """Irradiance of surfaces at points in the room.

        Parameters
        ----------
        points : array_like, shape (p, 3) or (3,)
            Metres from the camera, in the frame of `EnvMap`.
        normals : array_like, shape (n, 3)
            Unit vectors.

        Returns
        -------
        ndarray, shape (p, n, 3) or (n, 3)
            Linear RGB. Rectangles are in closed form (Lambert), spheres as discs. The light of the
            surfaces is that of the remainder, plus the difference of the patches to the camera, so
            that it is exact there.
        """
        places, is_one = one_or_more("points", points)
        rows = reals("normals", normals, 2)
        near = self._near(places, rows, self.lights, self.patches)
        values: Reals = np.maximum(near + self._around(rows) + self._suns(rows), 0)
        return values[0] if is_one else values

    def at(self, point: ArrayLike) -> Rig:
        """Rig of the light at a point: lamps as discs, and surfaces as nine harmonics.

        Parameters
        ----------
        point : array_like, shape (3,)
            Metres from the camera.

        Returns
        -------
        Rig
            An ordinary rig, whose `error` is relative to `irradiance` at this point.
        """
        place = _point(point)
        normals, weights = icosphere(320)
        lights = lights_from(self.lights, place, self.units, most=_MOST_LIGHTS)
        surfaces = self._near(place[None], normals, (), self.patches)[0] + self._around(normals)
        surfaces = np.maximum(surfaces, 0)
        sky = fit_probe(normals, surfaces, 0, weights=weights, ambient="sh2")
        rig = Rig(sky.ambient, lights, 0.0)
        error = relative_rms(rig.probe(normals), self.irradiance(place, normals), weights)
        return Rig(sky.ambient, lights, error, notes=self.notes)

    def map_at(self, point: ArrayLike) -> EnvMap:
        """Map at a point: surfaces moved by their depth, and lamps drawn at their positions.

        Parameters
        ----------
        point : array_like, shape (3,)
            Metres from the camera.

        Returns
        -------
        EnvMap
            Map of the size of the remainder. Surfaces that the camera does not see are missing.
        """
        place = _point(point)
        remainder = self.remainder.cells()
        if self.depth is not None:
            remainder = warped(remainder, self.depth, place)
        cards = cards_from(self.lights, place, self.units)
        others = [each for each in self.lights if each.kind != "plane"]
        discs = lights_from(others, place, self.units).to_map(self.remainder.height).radiance
        lamps = cards.to_map(self.remainder.width).radiance + discs
        return EnvMap(remainder + lamps, units=self.units)

    def compare(self, maps: Mapping[Any, Any]) -> PointErrors:
        """Errors of the irradiance at points where maps were taken.

        Parameters
        ----------
        maps : mapping
            Maps, or what `EnvMap` accepts, by their positions, (x, y, z) in metres from the camera.

        Returns
        -------
        PointErrors
            Relative RMS errors over 320 normals, beside those with all light at infinity.
        """
        normals, weights = icosphere(320)
        points = np.reshape([_point(each) for each in maps], (-1, 3))
        here, home = self.irradiance(points, normals), self.irradiance(np.zeros(3), normals)
        truth = [as_envmap(each).probe(normals) for each in maps.values()]
        pairs = list(zip(here, truth, strict=True))
        errors = [relative_rms(guess, wanted, weights) for guess, wanted in pairs]
        far = [relative_rms(home, wanted, weights) for wanted in truth]
        return PointErrors(points, np.array(errors), np.array(far))

    def _near(
        self, points: Reals, normals: Reals, lights: Sequence[PlacedLight], patches: Patches
    ) -> Reals:
        """Irradiance of lights and patches with positions, (p, n, 3)."""
        balls = [each for each in lights if each.kind == "sphere"]
        planes = [each for each in lights if each.kind == "plane"]
        return _native.near_irradiance(
            points,
            normals,
            (
                np.reshape([each.position for each in balls], (-1, 3)),
                np.array([each.radius for each in balls], float),
                np.reshape([each.irradiance for each in balls], (-1, 3)),
            ),
            (
                np.reshape([each.matrix for each in planes], (-1, 3, 3)),
                [each.is_disc for each in planes],
                np.reshape([each.irradiance for each in planes], (-1, 3)),
            ),
            patches,
        )

    def _around(self, normals: Reals) -> Reals:
        """Irradiance of the remainder, less that of the patches at the camera."""
        patches = self._near(np.zeros((1, 3)), normals, (), self.patches)[0]
        values: Reals = self.remainder.probe(normals) - patches
        return values

    def _suns(self, normals: Reals) -> Reals:
        suns = lights_from(self._of_kind("sun"), np.zeros(3), self.units)
        arrays = suns.direction, suns.irradiance, suns.angular_radius
        return rig_irradiance(normals, np.zeros(3), *arrays)

    def in_short(self) -> str:
        """Number of lights of each kind, and of patches."""
        counts = ((len(self._of_kind(kind)), kind) for kind in ("plane", "sphere", "sun"))
        lights = [quantity(number, kind) for number, kind in counts if number] or ["no light"]
        patches = f", and {len(self.patches.area)} patches" if len(self.patches.area) else ""
        return ", ".join(lights) + patches

    def _table(self) -> Table:
        names = ["light", "kind", "x", "y", "z", "size", "uncertainty", rgb_heading(self.units)]
        rows = [
            [
                f"{number}",
                light.kind,
                *(f"{value:.2f}" for value in light.position),
                light.in_short().split(", ")[1] if light.kind != "sun" else "",
                percent(light.uncertainty),
                rgb_cell(light.irradiance),
            ]
            for number, light in enumerate(self.lights[:MOST_ROWS], 1)
        ]
        more = len(self.lights) - len(rows)
        rest = quantity(more, "more light") if more else ("" if rows else "no light")
        colours = np.reshape([each.irradiance for each in self.lights[:MOST_ROWS]], (-1, 3))
        return Table(names, rows, rest, thumbnails.hex_of(colours))

    def _lines(self) -> list[str]:
        return [f"note: {note}" for note in self.notes]

    def to_dict(self) -> dict[str, Any]:
        """Lists of numbers and strings for each light, for example for JSON."""
        names = ("position", "normal", "up", "size", "radiance", "intensity", "irradiance")
        return {
            "lights": [
                {"kind": light.kind, "shape": light.shape, "radius": light.radius}
                | {name: np.asarray(getattr(light, name)).tolist() for name in names}
                for light in self.lights
            ],
            "scale": self.units,
            "notes": list(self.notes),
        }


def _point(values: ArrayLike) -> Reals:
    point = reals("point", values, 1)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise EnvLightsError(f"point must be three finite numbers in metres; got {point.tolist()}")
    return point
