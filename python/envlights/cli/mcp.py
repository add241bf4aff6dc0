"""`envlights mcp`: tools for agents, by the Model Context Protocol."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import click

from envlights._common.printable import printable
from envlights._native import EnvLightsError
from envlights.cli.options.outputs import check_source
from envlights.cli.relight import EDITS, apply_edits
from envlights.comparison.compare import compare
from envlights.detection.detect import detect
from envlights.detection.lights_file import SUFFIXES, load_lights
from envlights.environment.envmap import EnvMap
from envlights.environment.layouts.projections import Layout
from envlights.environment.reading import as_envmap
from envlights.export.saving import save
from envlights.fitting.fit import fit
from envlights.splitting.split import split
from envlights.viewer.page import view

#: Reading options that only a user may set.
_TRUSTED = ("any_format", "max_pixels")
Count = int | None
Number = float | None
File = str | None
Reading = dict[str, Any] | None
Answer = dict[str, Any]
#: End of the description of each tool with an argument `reading`.
_READING = (
    " `reading` has arguments of EnvMap.open, levelled, calibrated and rotated, such as"
    ' {"colour": "linear", "lux": 900, "layout": {"projection": "cube", "faces": "opengl"}}.'
)


class Tools:
    """Tools that access files in the given folders only."""

    def __init__(self, folders: Sequence[str]) -> None:
        for folder in folders:
            if not os.path.isdir(folder):  # noqa: PTH112, which refuses bytes in names
                raise EnvLightsError(f"{folder} is no folder; give folders of maps")
        self.folders = [Path(os.path.realpath(folder)) for folder in folders]

    def open(self, map: str, reading: Reading = None) -> Answer:
        """Size, layout, units, clip level and notes of an environment map."""
        env = self._read(map, reading)
        names = ("width", "height", "units", "clip_level", "coverage_fraction")
        facts = {name: getattr(env, name) for name in names}
        return {**facts, "layout": env.source.projection, "notes": list(env.notes)}

    def fit(
        self, map: str, lights: Count = None, error: Number = None, ambient: str = "constant",
        output: File = None, reading: Reading = None,
    ) -> Answer:  # fmt: skip
        """Fit an ambient term and at most this many lights (4 without an error); write a rig."""
        most = 4 if lights is None and error is None else lights
        rig = fit(self._read(map, reading), most, error=error, ambient=ambient)
        return self._answer(rig, output, map)

    def detect(
        self, map: str, lights: Count = None, output: File = None, reading: Reading = None
    ) -> Answer:
        """Find the lights of a map, the brightest first."""
        return self._answer(detect(self._read(map, reading), lights=lights), output, map)

    def split(
        self, map: str, lights: Count = None, output: File = None, remainder: File = None,
        reading: Reading = None,
    ) -> Answer:  # fmt: skip
        """Remove lights from a map; write them, and the remaining map (.exr, .hdr)."""
        parts = split(self._read(map, reading), lights)
        if remainder is not None:
            parts.remainder.save(self._output(remainder, map))
        return self._answer(parts.lights, output, map)

    def relight(self, map: str, output: str, edits: list[str], reading: Reading = None) -> Answer:
        """Change the lights of a map and write the new map (.exr, .hdr).

        Edits, with the numbers of `split` from 1, in degrees: "move 1=azimuth,elevation", "turn
        1=0,-20" by a difference, "gain 2=0.5", "tint 1=1,0.8,0.6" or "tint 1=2500K", "radius
        1=0.27", "remove 3", "add azimuth,elevation,irradiance".
        """
        each: dict[str, list[str]] = {name: [] for name in EDITS}
        for edit in edits:
            name, _, text = edit.partition(" ")
            if name not in each:
                raise EnvLightsError(f"an edit is one of {', '.join(EDITS)}; got {edit}")
            each[name].append(text)
        parts = split(self._read(map, reading))
        lights = apply_edits(parts.lights, each)
        parts.with_lights(lights).save(self._output(output, map))
        return {**lights.to_dict(), "written": output}

    def compare(self, truth: str, guess: str, reading: Reading = None) -> Answer:
        """Compare the lighting of two maps, rigs or files of lights."""
        return compare(*(self._lighting(each, reading) for each in (truth, guess))).to_dict()

    def view(self, map: str, output: str, lights: int = 4, reading: Reading = None) -> Answer:
        """Write a page (.html) that shows things in a map, lit by a few lights."""
        env = self._read(map, reading)
        view(env, fit(env, lights), title=Path(map).stem).save(self._output(output, map))
        return {"written": output}

    def export(self, rig: str, output: str) -> Answer:
        """Write a rig or lights (.json, .csv) for the program of the suffix, such as .usda."""
        save(load_lights(self._input(rig)), self._output(output, rig))
        return {"written": output}

    def _place(self, name: str) -> Path:
        """Path inside one of the folders, with links resolved; raises an error for other paths."""
        # `realpath` rejects zero bytes, which no file name contains.
        path = Path(os.path.realpath(self.folders[0] / name)) if "\0" not in name else Path()
        if not any(path.is_relative_to(folder) for folder in self.folders):
            raise EnvLightsError(f"{name} is not below the folders of this server; give another")
        return path

    def _input(self, name: str) -> str:
        path = self._place(name)
        if not path.is_file() or "{" in path.name:
            raise EnvLightsError(f"{name} is no file in the folders of this server")
        return str(path)

    def _output(self, name: str, source: str) -> str:
        path = str(self._place(name))
        check_source(path, {"the input": self._input(source)})
        return path

    def _read(self, name: str, reading: Reading) -> EnvMap:
        options = dict(reading or {})
        if trusted := [each for each in _TRUSTED if each in options]:
            raise EnvLightsError(f"{trusted[0]} is not for agents; leave it out")
        if isinstance(options.get("layout"), dict):
            try:
                options["layout"] = Layout(**options["layout"])
            except TypeError as error:
                raise EnvLightsError(f"layout: {error}") from None
        if set(str(options.get("colour", ""))) & set("./\\"):  # path of an ICC profile
            options["colour"] = self._input(str(options["colour"]))
        return as_envmap(self._input(name), options)

    def _lighting(self, name: str, reading: Reading) -> Any:
        is_lights = name.lower().endswith(SUFFIXES)
        return load_lights(self._input(name)) if is_lights else self._read(name, reading)

    def _answer(self, result: Any, output: File, source: str) -> Answer:
        """Numbers of a result, after it is written."""
        if output is None:
            return dict(result.to_dict())
        result.save(self._output(output, source))
        return {**result.to_dict(), "written": output}


def server(folders: Sequence[str]) -> Any:
    """Server of the tools; needs the extra `mcp`."""
    tools = Tools(folders)
    try:
        package = import_module("mcp.server.mcpserver")
        failure = import_module("mcp.server.mcpserver.exceptions").ToolError
    except ImportError:
        raise EnvLightsError(
            "the server needs the package mcp, version 2: pip install 'envlights[mcp]'"
        ) from None
    made = package.MCPServer("envlights")
    for name in ("open", "fit", "detect", "split", "relight", "compare", "view", "export"):
        tool = getattr(tools, name)
        text = f"{tool.__doc__}{_READING if 'reading' in tool.__annotations__ else ''}"
        made.add_tool(_with_refusals(tool, failure), description=text)
    return made


def _with_refusals(tool: Callable[..., Any], failure: type[Exception]) -> Callable[..., Any]:
    """Tool whose errors reach an agent as sentences."""

    @functools.wraps(tool)
    def call(*arguments: Any, **options: Any) -> Any:
        try:
            return tool(*arguments, **options)
        except EnvLightsError as refusal:
            raise failure(printable(str(refusal))) from None

    return call


@click.command("mcp")
@click.argument("folders", metavar="FOLDER...", nargs=-1, required=True)
def command(folders: Sequence[str]) -> None:
    """Serve tools for agents on the files below each FOLDER, over the standard streams."""
    server(folders).run()
