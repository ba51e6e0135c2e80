"""A cantilever falls under its weight and swings when the load ceases: implicit steps of 8 ms.

Source: Aulisa & Capodaglio, Monolithic coupling of implicit material point method with finite element method, section 6.2.
Expected: tip at (0.0119456, -0.3638782) m at 0.4 s (reference computation), where the beam has just been let go.
Newton's method takes 2 to 5 iterations a step.
Runs in about 5 s to 0.4 s; `matpoint run cantilever` goes on to 8 s.
"""

import matpoint as mp
import numpy as np


def case() -> mp.Case:
    """The case, word for word as cases/cantilever.toml."""
    return mp.Case(
        "cantilever",
        title="A cantilever swings after a load that ceases",
        source="Aulisa & Capodaglio, Monolithic coupling of implicit material point method with finite element method, section 6.2",
        gravity=(0, -9.81),
        gravity_times=(0.392, 0.4),
        gravity_factors=(1, 0),
        grid=mp.Grid(lower=(-0.5, -0.5), upper=(0.5, 0.5), cells=(2, 2), refinements=3),
        time=mp.Time(end=8, dt=0.008),
        solver=mp.Solver(
            type="implicit",
            basis="element",
            beta=0.3,
            initial_acceleration="zero",
            soft_stiffness=(1e-6, 1e-10),
        ),
        output=mp.Output(history_every=0.008),
        body=mp.Body(
            name="beam",
            region=mp.Box(lower=(-0.5, -0.125), upper=(0.125, 0.125)),
            layout=mp.LayeredBeam(core_height=0.15, rows=20, ratio=1.148, normalized=False),
            material=mp.NeoHookean(density=1e4, youngs_modulus=1.74e6, poissons_ratio=0.4),
        ),
        boundary=[
            mp.Boundary(side="left", kind="fixed", attached=True),
            mp.Boundary(side="right", kind="slip"),
            mp.Boundary(side="bottom", kind="slip"),
            mp.Boundary(side="top", kind="slip"),
        ],
        probe=mp.Probe(name="tip", body="beam", nearest=(0.125, -0.0001)),
    )


def run() -> mp.Simulation:
    """Runs it until the load has ceased."""
    simulation = case().build()
    simulation.run(until=0.4, progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    start = case().build().bodies["beam"].position
    tip = int(np.argmin(np.linalg.norm(start - (0.125, -0.0001), axis=1)))
    position = simulation.bodies["beam"].position[tip]
    assert np.abs(position - (0.01194564, -0.3638782)).max() < 1e-6
    iterations = simulation.history["newton_iterations"][1:]
    assert 2 <= iterations.min() and iterations.max() <= 5


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "von_mises").savefig("cantilever.png")
