"""Collision of convex hulls of points: closed sets, every answer certified."""

import itertools
import sys
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mesocrete as mc
from mesocrete import gjk

METHODS = ["enhanced", "classical", "signed-volumes", "exact"]
CUBE = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
# Integers keep the reference exact, and meet flat, collinear, repeated and touching bodies all the time.
GRID = st.lists(st.tuples(*[st.integers(-3, 3)] * 3), min_size=1, max_size=7).map(lambda rows: np.array(rows, float))


def ball(rng, center, radius, count=25):
    points = rng.normal(size=(count, 3))
    return center + radius * points / np.linalg.norm(points, axis=1)[:, None]


@pytest.mark.parametrize("method", METHODS)
def test_touching_cubes_overlap_and_one_ulp_apart_they_do_not(method):
    assert gjk.intersects(CUBE, CUBE + [1.0, 0.0, 0.0], method=method)
    assert gjk.intersects(CUBE, CUBE + [1.0, 1.0, 1.0], method=method)
    gap = np.nextafter(1.0, 2.0)
    assert not gjk.intersects(CUBE, CUBE + [gap, 0.0, 0.0], method=method)


@pytest.mark.parametrize("method", METHODS)
def test_bodies_may_be_points_segments_and_polygons(method):
    segment = [[-1, 0.5, 0.5], [2, 0.5, 0.5]]
    polygon = [[0.5, -1, -1], [0.5, 2, -1], [0.5, 0, 3]]
    point = [[0.5, 0.5, 0.5]]
    for a, b in itertools.combinations([CUBE, segment, polygon, point], 2):
        assert gjk.intersects(a, b, method=method)
        assert not gjk.intersects(a, np.add(b, [0, 9, 0]), method=method)


@given(GRID, GRID)
@settings(max_examples=300, deadline=None)
def test_all_methods_agree_on_small_integer_bodies(a, b):
    answers = {gjk.intersects(a, b, method=method) for method in METHODS}
    assert len(answers) == 1
    assert answers == {gjk.distance(a, b) == 0.0}
    assert answers == {gjk.intersects(b[::-1], np.repeat(a, 2, axis=0))}


def linear_program_says_they_intersect(a, b):
    """A point of both hulls as the feasible point of a linear program, on integers far from its tolerance."""
    optimize = pytest.importorskip("scipy.optimize")
    ones, zeros = np.ones, np.zeros
    equalities = np.vstack(
        [np.hstack([a.T, -b.T]), np.r_[ones(len(a)), zeros(len(b))], np.r_[zeros(len(a)), ones(len(b))]]
    )
    result = optimize.linprog(zeros(len(a) + len(b)), A_eq=equalities, b_eq=[0, 0, 0, 1, 1])
    return result.status == 0


def test_answers_match_a_linear_program_on_random_integer_pairs():
    pytest.importorskip("scipy")
    rng = np.random.default_rng(11)
    hits = 0
    for _ in range(150):
        a, b = (rng.integers(-4, 5, size=(rng.integers(1, 9), 3)).astype(float) for _ in range(2))
        b = b + rng.integers(-3, 4, size=3)
        expected = linear_program_says_they_intersect(a, b)
        hits += expected
        assert gjk.intersects(a, b) == expected
    assert 45 < hits < 105, "the pairs must be neither all apart nor all overlapping"


def test_distance_of_boxes_is_the_exact_one():
    assert gjk.distance(CUBE, CUBE + [4.0, 5.0, 0.0]) == 5.0
    assert gjk.distance(CUBE, CUBE + [1.0, 0.0, 0.0]) == 0.0
    assert gjk.distance([[0, 0, 0]], [[1, 2, 2]]) == 3.0


@given(st.integers(0, 2**32 - 1), st.floats(1e-12, 10.0))
@settings(max_examples=100, deadline=None)
def test_distance_is_zero_exactly_when_they_intersect(seed, shift):
    rng = np.random.default_rng(seed)
    a, b = ball(rng, np.zeros(3), 1.0), ball(rng, np.array([1.0 + shift, 0.2, 0.1]), 1.0)
    assert (gjk.distance(a, b) == 0.0) == gjk.intersects(a, b)


def test_many_answers_are_the_single_ones():
    rng = np.random.default_rng(3)
    a = ball(rng, np.zeros(3), 1.0)
    bodies = [ball(rng, rng.uniform(-2, 2, size=3), 0.7, count=int(rng.integers(4, 30))) for _ in range(5000)]
    expected = np.array([gjk.intersects(a, b) for b in bodies])
    assert 0.2 < expected.mean() < 0.8
    for method in METHODS[:3]:
        many = gjk.intersects_many(a, bodies, method=method)
        assert many.dtype == bool
        assert np.array_equal(many, expected)


def test_many_takes_any_iterable_and_no_bodies_at_all():
    assert gjk.intersects_many(CUBE, []).shape == (0,)
    assert gjk.intersects_many(CUBE, (CUBE + s for s in (0.0, 2.0))).tolist() == [True, False]
    assert gjk.intersects_many(CUBE, np.stack([CUBE, CUBE + 2.0])).tolist() == [True, False]
    with pytest.raises(TypeError, match="iterable"):
        gjk.intersects_many(CUBE, 3)


def test_unknown_methods_are_named_with_those_there_are():
    with pytest.raises(ValueError, match="'?\"?newton.*enhanced.*classical"):
        gjk.intersects(CUBE, CUBE, method="newton")
    with pytest.raises(TypeError):
        gjk.intersects(CUBE, CUBE, method=3)


def test_eight_threads_get_the_serial_answers():
    rng = np.random.default_rng(5)
    pairs = [(ball(rng, np.zeros(3), 1.0), ball(rng, rng.uniform(-1.5, 1.5, 3), 1.0)) for _ in range(100)]
    serial = [(gjk.intersects(a, b), gjk.distance(a, b)) for a, b in pairs]
    results = [None] * 8

    def work(slot):
        results[slot] = [[(gjk.intersects(a, b), gjk.distance(a, b)) for a, b in pairs] for _ in range(20)]

    threads = [threading.Thread(target=work, args=(slot,)) for slot in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(round_ == serial for result in results for round_ in result)


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc/self/statm")
def test_memory_stays_flat_over_many_calls():
    def calls(count):
        for _ in range(count):
            gjk.intersects(CUBE, CUBE[:4])
            mc.convex_hull(CUBE).vertices.sum()

    def resident_pages():
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1])

    calls(5_000)
    before = resident_pages()
    calls(50_000)
    assert resident_pages() - before < 500  # 2 MB: a leak of 40 bytes a call shows


def grains(rng, count, away=0.0):
    return [ball(rng, rng.uniform(-away, away, 3) + rng.normal(size=3), rng.uniform(0.3, 1.0)) for _ in range(count)]


def test_closest_points_are_those_of_boxes():
    points = gjk.closest_points(CUBE, CUBE + [3.0, 0.25, 5.0])
    assert points.shape == (2, 3)
    assert np.linalg.norm(points[1] - points[0]) == np.hypot(2.0, 4.0)
    shared = gjk.closest_points(CUBE, CUBE + [0.5, 0.5, 0.5])
    assert (shared[0] == shared[1]).all()


def test_penetration_is_the_shortest_way_out_of_a_box():
    found = gjk.penetration(CUBE, CUBE + [0.1, 0.7, 0.2])
    assert isinstance(found, gjk.Penetration)
    assert found.at_least <= 0.3 <= found.depth < 0.3 + 1e-13
    assert found.direction == pytest.approx([0.0, 1.0, 0.0])
    assert not gjk.intersects(CUBE, CUBE + [0.1, 0.7, 0.2] + found.direction * (found.depth + 1e-12))
    assert gjk.penetration(CUBE, CUBE + 2.0) is None


def test_a_moving_box_arrives_when_its_distance_is_covered():
    found = gjk.time_of_impact(CUBE, CUBE + [4.0, 0.0, 0.0], [-4.0, 0.0, 0.0])
    assert isinstance(found, gjk.Impact)
    assert found.not_before <= 0.75 <= found.by < 0.75 + 1e-13
    assert found.direction == pytest.approx([1.0, 0.0, 0.0])
    assert gjk.time_of_impact(CUBE, CUBE + [4.0, 0.0, 0.0], [0.0, 9.0, 0.0]) is None
    with pytest.raises(ValueError, match="motion must be three finite numbers"):
        gjk.time_of_impact(CUBE, CUBE, [0.0, np.nan, 0.0])


@pytest.mark.parametrize("away", [0.0, 300.0])
def test_bodies_answer_as_their_points_do(away):
    rng = np.random.default_rng(5)
    points = grains(rng, 40, away / 300.0)
    points = [p + away for p in points]
    bodies = gjk.Bodies(points)
    truth = np.array([[gjk.intersects(a, b) for b in points] for a in points])
    assert 100 < truth.sum() < 1500
    for row, a in zip(truth, points, strict=True):
        assert (bodies.intersects(a) == row).all()
        assert (gjk.intersects_many(a, points) == row).all()
    pairs = np.argwhere(np.ones_like(truth))
    assert (bodies.intersects_pairs(pairs) == truth.ravel()).all()
    upper = np.argwhere(np.triu(truth, 1))
    assert (bodies.overlapping_pairs() == upper).all()


def test_bodies_are_shifted_exactly():
    row = gjk.Bodies([CUBE, CUBE + [2.0, 0.0, 0.0], [[9.0, 9.0, 9.0]]])
    ulp = np.nextafter(1.0, 2.0) - 1.0
    shifts = [[-1.0, 0.0, 0.0], [-1.0 + ulp, 0.0, 0.0], [-1.0, 1e-300, -1.0], [-1.0, 1.0 + ulp, 0.0]]
    assert row.intersects_pairs([[0, 1]] * 4, shifts=shifts).tolist() == [True, False, True, False]
    assert row.intersects(CUBE, shift=[1.0, 1.0, 1.0]).tolist() == [True, True, False]
    assert row.intersects_pairs(np.empty((0, 2), int)).shape == (0,)
    assert row.intersects_pairs([[1, 0]], other=gjk.Bodies([CUBE + [3.0, 1.0, 0.5]])).tolist() == [True]


def test_bodies_are_turned_and_displaced():
    rng = np.random.default_rng(6)
    rotation = pytest.importorskip("scipy.spatial.transform").Rotation
    shapes, positions = grains(rng, 12), rng.uniform(-1, 1, (12, 3))
    turns = rotation.random(12, random_state=7)
    placed = gjk.Bodies(shapes).placed(positions, turns.as_quat())
    expected = [turn.apply(shape) + at for turn, shape, at in zip(turns, shapes, positions, strict=True)]
    assert np.allclose(placed.points(3), expected[3], atol=1e-14)
    truth = [[i, j] for i, j in itertools.combinations(range(12), 2) if gjk.intersects(placed.points(i), placed.points(j))]
    assert placed.overlapping_pairs().tolist() == truth
    with pytest.raises(ValueError, match=r"rotations has shape \(12, 3\)"):
        gjk.Bodies(shapes).placed(positions, positions)


def test_places_are_clear_beyond_the_gap():
    rng = np.random.default_rng(8)
    bodies, own = gjk.Bodies(shapes := grains(rng, 30, 3.0)), ball(rng, 0.0, 0.5)
    shifts = rng.uniform(-4, 4, (200, 3))
    for gap in (0.0, 0.25):
        truth = [all(gjk.distance(own + shift, shape) > gap for shape in shapes) for shift in shifts]
        assert bodies.clear(own, shifts, gap=gap).tolist() == truth
        assert 20 < sum(truth) < 190
    with pytest.raises(ValueError, match="gap is -1"):
        bodies.clear(own, shifts, gap=-1.0)


def test_bodies_take_what_the_package_makes_and_survive_pickling():
    import pickle

    packing = mc.pack({"specimen": {"kind": "cube", "side_mm": 60.0}}, fraction=0.2, seed=3)
    bodies = gjk.Bodies(packing.aggregates)
    assert len(bodies) == len(packing)
    assert len(bodies.overlapping_pairs()) == 0
    copy = pickle.loads(pickle.dumps(bodies))  # noqa: S301 - our own
    assert (copy.points(0) == bodies.points(0)).all()
    assert repr(copy) == f"Bodies({len(packing)} bodies)"
    assert bodies.intersects(packing.aggregates[0]).sum() == 1


def test_wrong_bodies_and_pairs_are_named():
    bodies = gjk.Bodies([CUBE, CUBE + 2.0])
    with pytest.raises(ValueError, match=r"bodies\[1\]\[0\] is"):
        gjk.Bodies([CUBE, [[0.0, np.nan, 0.0]]])
    with pytest.raises(ValueError, match=r"pairs\[1\] is \(0, 2\)"):
        bodies.intersects_pairs([[0, 1], [0, 2]])
    with pytest.raises(TypeError, match="pairs has dtype float64"):
        bodies.intersects_pairs([[0.0, 1.0]])
    with pytest.raises(ValueError, match="shifts has 1 rows"):
        bodies.intersects_pairs([[0, 1], [1, 0]], shifts=[[0, 0, 0]])
    with pytest.raises(IndexError, match="there is no body 2"):
        bodies.points(2)
