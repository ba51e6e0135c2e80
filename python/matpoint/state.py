"""What a simulation consists of at a time: its bodies with their fields, and the grid."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from matpoint import _core
from matpoint._core import Simulation as CoreSimulation
from matpoint.case_data import node_positions
from matpoint.errors import ResultsError, did_you_mean, shown
from matpoint.fields import Floats, scalar_of
from matpoint.scene import Particles

if TYPE_CHECKING:
    import pyvista

__all__ = ["BodyState", "BoundaryState", "FieldArray", "GridState"]


class BoundaryState(NamedTuple):
    """What one boundary, tool or load does to the bodies.

    Attributes:
        force: On the bodies, in the last step, shape (dim,) [N].
        impulse: Force times time since the start, shape (dim,) [N s]; 0 in statics.
        work: Done on the bodies since the start [J].
    """

    force: Floats
    impulse: Floats
    work: float


class FieldArray(NDArray[np.float64] if TYPE_CHECKING else np.ndarray):  # type: ignore[misc]
    """A field of a body as it was when it was read: a NumPy array that owns its numbers and stays valid.

    Assigning to a part of it assigns to the simulation: `body.velocity[mask] = 0` reads the field, changes the part, and assigns the whole
    with `BodyState.assign`. Everything computed from it is a plain array, and so is a part that is read: a copy.
    """

    _assign: Callable[[Any, Any], Floats] | None

    def __array_finalize__(self, obj: Any) -> None:
        self._assign = None

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        plain = np.asarray(array)
        return plain[()] if plain.ndim == 0 else plain

    # `body.velocity *= 2` is a new array that is then assigned; the snapshot itself stays.
    def __iadd__(self, other: Any) -> Any:
        return np.asarray(self) + other

    def __isub__(self, other: Any) -> Any:
        return np.asarray(self) - other

    def __imul__(self, other: Any) -> Any:
        return np.asarray(self) * other

    def __itruediv__(self, other: Any) -> Any:
        return np.asarray(self) / other

    def __getitem__(self, key: Any) -> Any:
        return np.array(np.asarray(self)[key])[()]

    def __setitem__(self, key: Any, value: Any) -> None:
        if self._assign is None and self.flags.writeable:  # a copy, or an array made after one
            self.view(np.ndarray)[key] = value
            return
        if self._assign is None:
            raise _core.InputError(
                "this array is a view of a field that was read; assign to the field of the body itself: body.velocity[...] = ..."
            )
        fresh = self._assign(key, value)
        plain = self.view(np.ndarray)
        plain.flags.writeable = True
        if plain.shape == fresh.shape:
            plain[...] = fresh
        plain.flags.writeable = False


class _HasCore(Protocol):
    """A simulation as its bodies see it; they keep it alive."""

    _core: CoreSimulation


class BodyState:
    """A body of a simulation: its particles now, in the order of their ids. `Simulation.bodies` has them.

    Reading a field gives a snapshot (n particles). Assigning position, velocity or deformation_gradient, or a part of one, changes the
    simulation; other fields follow from these and are refused with the reason.
    """

    def __init__(self, simulation: _HasCore, index: int, name: str) -> None:
        self._simulation = simulation
        self._index = index
        self._name = name

    @property
    def name(self) -> str:
        """The body's name."""
        return self._name

    def __len__(self) -> int:
        return int(self._simulation._core.particle_count(self._index))

    def __repr__(self) -> str:
        return f"<body {self._name}: {len(self)} particles, fields {', '.join(self.fields)}>"

    @property
    def fields(self) -> list[str]:
        """Names of all fields."""
        return list(self._simulation._core.field_names(self._index))

    def field(self, name: str) -> FieldArray:
        """A field by its name (`fields`), shape (n,), (n, dim) or (n, 3, 3). Raises InputError for an unknown name."""
        array = cast(FieldArray, self._simulation._core.field(self._index, name).view(FieldArray))
        array.flags.writeable = False
        simulation = weakref.ref(self._simulation)
        index = self._index

        def assign(key: Any, value: Any) -> Floats:
            alive = simulation()
            if alive is None:
                raise _core.InputError(f"{name}: its simulation does not exist any more, so nothing can be assigned to it")
            fresh = np.array(alive._core.field(index, name))
            try:
                fresh[key] = value
            except (ValueError, TypeError) as error:
                raise _core.InputError(f"{name}[{shown(key)}] = {shown(value)} is not allowed: {error}") from None
            alive._core.set_field(index, name, np.ascontiguousarray(fresh))
            return fresh

        array._assign = assign
        return array

    def __getitem__(self, name: str) -> FieldArray:
        if not isinstance(name, str):
            raise _core.InputError(f'body "{self._name}": {shown(name)} is no name of a field; it has {", ".join(self.fields)}')
        return self.field(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.fields)

    def __contains__(self, name: object) -> bool:
        return name in self.fields

    def assign(self, name: str, values: ArrayLike) -> None:
        """Assigns a field of all particles.

        Args:
            name: "position" [m], "velocity" [m/s], "deformation_gradient" [1] or "stress" [Pa], to which the material is brought.
            values: The shape of the field, or one that broadcasts to it.

        Raises:
            InputError: The field cannot be assigned, the shape is wrong, or a value is impossible (outside of the grid, not finite,
                det F <= 0); the text says which, and nothing has changed.

        Energy and momentum that come or go with it are booked as the start's, so that the balances of the history stay closed.
        """
        shape = self._simulation._core.field(self._index, name).shape
        try:
            given = np.asarray(values, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            raise _core.InputError(f'body "{self._name}": {name} = {shown(values)} is not allowed: it must be numbers') from None
        try:
            full = np.ascontiguousarray(np.broadcast_to(given, shape))
        except ValueError:
            raise _core.InputError(
                f'body "{self._name}": {name} has the shape {shape}; an array of shape {given.shape} does not fit'
            ) from None
        if name == "stress":
            if not np.array_equal(full, full.transpose(0, 2, 1)):
                raise _core.InputError(f'body "{self._name}": stress is not symmetric')
            full = np.ascontiguousarray(full.reshape(-1, 9)[:, [0, 4, 8, 1, 5, 2]])
        self._simulation._core.set_field(self._index, name, full)

    def __setitem__(self, name: str, values: ArrayLike) -> None:
        self.assign(name, values)

    def __setattr__(self, name: str, value: Any) -> None:
        described = getattr(type(self), name, None)
        if name.startswith("_") or (isinstance(described, property) and described.fset is not None):
            object.__setattr__(self, name, value)
        else:
            self.assign(name, value)  # which says why this one cannot be assigned

    @property
    def position(self) -> FieldArray:
        """Positions [m], shape (n, dim). May be assigned."""
        return self.field("position")

    @position.setter
    def position(self, values: ArrayLike) -> None:
        self.assign("position", values)

    @property
    def velocity(self) -> FieldArray:
        """Velocities [m/s], shape (n, dim). May be assigned."""
        return self.field("velocity")

    @velocity.setter
    def velocity(self, values: ArrayLike) -> None:
        self.assign("velocity", values)

    @property
    def displacement(self) -> FieldArray:
        """Displacements since the start of the run [m], shape (n, dim). Raises InputError unless `output.fields` names "displacement"."""
        return self.field("displacement")

    @property
    def deformation_gradient(self) -> FieldArray:
        """Deformation gradients F [1], shape (n, 3, 3); plane strain in 2D. May be assigned."""
        return self.field("deformation_gradient")

    @deformation_gradient.setter
    def deformation_gradient(self, values: ArrayLike) -> None:
        self.assign("deformation_gradient", values)

    @property
    def stress(self) -> FieldArray:
        """Cauchy stresses [Pa], shape (n, 3, 3). May be assigned: a law that flows remembers the strain, others get the F that holds it."""
        return self.field("stress")

    @stress.setter
    def stress(self, values: ArrayLike) -> None:
        self.assign("stress", values)

    @property
    def von_mises(self) -> FieldArray:
        """Von Mises stresses [Pa], shape (n,)."""
        return self.field("von_mises")

    @property
    def pressure(self) -> FieldArray:
        """Pressures, minus the mean stress [Pa], shape (n,)."""
        return self.field("pressure")

    @property
    def J(self) -> FieldArray:
        """Volume ratios det F [1], shape (n,)."""
        return self.field("J")

    @property
    def volume(self) -> FieldArray:
        """Present volumes [m^3] (areas [m^2] in 2D), shape (n,)."""
        return self.field("volume")

    @property
    def mass(self) -> FieldArray:
        """Masses [kg] (per metre of thickness in 2D), shape (n,)."""
        return self.field("mass")

    @property
    def id(self) -> NDArray[np.int64]:
        """Ids, ascending, shape (n,); with removed particles there are gaps."""
        return np.asarray(self.field("id")).astype(np.int64)

    @property
    def cells(self) -> NDArray[np.int64] | None:
        """Cells of a body of finite elements, shape (cells, nodes per cell): rows of `node_field`, in VTK's order. None for particles."""
        _, per_cell, nodes = self._simulation._core.cells(self._index)
        return np.array(nodes, dtype=np.int64).reshape(-1, per_cell) if per_cell else None

    @property
    def node_fields(self) -> list[str]:
        """Names of the fields that a body of finite elements has at its nodes; none for particles."""
        return list(self._simulation._core.node_field_names(self._index))

    def node_field(self, name: str) -> Floats:
        """A field at the nodes of a body of finite elements, shape (nodes,), (nodes, dim) or (nodes, 3, 3).

        Position, displacement and velocity are the nodes' own; the others are extended from the Gauss points of each cell (`field` has
        them there) and averaged where cells meet.

        Raises:
            InputError: The body consists of particles, or has no such field.
        """
        return np.asarray(self._simulation._core.node_field(self._index, name))

    def to_pyvista(self) -> pyvista.DataSet:
        """The particles, or the cells of finite elements, with all fields as a PyVista object, for `.plot()`.

        Raises ImportError without the package pyvista.
        """
        from matpoint import plot

        return plot.to_pyvista(self)

    def _drawn(self, time: float, is_fluid: bool) -> _LiveBody:
        return _LiveBody(self, time, is_fluid)

    def _particles(self) -> Particles:
        return self._drawn(0.0, False)


class _LiveBody:
    """A body of a simulation as pictures see it."""

    def __init__(self, state: BodyState, time: float, is_fluid: bool) -> None:
        self.name = state.name
        self.times = np.array([time])
        self.cells = state.cells
        self.names = [name for name in (state.fields if self.cells is None else state.node_fields) if name != "position"]
        self.is_fluid = is_fluid
        self._state = state

    def _read(self, name: str) -> Floats:
        return np.asarray(self._state.field(name) if self.cells is None else self._state.node_field(name))

    def positions(self, index: int) -> Floats:
        """Positions [m], shape (n, 3)."""
        x = self._read("position")
        return np.pad(x, ((0, 0), (0, 3 - x.shape[1])))

    def field(self, name: str, index: int) -> Floats:
        """A field, shape (n,) or (n, components), as files have it. Raises ResultsError."""
        if name not in self.names:
            raise ResultsError(f'body "{self.name}" has no field "{name}", it has: {", ".join(self.names)}{did_you_mean(name, self.names)}')
        values = self._read(name)
        if values.ndim == 3:
            return values.reshape(len(values), 9)[:, [0, 4, 8, 1, 5, 2]] if name == "stress" else values.reshape(len(values), 9)
        return np.pad(values, ((0, 0), (0, 1))) if values.ndim == 2 and values.shape[1] == 2 else values

    def scalar(self, name: str, index: int) -> Floats:
        """One number per particle. Raises ResultsError."""
        return scalar_of(self, name, index)


class GridState:
    """The background grid of a simulation: its nodes and what they carried in the last step. Arrays are numbered x fastest."""

    def __init__(self, simulation: _HasCore, axes: list[Floats]) -> None:
        self._simulation = simulation
        self._axes = axes

    @property
    def shape(self) -> tuple[int, ...]:
        """Nodes per direction, slowest first: (ny, nx) or (nz, ny, nx), so `grid.mass.reshape(grid.shape)` is a picture."""
        return tuple(len(axis) for axis in reversed(self._axes))

    @property
    def node_count(self) -> int:
        """Number of all nodes."""
        return int(self._simulation._core.node_count())

    @property
    def position(self) -> Floats:
        """Positions of the nodes [m], shape (nodes, dim)."""
        return node_positions(self._axes)

    @property
    def mass(self) -> Floats:
        """Nodal masses of the last step [kg], shape (nodes,); 0 where no particle is near."""
        return np.asarray(self._simulation._core.grid_fields()["mass"])

    @property
    def velocity(self) -> Floats:
        """Nodal velocities of the last step [m/s], shape (nodes, dim)."""
        return np.asarray(self._simulation._core.grid_fields()["velocity"])

    def __repr__(self) -> str:
        return f"<grid: {' x '.join(str(n) for n in reversed(self.shape))} nodes>"
