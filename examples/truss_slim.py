"""A slim block under a large weight: two hyperelastic laws differ by half its length.

Source: Kamuth, thesis on the explicit material point method, section 8.2.1.
Expected: heights of the lowest particle at 0.04, 0.08, 0.12 s, read from a figure: 0.17, 0.04, 0.14 m and 0.30, 0.31, 0.34 m.
Runs in about 3 s. The same as a case file: `matpoint run truss_slim`.
"""

import matpoint as mp


def case() -> mp.Case:
    """The case, word for word as cases/truss_slim.toml."""
    return mp.Case(
        "truss_slim",
        title="A slim truss under its own weight",
        source="Kamuth, thesis on the explicit material point method, section 8.2.1",
        gravity=(0, -500),
        grid=mp.Grid(upper=(0.06, 0.6), cells=(7, 7)),
        time=mp.Time(dt=1e-05, end=2),
        solver=mp.Solver(shape="linear", stress_order="usl", damping=25, mass_cutoff=1e-10),
        body=[
            mp.Body(
                name="truss",
                region=mp.Box(lower=(0.02, 0.4), upper=(0.04, 0.6)),
                layout=mp.Lattice(divisions=(20, 150)),
                material=mp.NeoHookean(density=1500, youngs_modulus=100000.0, poissons_ratio=0.3),
            ),
        ],
        boundary=[
            mp.Boundary(side="top", kind="fixed", components=["y"]),
        ],
    )


PUBLISHED = {"neo_hookean": [0.1702, 0.0420, 0.1377], "st_venant_kirchhoff": [0.3002, 0.3108, 0.3361]}  # with the digits of our reference


def run() -> dict[str, list[float]]:
    """Height of the lowest particle [m] at t = 0.04, 0.08 and 0.12 s, for two laws that share their parameters."""
    heights = {}
    for law in (mp.NeoHookean, mp.StVenantKirchhoff):
        problem = case()
        problem.body[0].material = law(density=1500, youngs_modulus=1e5, poissons_ratio=0.3)
        simulation = problem.build()
        heights[problem.body[0].material.type] = []
        for time in (0.04, 0.08, 0.12):
            simulation.run(until=time)
            heights[problem.body[0].material.type].append(float(simulation.bodies["truss"].position[:, 1].min()))
    return heights


def check(heights: dict[str, list[float]]) -> None:
    """Compares with the numbers above."""
    for law, expected in PUBLISHED.items():
        for ours, theirs in zip(heights[law], expected, strict=True):
            assert abs(ours - theirs) < 1e-3, (law, ours, theirs)


if __name__ == "__main__":
    check(run())
