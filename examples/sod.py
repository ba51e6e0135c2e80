"""A shock tube: two gases at different pressures, parted by nothing from t = 0 on.

Source: Sod (1978); the exact answer is Riemann's solution.
Expected: at t = 0.2 s the shock at 0.850 m, pressure 0.303 Pa and velocity 0.927 m/s behind it, density 0.266 kg/m^3.
Runs in about 2 s. The same as a case file: `matpoint run sod`.
"""

import matpoint as mp
import numpy as np


def case() -> mp.Case:
    """The case, word for word as cases/sod.toml."""
    layout = mp.PerCell(count=4)
    return mp.Case(
        "sod",
        title="Sod's shock tube",
        source="Sod (1978)",
        grid=mp.Grid(upper=(1, 0.01), cells=(200, 2)),
        time=mp.Time(end=0.2),
        output=mp.Output(fields=["velocity", "pressure", "density", "internal_energy"], fields_every=0.02),
        body=[
            mp.Body(
                name="left",
                region=mp.Box(lower=(0, 0), upper=(0.5, 0.01)),
                layout=layout,
                material=mp.IdealGas(density=1, pressure=1),
            ),
            mp.Body(
                name="right",
                region=mp.Box(lower=(0.5, 0), upper=(1, 0.01)),
                layout=layout,
                material=mp.IdealGas(density=0.125, pressure=0.1),
            ),
        ],
        boundary=[mp.Boundary(side=side, kind="slip") for side in ("left", "right", "bottom", "top")],
    )


def run() -> mp.Simulation:
    """Runs it."""
    simulation = case().build()
    simulation.run(progress=True)
    return simulation


def profile(simulation: mp.Simulation, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Places and values of a field of both gases, from left to right."""
    bodies = [simulation.bodies[body] for body in ("left", "right")]
    x = np.concatenate([body.position[:, 0] for body in bodies])
    values = np.concatenate([np.asarray(body.field(name)) for body in bodies])
    order = np.argsort(x)
    return x[order], values[order]


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    x, pressure = profile(simulation, "pressure")
    behind = (x > 0.71) & (x < 0.82)
    assert abs(pressure[behind].mean() / 0.30313 - 1) < 0.015
    assert abs(profile(simulation, "density")[1][behind].mean() / 0.26557 - 1) < 0.015
    assert abs(x[pressure > 0.2].max() - 0.8504) < 0.005


if __name__ == "__main__":
    import matplotlib.pyplot as plt

    done = run()
    check(done)
    figure, axes = plt.subplots(2, 1, sharex=True, figsize=(7, 5), layout="constrained")
    for axis, name, unit, states in zip(axes, ("density", "pressure"), ("kg/m$^3$", "Pa"), ((0.4263, 0.2656), (0.3031, 0.3031))):
        axis.plot(*profile(done, name), ".", markersize=2, label="particles")
        axis.hlines(states, (0.486, 0.6855), (0.6855, 0.8504), color="black", linewidth=0.8, label="Riemann's solution")
        axis.set_ylabel(f"{name} [{unit}]")
    axes[0].legend(frameon=False)
    axes[1].set_xlabel("x [m]")
    figure.savefig("sod.png", dpi=150)
