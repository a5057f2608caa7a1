"""A packing: what was asked, what was reached, and every aggregate."""

import copy
import json
import math
import pickle

import numpy as np
import pytest

import mesocrete as mc
from mesocrete import gjk

REPORT_KEYS = {
    "version", "seed", "target_fraction", "fraction", "aggregates", "discarded", "specimen", "classes", "stop_reason",
    "work",
}  # fmt: skip


def test_the_target_is_reached_class_by_class(packing):
    report = packing.report()
    assert packing.fraction == report["fraction"] == pytest.approx(0.35, abs=0.002)
    assert sum(c["aggregates"] for c in report["classes"]) == len(packing) == report["aggregates"]
    assert [c["d_min_mm"] for c in report["classes"]] == [5.0, 10.0, 15.0]


def test_fraction_is_the_polyhedra_over_the_specimen(packing):
    total = math.fsum(a.volume for a in packing.aggregates)
    assert total / packing.report()["specimen"]["volume_mm3"] == pytest.approx(packing.fraction, rel=1e-12)


def test_a_citation_has_the_dimensions_and_the_figures_of_the_packing(packing):
    text = " ".join(packing.cite().split())
    assert "The specimen is a cube of 60 mm (216,000 mm3)." in text and f"a volume fraction of {packing.fraction:.4f}" in text
    assert "[1] The mesocrete developers" in text
    mesh = packing.mesh(method="voxel", element_size=2.0, accept_phase_error=True)
    materials = {"mortar_strength": {"compressive_mpa": 41.0, "tensile_mpa": 3.5}}
    text = " ".join(packing.cite(mesh, materials=materials).split())
    assert f"The mesh has {len(mesh.cells):,} hexahedra of 2 mm (voxel) with {len(mesh.points):,} nodes; of all phases the" in text
    assert "the mortar has a compressive strength of 41 MPa, a tensile strength of 3.5 MPa, and the ITZ" in text
    with pytest.raises(ValueError, match="mesh is of another packing"):
        mc.pack({"specimen": mc.Specimen.cube(60)}, seed=8, fraction=0.1).cite(mesh)


def test_report_has_the_keys_of_the_summary(packing):
    report = packing.report()
    assert REPORT_KEYS <= report.keys()
    assert report["specimen"] == {"kind": "cube", "volume_mm3": 216000.0}
    assert "seconds" not in report
    assert {"total", "take", "place", "write"} <= packing.work["seconds"].keys()
    assert packing.work["gjk_calls"] == report["work"]["gjk_calls"]
    assert {"candidates", "pairs_broad", "pairs_sphere", "pairs_axis", "gjk_calls", "exact_calls"} <= report["work"].keys()
    assert report["seed"] == packing.seed == 7


def test_no_two_aggregates_overlap_by_our_own_gjk(packing):
    bodies = [a.vertices for a in packing.aggregates]
    for i, body in enumerate(bodies[:60]):
        assert not gjk.intersects_many(body, bodies[:i] + bodies[i + 1 :]).any()


def test_every_vertex_lies_inside_the_specimen(packing):
    low, high = packing.bounds
    for aggregate in packing.aggregates:
        assert (aggregate.vertices >= low).all()
        assert (aggregate.vertices <= high).all()


def test_aggregates_are_a_sequence_in_descending_volume(packing):
    aggregates = packing.aggregates
    assert len(aggregates) == len(packing)
    assert [a.id for a in aggregates] == list(range(len(packing)))
    volumes = [a.volume for a in aggregates]
    assert volumes == sorted(volumes, reverse=True)
    assert aggregates[-1] == aggregates[len(packing) - 1]
    assert aggregates[np.int64(0)] == aggregates[0]
    assert [a.id for a in aggregates[5:0:-2]] == [5, 3, 1]
    assert aggregates[0] in aggregates
    assert aggregates.index(aggregates[3]) == 3
    assert aggregates.index(aggregates[3], -len(packing)) == 3
    with pytest.raises(ValueError, match="is not among the aggregates"):
        aggregates.index(aggregates[3], 4)
    assert (aggregates.count(aggregates[3]), aggregates.count("no aggregate")) == (1, 0)
    assert pickle.loads(pickle.dumps(aggregates)) == aggregates
    assert [a.id for a in reversed(aggregates)][0] == len(packing) - 1
    with pytest.raises(IndexError):
        aggregates[len(packing)]
    with pytest.raises(IndexError):
        aggregates[-len(packing) - 1]
    with pytest.raises(IndexError):
        aggregates[2**70]
    with pytest.raises(TypeError, match="int or slice"):
        aggregates["first"]


def test_an_aggregate_is_a_closed_convex_body_with_a_shell(packing):
    for aggregate in packing.aggregates[:20]:
        assert 20 <= len(aggregate.vertices) <= 30
        assert aggregate.vertices.dtype == np.float64
        assert aggregate.triangles.shape == (sum(len(f) - 2 for f in aggregate.faces), 3)
        assert 0.1 <= aggregate.itz_thickness <= 0.5
        core = aggregate.core()
        assert 0.0 < core.volume < aggregate.volume
        assert core == aggregate.body.offset(aggregate.itz_thickness)
        hull = mc.convex_hull(aggregate.vertices)
        assert hull.volume == pytest.approx(aggregate.volume, rel=1e-14)


def test_an_aggregate_outlives_its_packing(small_spec):
    aggregate = mc.pack(small_spec, fraction=0.05).aggregates[0]
    assert aggregate.volume > 0.0


def test_the_same_seed_gives_the_same_packing_and_another_another(small_spec, packing):
    assert mc.pack(small_spec, seed=7) == packing
    assert mc.pack(mc.Spec(**small_spec), seed=7) == packing
    assert mc.pack(small_spec, seed=8) != packing


def test_keywords_replace_what_the_spec_says(small_spec):
    packing = mc.pack(mc.Spec(**small_spec), seed=np.int64(3), fraction=np.float64(0.1))
    assert packing.spec == mc.Spec(**small_spec).replace(seed=3, fraction=0.1)


def test_falling_short_is_a_report_not_an_error(small_spec):
    spec = small_spec | {"fraction": 0.55, "placement": {"strategy": "take-and-place", "attempts": 5}}
    packing = mc.pack(spec)
    report = packing.report()
    assert packing.fraction < 0.5
    assert report["stop_reason"] == "attempts-exhausted"
    assert report["discarded"] > 0


def test_pickle_and_copy_round_trip_bit_for_bit(packing):
    again = pickle.loads(pickle.dumps(packing))
    assert again == packing
    assert again.report() == packing.report()
    for ours, theirs in zip(again.aggregates, packing.aggregates, strict=True):
        assert ours.vertices.tobytes() == theirs.vertices.tobytes()
    assert copy.copy(packing) == copy.deepcopy(packing) == packing
    aggregate = packing.aggregates[3]
    assert pickle.loads(pickle.dumps(aggregate)) == copy.deepcopy(aggregate) == aggregate


def test_damaged_pickles_are_value_errors(packing):
    restore, (model, report) = packing.__reduce__()
    for state in ((b"", report), (model[:-5], report), (model, "{}"), (model.replace(b'"id":0', b'"id":9'), report)):
        with pytest.raises(ValueError, match="damaged"):
            restore(*state)


def test_packings_do_not_hash_and_say_what_they_are(packing):
    with pytest.raises(TypeError):
        hash(packing)
    assert repr(packing) == f"Packing({len(packing)} aggregates in a cube, fraction={packing.fraction:.4f}, seed=7)"
    assert "Aggregate(id=0, size_class=" in repr(packing.aggregates[0])
    assert repr(packing.aggregates) == f"<{len(packing)} aggregates>"


def test_check_proves_the_packing(packing):
    check = packing.check()
    assert check["sound"] is True
    assert check["findings"] == []
    assert check["aggregates"] == len(packing)
    assert check["pairs_tested"] > len(packing)
    assert check["fraction"] == pytest.approx(packing.fraction, rel=1e-12)


def test_check_finds_what_a_hand_has_moved(packing, tmp_path):
    packing.write(tmp_path / "model.json")
    model = json.loads((tmp_path / "model.json").read_text(encoding="utf-8"))
    first, second = model["aggregates"][:2]
    shift = np.mean(second["vertices"], axis=0) - np.mean(first["vertices"], axis=0)
    first["vertices"] = (np.array(first["vertices"]) + shift).tolist()
    (tmp_path / "moved.json").write_text(json.dumps(model), encoding="utf-8")
    check = mc.load(tmp_path / "moved.json").check()
    assert check["sound"] is False
    assert check["findings"]


@pytest.mark.parametrize(("seed", "error"), [(-1, ValueError), (2**64, ValueError), (1.5, TypeError), ("1", TypeError), (True, TypeError)])
def test_seeds_out_of_range_are_refused(seed, error):
    with pytest.raises(error, match="seed.*2\\^64 - 1"):
        mc.pack(seed=seed)


@pytest.mark.parametrize(("fraction", "error"), [(0, ValueError), (1, ValueError), (45, ValueError), (float("nan"), ValueError), ("0.4", TypeError), (True, TypeError)])
def test_fractions_out_of_range_are_refused(fraction, error):
    with pytest.raises(error, match="fraction.*above 0 and below 1"):
        mc.pack(fraction=fraction)


def test_other_wrong_arguments_are_refused():
    with pytest.raises(TypeError, match="None, a dict, a path or a mesocrete.Spec"):
        mc.pack(3)
    with pytest.raises(TypeError, match="callable"):
        mc.pack(progress=3)
    with pytest.raises(TypeError):
        mc.pack({}, 3)


def test_statistics_know_their_limits(packing):
    statistics = packing.statistics(lines=2000, points=20_000)
    assert statistics["fraction"] == pytest.approx(packing.fraction, rel=1e-12)
    assert statistics == packing.statistics(lines=2000, points=20_000)
    with pytest.raises(ValueError, match="lag_mm is -1; it must be a positive length"):
        packing.statistics(lag_mm=-1.0)
    with pytest.raises(ValueError, match="lagmm is not a known key"):
        packing.statistics(lagmm=1.0)
