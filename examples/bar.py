"""An elastic bar, held at its left end, vibrates along its axis in its first mode.

Source: closed form, v = v0 sin(b x) cos(w t) with b = pi / (2 L) and w = b sqrt(E / rho).
Expected: the velocity of the centre of mass is 0.063662 cos(2 pi t / 10 s) m/s, within 1.3 % of its amplitude for 25 cells.
Runs in about 1 s. The same as a case file: `matpoint run bar`.
"""

import matpoint as mp
import numpy as np


def case() -> mp.Case:
    """The case, word for word as cases/bar.toml."""
    return mp.Case(
        "bar",
        title="An elastic bar vibrates along its axis",
        source="Closed form: v = v0 sin(b x) cos(w t), b = pi / (2 L), w = b sqrt(E / rho)",
        grid=mp.Grid(upper=(26, 1), cells=(26, 1)),
        time=mp.Time(dt=0.005, end=30),
        solver=mp.Solver(shape="linear", stress_order="usl"),
        body=[
            mp.Body(
                name="bar",
                region=mp.Box(lower=(0, 0), upper=(25, 1)),
                layout=mp.PerCell(count=1),
                velocity=mp.SineVelocity(value=(0.1, 0), wave_vector=(0.06283185307179587, 0)),
                material=mp.NeoHookean(density=1, youngs_modulus=100, poissons_ratio=0),
            ),
        ],
        boundary=[
            mp.Boundary(side="left", kind="fixed", components=["x"]),
            mp.Boundary(side="bottom", kind="slip"),
            mp.Boundary(side="top", kind="slip"),
        ],
        probe=[
            mp.Probe(name="end", body="bar", nearest=(25, 0.5)),
        ],
    )


def run() -> mp.Simulation:
    """Runs it."""
    problem = case()
    simulation = problem.build()
    simulation.run(progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    history = simulation.history
    velocity = history["momentum_x"] / history["mass"]
    exact = 0.2 / np.pi * np.cos(2 * np.pi * history["time"] / 10)
    assert np.abs(velocity - exact).max() < 0.0124 * 0.2 / np.pi


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done).savefig("bar.png")
    mp.plot.energies(done.history).savefig("bar_energies.png")
