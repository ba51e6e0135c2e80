"""A bar hangs from its upper end, stretches under its own weight and comes to rest by damping.

Source: Kamuth, thesis on the explicit material point method, section 8.1.
Expected: displacement of the lowest particle 3.01255e-3 m at t = 2 s; the thesis prints the mean, 3.0050284855e-3 m.
Runs in about 1 s. The same as a case file: `matpoint run spring`.
"""

import matpoint as mp


def case() -> mp.Case:
    """The case, word for word as cases/spring.toml."""
    return mp.Case(
        "spring",
        title="A spring under its own weight",
        source="Kamuth, thesis on the explicit material point method, section 8.1",
        gravity=(0, -9.81),
        grid=mp.Grid(upper=(0.02, 1.0), cells=(1, 21)),
        time=mp.Time(dt=0.0001, end=2),
        solver=mp.Solver(shape="linear", stress_order="usl", damping=15, mass_cutoff=1e-10),
        body=[
            mp.Body(
                name="spring",
                region=mp.Box(lower=(0, 0.8), upper=(0.02, 1.0)),
                layout=mp.Lattice(divisions=(1, 10)),
                material=mp.StVenantKirchhoff(density=1500, youngs_modulus=100000.0, poissons_ratio=0),
            ),
        ],
        boundary=[
            mp.Boundary(side="top", kind="fixed", components=["y"]),
        ],
        probe=[
            mp.Probe(name="lowest", body="spring", nearest=(0.01, 0.8)),
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
    lowest = simulation.bodies["spring"].position[:, 1].min()
    assert abs(0.81 - lowest - 3.01255026e-3) < 2e-9  # it starts at y = 0.81 m


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done).savefig("spring.png")
    mp.plot.energies(done.history).savefig("spring_energies.png")
