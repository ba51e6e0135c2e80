"""A sand in a triaxial cell: the strength of a test, and the parameters that give it, in one call.

Source: Mohr & Coulomb: under the pressure p the axial stress at failure is Kp p + 2 c sqrt(Kp), Kp = tan^2(45 + phi/2).
Expected: the fitted angle and cohesion are those of the "measurement" within 1e-3.
Runs in about 2 s. On the command line: `matpoint test-material mohr_coulomb --path triaxial --confining 1e5 ...`.
"""

import matpoint as mp
import numpy as np

PRESSURES = (5e4, 1e5, 2e5)  # [Pa]


def sand(friction_angle: float, cohesion: float) -> mp.MohrCoulomb:
    """A sand that keeps its volume when it fails."""
    return mp.MohrCoulomb(density=1800, youngs_modulus=5e7, poissons_ratio=0.3, cohesion=cohesion, friction_angle=friction_angle)


def strengths(material: mp.MohrCoulomb) -> np.ndarray:
    """Axial stress at the end of tests under three pressures, compression positive [Pa]."""
    return np.array([-mp.point_test(material, "triaxial", strain=-0.1, confining=p)["stress_xx"][-1] for p in PRESSURES])


def calibrate(measured: np.ndarray) -> tuple[float, float]:
    """Angle [deg] and cohesion [Pa] whose tests have the measured strengths: Newton's method with differences."""
    guess = np.array([30.0, 1e4])
    for _ in range(6):
        now = strengths(sand(*guess))
        slopes = np.stack([(strengths(sand(*(guess + step))) - now) / step.sum() for step in (np.array([0.1, 0]), np.array([0, 100.0]))])
        guess = guess + np.linalg.lstsq(slopes.T, measured - now, rcond=None)[0]
    return float(guess[0]), float(guess[1])


def run() -> tuple[float, float]:
    """Fits the strengths of a sand of 34 degrees and 4 kPa."""
    ratio = np.tan(np.radians(45 + 34 / 2)) ** 2
    return calibrate(np.array([ratio * p + 2 * 4e3 * np.sqrt(ratio) for p in PRESSURES]))


def check(fitted: tuple[float, float]) -> None:
    """Compares with the numbers above."""
    assert abs(fitted[0] - 34) < 0.034
    assert abs(fitted[1] - 4e3) < 40


if __name__ == "__main__":
    import matplotlib.pyplot as plt

    angle, cohesion = run()
    check((angle, cohesion))
    print(f"friction_angle = {angle:.2f} deg, cohesion = {cohesion:.0f} Pa")
    figure, axis = plt.subplots(layout="constrained")
    for pressure in PRESSURES:
        test = mp.point_test(sand(angle, cohesion), "triaxial", strain=-0.1, confining=pressure)
        axis.plot(-100 * test["strain"], test["q"] / 1e3, label=f"{pressure / 1e3:.0f} kPa")
    axis.set(xlabel="axial strain [%]", ylabel="q [kPa]")
    axis.legend(title="confining pressure", frameon=False)
    figure.savefig("triaxial.png", dpi=150)
