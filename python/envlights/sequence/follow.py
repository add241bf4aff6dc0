"""Rigs for the frames of a sequence, whose lights keep their identity."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator

from envlights._common.check import check_choice, check_progress, count, named_arguments
from envlights._common.progress import progress_bar
from envlights._native import EnvLightsError
from envlights.environment.fill import Fill
from envlights.environment.reading import AnyMap, Reading
from envlights.fitting.map_fit import check_arguments
from envlights.fitting.request import AMBIENTS, MOST_LIGHTS, FitArguments
from envlights.rigs.report import SHOWN_ROUGHNESS
from envlights.sequence.continuation import Continuation
from envlights.sequence.frame_rig import FrameRig
from envlights.sequence.frames import AnyFrames, Frames, enumerate_maps, read_frames
from envlights.sequence.identity import Identities
from envlights.sequence.rig_sequence import RigSequence
from envlights.sequence.steadiness import frame_rate, window_frames
from envlights.sequence.window import FrameFit, average


class RigStream(Iterator[FrameRig]):
    """Iterator of rigs, each available as soon as its window is complete."""

    def __init__(
        self, frames: Frames, arguments: FitArguments, steadiness: int, fps: float | None
    ) -> None:
        self._frames, self._rigs = frames, _rigs(frames.maps, arguments, steadiness)
        self.steadiness = steadiness
        """Half-width of the window in frames, which is also the delay of a rig after its map."""
        self.fps = fps
        """Frames per second, or None."""

    def __next__(self) -> FrameRig:
        return next(self._rigs)

    def __repr__(self) -> str:
        return f"<RigStream: {self._frames.number or 'any number of'} frames; not in memory>"

    def sequence(self, *, progress: bool | None = None) -> RigSequence:
        """All remaining rigs, in memory.

        Parameters
        ----------
        progress : bool, optional
            Show a progress bar. Default: in a terminal or a notebook, after a second.
        """
        check_progress(progress)
        rigs = progress_bar(self, "rigs", "frame", progress, total=self._frames.number)
        return RigSequence(tuple(rigs), steadiness=self.steadiness, fps=self.fps)


@named_arguments()
def follow(
    frames: AnyFrames,
    lights: int | None = 4,
    *,
    steadiness: int | str = 3,
    fps: float | None = None,
    error: float | None = None,
    sizes: bool = True,
    max_radius: float | None = None,
    objective: str = "mixed",
    ambient: str = "constant",
    floor: bool = False,
    fill: Fill = None,
    reading: Reading | None = None,
) -> RigStream:
    """Fit a rig to each frame of a sequence of maps; each light keeps its identity.

    The fit of a frame continues that of the last one: lights start where they are expected from
    their motion. A full search runs for the first frame, if the error grows by a tenth over the
    level of the last search, at a step of the light, and every 24 frames. Its lights are taken if
    they lower the error by 5 %. The rig of a frame is the mean over a window around it, so new
    lights are faded in.

    Parameters
    ----------
    frames : str, path-like, array_like or iterable of maps
        A pattern such as ``"frames/*.exr"`` or a folder, in natural order; a video (with the extra
        ``video``); an array of the shape (frames, height, 2 * height, 3); or anything that yields
        maps as `fit` takes them, which is read as the rigs are needed.
    lights : int or None
        Largest number of lights of a fit. While lights are exchanged, a rig has those before and
        those after. None, with `error`: up to 32.
    steadiness : int or str
        Half-width of the window: frames, or seconds such as ``"0.2 s"``, which need `fps`. The mean
        is over the frames from ``-steadiness`` to ``steadiness``, weighted by a raised cosine.
        Larger values remove more noise and fade more slowly. The lag: a stream yields a rig
        `steadiness` frames after its map. Motion and changes at constant speed are not delayed,
        because the window is symmetric; it is shorter at the ends and at steps of the light. 0:
        the fits themselves.
    fps : float, optional
        Frames in a second, for times in files. Default: that of a video.
    error : float, optional
        Largest accepted relative RMS error; the fits have the fewest lights that reach it. A search
        for another number must reach 90 % of it, and one for fewer runs below 50 %.
    sizes, max_radius, objective, ambient, floor, fill
        As in `fit`.
    reading : mapping, optional
        Options on how the frames are read, as of `batch`.

    Returns
    -------
    RigStream
        Iterator of `FrameRig`. ``sequence()`` holds all in memory, with measurements and files.

    Raises
    ------
    EnvLightsError
        If there is no frame, or an argument is wrong; while it runs, if a frame is not a map.

    See Also
    --------
    fit : rig of one map.

    Notes
    -----
    A step of the light is a change of the irradiance by more than 1 % and more than 5 times the
    median change of the last 12 frames, as of a lamp that is switched; the same holds for what
    remains of the change at the best scale of each channel, which flicker of the exposure does not
    hide. The window does not reach across it, so the rig changes in the same frame as the scene.

    Lights are paired with those of earlier frames by the least sum of costs: the angle to the
    expected direction over 5 degrees, and the logarithm of the ratio of the fluxes to the base 4.

    Examples
    --------
    A lamp that moves by 2 degrees in each frame:

    >>> import numpy as np
    >>> import envlights as el
    >>> angles = np.deg2rad([40, 42, 44])
    >>> lamps = [el.Lights([[np.sin(a), 0, np.cos(a)]], [[2, 2, 2]], [0.1]) for a in angles]
    >>> stream = el.follow((lamp.to_map(64) for lamp in lamps), lights=1)
    >>> for rig in stream:
    ...     print(rig.frame, rig.ids, np.rad2deg(np.arcsin(rig.lights.direction[0, 0])).round(1))
    0 (0,) 40.0
    1 (0,) 42.0
    2 (0,) 44.0
    """
    rate = frame_rate(fps)
    found = read_frames(frames, reading, fill)
    rate = found.fps if rate is None else rate
    half = window_frames(steadiness, rate)
    if lights is None and error is None:
        raise EnvLightsError("lights must be a whole number, 0 or more, without an error; got None")
    most = MOST_LIGHTS if lights is None else count("lights", lights)
    arguments = FitArguments(
        lights=most,
        error=error,
        shadow_error=None,
        gloss_error=None,
        roughness=SHOWN_ROUGHNESS,
        sizes=sizes,
        max_radius=max_radius,
        objective=objective,
        ambient=ambient,
        start="greedy",
        fixed=None,
        floor=floor,
        fill=fill,
        target=None,
    )
    # Rigs with different kinds of ambient term cannot be averaged.
    check_choice("ambient", ambient, tuple(AMBIENTS))
    check_arguments(arguments)
    return RigStream(found, arguments, half, rate)


def _rigs(maps: Iterable[AnyMap], arguments: FitArguments, steadiness: int) -> Iterator[FrameRig]:
    window: deque[FrameFit] = deque()
    middle = 0
    for fit in _fits(maps, arguments):
        if fit.is_step:
            yield from _until_the_end(window, middle)
            window.clear()
            middle = 0
        window.append(fit)
        if len(window) <= middle + steadiness:
            continue
        yield _mean(window, middle, steadiness)
        if middle < steadiness:
            middle += 1
        else:
            window.popleft()
    yield from _until_the_end(window, middle)


def _until_the_end(window: deque[FrameFit], middle: int) -> Iterator[FrameRig]:
    """Means for the frames from `middle` on, with windows that shrink at the end."""
    for frame in range(middle, len(window)):
        yield _mean(window, frame, len(window) - 1 - frame)


def _mean(window: deque[FrameFit], middle: int, most: int) -> FrameRig:
    """Mean over a symmetric window inside `window`, with a half-width of at most `most`."""
    half = min(most, middle)
    return average([window[row] for row in range(middle - half, middle + half + 1)])


def _fits(maps: Iterable[AnyMap], arguments: FitArguments) -> Iterator[FrameFit]:
    """Fits of the frames, with identities of their lights."""
    continuation, identities = Continuation(arguments), Identities()
    start, units = None, None
    for number, env in enumerate_maps(maps):
        try:
            fit = continuation.fit(env, start)
        except EnvLightsError as refusal:
            raise type(refusal)(f"frame {number}: {refusal}") from None
        units = units or fit.rig.units
        if fit.rig.units != units:
            raise EnvLightsError(
                f"all frames must have the same units; frame {number} has {fit.rig.units!r}, those"
                f" before it {units!r}. Calibrate all of them"
            )
        ids = identities.follow(fit.rig.lights)
        start = identities.next_lights()
        yield FrameFit(number, fit.rig, ids, fit.samples, fit.is_search, fit.is_step)
