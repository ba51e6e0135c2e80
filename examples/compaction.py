"""A soft column is compacted by its weight to an eighth at its foot: which shape functions follow it.

Source: Bardenhagen & Kober (2004); sigma_yy = -rho g (H - Y) exactly, at any strain (nu = 0).
Expected: mean error over rho g H on 16 and 32 cells: total Lagrangian quadratic B-splines 5e-4, 1.3e-4; CPDI 3.4e-3, 9.4e-4.
Updated B-splines: 9.4e-4, 4.3e-4, and no better on finer grids.
Runs in about 6 s.
"""

import math

import matpoint as mp
import numpy as np

HEIGHT, DENSITY, GRAVITY, E = 50.0, 80.0, 10.0, 1e4
CHOICES = {
    "total Lagrangian": {"shape": "bspline2", "formulation": "total", "particles": 16},
    "CPDI": {"shape": "cpdi", "formulation": "updated", "particles": 4},
    "updated": {"shape": "bspline2", "formulation": "updated", "particles": 16},
}


def error(cells: int, shape: str, formulation: str, particles: int) -> float:
    """Mean error of sigma_yy over rho g H."""
    size = HEIGHT / cells
    period = 4 * HEIGHT / math.sqrt(E / DENSITY)
    simulation = mp.Case(
        "column",
        gravity=(0, -GRAVITY),
        gravity_times=(0, 4 * period),
        gravity_factors=(0, 1),
        grid=mp.Grid(upper=(size, HEIGHT), cells=(1, cells)),
        time=mp.Time(end=8 * period, cfl=0.3),
        solver=mp.Solver(stress_order="usl", shape=shape, damping=2 * math.pi / period),
        body=mp.Body(
            name="column",
            formulation=formulation,
            region=mp.Box(lower=(0, 0), upper=(size, HEIGHT)),
            layout=mp.PerCell(count=particles),
            material=mp.NeoHookean(density=DENSITY, youngs_modulus=E, poissons_ratio=0),
        ),
        boundary=[mp.Boundary(side="left"), mp.Boundary(side="right"), mp.Boundary(side="bottom")],
    ).build()
    column = simulation.bodies["column"]
    start = column.position[:, 1].copy()
    simulation.run()
    exact = -DENSITY * GRAVITY * (HEIGHT - start)
    return float(np.abs(column.stress[:, 1, 1] - exact).mean() / (DENSITY * GRAVITY * HEIGHT))


def run() -> dict[str, tuple[float, float]]:
    """Errors of each choice on 16 and 32 cells."""
    return {name: (error(16, **choice), error(32, **choice)) for name, choice in CHOICES.items()}


def check(results: dict[str, tuple[float, float]]) -> None:
    """Compares with the numbers above."""
    for name, coarse in (("total Lagrangian", 6e-4), ("CPDI", 4e-3)):
        assert results[name][0] < coarse, results
        assert results[name][0] / results[name][1] > 3.4, results


if __name__ == "__main__":
    found = run()
    for choice, (coarse, fine) in found.items():
        print(f"{choice:18s} {coarse:.2e} {fine:.2e}, order {math.log2(coarse / fine):.2f}")
    check(found)
