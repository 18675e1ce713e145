"""How far does a robot arm lag behind its hub as it is spun up?

The manoeuvre of Kane, Ryan and Banerjee: an arm of 10 m is brought to 6 rad/s within 15 s.
Its tip lags by 0.574 m at most, after 6.75 s. Then it swings by 3.64 mm, and the arm is longer by
0.5145 mm. A theory without the stiffening by rotation lets the tip run away.

Source: Kane, Ryan & Banerjee (1987); Simo & Vu-Quoc (1986), their values refined.
"""

import sys

import matplotlib.pyplot as plt

from beamviz import Beam, Ramp, motion

PICTURE = "spin_up.png"  # in the current folder, unless the command line names a file


def main(picture=PICTURE):
    arm = Beam.from_si(
        length=10.0, density=3000.0, area=4e-4, second_moment=2e-7, youngs_modulus=7e10
    )
    L, T = arm.units.length, arm.units.time  # [m], [s]
    moved = motion(arm, until=20 / T, speed=Ramp(to=6 * T, within=15 / T), points=2001)
    seconds, deflection = T * moved.t, L * moved.tip[:, 1]

    figure, axes = plt.subplots(figsize=(6, 3.6), layout="constrained")
    axes.plot(seconds, deflection)
    axes.set(xlabel="time [s]", ylabel="deflection of the tip [m]", title="a spin-up to 6 rad/s")
    speed = axes.twinx()
    speed.plot(seconds, moved.gamma / T, color="0.6", ls="--")
    speed.set_ylabel("speed [rad/s], dashed")
    figure.savefig(picture, dpi=100)
    plt.close(figure)

    after = seconds > 15.1
    return {
        "greatest lag [m]": -deflection.min(),
        "at [s]": seconds[deflection.argmin()],
        "swing afterwards [mm]": 1e3 * abs(deflection[after]).max(),
        "elongation [mm]": 1e3 * L * (moved.tip[after, 0].max() - 1),
    }


if __name__ == "__main__":
    for name, value in main(*sys.argv[1:]).items():
        print(f"{name}: {value:.6g}")
