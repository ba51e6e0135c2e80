"""The pictures: what they show, and what is said when they cannot be drawn. The results folders are made here, number by number."""

import os
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from matpoint import Results, ResultsError, plot

PYTHON_FOLDER = Path(__file__).resolve().parents[2] / "python"


def write_history(folder, dim, bodies, times):
    """Energies that trade places, with a sum of 10 J at all times, and momentum t in x."""
    columns = {"time": times, "step": np.arange(len(times)), "dt": np.full(len(times), 0.1)}
    columns["mass"] = np.ones_like(times)
    columns["kinetic_energy"] = 7 - times
    columns["strain_energy"] = 3 + 0.5 * times
    columns["gravitational_energy"] = -times
    columns["damping_dissipation"] = times
    columns["viscous_dissipation"] = 2 * times
    columns["boundary_work"] = 2 * times
    columns["removed_energy"] = 0.5 * times
    columns["transfer_loss"] = 0 * times
    for prefix in ["", *(f"{body}." for body in bodies)]:
        columns[f"{prefix}mass"] = np.ones_like(times)
        for d in "xyz"[:dim]:
            columns[f"{prefix}momentum_{d}"] = times if d == "x" else 0 * times
    rows = np.column_stack(list(columns.values()))
    text = "\n".join(",".join(map(repr, map(float, row))) for row in rows)
    (folder / "history.csv").write_text(",".join(columns) + "\n" + text + "\n")


def write_fields(path, positions, fields, times, sizes=None):
    """A temporal VTKHDF file; `sizes[k]` particles at the time k."""
    sizes = sizes or [len(positions)] * len(times)
    with h5py.File(path, "w") as file:
        root = file.create_group("VTKHDF")
        root["Points"] = np.concatenate([positions[:n] + 0.01 * k for k, n in enumerate(sizes)])
        root["NumberOfPoints"] = np.array(sizes)
        root["Types"] = np.ones(sum(sizes), dtype=np.uint8)
        root["Connectivity"] = np.concatenate([np.arange(n) for n in sizes])
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = len(times)
        steps["Values"] = times
        steps["PartOffsets"] = np.arange(len(times))
        steps["PointOffsets"] = np.cumsum([0, *sizes[:-1]])
        for name, values in fields.items():
            root[f"PointData/{name}"] = np.concatenate([values[:n] * (k + 1) for k, n in enumerate(sizes)])


def make_results(folder, dim=2, materials=None, times=(0.0, 0.5, 1.0), probes=()):
    """A folder like one that a run leaves."""
    materials = materials or {"lower": "youngs_modulus = 1e4", "upper": "youngs_modulus = 1e4"}
    folder.mkdir()
    body_tables = "".join(f'[[case.body]]\nname = "{name}"\nmaterial = {{ {keys} }}\n' for name, keys in materials.items())
    (folder / "manifest.toml").write_text(
        f'status = "finished"\ncase_name = "two"\n[units.fields]\nvon_mises = "Pa"\npressure = "Pa"\nvelocity = "m/s"\nstress = "Pa"\n'
        f'[case]\ntitle = "Two bodies"\ndim = {dim}\n[case.grid]\nlower = {[0.0] * dim}\nupper = {[1.0] * dim}\n{body_tables}'
    )
    times = np.array(times)
    write_history(folder, dim, materials, times)
    axis = (np.arange(5) + 0.5) / 20
    for number, name in enumerate(materials):
        grids = np.meshgrid(*[axis + 0.3 * number] * dim, indexing="ij")
        positions = np.zeros((5**dim, 3))
        positions[:, :dim] = np.stack(grids, axis=-1).reshape(-1, dim)
        fields = {
            "von_mises": 100 * positions[:, 0],
            "pressure": 100 * (positions[:, 1] - 0.3),
            "velocity": np.tile([3.0, 4.0, 0.0], (len(positions), 1)),
            "stress": np.tile(np.arange(6.0), (len(positions), 1)),
            "volume": np.full(len(positions), 0.05**dim),
        }
        write_fields(folder / f"{name}.vtkhdf", positions, fields, times)
    for probe in probes:
        keys = ["time", *(f"{q}_{d}" for q in ("position", "velocity") for d in "xyz"[:dim]), "stress_xx", "stress_yy"]
        rows = "\n".join(",".join(str(float(t + k)) for k in range(len(keys))) for t in times)
        (folder / f"probe_{probe}.csv").write_text(",".join(keys) + "\n" + rows + "\n")
    return folder


def run_plot(*arguments, **environment):
    return subprocess.run(
        [sys.executable, "-m", "matpoint.plot_command", *map(str, arguments)],
        env={**os.environ, "PYTHONPATH": str(PYTHON_FOLDER), **environment},
        capture_output=True,
        text=True,
        timeout=120,
    )


def curves(axes):
    return {line.get_label(): line.get_ydata() for line in axes.get_lines()}


def test_energies_show_each_part_and_a_total_that_balances(tmp_path):
    axes = plot.energies(Results(make_results(tmp_path / "r"))).axes[0]
    shown = curves(axes)
    times = np.array([0.0, 0.5, 1.0])
    # Exact in the file (shortest decimals), a handful of additions: a few eps of 10.
    np.testing.assert_allclose(shown["total"], 10, rtol=1e-14)
    np.testing.assert_allclose(shown["dissipated"], 3 * times, rtol=1e-14)
    np.testing.assert_array_equal(shown["kinetic"], 7 - times)
    assert set(shown) == {"kinetic", "strain", "gravitational", "dissipated", "work from outside", "removed", "total"}


SOLID = 'material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }'
SAND = 'material = { type = "mohr_coulomb", density = 1600, youngs_modulus = 1e6, poissons_ratio = 0.3, cohesion = 0, friction_angle = 30 }'
WATER = 'material = { type = "newtonian_fluid", density = 1000, pressure_scale = 1e4, viscosity = 1 }'


@pytest.mark.parametrize(
    ("material", "extra", "columns"),
    [
        (SAND, "", ["plastic_dissipation"]),
        (SOLID, '[solver]\ncontact = "pairs"\nfriction = 0.3\n', ["contact_dissipation", "contact_energy"]),
        (SOLID, "[solver]\ndamping = 2.0\n", ["damping_dissipation"]),
        (WATER, "", ["filter_dissipation", "viscous_dissipation"]),
        (SOLID, '[solver]\ntype = "implicit"\n', ["reset_loss"]),
    ],
)
def test_total_energy_is_constant_but_for_the_transfers(material, extra, columns, program, tmp_path):
    (tmp_path / "case.toml").write_text(f"""
gravity = [0, -9.81]
{extra}
[grid]
upper = [1, 1]
cells = [10, 10]
[time]
end = 0.3
{"dt = 0.01" if "implicit" in extra else ""}
[[body]]
name = "a"
region = {{ type = "box", lower = [0.2, 0.1], upper = [0.6, 0.3] }}
layout = {{ type = "per_cell", count = 4 }}
{material}
[[body]]
name = "b"
region = {{ type = "box", lower = [0.3, 0.4], upper = [0.5, 0.6] }}
layout = {{ type = "per_cell", count = 4 }}
velocity = [0.5, -1]
{material}
[[boundary]]
side = "bottom"
kind = "fixed"
[[boundary]]
side = "left"
kind = "slip"
[[boundary]]
side = "right"
kind = "slip"
""")
    done = subprocess.run([program, "run", "case.toml", "--out", "r"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    history = Results(tmp_path / "r").history
    for name in columns:
        assert np.any(history[name] != 0), name
    closed = plot.total_energy(history) + history["transfer_loss"]
    np.testing.assert_allclose(closed, closed[0], rtol=0, atol=1e-9 * np.abs(closed[0]))


def test_energies_leave_out_what_is_zero_throughout(tmp_path):
    results = Results(make_results(tmp_path / "r"))
    results.history["gravitational_energy"] = np.zeros(3)
    assert "gravitational" not in curves(plot.energies(results).axes[0])


@pytest.mark.parametrize("dim", [2, 3])
def test_momentum_has_a_panel_per_direction_and_a_line_per_body(tmp_path, dim):
    figure = plot.momentum(Results(make_results(tmp_path / "r", dim)))
    assert len(figure.axes) == dim
    assert set(curves(figure.axes[0])) == {"lower", "upper", "total"}
    np.testing.assert_array_equal(curves(figure.axes[0])["total"], [0, 0.5, 1])


@pytest.mark.parametrize("dim", [2, 3])
def test_all_pictures_are_written_and_have_ink(tmp_path, dim):
    folder = make_results(tmp_path / "r", dim, probes=["tip"])
    done = run_plot(folder)
    assert done.returncode == 0, done.stderr
    names = ["energies.png", "momentum.png", "particles_von_mises.png", "probes.png"]
    assert done.stdout.split() == [str(folder / name) for name in names]
    for name in names:
        pixels = plot.plt.imread(folder / name)
        assert min(pixels.shape[:2]) > 300
        assert np.std(pixels[..., :3]) > 0.01, f"{name} is blank"


def test_particles_stand_where_the_file_has_them_with_its_values(tmp_path):
    results = Results(make_results(tmp_path / "r"))
    figure = plot.particles(results, "von_mises", [1.0])
    scatters = figure.axes[0].collections
    assert len(scatters) == 2
    for scatter, body in zip(scatters, results.bodies.values()):
        np.testing.assert_array_equal(scatter.get_offsets(), body.positions(2)[:, :2])
        np.testing.assert_array_equal(scatter.get_array(), body.field("von_mises", 2))
    assert scatters[0].norm.vmin == scatters[1].norm.vmin and scatters[0].norm.vmax == scatters[1].norm.vmax
    assert figure.axes[0].get_title() == "t = 1 s"
    assert figure.axes[-1].get_ylabel() == "von_mises [Pa]"


def test_particles_have_their_size_in_the_picture(tmp_path):
    figure = plot.particles(Results(make_results(tmp_path / "r")), "von_mises", [0.0])
    axes = figure.axes[0]
    scale = axes.transData.transform([[0, 0], [0.05, 0]])
    edge = (scale[1, 0] - scale[0, 0]) * 72 / figure.dpi
    # 2 % larger, so that no seams show between neighbours; the layout moves by less than a percent when it is drawn again.
    assert np.sqrt(axes.collections[0].get_sizes()[0]) == pytest.approx(1.02 * edge, rel=0.02)


def test_default_is_von_mises_for_solids_and_pressure_for_fluids(tmp_path):
    solid, fluid = "youngs_modulus = 1e4", "viscosity = 0.5"
    for materials, expected in [
        ({"a": solid}, ["von_mises"]),
        ({"a": fluid}, ["pressure"]),
        ({"a": solid, "b": fluid}, ["von_mises", "pressure"]),
    ]:
        folder = make_results(tmp_path / "_".join(expected), materials=materials)
        assert plot.default_fields(list(Results(folder).bodies.values())) == expected


def test_times_default_to_six_and_take_the_nearest(tmp_path):
    results = Results(make_results(tmp_path / "r", times=np.linspace(0, 1, 51)))
    bodies = list(results.bodies.values())
    assert plot.choose_times(bodies, None) == [0, 10, 20, 30, 40, 50]
    assert plot.choose_times(bodies, [0.5001, 0.099]) == [5, 25]
    with pytest.raises(ResultsError, match="time 2 s was not written: the fields cover 0 to 1 s"):
        plot.choose_times(bodies, [2.0])


def test_a_number_of_particles_that_changes_is_followed(tmp_path):
    folder = make_results(tmp_path / "r", materials={"a": "viscosity = 1"})
    positions = np.zeros((10, 3))
    positions[:, 0] = np.arange(10)
    write_fields(folder / "a.vtkhdf", positions, {"pressure": np.arange(10.0)}, [0.0, 0.5, 1.0], sizes=[10, 7, 0])
    body = Results(folder).bodies["a"]
    assert [len(body.positions(k)) for k in range(3)] == [10, 7, 0]
    np.testing.assert_array_equal(body.field("pressure", 1), 2 * np.arange(7.0))
    assert run_plot(folder).returncode == 0


def test_components_and_magnitudes(tmp_path):
    body = Results(make_results(tmp_path / "r")).bodies["lower"]
    np.testing.assert_allclose(body.scalar("velocity", 0), 5, rtol=1e-15)
    np.testing.assert_array_equal(body.scalar("velocity_y", 0), 4)
    np.testing.assert_array_equal(body.scalar("stress_xy", 0), 3)
    with pytest.raises(ResultsError, match="stress_xx, stress_yy"):
        body.scalar("stress", 0)
    with pytest.raises(ResultsError, match='no component "w", it has: x, y, z'):
        body.scalar("velocity_w", 0)


def test_projection_to_the_picture_keeps_lengths_of_the_isometric_view():
    # All three edges of a cube appear with the same length sqrt(2/3), and y points up.
    edges = plot.project(np.eye(3), 3)
    np.testing.assert_allclose(np.linalg.norm(edges, axis=1), np.sqrt(2 / 3), rtol=1e-15)
    np.testing.assert_allclose(edges[1], [0, np.sqrt(2 / 3)], atol=1e-15)


def test_color_scale_is_symmetric_for_both_signs_and_ignores_a_few_outliers():
    norm, _, _ = plot.color_scale(np.linspace(-2, 1, 1001))
    assert norm.vmin == -norm.vmax and 1.9 < norm.vmax <= 2
    norm, _, extend = plot.color_scale(np.append(np.linspace(0, 1, 1000), 1e6))
    assert norm.vmax < 1.1 and extend == "max"
    norm, _, _ = plot.color_scale(np.zeros(5))
    assert norm.vmin < norm.vmax


def test_a_history_row_that_was_cut_short_is_left_out(tmp_path):
    folder = make_results(tmp_path / "r")
    with open(folder / "history.csv", "a") as file:
        file.write("1.5,3,0.")
    assert len(Results(folder).history["time"]) == 3


def test_wrong_folders_are_refused_in_words(tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").write_text("")
    for name, message in [
        ("nowhere", "is no results folder: there is no such folder"),
        ("empty", "is no results folder: it has no manifest.toml"),
        ("file", "is no results folder: it is not a folder"),
    ]:
        done = run_plot(tmp_path / name)
        assert done.returncode == 2
        assert done.stderr.startswith("error: ") and message in done.stderr
        assert "Traceback" not in done.stderr


def test_damaged_files_are_refused_in_words(tmp_path):
    folder = make_results(tmp_path / "r")
    (folder / "lower.vtkhdf").write_bytes(b"noise" * 100)
    done = run_plot(folder)
    assert done.returncode == 2 and "is not a VTKHDF file of matpoint" in done.stderr
    (folder / "manifest.toml").write_text("= nonsense")
    done = run_plot(folder)
    assert done.returncode == 2 and "is not a manifest of matpoint" in done.stderr


def test_unknown_field_and_time_are_refused_with_what_there_is(tmp_path):
    folder = make_results(tmp_path / "r")
    done = run_plot(folder, "--field", "von_misses")
    assert done.returncode == 2
    assert 'has no field "von_misses", it has: pressure, ' in done.stderr and 'did you mean "von_mises"?' in done.stderr
    done = run_plot(folder, "--times", "9")
    assert done.returncode == 2 and "time 9 s was not written" in done.stderr
    done = run_plot(folder, "--times", "soon")
    assert done.returncode == 2 and "give numbers with commas between" in done.stderr


def test_results_without_vtkhdf_still_give_the_histories(tmp_path):
    folder = make_results(tmp_path / "r")
    for file in folder.glob("*.vtkhdf"):
        file.unlink()
    done = run_plot(folder)
    assert done.returncode == 0 and done.stdout.split() == [str(folder / "energies.png"), str(folder / "momentum.png")]
    done = run_plot(folder, "--field", "pressure")
    assert done.returncode == 2 and 'output.formats must contain "vtkhdf"' in done.stderr


@pytest.mark.parametrize("package", ["matplotlib", "h5py", "numpy"])
def test_a_missing_package_is_named(tmp_path, package):
    (tmp_path / f"{package}.py").write_text(f"raise ImportError(\"No module named '{package}'\")")
    done = run_plot(tmp_path, PYTHONPATH=f"{tmp_path}{os.pathsep}{PYTHON_FOLDER}")
    assert done.returncode == 2
    assert f"No module named '{package}'" in done.stderr and "set MATPOINT_PYTHON" in done.stderr
    assert "Traceback" not in done.stderr
