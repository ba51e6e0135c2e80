"""A free square turns and travels: what each transfer between grid and particles takes from its turning, and per step.

Source: Jiang et al. (2015) for APIC, Nairn & Hammerquist (2021) for FMPM.
Expected: of the kinetic energy of the turning APIC and TPIC keep 0.9998 in a second of steps of 2 ms and of 0.5 ms; PIC keeps nothing,
FLIP about 0.9, and FMPM with 4 terms about half in steps of 2 ms and 0.08 in steps of 0.5 ms, for it loses a little in each step. (FMPM
has a mass cutoff here: with USL its terms throw nodes of next to no mass.)
Runs in about 2 s.
"""

import matpoint as mp

TRANSFERS = {"flip": {}, "pic": {}, "apic": {}, "tpic": {}, "fmpm": {"fmpm_order": 4, "mass_cutoff_relative": 1e-3}}


def kept(transfer: str, dt: float, **choices: float) -> float:
    """Kinetic energy of the turning after a second over that at the start."""
    simulation = mp.Case(
        "square",
        grid=mp.Grid(lower=(-1, -1), upper=(2, 1), cells=(24, 16)),
        time=mp.Time(dt=dt, end=1),
        solver=mp.Solver(stress_order="usl", shape="bspline2", transfer=transfer, **choices),
        body=mp.Body(
            name="square",
            region=mp.Box(lower=(-0.5, -0.5), upper=(0.5, 0.5)),
            layout=mp.PerCell(count=4),
            velocity=mp.RotatingVelocity(center=(0, 0), angular_velocity=1, value=(0.1, 0)),
            material=mp.NeoHookean(density=1550, youngs_modulus=1e6, poissons_ratio=0.3),
        ),
    ).build()
    travelling = 0.5 * simulation.bodies["square"].mass.sum() * 0.1**2
    simulation.run()
    kinetic = simulation.history["kinetic_energy"]
    return float((kinetic[-1] - travelling) / (kinetic[0] - travelling))


def run() -> dict[str, tuple[float, float]]:
    """What each transfer keeps in steps of 2 and of 0.5 ms."""
    return {name: (kept(name, 2e-3, **choices), kept(name, 5e-4, **choices)) for name, choices in TRANSFERS.items()}


def check(results: dict[str, tuple[float, float]]) -> None:
    """Compares with the numbers above."""
    assert min(*results["apic"], *results["tpic"]) > 0.999, results
    assert abs(results["pic"][0]) < 0.01, results
    assert 0.4 < results["fmpm"][0] < 0.7, results
    assert results["fmpm"][1] < 0.15, results
    assert min(results["flip"]) > 0.85, results


if __name__ == "__main__":
    found = run()
    for transfer, (long, short) in found.items():
        print(f"{transfer:5s} keeps {long:6.3f} in steps of 2 ms, {short:6.3f} in steps of 0.5 ms")
    check(found)
