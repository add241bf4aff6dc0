"""Colour spaces of files: which statement counts, and the linear values that follow."""

from dataclasses import replace

import numpy as np
import pytest

from envlights import EnvLightsError
from envlights._common.srgb import decode_codes, decode_srgb, encode_srgb
from envlights.environment.colour import colour_spaces, transfer_curves
from envlights.environment.colour.choice import conversion
from envlights.environment.colour.linear import Linear
from envlights.environment.colour.primaries import (
    ACES_AP1,
    ADOBE_RGB,
    DISPLAY_P3,
    PROPHOTO,
    REC709,
    REC2020,
    to_rec709,
)
from envlights.environment.decoders.raw_image import FileColour, Header
from tests.io import profiles
from tests.reference import srgb

SRGB_NOTE = "integer samples were decoded from sRGB"


def header(kind="png", dtype="u1", **said):
    return Header(4, 2, kind, np.dtype(dtype), ("R", "G", "B"), FileColour(**said))


def linear(samples, colour=None, kind="png", **said):
    """Linear Rec.709 of one colour, by the whole conversion."""
    samples = np.asarray(samples)
    image = np.broadcast_to(samples, (2, 4, 3))
    head = header(kind, samples.dtype, **said)
    return Linear(head, conversion(head, colour))(image)[1, 2]


def codes(values, encode, dtype="u2"):
    largest = np.iinfo(dtype).max
    return np.round(encode(np.asarray(values, float)) * largest).astype(dtype)


def pq(relative):
    y = (np.asarray(relative) * 203 / 10000) ** 0.1593017578125
    return ((0.8359375 + 18.8515625 * y) / (1 + 18.6875 * y)) ** 78.84375


def hlg(scene):
    scene = np.asarray(scene, float)
    bright = 0.17883277 * np.log(np.maximum(12 * scene - 0.28466892, 1e-9)) + 0.55991073
    return np.where(scene <= 1 / 12, np.sqrt(3 * scene), bright)


SKY = [0.1, 0.2, 0.3]


@pytest.mark.parametrize("dtype", ["u1", "u2"])
@pytest.mark.parametrize(
    ("encode", "kind", "said"),
    [
        (lambda x: x, "png", {"gamma": 1.0}),
        (lambda x: x ** (1 / 1.8), "png", {"gamma": 0.55556}),
        (lambda x: x ** (1 / 2.2), "png", {"gamma": 0.45455}),
        (lambda x: x ** (1 / 2.6), "png", {"gamma": 0.38462}),
        (lambda x: x, "png", {"cicp": (1, 8, 0, 1)}),
        (encode_srgb, "png", {"cicp": (1, 13, 0, 1), "gamma": 1.0}),
        (lambda x: x ** (1 / 2.2), "png", {"cicp": (1, 4, 0, 1)}),
        (encode_srgb, "png", {"cicp": (2, 2, 0, 1)}),
        (encode_srgb, "png", {"is_srgb": True, "gamma": 1.0}),
        (encode_srgb, "png", {}),
        (lambda x: x, "tiff", {"icc": profiles.rgb(profiles.IDENTITY)}),
        (lambda x: x ** (1 / 1.8), "tiff", {"icc": profiles.rgb(profiles.parametric(0, 1.8))}),
        (lambda x: x, "jpeg", {"icc": profiles.rgb(profiles.gamma(1)), "is_srgb": True}),
        (lambda x: x, "png", {"icc": profiles.grey(profiles.IDENTITY), "gamma": 0.5}),
        (encode_srgb, "jpeg", {"icc": profiles.rgb(profiles.SRGB_SAMPLED)}),
        (lambda x: x, "tga", {"name": "lin_rec709_scene"}),
        (lambda x: x ** (1 / 1.8), "tga", {"name": "g18_rec709_scene"}),
        (encode_srgb, "tga", {"name": "srgb_rec709_scene"}),
        (lambda x: np.where(x < 0.018, 4.5 * x, 1.0992968 * x**0.45 - 0.0992968), "png",
         {"cicp": (1, 1, 0, 1)}),
    ],
)  # fmt: skip
def test_codes_become_the_light_that_their_file_means(dtype, encode, kind, said):
    found = linear(codes(SKY, encode, dtype), kind=kind, **said)
    np.testing.assert_allclose(found, SKY, rtol=0.03 if dtype == "u1" else 5e-4)


@pytest.mark.parametrize("light", [0.001, 0.1, 1.0, 10.0, 49.0])
def test_pq_names_luminance(light):
    grey = codes([light] * 3, pq)
    np.testing.assert_allclose(linear(grey, cicp=(9, 16, 0, 1)), [light] * 3, rtol=3e-3)


@pytest.mark.parametrize("scene", [0.01, 0.08, 0.1, 0.5, 1.0])
def test_hlg_becomes_the_light_of_the_scene(scene):
    grey = codes([scene] * 3, hlg)
    # Diffuse white, of a signal of 0.75, becomes 1.
    white = (np.exp((0.75 - 0.55991073) / 0.17883277) + 0.28466892) / 12
    np.testing.assert_allclose(linear(grey, cicp=(9, 18, 0, 1)), [scene / white] * 3, rtol=1e-3)


@pytest.mark.parametrize("dtype", ["u1", "u2"])
def test_the_narrow_range_of_video_is_widened(dtype):
    step = 1 if dtype == "u1" else 256
    for code, expected in ((16, 0.0), (235, 1.0), (125.5, 0.5)):
        found = linear(np.array([code * step] * 3).astype(dtype), cicp=(1, 8, 0, 0))
        np.testing.assert_allclose(found, [expected] * 3, atol=3e-3)


@pytest.mark.parametrize(
    ("space", "colour", "expected"),
    [
        (DISPLAY_P3, [0.9, 0.1, 0.1], [1.080, 0.066, 0.084]),
        (ADOBE_RGB, [0.2, 0.6, 0.2], [0.041, 0.600, 0.183]),
        (REC2020, [1000, 500, 200], [1352, 440, 155]),
        (ACES_AP1, [200, 800, 300], [0, 883, 238]),
        (PROPHOTO, [1, 1, 1], [1, 1, 1]),
    ],
)  # fmt: skip
def test_primaries_of_linear_files_are_converted(space, colour, expected):
    samples = np.array(colour, "f4")
    tolerance = 0.01 * max(expected)
    icc = profiles.rgb(profiles.IDENTITY, space)
    for kind, said in [
        ("openexr", {"chromaticities": space}),
        ("radiance", {"chromaticities": space}),
        ("tiff", {"icc": icc}),
    ]:
        np.testing.assert_allclose(linear(samples, kind=kind, **said), expected, atol=tolerance)
    half = linear(samples.astype("f2"), kind="openexr", chromaticities=space)
    np.testing.assert_allclose(half, expected, atol=tolerance)


@pytest.mark.parametrize("said", [{"icc": profiles.rgb(profiles.SRGB, DISPLAY_P3)},
                                  {"cicp": (12, 13, 0, 1)}, {"name": "srgb_p3d65_scene"},
                                  {"chromaticities": DISPLAY_P3}])  # fmt: skip
def test_display_p3_is_converted_however_it_is_said(said):
    red = codes([0.9, 0.1, 0.1], encode_srgb)
    np.testing.assert_allclose(linear(red, **said), [1.080, 0.066, 0.084], atol=2e-3)
    np.testing.assert_allclose(linear(red, "p3"), [1.080, 0.066, 0.084], atol=2e-3)


def test_adobe_rgb_has_the_exponent_of_its_profile():
    green = codes([0.2, 0.6, 0.2], lambda x: x ** (256 / 563))
    profile = profiles.rgb(profiles.gamma(563 / 256), ADOBE_RGB, name="Adobe RGB (1998)")
    steps = conversion(header("jpeg", "u2", icc=profile), None)
    assert steps.notes == (
        "integer samples were decoded from the curve of the ICC profile 'Adobe RGB (1998)'",
        "colours were converted from the ICC profile 'Adobe RGB (1998)' to Rec.709",
    )
    for colour, said in ((None, {"icc": profile}), ("adobe-rgb", {}), ("Adobe RGB", {})):
        np.testing.assert_allclose(
            linear(green, colour, "jpeg", **said), [0.041, 0.6, 0.183], atol=2e-3
        )


@pytest.mark.parametrize("light", [[1000, 500, 200], [0.1, 0.1, 0.1], [1, 2, 3], [0, 1, 0]])
def test_xyz_of_radiance_becomes_rgb(light):
    xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    samples = (xyz @ light).astype("f4")
    found = linear(samples, kind="radiance", is_xyz=True)
    np.testing.assert_allclose(found, light, atol=2e-3 * max(light))


@pytest.mark.parametrize(
    "values",
    [(0,) * 8, (0.640, 0.330, 0.290, 0.600, 0.150, 0.060, 0.333, 0.333), REC709, None],
)
@pytest.mark.parametrize("kind", ["radiance", "openexr"])
def test_linear_files_without_primaries_keep_their_samples(values, kind):
    head = header(kind, "f4", chromaticities=values)
    steps = conversion(head, None)
    assert steps == (None, None, None, ())
    samples = np.random.default_rng(1).random((2, 4, 3), "f4")
    assert np.shares_memory(Linear(head, steps)(samples), samples)


@pytest.mark.parametrize("values", [(0.3,) * 8, (*REC709[:7], np.nan), (*REC709[:6], 0.9, 0.05)])
def test_impossible_primaries_are_ignored_with_a_note(values):
    steps = conversion(header("openexr", "f4", chromaticities=values), None)
    assert steps.matrix is None
    assert "the primaries of the file were ignored" in steps.notes[0]


def test_a_float_file_follows_the_curve_of_its_profile_above_white():
    light = np.array([0.1, 1.0, 20.0])
    encoded = srgb.encode(light)
    profile = profiles.rgb(profiles.SRGB)
    for dtype in ("f4", "f2"):
        found = linear(encoded.astype(dtype), kind="tiff", icc=profile)
        np.testing.assert_allclose(found, light, rtol=3e-3)
    power = profiles.rgb(profiles.through(np.linspace(0, 1, 4096) ** 1.8))
    found = linear((light ** (1 / 1.8)).astype("f4"), kind="tiff", icc=power)
    np.testing.assert_allclose(found, light, rtol=2e-3)


def test_statements_about_a_camera_picture_leave_floats_linear():
    for said in ({"is_srgb": True}, {"name": "srgb_rec709_scene"}):
        assert conversion(header("tiff", "f4", **said), None) == (None, None, None, ())
    assert conversion(header("tiff", "f4", name="lin_ap1_scene"), None).matrix is not None
    stale = conversion(header("openexr", "f2", icc=profiles.rgb(profiles.SRGB, DISPLAY_P3)), None)
    assert stale == (None, None, None, ())


@pytest.mark.parametrize("dtype", ["u1", "u2"])
@pytest.mark.parametrize(
    "said", [{}, {"is_srgb": True}, {"icc": profiles.rgb(profiles.SRGB_SAMPLED)}]
)
def test_srgb_pictures_keep_every_bit(dtype, said):
    head = header("jpeg", dtype, **said)
    steps = conversion(head, None)
    assert (steps.notes, steps.clip_level, steps.matrix) == ((SRGB_NOTE,), 1.0, None)
    picture = np.random.default_rng(2).integers(0, np.iinfo(dtype).max, (5, 8, 3)).astype(dtype)
    np.testing.assert_array_equal(Linear(head, steps)(picture), decode_codes(picture))
    largest = np.iinfo(dtype).max
    table = steps.table(8 * picture.itemsize)
    np.testing.assert_array_equal(table, decode_srgb(np.arange(largest + 1) / largest))


@pytest.mark.parametrize("dtype", ["u1", "u2", "f2", "f4"])
def test_channels_with_different_curves_are_decoded_each(dtype):
    curves = [profiles.gamma(2), profiles.gamma(3), profiles.IDENTITY]
    largest = np.iinfo(dtype).max if dtype[0] == "u" else 1
    samples = np.array([51, 102, 204]) / 255 * largest
    found = linear(samples.astype(dtype), kind="tiff", icc=profiles.rgb(curves))
    np.testing.assert_allclose(found, [0.04, 0.064, 0.8], rtol=3e-3)


def test_white_is_the_light_of_the_largest_code():
    assert conversion(header(cicp=(9, 16, 0, 1)), None).clip_level == pytest.approx(10000 / 203)
    assert conversion(header(gamma=1.0), None).clip_level == 1
    assert conversion(header("tiff", "f4"), None).clip_level is None


def test_a_profile_of_another_kind_leaves_a_note():
    lookup = profiles.assemble({b"A2B0": b"mft2", b"desc": profiles.description("scanner")})
    steps = conversion(header("tiff", icc=lookup), None)
    assert steps.notes[1] == (
        "the ICC profile 'scanner' holds lookup tables, which are not applied; sRGB was assumed"
    )
    assert conversion(header("tiff", "f4", icc=lookup), None).curve is None


def test_colours_outside_rec709_are_counted():
    head = header("openexr", "f4", chromaticities=REC2020)
    converter = Linear(head, conversion(head, None))
    samples = np.ones((4, 8, 3), "f4")
    samples[0, :, 0] = 0
    samples[0, 0] = np.inf
    found = converter(samples)
    assert found.min() == 0
    assert np.isinf(found[0, 0]).all()
    assert converter.notes == (
        "22 % of the pixels lay outside Rec.709; their negative channels became 0",
    )
    assert samples[0, 1, 0] == 0
    assert samples[1, 1, 0] == 1


@pytest.mark.parametrize("name", colour_spaces.NAMES)
def test_each_name_keeps_black_and_white_grey(name):
    for code in (0, 255):
        found = linear(np.array([code] * 3, "u1"), name)
        spread = np.ptp(found) if name != "xyz" else 0
        assert spread < 1e-5 * max(1, found.max())
    assert linear(np.zeros(3, "u1"), name).max() == 0


def test_by_hand_wins_over_the_file(tmp_path):
    grey = np.array([128] * 3, "u1")
    assert linear(grey, "linear", cicp=(9, 16, 0, 1))[0] == pytest.approx(128 / 255)
    assert linear(grey, "SRGB", gamma=1.0)[0] == pytest.approx(decode_srgb(np.array(128 / 255)))
    profile = profiles.rgb(profiles.gamma(2))
    (tmp_path / "two.icc").write_bytes(profile)
    for by_hand in (profile, tmp_path / "two.icc", str(tmp_path / "two.icc")):
        assert linear(grey, by_hand, gamma=1.0)[0] == pytest.approx((128 / 255) ** 2)
    damaged = {"icc": b"x" * 200}
    assert linear(grey, "linear", **damaged)[0] == pytest.approx(128 / 255)


@pytest.mark.parametrize("colour", ["nonsense", 3, "", "a\0b", ["srgb"]])
def test_other_names_are_refused_with_the_list(colour):
    with pytest.raises(EnvLightsError, match=r'colour must be "linear", "srgb", "p3"|cannot read'):
        conversion(header(), colour)


@pytest.mark.parametrize(
    ("said", "reason"),
    [
        ({"icc": b"x" * 200}, "the ICC profile is damaged: its header has no signature"),
        ({"icc": profiles.rgb(profiles.SRGB)[:300]}, "the ICC profile is damaged"),
        ({"cicp": (9, 9, 0, 1)}, r"the codes \(9, 9, 0, 1\) of ITU-T H.273"),
        ({"cicp": (77, 13, 0, 1)}, "are not supported; name the colour space"),
    ],
)
def test_what_cannot_be_converted_is_refused(said, reason):
    with pytest.raises(EnvLightsError, match=reason):
        conversion(header(**said), None)


def test_negative_codes_get_the_negative_light():
    names = ("srgb", "rec709", "pq", "hlg", "prophoto")
    curves = [getattr(transfer_curves, name) for name in names]
    for curve in (*curves, transfer_curves.Power(2.2)):
        code = np.array([0.01, 0.3, 0.9, 1.0])
        np.testing.assert_array_equal(curve(-code), -curve(code))
        assert np.isnan(curve(np.array([np.nan]))).all()


def test_rec2020_by_cicp_is_the_matrix_of_its_primaries():
    steps = conversion(header(cicp=(9, 8, 0, 1)), None)
    np.testing.assert_allclose(steps.matrix, to_rec709(REC2020))
    assert steps.notes == (
        "integer samples were read as linear",
        "colours were converted from Rec.2020 to Rec.709",
    )


@pytest.mark.parametrize("dtype", ["u1", "f2", "f4"])
def test_a_grey_channel_becomes_three_equal_ones(dtype):
    curves = [profiles.gamma(2), profiles.gamma(3), profiles.IDENTITY]
    for curve, expected in ((profiles.gamma(2), 0.04), (curves, 0.008)):
        head = header("tiff", dtype, icc=profiles.rgb(curve, DISPLAY_P3))
        grey = np.full((2, 4, 1), 51 if dtype == "u1" else 0.2, dtype)
        found = Linear(head, conversion(head, None))(grey)
        assert found.shape == (2, 4, 3)
        np.testing.assert_allclose(found, expected, rtol=3e-3)


def test_the_exposure_of_the_header_is_divided_out():
    head = replace(header("radiance", "f4"), exposure=(0.1, 0.2, 0.5))
    found = Linear(head, conversion(head, None))(np.ones((2, 4, 3), "f4"))
    np.testing.assert_allclose(found[1, 1], [10, 5, 2], rtol=1e-6)


#: Red, green, blue and white of the codes of ITU-T H.273, table 2.
H273 = {
    1: (0.640, 0.330, 0.300, 0.600, 0.150, 0.060, 0.3127, 0.3290),
    4: (0.670, 0.330, 0.210, 0.710, 0.140, 0.080, 0.310, 0.316),
    5: (0.640, 0.330, 0.290, 0.600, 0.150, 0.060, 0.3127, 0.3290),
    6: (0.630, 0.340, 0.310, 0.595, 0.155, 0.070, 0.3127, 0.3290),
    7: (0.630, 0.340, 0.310, 0.595, 0.155, 0.070, 0.3127, 0.3290),
    8: (0.681, 0.319, 0.243, 0.692, 0.145, 0.049, 0.310, 0.316),
    9: (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290),
    11: (0.680, 0.320, 0.265, 0.690, 0.150, 0.060, 0.314, 0.351),
    12: (0.680, 0.320, 0.265, 0.690, 0.150, 0.060, 0.3127, 0.3290),
    22: (0.630, 0.340, 0.295, 0.605, 0.155, 0.077, 0.3127, 0.3290),
}


@pytest.mark.parametrize("code", H273)
def test_codes_of_primaries_have_the_chromaticities_of_h273(code):
    found = colour_spaces.by_cicp((code, 8, 0, 1), 8).matrix
    wanted = to_rec709(H273[code])
    assert (found is None) == (wanted is None) == (code == 1)
    if wanted is not None:
        np.testing.assert_allclose(found, wanted, rtol=1e-12)


@pytest.mark.parametrize(
    ("gamma", "is_used"), [(0.1, True), (10.0, True), (0.099, False), (10.1, False)]
)
def test_exponents_of_png_are_used_from_a_tenth_to_10(gamma, is_used):
    found = conversion(header(gamma=gamma), None)
    assert any("was ignored" in note for note in found.notes) != is_used
    value = linear(np.array([200, 100, 50], "u1"), gamma=gamma)
    wanted = (np.array([200, 100, 50]) / 255) ** (1 / gamma)
    assert np.allclose(value, wanted, rtol=1e-3) == is_used
