"""What a run says about itself at its end."""

from __future__ import annotations

import warnings
from typing import NamedTuple


class HealthLine(NamedTuple):
    """One thing that a run says about itself.

    Attributes:
        name: "energy", "momentum", "body water", "particles".
        text: What was measured, in words.
        is_good: The verdict.
        remedy: What would do, where it is not good; else empty.
    """

    name: str
    text: str
    is_good: bool
    remedy: str


class HealthWarning(UserWarning):
    """A run whose books are out of bounds; the text says by how much, and what would do."""


def warn_of(lines: list[HealthLine], stacklevel: int) -> None:
    """Warns once of everything that is not good."""
    bad = [f"{line.name}: {line.text}; {line.remedy}" for line in lines if not line.is_good]
    if bad:
        warnings.warn("\n".join(bad), HealthWarning, stacklevel=stacklevel + 1)
