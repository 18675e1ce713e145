"""Random inputs for Beam, solve, loci, the TOML reader and the command line, with a check for each.

The outcome must be an answer, or an error of the package that names the input. scripts/fuzz.py
draws many inputs, tests/test_fuzz.py a fixed few; scripts/measure_error_bars.py judges the errors.
"""

import contextlib
import io
import math
import re
import tempfile
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from hypothesis import strategies as st

from beamviz.beam import PARAMETERS, Beam
from beamviz.cli import main
from beamviz.errors import BeamvizError, ImplausibleInput, InvalidInput
from beamviz.frequency_loci import loci
from beamviz.si import SECTION, SI_KEYS, SI_REQUIRED
from beamviz.solver import solve
from beamviz.solver.problem import CHOICES

EVERYDAY = {name: one.slider[:2] for name, one in PARAMETERS.items()}
NUMBERS = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.sampled_from([0.0, -0.0, 1e300, -1e300, 5e-324, math.nan, math.inf, 10**400, -1]),
)
ANY_VALUE = st.one_of(
    NUMBERS, st.none(), st.booleans(), st.text(max_size=5), st.lists(st.integers(), max_size=2)
)


def within(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers of a range, its ends and its small ones among them."""
    return st.one_of(
        st.floats(low, high, allow_subnormal=False), st.sampled_from([low, high, max(low, 0.0)])
    )


@st.composite
def beams(draw: Callable) -> Beam:
    """Beams of the whole accepted range."""
    numbers = {
        name: draw(within(*PARAMETERS[name].limits)) for name in ("alpha", "beta", "delta", "mu")
    }
    gamma = draw(within(0.0, min(PARAMETERS["gamma"].limits[1], 5 * numbers["mu"])))
    return Beam(gamma=gamma, **numbers)


OPTIONS = st.fixed_dictionaries(
    {},
    optional={
        **{name: st.sampled_from(list(known)) for name, known in CHOICES.items()},
        "coriolis": st.booleans(),
        "modes": st.integers(1, 8),
        "tolerance": st.sampled_from([1e-3, 1e-6, 1e-9]),
    },
)
ANY_OPTIONS = st.dictionaries(
    st.sampled_from([*CHOICES, "coriolis", "modes", "tolerance", "elements"]), ANY_VALUE, max_size=2
)


def answer(function: Callable, *arguments: Any, names: Iterable[str] = (), **options: Any) -> Any:
    """What a function returns; None for an error of the package, whose message is one line that
    names one of the inputs `names` if it is about input."""
    try:
        return function(*arguments, **options)
    except BeamvizError as error:
        text, named = str(error), list(names) if isinstance(error, InvalidInput) else []
        assert "\n" not in text, text
        assert len(text) > 10, text
        assert not named or any(name in text for name in named), text
        return None


def make_beam(values: dict[str, Any]) -> None:
    """Any five values: a beam within its limits, or an error that names one of them."""
    if beam := answer(Beam, names=values, **values):
        for name, parameter in PARAMETERS.items():
            assert parameter.limits[0] <= beam.numbers[name] <= parameter.limits[1]


def solve_beam(beam: Beam, options: dict[str, Any]) -> None:
    """Frequencies or nan, with errors, or an error; for the truth of both see oracle/error_bars."""
    solution = answer(solve, beam, **options)
    if solution is None:
        return
    assert np.all(solution.errors >= 0)
    assert np.all((solution.frequencies >= 0) | np.isnan(solution.frequencies))


def solve_any_options(beam: Beam, options: dict[str, Any]) -> None:
    """Any keywords: an answer, or an error that names one of them."""
    answer(solve, beam, names=options, **options)


@st.composite
def ranges(draw: Callable, *, wide: bool) -> tuple[Beam, str, tuple[float, float]]:
    """A beam, one of its parameters and a range of it: any accepted one if `wide`, or everyday."""
    over = draw(st.sampled_from(list(PARAMETERS)))
    if wide:
        beam, (low, high) = draw(beams()), PARAMETERS[over].limits
    else:
        numbers = {name: draw(st.floats(*EVERYDAY[name])) for name in EVERYDAY}
        beam, (low, high) = Beam(**numbers), EVERYDAY[over]
    if over == "gamma":
        high = min(high, 5 * beam.mu)
    if over == "mu":
        low = max(low, beam.gamma / 5)
    ends = st.tuples(within(low, high), within(low, high)).map(sorted)
    return beam, over, tuple(draw(ends.filter(lambda pair: pair[0] < pair[1])))


def sweep(
    where: tuple[Beam, str, tuple[float, float]], points: int, modes: int, options: dict[str, Any]
) -> None:
    """Loci with a value of each branch at each point and events within the range, or an error."""
    beam, over, ends = where
    found = answer(loci, beam, over, np.linspace(*ends, points), modes, **options)
    if found is None:
        return
    assert all(len(branch.frequency) == points for branch in found.branches)
    assert all(event.gap >= 0 for event in found.events)
    assert all(ends[0] <= event.at <= ends[1] for event in found.events)
    assert all(ends[0] <= limit.start <= limit.stop <= ends[1] for limit in found.limits)


SWEEP_OPTIONS = {name: st.sampled_from(list(CHOICES[name])) for name in ("plane", "strain")}
SWEEP_OPTIONS |= {"coriolis": st.booleans()}
SWEPT = st.integers(2, 6), st.integers(1, 5), st.fixed_dictionaries({}, optional=SWEEP_OPTIONS)
ANY_RANGE = st.one_of(st.lists(ANY_VALUE, max_size=4), ANY_VALUE)


def sweep_any_values(beam: Beam, over: str, values: Any) -> None:
    """Any values: loci, or an error that names the parameter."""
    answer(loci, beam, over, values, 1, names=[over])


SIZES = st.floats(1e-9, 1e9)
ROWS = SIZES | st.lists(SIZES, min_size=1, max_size=3) | st.lists(st.just(1.0), max_size=3)
TOML = st.one_of(
    st.binary(max_size=200),
    st.text(max_size=200).map(str.encode),
    st.dictionaries(
        st.sampled_from([*SI_KEYS, "colour"]),
        st.one_of(NUMBERS, st.text("ab\"'\\", max_size=3), st.booleans()),
        max_size=9,
    ).map(lambda d: "\n".join(f"{k} = {str(v).lower()}" for k, v in d.items()).encode()),
    st.one_of(
        st.fixed_dictionaries(dict.fromkeys(SI_REQUIRED, SIZES)),
        st.fixed_dictionaries(
            {"length": st.just(1.0), **dict.fromkeys(SECTION, ROWS)},
            optional={
                "stations": st.sampled_from([[0.0, 1.0], [0, 0.5, 1.0], [0, 2], [], [1.0]]),
                "degree": st.integers(0, 3),
                "masses": st.lists(NUMBERS, max_size=2),
                "root_stiffness": SIZES,
            },
        ),
    ).map(lambda d: "\n".join(f"{k} = {v!r}" for k, v in d.items()).encode()),
)


def read_toml(text: bytes) -> None:
    """Any bytes as a beam file: a beam, or an error that names the file or a quantity."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", ImplausibleInput)  # most of these sizes
        path = Path(folder) / "beam.toml"
        path.write_bytes(text)
        answer(Beam.from_toml, path, names=["beam.toml", *SI_KEYS, *PARAMETERS, "T*"])


COMMAND_WORDS = """
modes loci lessons --alpha --beta --gamma --delta --mu --method --strain --plane --modes
--tolerance --elements --coriolis --format json csv table green biot auto foac ancf
flapwise --over gamma alpha --start --stop --points --per-rev --si --help --version 0 1
0.5 -1 7 50 1e3 1e-3 nan inf -inf 1e300 --
"""
WORDS = st.one_of(
    st.sampled_from(COMMAND_WORDS.split()),
    st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=6),
)
LOCI = ["loci", "--over", "gamma", "--start", "0", "--stop", "9", "--points", "4"]
LINES = st.one_of(
    st.lists(WORDS, max_size=8),
    st.lists(WORDS, max_size=6).map(lambda words: ["modes", *words]),
    st.lists(WORDS, max_size=4).map(lambda words: LOCI + words),
)


def run_command(line: list[str]) -> None:
    """Any command line: a documented exit code, and one line on stderr if it failed."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(line)
    assert code in (0, 1, 2, 3, 4), code
    errors = err.getvalue()
    assert "Traceback" not in errors, errors
    assert not re.search(r"unexpected \w+: ", errors), errors  # an error that is not ours
    if code:
        assert re.fullmatch(r"(beamviz: [^\n]*\n)+", errors), errors


NAMES = st.sampled_from(list(PARAMETERS))


class Case(NamedTuple):
    """A kind of input: its check, the strategies that draw it, its share of the inputs of
    scripts/fuzz.py (large if it is quick to check), and how many tests/test_fuzz.py draws."""

    check: Callable[..., None]
    strategies: tuple[st.SearchStrategy, ...]
    share: float
    examples: int = 15


CASES = {
    "Beam": Case(make_beam, (st.dictionaries(NAMES, ANY_VALUE, min_size=1),), 0.4, 30),
    "solve": Case(solve_beam, (beams(), OPTIONS), 0.1, 10),
    "solve, odd keywords": Case(solve_any_options, (beams(), ANY_OPTIONS), 0.03),
    "loci": Case(sweep, (ranges(wide=False), *SWEPT), 0.008, 3),
    "loci, wild": Case(sweep, (ranges(wide=True), *SWEPT), 0.002, 5),
    "loci, odd ranges": Case(sweep_any_values, (beams(), NAMES, ANY_RANGE), 0.01),
    "TOML": Case(read_toml, (TOML,), 0.3, 30),
    "command line": Case(run_command, (LINES,), 0.15),
}
