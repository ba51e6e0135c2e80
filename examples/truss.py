"""A square of Neo-Hookean material hangs from its upper side and stretches to twice its length.

Source: Kamuth, thesis on the explicit material point method, section 8.2.
Expected: length of the middle column 0.1202 m, width of the top row 0.0308 m, as published for 4 x 4 cells and 20 x 20 particles.
Runs in about 5 s. The same as a case file: `matpoint run truss`.
"""

import matpoint as mp
import numpy as np


def case() -> mp.Case:
    """The case, word for word as cases/truss.toml."""
    return mp.Case(
        "truss",
        title="A truss under its own weight",
        source="Kamuth, thesis on the explicit material point method, section 8.2",
        gravity=(0, -1400),
        grid=mp.Grid(upper=(0.18, 0.18), cells=(4, 4)),
        time=mp.Time(dt=1e-05, end=1.995),
        solver=mp.Solver(shape="linear", stress_order="usl", damping=25, mass_cutoff=1e-10),
        body=[
            mp.Body(
                name="truss",
                region=mp.Box(lower=(0.06, 0.12), upper=(0.12, 0.18)),
                layout=mp.Lattice(divisions=(20, 20)),
                material=mp.NeoHookean(density=1500, youngs_modulus=100000.0, poissons_ratio=0.3),
            ),
        ],
        boundary=[
            mp.Boundary(side="top", kind="fixed", components=["y"]),
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
    x = np.asarray(simulation.bodies["truss"].position).reshape(20, 20, 2)  # [column, row]
    length = x[10, -1, 1] - x[11, 0, 1]
    width = np.ptp(x[:, -1, 0])
    assert abs(length - 0.12027) < 4e-4
    assert abs(width - 0.03087) < 4e-4


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done).savefig("truss.png")
    mp.plot.energies(done.history).savefig("truss_energies.png")
