"""A beam of ice falls on a peg and breaks: a brittle solid with a fracture energy.

Source: Oliver, Cervera, Oller & Lubliner (1990) for the law; the fracture energy by the width of the cells after Bazant & Oh (1983).
Expected: the beam has broken over the peg, and its ends fall; what broke took 4.5 J, 6 % of the energy that moves.
Runs in about 5 s. The same as a case file: `matpoint run ice`.
"""

import matpoint as mp
import numpy as np


def case() -> mp.Case:
    """The case, word for word as cases/ice.toml."""
    return mp.Case(
        "ice",
        title="A beam of ice breaks",
        source="Oliver et al. (1990) for the law",
        gravity=(0, -9.81),
        grid=mp.Grid(upper=(1, 0.6), cells=(100, 60)),
        time=mp.Time(end=0.08),
        output=mp.Output(fields=["velocity", "damage"]),
        body=[
            mp.Body(
                name="beam",
                region=mp.Box(lower=(0.1, 0.2), upper=(0.9, 0.28)),
                layout=mp.PerCell(count=4),
                velocity=mp.UniformVelocity(value=(0, -1)),
                material=mp.RankineDamage(density=900, youngs_modulus=1e8, poissons_ratio=0.3, tensile_strength=1e5, fracture_energy=2),
            ),
        ],
        boundary=[
            mp.Boundary(name="peg", region=mp.Box(lower=(0.48, 0), upper=(0.52, 0.19)), kind="fixed"),
            mp.Boundary(side="bottom", kind="slip"),
            mp.Boundary(side="left", kind="slip"),
            mp.Boundary(side="right", kind="slip"),
        ],
    )


def run() -> mp.Simulation:
    """Runs it."""
    simulation = case().build()
    simulation.run(progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    beam = simulation.bodies["beam"]
    x, damage = beam.position[:, 0], np.asarray(beam.field("damage"))
    assert damage[(x > 0.45) & (x < 0.55)].max() > 0.99
    assert damage[(x < 0.12) | (x > 0.88)].max() < 0.1
    assert 1 < simulation.history["plastic_dissipation"][-1] < 6


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "damage").savefig("ice.png")
