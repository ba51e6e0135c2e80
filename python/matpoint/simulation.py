"""Simulations: run, read and change a case while it runs."""

from __future__ import annotations

import os
import sys
import weakref
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from matpoint import _core
from matpoint.case import Case, node_axes
from matpoint.functions import Floats
from matpoint.results import did_you_mean
from matpoint.state import BodyState, GridState

if TYPE_CHECKING:
    import pandas

# A process forked from one whose threads have worked has none of them, and would wait for them for ever.
os.register_at_fork(after_in_child=lambda: _core.set_threads(1))


def set_threads(count: int) -> None:
    """Threads for all simulations from now on; 0 takes all processors. Results are the same bits for any number.

    Raises:
        InputError: The count is negative or above 1024.
    """
    if not isinstance(count, (int, np.integer)) or not 0 <= count <= 1024:
        raise _core.InputError(f"set_threads: {count} is not allowed: give 1 to 1024, or 0 for all processors")
    _core.set_threads(count)


def threads() -> int:
    """Threads that simulations use."""
    return int(_core.threads())


class History(Mapping[str, Floats]):
    """Sums over the bodies at the times of the history: the columns of history.csv as arrays of shape (rows,)."""

    def __init__(self, columns: dict[str, Floats], units: dict[str, str]) -> None:
        self._columns = columns
        self.units = units
        """Unit of each column."""

    def __getitem__(self, name: str) -> Floats:
        if name not in self._columns:
            raise KeyError(f'the history has no column "{name}"{did_you_mean(name, list(self._columns))}')
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return f"<history: {len(next(iter(self._columns.values())))} rows, {len(self)} columns>"

    def to_pandas(self) -> pandas.DataFrame:
        """A DataFrame with the times as index. Raises ImportError without the package pandas."""
        import pandas

        return pandas.DataFrame(dict(self._columns)).set_index("time")

    def _repr_png_(self) -> bytes:
        from matpoint import plot

        return plot.png_of(plot.energies(self))


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
    def grid(self) -> GridState:
        """The background grid."""
        return GridState(self, self._node_axes)

    @property
    def history(self) -> History:
        """What `run` and `record` have recorded so far, every `output.history_every` seconds of simulated time."""
        names, table = self._core.history_names(), self._core.history()
        return History({name: table[row] for row, name in enumerate(names)}, dict(zip(names, self._core.history_units())))

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

        Raises:
            InputError: The folder may not be used; it is given although steps were done; `until` is not a positive time.
            SolverError: The state stopped being finite, a particle left the grid, or the disk is full; files are intact up to then.
            KeyboardInterrupt: Ctrl-C; files are complete up to the present time.
            Exception: Whatever a function of the case or a callback raises, unchanged; files are intact.
        """
        if until is not None:
            if not isinstance(until, (int, float, np.integer, np.floating)) or not (0 < float(until) < float("inf")):
                raise _core.InputError(f"run: until = {until!r} is not allowed, it must be a positive time [s]")
            if float(until) < self.time * (1 - 1e-12):
                raise _core.InputError(f"run: until = {until} s is before the present time, {self.time} s")
        if output is not None:
            if self.step_count > 0 or self._core.has_results():
                raise _core.InputError("run: output can be given to the first run of a simulation only; later runs go on writing there")
            self._core.open_results(str(output), overwrite, f"Python: {' '.join(sys.argv) or 'interactive'}")
        if not progress:
            return str(self._core.run(until))
        with _Progress(self, until):
            return str(self._core.run(until))

    def step(self, count: int = 1) -> None:
        """Does some steps, without recording or writing anything and without calling callbacks.

        Raises:
            InputError: The count is negative.
            SolverError: As for `run`.
        """
        if not isinstance(count, (int, np.integer)) or count < 0:
            raise _core.InputError(f"step: count = {count!r} is not allowed, it must be an integer >= 0")
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
            raise _core.InputError(f"every: steps = {steps!r} is not allowed, it must be an integer >= 1")
        if time is not None and not time > 0:
            raise _core.InputError(f"every: time = {time} is not allowed, it must be > 0 [s]")
        if function is None:
            return lambda decorated: self._add(decorated, steps, time)
        return self._add(function, steps, time)

    def _add(self, function: Callable[[Simulation], object], steps: int | None, time: float | None) -> Callable[[Simulation], object]:
        if not callable(function):
            raise _core.InputError(f"every: {function!r} is no function")
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

    def __copy__(self) -> Simulation:
        raise _core.InputError(
            "a simulation cannot be copied; build its case again, and assign position, velocity and deformation_gradient"
        )

    def __deepcopy__(self, memo: object) -> Simulation:
        return self.__copy__()

    def __reduce__(self) -> str:
        raise _core.InputError("a simulation cannot be pickled; pickle its case, or write results (run(output=...))")

    def _repr_png_(self) -> bytes:
        from matpoint import plot

        return plot.png_of(plot.particles(self))


def _trampoline(simulation: Simulation, index: int) -> Callable[[], bool]:
    reference = weakref.ref(simulation)

    def call() -> bool:
        alive = reference()
        if alive is None:
            return True
        result = alive._callbacks[index](alive)
        return bool(result) if isinstance(result, (bool, np.bool_)) else True

    return call


class _Progress:
    """Prints how far a run is, once a second."""

    _installed: weakref.WeakKeyDictionary[Simulation, list[_Progress | None]] = weakref.WeakKeyDictionary()

    def __init__(self, simulation: Simulation, until: float | None) -> None:
        self._end = float(until) if until is not None else float(simulation._core.resolved()["time"]["end"])
        self._begin = simulation.time
        self._simulation = simulation

    def __enter__(self) -> None:
        import time

        self._start = time.perf_counter()
        current = self._installed.get(self._simulation)
        if current is not None:
            current[0] = self
            return
        slot: list[_Progress | None] = [self]
        self._installed[self._simulation] = slot
        reference = weakref.ref(self._simulation)

        def tell() -> bool:
            alive = reference()
            if alive is not None and slot[0] is not None:
                slot[0].show(alive)
            return True

        self._simulation._core.add_callback(tell, 0, 0.0, 1.0)

    def show(self, simulation: Simulation) -> None:
        """One line, over the last one."""
        import time

        share = (simulation.time - self._begin) / max(self._end - self._begin, 1e-300)
        left = (time.perf_counter() - self._start) * (1 - share) / max(share, 1e-9)
        print(
            f"\r{100 * share:5.1f} %  t = {simulation.time:.4g} s  step {simulation.step_count}  {left:.0f} s left   ", end="", flush=True
        )

    def __exit__(self, *_: object) -> None:
        self._installed[self._simulation][0] = None
        share = (self._simulation.time - self._begin) / max(self._end - self._begin, 1e-300)
        print(f"\r{100 * share:5.1f} %  t = {self._simulation.time:.4g} s  step {self._simulation.step_count}" + " " * 20, flush=True)


__all__ = ["History", "Simulation", "set_threads", "threads"]
