"""What the package promises about itself: docstrings, types, style, examples."""

import importlib.util
import inspect
import re
import subprocess
import sys
from pathlib import Path

import matpoint as mp
import numpy as np
import pytest
from conftest import PACKAGE, ROOT
from matpoint._core import vocabulary

EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
SHIPPED = [path for path in EXAMPLES if path.stem in mp.shipped_cases()]


def public_members():
    """(name, object) of everything public: the package's names, the members of its classes, the functions of its modules."""
    for name in mp.__all__:
        value = getattr(mp, name)
        yield name, value
        if inspect.isclass(value):
            for member, described in vars(value).items():
                if not member.startswith("_") and (callable(described) or isinstance(described, property | classmethod)):
                    yield f"{name}.{member}", described
        if inspect.ismodule(value):
            for member in value.__all__:
                yield f"{name}.{member}", getattr(value, member)


MEMBERS = dict(public_members())


@pytest.mark.parametrize("name", MEMBERS)
def test_every_public_name_has_a_docstring_with_parameters_shapes_units_and_errors(name):
    described = MEMBERS[name]
    text = inspect.getdoc(described)
    assert text and len(text) > 10, f"{name} has no docstring"
    function = described.__func__ if isinstance(described, classmethod) else described
    if not inspect.isfunction(function):
        return
    parameters = [p for p in inspect.signature(function).parameters if p not in ("self", "cls")]
    if len(parameters) > 1:
        assert "Args:" in text and all(f"{p}:" in text for p in parameters), f"{name}: not all of {parameters} are described"
    if "raise " in inspect.getsource(function):
        assert "Raises" in text, f"{name} raises, and its docstring does not say so"


@pytest.mark.parametrize("name", ["position", "velocity", "stress", "deformation_gradient", "von_mises", "mass", "volume"])
def test_fields_say_their_shape_and_unit(name):
    text = getattr(mp.BodyState, name).__doc__
    assert "shape (n" in text and "[" in text


def test_every_part_describes_its_parameters():
    for name in [n for n in mp.__all__ if inspect.isclass(getattr(mp, n))]:
        part = getattr(mp, name)
        if issubclass(part, mp.Part) and part is not mp.Part:
            assert all(f"    {p}: " in part.__doc__ for p in part._parameters), name


@pytest.mark.parametrize("law", [entry["name"] for entry in vocabulary()["materials"]])
def test_every_law_names_its_source(law):
    described = getattr(mp, "".join(word.capitalize() for word in law.split("_"))).__doc__
    assert re.search(r"\([A-Z].* \d{4}", described), described


def test_types_are_strict():
    checked = subprocess.run([sys.executable, "-m", "mypy", str(PACKAGE / "matpoint")], cwd=ROOT, capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout[-3000:]


def test_a_users_script_is_typed(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import matpoint as mp\n"
        "case = mp.Case('a', grid=mp.Grid(upper=(1, 1), cells=(2, 2)))\n"
        "simulation: mp.Simulation = case.build()\n"
        "simulation.bodies['a'].velocity = [0.0, 1.0]\n"
        "reveal_type(simulation.time)\n"
        "mp.Box(lower=(0, 0))\n"
    )
    checked = subprocess.run([sys.executable, "-m", "mypy", "--strict", str(script)], cwd=tmp_path, capture_output=True, text=True)
    assert 'Revealed type is "builtins.float"' in checked.stdout or 'Revealed type is "float"' in checked.stdout
    assert 'Missing named argument "upper" for "Box"' in checked.stdout
    assert "Found 1 error" in checked.stdout, checked.stdout[-3000:]


def test_style_is_clean():
    for words in (["check", "-q"], ["format", "--check", "-q"]):
        checked = subprocess.run(
            [sys.executable, "-m", "ruff", *words, "python", "examples", "tests/python"], cwd=ROOT, capture_output=True, text=True
        )
        assert checked.returncode == 0, checked.stdout[-3000:]


def test_the_documentation_builds_as_a_site_without_warnings(tmp_path):
    words = ["-q", "-W", "--keep-going", "-b", "html", "-d", str(tmp_path / "doctrees"), str(ROOT / "docs"), str(tmp_path / "site")]
    built = subprocess.run([sys.executable, "-m", "sphinx", *words], capture_output=True, text=True)
    assert built.returncode == 0, built.stderr[-3000:]
    api = (tmp_path / "site/api.html").read_text()
    assert all(f'id="matpoint.{name}"' in api for name in ("Case", "Simulation", "BodyState.velocity", "plot.profile"))
    assert "matpoint.parts.NeoHookean" in api


def test_the_implicit_tutorial_runs_and_its_numbers_hold(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs/tutorial_implicit.md").read_text()
    file, swing = re.findall(r"^```toml\n(.*?)^```", page, re.M | re.S)
    Path("sag.toml").write_text(file)
    sagging = mp.Case.from_toml("sag.toml").build()
    start = sagging.bodies["beam"].position
    tip = int(np.argmin(np.linalg.norm(start - (0.625, 0), axis=1)))
    sagging.run()
    assert abs(sagging.bodies["beam"].position[tip, 1] - start[tip, 1] + 0.192) < 0.002
    assert sagging.history["newton_iterations"][1:].max() <= 6
    free = mp.Case.from_toml("sag.toml")
    free.boundary = []
    with pytest.raises(mp.InputError, match="nothing holds the body"):
        free.build()
    changes = [line.split("#")[0].strip() for line in swing.splitlines()]
    assert changes[:2] == ["gravity_times = [0.39, 0.4]", "gravity_factors = [1, 0]"]
    moving = mp.Case.from_toml(
        "sag.toml", ["gravity_times=[0.39,0.4]", "gravity_factors=[1,0]", "time.end=2", "time.dt=0.008", "solver.mode=dynamic"]
    )
    swinging = moving.build()
    swinging.run(until=0.368)
    assert abs(swinging.bodies["beam"].position[tip, 1] - start[tip, 1] + 0.37) < 0.01
    names = {}
    exec(re.findall(r"^```python\n(.*?)^```", page, re.M | re.S)[0], names)  # noqa: S102
    assert names["simulation"].bodies["beam"].position[:, 1].min() > -0.26


def test_the_tutorial_runs_and_its_numbers_hold(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / "docs/tutorial.md").read_text(), re.M | re.S)
    names = {}
    for block in blocks:
        exec(block, names)  # noqa: S102
    history = names["simulation"].history
    assert abs(history["kinetic_energy"].max() - 2.5132741) < 1e-6
    assert abs(-history["lower.momentum_x"][-1] / history["lower.momentum_x"][0] - 0.969) < 1e-3
    assert abs(history["momentum_x"]).max() < 1e-12
    assert 0.002 < names["again"].history["transfer_loss"][-1] / history["transfer_loss"][-1] < 0.02
    assert (tmp_path / "disks.png").stat().st_size > 10_000
    assert names["case"].check().particles == {"lower": 316, "upper": 316}


def test_the_coupling_tutorial_runs_and_its_numbers_hold(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / "docs/tutorial_coupling.md").read_text(), re.M | re.S)
    names = {}
    for block in blocks[:2]:
        exec(block, names)  # noqa: S102
    assert abs(names["sagging"].bodies["shelf"].node_field("displacement")[:, 1].min() + 0.0075) < 1e-4
    assert abs(names["speed"].min() + 1.47) < 0.01 and abs(names["speed"].max() - 1.22) < 0.01
    assert names["history"]["penetrated_particles"].max() == 0
    assert (tmp_path / "drop.png").stat().st_size > 10_000
    tuned = names["drop"](0.2).history
    assert abs(tuned["disk.momentum_y"].max() / tuned["disk.mass"][0] - 1.37) < 0.01
    assert abs(tuned["receding_work"][-1] - 6.7) < 0.1
    assert abs(tuned["kinetic_energy"].max() - 51) < 2
    names["shelf"].region = mp.Box(lower=(0, 0), upper=(1, 0.12))
    with pytest.raises(mp.InputError, match="its region cuts the cell around"):
        names["drop"](0)


def load(path: Path):
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def in_examples(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "examples"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_example_runs_and_its_numbers_hold(path, in_examples):
    module = load(path)
    module.check(module.run())


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_example_opens_with_source_number_and_run_time(path):
    text = path.read_text()
    assert len(text.splitlines()) <= 120
    opening = text.split('"""')[1]
    assert all(word in opening for word in ("Source: ", "Expected: ", "Runs in about "))


def test_there_is_an_example_for_each_shipped_case():
    assert {path.stem for path in SHIPPED} == set(mp.shipped_cases())


@pytest.mark.parametrize("path", SHIPPED, ids=lambda p: p.stem)
def test_example_says_what_the_case_file_says(path, in_examples):
    assert load(path).case().resolved() == mp.Case.from_toml(path.stem).resolved()
