"""Fields as plain arrays: what they are made of, and one number per particle."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from matpoint.errors import ResultsError, shown

Floats = NDArray[np.float64]

COMPONENTS = {
    3: ("x", "y", "z"),
    6: ("xx", "yy", "zz", "xy", "yz", "xz"),
    9: ("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"),
}


class _HasFields(Protocol):
    names: list[str]

    def field(self, name: str, index: int) -> Floats: ...


def scalar_of(body: _HasFields, name: str, index: int) -> Floats:
    """One number per particle, shape (n,): a scalar field, a vector's magnitude, or a component: `stress_xy`. Raises ResultsError."""
    if not isinstance(name, str):
        raise ResultsError(f"{shown(name)} is no name of a field")
    base, _, component = name.rpartition("_")
    if name in body.names or base not in body.names:
        values = body.field(name, index)
        if values.ndim == 1:
            return values
        if values.shape[1] == 3:
            magnitude: Floats = np.linalg.norm(values, axis=1)
            return magnitude
        components = ", ".join(f"{name}_{suffix}" for suffix in COMPONENTS[values.shape[1]])
        raise ResultsError(f'field "{name}" is a tensor; give one of its components: {components}')
    values = body.field(base, index)
    known = COMPONENTS.get(values.shape[1], ()) if values.ndim == 2 else ()
    if component not in known:
        raise ResultsError(f'field "{base}" has no component "{component}", it has: {", ".join(known) or "none"}')
    return values[:, known.index(component)]
