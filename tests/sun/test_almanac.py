"""The sun from time and place, against a full solar position algorithm and closed forms."""

import datetime
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from envlights import EnvLightsError
from envlights.sun.almanac import SunAt, _equatorial

UTC = datetime.timezone.utc
#: Time, latitude, longitude, true elevation, apparent elevation and bearing in degrees, by the
#: solar position algorithm of NREL (Reda and Andreas 2004) in pvlib 0.16.1.
STORED = [
    ("2037-03-31T07:50:31", 51.638, 99.247, 34.106, 34.1308, 224.8622),
    ("2021-04-03T19:20:34", -35.723, -71.94, 35.7646, 35.788, 311.8123),
    ("2004-04-03T00:52:51", -64.316, 115.642, 10.4518, 10.5384, 52.8924),
    ("2033-09-05T06:28:30", 38.619, -11.543, 0.9788, 1.3432, 82.2451),
    ("2030-10-28T16:40:40", -28.805, -88.247, 69.7418, 69.748, 42.9184),
    ("2017-09-04T05:53:21", 15.883, 176.026, 7.096, 7.2179, 275.3952),
    ("1997-07-06T00:32:28", 62.237, 32.397, 0.5253, 0.939, 35.8019),
    ("2030-10-06T14:49:35", -63.145, 46.246, 3.9808, 4.1708, 266.158),
    ("2031-03-05T11:51:15", 1.835, -1.126, 80.0032, 80.0061, 141.8425),
    ("2020-05-05T20:43:36", 9.063, -127.634, 81.4959, 81.4984, 332.3594),
]
#: Degrees by which the short formula may differ.
TOLERANCE = 0.02

times = st.datetimes(
    datetime.datetime(1950, 1, 2), datetime.datetime(2050, 12, 30), timezones=st.just(UTC)
)
latitudes, longitudes = st.floats(-90, 90), st.floats(-180, 180)


@pytest.mark.parametrize("row", STORED, ids=[row[0] for row in STORED])
def test_position_is_that_of_a_full_algorithm(row):
    time, latitude, longitude, _, apparent, bearing = row
    sun = SunAt(datetime.datetime.fromisoformat(time).replace(tzinfo=UTC), latitude, longitude)
    assert math.degrees(sun.elevation) == pytest.approx(apparent, abs=TOLERANCE)
    off = (math.degrees(sun.from_north) - bearing + 180) % 360 - 180
    assert abs(off) * math.cos(sun.elevation) < TOLERANCE


@pytest.mark.parametrize("days", np.linspace(-18000, 18000, 37))
def test_the_place_among_the_stars_follows_from_the_equation_of_kepler(days):
    # Mean elements of the Astronomical Almanac; eccentricity of the orbit in the year 2000.
    mean, eccentricity = math.radians(357.528 + 0.9856003 * days), 0.016709
    anomaly = mean
    for _ in range(20):
        anomaly = mean + eccentricity * math.sin(anomaly)
    ratio = math.sqrt((1 + eccentricity) / (1 - eccentricity))
    true = mean + 2 * math.atan(ratio * math.tan(anomaly / 2)) - 2 * math.atan(math.tan(mean / 2))
    longitude = math.radians(280.460 + 0.9856474 * days) + true - mean
    tilt = math.radians(23.439 - 0.0000004 * days)
    wanted = [
        math.cos(longitude),
        math.cos(tilt) * math.sin(longitude),
        math.sin(tilt) * math.sin(longitude),
    ]
    ascension, declination = _equatorial(days)
    found = [
        math.cos(declination) * math.cos(ascension),
        math.cos(declination) * math.sin(ascension),
        math.sin(declination),
    ]
    # The formula leaves out the third harmonic, 0.0003 degrees, and rounds the others to 0.001.
    np.testing.assert_allclose(found, wanted, atol=math.radians(0.001))


@given(times, latitudes, longitudes)
def test_elevation_changes_by_at_most_a_quarter_degree_in_a_minute(time, lat, lon):
    later = SunAt(time + datetime.timedelta(minutes=1), lat, lon)
    sun = SunAt(time, lat, lon)
    # At -1 degrees the refraction of 0.7 degrees stops.
    assert abs(later.elevation - sun.elevation) < math.radians(0.25 + 0.72)
    assert abs(sun.elevation) <= math.pi / 2 + 1e-9


@given(times, st.floats(-180, 180), st.floats(0, 360))
def test_noon_stands_in_the_south_north_of_the_tropics(time, longitude, north):
    noon = time.replace(hour=12, minute=0, second=0) - datetime.timedelta(hours=longitude / 15)
    sun = SunAt(noon, 50.0, longitude, north)
    # The equation of time is at most 16.5 minutes, and the sun moves fast when it is high.
    assert abs(math.degrees(sun.from_north) - 180) < 4.2 / math.cos(sun.elevation) + 1
    assert sun.direction @ sun.direction == pytest.approx(1)
    assert math.asin(sun.direction[1]) == pytest.approx(sun.elevation)


def test_equal_moments_in_two_zones_give_equal_positions():
    noon = datetime.datetime(2024, 6, 21, 12, tzinfo=UTC)
    east = noon.astimezone(datetime.timezone(datetime.timedelta(hours=9)))
    assert SunAt(noon, 40, 10).elevation == SunAt(east, 40, 10).elevation


def test_east_lies_a_quarter_clockwise_of_north_in_the_map():
    """At the equinox the sun rises in the east; north at the middle, +z, puts east at -x."""
    sunrise = datetime.datetime(2024, 3, 20, 6, 10, tzinfo=UTC)
    sun = SunAt(sunrise, 0.0, 0.0, north=180.0)
    assert sun.direction @ [-1, 0, 0] > np.cos(np.radians(3))


def test_without_north_only_the_elevation_is_known():
    sun = SunAt(datetime.datetime(2024, 6, 21, 12, tzinfo=UTC), 51.48, 0.0)
    assert sun.direction is None
    assert sun.azimuth is None
    assert math.degrees(sun.elevation) == pytest.approx(90 - 51.48 + 23.44, abs=0.05)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((datetime.datetime(2024, 6, 21), 0, 0), "time zone"),
        (("2024-06-21", 0, 0), "time zone"),
        ((datetime.datetime(1850, 6, 21, tzinfo=UTC), 0, 0), "1850"),
        ((datetime.datetime(2024, 6, 21, tzinfo=UTC), 91, 0), "latitude"),
        ((datetime.datetime(2024, 6, 21, tzinfo=UTC), 0, math.nan), "longitude"),
        ((datetime.datetime(2024, 6, 21, tzinfo=UTC), 0, 0, 400), "north"),
    ],
)
def test_impossible_times_and_places_are_refused(arguments, words):
    with pytest.raises(EnvLightsError, match=words):
        SunAt(*arguments)
