"""Pictures with a known sun: 8-bit versions of HDR maps, and clear skies made by Mitsuba."""

import io
from dataclasses import dataclass

import numpy as np
from clipped_maps import quantile, reduce_width
from PIL import Image

import envlights as el
from envlights._common.srgb import encode_srgb
from envlights.kernels.image import LUMINANCE, blur
from envlights.kernels.sphere import pixel_directions, pixel_solid_angles

#: Columns of all pictures.
WIDTH = 1024

#: Curve, percentage of the sphere that is white, and quality of the JPEG.
TONES = (
    *(("clip", share, 95) for share in (0.2, 1, 5, 10)),
    *(("filmic", share, 85) for share in (0.2, 1, 5)),
)

#: Turbidity and elevation in degrees of the made skies.
SKIES = tuple((turbidity, elevation) for turbidity in (2.5, 5) for elevation in (10, 30, 50, 75))

#: Input of the filmic curve that becomes white.
_FILMIC_WHITE = 7.0


@dataclass(frozen=True)
class Truth:
    """Sun of an HDR map, in its luminance."""

    direction: np.ndarray
    flux: float
    """Irradiance at normal incidence of the sun alone."""
    sky: float = np.nan
    """Horizontal irradiance of the rest."""


@dataclass(frozen=True)
class Picture:
    """8-bit picture of a map, and its scale."""

    codes: np.ndarray
    scale: float
    """Factor of the radiance before the curve."""
    is_film: bool
    """True if the curve bends."""


def read(path):
    """Radiance of a map with at most `WIDTH` columns."""
    return reduce_width(el.EnvMap.open(path).radiance, WIDTH)


def truth_of(radiance):
    """Direction of the brightest place above the horizon, and the flux within 3 degrees of it."""
    luminance = radiance @ LUMINANCE
    directions = pixel_directions(*luminance.shape)
    solid_angles = pixel_solid_angles(*luminance.shape)
    up = np.where(directions[..., 1] > -0.03, luminance, 0).astype(np.float32)
    peak = directions[np.unravel_index(blur(up, 0.7).argmax(), up.shape)]
    for radius in (3.0, 2.0):
        near = directions @ peak > np.cos(np.radians(radius))
        weight = np.maximum(luminance - 0.02 * luminance[near].max(), 0) * solid_angles * near
        peak = (directions * weight[..., None]).sum(axis=(0, 1))
        peak /= np.linalg.norm(peak)
    angle = np.degrees(np.arccos(np.clip(directions @ peak, -1, 1)))
    ring = np.median(luminance[(angle > 3) & (angle < 5)])
    flux = ((luminance - ring) * solid_angles)[angle < 3].sum()
    up = np.maximum(directions[..., 1], 0) * solid_angles * (angle >= 3)
    return Truth(peak, float(flux), float((luminance * up).sum()))


def filmic(radiance):
    """Narkowicz's fit of the ACES curve."""
    x = radiance
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)


def picture(radiance, tone):
    """8-bit picture of a map in one of the `TONES`, as a JPEG holds it."""
    curve, share, quality = tone
    scale = 1 / quantile(radiance, 1 - share / 100)
    exposed = radiance * scale
    if curve == "filmic":
        scale *= _FILMIC_WHITE
        exposed = filmic(radiance * scale)
    codes = (encode_srgb(np.clip(exposed, 0, 1)) * 255 + 0.5).astype(np.uint8)
    file = io.BytesIO()
    Image.fromarray(codes).save(file, "jpeg", quality=quality)
    decoded = np.asarray(Image.open(io.BytesIO(file.getvalue())))
    return Picture(decoded, float(scale), curve == "filmic")


def made_sky(turbidity, elevation, azimuth=40.0):
    """Clear sky by Mitsuba's `sunsky` over grey ground, with the sun in one pixel, and its truth.

    The sun has 4 times the irradiance of the sky, the ground an albedo of 0.2; noise is 3 %.
    """
    height, columns = WIDTH // 2, WIDTH
    lift, turn = np.radians((elevation, azimuth))
    sun = np.array([np.sin(turn) * np.cos(lift), np.sin(lift), -np.cos(turn) * np.cos(lift)])
    # The middle of a pixel.
    row, column = el.kernels.uv_to_pixel(el.kernels.direction_to_uv(sun[None]), height, columns)[0]
    directions = pixel_directions(height, columns)
    sun = directions[row, column]
    channels = np.moveaxis(_sky(turbidity, sun), 2, 0)
    resize = el.kernels.resize_bilinear
    sky = np.stack([resize(each, height, columns, wrap=True) for each in channels], axis=2)
    solid_angles = pixel_solid_angles(height, columns)
    up = np.maximum(directions[..., 1], 0) * solid_angles
    sky[directions[..., 1] < 0] = 0
    of_sky = (sky * up[..., None]).sum(axis=(0, 1))
    flux = 4 * (of_sky @ LUMINANCE)
    ground = 0.2 / np.pi * (of_sky + flux * sun[1])
    sky[directions[..., 1] < 0] = ground
    sky *= np.random.default_rng(1).normal(1, 0.03, (height, columns, 1)).astype(np.float32)
    sky[row, column] += flux / solid_angles[row, column]
    return sky, Truth(sun, float(flux), float(of_sky @ LUMINANCE))


def _sky(turbidity, sun):
    """Sky without its sun, half as wide as the pictures."""
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    # The pole of `sunsky` is z.
    settings = {"turbidity": turbidity, "sun_scale": 0.0, "albedo": 0.2}
    towards = {"sun_direction": [sun[0], -sun[2], sun[1]]}
    emitter = mi.load_dict({"type": "sunsky", **settings, **towards})
    directions = pixel_directions(WIDTH // 4, WIDTH // 2)
    sky = np.zeros((WIDTH // 4, WIDTH // 2, 3), np.float32)
    interaction = mi.SurfaceInteraction3f()
    for row in range(WIDTH // 8):
        for column in range(WIDTH // 2):
            x, y, z = directions[row, column]
            interaction.wi = mi.ScalarVector3f(-x, z, -y)
            sky[row, column] = emitter.eval(interaction)
    # The row below the horizon, for interpolation.
    sky[WIDTH // 8] = sky[WIDTH // 8 - 1]
    return sky
