"""Label volumes become packings: `from_labels` takes arrays and files, and names what is wrong."""

import mesocrete as mc
import numpy as np
import pytest


@pytest.fixture(scope="module")
def labels():
    """Two balls, one of them cut by a face of the volume."""
    z, y, x = np.mgrid[:30, :30, :30] + 0.5
    labels = np.zeros((30, 30, 30), np.uint16)
    labels[(x - 9) ** 2 + (y - 12) ** 2 + (z - 14) ** 2 < 49] = 4
    labels[(x - 22) ** 2 + (y - 18) ** 2 + (z - 30) ** 2 < 64] = 700
    return labels


def test_the_grains_of_an_array_are_a_packing_that_is_sound(labels):
    packing = mc.from_labels(labels, 0.5)
    report = packing.report()["labels"]
    assert report["labels"] == [4, 700] and report["voxel_size_mm"] == [0.5, 0.5, 0.5]
    for aggregate, label in zip(packing.aggregates, report["labels"]):
        assert aggregate.volume == pytest.approx((labels == label).sum() * 0.5**3, rel=0.005)
    assert packing.check()["sound"] is True
    assert np.unique(packing.voxelize(0.5, what="grain")).tolist() == [-1, 0, 1]


def test_a_file_gives_the_packing_of_its_array(labels, tmp_path):
    np.save(tmp_path / "scan.npy", labels)
    assert mc.from_labels(tmp_path / "scan.npy", 0.5).fraction == mc.from_labels(labels, 0.5).fraction


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_slab_from_side_to_side_keeps_its_edges(axis):
    """The case: normal to z, 12 % of the slab were cut off, since a mean over large sides hides what is lost at an edge."""
    slab = np.zeros((60, 60, 60), np.uint8)
    np.moveaxis(slab, axis, 0)[20:31] = 1
    packing = mc.from_labels(slab, 1.0, largest_grain=0.9)
    assert packing.report()["labels"]["farthest_mm"] < 0.5
    assert packing.fraction == pytest.approx(11 / 60, rel=1e-3)


def test_a_slab_of_two_voxels_in_a_side_keeps_its_volume():
    """The case: 8 % were lost, since triangles in the side counted among those that a vertex must stay near."""
    slab = np.zeros((40, 40, 40), np.uint8)
    slab[:2] = 1
    packing = mc.from_labels(slab, 0.5, largest_grain=1.0)
    assert packing.fraction == pytest.approx(0.05, rel=1e-3)
    assert packing.report()["labels"]["farthest_mm"] < 0.1


def test_a_question_names_the_keyword_of_either_answer():
    """The case: a grain at two walls was asked about, and nothing took it."""
    walls = np.zeros((24, 24, 24), np.uint8)
    walls[14:20, 14:20, 14:20] = 2
    walls[:5] = walls[:, :5] = 1
    with pytest.raises(ValueError, match=r"is it mortar\? mortar=\[0, 1\] if so, or largest_grain=1 if it is a grain"):
        mc.from_labels(walls, 1.0)
    assert len(mc.from_labels(walls, 1.0, largest_grain=1)) == 2
    assert len(mc.from_labels(walls, 1.0, mortar=[0, 1])) == 1


def test_wrong_labels_and_options_are_named(labels):
    for arguments, kind, said in [
        ((labels * 0.5,), TypeError, "labels has dtype float64"),
        ((labels[0],), ValueError, "30 x 30 x 1 voxels"),
        ((labels, 0), ValueError, "voxel_size is 0; it must be a positive number"),
    ]:
        with pytest.raises(kind, match=said):
            mc.from_labels(*arguments)
    for options, said in [
        ({"mortar": [1]}, "mortar names 1, which the volume does not have"),
        ({"step": 9}, "step is 9; it must be 1 to 8 voxels"),
        ({"least_voxels": 10**6}, "no grain of 1000000 voxels"),
    ]:
        with pytest.raises(ValueError, match=said):
            mc.from_labels(labels, 0.5, **options)
    with pytest.raises(OSError):
        mc.from_labels("missing.npy")


def test_an_image_of_phases_is_read_back_by_the_numbers_of_its_grains_and_their_itz():
    """The case: the docs named the numbers of mortar and ITZ, which made one grain of the mortar."""
    spec = {
        "fraction": 0.15,
        "specimen": {"kind": "cube", "side_mm": 30},
        "grading": {"d_min_mm": 8, "d_max_mm": 12},
        "placement": {"min_gap_mm": 1.5},
    }
    packing = mc.pack(spec, seed=1)
    image = packing.voxelize(0.5, what="phase")
    with pytest.raises(ValueError, match=r"or aggregate=\[1, 2\] if these labels are one phase, as core and ITZ are"):
        mc.from_labels(image, 0.5)
    found = mc.from_labels(image, 0.5, aggregate=[1, 2])
    assert len(found) == len(packing)
    assert found.fraction == pytest.approx(packing.fraction, rel=0.02)


@pytest.mark.parametrize(
    ("spacing", "said"),
    [
        (float("nan"), "the file has the `spacing` `nan`, which is no length: slices are 1 mm apart, pixels 1 mm"),
        (float("inf"), "the file has the `spacing` `inf`, which is no length"),
        (0, "the file has the `spacing` `0`, which is no length"),
        (1e300, r"the file has voxels of 1 x 1 x 1e300 mm, which no specimen has, so it is 1 mm"),
        (1e-300, "which no specimen has, so it is 1 mm"),
    ],
)
def test_slices_without_a_length_apart_are_warned_of(tmp_path, labels, spacing, said):
    """The case: they were 1 mm apart without a word, and 1e300 mm ended in a bug."""
    tifffile = pytest.importorskip("tifffile")
    metadata = {"spacing": spacing, "unit": "mm", "axes": "ZYX"}
    tifffile.imwrite(tmp_path / "s.tif", labels, imagej=True, resolution=(1, 1), metadata=metadata)
    with pytest.warns(UserWarning, match=said):
        packing = mc.from_labels(tmp_path / "s.tif")
    assert packing.report()["labels"]["voxel_size_mm"] == [1.0, 1.0, 1.0]
