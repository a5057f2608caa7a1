"""Properties that hold for whatever Hypothesis thinks of; what fails is shrunk to its smallest case."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mesocrete as mc

NUMBER = st.floats(-100, 100, allow_nan=False, width=32)
POINTS = st.lists(st.tuples(NUMBER, NUMBER, NUMBER), min_size=1, max_size=12).map(lambda rows: np.array(rows, dtype=float))
STEP = st.integers(-4, 4).map(float)
# Lattices: repeated, collinear and coplanar points, and bodies that touch.
LATTICE = st.lists(st.tuples(STEP, STEP, STEP), min_size=1, max_size=12).map(lambda rows: np.array(rows, dtype=float))
BODY = st.one_of(POINTS, LATTICE)


@given(BODY, BODY)
@settings(max_examples=300, deadline=None)
def test_searches_agree_and_a_distance_is_zero_on_contact_alone(a, b):
    answer = mc.gjk.intersects(a, b, method="exact")
    assert [mc.gjk.intersects(x, y, method=m) for x, y in ((a, b), (b, a)) for m in ("enhanced", "classical")] == [answer] * 4
    assert (mc.gjk.distance(a, b) == 0) == answer


@given(BODY, BODY, st.integers(-60, 60))
@settings(max_examples=200, deadline=None)
def test_powers_of_two_scale_answers_and_distances_exactly(a, b, power):
    scale = 2.0**power
    assert mc.gjk.intersects(scale * a, scale * b) == mc.gjk.intersects(a, b)
    assert mc.gjk.distance(scale * a, scale * b) == pytest.approx(scale * mc.gjk.distance(a, b), rel=1e-15, abs=0)


@given(BODY, st.lists(st.floats(0, 1), min_size=12, max_size=12))
@settings(max_examples=200, deadline=None)
def test_points_between_points_share_one_with_them(a, weights):
    weights = np.array(weights[: len(a)]) + 1e-9
    mean = (weights[:, None] * a).sum(axis=0) / weights.sum()
    assert mc.gjk.distance(a, [mean]) <= 1e-14 * (1 + np.abs(a).max())
    assert mc.gjk.intersects(a, a[:1])


@given(BODY)
@settings(max_examples=300, deadline=None)
def test_a_hull_holds_its_points_and_a_flat_one_is_an_error(points):
    try:
        hull = mc.convex_hull(points)
    except ValueError:
        return
    assert hull.volume > 0 and hull.area > 0
    assert all(mc.gjk.intersects(hull.vertices, [point], method="exact") for point in points)
    assert {tuple(vertex) for vertex in hull.vertices} <= {tuple(point) for point in points}


@given(BODY, st.floats(0, 2))
@settings(max_examples=300, deadline=None)
def test_an_offset_lies_inside_by_its_thickness(points, thickness):
    try:
        hull = mc.convex_hull(points)
        inner = hull.offset(thickness)
    except (ValueError, ArithmeticError):
        return
    if inner is None:
        return
    slack = 1e-9 * (1 + np.abs(points).max())
    assert (inner.vertices.min(axis=0) >= hull.vertices.min(axis=0) + thickness - slack).all()
    assert (inner.vertices.max(axis=0) <= hull.vertices.max(axis=0) - thickness + slack).all()
    assert inner.volume <= hull.volume * (1 + 1e-9)


SPECIMEN = st.one_of(
    st.fixed_dictionaries({"kind": st.just("cube"), "side_mm": st.floats(20, 32), "periodic": st.sampled_from([[], ["x"], ["x", "y", "z"]])}),
    st.fixed_dictionaries({"kind": st.just("cylinder"), "diameter_mm": st.floats(22, 32), "height_mm": st.floats(20, 32)}),
    st.fixed_dictionaries({"kind": st.just("sphere"), "diameter_mm": st.floats(24, 34)}),
)
SPEC = st.fixed_dictionaries(
    {
        "specimen": SPECIMEN,
        "fraction": st.floats(0.05, 0.4),
        "seed": st.integers(0, 2**64 - 1),
        "grading": st.fixed_dictionaries({"d_max_mm": st.sampled_from([8.0, 10.0, 12.0])}),
        "shape": st.fixed_dictionaries({"kind": st.sampled_from(["polyhedron", "rounded", "crushed"])}),
        "itz": st.tuples(st.floats(0, 0.3), st.floats(0.3, 1)).map(lambda t: {"thickness_mm": list(t)}),
        "placement": st.fixed_dictionaries(
            {"min_gap_mm": st.floats(0, 0.3), "wall_gap_mm": st.floats(0, 0.3), "time_limit_s": st.just(5.0)}
        ),
    }
)


@given(SPEC)
@settings(max_examples=25, deadline=None)
def test_whatever_is_packed_is_sound_and_survives_a_file(tmp_path_factory, spec):
    try:
        packing = mc.pack(spec)
    except ValueError:
        return
    assert packing.check()["findings"] == []
    path = tmp_path_factory.mktemp("models") / "model.json"
    packing.write(path)
    assert mc.load(path) == packing


JUNK = st.recursive(
    st.one_of(st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=5)),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.text(max_size=8), inner, max_size=3)),
    max_leaves=6,
)
KEY = st.sampled_from(["seed", "fraction", "specimen", "grading", "shape", "itz", "placement", "voids", "fibres", "mix", "x"])


@given(st.dictionaries(KEY, JUNK, min_size=1, max_size=3))
@settings(max_examples=300, deadline=None)
def test_a_spec_of_junk_is_a_value_or_type_error(spec):
    try:
        mc.Spec(**spec)
    except (ValueError, TypeError):
        return
