"""A bar of metal is pulled until it necks: half of a slab in statics, as a body of finite elements.

Source: Simo & Hughes (1998), Computational Inelasticity: the material and the bar.
Expected: the load on the half is greatest, 4.574 MN/m, at 2.6 mm to each side; at 4 mm the neck is 0.685 as wide as the bar.
Runs in about 6 s. The same as a case file: `matpoint run necking`.
"""

import matpoint as mp
import numpy as np


def case() -> mp.Case:
    """The case, word for word as cases/necking.toml."""
    return mp.Case(
        "necking",
        title="A bar that necks",
        source="Simo & Hughes (1998), Computational Inelasticity: the material and the bar",
        grid=mp.Grid(upper=(6.413e-3, 26.667e-3), cells=(8, 24), corners=[(0, 0), (6.297566e-3, 0), (6.413e-3, 26.667e-3), (0, 26.667e-3)]),
        time=mp.Time(end=1, dt=0.01),
        solver=mp.Solver(type="implicit", mode="static", basis="element", element_order=1, halving="residual"),
        body=[
            mp.Body(
                name="bar",
                method="elements",
                fbar=True,
                region=mp.Box(lower=(-1, -1), upper=(1, 1)),
                material=mp.J2(
                    density=7850,
                    youngs_modulus=206.9e9,
                    poissons_ratio=0.29,
                    yield_stress=0.45e9,
                    saturation_stress=0.715e9,
                    saturation_rate=16.93,
                    hardening_modulus=0.12924e9,
                ),
            ),
        ],
        boundary=[
            mp.Boundary(name="end", side="top", kind="velocity", velocity=(0, 5e-3)),
            mp.Boundary(side="left", kind="slip"),
            mp.Boundary(side="bottom", kind="slip"),
        ],
        output=mp.Output(history_every=0.01),
    )


def run() -> mp.Simulation:
    """Runs it."""
    simulation = case().build()
    simulation.run(progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    history = simulation.history
    load, pulled = history["end.force_y"], 5e-3 * history["time"]
    assert abs(load.max() - 4.574e6) < 0.01e6
    assert abs(pulled[load.argmax()] - 2.6e-3) < 0.15e-3
    bar = simulation.bodies["bar"]
    assert 0.8 < np.asarray(bar.node_field("plastic_strain")).max() < 0.9
    x = np.asarray(bar.node_field("position"))
    neck = x[x[:, 1] < 1e-9, 0].max()
    assert abs(neck / 6.413e-3 - 0.515) < 0.01


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "plastic_strain").savefig("necking.png")
