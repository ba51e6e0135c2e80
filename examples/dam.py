"""A column of water collapses and runs along the floor.

Source: Kamuth, thesis on the explicit material point method, section 8.4; Mast et al. (2012).
Expected: the front passes x = 4 m at 0.5170 s with MUSL and dt = 1e-4 s (0.5172 s with the thesis' USL and 1e-5 s).
Runs in about 5 s. The same as a case file: `matpoint run dam`.
"""

import matpoint as mp
import numpy as np


def case() -> mp.Case:
    """The case, word for word as cases/dam.toml."""
    return mp.Case(
        "dam",
        title="A dam breaks against a barrier",
        source="Kamuth, thesis on the explicit material point method, section 8.4; Mast et al. (2012)",
        gravity=(0, -9.81),
        grid=mp.Grid(upper=(6, 8), cells=(18, 24), particles_outside="stop"),
        time=mp.Time(dt=1e-05, end=4),
        solver=mp.Solver(shape="linear", stress_order="usl", mass_cutoff=1e-10),
        body=[
            mp.Body(
                name="water",
                region=mp.Box(lower=(0, 0), upper=(2, 4)),
                layout=mp.Lattice(divisions=(60, 80), points=2),
                material=mp.NewtonianFluid(density=997.5, pressure_scale=2000000.0, gamma=7, viscosity=0.01),
            ),
        ],
        boundary=[
            mp.Boundary(side="left", kind="slip"),
            mp.Boundary(side="right", kind="slip"),
            mp.Boundary(side="bottom", kind="slip"),
        ],
    )


def run() -> mp.Simulation:
    """Runs it, with MUSL and a longer step than the thesis'."""
    problem = case()
    problem.solver.stress_order = "musl"
    problem.time.dt = 0.0001
    problem.output.history_every = 0.005
    simulation = problem.build()
    simulation.run(until=0.55, progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    history = simulation.history
    front = history["water.upper_x"]
    row = int(np.argmax(front > 4.0))
    time = np.interp(4.0, front[row - 1 : row + 1], history["time"][row - 1 : row + 1])
    assert abs(time - 0.5170) < 3.6e-3


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done).savefig("dam.png")
    mp.plot.energies(done.history).savefig("dam_energies.png")
