"""Cases and simulations: the whole problem as data, and its run. They stand in one module because each makes the other."""

from __future__ import annotations

import atexit
import html
import os
import sys
import tempfile
import weakref
from collections.abc import Callable, Iterable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from matpoint import _core
from matpoint.case_data import copied, node_axes, placeholders, plain, refuse_functions, require_picklable, text_for_core, text_of, to_core
from matpoint.errors import shown
from matpoint.health import HealthLine, warn_of
from matpoint.history import History
from matpoint.parts import empty_section, part_of
from matpoint.progress import Progress
from matpoint.scene import Scene
from matpoint.state import BodyState, BoundaryState, GridState

_TABLES = ("grid", "time", "solver", "output")
_LISTS = ("body", "boundary", "load", "tool", "probe")
_VALUES = (
    "title",
    "source",
    "dim",
    "gravity",
    "gravity_times",
    "gravity_factors",
    "base_acceleration",
    "base_acceleration_times",
    "body_force",
)

# A process forked from one whose threads have worked has none of them, and would wait for them for ever.
os.register_at_fork(after_in_child=lambda: _core.set_threads(1))
# A run in a thread that outlives the interpreter ends after its step, with everything written.
atexit.register(_core.end_runs)


def set_threads(count: int) -> None:
    """Threads for all simulations from now on; 0 takes all processors. Results are the same bits for any number.

    Raises:
        InputError: The count is negative or above 1024.
    """
    if not isinstance(count, (int, np.integer)) or not 0 <= count <= 1024:
        raise _core.InputError(f"set_threads: {shown(count)} is not allowed: give 1 to 1024, or 0 for all processors")
    _core.set_threads(count)


def threads() -> int:
    """Threads that simulations use."""
    return int(_core.threads())


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
        sections: The keys of a case file: title, source, dim, gravity [m/s^2], gravity_times [s], gravity_factors,
            base_acceleration (n, dim) [m/s^2], base_acceleration_times (n,) [s], grid, time, solver, output, body, boundary, load,
            tool, probe. Sections are parts (`Grid(...)`) or dicts, lists of them for body, boundary, load, tool and probe.
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
            raise _core.InputError(f"Case: name = {shown(name)} is not allowed, it must be a string")
        object.__setattr__(self, "name", text_for_core("Case: name", name))
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
            raise _core.InputError(f"Case: {key} = {shown(value)} is not allowed: give one {key.capitalize()}(...), or a list of them")
        try:
            self._data[key] = part_of(key, list(value) if key in _LISTS else value)
        except RecursionError as error:
            raise _core.InputError(f"Case: {key} holds itself") from error

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
        return {key: value for key, value in plain(self._data).items() if value not in ({}, [])}

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
        name, data = _core.load_case(text_for_core("from_toml", source), [sets] if isinstance(sets, str) else list(sets))
        return cls(name, **data)

    def to_toml(self, path: str | Path | None = None) -> str:
        """The case as a case file, also written to `path` when given; `from_toml` reads the same case back.

        Raises:
            InputError: The case holds a Python function, which no file can.
        """
        try:
            for key, value in self._data.items():
                refuse_functions(key, value)
            data = plain(self._data)
        except RecursionError as error:
            raise _core.InputError("Case: a list or dict of the case holds itself") from error
        text = _core.write_toml(data)
        if path is not None:
            Path(path).write_text(text, encoding="utf-8")
        return text

    def resolved(self) -> dict[str, Any]:
        """All values with their defaults, as `matpoint check` prints them; functions and arrays of points as text. Raises InputError."""
        data = self._resolve()
        for key in ("body", "boundary", "load"):
            for said, given in zip(data.get(key, []), self._data.get(key, [])):
                said.update({name: text for name in ("region", "velocity", "layout") if (text := text_of(name, given.get(name)))})
        return data

    def _resolve(self) -> dict[str, Any]:
        try:
            data: dict[str, Any] = _core.resolve(placeholders(self._data, self.dim), self.name)
        except RecursionError as error:
            raise _core.InputError("Case: a list or dict of the case holds itself") from error
        return data

    def _to_core(self) -> dict[str, Any]:
        resolved = self._resolve()  # which refuses a dim that is no number
        return to_core(self._data, int(self.dim), resolved)

    def __copy__(self) -> Case:
        return self.copy()

    def __deepcopy__(self, memo: object) -> Case:
        return self.copy()

    def copy(self) -> Case:
        """A case that can be changed without changing this one; functions are shared. Raises InputError for a list that holds itself."""
        made = Case(self.name)
        try:
            made._data.update({key: copied(value) for key, value in self._data.items()})
        except RecursionError as error:
            raise _core.InputError("Case: a list or dict of the case holds itself") from error
        return made

    def check(self) -> CaseReport:
        """Says what a run would be, without running. Raises InputError for whatever `build` would refuse."""
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
        return Simulation(self)


class Simulation:
    """A case with its particles, ready to run or in the middle of it.

    Args:
        case: What to simulate; later changes of it do not change the simulation.

    Raises:
        InputError: The case is wrong; the text names the place, the value and what is allowed.
    """

    def __init__(self, case: Case) -> None:
        self._case = case.copy()
        self._core = _core.Simulation(self._case._to_core(), self._case.name)
        self._callbacks: list[Callable[[Simulation], object]] = []
        resolved = self._core.resolved()
        self._node_axes = node_axes(resolved["grid"], resolved["solver"].get("shape", "linear"))
        for index, body in enumerate(self._case.body):
            velocity = body.get("velocity")
            if callable(velocity):
                state = self.bodies[self._core.body_names()[index]]
                state.velocity = velocity(np.asarray(state.position))

    @property
    def case(self) -> Case:
        """A copy of the case."""
        return self._case.copy()

    @property
    def time(self) -> float:
        """Present time [s]."""
        return float(self._core.time())

    @property
    def step_count(self) -> int:
        """Steps done."""
        return int(self._core.step_count())

    @property
    def dt(self) -> float:
        """The last time step [s]; 0 before the first."""
        return float(self._core.last_dt())

    @property
    def next_dt(self) -> float:
        """The next time step [s]: the fixed one, or cfl times the stable limit now. Raises SolverError below dt_min."""
        return float(self._core.next_dt())

    @property
    def memory(self) -> int:
        """Bytes of particles and grid."""
        return int(self._core.memory())

    @property
    def warnings(self) -> list[str]:
        """Things that work as asked but probably not as meant, a sentence each."""
        return list(self._core.warnings())

    @property
    def bodies(self) -> dict[str, BodyState]:
        """The bodies by name, in the order of the case."""
        return {name: BodyState(self, index, name) for index, name in enumerate(self._core.body_names())}

    @property
    def boundaries(self) -> dict[str, BoundaryState]:
        """What each boundary, tool and load does to the bodies, by its name or side, in the order of the case."""
        return {name: BoundaryState(np.array(force), np.array(impulse), work) for name, force, impulse, work in self._core.boundaries()}

    @property
    def grid(self) -> GridState:
        """The background grid."""
        return GridState(self, self._node_axes)

    @property
    def history(self) -> History:
        """What `run` and `record` have recorded so far, every `output.history_every` seconds of simulated time."""
        names, table = self._core.history_names(), self._core.history()
        return History({name: table[row] for row, name in enumerate(names)}, dict(zip(names, self._core.history_units())))

    @property
    def health(self) -> list[HealthLine]:
        """What the last `run` said about itself at its end: energy, momentum, volumes, lost particles, each with a verdict."""
        return [HealthLine(*line) for line in self._core.health()]

    def run(self, until: float | None = None, *, output: str | Path | None = None, overwrite: bool = False, progress: bool = False) -> str:
        """Runs on; other Python threads go on meanwhile, and Ctrl-C ends the run after a step with everything written.

        Args:
            until: Time [s]; default: `time.end` of the case. The last automatic step is cut to end there.
            output: A results folder, as `matpoint run` writes it (`Results` reads it). Only when no step is done yet; later runs go on
                writing into it.
            overwrite: Replace the results of an earlier run in that folder.
            progress: Print the share done and the time left, once a second.

        Returns:
            Why it ended: "finished", "stopped" (by a callback), "stopped (a particle left the grid)".

        Warns:
            HealthWarning: Something of `health` is not good.

        Raises:
            InputError: The folder may not be used; it is given although steps were done; `until` is not a positive time.
            SolverError: The state stopped being finite, a particle left the grid, or the disk is full; files are intact up to then.
            KeyboardInterrupt: Ctrl-C; files are complete up to the present time.
            Exception: Whatever a function of the case or a callback raises, unchanged; files are intact.
        """
        if until is not None:
            if not isinstance(until, (int, float, np.integer, np.floating)) or not (0 < float(until) < float("inf")):
                raise _core.InputError(f"run: until = {shown(until)} is not allowed, it must be a positive time [s]")
            if float(until) < self.time * (1 - 1e-12):
                raise _core.InputError(f"run: until = {until} s is before the present time, {self.time} s")
        if output is not None:
            if self.step_count > 0 or self._core.has_results():
                raise _core.InputError("run: output can be given to the first run of a simulation only; later runs go on writing there")
            self._core.open_results(text_for_core("run: output", output), overwrite, f"Python: {' '.join(sys.argv) or 'interactive'}")
        with Progress(self, until) if progress else nullcontext():
            ending = str(self._core.run(until))
        if ending != "interrupted":
            warn_of(self.health, stacklevel=2)
        return ending

    def step(self, count: int = 1) -> None:
        """Does some steps, without recording or writing anything and without calling callbacks.

        Raises:
            InputError: The count is negative.
            SolverError: As for `run`.
        """
        if not isinstance(count, (int, np.integer)) or count < 0:
            raise _core.InputError(f"step: count = {shown(count)} is not allowed, it must be an integer >= 0")
        self._core.step(int(count))

    def record(self) -> None:
        """Adds the present state to the history, e.g. after `step`."""
        self._core.record()

    def every(
        self, function: Callable[[Simulation], object] | None = None, *, steps: int | None = None, time: float | None = None
    ) -> Callable[[Simulation], object] | Callable[[Callable[[Simulation], object]], Callable[[Simulation], object]]:
        """Has `run` call a function after every so many steps or so much simulated time, and at the start. May be used as a decorator.

        Args:
            function: Takes the simulation; it may read and assign fields. Returning False ends the run; anything else goes on.
            steps: Number of steps between calls; default 1 when `time` is not given.
            time: Simulated time between calls [s]: called after the first step at or after each multiple. Steps are not cut for it.

        Returns:
            The function.

        Raises:
            InputError: steps or time is not positive, or both are given.

        Example:
            @simulation.every(time=0.01)
            def stop_when_slow(now): return now.time < 0.1 or abs(now.bodies["ball"].velocity).max() > 0.1
        """
        if steps is not None and time is not None:
            raise _core.InputError("every: steps and time are both given; give one of them")
        if steps is not None and (not isinstance(steps, (int, np.integer)) or steps < 1):
            raise _core.InputError(f"every: steps = {shown(steps)} is not allowed, it must be an integer >= 1")
        if time is not None and not (isinstance(time, (int, float, np.integer, np.floating)) and time > 0):
            raise _core.InputError(f"every: time = {shown(time)} is not allowed, it must be > 0 [s]")
        if function is None:
            return lambda decorated: self._add(decorated, steps, time)
        return self._add(function, steps, time)

    def _add(self, function: Callable[[Simulation], object], steps: int | None, time: float | None) -> Callable[[Simulation], object]:
        if not callable(function):
            raise _core.InputError(f"every: {shown(function)} is no function")
        # The core keeps a weak reference: a function that knows the simulation would keep it alive for ever.
        self._callbacks.append(function)
        self._core.add_callback(_trampoline(self, len(self._callbacks) - 1), (steps or 1) if time is None else 0, time or 0.0, 0.0)
        return function

    def __repr__(self) -> str:
        try:
            bodies = ", ".join(f"{name} ({len(body)} particles)" for name, body in self.bodies.items())
        except _core.InputError:  # in the middle of a step
            return f"<simulation of {self._case.name}: running>"
        return f"<simulation of {self._case.name}: t = {self.time:.6g} s, step {self.step_count}, {bodies}>"

    def save(self, path: str | Path) -> None:
        """Writes a file with the state: everything that decides how the simulation goes on, and its history; `load` goes on from it.

        Callbacks and an open results folder are not part of it. A file of that name is replaced when the new one is complete.

        Raises:
            InputError: The simulation is in the middle of a step.
            SolverError: The file cannot be written, or the simulation broke off.
        """
        self._core.save(text_for_core("save", path))

    def set_state(self, other: Simulation) -> None:
        """Takes positions, velocities and deformation gradients of the bodies that both simulations have, by the particles' ids.

        The grid, the scheme, loads and materials stay this simulation's own: the way from one grid to a finer one. The time stays, too.
        For a run that goes on to the last bit, `save` and `load`.

        Raises:
            InputError: There is no such body, its particles have other ids, or a value cannot be taken (a position outside of the grid);
                bodies before that one have been changed then.
        """
        common = [name for name in self.bodies if name in other.bodies]
        if not common:
            raise _core.InputError(f"set_state: no body of {list(other.bodies)} is one of this simulation, {list(self.bodies)}")
        for name in common:
            mine, theirs = self.bodies[name], other.bodies[name]
            if not np.array_equal(mine.id, theirs.id):
                raise _core.InputError(
                    f'set_state: the particles of body "{name}" have other ids here ({len(mine)}) than there ({len(theirs)}); the '
                    "bodies must have the same particles, so give their layout in a way that does not depend on the grid (lattice, points)"
                )
        for name in common:
            mine, theirs = self.bodies[name], other.bodies[name]
            for field in ("position", "velocity", "deformation_gradient"):
                setattr(mine, field, np.asarray(getattr(theirs, field)))

    def __copy__(self) -> Simulation:
        made = Simulation(self._case)
        made._core.copy_state(self._core)
        return made

    def __deepcopy__(self, memo: object) -> Simulation:
        return self.__copy__()

    def __reduce__(self) -> tuple[Callable[[Case, bytes], Simulation], tuple[Case, bytes]]:
        require_picklable("the case", self._case._data)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "state.h5"
            self.save(path)
            return _unpickled, (self._case.copy(), path.read_bytes())

    def _scene(self) -> Scene:
        return _LiveScene(self)

    def _repr_png_(self) -> bytes:
        from matpoint import plot

        return plot.png_of(plot.particles(self))


class _LiveScene:
    """A simulation as pictures see it."""

    units = {"velocity": "m/s", "stress": "Pa", "von_mises": "Pa", "pressure": "Pa", "mass": "kg", "volume": "m^3"}

    def __init__(self, simulation: Simulation) -> None:
        self.case = simulation._core.resolved()
        self.dim = int(self.case["dim"])
        self.title = str(self.case.get("title") or simulation.case.name)
        fluids = {body["name"] for body in self.case["body"] if "viscosity" in body.get("material", {})}
        self.bodies = {name: state._drawn(simulation.time, name in fluids) for name, state in simulation.bodies.items()}

    def unit(self, field_name: str) -> str:
        """Unit of a field or of a component of it; empty where it has none."""
        return self.units.get(field_name, self.units.get(field_name.rpartition("_")[0], ""))


def load(path: str | Path, case: Case | None = None) -> Simulation:
    """A simulation that goes on where `Simulation.save`, or a checkpoint of a run, left it: to the last bit the one that was saved.

    Args:
        path: The file, or a results folder, whose last checkpoint is taken.
        case: The case again, where it has Python functions, which no file can hold; else it is read from the state.

    Raises:
        InputError: There is no such file, it is damaged or of another version, the case has functions and is not given, or the given
            case is another one: the text names the first difference.
    """
    path = text_for_core("load", path)
    data = _core.case_of_state(path, case is not None)
    simulation = Simulation(Case(data[0], **data[1]) if case is None else case)
    simulation._core.load(path)
    return simulation


def _unpickled(case: Case, state: bytes) -> Simulation:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "state.h5"
        path.write_bytes(state)
        return load(path, case)


def _trampoline(simulation: Simulation, index: int) -> Callable[[], bool]:
    reference = weakref.ref(simulation)

    def call() -> bool:
        alive = reference()
        if alive is None:
            return True
        result = alive._callbacks[index](alive)
        return bool(result) if isinstance(result, (bool, np.bool_)) else True

    return call


__all__ = ["Case", "CaseReport", "Simulation", "load", "set_threads", "threads"]
