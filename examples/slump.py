"""A block of mud spreads on a rough floor and comes to rest, since it has a yield stress: Bingham's fluid.

Source: Liu & Mei (1989): at rest the lubrication limit reaches 0.2805 m. The same law in an independent program: 0.2463 m after 4 s.
Expected: the front at 0.208, 0.228, 0.237, 0.245 m after 1, 2, 3, 4 s.
Runs in about 2 s. The same as a case file: `matpoint run slump`.
"""

import matpoint as mp


def case() -> mp.Case:
    """The case, word for word as cases/slump.toml."""
    return mp.Case(
        "slump",
        title="A block of mud slumps",
        source="Liu & Mei (1989) for the shape at rest",
        gravity=(0, -9.81),
        grid=mp.Grid(upper=(0.4, 0.12), cells=(80, 24)),
        time=mp.Time(end=4),
        body=[
            mp.Body(
                name="mud",
                region=mp.Box(lower=(0, 0), upper=(0.1, 0.1)),
                layout=mp.PerCell(count=4),
                material=mp.HerschelBulkley(density=1000, youngs_modulus=3e4, poissons_ratio=0.3, yield_stress=50, consistency=20),
            ),
        ],
        boundary=[mp.Boundary(side="bottom", kind="fixed"), mp.Boundary(side="left", kind="slip")],
    )


def run() -> mp.Simulation:
    """Runs it."""
    simulation = case().build()
    simulation.run(progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    history = simulation.history
    front = history["mud.upper_x"]
    for time, place in ((1, 0.208), (2, 0.228), (3, 0.237), (4, 0.245)):
        assert abs(front[abs(history["time"] - time).argmin()] - place) < 0.005
    assert front.max() < 0.2805


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "plastic_strain").savefig("slump.png")
