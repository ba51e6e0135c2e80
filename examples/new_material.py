"""A material law written in Python: Hencky's, linear between the Kirchhoff stress and the logarithmic strain.

Source: Hencky (1928); tau = 2 mu dev(ln V) + K ln(J) I with V^2 = F F^T.
Expected: for small strains it is Hooke's law, so the bar of bar.py vibrates with the same period, 10.0068 s for 25 cells.
Runs in about 2 s: a law in Python is a hundred times slower than one in C++ (docs/add_a_material.md), fast enough to try one.
"""

import matpoint as mp
import numpy as np
from bar import case as bar

YOUNGS_MODULUS = 100.0  # [Pa]
SHEAR_MODULUS = YOUNGS_MODULUS / 2  # Poisson's ratio is 0
BULK_MODULUS = YOUNGS_MODULUS / 3


def hencky(F: np.ndarray) -> np.ndarray:
    """Kirchhoff stresses [Pa] of deformation gradients, both of shape (n, 3, 3)."""
    squares, directions = np.linalg.eigh(F @ F.transpose(0, 2, 1))
    strains = 0.5 * np.log(squares)
    volume_strain = strains.sum(axis=1, keepdims=True)
    stresses = 2 * SHEAR_MODULUS * (strains - volume_strain / 3) + BULK_MODULUS * volume_strain
    return np.einsum("nik,nk,njk->nij", directions, stresses, directions)


def case() -> mp.Case:
    """The bar with the new law."""
    problem = bar()
    problem.body[0].material = mp.FunctionLaw(hencky, density=1.0, wave_speed=10.0)
    problem.output.history_every = 0.05
    return problem


def run() -> mp.Simulation:
    """Runs one period and a half."""
    simulation = case().build()
    simulation.run(until=15.0, progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """The period from the zeros of the momentum at 1/4, 3/4 and 5/4 of it."""
    time, momentum = simulation.history["time"], simulation.history["momentum_x"]
    before = np.flatnonzero(momentum[:-1] * momentum[1:] < 0)
    zeros = time[before] - momentum[before] * (time[before + 1] - time[before]) / (momentum[before + 1] - momentum[before])
    assert abs((zeros[2] - zeros[0]) - 10.0068) < 5e-3


if __name__ == "__main__":
    check(run())
