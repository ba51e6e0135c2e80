"""A column of rods collapses on a rough floor: Mohr-Coulomb's law with 19.8 degrees of friction and no cohesion.

Source: Bui, Fukagawa, Sako & Ohno (2008), experiment: the toe of the heap comes to 0.44 m.
Expected: the toe at 0.425 m, the surface 2.0 mm from the measured one in the mean, all at rest after 0.8 s.
Runs in about 2 s. The same as a case file: `matpoint run granular_column`.
"""

import matpoint as mp
import numpy as np

MEASURED = [0.0992, 0.0959, 0.0844, 0.0722, 0.0616, 0.0474, 0.0348, 0.0265, 0.0189, 0.0109, 0.0037, 0.0015]
"""Height of the surface [m] at 0, 0.04, 0.08, ... m."""


def case() -> mp.Case:
    """The case, word for word as cases/granular_column.toml."""
    return mp.Case(
        "granular_column",
        title="A granular column collapses",
        source="Bui, Fukagawa, Sako & Ohno (2008)",
        gravity=(0, -9.81),
        grid=mp.Grid(upper=(0.6, 0.15), cells=(120, 30)),
        time=mp.Time(end=0.8),
        body=[
            mp.Body(
                name="rods",
                region=mp.Box(lower=(0, 0), upper=(0.2, 0.1)),
                layout=mp.PerCell(count=4),
                material=mp.MohrCoulomb(density=2650, youngs_modulus=0.84e6, poissons_ratio=0.3, cohesion=0, friction_angle=19.8),
            ),
        ],
        boundary=[mp.Boundary(side="bottom", kind="fixed"), mp.Boundary(side="left", kind="slip")],
    )


def surface(simulation: mp.Simulation) -> np.ndarray:
    """Height of the heap [m] where it was measured."""
    x = np.asarray(simulation.bodies["rods"].position)
    quarter = 0.005 / 4  # of a cell: from a particle's middle to its top
    heights = []
    for place in 0.04 * np.arange(len(MEASURED)):
        near = abs(x[:, 0] - max(place, quarter)) < 0.0026
        heights.append(x[near, 1].max() + quarter if near.any() else 0)
    return np.array(heights)


def run() -> mp.Simulation:
    """Runs it."""
    simulation = case().build()
    simulation.run(progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    assert abs(np.asarray(simulation.bodies["rods"].position)[:, 0].max() - 0.425) < 0.01
    assert abs(surface(simulation) - MEASURED).mean() < 0.003
    assert simulation.history["kinetic_energy"][-1] < 1e-4


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "plastic_strain").savefig("granular_column.png")
