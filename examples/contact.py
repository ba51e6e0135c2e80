"""Two disks collide, each with its own velocities: they touch when they touch, and not a cell before.

Source: Sulsky, Chen & Schreyer (1994); the disks' outlines touch at t = 1.5858 s.
Expected: they begin to slow within 3.5 % of that time (with one velocity field: at 1.22 s), the energy never rises and falls by
at most 8 %, momentum stays zero. Forces between pairs of particles keep 99 % of the energy, and store up to 0.1 % more of
it while the disks press.
Runs in about 6 s.
"""

import matpoint as mp
import numpy as np
from disks import case


def simulate(contact: str) -> mp.Simulation:
    """Runs the shipped case with a method of contact, and MUSL."""
    problem = case()
    problem.solver.stress_order = "musl"
    problem.solver.contact = contact
    problem.output.history_every = 0.001
    simulation = problem.build()
    simulation.run()
    return simulation


def run() -> dict[str, mp.Simulation]:
    """With a velocity field per body, and by pairs of particles."""
    return {contact: simulate(contact) for contact in ("multi_field", "pairs")}


def time_of_contact(simulation: mp.Simulation) -> float:
    """When the disks have lost a ten-thousandth of their kinetic energy [s]."""
    kinetic = simulation.history["kinetic_energy"]
    return float(simulation.history["time"][np.argmax(kinetic < kinetic[0] * (1 - 1e-4))])


def check(simulations: dict[str, mp.Simulation]) -> None:
    """Compares with the numbers above."""
    for contact, least, greatest in (("multi_field", 0.92, 1 + 1e-6), ("pairs", 0.99, 1.001)):
        history = simulations[contact].history
        stored = history["contact_energy"] if contact == "pairs" else 0
        energy = (history["kinetic_energy"] + history["strain_energy"] + stored) / history["kinetic_energy"][0]
        assert abs(time_of_contact(simulations[contact]) - 1.5858) < 0.035 * 1.5858
        assert energy.max() < greatest
        assert energy[-1] > least
        assert abs(history["momentum_x"]).max() < 1e-12


if __name__ == "__main__":
    done = run()
    check(done)
    for name, found in {"single_field": simulate("single_field"), **done}.items():
        print(f"{name:12s} begins to slow at {time_of_contact(found):.3f} s, exact: 1.586 s")
    mp.plot.particles(done["pairs"]).savefig("contact.png")
