"""Meshes read back by programs that are not ours: gmsh, meshio, PyVista, PyDyna (Ansys), mapdl-archive, tifffile."""

import json

import mesocrete as mc
import numpy as np
import pytest

SIDES = ("XMIN", "XMAX", "YMIN", "YMAX", "ZMIN", "ZMAX")
PARTS = {2: 1, 1: 2, 0: 3, 4: 4}  # of a phase: aggregate, ITZ, mortar, fibre


def pack(periodic):
    specimen = mc.Specimen.cube(30, periodic=periodic)
    spec = {"specimen": specimen, "fraction": 0.3, "placement": {"min_gap_mm": 1.0}, "grading": mc.Grading.fuller(6, 12)}
    return mc.pack(spec)


CASES = {
    "voxels": (False, {"method": "voxel", "element_size": 3.0, "itz": "none"}),
    "voxels with cohesive ITZ": (False, {"method": "voxel", "element_size": 3.0, "itz": "cohesive", "joined": "mortar"}),
    "lattice": (True, {"method": "lattice", "element_size": 4.0, "itz": "none"}),
    "lattice with cohesive ITZ": (True, {"method": "lattice", "element_size": 4.0, "itz": "cohesive"}),
    "second order": (False, {"method": "lattice", "element_size": 5.0, "itz": "none", "order": 2}),
}


@pytest.fixture(scope="module", params=CASES)
def mesh(request):
    periodic, options = CASES[request.param]
    # Small and coarse: what is read back counts, and not the volumes.
    return pack(periodic).mesh(**options, accept_phase_error=True)


def sides(mesh):
    """The nodes on the bounding planes, by name."""
    points = mesh.points
    low, high = points.min(axis=0), points.max(axis=0)
    near = 1e-9 * (high - low).max()
    ends = [np.flatnonzero(np.abs(points[:, axis] - end[axis]) <= near) for axis in range(3) for end in (low, high)]
    return dict(zip(SIDES, ends, strict=True))


def test_vtu_has_every_cell_and_every_cohesive_element(mesh, tmp_path):
    """Wedges, or hexahedra between voxels, follow the cells in meshio, PyVista and to_meshio; they are of the ITZ."""
    meshio, pyvista = pytest.importorskip("meshio"), pytest.importorskip("pyvista")
    joints = mesh.cohesive
    for name in ("mesh.vtu", "mesh.pvtu"):
        mesh.write(tmp_path / name)
        grid = pyvista.read(tmp_path / name)
        assert grid.n_cells == len(mesh.cells) + len(joints)
        assert (grid.cell_data["phase"] == 1).sum() == (mesh.phase == 1).sum() + len(joints)
    read = meshio.read(tmp_path / "mesh.vtu")
    assert np.array_equal(read.points, mesh.points)
    for form in (read, mesh.to_meshio()):
        nodes = np.concatenate([block.data.ravel() for block in form.cells])
        assert np.array_equal(nodes[: mesh.cells.size], mesh.cells.ravel())
        # VTK turns wedges about: the base of its wedge looks outwards.
        faces = nodes[mesh.cells.size :].reshape(joints.shape)
        assert np.array_equal(np.sort(faces, axis=1), np.sort(joints, axis=1))
    assert mesh.to_pyvista().n_cells == grid.n_cells


def test_gmsh_and_meshio_read_periodic_pairs(mesh, tmp_path, gmsh):
    """Every pair of a periodic surface is a period apart within 1e-12."""
    meshio = pytest.importorskip("meshio")
    mesh.write(tmp_path / "mesh.msh")
    points = mesh.points
    lengths = points.max(axis=0) - points.min(axis=0)
    pairs = {}
    for dimension, (slave, master), _, nodes in meshio.read(tmp_path / "mesh.msh").gmsh_periodic or ():
        assert (dimension, slave - master, slave % 2) == (2, 1, 0)
        pairs[int(slave)] = nodes
        step = np.eye(3)[slave // 2 - 1] * lengths
        assert np.abs(points[nodes[:, 0]] - points[nodes[:, 1]] - step).max() < 1e-12
    gmsh.open(str(tmp_path / "mesh.msh"))
    found = sides(mesh)
    for slave, nodes in pairs.items():
        master, own, _, _ = gmsh.model.mesh.getPeriodicNodes(2, slave)
        assert master == slave - 1 and sorted(own) == sorted(nodes[:, 0] + 1)
        if not len(mesh.cohesive):
            assert np.array_equal(np.sort(nodes[:, 0]), found[SIDES[slave - 1]])


def test_ansys_archives_hold_nodes_cells_and_components(mesh, tmp_path):
    """mapdl-archive finds every node within 1e-12, every element, and the sets."""
    reader = pytest.importorskip("mapdl_archive", reason="needs mapdl-archive (pip install mapdl-archive)")
    mesh.write(tmp_path / "mesh.cdb")
    archive = reader.Archive(str(tmp_path / "mesh.cdb"))
    assert np.abs(archive.nodes - mesh.points).max() < 1e-12
    elements = [element[10:] - 1 for element in archive.elem]
    width, joints = mesh.cells.shape[1], mesh.cohesive
    cells = np.array([element[:width] for element in elements[: len(mesh.cells)]])
    assert np.array_equal(cells, mesh.cells) and len(elements) == len(mesh.cells) + len(joints)
    if joints.shape[1] == 6 and len(joints):
        assert np.array_equal(np.array(elements[len(mesh.cells) :])[:, [0, 1, 2, 4, 5, 6]], joints)
    for name, nodes in sides(mesh).items():
        assert np.array_equal(np.sort(archive.node_components[name]) - 1, nodes)
    itz = archive.element_components.get("ITZ", [])
    assert len(itz) == (mesh.phase == 1).sum() + len(joints)


def keyword_deck(path):
    """Read a .k by Ansys' own keyword classes; nothing may stay unread."""
    core = pytest.importorskip("ansys.dyna.core", reason="needs PyDyna (pip install ansys-dyna-core)")
    deck = core.Deck()
    deck.import_file(str(path))
    assert not deck.string_keywords, deck.string_keywords
    return deck


def keywords(deck, title):
    return [keyword for keyword in deck.keywords if keyword.get_title().startswith(title)]


def test_keyword_decks_hold_nodes_elements_parts_and_sets(mesh, tmp_path):
    """PyDyna finds every node within 1e-12, every element with its part, and the sets."""
    mesh.write(tmp_path / "mesh.k")
    deck = keyword_deck(tmp_path / "mesh.k")
    nodes = keywords(deck, "*NODE")[0].nodes
    assert np.abs(nodes[["x", "y", "z"]].to_numpy(float) - mesh.points).max() < 1e-12
    width, joints = mesh.cells.shape[1], mesh.cohesive
    blocks = [block.elements for block in keywords(deck, "*ELEMENT_SOLID")]
    columns = [f"n{i + 1}" for i in range(width)]
    assert np.array_equal(blocks[0][columns].to_numpy(int) - 1, mesh.cells)
    assert np.array_equal(blocks[0]["pid"].to_numpy(int), [PARTS[phase] for phase in mesh.phase])
    if len(joints):
        order = [f"n{i}" for i in ((1, 2, 3, 5, 6, 7) if joints.shape[1] == 6 else range(1, 9))]
        assert np.array_equal(blocks[1][order].to_numpy(int) - 1, joints)
    found = sides(mesh)
    sets = {keyword.title: keyword for keyword in keywords(deck, "*SET_NODE_LIST")}
    for name, members in found.items():
        assert np.array_equal(np.sort([node for node in sets[name].nodes.data if node]) - 1, members)
    segments = {keyword.title: keyword.segments for keyword in keywords(deck, "*SET_SEGMENT")}
    assert set(segments) == set(SIDES) and all(len(of_side) for of_side in segments.values())


@pytest.mark.parametrize(
    ("analysis", "law", "material"),
    [
        ("compression", "cdpm", "*MAT_CDPM"),
        ("tension", "rel3", "*MAT_CONCRETE_DAMAGE_REL3"),
        ("impact", "cscm", "*MAT_CSCM_CONCRETE"),
    ],
)
def test_templates_of_tests_are_read_without_a_word_left(tmp_path, analysis, law, material):
    """Every card of the three templates has its fields where PyDyna, after the manual, expects them."""
    mesh = pack(False).mesh(
        method="lattice", element_size=4.0, itz="smeared", joined="mortar", accept_phase_error=True
    )
    mesh.write(tmp_path / "test.k", analysis=analysis, lsdyna_law=law)
    deck = keyword_deck(tmp_path / "test.k")
    assert [keyword.mid for keyword in keywords(deck, material)] == [2, 3]
    if analysis != "tension":
        contact = keywords(deck, "*CONTACT")[0]
        assert (contact.surfa, contact.surfb, contact.surfatyp, contact.surfbtyp, contact.fs) == (5, 11, 4, 3, 0.1)
    if analysis == "impact":
        assert keywords(deck, "*INITIAL_VELOCITY_RIGID_BODY")[0].vz == -5000.0
    if analysis == "compression":
        law = keywords(deck, material)[1]
        assert (law.ft, law.fc, law.type, law.efc > 0) == (3.4, 40.0, 1.0, True)


@pytest.mark.parametrize(("size", "options"), [(3, ["--method", "voxel"]), (4, ["--method", "lattice"])])
@pytest.mark.parametrize("itz", ["none", "cohesive"])
def test_xdmf_of_the_command_has_every_cell_and_every_cohesive_element(run, tmp_path, size, options, itz):
    """meshio and VTK's reader of XDMF find points, cells and phases of the .vtu."""
    meshio, pyvista = pytest.importorskip("meshio"), pytest.importorskip("pyvista")
    pack(False).write(tmp_path / "model.json")
    flags = [*options, "--element-size-mm", size, "--itz", itz, "--accept-phase-error"]
    done = run("mesh", "model.json", "-o", "mesh.xdmf", "-o", "mesh.vtu", *flags)
    assert done.returncode == 0, done.stderr
    ours, theirs = meshio.read(tmp_path / "mesh.xdmf"), meshio.read(tmp_path / "mesh.vtu")
    assert np.array_equal(ours.points, theirs.points)
    for mine, other in zip(ours.cells, theirs.cells, strict=True):
        # meshio turns the wedges of VTK's files into its own order, and leaves those of XDMF.
        order = [0, 2, 1, 3, 5, 4] if mine.type == "wedge" else slice(None)
        assert mine.type == other.type and np.array_equal(mine.data, other.data[:, order])
    for name in ("phase", "aggregate"):
        mine, other = (np.concatenate([block.ravel() for block in read.cell_data[name]]) for read in (ours, theirs))
        assert np.array_equal(mine, other)
    reader = pytest.importorskip("vtkmodules.vtkIOXdmf2").vtkXdmfReader()
    reader.SetFileName(str(tmp_path / "mesh.xdmf"))
    reader.Update()
    grid, expected = pyvista.wrap(reader.GetOutputDataObject(0)), pyvista.read(tmp_path / "mesh.vtu")
    assert np.array_equal(grid.cell_connectivity, expected.cell_connectivity)
    assert np.array_equal(grid.celltypes, expected.celltypes)


def test_workbooks_are_sieve_tables(tmp_path, caplog):
    """A sheet of openpyxl is read as its CSV would be; per cent of a number format count."""
    openpyxl = pytest.importorskip("openpyxl", reason="needs openpyxl (pip install openpyxl)")
    book = openpyxl.Workbook()
    sheet = book.active
    for row in (["Sieve (mm)", "Passing"], [16, 1.0], [8, 0.6], [4, 0.1]):
        sheet.append(row)
    for row in sheet.iter_rows(min_row=2, min_col=2):
        row[0].number_format = "0%"
    book.save(tmp_path / "lab.xlsx")
    grading = mc.Grading.table(tmp_path / "lab.xlsx", 4, 16)
    curve = mc.Spec(grading=grading).grading["curve"]
    assert curve == {"kind": "sieves", "sieves_mm": [4.0, 8.0, 16.0], "passing": [0.1, 0.6, 1.0]}
    assert "4 to 16 mm is 90 % of the curve" in caplog.text
    book.create_sheet("second").append([1, 2])
    book.save(tmp_path / "lab.xlsx")
    with pytest.raises(ValueError, match="2 of its sheets have numbers; choose one"):
        mc.Spec(grading=mc.Grading.table(tmp_path / "lab.xlsx", 4, 16))
    chosen = mc.Grading.table(tmp_path / "lab.xlsx", 4, 16, choices={"sheet": "Sheet"})
    assert json.dumps(mc.Spec(grading=chosen).grading["curve"]) == json.dumps(curve)
