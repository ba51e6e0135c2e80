"""Two disks collide, each with its own velocities: they touch when they touch, and not a cell before.

Source: Sulsky, Chen & Schreyer (1994); the disks' outlines touch at t = 1.5858 s.
Expected: they begin to slow within 3.5 % of that time (with one velocity field: at 1.22 s), the energy never rises and falls by
at most 8 %, momentum stays zero.
Runs in about 3 s.
"""

import matpoint as mp
import numpy as np
from disks import case


def run(contact: str = "multi_field") -> mp.Simulation:
    """Runs the shipped case with a velocity field per body, and MUSL."""
    problem = case()
    problem.solver.stress_order = "musl"
    problem.solver.contact = contact
    problem.output.history_every = 0.001
    simulation = problem.build()
    simulation.run()
    return simulation


def time_of_contact(simulation: mp.Simulation) -> float:
    """When the disks have lost a ten-thousandth of their kinetic energy [s]."""
    kinetic = simulation.history["kinetic_energy"]
    return float(simulation.history["time"][np.argmax(kinetic < kinetic[0] * (1 - 1e-4))])


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    history = simulation.history
    energy = (history["kinetic_energy"] + history["strain_energy"]) / history["kinetic_energy"][0]
    assert abs(time_of_contact(simulation) - 1.5858) < 0.035 * 1.5858
    assert energy.max() < 1 + 1e-6
    assert energy[-1] > 0.92
    assert abs(history["momentum_x"]).max() < 1e-12


if __name__ == "__main__":
    done = run()
    check(done)
    print(f"one velocity field: {time_of_contact(run('single_field')):.3f} s, one for each: {time_of_contact(done):.3f} s, exact: 1.586 s")
    mp.plot.particles(done).savefig("contact.png")
