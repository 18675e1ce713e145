"""The features of the page, one file each: every class of a file here that extends `Feature` is
one. A new file needs no other entry."""

from importlib import import_module
from pkgutil import iter_modules

from beamviz.explorer.feature import Feature

for found in iter_modules(__path__):
    import_module(f"{__name__}.{found.name}")
FEATURES = tuple(Feature.__subclasses__())
