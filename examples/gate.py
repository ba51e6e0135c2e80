"""Water behind a gate on a hinge with a spring: a rigid tool that moves freely, and the moment that it feels.

Source: hydrostatics, rho g H^3 / 6 per width about the foot.
Expected: the moment of the water, whose level sinks as the gate gives way by 2 degrees, to 5 %.
Runs in about 1 s. The same as a case file: `matpoint run gate`.
"""

import matpoint as mp
import numpy as np

DEPTH, LENGTH, SPRING = 0.5, 0.8, 5000.0


def case() -> mp.Case:
    """The case, word for word as cases/gate.toml."""
    return mp.Case(
        "gate",
        title="Water behind a gate on a hinge",
        source="hydrostatics",
        gravity=(0, -9.81),
        grid=mp.Grid(upper=(1.2, 0.8), cells=(30, 20)),
        time=mp.Time(end=1.5),
        body=[
            mp.Body(
                name="water",
                region=mp.Box(lower=(0, 0), upper=(LENGTH, DEPTH)),
                layout=mp.PerCell(count=4),
                material=mp.NewtonianFluid(density=1000, viscosity=1e-3, pressure_scale=1e5),
            ),
        ],
        boundary=[mp.Boundary(side="left", kind="slip"), mp.Boundary(side="bottom", kind="slip")],
        tool=[
            mp.Tool(
                name="gate",
                shape=mp.Box(lower=(LENGTH, 0), upper=(0.9, 0.7)),
                density=100,
                hinge=(LENGTH, 0),
                spring=SPRING,
                spring_damping=200,
            ),
        ],
    )


def run() -> mp.Simulation:
    """Runs it."""
    simulation = case().build()
    simulation.run(progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with hydrostatics."""
    history = simulation.history
    late = history["time"] > 0.5
    turn = history["gate.turn"][late].mean()
    moment = -history["gate.torque"][late].mean()
    level = DEPTH + 0.5 * DEPTH**2 * np.tan(turn) / LENGTH  # what the wedge beside the gate takes; turn < 0
    assert abs(moment / (1000 * 9.81 * level**3 / 6) - 1) < 0.05
    weight = 100 * 0.1 * 0.7 * 9.81 * (0.05 - turn * 0.35)  # of the gate, about its hinge
    assert abs(-SPRING * turn / (moment + weight) - 1) < 0.05
    assert simulation.bodies["water"].position[:, 0].max() < 0.9


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "pressure").savefig("gate.png")
