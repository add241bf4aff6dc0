"""The probe against a white sphere that Mitsuba renders under the same map."""

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from tests.helpers import angle_deg

mi = pytest.importorskip("mitsuba")

SIZE = 48


def smooth_sky(theta, phi):
    """Two soft lamps before a gradient: no pixel matters, only the frame does."""
    theta, phi = np.broadcast_arrays(theta, phi)
    directions = kernels.uv_to_direction(
        np.stack([phi.ravel() / (2 * np.pi), theta.ravel() / np.pi], axis=-1)
    )
    radiance = np.full((len(directions), 3), 0.2) + 0.1 * directions[:, 1:2] * [1, 0, -1]
    lamps = [((0.6, 0.64, -0.48), (8, 6, 3)), ((-0.8, -0.36, 0.48), (1, 3, 5))]
    for centre, colour in lamps:
        radiance += np.exp(12 * (directions @ np.array(centre) - 1))[:, None] * colour
    return radiance.reshape(*theta.shape, 3).astype(np.float32)


def skies(height):
    """One sky for us (rows between the poles) and for Mitsuba (rows on the poles)."""
    phi = 2 * np.pi * (np.arange(2 * height) + 0.5) / (2 * height)
    ours = np.pi * (np.arange(height)[:, None] + 0.5) / height
    theirs = np.pi * np.arange(height)[:, None] / (height - 1)
    return smooth_sky(ours, phi), smooth_sky(theirs, phi)


def render(emitters, samples, seed, view=(0.0, 0.0, 1.0), up=(0.0, 1.0, 0.0)):
    """Radiance of a white Lambertian sphere, seen from `view` without perspective."""
    origin = [5 * component for component in view]
    eye = mi.ScalarTransform4f().look_at(origin=origin, target=[0, 0, 0], up=list(up))
    film = {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}}
    white = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}}
    scene = {
        "type": "scene",
        "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 1},
        "sensor": {"type": "orthographic", "to_world": eye, "film": film},
        "probe": {"type": "sphere", "bsdf": white},
        **emitters,
    }
    image = mi.render(mi.load_dict(scene), spp=samples, seed=seed)
    return np.array(image)[..., :3]


def visible_normals():
    """Normals at the pixels' centres, and which pixels lie well inside the outline."""
    at = (2 * np.arange(SIZE) + 1) / SIZE - 1
    # Seen from +z with +y up, +x lies to the right.
    x, y = np.meshgrid(at, -at)
    inside = x**2 + y**2 < 0.85
    x, y = x[inside], y[inside]
    return np.stack([x, y, np.sqrt(1 - x**2 - y**2)], axis=-1), inside


def compare(emitters, irradiance, samples):
    """RMS of Mitsuba's noise and of our difference from it, both relative."""
    _, inside = visible_normals()
    first, second = (np.pi * render(emitters, samples, seed)[inside] for seed in (1, 2))
    mean = (first + second) / 2
    size = np.sqrt((mean**2).mean())
    # The mean of two has half the variance of one, and their difference twice.
    noise = np.sqrt(((first - second) ** 2).mean()) / 2 / size
    return noise, np.sqrt(((mean - irradiance) ** 2).mean()) / size


@pytest.fixture(scope="module", autouse=True)
def variant():
    mi.set_variant("scalar_rgb")


@pytest.mark.slow
def test_probe_agrees_with_mitsuba_within_its_noise():
    ours, theirs = skies(256)
    normals, _ = visible_normals()
    emitter = {"type": "envmap", "bitmap": mi.Bitmap(theirs)}
    noise, difference = compare({"sky": emitter}, el.EnvMap(ours).probe(normals), 4096)
    assert noise < 0.01
    assert difference < 1.2 * noise, f"difference {difference:.2e}, noise {noise:.2e}"


def test_a_rig_lights_mitsubas_probe_as_it_says():
    """`constant.radiance` is our ambient, `directional.irradiance` ours; theirs points away."""
    rig = el.fit(skies(64)[0], lights=2, sizes=False)
    normals, _ = visible_normals()
    noise, difference = compare(emitters_of(rig), rig.probe(normals), 64)
    # A pixel is 1/24 of the radius wide: across a terminator its mean is not its middle.
    assert difference < max(1.2 * noise, 5e-3), f"difference {difference:.2e}, noise {noise:.2e}"


def test_the_brightness_of_each_emitter_is_that_of_its_render():
    """One emitter alone has no noise of a choice, and the mean over pixels has little."""
    rig = el.fit(skies(64)[0], lights=2, sizes=False)
    normals, inside = visible_normals()
    for name, emitter in emitters_of(rig).items():
        is_light = name.startswith("light")
        own = [i for i in range(len(rig.lights)) if is_light and name == f"light_{i}"]
        parts = (getattr(rig.lights, part)[own] for part in ("direction", "irradiance"))
        part = el.Rig(np.zeros(3) if is_light else rig.ambient, el.Lights(*parts), 0.0)
        said = part.probe(normals)
        if not said.any():
            continue
        image = np.pi * render({name: emitter}, 64, 1)[inside]
        scale = (image * said).sum() / (said * said).sum()
        assert scale == pytest.approx(1, abs=0.003), name


@pytest.mark.slow
def test_the_error_is_that_between_renders_under_map_and_rig():
    ours, theirs = skies(256)
    rig = el.fit(ours, lights=2, sizes=False)
    sky = {"sky": {"type": "envmap", "bitmap": mi.Bitmap(theirs)}}
    under_sky, weights = whole_probe(sky, 256, seeds=(1, 2))
    # Mitsuba draws one emitter for each sample; each for itself leaves no noise of that draw.
    emitters = emitters_of(rig).items()
    under_rig = sum(whole_probe({name: one}, 64, seeds=(3, 4))[0] for name, one in emitters)
    whole = np.sum(weights * (under_sky[0] * under_sky[1]).sum(axis=1))
    # Noise that is independent has no part in the mean of the product.
    one, other = under_sky - under_rig
    error = np.sqrt(np.sum(weights * (one * other).sum(axis=1)) / whole)
    # One and other share what is true: where their squares differ, they do by noise.
    noisy = weights * (one**2 - other**2).sum(axis=1) / 2
    noise = np.sqrt(np.sum(noisy**2)) / whole / (2 * error)
    assert noise < 0.02 * error
    assert abs(error - rig.error) < 3 * noise, f"{error:.4f} +- {noise:.4f}, said {rig.error:.4f}"


@pytest.mark.slow
def test_a_rendered_probe_under_sun_and_sky_gives_the_sun_back():
    """`fit_probe` on what another program rendered: a hard sun, and a sky of a few harmonics."""
    ours, theirs = soft_sky(256)
    towards = np.array([0.48, 0.6, 0.64])
    irradiance = np.array([5.0, 4.5, 4.0])
    sun = {"type": "directional", "direction": (-towards).tolist(), "irradiance": rgb(irradiance)}
    sky = {"type": "envmap", "bitmap": mi.Bitmap(theirs)}
    # Separate emitters avoid the noise of choosing one.
    (probe, weights), (under_sky, _) = (
        whole_probe({"emitter": each}, samples, seeds=(1,))
        for each, samples in ((sun, 64), (sky, 256))
    )
    rig = el.fit_probe(whole_normals(), (probe + under_sky)[0], 1, weights=weights, ambient="sh2")
    assert len(rig.lights) == 1
    # A pixel is a 24th of the radius wide: across the terminator its mean is not its middle.
    assert angle_deg(rig.lights.direction[0], towards) < 0.2
    np.testing.assert_allclose(rig.lights.irradiance[0], irradiance, rtol=0.02)
    wanted = el.EnvMap(ours).probe(whole_normals())
    found = el.Rig(rig.ambient, el.Lights(np.zeros((0, 3)), np.zeros((0, 3))), 0.0)
    difference = found.probe(whole_normals()) - wanted
    assert np.linalg.norm(difference) < 0.05 * np.linalg.norm(wanted)


def soft_sky(height):
    """A gradient for us and for Mitsuba, which nine harmonics hold."""
    rows = np.pi * (np.arange(height) + 0.5) / height, np.pi * np.arange(height) / (height - 1)
    colour = np.array([0.4, 0.5, 0.7])
    return [
        np.broadcast_to(
            (1 + 0.6 * np.cos(theta))[:, None, None] * colour, (height, 2 * height, 3)
        ).astype(np.float32)
        for theta in rows
    ]


def whole_normals():
    """The normals of `whole_probe`, in its order."""
    at = (2 * np.arange(SIZE) + 1) / SIZE - 1
    x, y = np.meshgrid(at, -at)
    z = np.sqrt(np.maximum(1 - x**2 - y**2, 0))
    own = (z > 0) & (z >= np.abs(x)) & (z >= np.abs(y))
    inside = np.stack([x[own], y[own], z[own]], axis=1)
    frames = []
    for view in np.concatenate([np.eye(3), -np.eye(3)]):
        up = np.roll(view, 1)
        frames.append(inside @ np.stack([np.cross(up, view), up, view]))
    return np.concatenate(frames)


def whole_probe(emitters, samples, seeds):
    """Irradiance all around for each seed, (seeds, n, 3), and the solid angle of each pixel."""
    at = (2 * np.arange(SIZE) + 1) / SIZE - 1
    x, y = np.meshgrid(at, -at)
    z = np.sqrt(np.maximum(1 - x**2 - y**2, 0))
    # Six views, of each the part that no other sees better.
    own = (z > 0) & (z >= np.abs(x)) & (z >= np.abs(y))
    views = [
        [np.pi * render(emitters, samples, seed, view, np.roll(view, 1))[own] for seed in seeds]
        for view in np.concatenate([np.eye(3), -np.eye(3)])
    ]
    return np.concatenate(views, axis=1), np.tile((2 / SIZE) ** 2 / z[own], 6)


def emitters_of(rig):
    emitters = {"ambient": {"type": "constant", "radiance": rgb(rig.ambient)}}
    for i, direction in enumerate(rig.lights.direction):
        irradiance = rgb(rig.lights.irradiance[i])
        light = {"type": "directional", "direction": (-direction).tolist()}
        emitters[f"light_{i}"] = {**light, "irradiance": irradiance}
    return emitters


def rgb(values):
    return {"type": "rgb", "value": values.tolist()}


def metal_ball(radiance, roughness, view, seed):
    """Image of a ball of rough metal without Fresnel's colours, under a map, from one side."""
    world = mi.Bitmap(radiance.astype(np.float32))
    origin = [5 * component for component in view]
    up = [0, 1, 0] if abs(view[1]) < 0.9 else [1, 0, 0]
    eye = mi.ScalarTransform4f().look_at(origin=origin, target=[0, 0, 0], up=up)
    film = {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}}
    metal = {"type": "roughconductor", "material": "none", "distribution": "ggx"}
    scene = {
        "type": "scene",
        "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 1},
        "sensor": {"type": "orthographic", "to_world": eye, "film": film},
        "ball": {"type": "sphere", "bsdf": {**metal, "alpha": roughness**2}},
        "world": {"type": "envmap", "bitmap": world},
    }
    image = np.array(mi.render(mi.load_dict(scene), spp=24, seed=seed))[..., :3]
    at = (2 * np.arange(SIZE) + 1) / SIZE - 1
    return image[np.hypot(*np.meshgrid(at, at)) < 1]


def test_the_gloss_error_is_that_of_rendered_metal():
    """A pixel's difference in two renders has independent noise, so their product has none."""
    env = el.EnvMap(el.synthetic.hall(64).radiance)
    rig = el.fit(env, 2)
    # Mitsuba interpolates pixels, and its rows lie on the poles: squares of 4 pixels hide both.
    whole, seen = env.radiance.repeat(4, axis=0).repeat(4, axis=1), rig.to_map(256).radiance
    squares = np.zeros(2)
    for side, view in enumerate(kernels.icosphere(20)[0]):
        truth, light = (
            [metal_ball(radiance, 0.4, view, 4 * side + k + first) for k in (0, 1)]
            for first, radiance in ((0, whole), (2, seen))
        )
        off = [one - other for one, other in zip(light, truth, strict=True)]
        squares += (off[0] * off[1]).sum(), (truth[0] * truth[1]).sum()
    expected = np.sqrt(squares[0] / squares[1])
    assert rig.report.gloss_error(0.4) == pytest.approx(expected, rel=0.05)


def test_a_sun_that_was_moved_in_the_map_casts_its_shadow_from_there():
    """The shadow of a hanging ball on a floor, seen from above, under the changed map alone."""
    sun = el.synthetic.Disc((1, 1.5, 0.2), 1.5, (3000, 2800, 2500))
    parts = el.split(el.synthetic.scene(256, background=[0.3, 0.4, 0.5], shapes=[sun]).radiance)
    moved = parts.lights.moved(0, azimuth=np.deg2rad(250), elevation=np.deg2rad(50))
    env = parts.with_lights(moved)
    eye = mi.ScalarTransform4f().look_at(origin=[0, 3, 0], target=[0, 0, 0], up=[0, 0, 1])
    eye = eye @ mi.ScalarTransform4f().scale([2, 2, 1])
    flat = mi.ScalarTransform4f().rotate([1, 0, 0], -90).scale(4)
    film = {"type": "hdrfilm", "width": 80, "height": 80, "rfilter": {"type": "box"}}
    white = {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}}
    scene = {
        "type": "scene",
        "integrator": {"type": "direct"},
        "sensor": {"type": "orthographic", "to_world": eye, "film": film},
        "floor": {"type": "rectangle", "to_world": flat, "bsdf": white},
        "ball": {"type": "sphere", "center": [0, 1, 0], "radius": 0.15, "bsdf": white},
        **el.export.mitsuba(parts.lights[:0], env),
    }
    image = np.array(mi.render(mi.load_dict(scene), spp=64, seed=1)).mean(axis=2)
    z, x = 2 - 4 * (np.mgrid[:80, :80] + 0.5) / 80  # seen from above, +x is to the left
    dark = (image < 0.5 * np.median(image)) & (np.hypot(x, z) > 0.2)
    x, z = x[dark].mean(), z[dark].mean()
    towards = moved.direction[0]
    np.testing.assert_allclose([x, z], -towards[[0, 2]] / towards[1], atol=0.03)
