"""Effective properties of a packing."""

import copy
import pickle
import re
import subprocess
import sys

import numpy as np
import pytest

import mesocrete as mc
from mesocrete import _results

SPEC = {"fraction": 0.3, "seed": 1, "specimen": {"kind": "cube", "side_mm": 30, "periodic": ["x", "y", "z"]}, "grading": {"d_min_mm": 5, "d_max_mm": 10}}

# Keys that only one of the divisions has.
OF_TETRAHEDRA, OF_VOXELS = {"elements", "element_size_mm"}, {"voxels", "voxel_size_mm"}
# And those of a frame.
OF_FRAMES = {"frame", "strain", "stress_mpa"}


@pytest.fixture(scope="module")
def cube():
    return mc.pack(SPEC)


def test_a_tensor_lies_between_its_bounds(cube):
    found = cube.effective(voxel_size=1.5, phases={"itz": 0})
    assert set(found) == set(_results.Effective.__annotations__) - OF_TETRAHEDRA - OF_FRAMES
    for axis in range(3):
        value, error = found["tensor"][axis][axis], found["error"][axis][axis]
        assert 0.4 < value < found["bounds"]["voigt"] and value - error < found["bounds"]["hashin_shtrikman_upper"]
    assert found["boundary"] == ["periodic"] * 3
    assert (found.tensor, found.error, found.bounds) == (found["tensor"], found["error"], found["bounds"])
    with pytest.raises(AttributeError, match="has no 'tensors'; it has boundary, bounds"):
        found.tensors  # noqa: B018
    assert pickle.loads(pickle.dumps(found)) == copy.deepcopy(found) == found


def test_stiffness_lies_between_its_bounds_and_shrinks(cube):
    found = cube.effective("stiffness", voxel_size=3, phases={"itz": {"youngs_modulus_mpa": 20000}}, eigenstrain={"mortar": -4e-4})
    assert set(found) == set(_results.Stiffness.__annotations__) - OF_TETRAHEDRA
    bulk, bounds = found["isotropic"]["bulk_modulus_mpa"], found["bounds"]["bulk_modulus_mpa"]
    assert bounds["reuss"] < bulk < bounds["voigt"]
    assert -4e-4 < found["expansion"][0] < 0


def test_shells_make_an_itz_whose_values_follow_the_distance():
    def found(values):
        shells = [{"name": f"rim_{i}", "thickness_mm": [0.4 / len(values)] * 2} for i in range(len(values))]
        packing = mc.pack({**SPEC, "itz": {"thickness_mm": [0, 0]}, "shape": {"shells": shells}})
        assert [shell["phase"] for shell in packing.report()["shells"]] == [shell["name"] for shell in shells]
        own = {shell["name"]: value for shell, value in zip(shells, values, strict=True)}
        result = packing.effective(voxel_size=1.5, axes="x", phases={"mortar": 1, "aggregate": 0, **own})
        return result["tensor"][0][0], result["error"][0][0]

    (mortar, _), (even, error), (rising, own_error) = found([1]), found([4]), found([1.4, 6.6])
    assert found([4, 4])[0] == pytest.approx(even, rel=1e-6)
    # Thin shells count by thickness times value.
    assert abs(rising - even) < min(error, own_error) and min(rising, even) > 1.3 * mortar


def test_tetrahedra_have_the_values_of_voxels(cube):
    found = cube.effective(method="lattice", element_size=1.5, axes="x")
    assert set(found) == set(_results.Effective.__annotations__) - OF_VOXELS - OF_FRAMES
    assert found["tensor"][0][0] == pytest.approx(cube.effective(voxel_size=0.75, axes="x")["tensor"][0][0], rel=0.02)
    stiff = cube.effective("stiffness", method="lattice", element_size=2, phases={"itz": {"youngs_modulus_mpa": 20000}})
    assert set(stiff) == set(_results.Stiffness.__annotations__) - OF_VOXELS
    bulk, bounds = stiff["isotropic"]["bulk_modulus_mpa"], stiff["bounds"]["bulk_modulus_mpa"]
    assert bounds["reuss"] < bulk < bounds["voigt"]
    with pytest.raises(ValueError, match="aggregate takes .* in the tetrahedra"):
        cube.effective("stiffness", method="lattice", element_size=5)


def test_uniform_flux_and_uniform_gradient_enclose_fixed_ends():
    walled = mc.pack({**SPEC, "fraction": 0.2, "specimen": {"kind": "cube", "side_mm": 30}})
    low, middle, high = (
        walled.effective(method="lattice", element_size=2.5, boundary=name, axes="x")["fine"][0][0]
        for name in ("uniform-flux", "fixed", "uniform-gradient")
    )
    assert low < middle < high


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"method": "conforming"}, "method is conforming; it must be voxel or lattice"),
        ({"element_size": 1}, "element_size is 1; only the method lattice takes it"),
        ({"method": "lattice", "voxel_size": 1}, "voxel_size is 1; only the method voxel takes it"),
        ({"boundary": "free"}, 'boundary is "free"; it must be one of "fixed", "uniform-gradient", "uniform-flux"'),
        ({"boundary": "uniform-flux"}, "boundary is uniform-flux; voxels have fixed; take the method lattice"),
        ({"what": "stiffness", "boundary": "uniform-flux"}, "boundary is uniform-flux; stiffness takes fixed"),
        ({"boundary": "uniform-flux", "method": "lattice"}, "a cube, a box or a prism that has walls on all sides"),
        ({"method": "lattice", "element_size": 20}, "element_size is 20; it must be 0.03 to 7.5 mm"),
    ],
)
def test_a_division_that_cannot_be_is_refused(cube, options, said):
    with pytest.raises(ValueError, match=re.escape(said)):
        cube.effective(**options)


def test_only_the_asked_axes_have_columns(cube):
    found = cube.effective("conductivity", voxel_size=3, axes="y")
    assert found["tensor"][0][0] is None and found["tensor"][1][1] > 1.5


def test_a_label_array_has_values_by_label():
    labels = np.zeros((8, 4, 6), dtype=np.uint16)
    labels[:4] = 7
    found = mc.effective(labels, phases={0: 1, 7: 3}, voxel_size=(0.5, 0.5, 1), periodic="xy")
    assert set(found) == set(_results.Effective.__annotations__) - OF_TETRAHEDRA - OF_FRAMES
    assert [found["tensor"][axis][axis] for axis in range(3)] == pytest.approx([2, 2, 1.5], rel=1e-6)
    assert found["boundary"] == ["periodic", "periodic", "fixed"]
    assert found["voxel_size_mm"] == [0.5, 0.5, 1]
    assert [phase["name"] for phase in found["phases"]] == ["0", "7"]
    elastic = mc.effective(labels, "stiffness", phases={n: {"youngs_modulus_mpa": 3e4} for n in (0, 7)}, eigenstrain={0: 1e-4, 7: 1e-4})
    assert elastic["isotropic"]["youngs_modulus_mpa"] == pytest.approx(3e4)
    assert elastic["expansion"][2] == pytest.approx(1e-4)


def test_an_image_of_a_packing_has_the_values_of_its_phases(cube):
    exact = cube.effective(voxel_size=1.5, axes="x")["tensor"][0][0]
    coarse, fine = (mc.effective(cube.voxelize(h), voxel_size=h, periodic="xyz", axes="x")["fine"][0][0] for h in (1.5, 0.75))
    # Whole voxels close the mortar between grains.
    assert 0.8 * exact < coarse < fine < exact


@pytest.mark.parametrize(
    ("labels", "options", "error", "said"),
    [
        ([[0.5]], {}, TypeError, "labels has dtype float64; it must be integers"),
        ([0, 1], {}, ValueError, "labels has 1 axes"),
        ([[9]], {}, ValueError, "label 9 has no value"),
        ([[0]], {"phases": {0: -1}}, ValueError, "diffusivity.0 is -1"),
        ([[0]], {"voxel_size": 0}, ValueError, "voxel_size is 0; it must be a positive number"),
        ([[0]], {"voxel_size": [1, 2]}, TypeError, "it must be a number or three"),
        ([[0]], {"periodic": "w"}, ValueError, "periodic is"),
        ([[0]], {"what": "stiffness", "eigenstrain": 3}, TypeError, "eigenstrain is 3; it must be a map"),
        (np.arange(300).reshape(1, 300), {}, ValueError, "more than 256 labels"),
        # The value of the text won over that of the number, without a word.
        ([[1]], {"phases": {1: 2.0, "1": 5.0}}, ValueError, "the key 1 is given twice, as a number and as text"),
        ([[1]], {"phases": {1: 1e300}}, ValueError, "it must be 0, or 1e-30 to 1e30"),
        ([[0]], {"what": "stiffness", "phases": {0: {"youngs_modulus_mpa": 2e10}}}, ValueError, "2e10 Pa are 20000 MPa"),
        ([[0]], {"what": "stiffness", "eigenstrain": {0: 1e-4, "0": 2e-4}}, ValueError, "the key 0 is given twice"),
        ([[0]], {"what": "stiffness", "phases": {0: {"youngs_modulus_mpa": 2e4}}, "eigenstrain": {7: 1e-4}}, ValueError, "no such label"),
    ],
)
def test_labels_that_cannot_be_solved_are_refused(labels, options, error, said):
    with pytest.raises(error, match=said):
        mc.effective(labels, **options)


def test_strains_of_phases_that_are_not_there_are_refused_by_name():
    """The case: strains of an ITZ without thickness, or of a label that a volume has not, were left out without a word."""
    bare = mc.pack({"fraction": 0.1, "specimen": {"kind": "cube", "side_mm": 20}, "itz": {"thickness_mm": [0, 0]}}, seed=1)
    coarse = {"what": "stiffness", "voxel_size": 4.0}
    with pytest.raises(ValueError, match=r"stiffness.itz.eigenstrain is .* no such phase, it has mortar, aggregate; leave it out"):
        bare.effective(eigenstrain={"itz": 1e-4}, **coarse)
    assert bare.effective(eigenstrain={"mortar": 1e-4, "itz": 1e-4}, **coarse).expansion[0] > 0
    labels = np.zeros((6, 6, 6), np.uint8)
    labels[2:4, 2:4, 2:4] = 2
    for phases, strain in [
        ({}, "fibre"),
        ({"mortar": {"eigenstrain": 1e-4}, "aggregate": {"poisson_ratio": 0.2}}, "itz"),
        ({0: {"youngs_modulus_mpa": 2e4}, 2: {"youngs_modulus_mpa": 6e4}, 7: {"eigenstrain": 1e-4}}, ""),
    ]:
        eigenstrain = {strain: 1e-4} if strain else {}
        with pytest.raises(ValueError, match=rf"stiffness.{strain or 7}.eigenstrain is 0.0001; the specimen has no such phase"):
            mc.effective(labels, what="stiffness", phases=phases, eigenstrain=eigenstrain)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"what": "strength"}, "what is"),
        ({"what": "stiffness", "axes": "x"}, "axes is"),
        ({"eigenstrain": {"mortar": -1e-4}}, "eigenstrain is mortar=-1e-4; only stiffness has strains"),
        ({"what": "stiffness", "eigenstrain": {"stone": -1e-4}}, "eigenstrain is stone=-1e-4; its phases must be mortar"),
        ({"what": "stiffness", "phases": {"mortar": {"poisson_ratio": 0.5}}}, "stiffness.mortar.poisson_ratio is 0.5"),
        # Pascals and per cent were solved.
        ({"what": "stiffness", "phases": {"mortar": {"youngs_modulus_mpa": 2e10}}}, "0 to 2000000 MPa: 2e10 Pa are 20000 MPa"),
        ({"what": "stiffness", "eigenstrain": {"mortar": -0.04}}, "stiffness.mortar.eigenstrain is -0.04; .*: -0.04 % are -0.0004"),
        ({"what": "stiffness", "eigenstrain": {"fibre": 1e-4}}, "stiffness.fibre.eigenstrain is .*; the specimen has no such phase"),
        ({"axes": "xx"}, "axes is"),
        ({"voxel_size": 20}, "voxel_size is 20; it must be at most 7.5 mm"),
        ({"phases": {"stone": 1}}, "stone"),
        ({"phases": {"mortar": 0}}, "diffusivity.mortar is 0; it must be 1e-30 to 1e30"),
    ],
)
def test_wrong_options_are_named_with_their_range(cube, options, said):
    with pytest.raises(ValueError, match=said):
        cube.effective(**options)


def test_moduli_that_may_be_gigapascals_are_warned_of():
    layers = np.zeros((8, 8, 8), np.uint8)
    layers[:4] = 1
    found = mc.effective(layers, "stiffness", phases={0: {"youngs_modulus_mpa": 20}, 1: {"youngs_modulus_mpa": 60}}, voxel_size=1)
    assert "moduli below 300 MPa (0, 1) are no mortar's: 20 GPa would be 20000 MPa" in found.warnings


def test_a_size_beyond_the_memory_is_refused_by_its_keyword(cube):
    """The message named element_size, which effective does not take (review of the first version)."""
    with pytest.raises(MemoryError, match=r"effective takes about .* take a larger voxel_size$"):
        cube.effective("stiffness", voxel_size=0.0305)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"what": "stiffness", "boundary": "uniform-flux"}, "is uniform-flux; stiffness takes fixed"),
        ({"element_size_mm": 2}, "is 2; only the method lattice takes it"),
        ({"eigenstrain": {"mortar": -1e-4}}, "is mortar=-1e-4; only stiffness has strains; take what = stiffness or all"),
        ({"tolerance": 0.5}, "is 0.5; it must be 1e-13 to 0.01"),
        ({"voxel_size_mm": 20}, "is 20; it must be at most 7.5 mm, a quarter of the shortest side"),
    ],
)
def test_command_and_python_refuse_alike_in_their_own_spelling(cube, options, said, tmp_path):
    """Their rules stood in two places, and their words differed (effective, stiffness with a boundary)."""
    key = next(name for name in reversed(options))
    cube.write(tmp_path / "m.json")
    flags = [f"--{name.replace('_', '-')}={next(f'{a}={b}' for a, b in value.items()) if isinstance(value, dict) else value}" for name, value in options.items()]
    run = subprocess.run([sys.executable, "-m", "mesocrete", "effective", "m.json", *flags], cwd=tmp_path, check=False, capture_output=True, text=True)
    assert (run.returncode, run.stderr.strip()) == (2, f"error: --{key.replace('_', '-')} {said}")
    with pytest.raises(ValueError, match=rf"^{key.removesuffix('_mm')} {re.escape(said)}$"):
        cube.effective(**{name.removesuffix("_mm"): value for name, value in options.items()})


def test_all_properties_are_one_request():
    small = mc.pack({**SPEC, "fraction": 0.1})
    found = small.effective("all", voxel_size=3, phases={"diffusivity": {"itz": 2.0}})
    assert [of["what"] if "what" in of else None for of in found] == ["diffusivity", "conductivity", "stiffness"]
    assert found[0] == small.effective(voxel_size=3, phases={"itz": 2.0})


def test_a_frame_of_a_test_has_the_properties_of_its_cracks():
    spec = {**SPEC, "specimen": {"kind": "cube", "side_mm": 30}}
    response = mc.pack(spec).mesh(element_size=3, for_test=True, accept_phase_error=True).solve(test="tension", strain=0.002, frames=2)
    found = response.effective(2, "permeability", axes="xz")
    assert found.frame == 2 and found.strain == response.frames[1].strain and found.what == "permeability"
    assert found.tensor[0][0] > 1e3 * found.tensor[2][2] > 0 and found.tensor[1][1] is None
    # The end is the last frame; water in the cracks conducts.
    wet, dry = (response.effective("last", crack_diffusivity=value, axes="x") for value in (500, 1))
    assert wet.tensor == response.effective(0.002, crack_diffusivity=500, axes="x").tensor and wet.frame == 0
    assert wet.tensor[0][0] > 2 * dry.tensor[0][0]
    assert [of.frame for of in response.effective("all", axes="x")] == [1, 2]
    with pytest.warns(UserWarning, match="frame 1, the nearest to the peak"):
        several = response.effective(what="all", phases={"conductivity": {"mortar": 2}}, axes="x")
    assert [of.what for of in several] == ["diffusivity", "conductivity", "permeability", "stiffness"]
    modulus, _, none = several[3].youngs_modulus_mpa
    assert 10_000 < modulus < 40_000 and none is None
    assert set(several[3]) == set(_results.Unloading.__annotations__) - OF_VOXELS - {"element_size_mm"}
    for keywords, message in (
        ({"frame": 3}, "frame is 3; the test has frames 1 to 2"),
        ({"frame": "middle"}, "peak, last, all, the number of a frame from 1, or a strain below 1"),
        ({"crack_roughness": 2}, "crack_roughness is 2; it must be 0 to 1"),
        ({"what": "strength"}, "strength"),
    ):
        with pytest.raises(ValueError, match=message):
            response.effective(**keywords)
    with pytest.raises(ValueError, match="the test has no frames; solve it again with frames 20"):
        mc.pack(spec).mesh(element_size=5, for_test=True, accept_phase_error=True).solve(strain=0.0005).effective()
