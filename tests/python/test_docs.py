"""docs/case_file.md says the same as the declarations that the program reads case files with."""

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).resolve().parents[2] / "docs/case_file.md"
HEADINGS = {
    "materials": "Materials",
    "regions": "Regions",
    "layouts": "Layouts",
    "velocities": "Velocities",
    "initial_stresses": "Initial stresses",
}
KINDS = {"materials": "material", "regions": "region", "layouts": "layout", "velocities": "velocity", "initial_stresses": "initial_stress"}


def declared(matpoint, name, kind="section"):
    """{parameter: (unit, is required)} as `matpoint explain` prints them; two spaces or more between columns."""
    parameters = {}
    for topic in matpoint("explain", name).stdout.split("\n\n"):
        if topic.startswith(kind + " "):
            for line in re.findall(r"^  (\S.*)$", topic, re.M)[1:]:
                key, _, unit, default = re.split(r" {2,}", line)[:4]
                parameters[key] = (unit, default == "required")
    return parameters


def tables(heading):
    """{type: {key: (unit, is required)}} of the tables below a heading; the type is empty where the table has no such column."""
    section = re.search(rf"^## {heading}\n(.*?)(?=^## |\Z)", PAGE.read_text(), re.M | re.S)
    assert section, f'docs/case_file.md has no "## {heading}"'
    found, columns, kind = {}, [], ""
    for line in re.findall(r"^\| (.*) \|$", section[1], re.M):
        cells = [cell.strip() for cell in re.split(r"(?<!\\)\|", line)]
        if "key" in cells:
            columns = cells
        elif cells[0].startswith("---"):
            continue
        else:
            row = dict(zip(columns, cells))
            if row.get("type"):
                kind = re.match(r"`(\w+)`", row["type"])[1]
            found.setdefault(kind, {})[row["key"].strip("`")] = (row["unit"] or "1", row["default"] == "required")
    return found


def test_every_section_has_its_keys_with_unit_and_whether_they_are_required(matpoint):
    sections = re.findall(r"^  (\S+)", matpoint("list", "sections").stdout, re.M)
    assert len(sections) >= 8
    for section in sections:
        parameters = declared(matpoint, section)
        assert parameters
        assert tables("top" if section == "case" else section)[""] == parameters, section


@pytest.mark.parametrize("what", HEADINGS)
def test_every_type_has_its_keys_with_unit_and_whether_they_are_required(matpoint, what):
    names = re.findall(r"^  (\S+)", matpoint("list", what).stdout, re.M)
    documented = tables(HEADINGS[what])
    assert sorted(documented) == sorted(names)
    for name in names:
        parameters = declared(matpoint, name, KINDS[what])
        assert parameters
        assert documented[name] == parameters, name


def test_every_particle_field_and_command_is_named(matpoint):
    page = PAGE.read_text()
    for field in re.findall(r"^  (\S+)", matpoint("list", "fields").stdout, re.M):
        assert field == "position" or f"`{field}`" in page, field


def test_every_history_column_is_named(matpoint, tmp_path):
    assert matpoint("run", "disks", "--set", "time.end=1e-3", "--out", "r").returncode == 0
    page = PAGE.read_text()
    for column in (tmp_path / "r/history.csv").read_text().splitlines()[0].split(","):
        if "." not in column:  # a body's columns are the totals again
            assert f"`{re.sub('_y$', '_x', column)}`" in page, column


def test_the_first_example_is_a_valid_case(matpoint, tmp_path):
    (tmp_path / "ball.toml").write_text(re.search(r"```toml\n(.*?)```", PAGE.read_text(), re.S)[1])
    done = matpoint("check", "ball.toml")
    assert done.returncode == 0 and done.stderr == "", done.stderr


def test_every_example_of_set_works(matpoint):
    commands = re.findall(r"^matpoint run dam (--set .*?)(?: +#.*)?$", PAGE.read_text(), re.M)
    assert len(commands) == 5
    for command in commands:
        arguments = [word.strip("'") for word in re.findall(r"'[^']*'|\S+", command)]
        done = matpoint("check", "dam", *arguments)
        assert done.returncode == 0, done.stderr


def test_every_shipped_case_has_a_page(matpoint):
    for name in re.findall(r"^  (\S+)", matpoint("list", "cases").stdout, re.M):
        assert (PAGE.parent / "cases" / f"{name.removesuffix('_slim')}.md").exists(), name


def test_every_parameter_set_is_listed_with_its_law_and_explained_with_its_numbers(matpoint):
    names = re.findall(r"^  (\S+)", matpoint("list", "parameter_sets").stdout, re.M)
    assert len(names) > 8
    rows = dict(re.findall(r"^\| `(\w+)` \| `(\w+)` \|", PAGE.read_text(), re.M))
    for name in names:
        explained = matpoint("explain", name).stdout
        assert f'type = "{rows[name]}"' in explained and "density = " in explained
