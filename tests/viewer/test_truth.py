"""`el.view(truth=True)`: a path-traced picture of the start beside the page."""

import base64
import io
import sys

import numpy as np
import pytest

import envlights as el
from envlights._common.srgb import decode_srgb
from envlights.scene.mitsuba.path_traced import Still
from envlights.viewer import truth
from tests.cli.test_cli import run as command
from tests.viewer.browser import needs_browser, overlapping_texts, run

HALL = el.synthetic.hall(64).radiance
RIG = el.fit(HALL, lights=2, floor=True)


@pytest.fixture
def radiance(monkeypatch):
    """A made-up truth: a third of white at the left, twice white at the right, black below."""
    page = el.view(HALL, RIG)
    image = np.full((270, 480, 3), 1 / 3 / page.data["exposure"])
    image[:, 240:] *= 6
    image[135:] = 0
    monkeypatch.setattr(truth, "check_renderer", lambda: None)
    monkeypatch.setattr(el.viewer.page, "check_renderer", lambda: None)
    monkeypatch.setattr(truth, "true_view", lambda *_: Still(image * 1.01, image * 0.99))
    return image


def radiance_of(content):
    """Radiance of the truth in the data of a page."""
    from PIL import Image

    file = io.BytesIO(base64.b64decode(content["truth"]["picture"].split("base64,")[1]))
    codes = np.asarray(Image.open(file))
    return content["truth"]["headroom"] / content["exposure"] * decode_srgb(codes / 255)


def test_the_picture_is_linear_with_two_stops_of_headroom(radiance):
    content = el.view(HALL, RIG, truth=True).data
    stored, found = content["truth"], radiance_of(content)
    assert stored["headroom"] == 4
    np.testing.assert_allclose(found[:120, [0, -1]], radiance[:120, [0, -1]], rtol=0.02)
    assert stored["noise"] == pytest.approx(0.01)
    assert stored["start"].items() <= content["state"].items()


def test_only_a_page_with_a_truth_has_its_code(radiance):
    assert "presentTruth(scene" in el.view(HALL, RIG, truth=True).html
    assert "presentTruth(scene" not in el.view(HALL, RIG).html


def test_the_command_passes_the_flag(radiance, tmp_path):
    el.io.write_exr(tmp_path / "hall.exr", HALL)
    result = command("view", tmp_path / "hall.exr", "--truth", "-o", tmp_path / "page.html")
    assert result.exit_code == 0, result.output
    assert "200" in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_refusals(monkeypatch):
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    with pytest.raises(el.EnvLightsError, match=r"envlights\[bake\]"):
        el.view(HALL, RIG, truth=True)
    with pytest.raises(el.EnvLightsError, match="truth or model"):
        el.view(HALL, RIG, truth=True, model="none.glb")
    with pytest.raises(el.EnvLightsError, match="truth must be True or False"):
        el.view(HALL, RIG, truth="yes")


#: Codes left and right in the middle row after some steps, and whether the sentence is hidden.
SCRIPT = """() => {
  const { canvas, scene, state, split, root } = envlights, { gl } = scene, pixel = new Uint8Array(4);
  const slide = (value) => { split.value = value; split.dispatchEvent(new Event("input")); };
  return [
    () => {},
    () => slide(1),
    () => { state.exposure = -2; },
    () => { state.exposure = 0; state.ball[0] += 0.1; },
    () => { root.querySelector(".changed button").click(); slide(0.5); },
  ].map((change) => {
    change();
    envlights.changed = true;
    envlights.draw();
    return [0.06, 0.3, 0.7, 0.94].map((x) => {
      gl.readPixels(Math.round(x * canvas.width), Math.round(0.8 * canvas.height), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
      return pixel[0];
    }).concat(root.querySelector(".changed").hidden);
  });
}"""  # noqa: E501


@needs_browser
def test_the_split_shows_both_halves_until_something_changes(radiance, tmp_path):
    page = tmp_path / "page.html"
    el.view(HALL, RIG, truth=True).save(page)
    answer = run(page, SCRIPT, size=(680, 352))
    assert answer["messages"] == []
    first, whole, dim, moved, again = answer["result"]
    third, sixth = 156, 188  # sRGB codes of 1/3 and of 2/4
    assert first[:2] == pytest.approx([third, third], abs=2)
    assert first[2:4] == moved[2:4]
    assert whole[:4] == pytest.approx([third, third, 255, 255], abs=2)
    assert dim[2:4] == pytest.approx([sixth, sixth], abs=2)
    assert [each[4] for each in answer["result"]] == [True, True, True, False, True]
    assert again == first


@needs_browser
def test_captions_of_a_narrow_page_with_a_truth_do_not_overlap(radiance, tmp_path):
    page = tmp_path / "page.html"
    el.view(HALL, RIG, truth=True).save(page)
    pairs, count = overlapping_texts(page, size=(420, 800))
    assert pairs == []
    assert count >= 30


@needs_browser
def test_the_start_is_that_of_a_page_without_a_truth(tmp_path):
    page = tmp_path / "page.html"
    shown = el.view(HALL, RIG)
    shown.save(page)
    start = truth.start_of(shown.data["state"]["azimuth"])
    state = run(page, "() => envlights.state")["result"]
    for name, value in start.items():
        np.testing.assert_allclose(state[name], value, atol=1e-9, err_msg=name)


@pytest.mark.slow
@needs_browser
def test_page_and_truth_agree(monkeypatch, tmp_path):
    pytest.importorskip("mitsuba")
    monkeypatch.setattr(truth, "_PATHS", 32)
    page = tmp_path / "page.html"
    hall = el.synthetic.hall(256).radiance
    shown = el.view(hall, el.fit(hall, 8, floor=True), truth=True)
    shown.save(page)
    drawn = run(page, "() => envlights.render({ width: 480, height: 270, count: 8 })")["result"]
    # The rows of the page go up. Means of 10x10 pixels have little noise. The largest error, of the
    # model of reflected light, is on the side of the ball that the box lights.
    drawn = np.reshape(drawn, (270, 480, 4))[::-1, :, :3]
    ours, true = (
        image.reshape(27, 10, 48, 10, 3).mean(axis=(1, 3))
        for image in (drawn, radiance_of(shown.data))
    )
    assert np.linalg.norm(ours - true) < 0.05 * np.linalg.norm(true)
    assert np.median(np.abs(ours - true) / true) < 0.03
