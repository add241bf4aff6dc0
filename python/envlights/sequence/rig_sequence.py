"""Rigs of all frames of a sequence, with measurements of their lights over time."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import count
from envlights._common.result import TableResult
from envlights._common.tables import MOST_ROWS, Table
from envlights._common.words import percent, quantity
from envlights._native import EnvLightsError
from envlights.kernels.image import LUMINANCE
from envlights.rigs.rig import error_of
from envlights.sequence.formats import read_json_lines, save
from envlights.sequence.frame_rig import FrameRig
from envlights.sequence.light_tracks import checked_rigs
from envlights.sequence.steadiness import MOST_FRAMES, frame_rate


@dataclass(frozen=True, eq=False, repr=False)
class RigSequence(TableResult):
    """Rigs of the frames of a sequence; a light has the same `id` in all frames.

    Arrays have a row for each frame and a column for each identity in `ids`.

    Examples
    --------
    >>> import envlights as el
    >>> lamp = el.Lights([[0, 0, 1]], [[2, 2, 2]], [0.1]).to_map(64)
    >>> rigs = el.follow([lamp, lamp, lamp], lights=1).sequence()
    >>> len(rigs), rigs.ids, rigs.flux.shape, round(rigs.flicker, 6)
    (3, (0,), (3, 1), 0.0)
    """

    rigs: tuple[FrameRig, ...]
    """Rig of each frame."""

    steadiness: int = 0
    """Half-width in frames of the averaging window."""

    fps: float | None = None
    """Frames per second, or None."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "rigs", tuple(checked_rigs(self.rigs)))
        if len({(np.shape(rig.ambient), rig.units, rig.floor) for rig in self.rigs}) > 1:
            raise EnvLightsError(
                "rigs must have the same kind of ambient term, units and floor in all frames"
            )

        count("steadiness", self.steadiness, most=MOST_FRAMES)
        frame_rate(self.fps)

    def __len__(self) -> int:
        return len(self.rigs)

    def __iter__(self) -> Iterator[FrameRig]:
        return iter(self.rigs)

    def __getitem__(self, frame: int) -> FrameRig:
        """Rig of a frame."""
        return self.rigs[frame]

    @cached_property
    def ids(self) -> tuple[int, ...]:
        """Identities of all lights, ascending."""
        return tuple(sorted({identity for rig in self.rigs for identity in rig.ids}))

    @property
    def direction(self) -> NDArray[np.float64]:
        """Unit vectors to the lights, (frames, ids, 3); NaN in frames without the light."""
        return self._by_identity(lambda rig: rig.lights.direction, 3, np.nan)

    @property
    def irradiance(self) -> NDArray[np.float64]:
        """Irradiance of the lights at normal incidence, (frames, ids, 3); 0 without the light."""
        return self._by_identity(lambda rig: rig.lights.irradiance, 3, 0.0)

    @property
    def angular_radius(self) -> NDArray[np.float64]:
        """Angular radius in radians, (frames, ids); NaN in frames without the light."""
        return self._by_identity(lambda rig: rig.lights.angular_radius[:, None], 1, np.nan)[..., 0]

    @property
    def ambient(self) -> NDArray[np.float64]:
        """Ambient radiance, (frames, 3), or its harmonics, (frames, 9, 3)."""
        return np.array([rig.ambient for rig in self.rigs])

    @property
    def flux(self) -> NDArray[np.float64]:
        """Luminance of the irradiance of each light, (frames, ids); 0 without the light."""
        flux: NDArray[np.float64] = self.irradiance @ LUMINANCE
        return flux

    @property
    def error(self) -> NDArray[np.float64]:
        """Relative RMS error of each rig under its own map, (frames,); NaN if not measured."""
        return np.array([error_of(rig) for rig in self.rigs])

    @property
    def fit_error(self) -> NDArray[np.float64]:
        """Relative RMS error of the fit to each frame alone, (frames,)."""
        return np.array([rig.fit_error for rig in self.rigs])

    @property
    def motion_deg(self) -> NDArray[np.float64]:
        """Angle in degrees between the directions of consecutive frames, (frames - 1, ids).

        NaN if either frame does not have the light.
        """
        chord = np.linalg.norm(np.diff(self.direction, axis=0), axis=2)
        angles: NDArray[np.float64] = np.rad2deg(2 * np.arcsin(np.minimum(chord / 2, 1)))
        return angles

    @property
    def flicker(self) -> float:
        r"""Flicker of the lights under constant lighting.

        With the flux F of the light i in the frame k, and D its second difference
        :math:`F_{i,k-1} - 2 F_{i,k} + F_{i,k+1}`, it is
        :math:`\sqrt{\mathrm{mean}_k \sum_i D_{i,k}^2 / 6} \,/\, \mathrm{mean}_k \sum_i F_{i,k}`.
        Changes at constant speed count nothing. Independent noise of one light counts by its
        relative standard deviation, because D has 6 times its variance. Differences across a step
        of the light are left out; 0 if none is left.
        """
        flux = self.flux
        is_step = np.array([rig.is_step for rig in self.rigs])
        second = flux[:-2] - 2 * flux[1:-1] + flux[2:]
        second = second[~(is_step[1:-1] | is_step[2:])[: len(second)]]
        mean = flux.sum(axis=1).mean()
        if not len(second) or mean == 0:
            return 0.0
        return float(np.sqrt((second**2).sum(axis=1).mean() / 6) / mean)

    def _by_identity(self, values_of: Any, width: int, missing: float) -> NDArray[np.float64]:
        """Values of each light, one column per identity, (frames, ids, width)."""
        table = np.full((len(self.rigs), len(self.ids), width), missing)
        for row, rig in enumerate(self.rigs):
            table[row, np.searchsorted(self.ids, rig.ids)] = values_of(rig)
        return table

    def save(self, path: str | os.PathLike[str], **options: Any) -> None:
        """Write the sequence in the format of the suffix; a failure leaves no file.

        Parameters
        ----------
        path : path-like
            ``.jsonl``: a rig in each line, lossless; `load` reads it. ``.csv``: a row for each
            light of each frame. ``.usda``, ``.usdc``, ``.usd``: time samples. ``.gltf``: an
            animation. ``.py``: keyframes for Blender.
        **options
            `up` and `metres_per_unit` of an OpenUSD file, as in `el.export.usd`.

        See Also
        --------
        envlights.sequence : functions that return text and dictionaries.
        """
        save(self, path, self.steadiness, self.fps, **options)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> RigSequence:
        """Read a sequence that `save` wrote as ``.jsonl``.

        Raises
        ------
        EnvLightsError
            If the file is missing, or is no complete sequence.
        """
        rigs, steadiness, fps = read_json_lines(path)
        return cls(rigs, steadiness, fps)

    def to_dict(self) -> dict[str, Any]:
        """All fields as plain numbers, lists and strings."""
        return {
            "steadiness": self.steadiness,
            "fps": self.fps,
            "flicker": self.flicker,
            "rigs": [rig.to_dict() for rig in self.rigs],
        }

    def columns(self) -> dict[str, NDArray[Any]]:
        """Columns by name, with a value per light and frame."""
        numbers = [len(rig.ids) for rig in self.rigs]
        direction, irradiance = (
            np.concatenate([getattr(rig.lights, name) for rig in self.rigs])
            for name in ("direction", "irradiance")
        )
        return {
            "frame": np.repeat([rig.frame for rig in self.rigs], numbers),
            "id": np.array([each for rig in self.rigs for each in rig.ids], np.int64),
            **dict(zip("xyz", direction.T, strict=True)),
            **dict(zip(("red", "green", "blue"), irradiance.T, strict=True)),
            "angular_radius": np.concatenate([rig.lights.angular_radius for rig in self.rigs]),
        }

    def in_short(self) -> str:
        """Number of frames and lights, mean error and flicker."""
        frames, lights = quantity(len(self), "frame"), quantity(len(self.ids), "light")
        mean = self.error.mean()
        error = "error not measured" if np.isnan(mean) else f"mean error {percent(mean)}"
        return f"{frames}, {lights}, {error}, flicker {percent(self.flicker, 2)}"

    def table(self) -> Table:
        """Table of the twelve lights with the most flux over all frames."""
        flux, motion = self.flux, self.motion_deg
        order = np.argsort(-flux.sum(axis=0), kind="stable")
        columns = ["id", "frames", "fraction", "mean flux", "fastest motion"]
        rows = [self._cells(column, flux, motion) for column in order[:MOST_ROWS]]
        hidden = len(order) - MOST_ROWS
        rest = quantity(hidden, "more light") if hidden > 0 else ""
        return Table(columns, rows, rest if rows else "no light")

    def _cells(
        self, column: int, flux: NDArray[np.float64], motion: NDArray[np.float64]
    ) -> list[str]:
        frames = [self.rigs[row].frame for row in np.flatnonzero(flux[:, column])]
        steps = motion[:, column][~np.isnan(motion[:, column])]
        return [
            f"{self.ids[column]}",
            f"{frames[0]} to {frames[-1]}" if frames else "none",
            f"{100 * flux[:, column].sum() / (flux.sum() or 1):.1f} %",
            f"{flux[:, column].mean():.4g}",
            f"{steps.max():.2f}° a frame" if len(steps) else "none",
        ]

    def _lines(self) -> list[str]:
        """Lines below the table."""
        searches = [rig.frame for rig in self.rigs if rig.is_search]
        steps = [rig.frame for rig in self.rigs if rig.is_step]
        return [
            f"{len(self)} frames, steadiness {self.steadiness} frames"
            + (f" at {self.fps:g} frames in a second" if self.fps else ""),
            f"relative RMS error {self._errors()}; of the fits alone"
            f" {percent(self.fit_error.mean())}",
            f"flicker {percent(self.flicker, 2)}",
            f"searches that changed the lights: {_some(searches)}; steps of the light:"
            f" {_some(steps)}",
        ]

    def _errors(self) -> str:
        errors = self.error
        if np.isnan(errors).any():
            return "not measured"
        worst = int(errors.argmax())
        most = f"{percent(errors[worst])} in frame {self.rigs[worst].frame}"
        return f"{percent(errors.mean())} on average, at most {most}"


def _some(frames: list[int]) -> str:
    if not frames:
        return "none"
    rest = f" and {len(frames) - MOST_ROWS} more" if len(frames) > MOST_ROWS else ""
    return f"frame{'' if len(frames) == 1 else 's'} {', '.join(map(str, frames[:MOST_ROWS]))}{rest}"
