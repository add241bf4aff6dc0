"""Properties of an XMP packet (ISO 16684-1), by a parser that expands no entities."""

from __future__ import annotations

from collections.abc import Iterable
from xml.parsers import expat

#: Namespaces of the properties that are used, by their usual prefix.
_SPACES = {
    "http://ns.google.com/photos/1.0/panorama/": "GPano",
    "http://ns.google.com/videos/1.0/spherical/": "GSpherical",
    "http://ns.adobe.com/hdr-gain-map/1.0/": "hdrgm",
    "http://ns.apple.com/HDRGainMap/1.0/": "HDRGainMap",
}
#: Separator of namespace and name; no namespace contains it.
_BETWEEN = " "
#: First bytes of UTF-32 packets, which the parser would report as damaged.
_UTF_32 = (b"\xff\xfe\0\0", b"\0\0\xfe\xff", b"<\0\0\0", b"\0\0\0<")
#: Longest packet that is read, in bytes.
_LONGEST = 2**22


class UnknownEncodingError(ValueError):
    """Error for a packet in an encoding that the parser cannot read."""


def properties(packets: Iterable[bytes]) -> dict[str, str]:
    """Properties such as "GPano:ProjectionType" of all packets in a file; the first packet wins.

    Raises
    ------
    UnknownEncodingError
        For a packet whose encoding is unknown.
    """
    found: dict[str, str] = {}
    for packet in packets:
        found = _properties(packet) | found
    return found


def _properties(packet: bytes) -> dict[str, str]:
    """Properties of a packet, from attributes and from elements.

    A packet that is damaged, too long, or declares entities gives none.
    """
    if not packet or len(packet) > _LONGEST:
        return {}
    reader = _Reader()
    parser = expat.ParserCreate(namespace_separator=_BETWEEN)
    parser.buffer_text = True
    parser.StartElementHandler = reader.start
    parser.EndElementHandler = reader.end
    parser.CharacterDataHandler = reader.text
    parser.StartDoctypeDeclHandler = _refuse
    try:
        parser.Parse(packet.strip(b"\0"), True)
    except (expat.ExpatError, ValueError) as error:
        if "encoding" in str(error) or packet.startswith(_UTF_32):
            raise UnknownEncodingError(str(error)) from None
        return {}
    return reader.found


class _Reader:
    """Collection of the properties of known namespaces."""

    def __init__(self) -> None:
        self.found: dict[str, str] = {}
        self._name = ""

    def start(self, name: str, attributes: dict[str, str]) -> None:
        """Store the attributes, and begin to collect the text of an element."""
        self._name = _short(name)
        for attribute, value in attributes.items():
            if short := _short(attribute):
                self.found[short] = value.strip()

    def text(self, data: str) -> None:
        """Collect the text of an element."""
        if self._name:
            self.found[self._name] = self.found.get(self._name, "") + data.strip()

    def end(self, _: str) -> None:
        """Store the collected text of an element."""
        self._name = ""


def _short(name: str) -> str:
    """Name with the usual prefix; empty for other namespaces."""
    space, _, last = name.rpartition(_BETWEEN)
    return f"{_SPACES[space]}:{last}" if space in _SPACES else ""


def _refuse(*_: object) -> None:
    raise ValueError("an XMP packet declares no document type")
