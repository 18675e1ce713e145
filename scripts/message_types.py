"""Write the types of what pages are given for their scripts: messages.d.ts and offline.d.ts.

python scripts/message_types.py

The types are those of beamviz/explorer/page/messages.py, of the actions that the features of the
page declare, and of beamviz/exports/offline_data.py; run this after a change of them.
"""

from types import ModuleType
from typing import Any
from unittest.mock import MagicMock

import _script
import msgspec.inspect as types
from msgspec import Struct

from beamviz.explorer.links import PAGE
from beamviz.explorer.page import messages
from beamviz.explorer.state import State
from beamviz.explorer.visitor import Visitor
from beamviz.exports import offline_data
from beamviz.scene import START

PATH = _script.ROOT / "beamviz" / "explorer" / "page" / "messages.d.ts"
OFFLINE = _script.ROOT / "beamviz" / "exports" / "offline.d.ts"
HEAD = """\
// The messages between server and page, written by scripts/message_types.py from messages.py and
// from what the features of the page declare.

"""
OFFLINE_HEAD = """\
// The data of exported pages, written by scripts/message_types.py from offline_data.py. Columns of
// numbers over speeds or moments are second differences until `undoSteps`.

type Vec3 = [number, number, number];

"""
NAMES = {types.StrType: "string", types.IntType: "number", types.FloatType: "number"}
NAMES |= {types.BoolType: "boolean", types.NoneType: "null"}


def typescript(kind: types.Type) -> str:
    """A type as TypeScript has it."""
    if isinstance(kind, types.StructType):
        return kind.cls.__name__
    if isinstance(kind, types.UnionType):
        return " | ".join(dict.fromkeys(map(typescript, kind.types)))  # without UNSET
    if isinstance(kind, types.ListType):
        return f"Array<{typescript(kind.item_type)}>"
    if isinstance(kind, types.TupleType):
        return f"[{', '.join(map(typescript, kind.item_types))}]"
    if isinstance(kind, types.DictType):
        return f"Record<string, {typescript(kind.value_type)}>"
    return NAMES[type(kind)]


def interface(struct: type[Struct]) -> str:
    """A record as TypeScript has it; a field with a default may be missing in a message."""
    fields = types.type_info(struct).fields  # type: ignore[attr-defined]
    omits = struct.__struct_config__.omit_defaults
    lines = []
    for field in fields:
        mark = "?" if omits and not field.required else ""
        lines.append(f"  {field.encode_name}{mark}: {typescript(field.type)};\n")
    return f"interface {struct.__name__} {{\n{''.join(lines)}}}\n"


def actions() -> dict[str, Any]:
    """The types of the values of all actions by their names, as a visitor's features declare them;
    the visitor may follow a presenter, has no browser, and nothing is solved."""
    visitor = Visitor(MagicMock(), State.of(START), MagicMock(), MagicMock(), MagicMock())
    for kind in PAGE:
        kind(visitor)
    return {name: one.takes for name, one in sorted(visitor.page.actions.items())}


def interfaces(module: ModuleType) -> list[str]:
    """The records of a module that have fields."""
    structs = [one for one in vars(module).values() if isinstance(one, type)]
    own = [one for one in structs if issubclass(one, Struct) and one.__struct_fields__]
    return [interface(one) for one in own]


def offline_declarations() -> str:
    """The data of exported pages."""
    return OFFLINE_HEAD + "\n".join(interfaces(offline_data))


def declarations() -> str:
    """All messages."""
    taken = {name: typescript(types.type_info(kind)) for name, kind in actions().items()}
    lines = "".join(f'  "{name}": {kind};\n' for name, kind in taken.items())
    names = f"interface Actions {{ // the types of their values\n{lines}}}\n"
    return HEAD + "\n".join([*interfaces(messages), names])


if __name__ == "__main__":
    _script.Parser(__doc__).parse_args()
    for path, text in ((PATH, declarations()), (OFFLINE, offline_declarations())):
        path.write_text(text)
        print(path)
