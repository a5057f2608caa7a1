"""Convex hulls, their integrals and their inward offsets."""

import copy
import itertools
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mesocrete as mc

CUBE = np.array(list(itertools.product((0.0, 2.0), repeat=3)))


def random_body(seed, count=25):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3))
    return mc.convex_hull(points / np.linalg.norm(points, axis=1)[:, None] * [3.0, 2.0, 1.0])


def test_hull_of_a_cube_has_six_square_faces():
    body = mc.convex_hull(np.vstack([CUBE, [[1.0, 1.0, 1.0]], CUBE]))
    assert body.vertices.shape == (8, 3)
    assert body.vertices.dtype == np.float64
    assert sorted(map(len, body.faces)) == [4] * 6
    assert body.triangles.shape == (12, 3)
    assert body.volume == 8.0
    assert body.area == 24.0
    assert body.centroid == pytest.approx([1.0, 1.0, 1.0], rel=1e-15)


def test_faces_are_counter_clockwise_from_outside():
    body = random_body(1)
    for face in body.faces:
        a, b, c = body.vertices[face[:3]]
        assert np.cross(b - a, c - a) @ (a - body.centroid) > 0.0


def test_triangles_close_the_surface():
    body = random_body(2)
    edges = [(t[i], t[(i + 1) % 3]) for t in body.triangles.tolist() for i in range(3)]
    assert len(set(edges)) == len(edges)
    assert {(b, a) for a, b in edges} == set(edges)


@pytest.mark.parametrize("seed", range(10))
def test_hull_agrees_with_qhull(seed):
    spatial = pytest.importorskip("scipy.spatial")
    points = np.random.default_rng(seed).normal(size=(40, 3))
    ours, theirs = mc.convex_hull(points), spatial.ConvexHull(points)
    assert len(ours.vertices) == len(theirs.vertices)
    assert ours.volume == pytest.approx(theirs.volume, rel=1e-12)
    assert ours.area == pytest.approx(theirs.area, rel=1e-12)


@pytest.mark.parametrize(
    ("points", "where"),
    [
        ([[1, 2, 3]], "one point"),
        ([[0, 0, 0], [1, 1, 1], [2, 2, 2]], "one line"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], "one plane"),
    ],
)
def test_points_without_a_solid_hull_say_where_they_lie(points, where):
    with pytest.raises(ValueError, match=where):
        mc.convex_hull(points)


def test_offset_of_a_cube_is_a_smaller_cube():
    inner = mc.convex_hull(CUBE).offset(0.25)
    assert inner.volume == pytest.approx(1.5**3, rel=1e-12)
    assert mc.convex_hull(CUBE).offset(0.0) == mc.convex_hull(CUBE)


def test_a_body_vanishes_where_the_thickness_reaches_its_inradius():
    body = mc.convex_hull(CUBE)
    assert body.offset(1.0 - 1e-9) is not None
    assert body.offset(1.0) is None
    assert body.offset(50.0) is None


@pytest.mark.parametrize("thickness", [-0.1, float("nan"), float("inf")])
def test_thickness_out_of_range_is_a_value_error(thickness):
    with pytest.raises(ValueError, match="thickness"):
        mc.convex_hull(CUBE).offset(thickness)


@given(st.integers(0, 2**32 - 1), st.integers(8, 40))
@settings(max_examples=50, deadline=None)
def test_pickle_and_copy_round_trip_bit_for_bit(seed, count):
    body = random_body(seed, count)
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
        again = pickle.loads(pickle.dumps(body, protocol=protocol))
        assert again == body
        assert again.vertices.tobytes() == body.vertices.tobytes()
        assert again.faces == body.faces
    assert copy.copy(body) == copy.deepcopy(body) == body


@pytest.mark.parametrize("shape", [{"kind": "sphere"}, {"kind": "ellipsoid"}, {"kind": "library", "path": "cross.obj"}])
def test_round_bodies_and_those_with_dents_stay_what_they_are_in_a_pickle(shape, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arms = [[x, y, z] for x in (-3, -1, 1, 3) for y in (-3, -1, 1, 3) for z in (-1, 1)]
    faces = cross_faces(arms)
    lines = [f"v {x} {y} {z}" for x, y, z in arms] + ["f " + " ".join(str(i + 1) for i in face) for face in faces]
    (tmp_path / "cross.obj").write_text("\n".join(lines))
    specimen = {"kind": "cube", "side_mm": 40}
    packing = mc.pack({"specimen": specimen, "fraction": 0.1, "shape": shape, "grading": {"d_min_mm": 10, "d_max_mm": 16}})
    for aggregate in packing.aggregates:
        again = pickle.loads(pickle.dumps(aggregate))
        assert again == aggregate and again.body == aggregate.body
        assert again.body.volume == aggregate.body.volume
    restore, (vertices, faces, dents, is_round) = packing.aggregates[0].body.__reduce__()
    if is_round:
        with pytest.raises(ValueError, match="damaged"):
            restore(vertices + 0.1 * np.arange(len(vertices))[:, None], faces, dents, is_round)
    else:
        assert dents == 0


def cross_faces(points):
    """Faces of a plus sign of unit squares, extruded: quadrilaterals, counter-clockwise from outside."""
    at = {tuple(point): i for i, point in enumerate(points)}
    cells = {(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)}
    steps = (-3, -1, 1, 3)
    faces = []
    for i, j in cells:
        (x, p), (y, q) = ((steps[k + 1], steps[k + 2]) for k in (i, j))
        ring = [(x, y), (p, y), (p, q), (x, q)]
        faces.append([at[(*corner, 1)] for corner in ring])
        faces.append([at[(*corner, -1)] for corner in reversed(ring)])
        beside = [(i, j - 1), (i + 1, j), (i, j + 1), (i - 1, j)]
        for k, cell in enumerate(beside):
            if cell not in cells:
                a, b = ring[k], ring[(k + 1) % 4]
                faces.append([at[(*a, -1)], at[(*b, -1)], at[(*b, 1)], at[(*a, 1)]])
    return faces


def test_damaged_pickles_are_value_errors():
    restore, (vertices, *_) = mc.convex_hull(CUBE).__reduce__()
    for faces in ([[0, 1, 99]], [[0, 1]]):
        with pytest.raises(ValueError, match="damaged"):
            restore(vertices, faces)


def test_equality_is_of_values_and_bodies_do_not_hash():
    assert mc.convex_hull(CUBE) == mc.convex_hull(CUBE)
    assert mc.convex_hull(CUBE) != mc.convex_hull(CUBE + 1.0)
    assert mc.convex_hull(CUBE) != "a cube"
    with pytest.raises(TypeError):
        hash(mc.convex_hull(CUBE))


def test_repr_says_what_it_is():
    assert repr(mc.convex_hull(CUBE)) == "Polyhedron(8 vertices, 6 faces, volume=8 mm3)"


def test_bodies_cannot_be_changed():
    with pytest.raises(AttributeError):
        mc.convex_hull(CUBE).volume = 3.0
