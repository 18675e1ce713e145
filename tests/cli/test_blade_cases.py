"""Blades and beams on which programs fail: soft dips, light tips, hinges; against a Ritz solution
with Hermite cubics and graded bubbles."""

import json

import pytest

from beamviz.cli import main

DIP = """\
stations = [0, 0.27, 0.37, 0.47, 1]
mass_per_length = 1.0
bending_stiffness = [100, 100, 0.1, 100, 100]
axial_stiffness = 1e6
rotation_speed = 30
"""
DIP_FREQUENCIES = [3.034583334, 18.877321245, 53.008659974]
LIGHT_TIP = """\
stations = [
    0, 0.699912, 1.749948, 3.499895, 5.249842, 7.000122, 8.75007, 10.500018, 12.249965, 13.999912,
    15.74986, 17.50014, 19.250087, 21.000035, 22.749982, 24.49993, 26.249878, 28.000158, 29.750105,
    31.500053, 33.25,
]
mass_per_length = [
    1447.607, 180.333, 181.672, 183.905, 186.138, 188.37, 178.321, 168.271, 158.222, 148.172,
    138.123, 122.896, 107.669, 92.442, 77.215, 61.988, 51.861, 41.734, 31.607, 21.48, 11.353,
]
bending_stiffness = [
    7.68146e9, 1.16987e9, 1.09228e9, 9.6297e8, 8.3366e8, 7.0435e8, 6.1465e8, 5.2496e8, 4.3526e8,
    3.4557e8, 2.5587e8, 2.1787e8, 1.7986e8, 1.4186e8, 1.0385e8, 6.585e7, 5.425e7, 4.266e7, 3.106e7,
    1.947e7, 7.87e6,
]
axial_stiffness = [
    2.895214e10, 3.60666e9, 3.63344e9, 3.6781e9, 3.72276e9, 3.7674e9, 3.56642e9, 3.36542e9,
    3.16444e9, 2.96344e9, 2.76246e9, 2.45792e9, 2.15338e9, 1.84884e9, 1.5443e9, 1.23976e9,
    1.03722e9, 8.3468e8, 6.3214e8, 4.296e8, 2.2706e8,
]
hub_radius = 1.75
rotation_rpm = 20.463
"""
BENT = "angular_acceleration = 1e-7\n"  # without effect, but for the equations of a bent beam
HINGED = """\
length = 6
mass_per_length = 10
bending_stiffness = 2e6
flap_stiffness = 5e4
axial_stiffness = 1e8
rotation_speed = 30
root_stiffness = 0
"""
SOFT_MIDDLE = """\
stations = [0, 0.5, 1]
mass_per_length = 1.0
bending_stiffness = [100, 0.01, 100]
axial_stiffness = 4e6
rotation_speed = 20
"""
SOFT_TIP = """\
station,mass_per_length,bending_stiffness,flap_stiffness,axial_stiffness
0,2371.9,1.1989e+11,1.1992e+11,4.7438e+10
3.336209,1293.1,4.2361e+10,6.7756e+10,2.5862e+10
6.672902,1227.2,3.5893e+10,5.718e+10,2.4544e+10
10.009014,1100.2,3.1855e+10,4.4098e+10,2.2004e+10
13.345804,978.74,3.0844e+10,2.8277e+10,1.95748e+10
16.682304,862.52,3.0589e+10,1.4931e+10,1.72504e+10
20.018513,764.52,2.8576e+10,9.5792e+09,1.52904e+10
23.354528,674.55,2.3836e+10,7.6692e+09,1.3491e+10
26.691028,612.8,1.982e+10,6.4041e+09,1.2256e+10
30.02743,559.7,1.6031e+10,5.2922e+09,1.1194e+10
33.36422,520.02,1.3075e+10,4.3773e+09,1.04004e+10
36.700333,489.47,1.0747e+10,3.6056e+09,9.7894e+09
40.036638,459.96,8.685e+09,2.9174e+09,9.1992e+09
43.373525,432.44,6.9522e+09,2.3144e+09,8.6488e+09
46.709831,413.65,5.4515e+09,1.8056e+09,8.273e+09
50.046233,386.86,4.3047e+09,1.3641e+09,7.7372e+09
53.382249,359.2,3.3481e+09,9.6193e+08,7.184e+09
56.718652,332.97,2.6054e+09,6.6928e+08,6.6594e+09
60.055345,307.9,2.0239e+09,4.5522e+08,6.158e+09
63.391167,282.5,1.5585e+09,3.1242e+08,5.65e+09
66.72786,259,1.1976e+09,2.2858e+08,5.18e+09
70.064553,233.74,9.1643e+08,1.6632e+08,4.6748e+09
73.400568,208.51,6.9775e+08,1.1882e+08,4.1702e+09
76.736487,183.95,5.2556e+08,83866000,3.679e+09
80.07347,159.18,3.8946e+08,58289000,3.1836e+09
83.409776,133.88,2.8094e+08,39885000,2.6776e+09
86.746179,106.7,1.9183e+08,25896000,2.134e+09
90.082775,74.392,1.1246e+08,14183000,1.48784e+09
93.418791,41.582,44311000,4478500,8.3164e+08
96.755,2.3788,24645,728.5,47576000
"""


def answer(tmp_path, capsys, text: str, *command: str):
    file = tmp_path / "beam.toml"
    file.write_text(text)
    first, *options = command
    assert main([first, "--si", str(file), *options, "--format", "json"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(
    ("text", "options", "right", "tolerance"),
    [
        (DIP, ["--tolerance", "1e-10"], DIP_FREQUENCIES, 1e-9),
        (DIP + BENT, ["--state", "bent"], DIP_FREQUENCIES, 0.0),
        (LIGHT_TIP + BENT, ["--state", "bent"], [5.707169608, 19.328277092], 0.0),
    ],
)
def test_frequencies_are_right_within_their_errors(
    tmp_path, capsys, text, options, right, tolerance
):
    modes = answer(tmp_path, capsys, text, "modes", "--modes", "4", *options)["modes"]
    for mode, frequency in zip(modes, right, strict=False):
        off = abs(mode["frequency"] - frequency)
        assert off <= max(mode["error"], tolerance * frequency, 5e-10)


def test_a_blade_that_is_softer_in_its_middle_than_at_its_ends_is_solved(tmp_path, capsys):
    """To the default tolerance, a relative error of 1e-6."""
    modes = answer(tmp_path, capsys, SOFT_MIDDLE, "modes")["modes"]
    assert all(mode["error"] <= 1e-6 * mode["frequency"] for mode in modes)


def test_the_first_flap_mode_of_a_hinged_blade_lies_on_once_per_revolution(tmp_path, capsys):
    """At each speed: it turns as a rigid body."""
    sweep = ["--over", "rad/s", "--start", "0", "--stop", "40", "--points", "21", "--per-rev", "2"]
    loci = answer(tmp_path, capsys, HINGED, "loci", "--plane", "flapwise", *sweep)
    on_line = [event for event in loci["events"] if event.get("per_rev") == 1]
    assert [event["branches"] for event in on_line] == [["B1"]]
    assert on_line[0]["until"] == pytest.approx(loci["values"][-1])


def test_a_tip_with_a_ten_millionth_of_the_stiffness_of_the_root_is_solved(tmp_path, capsys):
    """The blade of the IEA 10 MW turbine, in the values of its WISDEM model, at 5 rpm."""
    (tmp_path / "blade.csv").write_text(SOFT_TIP)
    text = 'stations_file = "blade.csv"\nrotation_rpm = 5\nhub_radius = 2.4\n'
    for plane, hertz in (("chordwise", 0.654712), ("flapwise", 0.409306)):
        modes = answer(tmp_path, capsys, text, "modes", "--plane", plane)["modes"]
        assert modes[0]["hertz"] == pytest.approx(hertz, rel=1e-4)  # its hub is not known
