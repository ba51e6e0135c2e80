"""A few of the trials of scripts/faults: runs that are killed, lose power or meet failing writes."""

import shutil

import faults
import pytest

pytest.importorskip("vtkmodules.vtkIOHDF")


@pytest.mark.parametrize("name", list(faults.RUNS))
def test_what_a_run_leaves_is_readable_and_goes_on(program, tmp_path, name):
    if shutil.which("cc") is None:
        pytest.skip("there is no C compiler")
    trials = faults.Trials(str(program), tmp_path)
    calls, whole = trials.prepare(name)
    assert calls > 100
    for number, kind in enumerate(faults.KINDS):
        for share in (0.02, 0.35, 0.8):
            trials.try_one(name, kind, 1 + int(share * calls) + 7 * number, whole)
    assert not trials.failures, "\n".join(trials.failures)
