"""The layers of the package: imports of every form point down, and the lower layers stay light."""

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path
from typing import NamedTuple

import pytest
from helpers import slow

from beamviz.explorer.features import FEATURES

ROOT = Path(__file__).resolve().parents[1]
LAYERS = (  # a module belongs to the layer that names it or the nearest of its parents
    ("errors", "signals", "files", "version", "installation"),
    ("workers",),
    ("checks",),
    ("blade", "units", "input_files", "conversions"),
    ("blade_files",),
    ("si",),
    ("plausibility", "mass_properties"),
    ("beam",),
    ("presets", "chart_ranges"),
    ("space", "mechanics", "solver"),  # see test_the_space_needs_no_mechanics
    ("sensitivities", "measured"),
    ("dynamics",),
    ("scene",),
    ("frequency_loci",),
    ("tables", "datasets"),  # of results
    ("sweeps",),
    ("adjusting",),
    ("plotting",),
    ("lessons",),
    ("output",),
    ("server",),
    ("drawing",),
    ("exports", "export_formats"),
    ("explorer",),
    ("notebook",),
    ("evidence",),
    ("cli",),
    ("__main__", "beamviz"),
)
LATE_IMPORTS = {  # all that point up: methods of results import what they call, as a statement
    ("solver.solution", "Solution.to_xarray", "datasets"),
    ("solver.solution", "Solution.sensitivities", "sensitivities"),
    ("solver.solution", "Solution.plot", "plotting"),
    ("solver.solution", "Solution.show", "notebook"),
    ("solver.solution", "Solution._repr_html_", "tables"),
    ("dynamics.result", "Motion.table", "tables"),
    ("dynamics.result", "Motion.to_xarray", "datasets"),
    ("dynamics.result", "Motion.plot", "plotting.motion"),
    ("dynamics.result", "Motion._repr_html_", "tables"),
    ("frequency_loci", "Loci.to_xarray", "datasets"),
    ("frequency_loci", "Loci.events_dataframe", "tables"),
    ("frequency_loci", "Loci.limits_dataframe", "tables"),
    ("frequency_loci", "Loci.plot", "plotting.loci"),
    ("frequency_loci", "Loci._repr_html_", "tables"),
}
EVIDENCE_COMMANDS = {  # and the completion of the names that one takes
    ("cli.commands", name) for name in ("reproduce", "paper_names", "benchmark", "stability")
}
INSIDE_THE_SOLVER = {  # parts of it that are used above it, by the package that uses them
    "frequency_loci": {  # mode vectors at the points of a quadrature; other stable states
        *("solver.quadrature", "solver.straight", "solver.bent"),
    },
    "dynamics": {  # strain laws; Newton's method; modes without mass
        *("solver.constitutive", "solver.continuation", "solver.pencil.inverse"),
    },
    "evidence": {"solver.bent"},  # other stable states
}
BY_NAME = {  # modules that import by a name, which is not seen unless it is a whole one
    "beamviz",  # its public names on first use
    *("evidence.benchmark.blade", "evidence.benchmark.external"),  # other programs
    "evidence.benchmark.exudyn_motion",
}
parses_everything = pytest.mark.slow  # the text of the package, for a second or two
VIEWERS = {"viser", "matplotlib", "trimesh"}
LIBRARIES = {"scipy.optimize", "scipy.sparse", "scipy.special", "scipy.integrate", "rich"}


def module_name(path: Path) -> str:
    """beamviz/solver/bent/beam.py is solver.bent.beam; the package itself is "beamviz"."""
    parts = path.relative_to(ROOT / "beamviz").with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts) or "beamviz"


MODULES = {module_name(path): path for path in sorted((ROOT / "beamviz").rglob("*.py"))}


class Import(NamedTuple):
    """An import anywhere in a module: at its top, in a function, for its types, or by its name in a
    string, as `import_module` and tables of modules have it."""

    module: str
    scope: str  # the class and function that it is in, as in "Solution.plot"
    target: str  # a module of the package without "beamviz.", or another package
    is_statement: bool

    @property
    def points_up(self) -> bool:
        return self.target in MODULES and layer(self.target) > layer(self.module)

    @property
    def is_late(self) -> bool:
        """Whether it is one of LATE_IMPORTS, and visible as a statement."""
        return self.is_statement and self[:3] in LATE_IMPORTS


def imports(module: str, tree: ast.Module) -> Iterator[Import]:
    for node, scope in nodes(tree):
        for name in imported(node):
            is_statement = not isinstance(node, ast.Constant)
            yield Import(module, scope, name.removeprefix("beamviz."), is_statement)


def nodes(tree: ast.AST) -> Iterator[tuple[ast.AST, str]]:
    """All nodes below another, each with the class and function that it is in."""
    waiting = [(tree, "")]
    while waiting:
        parent, scope = waiting.pop()
        for node in ast.iter_child_nodes(parent):
            yield node, scope
            named = isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
            waiting.append((node, f"{scope}.{node.name}".strip(".") if named else scope))


def imported(node: ast.AST) -> Iterator[str]:
    """The modules that a node of a syntax tree imports or names."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom):
        assert not node.level, "a relative import"
        for alias in node.names:
            full = f"{node.module}.{alias.name}"
            yield full if full.removeprefix("beamviz.") in MODULES else str(node.module)
    elif isinstance(node, ast.Constant) and str(node.value).startswith("beamviz."):
        yield str(node.value)


@cache
def trees() -> dict[str, ast.Module]:
    """The syntax trees of all modules."""
    return {name: ast.parse(path.read_text()) for name, path in MODULES.items()}


@cache
def all_imports() -> list[Import]:
    return [each for name, tree in trees().items() for each in imports(name, tree)]


@cache
def layer(module: str) -> int:
    """The number of the layer of a module, 0 the lowest."""
    named = {name: number for number, names in enumerate(LAYERS) for name in names}
    while module not in named:
        module = module.rpartition(".")[0]
        assert module, "a new folder: add it to LAYERS"
    return named[module]


def breaches(seen: list[Import]) -> list[Import]:
    """Imports that point up and are not allowed to."""
    return [each for each in seen if each.points_up and not each.is_late]


@parses_everything
def test_imports_point_down():
    """But for the methods of results, exactly as LATE_IMPORTS lists them."""
    assert breaches(all_imports()) == []
    assert {each[:3] for each in all_imports() if each.points_up} == LATE_IMPORTS


@parses_everything
def test_no_circle_of_imports():
    """Of no form, late imports aside."""
    graph = {module: set() for module in MODULES}
    for each in all_imports():
        if each.target in MODULES and each.target != each.module and not each.is_late:
            graph[each.module].add(each.target)
    TopologicalSorter(graph).prepare()  # raises CycleError, which lists the circle


@pytest.mark.parametrize(
    "line",
    [
        "from beamviz import notebook",
        "import beamviz.notebook",
        "from beamviz import show",
        "from beamviz.notebook import show",
        "class Solution:\n    def display(self):\n        from beamviz.notebook import show",
        "class Solution:\n    def show(self):\n        from beamviz.explorer import serve",
        "class Solution:\n    def show(self):\n        import_module('beamviz.notebook').show()",
        "def show():\n    from beamviz.notebook import show",
        "if TYPE_CHECKING:\n    from beamviz.notebook import View",
        "TABLE = {'beamviz.notebook': ('show',)}",
    ],
)
def test_every_form_of_import_is_seen(line):
    """An import of a layer above by the solver is refused in each form, also where a method of a
    result imports another module, or the right one invisibly."""
    assert breaches([*imports("solver.solution", ast.parse(line))])


def test_few_modules_import_by_name():
    """A name that is put together would not be seen by `imports`."""
    texts = {name: path.read_text() for name, path in MODULES.items()}
    assert {
        n for n, text in texts.items() if re.search("import_module|__import__", text)
    } == BY_NAME


def test_no_attribute_is_made_on_access():
    """The package itself imports its public names on first use; no other module has the like, and
    none re-exports names of another for their users."""
    for module in MODULES.keys() - {"beamviz"}:
        text = MODULES[module].read_text()
        assert "\ndef __getattr__" not in text, module
        assert "locals()" not in text, module


@parses_everything
def test_evidence_is_imported_by_its_commands_only():
    """Each of which imports its part where it runs, so that no other command loads it."""
    evidence = [each for each in all_imports() if each.target.startswith("evidence")]
    users = {each[:2] for each in evidence if not each.module.startswith("evidence")}
    assert users == EVIDENCE_COMMANDS


@parses_everything
def test_the_space_needs_no_mechanics():
    """Of the solver it takes options, the strain laws for its first mesh, and a helper."""
    below = {"solver.problem", "solver.constitutive", "solver.solution"}
    for each in all_imports():
        if each.module.startswith("space") and each.target.startswith(("solver", "mechanics")):
            assert each.target in below, each


@parses_everything
def test_the_solver_needs_numpy_and_scipy_only():
    """Beside the standard library and the package itself."""
    for each in all_imports():
        if each.module.startswith("solver") and each.target not in MODULES:
            root = each.target.partition(".")[0]
            assert root in {*sys.stdlib_module_names, "numpy", "scipy"}, each


@parses_everything
def test_the_solver_is_used_through_its_entry_points():
    """Nothing above it imports a method, but where it needs what no solution has."""
    for each in all_imports():
        if each.target.startswith("solver.") and layer(each.module) > layer("solver"):
            parts = INSIDE_THE_SOLVER.get(each.module.partition(".")[0], set())
            assert (
                each.target in {"solver.problem", "solver.solution", "solver.stability"} | parts
            ), each


@pytest.mark.parametrize(
    ("code", "used", "unused"),
    [
        ("import beamviz", "beamviz", {"numpy", "scipy", *VIEWERS}),
        (
            "from beamviz.cli import main; modes = ['modes', '--gamma=9', '--coriolis'];"
            "main(modes); main([*modes, '--state=stable'])",
            *("scipy.linalg", LIBRARIES | VIEWERS | {"beamviz.solver.bent"}),
        ),
        *slow(
            (
                "import tempfile; from beamviz import Scene, screenshot;"
                "screenshot(tempfile.mkdtemp() + '/a.png', Scene(), 64, 64)",
                *("trimesh", {"viser", "websockets", "beamviz.server"}),
            )
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


CORE = ("session", "frame_loop", "view", "state", "snapshot", "visitor", "feature")


@pytest.mark.parametrize("name", CORE)
def test_the_core_of_the_page_imports_no_feature(name):
    module = f"explorer.{name}"
    targets = {one.target for one in imports(module, ast.parse(MODULES[module].read_text()))}
    assert not {one for one in targets if one.startswith("explorer.features")}


def test_each_feature_of_the_page_is_in_its_tuple():
    """A file of `explorer.features` that is forgotten would never be shown."""
    listed = {kind.__module__ for kind in FEATURES}
    written = {f"beamviz.{name}" for name in MODULES if name.startswith("explorer.features.")}
    assert listed == written


@parses_everything
def test_no_two_classes_have_the_same_name():
    classes = [
        node.name
        for tree in trees().values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
    ]
    assert len(classes) == len(set(classes)), [k for k in set(classes) if classes.count(k) > 1]
