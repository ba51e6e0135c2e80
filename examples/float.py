"""A triangular block is set on water, sinks in and rises.

Source: Kamuth, thesis on the explicit material point method, section 8.7.
Expected: first minimum of the block's bottom particle 0.1211 m at 0.644 s (thesis: 0.121 m at 0.67 s).
Runs in about 5 s. The same as a case file: `matpoint run float`.
"""

import matpoint as mp
import numpy as np

HEIGHTS: list[tuple[float, float]] = []  # time [s], height of the keel [m]


def case() -> mp.Case:
    """The case, word for word as cases/float.toml."""
    return mp.Case(
        "float",
        title="A block floats on water",
        source="Kamuth, thesis on the explicit material point method, section 8.7",
        gravity=(0, -9.81),
        grid=mp.Grid(upper=(0.4, 0.4), cells=(15, 15)),
        time=mp.Time(dt=1e-06, end=2),
        solver=mp.Solver(shape="linear", stress_order="usl", mass_cutoff=1e-10),
        body=[
            mp.Body(
                name="water",
                region=mp.Box(lower=(0, 0), upper=(0.4, 0.2)),
                layout=mp.Lattice(divisions=(40, 40), points=2),
                material=mp.NewtonianFluid(density=997, pressure_scale=2000.0, gamma=7, viscosity=0.98),
            ),
            mp.Body(
                name="block",
                region=mp.Polygon(vertices=[(0.1, 0.2), (0.3, 0.2), (0.2, 0.4)]),
                layout=mp.Lattice(divisions=(10, 10), points=2),
                material=mp.StVenantKirchhoff(density=917, youngs_modulus=200000.0, poissons_ratio=0.3),
            ),
        ],
        boundary=[
            mp.Boundary(side="left", kind="slip"),
            mp.Boundary(side="right", kind="slip"),
            mp.Boundary(side="bottom", kind="slip"),
        ],
        probe=[
            mp.Probe(name="keel", body="block", nearest=(0.195, 0.2)),
        ],
    )


def run() -> mp.Simulation:
    """Runs it to the first minimum, with MUSL and a longer step than the thesis'. The height of the keel is recorded by a callback."""
    problem = case()
    problem.solver.stress_order = "musl"
    problem.time.dt = 5e-5
    simulation = problem.build()
    start = simulation.bodies["block"].position
    keel = int(np.argmin(np.hypot(start[:, 0] - 0.195, start[:, 1] - 0.2)))

    @simulation.every(time=0.005)
    def record(now: mp.Simulation) -> None:
        HEIGHTS.append((now.time, float(now.bodies["block"].position[keel, 1])))

    HEIGHTS.clear()
    simulation.run(until=0.8, progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    assert simulation.time > 0.79
    times, heights = np.array(HEIGHTS).T
    lowest = int(np.argmin(heights))
    assert abs(heights[lowest] - 0.1211) < 1e-3
    assert abs(times[lowest] - 0.644) < 0.02


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "velocity").savefig("float.png")
