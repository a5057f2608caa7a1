"""Types of what the package returns: every dict has the keys that its type has, and no public signature says `Any`."""

import ast
import importlib.util
import typing
from pathlib import Path

import pytest

import mesocrete as mc
from mesocrete import _results

CRATE = Path(__file__).parents[2] / "crates" / "meso-py"
PACKAGE = CRATE / "python" / "mesocrete"


@pytest.fixture(scope="module")
def mixed():
    spec = {
        "specimen": {"kind": "cube", "side_mm": 40.0},
        "fraction": 0.2,
        "voids": {"fraction": 0.01, "diameter_mm": [2.0, 3.0]},
        "fibres": {"fraction": 0.003, "length_mm": 15.0, "diameter_mm": 0.8},
    }
    return mc.pack(spec, seed=1)


def agrees(value, kind, where):
    """The value is of the type, all keys and elements included."""
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if typing.is_typeddict(kind):
        hints = typing.get_type_hints(kind, localns={"NotRequired": typing.NotRequired}, include_extras=True)
        needed = {key for key, hint in hints.items() if typing.get_origin(hint) is not typing.NotRequired}
        assert needed <= set(value) <= set(hints), f"{where}: {set(value) ^ set(hints)}"
        for key, item in value.items():
            hint = hints[key]
            agrees(item, typing.get_args(hint)[0] if typing.get_origin(hint) is typing.NotRequired else hint, f"{where}.{key}")
    elif origin in (list, dict):
        assert isinstance(value, origin), f"{where} is {type(value)}"
        items = value if origin is list else value.values()
        for item in items:
            agrees(item, inner[-1], f"{where}[]")
    elif inner and type(None) in inner:
        assert value is None or agrees(value, inner[0], where) is None
    elif kind is float:
        assert isinstance(value, float | int), f"{where} is {type(value)}"
    elif isinstance(kind, type) and kind is not object:
        assert isinstance(value, kind), f"{where} is {type(value)}"


def test_results_of_a_packing_are_as_their_types_say(mixed, packing):
    for found in (mixed, packing):
        agrees(found.report(), _results.Report, "report")
        agrees(found.work, _results.WorkDone, "work")
        agrees(found.check(), _results.CheckResult, "check")
        agrees(found.statistics(), _results.Statistics, "statistics")
        assert set(found.table()) == set(_results.Table.__annotations__)


def test_results_of_a_mesh_and_a_test_are_as_their_types_say(mixed):
    for itz in ("none", "cohesive"):
        mesh = mixed.mesh(element_size=4.0, itz=itz, accept_phase_error=True)
        agrees(mesh.quality(), _results.QualityReport, "quality")
        agrees(mesh.mass_scaling(), _results.MassScaling, "mass_scaling")
    small = mc.pack({"specimen": {"kind": "cube", "side_mm": 20.0}, "fraction": 0.1}, seed=1)
    response = small.mesh(element_size=4.0, itz="none", accept_phase_error=True).solve(strain=0.0005)
    agrees(response.result, _results.TestResult, "result")


def test_images_have_the_types_that_their_overloads_say(packing):
    kinds = {"phase": "uint8", "grain": "int32", "share": "float32", "distance": "float32"}
    for what, kind in kinds.items():
        assert packing.voxelize(5.0, what).dtype == kind
        assert packing.section("z", 30.0, 16, what).dtype == kind


def test_the_types_are_those_of_the_sources():
    path = CRATE / "make_results.py"
    module = importlib.util.module_from_spec(spec := importlib.util.spec_from_file_location("make_results", path))
    spec.loader.exec_module(module)
    assert module.results() == module.TARGET.read_text(encoding="utf-8"), "run crates/meso-py/make_results.py"


def public_signatures(tree):
    """Every function of public name, those of private classes left out."""
    for node in tree.body:
        owner = getattr(node, "name", "")
        if owner.startswith("_"):
            continue
        for item in [node, *getattr(node, "body", [])]:
            if isinstance(item, ast.FunctionDef) and (not item.name.startswith("_") or item.name.endswith("__")):
                yield f"{owner}.{item.name}", item


@pytest.mark.parametrize("name", ["_mesocrete.pyi", "_options.py", "_study.py", "gjk.py", "__init__.py"])
def test_no_public_signature_says_any(name):
    tree = ast.parse((PACKAGE / name).read_text(encoding="utf-8"))
    for where, node in public_signatures(tree):
        arguments = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs, node.args.vararg, node.args.kwarg]
        hints = [node.returns, *(argument.annotation for argument in arguments if argument is not None)]
        text = " ".join(ast.unparse(hint) for hint in hints if hint is not None)
        assert "Any" not in text.replace("[", " ").replace("]", " ").replace(",", " ").split(), f"{where}: {text}"
