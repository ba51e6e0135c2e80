"""Stairs that go one way: what the includes and imports use, against the tables of CONTRIBUTING.md.

A room (a folder of `src`, a program, a module of the package) uses rooms of lower floors only, and the table names which. An arrow counts
wherever it stands: in a header or a source, at the top of a module, inside a function or under TYPE_CHECKING. A class that is declared
without its header is an arrow to the room that defines it.
"""

import ast
import re

import pytest
from conftest import PACKAGE, ROOT

# Where the rooms of C++ lie; everything else is `src/<room>`.
FOLDERS = {"apps": "apps", "bench": "bench", "bindings": "python/bindings"}
OUTER = ("apps", "bench", "bindings")


def table_of(heading):
    """Room -> (floor, rooms that it may use), of the table under a heading of CONTRIBUTING.md."""
    text = (ROOT / "CONTRIBUTING.md").read_text()
    section = text.partition(f"### {heading}\n")[2].partition("\n#")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in section.splitlines() if re.match(r"\| \d", line)]
    assert rows, f"CONTRIBUTING.md has no table under {heading!r}"
    return {name.strip("`").removeprefix("src/"): (int(floor), set(re.findall(r"`(\w+)`", uses))) for floor, name, _, uses, *_ in rows}


def room_folder(room):
    return ROOT / FOLDERS.get(room, f"src/{room}")


def sources_of(room):
    return sorted(path for path in room_folder(room).iterdir() if path.suffix in (".cpp", ".hpp"))


def class_homes(rooms):
    """Class or struct -> the rooms that define it."""
    homes = {}
    for room in rooms:
        for path in sources_of(room):
            for name in re.findall(r"^(?:class|struct|enum class) (?:alignas\(\w+\) )?(\w+)[^;\n]*\{", path.read_text(), re.M):
                homes.setdefault(name, set()).add(room)
    return homes


def cpp_arrows(rooms):
    """(room, used room, place) of each include and of each declaration of another room's class."""
    homes = class_homes(rooms)
    for room in rooms:
        for path in sources_of(room):
            for number, line in enumerate(path.read_text().splitlines(), start=1):
                place = f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
                if included := re.match(r'\s*#\s*include "(\w+)/', line):
                    if included[1] != room:
                        yield room, included[1], place
                elif declared := re.match(r"(?:class|struct) (\w+);", line):
                    if homes.get(declared[1]) and room not in homes[declared[1]]:
                        yield from ((room, home, place) for home in homes[declared[1]])


def python_arrows(modules):
    """(module, used module, place) of each import of one of the package's own modules."""
    for module in modules:
        path = PACKAGE_SOURCE / f"{module}.py"
        for node in ast.walk(ast.parse(path.read_text())):
            used = []
            if isinstance(node, ast.ImportFrom) and node.module == "matpoint":
                used = [name.name for name in node.names]
            elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("matpoint."):
                used = [node.module.split(".")[1]]
            elif isinstance(node, ast.Import):
                used = [name.name.split(".")[1] for name in node.names if name.name.startswith("matpoint.")]
            for name in used:
                if name in modules and name != module:
                    yield module, name, f"{path.relative_to(ROOT)}:{node.lineno}: import of {name}"


PACKAGE_SOURCE = ROOT / "python/matpoint"
CPP = table_of("Rooms of C++")
PYTHON = table_of("Modules of the package")


def complaints(table, arrows):
    """A line for each arrow that the table does not have, and for each of the table's that nothing uses."""
    used = {room: set() for room in table}
    found = []
    for room, other, place in arrows:
        used[room].add(other)
        if other not in table[room][1]:
            floors = f"floor {table[room][0]} and {table[other][0]}" if other in table else "no room of the table"
            found.append(f"{place}\n    {room} uses {other} ({floors}), which its row in CONTRIBUTING.md does not list")
    for room, (_, listed) in table.items():
        found += [f"CONTRIBUTING.md: {room} is said to use {other}, and does not" for other in sorted(listed - used[room])]
    return found


@pytest.mark.parametrize("table", [CPP, PYTHON], ids=["cpp", "python"])
def test_the_table_goes_downwards_only(table):
    for room, (floor, uses) in table.items():
        for other in uses:
            assert other in table, f"{room} uses {other}, which is no room of the table"
            assert table[other][0] < floor, f"{room} (floor {floor}) uses {other} (floor {table[other][0]})"


def test_the_tables_have_all_rooms():
    assert {path.name for path in (ROOT / "src").iterdir() if path.is_dir()} == set(CPP) - set(OUTER)
    assert {path.stem for path in PACKAGE_SOURCE.glob("*.py")} == set(PYTHON)
    assert PACKAGE.is_dir()


def test_includes_go_downwards_as_the_table_says():
    found = complaints(CPP, cpp_arrows(CPP))
    assert not found, "\n".join(found)


def test_imports_go_downwards_as_the_table_says():
    found = complaints(PYTHON, python_arrows(PYTHON))
    assert not found, "\n".join(found)


def test_tests_mirror_the_rooms():
    folders = {path.name for path in (ROOT / "tests").iterdir() if path.is_dir()} - {"support", "python", "mpi", "data"}
    assert folders <= set(CPP) - set(OUTER), f"no room has the name of tests/{', tests/'.join(sorted(folders - set(CPP)))}"
