"""Pages in a browser: messages, requests, controls, pictures."""

# ruff: noqa: E501, scripts keep their lines
import numpy as np
import pytest

import envlights as el
from envlights._common.srgb import encode_srgb
from tests.conftest import real_maps
from tests.viewer.browser import needs_browser, overlapping_texts, run

pytestmark = needs_browser

#: Number of frames at full size, their mean code, and the title.
FRAME = """() => {
  const { canvas, scene } = envlights, { gl } = scene, pixels = new Uint8Array(4 * canvas.width * canvas.height);
  gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return [scene.frames, pixels.reduce((sum, x) => sum + x, 0) / pixels.length, document.title];
}"""
DRAWN = "envlights.scene.frames > 0"
#: Mean radiance of pictures with other options.
MEANS = """(options) => options.map((each) => {
  const pixels = envlights.render({ width: 64, height: 48, ...each });
  return [0, 1, 2].map((channel) => pixels.filter((_, k) => k % 4 === channel).reduce((sum, x) => sum + x, 0));
})"""


@pytest.fixture(scope="module")
def hall(tmp_path_factory):
    path = tmp_path_factory.mktemp("pages") / "hall.html"
    el.view(el.synthetic.hall(128).radiance, title="</script><b>&hall").save(path)
    return path


def test_a_page_draws_without_messages_and_requests(hall):
    answer = run(hall, FRAME, still=False, wait=DRAWN)
    frames, mean, title = answer["result"]
    assert frames >= 1
    assert 20 < mean < 235
    assert title == "</script><b>&hall"
    assert answer["messages"] == []
    assert answer["requests"] == [f"file://{hall}"]


@real_maps("hdr/*.hdr")
def test_a_page_of_a_real_map_draws(path, tmp_path):
    page = tmp_path / "page.html"
    el.view(path).save(page)
    answer = run(page, FRAME, still=False, wait=DRAWN)
    assert 5 < answer["result"][1] < 250
    assert (answer["messages"], answer["requests"]) == ([], [f"file://{page}"])


def test_a_browser_without_webgl_shows_a_sentence(hall):
    answer = run(hall, "() => document.querySelector('[role=alert]').textContent", webgl=False)
    assert "needs WebGL 2" in answer["result"]


def test_each_choice_changes_the_picture(hall):
    options = [
        {}, {"shadows": "paper"}, {"shadows": "none"}, {"shape": "points"}, {"count": 1}, {"off": [0]},
        {"ambient": "harmonics"}, {"shine": 1}, {"albedo": 0.2}, {"dome": 3}, {"cameraHeight": 4},
        {"box": [0, 0, 0.5, 0.5, 0.5, 0]}, {"azimuth": 1}, {"only": 1},
    ]  # fmt: skip
    means = np.array(run(hall, MEANS, options)["result"])
    assert np.isfinite(means).all()
    assert len(np.unique(means.round(6), axis=0)) == len(options)


def test_harmonics_come_with_a_sentence_about_the_ground(hall):
    script = """() => {
      const [note] = [...document.querySelectorAll(".note")].filter((each) => /over a floor/.test(each.textContent));
      const radio = document.querySelector("[aria-label='Ambient term'] input:not(:checked)"), before = note.hidden;
      radio.click();
      return [radio.value, before, note.hidden];
    }"""
    assert run(hall, script)["result"] == ["harmonics", True, False]


def test_a_rig_of_one_ambient_term_offers_no_other(tmp_path):
    page = tmp_path / "page.html"
    el.view(el.fit(el.synthetic.hall(64).radiance, lights=2, ambient="sh2")).save(page)
    script = (
        "() => [envlights.state.ambient, document.querySelector(\"[aria-label='Ambient term']\")]"
    )
    assert run(page, script)["result"] == ["harmonics", None]


@pytest.mark.parametrize("size", [(390, 844), (420, 800), (760, 600), (1100, 700)])
def test_texts_do_not_overlap(hall, size):
    pairs, count = overlapping_texts(hall, size=size)
    assert pairs == []
    assert count >= 30


def test_the_canvas_shows_the_srgb_codes_of_linear_radiance(hall):
    """Away from outlines, which frames average."""
    script = """() => {
      const { canvas, scene, state, data } = envlights, { gl } = scene, { width, height } = canvas;
      const codes = new Uint8Array(4 * width * height);
      state.probes = false;
      scene.preview(state, [width, height]);
      gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, codes);
      return [Array.from(codes), envlights.render({ width, height }), data.exposure * 2 ** state.exposure];
    }"""
    codes, radiance, exposure = run(hall, script)["result"]
    codes, radiance = (np.reshape(each, (-1, 4))[:, :3] for each in (codes, radiance))
    apart = np.abs(codes - 255 * encode_srgb(np.clip(exposure * radiance, 0, 1)))
    assert (apart < 1.5).mean() > 0.999
    assert 50 < codes.mean() < 220


def test_a_sky_of_one_radiance_is_drawn_with_that_radiance(tmp_path):
    """Within the codes of a lossy picture with two stops of headroom."""
    page = tmp_path / "page.html"
    radiance = [0.2, 0.3, 0.4]
    el.view(
        np.full((32, 64, 3), radiance),
        el.Rig(radiance, el.Lights([[0, 1, 0]], [[1, 1, 1]])[:0], 0.0),
    ).save(page)
    found = run(
        page, "() => envlights.render({ width: 8, height: 8, elevation: -0.5, look: [0, 9, 0] })"
    )
    found = np.reshape(found["result"], (-1, 4))[:, :3]
    np.testing.assert_allclose(found.mean(axis=0), radiance, rtol=0.05)


def test_overlays_are_never_darker_than_what_they_stand_for(hall):
    """A product of single ratios is too bright where shadows overlap."""
    script = (
        "(options) => options.map((each) => envlights.render({ width: 64, height: 48, ...each }))"
    )
    same = {"flatFloor": True, "shape": "points", "only": 2, "look": [0, 0, 0]}
    overlays, none = run(hall, script, [{**same, "shadows": name} for name in ("paper", "none")])[
        "result"
    ]
    assert (np.array(overlays) <= np.array(none) + 1e-6).all()


def test_controls_have_names_and_keys_turn_the_camera(hall):
    script = """() => {
      const inputs = [...document.querySelectorAll("input")];
      const named = inputs.filter((x) => x.getAttribute("aria-label") || x.closest("label")?.textContent.trim());
      const before = { ...envlights.state, ball: [...envlights.state.ball] }, { canvas, state } = envlights;
      const press = (key, more = {}) => canvas.dispatchEvent(new KeyboardEvent("keydown", { key, ...more }));
      press("ArrowLeft"); press("+"); press("ArrowUp", { shiftKey: true });
      return [inputs.length, named.length, canvas.tabIndex, canvas.getAttribute("role"), before.azimuth !== state.azimuth,
        state.distance < before.distance, Math.hypot(state.ball[0] - before.ball[0], state.ball[1] - before.ball[1])];
    }"""
    count, named, *rest = run(hall, script)["result"]
    assert count == named >= 20
    assert rest[:4] == [0, "img", True, True]
    assert rest[4] == pytest.approx(0.1)


def test_a_thing_is_moved_by_a_pointer_and_the_rest_turns_the_camera(hall):
    script = """() => {
      const { canvas, state } = envlights, box = canvas.getBoundingClientRect();
      canvas.setPointerCapture = () => {};
      const drag = (x, y) => {
        const before = JSON.stringify([state.ball, state.box, state.azimuth]);
        const send = (type, dx) => canvas.dispatchEvent(new PointerEvent(type, { pointerId: 1, clientX: x + dx, clientY: y }));
        send("pointerdown", 0); send("pointermove", 12); send("pointerup", 12);
        const [ball, cube, azimuth] = JSON.parse(before);
        return [ball[0] !== state.ball[0], cube[0] !== state.box[0], azimuth !== state.azimuth];
      };
      const at = (u, v) => [box.left + u * box.width, box.top + v * box.height];
      const hits = [];
      for (let u = 0.05; u < 1; u += 0.03) { const thing = envlights.pick({ clientX: at(u, 0.55)[0], clientY: at(u, 0.55)[1] }); if (thing) hits.push([thing.name, u]); }
      const first = (name) => hits.filter(([n]) => n === name).map(([, u]) => u), middle = (list) => list[list.length >> 1];
      return [drag(...at(middle(first("ball")), 0.55)), drag(...at(middle(first("box")), 0.55)), drag(...at(0.5, 0.03))];
    }"""
    assert run(hall, script, size=(900, 500))["result"] == [
        [True, False, False],
        [False, True, False],
        [False, False, True],
    ]


@pytest.mark.slow
def test_a_large_map_opens_within_two_seconds(tmp_path):
    rng = np.random.default_rng(0)
    world = el.EnvMap(el.synthetic.hall(256).radiance).resized(4096).radiance
    page = tmp_path / "page.html"
    made = el.view(world * rng.uniform(0.9, 1.1, world.shape).astype(np.float32))
    made.save(page)
    assert run(page, "() => 0")["opened"] < 2000
