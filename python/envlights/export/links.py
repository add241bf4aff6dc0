"""Export of lights and the remaining map to several files that share one copy of the map."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from envlights._common.files import as_path, check_writable
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.environment.files.image_output import MAP_SUFFIXES
from envlights.export.files import AnyPath
from envlights.export.saving import check_options, save_for
from envlights.export.targets import PANORAMA, Target, target_of


class LinkedFile(NamedTuple):
    """File to write, with the map that it references."""

    path: Path
    """Path of the file."""

    target: Target | None
    """Target of the lights; None for a file of the map itself."""

    texture: Path | None = None
    """Map that is written with the file, in the format of its target."""

    link: str | None = None
    """Relative name of a map that another file provides."""

    crops: tuple[Path, ...] = ()
    """Textures of cards that are written with the file."""


def save_with_map(
    lights: Any, environment: EnvMap, paths: Iterable[AnyPath], **options: Any
) -> tuple[Path, ...]:
    """Write lights and the map around them; scenes name the map, which is written once.

    Parameters
    ----------
    lights : Rig, Lights or Cards
    environment : EnvMap
        Map around the lights.
    paths : iterable of path-like
        Scenes for the targets of their suffixes, and files of the map (.exr, .hdr).
    **options
        Further arguments of the writers that have them, as of `saving.save`.

    Returns
    -------
    tuple of Path
        All files; the map of a scene comes after the scene.

    Raises
    ------
    EnvLightsError
        If there is no path, a suffix is unknown, two of the files have the same path, or one cannot
        be written.
    """
    files = plan(environment, paths, lights)
    if not files:
        raise EnvLightsError("there is no path; give one or several, such as 'room.usda'")
    check_options((file.target for file in files if file.target), options)
    # Write map files first, so that no scene references a missing map.
    for file in sorted(files, key=lambda file: file.target is not None):
        if file.target is None:
            environment.save(file.path)
            continue
        around = environment if file.target.shows.environment else None
        link = {} if file.link is None else {"texture": file.link}
        own = {name: options[name] for name in options if name in file.target.options}
        save_for(file.target, lights, file.path, around, **link, **own)
    return tuple(paths_of(files))


class LinkedParts:
    """Lights (`lights`) and the remaining map (`remainder`), saved and displayed together."""

    __slots__ = ()

    lights: Any
    remainder: EnvMap

    def save(self, *paths: AnyPath, **options: Any) -> tuple[Path, ...]:
        """Write the lights and the remaining map, for one or several programs.

        A scene loads the remainder by a relative name. Blender, OpenUSD, Godot, Unity and Unreal
        name the file of the remainder among `paths`, or one that is written beside the first scene,
        ``sun.ambient.exr`` beside ``sun.usda``; glTF names it in its extras. Mitsuba, pbrt and
        Radiance get a map of their own form beside the scene; three.js has it in its file. MuJoCo,
        SAPIEN and Genesis take its mean radiance. JSON and CSV hold the lights alone.

        Parameters
        ----------
        *paths : path-like
            Scenes (`el.export.TARGETS` lists the suffixes), and files of the remainder (.exr,
            .hdr).
        **options
            Further arguments of the writers that have them: ``up="z"`` of OpenUSD.

        Returns
        -------
        tuple of Path
            All written files.

        Raises
        ------
        EnvLightsError
            If there is no path, a suffix is unknown, two files have the same path, or one cannot be
            written.

        Warns
        -----
        UserWarning
            If a target shows the lights with a larger error.

        Examples
        --------
        >>> import tempfile
        >>> import envlights as el
        >>> parts = el.split(el.synthetic.plain(0, 128).radiance)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     paths = Path(folder, "rest.exr"), Path(folder, "sun.py")
        ...     [path.name for path in parts.save(*paths)]
        ['rest.exr', 'sun.py']
        """
        return save_with_map(self.lights, self.remainder, paths, **options)

    def _repr_pretty_(self, printer: Any, _: bool) -> None:
        printer.text(repr(self) if printer.indentation else str(self))

    def _repr_html_(self) -> str:
        return f"{self.lights._repr_html_()}{self.remainder._repr_html_()}"


def plan(environment: EnvMap, paths: Iterable[AnyPath], lights: Any = None) -> list[LinkedFile]:
    """Files for `save_with_map`, all checked before any is written."""
    given = [as_path(path) for path in paths]
    panorama = _panorama(environment, given)
    files: list[LinkedFile] = []
    for path in given:
        is_whole = path.suffix.lower() in MAP_SUFFIXES or _shows_all(target_of(path), lights)
        file = _file_at(path, panorama if is_whole else None)
        file = file._replace(crops=_crops(file, lights))
        if panorama is None and is_whole and file.target and file.target.texture == PANORAMA:
            panorama = file.texture
        files.append(file)
    _check_paths(paths_of(files))
    return files


def _shows_all(target: Target, lights: Any) -> bool:
    """True if a program draws all lights; else its map also holds the surplus ones."""
    most = target.shows.lights
    return most is None or lights is None or len(getattr(lights, "lights", lights)) <= most


def paths_of(files: Iterable[LinkedFile]) -> Iterator[Path]:
    """Paths of all files and of their maps."""
    for file in files:
        yield file.path
        yield from file.crops
        if file.texture is not None:
            yield file.texture


def _crops(file: LinkedFile, lights: Any) -> tuple[Path, ...]:
    """Textures of the cards among lights."""
    if file.target is None or file.target.crop is None:
        return ()
    names = file.target.crop.names(f"{file.path.stem}.", getattr(lights, "outlined_shapes", ()))
    return tuple(file.path.with_name(name) for name in names if name)


def _panorama(environment: EnvMap, paths: list[Path]) -> Path | None:
    """Most accurate of the map files that programs can read directly (cell-centred)."""
    cells = MAP_SUFFIXES[environment.is_border_sampled :]
    found = [path for suffix in cells for path in paths if path.suffix.lower() == suffix]
    return found[0] if found else None


def _file_at(path: Path, panorama: Path | None) -> LinkedFile:
    """File that references `panorama` if its target can read it, otherwise with its own map."""
    if path.suffix.lower() in MAP_SUFFIXES:
        return LinkedFile(path, None)
    target = target_of(path)
    link = relative_name(panorama, path) if panorama and target.texture == PANORAMA else None
    if link is not None or not target.texture:
        return LinkedFile(path, target, link=link)
    return LinkedFile(path, target, texture=path.with_name(path.stem + target.texture))


def relative_name(file: Path, path: Path) -> str | None:
    """Name of `file` relative to a scene at `path`; None if there is none.

    Programs join the names of folders as text, which fails if a folder is a symbolic link. On
    Windows, no relative name leads to another drive.
    """
    try:
        name = Path(os.path.relpath(file, path.parent))
    except ValueError:
        return None
    return name.as_posix() if (path.parent / name).resolve() == file.resolve() else None


def _check_paths(paths: Iterable[Path]) -> None:
    """Raise an error for files that cannot be written, and for duplicate paths."""
    seen: set[Path] = set()
    for path in paths:
        target = check_writable(path)
        if target in seen:
            raise EnvLightsError(
                f"cannot write {path} twice: it is an output or the map of a scene, and another"
                " file has the same path; give another name"
            )
        seen.add(target)
