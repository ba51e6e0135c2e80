"""A ball of snow hits a wall at 5 m/s, packs, and clings to it, while loose snow flies off.

Source: Stomakhin, Schroeder, Chai, Teran & Selle (2013) for the law and its parameters.
Expected: after 0.4 s nine tenths of the ball are within 0.2 m of the wall; the snow there has packed to a volume of 0.5.
Runs in about 15 s. The same as a case file: `matpoint run snowball`.
"""

import matpoint as mp
import numpy as np


def case() -> mp.Case:
    """The case, word for word as cases/snowball.toml."""
    return mp.Case(
        "snowball",
        title="A snowball hits a wall",
        source="Stomakhin et al. (2013) for the law",
        gravity=(0, -9.81),
        grid=mp.Grid(upper=(1, 1.2), cells=(100, 120)),
        time=mp.Time(end=0.4),
        output=mp.Output(fields=["velocity", "plastic_volume_strain", "pressure"]),
        body=[
            mp.Body(
                name="ball",
                region=mp.Disk(center=(0.6, 0.5), radius=0.1),
                layout=mp.PerCell(count=9),
                velocity=mp.UniformVelocity(value=(5, 1)),
                material="snow_dry",
            ),
        ],
        boundary=[
            mp.Boundary(side="right", kind="fixed"),
            mp.Boundary(side="bottom", kind="fixed"),
            mp.Boundary(side="left", kind="slip"),
            mp.Boundary(side="top", kind="slip"),
        ],
    )


def run() -> mp.Simulation:
    """Runs it."""
    simulation = case().build()
    simulation.run(progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    ball = simulation.bodies["ball"]
    assert (ball.position[:, 0] > 0.8).mean() > 0.85
    assert 0.4 < np.exp(ball.field("plastic_volume_strain")).min() < 0.7


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "plastic_volume_strain").savefig("snowball.png")
