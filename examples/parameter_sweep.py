"""A parameter sweep on two processes: the period of a vibrating bar for some Young's moduli.

Source: closed form, period 4 L sqrt(rho / E).
Expected: 20, 10 and 5 s for E = 25, 100 and 400 Pa, within 0.1 %.
Runs in about 3 s.
"""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import matpoint as mp
import numpy as np
from bar import case

MODULI = [25.0, 100.0, 400.0]  # [Pa]


def period(youngs_modulus: float) -> float:
    """Period [s] of the bar, from the zeros of its momentum. Runs in a process of its own, on one thread."""
    mp.set_threads(1)
    expected = 100 / np.sqrt(youngs_modulus)
    problem = case()
    problem.body[0].material.youngs_modulus = youngs_modulus
    problem.time = mp.Time(dt=expected / 2000, end=1.5 * expected)
    problem.output.history_every = expected / 200
    simulation = problem.build()
    simulation.run()
    time, momentum = simulation.history["time"], simulation.history["momentum_x"]
    before = np.flatnonzero(momentum[:-1] * momentum[1:] < 0)
    zeros = time[before] - momentum[before] * (time[before + 1] - time[before]) / (momentum[before + 1] - momentum[before])
    return float(zeros[2] - zeros[0])


def run() -> dict[float, float]:
    """Period [s] for each modulus [Pa]. Spawned, not forked: a fork would share the threads of this process."""
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        return dict(zip(MODULI, pool.map(period, MODULI), strict=True))


def check(periods: dict[float, float]) -> None:
    """Compares with the closed form."""
    for modulus, measured in periods.items():
        expected = 100 / np.sqrt(modulus)
        assert abs(measured - expected) < 1e-3 * expected, (modulus, measured, expected)


if __name__ == "__main__":
    check(run())
