"""A quarter of a thick tube with a pressure inside, in statics: loads on the surface of particles.

Source: Lame's solution for a thick cylinder in plane strain.
Expected: the inner surface moves outwards as Lame says, to 1.5 %; the resultant is p times the bore's shadow as it is then.
Runs in about 1 s. The same as a case file: `matpoint run tube`.
"""

import matpoint as mp
import numpy as np

INNER, OUTER, MODULUS, POISSON, PRESSURE = 0.5, 1.0, 1e8, 0.3, 1e5


def case() -> mp.Case:
    """The case, word for word as cases/tube.toml."""
    bore = mp.Disk(center=(0, 0), radius=INNER)
    planes = [mp.HalfSpace(point=(0, 0), normal=(1, 0)), mp.HalfSpace(point=(0, 0), normal=(0, 1))]
    return mp.Case(
        "tube",
        title="A thick tube under pressure",
        source="Lame (1833)",
        grid=mp.Grid(upper=(1.2, 1.2), cells=(24, 24)),
        time=mp.Time(end=1, dt=1),
        solver=mp.Solver(type="implicit", mode="static"),
        body=[
            mp.Body(
                name="tube",
                region=mp.Difference(of=[mp.Disk(center=(0, 0), radius=OUTER), bore, *planes]),
                layout=mp.PerCell(count=9),
                material=mp.NeoHookean(density=1000, youngs_modulus=MODULUS, poissons_ratio=POISSON),
            ),
        ],
        boundary=[mp.Boundary(side="left", kind="slip"), mp.Boundary(side="bottom", kind="slip")],
        load=[mp.Load(name="gas", body="tube", kind="pressure", pressure=PRESSURE, region=mp.Disk(center=(0, 0), radius=0.75))],
    )


def lame(r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Displacement outwards [m] and stress around the axis [Pa] at the radius r [m]."""
    share = PRESSURE * INNER**2 / (OUTER**2 - INNER**2)
    moved = (1 + POISSON) / MODULUS * share * ((1 - 2 * POISSON) * r + OUTER**2 / r)
    return moved, share * (1 + OUTER**2 / r**2)


def run() -> tuple[mp.Simulation, np.ndarray]:
    """Runs it; with the positions at the start."""
    simulation = case().build()
    start = np.array(simulation.bodies["tube"].position)
    simulation.run()
    return simulation, start


def check(done: tuple[mp.Simulation, np.ndarray]) -> None:
    """Compares with Lame's solution."""
    simulation, start = done
    tube = simulation.bodies["tube"]
    r = np.hypot(start[:, 0], start[:, 1])
    moved = np.einsum("pi,pi->p", tube.position - start, start) / r
    displacement, around = lame(r)
    inner = r < INNER + 0.05
    assert abs((moved / displacement)[inner].mean() - 1) < 0.015
    normal = start / r[:, None]
    tangent = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
    hoop = np.einsum("pi,pij,pj->p", tangent, tube.stress[:, :2, :2], tangent)
    within = (r > 0.6) & (r < 0.9)  # the steps of the staircase are felt beside the surface
    assert abs(hoop / around - 1)[within].max() < 0.03
    bore = INNER + lame(np.array(INNER))[0]  # as it is now
    assert np.allclose(simulation.boundaries["gas"].force, PRESSURE * bore, rtol=1e-3)


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done[0], "von_mises").savefig("tube.png")
