"""A heavy and a light fluid stand side by side; the heavy one flows under the light one.

Source: Kamuth, thesis on the explicit material point method, section 8.6.
Expected: heavy front at x = 0.0194 m and light front at 0.0853 m at t = 0.25 s (thesis, read from a figure: 0.020 and 0.085 m).
Runs in about 8 s. The same as a case file: `matpoint run gravity_current`.
"""

import matpoint as mp


def case() -> mp.Case:
    """The case, word for word as cases/gravity_current.toml."""
    return mp.Case(
        "gravity_current",
        title="A heavy fluid flows under a light one",
        source="Kamuth, thesis on the explicit material point method, section 8.6",
        gravity=(0, -9.81),
        grid=mp.Grid(upper=(0.12, 0.08), cells=(24, 16)),
        time=mp.Time(dt=1e-06, end=0.5),
        solver=mp.Solver(shape="linear", stress_order="usl", mass_cutoff=1e-10),
        body=[
            mp.Body(
                name="light",
                region=mp.Box(lower=(0, 0), upper=(0.06, 0.06)),
                layout=mp.Lattice(divisions=(30, 30), points=2),
                material=mp.NewtonianFluid(density=1000, pressure_scale=20000.0, gamma=7, viscosity=0.01),
            ),
            mp.Body(
                name="heavy",
                region=mp.Box(lower=(0.06, 0), upper=(0.12, 0.06)),
                layout=mp.Lattice(divisions=(30, 30), points=2),
                material=mp.NewtonianFluid(density=1500, pressure_scale=20000.0, gamma=7, viscosity=0.01),
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
    problem.time.dt = 1e-05
    simulation = problem.build()
    simulation.run(until=0.25, progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    assert abs(simulation.bodies["heavy"].position[:, 0].min() - 0.0194) < 6e-4
    assert abs(simulation.bodies["light"].position[:, 0].max() - 0.0853) < 1e-3


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done).savefig("gravity_current.png")
    mp.plot.energies(done.history).savefig("gravity_current_energies.png")
