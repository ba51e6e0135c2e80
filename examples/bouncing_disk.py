"""A disk of particles falls on a thin plate of finite elements and bounces; the time step follows its distance from the plate.

Source: Aulisa & Capodaglio, Monolithic coupling of implicit material point method with finite element method, section 6.3 (C_E,1, J = 2).
Expected: free fall as Newmark's method has it, to 1e-12 m. `matpoint run bouncing_disk` goes on to three bounces at 3.5 s, after which the
centre of mass comes back to -0.0004 m. Runs in about 4 s to 0.15 s.
"""

import matpoint as mp


def case() -> mp.Case:
    """The case, word for word as cases/bouncing_disk.toml."""
    return mp.Case(
        "bouncing_disk",
        title="A disk bounces on a plate of finite elements",
        source="Aulisa & Capodaglio, Monolithic coupling of implicit material point method with finite element method, "
        "section 6.3 (C_E,1, J = 2)",
        gravity=(0, -9.81),
        grid=mp.Grid(
            lower=(-0.64, -1.68),
            upper=(0.64, 0.32),
            cells=(8, 12),
            lines_y=(-1.68, -1.6, -1.52, -1.336, -1.152, -0.968, -0.784, -0.6, -0.416, -0.232, -0.048, 0.136, 0.32),
            refinements=1,
        ),
        time=mp.Time(
            end=3.5,
            rule=mp.DistanceRule(toward="bottom", positions=(-1.428, -0.794, -0.16), steps=(5e-4, 0.01, 0.005), interpolation="quadratic"),
        ),
        solver=mp.Solver(type="implicit", basis="element", beta=0.3, initial_acceleration="zero", soft_stiffness=(1e-2, 1e-6)),
        body=[
            mp.Body(
                name="disk",
                region=mp.Disk(center=(0, 0), radius=0.16),
                layout=mp.LayeredDisk(core_radius=0.14, points=300, ratio=1.14, normalized=False),
                material=mp.NeoHookean(density=1000, youngs_modulus=5.91e6, poissons_ratio=0.4),
            ),
            mp.Body(
                name="plate",
                method="elements",
                region=mp.Box(lower=(-0.64, -1.68), upper=(0.64, -1.52)),
                material=mp.NeoHookean(density=1, youngs_modulus=4.2e7, poissons_ratio=0.4),
                weight_density=0,
                receding_correction=0.06,
            ),
        ],
        boundary=[
            mp.Boundary(side="left", kind="fixed"),
            mp.Boundary(side="right", kind="fixed"),
            mp.Boundary(side="top", kind="fixed", components=["x"]),
        ],
        probe=mp.Probe(name="center", body="disk", particle=0),
    )


def run() -> mp.Simulation:
    """Runs the beginning of the fall, one step at a time to see their lengths."""
    simulation = case().build()
    while simulation.time < 0.15:
        simulation.step(1)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    first = case().build()
    first.step(1)
    dt, after = first.time, simulation.time - first.time
    fallen = 9.81 * (0.3 * dt * dt + 0.5 * dt * after + 0.5 * after * after)
    assert abs(simulation.bodies["disk"].position[:, 1].mean() - case().build().bodies["disk"].position[:, 1].mean() + fallen) < 1e-12
    assert 0.005 < dt < simulation.time / 20


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "von_mises").savefig("bouncing_disk.png")
