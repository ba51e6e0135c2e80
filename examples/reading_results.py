"""Reading what a run has written: fields by body, name and time, the history, pictures, and a hand-over to PyVista.

Source: the disks of disks.py.
Expected: the files hold what the simulation had, to single precision; momentum of the two disks is opposite at each time.
Runs in about 2 s.
"""

import tempfile
from pathlib import Path

import matpoint as mp
import numpy as np
from disks import case


def run() -> tuple[mp.Simulation, mp.Results, Path]:
    """Runs to 1.7 s into a new folder, opens it, and draws a picture and an animation there."""
    folder = Path(tempfile.mkdtemp()) / "disks"
    problem = case()
    problem.output.fields_every = 0.1
    simulation = problem.build()
    simulation.run(until=1.7, output=folder)
    results = mp.results.open(folder)
    mp.plot.particles(results, "von_mises", times=[0.0, 1.5, 1.7]).savefig(folder / "stress.png")
    mp.plot.animate(results, "von_mises", folder / "stress.gif")
    return simulation, results, folder


def check(done: tuple[mp.Simulation, mp.Results, Path]) -> None:
    """Compares the files with the simulation."""
    simulation, results, folder = done
    lower = results.bodies["lower"]
    assert len(lower.times) == 18 and abs(lower.times[-1] - simulation.time) < 1e-12
    written = lower.field("velocity", -1)[:, :2]  # vectors have three components in files
    assert np.allclose(written, simulation.bodies["lower"].velocity, rtol=1e-6, atol=1e-8)
    for index in range(len(lower.times)):
        momentum = sum(body.field("mass", index).astype(float) @ body.field("velocity", index) for body in results.bodies.values())
        assert np.abs(momentum).max() < 1e-5  # of 12.6 N s: single precision
    assert np.array_equal(results.history["kinetic_energy"], simulation.history["kinetic_energy"])
    assert (folder / "stress.png").stat().st_size > 10_000 and (folder / "stress.gif").stat().st_size > 10_000


if __name__ == "__main__":
    check(run())
