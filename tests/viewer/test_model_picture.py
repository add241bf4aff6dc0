"""Pictures of a model, against the closed forms of the page and rays to every triangle."""

import numpy as np
import pytest

import envlights as el
from tests.viewer import things
from tests.viewer.browser import needs_browser, run
from tests.viewer.test_model import cube

pytestmark = needs_browser

WIDTH, HEIGHT, FRAMES = 96, 60, 16
#: Box of the page: place, half sides and turn; a cube as a model is in the same place.
BOX = [0.3, -0.2, 0.4, 0.4, 0.4, 25]
STATE = {
    "box": BOX,
    "model": [BOX[0], BOX[1], BOX[5]],
    "ball": [-0.6, 0.1, 0.5],
    "flatFloor": True,
    "albedo": 0,
    "elevation": 0.6,
    "look": [0, 0.3, 0],
    "distance": 3.2,
}
#: Mean over the frames of a picture with the model, and one picture of the closed form.
COMPARE = """async ({ state, frames, size: [width, height], withModel, without }) => {
  const { scene } = envlights, s = { ...envlights.state, ...state }, { model } = scene.data;
  const sum = new Float64Array(4 * width * height);
  scene.data.floor = [1, 1, 1];
  for (let frame = 0; frame < frames; frame++) {
    const pixels = scene.read({ ...s, only: withModel }, 0, width, height, { frame });
    pixels.forEach((x, k) => { sum[k] += x / frames; });
  }
  scene.data.model = null;
  return [[...sum], [...scene.read({ ...s, only: without }, 0, width, height)]];
}"""
#: Radiance of a model of albedo 1 under ambient light alone, without what hides or reflects it.
SHADE = """({ state, size }) => [envlights.state, [...envlights.scene.read(
  { ...envlights.state, ...state, off: [0, 1], shadows: "none" }, 0, ...size)]]"""


def rig():
    lights = el.Lights([[0.48, 0.8, 0.36], [-0.8, 0.6, 0]], [[2, 1.5, 1], [0.5, 1, 2]], [0.1, 0.5])
    return el.Rig([0.3, 0.4, 0.5], lights, 0.0, floor=True)


def page_of(path, model):
    el.view(rig(), model=model).save(path)
    return path


@pytest.mark.parametrize(("with_model", "without"), [(3, 2), (1, 0)], ids=["alone", "and a ball"])
def test_a_cube_hides_as_much_as_the_box_of_the_page(tmp_path, with_model, without):
    """The mean over the frames is that of the closed form: noise alone differs."""
    page = page_of(tmp_path / "page.html", el.viewer.Model(*cube(side=0.8), [0, 0, 0]))
    job = {"state": STATE, "frames": FRAMES, "size": [WIDTH, HEIGHT]}
    job |= {"withModel": with_model, "without": without}
    answer = run(page, COMPARE, job)
    assert answer["messages"] == []
    seen, wanted = (np.reshape(x, (-1, 4))[:, :3] for x in answer["result"])
    assert np.isfinite(seen).all()
    # Things are black here; their outlines are the same to the pixel.
    assert ((seen == 0).all(axis=1) == (wanted == 0).all(axis=1)).all()
    lit = (wanted > 0).all(axis=1)
    error = (seen - wanted)[lit] / wanted[lit].mean()
    assert abs(error.mean()) < 5e-4
    assert np.sqrt((error**2).mean()) < 0.04


def nearest(corners, eye, towards):
    """Length of each ray to the nearest of all triangles, and the normal there (Moeller 1997)."""
    a, one, two = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    best, normals = np.full(len(towards), np.inf), np.zeros((len(towards), 3))
    with np.errstate(divide="ignore", invalid="ignore"):
        for k in range(len(corners)):
            p, q = np.cross(towards, two[k]), np.cross(eye - a[k], one[k])
            det = p @ one[k]
            u, v, t = p @ (eye - a[k]) / det, towards @ q / det, two[k] @ q / det
            closer = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < best)
            normal = np.cross(one[k], two[k])
            best[closer], normals[closer] = t[closer], normal / np.linalg.norm(normal)
    side = np.sign(np.einsum("ij,ij->i", normals, towards))
    return best, -side[:, None] * normals


def test_rays_of_the_shader_meet_the_same_triangles_as_rays_against_all(tmp_path):
    rng = np.random.default_rng(3)
    middles = rng.uniform(-0.5, 0.5, (60, 1, 3))
    corners = middles + rng.normal(size=(60, 3, 3)) * rng.choice([0.1, 0.5], (60, 1, 1))
    rows = np.arange(180).reshape(-1, 3)
    model = el.viewer.Model(corners.reshape(-1, 3), rows, [1, 1, 1])
    page = page_of(tmp_path / "page.html", model)
    state = {"elevation": 0.4, "only": 3, "flatFloor": True, "bare": True}
    answer = run(page, SHADE, {"state": state, "size": [WIDTH, HEIGHT]})
    assert answer["messages"] == []
    start, pixels = answer["result"]
    seen = np.reshape(pixels, (-1, 4))[:, :3]
    eye, towards = things.rays({**start, **state}, WIDTH, HEIGHT)
    length, normals = nearest(model.vertices[model.triangles], eye, towards)
    floor = np.where(towards[:, 1] < 0, -eye[1] / towards[:, 1], np.inf)
    met = length < floor
    assert met.mean() > 0.04
    wanted = np.outer(0.5 + 0.5 * normals[:, 1], rig().ambient)
    error = np.abs(seen - wanted)[met].max(axis=1)
    # Rays through edges may go either way.
    assert np.mean(error > 2e-3) < 0.01
    assert np.median(error) < 2e-5


def test_the_page_of_a_model_refines_and_asks_for_nothing(tmp_path):
    page = page_of(tmp_path / "page <b>.html", el.viewer.Model(*cube(), scale=1000))
    script = """async () => {
      while (envlights.scene.frames < 2) await new Promise((then) => setTimeout(then, 50));
      return [envlights.scene.sums, document.querySelector(".panel").textContent];
    }"""
    answer = run(page, script, still=False, size=(240, 160))
    assert answer["messages"] == []
    assert [address.partition("?")[0] for address in answer["requests"]] == [page.as_uri()]
    sums, text = answer["result"]
    assert sums
    assert "12 triangles" in text
    assert "the model is 1e+03 m large" in text
