"""The steps of baking, with a scene that renders nothing."""

import numpy as np
import pytest

import envlights as el

TEXELS = np.zeros((2, 3, 3))
RIGS = el.synthetic.rigs(3)


class Scene(el.scene.MitsubaScene):
    """Records its calls; the image of rig k is k + 1 everywhere."""

    lightmap = el.scene.Surface(TEXELS, TEXELS + np.array([0, 1, 0]), TEXELS + 0.5)

    def __init__(self, failing=None):
        object.__setattr__(self, "asked", [])
        object.__setattr__(self, "failing", failing)

    points = el.scene.Surface(
        *(np.ones((16, 16, 3)) * each for each in ([0, 0, 0], [0, 1, 0], 0.5))
    )

    def gather(self, *, size, progress):
        raise el.EnvLightsError("it has no geometry")

    def direct(self, rig, size):
        assert size == 16
        self.asked.append(("direct", RIGS.index(rig)))
        return np.full((2, 2, 3), RIGS.index(rig) + 1.0, np.float32)

    def indirect(self, rig, samples, seed):
        k = RIGS.index(rig)
        if k == self.failing:
            raise el.EnvLightsError("the renderer broke")
        self.asked.append(("indirect", k, samples, seed))
        return el.scene.Rendering(np.full((2, 3, 3), k + 1, np.float32), 0.25 * k)


def test_each_rig_is_rendered_once_in_its_order_and_with_a_seed_of_its_own():
    scene = Scene()
    pairs = el.bake(scene, iter(RIGS), samples=7, seed=40)
    steps = [step for k in range(3) for step in (("direct", k), ("indirect", k, 7, 40 + k))]
    assert scene.asked == steps
    for images in (pairs.direct, pairs.indirect):
        np.testing.assert_array_equal(images[:, 0, 0, 0], [1, 2, 3])
    np.testing.assert_array_equal(pairs.noise, [0, 0.25, 0.5])
    assert pairs.prior is None
    assert pairs.skipped == ("no prior: it has no geometry",)


def test_a_render_that_fails_ends_the_baking():
    scene = Scene(failing=1)
    with pytest.raises(el.EnvLightsError, match="the renderer broke"):
        el.bake(scene, RIGS, samples=1)
    assert ("direct", 2) not in scene.asked


def test_what_cannot_be_baked_is_refused_before_anything_is_rendered():
    scene = Scene()
    for rigs, options, message in [
        ([], {}, "give at least one rig"),
        (["lamp", RIGS[0]], {}, "must be a Rig"),
        (RIGS, {"seed": -1}, "seed must be a whole number"),
    ]:
        with pytest.raises(el.EnvLightsError, match=message):
            el.bake(scene, rigs, **options)
    assert scene.asked == []
