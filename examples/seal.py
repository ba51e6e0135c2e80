"""A rubber seal in a groove is pressed by a lid: statics, with friction at all sides, which let go.

Source: Johnson (1985), Contact Mechanics, eq. 5.57, for small loads; beyond, the balance of forces and Coulomb's law.
Expected: the lid takes 9.5 kN per metre when it has come down by a fifth of the seal, and the wall that the seal leans on 3.0 kN.
Runs in about 10 s. The same as a case file: `matpoint run seal`.
"""

import matpoint as mp


def case() -> mp.Case:
    """The case, word for word as cases/seal.toml."""
    sides = [mp.Boundary(side=side, kind="fixed", contact="friction", friction=0.2) for side in ("bottom", "left", "right")]
    return mp.Case(
        "seal",
        title="A seal in its groove",
        source="Johnson (1985), Contact Mechanics, eq. 5.57, for small loads",
        grid=mp.Grid(upper=(0.012, 0.01), cells=(24, 20)),
        time=mp.Time(end=1, dt=0.05),
        solver=mp.Solver(type="implicit", mode="static"),
        body=[
            mp.Body(
                name="seal",
                region=mp.Disk(center=(0.005, 0.005), radius=0.005),
                layout=mp.PerCell(count=16),
                material=mp.NeoHookean(density=1100, youngs_modulus=5e6, poissons_ratio=0.49),
            ),
        ],
        boundary=[
            mp.Boundary(name="lid", side="top", kind="velocity", velocity=(0, -0.002), contact="friction", friction=0.2),
            *sides,
        ],
        output=mp.Output(history_every=0.05),
    )


def run() -> mp.Simulation:
    """Runs it."""
    simulation = case().build()
    simulation.run(progress=True)
    return simulation


def check(simulation: mp.Simulation) -> None:
    """Compares with the numbers above."""
    history = simulation.history
    assert abs(history["lid.force_y"][-1] + 9.54e3) < 0.1e3
    assert abs(history["left.force_x"][-1] - 3.02e3) < 0.1e3
    assert history["right.force_x"][-1] == 0
    # In statics the forces of all sides balance, and friction is at most 0.2 of what presses.
    for axis in "xy":
        assert abs(sum(history[f"{side}.force_{axis}"][-1] for side in ("lid", "bottom", "left", "right"))) < 1e-4 * 9.5e3
    assert abs(history["bottom.force_x"][-1]) <= 0.2 * history["bottom.force_y"][-1] * (1 + 1e-6)
    assert abs(history["left.force_y"][-1]) <= 0.2 * history["left.force_x"][-1] * (1 + 1e-6)


if __name__ == "__main__":
    done = run()
    check(done)
    mp.plot.particles(done, "pressure").savefig("seal.png")
