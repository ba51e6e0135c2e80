"""A few of the trials of scripts/faults: runs that are killed, lose power or meet failing writes."""

import subprocess

import faults
import numpy as np
import pytest
from matpoint import results


@pytest.mark.parametrize("name", list(faults.RUNS))
def test_what_a_run_leaves_is_readable_and_goes_on(program, tmp_path, name):
    trials = faults.Trials(str(program), tmp_path)
    calls, whole = trials.prepare(name)
    assert calls > 100
    for number, kind in enumerate(faults.KINDS):
        for share in (0.02, 0.35, 0.8):
            trials.try_one(name, kind, 1 + int(share * calls) + 7 * number, whole)
    assert not trials.failures, "\n".join(trials.failures)


def test_files_can_be_read_all_the_time_while_a_run_writes_them(program, tmp_path):
    (tmp_path / "block.toml").write_text(faults.RUNS["times"][0].replace("0.0028", "0.0005").replace("end = 0.2", "end = 1"))
    running = subprocess.Popen([program, "run", "block.toml", "--out", "r"], cwd=tmp_path, stdout=subprocess.DEVNULL)
    path = tmp_path / "r/block.vtkhdf"
    seen = []
    try:
        while running.poll() is None:
            if not path.exists():
                continue
            for reader in (faults.read_hdf, faults.read_vtk):
                times = [time for time, _ in reader(path)]
                assert times == sorted(times) and (not seen or times[: len(seen[-1])] == seen[-1])
                seen.append(times)
            ours = results.Results(tmp_path / "r").bodies["block"]
            assert np.isfinite(ours.positions(len(ours.times) - 1)).all()
    finally:
        running.kill()
        running.wait()
    assert len(seen) > 10 and len(seen[0]) < len(seen[-1])
