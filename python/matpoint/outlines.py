"""Outlines of rigid tools in pictures: their shapes where they are at a time, by the columns of the history."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from matpoint.fields import Floats

_CIRCLE = np.linspace(0, 2 * np.pi, 65)


def _box(lower: Floats, upper: Floats) -> list[Floats]:
    dim = len(lower)
    if dim == 2:
        return [np.array([[lower[0], lower[1]], [upper[0], lower[1]], [upper[0], upper[1]], [lower[0], upper[1]], [lower[0], lower[1]]])]
    corners = np.array([[(lower, upper)[(k >> d) & 1][d] for d in range(3)] for k in range(8)])
    return [corners[[k, k | (1 << d)]] for k in range(8) for d in range(3) if not (k >> d) & 1]


def _circle(center: Floats, one: Floats, other: Floats) -> Floats:
    return center + np.cos(_CIRCLE)[:, None] * one + np.sin(_CIRCLE)[:, None] * other


def _lines(shape: Mapping[str, Any], size: float) -> list[Floats]:
    """The shape's lines at the start, each of shape (n, dim) [m]; a plane is drawn as far as `size`."""
    kind = shape["type"]
    if kind == "union":
        return [line for part in shape["of"] for line in _lines(part, size)]
    if kind == "box":
        return _box(np.array(shape["lower"], float), np.array(shape["upper"], float))
    if kind == "polygon":
        corners = np.array(shape["vertices"], float)
        return [np.concatenate([corners, corners[:1]])]
    if kind == "half_space":
        point, normal = np.array(shape["point"], float), np.array(shape["normal"], float)
        if len(point) == 3:
            return []
        along = np.array([-normal[1], normal[0]]) / np.hypot(*normal)
        return [np.stack([point - size * along, point + size * along])]
    if kind in ("disk", "sphere"):
        center, axes = np.array(shape["center"], float), shape["radius"] * np.eye(len(shape["center"]))
        return [_circle(center, axes[a], axes[b]) for a in range(len(axes)) for b in range(a)]
    if kind == "cylinder":
        start, end = np.array(shape["start"], float), np.array(shape["end"], float)
        axis = (end - start) / np.linalg.norm(end - start)
        one = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
        one *= shape["radius"] / np.linalg.norm(one)
        other = np.cross(axis, one)
        sides = [np.stack([start + way, end + way]) for way in (one, other, -one, -other)]
        return [_circle(start, one, other), _circle(end, one, other), *sides]
    return []


def _turned(points: Floats, turn: Floats) -> Floats:
    """By a rotation vector [rad]; in 2D by an angle."""
    angle = float(np.linalg.norm(turn))
    if points.shape[1] == 2:
        angle = float(turn[0])
        in_plane: Floats = points @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        return in_plane
    if angle == 0:
        return points
    axis = turn / angle
    across = np.cross(axis, points)
    turned: Floats = points + np.sin(angle) * across + (1 - np.cos(angle)) * np.cross(axis, across)
    return turned


def tool_lines(case: Mapping[str, Any], history: Mapping[str, Floats], time: float, size: float) -> list[Floats]:
    """Lines of all tools at a time [s], each of shape (n, dim) [m]; where the history has no row yet, as they start."""
    dim = int(case.get("dim", 2))
    lines = []
    for tool in case.get("tool", []):
        if not isinstance(tool.get("shape"), Mapping):
            continue

        def column(name: str, tool: Mapping[str, Any] = tool) -> Floats:
            places = [f"{name}_{axis}" for axis in "xyz"[:dim]] if dim == 3 or name == "position" else [name]
            return np.stack([history[f"{tool['name']}.{place}"] for place in places], axis=1)

        start_lines = _lines(tool["shape"], size)
        if len(history.get("time", ())) == 0:
            lines += start_lines
            continue
        times, position, turn = history["time"], column("position"), column("turn")
        now = [np.array([np.interp(time, times, values[:, d]) for d in range(values.shape[1])]) for values in (position, turn)]
        lines += [now[0] + _turned(line - position[0], now[1]) for line in start_lines]
    return lines
