"""A small hall, by counts: what it takes in time is measured by scripts/load.py."""

import asyncio
import os
import sys
from pathlib import Path

import pytest

from beamviz.explorer.app import explorer
from beamviz.scene import Scene

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))

from load import START, Guest, hall

VISITORS, SECONDS = 12, 4.0


@pytest.fixture(scope="module")
def visit() -> tuple[list[Guest], dict[str, float]]:
    """Twelve visitors who drag for a while, and the rows of the script."""
    guests = [Guest() for _ in range(VISITORS)]
    with explorer(Scene(START)) as url:
        rows = asyncio.run(hall(url, guests, SECONDS, os.getpid()))
    return guests, {key: value for key, value, _ in rows}


def test_nobody_in_the_hall_is_left_out(visit):
    """Everybody gets pictures, and answers to what they asked for."""
    guests, _ = visit
    assert min(guest.frames for guest in guests) > 0
    assert min(guest.solved for guest in guests) > 0


def test_frames_are_shared_evenly(visit):
    """However slow the machine: nobody gets half of what another one gets."""
    guests, _ = visit
    frames = sorted(guest.frames for guest in guests)
    assert frames[-1] <= 2 * frames[0] + 4


def test_edits_are_not_queued(visit):
    """The latest wins: of the edits sent while the solver was busy, most are never solved."""
    guests, _ = visit
    sent = VISITORS * SECONDS / guests[0].pace
    assert sum(guest.solved for guest in guests) < sent


def test_the_rows_of_the_script_are_complete(visit):
    """Each figure of the script is there and makes sense."""
    _, rows = visit
    assert rows["visitors"] == VISITORS
    assert 0 < rows["fewest frames"] <= rows["median frames"] <= rows["most frames"]
    assert 0 < rows["every edit to update, median"] <= rows["every edit to update, 95 %"]
    assert rows["server CPU"] > 0
    assert rows["memory"] > 0
