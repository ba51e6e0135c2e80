"""A slope of 2:1 whose soil is too weak slides on a circle through its foot; and its factor of safety, by reducing the strength.

Source: Griffiths & Lane (1999), example 1: 1.4; Bishop's circles: 1.38.
Expected: it stands with its strength divided by 1.3, and slides where it is divided by 1.5: there the crest moves by 4 to 5 cm.
Runs in about 5 s. The same as a case file: `matpoint run slope`.
"""

import math

import matpoint as mp
import numpy as np


def case(factor: float = 1.5) -> mp.Case:
    """The case, for 1.5 word for word as cases/slope.toml: tan phi = tan(20)/factor and c = 0.05 rho g H/factor."""
    phi = math.degrees(math.atan(math.tan(math.radians(20)) / factor))
    return mp.Case(
        "slope",
        title="A slope that slides",
        source="Griffiths & Lane (1999), example 1; Bishop & Morgenstern's charts",
        gravity=(0, -9.81),
        gravity_times=[0, 1.5],
        gravity_factors=[0, 1],
        grid=mp.Grid(upper=(6, 1.3), cells=(60, 13)),
        time=mp.Time(end=3),
        body=[
            mp.Body(
                name="ground",
                region=mp.Polygon(vertices=[(1.5, 0), (6, 0), (6, 1), (3.5, 1)]),
                layout=mp.PerCell(count=4),
                material=mp.MohrCoulomb(
                    density=2000, youngs_modulus=9.81e6, poissons_ratio=0.3, cohesion=981 / factor, friction_angle=round(phi, 4)
                ),
            ),
        ],
        boundary=[mp.Boundary(side="bottom", kind="fixed"), mp.Boundary(side="right", kind="slip")],
    )


def ways(simulation: mp.Simulation) -> list[float]:
    """Way [m] of the crest when all of the weight is there, and at the end; runs it."""
    start = np.array(simulation.bodies["ground"].position)
    crest = np.argmin(np.linalg.norm(start - [3.5, 1], axis=1))
    found = []
    for until in (1.5, 3):
        simulation.run(until=until)
        found.append(float(np.linalg.norm(simulation.bodies["ground"].position[crest] - start[crest])))
    return found


def run() -> mp.Simulation:
    """Runs it."""
    simulation = case().build()
    simulation.run(progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    assert np.asarray(simulation.bodies["ground"].field("plastic_strain")).max() > 0.1
    settled, end = ways(case(1.3).build())
    assert end < 1.1 * settled
    settled, end = ways(case(1.5).build())
    assert end > 5 * settled and 0.04 < end < 0.05


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "plastic_strain").savefig("slope.png")
    for factor in (1.2, 1.3, 1.4, 1.5, 1.6):
        settled, end = ways(case(factor).build())
        print(f"strength over {factor}: the crest moves by {1e3 * settled:.1f} mm under the weight, and by {1e3 * end:.1f} mm in the end")
