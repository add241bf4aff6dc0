"""Detection in photographs: against the slow reference, in closed form, and on views of maps."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import envlights as el
from envlights import kernels
from envlights.environment.layouts.picture_layout import planar
from envlights.papers.loghin import PHOTOGRAPH
from envlights.papers.photograph import _solid_angles
from envlights.synthetic import Disc, Rectangle, scene
from tests.conftest import real_maps
from tests.helpers import angle_deg, printed_by_threads
from tests.reference import photograph

ARTICLE = {
    "relative": False,
    "move_to_maximum": False,
    "samples_per_pixel": 0.006,
    "suppression_px": 20.0,
    "window_px": 12,
}


def detect(image, fov=None, *, working_side=1024, **settings):
    """`detect_photograph` with some settings of its own."""
    settings = replace(PHOTOGRAPH, **settings)
    return el.detect_photograph(image, fov, working_side=working_side, settings=settings)


def some_pictures():
    rng = np.random.default_rng(1)
    yield rng.random((120, 170), dtype=np.float32)
    yield rng.random((170, 96), dtype=np.float32) ** 8 * 3
    lamps = [Disc((0.2, 0.1, 1), 6, (3, 3, 3)), Rectangle((-0.4, 0.1, 1), 30, 4, (1.1, 1, 1))]
    world = scene(256, background=[0.2] * 3, shapes=lamps).radiance
    yield kernels.luminance(photograph.view(world, np.eye(3), 144, 256, 90))
    night = np.full((150, 220), 0.01, np.float32)
    night[20:26, 30:90] = rng.uniform(0.9, 1.1, (6, 60))
    night[100:103, 200:202] = 40.0
    night[60, 0] = night[60, 219] = 2.0  # the two borders, far apart in a plane
    yield night


@pytest.mark.parametrize("sampling", ["halton", "hammersley"])
@pytest.mark.parametrize("which", range(4))
@pytest.mark.parametrize("is_article", [True, False])
def test_it_agrees_with_the_slow_reference(which, sampling, is_article):
    """Same samples in the same order, same light for each, same places."""
    luminance = list(some_pictures())[which]
    options = ARTICLE if is_article else {}
    found = detect(luminance, sampling=sampling, **options)
    level = found.report.threshold
    settings = {"per_pixel": 0.012, "apart": 10.0, "bright": level, "peak": 2 * level, "reach": 6}
    settings = {} if is_article else settings
    # An array of one channel is grey: its luminance is a sum of three products.
    image = kernels.luminance(np.repeat(luminance[..., None], 3, axis=2))
    first, at, light, places = photograph.detect(image, sequence=sampling, **settings)
    assert len(found) == len(places)
    assert found.samples.first.tolist() == [list(pixel) for pixel in first]
    assert found.samples.pixel.tolist() == [list(pixel) for pixel in at]
    number = {home: found.samples.light[home] for home in places}
    assert found.samples.light.tolist() == [number[home] for home in light]
    for home, (row, column) in places.items():
        x, y = found.position[number[home]]
        np.testing.assert_allclose((y - 0.5, x - 0.5), (row, column), atol=1e-9)


def test_blur_and_reduction_end_at_the_border():
    luminance = np.zeros((90, 160), np.float32)
    luminance[:, 0] = 1.0
    np.testing.assert_allclose(
        kernels.blur(luminance, 1.5), photograph.blur(luminance, 1.5), atol=1e-6
    )
    assert kernels.blur(luminance, 1.5)[:, 80:].max() == 0
    assert kernels.resize_bilinear(luminance, 45, 80)[:, 1:].max() == 0


def test_lamps_at_opposite_borders_are_two_lights():
    image = np.full((200, 400, 3), 0.01)
    image[90:110, :10] = image[90:110, -10:] = 1.0
    for options in ({}, ARTICLE, {"blur_px": 1.0}):
        x = detect(image, **options).position[:, 0]
        assert len(x) == 2
        assert min(x) < 12
        assert max(x) > 388


def test_a_blurred_lamp_at_one_border_does_not_show_at_the_other():
    image = np.full((200, 400, 3), 0.01)
    image[90:110, :10] = 1.0
    found = detect(image, blur_px=2.0)
    assert len(found) == 1
    assert found.position[0, 0] < 15


@pytest.mark.parametrize(("gap", "lights"), [(2, 1), (6, 2)])
def test_a_black_bar_parts_a_lamp_if_it_is_wide(gap, lights):
    """A black pixel counts as 2 stops below the threshold, so that a thin bar parts nothing."""
    image = np.full((400, 1024, 3), 0.1)
    image[180:220, 300:400] = 3.0
    image[180:220, 350 : 350 + gap] = 0.0
    assert len(el.detect_photograph(image)) == lights


def test_the_longer_side_of_a_portrait_is_reduced():
    image = np.full((2048, 1024, 3), 0.1)
    image[500:580, 400:480] = 5.0
    found = el.detect_photograph(image)
    assert found.report.working_size == (1024, 512)
    np.testing.assert_allclose(found.position, [[440, 540]], atol=15)


@pytest.mark.parametrize("reduction", ["bilinear", "area"])
def test_a_reduced_picture_reports_places_in_its_own_pixels(reduction):
    image = np.full((2000, 3000, 3), 0.1)
    image[500:580, 2400:2520] = 5.0
    found = detect(image, reduction=reduction)
    assert found.report.working_size == (683, 1024)
    np.testing.assert_allclose(found.position, [[2460, 540]], atol=15)
    np.testing.assert_allclose(found.luminance, 5 * 80 * 120, rtol=0.2)
    assert image[tuple(found.peak_pixel[0])][0] == 5.0


def test_an_area_reduction_keeps_the_mean_of_any_size():
    image = np.random.default_rng(0).random((113, 201, 3))
    found = detect(image, reduction="area", working_side=50, relative=False)
    assert found.report.working_size == (28, 50)
    image[60, 120] = 4000.0
    (light,) = detect(image, reduction="area", working_side=50)
    np.testing.assert_allclose(light.position, (120.5, 60.5), atol=3)


@given(
    exposure=st.integers(-60, 60),
    seed=st.integers(0, 9),
    sampling=st.sampled_from(["halton", "hammersley"]),
)
def test_the_exposure_has_no_influence(exposure, seed, sampling):
    image = np.random.default_rng(seed).random((40, 60, 3), dtype=np.float32) ** 9
    one = detect(image, 60, sampling=sampling)
    other = detect(image * np.float32(2.0**exposure), 60, sampling=sampling)
    np.testing.assert_array_equal(one.position, other.position)
    np.testing.assert_allclose(one.irradiance * 2.0**exposure, other.irradiance)


@pytest.mark.parametrize("height", [300, 301])
def test_a_portrait_is_searched_with_the_lengths_of_a_landscape(height):
    image = np.full((height, 200, 3), 0.1)
    image[40:60, 90:110] = 3.0
    upright = el.detect_photograph(image)
    lying = el.detect_photograph(image.swapaxes(0, 1))
    np.testing.assert_allclose(upright.position, lying.position[:, ::-1], atol=3)


class TestField:
    """Field of view, directions and irradiance."""

    @given(
        height=st.integers(2, 40),
        width=st.integers(2, 40),
        reduction=st.integers(1, 3),
        fov=st.floats(1.0, 178.0),
    )
    def test_solid_angles_of_the_samples_sum_to_the_closed_form(
        self, height, width, reduction, fov
    ):
        camera = planar(reduction * height, reduction * width, field_of_view=np.deg2rad(fov))
        pixel = np.argwhere(np.ones((height, width)))
        angles = _solid_angles(camera, pixel, (height, width), reduction**2)
        a = np.tan(np.deg2rad(fov) / 2)
        b = a * height / width
        whole = 4 * np.arctan2(a * b, np.sqrt(1 + a * a + b * b))
        np.testing.assert_allclose(angles.sum(), whole, rtol=1e-12)
        assert (angles > 0).all()

    def test_a_reduction_that_rounds_the_sides_keeps_the_solid_angle_of_the_axis(self):
        camera = planar(9, 2001, field_of_view=0.2)
        (angle,) = _solid_angles(camera, np.array([[1, 333]]), (2, 667), 3.0)
        focal = 2001 / 2 / np.tan(0.1)
        np.testing.assert_allclose(angle, 3 / focal**2, rtol=1e-5)

    def test_right_of_the_picture_is_minus_x_and_its_upper_side_plus_y(self):
        image = np.full((100, 200, 3), 0.01)
        image[20:24, 148:152] = 9.0
        found = el.detect_photograph(image, fov=90)
        slopes = (image.shape[1] / 2 - found.position[:, 0], 50 - found.position[:, 1])
        wanted = np.array([slopes[0] / 100, slopes[1] / 100, np.ones(1)]).T
        np.testing.assert_allclose(found.direction, wanted / np.linalg.norm(wanted))
        assert found.direction[0, 0] < 0 < found.direction[0, 1]

    def test_the_irradiance_of_a_bright_square_is_that_of_its_solid_angle(self):
        """The factor is the error of the samples: 800 of them lie on the square."""
        image = np.full((1000, 1000, 3), 0.001)
        image[350:650, 350:650] = 2.0
        found = el.detect_photograph(image, fov=90)[:1]
        grid = (np.arange(300) + 0.5) / 300 * 0.6 - 0.3
        cosines = 1 / np.sqrt(1 + grid[:, None] ** 2 + grid**2)
        # A pixel has the solid angle cos^3 / f^2, and its irradiance one cosine more.
        wanted = 2.0 * (cosines**4).sum() * 0.002**2
        np.testing.assert_allclose(found.irradiance[0], wanted, rtol=0.05)

    def test_without_a_field_there_are_no_directions(self):
        image = np.full((40, 60, 3), 0.01)
        image[20:24, 30:34] = 9.0
        found = el.detect_photograph(image)
        assert found.direction is found.irradiance is found.field_of_view is None
        assert "give fov in degrees" in found.report.notes[-1]
        assert found[0].direction is None

    @pytest.mark.parametrize(
        ("tags", "size", "wanted"),
        [
            # The diagonal of 36 x 24 mm at 27 mm; landscape, portrait, another aspect.
            ({0xA405: 27}, (300, 200), 2 * np.arctan(18 / 27)),
            ({0xA405: 27}, (200, 300), 2 * np.arctan(12 / 27)),
            ({0xA405: 27}, (400, 300), 2 * np.arctan(0.8 * np.hypot(18, 12) / 27)),
            # 5 mm on a sensor of 200 pixels a millimetre, whose picture was reduced by 10.
            (
                {0x920A: 5.0, 0xA20E: 2000.0, 0xA210: 3, 0xA002: 3000, 0xA003: 2000},
                (300, 200),
                2 * np.arctan(150 / 100),
            ),
            ({0x920A: 5.0}, (300, 200), None),
            ({0xA405: 0}, (300, 200), None),
        ],
    )
    def test_exif_gives_it(self, tags, size, wanted, tmp_path):
        image = pytest.importorskip("PIL.Image")
        rational = pytest.importorskip("PIL.TiffImagePlugin").IFDRational
        path = tmp_path / "photograph.jpg"
        exif = image.Exif()
        for tag, value in tags.items():
            exif.get_ifd(0x8769)[tag] = rational(value) if isinstance(value, float) else value
        image.new("RGB", size, (20, 20, 20)).save(path, exif=exif)
        for source in (path, path.read_bytes()):
            found = el.detect_photograph(source)
            assert found.size == size[::-1]
            if wanted is None:
                assert found.field_of_view is None
            else:
                np.testing.assert_allclose(found.field_of_view, wanted, rtol=1e-6)
                assert "from the EXIF (FocalLength" in found.report.notes[-1]
        assert el.detect_photograph(path, fov=50).field_of_view == pytest.approx(np.deg2rad(50))


class TestInput:
    """Files, arrays and refusals."""

    def test_codes_are_those_of_the_file(self, tmp_path):
        image = pytest.importorskip("PIL.Image")
        codes = np.full((90, 120, 3), 60, np.uint8)
        codes[30:40, 60:80] = 255
        path = tmp_path / "photograph.png"
        image.fromarray(codes).save(path)
        of_file, of_array = el.detect_photograph(path), el.detect_photograph(codes)
        np.testing.assert_array_equal(of_file.position, of_array.position)
        np.testing.assert_array_equal(of_file.pixel_flux, of_array.pixel_flux)
        assert of_file.is_clipped.tolist() == [True]
        wide = el.detect_photograph(np.uint16(257) * codes)
        np.testing.assert_allclose(wide.position, of_array.position)

    @pytest.mark.parametrize(("code", "lights"), [(231, 0), (232, 1)])
    def test_the_absolute_threshold_is_the_code_231(self, code, lights):
        picture = np.full((64, 99, 3), code, np.uint8)
        assert len(detect(picture, relative=False)) == lights

    @pytest.mark.parametrize("bright", [1.0, 0.3])
    def test_a_clipped_picture_that_is_bright_everywhere_has_lights(self, bright):
        """Twice the background lies above the clip level."""
        codes = np.full((64, 99, 3), int(255 * bright**0.4), np.uint8)
        codes[20:30, 20:30] = 255
        assert len(el.detect_photograph(codes)) == 1

    def test_alpha_and_masks_are_black(self):
        image = np.full((400, 600, 4), 9.0)
        image[..., 3] = 0.0
        image[100:140, 300:340, 3] = 1.0
        found = el.detect_photograph(image)
        assert len(found) == 1
        assert abs(found.position[0] - (320, 120)).max() < 3
        masked = np.ma.array(image[..., :3], mask=np.repeat(image[..., 3:] == 0, 3, axis=2))
        np.testing.assert_array_equal(el.detect_photograph(masked).position, found.position)

    def test_samples_that_are_no_radiance_are_replaced_by_neighbours_on_their_side(self):
        image = np.full((40, 60, 3), 0.1)
        image[:, -1] = 5.0
        image[20, 0] = np.nan
        found = el.detect_photograph(image)
        assert "3 NaN samples set to the mean of the neighbours" in found.report.notes
        assert (found.position[:, 0] > 30).all()

    @pytest.mark.parametrize("image", [np.zeros((40, 60)), np.full((40, 60), 0.5), np.ones((2, 2))])
    def test_worst_cases_are_answered(self, image):
        assert len(el.detect_photograph(image, 40)) == 0
        lamp = np.zeros((40, 60))
        lamp[20, 30] = 1e30
        assert len(el.detect_photograph(lamp, 40)) <= 1

    @pytest.mark.parametrize(
        ("call", "message"),
        [
            (lambda: el.detect_photograph(np.ones((1, 9))), "at least 2x2 pixels; got 9x1"),
            (lambda: el.detect_photograph(np.ones((9, 9, 2))), "a photograph must have the shape"),
            (lambda: el.detect_photograph(np.ones((9, 9), int)), "a photograph must be floating"),
            (lambda: el.detect_photograph(el.EnvMap(np.ones((4, 8)))), "whose lights `detect`"),
            (lambda: el.detect_photograph(np.ones((9, 9)), 180), "fov must be a finite number"),
            (lambda: el.detect_photograph(np.ones((9, 9)), 0), "from 0.05 to 179; got 0"),
            (lambda: el.detect_photograph(np.ones((9, 9)), colour="srgb"), "colour describe a fil"),
            (lambda: el.detect_photograph(np.ones((9, 9)), part=0), "part describe a file"),
            (lambda: detect(np.ones((9, 9)), sampling="x"), "'hammersley' or"),
            (lambda: detect(np.ones((9, 9)), reduction="x"), "'bilinear' or 'area'"),
            (lambda: el.detect_photograph(np.full((9, 9), np.nan)), "no finite sample"),
            (lambda: el.detect(np.ones((9, 16, 3))), "detect_photograph"),
            (
                lambda: el.plot.photograph(el.detect_photograph(np.ones((9, 9))), fov=3),
                "no options",
            ),
        ],
    )
    def test_bad_input_is_refused_by_name(self, call, message):
        with pytest.raises(el.EnvLightsError, match=message):
            call()


class TestResult:
    """The object that holds the lights."""

    FOUND = el.detect_photograph(
        np.random.default_rng(3).random((90, 150, 3), dtype=np.float32) ** 12, 60
    )

    def test_it_is_sorted_sliced_and_iterated(self):
        found = self.FOUND
        assert len(found) > 3
        assert (np.diff(found.luminance) <= 1e-9).all()
        part = found[[2, 0]]
        assert part == found[np.array([0, 2])]
        assert [light.flux_fraction for light in part] == [found.fraction[0], found.fraction[2]]
        assert found[-1] == list(found)[-1]
        wanted = found.samples.pixel[np.isin(found.samples.light, [0, 2])]
        np.testing.assert_array_equal(part.samples.pixel, wanted)
        homes = part.samples.light[part.samples.survivor]
        np.testing.assert_array_equal(homes, part.samples.light)
        assert len(el.detect_photograph(np.ones((9, 9)))[:2]) == 0
        with pytest.raises(el.EnvLightsError, match="index of lights"):
            found["x"]

    def test_its_texts_have_the_places(self):
        found = self.FOUND
        x = f"{found.position[0, 0]:.1f}"
        for text in (str(found), str(found[0]), found._repr_html_(), repr(found[0])):
            assert x in text
        assert repr(found).endswith("150x90 pixels, 60° wide>")
        assert "data:image/png" in found._repr_html_()
        assert "of 162 samples are dark" in found.verbose()
        assert found.verbose().startswith(str(found.table()))
        rows = found.table().rows
        assert [row[0] for row in rows] == [str(j + 1) for j in range(len(rows))]

    def test_a_limit_drops_the_dimmest(self):
        image = np.random.default_rng(3).random((90, 150, 3), dtype=np.float32) ** 12
        assert el.detect_photograph(image, 60, lights=2) == self.FOUND[:2]


def test_any_number_of_threads_gives_the_same_bits():
    code = (
        "import numpy as np, envlights as el;"
        "image = np.random.default_rng(0).random((300, 500, 3), dtype=np.float32) ** 9;"
        "from dataclasses import replace;"
        "settings = replace(el.papers.loghin.PHOTOGRAPH, blur_px=1.0);"
        "found = el.detect_photograph(image, 70, working_side=400, settings=settings);"
        "print(found.irradiance.tobytes().hex(), found.samples.light.tolist())"
    )
    assert len(printed_by_threads(code)) == 1


def lights_near(radiance, lights, azimuths, elevation):
    """Distance in degrees of each light in some views from the nearest one found there."""
    nearest = []
    for azimuth in azimuths:
        axes = photograph.axes_of_view(azimuth, elevation)
        image = photograph.view(radiance, axes, 360, 640, 90, places=2)
        d, inside = photograph.directions_in_view(lights, axes, 360, 640, 90)
        found = el.detect_photograph(image, 90)
        angles = angle_deg(d[inside][:, None], found.direction[None])
        nearest += angles.min(axis=1, initial=180.0).tolist()
    return nearest


def test_lamps_of_generated_worlds_are_found_in_views_of_them():
    """Nine of ten within one degree, at linear values."""
    nearest = []
    for seed in list(el.synthetic.TUNING)[:6]:
        radiance = el.synthetic.plain(seed).radiance
        nearest += lights_near(radiance, el.detect(radiance), (0, 90, 180, 270), 10)
    assert len(nearest) > 5
    assert np.mean(np.array(nearest) < 1) >= 0.9


@real_maps("hdr/st_peters*.hdr", "hdr/f3d*.hdr", all_quick=True)
def test_lights_of_real_maps_are_found_in_views_of_them(path):
    env = el.EnvMap.open(path)
    nearest = lights_near(env.radiance, el.detect(env), (0, 90, 180, 270), 20)
    assert len(nearest) > 5
    assert np.mean(np.array(nearest) < 1) >= 0.9


def small_lamp(side, x=301, y=233):
    picture = np.full((480, 640, 3), 0.05, np.float32)
    picture[y : y + side, x : x + side] = 2.0
    return picture


@pytest.mark.parametrize("side", [4, 6, 9, 13])
@pytest.mark.parametrize("at", [(301, 233), (44, 400), (590, 60)])
def test_the_uncertainty_of_small_lamps_holds_their_flux(side, at):
    """The note states a factor, which the true flux is within, or that it is unknown."""
    found = el.detect_photograph(small_lamp(side, *at), fov=60)
    truth = 2.0 * side**2
    for light, number in zip(found, range(1, 99), strict=False):
        pattern = rf"light {number} (unknown|a factor of ([\d.e+]+)) \((\d+) samples?\)"
        stated = re.search(pattern, str(found))
        ratio = light.pixel_flux[1] / truth
        factor = 2.0 if stated is None else float(stated[2] or np.inf)
        assert 1 / factor <= ratio <= factor


def test_a_large_lamp_has_no_note_of_uncertainty(tmp_path):
    found = el.detect_photograph(small_lamp(120), fov=60)
    assert not any("uncertain" in note for note in found.report.notes)
    small = el.detect_photograph(small_lamp(9))
    assert el.Note(small.report.notes[0]).code == "few-samples"
    small.save(tmp_path / "lights.json")
    assert type(small).load(tmp_path / "lights.json").report.notes == small.report.notes
