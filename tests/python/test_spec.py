"""Specs: what is left out keeps its default, what is wrong is named."""

import copy
import pickle

import numpy as np
import pytest

import mesocrete as mc


def test_default_is_the_papers_specimen():
    spec = mc.Spec()
    assert spec.fraction == 0.5
    assert spec.specimen == {"kind": "cube", "side_mm": 150.0}
    assert spec.grading["classes_mm"] == [5.0, 10.0, 15.0, 20.0]
    assert spec.shape["vertices"] == [20, 30]
    assert spec.itz == {"thickness_mm": [0.1, 0.5]}
    assert spec.placement["strategy"] == "auto"
    assert spec.voids is None and spec.fibres is None


def test_sections_are_laid_over_the_defaults():
    spec = mc.Spec(seed=3, placement={"attempts": 100})
    assert spec.seed == 3
    assert mc.Spec(voids={"fraction": 0.01, "diameter_mm": [1.0, 2.0]}).voids == {"fraction": 0.01, "diameter_mm": [1.0, 2.0]}
    assert spec.placement["attempts"] == 100
    assert spec.placement["surplus"] == mc.Spec().placement["surplus"]


def test_dict_toml_and_file_round_trip(tmp_path):
    spec = mc.Spec(fraction=0.1 + 0.2, seed=2**63 - 1, specimen={"kind": "box", "size_mm": [40.0, 50.0, 60.0]})
    assert mc.Spec(**spec.to_dict()) == spec
    assert mc.Spec.from_toml(spec.to_toml()) == spec
    path = tmp_path / "spec.toml"
    path.write_text(spec.to_toml(), encoding="utf-8")
    assert mc.Spec.read(path) == mc.Spec.read(str(path)) == spec


def test_a_spec_says_what_each_of_its_keys_means():
    spec = mc.Spec(fraction=0.3, specimen=mc.Specimen.cylinder(100, 200))
    text = spec.describe()
    assert mc.Spec.from_toml(text) == spec
    assert "# Smallest distance between two aggregates, mm; 0 means: proved apart.\nmin_gap_mm = 0.0\n" in text
    assert 'One of "longest-axis", "sieve".\nsize = "longest-axis"\n' in text


def test_pickle_and_copy_round_trip():
    spec = mc.Spec(fraction=0.1 + 0.2, seed=2**64 - 1)
    assert pickle.loads(pickle.dumps(spec)) == spec
    assert copy.deepcopy(spec) == copy.copy(spec) == spec


def test_replace_merges_sections():
    spec = mc.Spec(fraction=0.4).replace(seed=9, itz={"thickness_mm": [0.2, 0.2]})
    assert (spec.seed, spec.fraction, spec.itz) == (9, 0.4, {"thickness_mm": [0.2, 0.2]})
    box = mc.Spec().replace(specimen={"kind": "box", "size_mm": [40, 50, 60]})
    assert box.specimen == {"kind": "box", "size_mm": [40.0, 50.0, 60.0]}


def test_numpy_scalars_and_arrays_count_as_numbers():
    spec = mc.Spec(fraction=np.float32(0.5), seed=np.int64(5), itz={"thickness_mm": np.array([0.1, 0.2])})
    assert (spec.fraction, spec.seed, spec.itz["thickness_mm"]) == (0.5, 5, [0.1, 0.2])


def test_none_means_left_out():
    assert mc.Spec(seed=None, placement={"attempts": None}) == mc.Spec()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fraction": 40}, "fraction is 40;.*above 0 and below 1.*0.4"),
        ({"fraction": 0.0}, "fraction is 0;.*above 0"),
        ({"fraction": -0.1}, "fraction is -0.1;"),
        ({"fraction": float("nan")}, "fraction is NaN; it must be finite"),
        ({"fracton": 0.4}, "fracton is not a known key; did you mean fraction"),
        ({"grading": {"d_min_mm": 25.0}}, "grading.d_min_mm is 25"),
        ({"grading": {"classes_mm": [5.0, 15.0, 10.0, 20.0]}}, "grading.classes_mm"),
        ({"grading": {"form": "bolomey-ish"}}, "grading.form"),
        ({"specimen": {"kind": "cube", "side_mm": 0.0}}, "specimen.side_mm is 0"),
        ({"specimen": {"kind": "donut"}}, "specimen.kind"),
        ({"seed": 2**64}, "seed is 18446744073709551616; it does not fit 64 bits"),
        ({"itz": {"thickness_mm": [0.5, 0.1]}}, "itz.thickness_mm"),
    ],
)
def test_values_that_cannot_be_name_key_value_and_range(options, message):
    with pytest.raises(ValueError, match=message):
        mc.Spec(**options)
    with pytest.raises(ValueError, match=message):
        mc.pack(options)


@pytest.mark.parametrize(
    ("options", "key"),
    [
        ({"fraction": "half"}, "fraction"),
        ({"seed": 1.5}, "seed"),
        ({"specimen": 150.0}, "specimen"),
        ({"itz": {"thickness_mm": {1, 2}}}, "itz.thickness_mm"),
        ({"grading": {"classes_mm": [5.0, "ten", 20.0]}}, "grading.classes_mm"),
        ({"placement": {"attempts": True}}, "placement.attempts"),
        ({"itz": {3: 4}}, "itz"),
    ],
)
def test_wrong_types_are_type_errors_that_name_the_key(options, key):
    with pytest.raises(TypeError, match=key):
        mc.Spec(**options)


def test_a_dict_that_holds_itself_is_refused():
    options = {}
    options["placement"] = options
    with pytest.raises(ValueError, match="nested"):
        mc.Spec(**options)


def test_files_that_are_not_there_are_os_errors(tmp_path):
    with pytest.raises(FileNotFoundError) as caught:
        mc.Spec.read(tmp_path / "nowhere.toml")
    assert caught.value.filename == str(tmp_path / "nowhere.toml")
    with pytest.raises(OSError):
        mc.pack(tmp_path)


def test_a_file_that_is_wrong_is_named_with_its_line(tmp_path):
    path = tmp_path / "spec.toml"
    path.write_text("seed = 1\nfraction = 45\n", encoding="utf-8")
    with pytest.raises(ValueError, match="spec.toml: line 2: fraction is 45"):
        mc.pack(path)
    path.write_bytes(b"seed = \xff\xfe")
    with pytest.raises(ValueError, match="spec.toml.*UTF-8"):
        mc.Spec.read(path)
