"""Makes runs fail at each of their calls that change files, and looks at what is left.

    scripts/faults                      all kinds at all calls of all runs (half an hour)
    scripts/faults --every 20           at each 20th call
    scripts/faults kill power --runs explicit implicit

A run that was killed must leave files that every reader opens (h5py, VTK, ours), with the times that were complete and nothing else, and
end with the files of an uninterrupted run when it is continued. A run whose call failed must say so, or have right files.
"""

from __future__ import annotations

import argparse
import csv
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

HERE = Path(__file__).resolve().parent
BLOCK = """
gravity = [0, -9.81]
[grid]
upper = [1, 1]
cells = [10, 10]
[time]
end = 0.2
[[body]]
name = "block"
region = { type = "box", lower = [0.3, 0.1], upper = [0.5, 0.3] }
layout = { type = "per_cell", count = 4 }
material = { type = "neo_hookean", density = 1000, youngs_modulus = 1e5, poissons_ratio = 0.3 }
[[boundary]]
side = "bottom"
kind = "fixed"
[[probe]]
name = "one"
body = "block"
particle = 1
"""
LINEAR = BLOCK + '[solver]\nshape = "linear"\n'
# Name -> case, options.
RUNS = {
    "explicit": (BLOCK + "[output]\nfields_every = 0.01\nhistory_every = 0.005\n", []),
    "compressed": (LINEAR + "[output]\nfields_every = 0.01\nhistory_every = 0.005\ncompression = 2\ngrid = true\n", []),
    "vtu": (BLOCK + '[output]\nfields_every = 0.01\nhistory_every = 0.005\nformats = ["vtu"]\n', ["--checkpoint-time", "0.04"]),
    "implicit": (
        BLOCK.replace("end = 0.2", "end = 0.08\ndt = 0.002")
        + '[solver]\ntype = "implicit"\n[output]\nfields_every = 0.004\nhistory_every = 0.002\n',
        ["--checkpoint-steps", "8"],
    ),
    "times": (BLOCK + "[output]\nfields_every = 0.0028\nhistory_every = 0.0028\n", ["--checkpoint-steps", "20"]),
}
KINDS = ("kill", "power", "eio", "enospc", "short", "eintr")


def build(folder: Path) -> Path:
    """The library to preload."""
    library = folder / "faults.so"
    compiler = os.environ.get("CC", "cc")
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", library, HERE / "faults_preload.c", "-ldl", "-lpthread"], check=True)
    return library


def read_hdf(path: Path) -> list[tuple[float, dict[str, bytes]]]:
    """Times and arrays of a VTKHDF file, by h5py."""
    with h5py.File(path) as file:
        root = file["VTKHDF"]
        count = int(root["Steps"].attrs["NSteps"])
        times = root["Steps/Values"][...]
        assert len(times) == count, f"{path}: {len(times)} times, {count} announced"
        found = []
        for k in range(count):
            arrays = {}
            for name, data in root["PointData"].items():
                begin = int(root[f"Steps/PointDataOffsets/{name}"][k])
                is_image = "NumberOfPoints" not in root
                size = 1 if is_image else int(root["NumberOfPoints"][root["Steps/PartOffsets"][k]])
                arrays[name] = (data[...] if is_image and count == 1 else data[begin : begin + size]).tobytes()
            found.append((float(times[k]), arrays))
        return found


def read_vtk(path: Path) -> list[tuple[float, dict[str, bytes]]]:
    """The same by VTK's reader, as ParaView has it."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    found = []
    for step in range(reader.GetNumberOfSteps()):
        reader.SetStep(step)
        reader.Update()
        data = reader.GetOutputDataObject(0).GetPointData()
        names = [data.GetArrayName(k) for k in range(data.GetNumberOfArrays())]
        assert names, f"{path}: VTK shows no fields at {reader.GetTimeValue()}"
        found.append((reader.GetTimeValue(), {name: vtk_to_numpy(data.GetArray(name)).tobytes() for name in names}))
    return found


def read_rows(path: Path) -> list[list[str]]:
    """Complete rows of a CSV file, without what differs between any two runs."""
    lines = path.read_text().split("\n")[:-1]  # a row is complete with its end of line
    rows = list(csv.reader(lines))
    kept = [k for k, name in enumerate(rows[0]) if name != "step_seconds"] if rows else []
    return [[row[k] for k in kept] for row in rows]


class Left:
    """What a run has left in its folder, by name: rows, times of fields, files."""

    def __init__(self, folder: Path) -> None:
        self.parts: dict[str, list] = {}
        for path in sorted(folder.iterdir()) if folder.exists() else []:
            if path.suffix == ".csv":
                self.parts[path.name] = read_rows(path)
            if path.suffix == ".vtkhdf":
                by_h5py, by_vtk = read_hdf(path), read_vtk(path)
                assert [time for time, _ in by_h5py] == [time for time, _ in by_vtk], f"{path}: readers see other times"
                for (time, mine), (_, theirs) in zip(by_h5py, by_vtk, strict=True):
                    for name, values in theirs.items():
                        assert name not in mine or mine[name] == values, f"{path}: readers see another {name} at {time}"
                self.parts[path.name] = by_h5py
            if path.suffix == ".pvd":
                entries = [line.split('"') for line in path.read_text().splitlines() if line.startswith("<DataSet")]
                self.parts[path.name] = [(float(line[1]), (folder / line[5]).read_bytes()) for line in entries]
        if (folder / "manifest.toml").exists():
            sys.path.insert(0, str(HERE.parent.parent / "python"))
            from matpoint.results import Results

            results = Results(folder)
            for name, body in results.bodies.items():
                for k in range(len(body.times)):
                    assert np.isfinite(body.positions(k)).all(), f"{name}: our reader sees no numbers"

    def is_beginning_of(self, whole: Left) -> str:
        """What is not as in the whole run, up to where it ends; empty if nothing."""
        for name, part in self.parts.items():
            full = whole.parts.get(name)
            if full is None or part != full[: len(part)]:
                return f"{name} is not the beginning of that of the whole run"
        return ""


class Trials:
    def __init__(self, program: str, folder: Path) -> None:
        self.program = program
        self.folder = folder
        self.preload = build(folder)
        self.failures: list[str] = []
        self.count = 0

    def run(self, *words: str, kind: str = "", at: int = 0, counts: bool = False) -> subprocess.CompletedProcess[str]:
        results = self.folder / "cut"
        spare = self.folder / "spare"
        spare.mkdir(exist_ok=True)
        extra = {"LD_PRELOAD": str(self.preload), "FAULT_FOLDER": str(results), "FAULT_AT": str(at), "FAULT_KIND": kind}
        extra["FAULT_SPARE"] = str(spare)
        if counts:
            extra["FAULT_COUNT"] = str(self.folder / "calls")
        environment = {**os.environ, **(extra if kind or counts else {})}
        return subprocess.run(
            [self.program, "run", *words, "--threads", "1"],
            cwd=self.folder,
            env=environment,
            capture_output=True,
            text=True,
            timeout=300,
        )

    def prepare(self, name: str) -> tuple[int, Left]:
        """Calls of an undisturbed run, and what it leaves."""
        case, options = RUNS[name]
        (self.folder / f"{name}.toml").write_text(case)
        shutil.rmtree(self.folder / "cut", ignore_errors=True)
        done = self.run(f"{name}.toml", "--out", "cut", *options, counts=True)
        assert done.returncode == 0, done.stderr
        return int((self.folder / "calls").read_text()), Left(self.folder / "cut")

    def try_one(self, name: str, kind: str, at: int, whole: Left) -> None:
        options = RUNS[name][1]
        folder = self.folder / "cut"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.rmtree(self.folder / "spare", ignore_errors=True)
        done = self.run(f"{name}.toml", "--out", "cut", *options, kind=kind, at=at)
        self.count += 1

        def fail(what: str) -> None:
            self.failures.append(f"{name}: {kind} at call {at}: {what}; exit code {done.returncode}, {done.stderr.strip()[:300]}")

        try:
            left = Left(folder)
        except Exception as error:  # whatever a reader raises
            return fail(f"unreadable: {error}")
        if wrong := left.is_beginning_of(whole):
            return fail(wrong)
        if kind in ("kill", "power"):
            if done.returncode != -9:
                return fail("was not killed")
        elif done.returncode == 0:
            if left.parts != whole.parts:
                fail("says that it has finished, with wrong files")
            return None
        else:
            if kind in ("short", "eintr"):
                return fail("ended")
            if done.returncode not in (2, 3) or done.stderr.count("error: ") != 1:
                return fail("must end with exit code 3 (2 before it has begun) and one line")
            if (folder / "manifest.toml").exists() and 'status = "finished"' in (folder / "manifest.toml").read_text():
                return fail("says that it has finished")
        if not (folder / "manifest.toml").exists():
            again = self.run(f"{name}.toml", "--out", "cut", *options)
        else:
            again = self.run("--continue", "cut", *options)
        if again.returncode != 0:
            return fail(f"cannot be continued: {again.stderr.strip()}")
        if Left(folder).parts != whole.parts:
            return fail("continued, it ends with other files")
        return None


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinds", nargs="*", default=list(KINDS), metavar="KIND", help=f"of {', '.join(KINDS)}; default: all")
    parser.add_argument("--runs", nargs="+", default=list(RUNS), choices=list(RUNS))
    parser.add_argument("--every", type=int, default=1, help="try each so many-th call")
    parser.add_argument("--program", default=str(HERE.parent.parent / "build/release/bin/matpoint"))
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        trials = Trials(arguments.program, Path(folder))
        for name in arguments.runs:
            calls, whole = trials.prepare(name)
            for kind in arguments.kinds:
                before = len(trials.failures)
                for at in range(1 + (calls * 7 + len(kind)) % arguments.every, calls + 1, arguments.every):
                    trials.try_one(name, kind, at, whole)
                print(f"{name}: {calls} calls, {kind}: {len(trials.failures) - before} failures", flush=True)
        for failure in trials.failures[:20]:
            print(failure)
        print(f"{trials.count} trials, {len(trials.failures)} failures")
        return 1 if trials.failures else 0


if __name__ == "__main__":
    sys.exit(main())
