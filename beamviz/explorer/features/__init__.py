"""The features of the page, one file each: every class of a file here that extends Feature is one.
A new file needs no other entry."""

from importlib import import_module
from pkgutil import iter_modules

from beamviz.explorer.feature import Feature

MODULES = [import_module(f"{__name__}.{found.name}") for found in iter_modules(__path__)]
FEATURES = tuple(
    kind
    for module in MODULES
    for kind in vars(module).values()
    if isinstance(kind, type) and issubclass(kind, Feature) and kind.__module__ == module.__name__
)
