"""What pictures of particles need to know of whatever is drawn: its bodies, times, fields and units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from matpoint.errors import ResultsError, shown
from matpoint.fields import Floats

PANELS = 6


class Particles(Protocol):
    """The particles of one body at some times, from a file or from a simulation."""

    name: str
    times: Floats
    names: list[str]
    is_fluid: bool
    cells: NDArray[np.int64] | None

    def positions(self, index: int) -> Floats:
        """Positions [m], shape (n, 3); of the nodes where there are cells."""

    def field(self, name: str, index: int) -> Floats:
        """A field, shape (n,) or (n, components)."""

    def scalar(self, name: str, index: int) -> Floats:
        """One number per particle."""


class Scene(Protocol):
    """What pictures of particles need to know of a results folder or a simulation."""

    dim: int
    title: str

    @property
    def case(self) -> Mapping[str, Any]:
        """The resolved case."""

    @property
    def bodies(self) -> Mapping[str, Particles]:
        """The bodies by name."""

    def unit(self, field_name: str) -> str:
        """Unit of a field."""


class HasScene(Protocol):
    """What can be drawn: a results folder, or a simulation as it is now."""

    def _scene(self) -> Scene:
        """Itself as pictures see it."""


class HasParticles(Protocol):
    """A body that can be drawn, of a file or of a simulation."""

    def _particles(self) -> Particles:
        """Itself as pictures see it."""


def common_count(bodies: Sequence[Particles]) -> int:
    """How many times are written for all bodies. Raises ResultsError when there is none."""
    if not bodies:
        raise ResultsError('there are no fields of particles: the output.formats of the case must contain "vtkhdf"')
    # A run that was killed between two bodies has written one time more for the first.
    count = min(len(body.times) for body in bodies)
    if count == 0:
        raise ResultsError(f'body "{bodies[0].name}" has no fields yet: no time is written')
    return count


def choose_times(bodies: Sequence[Particles], wanted: Sequence[float] | None) -> list[int]:
    """Indices of the written times that are nearest to the wanted ones; without these, a few evenly spaced.

    Raises:
        ResultsError: Nothing was written, or a wanted time is outside of what was.
    """
    count = common_count(bodies)
    times = bodies[0].times[:count]
    if wanted is None:
        even = np.linspace(times[0], times[-1], PANELS)
        return sorted({int(np.argmin(np.abs(times - t))) for t in even})
    try:
        asked = [float(t) for t in wanted]
    except (TypeError, ValueError, OverflowError):
        asked = []
    if not asked:
        raise ResultsError(f"times = {shown(wanted)} is not allowed, it must be a list of times [s]")
    # Half an interval, because an output falls on the nearest step.
    slack = 0.5 * (times[-1] - times[0]) / max(1, count - 1) + 1e-12
    for t in asked:
        if not times[0] - slack <= t <= times[-1] + slack:
            raise ResultsError(f"time {t:g} s was not written: the fields cover {times[0]:g} to {times[-1]:g} s")
    return sorted({int(np.argmin(np.abs(times - t))) for t in asked})


def default_fields(bodies: Sequence[Particles]) -> list[str]:
    """Von Mises stress if there is a solid, pressure if there is a fluid; what the files have if they have neither."""
    wanted = (["von_mises"] if any(not b.is_fluid for b in bodies) else []) + (["pressure"] if any(b.is_fluid for b in bodies) else [])
    present = [name for name in wanted if all(name in body.names for body in bodies)]
    if present:
        return present
    return [name for name in ("velocity", "J", "body", "id") if all(name in body.names for body in bodies)][:1]


def particle_size(scene: Scene, body: Particles) -> float:
    """Edge [m] of the square or cube that a particle stands for; of a ring around an axis, of its section."""
    dim = scene.dim
    positions = body.positions(0)[:, :dim]
    if "volume" in body.names:
        volume = np.asarray(body.field("volume", 0))
        if scene.case["grid"].get("axisymmetric"):
            volume = volume / (2 * np.pi * np.maximum(positions[:, 0], 1e-300))
        return float(np.median(volume) ** (1 / dim))
    extent = np.maximum(np.ptp(positions, axis=0), 1e-12)
    return float((np.prod(extent) / len(positions)) ** (1 / dim))


def grid_box(scene: Scene) -> tuple[Floats, Floats]:
    """Corners [m] of the grid, each of shape (dim,)."""
    grid = scene.case["grid"]
    lower = np.array(grid.get("lower", [0.0] * scene.dim), dtype=float)
    return lower, np.array(grid["upper"], dtype=float)


def panel_grid(count: int, aspect: float) -> tuple[int, int]:
    """Rows and columns for panels of the given height / width: about 1.6 times as wide as high as a whole, with few empty places."""

    def badness(columns: int) -> float:
        rows = -(-count // columns)
        return float(abs(np.log(1.6 * aspect * rows / columns)) + (rows * columns - count) / count)

    columns = min(range(1, count + 1), key=badness)
    return -(-count // columns), columns


def points_of(body: Particles, index: int, field: str, dim: int) -> tuple[Floats, Floats]:
    """Places in the picture's plane [m], shape (n, 2), and values, shape (n,), in the order in which they are to be drawn."""
    positions = body.positions(index)
    values = body.scalar(field, index)
    if dim == 3:
        # Far ones first: the view is the standard isometric one of project().
        order = np.argsort(positions @ np.array([1.0, 1.0, 1.0]))
        positions, values = positions[order], values[order]
    return project(positions, dim), values


def project(positions: Floats, dim: int) -> Floats:
    """Positions in the picture's plane [m], shape (n, 2): x and y in 2D, an isometric view with y upward in 3D.

    The viewer is at (1, 1, 1): x comes to the front on the right, z on the left.
    """
    if dim == 2:
        return positions[:, :2]
    x, y, z = positions[:, 0], positions[:, 1], positions[:, 2]
    return np.stack([(x - z) / np.sqrt(2), np.sqrt(2 / 3) * y - (x + z) / np.sqrt(6)], axis=1)
