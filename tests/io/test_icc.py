"""ICC profiles: against LittleCMS, closed forms and random curves; damaged ones are refused."""

import io
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from envlights.environment.colour import icc, transfer_curves
from envlights.environment.colour.primaries import ADOBE_RGB, DISPLAY_P3, REC2020, to_rec709
from tests.io import profiles

CODES = np.linspace(0, 1, 256)


@pytest.mark.parametrize(
    ("curve", "formula"),
    [
        (profiles.gamma(1.8), lambda x: x ** (461 / 256)),
        (profiles.gamma(563 / 256), lambda x: x ** (563 / 256)),
        (profiles.parametric(0, 2.5), lambda x: x**2.5),
        (profiles.parametric(1, 2, 1.25, -0.25), lambda x: np.maximum(1.25 * x - 0.25, 0) ** 2),
        (
            profiles.parametric(2, 2, 1.25, -0.25, 0.125),
            lambda x: np.maximum(1.25 * x - 0.25, 0) ** 2 + 0.125,
        ),
        (
            profiles.parametric(3, 3, 0.75, 0.25, 0.5, 0.25),
            lambda x: np.where(x >= 0.25, (0.75 * x + 0.25) ** 3, 0.5 * x),
        ),
        (
            profiles.parametric(4, 3, 0.75, 0.25, 0.5, 0.25, 0.125, 0.0625),
            lambda x: np.where(x >= 0.25, (0.75 * x + 0.25) ** 3 + 0.125, 0.5 * x + 0.0625),
        ),
        (profiles.through(CODES**3), lambda x: x**3),
    ],
)
def test_each_kind_of_curve_follows_its_formula(curve, formula):
    for profile in (profiles.rgb(curve), profiles.grey(curve)):
        found = icc.parse(profile)
        np.testing.assert_allclose(found.curve(CODES), formula(CODES), atol=2e-5)
        assert found.matrix is None


@pytest.mark.parametrize("curve", [profiles.SRGB, profiles.SRGB_SAMPLED])
def test_curves_of_srgb_are_the_table_of_srgb(curve):
    found = icc.parse(profiles.rgb(curve))
    assert found.curve is transfer_curves.srgb
    assert found.matrix is None
    assert found.name == "test"


@pytest.mark.parametrize(
    "curve",
    [profiles.IDENTITY, profiles.gamma(1), profiles.parametric(0, 1), profiles.through([0, 1])],
)
def test_linear_curves_are_none(curve):
    assert icc.parse(profiles.rgb(curve)).curve is None


@pytest.mark.parametrize("space", [DISPLAY_P3, ADOBE_RGB, REC2020])
def test_primaries_of_a_profile_give_the_matrix_of_their_chromaticities(space):
    found = icc.parse(profiles.rgb(profiles.SRGB, space)).matrix
    np.testing.assert_allclose(found, to_rec709(space), atol=2e-3)


@pytest.mark.parametrize("space", [DISPLAY_P3, ADOBE_RGB, REC2020])
@pytest.mark.parametrize("curve", [profiles.SRGB, profiles.gamma(1.8), profiles.gamma(2.2)])
def test_littlecms_gives_the_same_colours(space, curve):
    cms = pytest.importorskip("PIL.ImageCms")
    image = pytest.importorskip("PIL.Image")
    data = profiles.rgb(curve, space)
    # Muted colours, which lie inside Rec.709, where LittleCMS does not cut.
    rng = np.random.default_rng(3)
    codes = (rng.integers(60, 200, (64, 1, 1)) + rng.integers(-25, 25, (64, 64, 3))).astype("u1")
    into = cms.createProfile("sRGB")
    picture = cms.profileToProfile(
        image.fromarray(codes), cms.ImageCmsProfile(io.BytesIO(data)), into, renderingIntent=1
    )
    profile = icc.parse(data)
    linear = profile.curve(codes / 255) @ profile.matrix.T
    expected = np.asarray(picture, float)
    found = 255 * transfer_curves.encode_srgb(linear)
    assert np.abs(found - expected).max() < 1.2


@pytest.mark.parametrize("space", ["sRGB"])
def test_the_profile_of_littlecms_is_srgb(space):
    cms = pytest.importorskip("PIL.ImageCms")
    found = icc.parse(cms.ImageCmsProfile(cms.createProfile(space)).tobytes())
    assert found.curve is transfer_curves.srgb
    assert found.matrix is None
    assert "sRGB" in found.name


def test_channels_may_have_different_curves():
    curves = [profiles.gamma(2), profiles.gamma(3), profiles.IDENTITY]
    found = icc.parse(profiles.rgb(curves)).curve(np.full((2, 3), 0.5))
    np.testing.assert_allclose(found, [[0.25, 0.125, 0.5]] * 2)


def test_codes_of_hdr_come_with_a_profile():
    cicp = b"cicp\0\0\0\0" + bytes([9, 16, 0, 1])
    assert icc.parse(profiles.rgb(profiles.SRGB, cicp=cicp)).cicp == (9, 16, 0, 1)


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (profiles.assemble({b"A2B0": b"mft2"}), "lookup tables"),
        (profiles.assemble({b"A2B0": b"mft2"}, b"CMYK", b"prtr"), "RGB or grey"),
        (profiles.assemble({}, b"Lab "), "RGB or grey"),
        (profiles.assemble({}, b"RGB ", b"link"), "RGB or grey"),
    ],
)
def test_other_kinds_of_profiles_are_not_used(data, reason):
    with pytest.raises(icc.UnusedProfileError, match=reason):
        icc.parse(data)


@pytest.mark.parametrize(
    "curve",
    [
        profiles.parametric(0, 0),
        profiles.parametric(0, -1),
        profiles.parametric(5, 1),
        profiles.parametric(1, 1, 0, 1),
        profiles.through([0, 0]),
        profiles.gamma(0)[:-2],
        b"curv\0\0\0\0" + struct.pack(">I", 2**32 - 1),
        b"none\0\0\0\0\0\0\0\0",
        b"",
    ],
)
def test_impossible_curves_are_refused(curve):
    with pytest.raises(ValueError, match="curve"):
        icc.parse(profiles.rgb(curve))


@given(arrays(np.float64, st.integers(2, 300), elements=st.floats(0, 1)))
def test_a_sampled_curve_gives_its_values_back(values):
    values[-1] = 1
    curve = icc.parse(profiles.rgb(profiles.through(values))).curve
    codes = np.linspace(0, 1, len(values))
    found = codes if curve is None else curve(codes)
    tolerance = 1e-5 if curve is not transfer_curves.srgb else 0.01
    np.testing.assert_allclose(found, values, atol=max(tolerance, 4e-5))


def test_every_truncation_and_500_mutants_get_an_answer_or_a_reason():
    rng = np.random.default_rng(7)
    whole = profiles.rgb([profiles.SRGB, profiles.gamma(2), profiles.through(CODES)], DISPLAY_P3)
    mutants = [whole[:size] for size in range(len(whole))]
    for _ in range(500):
        mutant = np.frombuffer(whole, "u1").copy()
        places = rng.integers(0, len(mutant), rng.integers(1, 30))
        mutant[places] = rng.choice([0, 1, 127, 128, 255], len(places))
        mutants.append(mutant.tobytes())
    for mutant in mutants:
        try:
            found = icc.parse(mutant)
        except ValueError:
            continue
        assert found.matrix is None or np.isfinite(found.matrix).all()
        if found.curve is not None:
            assert np.isfinite(found.curve(np.repeat(CODES[:, None], 3, axis=1))).all()


@pytest.mark.parametrize("size", [0, 3, 4, 8, 11])
def test_codes_that_are_cut_off_leave_the_curve_of_the_profile(size):
    tag = b"cicp\0\0\0\0" + bytes((9, 16, 0, 1))
    assert icc.parse(profiles.rgb(profiles.SRGB, cicp=tag)).cicp == (9, 16, 0, 1)
    found = icc.parse(profiles.rgb(profiles.SRGB, cicp=tag[:size]))
    assert found.cicp is None
    assert found.curve is transfer_curves.srgb
