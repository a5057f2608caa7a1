"""Effective properties of a packing."""

import pytest

import mesocrete as mc
from mesocrete import _results

SPEC = {"fraction": 0.3, "seed": 1, "specimen": {"kind": "cube", "side_mm": 30, "periodic": ["x", "y", "z"]}, "grading": {"d_min_mm": 5, "d_max_mm": 10}}


@pytest.fixture(scope="module")
def cube():
    return mc.pack(SPEC)


def test_a_tensor_lies_between_its_bounds(cube):
    found = cube.effective(voxel_size=1.5, phases={"itz": 0})
    assert set(found) == set(_results.Effective.__annotations__)
    for axis in range(3):
        assert 0.4 < found["tensor"][axis][axis] < found["bounds"]["hashin_shtrikman_upper"]
    assert found["boundary"] == ["periodic"] * 3


def test_only_the_asked_axes_have_columns(cube):
    found = cube.effective("conductivity", voxel_size=3, axes="y")
    assert found["tensor"][0][0] is None and found["tensor"][1][1] > 1.5


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"what": "stiffness"}, "what is"),
        ({"axes": "xx"}, "axes is"),
        ({"voxel_size": 20}, "voxel_size is 20; it must be at most 7.5 mm"),
        ({"phases": {"stone": 1}}, "stone"),
        ({"phases": {"mortar": 0}}, "diffusivity.mortar is 0; it must be a positive number"),
    ],
)
def test_wrong_options_are_named_with_their_range(cube, options, said):
    with pytest.raises(ValueError, match=said):
        cube.effective(**options)
