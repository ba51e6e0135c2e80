"""A nearly incompressible beam bends by its weight: with F-bar as far as it should, without it hardly.

Source: Euler-Bernoulli beam in plane strain with Timoshenko's shear: w = q L^4 / (8 E' I) + q L^2 / (2 k G A), E' = E / (1 - nu^2).
Expected: with `fbar` within 8 % of that, without it less than 60 %.
Runs in about 10 s.
"""

import math

import matpoint as mp

LENGTH, HEIGHT, CELL = 1.0, 0.2, 0.05
DENSITY, E, NU, GRAVITY = 1000.0, 1e6, 0.499, 1.0


def deflection(fbar: bool) -> float:
    """How far the tip sinks [m]."""
    # Damped critically in the first mode of the beam; gravity grows over two of its periods.
    bending = E / (1 - NU**2) * HEIGHT**3 / 12
    omega = 1.875**2 / LENGTH**2 * math.sqrt(bending / (DENSITY * HEIGHT))
    period = 2 * math.pi / omega
    simulation = mp.Case(
        "beam",
        gravity=(0, -GRAVITY),
        gravity_times=(0, 2 * period),
        gravity_factors=(0, 1),
        grid=mp.Grid(lower=(0, 0), upper=(1.1, 0.3), cell_size=CELL),
        time=mp.Time(end=5 * period, cfl=0.5),
        solver=mp.Solver(shape="linear", stress_order="usl", damping=2 * omega),
        body=mp.Body(
            name="beam",
            formulation="total",
            fbar=fbar,
            region=mp.Box(lower=(0, 0.05), upper=(LENGTH, 0.05 + HEIGHT)),
            layout=mp.PerCell(count=4),
            material=mp.NeoHookean(density=DENSITY, youngs_modulus=E, poissons_ratio=NU),
        ),
        boundary=mp.Boundary(side="left", kind="fixed"),
    ).build()
    beam = simulation.bodies["beam"]
    at_tip = beam.position[:, 0] > LENGTH - CELL / 2
    before = beam.position[at_tip, 1].mean()
    simulation.run()
    return float(before - beam.position[at_tip, 1].mean())


def exact() -> float:
    """The tip's deflection of a slender beam [m]."""
    load = DENSITY * GRAVITY * HEIGHT
    bending = E / (1 - NU**2) * HEIGHT**3 / 12
    shear = 5 / 6 * E / (2 * (1 + NU)) * HEIGHT
    return load * LENGTH**4 / (8 * bending) + load * LENGTH**2 / (2 * shear)


def run() -> dict[str, float]:
    """The deflections over the exact one, with F-bar and without."""
    return {"with": deflection(True) / exact(), "without": deflection(False) / exact()}


def check(results: dict[str, float]) -> None:
    """Compares with the numbers above."""
    assert abs(results["with"] - 1) < 0.08, results
    assert results["without"] < 0.6, results


if __name__ == "__main__":
    found = run()
    print(f"of {1000 * exact():.1f} mm: {found['with']:.3f} with F-bar, {found['without']:.3f} without")
    check(found)
