"""Notes with codes, and the `logging` channel that reports them."""

from __future__ import annotations

import logging
from collections.abc import Iterable
from typing import Any, NamedTuple

from envlights._common.printable import printable

LOG = logging.getLogger("envlights")
LOG.addHandler(logging.NullHandler())

#: Code of a text that no code matches.
OTHER = "other"


class Code(NamedTuple):
    """Kind of notes."""

    phrases: tuple[str, ...]
    """Parts of the sentence; a note that contains one of them has this code."""

    meaning: str
    """Meaning, for the documentation."""

    is_warning: bool = False
    """True if results may be wrong; these notes are logged as warnings."""


#: Codes of notes; the first match counts.
CODES = {
    "black": Code((" is black everywhere",), "There is no light.", True),
    "sun-added": Code(("added as a disc: ", "as a light of its own: "), "A sun was added."),
    "sun-missing": Code(("no sun was added",), "No sun was added, and why.", True),
    "calibrated": Code(("calibrated to cd/m2", "(whiteLuminance)"), "Radiance is in cd/m2."),
    "codes": Code(
        ("decoded as 8-bit codes from sRGB", "but were taken for linear radiance"),
        "Floats that look like codes of 8 bits.",
        True,
    ),
    "colour-assumed": Code((" was assumed",), "The colour space is a guess.", True),
    "colour-ignored": Code(
        ("of the gAMA chunk was ignored", "the primaries of the file were ignored"),
        "A statement on colour was ignored because it is impossible.",
        True,
    ),
    "outside-rec709": Code(("of the pixels lay outside Rec.709",), "Colours were cut to Rec.709."),
    "decoded": Code(("samples were decoded from ",), "The transfer curve was removed."),
    "linear": Code(("integer samples were read as linear",), "Integers were taken as they are."),
    "primaries": Code(("colours were converted from ",), "Primaries were converted to Rec.709."),
    "raw": Code(("raw files were developed by LibRaw",), "A raw file was developed."),
    "gain-map": Code(("the file's gain map",), "A gain map was applied, or left out."),
    "grey": Code(("was read as grey",), "One channel became three."),
    "infinite": Code((" and counted as clipped",), "Infinite samples were replaced.", True),
    "nan": Code((" set to the mean of the neighbours",), "NaN was replaced.", True),
    "negative": Code((" set to 0",), "Negative samples became 0.", True),
    "clip-level": Code(
        ("the picture is clipped at code ", "which was taken for white"), "Clip level below 255."
    ),
    "eye": Code((" eye, was read",), "One of two eyes was read."),
    "part": Code(
        (
            "of several images in the file was read",
            "image of the animation was read",
            "by its tags the picture is a reduced copy",
        ),
        "One of several pictures in the file was read.",
    ),
    "layer": Code((" was read; others are ", "the only layer, "), "One of several layers."),
    "channels": Code(("other channels were ignored",), "Channels were ignored."),
    "data-window": Code((" was placed in the display window ",), "The border is black."),
    "orientation": Code(("rotated or mirrored by the orientation",), "The picture was turned."),
    "pose": Code(("the camera's pose was not applied",), "GPano states a turn.", True),
    "crop-ignored": Code(("its GPano crop contradicts",), "A crop was ignored.", True),
    "crop": Code(
        ("shows a part of the sphere (GPano)", "is a part of a panorama"), "A part of a panorama."
    ),
    "horizon": Code(("the horizon is taken to be the middle row",), "Horizon is a guess.", True),
    "shape": Code(("nearly twice as wide as high",), "Read as the whole sphere all the same."),
    "layout-doubt": Code(
        ("the picture may be no panorama", "was taken for the front of the map"),
        "Two lenses, two eyes, a part of a panorama, or a direction that nobody gave.",
        True,
    ),
    "layout": Code(
        ("pixels, converted to ", "the edges of the faces are equal, ", "faces in the order of "),
        "Layout of the picture, and its conversion.",
    ),
    "filled": Code(("of the sphere that is not seen ",), "The unseen part was filled."),
    "unseen": Code(("of the sphere is not seen",), "A part of the sphere is not seen.", True),
    "limited": Code(("limited to ",), "Large samples were limited."),
    "removed": Code(("of the flux removed", " removed from the map"), "Lights were removed."),
    "removed-part": Code(("so only the seen part was removed",), "A light was cut off.", True),
    "few-samples": Code(
        ("the flux of small lights are uncertain",), "Few samples lie on a light.", True
    ),
    "clipped-flux": Code(
        ("so the lights there are a lower bound",),
        "Clipping lost light; see `with_sun` and `repaired`.",
        True,
    ),
    "repaired": Code(
        (" for the clipped light: ", "nothing was added: no pixel is clipped"),
        "Light lost to clipping was estimated.",
    ),
    "depth-doubt": Code(
        (
            "the depth puts the floor ",
            "the depth shows no flat surfaces",
            "the depth is that of the walls ",
            ") lies behind a surface at ",
            "there is no depth, so surfaces are as from ",
        ),
        "A depth is missing, doubtful or has no lamps in it, or a point lies behind a surface.",
        True,
    ),
    "depth": Code(
        ("the depth was read as ", "the depth is unknown for "),
        "Reading of a depth, and its holes.",
    ),
    "parallax": Code(
        (" placed by the parallax of ", "without a partner or without parallax"),
        "Lights that several maps place.",
    ),
    "exposures": Code((" exposures were merged",), "Number and times of merged exposures."),
    "exposure-response": Code(("the response of the camera is not sRGB",), "Response used."),
    "exposure-time": Code(
        ("which its pixels show", "is a time wrong?", "to check their times"),
        "A time is wrong, or was not checked.",
        True,
    ),
    "exposure-moved": Code(("pixels onto the others",), "An exposure was aligned."),
    "exposure-contradiction": Code(
        ("exposures contradict each other", "differ in white balance"),
        "Something moved, or the white balance changed.",
        True,
    ),
}


class Note(str):
    """Note on an assumption or change: one line of text, with the `code` of its kind."""

    __slots__ = ()

    def __new__(cls, text: str = "") -> Note:
        """Make `text` printable, so that it cannot forge lines or control a terminal."""
        return super().__new__(cls, printable(text))

    @property
    def code(self) -> str:
        """Key of `CODES`; "other" if no code matches."""
        for code, kind in CODES.items():
            if any(phrase in self for phrase in kind.phrases):
                return code
        return OTHER


def black_note(light: Any, what: str = "map") -> tuple[str, ...]:
    """Note if the array `light` of a map is 0 everywhere; otherwise empty."""
    return () if light.any() else (f"the {what} is black everywhere, so there is no light to find",)


def warnings(notes: Iterable[str]) -> tuple[str, ...]:
    """Notes that warn of possibly wrong results."""
    kinds = ((note, CODES.get(Note(note).code)) for note in notes)
    return tuple(note for note, kind in kinds if kind and kind.is_warning)


def log(notes: Iterable[str]) -> None:
    """Log notes to the channel "envlights"; possibly wrong results as warnings."""
    for note in notes:
        kind = CODES.get(Note(note).code)
        LOG.log(logging.WARNING if kind and kind.is_warning else logging.INFO, "%s", note)
