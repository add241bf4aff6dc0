"""The notebook's figure: what it shows and the errors that it tells."""

import numpy as np
import pytest

import envlights as el
from envlights._srgb import encode_srgb
from envlights.plot import transfer_picture
from tests.helpers import oblong, relative_errors

ROOM = el.synthetic.room(40, width=32)
FRAME = ROOM.direct[35], ROOM.indirect[35]


@pytest.fixture(scope="module")
def model():
    return el.TransferModel.fit(ROOM.direct[:32], ROOM.indirect[:32], rank=16)


def panels(figure):
    """Titles and drawn values of the images, without their colour bars."""
    drawn = [axes for axes in figure.axes if axes.images]
    return [axes.get_title() for axes in drawn], [axes.images[0].get_array() for axes in drawn]


def test_titles_tell_the_relative_errors(model):
    titles, _ = panels(transfer_picture(model, *FRAME))
    truth = FRAME[1][None].astype(float)
    predicted, projected = (
        100 * relative_errors(image[None], truth)[0]
        for image in (model.predict(FRAME[0]), model.project(FRAME[1]))
    )
    assert titles == [
        "reference",
        f"transfer: {predicted:.3g} %",
        f"projection: {projected:.3g} %",
        "transfer minus reference",
    ]
    assert projected < predicted


def test_images_have_one_exposure_and_the_difference_is_signed(model):
    _, images = panels(transfer_picture(model, *FRAME))
    predicted = model.predict(FRAME[0])
    white = np.percentile(FRAME[1], 99)
    for drawn, truth in zip(images, (FRAME[1], predicted, model.project(FRAME[1])), strict=False):
        # sRGB is 13 times as steep as linear light near black: 13 times the rounding of float32.
        np.testing.assert_allclose(drawn, encode_srgb(truth / white), atol=1e-5)
    wanted, found = (image @ [0.2126, 0.7152, 0.0722] for image in (FRAME[1], predicted))
    percent = 100 * (found - wanted) / wanted[model.lit].mean()
    np.testing.assert_allclose(images[3][model.lit], percent[model.lit], atol=1e-3)
    np.testing.assert_array_equal(images[3].mask, ~model.lit)


def test_frames_stand_one_below_the_other(model):
    figure = transfer_picture(model, ROOM.direct[32:35], ROOM.indirect[32:35])
    titles, images = panels(figure)
    assert titles.count("reference") == 3
    for row in range(3):
        alone = panels(transfer_picture(model, ROOM.direct[32 + row], ROOM.indirect[32 + row]))
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
    titles, _ = panels(transfer_picture(model, 0 * FRAME[0], 0 * FRAME[1]))
    assert titles[1:3] == ["transfer: of black", "projection: of black"]


def test_frames_that_do_not_fit_are_refused(model):
    direct, indirect = FRAME
    for pair, message in [
        ((direct, indirect[:8]), "indirect must be 32x32 pixels"),
        ((direct[:8], indirect), "direct must be 16x16 pixels"),
        ((ROOM.direct[:2], ROOM.indirect[:3]), "as many images; got 2 and 3"),
        ((direct, np.nan * indirect), "indirect must be finite"),
    ]:
        with pytest.raises(el.EnvLightsError, match=message):
            transfer_picture(model, *pair)
