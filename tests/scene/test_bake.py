"""A courtyard under rigs: Mitsuba's own numbers, pairs, and the steps from a rig to a lightmap."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import envlights as el
from envlights import kernels

mi = pytest.importorskip("mitsuba")

from envlights.scene.mitsuba.emitters import emitters  # noqa: E402, needs Mitsuba
from envlights.scene.mitsuba.renderer import mitsuba  # noqa: E402, needs Mitsuba
from tests.reference.mitsuba_images import noise_of, relative, texels_by_mitsuba  # noqa: E402, needs Mitsuba

NO_LIGHTS = el.Lights(np.zeros((0, 3)), np.zeros((0, 3)))
LIT = el.synthetic.rigs(48)
NEW = el.synthetic.rigs(6, seed=1)


@pytest.fixture(scope="module")
def yard():
    return el.scene.MitsubaScene(el.synthetic.courtyard(), lightmap=16)


@pytest.fixture(scope="module")
def pairs(yard):
    return el.bake(yard, LIT, samples=128)


def test_the_charts_are_the_faces_in_the_order_of_their_names(yard):
    """Five faces of each box, the canopy, the floor, four walls: 4 by 4 charts of 4 by 4."""
    charts = [
        chart.reshape(4, 4, 4, 4, 3).swapaxes(1, 2).reshape(16, 16, 3)
        for chart in (yard.lightmap.position, yard.lightmap.normal, yard.lightmap.albedo)
    ]
    names = sorted(name for name in el.synthetic.courtyard() if name != "type")
    towards = {
        "east": [1, 0, 0],
        "west": [-1, 0, 0],
        "north": [0, 0, 1],
        "south": [0, 0, -1],
        "top": [0, 1, 0],
        "floor": [0, 1, 0],
        "canopy": [0, -1, 0],
    }
    for name, position, normal in zip(names, *charts[:2], strict=True):
        # The walls are seen from inside, the boxes from outside.
        side = -1 if name.startswith("wall") else 1
        wanted = side * np.array(towards[name.split("_")[-1]])
        np.testing.assert_allclose(normal, np.tile(wanted, (16, 1)), atol=1e-6)
        assert np.ptp(position @ wanted) < 1e-5, "flat"
    position, _, albedo = (chart[names.index("floor")] for chart in charts)
    np.testing.assert_allclose(position.min(axis=0), [-3, 0, -3], atol=1e-5)
    np.testing.assert_allclose(position.max(axis=0), [3, 0, 3], atol=1e-5)
    np.testing.assert_allclose(albedo, np.tile([0.5, 0.46, 0.4], (16, 1)), atol=1e-6)


@pytest.mark.slow
def test_threads_do_not_mix_their_images(yard):
    alone = [yard.indirect(rig, samples=16).image for rig in NEW]
    with ThreadPoolExecutor(4) as threads:
        together = list(threads.map(lambda rig: yard.indirect(rig, samples=16).image, NEW))
    np.testing.assert_array_equal(together, alone)


def test_what_blocks_a_ray_is_what_stands_there(yard):
    rays = [
        ([-2, 0.1, -2], [0, 1, 0], True),  # the canopy
        ([2, 0.1, 2], [0, 1, 0], False),  # the open sky
        ([0, 0.5, 1.4], [-1, 0, 0], True),  # the low box
        ([0, 1.5, 1.4], [-0.6, 0.8, 0], False),  # above it, and above the wall behind
        ([0, 1.5, 1.4], [-1, 0, 0], True),  # the wall
    ]
    origins, directions, wanted = (np.array(each) for each in zip(*rays, strict=True))
    np.testing.assert_array_equal(yard.blocked(origins, directions), wanted)


@pytest.mark.slow
def test_direct_light_of_unseen_rigs_is_mitsubas(yard):
    """Within 5 %; at the same points, so that the outlines of shadows are sampled alike."""
    constant = el.Rig([0.3, 0.4, 0.6], NEW[0].lights, error=0.0)
    rigs = [*NEW[:2], constant]
    for rig, images in zip(rigs, texels_by_mitsuba(yard.points, rigs, depth=2), strict=True):
        images = [yard.points.means(image, 16) for image in images]
        noise, difference = noise_of(*images), relative(yard.direct(rig), sum(images) / 2)
        assert noise < 0.02
        assert difference < 0.05, f"difference {difference:.3f}, noise {noise:.3f}"


def test_a_light_alone_is_mitsubas_to_rounding(yard):
    """A light that has no size leaves no noise, and no shadow is missed."""
    some = yard.points.thinned(2, 2)
    light = el.scene.DirectLight.of(some, yard.blocked, 1)
    rigs = [el.Rig(np.zeros(3), each.lights[:1], error=0.0) for each in NEW]
    for rig, (seen,) in zip(rigs, texels_by_mitsuba(some, rigs, depth=2, seeds=(1,)), strict=True):
        # A light that grazes an edge may fall on the other side of it.
        assert relative(light.image(rig), seen) < 0.01


@pytest.mark.slow
def test_discs_are_mitsubas_in_every_direction():
    """Irradiance of the emitters at 320 normals: that of the probe in closed form, within noise."""
    normals, _ = kernels.icosphere(320)
    square = kernels.hammersley(16384)
    with mitsuba() as mi:
        for number, radius in enumerate([0.27, 3, 25, 70, 90]):
            at = kernels.uniform_sphere(np.random.default_rng(number).random((1, 2)))
            lamp = el.Lights(at, [[1, 2, 4]], [np.deg2rad(radius)])
            rig = el.Rig(np.zeros(3), lamp, 0.0)
            ((weight, emitter),) = emitters(rig)
            ball = {"type": "sphere", "radius": 1e-3}
            scene = mi.load_dict({"type": "scene", "ball": ball, **emitter}, optimize=False)
            place = mi.SurfaceInteraction3f()
            samples = [
                scene.sample_emitter_direction(place, mi.Point2f(*each), False) for each in square
            ]
            towards = np.array([list(sample.d) for sample, _ in samples])
            strength = np.array([list(colour) for _, colour in samples])
            towards, strength = (each[strength.any(axis=1)] for each in (towards, strength))
            seen = weight * np.maximum(normals @ towards.T, 0) @ strength / len(square)
            assert relative(seen, rig.probe(normals)) < 1e-3, radius


@pytest.mark.slow
def test_direct_light_of_discs_is_mitsubas(yard):
    """Soft shadows of discs, together with points and an ambient term."""
    lights = el.Lights(NEW[4].lights.direction, NEW[4].lights.irradiance, [0.02, 0.3, 0.0])
    rigs = [el.Rig([0.02, 0.03, 0.05], lights, 0.0), el.Rig(NEW[1].ambient, lights, 0.0)]
    for rig, images in zip(rigs, texels_by_mitsuba(yard.points, rigs, depth=2), strict=True):
        images = [yard.points.means(image, 16) for image in images]
        noise, difference = noise_of(*images), relative(yard.direct(rig), sum(images) / 2)
        assert noise < 0.02
        assert difference < 0.03, f"difference {difference:.3f}, noise {noise:.3f}"


@pytest.mark.slow
@pytest.mark.parametrize("radius", [0.0, 0.3])
def test_direct_and_indirect_light_are_what_mitsuba_sees(yard, radius):
    """All light, computed twice: direct and indirect light, or sensors above the texels."""
    lights = NEW[2].lights
    radii = np.full(len(lights), radius)
    rig = el.Rig(NEW[2].ambient, el.Lights(lights.direction, lights.irradiance, radii), 0.0)
    ((one, two),) = texels_by_mitsuba(yard.lightmap, [rig], depth=-1, effort=64)
    light = el.scene.DirectLight.of(yard.lightmap, yard.blocked, 512)
    direct = replace(light, rays=64).image(rig)
    indirect = yard.indirect(rig, samples=4096)
    truth = (one + two) / 2
    noise = noise_of(one, two)
    noise += indirect.noise * np.linalg.norm(indirect.image) / np.linalg.norm(truth)
    difference = relative(direct + indirect.image, truth)
    assert noise < 0.05
    assert difference < noise, f"difference {difference:.3f}, noise {noise:.3f}"


@pytest.mark.slow
def test_the_noise_of_a_render_is_what_it_says(yard):
    truth = yard.indirect(NEW[0], samples=4096)
    for samples in (32, 128):
        rendered = yard.indirect(NEW[0], samples, seed=1)
        assert relative(rendered.image, truth.image) == pytest.approx(rendered.noise, rel=0.2)


@pytest.mark.slow
def test_an_ambient_term_may_take_light_away(yard):
    """Harmonics that are negative somewhere are no map for a renderer; light is linear."""
    dome, lobe = (each.ambient for each in NEW[:2])
    parts = [el.Rig(ambient, NO_LIGHTS, 0.0) for ambient in (dome, 3 * lobe, dome - 3 * lobe)]
    assert (kernels.harmonic_radiance(kernels.icosphere(1280)[0]) @ parts[2].ambient).min() < -0.1
    one, two, both = (yard.indirect(rig, samples=512) for rig in parts)
    noise = sum(each.noise * np.linalg.norm(each.image) for each in (one, two, both))
    assert np.linalg.norm(one.image - two.image - both.image) < noise
    direct = [yard.direct(rig) for rig in parts]
    np.testing.assert_allclose(direct[0] - direct[1], direct[2], atol=1e-6)


def test_a_seed_gives_the_same_bits(yard):
    once, again = (yard.indirect(NEW[0], samples=8, seed=3) for _ in range(2))
    np.testing.assert_array_equal(once.image, again.image)
    assert not np.array_equal(once.image, yard.indirect(NEW[0], samples=8, seed=4).image)


@pytest.mark.slow
def test_a_rig_becomes_a_lightmap_within_the_error_that_the_model_states(yard, pairs):
    """The whole bridge: rigs, pairs, a model, a new rig, its direct and its indirect light."""
    model = el.TransferModel.fit(pairs.direct, pairs.indirect, rank=32, ridge="loo")
    errors, noise = [], []
    for rig in NEW:
        truth = yard.indirect(rig, samples=800, seed=1000)
        errors.append(relative(model.predict(yard.direct(rig)), truth.image))
        noise.append(truth.noise)
    stated, error, noisy = model.report.error, np.median(errors), np.median(noise)
    assert noisy < 0.1
    assert error < stated + noisy, f"error {error:.3f}, stated {stated:.3f}, noise {noisy:.3f}"
    assert max(errors) < max(model.report.unseen_errors)


@pytest.mark.slow
def test_more_paths_are_not_in_the_direct_light(yard, pairs):
    again = el.bake(yard, LIT[:2], samples=8)
    np.testing.assert_array_equal(again.direct, pairs.direct[:2])
    assert (again.noise > pairs.noise[:2]).all()


def test_noise_is_of_its_own_for_each_rig(yard):
    twice = el.bake(yard, [LIT[0], LIT[0]], samples=8)
    np.testing.assert_array_equal(*twice.direct)
    assert not np.array_equal(*twice.indirect)


def test_lights_alone_are_rigs_without_an_ambient_term(yard):
    dark = el.Rig(np.zeros(3), NEW[0].lights, error=0.0)
    one, other = (el.bake(yard, [each], samples=8) for each in (NEW[0].lights, dark))
    np.testing.assert_array_equal(one.direct, other.direct)
    np.testing.assert_array_equal(one.indirect, other.indirect)


def test_detected_lights_are_lights(yard):
    found = el.detect(el.synthetic.hall(64).radiance)
    one, other = (el.bake(yard, [each], samples=8) for each in (found, found.discs()))
    np.testing.assert_array_equal(one.direct, other.direct)
    assert one.direct.any()


def test_no_light_gives_a_black_pair(yard):
    dark = el.bake(yard, [el.Rig(np.zeros(3), NO_LIGHTS, error=0.0)], samples=8)
    assert not dark.direct.any()
    assert not dark.indirect.any()
    assert dark.noise == 0


@pytest.mark.slow
def test_pairs_on_disk_are_those_in_memory(pairs, tmp_path):
    pairs.save(tmp_path)
    read = el.read_pairs(tmp_path)
    np.testing.assert_array_equal(read.direct, pairs.direct)
    np.testing.assert_array_equal(read.indirect, pairs.indirect)


def test_a_lightmap_of_your_own_is_taken(yard):
    own = el.scene.MitsubaScene(el.synthetic.courtyard(), yard.lightmap)
    one, other = (each.indirect(NEW[0], samples=8).image for each in (own, yard))
    np.testing.assert_array_equal(one, other)
    assert own.points.covered.shape == (16, 16)
    # One point for each texel of the direct image, not 8 by 8: what shadows cut is all or nothing.
    assert relative(own.direct(NEW[0]), yard.direct(NEW[0])) < 0.5


XML = """<scene version="3.0.0">
  <emitter type="constant"/>
  <sensor type="perspective"/>
  <shape type="rectangle" id="floor">
    <transform name="to_world"><rotate x="1" angle="-90"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.2, 0.4, 0.8"/></bsdf>
  </shape>
</scene>"""


def test_shapes_of_any_kind_have_charts():
    floor = {"type": "rectangle", "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], -90)}
    kinds = {
        "ball": {"type": "sphere", "center": [3, 1, 0], "radius": 0.5},
        "cube": {"type": "cube"},
        "disc": {"type": "disk"},
        "floor": floor,
    }
    scene = el.scene.MitsubaScene({"type": "scene", **kinds}, lightmap=16)
    ball, cube, disc, floor = (
        scene.lightmap.position.reshape(2, 8, 2, 8, 3).swapaxes(1, 2).reshape(4, 64, 3)
    )
    np.testing.assert_allclose(np.linalg.norm(ball - [3, 1, 0], axis=1), 0.5, rtol=1e-5)
    np.testing.assert_allclose(np.abs(cube).max(axis=1), 1, rtol=1e-5)
    assert (np.linalg.norm(disc, axis=1) < 1).all()
    np.testing.assert_allclose(floor[:, 1], 0, atol=1e-6)


def test_a_large_lightmap_is_measured_at_enough_of_its_texels(yard):
    own = yard.lightmap
    large = [maps.repeat(2, axis=0).repeat(30, axis=1) for maps in (own.position, own.normal)]
    scene = el.scene.MitsubaScene(
        el.synthetic.courtyard(), el.scene.Surface(*large, np.ones((32, 480, 3)))
    )
    # 2 by 30 texels for each of the direct image: each third of 30, for 8 are enough.
    assert scene.points.covered.shape == (32, 160)
    np.testing.assert_array_equal(scene.points.position[::2, ::10], own.position)


def test_a_file_is_taken_and_its_own_light_left_out(tmp_path):
    (tmp_path / "floor.xml").write_text(XML)
    floor = el.scene.MitsubaScene(tmp_path / "floor.xml", lightmap=4)
    up = el.Rig([1, 1, 1], el.Lights([[0, 1, 0]], [[np.pi] * 3]), error=0.0)
    seen = el.scene.DirectLight.of(floor.lightmap, floor.blocked).image(up)
    np.testing.assert_allclose(seen, np.tile([0.4, 0.8, 1.6], (4, 4, 1)), rtol=1e-6)
    assert not floor.indirect(up, samples=8).image.any(), "nothing is there to bounce from"


def test_the_variant_of_the_user_is_left_alone():
    before = mi.variant()
    mi.set_variant("scalar_spectral")
    try:
        el.scene.MitsubaScene(el.synthetic.courtyard(), lightmap=4)
        with pytest.raises(el.EnvLightsError):
            el.scene.MitsubaScene({"type": "nothing"})
        assert mi.variant() == "scalar_spectral"
    finally:
        mi.set_variant(before or "scalar_rgb")


def triangle():
    """A mesh without UV coordinates."""
    mesh = mi.Mesh("bare", 3, 1)
    corners = mi.traverse(mesh)
    corners["vertex_positions"] = [0.0, 0, 0, 0, 0, 1, 1, 0, 0]
    corners["faces"] = [0, 1, 2]
    corners.update()
    return {"type": "scene", "bare": mesh}


def lamp():
    return {**el.synthetic.courtyard(), "lamp": {"type": "sphere", "emitter": {"type": "area"}}}


@pytest.mark.parametrize(
    ("scene", "lightmap", "message"),
    [
        (lamp, 16, "the shape 'lamp' is an area light; remove it"),
        (
            lambda: 3,
            16,
            "scene must be a dict or the path of an XML file; got an object of the type int",
        ),
        (lambda: {"type": "scene"}, 16, "the scene has no shapes"),
        (lambda: {"type": "scene", "a": {"type": "cubus"}}, 16, "cannot load the scene: .*cubus"),
        (lambda: "nowhere.xml", 16, "cannot load the scene: .*nowhere.xml"),
        (lambda: {"type": "cube"}, 16, "scene must be of the type 'scene'; got a "),
        (triangle, 16, "the shape 'bare' has no chart: .*UV.*; give a lightmap of your own"),
        (el.synthetic.courtyard, 3, "16 shapes need a lightmap 4 wide; got 3"),
        (el.synthetic.courtyard, 0, "lightmap must be a whole number, 1 or more; got 0"),
    ],
)
def test_scenes_that_no_rig_can_light_are_refused(scene, lightmap, message):
    with pytest.raises(el.EnvLightsError, match=message) as refusal:
        el.scene.MitsubaScene(scene(), lightmap)
    assert "\n" not in str(refusal.value)


def test_what_is_no_light_is_refused(yard):
    with pytest.raises(el.EnvLightsError, match="rigs is empty"):
        el.bake(yard, [])
    for work in (lambda sun: el.bake(yard, [NEW[0], sun]), yard.direct, yard.indirect):
        with pytest.raises(
            el.EnvLightsError, match="Rig, Lights or DetectedLights; got an object of the type str"
        ):
            work("sun")
    with pytest.raises(
        el.EnvLightsError, match=r"must be a MitsubaScene; got an object of the type dict"
    ):
        el.bake({"type": "scene"}, NEW)
    with pytest.raises(el.EnvLightsError, match="samples must be a whole number, 1 or more"):
        el.bake(yard, NEW[:1], samples=0)
    with pytest.raises(el.EnvLightsError, match="seed must be a whole number, 0 or more"):
        el.bake(yard, NEW[:1], seed=-1)
    odd = el.scene.Surface(*np.ones((3, 20, 16, 3)) * [0, 1, 0])
    with pytest.raises(el.EnvLightsError, match="multiple of 16 rows and columns; got 20x16"):
        el.scene.MitsubaScene(el.synthetic.courtyard(), odd)


@pytest.mark.slow
def test_a_gathered_prior_is_what_mitsuba_renders(yard):
    """The prior takes backs of the two-sided walls and the canopy as black."""
    pairs = el.bake(yard, LIT[:3], samples=512, size=32)
    errors = pairs.prior.errors(pairs.direct, pairs.indirect)
    assert np.median(errors) < 0.2
    # Check the energy too.
    seen = pairs.prior.predict(pairs.direct)
    scale = np.sum(seen * pairs.indirect, axis=(1, 2, 3)) / np.sum(seen**2, axis=(1, 2, 3))
    np.testing.assert_allclose(scale, 1, atol=0.03)


def test_a_gather_needs_charts_and_an_albedo_below_1(yard):
    own = el.scene.MitsubaScene(el.synthetic.courtyard(), yard.points)
    with pytest.raises(el.EnvLightsError, match="the lightmap is your own"):
        own.gather()
    white = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [1.0, 1.0, 1.0]}}
    scene = el.scene.MitsubaScene(
        {"type": "scene", "floor": {"type": "rectangle", "bsdf": white}}, 16
    )
    with pytest.raises(el.EnvLightsError, match="albedo must be from 0 to below 1"):
        scene.gather(rays=4)
    with pytest.raises(el.EnvLightsError, match="multiple of 24 rows and columns; got 128x128"):
        yard.gather(size=24)
