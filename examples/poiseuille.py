"""Water between two plates at rest is driven along them by a body force.

Source: Morris, Fox & Zhu (1997), section 4.1.
Expected: the parabola v = F y (L - y) / (2 nu), 2.5e-5 m/s in the middle, within 0.3 % of the peak.
Runs in about 1 s. The same as a case file: `matpoint run poiseuille`.
"""

import matpoint as mp
import numpy as np


def case() -> mp.Case:
    """The case, word for word as cases/poiseuille.toml."""
    return mp.Case(
        "poiseuille",
        title="Flow between two plates",
        source="Morris, Fox & Zhu (1997), section 4.1; steady state and transient series in closed form",
        gravity=(0.0002, 0),
        grid=mp.Grid(upper=(0.0002, 0.001), cells=(4, 20), periodic=["x"]),
        time=mp.Time(dt=0.0001, end=1),
        solver=mp.Solver(shape="linear", stress_order="usl"),
        body=[
            mp.Body(
                name="water",
                region=mp.Box(lower=(0, 0), upper=(0.0002, 0.001)),
                layout=mp.PerCell(count=4),
                material=mp.NewtonianFluid(density=1000, pressure_scale=0.000893, gamma=7, viscosity=0.001),
            ),
        ],
        boundary=[
            mp.Boundary(side="bottom", kind="fixed"),
            mp.Boundary(side="top", kind="fixed"),
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
    water = simulation.bodies["water"]
    y = water.position[:, 1]
    exact = 2e-4 * y * (1e-3 - y) / (2 * 1e-6)
    assert np.abs(water.velocity[:, 0] - exact).max() < 0.00275 * 2.5e-5


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done).savefig("poiseuille.png")
    mp.plot.energies(done.history).savefig("poiseuille_energies.png")
