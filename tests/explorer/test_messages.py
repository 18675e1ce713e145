"""What travels between server and page is one declared set of messages, on both sides."""

import json
import shutil
import subprocess

import msgspec
import pytest
from helpers import load_script

from beamviz.explorer import page
from beamviz.explorer.page import messages

TYPES = load_script("message_types")
CHECK = load_script("check_page")


def test_the_types_of_the_page_are_those_of_the_server():
    """messages.d.ts is written from messages.py."""
    assert TYPES.PATH.read_text() == TYPES.declarations()


def test_an_update_has_the_declared_types():
    """A part that is not declared in this form is refused, before it is sent."""
    assert json.loads(messages.encode_update({"html": {"work": ""}})) == {"html": {"work": ""}}
    for wrong in (
        {"html": {"work": 1}},
        {"charts": {"loci-chart": {"cursor": {"action": "gamma", "x": "5"}}}},
        {"charts": {"loci-chart": {"marks": [{"key": "a"}]}}},
        {"captions": [{"name": "/scene", "text": "B1"}]},
    ):
        with pytest.raises(msgspec.ValidationError):
            messages.encode_update(wrong)


@pytest.mark.parametrize("text", ["", "[1]", '[1, "a", []]', '["1", "a", 1]', '[1, "a", NaN]'])
def test_an_action_has_the_declared_types(text):
    """A number, a name and a plain value."""
    assert messages.decode_action('[1, "gamma", 5.5]') == (1, "gamma", 5.5)
    assert messages.decode_action(f'[1, "gamma", {10**40}]')[2] == 1e40
    with pytest.raises(msgspec.MsgspecError):
        messages.decode_action(text)


@pytest.mark.skipif(not shutil.which("tsc"), reason="TypeScript is not installed")
def test_the_scripts_of_the_page_have_these_types():
    """As scripts/check_page.py checks them, here only where tsc is installed."""
    command = [*CHECK.compiler(), "-p", str(CHECK.PROJECT)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stdout == ""
    assert done.returncode == 0


def test_negative_numbers_have_a_minus_sign_and_what_is_typed_and_named_a_hyphen():
    """In HTML outside tags; an exponent and a range of whole numbers stay."""
    html = '<a data-value="-1">-1.5</a> TP-500-38, 1e-06, 4-5, (-.2), δ = -1 .. 2'
    expected = '<a data-value="-1">−1.5</a> TP-500-38, 1e-06, 4-5, (−.2), δ = −1 .. 2'
    assert page.html("id", html) == {("html", "id"): expected}
