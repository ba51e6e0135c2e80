"""Feeds the program with input that nobody would write: cases, command lines and states with random changes, odd calls in Python.

    scripts/fuzz                         1000 of each kind
    scripts/fuzz --count 10000 check     cases through `matpoint check`
    scripts/fuzz --seed 7 run            another sequence
    scripts/fuzz --count 60 calls        3000 calls of the Python API, 50 in each trial

The program must answer each with exit code 0, or with one line that begins with "error: " and names the place (exit codes 2 and 3): no
signal, no exit code 1, no message of C++ or HDF5, and within 30 s of computing and 4 GB.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

ROOT = Path(__file__).resolve().parent.parent.parent
KINDS = ("check", "run", "words", "states", "calls")
VALUES = (
    "0 -0.0 1 -1 2 1e-300 1e300 -1e300 inf nan 1e9 4096 0.1 9223372036854775807 -9223372036854775808 18446744073709551616 true false [] {} "
    "[1] [0,0] [0,-9.81] [1,1,1] [[0,0],[1,0],[0,1]] '' 'x' 'left' 'bottom' 'fixed' 'slip' 'friction' 'implicit' 'explicit' 'pairs' 'gimp' "
    "'linear' 'element' 'bspline' 'static' 1979-05-27 '\\u0000' [inf,nan] {type='disk'} {type='box',lower=[0,0],upper=[0,0]}"
).split(" ")
STATES = ("disks", "ball", "float", "granular_column", "sphere", "rolling_disk")
CASES = sorted((ROOT / "cases").glob("*.toml"))


def lines_of(text: str) -> list[str]:
    return text.splitlines()


def mutated(text: str, other: str, rng: random.Random) -> str:
    """A case with some changes: values, keys, lines, sections of another case, bytes."""
    for _ in range(rng.choice([1, 1, 1, 2, 3, 6])):
        lines = lines_of(text) or [""]
        at = rng.randrange(len(lines))
        kind = rng.randrange(9)
        if kind <= 3 and "=" in lines[at]:
            key = lines[at].split("=", 1)[0]
            lines[at] = f"{key}= {rng.choice(VALUES)}"
        elif kind == 4 and "=" in lines[at]:
            key, value = lines[at].split("=", 1)
            lines[at] = f"{key.strip()[:-1]}x ={value}"
        elif kind == 5:
            del lines[at]
        elif kind == 6:
            lines.insert(at, rng.choice(lines_of(other) or [""]))
        elif kind == 7:
            numbers = list(re.finditer(r"-?\d+\.?\d*(e-?\d+)?", lines[at]))
            if numbers:
                found = rng.choice(numbers)
                lines[at] = lines[at][: found.start()] + rng.choice(VALUES) + lines[at][found.end() :]
        else:
            position = rng.randrange(len(text) + 1)
            text = text[:position] + rng.choice(["[", "]", '"', "\n", "=", "\x00", "é", "#", "{", ",", "\udcff"]) + text[position + 1 :]
            continue
        text = "\n".join(lines) + "\n"
    return text


def sealed(data: bytes) -> bytearray:
    """The file with the size and checksum that it has now, as src/io/hdf5_file.cpp writes them."""
    title, rest = data[:512].split(b"\n", 1)[0], data[512:]
    mask = 2**64 - 1
    total = 0xCBF29CE484222325
    for word in np.frombuffer(rest + bytes(-len(rest) % 8), "<u8").tolist():
        total = ((total ^ word) * 0x100000001B3) & mask
        total = ((total << 29) | (total >> 35)) & mask
    text = title + f"\n{len(rest)} bytes follow this block of 512\nchecksum {total:016x}\n".encode()
    return bytearray(text.ljust(512, b"\0") + rest)


class Trials:
    def __init__(self, program: str, folder: Path, seed: int) -> None:
        self.program = program
        self.folder = folder
        self.rng = random.Random(seed)
        self.count = 0
        self.good = 0
        self.failures: list[str] = []
        self.saved: dict[str, tuple[bytes, float]] = {}

    def answer(self, words: list[str], what: str) -> subprocess.CompletedProcess[bytes]:
        """Runs the program, and looks at how it ends."""

        def limits() -> None:
            resource.setrlimit(resource.RLIMIT_CPU, (30, 31))
            resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))

        self.count += 1
        done = subprocess.run([self.program, *words], cwd=self.folder, capture_output=True, preexec_fn=limits, timeout=300)
        errors = done.stderr.decode("utf-8", "replace")
        lines = [line for line in errors.split("\n") if line and not line.startswith("warning: ")]
        self.good += done.returncode == 0
        if done.returncode == 0 and not lines:
            return done
        if done.returncode in (2, 3) and len(lines) == 1 and lines[0].startswith("error: ") and len(lines[0]) > 20:
            if not re.search(r"std::|basic_string|vector::|HDF5-DIAG|bad_alloc", lines[0]):
                return done
        kept = self.folder / f"failure-{len(self.failures)}"
        self.failures.append(f"{what}: exit code {done.returncode}: {errors.strip()[:400]} (kept as {kept})")
        for path in self.folder.glob("trial*"):
            if path.is_file():
                shutil.copy(path, f"{kept}-{path.name}")
        return done

    def case(self) -> Path:
        path = self.folder / "trial.toml"
        text = mutated(self.rng.choice(CASES).read_text(), self.rng.choice(CASES).read_text(), self.rng)
        path.write_bytes(text.encode("utf-8", "surrogateescape"))
        return path

    def check(self) -> None:
        self.answer(["check", str(self.case())], "check")

    def run(self) -> None:
        """For some steps."""
        case = self.case()
        checked = self.answer(["check", str(case)], "check")
        step = re.search(rb"# time step +(\S+) s", checked.stdout)
        size = re.search(rb"(\d+) particles", checked.stdout)
        if checked.returncode != 0 or step is None or (size is not None and int(size[1]) > 20000):
            return
        shutil.rmtree(self.folder / "r", ignore_errors=True)
        end = ["--set", f"time.end={3 * float(step[1])!r}"]
        self.answer(["run", str(case), "--out", "r", *end], "run")

    def words(self) -> None:
        """A command line of right words, wrong ones, and the sets of a case."""
        known = "run check list explain status plot verify --out --set --threads --overwrite --continue --from --time-limit".split()
        other = [
            "disks",
            "dam",
            "r",
            "",
            "-",
            "--",
            "1",
            "-1",
            "nan",
            "1e999",
            "time.end=1e-9",
            "solver.shape=gimp",
            "body.1.name=",
            "a.b.c=1",
            "=",
            "x=[",
            "é",
        ]
        words = [self.rng.choice(known if self.rng.random() < 0.5 else other) for _ in range(self.rng.randrange(1, 6))]
        if words[0] in ("verify", "plot") or ("run" in words and any(word in ("disks", "dam") for word in words)):
            words = ["check", *words[1:]]
        self.answer(words, " ".join(words))

    def states(self) -> None:
        """Checkpoints with changed bytes, cut, or grown; and such with other contents, sealed anew, that only the loading can refuse."""
        name = self.rng.choice(STATES)
        if name not in self.saved:
            words = ["run", name, "--out", "saved", "--overwrite", "--checkpoint-steps", "3", "--time-limit", "0.5"]
            done = subprocess.run([self.program, *words], cwd=self.folder, capture_output=True)
            assert done.returncode in (0, 75), done.stderr
            last = sorted((self.folder / "saved/checkpoints").glob("*.h5"))[-1]
            with h5py.File(last) as file:
                end = float(file["simulation/time"][0] + 3 * file["simulation/dt"][0])
            self.saved[name] = (last.read_bytes(), end)
        state, end = self.saved[name]
        data = bytearray(state)
        kind = self.rng.randrange(8)
        if kind >= 4:
            data = self.with_other_contents(state)
        elif kind == 0:
            data = data[: self.rng.randrange(len(data))]
        elif kind == 1:
            data += bytes(self.rng.randrange(1, 5000))
        else:
            # The file's own tables are at its beginning and end, where a change does most.
            for _ in range(self.rng.choice([1, 1, 4, 50])):
                at = (
                    self.rng.randrange(len(data))
                    if kind == 2
                    else self.rng.choice([self.rng.randrange(4096), -1 - self.rng.randrange(8192)])
                )
                data[at] = self.rng.randrange(256)
        path = self.folder / "trial.h5"
        path.write_bytes(bytes(data))
        shutil.rmtree(self.folder / "r", ignore_errors=True)
        self.answer(["run", "--from", str(path), "--out", "r", "--set", f"time.end={end!r}"], f"state of {name}")

    def calls(self) -> None:
        """50 odd calls of the Python API, in an interpreter of their own."""
        seed = str(self.rng.randrange(10**6))
        words = [sys.executable, str(Path(__file__).with_name("fuzz_calls.py")), seed, "50"]
        done = subprocess.run(words, capture_output=True, text=True, cwd=self.folder, timeout=600)
        self.count += 1
        self.good += done.returncode == 0
        if done.returncode != 0:
            self.failures.append(f"calls of seed {seed}: exit code {done.returncode}: {done.stdout[-1000:]} {done.stderr[-500:]}")

    def with_other_contents(self, state: bytes) -> bytearray:
        """Data sets that are missing, of another size or kind, or have another value."""
        path = self.folder / "other.h5"
        path.write_bytes(state)
        with h5py.File(path, "r+") as file:
            names: list[str] = []
            file.visititems(lambda name, found: names.append(name) if isinstance(found, h5py.Dataset) else None)
            for _ in range(self.rng.choice([1, 1, 1, 3])):
                name = self.rng.choice(names)
                if name not in file:
                    continue
                old = file[name][()]
                odd = self.rng.choice([0, -1, 1, 7, 2**31, 2**62, -(2**63), 1e300, -1e-300, float("nan"), float("inf")])
                how = self.rng.randrange(6)
                if isinstance(old, bytes) or how == 0:
                    del file[name]
                    if how > 1:
                        file[name] = self.rng.choice([np.float64(1), "", "x = [", "0", np.zeros(3), old[: len(old) // 2]])
                elif how == 1:
                    del file[name]
                    file[name] = np.resize(old, self.rng.choice([0, 1, 2, old.size + 1, 2 * old.size]))
                elif how == 2:
                    del file[name]
                    file[name] = old.astype(self.rng.choice(["i8", "f4", "f8"]))
                elif old.size > 0:
                    with np.errstate(all="ignore"):
                        old.flat[self.rng.randrange(old.size)] = (
                            odd if old.dtype.kind == "f" else np.array(odd).astype("i8", casting="unsafe")
                        )
                    file[name][...] = old
        return sealed(path.read_bytes())


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kinds", nargs="*", default=list(KINDS), metavar="KIND", help=f"of {', '.join(KINDS)}; default: all")
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/matpoint"))
    parser.add_argument("--keep", help="a folder for the inputs that failed")
    arguments = parser.parse_args()
    os.environ["MATPLOTLIBRC"] = os.devnull
    with tempfile.TemporaryDirectory() as folder:
        keep = Path(arguments.keep) if arguments.keep else Path(folder)
        keep.mkdir(parents=True, exist_ok=True)
        failed = 0
        for kind in arguments.kinds:
            trials = Trials(arguments.program, keep, arguments.seed)
            for _ in range(arguments.count):
                getattr(trials, kind)()
            print(f"{kind}: {trials.count} trials, {trials.good} of them went well, {len(trials.failures)} failures", flush=True)
            for failure in trials.failures[:20]:
                print(failure)
            failed += len(trials.failures)
        return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
