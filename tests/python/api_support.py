"""What the tests of the Python API share: a block of rubber in free fall."""

import matpoint as mp
import numpy as np

FALL = -9.81


def block(dim=2, **changes) -> mp.Case:
    """A block of rubber in free fall; changes replace sections."""
    sections = {
        "dim": dim,
        "gravity": [0, FALL, 0][:dim],
        "grid": mp.Grid(upper=[1.0] * dim, cells=[8] * dim),
        "time": mp.Time(dt=1e-3, end=0.02),
        "body": mp.Body(
            name="block",
            region=mp.Box(lower=[0.25] * dim, upper=[0.75] * dim),
            layout=mp.PerCell(count=2**dim),
            material=mp.NeoHookean(density=1000, youngs_modulus=1e5, poissons_ratio=0.3),
        ),
    }
    return mp.Case("block", **{**sections, **changes})


def same_bits(a: mp.Simulation, b: mp.Simulation) -> bool:
    return list(a.history) == list(b.history) and all(np.array_equal(a.history[k], b.history[k], equal_nan=True) for k in a.history)
