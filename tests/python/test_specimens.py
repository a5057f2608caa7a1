"""Specimens of every kind, and periodic ones: what is inside, and what is asked in vain."""

import struct

import mesocrete as mc
import numpy as np
import pytest


def vertices(packing):
    return np.concatenate([a.vertices for a in packing.aggregates])


def test_grains_lie_in_a_cylinder_and_voxels_fill_it():
    specimen = {"kind": "cylinder", "diameter_mm": 60, "height_mm": 50}
    packing = mc.pack({"specimen": specimen}, fraction=0.45)
    assert packing.report()["specimen"] == {"kind": "cylinder", "volume_mm3": pytest.approx(np.pi * 900 * 50)}
    points = vertices(packing)
    assert np.hypot(points[:, 0] - 30, points[:, 1] - 30).max() <= 30
    assert points[:, 2].min() >= 0 and points[:, 2].max() <= 50
    assert packing.check()["sound"]
    assert sum(packing.mesh(element_size=2.0).volumes().values()) == pytest.approx(np.pi * 900 * 50, rel=0.02)


def test_a_periodic_cube_has_each_grain_once_and_faces_that_match(tmp_path):
    specimen = {"kind": "cube", "side_mm": 45, "periodic": ["x", "y", "z"]}
    packing = mc.pack({"specimen": specimen}, fraction=0.5)
    assert packing.spec.specimen == {"kind": "cube", "side_mm": 45.0, "periodic": ["x", "y", "z"]}
    assert packing.check()["sound"]
    assert sum(a.volume for a in packing.aggregates) / 45**3 == pytest.approx(packing.fraction, rel=1e-12)
    points = vertices(packing)
    assert points.min() < 0 and points.max() > 45
    packing.write(tmp_path / "cut.json")
    assert mc.load(tmp_path / "cut.json") == packing
    assert packing.mesh(element_size=1.5).points.max() == 45
    with pytest.raises(ValueError, match='images is "halved"; it must be one of "none", "whole", "cut"'):
        packing.write(tmp_path / "x.stl", images="halved")


def test_cut_images_fill_the_box_and_meet_both_faces(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    packing = mc.pack({"specimen": {"kind": "cube", "side_mm": 45, "periodic": ["x"]}}, fraction=0.4)
    packing.write(tmp_path / "cut.vtu", images="cut")
    points = pyvista.read(tmp_path / "cut.vtu").points
    assert points[:, 0].min() == 0 and points[:, 0].max() == 45
    low, high = (np.unique(points[points[:, 0] == place][:, 1:], axis=0) for place in (0, 45))
    assert len(low) > 20
    assert np.array_equal(low, high)


def write_stl(path, points, triangles):
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(points[list(t)]), 0) for t in triangles)
    path.write_bytes(b"\0" * 80 + struct.pack("<I", len(triangles)) + body)


def test_an_stl_beside_the_spec_is_filled(tmp_path):
    # A cone of 80 mm, 80 mm high, on a ring of 40 points.
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    ring = np.c_[40 * np.cos(angle), 40 * np.sin(angle), np.zeros(40)]
    points = np.r_[ring, [[0, 0, 0], [0, 0, 80]]].astype(np.float32)
    steps = [(i, (i + 1) % 40) for i in range(40)]
    triangles = [(j, i, 40) for i, j in steps] + [(i, j, 41) for i, j in steps]
    write_stl(tmp_path / "cone.stl", points, triangles)
    spec = tmp_path / "spec.toml"
    spec.write_text('fraction = 0.3\n[specimen]\nkind = "mesh"\nfile = "cone.stl"\n')
    packing = mc.pack(spec)
    volume = 40 * 0.5 * 40 * 40 * np.sin(2 * np.pi / 40) * 80 / 3
    assert packing.report()["specimen"]["volume_mm3"] == pytest.approx(volume, rel=1e-6)
    assert packing.fraction == pytest.approx(0.3, abs=0.01)
    assert packing.check()["sound"]
    points = vertices(packing)
    assert (np.hypot(points[:, 0] - 40, points[:, 1] - 40) <= 40 * (1 - points[:, 2] / 80) + 1e-4).all()
    write_stl(tmp_path / "cone.stl", np.r_[ring, [[0, 0, 0], [0, 0, 80]]].astype(np.float32), triangles[1:])
    with pytest.raises(ValueError, match="specimen.file is \"cone.stl\": its surface is open: 3 edge"):
        mc.pack(spec)


def test_the_specimens_surface_is_closed():
    specimen = {"kind": "notched-prism", "length_mm": 120, "width_mm": 40, "depth_mm": 40,
                "notch_depth_mm": 8, "notch_width_mm": 3}
    packing = mc.pack({"specimen": specimen}, fraction=0.2)
    points, triangles = packing.specimen_surface()
    a, b, c = (points[triangles[:, k]] for k in range(3))
    assert np.einsum("ij,ij", a, np.cross(b, c)) / 6 == pytest.approx(120 * 40 * 40 - 8 * 3 * 40)
    assert packing.check()["sound"]
