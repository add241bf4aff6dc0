"""Lights that are changed in a page, and the files that it saves."""

# ruff: noqa: E501, scripts keep their lines
import json

import numpy as np
import pytest

import envlights as el
from envlights._common.srgb import decode_srgb
from tests.viewer.browser import needs_browser, run

pytestmark = needs_browser

LIGHTS = el.Lights(
    [[0.6, 0.64, 0.48], [-0.6, 0.8, 0], [0, 0.28, -0.96]],
    [[3, 2.8, 2.2], [0.5, 0.6, 0.9], [0.3, 0.2, 0.1]],
    [0.005, 0.5, 0],
)
RIGS = {
    "floor": el.Rig([0.3, 0.4, 0.5], LIGHTS, 0.1, notes=("filled",), floor=True),
    "constant": el.Rig([0.3, 0.4, 0.5], LIGHTS, 0.1),
    "harmonics": el.fit(el.synthetic.hall(64).radiance, lights=2, ambient="sh2"),
}
#: Parts of a page that scripts change: rows, handles, and events as a user makes them.
TOOLS = """
  const { root, state } = envlights, find = (what) => [...root.querySelectorAll(what)];
  const set = (input, value) => { input.value = value; input.dispatchEvent(new Event("input")); };
  const [switches, stops, tints, handles] = [".lamp [type=checkbox]", ".lamp [type=range]", ".lamp [type=color]", ".handle"].map(find);
  const handle = (k) => handles.find((each) => each.textContent === String(k + 1));
  const save = (name) => find(".files button").find((each) => each.textContent === name).click();
  const drag = (k, right, down) => {
    const box = root.querySelector(".sky").getBoundingClientRect(), held = handle(k);
    held.setPointerCapture = () => {};
    const send = (type, x, y) => held.dispatchEvent(new PointerEvent(type, { pointerId: 1, clientX: 40 + x * box.width, clientY: 90 + y * box.height }));
    send("pointerdown", 0, 0); send("pointermove", right / 2, 0); send("pointermove", right, down); send("pointerup", right, down);
  };"""


def page_of(folder, rig, **options):
    path = folder / "page.html"
    el.view(rig, **options).save(path)
    return path


def answer_of(page, script, folder, files=1, **options):
    """Answer of a script that saves files."""
    return run(page, f"() => {{{TOOLS}{script}}}", folder=str(folder), files=files, **options)


def assert_same(found, expected):
    """Compare rigs to 1e-6; the first is not measured."""
    for name in ("direction", "irradiance", "angular_radius"):
        pair = [getattr(each.lights, name) for each in (found, expected)]
        np.testing.assert_allclose(*pair, rtol=1e-6, atol=1e-6, err_msg=name)
    np.testing.assert_allclose(found.ambient, expected.ambient, rtol=1e-6, atol=1e-6)
    assert (found.error, found.report.stop_reason) == (None, el.rigs.StopReason.NOT_FITTED)
    assert (found.floor, found.notes, found.units) == (
        expected.floor,
        expected.notes,
        expected.units,
    )


@pytest.mark.parametrize("name", RIGS)
def test_a_light_that_is_dragged_dimmed_and_saved_is_that_of_python(name, tmp_path):
    rig = RIGS[name]
    page = page_of(tmp_path, rig)
    script = "drag(0, 0.25, 0); set(stops[0], -1); set(tints[1], '#ff8040'); save('Save lights');"
    answer = answer_of(page, script, tmp_path)
    assert answer["messages"] == []
    lights = rig.lights.moved(0, azimuth=rig.lights.azimuth[0] + np.pi / 2).dimmed(0, 0.5)
    # Half as bright, the first light of a rig may not be the first any more.
    other = lights.origin.index(1)
    lights = lights.coloured(other, decode_srgb(np.array([255, 128, 64]) / 255))
    found = el.Rig.load(tmp_path / "lights.json")
    assert_same(found, el.Rig(rig.ambient, lights, notes=rig.notes, floor=rig.floor))
    fields = json.loads((tmp_path / "lights.json").read_text())
    assert fields.keys() == found.to_dict().keys()
    assert fields["report"] == found.to_dict()["report"]


def test_a_light_that_is_off_is_not_in_the_files(tmp_path):
    page = page_of(tmp_path, RIGS["floor"])
    answer_of(page, "switches[1].click(); save('Save lights');", tmp_path)
    rig = RIGS["floor"]
    expected = el.Rig(rig.ambient, LIGHTS.without(1), notes=rig.notes, floor=True)
    assert_same(el.Rig.load(tmp_path / "lights.json"), expected)


def test_lights_of_a_split_keep_their_numbers_so_that_relight_finds_their_pixels(tmp_path):
    parts = el.split(el.synthetic.hall(128).radiance, lights=2)
    page = page_of(tmp_path, el.Rig([0, 0, 0], parts.lights))
    answer_of(page, "drag(1, 0.1, 0); switches[0].click(); save('Save lights');", tmp_path)
    lights = el.Rig.load(tmp_path / "lights.json").lights
    assert lights.origin == (1,)
    moved = parts.lights.moved(1, azimuth=parts.lights.azimuth[1] + 0.2 * np.pi).without(0)
    found, expected = (parts.with_lights(each).radiance for each in (lights, moved))
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("name", RIGS)
def test_the_saved_map_is_that_of_the_saved_rig(name, tmp_path):
    page = page_of(tmp_path, RIGS[name])
    script = "drag(0, -0.4, 0.1); switches[1].click(); save('Save map'); save('Save lights');"
    answer_of(page, script, tmp_path, files=2)
    rig, found = el.Rig.load(tmp_path / "lights.json"), el.EnvMap.open(tmp_path / "map.hdr")
    expected = rig.to_map(512)
    assert found.radiance.shape == expected.radiance.shape
    # A code of the file is half a step off, of 128 steps at least; pixels on rims differ more.
    off = (
        np.abs(found.radiance - expected.radiance)
        > expected.radiance.max(axis=2, keepdims=True) / 250
    )
    assert off.mean() < 2e-3
    normals = np.concatenate([np.eye(3), -np.eye(3), rig.lights.direction])
    np.testing.assert_allclose(found.probe(normals), expected.probe(normals), rtol=5e-3, atol=2e-3)


def test_a_drag_wraps_at_the_seam_and_ends_at_pole_and_horizon(tmp_path):
    script = """
      const { data } = envlights, lights = data.rigs["constant discs"][0].lights, ends = [];
      for (const [right, down] of [[0.75, 0], [0, -3], [0, 3]]) { drag(0, right, down); ends.push([...lights[0].direction]); }
      return ends;"""
    floor, free = (
        np.array(answer_of(page_of(tmp_path, RIGS[name]), script, tmp_path, 0)["result"])
        for name in ("floor", "constant")
    )
    x, y, z = LIGHTS.direction[0]
    for ends in (floor, free):
        np.testing.assert_allclose(ends[0], [z, y, -x], atol=1e-8)
        np.testing.assert_allclose(ends[1], [0, 1, 0], atol=1e-5)
        np.testing.assert_allclose(np.linalg.norm(ends, axis=1), 1, atol=1e-9)
    # The azimuth outlasts the pole.
    flat = np.hypot(x, z)
    np.testing.assert_allclose(floor[2], [z / flat, 0, -x / flat], atol=1e-8)
    np.testing.assert_allclose(free[2], [0, -1, 0], atol=1e-5)


def test_the_picture_follows_a_light_in_the_same_frame(tmp_path):
    page = page_of(tmp_path, RIGS["floor"])
    script = """
      drag(0, 0.25, 0.05); switches[2].click();
      envlights.due = envlights.changed = false;
      set(stops[1], 1.5);
      const rig = envlights.data.rigs["constant discs"][0], shown = envlights.render({ width: 64, height: 36 });
      const lights = rig.lights.map((each) => [...each.direction, ...each.irradiance, each.radius]);
      return [shown, lights, envlights.due && envlights.changed];"""
    shown, lights, due = answer_of(page, script, tmp_path, 0)["result"]
    expected = LIGHTS.moved(
        0, azimuth=LIGHTS.azimuth[0] + np.pi / 2, elevation=LIGHTS.elevation[0] - 0.05 * np.pi
    )
    expected = expected.dimmed(1, 2**1.5)
    np.testing.assert_allclose(
        lights,
        np.hstack([expected.direction, expected.irradiance, expected.angular_radius[:, None]])[
            [expected.origin.index(k) for k in range(3)]
        ],
        atol=1e-8,
    )
    rig = {"ambient": [[0.3, 0.4, 0.5]], "floor": True, "lights": lights[:2]}
    same = run(page, "(rig) => envlights.render({ width: 64, height: 36, rig })", rig)["result"]
    assert due
    assert shown == same


def test_no_control_makes_an_impossible_light_and_undo_gives_the_first_ones(tmp_path):
    dark = el.Lights([[0, 1, 0], [0, 0, 1]], [[1, 1, 1], [0, 0, 0]])
    page = page_of(tmp_path, el.Rig([0.1, 0.1, 0.1], dark, 0.1))
    script = """
      const lights = () => envlights.data.rigs["constant discs"][0].lights.map((each) => each.irradiance);
      const said = () => find(".note")[0].textContent, before = said();
      for (const k of [0, 1]) { set(stops[k], 99); set(tints[k], "#000000"); set(tints[k], "#00ff00"); }
      const changed = [lights(), said()];
      find(".files button").find((each) => each.textContent === "Undo").click();
      return [changed, lights(), [before, said()]];"""
    (changed, said), after, notes = answer_of(page, script, tmp_path, 0)["result"]
    green = dark.dimmed(0, 16).coloured(0, [0, 1, 0]).irradiance
    np.testing.assert_allclose(changed, green, atol=1e-9)
    assert (after, notes[0]) == (dark.irradiance.tolist(), notes[1])
    assert "10 %" in notes[0]
    assert "not measured" in said


def test_keys_turn_a_light_and_each_control_says_which_light_it_changes(tmp_path):
    page = page_of(tmp_path, RIGS["floor"])
    script = """
      for (const key of ["ArrowRight", "ArrowUp", "ArrowUp"]) handle(0).dispatchEvent(new KeyboardEvent("keydown", { key }));
      save("Save lights");
      return [switches, stops, tints, handles].map((each) => each.map((one) => one.ariaLabel));"""
    labels = answer_of(page, script, tmp_path)["result"]
    moved = LIGHTS.moved(
        0, azimuth=LIGHTS.azimuth[0] + np.deg2rad(2), elevation=LIGHTS.elevation[0] + np.deg2rad(4)
    )
    found = el.Rig.load(tmp_path / "lights.json").lights
    np.testing.assert_allclose(found.direction, moved.direction, atol=1e-8)
    for control in labels:
        assert len({label.lower().split("light ")[1][0] for label in control}) == 3
    azimuth, elevation = np.rad2deg([moved.azimuth[0], moved.elevation[0]]).round()
    assert f"azimuth {azimuth:.0f}°, elevation {elevation:.0f}°" in labels[3][-1]


def test_a_quarter_of_the_size_comes_first_and_a_mark_stays_until_a_frame_is_full(tmp_path):
    page = page_of(tmp_path, RIGS["floor"])
    script = """() => {
      const { scene, canvas, stage } = envlights, { preview } = scene, drawn = [], busy = [], seen = [];
      const mark = stage.querySelector(".refining");
      scene.preview = (s, size) => { drawn.push([s.shadows, size[0] / canvas.width, size[1] / canvas.height]); preview.call(scene, s, size); };
      scene.finished = (start, then) => then(5);
      mark.style.transition = "none";
      while (!scene.frames) { envlights.draw(); busy.push(canvas.ariaBusy); seen.push(getComputedStyle(mark).visibility); }
      return [drawn, busy, seen];
    }"""
    drawn, busy, seen = run(page, script, size=(320, 240))["result"]
    shadows, *sizes = drawn[0]
    assert shadows == "paper"
    np.testing.assert_allclose(sizes, 0.25, atol=0.01)
    assert [each[0] for each in drawn[1:]] == ["exact"]
    assert len(busy) >= 3
    assert busy == ["true"] * (len(busy) - 1) + ["false"]
    assert seen == ["visible" if each == "true" else "hidden" for each in busy]
