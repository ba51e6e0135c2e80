"""A ball of soft rubber falls on a frictionless floor and bounces.

Source: finite elements (explicit, 48 across the ball, frictionless floor that lets go): the centre is lowest at 0.0993 m, the next top
at 0.3745 m.
Expected: 2.61 m/s at the floor (2.62 m/s for a point), 1.97 m/s after the bounce; lowest 0.103 m, next top 0.356 m; 80 cells 0.101, 0.373.
Runs in about 1 s. The same as a case file: `matpoint run ball`.
"""

import matpoint as mp


def case() -> mp.Case:
    """The case, word for word as cases/ball.toml."""
    return mp.Case(
        "ball",
        title="A rubber ball falls",
        gravity=(0, -9.81),
        grid=mp.Grid(upper=(1.0, 1.0), cells=(40, 40)),
        time=mp.Time(end=1.0),
        body=[
            mp.Body(
                name="ball",
                region=mp.Disk(center=(0.5, 0.5), radius=0.15),
                layout=mp.PerCell(count=4),
                material=mp.NeoHookean(density=1000, youngs_modulus=100000.0, poissons_ratio=0.3),
            ),
        ],
        boundary=[
            mp.Boundary(side="bottom", kind="slip", contact="no_tension"),
        ],
    )


def run() -> mp.Simulation:
    """Runs it."""
    problem = case()
    simulation = problem.build()
    simulation.run(progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    history = simulation.history
    speed = history["momentum_y"] / history["mass"]
    assert abs(speed.min() + 2.61) < 0.03
    assert abs(speed.max() - 1.97) < 0.05
    height = history["center_of_mass_y"]
    assert abs(height.min() / 0.0993 - 1) < 0.04
    assert abs(height[history["time"] > 0.4].max() / 0.3745 - 1) < 0.06
    assert history["ball.lower_y"].min() > 0


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done).savefig("ball.png")
    mp.plot.energies(done.history).savefig("ball_energies.png")
