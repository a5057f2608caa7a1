"""Files: whole or not at all, the same as the command's, and readable by meshio and PyVista."""

import csv
import json
import math
import os
import stat

import numpy as np
import pytest

import mesocrete as mc


@pytest.mark.parametrize("extension", ["json", "vtu", "stl", "csv", "inp"])
def test_every_format_is_written_by_its_extension(packing, tmp_path, extension):
    path = tmp_path / f"model.{extension}"
    packing.write(path)
    packing.write(str(tmp_path / f"again.{extension.upper()}"))
    assert path.read_bytes() == (tmp_path / f"again.{extension.upper()}").read_bytes()
    assert path.stat().st_size > 1000
    assert len(os.listdir(tmp_path)) == 2, "no temporary file is left"


def test_a_page_is_the_one_of_the_command(packing, tmp_path, run):
    packing.write(tmp_path / "model.json")
    packing.write(tmp_path / "python.html")
    assert run("report", "model.json", "-o", "command.html").returncode == 0
    assert (tmp_path / "python.html").read_bytes() == (tmp_path / "command.html").read_bytes()


def test_a_saved_model_comes_back_bit_for_bit(packing, tmp_path):
    packing.write(tmp_path / "model.json")
    again = mc.load(tmp_path / "model.json")
    assert again == packing
    again.write(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (tmp_path / "model.json").read_bytes()


def test_the_saved_model_has_the_documented_keys(packing, tmp_path):
    packing.write(tmp_path / "model.json")
    model = json.loads((tmp_path / "model.json").read_text(encoding="utf-8"))
    assert {"mesocrete", "spec", "seed", "specimen", "aggregates"} <= model.keys()
    assert model["mesocrete"] == mc.__version__
    assert model["seed"] == 7
    first = model["aggregates"][0]
    assert {"id", "class", "itz_thickness_mm", "vertices", "faces"} <= first.keys()
    assert np.array_equal(first["vertices"], packing.aggregates[0].vertices)
    assert first["faces"] == packing.aggregates[0].faces


def test_an_unknown_extension_is_a_value_error_that_lists_the_known(packing, tmp_path):
    for name in ("model.docx", "model", ".json"):
        with pytest.raises(ValueError, match=r"\.json.*\.vtu"):
            packing.write(tmp_path / name)
    with pytest.raises(ValueError, match=r"an image: voxelize, section, or mesocrete image"):
        packing.write(tmp_path / "model.tif")
    with pytest.raises(ValueError, match=r"\.inp.*\.vtu"):
        packing.mesh(element_size=3.0).write(tmp_path / "mesh.json")
    assert os.listdir(tmp_path) == []


def test_an_existing_file_is_kept_where_asked(packing, tmp_path):
    path = tmp_path / "model.csv"
    path.write_text("mine", encoding="utf-8")
    with pytest.raises(FileExistsError, match="overwrite=True"):
        packing.write(path, overwrite=False)
    assert path.read_text(encoding="utf-8") == "mine"
    packing.write(path)
    assert path.read_text(encoding="utf-8").startswith("id,")


def test_folders_that_are_not_there_are_os_errors_with_the_path(packing, tmp_path):
    path = tmp_path / "nowhere" / "model.json"
    with pytest.raises(FileNotFoundError) as caught:
        packing.write(path)
    assert caught.value.filename == str(path)
    with pytest.raises(FileNotFoundError):
        mc.load(path)
    with pytest.raises(OSError):
        mc.load(tmp_path)
    (tmp_path / "folder.json").mkdir()
    with pytest.raises(OSError):
        packing.write(tmp_path / "folder.json")
    with pytest.raises((OSError, ValueError)):
        packing.write(tmp_path / ("x" * 300 + ".json"))
    with pytest.raises((OSError, ValueError)):
        packing.write(str(tmp_path) + "/nul\0.json")


@pytest.mark.skipif(os.name == "nt", reason="POSIX links and devices")
def test_links_stay_links_and_devices_stay_devices(packing, tmp_path):
    (tmp_path / "real.csv").write_text("old", encoding="utf-8")
    (tmp_path / "link.csv").symlink_to(tmp_path / "real.csv")
    packing.write(tmp_path / "link.csv")
    assert (tmp_path / "link.csv").is_symlink()
    assert (tmp_path / "real.csv").read_text(encoding="utf-8").startswith("id,")
    (tmp_path / "null.csv").symlink_to("/dev/null")
    packing.write(tmp_path / "null.csv")
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)


@pytest.mark.skipif(os.name == "nt", reason="POSIX permissions")
def test_new_files_have_the_permissions_of_any_new_file(packing, tmp_path):
    packing.write(tmp_path / "model.csv")
    (tmp_path / "plain").write_text("", encoding="utf-8")
    modes = [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("model.csv", "plain")]
    assert modes[0] == modes[1]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
def test_a_full_device_is_an_os_error(packing, tmp_path):
    (tmp_path / "full.csv").symlink_to("/dev/full")
    with pytest.raises(OSError, match="full.csv"):
        packing.write(tmp_path / "full.csv")


@pytest.mark.skipif(os.name == "nt", reason="POSIX limits")
def test_a_file_that_outgrows_its_limit_is_an_os_error_and_keeps_the_old_file(packing, tmp_path):
    resource = pytest.importorskip("resource")
    import signal

    path = tmp_path / "model.json"
    path.write_text("old", encoding="utf-8")
    old_limit, old_handler = resource.getrlimit(resource.RLIMIT_FSIZE), signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, old_limit[1]))
    try:
        with pytest.raises(OSError):
            packing.write(path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, old_limit)
        signal.signal(signal.SIGXFSZ, old_handler)
    assert path.read_text(encoding="utf-8") == "old"
    assert os.listdir(tmp_path) == ["model.json"]


DAMAGED = {
    "empty": b"",
    "not JSON": b"\x89PNG",
    "another JSON": b'{"a": 1}',
    "a list": b"[1, 2]",
    "deep": b"[" * 200_000,
}


@pytest.mark.parametrize("name", DAMAGED)
def test_files_that_are_no_model_are_value_errors_with_the_path(tmp_path, name):
    path = tmp_path / "model.json"
    path.write_bytes(DAMAGED[name])
    with pytest.raises(ValueError, match=r"model\.json"):
        mc.load(path)


def test_a_model_changed_by_hand_is_refused_by_name(packing, tmp_path):
    packing.write(tmp_path / "model.json")
    model = json.loads((tmp_path / "model.json").read_text(encoding="utf-8"))

    def refused(change):
        broken = json.loads(json.dumps(model))
        change(broken)
        (tmp_path / "broken.json").write_text(json.dumps(broken), encoding="utf-8")
        with pytest.raises(ValueError, match=r"broken\.json"):
            mc.load(tmp_path / "broken.json")

    refused(lambda m: m["aggregates"][2]["faces"][0].append(999))
    refused(lambda m: m["aggregates"][2].pop("vertices"))
    refused(lambda m: m["spec"].update(fraction=45))
    refused(lambda m: m.update(seed=-1))
    refused(lambda m: m.update(mesocrete="999.0.0"))


def test_the_csv_has_one_row_per_aggregate(packing, tmp_path):
    packing.write(tmp_path / "model.csv")
    with open(tmp_path / "model.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(packing)
    assert [float(row["volume_mm3"]) for row in rows] == pytest.approx([a.volume for a in packing.aggregates], rel=1e-12)
    assert [float(row["itz_thickness_mm"]) for row in rows] == [a.itz_thickness for a in packing.aggregates]
    assert {row["phase"] for row in rows} == {"aggregate"}


def volumes_of_closed_surfaces(points, faces, owners):
    """Volume of every body from its outward polygons, by the divergence theorem, one numpy step per polygon."""
    volumes = np.zeros(int(max(owners)) + 1)
    for face, owner in zip(faces, owners, strict=True):
        corners = points[face] - points[faces[np.searchsorted(owners, owner)][0]]
        fans = np.einsum("j,ij->i", corners[0], np.cross(corners[1:-1], corners[2:]))
        volumes[owner] += fans.sum() / 6.0
    return volumes


def test_pyvista_reads_the_reports_volume_from_the_vtu(packing, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    packing.write(tmp_path / "model.vtu")
    grid = pyvista.read(tmp_path / "model.vtu")
    owners = grid.cell_data["aggregate"]
    faces = [cell.point_ids for cell in grid.cell]
    volumes = volumes_of_closed_surfaces(grid.points.astype(np.float64), faces, owners)
    report = packing.report()
    assert math.fsum(volumes) == pytest.approx(report["fraction"] * report["specimen"]["volume_mm3"], rel=1e-9)
    assert volumes == pytest.approx([a.volume for a in packing.aggregates], rel=1e-9)
    assert set(grid.cell_data.keys()) >= {"aggregate", "class", "phase", "itz_thickness_mm"}
    thickness = np.array([a.itz_thickness for a in packing.aggregates])
    assert np.allclose(grid.cell_data["itz_thickness_mm"], thickness[owners], rtol=1e-6)


def test_vtk_itself_measures_the_same_volume(packing, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    packing.write(tmp_path / "model.vtu")
    grid = pyvista.read(tmp_path / "model.vtu")
    surface = pyvista.PolyData(grid.points, grid.cells).triangulate()
    expected = packing.fraction * packing.report()["specimen"]["volume_mm3"]
    # vtkMassProperties works in single precision on some inputs; 1e-5 is its own accuracy, not ours.
    assert surface.volume == pytest.approx(expected, rel=1e-5)


def test_meshio_reads_the_reports_volume_from_the_vtu(packing, tmp_path):
    meshio = pytest.importorskip("meshio")
    packing.write(tmp_path / "model.vtu")
    mesh = meshio.read(tmp_path / "model.vtu")
    total = 0.0
    for block, owners in zip(mesh.cells, mesh.cell_data["aggregate"], strict=True):
        first = np.array([packing.aggregates[int(owner)].vertices[0] for owner in np.ravel(owners)])
        corners = mesh.points[block.data] - first[:, None]
        for i in range(1, corners.shape[1] - 1):
            total += np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, i], corners[:, i + 1])) / 6.0
    expected = packing.fraction * packing.report()["specimen"]["volume_mm3"]
    assert total == pytest.approx(expected, rel=1e-9)


def test_meshio_reads_the_stl(packing, tmp_path):
    meshio = pytest.importorskip("meshio")
    packing.write(tmp_path / "model.stl")
    mesh = meshio.read(tmp_path / "model.stl")
    assert sum(len(block.data) for block in mesh.cells) == sum(len(a.triangles) for a in packing.aggregates)
