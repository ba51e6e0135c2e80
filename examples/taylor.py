"""A bar of copper hits a rigid wall at 227 m/s and mushrooms: Taylor's impact test, in plane strain.

Source: finite elements (Q1P0, explicit, 8 x 40 and 16 x 80): 21.86 and 21.68 mm long, half 12.81 and 12.62 mm wide at the foot.
Expected: 21.6 mm long, half 13.1 mm wide, 98 % of the energy is plastic work.
Runs in about 1 s. The same as a case file: `matpoint run taylor`.
"""

import matpoint as mp
import numpy as np


def case() -> mp.Case:
    """The case, word for word as cases/taylor.toml."""
    return mp.Case(
        "taylor",
        title="Taylor's impact test",
        source="Taylor (1948); Wilkins & Guinan (1973)",
        grid=mp.Grid(upper=(0.0192, 0.0352), cells=(36, 66)),
        solver=mp.Solver(shape="bspline2"),
        time=mp.Time(end=80e-6),
        body=[
            mp.Body(
                name="bar",
                region=mp.Box(lower=(0, 0), upper=(0.0032, 0.0324)),
                layout=mp.PerCell(count=4),
                velocity=mp.UniformVelocity(value=(0, -227)),
                material=mp.J2(
                    density=8930,
                    youngs_modulus=117e9,
                    poissons_ratio=0.35,
                    yield_stress=400e6,
                    hardening_modulus=100e6,
                ),
            ),
        ],
        boundary=[mp.Boundary(side="bottom", kind="slip"), mp.Boundary(side="left", kind="slip")],
    )


def run() -> mp.Simulation:
    """Runs it."""
    simulation = case().build()
    simulation.run(progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    bar = simulation.bodies["bar"]
    x = np.asarray(bar.position)
    assert abs(x[:, 1].max() * 1e3 - 21.6) < 0.3
    assert abs(x[:, 0].max() * 1e3 - 13.1) < 0.3
    history = simulation.history
    assert history["plastic_dissipation"][-1] > 0.97 * history["kinetic_energy"][0]
    assert 2 < np.asarray(bar.field("plastic_strain")).max() < 4


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "plastic_strain").savefig("taylor.png")
