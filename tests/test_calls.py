"""Public functions return a result or raise `EnvLightsError`, for any arguments."""

import collections
import inspect
import signal
import sys

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import envlights as el
from envlights import (
    batches,
    cards,
    comparison,
    detection,
    export,
    fitting,
    frames,
    kernels,
    papers,
    placing,
    rigs,
    scene,
    sequence,
    splitting,
    sun,
    transfer,
    viewer,
)
from tests.call_values import STRANGE
from tests.calls import CALLS
from tests.helpers import cases, limited_memory

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="elsewhere neither memory nor time is limited so"
)

EXAMPLES = cases(short=12, long=330)
#: No call of this size takes that long: of the processor, and asleep on a machine that others use.
SECONDS, SECONDS_ASLEEP = 20, 200
#: Beside what the process has: what asks for more is refused.
BYTES = 2**31

#: Public functions and classes that are not in the table, and why.
LEFT_OUT = {
    "Batch": "comes from batch",
    "BakedPairs": "comes from bake",
    "Comparison": "comes from compare",
    "DetectedLights": "comes from detect",
    "DetectionReport": "comes from detect",
    "DirectLight": "asks a scene of the caller's",
    "EnvLightsError": "is the refusal",
    "FileError": "is a refusal",
    "FilePairs": "comes from read_pairs",
    "FitReport": "comes from fit",
    "Camera": "is a part of a protocol",
    "Card": "comes from split",
    "CardSplit": "comes from split",
    "ErrorCurve": "comes from error_curve",
    "FolderComparison": "comes from compare_folders",
    "ImageErrors": "comes from image_errors",
    "LabelArrays": "comes from label_arrays",
    "LightSetDifference": "comes from compare_lights",
    "Light": "comes from lights",
    "Limit": "comes from limit",
    "Material": "is a part of a protocol",
    "MitsubaScene": "is Mitsuba's answer to a scene",
    "Note": "is a text",
    "PaperFit": "comes from papers.madsen.fit",
    "PhotographLight": "comes from detect_photograph",
    "PhotographLights": "comes from detect_photograph",
    "PlacedLight": "comes from place",
    "PointErrors": "comes from PlacedLights.compare",
    "PROTOCOLS": "is a table",
    "Rendering": "comes from MitsubaScene.render",
    "Rig": "comes from fit",
    "RigStream": "comes from follow",
    "Split": "comes from split",
    "Sun": "comes from find_sun",
    "SunSplit": "comes from with_sun",
    "StopReason": "is an enumeration",
    "Surface": "comes from a scene",
    "RemovedLights": "comes from split",
    "ShadowOverlay": "comes from shadow_overlay",
    "Variation": "comes from vary",
    "View": "comes from view",
    "TransferPrior": "comes from MitsubaScene.gather",
    "TransferReport": "comes from TransferModel.fit",
    "bake": "renders, by Mitsuba",
    "gather": "asks a scene of the caller's",
    "export.add_to_blender": "needs Blender",
    "export.AXES": "is a table",
    "frames.Axes": "is a row of it",
    "frames.FRAMES": "is a table",
    "export.Axes": "is a row of it",
    "export.TARGETS": "is a table",
    "export.Target": "is a row of it",
    "kernels.WORKING_COLUMNS": "is a number",
    "kernels.gloss": "holds functions, which are called by their own names",
    "threads": "changes the threads of the process",
}


def test_no_public_function_is_missing():
    names = [name for name in el.__all__ if not inspect.ismodule(getattr(el, name))]
    for part in (comparison, detection, fitting, papers, placing, rigs, scene, splitting, sun):
        names += [name for name in part.__all__ if not inspect.ismodule(getattr(part, name))]
    for part in (batches, cards, transfer, viewer):
        names += part.__all__
    names += [name for name in sequence.__all__ if not name.islower()]
    for part in (export, frames, kernels):
        names += [f"{part.__name__.split('.')[-1]}.{name}" for name in part.__all__]
    there = {name.split(" ")[0] for name in CALLS}
    # A class may be there by its methods.
    there |= {name.split(".")[0] for name in there}
    assert set(names) - there - set(LEFT_OUT) == set(), "add these to tests/calls.py"
    assert set(LEFT_OUT) - set(names) == set(), "these are not public any more"


@st.composite
def arguments(draw, strategies):
    """Arguments that a function takes; in every second call one of them is strange."""
    drawn = {name: draw(strategy) for name, strategy in strategies.items()}
    if draw(st.booleans()):
        drawn[draw(st.sampled_from(sorted(drawn)))] = draw(STRANGE)
    return drawn


@pytest.fixture(scope="module")
def outcomes():
    """Count of each outcome of the calls, printed at the end."""
    counted = collections.Counter()
    before = {each: signal.signal(each, give_up) for each in (signal.SIGALRM, signal.SIGPROF)}
    with limited_memory(BYTES):
        yield counted
    for each, handler in before.items():
        signal.signal(each, handler)
    print(f"\n{counted.total()} generated calls: {dict(counted)}")


def watch(busy, asleep):
    """Let `give_up` be called after that many seconds; 0 ends the watch."""
    signal.setitimer(signal.ITIMER_PROF, busy)
    signal.setitimer(signal.ITIMER_REAL, asleep)


def give_up(number, _):
    """Fail the call that takes too long: kernels look for signals."""
    seconds = SECONDS if number == signal.SIGPROF else SECONDS_ASLEEP
    pytest.fail(f"no answer for {seconds} seconds")


@pytest.mark.parametrize("name", CALLS)
def test_calls_answer_or_refuse(name, outcomes, capfd, tmp_path, monkeypatch):
    function, strategies = CALLS[name]
    monkeypatch.chdir(tmp_path)  # a strange path may be that of a file here

    @settings(max_examples=EXAMPLES, suppress_health_check=list(HealthCheck))
    @given(drawn=arguments(strategies))
    def answers_or_refuses(drawn):
        watch(SECONDS, SECONDS_ASLEEP)
        try:
            check_answer(function(**drawn))
            outcomes["answer"] += 1
        except (el.EnvLightsError, MemoryError) as refusal:
            outcomes[type(refusal).__name__] += 1
        finally:
            watch(0, 0)

    answers_or_refuses()
    assert capfd.readouterr().err == ""


def check_answer(answer):
    """No number of an answer is NaN."""
    for part in answer if isinstance(answer, tuple) else (answer,):
        if isinstance(part, np.ndarray | float) and np.asarray(part).dtype.kind == "f":
            assert not np.isnan(part).any()
    assert isinstance(repr(answer), str)
