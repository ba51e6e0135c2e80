"""Draws the pictures of a results folder: `python -m matpoint.plot DIR`, or `matpoint plot DIR`.

    energies.png            energies of the whole system over time
    momentum.png            momentum over time, per body and in total
    particles_<field>.png   all particles coloured by a field at a few times
    probes.png              motion and stress of the probes' particles, when there are probes

Exit code 2 when DIR is no results folder, a field or time does not exist, or a Python package is missing.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

try:
    import h5py  # noqa: F401  (results.py reads with it; its absence shall be said here, in words)
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    from matplotlib.colors import ListedColormap, Normalize
    from matplotlib.patches import Patch
except ImportError as missing:
    print(
        f"error: {missing}: pictures need the Python packages numpy, matplotlib and h5py; this is {sys.executable}. Install them "
        "there, or set MATPOINT_PYTHON to a Python that has them",
        file=sys.stderr,
    )
    sys.exit(2)

from matpoint.results import BodyFields, Results, ResultsError

STYLE = {
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
# Okabe & Ito (2008): colours that the colour-blind tell apart.
COLORS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#7F7F7F"]
PANELS = 6


def dissipated_energy(history: dict[str, np.ndarray]) -> np.ndarray:
    """Energy that damping and viscosity have taken [J], shape (rows,)."""
    return history["damping_dissipation"] + history["viscous_dissipation"]


def total_energy(history: dict[str, np.ndarray]) -> np.ndarray:
    """Kinetic + strain + gravitational + dissipated + removed - work of the boundaries [J], shape (rows,).

    It is constant but for what the transfers between particles and grid take (the column transfer_loss).
    """
    stored = history["kinetic_energy"] + history["strain_energy"] + history["gravitational_energy"]
    return stored + dissipated_energy(history) + history["removed_energy"] - history["boundary_work"]


def plot_energies(results: Results) -> plt.Figure:
    """Energies over time; parts that are zero throughout are left out."""
    history = results.history
    figure, axes = plt.subplots(figsize=(6.4, 3.8))
    parts = [
        ("kinetic", history["kinetic_energy"]),
        ("strain", history["strain_energy"]),
        ("gravitational", history["gravitational_energy"]),
        ("dissipated", dissipated_energy(history)),
        ("work of boundaries", history["boundary_work"]),
        ("removed", history["removed_energy"]),
    ]
    for (label, values), color in zip(parts, COLORS):
        if np.any(values != 0):
            axes.plot(history["time"], values, label=label, color=color)
    axes.plot(history["time"], total_energy(history), label="total", color="black", linestyle="--")
    axes.set(xlabel="time [s]", ylabel="energy [J]" if results.dim == 3 else "energy per thickness [J/m]", title=title_of(results))
    axes.margins(x=0)
    axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return figure


def plot_momentum(results: Results) -> plt.Figure:
    """Momentum over time, one panel per direction."""
    history = results.history
    figure, panels = plt.subplots(results.dim, 1, figsize=(6.4, 1.2 + 1.7 * results.dim), sharex=True)
    bodies = [name.removesuffix(".mass") for name in history if name.endswith(".mass")]
    for axes, direction in zip(panels, "xyz"):
        if len(bodies) > 1:
            for number, body in enumerate(bodies):
                axes.plot(history["time"], history[f"{body}.momentum_{direction}"], label=body, color=COLORS[number % len(COLORS)])
        axes.plot(history["time"], history[f"momentum_{direction}"], label="total", color="black", linestyle="--")
        axes.set_ylabel(f"{direction} [N s]" if results.dim == 3 else f"{direction} [N s/m]")
        axes.margins(x=0)
    panels[0].set_title(title_of(results, "momentum"))
    panels[-1].set_xlabel("time [s]")
    panels[0].legend(loc="upper left", bbox_to_anchor=(1, 1))
    return figure


def plot_probes(results: Results) -> plt.Figure:
    """Position, velocity and stress of the probes' particles over time."""
    names = list(results.probes)
    quantities = [("position", "m"), ("velocity", "m/s"), ("stress", "Pa")]
    figure, panels = plt.subplots(
        len(quantities), len(names), figsize=(1.5 + 4.2 * len(names), 6.4), sharex=True, squeeze=False
    )
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


def choose_times(bodies: list[BodyFields], wanted: list[float] | None) -> list[int]:
    """Indices of the written times that are nearest to the wanted ones; without these, a few evenly spaced.

    Raises:
        ResultsError: Nothing was written, or a wanted time is outside of what was.
    """
    # A run that was killed between two bodies has written one time more for the first.
    count = min(len(body.times) for body in bodies)
    times = bodies[0].times[:count]
    if count == 0:
        raise ResultsError(f'"{bodies[0].path}" holds no time yet')
    if wanted is None:
        even = np.linspace(times[0], times[-1], PANELS)
        return sorted({int(np.argmin(np.abs(times - t))) for t in even})
    # Half an interval, because an output falls on the nearest step.
    slack = 0.5 * (times[-1] - times[0]) / max(1, count - 1) + 1e-12
    for t in wanted:
        if not times[0] - slack <= t <= times[-1] + slack:
            raise ResultsError(f"time {t:g} s was not written: the fields cover {times[0]:g} to {times[-1]:g} s")
    return sorted({int(np.argmin(np.abs(times - t))) for t in wanted})


def default_fields(bodies: list[BodyFields]) -> list[str]:
    """Von Mises stress if there is a solid, pressure if there is a fluid; what the files have if they have neither."""
    wanted = (["von_mises"] if any(not b.is_fluid for b in bodies) else []) + (["pressure"] if any(b.is_fluid for b in bodies) else [])
    present = [name for name in wanted if all(name in body.names for body in bodies)]
    if present:
        return present
    return [name for name in ("velocity", "J", "body", "id") if all(name in body.names for body in bodies)][:1]


def particle_size(body: BodyFields, dim: int) -> float:
    """Edge [m] of the square or cube that a particle stands for."""
    if "volume" in body.names:
        return float(np.median(body.field("volume", 0))) ** (1 / dim)
    positions = body.positions(0)[:, :dim]
    extent = np.maximum(np.ptp(positions, axis=0), 1e-12)
    return float(np.prod(extent) / len(positions)) ** (1 / dim)


def grid_box(results: Results) -> tuple[np.ndarray, np.ndarray]:
    """Corners [m] of the grid, each of shape (dim,)."""
    grid = results.case["grid"]
    lower = np.array(grid.get("lower", [0.0] * results.dim), dtype=float)
    return lower, np.array(grid["upper"], dtype=float)


def color_scale(values: np.ndarray) -> tuple[Normalize, str, str]:
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


def panel_grid(count: int, aspect: float) -> tuple[int, int]:
    """Rows and columns for panels of the given height / width: about 1.6 times as wide as high as a whole, with few empty places."""

    def badness(columns: int) -> float:
        rows = -(-count // columns)
        return abs(np.log(1.6 * aspect * rows / columns)) + (rows * columns - count) / count

    columns = min(range(1, count + 1), key=badness)
    return -(-count // columns), columns


def draw_particles(axes: plt.Axes, results: Results, index: int, field: str, norm: Normalize, cmap: str | ListedColormap) -> list:
    """Draws all bodies at one written time. Returns the scatters with their particle sizes [m]."""
    drawn = []
    for body in results.bodies.values():
        positions = body.positions(index)
        values = body.scalar(field, index)
        if results.dim == 3:
            # Far ones first: the view is the standard isometric one of project().
            order = np.argsort(positions @ np.array([1.0, 1.0, 1.0]))
            positions, values = positions[order], values[order]
        points = project(positions, results.dim)
        marker = "s" if results.dim == 2 else "o"
        scatter = axes.scatter(points[:, 0], points[:, 1], c=values, norm=norm, cmap=cmap, marker=marker, linewidths=0, rasterized=True)
        drawn.append((scatter, particle_size(body, results.dim)))
    return drawn


def project(positions: np.ndarray, dim: int) -> np.ndarray:
    """Positions in the picture's plane [m], shape (n, 2): x and y in 2D, an isometric view with y upward in 3D.

    The viewer is at (1, 1, 1): x comes to the front on the right, z on the left.
    """
    if dim == 2:
        return positions[:, :2]
    x, y, z = positions[:, 0], positions[:, 1], positions[:, 2]
    return np.stack([(x - z) / np.sqrt(2), np.sqrt(2 / 3) * y - (x + z) / np.sqrt(6)], axis=1)


def draw_grid_box(axes: plt.Axes, results: Results) -> None:
    """The outline of the grid."""
    lower, upper = grid_box(results)
    dim = results.dim
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


def plot_particles(results: Results, field: str, wanted_times: list[float] | None = None) -> plt.Figure:
    """All particles coloured by a field, one panel per time, on one colour scale.

    Args:
        field: A field of the VTKHDF files, or a component of one: stress_xy.
        wanted_times: Times [s]; the nearest written ones are taken. Default: six, evenly spaced.

    Raises:
        ResultsError: A body lacks the field, or a time was not written.
    """
    bodies = list(results.bodies.values())
    indices = choose_times(bodies, wanted_times)
    if field == "body":
        norm, cmap, extend = Normalize(-0.5, len(COLORS) - 0.5), ListedColormap(COLORS), "neither"
    else:
        norm, cmap, extend = color_scale(np.concatenate([body.scalar(field, i) for i in indices for body in bodies]))
    lower, upper = grid_box(results)
    box = project(np.stack([lower, upper]), 2) if results.dim == 2 else np.array([[0, 0], [1.0, 1.0]])
    aspect = float(np.clip(np.ptp(box[:, 1]) / np.ptp(box[:, 0]), 0.15, 6))
    rows, columns = panel_grid(len(indices), aspect)
    width = min(9.0 / columns, 9.0 / (rows * aspect), 4.5)
    figure, panels = plt.subplots(
        rows, columns, figsize=(width * columns + 1.4, width * aspect * rows + 0.35 * rows + 0.5), squeeze=False, sharex=True, sharey=True
    )
    drawn = []
    for axes, index in zip(panels.flat, indices):
        axes.grid(False)
        draw_grid_box(axes, results)
        drawn += [(axes, *item) for item in draw_particles(axes, results, index, field, norm, cmap)]
        axes.set_title(f"t = {bodies[0].times[index]:.4g} s")
    for axes in panels.flat[len(indices) :]:
        axes.set_visible(False)
    label_panels(panels, len(indices), results.dim)
    unit = results.unit(field)
    if field == "body":
        patches = [Patch(color=cmap(norm(int(body.scalar(field, indices[0])[0]))), label=name) for name, body in results.bodies.items()]
        figure.legend(handles=patches, loc="outside right center")
    else:
        figure.colorbar(drawn[0][1], ax=panels, label=f"{field} [{unit}]" if unit else field, extend=extend, shrink=0.9, pad=0.02)
    figure.suptitle(title_of(results), fontsize=10)
    size_markers(figure, drawn)
    return figure


def label_panels(panels: np.ndarray, count: int, dim: int) -> None:
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


def size_markers(figure: plt.Figure, drawn: list) -> None:
    """Gives every marker the size that its particle has in the picture, once the layout is known."""
    figure.canvas.draw()
    for axes, scatter, size in drawn:
        left, right = axes.get_xlim()
        points_per_meter = axes.get_window_extent().width / (right - left) * 72 / figure.dpi
        scatter.set_sizes([max(0.6, 1.02 * size * points_per_meter) ** 2])


def title_of(results: Results, what: str = "") -> str:
    """The case's title, or its name."""
    title = results.case.get("title") or results.manifest.get("case_name", results.folder.name)
    return f"{title}: {what}" if what else title


def draw_all(results: Results, fields: list[str] | None, times: list[float] | None) -> list[Path]:
    """Writes all pictures into the folder. Returns their paths. Raises ResultsError."""
    figures = {}
    with plt.rc_context(STYLE):
        if len(results.history.get("time", [])) > 1:
            figures["energies"] = plot_energies(results)
            figures["momentum"] = plot_momentum(results)
        bodies = list(results.bodies.values())
        if bodies:
            for name in fields or default_fields(bodies):
                figures[f"particles_{name}"] = plot_particles(results, name, times)
        elif fields or times:
            raise ResultsError(f'"{results.folder}" holds no .vtkhdf file: the case\'s output.formats must contain "vtkhdf"')
        if any(len(table["time"]) > 1 for table in results.probes.values()):
            figures["probes"] = plot_probes(results)
        paths = []
        for name, figure in figures.items():
            paths.append(results.folder / f"{name}.png")
            figure.savefig(paths[-1])
            plt.close(figure)
    return paths


def read_times(texts: list[str] | None) -> list[float] | None:
    """Numbers of `--times 0,0.5,1`. Raises ResultsError."""
    if texts is None:
        return None
    try:
        return [float(word) for text in texts for word in text.split(",")]
    except ValueError as error:
        raise ResultsError(f'--times {" ".join(texts)}: {error}; give numbers with commas between, e.g. 0,0.5,1') from error


def main(arguments: list[str] | None = None) -> int:
    """The command line; returns the exit code."""
    parser = argparse.ArgumentParser(prog="matpoint plot", description="Draw pictures of a results folder into it.")
    parser.add_argument("folder", metavar="DIR", help="the results folder")
    parser.add_argument("--field", action="append", metavar="NAME", help="field that colours the particles; may be repeated")
    parser.add_argument("--times", action="append", metavar="T,T,...", help="times [s] of the pictures; default: six")
    options = parser.parse_args(arguments)
    try:
        for path in draw_all(Results(options.folder), options.field, read_times(options.times)):
            print(path)
    except ResultsError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"error: cannot write the pictures: {error}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
