"""The layers of the package: every import points down, and the lower layers stay light."""

import ast
import subprocess
import sys
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
LAYERS = (  # a module belongs to the layer that names it or the nearest of its parents
    ("errors", "signals", "files"),
    ("beam",),
    ("solver",),
    ("scene",),
    ("frequency_loci",),
    ("sweeps",),
    ("chart_ranges",),
    ("plotting",),
    ("lessons",),
    ("output",),
    ("paper", "failure_maps"),
    ("benchmark",),
    ("server",),
    ("drawing",),
    ("exports",),
    ("explorer",),
    ("cli",),
    ("__main__", "beamviz"),
)
VIEWERS = {"viser", "matplotlib", "trimesh"}
LIBRARIES = {"scipy.optimize", "scipy.sparse", "scipy.special", "scipy.integrate", "rich"}


def module_name(path: Path) -> str:
    """beamviz/solver/hp/mesh.py is solver.hp.mesh; the package itself is "beamviz"."""
    parts = path.relative_to(ROOT / "beamviz").with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts) or "beamviz"


MODULES = {module_name(path): path for path in sorted((ROOT / "beamviz").rglob("*.py"))}


@cache
def imports(path: Path) -> set[str]:
    """Every module a file imports anywhere in it, lazily or for its types too."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            full = {f"{node.module}.{alias.name}" for alias in node.names}
            inside = {name for name in full if name.removeprefix("beamviz.") in MODULES}
            names |= inside or {str(node.module)}
    return names


def own_imports(module: str) -> set[str]:
    return {name.removeprefix("beamviz.") for name in imports(MODULES[module])} & set(MODULES)


def layer(module: str) -> int:
    """The number of the layer of a module, 0 the lowest."""
    named = {name: number for number, names in enumerate(LAYERS) for name in names}
    while module not in named:
        module = module.rpartition(".")[0]
        assert module, "a new folder: add it to LAYERS"
    return named[module]


def test_imports_point_down():
    for module in MODULES.keys() - {"beamviz"}:
        below = own_imports(module) - {"beamviz"}
        assert [name for name in below if layer(name) > layer(module)] == [], module


def test_no_import_cycles():
    order = TopologicalSorter({module: own_imports(module) for module in MODULES})
    assert len(list(order.static_order())) == len(MODULES)


def test_modules_are_short():
    """At most 400 lines: a longer one has two subjects."""
    lengths = {module: len(path.read_text().splitlines()) for module, path in MODULES.items()}
    assert {module: length for module, length in lengths.items() if length > 400} == {}


def test_solver_needs_numpy_and_scipy_only_and_is_used_through_solve_only():
    """Beside the standard library and its own package; nothing above imports a single method, but
    the benchmark times the eigenproblems alone."""
    timed = {"benchmark.work_precision": {"solver.eigen"}}
    for module, path in MODULES.items():
        if module.startswith("solver"):
            roots = {name.partition(".")[0] for name in imports(path)}
            assert roots - set(sys.stdlib_module_names) <= {"numpy", "scipy", "beamviz"}, module
        elif layer(module) > layer("solver"):
            seen = {name for name in own_imports(module) if name.startswith("solver")}
            assert seen - timed.get(module, set()) <= {"solver", "solver.solution"}, module


@pytest.mark.parametrize(
    ("code", "used", "unused"),
    [
        ("import beamviz", "beamviz", {"numpy", "scipy", *VIEWERS}),
        ('from beamviz.cli import main; main(["modes"])', "scipy.linalg", LIBRARIES | VIEWERS),
        (
            "from beamviz import Beam, solve; beam = Beam(alpha=1, beta=0.5, gamma=10);"
            "[solve(beam, state=state, coriolis=True) for state in ('straight', 'stable')]",
            *("beamviz.solver", {"beamviz.solver.bent"}),
        ),
    ],
)
def test_nothing_is_loaded_that_is_not_used(code, used, unused):
    """Neither by the package nor by a solve, which needs of scipy its LAPACK only, and of bent
    states nothing while the straight one is stable."""
    command = [sys.executable, "-c", f"{code}; import sys; print(*sys.modules, file=sys.stderr)"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    loaded = set(done.stderr.split())
    assert used in loaded
    assert loaded & unused == set()


def test_no_submodule_has_the_name_of_a_public_function():
    """A folder `loci` would replace the function `beamviz.loci` as soon as it is imported."""
    import beamviz

    assert all(hasattr(beamviz, name) for name in beamviz.__all__)
    assert not set(beamviz.__all__) & set(MODULES)
    assert not hasattr(beamviz, "nothing_of_that_name")
