"""A disk of particles rolls down a plate of finite elements: one Newton solve for both, no search for contact.

Source: Aulisa & Capodaglio, Monolithic coupling of implicit material point method with finite element method, section 6.3, row 2.
Expected: the disk's centre at (0.1093347, 0.04848217) m at 0.2 s (reference computation), the plate pressed down
under it, no particle in the plate.
Runs in about 8 s to 0.2 s; `matpoint run disk_on_plate` goes on to 2.5 s.
"""

import matpoint as mp
import numpy as np


def case() -> mp.Case:
    """The case, word for word as cases/disk_on_plate.toml."""
    return mp.Case(
        "disk_on_plate",
        title="A disk rolls down a plate of finite elements",
        source="Aulisa & Capodaglio, Monolithic coupling of implicit material point method with finite element method, "
        "section 6.3 (row 2 of its Table 2)",
        gravity=(6.936717523440032, -6.936717523440032),
        grid=mp.Grid(
            lower=(-2, -3.2),
            upper=(22, 3.4),
            cells=(20, 6),
            lines_y=(-3.2, -2.4, -1.6, -0.7327913279132791, 0.3512195121951218, 1.7062330623306233, 3.4),
            refinements=2,
        ),
        time=mp.Time(end=2.5, dt=0.01),
        solver=mp.Solver(type="implicit", basis="element", beta=0.3, initial_acceleration="zero", soft_stiffness=(1e-3, 1e-7)),
        body=[
            mp.Body(
                name="disk",
                region=mp.Disk(center=(0, 0.1), radius=1.6),
                layout=mp.LayeredDisk(core_radius=1.4, points=600, ratio=1.05, normalized=False),
                material=mp.NeoHookean(density=1000, youngs_modulus=4.2e6, poissons_ratio=0.4),
            ),
            mp.Body(
                name="plate",
                method="elements",
                region=mp.Box(lower=(-2, -3.2), upper=(22, -1.6)),
                material=mp.NeoHookean(density=1000, youngs_modulus=8.4e6, poissons_ratio=0.4),
                weight_density=0,
                receding_correction=0.5,
            ),
        ],
        boundary=[
            mp.Boundary(side="bottom", kind="fixed"),
            mp.Boundary(side="left", kind="slip"),
            mp.Boundary(side="right", kind="slip"),
            mp.Boundary(side="top", kind="slip"),
        ],
        probe=mp.Probe(name="center", body="disk", particle=0),
    )


def run() -> mp.Simulation:
    """Runs the first steps of it."""
    simulation = case().build()
    simulation.run(until=0.2, progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    assert np.abs(simulation.bodies["disk"].position[0] - (0.1093347, 0.04848217)).max() < 2e-6
    assert simulation.history["penetrated_particles"].max() == 0
    assert simulation.history["plate.strain_energy"][-1] > 800
    assert simulation.history["newton_iterations"].max() <= 5


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "von_mises").savefig("disk_on_plate.png")
