"""Lights of a room with their positions, and the light of its surfaces."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _native
from envlights._common.check import count, describe, one_or_more, reals, texts
from envlights._common.files import as_path
from envlights._common.notes import Note
from envlights._common.result import Result
from envlights._common.tables import MOST_ROWS, Table
from envlights._common.words import percent, quantity
from envlights._native import EnvLightsError
from envlights.cards import Cards
from envlights.environment.envmap import EnvMap
from envlights.environment.files.image_output import MAP_SUFFIXES
from envlights.environment.reading import AnyMap, as_envmap
from envlights.export.files import AnyPath
from envlights.export.links import save_with_map
from envlights.export.targets import TARGETS, target_of
from envlights.fitting.fit import fit_probe
from envlights.kernels import thumbnails
from envlights.kernels.probe import relative_rms, rig_irradiance
from envlights.kernels.sampling import icosphere
from envlights.placing.depth import triple
from envlights.placing.patches import surface_behind, warp
from envlights.placing.placed_light import PlacedLight
from envlights.placing.planes import Reals
from envlights.rigs.lights import Lights, rgb_cell, rgb_heading
from envlights.rigs.rig import Rig

#: Angular radius in radians above which `PlacedLights.at` cuts a rectangle into four: as one disc,
#: a panel of 1.2 m adds 0.8 % to the error at 1 m.
_LARGE = 0.15
#: Suffixes of programs that show lights with positions.
_SUFFIXES = [suffix for target in TARGETS if target.shows.cards for suffix in target.suffixes]


class PointErrors(NamedTuple):
    """Relative RMS errors of irradiance over 320 normals, at points of a room."""

    point: Reals
    """Metres from the camera, (n, 3)."""

    error: Reals
    """Error of the placed lights, (n,)."""

    error_at_infinity: Reals
    """Error of the same light without positions, (n,)."""


@dataclass(frozen=True, eq=False, repr=False)
class PlacedLights(Result):
    """Lights of a room in metres from the camera, and its surfaces, as `place` returns them.

    Nothing hides a light from a point, surfaces are diffuse, and spheres shine evenly.

    Examples
    --------
    A panel in the ceiling of a room:

    >>> import envlights as el
    >>> lamp = el.synthetic.Rectangle((0, 1, 0), 30.0, 30.0, (9, 9, 9))
    >>> world = el.synthetic.scene(64, background=[0.2] * 3, shapes=[lamp])
    >>> placed = el.place(world.radiance, room=(6, 3, 5))
    >>> placed
    <PlacedLights: 1 plane, and 512 patches>
    >>> placed.irradiance([[0, 0, 0], [0, 1, 0]], [[0, 1, 0]])[..., 0].round(1)
    array([[ 2.9],
           [12.9]])
    """

    lights: tuple[PlacedLight, ...]
    """Lights with positions, brightest at the camera first."""

    remainder: EnvMap
    """The map without the lights."""

    patches: Reals
    """The remainder as diffuse patches: centre, unit normal, area and radiance, (n, 10)."""

    depth: Reals | None = None
    """Distance along the ray of each pixel without the lights, infinite if unknown; or None."""

    notes: tuple[str, ...] = ()
    """Remarks on the depth and on the lights; those on the map are `remainder.notes`."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "notes", tuple(map(Note, texts("notes", self.notes))))

    def __len__(self) -> int:
        return len(self.lights)

    def __getitem__(self, row: int) -> PlacedLight:
        return self.lights[row]

    def __iter__(self) -> Iterator[PlacedLight]:
        return iter(self.lights)

    def _of_kind(self, *kinds: str) -> list[PlacedLight]:
        return [light for light in self.lights if light.kind in kinds]

    @property
    def cards(self) -> Cards:
        """All lights as cards: planes and spheres at their positions, and suns as "other"."""
        return self._cards_around(np.zeros(3))

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
        around = self._around(places, rows)
        values: Reals = around + near_irradiance(places, rows, self.lights, self.patches[:0])
        return values[0] if is_one else values

    def at(self, point: ArrayLike, *, lights: int = 8) -> Rig:
        """Rig of the light at a point: lamps as discs, and surfaces as nine harmonics.

        Parameters
        ----------
        point : array_like, shape (3,)
            Metres from the camera.
        lights : int
            Number of lights up to which large rectangles are cut into four, for their shape.

        Returns
        -------
        Rig
            An ordinary rig, whose `error` is relative to `irradiance` at this point.
        """
        place, (normals, weights) = triple("point", point), icosphere(320)
        around = self._around(place[None], normals)[0] - self._suns(normals)
        lamps = self._lamps_from(place, self._pieces(place, count("lights", lights)))
        sky = fit_probe(normals, np.maximum(around, 0), 0, weights=weights, ambient="sh2")
        rig = Rig(sky.ambient, lamps, 0.0, notes=self._all_notes(place))
        error = relative_rms(rig.probe(normals), self.irradiance(place, normals), weights)
        return replace(rig, error=error)

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
        place = triple("point", point)
        around, cards = self._remainder_at(place).filled(), self._cards_around(place)
        total = around.cells() + cards.to_map(around.width).radiance
        return EnvMap(total, units=around.units, notes=self._all_notes(place))

    def save(
        self, *paths: AnyPath, at: ArrayLike = (0.0, 0.0, 0.0), **options: Any
    ) -> tuple[Path, ...]:
        """Write the lights with their positions in metres, and the remainder around them.

        Planes are rectangles and discs, spheres are spheres or points of the same intensity, and
        suns stay directional. The origin is the camera, and the axes are those of `CardSplit.save`.
        OpenUSD, Mitsuba, Blender, pbrt, three.js and glTF show positions; for others, `at` gives a
        rig whose `save` writes the light of one point.

        Parameters
        ----------
        *paths : path-like
            Scenes for these programs, and files of the remainder (.exr, .hdr).
        at : array_like, shape (3,)
            Point in metres from the camera whose remainder is the map around the lights. Default:
            the camera. Elsewhere, this map is wrong by the parallax of the walls: 1 to 3 % of the
            irradiance at 0.5 m, 3 to 10 % at 2 m in five rooms.
        **options
            Further arguments of the writers that have them: ``up="z"`` of OpenUSD.

        Returns
        -------
        tuple of Path
            All written files.

        Raises
        ------
        EnvLightsError
            If there is no path, a program shows no positions, or a file cannot be written.

        Examples
        --------
        >>> import tempfile
        >>> import envlights as el
        >>> lamp = el.synthetic.Rectangle((0, 1, 0), 30.0, 30.0, (9, 9, 9))
        >>> world = el.synthetic.scene(64, background=[0.2] * 3, shapes=[lamp])
        >>> placed = el.place(world.radiance, room=(6, 3, 5))
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     [path.name for path in placed.save(Path(folder, "room.usda"), at=[1, 0, 0])]
        ['room.usda', 'room.card_0.usd.exr', 'room.ambient.exr']
        """
        scenes = [path for path in paths if as_path(path).suffix.lower() not in MAP_SUFFIXES]
        for path in scenes:
            if not target_of(path).shows.cards:
                raise EnvLightsError(
                    f"cannot write {path}: {target_of(path).title} shows no lights with positions;"
                    f" give one of {', '.join(_SUFFIXES)}, or write the light of one point, a rig:"
                    " placed.at(point).save(...), or --point on the command line"
                )
        place = triple("at", at)
        seen_from = np.zeros(3) if self.depth is None else place
        where = " ".join(f"{metres:.4g}" for metres in seen_from)
        note = f"positions are in metres from the camera, and the map is that of ({where})"
        notes = self._notes_at(place)
        for doubt in notes[len(self.notes) :]:
            warnings.warn(doubt, stacklevel=2)
        cards = replace(self.cards, notes=(*notes, note))
        return save_with_map(cards, self._remainder_at(place), paths, **options)

    def compare(self, maps: Mapping[tuple[float, float, float], AnyMap]) -> PointErrors:
        """Errors of the irradiance at points where maps were taken.

        Parameters
        ----------
        maps : mapping
            Maps by their positions (x, y, z) in metres from the camera.

        Returns
        -------
        PointErrors
            Errors, beside those with all light at infinity.
        """
        if not isinstance(maps, Mapping):
            raise EnvLightsError(
                f"maps must be a mapping of positions to maps, such as {{(1, 0, 0): env}}; got"
                f" {describe(maps)}"
            )
        envs = [as_envmap(each) for each in maps.values()]
        if any(each.units != self.remainder.units for each in envs):
            raise EnvLightsError(
                "maps and placed lights must have the same units; calibrate all maps, also the one"
                " of `place`, or none"
            )
        normals, weights = icosphere(320)
        points = np.reshape([triple("position", each) for each in maps], (-1, 3))
        truth = [each.probe(normals) for each in envs]
        home = np.repeat(self.irradiance(np.zeros((1, 3)), normals), len(points), axis=0)
        errors = [
            np.array([relative_rms(*pair, weights) for pair in zip(guess, truth, strict=True)])
            for guess in (self.irradiance(points, normals), home)
        ]
        return PointErrors(points, *errors)

    def _remainder_at(self, point: Reals) -> EnvMap:
        """Map of the surfaces at a point."""
        if self.depth is None or not point.any():
            return self.remainder
        radiance = warp(self.remainder.filled().cells(), self.depth, point)
        return EnvMap(radiance, units=self.remainder.units)

    def _notes_at(self, point: Reals) -> tuple[str, ...]:
        """Notes, and one on a point that the camera does not see or whose surfaces are unknown."""
        if self.depth is None and point.any():
            return (
                *self.notes,
                "there is no depth, so surfaces are as from the camera, and only lights move",
            )
        surface = np.inf if self.depth is None else surface_behind(self.depth, point)
        if np.linalg.norm(point) <= surface:
            return self.notes
        place = " ".join(f"{metres:.4g}" for metres in point)
        where = f"the point ({place}) lies behind a surface at {surface:.4g} m"
        return (*self.notes, f"{where}, so its light is a guess")

    def _all_notes(self, point: Reals) -> tuple[str, ...]:
        """Notes of the map, except on lights that were removed, and those at a point."""
        of_map = (note for note in self.remainder.notes if Note(note).code != "removed")
        return tuple(dict.fromkeys((*of_map, *self._notes_at(point))))

    def _around(self, points: Reals, normals: Reals) -> Reals:
        """Irradiance of surfaces and suns, (p, n, 3): the camera's, and the change of patches."""
        there = near_irradiance(points, normals, (), self.patches)
        here = near_irradiance(np.zeros((1, 3)), normals, (), self.patches)
        surfaces = np.maximum(self.remainder.probe(normals) + there - here, 0)
        values: Reals = surfaces + self._suns(normals)
        return values

    def _suns(self, normals: Reals) -> Reals:
        suns = self._lamps_from(np.zeros(3), self._of_kind("sun"))
        arrays = suns.direction, suns.irradiance, suns.angular_radius
        return rig_irradiance(normals, np.zeros(3), *arrays)

    def _pieces(self, point: Reals, most: int) -> list[PlacedLight]:
        """Lights, with large rectangles in quarters as long as there are at most `most` lights."""
        pieces, left = list[PlacedLight](), most - len(self.lights)
        for light in self.lights:
            is_cut = left >= 3 and light.kind == "plane" and not light.is_disc
            if is_cut and light.seen_from(point)[2] > _LARGE:
                pieces, left = pieces + light.quarters(), left - 3
            else:
                pieces.append(light)
        return pieces

    def _lamps_from(self, point: Reals, lights: Sequence[PlacedLight]) -> Lights:
        """Lights as discs; those that turn their back are left out."""
        seen = [light.seen_from(point) for light in lights]
        shine = [each for each in seen if each[1].any()]
        direction, irradiance, radius = (np.array([each[k] for each in shine]) for k in range(3))
        vectors = direction.reshape(-1, 3), irradiance.reshape(-1, 3)
        return Lights(*vectors, radius, units=self.remainder.units)

    def _cards_around(self, point: Reals) -> Cards:
        """Lights as cards around a point; planes that turn their back are left out."""
        lights = [each for each in self.lights if np.linalg.det(each.around(point)) > 0]
        return Cards(
            tuple(map(_shape, lights)),
            np.reshape([each.around(point) for each in lights], (-1, 3, 3)),
            np.reshape([each.seen_from(point)[1] for each in lights], (-1, 3)),
            tuple(map(_texture, lights)),
            units=self.remainder.units,
            is_placed=True,
        )

    def in_short(self) -> str:
        """Number of lights of each kind, and of patches."""
        counts = ((len(self._of_kind(kind)), kind) for kind in ("plane", "sphere", "sun"))
        lights = [quantity(number, kind) for number, kind in counts if number] or ["no light"]
        return ", ".join(lights) + f", and {len(self.patches)} patches" * bool(len(self.patches))

    def _table(self) -> Table:
        some, scale = self.lights[:MOST_ROWS], self.remainder.units
        rows = [
            [
                *(f"{number}", light.kind, *(f"{value:.2f}" for value in light.position)),
                *(
                    " x ".join(f"{value:.2f}" for value in light.size),
                    percent(round(light.uncertainty, 6)),
                ),
                rgb_cell(light.irradiance),
            ]
            for number, light in enumerate(some, 1)
        ]
        more = quantity(len(self) - len(some), "more light") if len(self) > len(some) else ""
        colours = thumbnails.hex_of(np.reshape([light.irradiance for light in some], (-1, 3)))
        names = ["light", "kind", "x", "y", "z", "size", "uncertainty", rgb_heading(scale)]
        return Table(names, rows, more if rows else "no light", colours)

    def _lines(self) -> list[str]:
        return [f"note: {note}" for note in self.notes]

    def to_dict(self) -> dict[str, Any]:
        """Lists of numbers and strings for each light, for example for JSON."""
        names = ("position", "normal", "up", "size", "radiance", "intensity", "irradiance")
        rows = [
            {"kind": light.kind, "is_disc": light.is_disc, "radius": light.radius}
            | {name: getattr(light, name).tolist() for name in names}
            for light in self.lights
        ]
        return {"lights": rows, "scale": self.remainder.units, "notes": list(self.notes)}


def near_irradiance(
    points: Reals, normals: Reals, lights: Sequence[PlacedLight], patches: Reals
) -> Reals:
    """Irradiance of lights and patches with positions, (p, n, 3)."""
    spheres = [
        [*each.position, each.radius, *each.irradiance] for each in lights if each.kind == "sphere"
    ]
    planes = [
        [*each.matrix.T.ravel(), each.is_disc, *each.irradiance]
        for each in lights
        if each.kind == "plane"
    ]
    globes, cards = np.array(spheres, float), np.array(planes, float)
    arrays = globes.reshape(-1, 7), cards.reshape(-1, 13)
    return _native.near_irradiance(points, normals, *arrays, patches)


def _shape(light: PlacedLight) -> str:
    """Shape of the card of a light."""
    flat = "disc" if light.is_disc else "rectangle"
    return {"plane": flat, "sun": "other"}.get(light.kind, light.kind)


def _texture(light: PlacedLight) -> NDArray[np.floating[Any]]:
    """Texture of the card of a light; round ones shine evenly, and pixels on their rims do not."""
    is_round = light.kind == "sphere" or (light.kind == "plane" and light.is_disc)
    return light.radiance[None, None] if is_round else light.texture
