"""Reads a results folder: manifest.toml, history.csv, probe_<name>.csv and the fields in <body>.vtkhdf.

A run may still be going on, or may have been killed: every file is complete up to its last row or time.
"""

from __future__ import annotations

import csv
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from matpoint.errors import ResultsError, did_you_mean, shown
from matpoint.fields import Floats, scalar_of

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["BodyFields", "Results", "ResultsError", "open"]


def read_table(path: Path) -> dict[str, Floats]:
    """Columns of a CSV file that has its names in the first line.

    Returns:
        Column name -> float64 array, shape (rows,). A last row that was cut short is left out.

    Raises:
        ResultsError: The file is empty, or no table of numbers.
    """
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    if not rows:
        raise ResultsError(f'"{path}" is empty')
    names = rows[0]
    try:
        values = np.array([[float(x) for x in row] for row in rows[1:] if len(row) == len(names)])
    except ValueError as error:
        raise ResultsError(f'"{path}" is no table of numbers: {error}') from error
    values = values.reshape(-1, len(names))
    return {name: values[:, column] for column, name in enumerate(names)}


@dataclass
class BodyFields:
    """The particles of one body at all written times, read from the file on demand; or the nodes of a body of finite elements.

    Attributes:
        name: The body's name.
        path: Its VTKHDF file.
        times: Written times [s], shape (n_times,).
        names: The fields in the file.
        is_fluid: Whether the body's material has a viscosity.
        cells: Cells of a body of finite elements, shape (cells, nodes per cell), in VTK's order; None for particles.
    """

    name: str
    path: Path
    is_fluid: bool = False
    times: Floats = field(init=False)
    names: list[str] = field(init=False)
    cells: NDArray[np.int64] | None = field(init=False)
    _offsets: NDArray[np.int64] = field(init=False)

    def __post_init__(self) -> None:
        import h5py

        try:
            with h5py.File(self.path, "r") as file:
                root = file["VTKHDF"]
                count = int(root["Steps"].attrs["NSteps"])
                self.times = root["Steps/Values"][:count]
                self.names = sorted(root["PointData"])
                begins = root["Steps/PointOffsets"][:count]
                is_mesh = len(root["Types"]) > 0 and root["Types"][0] != 1
                self.cells = root["Connectivity"][...].reshape(len(root["Types"]), -1).astype(np.int64) if is_mesh else None
                sizes = root["NumberOfPoints"][...][root["Steps/PartOffsets"][:count]] if count else begins
        except (OSError, KeyError) as error:
            raise ResultsError(f'"{self.path}" is not a VTKHDF file of matpoint: {error}') from error
        self._offsets = np.stack([begins, begins + sizes], axis=1).astype(int)

    def positions(self, index: int) -> Floats:
        """Particle positions [m] at the time `times[index]`, shape (n, 3); z = 0 in 2D."""
        return self._read("Points", index)

    def field(self, name: str, index: int) -> Floats:
        """A field at the time `times[index]`, shape (n,) or (n, components), in the order of particle ids."""
        if not isinstance(name, str) or name not in self.names:
            known = ", ".join(self.names)
            raise ResultsError(f'body "{self.name}" has no field {shown(name)}, it has: {known}{did_you_mean(str(name), self.names)}')
        return self._read(f"PointData/{name}", index)

    def scalar(self, name: str, index: int) -> Floats:
        """One number per particle, shape (n,): a scalar field, `velocity` as its magnitude, or a component: `stress_xy`."""
        return scalar_of(self, name, index)

    def _particles(self) -> BodyFields:
        return self

    def _read(self, dataset: str, index: int) -> Floats:
        import h5py

        count = len(self._offsets)
        if isinstance(index, bool) or not isinstance(index, (int, np.integer)) or not -count <= index < count:
            raise ResultsError(f'body "{self.name}": index = {shown(index)} is not allowed: {count} times are written, 0 to {count - 1}')
        begin, end = self._offsets[index]
        with h5py.File(self.path, "r") as file:
            values: Floats = file["VTKHDF"][dataset][begin:end]
            return values


class Results:
    """A results folder.

    Args:
        folder: The folder that `matpoint run` wrote.

    Attributes:
        manifest: Everything in manifest.toml.
        case: The resolved case.
        dim: 2 or 3.
        title: The case's title, or its name.
        history: Columns of history.csv, each of shape (rows,); empty when there is none.
        probes: For each probe its columns.
        bodies: For each body with a VTKHDF file its fields.

    Raises:
        ResultsError: The folder is none that matpoint wrote.
    """

    def __init__(self, folder: str | Path) -> None:
        self.folder = Path(folder)
        try:
            is_folder, exists = self.folder.is_dir(), self.folder.exists()
        except (OSError, ValueError) as error:  # a name that no file can have
            raise ResultsError(
                f"{shown(str(folder))} is no results folder: {error.strerror if isinstance(error, OSError) else error}"
            ) from None
        if not is_folder:
            raise ResultsError(f'"{folder}" is no results folder: {"it is not a folder" if exists else "there is no such folder"}')
        path = self.folder / "manifest.toml"
        if not path.is_file():
            raise ResultsError(f'"{folder}" is no results folder: it has no manifest.toml (`matpoint run` makes one)')
        try:
            self.manifest = tomllib.loads(path.read_text(encoding="utf-8"))
            self.case = self.manifest["case"]
        except (tomllib.TOMLDecodeError, UnicodeDecodeError, KeyError) as error:
            raise ResultsError(f'"{path}" is not a manifest of matpoint: {error}') from error
        self.dim = int(self.case.get("dim", 2))
        self.title = str(self.case.get("title") or self.manifest.get("case_name", self.folder.name))
        self.history = read_table(self.folder / "history.csv") if (self.folder / "history.csv").is_file() else {}
        self.probes = {file.stem.removeprefix("probe_"): read_table(file) for file in sorted(self.folder.glob("probe_*.csv"))}
        self.bodies: dict[str, BodyFields] = {}
        for body in self.case.get("body", self.case.get("bodies", [])):
            file = self.folder / f"{body['name']}.vtkhdf"
            if file.is_file():
                self.bodies[body["name"]] = BodyFields(body["name"], file, "viscosity" in body.get("material", {}))

    def unit(self, field_name: str) -> str:
        """Unit of a field or of a component of it, as text; empty when the manifest does not know it."""
        units = self.manifest.get("units", {}).get("fields", {})
        return str(units.get(field_name, units.get(field_name.rpartition("_")[0], "")))

    def _scene(self) -> Results:
        return self

    def __repr__(self) -> str:
        run = self.manifest
        return f"<results of {run.get('case_name')}: {run.get('status')}, t = {run.get('time')} s, in {self.folder}>"

    def _repr_png_(self) -> bytes:
        from matpoint import plot

        return plot.png_of(plot.particles(self) if self.bodies else plot.energies(self))


def open(path: str | Path) -> Results:
    """A results folder: `open("results/dam").bodies["water"].field("pressure", -1)`.

    Args:
        path: The folder that `matpoint run` or `Simulation.run(output=...)` wrote.

    Raises:
        ResultsError: The folder is none that matpoint wrote.
    """
    return Results(path)
