"""The floors of the package: every import points down, and the lower floors stay light."""

import ast
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "beamviz"
FLOORS = (
    ("beamviz.errors", "beamviz.ending"),
    ("beamviz.beam",),
    (
        "beamviz.mechanics.assembly",
        "beamviz.mechanics.basis",
        "beamviz.mechanics.eigen",
        "beamviz.mechanics.newton",
        "beamviz.mechanics.roots",
    ),
    ("beamviz.mechanics.solution",),
    ("beamviz.mechanics",),  # all others in there
    ("beamviz.mechanics.methods",),
    ("beamviz.mechanics.solve",),
    ("beamviz.look",),
    ("beamviz.scene_file",),
    ("beamviz.study",),
    ("beamviz.lesson", "beamviz.lesson_numbers", "beamviz.lessons"),
    ("beamviz",),
    ("beamviz.show",),
    ("beamviz.options", "beamviz.report"),
    ("beamviz.loci_report", "beamviz.lessons_report"),
    ("beamviz.cli",),
    ("beamviz.__main__",),
)
FRONT_OF_MECHANICS = {"beamviz.mechanics.solution", "beamviz.mechanics.solve"}


def module_name(path: Path) -> str:
    """beamviz/mechanics/solve.py is beamviz.mechanics.solve."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_name(path): path for path in sorted(PACKAGE.rglob("*.py"))}


def imported(path: Path) -> set[str]:
    """Every module a file imports anywhere in it, lazily or for its types too."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            inside = {f"{node.module}.{alias.name}" for alias in node.names} & set(MODULES)
            names |= inside or {str(node.module)}
    return names


def floor(module: str) -> int:
    """The number of the floor a module is on: the one that names the nearest of its parents."""
    named = {name: number for number, names in enumerate(FLOORS) for name in names}
    while module not in named:
        module = module.rpartition(".")[0]
    return named[module]


def own_imports(module: str) -> set[str]:
    """The modules of this package that one of its modules imports."""
    return imported(MODULES[module]) & set(MODULES)


@pytest.mark.parametrize("module", MODULES)
def test_imports_point_down(module):
    """No module imports from a floor above its own."""
    above = {name for name in own_imports(module) if floor(name) > floor(module)}
    assert not above, f"{module} imports from above: {sorted(above)}"


def test_no_import_cycles():
    """Modules can be put in an order in which each imports only earlier ones."""
    order = TopologicalSorter({module: own_imports(module) for module in MODULES})
    assert len(list(order.static_order())) == len(MODULES)


@pytest.mark.parametrize("module", [name for name in MODULES if ".mechanics" in name])
def test_mechanics_needs_numpy_and_scipy_only(module):
    """Mechanics imports numpy, scipy, the standard library and what lies below, nothing else."""
    roots = {name.partition(".")[0] for name in imported(MODULES[module])}
    assert roots - set(sys.stdlib_module_names) <= {"numpy", "scipy", "beamviz"}


@pytest.mark.parametrize(
    "module", [name for name in MODULES if floor(name) > floor("beamviz.mechanics.solve")]
)
def test_only_the_front_of_mechanics_is_seen_from_above(module):
    """Nothing above solve() reaches into a method."""
    seen = {name for name in own_imports(module) if name.startswith("beamviz.mechanics")}
    assert seen <= FRONT_OF_MECHANICS


def loaded_by(statement: str) -> set[str]:
    """The top-level packages a fresh interpreter has loaded after a statement."""
    script = f"{statement}; import sys; print(*{{name.partition('.')[0] for name in sys.modules}})"
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return set(done.stdout.split())


def test_importing_the_package_loads_no_viewer_and_no_solver():
    """`import beamviz` costs nothing that is not used."""
    assert not loaded_by("import beamviz") & {"viser", "matplotlib", "trimesh", "scipy", "numpy"}


def test_solving_loads_no_viewer():
    """The solver and the command line leave viser and matplotlib alone."""
    loaded = loaded_by("import beamviz.cli; from beamviz import Beam, solve; solve(Beam())")
    assert "scipy" in loaded
    assert not loaded & {"viser", "matplotlib", "trimesh", "rich"}


def test_every_public_name_exists():
    """What __all__ promises can be imported, also what loads on first use."""
    import beamviz

    assert all(hasattr(beamviz, name) for name in beamviz.__all__)
    assert not hasattr(beamviz, "nothing_of_that_name")
