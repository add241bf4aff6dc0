"""Tools for agents: results of the functions, and files of the named folders alone."""

import asyncio
import json
import os

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
from envlights.cli.mcp import Tools, server

NAMES = ["open", "fit", "detect", "split", "relight", "compare", "view", "export"]


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "maps"
    folder.mkdir()
    el.EnvMap(el.synthetic.hall(64).radiance).save(folder / "hall.exr")
    (tmp_path / "secret.exr").write_bytes((folder / "hall.exr").read_bytes())
    (folder / "hall_{face}.exr").write_bytes((folder / "hall.exr").read_bytes())
    (folder / "link.exr").symlink_to(tmp_path / "secret.exr")
    (folder / "out").symlink_to(tmp_path)
    return folder


@pytest.fixture
def call(folder):
    """Call of a tool by a client in this process, as an agent does."""
    client = pytest.importorskip("mcp", reason="needs the extra mcp").Client

    async def run(tool, arguments):
        async with client(server([str(folder)])) as one:
            return await one.call_tool(tool, arguments)

    def answer(tool, **arguments):
        result = asyncio.run(run(tool, arguments))
        text = "".join(each.text for each in result.content)
        return text if result.is_error else json.loads(text)

    return answer


def test_tools_have_schemas_of_their_signatures(folder):
    client = pytest.importorskip("mcp", reason="needs the extra mcp").Client

    async def tools():
        async with client(server([str(folder)])) as one:
            return (await one.list_tools()).tools

    found = {tool.name: tool for tool in asyncio.run(tools())}
    assert sorted(found) == sorted(NAMES)
    schema = found["fit"].input_schema
    assert schema["required"] == ["map"]
    assert schema["properties"]["lights"] == {
        "anyOf": [{"type": "integer"}, {"type": "null"}],
        "default": None,
        "title": "Lights",
    }
    assert all(tool.description for tool in found.values())


def test_a_client_gets_the_numbers_of_the_functions(call, folder):
    env = el.EnvMap.open(folder / "hall.exr")
    assert call("open", map="hall.exr", reading={"lux": 900})["units"] == "cd/m2"
    rig = call("fit", map="hall.exr", lights=2, output="rig.json")
    assert rig["error"] == pytest.approx(el.fit(env, 2).error)
    assert el.Rig.load(folder / "rig.json") == el.fit(env, 2)
    assert len(call("fit", map="hall.exr")["lights"]["direction"]) == 4
    assert len(call("fit", map="hall.exr", lights=2, error=1e-4)["lights"]["direction"]) == 2
    found = call("detect", map="hall.exr", lights=1)
    np.testing.assert_allclose(found["direction"], el.detect(env, lights=1).direction)
    call("split", map="hall.exr", remainder="rest.exr")
    assert el.EnvMap.open(folder / "rest.exr").radiance == pytest.approx(
        el.split(env).remainder.radiance, rel=1e-5
    )
    call("relight", map="hall.exr", output="new.exr", edits=["gain 1=0"])
    assert call("compare", truth="hall.exr", guess="new.exr")["probe_error"] > 0.1
    assert call("compare", truth="hall.exr", guess="rig.json")["probe_error"] < 0.1
    call("export", rig="rig.json", output="rig.usda")
    call("view", map="hall.exr", output="page.html")
    assert {"rig.usda", "page.html", "new.exr"} <= {path.name for path in folder.iterdir()}


def test_a_client_reads_a_refusal_as_a_sentence(call):
    assert "is not below the folders" in call("open", map="../secret.exr")
    assert "whole number" in call("fit", map="hall.exr", lights=-1)
    refused = call("relight", map="hall.exr", output="new.exr", edits=["drop 1"])
    assert "an edit is one of move, turn, gain, tint, radius, remove, add" in refused


@pytest.mark.parametrize(
    "name",
    ["../secret.exr", "link.exr", "out/secret.exr", "/etc/passwd", "a\0b", "", ".", "-", "s3://a/b",
     "none.exr", "hall_{face}.exr"],
)  # fmt: skip
def test_files_outside_of_the_folders_are_not_read(name, folder):
    tools = Tools([str(folder)])
    with pytest.raises(el.EnvLightsError, match=r"not below the folders|no file in the folders"):
        tools.open(name)
    with pytest.raises(el.EnvLightsError, match=r"not below the folders|no file in the folders"):
        tools.open("hall.exr", {"colour": f"./{name}"})


@pytest.mark.parametrize("name", ["../new.exr", "out/new.exr", "/new.exr", "link.exr"])
def test_files_outside_of_the_folders_are_not_written(name, folder):
    tools, before = Tools([str(folder)]), (folder.parent / "secret.exr").read_bytes()
    with pytest.raises(el.EnvLightsError, match="not below the folders"):
        tools.relight("hall.exr", name, ["gain 1=0.5"])
    assert (folder.parent / "secret.exr").read_bytes() == before
    assert not (folder.parent / "new.exr").exists()


def test_an_input_is_not_overwritten_and_trusted_options_are_refused(folder):
    tools = Tools([str(folder)])
    with pytest.raises(el.EnvLightsError, match="it is the input"):
        tools.split("hall.exr", remainder="hall.exr")
    for reading in ({"any_format": True}, {"max_pixels": 10**12}):
        with pytest.raises(el.EnvLightsError, match="is not for agents"):
            tools.open("hall.exr", reading)
    assert tools.open(os.fspath(folder / "hall.exr"), {"layout": {"projection": "equirectangular"}})
    with pytest.raises(el.EnvLightsError, match="layout"):
        tools.open("hall.exr", {"layout": {"shape": "round"}})


def test_the_command_needs_a_folder_and_the_package(folder, monkeypatch):
    done = CliRunner().invoke(main, ["mcp", str(folder / "none")])
    assert done.exit_code == 2
    assert "none is no folder" in done.output
    monkeypatch.setitem(__import__("sys").modules, "mcp.server.mcpserver", None)
    done = CliRunner().invoke(main, ["mcp", str(folder)])
    assert done.exit_code == 2
    assert "envlights[mcp]" in done.output
