"""Pictures: energies, momentum, particles coloured by a field, profiles, probes, animations.

    from matpoint import plot
    plot.energies(simulation.history)                  # also of a Results folder
    plot.particles(simulation, "von_mises")            # now; of a Results folder at some times
    plot.profile(results, "pressure", along="y")
    plot.point_test(mp.point_test("copper_ofhc", "uniaxial_stress"))
    plot.animate(results, "velocity", "dam.gif")

All functions return a matplotlib Figure (`animate` a path).
"""

from __future__ import annotations

import functools
import io
import itertools
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, Protocol

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import Colormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from matpoint.errors import ResultsError, did_you_mean, shown
from matpoint.fields import Floats
from matpoint.outlines import tool_lines
from matpoint.scene import (
    HasParticles,
    HasScene,
    Particles,
    Scene,
    choose_times,
    common_count,
    default_fields,
    grid_box,
    panel_grid,
    particle_size,
    points_of,
    project,
)

if TYPE_CHECKING:
    import pyvista
    from matplotlib.axes import Axes

__all__ = [
    "animate",
    "dissipated_energy",
    "energies",
    "momentum",
    "particles",
    "point_test",
    "probes",
    "profile",
    "to_pyvista",
    "total_energy",
]

STYLE: Any = {
    "figure.dpi": 150,
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "0.9",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
    "figure.constrained_layout.use": True,
}
# Okabe & Ito (2008), and the last one of Tol (2021): colours that the colour-blind tell apart.
COLORS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7F7F7F", "#882255"]


P = ParamSpec("P")


def _styled(function: Callable[P, Figure]) -> Callable[P, Figure]:
    """Our look for one function, and nobody else's settings touched."""

    @functools.wraps(function)
    def drawing(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with plt.rc_context(STYLE):
            return function(*args, **kwargs)

    return drawing


# The energy ledger (docs/theory.md): columns of the history, with their signs. Some are of one solver only.
_DISSIPATED = {
    "damping_dissipation": 1,
    "viscous_dissipation": 1,
    "plastic_dissipation": 1,
    "contact_dissipation": 1,
    "filter_dissipation": 1,
    "soft_dissipation": 1,
    "receding_work": -1,
    "integrator_loss": 1,
    "reset_loss": 1,
}
_FROM_OUTSIDE = {"boundary_work": 1, "body_force_work": 1, "shift_work": 1}


def _sum_of(history: Mapping[str, Floats], parts: Mapping[str, int]) -> Floats:
    total = np.zeros_like(history["kinetic_energy"])
    for name, sign in parts.items():
        if name in history:
            total = total + sign * history[name]
    return total


def dissipated_energy(history: Mapping[str, Floats]) -> Floats:
    """Energy that damping, viscosity, plastic flow, friction and impacts, filters and the implicit solver's method have taken [J], shape
    (rows,)."""
    return _sum_of(history, _DISSIPATED)


def total_energy(history: Mapping[str, Floats]) -> Floats:
    """Kinetic + strain + gravitational energy, that between bodies, dissipated and removed energy - work from outside [J], shape (rows,).

    It is constant but for what the transfers between particles and grid take (the column transfer_loss).
    """
    parts = ("kinetic_energy", "strain_energy", "gravitational_energy", "contact_energy", "removed_energy")
    return _sum_of(history, dict.fromkeys(parts, 1)) + dissipated_energy(history) - outer_work(history)


def outer_work(history: Mapping[str, Floats]) -> Floats:
    """Work of moving boundaries, of body forces other than gravity, and of moving a fluid's particles apart [J], shape (rows,)."""
    return _sum_of(history, _FROM_OUTSIDE)


class HasHistory(Protocol):
    """A results folder or a simulation: what has columns of a history."""

    @property
    def history(self) -> Mapping[str, Floats]:
        """Column name -> array of shape (rows,)."""


class HasProbes(Protocol):
    """A results folder: what has tables of probes."""

    @property
    def probes(self) -> Mapping[str, Mapping[str, Floats]]:
        """Name of the probe -> its columns."""


def _history_of(source: HasHistory | Mapping[str, Floats]) -> Mapping[str, Floats]:
    history = source if isinstance(source, Mapping) else getattr(source, "history", None)
    if not isinstance(history, Mapping):
        raise ResultsError(f"{shown(source)} has no history: give a results folder, a simulation, or its history")
    return history


@_styled
def energies(source: HasHistory | Mapping[str, Floats]) -> Figure:
    """Energies [J] over time [s]; parts that are zero throughout are left out.

    Args:
        source: A results folder, a simulation, or its history.
    """
    history = _history_of(source)
    dim = 3 if "momentum_z" in history else 2
    figure, axes = plt.subplots(figsize=(6.4, 3.8))
    parts = [
        ("kinetic", history["kinetic_energy"]),
        ("strain", history["strain_energy"]),
        ("gravitational", history["gravitational_energy"]),
        ("between bodies", _sum_of(history, {"contact_energy": 1})),
        ("plastic", _sum_of(history, {"plastic_dissipation": 1})),
        ("dissipated", _sum_of(history, _DISSIPATED | {"plastic_dissipation": 0})),
        ("work from outside", outer_work(history)),
        ("removed", history["removed_energy"]),
    ]
    for (label, values), color in zip(parts, COLORS):
        if np.any(values != 0):
            axes.plot(history["time"], values, label=label, color=color)
    axes.plot(history["time"], total_energy(history), label="total", color="black", linestyle="--")
    axes.set(xlabel="time [s]", ylabel="energy [J]" if dim == 3 else "energy per thickness [J/m]", title=_title_of(source))
    axes.margins(x=0)
    axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return figure


@_styled
def momentum(source: HasHistory | Mapping[str, Floats]) -> Figure:
    """Momentum [N s] over time [s], one panel per direction.

    Args:
        source: A results folder, a simulation, or its history.
    """
    history = _history_of(source)
    dim = 3 if "momentum_z" in history else 2
    figure, panels = plt.subplots(dim, 1, figsize=(6.4, 1.2 + 1.7 * dim), sharex=True)
    bodies = [name.removesuffix(".mass") for name in history if name.endswith(".mass")]
    for axes, direction in zip(panels, "xyz"):
        if len(bodies) > 1:
            for number, body in enumerate(bodies):
                axes.plot(history["time"], history[f"{body}.momentum_{direction}"], label=body, color=COLORS[number % len(COLORS)])
        axes.plot(history["time"], history[f"momentum_{direction}"], label="total", color="black", linestyle="--")
        axes.set_ylabel(f"{direction} [N s]" if dim == 3 else f"{direction} [N s/m]")
        axes.margins(x=0)
    panels[0].set_title(_title_of(source, "momentum"))
    panels[-1].set_xlabel("time [s]")
    panels[0].legend(loc="upper left", bbox_to_anchor=(1, 1))
    return figure


@_styled
def point_test(test: Mapping[str, Floats], title: str = "") -> Figure:
    """Curves of a test of one point (`mp.point_test`): stress and volume over strain, the path of stress, energies.

    Args:
        test: Its table, or that of `matpoint test-material`.
        title: Of the picture.

    Raises:
        ResultsError: It is no table of a test.
        KeyError: A column is missing.
    """
    if not isinstance(test, Mapping):
        raise ResultsError(f"{shown(test)} is no table of a point test: give what mp.point_test returns")
    strain = test["strain"]
    is_shear = bool(np.any(test["F_xy"] != 0)) and np.array_equal(strain, test["F_xy"])
    figure, panels = plt.subplots(2, 2, figsize=(7.2, 5.6))
    stress = ("stress_xy", "shear stress xy [Pa]") if is_shear else ("q", "q [Pa]")
    along = "shear F_xy [1]" if is_shear else "strain [1]"
    first, path, volume, energy = panels.flat
    first.plot(strain, test[stress[0]], color=COLORS[0])
    first.set(xlabel=along, ylabel=stress[1])
    path.plot(test["p"], test["q"], color=COLORS[0])
    path.plot(test["p"][:1], test["q"][:1], "o", color=COLORS[0], markersize=4)
    path.set(xlabel="pressure p [Pa]", ylabel="q [Pa]")
    volume.plot(strain, np.log(test["J"]), color=COLORS[0])
    volume.set(xlabel=along, ylabel="volume strain ln J [1]")
    energy.plot(strain, test["energy"], label="stored", color=COLORS[1])
    energy.plot(strain, test["dissipated"], label="dissipated", color=COLORS[2])
    energy.set(xlabel=along, ylabel="energy [J/m^3]")
    energy.legend()
    if strain[-1] < 0:  # compression goes to the right, too
        for axes in (first, volume, energy):
            axes.invert_xaxis()
    if title:
        figure.suptitle(title)
    return figure


@_styled
def probes(results: HasProbes) -> Figure:
    """Position, velocity and stress of the probes' particles over time."""
    names = list(results.probes)
    quantities = [("position", "m"), ("velocity", "m/s"), ("stress", "Pa")]
    figure, panels = plt.subplots(len(quantities), len(names), figsize=(1.5 + 4.2 * len(names), 6.4), sharex=True, squeeze=False)
    for column, name in enumerate(names):
        table = results.probes[name]
        for axes, (quantity, unit) in zip(panels[:, column], quantities):
            for number, key in enumerate(k for k in table if k.startswith(quantity + "_")):
                axes.plot(table["time"], table[key], label=key.removeprefix(quantity + "_"), color=COLORS[number % len(COLORS)])
            axes.set_ylabel(f"{quantity} [{unit}]")
            axes.margins(x=0)
            axes.legend(loc="upper left", bbox_to_anchor=(1, 1), handlelength=1)
        panels[0, column].set_title(f"probe {name}")
        panels[-1, column].set_xlabel("time [s]")
    return figure


def color_scale(values: Floats) -> tuple[Normalize, str, str]:
    """Norm, colour map and the `extend` of the colour bar for values of one sign or of both.

    A few particles in free flight or at a contact often have a hundred times the stress of the rest; the scale covers the
    middle 99 % and the bar shows by an arrow that there is more.
    """
    finite = values[np.isfinite(values)]
    if finite.size == 0:
        return Normalize(0, 1), "viridis", "neither"
    low, high = np.percentile(finite, [0.5, 99.5])
    if finite.min() >= 0:
        low = finite.min() if low < 0.2 * high else low
    elif finite.max() > 0 and min(-low, high) > 0.05 * max(-low, high):
        bound = max(-low, high)
        extend = "both" if finite.min() < -bound or finite.max() > bound else "neither"
        return Normalize(-bound, bound), "coolwarm", extend
    if low == high:
        low, high = low - 0.5 * max(abs(low), 1e-30), high + 0.5 * max(abs(high), 1e-30)
    below, above = finite.min() < low, finite.max() > high
    extend = {(True, True): "both", (True, False): "min", (False, True): "max", (False, False): "neither"}[(below, above)]
    return Normalize(low, high), "viridis", extend


def triangles_of(cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles, shape (n, 3), that fill 2D cells: two of a cell with 4 nodes, eight around the middle of one with 9."""
    if cells.shape[1] == 4:
        return np.concatenate([cells[:, [0, 1, 2]], cells[:, [0, 2, 3]]])
    around = [0, 4, 1, 5, 2, 6, 3, 7, 0]
    return np.concatenate([cells[:, [a, b, 8]] for a, b in itertools.pairwise(around)])


def draw_particles(
    axes: Axes, scene: Scene, index: int, field: str, norm: Normalize, cmap: str | Colormap, as_points: bool = False
) -> list[tuple[Any, float]]:
    """Draws all bodies at one written time, cells of finite elements filled in 2D unless `as_points`.

    Returns what was drawn: scatters with their particle sizes [m], filled cells with 0.
    """
    drawn: list[tuple[Any, float]] = []
    for body in scene.bodies.values():
        points, values = points_of(body, index, field, scene.dim)
        if body.cells is not None and scene.dim == 2 and not as_points:
            mesh = Triangulation(points[:, 0], points[:, 1], triangles_of(body.cells))
            drawn.append((axes.tripcolor(mesh, values, norm=norm, cmap=cmap, shading="gouraud", rasterized=True), 0))
            continue
        marker = "s" if scene.dim == 2 else "o"
        scatter = axes.scatter(points[:, 0], points[:, 1], c=values, norm=norm, cmap=cmap, marker=marker, linewidths=0, rasterized=True)
        drawn.append((scatter, particle_size(scene, body)))
    return drawn


def draw_grid_box(axes: Axes, scene: Scene) -> None:
    """The outline of the grid."""
    lower, upper = grid_box(scene)
    dim = scene.dim
    corners = np.array([[(lower, upper)[(k >> d) & 1][d] if d < dim else 0.0 for d in range(3)] for k in range(2**dim)])
    points = project(corners, dim)
    for k in range(2**dim):
        for d in range(dim):
            if not (k >> d) & 1:
                ends = points[[k, k | (1 << d)]]
                axes.plot(ends[:, 0], ends[:, 1], color="0.6", linewidth=0.7, zorder=0)
    axes.set_aspect("equal")
    margin = 0.02 * np.max(np.ptp(points, axis=0))
    axes.set_xlim(points[:, 0].min() - margin, points[:, 0].max() + margin)
    axes.set_ylim(points[:, 1].min() - margin, points[:, 1].max() + margin)


def draw_tools(axes: Axes, scene: Scene, history: Mapping[str, Floats], time: float) -> None:
    """The outlines of rigid tools at a time [s]."""
    lower, upper = grid_box(scene)
    for line in tool_lines(scene.case, history, time, float(np.linalg.norm(upper - lower))):
        points = project(line, scene.dim)
        axes.plot(points[:, 0], points[:, 1], color="black", linewidth=1.0)


@_styled
def particles(source: HasScene, field: str | None = None, times: Sequence[float] | None = None) -> Figure:
    """All particles coloured by a field, one panel per time, on one colour scale.

    Args:
        source: A results folder, or a simulation as it is now.
        field: A field, or a component of one: stress_xy; "body" colours by body. Default: von Mises stress, or pressure of fluids.
        times: Times [s] of a results folder; the nearest written ones are taken. Default: six, evenly spaced.

    Raises:
        ResultsError: A body lacks the field, or a time was not written.
    """
    scene = source._scene()
    bodies = list(scene.bodies.values())
    indices = choose_times(bodies, times)
    if field is None:
        field = (default_fields(bodies) or ["body"])[0]
    if not isinstance(field, str):
        raise ResultsError(f"{shown(field)} is no name of a field")
    if field == "body":
        norm, extend = Normalize(-0.5, len(COLORS) - 0.5), "neither"
        cmap: Any = ListedColormap(COLORS)
    else:
        norm, cmap, extend = color_scale(np.concatenate([body.scalar(field, i) for i in indices for body in bodies]))
    lower, upper = grid_box(scene)
    box = project(np.stack([lower, upper]), 2) if scene.dim == 2 else np.array([[0, 0], [1.0, 1.0]])
    aspect = float(np.clip(np.ptp(box[:, 1]) / np.ptp(box[:, 0]), 0.15, 6))
    rows, columns = panel_grid(len(indices), aspect)
    width = min(9.0 / columns, 9.0 / (rows * aspect), 4.5)
    figure, panels = plt.subplots(
        rows, columns, figsize=(width * columns + 1.4, width * aspect * rows + 0.35 * rows + 0.5), squeeze=False, sharex=True, sharey=True
    )
    drawn = []
    for axes, index in zip(panels.flat, indices):
        axes.grid(False)
        draw_grid_box(axes, scene)
        draw_tools(axes, scene, getattr(source, "history", {}), float(bodies[0].times[index]))
        drawn += [(axes, *item) for item in draw_particles(axes, scene, index, field, norm, cmap)]
        axes.set_title(f"t = {bodies[0].times[index]:.4g} s")
    for axes in panels.flat[len(indices) :]:
        axes.set_visible(False)
    label_panels(panels, len(indices), scene.dim)
    unit = scene.unit(field)
    if field == "body":
        patches = [Patch(color=cmap(norm(int(body.scalar(field, indices[0])[0]))), label=name) for name, body in scene.bodies.items()]
        figure.legend(handles=patches, loc="outside right center")
    else:
        figure.colorbar(drawn[0][1], ax=panels, label=f"{field} [{unit}]" if unit else field, extend=extend, shrink=0.9, pad=0.02)
    figure.suptitle(_title_of(source), fontsize=10)
    size_markers(figure, drawn)
    return figure


def label_panels(panels: Any, count: int, dim: int) -> None:
    """Axis labels at the outer panels; an isometric view has no axes to label."""
    rows, columns = panels.shape
    for number, axes in enumerate(panels.flat):
        if dim == 3:
            axes.set_axis_off()
            continue
        if number % columns == 0:
            axes.set_ylabel("y [m]")
        if number + columns >= count:
            axes.set_xlabel("x [m]")
            axes.tick_params(labelbottom=True)


def size_markers(figure: Figure, drawn: list[tuple[Any, Any, float]]) -> None:
    """Gives every marker the size that its particle has in the picture, once the layout is known."""
    figure.canvas.draw()
    for axes, scatter, size in drawn:
        if size == 0:
            continue
        left, right = axes.get_xlim()
        points_per_meter = axes.get_window_extent().width / (right - left) * 72 / figure.dpi
        scatter.set_sizes([max(0.6, 1.02 * size * points_per_meter) ** 2])


def _title_of(source: Any, what: str = "") -> str:
    """The case's title, or its name; nothing for a bare history."""
    title = "" if isinstance(source, Mapping) else source._scene().title
    return f"{title}: {what}" if what and title else title or what


@_styled
def profile(
    source: HasScene,
    field: str,
    along: str = "y",
    *,
    times: Sequence[float] | None = None,
    bodies: Sequence[str] | None = None,
) -> Figure:
    """A field of all particles over one coordinate [m], e.g. the velocity of a channel flow over y.

    Args:
        source: A results folder, or a simulation as it is now.
        field: A scalar field, or a component: velocity_x. A vector is drawn by its magnitude.
        along: "x", "y" or "z".
        times: Times [s] of a results folder; the nearest written ones are taken. Default: the last.
        bodies: Names; default: all.

    Raises:
        ResultsError: A body, field, direction or time does not exist.
    """
    scene = source._scene()
    if not isinstance(along, str) or along not in tuple("xyz"[: scene.dim]):
        raise ResultsError(f"along = {shown(along)} is not allowed, it must be one of {', '.join('xyz'[: scene.dim])}")
    for name in bodies or []:
        if name not in scene.bodies:
            raise ResultsError(f'there is no body "{name}"{did_you_mean(name, list(scene.bodies))}')
    chosen = [scene.bodies[name] for name in bodies or scene.bodies]
    last = common_count(chosen) - 1
    indices = choose_times(chosen, times if times is not None else [float(chosen[0].times[last])])
    figure, axes = plt.subplots(figsize=(5.2, 3.6))
    for number, (index, body) in enumerate((i, b) for i in indices for b in chosen):
        axes.plot(
            body.positions(index)[:, "xyz".index(along)],
            body.scalar(field, index),
            ".",
            markersize=3,
            color=COLORS[number % len(COLORS)],
            label=f"{body.name}, t = {body.times[index]:.4g} s",
        )
    unit = scene.unit(field)
    axes.set(xlabel=f"{along} [m]", ylabel=f"{field} [{unit}]" if unit else field, title=scene.title)
    axes.legend(loc="upper left", bbox_to_anchor=(1, 1))
    return figure


def animate(results: Scene, field: str, path: str | Path, *, frames_per_second: int = 10) -> Path:
    """An animation of all written times, particles coloured by a field.

    Args:
        results: A results folder.
        field: As for `particles`.
        path: A .gif file, written with Pillow; or .mp4, which needs the program ffmpeg.
        frames_per_second: Written times per second.

    Returns:
        The path.

    Raises:
        ResultsError: The ending is another one, ffmpeg is missing, nothing was written, or the field does not exist.
    """
    from matplotlib import animation

    path = Path(path)
    if path.suffix not in (".gif", ".mp4"):
        raise ResultsError(f'"{path}": animations end in .gif or .mp4')
    if path.suffix == ".mp4" and not animation.writers.is_available("ffmpeg"):
        raise ResultsError(f'"{path}": .mp4 needs the program ffmpeg, which is not installed; take .gif')
    bodies = list(results.bodies.values())
    count = common_count(bodies)
    norm, cmap, extend = color_scale(np.concatenate([body.scalar(field, i) for i in range(count) for body in bodies]))
    lower, upper = grid_box(results)
    aspect = float(np.clip((upper[1] - lower[1]) / (upper[0] - lower[0]), 0.3, 3)) if results.dim == 2 else 1.0
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(6.2, 5.0 * aspect + 0.8))

        unit = results.unit(field)
        scale = matplotlib.cm.ScalarMappable(norm, cmap)
        figure.colorbar(scale, ax=axes, label=f"{field} [{unit}]" if unit else field, extend=extend, shrink=0.9)
        axes.grid(False)
        axes.set(xlabel="x [m]" if results.dim == 2 else "", ylabel="y [m]" if results.dim == 2 else "", title=results.title)
        draw_grid_box(axes, results)
        drawn = draw_particles(axes, results, 0, field, norm, cmap, as_points=True)
        size_markers(figure, [(axes, *item) for item in drawn])
        figure.set_layout_engine("none")  # laid out; doing so for each frame takes most of the time

        def draw(index: int) -> list[Any]:
            axes.set_title(f"{results.title}, t = {bodies[0].times[index]:.4g} s")
            for (scatter, _), body in zip(drawn, bodies, strict=True):
                points, values = points_of(body, index, field, results.dim)
                scatter.set_offsets(points)
                scatter.set_array(values)
            return [scatter for scatter, _ in drawn]

        moving = animation.FuncAnimation(figure, draw, frames=count, init_func=lambda: [])
        moving.save(path, writer="ffmpeg" if path.suffix == ".mp4" else "pillow", fps=frames_per_second, dpi=80)
        plt.close(figure)
    return path


def to_pyvista(body: HasParticles, index: int = -1) -> pyvista.DataSet:
    """The particles of a body with all their fields as a PyVista object; the cells of a body of finite elements, with its nodes' fields.

    Args:
        body: A body of a simulation, or of a results folder.
        index: Which written time of a results folder; default: the last.

    Returns:
        A point cloud (PolyData) or a mesh (UnstructuredGrid): `to_pyvista(body).plot(scalars="pressure")`.

    Raises:
        ImportError: The package pyvista is not installed.
    """
    import pyvista

    source: Particles = body._particles()
    index = index % len(source.times)
    positions = np.asarray(source.positions(index), dtype=float)
    data: pyvista.DataSet
    if source.cells is None:
        data = pyvista.PolyData(positions)
    else:
        vtk_type = {4: 9, 9: 28, 8: 12, 27: 29}[source.cells.shape[1]]
        data = pyvista.UnstructuredGrid({vtk_type: source.cells}, positions)
    for name in source.names:
        data.point_data[name] = source.field(name, index)
    return data


def png_of(figure: Figure) -> bytes:
    """The figure as a PNG picture; closes it."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png")
    plt.close(figure)
    return stream.getvalue()
