"""Whatever is thrown at the public functions, only documented exceptions come back."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import mesocrete as mc
from mesocrete import gjk

DOCUMENTED = (ValueError, TypeError, OSError, ArithmeticError)

SCALARS = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8), st.binary(max_size=8), st.complex_numbers()
)
ANYTHING = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(SCALARS, inner, max_size=3), max_leaves=12
)
POINTS = st.lists(st.tuples(*[st.floats(width=64)] * 3), max_size=8)
SECTIONS = ("specimen", "grading", "shape", "itz", "placement")
NUMBERS = st.sampled_from(
    [0, -0.0, 1, -1, 5e-324, 1e308, 1e-308, 2**63, 2**64 - 1, -(2**63), float("nan"), float("inf"), 0.5, 45, "1,5", "", None, True]
)


def only_documented(call):
    try:
        call()
    except DOCUMENTED:
        pass


@given(ANYTHING)
@settings(max_examples=300, deadline=None)
def test_convex_hull_of_anything(anything):
    only_documented(lambda: mc.convex_hull(anything))


@given(ANYTHING, ANYTHING, st.text(max_size=10) | st.sampled_from(["enhanced", "classical"]))
@settings(max_examples=300, deadline=None)
def test_gjk_of_anything(a, b, method):
    only_documented(lambda: gjk.intersects(a, b, method=method))
    only_documented(lambda: gjk.distance(a, b))
    only_documented(lambda: gjk.intersects_many(a, b, method=method))


@given(POINTS, POINTS)
@settings(max_examples=500, deadline=None)
def test_gjk_and_hull_of_any_floats(a, b):
    only_documented(lambda: gjk.intersects(a, b))
    only_documented(lambda: gjk.distance(a, b))
    only_documented(lambda: mc.convex_hull(a + b).volume)
    only_documented(lambda: mc.convex_hull(a + b).offset(0.1))


@given(ANYTHING)
@settings(max_examples=200, deadline=None)
def test_a_spec_of_anything(anything):
    only_documented(lambda: mc.Spec(**anything))
    if not isinstance(anything, (str, bytes)) and anything not in (None, {}):
        only_documented(lambda: mc.pack(anything, fraction=2.0))


def leaves(options, path=()):
    for key, value in options.items():
        if isinstance(value, dict):
            yield from leaves(value, (*path, key))
        else:
            yield (*path, key)


LEAVES = sorted(leaves(mc.Spec().to_dict()))


@pytest.mark.parametrize("path", LEAVES, ids=".".join)
@given(number=NUMBERS | st.lists(NUMBERS, max_size=4))
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_every_key_of_a_spec_takes_or_names_any_value(path, number):
    options = mc.Spec().to_dict()
    section = options
    for key in path[:-1]:
        section = section[key]
    section[path[-1]] = number
    try:
        mc.Spec(**options)
    except (ValueError, TypeError) as error:
        # A tagged section may be refused as a whole; its name is still there.
        assert path[0] in str(error)


@given(st.binary(max_size=200))
@settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_loading_anything(tmp_path, content):
    path = tmp_path / "model.json"
    path.write_bytes(content)
    only_documented(lambda: mc.load(path))
    only_documented(lambda: mc.Spec.read(path))


def test_except_exception_catches_a_panic():
    # The only exceptions that pass `except Exception` are the interpreter's own.
    assert issubclass(RuntimeError, Exception)
    restore, (vertices, *_) = mc.convex_hull(np.eye(4)[:, :3]).__reduce__()
    # A surface that is not closed is no body; whatever its integrals are, asking for them must not end the process.
    for dents in (None, 0, 63):
        open_body = restore(vertices, [[0, 1, 2]], dents)
        only_documented(lambda body=open_body: body.offset(0.1))
        only_documented(lambda body=open_body: body.volume)


def test_a_target_beyond_reach_is_a_warning_at_the_callers_line():
    spec = {"specimen": {"kind": "cube", "side_mm": 20}, "grading": {"d_min_mm": 5, "d_max_mm": 10}}
    with pytest.warns(UserWarning, match="0.72 is more than this strategy reached in tests") as caught:
        mc.pack(spec, fraction=0.72)
    assert caught[0].filename == __file__


def test_a_gap_without_room_is_named():
    spec = {"fraction": 0.4, "specimen": {"kind": "cube", "side_mm": 61}, "placement": {"wall_gap_mm": 20}}
    with pytest.raises(ValueError, match="placement.wall_gap_mm is 20, which leaves no room for a fraction of 0.4"):
        mc.pack(spec)
    # What the spec leaves open counts only in the end.
    spec.pop("fraction")
    assert mc.pack(spec, fraction=0.02).fraction < 0.03


def test_a_spec_takes_a_dict_and_a_slip_of_the_keys_is_named():
    assert mc.Spec({"fraction": 0.3, "seed": 5}) == mc.Spec(fraction=0.3, seed=5) and mc.Spec({}) == mc.Spec()
    with pytest.raises(TypeError, match="Spec takes a dict or keywords; give one of the two"):
        mc.Spec({"seed": 5}, fraction=0.3)  # type: ignore[call-overload]
    with pytest.raises(TypeError, match=r"pack\(\) has no argument fracton; did you mean fraction\?"):
        mc.pack(fracton=0.3)  # type: ignore[call-arg]


def test_sections_that_are_given_to_pack_get_the_way_out():
    with pytest.raises(TypeError, match=r"pack\(\) has no argument specimen; what to pack is one argument, as mc\.pack\(mc\.Spec\("):
        mc.pack(specimen=mc.Specimen.cube(50))
    with pytest.raises(ValueError, match=r"kind is not a known key here; it belongs under \[shape\] or \[specimen\]"):
        mc.pack(mc.Specimen.cube(50))
