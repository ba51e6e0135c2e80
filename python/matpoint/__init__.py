"""matpoint: the material point method from a script or a notebook.

    import matpoint as mp

    case = mp.Case.from_toml("disks")                  # a case file, or the name of a shipped case
    simulation = case.build()
    simulation.run(until=1.0, progress=True)
    simulation.history["kinetic_energy"]               # one number per row
    simulation.bodies["lower"].velocity                # (n, dim), in the order of particle ids

A script says everything that a case file can say, in the same words: `mp.Case(dim=2, grid=mp.Grid(...), body=[mp.Body(...)], ...)`.
SI units throughout; in 2D all sums are per metre of thickness.
"""

from __future__ import annotations

import importlib
import os
from typing import TYPE_CHECKING, Any

# Threads of GNU OpenMP that wait for each other spin for milliseconds, which makes runs on a busy machine many times slower. The library
# reads this when it is loaded.
os.environ.setdefault("GOMP_SPINCOUNT", "20000")

if TYPE_CHECKING:
    from matpoint import plot as plot
    from matpoint import results as results
    from matpoint._core import InputError as InputError
    from matpoint._core import SolverError as SolverError
    from matpoint.errors import ResultsError as ResultsError
    from matpoint.functions import FunctionLaw as FunctionLaw
    from matpoint.functions import Where as Where
    from matpoint.health import HealthLine as HealthLine
    from matpoint.health import HealthWarning as HealthWarning
    from matpoint.history import History as History
    from matpoint.laboratory import point_test as point_test
    from matpoint.parts import *  # noqa: F403
    from matpoint.results import Results as Results
    from matpoint.simulation import Case as Case
    from matpoint.simulation import CaseReport as CaseReport
    from matpoint.simulation import Simulation as Simulation
    from matpoint.simulation import load as load
    from matpoint.simulation import set_threads as set_threads
    from matpoint.simulation import threads as threads
    from matpoint.state import BodyState as BodyState
    from matpoint.state import BoundaryState as BoundaryState
    from matpoint.state import FieldArray as FieldArray
    from matpoint.state import GridState as GridState

# Where the names come from. Imported on first use: reading and drawing results then needs no core, and running no matplotlib.
_homes = {
    "plot": "",
    "results": "",
    "InputError": "_core",
    "SolverError": "_core",
    "Case": "simulation",
    "CaseReport": "simulation",
    "FunctionLaw": "functions",
    "Where": "functions",
    "Results": "results",
    "point_test": "laboratory",
    "ResultsError": "errors",
    "BodyState": "state",
    "BoundaryState": "state",
    "FieldArray": "state",
    "GridState": "state",
    "HealthLine": "health",
    "HealthWarning": "health",
    "History": "history",
    "Simulation": "simulation",
    "load": "simulation",
    "set_threads": "simulation",
    "threads": "simulation",
}


if not TYPE_CHECKING:

    def __getattr__(name: str) -> Any:
        if name.startswith("__"):
            if name == "__version__":
                return importlib.import_module("matpoint._core").version()
            if name == "__all__":
                return [*_homes, "instruction_set", "shipped_cases", *importlib.import_module("matpoint.parts").__all__]
            raise AttributeError(name)
        if name in _homes:
            home = importlib.import_module(f"matpoint.{_homes[name] or name}")
            return getattr(home, name) if _homes[name] else home
        parts = importlib.import_module("matpoint.parts")
        if name in parts.__all__:
            return getattr(parts, name)
        raise AttributeError(f"module 'matpoint' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted({*globals(), *importlib.import_module("matpoint").__all__})


def instruction_set() -> str:
    """The SIMD instruction set that the kernels use: "avx512", "avx2" or "base".

    Raises:
        InputError: The environment variable MATPOINT_SIMD names one that this processor lacks.
    """
    return str(importlib.import_module("matpoint._core").instruction_set())


def shipped_cases() -> list[str]:
    """Names of the cases that come with matpoint, for `Case.from_toml`."""
    return list(importlib.import_module("matpoint._core").shipped_cases())
