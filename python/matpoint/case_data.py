"""What a case says as data for the core: parts as plain dicts, Python functions as objects of the core."""

from __future__ import annotations

import copy
import os
import pickle
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from matpoint import _core
from matpoint.errors import shown
from matpoint.fields import Floats
from matpoint.functions import FunctionLaw, Where, name_of, positional_count
from matpoint.parts import Part


def text_for_core(where: str, value: Any) -> str:
    """A name or path as text. Raises InputError for what is neither, and for half a character (a lone surrogate), which no file can
    hold."""
    if not isinstance(value, (str, os.PathLike)):
        raise _core.InputError(f"{where}: {shown(value)} is not allowed, it must be a text or a path")
    text = str(value)
    try:
        text.encode("utf-8")
    except UnicodeEncodeError as error:
        raise _core.InputError(f"{where}: the text {text!a} has a character that no file can hold (a lone surrogate)") from error
    return text


def copied(value: Any) -> Any:
    """A value of a case whose tables, lists and arrays can be changed alone; functions are shared."""
    if isinstance(value, Part):
        made = copy.copy(value)
        made.update({key: copied(item) for key, item in value.items()})
        return made
    if isinstance(value, (list, tuple)):
        return type(value)(copied(item) for item in value)
    if isinstance(value, np.ndarray):
        return value.copy()
    return value


def plain(value: Any) -> Any:
    """Parts as dicts, tuples and arrays as lists."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items() if item is not None}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    return value


def refuse_functions(where: str, value: Any) -> None:
    """Raises InputError, with the place, for what no case file can hold."""
    if isinstance(value, (Where, FunctionLaw)) or callable(value):
        name = repr(value) if isinstance(value, (Where, FunctionLaw)) else name_of(value)
        raise _core.InputError(f"{where} = {name} is a Python function, which a case file cannot hold")
    if isinstance(value, Mapping):
        for key, item in value.items():
            refuse_functions(f"{where}.{key}", item)
    elif isinstance(value, (list, tuple)):
        for index, item in enumerate(value):
            refuse_functions(f"{where}[{index}]", item)


def require_picklable(where: str, value: Any) -> None:
    """Raises InputError, with the place, for a function that cannot be pickled."""
    if isinstance(value, (Where, FunctionLaw)) or callable(value):
        try:
            pickle.dumps(value)
        except Exception as error:  # pickle raises whatever the object does
            name = repr(value) if isinstance(value, (Where, FunctionLaw)) else name_of(value)
            raise _core.InputError(f"{where} = {name} cannot be pickled: {error}; define it at the top of a module") from error
    if isinstance(value, Mapping):
        for key, item in value.items():
            require_picklable(f"{where}.{key}", item)
    elif isinstance(value, (list, tuple)):
        for index, item in enumerate(value):
            require_picklable(f"{where}[{index}]", item)


def _without_functions(table: Mapping[str, Any], dim: int) -> dict[str, Any]:
    plain = dict(table)
    if isinstance(plain.get("region"), Where):
        plain["region"] = {"type": "box", "lower": [0.0] * dim, "upper": [1.0] * dim}
    if callable(plain.get("velocity")):
        if plain.get("kind") == "velocity":
            plain["velocity"] = [0.0] * dim
        else:
            del plain["velocity"]
    if isinstance(plain.get("material"), FunctionLaw):
        plain["material"] = plain["material"].to_core()
    if _has_arrays(plain.get("layout")):
        plain["layout"] = _core.points(np.zeros((1, dim)), np.ones(1))
    return plain


def text_of(key: str, value: Any) -> str:
    """How a function or an array is said in words; nothing for what a case file can say."""
    if isinstance(value, Where):
        return f"chosen by {shown(value)}"
    if key == "velocity" and callable(value):
        return f"the function {name_of(value)}"
    if key == "layout" and _has_arrays(value):
        return f"{len(value['positions'])} points from an array"
    return ""


def _has_arrays(layout: Any) -> bool:
    return isinstance(layout, Mapping) and layout.get("type") == "points" and isinstance(layout.get("positions"), np.ndarray)


def _predicate(region: Where, dim: int, lower: Any, upper: Any) -> _core.Region:
    def contains(position: Floats) -> bool:
        return bool(region.mask(position)[0])

    corners = [[float(x) for x in np.asarray(corner).ravel()] for corner in (lower, upper)]
    return _core.predicate_region(contains, dim, corners[0], corners[1])


def _load_to_core(load: Mapping[str, Any], dim: int, grid: Mapping[str, Any]) -> dict[str, Any]:
    made = dict(load)
    if isinstance(made.get("region"), Where):
        made["region"] = _predicate(made["region"], dim, grid["lower"], grid["upper"])
    return made


def _body_to_core(body: Mapping[str, Any], dim: int) -> dict[str, Any]:
    made = dict(body)
    where = f'body "{body.get("name", "")}"'
    region = made.get("region")
    if isinstance(region, Where):
        if region.lower is None or region.upper is None:
            raise _core.InputError(f"{where}: region: {region!r} needs lower and upper, the corners of a box around it, to fill it")
        for corner in (region.lower, region.upper):
            if np.shape(corner) != (dim,):
                raise _core.InputError(f"{where}: region: {region!r}: the corner {shown(corner)} must have {dim} numbers")

        made["region"] = _predicate(region, dim, region.lower, region.upper)
    if isinstance(made.get("material"), FunctionLaw):
        made["material"] = made["material"].to_core()
    if callable(made.get("velocity")):
        del made["velocity"]  # assigned after the particles are made
    if _has_arrays(made.get("layout")):
        layout = made["layout"]
        positions = np.ascontiguousarray(layout["positions"], dtype=np.float64)
        if positions.ndim != 2 or positions.shape[1] != dim:
            raise _core.InputError(
                f"{where}: layout: positions have the shape {positions.shape}; the case has dim = {dim}, so it must be (n, {dim})"
            )
        made["layout"] = _core.points(positions, np.atleast_1d(np.asarray(layout.get("volumes"), dtype=np.float64)))
    return made


def node_axes(grid: Mapping[str, Any], shape: str) -> list[Floats]:
    """Coordinates [m] of the nodes of a resolved grid, per direction, for the shape functions of the explicit solver."""
    axes = []
    for lower, upper, cells in zip(grid["lower"], grid["upper"], grid["cells"], strict=True):
        places = np.arange(cells + 1.0)
        if shape in ("bspline2", "bspline3"):
            # Control points stand at the means of as many knots as the degree (Greville).
            degree = int(shape[-1])
            i = np.arange(cells + degree)
            places = np.mean([np.clip(i - k, 0, cells) for k in range(degree)], axis=0)
        elif shape in ("gimp", "cpdi"):
            places = np.arange(-1.0, cells + 2)
        axes.append(lower + (upper - lower) / cells * places)
    return axes


def node_positions(axes: list[Floats]) -> Floats:
    """Positions [m] of all nodes of such a grid, shape (n, dim), x fastest."""
    mesh = np.meshgrid(*reversed(axes), indexing="ij")
    return np.stack([axis.ravel() for axis in reversed(mesh)], axis=1)


def _node_set(region: Where, axes: list[Floats], where: str) -> _core.Region:
    mask = np.ascontiguousarray(region.mask(node_positions(axes)))
    if not mask.any():
        raise _core.InputError(f"{where}: {region!r} chooses none of the {len(mask)} nodes of the grid, so it would do nothing")
    return _core.node_set([[float(x) for x in axis] for axis in axes], mask)


def _numbers(what: str, value: Any) -> Floats:
    """What a function has given, as numbers. Raises InputError."""
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise _core.InputError(f"{what}: it gave {shown(value)}; it must give numbers") from None


def _checked_velocity(function: Callable[..., Any], dim: int) -> Callable[[float], Floats]:
    def velocity(time: float) -> Floats:
        values = np.ascontiguousarray(_numbers(f"boundary velocity {name_of(function)}", function(time)))
        if values.shape != (dim,) or not np.isfinite(values).all():
            raise _core.InputError(
                f"boundary velocity {name_of(function)}: at t = {time} s it gave {shown(values)}; it must give {dim} finite numbers [m/s]"
            )
        return values

    return velocity


def _body_force(function: Callable[..., Any], dim: int) -> _core.BodyForce:
    depends_on_time = positional_count(function) > 1

    def force(positions: Floats, time: float) -> Floats:
        given = function(positions, time) if depends_on_time else function(positions)
        values = _numbers(f"body_force {name_of(function)}", given)
        try:
            values = np.ascontiguousarray(np.broadcast_to(values, positions.shape))
        except ValueError:
            raise _core.InputError(
                f"body_force {name_of(function)}: it gave the shape {values.shape} for positions of shape {positions.shape}; "
                "it must give the same shape"
            ) from None
        if not np.isfinite(values).all():
            raise _core.InputError(f"body_force {name_of(function)}: at t = {time} s it gave a number that is not finite")
        return values

    return _core.body_force(force, dim, not depends_on_time)


def _without_empty(data: Mapping[str, Any]) -> dict[str, Any]:
    """Lists of sections that hold none are left out."""
    return {key: value for key, value in data.items() if not (isinstance(value, list) and not value) or key == "body"}


def placeholders(case: Mapping[str, Any], dim: int) -> dict[str, Any]:
    """The sections of a case with something plain where functions are: what the core can check before it meets them."""
    data = {key: value for key, value in case.items() if key != "body_force"}
    data["body"] = [_without_functions(body, dim) for body in case.get("body", [])]
    data["boundary"] = [_without_functions(boundary, dim) for boundary in case.get("boundary", [])]
    data["load"] = [_without_functions(load, dim) for load in case.get("load", [])]
    return _without_empty(plain(data))


def to_core(case: Mapping[str, Any], dim: int, resolved: Mapping[str, Any]) -> dict[str, Any]:
    """The sections of a case as the core takes them, functions and all; `resolved`: with their defaults. Raises InputError."""
    data = dict(case)
    axes = node_axes(resolved["grid"], resolved["solver"].get("shape", "linear"))
    data["body"] = [_body_to_core(body, dim) for body in case.get("body", [])]
    boundaries = []
    for number, boundary in enumerate(case.get("boundary", []), start=1):
        boundary = dict(boundary)
        if isinstance(boundary.get("region"), Where):
            boundary["region"] = _node_set(boundary["region"], axes, f"boundary {number}: region")
        if callable(boundary.get("velocity")):
            velocity = _checked_velocity(boundary["velocity"], dim)
            velocity(0.0)  # what is wrong with it shall be said now
            boundary["velocity"] = _core.velocity_history(velocity, dim)
        boundaries.append(boundary)
    data["boundary"] = boundaries
    data["load"] = [_load_to_core(load, dim, resolved["grid"]) for load in case.get("load", [])]
    if callable(data.get("body_force")):
        data["body_force"] = _body_force(data["body_force"], dim)
    return _without_empty(plain(data))
