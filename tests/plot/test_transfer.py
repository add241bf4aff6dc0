"""The notebook's figure: its images and its errors."""

from functools import partial

import numpy as np
import pytest

import envlights as el
from envlights._common.srgb import encode_srgb
from envlights.plot import room_picture, transfer_picture
from tests.helpers import oblong, pairs_of_room, relative_errors

room = partial(pairs_of_room, 40, 32)


def frame():
    return room().direct[35], room().indirect[35]


@pytest.fixture(scope="module")
def model():
    return el.TransferModel.fit(room().direct[:32], room().indirect[:32], rank=16)


def panels(figure):
    """Titles and drawn values of the images, without their colour bars."""
    drawn = [axes for axes in figure.axes if axes.images and "direct" not in axes.get_title()]
    return [axes.get_title() for axes in drawn], [axes.images[0].get_array() for axes in drawn]


def test_titles_tell_the_relative_errors(model):
    titles, _ = panels(transfer_picture(model, *frame()))
    truth = frame()[1][None].astype(float)
    predicted, projected = (
        100 * relative_errors(image[None], truth)[0]
        for image in (model.predict(frame()[0]), model.project(frame()[1]))
    )
    assert titles == [
        "reference",
        f"transfer: {predicted:.3g} %",
        f"projection: {projected:.3g} %",
        "transfer minus reference",
    ]
    assert projected < predicted


def test_images_have_one_exposure_and_the_difference_is_signed(model):
    _, images = panels(transfer_picture(model, *frame()))
    predicted = model.predict(frame()[0])
    white = np.percentile(frame()[1], 99)
    for drawn, truth in zip(
        images, (frame()[1], predicted, model.project(frame()[1])), strict=False
    ):
        # sRGB is 13 times as steep as linear light near black: 13 times the rounding of float32.
        np.testing.assert_allclose(drawn, encode_srgb(truth / white), atol=1e-5)
    wanted, found = (image @ [0.2126, 0.7152, 0.0722] for image in (frame()[1], predicted))
    percent = 100 * (found - wanted) / wanted[model.lit].mean()
    np.testing.assert_allclose(images[3][model.lit], percent[model.lit], atol=1e-3)
    np.testing.assert_array_equal(images[3].mask, ~model.lit)


def test_frames_stand_one_below_the_other(model):
    figure = transfer_picture(model, room().direct[32:35], room().indirect[32:35])
    titles, images = panels(figure)
    assert titles.count("reference") == 3
    for row in range(3):
        alone = panels(transfer_picture(model, room().direct[32 + row], room().indirect[32 + row]))
        assert titles[4 * row : 4 * row + 4] == alone[0]
        np.testing.assert_allclose(images[4 * row + 1], alone[1][1], atol=1e-5)


def test_oblong_images_are_not_turned_and_the_notebooks_projection_is_its_own():
    direct, indirect = oblong()
    other = el.TransferModel.fit(direct, indirect, rank=8, notebook=True)
    titles, images = panels(transfer_picture(other, direct[0], indirect[0]))
    assert [image.shape[:2] for image in images] == [(7, 11)] * 4
    norm = np.linalg.norm(direct[0])
    projected = norm * other.project(indirect[0] / norm)
    assert (
        titles[2] == f"projection: {100 * relative_errors(projected[None], indirect[:1])[0]:.3g} %"
    )


def test_darkness_is_drawn(model):
    titles, _ = panels(transfer_picture(model, 0 * frame()[0], 0 * frame()[1]))
    assert titles[1:3] == ["transfer: reference is black", "projection: reference is black"]


def test_frames_that_do_not_fit_are_refused(model):
    direct, indirect = frame()
    for pair, message in [
        ((direct, indirect[:8]), "indirect must be 32x32 pixels"),
        ((direct[:8], indirect), "direct must be 16x16 pixels"),
        ((room().direct[:2], room().indirect[:3]), "the same number of images; got 2 and 3"),
        ((direct, np.nan * indirect), "indirect must be finite"),
    ]:
        with pytest.raises(el.EnvLightsError, match=message):
            transfer_picture(model, *pair)


def test_the_direct_light_stands_first(model):
    first = transfer_picture(model, *frame()).axes[0]
    assert first.get_title() == "direct: 16x16 texels"
    white = np.percentile(frame()[0], 99)
    drawn = first.images[0].get_array()
    np.testing.assert_allclose(drawn, encode_srgb(frame()[0] / white), atol=1e-5)


def test_the_lightmap_hangs_where_the_room_has_it():
    """Each face that looks to the eye is drawn once, in the texels of its part."""
    lightmap = np.zeros((16, 16, 3))
    lightmap[:4, 8:12] = [0.2, 0.9, 0.1]  # the third part, C: the floor
    figure = room_picture(room().direct[0], lightmap)
    *_, view = figure.axes
    letters = {text.get_text(): text.get_position() for text in view.texts}
    assert set("ACE") <= set(letters)
    assert not set("BDF") & set(letters)
    assert {each.get_text() for each in figure.axes[1].texts} == set("ABCDEFGHIJKLMNOP")
    faces = dict(zip([text.get_text() for text in view.texts], view.collections, strict=True))
    for letter, face in faces.items():
        assert (face.get_array().reshape(-1, 3).max() > 0) == (letter == "C")
    bottom = {letter: face.get_datalim(view.transData).ymin for letter, face in faces.items()}
    assert min(bottom.values()) == bottom["C"]


@pytest.mark.parametrize("image", [np.ones((8, 9, 3)), np.ones((8, 8)), np.ones((6, 6, 3))])
def test_images_of_another_room_are_refused(image):
    with pytest.raises(el.EnvLightsError, match="indirect must have"):
        room_picture(room().direct[0], image)
