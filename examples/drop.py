"""A drop falls into a tank and pushes up a crown.

Source: Kamuth, thesis on the explicit material point method, section 8.5; Cueto-Felgueroso et al. (2004).
Expected: lowest point of the drop 0.0062 m and crown 0.0293 m at t = 0.075 s (thesis, read from a figure: 0.006 and 0.029 m).
Runs in about 6 s. The same as a case file: `matpoint run drop`.
"""

import matpoint as mp


def case() -> mp.Case:
    """The case, word for word as cases/drop.toml."""
    return mp.Case(
        "drop",
        title="A drop falls into a tank",
        source="Kamuth, thesis on the explicit material point method, section 8.5; Cueto-Felgueroso et al. (2004)",
        gravity=(0, -9.81),
        grid=mp.Grid(upper=(0.12, 0.06), cells=(120, 10)),
        time=mp.Time(dt=1e-06, end=0.2),
        solver=mp.Solver(shape="linear", stress_order="usl", mass_cutoff=1e-10),
        body=[
            mp.Body(
                name="drop",
                region=mp.Disk(center=(0.06, 0.03), radius=0.005),
                layout=mp.Lattice(divisions=(20, 20), points=2),
                velocity=mp.UniformVelocity(value=(0, -2)),
                material=mp.NewtonianFluid(density=1000, pressure_scale=30000, gamma=7, viscosity=0.5),
            ),
            mp.Body(
                name="tank",
                region=mp.Box(lower=(0, 0), upper=(0.12, 0.02)),
                layout=mp.Lattice(divisions=(240, 20), points=2),
                material=mp.NewtonianFluid(density=1000, pressure_scale=30000, gamma=7, viscosity=0.5),
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
    simulation.run(until=0.075, progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    assert abs(simulation.bodies["drop"].position[:, 1].min() - 0.0062) < 2e-4
    assert abs(simulation.bodies["tank"].position[:, 1].max() - 0.0293) < 6e-4


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done).savefig("drop.png")
    mp.plot.energies(done.history).savefig("drop_energies.png")
