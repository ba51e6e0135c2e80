"""A block on a rigid incline of 30 degrees sticks or slides, as Coulomb's law says.

Source: Coulomb's law: it slides with g (sin a - mu cos a) if mu < tan a = 0.577, else it stays.
Expected: accelerations within 0.5 % of g for mu = 0, 0.3 and 0.7.
Runs in about 3 s.
"""

import math

import matpoint as mp

ANGLE = math.radians(30)
GRAVITY = 9.81  # m/s^2


def case(friction: float) -> mp.Case:
    """The incline is the bottom of the grid, gravity is turned instead; it grows within .2 s, so that the block is pressed on gently."""
    return mp.Case(
        "incline",
        gravity=(GRAVITY * math.sin(ANGLE), -GRAVITY * math.cos(ANGLE)),
        gravity_times=[0, 0.2],
        gravity_factors=[0, 1],
        grid=mp.Grid(upper=(3, 0.5), cell_size=0.0625),
        time=mp.Time(end=0.8, cfl=0.3),
        solver=mp.Solver(mass_cutoff=0),
        body=[
            mp.Body(
                name="block",
                region=mp.Box(lower=(0.5, 0), upper=(1, 0.25)),
                layout=mp.PerCell(count=4),
                material=mp.NeoHookean(density=1000, youngs_modulus=2e5, poissons_ratio=0.3),
            )
        ],
        boundary=[mp.Boundary(side="bottom", kind="fixed", contact="friction", friction=friction)],
    )


def run() -> dict[float, float]:
    """Mean acceleration along the incline over g, by coefficient of friction."""
    accelerations = {}
    for friction in (0, 0.3, 0.7):
        simulation = case(friction).build()
        simulation.run()
        mean = float(simulation.bodies["block"].velocity[:, 0].mean())
        accelerations[friction] = mean / (GRAVITY * (simulation.time - 0.1))
    return accelerations


def check(accelerations: dict[float, float]) -> None:
    """Compares with the numbers above."""
    for friction, found in accelerations.items():
        exact = max(0, math.sin(ANGLE) - friction * math.cos(ANGLE))
        assert abs(found - exact) < 0.005, (friction, found, exact)


if __name__ == "__main__":
    done = run()
    check(done)
    for friction, found in done.items():
        print(f"friction {friction:3.1f}: {found:.4f} g, Coulomb {max(0, math.sin(ANGLE) - friction * math.cos(ANGLE)):.4f} g")
