"""Overlays of shadows: exact ratios, the errors of blending, files, refusals."""

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest

import envlights as el
from envlights._common.srgb import encode_srgb
from envlights.scene.solids import blocked_by

BALL = el.scene.Ball((0.0, 0.5, 0.0), 0.5)
BOX = el.scene.Box((1.2, 0.4, -0.2), (0.4, 0.4, 0.4), 0.5)
SUN = el.Lights([[0.48, 0.8, 0.36]], [[3, 2, 1]], [0.005])
LIGHTS = el.Lights(
    [[0.48, 0.8, 0.36], [-0.6, 0.64, -0.48], [0, 0.6, 0.8]],
    [[3, 2, 1], [1, 1.5, 2], [0.5, 0.9, 0.4]],
    [0.1, 0.4, 0.25],
)
RIG = el.Rig([0.2, 0.3, 0.4], LIGHTS, error=0.0, floor=True)
SHADOW = el.scene.shadow_overlay(RIG, [BALL, BOX], columns=48, floor_albedo=[0.6, 0.5, 0.3])


def test_one_light_is_exact_for_each_channel():
    """Against the radiance of the floor with a hidden light, over that with all light."""
    seen = el.scene.shadow_overlay(el.Rig([0.2, 0.3, 0.4], SUN, 0.0), BALL, columns=48)
    whole = np.pi * np.array([0.2, 0.3, 0.4]) + 0.8 * SUN.irradiance[0]
    away = np.array(BALL.centre) - seen.points
    distance = np.linalg.norm(away, axis=-1)
    contact = 0.5 * 0.25 / distance**3
    angle = np.arccos(np.clip(away @ SUN.direction[0] / distance, -1, 1))
    edge = np.arcsin(np.minimum(0.5 / distance, 1))
    is_dark, is_lit = angle < edge - 0.006, angle > edge + 0.006
    assert is_dark.sum() > 20
    for mask, light in ((is_dark, 0.0), (is_lit, 0.8)):
        expected = np.pi * np.outer(1 - contact[mask], [0.2, 0.3, 0.4]) + light * SUN.irradiance
        np.testing.assert_allclose(seen.ratio[mask], expected / whole, rtol=0, atol=1e-6)


def test_the_picture_is_the_floor_under_the_rig():
    """Reflected radiance by rays, over a floor of any colour."""
    albedo = np.array([0.9, 0.4, 0.1])
    surface = el.scene.Surface(
        SHADOW.points,
        np.broadcast_to([0, 1, 0], SHADOW.points.shape),
        np.broadcast_to(albedo, SHADOW.points.shape),
    )
    light = el.scene.DirectLight.of(surface, blocked_by((BALL, BOX)), 256)
    traced = el.scene.DirectLight(surface, light.blocked, light.sky, rays=256).image(RIG)
    drawn = SHADOW.over(albedo / np.pi * RIG.probe([0, 1, 0]))
    difference = np.abs(drawn - traced)[~SHADOW.covered] / drawn.max()
    assert difference.mean() < 1e-3
    assert np.quantile(difference, 0.999) < 0.02


def test_alpha_is_exact_on_its_own_floor_only():
    np.testing.assert_allclose(SHADOW.over(blending="alpha"), SHADOW.over(), atol=1e-12)
    other = [0.1, 0.8, 0.3]
    assert np.abs(SHADOW.over(other, "alpha") - SHADOW.over(other)).max() > 0.01
    assert (SHADOW.alpha >= 0).all()
    assert (SHADOW.alpha <= 1).all()
    assert (SHADOW.colour >= -1e-12).all()
    # The colour is blended in the standard way.
    alpha = SHADOW.alpha[..., None]
    blended = alpha * SHADOW.colour + (1 - alpha) * SHADOW.radiance
    np.testing.assert_allclose(blended, SHADOW.radiance * SHADOW.ratio, atol=1e-12)


def test_a_product_is_always_too_bright():
    product, exact = SHADOW.over(blending="product"), SHADOW.over()
    assert (product >= exact - 1e-12).all()
    hidden = (1 - SHADOW.single > 1e-12).any(axis=-1)
    is_single = hidden.sum(axis=0) <= 1
    np.testing.assert_allclose(product[is_single], exact[is_single], atol=1e-12)
    twins = el.Lights([[0.6, 0.8, 0], [-0.6, 0.8, 0]], [[1, 1, 1]] * 2)
    both = el.scene.shadow_overlay(twins, BALL, [[0, 0, 0.1]])
    assert both.ratio[0] == pytest.approx([0] * 3, abs=1e-12)
    assert both.over([1, 1, 1], "product")[0] == pytest.approx([0.25] * 3)


def test_codes_are_not_linear():
    floor = np.array([1.0, 0.5, 0.2])
    drawn = encode_srgb(SHADOW.over(floor, "codes"))
    np.testing.assert_allclose(drawn, encode_srgb(floor) * SHADOW.ratio, atol=1e-3)
    errors = SHADOW.code_errors(floor)
    assert errors["multiply"] == (0, 0)
    assert errors["codes"][1] > 20
    assert errors["alpha"][1] > 0.1
    assert SHADOW.code_errors()["alpha"][1] < 1e-6


def test_reflected_light_brightens_the_contact():
    dark, white = (
        el.scene.shadow_overlay(RIG, [BALL, BOX], columns=24, albedo=[value] * 3)
        for value in (0, 0.8)
    )
    plain = el.scene.shadow_overlay(RIG, [BALL, BOX], columns=24)
    np.testing.assert_allclose(dark.ratio, plain.ratio, atol=1e-9)
    assert (white.ratio >= dark.ratio - 1e-9).all()
    assert (white.ratio - dark.ratio).max() > 0.1
    assert "reflected light" in white.notes[0]


def test_harmonics_of_a_constant_are_the_constant():
    constant = np.zeros((9, 3))
    constant[0] = np.sqrt(4 * np.pi) * RIG.ambient
    harmonics = el.Rig(constant, LIGHTS, error=0.0)
    seen = el.scene.shadow_overlay(harmonics, [BALL, BOX], columns=24)
    expected = el.scene.shadow_overlay(RIG, [BALL, BOX], columns=24)
    np.testing.assert_allclose(seen.ratio, expected.ratio, atol=1e-9)


@pytest.mark.parametrize("blending", ["alpha", "multiply"])
def test_files_hold_the_overlay(tmp_path, blending):
    planes = [SHADOW.ratio]
    if blending == "alpha":
        planes = [SHADOW.colour * SHADOW.alpha[..., None], SHADOW.alpha[..., None]]
    expected = np.concatenate(planes, axis=-1)
    SHADOW.save(tmp_path / "shadow.exr", blending)
    read = oiio.ImageBuf(str(tmp_path / "shadow.exr"))
    np.testing.assert_allclose(read.get_pixels(), expected, rtol=1e-6, atol=1e-9)
    assert read.spec().alpha_channel == (3 if blending == "alpha" else -1)
    SHADOW.save(tmp_path / "shadow.png", blending)
    codes = oiio.ImageBuf(str(tmp_path / "shadow.png"))
    codes.reset(str(tmp_path / "shadow.png"), 0, 0, _straight_alpha())
    pixels = codes.get_pixels()
    white = SHADOW.radiance.max() if blending == "alpha" else 1
    colour = SHADOW.colour if blending == "alpha" else SHADOW.ratio
    np.testing.assert_allclose(pixels[..., :3], encode_srgb(colour / white), atol=0.6 / 255)
    if blending == "alpha":
        np.testing.assert_allclose(pixels[..., 3], SHADOW.alpha, atol=0.6 / 255)


def _straight_alpha():
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)
    return config


def test_views_name_the_errors():
    assert repr(SHADOW).startswith("<ShadowOverlay: 48x48 points under ambient + 3 lights")
    assert "product" in str(SHADOW)
    assert "<img" in SHADOW._repr_html_()
    rows = el.scene.shadow_overlay(RIG, BALL, [[0, 0, 0], [3, 0, 1]])
    assert repr(rows).startswith("<ShadowOverlay: 2 points")
    assert "<img" not in rows._repr_html_()


def test_a_solid_in_the_floor_is_noted():
    dome = el.scene.Ball((0, 0.0, 0), 0.5)
    assert (
        "solid 0 (Ball) reaches 0.5 below the floor" in el.scene.shadow_overlay(RIG, dome).notes[0]
    )


def test_points_under_a_solid_do_not_count_as_errors():
    points = [[1.2, 0, -0.2], [0, 0, 0], [0.01, 0, 0], [3, 0, 0]]
    seen = el.scene.shadow_overlay(RIG, [BALL, BOX], points)
    assert seen.covered.tolist() == [True, True, False, False]
    assert el.scene.shadow_overlay(RIG, [BALL, BOX], points[:2]).code_errors()["codes"] == (0, 0)


def test_no_light_and_no_solid_give_no_shadow():
    dark = el.Rig([0, 0, 0], LIGHTS[:0], error=0.0)
    assert (el.scene.shadow_overlay(dark, BALL, columns=8).ratio == 1).all()
    assert (el.scene.shadow_overlay(RIG, [], columns=8).ratio == 1).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: el.scene.shadow_overlay(RIG, el.scene.Ball((0, -2, 0), 1)),
            "solid 0 .Ball. is below the floor",
        ),
        (lambda: el.scene.shadow_overlay(RIG, "ball"), "solids must be Ball, Box or Polyhedron"),
        (lambda: el.scene.shadow_overlay("rig", BALL), "a rig must be a Rig, Lights"),
        (
            lambda: el.scene.shadow_overlay(RIG, BALL, [[0, 0]]),
            r"points must have the shape \(n, 3\) or",
        ),
        (
            lambda: el.scene.shadow_overlay(RIG, BALL, [[0, 0, 0], [0, 0]]),
            "points must be an array of real numbers",
        ),
        (lambda: el.scene.shadow_overlay(RIG, BALL, columns=0), "columns must be a whole number"),
        (
            lambda: el.scene.shadow_overlay(RIG, BALL, albedo=[2, 0, 0]),
            "albedo must lie from 0 to 1",
        ),
        (lambda: el.scene.shadow_overlay(RIG, BALL, albedo=[1, 0]), "albedo must have the shape"),
        (lambda: el.scene.shadow_overlay(RIG, BALL, floor_albedo=[-1, 0, 0]), "floor_albedo"),
        (
            lambda: el.scene.shadow_overlay(
                el.Rig(np.ones((9, 3)), SUN, 0.0), BALL, albedo=[1, 1, 1]
            ),
            "albedo needs a rig with a constant ambient term",
        ),
        (lambda: SHADOW.over([1, 1, 1], "screen"), "blending must be"),
        (lambda: SHADOW.over(np.ones((2, 2, 3))), "background must have the shape of the points"),
        (lambda: SHADOW.over([1, np.nan, 1]), "background must be finite radiance"),
        (lambda: SHADOW.over([[1, 1, 1], [1]]), "background must be an array of real numbers"),
        (lambda: SHADOW.save("shadow.jpg"), "the suffix must be .exr or .png"),
        (lambda: SHADOW.save("shadow.exr", "product"), "blending must be"),
        (
            lambda: el.scene.shadow_overlay(RIG, BALL, [[0, 0, 0]]).save("shadow.exr"),
            "only a picture can be saved",
        ),
    ],
)
def test_what_is_not_possible_is_refused(call, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(el.EnvLightsError, match=message):
        call()
