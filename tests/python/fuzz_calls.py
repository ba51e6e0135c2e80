"""Odd calls of the Python API, for scripts/fuzz: `python fuzz_calls.py SEED COUNT` prints those that are answered wrongly.

A call may do what was asked, or raise what the API declares: InputError, SolverError and ResultsError with a line of words, TypeError for
arguments that no function has, AttributeError and KeyError for names. Anything else is a fault, and so is the death of the interpreter.
"""

from __future__ import annotations

import copy
import math
import pickle
import random
import sys
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib
import matpoint as mp
import numpy as np

matplotlib.use("Agg")
DECLARED = (mp.InputError, mp.SolverError, mp.ResultsError)
NAMES = (TypeError, AttributeError, KeyError)


def odd_value(rng: random.Random, n: int = 0) -> Any:
    """Something that nobody would pass; `n`: what would be the right number of rows."""
    nested: list[Any] = []
    nested.append(nested)
    values = [
        None, True, 0, -1, 1, 2.5, math.nan, math.inf, -math.inf, 1e300, 1e-300, 10**30, 2**63, -(2**63) - 1, 1j, "", "x",
        "\ud800", "é" * 3000, b"x", b"\xff\x00", [], (), {}, set(), [None], [1, "x"], [[1, 2], [3]], nested, {"type": "disk"},
        {"type": None}, {1: 2}, {"": ""}, object(), int, len, lambda *a: None, lambda *a: math.nan, lambda *a: "x",
        lambda *a: np.zeros((3, 7)), iter([1]), range(1000), Path("."), Path("/nowhere/else"), np.nan, np.longdouble(1),
        np.clongdouble(1j), np.float16(1), np.int8(-1), np.uint64(2**64 - 1), np.bool_(True), np.str_("x"),
        np.datetime64("2020-01-01"), np.array(None), np.array([]), np.zeros(0), np.zeros((0, 3)), np.zeros((n, 2)),
        np.zeros((n, 3)), np.full((n, 2), np.nan), np.full((n, 3, 3), np.inf), np.zeros((n, 3, 3)), np.ones(n),
        np.ones(n, dtype=complex), np.ones((n, 2), dtype=int), np.array(["a"] * max(n, 1)), np.array([object()] * 2),
        np.ones((n, 2))[::-1], np.ones((2, n)).T, np.ma.masked_all(3), np.zeros((1,) * 30), mp.Grid(upper=(1, 1), cells=(4, 4)),
        mp.NeoHookean(density=1, youngs_modulus=1, poissons_ratio=0), mp.Case("other"), sys, warnings,
    ]  # fmt: skip
    return rng.choice(values)


def ball(**changes: Any) -> mp.Case:
    sections = dict(
        gravity=(0, -9.81),
        grid=mp.Grid(upper=(1, 1), cells=(6, 6)),
        time=mp.Time(end=0.02),
        body=mp.Body(
            name="ball",
            region=mp.Disk(center=(0.5, 0.5), radius=0.2),
            layout=mp.PerCell(count=4),
            material=mp.NeoHookean(density=1000, youngs_modulus=1e5, poissons_ratio=0.3),
        ),
    )
    return mp.Case("ball", **(sections | changes))


class Calls:
    def __init__(self, seed: int, folder: Path) -> None:
        self.rng = random.Random(seed)
        self.folder = folder
        self.simulation = ball().build()
        self.results: mp.Results | None = None

    def odd(self) -> Any:
        return odd_value(self.rng, len(self.simulation.bodies["ball"]))

    def case(self) -> None:
        """A section, or a key of one, has another value."""
        key = self.rng.choice(
            [
                "gravity",
                "grid",
                "time",
                "body",
                "boundary",
                "load",
                "tool",
                "solver",
                "output",
                "probe",
                "title",
                "dim",
                "rule",
                "body_force",
            ]
        )
        inner = {
            "grid": ["upper", "lower", "cells", "periodic", "origin"],
            "time": ["end", "dt", "cfl"],
            "body": ["name", "region", "layout", "material", "velocity", "initial_stress", "formulation"],
            "solver": ["shape", "transfer", "flip", "contact", "type", "damping", "precision"],
            "output": ["fields", "formats", "history_every", "fields_every", "fields_at"],
        }  # fmt: skip
        case = ball()
        if key in inner and self.rng.random() < 0.7:
            section = getattr(case, key)
            if key == "body":
                section = section[0] if isinstance(section, list) else section
            section[self.rng.choice(inner[key])] = self.odd()
        else:
            setattr(case, key, self.odd())
        act = self.rng.choice([case.check, case.build, case.to_toml, case.resolved, lambda: copy.deepcopy(case), lambda: repr(case)])
        made = act()
        if isinstance(made, mp.Simulation) and made.memory < 1e8:
            made.step(2)

    def parts(self) -> None:
        """A part with odd arguments."""
        name = self.rng.choice(
            ["Grid", "Time", "Body", "Disk", "Box", "PerCell", "Points", "NeoHookean", "J2", "Boundary", "Solver", "Output", "Where"]
        )
        made = getattr(mp, name)
        if self.rng.random() < 0.5:
            made(self.odd())
        else:
            made(
                **{self.rng.choice(["upper", "end", "name", "center", "count", "positions", "density", "side", "shape", "odd"]): self.odd()}
            )

    def field(self) -> None:
        """A field is assigned, or a part of one."""
        body = self.simulation.bodies["ball"]
        name = self.rng.choice([*body.fields, "displacement", "x", ""])
        how = self.rng.randrange(5)
        if how == 0:
            body.assign(name, self.odd())
        elif how == 1:
            setattr(body, name or "x", self.odd())
        elif how == 2:
            body[self.odd()]
        elif how == 3:
            body[name][self.rng.choice([0, slice(None), -1])] = self.odd()
        else:
            body.field(self.odd())

    def move(self) -> None:
        """Steps, runs, callbacks, states."""
        now = self.simulation
        odd = self.odd()
        if isinstance(odd, int) and abs(odd) > 1000 or isinstance(odd, float) and odd > 1:
            odd = -1
        act: Callable[[], Any] = self.rng.choice(
            [
                lambda: now.step(odd),
                lambda: now.run(odd),
                lambda: now.run(output=odd) if not isinstance(odd, (Path, str)) else None,
                lambda: now.every(time=odd),
                lambda: now.every(steps=odd),
                lambda: now.every(odd),
                lambda: now.save(odd) if not isinstance(odd, (Path, str)) else None,
                lambda: mp.load(odd),
                lambda: now.set_state(odd),
                lambda: mp.set_threads(odd),
                lambda: pickle.loads(pickle.dumps(now)).step(1),
                lambda: copy.copy(now).step(1),
                lambda: now.history[odd],
                lambda: now.boundaries[odd],
                lambda: mp.Simulation(odd),
                lambda: setattr(now, self.rng.choice(["time", "dt", "bodies", "x"]), odd),
                lambda: mp.Case.from_toml(odd) if not isinstance(odd, Path) else None,
                lambda: mp.Case.from_toml("disks", sets=odd),
            ]
        )
        act()

    def look(self) -> None:
        """Point tests, results and pictures."""
        odd = self.odd()
        if self.results is None:
            ball(output=mp.Output(fields_every=0.01)).build().run(output=self.folder / "r", overwrite=True)
            self.results = mp.Results(self.folder / "r")
        results = self.results
        body = results.bodies["ball"]
        soil = mp.MohrCoulomb(density=1800, youngs_modulus=1e7, poissons_ratio=0.3, cohesion=1e4, friction_angle=30)
        key = self.rng.choice(["strain", "confining", "rate", "steps", "cycles", "times", "deformation", "path"])
        if key in ("steps", "cycles") and isinstance(odd, (int, float)) and not isinstance(odd, bool) and abs(odd) > 1e4:
            odd = -1
        act: Callable[[], Any] = self.rng.choice(
            [
                lambda: mp.point_test(odd, "triaxial"),
                lambda: mp.point_test(soil, odd),
                lambda: mp.point_test(soil, **({"path": "triaxial"} | {key: odd})),
                lambda: mp.Results(odd),
                lambda: body.field(odd, 0),
                lambda: body.field("velocity", odd),
                lambda: body.positions(odd),
                lambda: body.scalar(odd, 0),
                lambda: mp.plot.particles(results, odd),
                lambda: mp.plot.particles(results, "velocity", times=odd),
                lambda: mp.plot.profile(results, "velocity_y", along=odd),
                lambda: mp.plot.energies(odd),
                lambda: mp.plot.point_test(odd),
            ]
        )
        act()
        matplotlib.pyplot.close("all")


def main() -> int:
    seed, count = int(sys.argv[1]), int(sys.argv[2])
    warnings.simplefilter("ignore")
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        calls = Calls(seed, Path(folder))
        kinds = [calls.case, calls.case, calls.parts, calls.field, calls.move, calls.look]
        for number in range(count):
            kind = calls.rng.choice(kinds)
            try:
                kind()
            except DECLARED as error:
                text = str(error)
                if not 5 < len(text) < 10000 or "\n" in text.strip():
                    failures += 1
                    print(f"call {number}, {kind.__name__}: no line of words: {text[:300]!r}")
            except NAMES:
                pass
            except Exception as error:
                failures += 1
                where = error.__traceback__
                while where is not None and where.tb_next is not None:
                    where = where.tb_next
                place = f"{where.tb_frame.f_code.co_filename}:{where.tb_lineno}" if where is not None else ""
                print(f"call {number}, {kind.__name__}: {type(error).__name__}: {' '.join(str(error).split())[:300]} ({place})")
            if number % 20 == 19:  # the state that odd calls have left is not to hide what later ones do
                calls.simulation = ball().build()
                mp.set_threads(1)
    print(f"{count} calls, {failures} failures")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
