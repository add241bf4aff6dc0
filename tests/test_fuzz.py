"""Damaged files of all kinds are opened or refused: nothing hangs, ends the process or prints."""

import sys

import pytest

from tests import fuzz
from tests.helpers import cases

FILES = {
    "images": cases(short=300, long=10_000),
    "models": cases(short=200, long=2000),
    "rigs": cases(short=200, long=2000),
}


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere memory is not limited so")
@pytest.mark.parametrize("kind", FILES)
def test_damaged_files_are_opened_or_refused(kind):
    counted, bad = fuzz.outcomes(kind, 0, FILES[kind])
    print(f"\n{FILES[kind]} damaged {kind}: {dict(counted)}")
    assert not bad
    assert counted["EnvLightsError"] > FILES[kind] / 4
