"""The benchmark of packings: its checker finds every fault, and its table is the page's."""

import csv
import importlib.util
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import mesocrete as mc

FOLDER = Path(__file__).resolve().parents[2] / "benchmark"
SPECS = sorted((FOLDER / "specs").glob("*.toml"))
SMALL = {
    "fraction": 0.3,
    "specimen": {"kind": "cube", "side_mm": 50.0},
    "grading": {"curve": {"kind": "fuller", "exponent": 0.5}, "d_min_mm": 5, "d_max_mm": 15, "classes_mm": [5, 10, 15]},
}
PERIODIC = SMALL | {"specimen": SMALL["specimen"] | {"periodic": ["x", "y", "z"]}}


@pytest.fixture(scope="module")
def checker():
    path = FOLDER / "check.py"
    check = importlib.util.module_from_spec(spec := importlib.util.spec_from_file_location("benchmark_check", path))
    sys.modules["benchmark_check"] = check
    spec.loader.exec_module(check)
    return check


def bodies(spec):
    return [grain.vertices for grain in mc.pack(spec, seed=2).aggregates]


@pytest.mark.parametrize("spec", [SMALL, PERIODIC], ids=["cube", "periodic"])
def test_a_packing_keeps_every_rule(checker, spec):
    row = checker.check(spec, bodies(spec))
    assert row["kept"] == "yes", row
    assert abs(row["fraction"] - 0.3) < 0.002


def test_the_checker_finds_overlaps_leavers_wrong_sizes_and_a_missing_class(checker):
    grains = bodies(SMALL)
    grains[0] = grains[0] + (grains[1].mean(axis=0) - grains[0].mean(axis=0))
    grains[2] = grains[2] + np.array([50.0, 0.0, 0.0])
    grains[3] = grains[3] * 0.1
    row = checker.check(SMALL, grains)
    assert (row["overlapping_pairs"] >= 1, row["outside"], row["wrong_size"], row["kept"]) == (True, 1, 1, "no")
    large = [grain for grain in bodies(SMALL) if checker.sizes([grain])[0] > 10]
    assert checker.check(SMALL, large)["worst_class_percent"] == -100.0


def test_an_image_across_a_periodic_face_overlaps(checker):
    cube = np.array([[x, y, z] for x in (0, 6) for y in (0, 6) for z in (0, 6)], float)
    far, near = cube + np.array([45.0, 20, 20]), cube + np.array([0.5, 20, 20])
    assert checker.check(SMALL, [far - [1.5, 0, 0], near])["overlapping_pairs"] == 0
    assert checker.check(PERIODIC, [far, near])["overlapping_pairs"] >= 1


def test_specs_are_those_of_the_table_and_mesocretes_rows_keep_the_rules(checker):
    with (FOLDER / "results.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    own = [row for row in rows if row["program"] == "mesocrete"]
    assert [row["spec"] for row in own] == [path.stem for path in SPECS]
    assert all(row["kept"] == "yes" for row in own)
    for row, path in zip(own, SPECS, strict=True):
        spec = tomllib.loads(path.read_text(encoding="utf-8"))
        assert mc.Spec.read(path).fraction == spec["fraction"]
        assert abs(float(row["fraction"]) - spec["fraction"]) < checker.SHORT
