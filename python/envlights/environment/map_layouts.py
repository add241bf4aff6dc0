"""A map in other layouts: rotation, size, pictures in any projection, a limit of the radiance."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, check_choice, count, rotation
from envlights._native import EnvLightsError
from envlights.environment import resample
from envlights.environment.files.images import MOST_PIXELS
from envlights.environment.layouts import layout as layouts
from envlights.environment.layouts.conventions import CONVENTIONS, CROSSES
from envlights.environment.layouts.layout import MAPPINGS, Layout
from envlights.environment.layouts.picture import Picture, picture_of, straight
from envlights.environment.layouts.records import REGISTRATIONS
from envlights.environment.map_pixels import MapPixels, checked_width
from envlights.environment.peaks import spread_peaks

if TYPE_CHECKING:
    from typing_extensions import Self


class MapLayouts(MapPixels):
    """Other layouts of a map; see `EnvMap`."""

    def rotated(self, matrix: ArrayLike) -> Self:
        """Rotate the map, so that the radiance from d comes from ``matrix @ d``.

        Parameters
        ----------
        matrix : array_like, shape (3, 3)
            A rotation, in the frame of the map.

        Returns
        -------
        EnvMap
            Map of the same size. Rotations about the pole by whole columns lose nothing. Other
            rotations average samples of each pixel, keep the flux of the map, the flux and the
            direction of each bright pixel, and make a border-sampled map cell-centred.

        See Also
        --------
        Rig.rotated : the same for a rig.

        Examples
        --------
        A quarter turn about the pole, from +z to +x:

        >>> import envlights as el
        >>> env = el.EnvMap(np.eye(8)[:4, :, None] * np.ones(3))
        >>> turned = env.rotated([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])
        >>> np.array_equal(turned.radiance, np.roll(env.radiance, -2, axis=1))
        True
        """
        radiance, coverage, is_border = resample.rotate(
            self._radiance, self._coverage, rotation(matrix), border_sampled=self.is_border_sampled
        )
        return self._with(radiance, coverage, REGISTRATIONS[is_border])

    def resized(self, width: int) -> Self:
        """Map of another size, with the same flux.

        Parameters
        ----------
        width : int
            Columns, even; the height is half of it.

        Returns
        -------
        EnvMap
            Cell-centred. Every bright pixel keeps its flux and its direction.

        Examples
        --------
        >>> import envlights as el
        >>> el.EnvMap(np.ones((64, 128, 3))).resized(32)
        EnvMap(32x16 equirectangular, cell-centred)
        """
        target = layouts.equirectangular(checked_width(width) // 2)
        radiance, coverage = resample.resample(
            self._radiance, self._coverage, self._layout(), target
        )
        return self._with(radiance, coverage, REGISTRATIONS[0])

    def to(
        self,
        projection: str,
        *,
        width: int | None = None,
        faces: str = "opengl",
        registration: str | None = None,
        mapping: str | None = None,
        fov: float | None = None,
        forward: ArrayLike | None = None,
    ) -> Picture:
        """Picture of the map in another projection.

        Parameters
        ----------
        projection : str
            "cube", "octahedral", "octahedral-equal-area", "angular", "mirror-ball", "fisheye",
            "cylinder", "planar", "equirectangular", or "source": the layout of `EnvMap.source`,
            with its size, faces, orientation and field of view, as for the rest of `split`.
        width : int, optional
            Columns; of a cube, those of one face. When left out, the pixels are as large as those
            of the map on its equator.
        faces : str
            Order of the faces of a cube: "opengl" (also of DirectX, Vulkan, Unity), "openexr",
            "py360convert", "pannellum", "directxtex".
        registration : {"cell-centred", "border-sampled"}, optional
            Positions of the samples of a cube's face. When left out, that of its order.
        mapping : {"equidistant", "equisolid", "stereographic", "orthographic"}, optional
            Mapping of a fisheye.
        fov : float, optional
            Field of view in degrees: across the circle of a fisheye, horizontally of a photograph
            or a cylinder.
        forward : array_like, shape (3,), optional
            Direction of the centre of a circle, a square or a photograph.

        Returns
        -------
        Picture
            `numpy.asarray` gives its samples; `Picture.save` writes files.

        Raises
        ------
        EnvLightsError
            If the projection is not known, or an argument is missing, out of its range or of
            another projection.

        Examples
        --------
        >>> import envlights as el
        >>> el.EnvMap(np.ones((64, 128, 3))).to("cube", width=32)
        Picture(32x192 cube, cell-centred, faces in the order of OpenGL)
        """
        check_choice("projection", projection, (*_TARGETS, SOURCE))
        check_choice("faces", faces, tuple(CONVENTIONS))
        options = {"registration": registration, "mapping": mapping, "fov": fov, "forward": forward}
        options |= {"width": width} if projection == SOURCE else {}
        _check_options(projection, [name for name, value in options.items() if value is not None])
        if projection == SOURCE:
            return self._in_layout_of_source()
        is_border = CONVENTIONS[faces].border_sampled
        if registration is not None:
            check_choice("registration", registration, REGISTRATIONS)
            is_border = registration == REGISTRATIONS[1]
        request = _Request(projection, is_border, mapping, fov, forward)
        columns = self._width_of(request) if width is None else count("width", width, least=2)
        layout = request.layout(columns)
        if layout.height * layout.width > MOST_PIXELS:
            raise EnvLightsError(f"width must give at most {MOST_PIXELS} pixels; got {columns}")
        return self._picture(layout, faces)

    def view(
        self,
        direction: ArrayLike,
        fov: float = 60.0,
        *,
        width: int = 800,
        height: int | None = None,
    ) -> Picture:
        """Picture that a level camera takes in the map.

        Parameters
        ----------
        direction : array_like, shape (3,)
            Direction of the centre of the picture.
        fov : float
            Horizontal field of view, in degrees.
        width, height : int
            Size of the picture; 3:2 when `height` is left out.

        Returns
        -------
        Picture
            Radiance, (height, width, 3).

        Examples
        --------
        >>> import envlights as el
        >>> el.EnvMap(np.ones((64, 128, 3))).view([0, 0, 1], width=90)
        Picture(90x60 planar)
        """
        columns = count("width", width, least=1)
        rows = max(round(columns / 1.5), 1) if height is None else count("height", height, least=1)
        if rows * columns > MOST_PIXELS:
            raise EnvLightsError(f"a view has at most {MOST_PIXELS} pixels; got {columns}x{rows}")
        view = math.radians(amount("fov", fov, 0.1, 179))
        axes = layouts.looking(direction, "direction")
        return self._picture(layouts.planar(rows, columns, field_of_view=view, axes=axes), "opengl")

    def limited(self, maximum: float) -> Self:
        """Map without samples above a maximum, for formats and displays that have one.

        The excess of each light is spread over the pixels around it, so that flux and direction of
        the light stay. `envlights.limit` returns the excess as lights instead.

        Parameters
        ----------
        maximum : float
            Largest value of a sample, such as 65504 for half floats.

        Returns
        -------
        EnvMap
            The last note says how much flux was moved, and how far.

        Raises
        ------
        EnvLightsError
            If the mean radiance of the map is above the maximum.

        Examples
        --------
        >>> import envlights as el
        >>> sky = np.ones((64, 128, 3))
        >>> sky[20, 40] = 1e5
        >>> env = el.EnvMap(sky).limited(65504)
        >>> float(env.radiance.max())
        65504.0
        >>> env.notes[-1]
        'limited to 65504: 32 % of the flux was moved by up to 4.2 degrees'
        """
        level = amount("maximum", maximum)
        radiance, note = spread_peaks(self._radiance, level, self.is_border_sampled, self._coverage)
        limited = self._with(radiance, self._coverage, self.registration)
        limited._notes += note
        return limited

    def _layout(self) -> Layout:
        size = self._radiance.shape[:2]
        return layouts.equirectangular(*size, border_sampled=self.is_border_sampled)

    def _with(
        self, radiance: NDArray[np.float32], coverage: NDArray[np.float32] | None, registration: str
    ) -> Self:
        """Map with other pixels of the same world."""
        clip_level = self._clip_level
        if clip_level is not None:
            radiance = np.minimum(radiance, np.float32(clip_level))
        env = type(self).unchecked(
            radiance,
            registration=registration,
            notes=self._notes,
            clip_level=clip_level,
            coverage=coverage,
            source=self._source,
        )
        return self._of_same_scale(env)

    def _picture(self, layout: Layout, faces: str, arrangement: str = "stack") -> Picture:
        image, coverage = self._radiance, self._coverage
        if layout != self._layout():
            image, coverage = resample.resample(image, coverage, self._layout(), layout)
        picture = picture_of(
            image, layout, faces=faces, coverage=coverage, notes=self.notes, arrangement=arrangement
        )
        return replace(picture, units=self._units)

    def _in_layout_of_source(self) -> Picture:
        source = self._source
        layout, (height, width) = source.layout, source.size
        if layout == self._layout():
            return self._picture(layout, source.faces)
        if layout.kind == "equirectangular":
            layout = layout._replace(border_sampled=False)
        if source.faces in CROSSES:
            return straight(self._picture(layout, "opengl", source.faces))
        arrangement = "strip" if source.faces and width > height else "stack"
        return straight(self._picture(layout, source.faces, arrangement))

    def _width_of(self, request: _Request) -> int:
        """Columns of a picture whose mean pixel is as large as a cell of the equator."""
        trial = 64
        width = trial * self.width / resample.default_width(request.layout(trial))
        return max(2 * round(width / 2), 2)


def _check_options(projection: str, given: list[str]) -> None:
    """Refuse options that a projection does not take."""
    taken = _OPTIONS[projection]
    if others := [name for name in given if name not in taken]:
        allowed = f"it takes {', '.join(taken)}" if taken else "it takes none of them"
        raise EnvLightsError(
            f"{', '.join(others)} is no argument of the projection {projection!r}; {allowed}"
        )


class _Request:
    """Layout that a user asks for, in any size."""

    def __init__(
        self,
        projection: str,
        border_sampled: bool,
        mapping: str | None,
        fov: float | None,
        forward: ArrayLike | None,
    ) -> None:
        self.projection, self.border_sampled = projection, border_sampled
        self.mapping, self.fov, self.forward = mapping, fov, forward

    def layout(self, width: int) -> Layout:
        """Layout with a number of columns."""
        return _TARGETS[self.projection](self, width)

    def axes(self, default: layouts.Axes = layouts.FRONT) -> layouts.Axes:
        """Axes of the picture."""
        return default if self.forward is None else layouts.looking(self.forward)

    def view(self, default: float | None) -> float:
        """Field of view in radians, or a refusal if it is missing."""
        if self.fov is None and default is None:
            raise EnvLightsError(f"the projection {self.projection!r} needs fov=, in degrees")
        return math.radians(amount("fov", default if self.fov is None else self.fov, 0.1, 360))


def _equirectangular(request: _Request, width: int) -> Layout:
    return layouts.equirectangular(checked_width(width) // 2)


def _cube(request: _Request, width: int) -> Layout:
    return layouts.cube(width, border_sampled=request.border_sampled)


def _octahedral(request: _Request, width: int) -> Layout:
    return layouts.octahedral(width, axes=request.axes(layouts.UP))


def _equal_area(request: _Request, width: int) -> Layout:
    return layouts.octahedral(width, equal_area=True, axes=request.axes(layouts.PBRT))


def _angular(request: _Request, width: int) -> Layout:
    return layouts.angular_map(width, axes=request.axes())


def _mirror_ball(request: _Request, width: int) -> Layout:
    return layouts.mirror_ball(width)


def _fisheye(request: _Request, width: int) -> Layout:
    mapping = MAPPINGS[0] if request.mapping is None else request.mapping
    return layouts.fisheye(width, mapping, request.view(180), axes=request.axes())


def _cylinder(request: _Request, width: int) -> Layout:
    view = request.view(360)
    # Elevations of up to 45 degrees.
    return layouts.cylinder(max(round(2 * width / view), 1), width, field_of_view=view)


def _planar(request: _Request, width: int) -> Layout:
    height = max(round(width / 1.5), 1)
    return layouts.planar(height, width, field_of_view=request.view(None), axes=request.axes())


#: Name of the layout of a map's source.
SOURCE = "source"
#: Layouts by the name of their projection.
_TARGETS: dict[str, Callable[[_Request, int], Layout]] = {
    "equirectangular": _equirectangular,
    "cube": _cube,
    "octahedral": _octahedral,
    "octahedral-equal-area": _equal_area,
    "angular": _angular,
    "mirror-ball": _mirror_ball,
    "fisheye": _fisheye,
    "cylinder": _cylinder,
    "planar": _planar,
}

#: Options of each projection, beside its width and the faces of a cube.
_OPTIONS: dict[str, tuple[str, ...]] = {
    "equirectangular": (),
    "cube": ("registration",),
    "octahedral": ("forward",),
    "octahedral-equal-area": ("forward",),
    "angular": ("forward",),
    "mirror-ball": (),
    "fisheye": ("mapping", "fov", "forward"),
    "cylinder": ("fov",),
    "planar": ("fov", "forward"),
    SOURCE: (),
}
