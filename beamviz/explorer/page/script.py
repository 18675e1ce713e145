"""A line of JavaScript for the page: its server may not run any there, its own elements may."""

from html import escape


def running(script: str) -> str:
    """An element that runs `script` when it is added: an image that cannot be loaded does, a
    script element in HTML that comes later does not."""
    return f'<img alt="" src="data:," style="display:none" onerror="{escape(script)}">'
