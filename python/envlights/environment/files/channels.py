"""Choice of the part and channels of a picture: by the caller, or the beauty layer by its name."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from envlights._common.errors import FileError
from envlights._native import EnvLightsError
from envlights.environment.decoders.raw_image import Part

#: Colour component by channel name, in lower case, without the layer name.
_COMPONENTS = {"r": 0, "red": 0, "g": 1, "green": 1, "b": 2, "blue": 2, "a": 3, "alpha": 3}

#: Priority of layer names for the finished picture: Houdini and Katana, Nuke, Arnold, Blender.
_BEAUTY = {"": 0, "c": 1, "ci": 1, "rgba": 2, "rgb": 2, "beauty": 3, "combined": 5}
#: Suffix of Blender's composited picture, and its priority over single layers.
_COMPOSITED, _COMPOSITE_RANK = "composite", 4
#: Priority of all other names.
_OTHER = 9

#: Names of layers that hold no light.
_NEVER = frozenset({
    "n", "nn", "ng", "ns", "normal", "normals", "albedo", "z", "depth", "zdepth", "p", "pos",
    "position", "pref", "pworld", "uv", "uvs", "st", "vector", "vectors", "velocity", "motion",
    "motionvector", "mv", "id", "objectid", "cryptomatte", "crypto", "mist", "mask", "matte",
    "diffcol", "glosscol", "transcol", "basecolor",
})  # fmt: skip
#: Priority of stereo views: the first is read, or the left one.
_VIEWS = {"left": 0, "right": 2}
#: Largest number of names in a message.
_MOST_NAMES = 8

_WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")


@dataclass(frozen=True)
class Choice:
    """Part and channels of a picture."""

    part: int
    """Index of the part, from 0."""

    colours: tuple[str, ...]
    """Red, green and blue, or a single grey channel."""

    alpha: str = ""
    """Alpha channel; empty if there is none."""

    notes: tuple[str, ...] = ()
    """Notes on the choice and on ignored channels."""


@dataclass(frozen=True)
class _Layer:
    """Red, green and blue channels with a common name in one part."""

    part: int
    name: str
    view: str
    colours: tuple[str, str, str]
    alpha: str

    @property
    def rank(self) -> int | None:
        """Priority of the layer's name; None for a layer that holds no light."""
        last = self.name.rpartition(".")[2]
        words = {word.lower() for word in _WORD.findall(last)} | {last.lower()}
        if words & _NEVER:
            return None
        if last.lower() == "combined" and self.name.lower().startswith(_COMPOSITED):
            return _COMPOSITE_RANK
        return _BEAUTY.get(last.lower(), _OTHER)

    def in_words(self) -> str:
        """Name of the layer for a message."""
        name = ".".join(filter(None, [self.name, self.view]))
        return name or "without a name"


def choose(
    name: str,
    parts: Sequence[Part],
    part: str | int | None = None,
    channels: str | Sequence[str] | None = None,
) -> Choice:
    """Channels to read as the picture.

    Parameters
    ----------
    name : str
        Name of the file, for refusals.
    parts : sequence of Part
        All images of the file.
    part : str or int, optional
        Name of a part or a layer, or number of a part, from 0.
    channels : str or sequence of str, optional
        Names of red, green and blue, or of a grey channel, then perhaps alpha; text is cut at
        commas.

    Raises
    ------
    EnvLightsError
        If there is no such part, or several could be the picture.
    """
    layers = list(_layers(parts))
    if part is not None:
        layers, wanted = _of_part(name, parts, layers, part)
    else:
        wanted = list(range(len(parts)))
    if channels is not None:
        return _by_hand(name, parts, wanted, channels)
    layer = _best(name, layers, is_named=part is not None)
    if layer is None:
        return _grey(name, parts, wanted)
    notes = (*_layer_notes(layer, layers, parts), *_channel_notes(layer, layers, parts))
    return Choice(layer.part, layer.colours, layer.alpha, notes if part is None else ())


def _layers(parts: Sequence[Part]) -> Iterator[_Layer]:
    """All layers with red, green and blue, in file order."""
    for number, part in enumerate(parts):
        groups: dict[str, dict[int, str]] = {}
        for channel in part.channels:
            prefix, _, last = channel.rpartition(".")
            if (component := _COMPONENTS.get(last.lower())) is not None:
                groups.setdefault(prefix, {}).setdefault(component, channel)
        for prefix, found in groups.items():
            if {0, 1, 2} <= set(found):
                name, view = _name_and_view(prefix or (part.name if len(parts) > 1 else ""))
                colours = (found[0], found[1], found[2])
                yield _Layer(number, name, part.view or view, colours, found.get(3, ""))


def _name_and_view(name: str) -> tuple[str, str]:
    """Name without its stereo view, and the view."""
    words = name.split(".")
    views = [word for word in words if word.lower() in _VIEWS]
    return ".".join(word for word in words if word not in views), views[0] if views else ""


def _of_part(
    name: str, parts: Sequence[Part], layers: list[_Layer], part: str | int
) -> tuple[list[_Layer], list[int]]:
    """Layers and indices of the parts that match `part`."""
    said = str(part).lower()
    number = int(said) if said.isdecimal() else -1
    wanted = [place for place, one in enumerate(parts) if one.name.lower() == said]
    if not wanted and 0 <= number < len(parts):
        wanted = [number]
    if wanted:
        return [layer for layer in layers if layer.part in wanted], wanted
    found = [one for one in layers if said in (one.name.lower(), one.in_words().lower())]
    if not found:
        found = [one for one in layers if one.name.lower().rpartition(".")[2] == said]
    if not found:
        raise EnvLightsError(
            f"cannot read {name}: there is no part {part!r}; it has {_in_words(parts, layers)}"
        )
    return found, [layer.part for layer in found]


def _best(name: str, layers: list[_Layer], *, is_named: bool) -> _Layer | None:
    """Layer to read as the picture; None if there is no layer."""
    if is_named and len(layers) == 1:
        return layers[0]
    ranks = {layer: layer.rank for layer in layers}
    lights = {layer: rank for layer, rank in ranks.items() if rank is not None}
    if layers and not lights:
        raise EnvLightsError(
            f"cannot read {name}: none of its layers is a picture by its name: {_names(layers)};"
            " choose one with part=, or channels="
        )
    best = [layer for layer, rank in lights.items() if rank == min(lights.values())]
    best.sort(key=lambda layer: _VIEWS.get(layer.view.lower(), 0 if not layer.view else 1))
    others = [layer for layer in best if layer.view == best[0].view or not layer.view]
    is_unnamed = bool(best) and not best[0].name
    if len(others) > 1 and not is_unnamed:
        raise EnvLightsError(
            f"cannot read {name}: several of its layers may be the picture: {_names(others)};"
            " choose one with part="
        )
    return best[0] if best else None


def _by_hand(
    name: str, parts: Sequence[Part], wanted: list[int], channels: str | Sequence[str]
) -> Choice:
    """Channels that the caller named."""
    names = _channel_names(channels)
    colours = names[: 3 if len(names) > 2 else 1]
    alpha = names[len(colours)] if len(names) > len(colours) else ""
    for place in wanted:
        if set(names) <= set(parts[place].channels):
            return Choice(place, tuple(colours), alpha)
    known = [channel for place in wanted for channel in parts[place].channels]
    raise EnvLightsError(
        f"cannot read {name}: it has not all of the channels {', '.join(names)};"
        f" it has {_some(known)}"
    )


def _channel_names(channels: str | Iterable[str]) -> list[str]:
    """One to four channel names; raises an error for other values."""
    try:
        names = channels.split(",") if isinstance(channels, str) else list(channels)
    except TypeError:
        raise EnvLightsError(
            f"channels must be the names of channels; got {type(channels).__name__}"
        ) from None
    if len(names) not in (1, 2, 3, 4) or not all(isinstance(one, str) for one in names):
        raise EnvLightsError(
            "channels must be the names of red, green and blue, or of a grey channel, then perhaps"
            f" alpha; got {_some(map(repr, names)) or 'none'}"
        )
    return [one.strip() for one in names]


def _grey(name: str, parts: Sequence[Part], wanted: list[int]) -> Choice:
    """The only channel of a part besides alpha and depth, read as grey."""
    for place in wanted:
        names = parts[place].channels
        if {"RY", "BY"} <= {channel.rpartition(".")[2] for channel in names}:
            raise FileError(
                f"cannot read {name}: it holds luminance and chroma (Y, RY, BY), which are not"
                " converted; give R, G and B"
            )
        colours = [one for one in names if one not in {"A", "a", "Z", "z"} and one != "Alpha"]
        if len(colours) == 1:
            note = f"the only channel, {colours[0]}, was read as grey"
            alpha = next((one for one in names if one in {"A", "a", "Alpha"}), "")
            others = [one for one in names if one not in {colours[0], alpha}]
            return Choice(place, (colours[0],), alpha, (note, *_note_on(others)))
    names = parts[wanted[0]].channels
    raise EnvLightsError(
        f"{name} has the channels {_some(names)}; it needs R, G and B, or a single channel"
    )


def _layer_notes(layer: _Layer, layers: list[_Layer], parts: Sequence[Part]) -> list[str]:
    """Notes on ignored parts, views and layers."""
    others = [one for one in layers if one != layer]
    views = [one for one in others if one.name == layer.name and one.view != layer.view]
    notes = []
    if views:
        read = layer.view or "without a name"
        notes.append(f"the view {read} was read; others are {_some(one.view for one in views)}")
    named = [one for one in others if one not in views and one.name]
    if layer.name and not named and len(layers) == 1 and layer.rank == _OTHER:
        notes.append(f"the only layer, {layer.name}, was read")
    elif named:
        notes.append(f"the layer {layer.in_words()} was read; others are {_names(named)}")
    elif len(parts) > 1 and not views:
        place = "the first" if layer.part == 0 else f"number {layer.part}, from 0,"
        notes.append(f"only {place} of several images in the file was read")
    return notes


def _channel_notes(layer: _Layer, layers: list[_Layer], parts: Sequence[Part]) -> list[str]:
    """Notes on channels of the part that belong to no layer."""
    known = {channel for one in layers for channel in (*one.colours, one.alpha)}
    return _note_on([one for one in parts[layer.part].channels if one not in known])


def _note_on(channels: list[str]) -> list[str]:
    return [f"other channels were ignored: {_some(channels)}"] if channels else []


def _names(layers: Sequence[_Layer]) -> str:
    return _some(layer.in_words() for layer in layers)


def _in_words(parts: Sequence[Part], layers: list[_Layer]) -> str:
    """List of parts and layers to choose from, for a message."""
    names = [part.name or str(place) for place, part in enumerate(parts)]
    return _some(dict.fromkeys([*names, *(layer.in_words() for layer in layers)]))


def _some(names: Iterable[str]) -> str:
    """First names of a list, and the number of omitted names."""
    known = list(names)
    more = f" and {len(known) - _MOST_NAMES} more" if len(known) > _MOST_NAMES else ""
    return ", ".join(known[:_MOST_NAMES]) + more
