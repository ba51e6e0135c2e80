"""One point of a material on a path: mp.point_test and `matpoint test-material`."""

import matpoint as mp
import numpy as np
import pytest

SOIL = dict(density=1800, youngs_modulus=1e7, poissons_ratio=0.3, cohesion=1e4, friction_angle=30)


def test_triaxial_strength_is_that_of_mohr_and_coulomb():
    soil = mp.MohrCoulomb(**SOIL)
    push = mp.point_test(soil, "triaxial", strain=-0.2, confining=5e4)
    # Kp p + 2 c sqrt(Kp), of Kirchhoff's stress: J is 0.995.
    assert abs(-push["stress_xx"][-1] * push["J"][-1] / (3 * 5e4 * push["J"][-1] + 2e4 * np.sqrt(3)) - 1) < 1e-6
    assert np.allclose(push["stress_yy"], -5e4) and np.allclose(push["stress_zz"], -5e4)
    assert push["plastic_strain"][-1] > 0.15 and (np.diff(push["dissipated"]) > -1e-9).all()
    pull = mp.point_test(soil, "triaxial", strain=0.2, confining=5e4)
    assert abs(-pull["stress_xx"][-1] - 5119.661) < 60
    assert push.units["q"] == "Pa" and len(push["q"]) == 201


def test_soil_that_softens_keeps_its_residual_strength_and_its_curves_show_it():
    test = mp.point_test(
        mp.MohrCoulomb(
            **SOIL,
            dilatancy_angle=10.0,
            residual_friction_angle=25.0,
            residual_cohesion=0.0,
            residual_dilatancy_angle=0.0,
            softening_slip=0.02,
            length=0.1,
        ),
        "triaxial",
        strain=-0.4,
        confining=5e4,
        steps=1000,
    )
    peak, residual = (np.tan(np.radians(45 + phi / 2)) ** 2 for phi in (30, 25))
    assert abs(test["q"].max() / ((peak - 1) * 5e4 + 2e4 * np.sqrt(peak)) - 1) < 0.02
    assert abs(test["q"][-1] / ((residual - 1) * 5e4) - 1) < 1e-6
    with pytest.raises(mp.InputError, match="needs `length`"):
        mp.point_test(mp.MohrCoulomb(**SOIL, residual_cohesion=0.0, softening_slip=0.02), "triaxial")
    figure = mp.plot.point_test(test, "sand")
    curves = [line for axes in figure.axes for line in axes.lines]
    np.testing.assert_array_equal(curves[0].get_ydata(), test["q"])
    assert [axes.get_ylabel() for axes in figure.axes] == ["q [Pa]", "q [Pa]", "volume strain ln J [1]", "energy [J/m^3]"]
    assert test._repr_png_().startswith(b"\x89PNG") and "401" not in repr(test) and "1001 rows" in repr(test)
    shear = mp.plot.point_test(mp.point_test("copper_linear", "simple_shear"))
    assert shear.axes[0].get_ylabel() == "shear stress xy [Pa]"


def test_cycles_and_functions():
    steel = mp.J2(density=7800, youngs_modulus=1e9, poissons_ratio=0.3, yield_stress=3e7)
    cyclic = mp.point_test(steel, "cyclic_shear", strain=0.1, cycles=2, steps=50)
    assert len(cyclic["strain"]) == 1 + 5 * 50
    assert abs(cyclic["stress_xy"].max() / (3e7 / np.sqrt(3)) - 1) < 1e-3
    law = mp.FunctionLaw(lambda F, L, dt, history: (1e5 * (F @ np.swapaxes(F, 1, 2) - np.eye(3)), history), density=1000, wave_speed=20)
    stretched = mp.point_test(law, "uniaxial_strain", strain=0.1)
    assert abs(stretched["stress_xx"][-1] - 1e5 * (np.exp(0.2) - 1) / np.exp(0.1)) < 1e-6


def test_what_is_wrong_is_said():
    soil = mp.MohrCoulomb(**SOIL)
    with pytest.raises(mp.InputError, match='path = "traxial" is unknown.*did you mean "triaxial"'):
        mp.point_test(soil, "traxial")
    with pytest.raises(mp.InputError, match="confining = -1 is not allowed, it must be >= 0"):
        mp.point_test(soil, "triaxial", confining=-1.0)
    soft = mp.FunctionLaw(lambda F, L, dt, history: (np.zeros_like(F), history), density=1000, wave_speed=20)
    with pytest.raises(mp.SolverError, match="no stretch holds the stress: 500 Pa are left"):
        mp.point_test(soft, "triaxial", confining=1e4)
    with pytest.raises(mp.InputError, match="dilatancy_angle = 40 is above friction_angle = 30"):
        mp.point_test(mp.MohrCoulomb(**SOIL, dilatancy_angle=40.0), "triaxial")


def test_the_command_writes_the_same_table(matpoint, tmp_path):
    words = [word for key, value in SOIL.items() for word in ("--set", f"{key}={value}")]
    done = matpoint(
        "test-material", "mohr_coulomb", *words, "--path", "triaxial", "--confining", "5e4", "--strain", "-0.2", "--out", "t.csv"
    )
    assert done.returncode == 0 and "201 rows in t.csv" in done.stdout, done.stderr
    table = np.genfromtxt(tmp_path / "t.csv", delimiter=",", names=True)
    same = mp.point_test(mp.MohrCoulomb(**SOIL), "triaxial", strain=-0.2, confining=5e4)
    for name in same:
        assert np.array_equal(table[name], same[name]), name
    assert done.stdout.splitlines()[-1].endswith(" plot t.csv")
    drawn = matpoint("plot", "t.csv")
    assert drawn.returncode == 0 and drawn.stdout == "t.png\n", drawn.stderr
    assert (tmp_path / "t.png").read_bytes().startswith(b"\x89PNG")
    (tmp_path / "other.csv").write_text("a,b\n1,2\n")
    for words, text in ((["other.csv"], 'it has no column "strain"'), (["t.csv", "--field", "velocity"], "are for a results folder")):
        wrong = matpoint("plot", *words)
        assert wrong.returncode == 2 and text in wrong.stderr and wrong.stderr.count("\n") == 1, wrong.stderr
    of_case = matpoint("test-material", "granular_column", "--path", "simple_shear", "--steps", "3")
    assert of_case.returncode == 0 and of_case.stdout.count("\n") == 5
    for words, text in (
        (["mohr_coulomb", "--path", "triaxial"], "density is missing"),
        (["granular_column", "--path", "triaxial", "--body", "rod"], 'did you mean "rods"'),
        (["granular_column", "--path", "triaxal"], 'did you mean "triaxial"'),
        (["granular_columns", "--path", "triaxial"], "granular_column"),
        (["granular_column"], "--path"),
    ):
        wrong = matpoint("test-material", *words)
        assert wrong.returncode == 2 and text in wrong.stderr and wrong.stderr.count("\n") == 1, wrong.stderr


def test_any_deformation_is_followed_and_a_name_is_a_material():
    """Shear given as F(t) is simple_shear; a turn in between changes nothing but the directions."""
    gamma = np.linspace(0, 0.4, 21)
    F = np.tile(np.eye(3), (len(gamma), 1, 1))
    F[:, 0, 1] = gamma
    given = mp.point_test("copper_linear", "deformation", times=gamma / 2, deformation=F, steps=10)
    driven = mp.point_test("copper_linear", "simple_shear", strain=0.4, rate=2.0, steps=200)
    np.testing.assert_allclose(given["stress_xy"], driven["stress_xy"], rtol=1e-9, atol=1)
    np.testing.assert_allclose(given["time"], driven["time"], atol=1e-12)
    hot = mp.point_test("copper_ofhc", "uniaxial_stress", strain=0.3, rate=1e3)
    assert hot["temperature"][0] == 298 and 310 < hot["temperature"][-1] < 330
    for wrong, text in (
        ({"times": [0, 1], "deformation": F[:1]}, "two times or more, and 9 numbers of deformation for each; got 2 times and 9 numbers"),
        ({"times": [0, 0], "deformation": F[:2]}, "times must ascend"),
        ({"times": [0, 1], "deformation": 2 * F[:2]}, "the first deformation must be the identity"),
    ):
        with pytest.raises(mp.InputError, match=text):
            mp.point_test("copper_linear", "deformation", **wrong)
    with pytest.raises(mp.InputError, match='did you mean "copper_ofhc"'):
        mp.point_test("coper_ofhc", "isotropic")
