"""Writes parts.pyi, the type stub of the classes that matpoint.parts makes at run time: `python stub_parts.py FILE`."""

import sys
from pathlib import Path

from matpoint.parts import class_names, docstring

HEAD = '''"""The parts of a case as Python objects: sections, regions, layouts, velocities, materials and rules."""

from typing import Any, ClassVar

__all__ = [{names}]

class Part(dict[str, Any]):
    _parameters: ClassVar[tuple[str, ...]]
    _type: ClassVar[str | None]
    def __init__(self, **parameters: Any) -> None: ...
    def __getattr__(self, name: str) -> Any: ...
    def __setattr__(self, name: str, value: Any) -> None: ...
    def __delattr__(self, name: str) -> None: ...

def docstring(entry: dict[str, Any], title: str) -> str: ...
def class_names() -> list[tuple[str, str, dict[str, Any], str]]: ...
def part_of(key: str, value: Any) -> Any: ...
def empty_section(name: str) -> Part: ...
'''


def main() -> None:
    parts = class_names()
    text = HEAD.replace("{names}", ", ".join(f'"{name}"' for name in ["Part", *(name for name, *_ in parts)]))
    for name, _, entry, title in parts:
        doc = docstring(entry, title).replace("\\", "\\\\").replace("\n", "\n    ")
        parameters = "".join(f", {p['name']}: Any{'' if p['is_required'] else ' = ...'}" for p in entry["parameters"])
        text += f'\nclass {name}(Part):\n    """{doc}\n    """\n\n'
        text += f"    def __init__(self, *{parameters}) -> None: ...\n" if parameters else "    def __init__(self) -> None: ...\n"
    Path(sys.argv[1]).write_text(text, encoding="utf-8")


main()
