"""How far a run is, printed while it goes on."""

from __future__ import annotations

import time
import weakref
from typing import Protocol

from matpoint._core import Simulation as CoreSimulation


class Running(Protocol):
    """A simulation as its progress sees it."""

    _core: CoreSimulation

    @property
    def time(self) -> float:
        """Present time [s]."""

    @property
    def step_count(self) -> int:
        """Steps done."""


class Progress:
    """Prints how far a run is, once a second."""

    _installed: weakref.WeakKeyDictionary[Running, list[Progress | None]] = weakref.WeakKeyDictionary()

    def __init__(self, simulation: Running, until: float | None) -> None:
        self._end = float(until) if until is not None else float(simulation._core.resolved()["time"]["end"])
        self._begin = simulation.time
        self._simulation = simulation

    def __enter__(self) -> None:
        self._start = time.perf_counter()
        current = self._installed.get(self._simulation)
        if current is not None:
            current[0] = self
            return
        slot: list[Progress | None] = [self]
        self._installed[self._simulation] = slot
        reference = weakref.ref(self._simulation)

        def tell() -> bool:
            alive = reference()
            if alive is not None and slot[0] is not None:
                slot[0].show(alive)
            return True

        self._simulation._core.add_callback(tell, 0, 0.0, 1.0)

    def show(self, simulation: Running) -> None:
        """One line, over the last one."""
        share = (simulation.time - self._begin) / max(self._end - self._begin, 1e-300)
        left = (time.perf_counter() - self._start) * (1 - share) / max(share, 1e-9)
        print(
            f"\r{100 * share:5.1f} %  t = {simulation.time:.4g} s  step {simulation.step_count}  {left:.0f} s left   ", end="", flush=True
        )

    def __exit__(self, *_: object) -> None:
        self._installed[self._simulation][0] = None
        share = (self._simulation.time - self._begin) / max(self._end - self._begin, 1e-300)
        print(f"\r{100 * share:5.1f} %  t = {self._simulation.time:.4g} s  step {self._simulation.step_count}" + " " * 20, flush=True)
