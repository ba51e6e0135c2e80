"""A round bar of copper hits a rigid wall at 227 m/s: Taylor's impact test, half of a section around the axis.

Source: published lengths 21.42 to 21.43 mm and radii 7.11 to 7.22 mm (axisymmetric finite elements).
Expected: 21.4 mm long, a foot of 7.2 mm, 99 % of the energy is plastic work.
Runs in about 1 s. The same as a case file: `matpoint run taylor_axial`.
"""

import matpoint as mp
import numpy as np


def case() -> mp.Case:
    """The case, word for word as cases/taylor_axial.toml."""
    return mp.Case(
        "taylor_axial",
        title="Taylor's impact test around an axis",
        source="Taylor (1948); Wilkins & Guinan (1973)",
        grid=mp.Grid(upper=(0.0096, 0.0352), cells=(24, 88), axisymmetric=True),
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
        boundary=[mp.Boundary(side="bottom", kind="slip")],
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
    quarter = 0.0001  # of a cell: half of a particle
    assert abs((x[:, 1].max() + quarter) * 1e3 - 21.43) < 0.05
    assert abs((x[:, 0].max() + quarter) * 1e3 - 7.17) < 0.05
    history = simulation.history
    assert abs(history["mass"][-1] - 8930 * np.pi * 0.0032**2 * 0.0324) < 1e-12
    assert 0.98 < history["plastic_dissipation"][-1] / history["kinetic_energy"][0] < 1.0


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "plastic_strain").savefig("taylor_axial.png")
