"""The layers of the package: imports of every form point down, and the lower layers stay light."""

import ast
import subprocess
import sys
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
LAYERS = (  # a module belongs to the layer that names it or the nearest of its parents
    ("errors", "signals", "files", "version", "hooks", "installation"),
    ("workers",),
    ("checks",),
    ("blade", "units", "input_files"),
    ("si",),
    ("plausibility",),
    ("beam",),
    ("presets",),
    ("protocols",),
    ("tables", "datasets", "plotting"),  # of columns and records, for the methods of results
    ("solver",),
    ("dynamics",),
    ("scene",),
    ("frequency_loci",),
    ("sweeps",),
    ("plotting.maps",),
    ("chart_ranges",),
    ("lessons",),
    ("output",),
    ("paper", "failure_maps"),
    ("benchmark",),
    ("server",),
    ("drawing",),
    ("exports",),
    ("explorer",),
    ("notebook",),
    ("cli",),
    ("__main__", "beamviz"),
)
EVIDENCE = ("paper", "failure_maps", "benchmark")  # for charts and tables, not of the product
INSIDE_THE_SOLVER = {  # parts of it that are used above it, by the folder that uses them
    "frequency_loci": {  # mode vectors at the points of a quadrature; other stable states
        *("solver.quadrature", "solver.hp", "solver.bent"),
    },
    "dynamics": {"solver.constitutive", "solver.fem.elements"},  # strain laws, cubic elements
    "failure_maps": {"solver.bent"},  # other stable states
}
VIEWERS = {"viser", "matplotlib", "trimesh"}
LIBRARIES = {"scipy.optimize", "scipy.sparse", "scipy.special", "scipy.integrate", "rich"}


def module_name(path: Path) -> str:
    """beamviz/solver/hp/mesh.py is solver.hp.mesh; the package itself is "beamviz"."""
    parts = path.relative_to(ROOT / "beamviz").with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts) or "beamviz"


MODULES = {module_name(path): path for path in sorted((ROOT / "beamviz").rglob("*.py"))}


@cache
def nodes(path: Path) -> list[ast.AST]:
    """All nodes of the syntax tree of a file."""
    return [*ast.walk(ast.parse(path.read_text()))]


@cache
def imports(path: Path) -> set[str]:
    """Every module a file imports anywhere in it: at its top, in functions, for its types, and by
    its name in a string, as `import_module` and tables of modules have it."""
    names = set()
    for node in nodes(path):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                full = f"{node.module}.{alias.name}"
                inside = full.removeprefix("beamviz.") in MODULES
                names.add(full if inside else str(node.module))
        elif isinstance(node, ast.Constant) and str(node.value).startswith("beamviz."):
            names.add(str(node.value))
    return names


WHOLE_FOLDERS = {"explorer.features"}  # packages that import each module of their own


def own_imports(module: str) -> set[str]:
    names = {name.removeprefix("beamviz.") for name in imports(MODULES[module])} & set(MODULES)
    folder = f"{module}." if module in WHOLE_FOLDERS else "-"
    return names | {name for name in MODULES if name.startswith(folder)}


def layer(module: str) -> int:
    """The number of the layer of a module, 0 the lowest."""
    named = {name: number for number, names in enumerate(LAYERS) for name in names}
    while module not in named:
        module = module.rpartition(".")[0]
        assert module, "a new folder: add it to LAYERS"
    return named[module]


def circle(graph: dict[str, set[str]]) -> list[str]:
    """A circle of modules that import each other; [] where there is none."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1]
    return []


def names_of(node: ast.expr) -> str:
    """The last name of what is called."""
    return getattr(node, "attr", getattr(node, "id", ""))


def test_imports_point_down():
    for module in MODULES.keys() - {"beamviz"}:
        above = [name for name in own_imports(module) if layer(name) > layer(module)]
        assert above == [], module


def test_no_circle_of_imports():
    """Of no form; `imports` sees each of them."""
    assert circle({module: own_imports(module) for module in MODULES}) == []


@pytest.mark.parametrize(
    "line",
    [
        "from beamviz import scene",
        "import beamviz.scene",
        "def f():\n    from beamviz.scene import Scene",
        "if TYPE_CHECKING:\n    from beamviz.scene import Scene",
        "import_module('beamviz.scene').Scene",
        "TABLE = {'beamviz.scene': ('Scene',)}",
    ],
)
def test_every_form_of_import_is_seen(tmp_path, line):
    """An import of the layer above by the solver, in each form, is one that points up."""
    (tmp_path / "module.py").write_text(line)
    assert "beamviz.scene" in imports(tmp_path / "module.py")
    below = {name: own_imports(name) for name in ("scene", "beam", "errors")}
    assert circle({**below, "solver.problem": {"scene"}})


def test_modules_are_imported_by_a_whole_name():
    """A name that is put together could not be resolved by `imports`. The package itself imports
    its public names on first use, from a table of whole names."""
    for module in MODULES.keys() - {"beamviz"} - WHOLE_FOLDERS:
        for call in (node for node in nodes(MODULES[module]) if isinstance(node, ast.Call)):
            if names_of(call.func) in ("import_module", "__import__"):
                assert isinstance(call.args[0], ast.Constant), f"{module}, line {call.lineno}"


def test_no_attribute_is_made_on_access():
    """The package itself imports its public names on first use; no other module has the like, and
    none re-exports names of another for their users."""
    for module in MODULES.keys() - {"beamviz"}:
        text = MODULES[module].read_text()
        assert "\ndef __getattr__" not in text, module
        assert "locals()" not in text, module


def test_evidence_is_imported_by_its_commands_only():
    for module in MODULES:
        seen = {name.partition(".")[0] for name in own_imports(module)} & {*EVIDENCE}
        assert seen <= {module.partition(".")[0]} or module == "cli.commands", module


def test_the_solver_needs_numpy_and_scipy_only():
    """Beside the standard library and its own package."""
    for module, path in MODULES.items():
        if module.startswith("solver"):
            roots = {name.partition(".")[0] for name in imports(path)}
            assert roots - set(sys.stdlib_module_names) <= {"numpy", "scipy", "beamviz"}, module


def test_the_solver_is_used_through_its_entry_points():
    """Nothing above it imports a method, but where it needs what no solution has."""
    for module in MODULES:
        if layer(module) > layer("solver"):
            seen = {name for name in own_imports(module) if name.startswith("solver.")}
            parts = INSIDE_THE_SOLVER.get(module.partition(".")[0], set())
            assert seen <= {"solver.problem", "solver.solution"} | parts, module


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
        (
            "import tempfile; from beamviz import Scene, screenshot;"
            "screenshot(tempfile.mkdtemp() + '/a.png', Scene(), 64, 64)",
            *("trimesh", {"viser", "websockets", "beamviz.server"}),
        ),
    ],
)
def test_nothing_is_loaded_that_is_not_used(code, used, unused):
    """Neither by the package nor by a solve, which needs of scipy its LAPACK only, and of bent
    states nothing while the straight one is stable; nor by a picture, which needs no page."""
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
