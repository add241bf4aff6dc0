"""Arrays for training, against closed forms."""

import numpy as np
import pytest

import envlights as el


def lights(*irradiances, radius=0.1):
    count = len(irradiances)
    directions = np.array([[0, 1, 0], [0, 0, 1], [0.6, 0.8, 0]])[:count]
    return el.Lights(directions, [[each] * 3 for each in irradiances], np.full(count, radius))


def test_places_have_the_brightest_lights_and_the_rest_is_a_fraction():
    arrays = el.batches.label_arrays([lights(6, 3, 1), lights(5)], lights=2)
    assert arrays.mask.tolist() == [[True, True], [True, False]]
    np.testing.assert_array_equal(arrays.direction[0], [[0, 1, 0], [0, 0, 1]])
    np.testing.assert_array_equal(arrays.irradiance[..., 1], [[6, 3], [5, 0]])
    np.testing.assert_allclose(arrays.left_out, [0.1, 0], rtol=1e-6)
    for name in ("direction", "irradiance", "amplitude", "sharpness", "angular_radius"):
        assert not getattr(arrays, name)[1, 1].any()
        assert getattr(arrays, name).dtype == np.float32


def test_the_solid_angle_is_that_of_the_cap():
    arrays = el.batches.label_arrays([lights(1, radius=0.3)], lights=1)
    assert arrays.solid_angle[0, 0] == pytest.approx(2 * np.pi * (1 - np.cos(0.3)), rel=1e-6)


def test_gaussians_keep_flux_and_mean_cosine_of_the_disc():
    """Integrals of the Gaussian by quadrature over the polar angle."""
    radius = 0.3
    arrays = el.batches.label_arrays([lights(2, radius=radius)], lights=1)
    sharpness, amplitude = float(arrays.sharpness[0, 0]), float(arrays.amplitude[0, 0, 0])
    cosine = np.linspace(-1, 1, 400_001)
    lobe = 2 * np.pi * amplitude * np.exp(sharpness * (cosine - 1))
    flux, moment = np.trapezoid(lobe, cosine), np.trapezoid(lobe * cosine, cosine)
    radiance = 2 / (np.pi * np.sin(radius) ** 2)
    cap = 2 * np.pi * (1 - np.cos(radius))
    assert moment == pytest.approx(2, rel=1e-6)
    assert flux == pytest.approx(radiance * cap, rel=1e-6)


def test_ambient_term_of_a_grey_map_is_its_radiance():
    grey = np.full((32, 64, 3), [0.5, 0.25, 1.0])
    arrays = el.batches.label_arrays([el.fit(grey, lights=0), lights(1)], lights=1)
    np.testing.assert_allclose(arrays.ambient[0], [0.5, 0.25, 1.0], rtol=1e-5)
    assert not arrays.ambient[1].any()
    assert not arrays.mask[0].any()


def test_arrays_of_a_batch_are_those_of_its_rigs_without_failures():
    maps = {f"map-{seed}": el.synthetic.plain(seed, 128).radiance for seed in range(3)}
    result = el.batch([*maps.items(), ("bad", [1])], lights=2, jobs=1)
    rigs = [el.fit(image, lights=2) for image in maps.values()]
    arrays, expected = el.batches.label_arrays(result, 3), el.batches.label_arrays(rigs, 3)
    assert arrays.names == tuple(maps)
    for name, array in expected.to_dict().items():
        if name != "names":
            np.testing.assert_array_equal(getattr(arrays, name), array)


def test_labels_without_lights_are_refused():
    result = el.batch([np.ones((16, 32, 3))], what=lambda env: {"peak": env.radiance.max()})
    with pytest.raises(el.EnvLightsError, match="labels must hold lights"):
        el.batches.label_arrays(result, 1)
    with pytest.raises(el.EnvLightsError, match="several rigs or lights; got"):
        el.batches.label_arrays(lights(1), 1)


def test_harmonics_of_rigs_are_in_the_labels(tmp_path):
    sky = el.synthetic.plain(0, 128)
    rig = el.fit(sky.radiance, lights=1, ambient="sh2")
    arrays = el.batches.label_arrays([rig, el.fit(sky.radiance, 1), lights(1)], lights=1)
    np.testing.assert_allclose(arrays.ambient_harmonics[0], rig.ambient, rtol=1e-6)
    # A constant term is the first harmonic alone: the same light.
    assert not arrays.ambient_harmonics[1, 1:].any()
    constant = el.Rig(arrays.ambient_harmonics[1].astype(float), lights(1), error=0.0)
    expected = el.Rig(arrays.ambient[1].astype(float), lights(1), error=0.0)
    np.testing.assert_allclose(constant.probe([[0, 1, 0]]), expected.probe([[0, 1, 0]]), rtol=1e-6)
    assert not arrays.ambient_harmonics[2].any()
    maps = [("sky", sky.radiance)]
    result = el.batch(maps, tmp_path, lights=1, ambient="sh2", jobs=1)
    for batch in (result, el.batches.Batch.load(tmp_path)):
        of_rows = el.batches.label_arrays(batch, 1).ambient_harmonics
        np.testing.assert_array_equal(of_rows[0], arrays.ambient_harmonics[0])


@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
@pytest.mark.parametrize("what", ["detect", "split", "limit"])
def test_the_ambient_label_of_lights_is_the_map_without_them(what, registration):
    """Together with the lights it has the flux of the map."""
    lamp = el.synthetic.Disc((1, 1, 0), 4.0, (90, 60, 30))
    shapes = {"background": [0.2, 0.3, 0.4], "shapes": [lamp]}
    layout = el.io.Layout(registration=registration)
    env = el.EnvMap(el.synthetic.scene(128, **shapes).radiance, layout=layout)
    work = {"detect": el.detect, "split": el.split, "limit": lambda env: el.limit(env, 0.5)}[what]
    (row,) = el.batch([env], what=work, jobs=1).rows()
    np.testing.assert_allclose(
        row["ambient"], [0.2, 0.3, 0.4], rtol=0.02 if what != "limit" else 0.3
    )
    if what == "detect":
        found = el.detect(env)
        total = env.harmonics(0)[0] * np.sqrt(4 * np.pi)
        rest = 4 * np.pi * np.array(found.report.remainder)
        np.testing.assert_allclose(found.flux.sum(axis=0) + rest, total, rtol=1e-5)
        labels = el.batches.label_arrays([found], 1)
        np.testing.assert_allclose(labels.ambient[0], row["ambient"], rtol=1e-6)


def test_the_remainder_of_a_part_of_the_sphere_is_the_mean_over_that_part():
    coverage = np.zeros((32, 64), np.float32)
    coverage[:20] = 1
    grey = np.full((32, 64, 3), [0.5, 0.25, 1.0], np.float32) * coverage[..., None]
    found = el.detect(el.EnvMap(grey, coverage=coverage))
    np.testing.assert_allclose(found.report.remainder, [0.5, 0.25, 1.0], rtol=1e-5)


def test_the_remainder_is_saved_with_the_lights(tmp_path):
    found = el.detect(el.synthetic.plain(0, 128).radiance)
    found.save(tmp_path / "lights.json")
    again = type(found).load(tmp_path / "lights.json")
    assert again.report.remainder == found.report.remainder
