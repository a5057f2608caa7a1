"""Voxel images: against half-spaces computed by numpy, and read back by programs that are not ours."""

import xml.etree.ElementTree
from pathlib import Path

import numpy as np
import pytest

import mesocrete as mc

CYLINDER = {"specimen": {"kind": "cylinder", "diameter_mm": 40, "height_mm": 30}, "fraction": 0.25}
PERIODIC = {"specimen": {"kind": "cube", "side_mm": 30, "periodic": ["x", "y", "z"]}, "fraction": 0.35}
FURTHER = {
    "specimen": {"kind": "box", "size_mm": [30, 24, 20]},
    "fraction": 0.2,
    "voids": {"fraction": 0.02, "diameter_mm": [1, 3]},
    "fibres": {"fraction": 0.01, "length_mm": 12, "diameter_mm": 1},
}
CODES = {"aggregate": 2, "void": 3, "fibre": 4}


def planes(body):
    """Outward unit normals and offsets of a body's triangles."""
    corners = body.vertices[body.triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals, (normals * corners[:, 0]).sum(axis=1)


def by_half_spaces(packing, h, inside=None):
    """Phases and ids of all voxels: every half-space of every body, and of its images, at every centre near it."""
    low, high = map(np.array, packing.bounds)
    counts = np.rint((high - low) / h).astype(int)
    axes = [low[i] + (np.arange(counts[i]) + 0.5) * h for i in range(3)]
    z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
    phase, grain = np.zeros(x.shape, np.uint8), np.full(x.shape, -1, np.int32)
    periodic = packing.spec.specimen.get("periodic", [])
    steps = [(-1, 0, 1) if name in periodic else (0,) for name in "xyz"]
    shifts = [np.array(s) * (high - low) for s in np.array(np.meshgrid(*steps)).reshape(3, -1).T]
    for body in [*packing.aggregates, *packing.inclusions]:
        normals, offsets = planes(body)
        for shift in shifts:
            corners = body.vertices + shift
            near = np.ones(x.shape, bool)
            for axis, values in enumerate((x, y, z)):
                near &= (values >= corners[:, axis].min()) & (values <= corners[:, axis].max())
            points = np.stack([x[near], y[near], z[near]], axis=1)
            height = (points @ normals.T - (offsets + normals @ shift)).max(axis=1, initial=-np.inf)
            at = [index[height <= 0] for index in np.nonzero(near)]
            shell = height[height <= 0] > -body.itz_thickness
            phase[tuple(at)] = np.where(shell & (body.phase == "aggregate"), 1, CODES[body.phase])
            grain[tuple(at)] = body.id
    if inside is not None:
        phase[~inside(x, y, z)], grain[~inside(x, y, z)] = 255, -2
    return phase, grain


@pytest.mark.parametrize(
    ("spec", "inside"),
    [
        (PERIODIC, None),
        (FURTHER, None),
        (CYLINDER, lambda x, y, z: (x - 20) ** 2 + (y - 20) ** 2 <= 400),
    ],
)
def test_every_voxel_has_the_phase_and_the_grain_of_the_half_spaces(spec, inside):
    """No voxel differs from a look at all half-spaces by numpy."""
    packing = mc.pack(spec, seed=3)
    phase, grain = by_half_spaces(packing, 0.5, inside)
    image = packing.voxelize(0.5)
    assert image.dtype == np.uint8 and image.flags.c_contiguous
    assert np.array_equal(image, phase)
    assert np.array_equal(packing.voxelize(0.5, what="grain"), grain)


def test_shares_have_the_fraction_and_the_shells_of_the_polyhedra(packing):
    """Summed shares are volumes; a voxel inside a grain has all of it."""
    shares = packing.voxelize(1.5, what="share")
    assert shares.dtype == np.float32 and shares.min() >= -1e-5 and shares.max() <= 1 + 1e-5
    assert shares.mean(dtype=np.float64) == pytest.approx(packing.fraction, rel=1e-5)
    shells = sum(a.volume - a.core().volume for a in packing.aggregates) / 60.0**3
    assert packing.voxelize(1.5, "share", of="itz").mean(dtype=np.float64) == pytest.approx(shells, rel=1e-4)
    fine = packing.voxelize(0.25, box=[[0, 0, 0], [15, 15, 15]])
    coarse = shares[:10, :10, :10]
    sampled = (fine > 0).reshape(10, 6, 10, 6, 10, 6).mean(axis=(1, 3, 5))
    assert np.abs(coarse - sampled).max() < 0.12 and np.abs((coarse - sampled).mean()) < 2e-3


def test_distances_are_metric_and_change_their_sign_at_the_surface(packing):
    """A distance is negative in a grain, at most a step from its neighbours', and the deepest is an inscribed radius."""
    distance = packing.voxelize(1.0, "distance")
    assert np.array_equal(distance <= 0, packing.voxelize(1.0, "grain") >= 0)
    assert all(np.abs(np.diff(distance, axis=axis)).max() <= 1 + 1e-5 for axis in range(3))


def test_sections_and_boxes_are_parts_of_the_whole(packing):
    """A section through the centres is a layer; a box is a slice."""
    whole = packing.voxelize(0.5)
    assert np.array_equal(packing.section("z", 30.25, px=120), whole[60])
    assert np.array_equal(packing.section("y", 30.25, px=120), whole[:, 60])
    assert np.array_equal(packing.section(y=30.25, px=120), whole[:, 60]), "as the command's --section y=30.25"
    for wrong in ({}, {"axis": "y", "y": 30.0}, {"x": 1.0, "y": 30.0}, {"at": 3.0, "z": 1.0}):
        with pytest.raises(TypeError, match=r'one plane: section\("y", at=50\) or section\(y=50\)'):
            packing.section(**wrong)
    assert np.array_equal(packing.section("y", px=119), packing.section("y", 30.0, px=119)), "the middle by default"
    assert np.array_equal(packing.section("x", 30.25, px=120), whole[:, :, 60])
    assert np.array_equal(packing.voxelize(0.5, box=[[5, 10, 15], [25, 40, 20]]), whole[30:40, 20:80, 10:50])


@pytest.mark.parametrize(
    ("ask", "error", "text"),
    [
        (lambda p: p.voxelize(0), ValueError, "^h is 0; it must lie within"),
        (lambda p: p.voxelize("1"), TypeError, "h"),
        (lambda p: p.voxelize(1, "colour"), ValueError, 'what is "colour"; it must be one of "phase"'),
        (lambda p: p.voxelize(1, of="itz"), ValueError, 'only for what="share"'),
        (lambda p: p.voxelize(1, box=[[0, 0, 0], [61, 1, 1]]), ValueError, "box is"),
        (lambda p: p.voxelize(1, box=[0, 0, 0, 9, 9, 9]), TypeError, "it must be a pair of corners in mm"),
        (lambda p: p.section("w", 1), ValueError, 'axis is "w"; it must be one of "x", "y", "z"'),
        (lambda p: p.section("z", 61), ValueError, "section is 61; it must lie within 0 and 60 mm"),
        (lambda p: p.section("z", 1, px=-1), ValueError, "px is -1; it must be 1 or more"),
        (lambda p: p.voxelize(0.001), ValueError, "mesocrete image"),
    ],
)
def test_impossible_pictures_are_named(packing, ask, error, text):
    """Every refusal names the option and the way out."""
    with pytest.raises(error, match=text.replace("[", r"\[")):
        ask(packing)


@pytest.fixture(scope="module")
def saved(packing, tmp_path_factory):
    """A saved model."""
    path = tmp_path_factory.mktemp("image") / "model.json"
    packing.write(path)
    return path


@pytest.mark.parametrize("what", ["phase", "grain", "share", "distance"])
def test_files_of_the_command_hold_the_arrays_of_python(packing, saved, run, tmp_path, what):
    """numpy, tifffile and PyVista read the same values, in the same order."""
    files = [tmp_path / f"image.{name}" for name in ("npy", "tif", "vti")]
    done = run("image", saved, "--voxel-size-mm", 2, "--what", what, *(x for f in files for x in ("-o", f)))
    assert done.returncode == 0, done.stderr
    expected = packing.voxelize(2, what)
    assert np.array_equal(np.load(files[0]), expected)
    tifffile = pytest.importorskip("tifffile")
    with tifffile.TiffFile(files[1]) as pages:
        assert np.array_equal(pages.asarray(), expected)
        assert pages.pages[0].resolution == (5.0, 5.0)
        about = pages.imagej_metadata
        assert (about["slices"], about["unit"], about["spacing"]) == (30, "cm", 0.2)
        assert pages.series[0].axes == "ZYX"
    pyvista = pytest.importorskip("pyvista")
    grid = pyvista.read(files[2])
    assert grid.spacing == (2.0, 2.0, 2.0) and grid.origin == (0.0, 0.0, 0.0)
    assert np.array_equal(grid.cell_data[what].reshape(30, 30, 30), expected)


def test_scikit_image_finds_the_grains(packing):
    """Ids plus one are labels: as many regions as grains that hold a voxel, with nearly their volumes."""
    measure = pytest.importorskip("skimage.measure")
    table = measure.regionprops_table(packing.voxelize(0.5, "grain") + 1, properties=("label", "area"))
    exact = np.array([packing.aggregates[int(label) - 1].volume for label in table["label"]])
    assert len(exact) == len(packing) and np.abs(table["area"] * 0.125 / exact - 1).max() < 0.1


def test_pictures_of_a_section_are_upright_and_hold_the_labels(packing, saved, run, tmp_path):
    """A .png has the labels as its indices, the lowest row below; an .svg is XML with a path for every outline."""
    done = run("image", saved, "--section", "y=30.25", "--voxel-size-mm", 0.5, "-o", "s.png", "-o", "s.svg", "-o", "s.npy")
    assert done.returncode == 0, done.stderr
    section = packing.section("y", 30.25, px=120)
    assert np.array_equal(np.load(tmp_path / "s.npy"), section)
    image = pytest.importorskip("PIL.Image")
    assert np.array_equal(np.array(image.open(tmp_path / "s.png"))[::-1], section)
    root = xml.etree.ElementTree.parse(tmp_path / "s.svg").getroot()
    assert root.tag.endswith("svg") and root.get("width") == "60mm"


EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "examples").glob("*.py"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_run_and_say_what_they_found(path, tmp_path, monkeypatch, capsys):
    """Each example ends with a line of results."""
    monkeypatch.chdir(tmp_path)
    for module in ("scipy.ndimage",) if "scipy" in path.read_text(encoding="utf-8") else ():
        pytest.importorskip(module)
    exec(compile(path.read_text(encoding="utf-8"), str(path), "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.strip()
