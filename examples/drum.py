"""A drum that turns slowly, two fifths full of sand: the angle at which its surface flows.

Source: Rajchenbach (1990): a surface that flows steadily, and plane, as long as the drum is slow.
Expected: the surface is inclined by the angle of friction, 30 degrees, within 2.
Runs in about 6 s. The same as a case file: `matpoint run drum`.
"""

import math

import matpoint as mp
import numpy as np


def case(friction_angle: float = 30) -> mp.Case:
    """The case, for 30 degrees word for word as cases/drum.toml."""
    circle = mp.Disk(center=(0, 0), radius=0.5)
    box = mp.Box(lower=(-0.55, -0.55), upper=(0.55, 0.55))
    return mp.Case(
        "drum",
        title="A rotating drum",
        source="Rajchenbach (1990): a surface that flows steadily, and plane, as long as the drum is slow",
        gravity=(0, -9.81),
        grid=mp.Grid(lower=(-0.55, -0.55), upper=(0.55, 0.55), cells=(44, 44)),
        time=mp.Time(end=8),
        output=mp.Output(fields_every=0.25),
        body=[
            mp.Body(
                name="sand",
                region=mp.Difference(of=[circle, mp.HalfSpace(point=(0, -0.1), normal=(0, -1))]),
                layout=mp.PerCell(count=4),
                material=mp.DruckerPrager(density=1600, youngs_modulus=1e6, poissons_ratio=0.3, cohesion=0, friction_angle=friction_angle),
            ),
        ],
        boundary=[
            mp.Boundary(
                name="drum",
                region=mp.Difference(of=[box, circle]),
                kind="velocity",
                velocity=mp.RotatingVelocity(center=(0, 0), angular_velocity=0.5),
                times=[0, 0.5],
                factors=[0, 1],
            )
        ],
    )


def surface_angle(simulation: mp.Simulation) -> float:
    """Inclination [degrees] of a line through the highest particles in 20 strips of the middle half."""
    position = simulation.bodies["sand"].position
    middles = np.linspace(-0.2375, 0.2375, 20)
    heights = [position[np.abs(position[:, 0] - x) <= 0.0125, 1].max() for x in middles]
    return math.degrees(math.atan(np.polyfit(middles, heights, 1)[0]))


def steady_angle(simulation: mp.Simulation) -> float:
    """Runs it; the mean of the last four seconds."""
    angles = []

    @simulation.every(time=0.25)
    def measure(now: mp.Simulation) -> None:
        if now.time > 4:
            angles.append(surface_angle(now))

    simulation.run()
    return float(np.mean(angles))


def run() -> tuple[mp.Simulation, float]:
    """Runs it, and measures."""
    simulation = case().build()
    return simulation, steady_angle(simulation)


def check(done: tuple[mp.Simulation, float]) -> None:
    """Compares with the numbers above."""
    assert abs(done[1] - 30) < 2


if __name__ == "__main__":
    simulation, angle = done = run()
    check(done)
    print(f"The surface flows at {angle:.1f} degrees.")
    mp.plot.particles(simulation, "velocity").savefig("drum.png")
    for friction_angle in (20, 40):
        print(f"With a friction of {friction_angle} degrees at {steady_angle(case(friction_angle).build()):.1f}.")
