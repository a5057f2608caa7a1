"""Meshes from Python: arrays, files, and what other libraries make of them."""

import pickle

import numpy as np
import pytest

import mesocrete as mc
import mesocrete._mesocrete


@pytest.fixture(scope="module")
def mesh(packing):
    return packing.mesh(method="voxel", element_size=3.0, itz="solid", accept_phase_error=True)


def test_arrays_have_the_documented_shapes(mesh):
    assert mesh.points.shape == (21**3, 3)
    assert mesh.points.dtype == np.float64
    assert mesh.cells.shape == (20**3, 8) == (len(mesh), 8)
    assert mesh.cells.min() == 0
    assert mesh.cells.max() == len(mesh.points) - 1
    assert mesh.phase.shape == mesh.aggregate.shape == (20**3,)
    assert set(np.unique(mesh.phase)) == {0, 1, 2}
    assert mesh.cell_type == "hexahedron"


def test_cells_of_aggregates_name_theirs_and_mortar_names_none(mesh, packing):
    assert (mesh.aggregate[mesh.phase == 0] == -1).all()
    assert (mesh.aggregate[mesh.phase != 0] >= 0).all()
    assert mesh.aggregate.max() < len(packing)


def test_volumes_add_up_to_the_specimen(mesh, packing):
    volumes = mesh.volumes()
    assert sum(volumes.values()) == pytest.approx(60.0**3, rel=1e-12)
    assert volumes["aggregate"] == pytest.approx(27.0 * (mesh.phase == 2).sum(), rel=1e-12)


def test_a_finer_mesh_comes_closer_to_the_exact_fraction(packing):
    fractions = [packing.mesh(element_size=h, itz="none").volumes()["aggregate"] / 60.0**3 for h in (6.0, 1.0)]
    errors = [abs(fraction - packing.fraction) for fraction in fractions]
    assert errors[1] < 0.002
    assert errors[1] <= errors[0]


def test_meshes_compare_by_value_and_say_what_they_are(mesh, packing):
    assert packing.mesh(element_size=3.0, itz="solid", accept_phase_error=True) == mesh
    assert packing.mesh(element_size=6.0) != mesh
    assert repr(mesh) == "Mesh(9,261 points, 8,000 cells of type hexahedron)"


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"method": "voxels"}, ValueError, "method is \"voxels\".*voxel"),
        ({"method": 3}, TypeError, "method"),
        ({"element_size": -1.0}, ValueError, "^element_size is -1"),
        ({"element_size": 0.0}, ValueError, "^element_size is 0"),
        ({"element_size": float("nan")}, ValueError, "^element_size is NaN"),
        ({"element_size": 1e-6}, ValueError, "^element_size is"),
        ({"element_size": "fine"}, TypeError, "^element_size is"),
        ({"itz": "thick"}, ValueError, "itz is \"thick\".*solid"),
        ({"size": 2.0}, ValueError, "size is not a known key; did you mean element_size[?]"),
        ({"elementsize": 2.0}, ValueError, "elementsize is not a known key.*element_size[?]"),
    ],
)
def test_options_that_cannot_be_are_named(packing, options, error, message):
    with pytest.raises(error, match=message):
        packing.mesh(**options)


def test_meshio_gets_the_same_mesh_with_a_set_per_phase(mesh):
    pytest.importorskip("meshio")
    theirs = mesh.to_meshio()
    assert np.array_equal(theirs.points, mesh.points)
    assert np.array_equal(theirs.cells[0].data, mesh.cells)
    for name, phase in (("MORTAR", 0), ("ITZ", 1), ("AGGREGATE", 2)):
        assert np.array_equal(theirs.cell_sets[name][0], np.flatnonzero(mesh.phase == phase))


def test_pyvista_gets_the_same_mesh_and_measures_the_same_volume(mesh):
    pytest.importorskip("pyvista")
    grid = mesh.to_pyvista()
    assert grid.n_cells == len(mesh)
    assert np.array_equal(grid.cell_data["phase"], mesh.phase)
    assert grid.compute_cell_sizes()["Volume"].sum() == pytest.approx(60.0**3, rel=1e-9)


def test_deck_options_are_those_of_the_command(mesh, tmp_path):
    mesh.write(tmp_path / "deck.inp")
    mesh.write(tmp_path / "geometry.inp", geometry_only=True, reduced_integration=True)
    deck, geometry = ((tmp_path / f"{name}.inp").read_text(encoding="ascii") for name in ("deck", "geometry"))
    assert "*MATERIAL" in deck.upper()
    assert "*MATERIAL" not in geometry.upper()
    assert "C3D8R" in geometry
    mesh.write(tmp_path / "run.inp", analysis="compression", friction=0.6, frames=9)
    deck = (tmp_path / "run.inp").read_text(encoding="ascii")
    assert "*FRICTION\n0.6,\n" in deck and "NUMBER INTERVAL=9\n" in deck
    with pytest.raises(ValueError, match="materials.mortar_strength.tensile_mpa is -3"):
        mesh.write(tmp_path / "wrong.inp", materials={"mortar_strength": {"tensile_mpa": -3.0}})
    with pytest.raises(ValueError, match="geometryonly is not a known key; did you mean geometry_only"):
        mesh.write(tmp_path / "wrong.inp", geometryonly=True)


def test_lattices_of_tetrahedra_are_meshes_too(packing):
    mesh = packing.mesh(method="lattice", element_size=4.0, accept_phase_error=True)
    assert mesh.cell_type == "tetra"
    assert mesh.cells.shape[1] == 4
    assert sum(mesh.volumes().values()) == pytest.approx(60.0**3, rel=1e-9)


def test_second_order_adds_a_node_in_the_middle_of_every_edge(packing):
    linear, quadratic = (packing.mesh(method="lattice", element_size=6.0, order=order, accept_phase_error=True) for order in (1, 2))
    assert quadratic.cell_type == "tetra10"
    assert np.array_equal(quadratic.cells[:, :4], linear.cells)
    ends = quadratic.cells[:, [0, 1, 2, 0, 1, 2]], quadratic.cells[:, [1, 2, 0, 3, 3, 3]]
    middles = (quadratic.points[ends[0]] + quadratic.points[ends[1]]) / 2.0
    assert np.array_equal(quadratic.points[quadratic.cells[:, 4:]], middles)
    assert quadratic.volumes() == linear.volumes()
    with pytest.raises(ValueError, match="order is 2; voxels take 1"):
        packing.mesh(order=2)


def test_cohesive_elements_notes_and_quality_are_there(packing):
    mesh = packing.mesh(method="lattice", element_size=4.0, itz="cohesive")
    bottom, top = mesh.cohesive[:, :3], mesh.cohesive[:, 3:]
    assert len(bottom) > 100
    assert (bottom != top).all()
    assert np.array_equal(mesh.points[bottom], mesh.points[top])
    assert mesh.notes["pinched_itz_nodes"] == 0
    assert mesh.notes.keys() >= {"closed_gaps", "closed_gap_pairs", "widest_closed_gap_mm", "thinned_itz_nodes"}
    quality = mesh.quality()
    assert quality["cells"] == len(mesh)
    assert quality["inverted"] == 0
    assert sum(quality["dihedral_histogram"]) == len(mesh)
    distance = quality["interface_distance"]
    assert distance["nodes"] == len(np.unique(mesh.points[np.unique(bottom)], axis=0))
    # Elements of nearly the size of the smallest aggregates cut these off.
    assert 0.0 <= distance["rms_mm"] < 1.0 and distance["rms_mm"] <= distance["max_mm"] < 6.0
    assert 0 < distance["joined"] < distance["nodes"] and distance["max_mm"] <= distance["joined_max_mm"] < 6.0
    worst, cell = quality["min_dihedral_deg"]
    assert list(mesh.bad_cells(np.nextafter(worst, 180.0))) == [cell]
    assert len(mesh.bad_cells(0.0)) == 0
    assert quality["bad_cells"] == list(mesh.bad_cells(8.0))
    assert quality["volumes_mm3"] == mesh.volumes()
    exact = quality["exact_volumes_mm3"]
    assert exact["aggregate"] / 60.0**3 == pytest.approx(packing.fraction, rel=1e-9)
    assert sum(exact.values()) == pytest.approx(60.0**3, rel=1e-12)


def test_conforming_meshes_keep_the_volume_to_the_last_digits():
    pytest.importorskip("gmsh")
    spec = {"fraction": 0.2, "specimen": {"kind": "cube", "side_mm": 30.0}}
    packing = mc.pack({**spec, "placement": {"min_gap_mm": 0.1, "wall_gap_mm": 0.1}})
    mesh = packing.mesh(method="conforming", element_size=4.0, itz="none")
    assert mesh.volumes()["aggregate"] / 30.0**3 == pytest.approx(packing.fraction, rel=1e-10)


@pytest.mark.parametrize("itz", ["none", "solid", "cohesive"])
def test_opposite_faces_of_a_periodic_conforming_mesh_have_the_same_triangles(itz, tmp_path):
    pytest.importorskip("gmsh")
    meshio = pytest.importorskip("meshio")
    specimen = {"kind": "cube", "side_mm": 30.0, "periodic": ["x", "y"]}
    gaps = {"min_gap_mm": 0.1, "wall_gap_mm": 0.1}
    packing = mc.pack({"fraction": 0.3, "specimen": specimen, "placement": gaps})
    packing.mesh(method="conforming", element_size=4.0, itz=itz).write(tmp_path / "mesh.vtu")
    mesh = meshio.read(tmp_path / "mesh.vtu")
    cells = np.concatenate([block.data for block in mesh.cells if block.type == "tetra"])
    triangles = mesh.points[np.concatenate([np.delete(cells, corner, axis=1) for corner in range(4)])]
    for axis in (0, 1):
        on_side = [(triangles[:, :, axis] == place).all(axis=1) for place in (0.0, 30.0)]
        lower, upper = (sorted(sorted(map(tuple, t)) for t in np.delete(triangles[on], axis, 2)) for on in on_side)
        assert len(lower) > 100
        assert lower == upper


def test_both_readers_read_the_vtu(mesh, tmp_path):
    mesh.write(tmp_path / "mesh.vtu")
    pyvista, meshio = pytest.importorskip("pyvista"), pytest.importorskip("meshio")
    grid = pyvista.read(tmp_path / "mesh.vtu")
    assert np.array_equal(grid.points, mesh.points)
    assert np.array_equal(grid.cell_data["phase"], mesh.phase)
    theirs = meshio.read(tmp_path / "mesh.vtu")
    assert np.array_equal(theirs.points, mesh.points)
    assert np.array_equal(theirs.cells[0].data, mesh.cells)


def test_a_mesh_that_lost_a_phase_is_an_error_unless_it_is_accepted(packing):
    coarse = {"element_size": 4.0, "itz": "solid"}
    with pytest.raises(ValueError, match=r"the ITZ takes .* where 10 % are accepted; take .*; accept_phase_error=True accepts it"):
        packing.mesh(**coarse)
    assert packing.mesh(**coarse, accept_phase_error=True).volumes()["itz"] > 0


def test_a_packing_for_a_test_is_that_of_the_command(run, tmp_path):
    (tmp_path / "s.toml").write_text('fraction = 0.3\nseed = 5\n[specimen]\nkind = "cube"\nside_mm = 30.0\n')
    for name, flags, keywords in [
        ("test", ["--analysis", "compression", "--element-size-mm", "2.5"], {"for_test": True, "element_size": 2.5}),
        ("facets", ["--method", "conforming"], {"method": "conforming"}),
        ("plain", [], {}),
    ]:
        done = run("pack", "s.toml", "-qo", f"{name}.json", *flags)
        assert done.returncode == 0, done.stderr
        mc.pack(tmp_path / "s.toml", **keywords).write(tmp_path / "own.json")
        assert (tmp_path / "own.json").read_bytes() == (tmp_path / f"{name}.json").read_bytes(), name
    gap = mc.load(tmp_path / "test.json").spec.placement["min_gap_mm"]
    assert gap == 1.25


def test_control_characters_of_names_are_escaped_in_messages(tmp_path):
    # shared/cases/trust/escape.toml
    path = tmp_path / "escape.toml"
    path.write_text('"\\u001b[2J\\u001b]0;title\\u0007" = 1\n')
    with pytest.raises(ValueError, match="is not a known key") as caught:
        mc.pack(path)
    assert r"\u{1b}[2J\u{1b}]0;title\u{7}" in str(caught.value)
    with pytest.raises(ValueError, match="is not a known key") as caught:
        mc.Spec(**{"\x1b[2J": 1})
    assert str(caught.value).isprintable()


def test_a_mesh_beyond_the_memory_is_refused_before_it_is_taken(packing, monkeypatch):
    big = mc.pack({"specimen": {"kind": "cube", "side_mm": 1400.0}, "grading": {"d_min_mm": 100.0, "d_max_mm": 200.0}}, fraction=0.05)
    with pytest.raises(MemoryError, match="GB are free; take a larger element_size"):
        big.mesh(method="lattice", element_size=1.0, itz="none")


def test_a_mesh_is_pickled_with_its_packing_and_meshes_on():
    packing = mc.pack({"specimen": mc.Specimen.cube(40), "fraction": 0.2}, seed=3)
    for options in ({"method": "voxel", "element_size": 4.0}, {"method": "lattice", "element_size": 4.0, "itz": "cohesive"}):
        mesh = packing.mesh(**options, accept_phase_error=True)
        again = pickle.loads(pickle.dumps(mesh))
        assert again == mesh and again.notes == mesh.notes
        assert again.quality() == mesh.quality()
    _, (state, model, options) = mesh.__reduce__()
    broken = (*state[:2], state[2] + np.uint32(1_000_000), *state[3:])
    with pytest.raises(ValueError, match="the pickle is damaged: its arrays do not fit each other"):
        mesocrete._mesocrete._restore_mesh(broken, model, options)


def test_notebooks_show_meshes_and_specs_as_html():
    packing = mc.pack({"specimen": mc.Specimen.cube(40), "fraction": 0.2}, seed=3)
    shown = packing.mesh(element_size=4.0, accept_phase_error=True)._repr_html_()
    assert "1,000, hexahedron" in shown and "mortar" in shown
    assert packing.spec._repr_html_().startswith("<pre>") and "fraction = 0.2" in packing.spec._repr_html_()
