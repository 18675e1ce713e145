"""The scripts that make the environment, find a browser, and run the checks."""

import ast
import os
import re
import signal
import subprocess
import sys
import tomllib
from functools import partial
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
from helpers import SCRIPTS, load_script
from packaging.requirements import Requirement

import beamviz

posix = pytest.mark.skipif(os.name != "posix", reason="writes a shell script")
PYTHON = Path(sys.executable)
GOOD = ["timeit", "-n1", "-r1", "pass"]
BAD = ["timeit", "-n1", "-r1", "raise SystemExit(3)"]
COUNTS = [
    (file.stem, option)
    for file in SCRIPTS.glob("*.py")
    for option in re.findall(r'"(--\w+)", type=_script.count', file.read_text())
]
WRONG = {"0": "0: must be at least 1", "-3": "-3: must", **{x: repr(x) for x in ("few", "inf")}}


@pytest.fixture
def environment():
    """scripts/_environment.py."""
    return load_script("_environment")


@pytest.fixture
def browser(monkeypatch):
    """scripts/test.py, with no browser named and none found or fetched yet."""
    monkeypatch.delenv("BEAMVIZ_BROWSER", raising=False)
    module = load_script("test")
    monkeypatch.setattr(module, "working", lambda browser: browser)
    for search in ("find_browser", "from_debian", "from_playwright"):
        monkeypatch.setattr(module, search, lambda *_: None)
    return module


@pytest.fixture
def checks(monkeypatch):
    """scripts/test.py, in this environment and without a browser."""
    module = load_script("test")
    for name in ("CI", "BEAMVIZ_BROWSER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(module, "ensure", lambda extra: PYTHON)
    monkeypatch.setattr(module, "find_or_fetch", lambda python: None)
    return module


@pytest.fixture
def project(tmp_path, environment, monkeypatch):
    """A project folder and what was done to install it, with pip and venv replaced."""
    (tmp_path / "pyproject.toml").write_text("one")
    done: list[str] = []

    def create(venv):
        environment.python_of(venv).parent.mkdir(parents=True, exist_ok=True)
        environment.python_of(venv).touch()

    monkeypatch.setattr(environment, "create", create)
    monkeypatch.setattr(environment, "install", lambda venv, root, extra: done.append(extra))
    return tmp_path, done


def executable(path: Path, code: str) -> Path:
    path.write_text(f"#!/bin/sh\n{code}\n")
    path.chmod(0o755)
    return path


@pytest.mark.parametrize("name", ["serve", "test"])
def test_the_scripts_start_with_any_python(name):
    """Python 3.10 ends with a sentence: no syntax newer than Python 3.7 stands before it. They load
    before anything is installed, with the search of the tests for a browser."""
    for file in (name, "_environment"):
        ast.parse((SCRIPTS / f"{file}.py").read_text(), feature_version=(3, 7))
    load = f"import runpy, sys; sys.path.insert(0, {str(SCRIPTS)!r}); "
    run = f"runpy.run_path({str(SCRIPTS / f'{name}.py')!r}, run_name='loaded')"
    python = [sys.executable, "-I", "-S", "-c"]
    subprocess.run([*python, load + run], check=True)
    old = load + "sys.version_info = (3, 10, 4, 'final', 0); " + run
    done = subprocess.run([*python, old], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr.startswith("beamviz needs Python 3.11 or newer; this is Python 3.10")
    assert done.stderr.count("\n") == 1


def test_an_installation_is_made_once_and_reused(environment, project, tmp_path):
    """What the tests need includes what the explorer needs, and not the other way round. It is made
    again for a changed pyproject.toml and for a moved project, to whose old place it points."""
    root, done = project

    def ensured(extra: str = "all") -> list[str]:
        python = environment.ensure(extra, root=root, venv=root / "venv")
        assert python == environment.python_of(root / "venv")
        return done

    assert ensured() == ensured() == ["all"]
    assert ensured("test") == ensured() == ["all", "test"]
    (root / "pyproject.toml").write_text("two")
    assert ensured() == ["all", "test", "all"]
    root = root.rename(tmp_path.with_name(tmp_path.name + "-moved"))
    assert ensured() == ["all", "test", "all", "all"]


def brought_by(extra: str) -> set[str]:
    """The packages that pyproject.toml names for beamviz with one of its extras, in lower case."""
    project = tomllib.loads((SCRIPTS.parent / "pyproject.toml").read_text())["project"]
    extras, found = project["optional-dependencies"], set()
    waiting = [*project["dependencies"], *extras[extra]]
    while waiting:
        named = Requirement(waiting.pop())
        found |= {named.name} - {project["name"]}
        waiting += [line for other in named.extras for line in extras[other]]
    return found


@pytest.mark.slow
def test_the_explorer_has_every_package_that_beamviz_imports(monkeypatch):
    """A user of scripts/serve.py meets no "pip install": its environment has all that any module
    of beamviz imports anywhere, except the peers of the benchmark. That of the tests has it too."""
    serve, started = load_script("serve"), []
    monkeypatch.setattr(serve, "ensure", lambda extra: started.append(extra) or PYTHON)
    monkeypatch.setattr(serve.os, "execv", lambda *_: None)
    serve.main()
    assert started == ["all"]
    imported = set()
    for file in (SCRIPTS.parent / "beamviz").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                imported |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                imported.add(str(node.module).split(".")[0])
    distributions = packages_distributions()
    foreign = imported - {*sys.stdlib_module_names, "beamviz"}
    needed = {distributions.get(module, [module])[0].lower() for module in foreign}
    assert {"av", "distributed", "pandas", "xarray", "zarr"} <= needed
    peers = brought_by("peers")
    assert needed - peers <= brought_by("all") <= brought_by("test")


def test_an_interrupted_installation_is_done_again(
    environment, project, monkeypatch, interruptible
):
    """The stamp comes last and old ones go first: half an installation is not taken for whole."""
    root, done = project
    ensure = partial(environment.ensure, root=root, venv=root / "venv")
    ensure("all")
    with monkeypatch.context() as during:
        during.setattr(environment, "install", lambda *_: signal.raise_signal(signal.SIGINT))
        with pytest.raises(KeyboardInterrupt):
            ensure("test")
    ensure("all")
    assert done == ["all", "all"]


@posix
def test_a_python_without_ensurepip_is_told_the_remedy(environment, tmp_path, monkeypatch):
    """Debian's Python without python3-venv leaves no half environment behind."""
    says = "echo The virtual environment was not created because ensurepip is not available"
    fake = executable(tmp_path / "python", f"mkdir -p {tmp_path}/venv/bin; {says}; exit 1")
    monkeypatch.setattr(sys, "executable", str(fake))
    with pytest.raises(SystemExit, match="apt-get install python3-venv"):
        environment.create(tmp_path / "venv")
    assert not (tmp_path / "venv").exists()


@posix
def test_a_failed_installation_ends_the_script(environment, tmp_path):
    python = environment.python_of(tmp_path)
    python.parent.mkdir()
    executable(python, "exit 1")
    with pytest.raises(SystemExit, match="installation failed"):
        environment.install(tmp_path, tmp_path, "test")


def test_a_browser_that_is_there_comes_first(browser, monkeypatch):
    """Then Debian's, then Playwright's, then none. BEAMVIZ_BROWSER is an order: none means none,
    and one that does not start is an error."""
    assert browser.find_or_fetch(PYTHON) is None
    for search in ("from_playwright", "from_debian", "find_browser"):
        monkeypatch.setattr(browser, search, lambda *_, found=search: found)
        assert browser.find_or_fetch(PYTHON) == search
    monkeypatch.setenv("BEAMVIZ_BROWSER", "none")
    assert browser.find_or_fetch(PYTHON) is None
    monkeypatch.setattr(browser, "find_browser", lambda: None)
    monkeypatch.setenv("BEAMVIZ_BROWSER", "mosaic")
    with pytest.raises(SystemExit, match="BEAMVIZ_BROWSER = mosaic: does not start"):
        browser.find_or_fetch(PYTHON)


@posix
def test_only_a_browser_that_starts_is_used(tmp_path, monkeypatch):
    """A command that only tells how to install a browser is not one; and a user who is not root
    gets no failing apt-get."""
    module = load_script("test")
    good, stub = (str(executable(tmp_path / f"exit {k}", f"exit {k}")) for k in (0, 1))
    found = [module.working(one) for one in (good, stub, str(tmp_path / "missing"), None)]
    assert found == [good, None, None, None]
    monkeypatch.setattr(module, "succeeded", lambda command: pytest.fail(f"ran {command}"))
    monkeypatch.setattr(module.shutil, "which", lambda name: f"/usr/bin/{name}")
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    assert module.from_debian(PYTHON) is None


@pytest.mark.parametrize(("name", "option"), COUNTS)
def test_a_wrong_number_is_an_error_of_one_line(monkeypatch, capsys, name, option):
    """It names the option and the value; nothing is measured."""
    script = load_script(name)
    for value, problem in WRONG.items():
        monkeypatch.setattr(sys, "argv", [f"{name}.py", f"{option}={value}"])
        with pytest.raises(SystemExit) as ended:
            script.main()
        error = capsys.readouterr().err
        assert (ended.value.code, error.count("\n")) == (2, 1)
        assert error.startswith(f"{name}.py: argument {option}: ")
        assert problem in error


def test_names_may_be_left_out_and_a_wrong_one_is_an_error_of_one_line(capsys):
    script = load_script("_script")
    parser = script.Parser("")
    parser.add_argument("names", nargs="*", type=script.one_of({"a": 1, "b": 2}))
    assert parser.parse_args([]).names == []
    assert parser.parse_args(["b", "a"]).names == ["b", "a"]
    with pytest.raises(SystemExit) as ended:
        parser.parse_args(["a", "c"])
    error = capsys.readouterr().err
    assert (ended.value.code, error.count("\n")) == (2, 1)
    assert "c: must be one of a, b" in error


@pytest.mark.slow
@pytest.mark.parametrize("name", ["benchmark", "validation"])
def test_a_script_ends_with_one_line_for_a_wrong_argument(name):
    command = [PYTHON, SCRIPTS / f"{name}.py", "--wrong"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)


def test_every_option_that_counts_is_known():
    """Other whole numbers are seeds."""
    scripts = {"load", "fuzz", "measure_error_bars", "measure_motion_error_bars", "several_servers"}
    assert {name for name, _ in COUNTS} == scripts
    text = "".join(file.read_text() for file in SCRIPTS.glob("*.py"))
    assert set(re.findall(r'"--(\w+)", type=int', text)) <= {"seed"}


@pytest.mark.parametrize("bad", ["types", "tests"])
def test_the_exit_code_says_whether_every_check_passed(checks, monkeypatch, capfd, bad):
    """One failure is a failure, in the background too, and the checks after it still run."""
    every = dict.fromkeys(("types", "lint", "tests"), GOOD)
    monkeypatch.setattr(checks, "CHECKS", every)
    assert checks.main([]) == 0
    monkeypatch.setattr(checks, "CHECKS", every | {bad: BAD})
    assert checks.main([]) == 1
    told = capfd.readouterr().err
    for words in ("all checks passed", "tests: passed", f"{bad}: FAILED"):
        assert words in told
    assert told.rstrip().endswith(f"FAILED: {bad}")


def test_arguments_are_passed_on_to_pytest(checks, monkeypatch, capfd):
    """`scripts/test.py -k name` runs a part of the tests; `--all` adds the slow ones: an expression
    of markers on the command line replaces the one of pyproject.toml."""
    monkeypatch.setattr(checks, "CHECKS", {"lint": GOOD, "tests": ["timeit", "-n1"]})
    assert checks.main(["raise SystemExit(3)"]) == 1
    assert capfd.readouterr().err.rstrip().endswith("FAILED: tests")
    assert checks.pytest_options(["--all", "-k", "name"]) == ["-m", "", "-k", "name"]
    assert checks.pytest_options(["-k", "name"]) == ["-k", "name"]
    assert checks.main(["--help"]) == 0

    assert "options of pytest" in capfd.readouterr().out


def test_a_missing_browser_fails_where_every_test_must_run(checks, monkeypatch, capfd):
    """With CI set, as .ci/run does; elsewhere, or where none is asked for, tests are skipped."""
    monkeypatch.setattr(checks, "CHECKS", {"tests": GOOD})
    assert checks.main([]) == 0
    monkeypatch.setenv("CI", "true")
    assert checks.main([]) == 1
    assert capfd.readouterr().err.rstrip().endswith("FAILED: browser")
    monkeypatch.setenv("BEAMVIZ_BROWSER", "none")
    assert checks.main([]) == 0


@pytest.mark.slow
def test_the_reference_has_every_public_name(tmp_path):
    """As pdoc makes it, whose warnings are errors here; each with a docstring."""
    page = load_script("reference").write_reference(tmp_path).read_text()
    for name in set(beamviz.__all__) - {"__version__"}:
        section = page.partition(f'<section id="{name}">')[2].partition("</section>")[0]
        assert 'class="docstring"' in section, name
