"""Data sets: many volumes from one call, with the same bytes on any number of jobs, and read by libraries that are not ours."""

import ast
import hashlib
import json
import pickle
import re
import warnings
from pathlib import Path

import numpy as np
import pytest

import mesocrete as mc

TINY = {"specimen": mc.Specimen.cube(30), "fraction": 0.25, "grading": mc.Grading.fuller(5, 10)}


def sampled(rng):
    return TINY | {"fraction": float(rng.uniform(0.15, 0.3))}


def contents(folder):
    """Every file and its hash."""
    files = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@pytest.mark.parametrize("sink", ["folder", "data.zarr"])
def test_a_data_set_has_the_same_bytes_on_any_number_of_jobs_and_after_a_loss(tmp_path, sink):
    """A case without a whole file is made again, and no other one."""
    arguments = {"shape": 24, "what": ["phase", "grain", "scan"], "scan": {"blur": 0}, "seed": 4, "model": True}
    one = mc.dataset(5, sampled, sink=tmp_path / "1" / sink, jobs=1, **arguments)
    mc.dataset(5, sampled, sink=tmp_path / "2" / sink, jobs=3, **arguments)
    whole = contents(tmp_path / "1" / sink)
    assert whole == contents(tmp_path / "2" / sink) and len([name for name in whole if name.endswith(".json.gz")]) == 5
    lost = next(tmp_path / "1" / sink / name for name in one.cases[3]["files"])
    lost.write_bytes(lost.read_bytes()[:-1])
    made = []
    mc.dataset(5, sampled, sink=tmp_path / "1" / sink, progress=lambda done, total: made.append((done, total)), **arguments)
    assert made == [(5, 5)] and contents(tmp_path / "1" / sink) == whole
    with pytest.raises(FileExistsError, match="holds 5 volumes .*, more than n = 3; this request is of 3 volumes"):
        mc.dataset(3, sampled, sink=tmp_path / "1" / sink, **arguments)
    shorter = mc.dataset(3, sampled, sink=tmp_path / "1" / sink, overwrite=True, **arguments)
    assert len(shorter) == 3 and shorter.cases == one.cases[:3]


SINKS = ["folder", "data.zarr", "data.h5"]
RANGES = {"fraction": (0.1, 0.25)}


def small(n, sink, sampler=RANGES, **changes):
    """A data set of eight voxels a side, and the numbers of volumes that the call made."""
    made = []
    arguments = {"spec": TINY, "shape": 8, "sink": sink, "progress": lambda done, _: made.append(done)} | changes
    return mc.dataset(n, sampler, **arguments), made


@pytest.mark.parametrize("sink", SINKS)
def test_another_request_destroys_no_data_set(tmp_path, sink):
    """The case: 200 volumes of 48 voxels became 5 of 128 without a word."""
    if sink.endswith("h5"):
        pytest.importorskip("h5py")
    path = tmp_path / sink
    data, _ = small(3, path)
    told = r"holds 3 volumes of shape 8, phase, fraction 0.1 to 0.25, seed 0, .*; this request is of"
    for change in (
        {"shape": 9},
        {"what": ["grain"]},
        {"seed": 1},
        {"sampler": {"fraction": (0.1, 0.2)}},
        {"spec": TINY | {"grading": mc.Grading.fuller(5, 9)}},
        {"sampler": None},
        {"n": 2},
    ):
        with pytest.raises(FileExistsError, match=told):
            small(**{"n": 3, "sink": path, **change})
    # Words that say the same of both requests name what differs.
    for change, word in [({"spec": TINY | {"grading": mc.Grading.fuller(5, 9)}}, "spec"), ({"targets": {"x": len}}, "targets"), ({"model": True}, "model")][: 2 if sink.endswith("h5") else 3]:
        with pytest.raises(FileExistsError, match=rf"holds 3 volumes of .*, with another {word}; this request is of"):
            small(**{"n": 3, "sink": path, **change})
    with pytest.raises(ValueError, match=r"n is 2.5; it must be a whole number from 1"):
        small(2.5, path)
    for wrong, message in [({"n": True}, "n is True; it must be an int"), ({"n": "2"}, "n is '2'"), ({"shape": 1.5}, "shape is 1.5; it must be a positive int or three")]:
        with pytest.raises(TypeError, match=message):
            small(**{"n": 3, "sink": path, **wrong})
    for wrong, message in [({"jobs": "2"}, "jobs is '2'; it must be a whole number from 1"), ({"jobs": 0}, "jobs is 0"), ({"shard": (1,)}, r"shard is \(1,\); it must be"), ({"shape": 0}, "shape is 0"), ({"shape": (4, 4)}, "shape is")]:
        with pytest.raises(ValueError, match=message):
            small(**{"n": 3, "sink": path, **wrong})
    for wrong, message in [({"targets": [1]}, r"targets is \[1\]; it must be a dict"), ({"scan": 5}, "scan is 5"), ({"overwrite": "no"}, "overwrite is 'no'; it must be True")]:
        with pytest.raises(TypeError, match=message):
            small(**{"n": 3, "sink": path, **wrong})
    assert small(np.int64(3), path, shape=np.int64(8))[1] == []
    assert mc.Dataset(path).cases == data.cases and small(3, path)[1] == []
    other, made = small(2, path, {"fraction": [0.1, 0.2]}, shape=5, overwrite=True)
    assert made == [1, 2] and len(other) == 2 and other[0]["phase"].shape == (5, 5, 5)


def test_files_of_others_are_no_data_set_and_stay(tmp_path):
    """Neither an array of one's own nor a group of zarr is taken for volumes."""
    for name, file in (("folder", "000000.npz"), ("d.zarr", ".zgroup"), ("d.zarr2.zarr", "zarr.json"), ("d.h5", None)):
        path = tmp_path / name if file is None else tmp_path / name / file
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(b"mine")
        if name.endswith("h5"):
            pytest.importorskip("h5py")
        with pytest.raises(FileExistsError, match="no data set; this request is of 1 volumes"):
            small(1, tmp_path / name)
        assert path.read_bytes() == b"mine"
    (tmp_path / "mixed" / "models").mkdir(parents=True)
    (tmp_path / "mixed" / "models" / "own.txt").write_text("mine")
    small(1, tmp_path / "mixed", model=True)
    small(1, tmp_path / "mixed", seed=2, overwrite=True)
    assert sorted(path.name for path in (tmp_path / "mixed" / "models").iterdir()) == ["own.txt"]


@pytest.mark.parametrize("sink", SINKS)
def test_a_data_set_grows_and_its_damage_is_found_and_made_again(tmp_path, sink):
    """The cases: n = 8 after n = 6 changed every volume; zeros in an HDF5 file and flipped bits were taken as done."""
    if sink.endswith("h5"):
        h5py = pytest.importorskip("h5py")
    path = tmp_path / sink
    first, _ = small(3, path)
    grown, made = small(5, path)
    assert made == [4, 5] and [case["hash"] for case in grown.cases[:3]] == [case["hash"] for case in first.cases]
    whole = [volume["phase"] for volume in grown]
    at_once, _ = small(5, tmp_path / "at_once" / sink)
    grown_files = {name: hash for name, hash in contents(tmp_path).items() if not name.startswith("at_once")}
    assert contents(tmp_path / "at_once") == grown_files
    for number in (0, 4):
        if sink.endswith("h5"):
            with h5py.File(path, "r+") as file:
                file["phase"][number] = 0
        else:
            damaged = path / next(iter(grown.cases[number]["files"]))
            flipped = bytearray(damaged.read_bytes())
            flipped[len(flipped) // 2] ^= 16
            damaged.write_bytes(flipped)
        with pytest.raises(OSError, match=f"volume {number} of .* is damaged; the same call of mc.dataset makes it again"):
            mc.Dataset(path)[number]
        again, made = small(5, path)
        assert made == [5] and all(np.array_equal(volume["phase"], old) for volume, old in zip(again, whole, strict=True))
    if not sink.endswith("h5"):
        record = path / "cases" / "000001.json"
        record.write_text(record.read_text(encoding="utf-8").replace('"voxel_size_mm": 3.75', '"voxel_size_mm": 3.85'), encoding="utf-8")
        assert small(5, path)[1] == [5]


def test_a_value_that_is_no_range_is_named(tmp_path):
    """The case: 'float' object is not iterable."""
    for value in (0.3, "0.3", {"low": 0.1}, None):
        with pytest.raises(TypeError, match=r"fraction is .*; give a range \(low, high\) or a list; what is the same for all goes"):
            small(2, tmp_path / "d", {"fraction": value})


def test_volumes_are_those_of_their_packings_in_every_sink(tmp_path):
    """The metadata give the packing again; sinks differ in their files alone."""
    sets = [mc.dataset(3, sampled, shape=20, what=["phase", "grain"], sink=tmp_path / name) for name in ("f", "d.zarr")]
    if pytest.importorskip("h5py"):
        sets.append(mc.dataset(3, sampled, shape=20, what=["phase", "grain"], sink=tmp_path / "d.h5"))
    for data in sets:
        assert [case["number"] for case in data.cases] == [0, 1, 2] and len({case["seed"] for case in data.cases}) == 3
        for volume, case in zip(pickle.loads(pickle.dumps(data)), data.cases, strict=True):
            assert volume["number"] == case["number"]
            packing = mc.pack(mc.Spec(**case["spec"]))
            assert packing.fraction == case["figures"]["fraction"] and case["voxel_size_mm"] == 1.5
            assert np.array_equal(volume["phase"], packing.voxelize(1.5))
            assert np.array_equal(volume["grain"], packing.voxelize(1.5, "grain")) and volume["grain"].dtype == np.int32
        assert data.table()["fraction"].tolist() == [case["figures"]["fraction"] for case in data.cases]
        assert data[1:][0]["number"] == 1 and mc.Dataset(data.path).cases == data.cases


def test_h5py_and_zarr_read_data_sets(tmp_path):
    """One array for each quantity, one chunk for each volume, and the metadata as JSON."""
    h5py = pytest.importorskip("h5py", reason="needs h5py (pip install h5py)")
    data = mc.dataset(2, sampled, shape=16, sink=tmp_path / "d.h5", seed=1)
    before = (tmp_path / "d.h5").read_bytes()
    with h5py.File(tmp_path / "d.h5") as file:
        assert file["phase"].shape == (2, 16, 16, 16) and file["phase"].chunks == (1, 16, 16, 16)
        assert np.array_equal(file["phase"][1], data[1]["phase"]) and json.loads(file["case"][1]) == data.cases[1]
    mc.dataset(2, sampled, shape=16, sink=tmp_path / "d.h5", seed=1, progress=lambda *_: pytest.fail("made twice"))
    (tmp_path / "d.h5").unlink()
    mc.dataset(2, sampled, shape=16, sink=tmp_path / "d.h5", seed=1)
    assert (tmp_path / "d.h5").read_bytes() == before and [path.name for path in tmp_path.iterdir()] == ["d.h5"]
    same = mc.dataset(2, sampled, shape=16, sink=tmp_path / "d.zarr", seed=1)
    assert np.array_equal(same[1]["phase"], data[1]["phase"])
    zarr = pytest.importorskip("zarr", reason="needs zarr (pip install zarr)")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        group = zarr.open_group(str(tmp_path / "d.zarr"), mode="r")
        assert sorted(name for name, _ in group.members()) == ["cases", "phase"]
    assert np.array_equal(group["phase"][1], data[1]["phase"])
    attributes = dict(group["phase"].attrs)
    assert attributes["voxel_size_mm"] == 1.875 and attributes["axes"] == ["volume", "z", "y", "x"]
    assert attributes["legend"]["2"] == "aggregate"


def test_a_latin_hypercube_has_one_volume_in_every_stratum(tmp_path):
    """Ranges are pairs, choices are lists; each volume has a seed of its own. Its first half is a hypercube of its own."""
    ranges = {"fraction": (0.1, 0.3), "grading.d_max_mm": [9, 10]}
    data = mc.dataset(8, ranges, spec=TINY, shape=8, sink=tmp_path / "d")
    table = data.table()
    assert sorted(((table["target_fraction"] - 0.1) / 0.2 * 8).astype(int)) == list(range(8))
    assert sorted(((table["target_fraction"][:4] - 0.1) / 0.2 * 4).astype(int)) == list(range(4))
    assert sorted(case["spec"]["grading"]["d_max_mm"] for case in data.cases) == [9] * 4 + [10] * 4
    assert len(set(table["seed"])) == 8 and set(data.cases[0]["values"]) == set(ranges)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n": 0}, "n is 0; it must be a whole number from 1 to 1,000,000"),
        ({"what": ["colour"]}, "what is .*colour.*; it must list some of phase, grain, share, distance, scan"),
        ({"scan": {"noise": 2}}, "noise is 2; it must be 0 or more, and below 1"),
        ({"scan": {"colour": 2}}, "scan has 'colour'; it must be one of blur"),
        ({"sampler": [TINY]}, "sampler has 1 specs; it must have n = 2"),
        ({"sampler": lambda _: {"fraction": 7}}, "volume 0: fraction is 7"),
        ({"sink": "d.h5", "model": True}, "an .h5 holds no models"),
        ({"sink": "d.hdf", "model": True}, "an .h5 holds no models"),
        ({"sink": "d.zarr", "sampler": [TINY, TINY | {"specimen": mc.Specimen.cylinder(20, 30)}]}, "a folder .* takes volumes of all"),
    ],
)
def test_wrong_options_of_a_data_set_are_named(tmp_path, arguments, message):
    sink = tmp_path / arguments.get("sink", "d")
    with pytest.raises(ValueError, match=message):
        mc.dataset(**{"n": 2, "sampler": sampled, "shape": 8, **arguments, "sink": sink})


def test_a_scan_mixes_phases_by_their_shares_and_repeats_itself():
    """Without blur, noise and rings its mean is that of the exact fractions; with them it is noisy about that."""
    packing = mc.pack(TINY, seed=3)
    grey = {"mortar": 0.4, "itz": 0.4, "aggregate": 0.8}
    clean = mc.scan(packing, shape=30, blur=0, noise=0, rings=0, grey=grey)
    cores = packing.voxelize(shape=30, what="share", of="core").mean()
    assert clean.shape == (30, 30, 30) and clean.dtype == np.uint8
    assert abs(clean.mean() / 255 - (0.4 + 0.4 * cores)) < 1e-3
    noisy = mc.scan(packing, shape=30, blur=0, noise=0.05, rings=0.03, grey=grey)
    assert np.array_equal(noisy, mc.scan(packing, 1.0, blur=0, noise=0.05, rings=0.03, grey=grey))
    assert abs((noisy.astype(float) - clean).std() / 255 - np.hypot(0.05, 0.03)) < 3e-3
    plain = mc.scan(packing, shape=30, blur=0, noise=0, rings=0, partial_volume=False, grey=grey)
    assert set(np.unique(plain)) == {102, 204}


def test_a_scan_blurs_and_has_rings_about_the_z_axis():
    """Pixels at one radius of a layer share their offset."""
    pytest.importorskip("scipy", reason="needs scipy (pip install scipy)")
    packing = mc.pack({"specimen": mc.Specimen.cylinder(20, 20), "fraction": 0.1, "grading": mc.Grading.fuller(5, 8)}, seed=1)
    rings = mc.scan(packing, 1.0, blur=0, noise=0, rings=0.1, grey=dict.fromkeys(["mortar", "itz", "aggregate"], 0.5))
    assert rings[5, 9, 0] == rings[5, 10, 19] and len(np.unique(rings)) > 20
    sharp, soft = (mc.scan(packing, 1.0, blur=blur, noise=0, rings=0) for blur in (0, 2.0))
    assert np.abs(np.diff(soft.astype(int))).max() < np.abs(np.diff(sharp.astype(int))).max() / 2
    assert sharp[0, 0, 0] == 5


def test_a_shape_gives_the_size_of_a_voxel():
    """Along the longest side, or for all three axes where cubes fit."""
    packing = mc.pack({"specimen": {"kind": "box", "size_mm": [20, 30, 40]}, "fraction": 0.1, "grading": {"d_max_mm": 8}})
    image = packing.voxelize(2.5)
    assert image.shape == (16, 12, 8)
    for shape in (16, (16, 12, 8)):
        assert np.array_equal(packing.voxelize(shape=shape), image)
    with pytest.raises(ValueError, match=r"voxels are cubes: the 20 x 30 x 40 mm fit \(16, 12, 8\), which shape=16 gives"):
        packing.voxelize(shape=(16, 16, 16))
    with pytest.raises(TypeError, match="give one of h"):
        packing.voxelize(1.0, shape=16)
    with pytest.raises(ValueError, match="shape is 0; it must be 1 or more"):
        packing.voxelize(shape=0)


def grains(packing):
    return len(packing)


def test_targets_are_numbers_of_each_volume_beside_its_arrays(tmp_path):
    """The case: properties as targets took a study beside the data set."""
    coarse = {"voxel_size": 2.5}
    targets = {
        "diffusivity": coarse | {"axis": "x"},
        "d_mean": coarse | {"of": "diffusivity", "phases": {"aggregate": 3.0}},
        "modulus": coarse | {"axis": "z"},
        "grains": grains,
    }
    data, made = small(2, tmp_path / "data.zarr", targets=targets)
    assert made == [1, 2]
    case = data.cases[1]
    packing = mc.pack(case["spec"], seed=case["seed"])
    found = packing.effective("diffusivity", voxel_size=2.5)
    assert data[1]["diffusivity"] == pytest.approx(found.tensor[0][0], rel=1e-8) and data[1]["diffusivity"] < 1.0
    assert case["targets"]["diffusivity_error"] == pytest.approx(found.error[0][0], rel=1e-6)
    richer = packing.effective("diffusivity", voxel_size=2.5, phases={"aggregate": 3.0}).tensor
    assert data[1]["d_mean"] == pytest.approx(np.trace(np.array(richer)) / 3, rel=1e-12) and data[1]["d_mean"] > 1.0
    stiffness = packing.effective("stiffness", voxel_size=2.5)
    assert data[1]["modulus"] == pytest.approx(1 / np.linalg.inv(np.array(stiffness.tensor))[2, 2], rel=1e-12)
    assert 0 < case["targets"]["modulus_error"] < 0.3 * data[1]["modulus"]
    assert data[1]["grains"] == len(packing) == data.table()["grains"][1]
    # The targets belong to the request, and the same ones are not made again.
    assert small(2, tmp_path / "data.zarr", targets=targets)[1] == []
    with pytest.raises(FileExistsError, match="another request|holds 2 volumes"):
        small(2, tmp_path / "data.zarr", targets={"diffusivity": coarse | {"axis": "y"}})


def test_another_function_as_a_target_is_another_request(tmp_path):
    """The case: two functions named `<lambda>` were one request, so that the second got the numbers of the first."""
    sink, factor = tmp_path / "data", 2.0
    of = lambda function, **keywords: small(1, sink, targets={"f": function}, **keywords)  # noqa: E731
    assert of(lambda packing: factor * packing.fraction)[0][0]["f"] == 2.0 * of(lambda packing: packing.fraction, overwrite=True)[0][0]["f"]
    with pytest.raises(FileExistsError, match="another sink"):
        of(lambda packing: 1.0 - packing.fraction)
    factor = 3.0
    with pytest.raises(FileExistsError):
        of(lambda packing: factor * packing.fraction)
    with pytest.raises(ValueError, match=r"targets\['f'\] returned 'much'; it must be a number"):
        of(lambda packing: "much", overwrite=True)


def test_wrong_targets_are_named_before_any_work(tmp_path):
    for targets, error, said in [
        ({"diffusivity": "w"}, ValueError, "axis is 'w'; it must be one of x, y, z, mean"),
        ({"strength": "z"}, ValueError, "of is 'strength'; it must be one of diffusivity, conductivity, modulus"),
        ({"modulus": {"size": 2}}, ValueError, "has 'size'; it takes of, axis, voxel_size"),
        ({"modulus": 3}, TypeError, "targets['modulus'] is 3; it must be an axis, a dict of keywords, or a function"),
    ]:
        with pytest.raises(error, match=re.escape(said)):
            small(2, tmp_path / "data", targets=targets)
    assert not (tmp_path / "data").exists()


def test_pytorch_loads_the_class_of_the_gallery(tmp_path):
    """Its workers get batches of the shapes and types that a network takes."""
    torch = pytest.importorskip("torch", reason="needs PyTorch (pip install torch)")
    pytest.importorskip("scipy")
    page = Path(__file__).parents[2] / "site" / "gallery" / "08_data_set.py"
    kept = [node for node in ast.parse(page.read_text(encoding="utf-8")).body if isinstance(node, ast.ClassDef)]
    names = {"mc": mc, "np": np, "Any": object}
    exec(compile(ast.Module(kept, []), page.name, "exec"), names)
    data = mc.dataset(4, sampled, shape=16, what=["phase", "scan"], sink=tmp_path / "data.zarr")
    plain = next(iter(torch.utils.data.DataLoader(data, batch_size=2)))
    assert plain["phase"].shape == (2, 16, 16, 16) and plain["number"].tolist() == [0, 1]
    batches = list(torch.utils.data.DataLoader(names["Volumes"](data), batch_size=2, num_workers=1))
    assert [(tuple(scan.shape), tuple(label.shape)) for scan, label in batches] == [((2, 1, 16, 16, 16), (2, 16, 16, 16))] * 2
    assert all(scan.dtype == torch.float32 and label.dtype == torch.int64 for scan, label in batches)
