"""Cases: the whole problem as data, from keywords or from a case file."""

from __future__ import annotations

import copy
import html
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from matpoint import _core
from matpoint.functions import Floats, FunctionLaw, Where, name_of, positional_count
from matpoint.parts import Part, empty_section, part_of

if TYPE_CHECKING:
    from matpoint.simulation import Simulation

_TABLES = ("grid", "time", "solver", "output")
_LISTS = ("body", "boundary", "probe")
_VALUES = ("title", "source", "dim", "gravity", "gravity_times", "gravity_factors", "body_force")


@dataclass(frozen=True)
class CaseReport:
    """What a run of a case would be, from `Case.check`.

    Attributes:
        particles: Particles per body.
        nodes: Nodes of the grid.
        dt: The first time step [s].
        steps: Steps to the end with that step.
        memory: Bytes of particles and grid.
        warnings: Things that work as asked but probably not as meant, a sentence each.
        resolved: All values of the case with their defaults, as in a case file.
    """

    particles: dict[str, int]
    nodes: int
    dt: float
    steps: int
    memory: int
    warnings: list[str]
    resolved: dict[str, Any]

    def _repr_html_(self) -> str:
        rows = [("particles", ", ".join(f"{name} {count}" for name, count in self.particles.items())), ("nodes", self.nodes)]
        rows += [("first step", f"{self.dt:.4g} s"), ("steps", self.steps), ("memory", f"{self.memory / 1e6:.1f} MB")]
        rows += [("warning", text) for text in self.warnings]
        return _table(rows)


def _table(rows: Iterable[tuple[str, Any]]) -> str:
    cells = "".join(
        f"<tr><th style='text-align:left'>{html.escape(k)}</th><td style='text-align:left'>{html.escape(str(v))}</td></tr>" for k, v in rows
    )
    return f"<table>{cells}</table>"


class Case:
    """A problem: what a case file holds, under the same names.

    Args:
        name: Names the results; a file's stem for a case that was read.
        sections: The keys of a case file: title, source, dim, gravity [m/s^2], gravity_times [s], gravity_factors, grid, time,
            solver, output, body, boundary, probe. Sections are parts (`Grid(...)`) or dicts, lists of them for body, boundary and probe.
            Beside what a file can say: `body_force`, a function of positions (n, dim) [m], or of positions and time [s], that gives
            accelerations (n, dim) [m/s^2], at the nodes or, with the implicit solver, at the particles; the initial `velocity` of a body
            as a function of positions (n, dim) that gives velocities (n, dim) [m/s]; the `velocity` of a boundary
            as a function of time that gives dim numbers [m/s]; regions chosen by `Where`; laws written as `FunctionLaw`; layouts `Points`
            from arrays.

    Raises:
        InputError: There is no such section. Everything else is checked by `check`, `build` and `resolved`.

    Sections are attributes: `case.solver.flip = 0.99` changes the case.
    """

    _data: dict[str, Any]
    name: str

    def __init__(self, name: str = "case", **sections: Any) -> None:
        if not isinstance(name, str):
            raise _core.InputError(f"Case: name = {name!r} is not allowed, it must be a string")
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "_data", {})
        for key, value in sections.items():
            setattr(self, key, value)

    def __setattr__(self, key: str, value: Any) -> None:
        if key == "name":
            object.__setattr__(self, key, value)
            return
        known = (*_VALUES, *_TABLES, *_LISTS)
        if key not in known:
            raise _core.InputError(f'Case: unknown section "{key}"; known: {", ".join(known)}')
        if key in _LISTS and isinstance(value, Mapping):
            value = [value]
        if key in _LISTS and not (isinstance(value, (list, tuple)) and all(isinstance(item, Mapping) for item in value)):
            raise _core.InputError(f"Case: {key} = {value!r} is not allowed: give one {key.capitalize()}(...), or a list of them")
        self._data[key] = part_of(key, list(value) if key in _LISTS else value)

    def __getattr__(self, key: str) -> Any:
        if key.startswith("_"):
            raise AttributeError(key)
        if key in _TABLES:
            return self._data.setdefault(key, empty_section(key))
        if key in _LISTS:
            return self._data.setdefault(key, [])
        if key in _VALUES:
            return self._data.get(key, 2 if key == "dim" else None)
        raise AttributeError(f"Case has no {key}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *_VALUES, *_TABLES, *_LISTS]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Case) and self.name == other.name and self._said() == other._said()

    def _said(self) -> dict[str, Any]:
        """What the case says, as plain data: sections that were only looked at say nothing."""
        return {key: value for key, value in _plain(self._data).items() if value not in ({}, [])}

    def __repr__(self) -> str:
        bodies = ", ".join(str(body.get("name")) for body in self.body)
        return f"<Case {self.name}: {self.dim}D, bodies {bodies or 'none'}>"

    def _repr_html_(self) -> str:
        rows: list[tuple[str, Any]] = [("case", self.name)]
        rows += [(key, value) for key, value in self._data.items() if key in _VALUES or key in _TABLES]
        for key in _LISTS:
            rows += [(key, item) for item in self._data.get(key, [])]
        return _table(rows)

    @classmethod
    def from_toml(cls, source: str | Path, sets: Iterable[str] = ()) -> Case:
        """A case from a file, or the shipped case of that name (`shipped_cases`).

        Args:
            source: Path of a case file, or a name.
            sets: Changes as on the command line, e.g. "solver.flip=0.99".

        Raises:
            InputError: The file is no valid case; the text names the line, the value and what is allowed.
        """
        name, data = _core.load_case(str(source), [sets] if isinstance(sets, str) else list(sets))
        return cls(name, **data)

    def to_toml(self, path: str | Path | None = None) -> str:
        """The case as a case file, also written to `path` when given; `from_toml` reads the same case back.

        Raises:
            InputError: The case holds a Python function, which no file can.
        """
        for key, value in self._data.items():
            _refuse_functions(key, value)
        text = _core.write_toml(_plain(self._data))
        if path is not None:
            Path(path).write_text(text, encoding="utf-8")
        return text

    def resolved(self) -> dict[str, Any]:
        """All values with their defaults, as `matpoint check` prints them; functions and arrays of points as text. Raises InputError."""
        data = self._resolve()
        for key in ("body", "boundary"):
            for said, given in zip(data.get(key, []), self._data.get(key, [])):
                said.update({name: text for name in ("region", "velocity", "layout") if (text := _text_of(name, given.get(name)))})
        return data

    def _resolve(self) -> dict[str, Any]:
        data: dict[str, Any] = _core.resolve(self._placeholders(), self.name)
        return data

    def __copy__(self) -> Case:
        return self.copy()

    def __deepcopy__(self, memo: object) -> Case:
        return self.copy()

    def copy(self) -> Case:
        """A case that can be changed without changing this one; functions are shared."""
        made = Case(self.name)
        made._data.update({key: _copied(value) for key, value in self._data.items()})
        return made

    def check(self) -> CaseReport:
        """Says what a run would be, without running. Raises InputError for whatever `build` would refuse."""
        from matpoint.simulation import Simulation

        simulation = Simulation(self)
        dt = simulation.next_dt
        resolved = self.resolved()
        return CaseReport(
            {name: len(body) for name, body in simulation.bodies.items()},
            simulation.grid.node_count,
            dt,
            int(np.ceil(resolved["time"]["end"] / dt * (1 - 1e-12))),
            simulation.memory,
            simulation.warnings,
            resolved,
        )

    def build(self) -> Simulation:
        """Makes the particles: a simulation at t = 0. Raises InputError: all errors of the input that remain appear here."""
        from matpoint.simulation import Simulation

        return Simulation(self)

    # --- for Simulation -----------------------------------------------------------------------------------------------

    def _placeholders(self) -> dict[str, Any]:
        """The data with something plain where functions are: what the core can check before it meets them."""
        data = {key: value for key, value in self._data.items() if key != "body_force"}
        data["body"] = [_without_functions(body, self.dim) for body in self._data.get("body", [])]
        data["boundary"] = [_without_functions(boundary, self.dim) for boundary in self._data.get("boundary", [])]
        return {key: value for key, value in _plain(data).items() if value != [] or key == "body"}

    def _to_core(self) -> dict[str, Any]:
        """The data as the core takes it, functions and all. Raises InputError."""
        data = dict(self._data)
        dim = int(self.dim)
        resolved = self._resolve()
        axes = node_axes(resolved["grid"], resolved["solver"].get("shape", "linear"))
        data["body"] = [_body_to_core(body, dim) for body in self._data.get("body", [])]
        boundaries = []
        for number, boundary in enumerate(self._data.get("boundary", []), start=1):
            boundary = dict(boundary)
            if isinstance(boundary.get("region"), Where):
                boundary["region"] = _node_set(boundary["region"], axes, f"boundary {number}: region")
            if callable(boundary.get("velocity")):
                velocity = _checked_velocity(boundary["velocity"], dim)
                velocity(0.0)  # what is wrong with it shall be said now
                boundary["velocity"] = _core.velocity_history(velocity, dim)
            boundaries.append(boundary)
        data["boundary"] = boundaries
        if callable(self.body_force):
            data["body_force"] = _body_force(self.body_force, dim)
        return {key: value for key, value in _plain(data).items() if value != [] or key == "body"}


def _copied(value: Any) -> Any:
    if isinstance(value, Part):
        made = copy.copy(value)
        made.update({key: _copied(item) for key, item in value.items()})
        return made
    if isinstance(value, (list, tuple)):
        return type(value)(_copied(item) for item in value)
    if isinstance(value, np.ndarray):
        return value.copy()
    return value


def _plain(value: Any) -> Any:
    """Parts as dicts, tuples and arrays as lists."""
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    return value


def _refuse_functions(where: str, value: Any) -> None:
    if isinstance(value, (Where, FunctionLaw)) or callable(value):
        name = repr(value) if isinstance(value, (Where, FunctionLaw)) else name_of(value)
        raise _core.InputError(f"{where} = {name} is a Python function, which a case file cannot hold")
    if isinstance(value, Mapping):
        for key, item in value.items():
            _refuse_functions(f"{where}.{key}", item)
    elif isinstance(value, (list, tuple)):
        for index, item in enumerate(value):
            _refuse_functions(f"{where}[{index}]", item)


def _without_functions(table: Mapping[str, Any], dim: int) -> dict[str, Any]:
    plain = dict(table)
    if isinstance(plain.get("region"), Where):
        plain["region"] = {"type": "box", "lower": [0.0] * dim, "upper": [1.0] * dim}
    if callable(plain.get("velocity")):
        if plain.get("kind") == "velocity":
            plain["velocity"] = [0.0] * dim
        else:
            del plain["velocity"]
    if isinstance(plain.get("material"), FunctionLaw):
        plain["material"] = plain["material"].to_core()
    if _has_arrays(plain.get("layout")):
        plain["layout"] = _core.points(np.zeros((1, dim)), np.ones(1))
    return plain


def _text_of(key: str, value: Any) -> str:
    """How a function or an array is said in words; nothing for what a case file can say."""
    if isinstance(value, Where):
        return f"chosen by {value!r}"
    if key == "velocity" and callable(value):
        return f"the function {name_of(value)}"
    if key == "layout" and _has_arrays(value):
        return f"{len(value['positions'])} points from an array"
    return ""


def _has_arrays(layout: Any) -> bool:
    return isinstance(layout, Mapping) and layout.get("type") == "points" and isinstance(layout.get("positions"), np.ndarray)


def _body_to_core(body: Mapping[str, Any], dim: int) -> dict[str, Any]:
    made = dict(body)
    where = f'body "{body.get("name", "")}"'
    region = made.get("region")
    if isinstance(region, Where):
        if region.lower is None or region.upper is None:
            raise _core.InputError(f"{where}: region: {region!r} needs lower and upper, the corners of a box around it, to fill it")
        for corner in (region.lower, region.upper):
            if np.shape(corner) != (dim,):
                raise _core.InputError(f"{where}: region: {region!r}: the corner {corner!r} must have {dim} numbers")

        def contains(position: Floats, chosen: Where = region) -> bool:
            return bool(chosen.mask(position)[0])

        corners = [[float(x) for x in np.asarray(corner).ravel()] for corner in (region.lower, region.upper)]
        made["region"] = _core.predicate_region(contains, dim, corners[0], corners[1])
    if isinstance(made.get("material"), FunctionLaw):
        made["material"] = made["material"].to_core()
    if callable(made.get("velocity")):
        del made["velocity"]  # assigned after the particles are made
    if _has_arrays(made.get("layout")):
        layout = made["layout"]
        positions = np.ascontiguousarray(layout["positions"], dtype=np.float64)
        if positions.ndim != 2 or positions.shape[1] != dim:
            raise _core.InputError(
                f"{where}: layout: positions have the shape {positions.shape}; the case has dim = {dim}, so it must be (n, {dim})"
            )
        made["layout"] = _core.points(positions, np.atleast_1d(np.asarray(layout.get("volumes"), dtype=np.float64)))
    return made


def node_axes(grid: Mapping[str, Any], shape: str) -> list[Floats]:
    """Coordinates [m] of the nodes of a resolved grid, per direction, for the shape functions of the explicit solver."""
    axes = []
    for lower, upper, cells in zip(grid["lower"], grid["upper"], grid["cells"], strict=True):
        places = np.arange(cells + 1.0)
        if shape in ("bspline2", "bspline3"):
            # Control points stand at the means of as many knots as the degree (Greville).
            degree = int(shape[-1])
            i = np.arange(cells + degree)
            places = np.mean([np.clip(i - k, 0, cells) for k in range(degree)], axis=0)
        elif shape in ("gimp", "cpdi"):
            places = np.arange(-1.0, cells + 2)
        axes.append(lower + (upper - lower) / cells * places)
    return axes


def node_positions(axes: list[Floats]) -> Floats:
    """Positions [m] of all nodes of such a grid, shape (n, dim), x fastest."""
    mesh = np.meshgrid(*reversed(axes), indexing="ij")
    return np.stack([axis.ravel() for axis in reversed(mesh)], axis=1)


def _node_set(region: Where, axes: list[Floats], where: str) -> _core.Region:
    mask = np.ascontiguousarray(region.mask(node_positions(axes)))
    if not mask.any():
        raise _core.InputError(f"{where}: {region!r} chooses none of the {len(mask)} nodes of the grid, so it would do nothing")
    return _core.node_set([[float(x) for x in axis] for axis in axes], mask)


def _checked_velocity(function: Callable[..., Any], dim: int) -> Callable[[float], Floats]:
    def velocity(time: float) -> Floats:
        values = np.ascontiguousarray(function(time), dtype=np.float64)
        if values.shape != (dim,) or not np.isfinite(values).all():
            raise _core.InputError(
                f"boundary velocity {name_of(function)}: at t = {time} s it gave {values!r}; it must give {dim} finite numbers [m/s]"
            )
        return values

    return velocity


def _body_force(function: Callable[..., Any], dim: int) -> _core.BodyForce:
    depends_on_time = positional_count(function) > 1

    def force(positions: Floats, time: float) -> Floats:
        values = np.asarray(function(positions, time) if depends_on_time else function(positions), dtype=np.float64)
        try:
            values = np.ascontiguousarray(np.broadcast_to(values, positions.shape))
        except ValueError:
            raise _core.InputError(
                f"body_force {name_of(function)}: it gave the shape {values.shape} for positions of shape {positions.shape}; "
                "it must give the same shape"
            ) from None
        if not np.isfinite(values).all():
            raise _core.InputError(f"body_force {name_of(function)}: at t = {time} s it gave a number that is not finite")
        return values

    return _core.body_force(force, dim, not depends_on_time)
