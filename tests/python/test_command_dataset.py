"""`mesocrete dataset`: the data set of Python by the command that the wheel installs."""

import subprocess

import numpy as np
import pytest

import mesocrete as mc

SPEC = "fraction = 0.2\nspecimen = { kind = 'cube', side_mm = 20 }\ngrading = { d_min_mm = 5, d_max_mm = 8 }\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "SPEC.toml").write_text(SPEC)
    (tmp_path / "ranges.toml").write_text("fraction = { low = 0.1, high = 0.2 }\ngrading.d_max_mm = [7, 8]\n")
    return tmp_path


def run(command, folder, *words):
    return subprocess.run([command, "dataset", "SPEC.toml", *words], cwd=folder, capture_output=True, text=True)


def test_volumes_by_the_command_are_those_of_python(command, folder):
    words = ["-n", "3", "--shape", "8", "--what", "phase,grain", "--over", "ranges.toml", "--seed", "5"]
    made = run(command, folder, *words, "-o", "a.zarr", "-q")
    assert (made.returncode, made.stderr) == (0, "")
    over = {"fraction": (0.1, 0.2), "grading.d_max_mm": [7, 8]}
    mc.dataset(3, over, spec=folder / "SPEC.toml", shape=8, what=["phase", "grain"], seed=5, sink=folder / "b.zarr")
    files = [{str(path.relative_to(folder / name)): path.read_bytes() for path in (folder / name).rglob("*") if path.is_file()} for name in ("a.zarr", "b.zarr")]
    assert files[0] == files[1] and len(files[0]) > 6
    assert np.unique(mc.dataset(3, over, spec=folder / "SPEC.toml", shape=8, what=["phase", "grain"], seed=5, sink=folder / "a.zarr")[0]["phase"]).size > 1
    other = run(command, folder, "-n", "3", "--shape", "9", "-o", "a.zarr")
    assert other.returncode == 1 and "--force replaces it" in other.stderr, other.stderr
    assert run(command, folder, "-n", "2", "--shape", "9", "-o", "a.zarr", "--force").stderr.endswith("2 volumes\n")


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["-n", "0"], 2, "it must be a whole number from 1"),
        (["-n", "1", "--what", "colour"], 2, "[possible values: phase, grain, share, distance, scan]"),
        (["-n", "1", "-o", "-"], 2, "--output - is standard output, but a data set has many volumes; name a sink"),
        (["-n", "1", "--over", "no.toml"], 1, "no.toml: No such file or directory"),
    ],
)
def test_wrong_requests_are_refused_and_make_nothing(command, folder, words, code, said):
    before = sorted(folder.iterdir())
    made = run(command, folder, *words)
    assert made.returncode == code and said in made.stderr, made.stderr
    assert sorted(folder.iterdir()) == before
