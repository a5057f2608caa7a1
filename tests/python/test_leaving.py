"""Leaving the program: CAD, scenes and surfaces, each read back by a program that is not ours."""

import gzip
import json

import numpy as np
import pytest

import mesocrete as mc

# The class colours of the pages and pictures, sRGB, as the pages' style sheet has them.
COLOURS = {0: (0x7F, 0xA8, 0xC9), 1: (0xC9, 0xA6, 0x6B), 2: (0xA3, 0xB1, 0x8A)}
FEW = {"specimen": {"kind": "cube", "side_mm": 30.0}, "fraction": 0.12}
SLENDER = FEW | {
    "voids": {"fraction": 0.01, "diameter_mm": [2.0, 3.0]},
    "fibres": {"fraction": 0.003, "length_mm": 12.0, "diameter_mm": 0.8},
}


@pytest.fixture(scope="module")
def few():
    return mc.pack(FEW, seed=3)


@pytest.fixture(scope="module")
def mixed():
    """Aggregates, voids and fibres."""
    return mc.pack(SLENDER, seed=3)


def names(packing):
    aggregates = [f"aggregate_{a.id}_class_{a.size_class}" for a in packing.aggregates]
    return aggregates + [f"{body.phase}_{body.id}" for body in packing.inclusions]


def bodies(packing):
    return [*packing.aggregates, *packing.inclusions]


def opened_in(gmsh, path):
    """The volumes of all solids by gmsh's OpenCASCADE, their names and colours, and the number of surfaces."""
    gmsh.option.setNumber("Geometry.OCCImportLabels", 1)
    solids = gmsh.model.occ.importShapes(str(path), highestDimOnly=True)
    gmsh.model.occ.synchronize()
    volumes = {}
    for dim, tag in solids:
        assert dim == 3
        name = gmsh.model.getEntityName(dim, tag).rsplit("/", 1)[-1]
        volumes[name] = (gmsh.model.occ.getMass(dim, tag), gmsh.model.getColor(dim, tag)[:3])
    return volumes, len(gmsh.model.getEntities(2))


def test_every_solid_of_a_step_has_its_volume_name_and_colour(mixed, tmp_path, gmsh):
    mixed.write(tmp_path / "part.step")
    found, _ = opened_in(gmsh, tmp_path / "part.step")
    assert set(found) == set(names(mixed))
    for body, name in zip(bodies(mixed), names(mixed), strict=True):
        volume, colour = found[name]
        assert volume == pytest.approx(body.volume, rel=1e-9)
        if body.phase == "aggregate":
            assert colour == COLOURS[body.size_class]


@pytest.mark.parametrize(
    "specimen",
    [
        {"kind": "cube", "side_mm": 30.0},
        {"kind": "cylinder", "diameter_mm": 30.0, "height_mm": 30.0},
        {"kind": "sphere", "diameter_mm": 36.0},
        {"kind": "notched-prism", "length_mm": 40, "width_mm": 30, "depth_mm": 30, "notch_depth_mm": 6, "notch_width_mm": 3},
    ],
    ids=lambda specimen: specimen["kind"],
)
def test_the_mortar_is_what_the_bodies_leave_of_the_specimen(specimen, tmp_path, gmsh):
    packing = mc.pack(FEW | {"specimen": specimen}, seed=3)
    packing.write(tmp_path / "part.stp", mortar=True)
    found, surfaces = opened_in(gmsh, tmp_path / "part.stp")
    mortar, _ = found.pop("mortar")
    grains = sum(volume for volume, _ in found.values())
    assert mortar + grains == pytest.approx(packing.report()["specimen"]["volume_mm3"], rel=1e-8)
    faces = sum(len(a.faces) for a in packing.aggregates)
    assert 2 * faces < surfaces <= 2 * faces + 24, "a cavity has the faces of its aggregate"


def test_a_periodic_specimen_has_no_mortar_of_one_piece(tmp_path, gmsh):
    packing = mc.pack(FEW | {"specimen": {"kind": "cube", "side_mm": 30.0, "periodic": ["x", "y", "z"]}}, seed=3)
    with pytest.raises(OSError, match="periodic"):
        packing.write(tmp_path / "part.step", mortar=True)
    packing.write(tmp_path / "part.step", images="cut")
    found, _ = opened_in(gmsh, tmp_path / "part.step")
    cut = sum(volume for volume, _ in found.values())
    assert len(found) == len(packing.aggregates), "images have their aggregate's name"
    assert cut > 0


def test_a_scene_has_a_named_coloured_object_per_body_in_metres(mixed, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    mixed.write(tmp_path / "scene.glb")
    scene = trimesh.load(tmp_path / "scene.glb")
    assert set(scene.geometry) == set(names(mixed))
    for body, name in zip(bodies(mixed), names(mixed), strict=True):
        mesh = scene.geometry[name]
        assert mesh.is_watertight
        assert mesh.volume == pytest.approx(body.volume, rel=1e-4)
        extras = scene.graph.transforms.edge_data["specimen", name]["metadata"]
        assert {"aggregate": body.id, "class": body.size_class}.items() <= extras.items()
        if body.phase == "aggregate":
            assert mesh.visual.material.name == f"class_{body.size_class}"
            linear = np.array(COLOURS[body.size_class]) / 255
            linear = ((linear + 0.055) / 1.055) ** 2.4
            assert mesh.visual.material.baseColorFactor[:3] == pytest.approx(255 * linear, abs=1)
    # A cube of 30 mm, with z upwards turned to y.
    low, high = scene.bounds
    assert (high - low).max() < 0.05
    top = max(a.vertices[:, 2].max() for a in bodies(mixed))
    assert high[1] == pytest.approx(top / 1000, rel=1e-5)


def test_a_ply_has_the_fields_and_colours_of_every_face(mixed, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    mixed.write(tmp_path / "grains.ply")
    mesh = trimesh.load(tmp_path / "grains.ply", process=False)
    assert mesh.volume == pytest.approx(sum(body.volume for body in bodies(mixed)), rel=1e-9)
    values = mesh.metadata["_ply_raw"]["face"]["data"]
    ids = np.concatenate([np.full(len(body.triangles), body.id) for body in bodies(mixed)])
    assert np.array_equal(np.ravel(values["aggregate"]), ids)
    classes = np.ravel(values["class"])
    for size_class, colour in COLOURS.items():
        assert np.all(mesh.visual.face_colors[classes == size_class][:, :3] == colour)
    assert set(np.ravel(values["phase"])) == {2, 3, 4}
    assert values["itz_thickness_mm"][0] == mixed.aggregates[0].itz_thickness


def test_an_obj_has_an_object_per_body(mixed, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    mixed.write(tmp_path / "grains.obj")
    mesh = trimesh.load(tmp_path / "grains.obj", process=False)
    volumes = sorted(part.volume for part in mesh.split())
    assert volumes == pytest.approx(sorted(body.volume for body in bodies(mixed)), rel=1e-9)
    assert set(COLOURS.values()) <= set(map(tuple, mesh.visual.vertex_colors[:, :3].tolist()))
    text = (tmp_path / "grains.obj").read_text(encoding="utf-8")
    assert [line[2:] for line in text.splitlines() if line.startswith("o ")] == names(mixed)


def test_an_stl_of_named_solids_has_one_per_body(mixed, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    mixed.write(tmp_path / "grains.stl", named_solids=True)
    scene = trimesh.load(tmp_path / "grains.stl")
    assert set(scene.geometry) == set(names(mixed))
    for body, name in zip(bodies(mixed), names(mixed), strict=True):
        assert scene.geometry[name].volume == pytest.approx(body.volume, rel=1e-4)
    mixed.write(tmp_path / "soup.stl")
    assert (tmp_path / "soup.stl").read_bytes()[:5] != b"solid"


@pytest.mark.parametrize("compress", [False, True])
def test_poly_data_hold_what_a_grid_of_surfaces_holds(mixed, tmp_path, compress):
    pyvista = pytest.importorskip("pyvista")
    mixed.write(tmp_path / "grains.vtp", compress=compress)
    mixed.write(tmp_path / "grains.vtu", compress=compress)
    surface, grid = pyvista.read(tmp_path / "grains.vtp"), pyvista.read(tmp_path / "grains.vtu")
    assert np.array_equal(surface.points, grid.points)
    assert surface.n_cells == grid.n_cells == sum(len(body.faces) for body in bodies(mixed))
    for field in ("aggregate", "class", "phase", "itz_thickness_mm"):
        assert np.array_equal(surface.cell_data[field], grid.cell_data[field])
    assert surface.triangulate().volume == pytest.approx(sum(body.volume for body in bodies(mixed)), rel=1e-6)


def test_a_compressed_model_is_the_same_text_and_every_reader_takes_it(mixed, run, tmp_path):
    mixed.write(tmp_path / "model.json")
    mixed.write(tmp_path / "model.json.gz")
    plain, packed = ((tmp_path / name).read_bytes() for name in ("model.json", "model.json.gz"))
    assert gzip.decompress(packed) == plain
    assert len(packed) < 0.5 * len(plain)
    assert mc.load(tmp_path / "model.json.gz") == mixed
    assert run("check", "model.json.gz").returncode == 0
    assert run("convert", "model.json.gz", "-o", "again.json").returncode == 0
    assert (tmp_path / "again.json").read_bytes() == plain
    assert json.loads(plain)["mesocrete"] == mc.__version__


def test_a_torn_compressed_model_is_refused_with_its_name(mixed, tmp_path):
    path = tmp_path / "model.json.gz"
    mixed.write(path)
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(ValueError, match="model.json.gz"):
        mc.load(path)
