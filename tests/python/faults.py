"""Makes runs fail at each of their calls that change files, and looks at what is left.

    scripts/faults                      all kinds at all calls of all runs (hours)
    scripts/faults --every 20           at each 20th call
    scripts/faults kill power --runs explicit implicit
    scripts/faults --random 1000         runs of some seconds, killed at random times instead, and continued

A run that was killed must leave files that every reader opens (h5py, VTK, ours), with the times that were complete and nothing else, and
end with the files of an uninterrupted run when it is continued. A run whose call failed must say so, or have right files.
"""

from __future__ import annotations

import argparse
import csv
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
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
# Runs of some seconds on one thread, for kills at random times.
LONG_RUNS = {
    "explicit_long": (
        BLOCK.replace("[10, 10]", "[150, 150]").replace("end = 0.2", "end = 2.4") + "[output]\nfields_every = 0.1\nhistory_every = 0.01\n",
        ["--checkpoint-steps", "100"],
    ),
    "implicit_long": (
        BLOCK.replace("[10, 10]", "[64, 64]").replace("end = 0.2", "end = 2.4\ndt = 0.002")
        + '[solver]\ntype = "implicit"\n[output]\nfields_every = 0.08\nhistory_every = 0.004\n',
        ["--checkpoint-wall", "0.5"],
    ),
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
        case, options = (RUNS | LONG_RUNS)[name]
        (self.folder / f"{name}.toml").write_text(case)
        shutil.rmtree(self.folder / "cut", ignore_errors=True)
        done = self.run(f"{name}.toml", "--out", "cut", *options, counts=True)
        assert done.returncode == 0, done.stderr
        return int((self.folder / "calls").read_text()), Left(self.folder / "cut")

    def try_one(self, name: str, kind: str, at: int, whole: Left) -> None:
        self.clear()
        done = self.run(f"{name}.toml", "--out", "cut", *RUNS[name][1], kind=kind, at=at)
        self.look_and_continue(name, f"{kind} at call {at}", kind, done, whole)

    def kill_at(self, name: str, seconds: float, whole: Left) -> None:
        """A run that is killed some seconds after its start, unless it has ended."""
        self.clear()
        options = LONG_RUNS[name][1]
        words = [
            "timeout",
            "--signal",
            "KILL",
            str(seconds),
            self.program,
            "run",
            f"{name}.toml",
            "--out",
            "cut",
            *options,
            "--threads",
            "1",
        ]
        done = subprocess.run(words, cwd=self.folder, capture_output=True, text=True)
        if done.returncode == 137:
            done.returncode = -9
        kind = "kill" if done.returncode != 0 else "end"
        self.look_and_continue(name, f"killed after {seconds:.3f} s", kind, done, whole)

    def clear(self) -> None:
        for folder in ("cut", "spare"):
            shutil.rmtree(self.folder / folder, ignore_errors=True)

    def look_and_continue(self, name: str, trial: str, kind: str, done: subprocess.CompletedProcess[str], whole: Left) -> None:
        """What the run has left must be the beginning of the whole one, and go on to its end."""
        options = (RUNS | LONG_RUNS)[name][1]
        folder = self.folder / "cut"
        self.count += 1

        def fail(what: str) -> None:
            self.failures.append(f"{name}: {trial}: {what}; exit code {done.returncode}, {done.stderr.strip()[:300]}")

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


def kill_at_random(trials: Trials, count: int, seed: int) -> None:
    times = random.Random(seed)
    for number, name in enumerate(LONG_RUNS):
        begin = time.monotonic()
        _, whole = trials.prepare(name)
        seconds = time.monotonic() - begin
        before = len(trials.failures)
        kills = count // len(LONG_RUNS) + (number < count % len(LONG_RUNS))
        for _ in range(kills):
            trials.kill_at(name, times.uniform(0.0, seconds), whole)
        print(f"{name}: {seconds:.1f} s, {kills} kills: {len(trials.failures) - before} failures", flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinds", nargs="*", default=list(KINDS), metavar="KIND", help=f"of {', '.join(KINDS)}; default: all")
    parser.add_argument("--runs", nargs="+", default=list(RUNS), choices=list(RUNS))
    parser.add_argument("--every", type=int, default=1, help="try each so many-th call")
    parser.add_argument(
        "--random", type=int, default=0, metavar="COUNT", help="so many runs of some seconds, killed at random times, instead"
    )
    parser.add_argument("--seed", type=int, default=1, help="of the random times")
    parser.add_argument("--program", default=str(HERE.parent.parent / "build/release/bin/matpoint"))
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        trials = Trials(arguments.program, Path(folder))
        if arguments.random > 0:
            kill_at_random(trials, arguments.random, arguments.seed)
        for name in arguments.runs if arguments.random == 0 else []:
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
