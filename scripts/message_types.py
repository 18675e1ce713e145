"""Write the types of the messages between server and page for its scripts: messages.d.ts.

python scripts/message_types.py

The types are those of beamviz/explorer/page/messages.py; run this after a change of them.
"""

import _script
import msgspec.inspect as types
from msgspec import Struct

from beamviz.explorer.page import messages

PATH = _script.ROOT / "beamviz" / "explorer" / "page" / "messages.d.ts"
HEAD = """\
// The messages between server and page, written by scripts/message_types.py from messages.py.

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


def declarations() -> str:
    """All messages."""
    structs = [one for one in vars(messages).values() if isinstance(one, type)]
    own = [one for one in structs if issubclass(one, Struct) and one is not Struct]
    action = f"type Action = {typescript(types.type_info(messages.Action))};\n"
    return HEAD + "\n".join([*map(interface, own), action])


if __name__ == "__main__":
    _script.Parser(__doc__).parse_args()
    PATH.write_text(declarations())
    print(PATH)
