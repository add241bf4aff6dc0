"""Calls of the functions on suns, for the table in `calls.py`."""

import datetime

from hypothesis import strategies as st

import envlights as el
from envlights import synthetic
from tests.call_values import AXIS_OF_SURFACE, FLAG, IMAGE, SIZE, SMALL

TIMES = st.datetimes(
    datetime.datetime(1990, 1, 1),
    datetime.datetime(2040, 1, 1),
    timezones=st.just(datetime.timezone.utc),
)
SUN = el.sun.Sun("sun", direction=[0.48, 0.6, 0.64], irradiance=[40, 38, 34])
SUNS = st.sampled_from(["auto", (0.5, 0.7, 0.5), SUN])

SUN_CALLS = {
    "SunAt": (
        el.sun.SunAt,
        {
            "time": TIMES,
            "latitude": SMALL,
            "longitude": SMALL,
            "north": st.one_of(st.none(), SMALL),
        },
    ),
    "find_sun": (
        lambda env, elevation: el.find_sun(el.EnvMap(env, clip_level=0.9), elevation=elevation),
        {"env": IMAGE, "elevation": st.one_of(st.none(), st.floats(1, 90))},
    ),
    "find_sun with a known direction": (
        el.find_sun,
        {"env": IMAGE, "direction": st.sampled_from([(0, 1, 0), [0.6, 0.8, 0]])},
    ),
    "with_sun": (
        el.with_sun,
        {"env": IMAGE, "sun": SUNS, "irradiance": st.one_of(st.none(), st.floats(0, 1e6))},
    ),
    "with_sun by a ratio": (el.with_sun, {"env": IMAGE, "sun": SUNS, "ratio": SMALL}),
    "SunSplit.to_map": (
        lambda env, **options: el.with_sun(el.EnvMap(env, clip_level=0.9), **options).to_map(),
        {"env": IMAGE, "sun": SUNS, "irradiance": st.one_of(st.none(), SMALL)},
    ),
    "fit with a sun": (
        el.fit,
        {"env": IMAGE, "lights": st.integers(1, 3), "sun": SUNS, "floor": FLAG, "sizes": FLAG},
    ),
    "synthetic.clear_sky": (
        synthetic.clear_sky,
        {"height": SIZE, "sun": AXIS_OF_SURFACE, "ratio": SMALL},
    ),
}
