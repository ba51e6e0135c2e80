"""Two elastic disks fly towards each other, collide and part.

Source: Sulsky, Chen & Schreyer (1994); Kamuth, thesis on the explicit material point method, section 8.3.
Expected: energy 2.5132741 J per metre at the start, restitution 0.96898, zero momentum of a disk at 1.6540 s.
Runs in about 1 s. The same as a case file: `matpoint run disks`.
"""

import matpoint as mp
import numpy as np


def case() -> mp.Case:
    """The case, word for word as cases/disks.toml."""
    return mp.Case(
        "disks",
        title="Two elastic disks collide",
        source="Sulsky, Chen & Schreyer (1994); Kamuth, thesis on the explicit material point method, section 8.3",
        grid=mp.Grid(upper=(1, 1), cells=(20, 20)),
        time=mp.Time(dt=0.0001, end=3),
        solver=mp.Solver(shape="linear", stress_order="usl", mass_cutoff=1e-10),
        output=mp.Output(history_every=0.01, fields_every=0.05),
        body=[
            mp.Body(
                name="lower",
                region=mp.Disk(center=(0.2, 0.2), radius=0.2),
                layout=mp.Lattice(divisions=(10, 10), points=2),
                velocity=mp.UniformVelocity(value=(0.1, 0.1)),
                material=mp.StVenantKirchhoff(density=1000, youngs_modulus=10000.0, poissons_ratio=0.3),
            ),
            mp.Body(
                name="upper",
                region=mp.Disk(center=(0.8, 0.8), radius=0.2),
                layout=mp.Lattice(divisions=(10, 10), points=2),
                velocity=mp.UniformVelocity(value=(-0.1, -0.1)),
                material=mp.StVenantKirchhoff(density=1000, youngs_modulus=10000.0, poissons_ratio=0.3),
            ),
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
    lower = history["lower.momentum_x"]
    assert abs(history["kinetic_energy"].max() - 2.5132741228718345) < 1e-11
    assert abs(-lower[-1] / lower[0] - 0.96898) < 4e-4  # restitution
    turn = int(np.argmax(lower < 0))  # the rows around the time of zero momentum
    time = np.interp(0.0, -lower[turn - 1 : turn + 1], history["time"][turn - 1 : turn + 1])
    assert abs(time - 1.6540) < 1e-3
    assert np.abs(history["momentum_x"]).max() < 1e-12


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done).savefig("disks.png")
    mp.plot.energies(done.history).savefig("disks_energies.png")
