"""The legend of the forces in the scene, and the bar of the energies in a motion in time."""

import re

import numpy as np
import pytest

from beamviz import Beam, Scene, motion
from beamviz.explorer.features.forces import AT_REST, NO_SOFTENING, NO_STIFFENING, energies_of

FIRST = Scene.of(Beam(alpha=1, beta=0.5, gamma=5), mode=1)
ROWS, BAR = "forces-rows", "energy-bar"


def test_the_legend_names_what_is_drawn_and_what_the_model_leaves_out(guest):
    """Nothing before the switch; a term switched off has no row; at rest it says so."""
    assert guest.texts[ROWS] == ""
    guest.do("forces", value=True)
    guest.wait(lambda _: "pull aside" in guest.texts[ROWS])
    assert "tension" in guest.texts[ROWS]
    assert "Coriolis" not in guest.texts[ROWS]
    assert guest.texts[BAR] == ""
    guest.do("coriolis", value=True)
    guest.wait(lambda _: "Coriolis" in guest.texts[ROWS])
    guest.do("softening", value=False)
    guest.wait(lambda _: NO_SOFTENING in guest.texts[ROWS])
    assert "<b>pull aside" not in guest.texts[ROWS]
    guest.do("stiffening", value=False)
    guest.wait(lambda _: NO_STIFFENING in guest.texts[ROWS])
    assert "<b>tension" not in guest.texts[ROWS]
    guest.do("gamma", 0.0, until=AT_REST)
    guest.do("forces", value=False)
    guest.wait(lambda _: guest.texts[ROWS] == "")


def test_a_beam_that_points_inward_is_pressed(guest):
    guest.do("link", "?gamma=2&delta=-1&forces=true")
    guest.wait(lambda _: "<b>compression" in guest.texts[ROWS])
    assert "<b>tension" not in guest.texts[ROWS]
    guest.do("delta", -0.6)
    guest.wait(
        lambda _: "<b>tension" in guest.texts[ROWS] and "<b>compression" in guest.texts[ROWS]
    )


def test_a_real_beam_has_its_forces_in_newtons(guest):
    guest.do(
        "link",
        "?length=1.0&mass_per_length=2.0&bending_stiffness=100.0&axial_stiffness=1e6&rotation_speed=10.0&forces=true",
    )
    # rho A Omega^2 L^2 / 2 of a beam that is hardly stretched
    guest.wait(lambda _: "≤ 100 N" in guest.texts[ROWS])


def test_the_energies_of_a_motion_keep_their_sum_as_the_bar_shows(guest, session):
    """Without damping, at a constant speed; with it the bar gets shorter."""
    guest.do("link", "?gamma=5&alpha=1&forces=true&moving=true&motion={damping=0.0,until=4.0}")
    guest.wait(lambda _: "kinetic" in guest.texts[BAR])
    guest.do("moment", 1.7)
    guest.wait(lambda _: session.visitor.clock.moment == 1.7)
    guest.wait(lambda _: re.search("as at the start|[+−]0.0", guest.texts[BAR]))
    parts = re.findall(r"width:([\d.]+)%", guest.texts[BAR])
    assert len(parts) == 3
    assert sum(map(float, parts)) == pytest.approx(100, abs=0.5)
    guest.do("motion.damping", 5.0)
    guest.wait(lambda _: re.search("−[1-9].* since the start", guest.texts[BAR]))


def test_the_bar_begins_with_nothing_but_the_work_of_the_pull():
    """Of a beam released from rest; no part is ever below 0, and the sum stays."""
    kinetic, strain, centrifugal = parts = energies_of(
        motion(Beam(alpha=1, gamma=3), 2.0, release=1.0)
    )
    assert kinetic[0] == pytest.approx(0, abs=1e-9)
    assert strain[0] > 0.01
    assert centrifugal[0] > 0.01
    assert parts.min() > -1e-9
    total = parts.sum(axis=0)
    assert np.ptp(total) < 1e-3 * total[0]


def test_colours_of_the_strain_of_a_known_material_tell_its_stress_and_yield(guest):
    """Of a slow steel bar, and of a fast one with rho Omega^2 L^2 / 2 = 628 MPa at its root."""
    steel = "youngs_modulus=210e9&density=7850&area=5e-4&second_moment=4.2e-9&yield_stress=250e6"
    link = f"?length=1.0&{steel}&colouring=axial strain&amplitude=0&rotation_speed="
    guest.do("link", f"{link}100")
    guest.wait(lambda _: "axial stress ± 39 MPa, yields at 250 MPa" in guest.texts["legend"])
    guest.do("link", f"{link}400")
    guest.wait(lambda _: "axial stress ± 630 MPa: yields" in guest.texts["legend"])
    assert 'class="stress yields"' in guest.texts["legend"]
