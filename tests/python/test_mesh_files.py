"""Mesh files in programs that we did not write: counts, volumes and sets against the mesh in memory."""

import numpy as np
import pytest

PHASES = {"MORTAR": 0, "ITZ": 1, "AGGREGATE": 2}
SIDES = ("XMIN", "XMAX", "YMIN", "YMAX", "ZMIN", "ZMAX")


@pytest.fixture(scope="module", params=["voxel", "lattice", "second order"])
def mesh(request, packing):
    if request.param == "voxel":
        return packing.mesh(method="voxel", element_size=4.0)
    return packing.mesh(method="lattice", element_size=4.0, itz="none", order=1 + (request.param == "second order"))


def phase_counts(mesh):
    return {name: count for name, value in PHASES.items() if (count := int((mesh.phase == value).sum()))}


@pytest.mark.parametrize("compress", [False, True])
def test_pyvista_reads_a_vtu(mesh, tmp_path, compress):
    pyvista = pytest.importorskip("pyvista")
    path = tmp_path / "mesh.vtu"
    mesh.write(path, compress=compress)
    grid = pyvista.read(path)
    assert np.array_equal(grid.points, mesh.points)
    assert np.array_equal(grid.cell_data["phase"], mesh.phase)
    assert np.array_equal(grid.cell_data["aggregate"], mesh.aggregate)
    sizes = grid.compute_cell_sizes(length=False, area=False).cell_data["Volume"]
    assert sizes.sum() == pytest.approx(60.0**3, rel=1e-9)
    if mesh.cell_type != "hexahedron":
        quality = grid.cell_data["radius_ratio"]
        assert ((quality > 0) & (quality <= 1 + 1e-6)).all()


def test_a_compressed_vtu_is_smaller_and_holds_the_same(mesh, tmp_path):
    meshio = pytest.importorskip("meshio")
    for name, compress in (("raw", False), ("packed", True)):
        mesh.write(tmp_path / f"{name}.vtu", compress=compress)
    assert (tmp_path / "packed.vtu").stat().st_size < 0.6 * (tmp_path / "raw.vtu").stat().st_size
    raw = meshio.read(tmp_path / "raw.vtu")
    assert np.array_equal(raw.cells[0].data, mesh.cells)


@pytest.mark.parametrize("compress", [False, True])
def test_pyvista_reads_a_pvtu_whose_pieces_are_the_mesh(packing, tmp_path, compress):
    pyvista = pytest.importorskip("pyvista")
    mesh = packing.mesh(method="lattice", fit="plain", element_size=1.7, itz="none")
    mesh.write(tmp_path / "large & whole.pvtu", compress=compress)
    names = [f"large & whole_{i}.vtu" for i in range(-(-len(mesh) // 500_000))]
    assert len(names) > 1
    assert sorted(file.name for file in tmp_path.iterdir()) == sorted(["large & whole.pvtu", *names])
    grid = pyvista.read(tmp_path / "large & whole.pvtu")
    assert np.array_equal(grid.cell_data["phase"], mesh.phase)
    assert np.array_equal(grid.cell_data["aggregate"], mesh.aggregate)
    assert grid.cell_data["min_dihedral_deg"].min() == pytest.approx(mesh.quality()["min_dihedral_deg"][0], rel=1e-6)
    corners = grid.points[grid.cells.reshape(-1, 5)[:, 1:]]
    assert np.array_equal(corners, mesh.points[mesh.cells])
    assert grid.compute_cell_sizes()["Volume"].sum() == pytest.approx(60.0**3, rel=1e-9)
    with pytest.raises(FileExistsError, match="large & whole_0.vtu exists"):
        mesh.write(tmp_path / "large & whole.pvtu", overwrite=False)


def test_surfaces_can_be_compressed_too(packing, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    packing.write(tmp_path / "grains.vtu", compress=True)
    grid = pyvista.read(tmp_path / "grains.vtu")
    assert grid.n_points == sum(len(a.vertices) for a in packing.aggregates)
    assert grid.n_cells == sum(len(a.faces) for a in packing.aggregates)


def test_meshio_reads_a_msh_with_its_groups(mesh, tmp_path):
    meshio = pytest.importorskip("meshio")
    mesh.write(tmp_path / "mesh.msh")
    theirs = meshio.read(tmp_path / "mesh.msh")
    assert np.array_equal(theirs.points, mesh.points)
    tags = {name: tag for name, (tag, dimension) in theirs.field_data.items() if dimension == 3}
    physical = np.concatenate(
        [tag for block, tag in zip(theirs.cells, theirs.cell_data["gmsh:physical"]) if block.type == mesh.cell_type]
    )
    assert {name: int((physical == tag).sum()) for name, tag in tags.items()} == phase_counts(mesh)
    grains = zip(theirs.cells, theirs.cell_data["aggregate"])
    grains = np.concatenate([values.ravel() for block, values in grains if block.type == mesh.cell_type])
    assert sorted(grains) == sorted(mesh.aggregate)


def test_gmsh_reads_a_msh_with_its_volumes_sides_and_grains(mesh, tmp_path, gmsh):
    mesh.write(tmp_path / "mesh.msh")
    gmsh.open(str(tmp_path / "mesh.msh"))
    groups = {gmsh.model.getPhysicalName(*group): group for group in gmsh.model.getPhysicalGroups()}
    assert set(groups) == set(phase_counts(mesh)) | set(SIDES)
    count = {name: sum(map(len, elements(gmsh, group))) for name, group in groups.items()}
    assert {name: count[name] for name in phase_counts(mesh)} == phase_counts(mesh)
    on_side = np.isclose(mesh.points[:, 0], 60.0, atol=1e-9).sum()
    assert len(gmsh.model.mesh.getNodesForPhysicalGroup(*groups["XMAX"])[0]) == on_side
    assert len(gmsh.model.mesh.getNodes()[0]) == len(mesh.points)
    _, numbers, values, _, _ = gmsh.view.getModelData(gmsh.view.getTags()[0], 0)
    cells = np.concatenate([e for name in phase_counts(mesh) for e in elements(gmsh, groups[name])])
    grains = dict(zip(numbers, (value[0] for value in values)))
    assert sorted(grains[cell] for cell in cells) == sorted(mesh.aggregate)
    # The Jacobian is right only where every node of the element is where gmsh takes it to be.
    volumes = gmsh.model.mesh.getElementQualities(cells, "volume")
    assert volumes.min() > 0
    assert volumes.sum() == pytest.approx(60.0**3, rel=1e-9)
    assert gmsh.model.mesh.getElementQualities(cells, "minDetJac").min() > 0


def elements(gmsh, group):
    """The numbers of the elements of every entity of a physical group."""
    dimension, tag = group
    for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag):
        yield np.concatenate(gmsh.model.mesh.getElements(dimension, entity)[1])


def test_xdmf_keeps_its_arrays_in_hdf5_and_meshio_reads_both(mesh, tmp_path):
    meshio = pytest.importorskip("meshio")
    pytest.importorskip("h5py")
    mesh.write(tmp_path / "mesh.xdmf")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["mesh.h5", "mesh.xdmf"]
    theirs = meshio.read(tmp_path / "mesh.xdmf")
    assert np.array_equal(theirs.points, mesh.points)
    assert np.array_equal(theirs.cells[0].data, mesh.cells)
    assert np.array_equal(theirs.cell_data["phase"][0], mesh.phase)
    with pytest.raises(FileExistsError, match="mesh.xdmf exists"):
        mesh.write(tmp_path / "mesh.xdmf", overwrite=False)


def test_meshio_reads_a_deck_with_its_sets(mesh, tmp_path):
    meshio = pytest.importorskip("meshio")
    mesh.write(tmp_path / "mesh.inp")
    theirs = meshio.read(tmp_path / "mesh.inp")
    assert np.allclose(theirs.points, mesh.points, atol=1e-9)
    assert sum(len(block.data) for block in theirs.cells) == len(mesh)
    sizes = {name: sum(map(len, theirs.cell_sets[name])) for name in phase_counts(mesh)}
    assert sizes == phase_counts(mesh)
    assert len(theirs.point_sets["ZMIN"]) == np.isclose(mesh.points[:, 2], 0.0, atol=1e-9).sum()


def test_cohesive_elements_are_prisms_of_the_itz_in_gmsh(packing, tmp_path, gmsh):
    packing.mesh(method="lattice", element_size=4.0, itz="cohesive").write(tmp_path / "mesh.msh")
    gmsh.open(str(tmp_path / "mesh.msh"))
    itz = next(g for g in gmsh.model.getPhysicalGroups(3) if gmsh.model.getPhysicalName(*g) == "ITZ")
    (entity,) = gmsh.model.getEntitiesForPhysicalGroup(*itz)
    kinds, numbers, _ = gmsh.model.mesh.getElements(3, entity)
    assert list(kinds) == [6]
    assert len(numbers[0]) > 0
