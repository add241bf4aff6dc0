"""Panels of an exported scene: cards as planes in front of the map."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights.environment.envmap import EnvMap
from envlights.export.look_up import looked_up
from envlights.export.targets import AXES, target_named

#: Smallest rows and columns of a texture that shows the map behind a uniform card.
_HIDDEN_TEXELS = 16
#: Largest cosine between the sides that counts as a right angle.
_SQUARE = 1e-6
#: Vertices of the polygon of a disc; its area is 0.16 % less than that of a circle.
VERTICES = 64


class Panel(NamedTuple):
    """Planar light: the points O + a U + b V, or the ellipse inscribed in this parallelogram.

    Or a sphere, in whose facing square the inscribed disc is its silhouette from the origin.

    Seen from the origin, U goes to the right and V down, in the frame of envlights.
    """

    name: str
    """Name in the scene, such as ``card_0``."""

    matrix: NDArray[np.float64]
    """Columns U, V, O, (3, 3)."""

    shape: str
    """"rectangle", "tube", "disc" or "sphere"."""

    irradiance: NDArray[np.float64]
    """Irradiance at the origin for a normal towards the panel's centre, (3,)."""

    radiance: NDArray[np.float64]
    """Uniform radiance of the light, without the map behind it, (3,)."""

    texture: NDArray[np.float32]
    """Radiance of the light, without the map behind it, (rows, columns, 3), row 0 at b = 0."""

    hidden: NDArray[np.float32]
    """Radiance of the map behind the panel, in the size of `texture`."""

    @property
    def opaque_texture(self) -> NDArray[np.float32]:
        """Texture for renderers in which the panel hides the map behind it."""
        return self.texture + self.hidden

    @property
    def opaque_radiance(self) -> NDArray[np.float64]:
        """Uniform radiance for renderers in which the panel hides the map behind it."""
        places = _texel_centres(self.hidden)
        # The solid angle of a texel falls with the cube of its distance.
        weights = np.linalg.norm(places @ self.matrix.T, axis=-1) ** -3
        if self.shape in ("disc", "sphere"):
            weights *= ((2 * places[..., :2] - 1) ** 2).sum(axis=-1) <= 1
        mean: NDArray[np.float64] = np.einsum("yx,yxc->c", weights / weights.sum(), self.hidden)
        return self.radiance + mean

    @property
    def radius(self) -> float:
        """Radius of a sphere."""
        u, v, start = self.matrix.T
        half, distance = np.linalg.norm([u / 2, start + (u + v) / 2], axis=1)
        return float(half * distance / np.hypot(half, distance))

    @property
    def intensity(self) -> NDArray[np.float64]:
        """Radiant intensity of a sphere, (3,)."""
        u, v, start = self.matrix.T
        intensity: NDArray[np.float64] = self.irradiance * ((start + (u + v) / 2) ** 2).sum()
        return intensity

    @property
    def is_rectangle(self) -> bool:
        """True if the sides U and V are perpendicular."""
        u, v, _ = self.matrix.T
        return bool(abs(u @ v) <= _SQUARE * np.linalg.norm(u) * np.linalg.norm(v))

    @property
    def size(self) -> NDArray[np.float64]:
        """Lengths of U and V, (2,)."""
        lengths: NDArray[np.float64] = np.linalg.norm(self.matrix[:, :2], axis=0)
        return lengths

    def axes(self, target: str) -> tuple[NDArray[np.float64], ...]:
        """U, V, the unit vector to the origin's side, and the centre, in the target's frame."""
        u, v, start = self.matrix.T
        facing = np.cross(v, u)
        vectors = u, v, facing / np.linalg.norm(facing), start + (u + v) / 2
        return tuple(AXES[target].to_target(vector) for vector in vectors)

    def outline(self, target: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Vertices in the target's frame, (n, 3), and their (a, b), (n, 2).

        They go counter-clockwise as seen from the origin: top left, bottom left, and so on.
        """
        if self.shape == "disc":
            angle = 2 * np.pi * np.arange(VERTICES) / VERTICES
            places = 0.5 + 0.5 * np.stack([np.cos(angle), -np.sin(angle)], axis=1)
        else:
            places = np.array([[0, 0], [0, 1], [1, 1], [1, 0]], float)
        points = np.insert(places, 2, 1.0, axis=1) @ self.matrix.T
        return AXES[target].to_target(points), places


def crop_names(panels: tuple[Panel, ...], prefix: str, target: str) -> list[str]:
    """Texture name for each panel in the files of a target; empty if it has no textures."""
    crop = target_named(target).crop
    return [] if crop is None else crop.names(prefix, (each.shape for each in panels))


def distant_and_panels(
    rig: Any, environment: EnvMap | None, factor: float = 1.0
) -> tuple[Any, tuple[Panel, ...]]:
    """Lights at infinity of a rig, lights or cards, and the panels of cards.

    Parameters
    ----------
    rig : Rig, Lights or Cards
    environment : EnvMap, optional
        Cell-centred map behind the panels.
    factor : float
        Factor of all radiance, for the units of a target.
    """
    if not hasattr(rig, "has_outline"):
        return getattr(rig, "lights", rig).discs(), ()
    shown = rig[rig.has_outline]
    cards = shown if shown.is_placed else shown.far()
    panels = (_panel(j, card, environment, factor) for j, card in enumerate(cards))
    return rig.distant, tuple(panels)


def _panel(j: int, card: Any, environment: EnvMap | None, factor: float) -> Panel:
    texture = card.texture
    if environment is not None:
        times = [-(-_HIDDEN_TEXELS // length) for length in texture.shape[:2]]
        texture = texture.repeat(times[0], axis=0).repeat(times[1], axis=1)
    hidden = np.zeros_like(texture) if environment is None else _behind(card, texture, environment)
    return Panel(
        f"card_{j}",
        card.matrix,
        card.shape,
        factor * card.irradiance,
        factor * card.radiance,
        np.float32(factor) * texture,
        np.float32(factor) * hidden,
    )


def _texel_centres(texture: NDArray[np.float32]) -> NDArray[np.float64]:
    """Coordinates (a, b, 1) of each texel, (rows, columns, 3)."""
    rows, columns, _ = texture.shape
    b, a = (np.arange(rows) + 0.5)[:, None] / rows, (np.arange(columns) + 0.5) / columns
    return np.stack(np.broadcast_arrays(a, b, 1.0), axis=-1)


def _behind(card: Any, texture: NDArray[np.float32], env: EnvMap) -> NDArray[np.float32]:
    """Radiance of the map in the direction of each texel of a card."""
    towards = _texel_centres(texture).reshape(-1, 3) @ card.matrix.T
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    return looked_up(env, towards).reshape(texture.shape)
