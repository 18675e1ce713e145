"""The result of `beamviz.motion`: a plain record."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beamviz.beam import Beam
from beamviz.checks import check_float
from beamviz.dynamics.drives import Hub, Ramp, Samples
from beamviz.dynamics.equation import Energies
from beamviz.dynamics.integration import Trajectory
from beamviz.dynamics.problem import MotionProblem
from beamviz.dynamics.refinement import RefinedMotion
from beamviz.errors import InvalidInput
from beamviz.mechanics.inertia import Loading
from beamviz.solver.constitutive import STRAIN_LAWS
from beamviz.solver.solution import GreatestStress, read_only, stress_of_deformation

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

# Samples of a spectrum for each step, whose polynomials have up to ten coefficients, so that no
# frequency of the motion appears as a lower one. Their number is a multiple of BLOCK, and AT_ONCE
# of them are computed together: a whole block takes 30 MB.
STEP_SAMPLES, BLOCK, AT_ONCE = 4, 8192, 1024
TABLE_ROWS = 21
STRESS_POINTS, STRESS_TIMES = 200, 400  # at which the greatest stress is looked for


@dataclass(frozen=True)
class MotionStats:
    """Cost and resolution of a motion."""

    dof: int  # unknowns of the beam
    elements: int
    order: int  # of the polynomials along the beam, the greatest
    steps: int  # in time
    runs: int  # computed until two of them agreed
    seconds: float  # wall time [s]


@dataclass(frozen=True, eq=False, repr=False)
class Motion:
    """A motion in time; lengths in L, times in T*, energies in E I / L. Arrays are read-only."""

    beam: Beam
    drive: Ramp | Samples | Hub
    model: Mapping[str, Any]  # the method and the terms of the theory
    start: Mapping[str, float]  # amplitudes of modes at t = 0
    release: float  # transverse force until t = 0 [E I / L^2], at the point release_at
    t: NDArray  # (n,)
    gamma: NDArray  # (n,) speed
    angle: NDArray  # (n,) of the hub [rad]
    tip: NDArray  # (n, 2) position of the tip from the clamp, in the rotating frame
    energies: Energies  # (n,) in the rotating frame: kinetic, strain, centrifugal
    error: float  # estimated largest error of the tip
    stats: MotionStats
    trajectory: Trajectory  # the unknowns as polynomials in time
    release_at: float = 1.0
    catch: float | None = None  # time at which the mass docks
    drop: float | None = None  # time at which it is released

    def __repr__(self) -> str:
        numbers = self.beam.summary
        _, y = self.tip[np.argmax(abs(self.tip[:, 1]))]
        return (
            f"<Motion of Beam({numbers}) until t = {self.t[-1]:g}: largest deflection of the tip"
            f" {y:.5g}, error {self.error:.1g}>"
        )

    @cached_property
    def energy(self) -> NDArray:
        """The sum of the energies (n,), q' M q' / 2 + U - gamma^2 / 2 int rho |R|^2: at a constant
        speed without damping it is constant, the Jacobi integral."""
        return read_only(self.energies.total)

    def position(self, t: ArrayLike, x: ArrayLike) -> NDArray:
        """Position (len(t), len(x), 2) of the points x in 0 .. 1 at times t, from the clamp, in the
        rotating frame. Raises ValueError outside."""
        r = self._states(t).positions(within("x", x, 1.0))
        return np.stack((r.real, r.imag), axis=-1)

    def velocity(self, t: ArrayLike, x: ArrayLike) -> NDArray:
        """Velocity (len(t), len(x), 2) [L/T*] of the points x in the rotating frame. Raises
        ValueError as `position`."""
        q, v = self.trajectory.at(within("t", t, float(self.t[-1])))
        beam = self.trajectory.beam
        q, v = q[:, : beam.size], v[:, : beam.size]
        rates = beam.moving(q, v, np.zeros_like(v), Loading(0.0)).velocities_at(within("x", x, 1.0))
        return np.stack((rates.real, rates.imag), axis=-1)

    def speed(self, t: ArrayLike) -> tuple[NDArray, NDArray]:
        """The speed of the hub [1/T*] and its rate [1/T*^2] (len(t),) each."""
        t = within("t", t, float(self.t[-1]))
        if not isinstance(self.drive, Hub):
            return self.drive(t)
        _, v = self.trajectory.at(t)
        return v[:, -1], self.trajectory.accelerations_at(t)[:, -1]

    def tension(self, t: ArrayLike, x: ArrayLike) -> NDArray:
        """Axial force (len(t), len(x)) [E I / L^2] by the strain law, tension positive; at a jump
        that inboard of it."""
        x = within("x", x, 1.0)
        law, blade = STRAIN_LAWS[self.model["strain"]], self.beam.blade
        axial = 1.0 if blade is None else blade.at("axial", x, inboard=True)
        return self.beam.mu**2 * axial * law.force(self.stretch(t, x))

    def stretch(self, t: ArrayLike, x: ArrayLike) -> NDArray:
        """Stretch |r'| (len(t), len(x)); at a jump the stretch inboard of it."""
        return self._states(t).stretch(within("x", x, 1.0))

    def curvature(self, t: ArrayLike, x: ArrayLike) -> NDArray:
        """Slope theta' of the angle of the beam's axis [1/L] (len(t), len(x))."""
        return self._states(t).curvature(within("x", x, 1.0))

    def _states(self, t: ArrayLike) -> Any:
        """The states of the beam at times."""
        q, _ = self.trajectory.at(within("t", t, float(self.t[-1])))
        return self.trajectory.beam.state(q[:, : self.trajectory.beam.size])

    def has_mass(self, t: float) -> bool:
        """Whether the concentrated mass is on the beam at a time."""
        events = {False: self.drop, True: self.catch}  # whether it is there after them
        passed = {time: there for there, time in events.items() if time is not None and time <= t}
        if passed:
            return passed[max(passed)]
        to_come = {time: there for there, time in events.items() if time is not None}
        return not to_come[min(to_come)] if to_come else bool(self.beam.alpha)

    @cached_property
    def greatest_stress(self) -> GreatestStress | None:
        """The greatest stress in the motion, `pascals`, with its place x / L, `at`, its time, `t`,
        and whether it `yields`, by the stretch and the curvature at a few hundred places and times;
        None for a beam whose material is not known."""
        units = self.beam.units
        if units is None or units.youngs_modulus is None:
            return None
        t = self.t[:: math.ceil(len(self.t) / STRESS_TIMES)]
        x = np.linspace(0.0, 1.0, STRESS_POINTS + 1)
        stress = stress_of_deformation(units, self.stretch(t, x), self.curvature(t, x))
        assert stress
        row, column = np.unravel_index(np.argmax(stress.greatest), stress.greatest.shape)
        greatest, at = float(stress.greatest[row, column]), float(x[column])
        known = stress.bending is not None
        return GreatestStress(greatest, at, known, units.yield_stress, float(t[row]))

    def spectrum(self, since: float = 0.0) -> tuple[NDArray, NDArray]:
        """Frequencies [1/T*] and the amplitude [L] of the tip's deflection at each (k,), by Fourier
        transform with a Hann window: a vibration of constant amplitude is a peak of its height.
        since: the time, before the end, from which on the motion counts. Raises InvalidInput."""
        last = float(self.t[-1])
        if check_float("since", since, 0.0, last) == last:
            raise InvalidInput(f"since = {since:g}: must be before the end of the motion")
        length, blocks = last - since, math.ceil(STEP_SAMPLES * self.stats.steps / BLOCK)
        t = since + np.linspace(0.0, length, BLOCK * blocks, endpoint=False)
        parts = [self.position(part, [1.0])[:, 0, 1] for part in t.reshape(-1, AT_ONCE)]
        deflection = np.concatenate(parts)
        window = np.hanning(len(t) + 1)[:-1]
        amplitude = abs(np.fft.rfft(window * (deflection - deflection.mean()))) * 2 / window.sum()
        return 2 * np.pi * np.fft.rfftfreq(len(t), length / len(t)), amplitude

    @property
    def columns(self) -> dict[str, NDArray]:
        """Everything over time (n,) each, by name."""
        return {
            "t": self.t,
            "gamma": self.gamma,
            "angle": self.angle,
            "tip_x": self.tip[:, 0],
            "tip_y": self.tip[:, 1],
            "energy": self.energy,
        }

    @property
    def table(self) -> dict[str, list[str]]:
        """The motion at some times, as texts by heading; of a beam in SI in seconds, rpm, metres
        and, where its mass is known, joules."""
        from beamviz.tables import significant_decimals

        rows = np.unique(np.linspace(0, len(self.t) - 1, TABLE_ROWS).round().astype(int))
        units = self.beam.units
        length = units.length if units else 1.0
        decimals = significant_decimals(length * self.error)
        time, speed = {"t [T*]": self.t}, {"gamma": self.gamma}
        energy = {"energy [E I / L]": self.energy}
        if units:
            time, speed = {"t [s]": self.t * units.time}, {"speed [rpm]": units.rpm(self.gamma)}
        if units and units.force is not None:
            energy = {"energy [J]": self.energy * units.force * units.length}
        tip = dict(zip(("x", "y"), length * self.tip.T, strict=True))
        unit = "m" if units else "L"
        general = {name: [f"{row[k]:.6g}" for k in rows] for name, row in (time | speed).items()}
        places = {
            f"tip {name} [{unit}]": [f"{row[k]:.{decimals}f}" for k in rows]
            for name, row in tip.items()
        }
        last = {name: [f"{row[k]:.6g}" for k in rows] for name, row in energy.items()}
        return general | places | last

    def to_xarray(self) -> "xarray.Dataset":
        """An xarray.Dataset: gamma, angle, tip and energy over t; the model, the numbers, error,
        units and version as attributes. Raises Unavailable where xarray is not installed."""
        from beamviz.datasets import attributes, motion_dataset

        notes = attributes(self.beam, self.model, self.beam.units)
        return motion_dataset(self.columns, {**notes, "error": self.error})

    def plot(self, ax: "Axes | None" = None) -> "Axes":
        """Draw the deflection of the tip over time onto matplotlib axes (the current ones by
        default), and return these."""
        from beamviz.plotting.motion import plot_deflection

        return plot_deflection(self.t, self.tip[:, 1], ax, self.beam.units)

    def _repr_html_(self) -> str:
        from beamviz.tables import html_table

        return html_table(repr(self).strip("<>"), self.table)


def motion_of(problem: MotionProblem, refined: RefinedMotion, seconds: float) -> Motion:
    """The result: a motion at the times asked for, with its error estimate, the number of runs it
    took and their time [s]."""
    t, drive, integrated = problem.times, problem.drive, refined.motion
    trajectory = integrated.trajectory
    angle = trajectory.at(t)[0][:, -1] if isinstance(drive, Hub) else drive.angle(t)
    orders = trajectory.beam.orders
    stats = MotionStats(
        dof=trajectory.beam.size,
        elements=len(orders),
        order=max(orders),
        steps=len(trajectory.q),
        runs=refined.runs,
        seconds=seconds,
    )
    energies = Energies(*map(read_only, integrated.energies(t)))
    t, gamma, angle, tip = map(read_only, (t, integrated.speed(t), angle, integrated.tip(t)))
    return Motion(
        beam=problem.beam,
        drive=drive,
        model=problem.model,
        start=problem.amplitudes,
        release=problem.release,
        release_at=problem.release_at,
        catch=problem.catch,
        drop=problem.drop,
        t=t,
        gamma=gamma,
        angle=angle,
        tip=tip,
        energies=energies,
        error=refined.error,
        stats=stats,
        trajectory=trajectory,
    )


def within(name: str, values: ArrayLike, last: float) -> NDArray:
    """An array (k,) of floats; ValueError outside 0 .. last."""
    array = np.atleast_1d(np.asarray(values, float))
    if array.size and not (array.min() >= 0 and array.max() <= last):
        raise ValueError(f"{name} = {array.min():g} .. {array.max():g}: must lie in 0 .. {last:g}")
    return array
