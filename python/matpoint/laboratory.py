"""A material on its own: one point on a path of strains, or under stresses that are held, as in a laboratory."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from matpoint import _core
from matpoint.errors import shown
from matpoint.functions import FunctionLaw
from matpoint.history import History


class PointTest(History):
    """What a test of one point has measured: columns as arrays of shape (rows,). In a notebook it shows its curves."""

    def __repr__(self) -> str:
        return f"<point test: {len(self['time'])} rows, {len(self)} columns>"

    def _repr_png_(self) -> bytes:
        from matpoint import plot

        return plot.png_of(plot.point_test(self))


def point_test(
    material: Mapping[str, Any] | FunctionLaw | str,
    path: str,
    *,
    strain: float = 0.1,
    confining: float = 0.0,
    rate: float = 1.0,
    steps: int = 200,
    cycles: int = 3,
    times: npt.ArrayLike | None = None,
    deformation: npt.ArrayLike | None = None,
) -> PointTest:
    """Strains one point of a material, from rest, in 3D.

    Args:
        material: A material of a body, e.g. `mp.MohrCoulomb(...)`, a `FunctionLaw`, or the name of a parameter set ("copper_ofhc").
        path: What is driven and what is held. "uniaxial_strain" (an oedometer): ln F_xx, nothing else moves. "uniaxial_stress" and
            "triaxial": ln F_xx, stresses across are held at `-confining`. "triaxial_undrained": ln F_xx at constant volume. "biaxial":
            ln F_xx, F_zz stays, sigma_yy is held. "isotropic": ln J. "simple_shear": F_xy. "cyclic_shear": F_xy to `strain`, and then
            `cycles` times to `-strain` and back. "deformation": any F(t), given by `times` and `deformation`.
        strain: Where it ends [1]; tension positive, so that a soil is compressed with a negative number.
        confining: Pressure that the point is brought to first [Pa].
        rate: Strain per time [1/s].
        steps: Steps of the path, or of each part of "cyclic_shear".
        cycles: Of "cyclic_shear".
        times: Of "deformation": ascending [s], shape (n,).
        deformation: Of "deformation": the deformation gradients F at these times [1], shape (n, 3, 3), the first one the identity; linear
            between them, in `steps` steps each.

    Returns:
        A row for each step, from the end of the confinement on, where the strains of a law that flows are counted from: time [s], strain
        [1], Cauchy stress (stress_xx, stress_yy, ... [Pa]), p = -tr sigma/3, q (von Mises' stress), F_xx, F_xy, F_yy, F_zz, J, energy
        and dissipated [J/m^3 of reference volume], and what the law remembers (plastic_strain, ...).

    Raises:
        InputError: The material or a number is wrong.
        SolverError: No stretch holds the stress that is to be held; the point is turned inside out.

    Example:
        triaxial = mp.point_test(sand, "triaxial", strain=-0.1, confining=1e5)
        triaxial["q"] / triaxial["p"]
        mp.plot.point_test(triaxial)
    """
    if not isinstance(material, (FunctionLaw, str, Mapping)):
        raise _core.InputError(f"point_test: {shown(material)} is no material: give one of a body, a FunctionLaw, or a name")
    law = material.to_core() if isinstance(material, FunctionLaw) else material if isinstance(material, str) else dict(material)
    test: dict[str, Any] = {"path": path, "strain": strain, "confining": confining, "rate": rate, "steps": steps, "cycles": cycles}
    for name, numbers in (("times", times), ("deformation", deformation)):
        if numbers is None:
            continue
        try:
            test[name] = np.asarray(numbers, dtype=float).ravel().tolist()
        except (TypeError, ValueError, OverflowError):
            raise _core.InputError(f"point_test: {name} = {shown(numbers)} is not allowed: it must be numbers") from None
    names, units, table = _core.point_test(law, test)
    return PointTest({name: table[row] for row, name in enumerate(names)}, dict(zip(names, units)))
