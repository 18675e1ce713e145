"""Modes of two solutions matched by their shapes."""

import pytest

from beamviz.beam import Beam
from beamviz.frequency_loci import match_modes
from beamviz.solver import solve

TIP = Beam(alpha=1, beta=1)


def test_a_solution_matches_itself():
    """Modes of one beam are orthonormal: MAC 1 on the diagonal, 0 elsewhere."""
    solution = solve(TIP.replace(gamma=3), modes=6)
    partner, mac = match_modes(solution, solution)
    assert partner.tolist() == list(range(6))
    assert mac == pytest.approx(mac.round(), abs=1e-9)


def test_modes_that_change_places_are_matched_by_shape():
    """alpha 1 to 2 at the tip: S1 is fourth, then third; a mode beyond those solved has none."""
    one, two = solve(TIP), solve(TIP.replace(alpha=2), modes=4)
    partner = match_modes(one, two).partner
    assert [two.labels[k] for k in partner[:4]] == list(one.labels[:4])
    assert partner[4] == -1


def test_at_a_veering_two_modes_share_two_shapes():
    """Coriolis on, gamma 4.65: S1 and B3 are mixed about 50:50; every mode has a partner."""
    beam = TIP.replace(gamma=4.65)
    mixed, plain = solve(beam, coriolis=True), solve(beam)
    partner, mac = match_modes(mixed, plain)
    assert partner.tolist() == list(range(5))
    assert mac[2:4, 2:4] == pytest.approx(0.5, abs=0.05)
    assert plain.frequencies[partner] == pytest.approx(mixed.frequencies, rel=0.02)
