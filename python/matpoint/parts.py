"""The parts of a case as Python objects: sections, regions, layouts, velocities, materials and rules.

They are made from the core's own list, so that Python, case files and C++ have the same names: the region `half_space` is the class
`HalfSpace`, its parameters are the keywords. A part is a dict with the keys of a case file; keys are attributes, too:

    disk = Disk(center=(0.3, 0.3), radius=0.2)
    disk.radius = 0.1
"""

from __future__ import annotations

from typing import Any, ClassVar

from matpoint import _core
from matpoint.errors import did_you_mean

__all__ = ["Part"]


class Part(dict[str, Any]):
    """A table of a case file. Use the classes made from it, e.g. `Box`, `Grid` or `NeoHookean`.

    Args:
        parameters: The keys of the table; lengths in m, times in s, SI units throughout.

    Raises:
        InputError: There is no such parameter. What values are allowed is checked when the case is built.
    """

    _parameters: ClassVar[tuple[str, ...]] = ()
    _type: ClassVar[str | None] = None

    def __init__(self, **parameters: Any) -> None:
        super().__init__()
        if self._type is not None:
            self["type"] = self._type
        for name, value in parameters.items():
            self._check(name)
            if value is not None:
                self[name] = value

    def _check(self, name: str) -> None:
        if name in self._parameters or name == "type":
            return
        known = ", ".join(self._parameters)
        hint = did_you_mean(name, list(self._parameters))
        raise _core.InputError(f'{type(self).__name__}: unknown parameter "{name}"; known: {known}{hint}')

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"{type(self).__name__} has no {name}") from None

    def __setattr__(self, name: str, value: Any) -> None:
        self._check(name)
        self[name] = value

    def __delattr__(self, name: str) -> None:
        self._check(name)
        self.pop(name, None)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{k}={v!r}' for k, v in self.items() if k != 'type' or self._type is None)})"

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._parameters]


def _class_name(word: str) -> str:
    return "".join(part.capitalize() for part in word.split("_"))


def docstring(entry: dict[str, Any], title: str) -> str:
    """The class docstring of a part: its summary and its parameters with units and what is allowed."""
    lines = [entry["summary"], "", title, "", "Args:"]
    for p in entry["parameters"]:
        unit = "" if p["unit"] == "1" else f" [{p['unit']}]"
        notes = [p["type"]]
        if p["allowed"]:
            notes.append(f"allowed: {p['allowed']}")
        if p["default"]:
            notes.append(f"default: {p['default']}")
        elif not p["is_required"]:
            notes.append("may be left out")
        lines.append(f"    {p['name']}: {p['help'].rstrip('.')}{unit}. {'; '.join(notes)}.")
    lines += ["", "Raises:", "    InputError: There is no such parameter."]
    return "\n".join(lines)


def class_names() -> list[tuple[str, str, dict[str, Any], str]]:
    """For each part: class name, its `type` in a case file ("" for a section), its description, and a line on where it is used."""
    vocabulary = _core.vocabulary()
    kinds = {
        "sections": ("", "A section of a case."),
        "regions": ("", "A region, for bodies, boundaries and loads."),
        "layouts": ("", "A layout, for bodies."),
        "velocities": ("Velocity", "A velocity by place: of a body at its start, or prescribed by a boundary."),
        "initial_stresses": ("Stress", "A stress that a body starts with."),
        "materials": ("", "A material, for bodies."),
        "rules": ("Rule", "How long the next step is, for `Time` and the implicit solver."),
    }
    found = []
    sections = {entry["name"]: entry for entry in vocabulary["sections"]}
    # One class for [solver], whose keys depend on its type.
    implicit = sections["implicit_solver"]["parameters"]
    explicit = sections["solver"]["parameters"]
    shared = {p["name"] for p in explicit}
    summary = f"{sections['solver']['summary']} Or {sections['implicit_solver']['summary']}"
    sections["solver"] = {
        **sections["solver"],
        "summary": summary,
        "parameters": explicit + [p for p in implicit if p["name"] not in shared],
    }
    del sections["implicit_solver"], sections["case"]
    vocabulary = {**vocabulary, "sections": list(sections.values())}
    for kind, (suffix, title) in kinds.items():
        for entry in vocabulary[kind]:
            found.append((_class_name(entry["name"]) + suffix, "" if kind == "sections" else entry["name"], entry, title))
    return found


# type -> class, for reading case files; stresses have names of their own.
_typed: dict[str, type[Part]] = {}
_stresses: dict[str, type[Part]] = {}
_sections: dict[str, type[Part]] = {}


def _make_classes() -> None:
    for name, type_name, entry, title in class_names():
        members = {
            "__doc__": docstring(entry, title),
            "__module__": __name__,
            "_parameters": tuple(p["name"] for p in entry["parameters"]),
            "_type": type_name or None,
        }
        made = type(name, (Part,), members)
        globals()[name] = made
        __all__.append(name)
        if type_name:
            (_stresses if name.endswith("Stress") else _typed)[type_name] = made
        else:
            _sections[entry["name"]] = made


_make_classes()


def part_of(key: str, value: Any) -> Any:
    """A value of a case file with its tables as parts; `key` is the key that it stands under."""
    if isinstance(value, dict):
        kind = _sections.get(key) or (_stresses if key == "initial_stress" else _typed).get(str(value.get("type"))) or None
        items = {name: part_of(name, item) for name, item in value.items()}
        if kind is None:
            return items
        made = kind()
        made.update(items)
        return made
    if isinstance(value, (list, tuple)):
        return type(value)(part_of(key, item) for item in value)
    return value


def empty_section(name: str) -> Part:
    """An empty section, e.g. for "solver"."""
    return _sections[name]()
