"""The results of a run open with VTK as a user would open them, and say the same as history.csv.

Needs vtk or pyvista from PyPI.
"""

import csv
import pathlib
import subprocess
import xml.etree.ElementTree

import numpy as np
import pytest
import tomllib

vtk = pytest.importorskip("vtk")
from vtk.util.numpy_support import vtk_to_numpy  # noqa: E402

END = 0.01
# Single precision rounds a coordinate to 2^-24 of itself; the grid is a few metres wide.
SINGLE = 2.0**-23


class Results:
    """A results folder with what the tests ask of it."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.manifest = tomllib.loads((self.folder / "manifest.toml").read_text())
        self.bodies = [body["name"] for body in self.manifest["case"]["body"]]
        with open(self.folder / "history.csv", newline="") as stream:
            self.history = {float(row["time"]): {k: float(v) for k, v in row.items()} for row in csv.DictReader(stream)}

    def hdf(self, name):
        """All times of a VTKHDF file, as (time, data set)."""
        reader = vtk.vtkHDFReader()
        reader.SetFileName(str(self.folder / f"{name}.vtkhdf"))
        reader.UpdateInformation()
        keys = vtk.vtkStreamingDemandDrivenPipeline
        times = reader.GetOutputInformation(0).Get(keys.TIME_STEPS())
        for step, time in enumerate(times):
            reader.SetStep(step)
            reader.Update()
            copy = reader.GetOutputDataObject(0).NewInstance()
            copy.DeepCopy(reader.GetOutputDataObject(0))
            yield time, copy

    def series(self, name):
        """All times of a .pvd with its .vtu or .vti files, as (time, data set)."""
        for entry in xml.etree.ElementTree.parse(self.folder / f"{name}.pvd").iter("DataSet"):
            file = self.folder / entry.get("file")
            reader = vtk.vtkXMLImageDataReader() if file.suffix == ".vti" else vtk.vtkXMLUnstructuredGridReader()
            assert reader.CanReadFile(str(file))
            reader.SetFileName(str(file))
            reader.Update()
            yield float(entry.get("timestep")), reader.GetOutput()


def arrays(data_set):
    point_data = data_set.GetPointData()
    return {point_data.GetArrayName(i): vtk_to_numpy(point_data.GetArray(i)) for i in range(point_data.GetNumberOfArrays())}


def points(data_set):
    return vtk_to_numpy(data_set.GetPoints().GetData())


@pytest.fixture(scope="module")
def results(program, tmp_path_factory):
    folder = tmp_path_factory.mktemp("results") / "disks"
    sets = [
        f"time.end={END}",
        "output.fields_every=0.002",
        "output.history_every=0.001",
        "output.grid=true",
        "output.compression=1",
        'output.formats=["vtkhdf", "vtu"]',
    ]
    command = [program, "run", "disks", "--out", str(folder)]
    for assignment in sets:
        command += ["--set", assignment]
    run = subprocess.run(command, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return Results(folder)


def test_manifest_says_how_the_run_ended(results):
    assert results.manifest["status"] == "finished"
    assert results.manifest["case"]["time"]["end"] == END
    assert set(results.manifest["files"]) >= {"manifest.toml", "history.csv", "grid.vtkhdf"}


def test_vtkhdf_has_all_times_and_fields(results):
    assert len(results.bodies) == 2
    for body in results.bodies:
        steps = list(results.hdf(body))
        assert len(steps) == 6
        np.testing.assert_allclose([time for time, _ in steps], np.linspace(0, END, 6), atol=END / 20)  # on the nearest step
        for _, data_set in steps:
            n = data_set.GetNumberOfPoints()
            assert n > 0 and data_set.GetNumberOfCells() == n
            fields = arrays(data_set)
            shapes = {"velocity": (n, 3), "stress": (n, 6), "deformation_gradient": (n, 9), "von_mises": (n,), "pressure": (n,), "J": (n,)}
            assert {name: fields[name].shape for name in shapes} == shapes
            np.testing.assert_array_equal(fields["id"], np.arange(n))
            assert np.issubdtype(fields["id"].dtype, np.integer)


def test_fields_agree_with_the_history(results):
    for body in results.bodies:
        for time, data_set in results.hdf(body):
            row = results.history[time]  # both are written at the same steps, and times are stored in double precision
            x = points(data_set)
            for axis, name in enumerate("xy"):
                scale = SINGLE * float(np.abs(x).max())
                assert x[:, axis].min() == pytest.approx(row[f"{body}.lower_{name}"], abs=scale)
                assert x[:, axis].max() == pytest.approx(row[f"{body}.upper_{name}"], abs=scale)
            assert np.all(x[:, 2] == 0)
            fields = arrays(data_set)
            assert fields["von_mises"].max() == pytest.approx(row[f"{body}.von_mises_max"], rel=SINGLE, abs=1e-30)
            assert fields["J"].min() == pytest.approx(row[f"{body}.J_min"], rel=SINGLE)
            # Components in VTK's order: von Mises stress from XX YY ZZ XY YZ XZ; the cancellation in it costs a few digits.
            s = fields["stress"].astype(float)
            deviator = s[:, :3] - s[:, :3].mean(axis=1, keepdims=True)
            von_mises = np.sqrt(1.5 * (deviator**2).sum(axis=1) + 3 * (s[:, 3:] ** 2).sum(axis=1))
            np.testing.assert_allclose(von_mises, fields["von_mises"], rtol=10 * SINGLE, atol=10 * SINGLE * np.abs(s).max())


def test_vtu_series_equals_vtkhdf(results):
    for name in results.bodies + ["grid"]:
        old, new = list(results.series(name)), list(results.hdf(name))
        assert [time for time, _ in old] == [time for time, _ in new]
        for (_, a), (_, b) in zip(old, new):
            assert a.GetBounds() == b.GetBounds()
            assert arrays(a).keys() == arrays(b).keys()
            for field, values in arrays(a).items():
                np.testing.assert_array_equal(values, arrays(b)[field])
            if name != "grid":
                np.testing.assert_array_equal(points(a), points(b))


def test_grid_carries_the_mass_of_the_bodies(results):
    time, grid = list(results.hdf("grid"))[-1]
    case = results.manifest["case"]["grid"]
    cells = case.get("cells") or [round((high - low) / h) for low, high, h in zip(case["lower"], case["upper"], case["cell_size"] * 2)]
    assert grid.GetDimensions() == (cells[0] + 1, cells[1] + 1, 1)
    np.testing.assert_allclose(grid.GetBounds()[:4], [case["lower"][0], case["upper"][0], case["lower"][1], case["upper"][1]], rtol=1e-12)
    # Shape functions sum to 1. Every node's mass is rounded by half an ulp of single precision.
    assert arrays(grid)["mass"].sum(dtype=float) == pytest.approx(results.history[time]["mass"], rel=SINGLE)


def test_pyvista_reads_both_formats(results):
    pyvista = pytest.importorskip("pyvista")
    body = results.bodies[0]
    first = next(iter(results.hdf(body)))[1]
    mesh = pyvista.read(results.folder / f"{body}.vtkhdf")
    assert mesh.n_points == first.GetNumberOfPoints()
    assert "velocity" in mesh.point_data
    reader = pyvista.get_reader(results.folder / f"{body}.pvd")
    assert len(reader.time_values) == 6
    reader.set_active_time_point(5)
    last = reader.read()[0]
    np.testing.assert_array_equal(last.points, points(list(results.hdf(body))[-1][1]))


ELEMENTS = """
dim = {dim}
[grid]
lower = {lower}
upper = {upper}
cells = {cells}
[time]
end = 1
dt = 0.5
[solver]
type = "implicit"
basis = "element"
element_order = {order}
mode = "static"
[output]
precision = "double"
formats = ["vtkhdf", "vtu"]
fields_every = 0.5
[[body]]
name = "block"
method = "elements"
region = {{ type = "box", lower = {lower}, upper = {upper} }}
material = {{ type = "neo_hookean", density = 1, youngs_modulus = 1000, poissons_ratio = 0.3 }}
[[boundary]]
side = "left"
[[boundary]]
side = "bottom"
{more}
[[boundary]]
side = "right"
kind = "traction"
traction = {traction}
"""


@pytest.mark.parametrize(
    ("dim", "order", "cell_type"),
    [(2, 1, "VTK_QUAD"), (2, 2, "VTK_BIQUADRATIC_QUAD"), (3, 1, "VTK_HEXAHEDRON"), (3, 2, "VTK_TRIQUADRATIC_HEXAHEDRON")],
)
def test_a_body_of_elements_opens_as_its_cells(program, tmp_path, dim, order, cell_type):
    lower, upper, cells = [1.0, -2.0, 0.5][:dim], [3.0, -1.0, 2.0][:dim], [4, 3, 2][:dim]
    traction = [100.0, 0.0, 0.0][:dim]
    more = '[[boundary]]\nside = "front"\n' if dim == 3 else ""
    case = tmp_path / "block.toml"
    case.write_text(
        ELEMENTS.format(dim=dim, order=order, lower=lower, upper=upper, cells=cells, traction=traction, more=more), encoding="utf-8"
    )
    run = subprocess.run([program, "run", str(case), "--out", str(tmp_path / "out")], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    results = Results(tmp_path / "out")
    hdf, series = list(results.hdf("block")), list(results.series("block"))
    assert [time for time, _ in hdf] == [time for time, _ in series] == [0, 0.5, 1]
    size = (np.array(upper) - lower) / cells
    for (_, data), (_, same) in zip(hdf, series):
        assert data.GetNumberOfCells() == same.GetNumberOfCells() == np.prod(cells)
        fields = arrays(data)
        for name, values in arrays(same).items():
            np.testing.assert_array_equal(values, fields[name])
        start = points(data) - fields["displacement"]
        for k in range(data.GetNumberOfCells()):
            cell = data.GetCell(k)
            assert cell.GetCellType() == same.GetCell(k).GetCellType() == getattr(vtk, cell_type)
            ids = [cell.GetPointId(i) for i in range(cell.GetNumberOfPoints())]
            # Where VTK has the nodes of such a cell is where ours are, undeformed.
            parametric = np.array(cell.GetParametricCoords()).reshape(-1, 3)[: len(ids), :dim]
            local = start[ids][:, :dim]
            np.testing.assert_allclose(local, local.min(axis=0) + parametric * size, atol=1e-12)
    # Uniform stress at the end: the nodes have that of the Gauss points, and the traction is P_xx = J sigma_xx / F_xx.
    _, data = hdf[-1]
    fields = arrays(data)
    assert {"id", "mass", "volume"}.isdisjoint(fields)
    F_xx = fields["deformation_gradient"].reshape(-1, 9)[:, 0]
    np.testing.assert_allclose(fields["J"] * fields["stress"][:, 0] / F_xx, 100, rtol=1e-9)
    np.testing.assert_allclose(
        fields["displacement"][:, 0], (F_xx - 1) * (points(data) - fields["displacement"] - lower[0])[:, 0], atol=1e-10
    )
    # history.csv's greatest stress is that of the Gauss points.
    np.testing.assert_allclose(fields["von_mises"], results.history[1.0]["von_mises_max"], rtol=1e-9)
