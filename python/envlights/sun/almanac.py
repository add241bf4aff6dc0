"""Position of the sun from time and place, by the short formula of the Astronomical Almanac.

It is right to about 0.01 degrees from 1950 to 2050. Refraction follows Saemundsson (1986), for 10
degrees Celsius at sea level, as given by Meeus, *Astronomical Algorithms* (1998), equation 16.4.
"""

from __future__ import annotations

import datetime
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import amount
from envlights._common.result import Result
from envlights._native import EnvLightsError

#: Noon of 1 January 2000, from which the formula counts days.
_EPOCH = datetime.datetime(2000, 1, 1, 12, tzinfo=datetime.timezone.utc)
#: Range of years in which the formula is accurate to 0.01 degrees.
_FIRST_YEAR, _LAST_YEAR = 1950, 2050
#: Elevation in degrees below which refraction is ignored, because the sun has set.
_SET = -1.0


@dataclass(frozen=True, eq=False, repr=False)
class SunAt(Result):
    """Position of the sun at a time and place.

    Parameters
    ----------
    time : datetime.datetime
        With its time zone, from 1950 to 2050.
    latitude, longitude : float
        Degrees; north and east are positive.
    north : float, optional
        Azimuth of north in the map, in degrees, as `print` shows azimuths of lights: 0 at the left
        edge, 180 in the middle. Without it only the elevation of the sun is known.

    Raises
    ------
    EnvLightsError
        If the time has no zone or lies outside the years of the formula, or an angle is out of
        range.

    Notes
    -----
    Low-precision formula of the *Astronomical Almanac*, page C5, with the refraction of Saemundsson
    (1986). It differs from a full solar position algorithm by at most 0.02 degrees.

    Examples
    --------
    >>> import datetime, envlights as el
    >>> noon = datetime.datetime(2024, 6, 21, 12, tzinfo=datetime.timezone.utc)
    >>> el.sun.SunAt(noon, latitude=51.48, longitude=0.0)
    <SunAt: elevation 62.0°, 179° from north>
    >>> el.sun.SunAt(noon, 51.48, 0.0, north=90).direction.round(2)
    array([-0.47,  0.88,  0.01])
    """

    time: datetime.datetime
    latitude: float
    longitude: float
    north: float | None = None

    def __post_init__(self) -> None:
        _check_time(self.time)
        amount("latitude", self.latitude, -90, 90)
        amount("longitude", self.longitude, -180, 180)
        if self.north is not None:
            amount("north", self.north, -360, 360)

    @property
    def elevation(self) -> float:
        """Apparent elevation in radians, with refraction; negative at night."""
        true, _ = self._true_position()
        return true + _refraction(true)

    @property
    def from_north(self) -> float:
        """Compass bearing in radians, clockwise from north over east."""
        return self._true_position()[1]

    @property
    def azimuth(self) -> float | None:
        """Azimuth in the map in radians, as in `Lights`; None without `north`."""
        if self.north is None:
            return None
        return (math.radians(self.north) + self.from_north) % (2 * math.pi)

    @property
    def direction(self) -> NDArray[np.float64] | None:
        """Unit vector to the sun in the frame of the map, (3,); None without `north`."""
        if self.azimuth is None:
            return None
        flat = math.cos(self.elevation)
        x, z = flat * math.sin(self.azimuth), -flat * math.cos(self.azimuth)
        return np.array([x, math.sin(self.elevation), z])

    def _true_position(self) -> tuple[float, float]:
        """Elevation without refraction, and bearing from north, in radians."""
        days = (self.time - _EPOCH) / datetime.timedelta(days=1)
        ascension, declination = _equatorial(days)
        sidereal = math.radians(280.46062 + 360.98564737 * days + self.longitude)
        return _horizontal(math.radians(self.latitude), declination, sidereal - ascension)

    def in_short(self) -> str:
        """Elevation and bearing in degrees."""
        elevation, bearing = math.degrees(self.elevation), math.degrees(self.from_north)
        return f"elevation {elevation:.1f}°, {bearing:.0f}° from north"

    def __str__(self) -> str:
        place = f"latitude {self.latitude:g}°, longitude {self.longitude:g}°"
        north = "" if self.north is None else f", north at azimuth {self.north:g}° of the map"
        return f"sun at {self.in_short()}\n{self.time.isoformat()}, {place}{north}"


def _equatorial(days: float) -> tuple[float, float]:
    """Right ascension and declination of the sun in radians, `days` after the epoch."""
    mean_longitude = 280.460 + 0.9856474 * days
    anomaly = math.radians(357.528 + 0.9856003 * days)
    centre = 1.915 * math.sin(anomaly) + 0.020 * math.sin(2 * anomaly)
    longitude = math.radians(mean_longitude + centre)
    obliquity = math.radians(23.439 - 0.0000004 * days)
    across = math.cos(obliquity) * math.sin(longitude)
    declination = math.asin(math.sin(obliquity) * math.sin(longitude))
    return math.atan2(across, math.cos(longitude)), declination


def _horizontal(latitude: float, declination: float, hour_angle: float) -> tuple[float, float]:
    """Elevation and bearing from north over east, in radians."""
    up = math.sin(latitude) * math.sin(declination)
    up += math.cos(latitude) * math.cos(declination) * math.cos(hour_angle)
    north = math.cos(latitude) * math.sin(declination)
    north -= math.sin(latitude) * math.cos(declination) * math.cos(hour_angle)
    east = -math.cos(declination) * math.sin(hour_angle)
    return math.atan2(up, math.hypot(north, east)), math.atan2(east, north) % (2 * math.pi)


def _refraction(elevation: float) -> float:
    """Angle in radians by which refraction raises a body at this true elevation."""
    degrees = math.degrees(elevation)
    if degrees < _SET:
        return 0.0
    minutes = 1.02 / math.tan(math.radians(degrees + 10.3 / (degrees + 5.11)))
    return math.radians(minutes / 60)


def _check_time(time: object) -> None:
    if not isinstance(time, datetime.datetime) or time.tzinfo is None:
        raise EnvLightsError(
            "time must be a datetime with a time zone, for example "
            f"datetime(2024, 6, 21, 12, tzinfo=timezone.utc); got {time!r}"
        )
    if not _FIRST_YEAR <= time.year <= _LAST_YEAR:
        raise EnvLightsError(
            f"time must lie from {_FIRST_YEAR} to {_LAST_YEAR}, for which the position of the sun "
            f"is right to 0.01 degrees; got the year {time.year}"
        )
