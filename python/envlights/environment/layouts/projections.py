"""Layouts for users: a class method of `Layout` and a row of `PROJECTIONS` per projection."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import KW_ONLY, dataclass, fields, replace
from functools import cache
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import amount, check_choice, describe, positive, reals
from envlights._native import EnvLightsError
from envlights.environment.files.hints import NO_HINTS, Hints
from envlights.environment.layouts import picture_layout as layouts
from envlights.environment.layouts.conventions import CONVENTIONS, NAMES
from envlights.environment.layouts.near_ball import reach_of
from envlights.environment.layouts.picture_layout import MAPPINGS, Axes, PictureLayout

#: Names of the sample positions.
REGISTRATIONS: tuple[str, str] = ("cell-centred", "border-sampled")
#: Target of `EnvMap.to` for the layout of the original picture.
SOURCE = "source"
#: Names of the halves of a stereo picture.
EYES = ("left", "right")


@dataclass(frozen=True)
class Layout:
    """Projection of a picture, with its arguments.

    `EnvMap`, `EnvMap.open` and `EnvMap.to` take it, or the name of a projection, as ``layout=``.
    The class methods make it, one for each projection. An argument that is left out is recognised
    from the picture, or a refusal asks for it; `EnvMap.to` has a default for most.

    Without a projection, the picture or the statement of its file decides on it, and the arguments
    replace single entries of that statement.

    Examples
    --------
    >>> Layout.fisheye(mapping="equisolid", fov=180)
    Layout.fisheye(mapping='equisolid', fov=180)
    >>> Layout("cube") == Layout.cube()
    True
    >>> Layout(eye="left")
    Layout(eye='left')
    """

    projection: str | None = None
    """Name of the projection: that of a class method, with "-" in place of "_"."""

    _: KW_ONLY

    faces: str | None = None
    """Order of the faces of a cube."""

    registration: str | None = None
    """Positions of the samples: "cell-centred" or "border-sampled"."""

    mapping: str | None = None
    """Mapping of a fisheye: one of `MAPPINGS`."""

    fov: float | None = None
    """Field of view in degrees: horizontal, or across the circle of a fisheye."""

    horizon: float | None = None
    """Row of elevation 0 in a cylinder or a crop of a panorama."""

    circle: ArrayLike | None = None
    """Centre x, centre y and radius of a circle, in pixels."""

    forward: ArrayLike | None = None
    """Direction of the centre of the picture."""

    eye: str | None = None
    """Half of a stereo panorama: "left" or "right"."""

    distance: float | None = None
    """Distance of the camera from the centre of a mirror ball, in radii of the ball."""

    axes: ArrayLike | None = None
    """Unit vectors forward, right and up of the picture, from the statement of a file."""

    def __post_init__(self) -> None:
        for name, choices in (
            ("projection", tuple(PROJECTIONS)),
            ("faces", NAMES),
            ("registration", REGISTRATIONS),
            ("mapping", MAPPINGS),
            ("eye", EYES),
        ):
            if (value := getattr(self, name)) is not None:
                check_choice(name, value, choices)
        if self.fov is not None:
            positive("fov", self.fov, 360)
        if self.distance is not None and amount("distance", self.distance) <= 1:
            raise EnvLightsError(
                "distance must be above 1, in radii from the centre of the mirror ball; got"
                f" {self.distance:g}"
            )
        for name, checked in (
            ("circle", _circle),
            ("forward", _direction),
            ("axes", layouts.checked_axes),
        ):
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, checked(value))
        if self.projection is not None:
            _check_unused(self.projection, self.arguments())

    def entries(self) -> dict[str, Any]:
        """All fields that are not None."""
        each = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value for name, value in each.items() if value is not None}

    def arguments(self) -> dict[str, Any]:
        """Arguments that are not None, except projection and axes."""
        others = ("projection", "axes")
        return {name: value for name, value in self.entries().items() if name not in others}

    def __repr__(self) -> str:
        given = self.entries()
        given.pop("projection", None)
        method = f".{_method(self.projection)}" if self.projection else ""
        each = ", ".join(f"{name}={value!r}" for name, value in given.items())
        return f"Layout{method}({each})"

    @classmethod
    def equirectangular(
        cls,
        *,
        registration: str | None = None,
        fov: float | None = None,
        horizon: float | None = None,
        eye: str | None = None,
    ) -> Layout:
        """Panorama of 2:1, or a part of one.

        Parameters
        ----------
        registration : {"cell-centred", "border-sampled"}, optional
            "cell-centred": a pixel covers the cell around its centre, as in most files.
            "border-sampled": the outer pixels lie on the seam and the poles, as in OpenEXR files
            with the `envmap` attribute.
        fov : float, optional
            Degrees of azimuth that a part of a panorama covers.
        horizon : float, optional
            Row of elevation 0 in a part of a panorama; the middle when left out.
        eye : {"left", "right"}, optional
            Half of a stereo panorama, of 1:1 or 4:1.

        Examples
        --------
        >>> import envlights as el
        >>> part = el.io.Layout.equirectangular(fov=90)
        >>> round(el.EnvMap(np.ones((64, 64, 3)), layout=part).coverage_fraction, 3)
        0.177
        """
        given = {"registration": registration, "fov": fov, "horizon": horizon, "eye": eye}
        return cls("equirectangular", **given)  # type: ignore[arg-type]

    @classmethod
    def cylinder(cls, *, fov: float | None = None, horizon: float | None = None) -> Layout:
        """Cylindrical panorama.

        Parameters
        ----------
        fov : float, optional
            Degrees of azimuth that it covers, if GPano does not state them; 360 in `EnvMap.to`.
        horizon : float, optional
            Row of elevation 0, which may lie outside; the middle when left out.
        """
        return cls("cylinder", fov=fov, horizon=horizon)

    @classmethod
    def cube(
        cls,
        *,
        faces: str | None = None,
        registration: str | None = None,
        fov: float | None = None,
    ) -> Layout:
        """Cube map: six squares, a strip, a stack, or a cross.

        Parameters
        ----------
        faces : str, optional
            Order of the faces: "opengl" (also of DirectX, Vulkan, Unity), "openexr",
            "py360convert", "pannellum", "directxtex", or the name of a cross. When left out, their
            edges decide; it is "opengl" in `EnvMap.to`.
        registration : {"cell-centred", "border-sampled"}, optional
            Positions of the samples of a face. When left out, that of the order.
        fov : float, optional
            Field of view of a face in degrees, 90 to 170, of a picture that is read; 90 when left
            out. Where wider faces overlap, the one whose centre is nearer counts.

        Examples
        --------
        >>> import envlights as el
        >>> el.EnvMap(np.ones((64, 128, 3))).to(el.io.Layout.cube(faces="openexr"), width=32)
        Picture(32x192 cube, border-sampled, faces in the order of OpenEXR)
        """
        return cls("cube", faces=faces, registration=registration, fov=fov)

    @classmethod
    def octahedral(cls, *, forward: ArrayLike | None = None) -> Layout:
        """Octahedron, unfolded to a square with up in its centre.

        Parameters
        ----------
        forward : array_like, shape (3,), optional
            Direction of the centre instead of up.
        """
        return cls("octahedral", forward=forward)

    @classmethod
    def octahedral_equal_area(cls, *, forward: ArrayLike | None = None) -> Layout:
        """Square of pbrt-v4, whose pixels have one solid angle.

        Parameters
        ----------
        forward : array_like, shape (3,), optional
            Direction of the centre instead of up.
        """
        return cls("octahedral-equal-area", forward=forward)

    @classmethod
    def angular(cls, *, forward: ArrayLike | None = None) -> Layout:
        """Angular map, or light probe: a disc of 360 degrees.

        Parameters
        ----------
        forward : array_like, shape (3,), optional
            Direction of the centre; +z when left out.
        """
        return cls("angular", forward=forward)

    @classmethod
    def mirror_ball(
        cls, *, circle: ArrayLike | None = None, distance: float | None = None
    ) -> Layout:
        """Photograph of a mirror ball.

        Parameters
        ----------
        circle : array_like, shape (3,), optional
            Centre x, centre y and radius of the ball, in pixels; the largest circle when left out.
        distance : float, optional
            Distance of the camera from the centre of the ball, in radii of the ball. The cone
            behind the ball is then not seen. When left out, the camera was far away, and a note
            states the error.
        """
        return cls("mirror-ball", circle=circle, distance=distance)

    @classmethod
    def fisheye(
        cls,
        *,
        mapping: str | None = None,
        fov: float | None = None,
        circle: ArrayLike | None = None,
        forward: ArrayLike | None = None,
    ) -> Layout:
        """Circular fisheye picture.

        Parameters
        ----------
        mapping : {"equidistant", "equisolid", "stereographic", "orthographic"}, optional
            Radius of a circle around the centre, by its angle. Required of a picture that is read;
            "equidistant" in `EnvMap.to`.
        fov : float, optional
            Degrees across the circle. Required of a picture that is read; 180 in `EnvMap.to`.
        circle : array_like, shape (3,), optional
            Centre x, centre y and radius, in pixels; the largest centred circle when left out.
        forward : array_like, shape (3,), optional
            Direction of the centre; +z when left out.
        """
        return cls("fisheye", mapping=mapping, fov=fov, circle=circle, forward=forward)

    @classmethod
    def planar(cls, *, fov: float | None = None, forward: ArrayLike | None = None) -> Layout:
        """Photograph without distortion.

        Parameters
        ----------
        fov : float
            Horizontal field of view in degrees; required, unless the file states it.
        forward : array_like, shape (3,), optional
            Direction of the centre; +z when left out.
        """
        return cls("planar", fov=fov, forward=forward)


def layout_of(layout: str | Layout | None, *others: str) -> Layout:
    """Layout of an argument ``layout=``; raises an error that lists `others` too."""
    if layout is None or isinstance(layout, Layout):
        return layout or Layout()
    if not isinstance(layout, str):
        raise EnvLightsError(
            "layout must be the name of a projection or a value such as el.io.Layout.cube(); got"
            f" {describe(layout)}"
        )
    check_choice("layout", layout, (*PROJECTIONS, *others))
    return Layout(layout)


def with_arguments(layout: str | Layout | None, **arguments: Any) -> Layout:
    """Layout with the former arguments of `EnvMap.open` added."""
    return replace(layout_of(layout), **arguments)


def with_target_arguments(layout: str | Layout | None, **arguments: Any) -> str | Layout:
    """Layout with the former arguments of `EnvMap.to` added.

    All projections had the argument `faces` there.
    """
    name = arguments.pop("projection", layout)
    if name != "cube":
        arguments.pop("faces", None)
    given = {each: value for each, value in arguments.items() if value is not None}
    if name == SOURCE and given:
        raise EnvLightsError(f"{', '.join(given)} is no argument of the layout 'source'")
    return with_arguments(name, **given) if given else name


def argument_for(layout: Layout) -> str:
    """Argument ``layout=`` for this layout, for a message."""
    is_name = layout == Layout(layout.projection)
    return f"layout={layout.projection!r}" if is_name else f"layout=el.io.{layout!r}"


def is_panorama(height: int, width: int) -> bool:
    """True for an aspect ratio of 2:1, within two columns in large pictures."""
    off = abs(width - 2 * height)
    return off == 0 or (off <= _OFF and off * _COLUMNS_PER_MISS <= width)


#: Number of columns by which the width of a panorama may differ from twice the height.
_OFF = 2
#: Smallest width per column of difference.
_COLUMNS_PER_MISS = 100

_Size = tuple[int, int]
#: Layout of a picture of a certain size, and notes on assumptions.
Placement = tuple[PictureLayout, tuple[str, ...]]


class Projection(NamedTuple):
    """Projection that a user can name."""

    title: str
    """Name with its article, for a message."""

    place: Callable[[Layout, _Size, Hints], Placement]
    """Function from a layout, a size and hints to the placement of a picture."""

    rows: Callable[[int, Layout], int]
    """Function from the number of columns in `EnvMap.to` to the number of rows."""

    defaults: Mapping[str, Any]
    """Default arguments of a picture that `EnvMap.to` creates."""

    shape: str = "any"
    """Usual shape: "panorama", "cube", "square", "disc" (in a black square) or "any"."""

    axes: Axes = layouts.FRONT
    """Axes of a picture without `forward`."""

    example: Mapping[str, Any] = MappingProxyType({})
    """Arguments besides the projection in the example of an error message."""


def _equirectangular(layout: Layout, size: _Size, hints: Hints) -> Placement:
    height, width = size
    is_border = hints.border_sampled
    if layout.registration is not None:
        is_border = layout.registration == REGISTRATIONS[1]
    if layout.fov is not None and (layout.fov < 360 or not is_panorama(height, width)):
        view = math.radians(layout.fov)
        part = layouts.crop(height, width, field_of_view=view, horizon=layout.horizon)
        return part, (f"the picture is a part of a panorama, {layout.fov:g} degrees wide",)
    if not is_panorama(height, width):
        eyes = ", eye='left' if it holds two eyes" if width in (height, 4 * height) else ""
        raise EnvLightsError(
            f"an equirectangular map is twice as wide as high; got {width}x{height} pixels; give"
            f" the degrees of azimuth that a part of one covers as fov={eyes}, or another layout="
        )
    if height < 2:
        raise EnvLightsError(f"a map needs at least 4x2 pixels; got {width}x{height}")
    whole = layouts.equirectangular(height, width, border_sampled=is_border)
    if width == 2 * height:
        return whole, ()
    note = (
        f"{width}x{height} pixels, which are nearly twice as wide as high, are read as the whole"
        " sphere"
    )
    return whole, (note,)


def _cylinder(layout: Layout, size: _Size, hints: Hints) -> Placement:
    horizon = hints.horizon if layout.horizon is None else layout.horizon
    degrees = hints.field_of_view if layout.fov is None else layout.fov
    if degrees is None:
        degrees = _value_of(layout, "fov", "the degrees of azimuth that it covers")
    made = layouts.cylinder(*size, field_of_view=math.radians(degrees), horizon=horizon)
    is_known = horizon is not None or hints.layout
    notes = [] if is_known else ["the horizon is taken to be the middle row (horizon=)"]
    if layout.fov is None:
        notes.insert(0, f"a cylindrical panorama of {degrees:.4g} degrees (GPano)")
    return made, tuple(notes)


def _cube(layout: Layout, size: _Size, hints: Hints) -> Placement:
    is_border = CONVENTIONS[layout.faces or "opengl"].border_sampled
    if layout.registration is not None:
        is_border = layout.registration == REGISTRATIONS[1]
    return layouts.cube(size[1], border_sampled=is_border), ()


def _octahedral(layout: Layout, size: _Size, hints: Hints) -> Placement:
    return layouts.octahedral(_square(layout, size), axes=_axes_of(layout)), ()


def _equal_area(layout: Layout, size: _Size, hints: Hints) -> Placement:
    return layouts.octahedral(_square(layout, size), equal_area=True, axes=_axes_of(layout)), ()


def _angular(layout: Layout, size: _Size, hints: Hints) -> Placement:
    return layouts.angular_map(_square(layout, size), axes=_axes_of(layout)), ()


def _mirror_ball(layout: Layout, size: _Size, hints: Hints) -> Placement:
    n = _square(layout, size) if layout.circle is None else min(size)
    made = layouts.mirror_ball(n, circle=layout.circle)  # type: ignore[arg-type]
    made = made._replace(height=size[0], width=size[1])
    front = (
        "a mirror ball as photographed: the camera, seen in its centre, becomes the front of the"
        " map (+z), and its right becomes +x"
    )
    if layout.distance is not None:
        reach = reach_of(layout.distance)
        blind = f"the ball hides {180 - math.degrees(reach):.3g} degrees around -z"
        return made._replace(reach=reach), (front, blind)
    afar = (
        "the camera of the mirror ball was taken to be far away: from a distance of n radii,"
        " directions 90 degrees beside the camera are 39 / n degrees off (distance=)"
    )
    return made, (front, afar)


def _fisheye(layout: Layout, size: _Size, hints: Hints) -> Placement:
    mapping = _value_of(layout, "mapping", " or ".join(map(repr, MAPPINGS)))
    view = math.radians(_value_of(layout, "fov", "the degrees across its circle"))
    circle: Any = layout.circle
    made = layouts.fisheye(size, mapping, view, circle=circle, axes=_axes_of(layout))
    return made, _note_on_front(layout)


def _planar(layout: Layout, size: _Size, hints: Hints) -> Placement:
    view = math.radians(_value_of(layout, "fov", "its horizontal field of view in degrees"))
    made = layouts.planar(*size, field_of_view=view, axes=_axes_of(layout))
    return made, _note_on_front(layout)


def _note_on_front(layout: Layout) -> tuple[str, ...]:
    """Note on a camera direction that neither the user nor the file states."""
    if layout.forward is not None or layout.axes is not None:
        return ()
    return ("the centre of the picture was taken for the front of the map, +z (forward=)",)


def _as_wide(width: int, _: Layout) -> int:
    return width


_FORWARD = {"forward": None}

#: Arguments of a `Layout`, formerly arguments of `EnvMap` and its methods.
ARGUMENTS = tuple(field.name for field in fields(Layout)[:-1])

#: Projections by name.
PROJECTIONS = {
    "equirectangular": Projection(
        "an equirectangular panorama or a part of one",
        _equirectangular,
        lambda width, _: width // 2,
        {},
        shape="panorama",
        example={"fov": 360},
    ),
    "cylinder": Projection(
        "a cylindrical panorama",
        _cylinder,
        # Use elevations of up to 45 degrees.
        lambda width, layout: max(round(2 * width / math.radians(layout.fov or 360)), 1),
        {"fov": 360},
        example={"fov": 360},
    ),
    "cube": Projection(
        "a cube map",
        _cube,
        lambda width, _: 6 * width,
        {"faces": "opengl", "registration": None},
        shape="cube",
        example={"faces": "opengl"},
    ),
    "octahedral": Projection(
        "an octahedral map", _octahedral, _as_wide, _FORWARD, shape="square", axes=layouts.UP
    ),
    "octahedral-equal-area": Projection(
        "an equal-area octahedral map, as of pbrt",
        _equal_area,
        _as_wide,
        _FORWARD,
        shape="square",
        axes=layouts.PBRT,
    ),
    "angular": Projection(
        "an angular map or light probe", _angular, _as_wide, _FORWARD, shape="disc"
    ),
    "mirror-ball": Projection(
        "a photograph of a mirror ball",
        _mirror_ball,
        _as_wide,
        {},
        shape="disc",
        axes=layouts.MIRRORED,
    ),
    "fisheye": Projection(
        "a fisheye picture",
        _fisheye,
        _as_wide,
        {"mapping": "equidistant", "fov": 180, **_FORWARD},
        shape="disc",
        example={"mapping": "equidistant", "fov": 180},
    ),
    "planar": Projection(
        "a photograph",
        _planar,
        lambda width, _: max(round(width / 1.5), 1),
        {"fov": None, **_FORWARD},
        example={"fov": 65},
    ),
}


def place(layout: Layout, size: tuple[int, int], hints: Hints = NO_HINTS) -> Placement:
    """Layout of a picture of a given size, and notes on assumptions."""
    return PROJECTIONS[layout.projection or ""].place(layout, size, hints)


def complete(layout: Layout) -> Layout:
    """Layout of a picture that `EnvMap.to` creates, with defaults filled in."""
    if layout.projection is None:
        raise EnvLightsError(f"layout must name a projection; got {layout!r}")
    defaults = PROJECTIONS[layout.projection].defaults
    given = layout.arguments()
    if others := [name for name in given if name not in defaults]:
        raise EnvLightsError(
            f"{', '.join(others)} is no argument of {PROJECTIONS[layout.projection].title} that"
            f" `EnvMap.to` makes; {_sentence_on(defaults)}"
        )
    if layout.faces is not None:
        check_choice("faces", layout.faces, tuple(CONVENTIONS))
    return replace(layout, **{**defaults, **given})


def candidates(names: Iterable[str]) -> str:
    """List of projections for a message, each with its argument."""
    each = [f"{PROJECTIONS[name].title} ({argument_for(_example(name))})" for name in names]
    return " or ".join([", ".join(each[:-1]), each[-1]] if len(each) > 1 else each)


def of_shape(*shapes: str) -> list[str]:
    """Names of the projections whose pictures have one of the shapes."""
    return [name for name, row in PROJECTIONS.items() if row.shape in shapes]


def _example(name: str) -> Layout:
    return Layout(name, **PROJECTIONS[name].example)


def _method(projection: str) -> str:
    return projection.replace("-", "_")


@cache
def parameters(projection: str) -> tuple[str, ...]:
    """Names of the arguments of a projection."""
    return tuple(inspect.signature(getattr(Layout, _method(projection))).parameters)


def _check_unused(projection: str, given: Iterable[str]) -> None:
    """Raise an error for arguments that a projection does not take."""
    allowed = parameters(projection)
    if others := [name for name in given if name not in allowed]:
        raise EnvLightsError(
            f"{', '.join(others)} is no argument of {PROJECTIONS[projection].title};"
            f" {_sentence_on(allowed)}; leave the others out"
        )


def _sentence_on(names: Iterable[str]) -> str:
    listed = ", ".join(names)
    return f"it takes {listed}" if listed else "it takes no arguments"


def _value_of(layout: Layout, name: str, meaning: str) -> Any:
    """Value of an argument; raises an error if it is missing."""
    if (value := getattr(layout, name)) is not None:
        return value
    projection = layout.projection or ""
    raise EnvLightsError(
        f"{PROJECTIONS[projection].title} needs {name}=, {meaning}; give it, as in"
        f" {argument_for(_example(projection))}"
    )


def _square(layout: Layout, size: _Size) -> int:
    """Side length of a square picture; raises an error for other shapes."""
    height, width = size
    if height != width:
        raise EnvLightsError(
            f"{PROJECTIONS[layout.projection or ''].title} is square; got {width}x{height} pixels;"
            " crop the picture, or give another layout="
        )
    return height


def _axes_of(layout: Layout) -> Axes:
    if layout.forward is not None:
        return layouts.looking(layout.forward)
    return layout.axes or PROJECTIONS[layout.projection or ""].axes  # type: ignore[return-value]


def _direction(forward: ArrayLike) -> tuple[float, ...]:
    """Direction as given; raises an error for other values."""
    layouts.looking(forward)
    direction: NDArray[np.float64] = reals("forward", forward, 1)
    return tuple(direction.tolist())


def _circle(values: ArrayLike) -> tuple[float, float, float]:
    """Centre and radius as numbers; raises an error for other values."""
    x, y, radius = (*reals("circle", values, 1), *(math.nan,) * 3)[:3]
    if np.shape(values) != (3,) or not (np.isfinite([x, y, radius]).all() and radius > 0):
        raise EnvLightsError(
            "circle must be centre x, centre y and a radius above 0, in pixels; got"
            f" {describe(values)}"
        )
    return amount("circle", float(x), -1e9), amount("circle", float(y), -1e9), float(radius)
