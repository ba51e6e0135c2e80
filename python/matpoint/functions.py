"""Python functions in a case: nodes and points chosen by a predicate, and constitutive laws."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from matpoint import _core
from matpoint.errors import shown
from matpoint.fields import Floats


def positional_count(function: Callable[..., Any]) -> int:
    """How many positional arguments a function takes; 1 where Python cannot tell."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return 1
    positional = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD)]
    return sum(p.default is p.empty or p.name in ("t", "time") for p in positional)


def name_of(function: Callable[..., Any]) -> str:
    """The function's name, for messages."""
    return getattr(function, "__qualname__", repr(function))


class Where:
    """A region chosen by a function of position: nodes for a boundary, points for a body.

    Args:
        predicate: Takes positions [m] of shape (n, dim) and returns n truth values; with `each` it takes one position of shape (dim,)
            and returns one.
        lower: Corner of a box around the region [m]; needed for a body only.
        upper: The opposite corner [m].
        each: Whether the predicate takes one position at a time.

    Raises:
        InputError: When the case is built: the predicate gives something else than truth values, or chooses no node.

    A boundary's nodes are chosen once, when the case is built. Example: `Boundary(region=Where(lambda x: x[:, 1] < 0.1), kind="fixed")`.
    """

    def __init__(
        self, predicate: Callable[..., Any], *, lower: ArrayLike | None = None, upper: ArrayLike | None = None, each: bool = False
    ) -> None:
        self.predicate = predicate
        self.lower = lower
        self.upper = upper
        self.each = each

    def __repr__(self) -> str:
        return f"Where({name_of(self.predicate)})"

    def mask(self, positions: Floats) -> NDArray[np.bool_]:
        """Which of the positions [m], shape (n, dim), are in the region: shape (n,). Raises InputError."""
        if self.each:
            return np.array([self._truth(np.asarray(self.predicate(x))) for x in positions], dtype=bool)
        chosen = np.asarray(self.predicate(positions))
        if chosen.shape == () and len(positions) == 1:
            chosen = chosen.reshape(1)
        if chosen.shape != (len(positions),):
            raise _core.InputError(
                f"{self!r}: the predicate gave an array of shape {chosen.shape} for {len(positions)} positions of shape "
                f"{positions.shape}; it must give ({len(positions)},), or take one position at a time with each=True"
            )
        return self._truth(chosen)

    def _truth(self, chosen: NDArray[Any]) -> NDArray[np.bool_]:
        if chosen.dtype != np.bool_:
            raise _core.InputError(f"{self!r}: the predicate gave {chosen.dtype} numbers; it must give truth values, e.g. x[:, 1] < 0.1")
        return chosen


def _number(name: str, value: object) -> float:
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        number = float("nan")
    if isinstance(value, (str, bytes)) or not math.isfinite(number):
        raise _core.InputError(f"function law: {name} = {shown(value)} is not allowed, it must be a finite number")
    return number


class FunctionLaw:
    """A constitutive law written in Python, for all particles of a body at once: ten times slower than a law of the core, or more.

    Args:
        stress: Takes deformation gradients F of shape (n, 3, 3) and returns Kirchhoff stresses tau = J sigma [Pa] of the same shape. Or it
            takes (F, L, dt, history) with the velocity gradient L [1/s] of shape (n, 3, 3), the time step dt [s] and the history of
            shape (n, history_size), and returns (tau, new history). It is called once in a step for all n particles of a body, in the
            order of their ids, as its fields are.
        density: Reference density [kg/m^3], > 0.
        wave_speed: An upper bound of the speed of pressure waves [m/s], > 0, for the stable time step.
        kinematic_viscosity: An upper bound [m^2/s], >= 0, for the stable time step.
        history: Names of the numbers per point that the law remembers, zero at the start, e.g. ("damage",): fields of the body, in
            files and as `body.field("damage")`, with the unit 1.
        history_size: How many numbers it remembers, where they need no names.

    Raises:
        InputError: What is given is no number, or no names; a number is not allowed (when the case is built), or the function gives another
            shape (when it runs).

    The strain energy is unknown: it is 0 in the history, and the column transfer_loss holds it.
    """

    def __init__(
        self,
        stress: Callable[..., Any],
        *,
        density: float,
        wave_speed: float,
        kinematic_viscosity: float = 0.0,
        history: Sequence[str] = (),
        history_size: int | None = None,
    ) -> None:
        self.stress = stress
        self.density = _number("density", density)
        self.wave_speed = _number("wave_speed", wave_speed)
        self.kinematic_viscosity = _number("kinematic_viscosity", kinematic_viscosity)
        names = (history,) if isinstance(history, str) else history
        if not isinstance(names, (list, tuple)) or not all(isinstance(name, str) and name.isascii() for name in names):
            raise _core.InputError(f'function law: history = {shown(history)} is not allowed, it must be names, e.g. ["damage"]')
        self.history = tuple(names)
        size = len(names) if history_size is None else _number("history_size", history_size)
        if size != int(size):
            raise _core.InputError(
                f"function law: history_size = {shown(history_size)} is not allowed, it must be an integer from 0 to 1000"
            )
        self.history_size = int(size)

    def __repr__(self) -> str:
        return f"FunctionLaw({name_of(self.stress)}, density={self.density}, wave_speed={self.wave_speed})"

    def _evaluate(self, F: Floats, L: Floats, dt: float, history: Floats) -> tuple[Floats, Floats]:
        if positional_count(self.stress) == 1:
            result = self.stress(F), history
        else:
            result = self.stress(F, L, dt, history)
            if not isinstance(result, tuple) or len(result) != 2:
                raise _core.InputError(f"{self!r}: the function must return (tau, history), it gave {type(result).__name__}")
        tau = np.ascontiguousarray(result[0], dtype=np.float64)
        new_history = np.ascontiguousarray(result[1], dtype=np.float64)
        for what, given, wanted in (("stresses", tau, F), ("history", new_history, history)):
            if given.shape != wanted.shape:
                raise _core.InputError(f"{self!r}: the function gave {what} of shape {given.shape}, it must be {wanted.shape}")
        return tau, new_history

    def to_core(self) -> _core.Material:
        """The law as the core takes it. Raises InputError."""
        return _core.function_material(
            name_of(self.stress),
            self._evaluate,
            self.density,
            self.wave_speed,
            self.kinematic_viscosity,
            self.history_size,
            list(self.history),
        )
