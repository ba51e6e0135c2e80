"""The program behind `matpoint plot DIR`, `python -m matpoint.plot_command DIR`: draws the pictures of a results folder into it.

    energies.png            energies of the whole system over time
    momentum.png            momentum over time, per body and in total
    particles_<field>.png   all particles coloured by a field at a few times
    probes.png              motion and stress of the probes' particles, when there are probes

Of a table that `matpoint test-material` has written, `triaxial.csv`, it draws the curves beside it, `triaxial.png`.

Exit code 2 when DIR is no results folder, a field or time does not exist, or a Python package is missing.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

try:
    import h5py  # noqa: F401  (results.py reads with it; its absence shall be said here, in words)
    import matplotlib
    import numpy as np  # noqa: F401
except ImportError as missing:
    print(
        f"error: {missing}: pictures need the Python packages numpy, matplotlib and h5py; this is {sys.executable}. Install them "
        "there, or set MATPOINT_PYTHON to a Python that has them",
        file=sys.stderr,
    )
    sys.exit(2)
matplotlib.use("Agg")
import matplotlib.pyplot as plt

from matpoint import plot
from matpoint.errors import ResultsError
from matpoint.results import Results, read_table
from matpoint.scene import default_fields


def draw_all(results: Results, fields: list[str] | None, times: list[float] | None) -> list[Path]:
    """Writes all pictures into the folder. Returns their paths. Raises ResultsError."""
    figures = {}
    with plt.rc_context(plot.STYLE):
        if len(results.history.get("time", [])) > 1:
            figures["energies"] = plot.energies(results)
            figures["momentum"] = plot.momentum(results)
        bodies = list(results.bodies.values())
        if bodies:
            for name in fields or default_fields(bodies):
                figures[f"particles_{name}"] = plot.particles(results, name, times)
        elif fields or times:
            raise ResultsError(f'"{results.folder}" holds no .vtkhdf file: the case\'s output.formats must contain "vtkhdf"')
        if any(len(table["time"]) > 1 for table in results.probes.values()):
            figures["probes"] = plot.probes(results)
        paths = []
        for name, figure in figures.items():
            paths.append(results.folder / f"{name}.png")
            figure.savefig(paths[-1])
            plt.close(figure)
    return paths


def draw_point_test(table: Path) -> Path:
    """Writes the curves of a test of one point beside its table. Returns their path. Raises ResultsError."""
    columns = read_table(table)
    missing = [name for name in ("strain", "p", "q", "J", "F_xy", "stress_xy", "energy", "dissipated") if name not in columns]
    if missing:
        raise ResultsError(f'"{table}" is no table of matpoint test-material: it has no column "{missing[0]}"')
    figure = plot.point_test(columns, table.stem)
    path = table.with_suffix(".png")
    figure.savefig(path)
    plt.close(figure)
    return path


def read_times(texts: list[str] | None) -> list[float] | None:
    """Numbers of `--times 0,0.5,1`. Raises ResultsError."""
    if texts is None:
        return None
    try:
        return [float(word) for text in texts for word in text.split(",")]
    except ValueError as error:
        raise ResultsError(f"--times {' '.join(texts)}: {error}; give numbers with commas between, e.g. 0,0.5,1") from error


def main(arguments: list[str] | None = None) -> int:
    """The command line; returns the exit code."""
    parser = argparse.ArgumentParser(prog="matpoint plot", description="Draw pictures of a results folder into it.")
    parser.add_argument("folder", metavar="DIR", help="the results folder, or a table of matpoint test-material")
    parser.add_argument("--field", action="append", metavar="NAME", help="field that colours the particles; may be repeated")
    parser.add_argument("--times", action="append", metavar="T,T,...", help="times [s] of the pictures; default: six")
    options = parser.parse_args(arguments)
    try:
        if options.folder.endswith(".csv") and Path(options.folder).is_file():
            if options.field or options.times:
                raise ResultsError("--field and --times are for a results folder")
            print(draw_point_test(Path(options.folder)))
            return 0
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
