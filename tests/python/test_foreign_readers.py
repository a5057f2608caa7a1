"""Meshes read back by programs that are not ours: gmsh, meshio, PyVista, PyDyna (Ansys), lsdyna-mesh-reader, mapdl-archive."""

import datetime
import json
import re

import mesocrete as mc
import numpy as np
import pytest

import matrix

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


# Cases of the random matrix that the whole suite reads; the slow tier reads all.
SHORT = [1000, 1006, 1008, 1064]
ALL = range(1000, 1300)


def pytest_generate_tests(metafunc):
    if "meshed" in metafunc.fixturenames:
        numbers = ALL if metafunc.config.getoption("--slow") else SHORT
        metafunc.parametrize("meshed", [*CASES, *numbers], indirect=True, scope="module")


@pytest.fixture(scope="module")
def meshed(request):
    """A specimen and its mesh."""
    if request.param not in CASES:
        specimen, mesh = matrix.meshed(request.param)
        return (specimen, mesh) if mesh else pytest.skip("no body found a place")
    periodic, options = CASES[request.param]
    packing = pack(periodic)
    # Small and coarse: what is read back counts, and not the volumes.
    return packing.spec.specimen, packing.mesh(**options, accept_phase_error=True)


@pytest.fixture
def mesh(meshed):
    return meshed[1]


def test_cases_of_the_matrix_are_those_of_the_rust_test():
    """Every choice stands there in the same order, and the generator draws the same numbers."""
    source = matrix.RUST.read_text(encoding="utf-8")
    for texts in [*matrix.TEXTS, [name.removesuffix(" again") for name in matrix.METHODS]]:
        listed = r",\s*".join(f'"?{re.escape(text)}"?' for text in texts)
        assert re.search(rf"\[\s*{listed},?\s*\]", source), texts
    assert len(matrix.meshed(1008)[1].cells) == 7921


def on_planes(mesh):
    """The nodes on the bounding planes, by name."""
    points = mesh.points
    low, high = points.min(axis=0), points.max(axis=0)
    near = 1e-9 * (high - low).max()
    ends = [np.flatnonzero(np.abs(points[:, axis] - end[axis]) <= near) for axis in range(3) for end in (low, high)]
    return dict(zip(SIDES, ends, strict=True))


# Sides that no face of a mesh lies on.
CURVED = {"cylinder": SIDES[:4], "sphere": SIDES}


@pytest.fixture
def sides(meshed, tmp_path):
    """The nodes of the sides, by name: on the bounding planes, and on a curved side those of an Abaqus deck."""
    specimen, mesh = meshed
    found, curved = on_planes(mesh), CURVED.get(specimen["kind"], ())
    if curved:
        mesh.write(tmp_path / "sides.inp", geometry_only=True)
        deck = (tmp_path / "sides.inp").read_text(encoding="utf-8")
        for name in curved:
            numbers = re.search(rf"\*NSET, NSET={name}\n([\d,\s]*)", deck)[1]
            nodes = np.sort([int(number) - 1 for number in re.findall(r"\d+", numbers)])
            assert set(found[name]) <= set(nodes)
            found[name] = nodes
    return found


# Elements of gmsh with so many nodes, as cells and as faces on the sides: type, and order of the nodes.
GMSH = {4: (4, 2, range(4)), 8: (5, 3, range(8)), 10: (11, 9, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8])}


def test_gmsh_and_meshio_find_nodes_cells_groups_and_sides(mesh, sides, tmp_path, gmsh):
    """Every node, every cell in the group of its phase, and the faces of the sides."""
    meshio = pytest.importorskip("meshio")
    mesh.write(tmp_path / "mesh.msh")
    gmsh.open(str(tmp_path / "mesh.msh"))
    groups = {gmsh.model.getPhysicalName(*group): group for group in gmsh.model.getPhysicalGroups()}
    tags, points, _ = gmsh.model.mesh.getNodes()
    assert np.array_equal(points.reshape(-1, 3)[np.argsort(tags)], mesh.points)
    read = meshio.read(tmp_path / "mesh.msh")
    assert np.array_equal(read.points, mesh.points)
    width, joints = mesh.cells.shape[1], mesh.cohesive
    cell, face, order = GMSH[width]
    for phase, name in enumerate(("MORTAR", "ITZ", "AGGREGATE", "", "FIBRE")):
        expected = mesh.cells[mesh.phase == phase]
        # Cohesive elements of voxels are hexahedra, too, in an entity of their own.
        entities = [tag for tag in gmsh.model.getEntitiesForPhysicalGroup(*groups[name]) if tag != 4] if name in groups else []
        found = [gmsh.model.mesh.getElementsByType(cell, tag)[1] for tag in entities]
        found = np.concatenate([*found, np.zeros(0, np.uint64)]).reshape(-1, width)[:, order]
        assert np.array_equal(found - 1, expected), name
        of_group = read.cell_data["gmsh:physical"]
        solids = [np.arange(len(block))[of == phase + 1] for block, of in zip(read.cells, of_group, strict=True) if block.dim == 3]
        assert sum(map(len, solids)) == len(expected) + (len(joints) if phase == 1 else 0)
    if len(joints):
        kind = 6 if width == 4 else 5
        assert np.array_equal(gmsh.model.mesh.getElementsByType(kind, 4)[1].reshape(joints.shape) - 1, joints)
    assert len({tag for _, tag in groups.values()}) == len(groups), "a surface has the number of a volume"
    for tag, name in enumerate(SIDES, 101):
        assert groups[name] == (2, tag)
        nodes = np.unique(gmsh.model.mesh.getElementsByType(face, tag)[1]) - 1
        assert len(nodes) and set(nodes) <= set(sides[name])


def test_gmsh_and_meshio_read_periodic_pairs(meshed, tmp_path, gmsh):
    """Every pair of a periodic surface is a period apart within 1e-12; every place with an opposite one is in a pair."""
    meshio = pytest.importorskip("meshio")
    specimen, mesh = meshed
    mesh.write(tmp_path / "mesh.msh")
    points = mesh.points
    lengths = points.max(axis=0) - points.min(axis=0)
    pairs = {}
    for dimension, (slave, master), _, nodes in meshio.read(tmp_path / "mesh.msh").gmsh_periodic or ():
        axis, is_upper = divmod(slave - 101, 2)
        assert (dimension, slave - master, is_upper) == (2, 1, 1)
        pairs[int(slave)] = nodes
        step = np.eye(3)[axis] * lengths
        assert np.abs(points[nodes[:, 0]] - points[nodes[:, 1]] - step).max() < 1e-12
    assert list(pairs) == [2 * "xyz".index(axis) + 102 for axis in specimen.get("periodic", ())]
    gmsh.open(str(tmp_path / "mesh.msh"))
    found = on_planes(mesh)
    for slave, nodes in pairs.items():
        master, own, _, _ = gmsh.model.mesh.getPeriodicNodes(2, slave)
        assert master == slave - 1 and sorted(own) == sorted(nodes[:, 0] + 1)
        assert len(set(nodes[:, 0])) == len(nodes), "a node has two partners"
        across = [axis for axis in range(3) if axis != (slave - 101) // 2]
        places = {name: set(map(tuple, points[found[name]][:, across].round(9))) for name in SIDES[slave - 102 : slave - 100]}
        assert set(map(tuple, points[nodes[:, 0]][:, across].round(9))) == set.intersection(*places.values())


@pytest.mark.parametrize("order", [1, 2])
def test_scikit_fem_and_gmshs_ascii_keep_every_group(tmp_path, gmsh, order):
    """The case: sides 1 and 3 beside MORTAR 1 and AGGREGATE 3. scikit-fem called mortar XMIN, akantu lost two sides."""
    skfem = pytest.importorskip("skfem", reason="needs scikit-fem (pip install scikit-fem)")
    mesh = pack(False).mesh(method="lattice", element_size=5.0, itz="none", order=order, accept_phase_error=True)
    mesh.write(tmp_path / "mesh.msh")
    read = skfem.Mesh.load(tmp_path / "mesh.msh")
    found = {name: len(cells) for name, cells in read.subdomains.items()}
    assert found == {"MORTAR": np.sum(mesh.phase == 0), "AGGREGATE": np.sum(mesh.phase == 2)}
    gmsh.open(str(tmp_path / "mesh.msh"))
    gmsh.option.setNumber("Mesh.Binary", 0)
    gmsh.write(str(tmp_path / "ascii.msh"))
    text = (tmp_path / "ascii.msh").read_text()
    names = re.findall(r'^\d (\d+) "(\w+)"$', text, re.MULTILINE)
    # akantu takes one name a number.
    assert {name for _, name in names} == {"MORTAR", "AGGREGATE", *SIDES} and len(dict(names)) == 8


def nodes_of(elements, width):
    """The first nodes of elements after mapdl-archive, from 0."""
    return np.array([element[10 : 10 + width] for element in elements]).reshape(-1, width) - 1


def test_ansys_archives_hold_nodes_cells_and_components(mesh, sides, tmp_path):
    """mapdl-archive finds every node within 1e-12, every element with its material, and the sets."""
    reader = pytest.importorskip("mapdl_archive", reason="needs mapdl-archive (pip install mapdl-archive)")
    mesh.write(tmp_path / "mesh.cdb")
    archive = reader.Archive(str(tmp_path / "mesh.cdb"))
    # Numbers of up to six digits take seven columns.
    assert {"(3i7,6e21.13e3)", "(19i7)"} <= set((tmp_path / "mesh.cdb").read_text().splitlines())
    assert np.abs(archive.nodes - mesh.points).max() < 1e-12
    width, joints, count = mesh.cells.shape[1], mesh.cohesive, len(mesh.cells)
    assert len(archive.elem) == count + len(joints)
    assert np.array_equal(nodes_of(archive.elem[:count], width), mesh.cells)
    parts = [PARTS[phase] for phase in mesh.phase] + [PARTS[1]] * len(joints)
    assert [element[0] for element in archive.elem] == parts
    if len(joints):
        order = [0, 1, 2, 4, 5, 6] if joints.shape[1] == 6 else range(8)
        assert np.array_equal(nodes_of(archive.elem[count:], 8)[:, order], joints)
    for name, nodes in sides.items():
        assert np.array_equal(np.sort(archive.node_components[name]) - 1, nodes)
    for part, name in enumerate(("AGGREGATE", "ITZ", "MORTAR", "FIBRE"), 1):
        found = archive.element_components.get(name, [])
        assert np.array_equal(np.sort(found), np.flatnonzero(np.array(parts) == part) + 1)


def keyword_deck(path):
    """Read a .k by Ansys' own keyword classes; nothing may stay unread."""
    core = pytest.importorskip("ansys.dyna.core", reason="needs PyDyna (pip install ansys-dyna-core)")
    deck = core.Deck()
    deck.import_file(str(path))
    assert not deck.string_keywords, deck.string_keywords
    return deck


def keywords(deck, title):
    return [keyword for keyword in deck.keywords if keyword.get_title().startswith(title)]


def test_keyword_decks_hold_nodes_elements_parts_and_sets(mesh, sides, tmp_path):
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
    sets = {keyword.title: keyword for keyword in keywords(deck, "*SET_NODE_LIST")}
    for name, members in sides.items():
        assert np.array_equal(np.sort([node for node in sets[name].nodes.data if node]) - 1, members)
    segments = {keyword.title: keyword.segments for keyword in keywords(deck, "*SET_SEGMENT")}
    assert set(segments) == set(SIDES)
    for name, faces in segments.items():
        corners = faces[["n1", "n2", "n3", "n4"]].to_numpy(int) - 1
        assert len(corners) and set(corners.ravel()) <= set(sides[name])


def test_a_second_reader_of_keyword_decks_agrees(mesh, tmp_path):
    """lsdyna-mesh-reader finds the same nodes, elements and parts."""
    reader = pytest.importorskip("lsdyna_mesh_reader", reason="needs lsdyna-mesh-reader (pip install lsdyna-mesh-reader)")
    if mesh.cells.shape[1] == 10:
        pytest.skip("lsdyna-mesh-reader reads no elements of ten nodes")
    mesh.write(tmp_path / "mesh.k", geometry_only=True)
    deck = reader.Deck(str(tmp_path / "mesh.k"))
    assert np.abs(deck.node_sections[0].coordinates - mesh.points).max() < 1e-12
    solids, width = deck.element_solid_sections, mesh.cells.shape[1]
    assert np.array_equal(solids[0].node_ids.reshape(-1, 8)[:, :width] - 1, mesh.cells)
    assert np.array_equal(solids[0].pid, [PARTS[phase] for phase in mesh.phase])
    assert sum(len(block.eid) for block in solids) == len(mesh.cells) + len(mesh.cohesive)


@pytest.mark.parametrize(
    ("analysis", "law", "material"),
    [
        ("compression", "cdpm", "*MAT_CDPM"),
        ("tension", "rel3", "*MAT_CONCRETE_DAMAGE_REL3"),
        ("striker", "cscm", "*MAT_CSCM_CONCRETE"),
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
        # The nodes of the lower side, or of the lower support.
        nodes = 5 if analysis == "striker" else 11
        assert (contact.surfa, contact.surfb, contact.surfatyp, contact.surfbtyp, contact.fs) == (nodes, 11, 4, 3, 0.1)
    if analysis == "striker":
        assert keywords(deck, "*INITIAL_VELOCITY_RIGID_BODY")[0].vz == -5000.0
    if analysis == "compression":
        law = keywords(deck, material)[1]
        assert (law.ft, law.fc, law.type, law.efc > 0) == (3.4, 40.0, 1.0, True)


def test_bars_of_a_hopkinson_deck_are_dampers_from_plates_to_the_ground(tmp_path):
    """PyDyna finds a damper a bar: from a corner of its plate to node 0, along z, with the bar's impedance."""
    mesh = pack(False).mesh(method="lattice", element_size=4.0, itz="smeared", joined="mortar", accept_phase_error=True)
    mesh.write(tmp_path / "bars.k", analysis="hopkinson")
    deck = keyword_deck(tmp_path / "bars.k")
    dampers = [block.elements.iloc[0] for block in keywords(deck, "*ELEMENT_DISCRETE")]
    plates = [block for block in keywords(deck, "*ELEMENT_SOLID")][-1].elements
    assert [int(damper["n1"]) for damper in dampers] == [int(node) for node in plates["n1"]]
    assert all(damper["n2"] in (0, None) and damper["vid"] == damper["pid"] for damper in dampers)
    along = [block.vectors.iloc[0] for block in keywords(deck, "*DEFINE_SD_ORIENTATION")]
    assert [(vector["xt"], vector["yt"], vector["zt"]) for vector in along] == [(0.0, 0.0, 1.0)] * 2
    impedance = 900.0 * (2.1e5 * 7.85e-9) ** 0.5
    assert [round(material.dc / impedance, 5) for material in keywords(deck, "*MAT_DAMPER_VISCOUS")] == [1.0, 1.0]
    # The wave of a striker of 8 m/s comes along the lower bar alone.
    assert [(load.pid, load.dof) for load in keywords(deck, "*LOAD_RIGID_BODY")] == [(11, 3)]


def test_decks_with_plates_keep_all_their_nodes_in_readers_that_take_one_block(tmp_path):
    """The case: meshio kept 1 of 1,123 nodes and knew no R3D4, lsdyna-mesh-reader raised IndexError."""
    meshio = pytest.importorskip("meshio")
    spec = {"specimen": mc.Specimen.cube(20), "fraction": 0.05, "grading": {"d_min_mm": 5.0, "d_max_mm": 6.0, "classes_mm": [5.0, 6.0]}}
    mesh = mc.pack(spec).mesh(for_test=True, element_size=4.0, accept_phase_error=True)
    for analysis in ("elastic", "compression", "tension", "triaxial", "biaxial"):
        mesh.write(tmp_path / "test.inp", analysis=analysis)
        theirs = meshio.read(tmp_path / "test.inp")
        assert np.abs(theirs.points[: len(mesh.points)] - mesh.points).max() < 1e-9, analysis
        assert sum(len(block.data) for block in theirs.cells if block.type == "tetra") == len(mesh)
        assert len(theirs.point_sets["ZMIN"]) < len(mesh.points)
    reader = pytest.importorskip("lsdyna_mesh_reader", reason="needs lsdyna-mesh-reader (pip install lsdyna-mesh-reader)")
    mesh.write(tmp_path / "test.k", analysis="compression")
    deck = reader.Deck(str(tmp_path / "test.k"))
    # Two blocks of one hexahedron and eight corners each.
    assert [len(section.coordinates) for section in deck.node_sections] == [len(mesh.points) + 16]
    assert deck.to_grid().n_cells == len(mesh) + 2


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


# Rows of sheets, the format of their numbers, and what passes 4, 8 and 16 mm; None where the sheet is refused.
NASTY = {
    "lines in headings, a title and remarks": (
        [["Prüfbericht 17", None], [None, None], ["Sieb\n(mm)", "Durchgang\n(M.-%)"], [16, 100], [8, 60], [4, 10], ["Bemerkung: nass", None]],
        "General",
        [0.1, 0.6, 1.0],
    ),
    "numbers as text with decimal commas": ([["Sieb (mm)", "Durchgang (%)"], ["16,0", "100,0"], ["8,0", "60,0"], ["4,0", "10,0"]], "@", [0.1, 0.6, 1.0]),
    "a sign that is only shown": ([["Sieve (mm)", "Passing"], [16, 100], [8, 60], [4, 10]], '0.0"%"', [0.1, 0.6, 1.0]),
    "shares shown as per cent": ([["Sieve (mm)", "Passing (%)"], [16, 1], [8, 0.6], [4, 0.1]], "0.0%", [0.1, 0.6, 1.0]),
    "masses with a pan": ([["Sieve (mm)", "Retained (g)"], [16, 0], [8, 1400], [4, 1750], ["Pan", 350]], "#,##0", [0.1, 0.6, 1.0]),
    "a sieve that became a date": ([["Sieve (mm)", "Passing (%)"], [16, 100], [datetime.date(2026, 8, 4), 60], [4, 10]], "General", None),
    "a formula without a value": ([["Sieve (mm)", "Passing (%)"], [16, 100], [8, "=100-40"], [4, 10]], "General", None),
}


@pytest.mark.parametrize("name", NASTY)
def test_nasty_workbooks_are_read_rightly_or_refused(tmp_path, name):
    """The case: a sign in quotes made 9,550 % of 95.5 %."""
    openpyxl = pytest.importorskip("openpyxl", reason="needs openpyxl (pip install openpyxl)")
    rows, form, passing = NASTY[name]
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(row)
    for (cell,) in book.active.iter_rows(min_col=2, max_col=2):
        cell.number_format = form
    book.save(tmp_path / "lab.xlsx")
    grading = mc.Grading.table(tmp_path / "lab.xlsx", 4, 16)
    if passing is None:
        with pytest.raises(ValueError, match="line 3|cell B3"):
            mc.Spec(grading=grading)
    else:
        assert mc.Spec(grading=grading).grading["curve"] == {"kind": "sieves", "sieves_mm": [4.0, 8.0, 16.0], "passing": passing}
