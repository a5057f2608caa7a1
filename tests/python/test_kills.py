"""Commands that are ended at random moments leave whole files, all old or all new, and no program behind."""

import sys

import pytest

from kills import campaign

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")


def strike(command, folder, moments):
    tally = campaign(command, folder, moments)
    assert tally.faults() == []
    # A kill between two names, microseconds apart, is rare.
    assert len(tally.between_names) <= 1 + moments // 250
    # Else nothing was stopped.
    assert tally.before_the_end > moments / 3
    assert tally.moments == moments


def test_twenty_moments_leave_nothing_torn_mixed_or_running(command, tmp_path):
    strike(command, tmp_path, 21)


@pytest.mark.slow
def test_five_hundred_moments_leave_nothing_torn_mixed_or_running(command, tmp_path):
    strike(command, tmp_path, 504)
