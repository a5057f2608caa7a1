"""What counts as an (n, 3) array, wherever points are taken."""

import threading

import numpy as np
import pytest

import mesocrete as mc

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=np.float64)
TAKERS = {
    "convex_hull": mc.convex_hull,
    "intersects, a": lambda points: mc.gjk.intersects(points, CUBE),
    "intersects, b": lambda points: mc.gjk.intersects(CUBE, points),
    "distance": lambda points: mc.gjk.distance(points, CUBE),
    "intersects_many, a": lambda points: mc.gjk.intersects_many(points, [CUBE]),
    "intersects_many, bodies": lambda points: mc.gjk.intersects_many(CUBE, [CUBE, points]),
}


def unaligned(array):
    raw = np.empty(array.nbytes + 1, dtype=np.uint8)
    view = raw[1:].view(np.float64).reshape(array.shape)
    view[:] = array
    assert not view.flags.aligned
    return view


def read_only(array):
    array = array.copy()
    array.flags.writeable = False
    return array


def memory_mapped(array, folder):
    mapped = np.memmap(folder / "points.bin", dtype=np.float64, mode="w+", shape=array.shape)
    mapped[:] = array
    return mapped


ACCEPTED = {
    "C order": lambda a: a,
    "Fortran order": np.asfortranarray,
    "transposed": lambda a: np.ascontiguousarray(a.T).T,
    "negative strides": lambda a: a[::-1].copy()[::-1],
    "columns of a wider array": lambda a: np.hstack([a, a])[:, :3],
    "every other row": lambda a: np.repeat(a, 2, axis=0)[::2],
    "broadcast": lambda a: np.broadcast_to(a, a.shape),
    "read-only": read_only,
    "unaligned": unaligned,
    "byte-swapped": lambda a: a.astype(a.dtype.newbyteorder()),
    "float16": lambda a: a.astype(np.float16),
    "float32": lambda a: a.astype(np.float32),
    "long double": lambda a: a.astype(np.longdouble),
    "int8": lambda a: a.astype(np.int8),
    "int64": lambda a: a.astype(np.int64),
    "uint64": lambda a: a.astype(np.uint64),
    "list of lists": np.ndarray.tolist,
    "tuple of arrays": tuple,
    "masked array without a mask": np.ma.array,
}


@pytest.mark.parametrize("taker", TAKERS)
@pytest.mark.parametrize("form", ACCEPTED)
def test_real_numbers_in_any_layout_are_accepted(taker, form):
    assert str(TAKERS[taker](ACCEPTED[form](CUBE))) == str(TAKERS[taker](CUBE))


def test_memory_mapped_arrays_are_accepted(tmp_path):
    assert mc.convex_hull(memory_mapped(CUBE, tmp_path)).volume == 1.0


@pytest.mark.parametrize("form", ACCEPTED)
def test_layout_does_not_change_the_hull(form):
    assert mc.convex_hull(ACCEPTED[form](CUBE)) == mc.convex_hull(CUBE)


WRONG_TYPE = {
    "bool": CUBE.astype(bool),
    "complex": CUBE.astype(complex),
    "object": CUBE.astype(object),
    "strings": CUBE.astype(str),
    "dates": CUBE.astype("datetime64[s]"),
    "structured": np.zeros(4, dtype=[("x", float), ("y", float), ("z", float)]),
    "None": None,
    "a dict": {"x": 1},
    "a function": len,
}


@pytest.mark.parametrize("taker", TAKERS)
@pytest.mark.parametrize("form", WRONG_TYPE)
def test_objects_without_real_numbers_are_type_errors(taker, form):
    with pytest.raises(TypeError, match="real numbers"):
        TAKERS[taker](WRONG_TYPE[form])


WRONG_SHAPE = {
    "empty list": [],
    "(0, 3)": np.zeros((0, 3)),
    "(3,)": np.zeros(3),
    "0-d": np.float64(3.0),
    "a number": 3.0,
    "(4, 2)": np.zeros((4, 2)),
    "(3, 4)": np.zeros((3, 4)),
    "(2, 4, 3)": np.zeros((2, 4, 3)),
    "ragged": [[0.0, 0.0, 0.0], [1.0, 1.0]],
}


@pytest.mark.parametrize("taker", TAKERS)
@pytest.mark.parametrize("form", WRONG_SHAPE)
def test_another_shape_is_a_value_error_that_names_the_right_one(taker, form):
    with pytest.raises(ValueError, match=r"\(n, 3\)"):
        TAKERS[taker](WRONG_SHAPE[form])


@pytest.mark.parametrize("taker", TAKERS)
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite_are_named_by_their_row(taker, value):
    points = CUBE.copy()
    points[5, 1] = value
    with pytest.raises(ValueError, match=r"\[5\].*finite"):
        TAKERS[taker](points)


def test_the_wrong_argument_is_named():
    with pytest.raises(ValueError, match=r"^b has shape"):
        mc.gjk.intersects(CUBE, np.zeros((4, 2)))
    with pytest.raises(ValueError, match=r"^bodies\[1\] has shape"):
        mc.gjk.intersects_many(CUBE, [CUBE, np.zeros((4, 2))])


@pytest.mark.parametrize("magnitude", [1e61, 1e-61, 5e-324, 1.7e308])
def test_a_hull_of_magnitudes_out_of_range_is_refused(magnitude):
    points = CUBE.copy()
    points[2, 2] = magnitude
    with pytest.raises(ValueError, match="1e-60 to 1e60"):
        mc.convex_hull(points)


@pytest.mark.parametrize("magnitude", [1e61, 1e-61, 5e-324, 1.7e308])
def test_collision_answers_for_every_finite_magnitude(magnitude):
    points = CUBE.copy()
    points[2, 2] = magnitude
    assert mc.gjk.intersects(points, CUBE)
    assert mc.gjk.intersects(CUBE, points)
    assert mc.gjk.distance(points, CUBE) == 0.0


@pytest.mark.parametrize("taker", TAKERS)
def test_integers_that_float64_cannot_hold_are_refused(taker):
    points = CUBE.astype(np.int64)
    points[3, 0] = 2**53 + 1
    with pytest.raises(ValueError, match=r"\[3\].*2\^53"):
        TAKERS[taker](points)


@pytest.mark.parametrize("taker", TAKERS)
def test_masked_entries_are_refused(taker):
    points = np.ma.array(CUBE, mask=CUBE > 2)
    points[1, 1] = np.ma.masked
    with pytest.raises(ValueError, match="masked"):
        TAKERS[taker](points)


def test_an_object_may_raise_its_own_exception_when_numpy_asks_it():
    class Broken:
        def __array__(self, *args, **kwargs):
            raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        mc.convex_hull(Broken())


def test_arrays_changed_by_another_thread_do_no_harm():
    points = np.repeat(CUBE, 50, axis=0) + np.linspace(0, 1, 400)[:, None]
    stop = threading.Event()

    def scribble():
        while not stop.is_set():
            points[:] = np.random.default_rng(0).random(points.shape)

    thread = threading.Thread(target=scribble)
    thread.start()
    try:
        for _ in range(200):
            assert mc.convex_hull(points).volume > 0.0
    finally:
        stop.set()
        thread.join()


def test_returned_arrays_belong_to_the_caller():
    body = mc.convex_hull(CUBE)
    vertices = body.vertices
    vertices[:] = 7.0
    assert body.vertices.max() == 1.0
    del body
    assert vertices.min() == 7.0
    assert vertices.flags.owndata or vertices.base is not None
