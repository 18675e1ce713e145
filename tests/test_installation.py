"""What is told to be installed is this program and the libraries it declares, in this Python, and
never the other program that PyPI has under the name of the import."""

import re
import shlex
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from beamviz import installation
from beamviz.errors import Unavailable, requires
from beamviz.installation import DISTRIBUTION, install_command

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
EXTRAS = PROJECT["optional-dependencies"]
DECLARED = [*map(Requirement, sum(EXTRAS.values(), PROJECT["dependencies"]))]
TEXTS = [
    *(ROOT / "beamviz").rglob("*.py"),
    *(ROOT / "scripts").glob("*.py"),
    *(ROOT / "assets").rglob("*.md"),
    *(ROOT / "assets").rglob("*.ipynb"),
    *(ROOT / "assets" / "examples").glob("*.py"),
    *(ROOT / name for name in ("README.md", "CHANGELOG.md", "CITATION.cff")),
]
HINT = re.compile(r"pip install ([^)\n`{]+)")


def words_of(hint: str) -> list[str]:
    """What a hint installs: the words before its end."""
    words = shlex.split(hint.replace('"\n', " ").partition('"')[0])
    taken = []
    for word in words:
        if not re.fullmatch(r"-e|\.(\[\w+\])?|[\w-]+(\[[\w,]+\])?([<>=~!].*)?", word):
            break
        taken.append(word)
    return taken


def hints() -> list[tuple[str, str]]:
    """Each word after "pip install" in the sources and pages, and its file."""
    found = []
    for file in TEXTS:
        for hint in HINT.findall(file.read_text()):
            found += [(file.name, word) for word in words_of(hint) if word != "-e"]
    return found


@pytest.mark.parametrize(("file", "word"), hints())
def test_a_hint_names_the_folder_or_a_library_that_is_declared(file, word):
    """Extras of the folder exist; a library has the versions that the project declares, if any."""
    if word.startswith("."):
        assert word == "." or word[2:-1] in EXTRAS
        return
    named = Requirement(word)
    declared = [one.specifier for one in DECLARED if one.name == named.name]
    assert declared
    assert named.specifier in ("", *declared)


def test_the_texts_have_hints():
    """Of the folder and of libraries: the test above has seen them."""
    assert {".[all]", ".[sweep]", "av", "exudyn", "viser>=1.1,<1.2"} <= {
        word for _, word in hints()
    }


@pytest.mark.parametrize("extra", sorted(EXTRAS))
def test_in_the_folder_of_the_source_it_is_installed_again(extra):
    """By this Python; pip knows the folder by its pyproject.toml."""
    python, *pip, place = shlex.split(install_command(extra, "missing"))
    assert (python, pip) == (sys.executable, ["-m", "pip", "install", "-e"])
    assert place == f"{ROOT}[{extra}]"
    assert PROJECT["name"] == DISTRIBUTION
    assert DISTRIBUTION in (ROOT / "README.md").read_text()
    assert DISTRIBUTION in (ROOT / "CITATION.cff").read_text()


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """This program installed as a wheel, with its metadata."""
    lines = [
        f'Requires-Dist: {line}; extra == "{extra}"' for extra in EXTRAS for line in EXTRAS[extra]
    ]
    info = tmp_path / f"{DISTRIBUTION.replace('-', '_')}-0.1.0.dist-info"
    info.mkdir()
    head = ["Metadata-Version: 2.4", f"Name: {DISTRIBUTION}", "Version: 0.1.0"]
    (info / "METADATA").write_text("\n".join([*head, *lines, ""]))
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(installation, "SOURCE", tmp_path)


@pytest.mark.parametrize("extra", sorted(EXTRAS))
def test_elsewhere_its_libraries_are_installed(extra, elsewhere):
    """Those of the extra, and of the extras within, which are of this distribution."""

    def needed(extra: str) -> set[Requirement]:
        found = set[Requirement]()
        for one in map(Requirement, EXTRAS[extra]):
            own = canonicalize_name(one.name) == DISTRIBUTION
            found |= set().union(*map(needed, one.extras)) if own else {one}
        return found

    python, *pip = shlex.split(install_command(extra, "missing"))
    assert (python, pip[:3]) == (sys.executable, ["-m", "pip", "install"])
    assert {*map(Requirement, pip[3:])} == needed(extra)


def test_without_any_installation_it_is_the_library_that_is_missing(tmp_path, monkeypatch):
    """As where the package is run from a copy of its folder only."""
    monkeypatch.setattr(installation, "SOURCE", tmp_path)
    monkeypatch.setattr(installation, "DISTRIBUTION", "of-no-such-name")
    assert shlex.split(install_command("film", "av"))[1:] == ["-m", "pip", "install", "av"]


def test_the_error_of_a_missing_library_has_the_command():
    with pytest.raises(Unavailable) as caught, requires("sweep"):
        raise ImportError("none here", name="zarr")
    assert str(caught.value).startswith(f"this needs zarr: {install_command('sweep', 'zarr')} (")
