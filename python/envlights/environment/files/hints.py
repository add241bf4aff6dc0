"""Metadata of a file on the projection of its picture."""

from __future__ import annotations

from typing import NamedTuple

from envlights.environment.decoders.description import projection_of_layout


class Hints(NamedTuple):
    """Metadata of a file on the projection of its picture; all empty for an array."""

    name: str = ""
    """Printable name of the file."""

    kind: str = ""
    """Format, such as "openexr"; see `Header`."""

    environment: str = ""
    """Environment attribute of OpenEXR, DDS or a texture: "latlong", "cube", or empty."""

    cube_sides: str = ""
    """Sides of a DDS cube, in the order of the file: "+x -x +y -y +z -z"."""

    border_sampled: bool = False
    """True if the metadata puts the outer samples on the borders."""

    projection: str = ""
    """Projection of the GPano properties, in lower case."""

    field_of_view: float | None = None
    """Horizontal field of view of a GPano cylinder, in degrees; None if unknown."""

    horizon: float | None = None
    """Row of elevation 0 of a GPano cylinder; None if unknown."""

    stereo: str = ""
    """Stereo mode of the GSpherical properties, in lower case, such as "top-bottom"."""

    order: str = ""
    """Order of cube faces, from the names of six files; see `layouts.conventions`."""

    layout: str = ""
    """Layout text that `envlights` wrote; see `layouts.attribute`."""

    @property
    def names_other_projection(self) -> str:
        """Projection in the metadata if it is not equirectangular; otherwise empty."""
        stated = projection_of_layout(self.layout)
        if self.environment == "cube" or stated == "cube":
            return "cube map"
        named = stated or self.projection
        return "" if named in ("", "equirectangular") else named


#: Hints of a picture without metadata.
NO_HINTS = Hints()
