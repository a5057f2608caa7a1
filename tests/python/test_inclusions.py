"""Voids and fibres from Python: placed, checked, written, meshed."""

import math
import pickle

import numpy as np
import pytest

import mesocrete as mc
from mesocrete import gjk

SPEC = {
    "fraction": 0.3,
    "specimen": {"kind": "cube", "side_mm": 40},
    "voids": {"fraction": 0.02, "diameter_mm": [2, 3]},
    "fibres": {"fraction": 0.01, "diameter_mm": 1, "length_mm": 20},
}


@pytest.fixture(scope="module")
def reinforced():
    return mc.pack(SPEC)


def test_voids_and_fibres_come_beside_the_aggregates(reinforced):
    inclusions = reinforced.inclusions
    assert [b.id for b in inclusions] == list(range(len(reinforced), len(reinforced) + len(inclusions)))
    assert {a.phase for a in reinforced.aggregates} == {"aggregate"}
    phases = {p["phase"]: p for p in reinforced.report()["phases"]}
    assert phases.keys() == {"void", "fibre"}
    for name, phase in phases.items():
        own = [b for b in inclusions if b.phase == name]
        assert len(own) == phase["bodies"] > 20
        assert math.fsum(b.volume for b in own) / 40**3 == pytest.approx(phase["fraction"], rel=1e-12)
        assert phase["fraction"] == pytest.approx(phase["target_fraction"], rel=0.05)
        assert phase["volume_mm3"] == pytest.approx(phase["fraction"] * 40**3, rel=1e-12)
    assert reinforced.fraction == pytest.approx(0.3, abs=0.005)
    assert reinforced.check()["sound"]


def test_statistics_tell_of_each_phase(reinforced):
    figures = {p["phase"]: p for p in reinforced.statistics(lines=64, points=64)["phases"]}
    assert {p["phase"]: p["bodies"] for p in reinforced.report()["phases"]} == {n: p["bodies"] for n, p in figures.items()}
    assert sum(figures["fibre"]["orientation"]["eigenvalues"]) == pytest.approx(1.0)
    assert "orientation" not in figures["void"]


def test_a_fibre_meets_no_other_body_by_our_own_gjk(reinforced):
    bodies = [b.vertices for b in [*reinforced.aggregates, *reinforced.inclusions]]
    for fibre in (b for b in reinforced.inclusions if b.phase == "fibre"):
        others = bodies[: fibre.id] + bodies[fibre.id + 1 :]
        assert not gjk.intersects_many(fibre.vertices, others).any()


def test_inclusions_survive_pickles_and_files(reinforced, tmp_path):
    assert pickle.loads(pickle.dumps(reinforced)) == reinforced
    fibre = reinforced.inclusions[-1]
    assert pickle.loads(pickle.dumps(fibre)) == fibre
    assert "phase=\"fibre\"" in repr(fibre)
    reinforced.write(tmp_path / "model.json")
    assert mc.load(tmp_path / "model.json") == reinforced
    assert mc.Spec(**reinforced.spec.to_dict()) == reinforced.spec


def test_a_packing_without_them_differs_and_has_none(reinforced):
    plain = mc.pack({"specimen": SPEC["specimen"]}, fraction=0.3)
    assert plain.inclusions == []
    assert "phases" not in plain.report()
    assert plain != reinforced


def test_meshes_have_fibres_and_leave_voids_out(reinforced):
    mesh = reinforced.mesh(element_size=0.8, itz="none")
    volumes = mesh.volumes()
    holes, fibres = (phase["fraction"] * 40**3 for phase in reinforced.report()["phases"])
    assert volumes["fibre"] == pytest.approx(fibres, rel=0.1)
    assert 40**3 - sum(volumes.values()) == pytest.approx(holes, rel=0.1)
    assert set(np.unique(mesh.phase)) == {0, 2, 4}
    fibre_ids = {b.id for b in reinforced.inclusions if b.phase == "fibre"}
    assert set(mesh.aggregate[mesh.phase == 4]) <= fibre_ids


def test_pictures_and_meshio_know_the_phase(reinforced):
    pytest.importorskip("pyvista")
    surface = reinforced.to_pyvista()
    assert set(np.unique(surface.cell_data["phase"])) == {2, 3, 4}
    pytest.importorskip("meshio")
    mesh = reinforced.mesh(element_size=1.0)
    sets = mesh.to_meshio().cell_sets
    assert len(sets["FIBRE"][0]) == (mesh.phase == 4).sum() > 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"voids": {"fraction": 2, "diameter_mm": [1, 2]}}, "voids.fraction is 2; .* for 2 % write 0.02"),
        ({"fibres": {"fraction": 0.2, "diameter_mm": 0.5, "length_mm": 30}}, "fibres.fraction is 0.2 but straight"),
        ({"fibres": {"fraction": 0.01, "diameter_mm": 0.5, "length_mm": 60}}, "fibres.length_mm .* has only 40 mm of room"),
    ],
)
def test_impossible_inclusions_are_named(change, message):
    with pytest.raises(ValueError, match=message):
        mc.pack(SPEC | change)
