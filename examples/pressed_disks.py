"""Two elastic disks are pressed together, in one load step of the implicit solver: contact between bodies of particles.

Source: Hertz; K. L. Johnson, Contact Mechanics (1985), eqs. 4.43 and 5.57. A quarter of each disk between planes of symmetry; the upper
one comes down by 15.3 mm.
Expected: the force with which Hertz's disks come that near within 3 %, no body enters the other, and nothing pulls.
Runs in about 1 s.
"""

import matpoint as mp
import numpy as np

RADIUS, SPACING, WAY = 0.5, 1 / 160, 0.0153
MODULUS, POISSON = 1e6, 0.3


def quarter_disk(name: str, is_upper: bool) -> mp.Body:
    """Particles in rings, as square pieces: their surface is smooth, which that of a lattice is not."""
    positions, volumes = [], []
    for r in np.arange(SPACING / 2, RADIUS, SPACING):
        count = max(1, round(np.pi * r / 2 / SPACING))
        angles = (np.arange(count) + 0.5) * np.pi / 2 / count
        y = r * np.cos(angles)
        positions.append(np.stack([r * np.sin(angles), 2 * RADIUS - y if is_upper else y], axis=1))
        volumes.append(np.full(count, r * SPACING * np.pi / 2 / count))
    return mp.Body(
        name=name,
        layout=mp.Points(positions=np.concatenate(positions), volumes=np.concatenate(volumes)),
        material=mp.NeoHookean(density=1000, youngs_modulus=MODULUS, poissons_ratio=POISSON),
    )


def case() -> mp.Case:
    """The case: each body has a field of displacements of its own."""
    return mp.Case(
        "pressed_disks",
        grid=mp.Grid(upper=(0.6, 1), cells=(48, 80)),
        time=mp.Time(dt=1, end=1),
        solver=mp.Solver(type="implicit", mode="static", contact="pairs"),
        body=[quarter_disk("low", False), quarter_disk("high", True)],
        boundary=[
            mp.Boundary(side="left"),
            mp.Boundary(side="bottom", name="floor"),
            mp.Boundary(side="top", name="ram", kind="velocity", components=["y"], velocity=(0, -WAY)),
        ],
    )


def run() -> mp.Simulation:
    """Runs it."""
    simulation = case().build()
    simulation.run()
    return simulation


def hertz(force: float) -> tuple[float, float]:
    """Half-width of the contact and approach of the middles of Hertz's disks under a force per length [m]."""
    plane = (1 - POISSON**2) / MODULUS
    half_width = np.sqrt(4 * force * RADIUS * plane / np.pi)
    return half_width, 2 * force * plane / np.pi * (2 * np.log(4 * RADIUS / half_width) - 1)


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    force = 2 * simulation.boundaries["floor"].force[1]
    assert abs(hertz(force)[1] / WAY - 1) < 0.03
    low, high = simulation.bodies["low"], simulation.bodies["high"]
    assert low.position[:, 1].max() < high.position[:, 1].min()
    assert low.stress[:, 1, 1].max() < 0.02 * abs(low.stress[:, 1, 1].min())


if __name__ == "__main__":
    done = run()
    check(done)
    total = 2 * done.boundaries["floor"].force[1]
    print(f"force {total:.0f} N/m, contact {2000 * hertz(total)[0]:.0f} mm wide, approach {hertz(total)[1] / WAY:.3f} of Hertz's")
    mp.plot.particles(done, "stress_yy").savefig("pressed_disks.png")
