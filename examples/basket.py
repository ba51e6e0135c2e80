"""A disk of particles thrown into an elastic basket of finite elements: faces below and at both sides.

Source: after the coupling of Aulisa & Capodaglio, Monolithic coupling of implicit material point method with finite element method.
Expected: the disk's centre of mass on a parabola until it touches; no particle in the basket; the basket sags by more than 0.2 m and
throws the disk back.
Runs in about 7 s.
"""

import matpoint as mp
import numpy as np


def case() -> mp.Case:
    """The case, word for word as cases/basket.toml."""
    return mp.Case(
        "basket",
        title="A disk thrown into a basket of finite elements",
        source="after the coupling of Aulisa & Capodaglio, Monolithic coupling of implicit material point method with finite element "
        "method, with faces below and at both sides",
        gravity=(0, -9.81),
        grid=mp.Grid(lower=(-1, -0.4), upper=(1, 1.6), cells=(10, 10), refinements=1),
        time=mp.Time(end=1, dt=0.002),
        solver=mp.Solver(type="implicit", basis="element", soft_stiffness=(1e-3, 1e-7)),
        body=[
            mp.Body(
                name="disk",
                region=mp.Disk(center=(-0.25, 1.1), radius=0.25),
                layout=mp.PerCell(count=64),
                velocity=mp.UniformVelocity(value=(1.5, -1)),
                material=mp.NeoHookean(density=1000, youngs_modulus=2e5, poissons_ratio=0.3),
            ),
            mp.Body(
                name="basket",
                method="elements",
                region=mp.Union(
                    of=[
                        mp.Box(lower=(-0.8, 0), upper=(0.8, 0.2)),
                        mp.Box(lower=(-0.8, 0.2), upper=(-0.6, 0.8)),
                        mp.Box(lower=(0.6, 0.2), upper=(0.8, 0.8)),
                    ]
                ),
                material=mp.NeoHookean(density=1200, youngs_modulus=1e6, poissons_ratio=0.3),
                receding_correction=0.1,
            ),
        ],
        boundary=[
            mp.Boundary(region=mp.Box(lower=(-1, 0.79), upper=(-0.55, 0.81)), kind="fixed"),
            mp.Boundary(region=mp.Box(lower=(0.55, 0.79), upper=(1, 0.81)), kind="fixed"),
        ],
        output=mp.Output(history_every=0.002, fields_every=0.04),
        probe=mp.Probe(name="center", body="disk", nearest=(-0.25, 1.1)),
    )


def run() -> mp.Simulation:
    """Runs it to the end."""
    simulation = case().build()
    simulation.run(progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    history = simulation.history
    flying = history["time"] <= 0.2
    t = history["time"][flying]
    assert np.abs(history["disk.center_of_mass_y"][flying] - (history["disk.center_of_mass_y"][0] - t - 0.5 * 9.81 * t**2)).max() < 1e-10
    assert history["penetrated_particles"].max() == 0
    assert history["basket.lower_y"].min() < -0.2
    lowest = history["disk.center_of_mass_y"].argmin()
    assert 0.27 < history["disk.center_of_mass_y"][lowest] < 0.29
    assert history["disk.momentum_y"][lowest:].max() > 0.5 * history["disk.mass"][0]
    # At the nodes: the rims are held, the floor hangs through.
    basket = simulation.bodies["basket"]
    held = basket.node_field("position")[:, 1] - basket.node_field("displacement")[:, 1] > 0.79
    assert np.all(basket.node_field("displacement")[held] == 0)


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "von_mises").savefig("basket.png")
