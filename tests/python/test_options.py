"""Options explain themselves: one source in Rust, from which schema, types, completions and manual come."""

import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import mesocrete as mc

ROOT = Path(__file__).resolve().parents[2]
if sys.version_info >= (3, 11):
    import tomllib


@pytest.fixture(scope="module")
def schema(command):
    """Return a validator of SPEC.toml."""
    jsonschema = pytest.importorskip("jsonschema")
    printed = subprocess.run([command, "schema"], capture_output=True, text=True, check=True).stdout
    found = json.loads(printed)
    jsonschema.Draft202012Validator.check_schema(found)
    return jsonschema.Draft202012Validator(found)


@pytest.mark.skipif(sys.version_info < (3, 11), reason="tomllib came with 3.11")
def test_every_recipe_fits_the_schema(schema):
    recipes = sorted((ROOT / "crates" / "meso-pack" / "src" / "recipes").glob("*.toml"))
    assert {path.stem for path in recipes} == set(mc.recipes())
    for path in recipes:
        spec = tomllib.loads(path.read_text(encoding="utf-8"))
        assert [error.message for error in schema.iter_errors(spec)] == [], path.name
        assert not list(schema.iter_errors(mc.Spec.recipe(path.stem).to_dict())), path.name


@pytest.mark.parametrize(
    "spec",
    [
        {"fractoin": 0.3},
        {"fraction": "half"},
        {"specimen": {"kind": "cub", "side_mm": 3}},
        {"specimen": {"kind": "cube", "side": 3}},
        {"grading": {"curve": {"kind": "fuller", "n": 0.5}}},
        {"placement": {"strategy": "fast"}},
        {"mix": {"cement": 300}},
    ],
)
def test_the_schema_refuses_specs_that_pack_refuses_by_their_form(schema, spec):
    assert list(schema.iter_errors(spec))
    with pytest.raises((ValueError, TypeError)):
        mc.Spec(**spec)


def test_every_option_of_the_schema_is_described(schema):
    def nameless(tree, path):
        for key, prop in tree.get("properties", {}).items():
            if "description" not in prop and "const" not in prop:
                yield f"{path}.{key}"
        for key, definition in tree.get("$defs", {}).items():
            yield from nameless(definition, key)

    assert list(nameless(schema.schema, "spec")) == []


def script(name):
    """Import a script that writes a part of the package."""
    found = importlib.util.spec_from_file_location(name, ROOT / "crates" / "meso-py" / f"{name}.py")
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


def test_the_stub_has_the_docstrings_of_the_compiled_module():
    module = script("make_stub_docs")
    stub = module.STUB.read_text(encoding="utf-8")
    assert module.documented(stub) == stub, "run crates/meso-py/make_stub_docs.py"
    assert stub.count('"""') > 100


@pytest.mark.parametrize(
    ("wrong", "python"),
    [({"friction": -1.0}, True), ({"span_mm": -3.0}, True), ({"rows": 9}, True), ({"expansion": {"mortar": 0.03}}, True), ({"instruction_set": "avx2"}, False)],
)
def test_the_schema_of_a_test_has_its_ranges(command, wrong, python):
    """The case: a friction of -1 fitted the schema of a TEST.toml."""
    jsonschema = pytest.importorskip("jsonschema")
    printed = subprocess.run([command, "schema", "solve"], capture_output=True, text=True, check=True).stdout
    fits = jsonschema.Draft202012Validator(json.loads(printed))
    assert not list(fits.iter_errors({"kind": "bending", "friction": 0.1, "span_mm": None}))
    assert list(fits.iter_errors(wrong))
    if python:
        with pytest.raises(ValueError, match="it must be"):
            mc.Test.bending(**wrong)


def test_the_types_are_those_of_the_schemas(command):
    module = script("make_types")
    assert module.types(command) == module.TARGET.read_text(encoding="utf-8"), "run crates/meso-py/make_types.py"


def test_recipes_are_specs():
    assert "rve-60" in mc.recipes()
    assert mc.Spec.recipe("rve-60").specimen == {"kind": "cube", "side_mm": 60.0, "periodic": ["x", "y", "z"]}
    assert mc.Spec.recipe("paper") == mc.Spec()
    with pytest.raises(ValueError, match=r'there is no recipe "rve-61"; the recipes are paper, '):
        mc.Spec.recipe("rve-61")
    with pytest.raises(FileNotFoundError, match=r'rve-60 is a recipe and no file: Spec.recipe\("rve-60"\)'):
        mc.pack("rve-60")


def test_gradings_and_specimens_have_their_names():
    spec = mc.Spec(grading=mc.Grading.fuller(4, 16, size="sieve"), specimen=mc.Specimen.cylinder(100, 200))
    assert spec.grading["curve"] == {"kind": "fuller", "exponent": 0.5}
    assert (spec.grading["d_max_mm"], spec.grading["size"]) == (16.0, "sieve")
    assert spec.specimen == {"kind": "cylinder", "diameter_mm": 100.0, "height_mm": 200.0}
    for specimen in (
        mc.Specimen.cube(50, periodic=True),
        mc.Specimen.box(50, 60, 70, periodic="x"),
        mc.Specimen.prism(160, 40, 40),
        mc.Specimen.sphere(50),
        mc.Specimen.notched_prism(400, 100, 100, notch_width_mm=4, notch_depth_mm=20),
        mc.Specimen.dogbone(300, 100, 50, neck_width_mm=60, neck_length_mm=40, radius_mm=100),
        mc.Specimen.polyhedron([[0, 0, 0], [60, 0, 0], [0, 60, 0], [0, 0, 60]]),
    ):
        assert mc.Spec(specimen=specimen).specimen["kind"] == specimen["kind"]
    for grading in (mc.Grading.bolomey(5, 20), mc.Grading.standard("din-1045-2-a16", 2, 16)):
        assert mc.Spec(grading=grading).grading["curve"]["kind"] == grading["curve"]["kind"]


def test_an_stl_file_is_a_specimen_by_its_path(tmp_path):
    corners = [[0, 0, 0], [40, 0, 0], [0, 40, 0], [0, 0, 40]]
    triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join("vertex {} {} {}\n".format(*corners[i]) for i in triangle) + "endloop\nendfacet\n"
        for triangle in triangles
    )
    path = tmp_path / "corner.stl"
    path.write_text(f"solid corner\n{facets}endsolid\n")
    named = mc.pack({"specimen": mc.Specimen.stl(path), "fraction": 0.1, "grading": mc.Grading.fuller(3, 6)}, seed=1)
    same = mc.pack({"specimen": mc.Specimen.mesh(corners, triangles), "fraction": 0.1, "grading": mc.Grading.fuller(3, 6)}, seed=1)
    assert np.array_equal(named.aggregates.centroid, same.aggregates.centroid)


def test_arrays_are_sieve_tables():
    table = np.array([[2.0, 0.2], [8.0, 0.6], [16.0, 1.0]])
    grading = mc.Grading.sieves(table[:, 0], table[:, 1], 4, 16)
    assert mc.Spec(grading=grading).grading["curve"]["sieves_mm"] == [2.0, 8.0, 16.0]
    whole = mc.Grading.sieves([2, 8, 16], [0, 0.6, 1])
    assert (whole["d_min_mm"], whole["d_max_mm"]) == (2.0, 16.0)
    assert mc.Grading.sieves(table, d_min_mm=4) == mc.Grading.sieves(table[:, 0], table[:, 1], 4)
    with pytest.raises(ValueError, match=r"passing is missing, and sieve_mm has shape \(3,\); give two rows"):
        mc.Grading.sieves([2, 8, 16])
    with pytest.raises(ValueError, match="sieve_mm is empty"):
        mc.Grading.sieves([], [])
    with pytest.raises(ValueError, match=r"sieve_mm has shape \(3, 2\); it must be one row of numbers"):
        mc.Grading.sieves(table, table[:, 1], 4, 16)


def test_a_mortar_is_known_by_its_name_and_strengths_name_the_unit_that_fits():
    """The case: `for_mortar("M40")` was a TypeError, and a mortar of 38e6 was called an fcm of 4.1e7."""
    assert mc.Materials.for_mortar("M40") == mc.Materials.for_mortar(40) == mc.Materials.for_concrete("M40")
    for name, given, said in [
        ("for_mortar", 38e6, r"mortar is 38000000; it must be .* MPa: 3.8e7 Pa are 38 MPa"),
        ("for_mortar", "M400", r'mortar "M400" is 400; it must be '),
        ("for_mortar", "C30", r'mortar "C30" is no mortar, as "M40"'),
        ("for_mortar", "40", "mortar .* is no mortar"),
        ("for_concrete", 38e6, "fcm is 38000000; it must be 20 to 128 MPa: 3.8e7 Pa are 38 MPa"),
    ]:
        with pytest.raises(ValueError, match=said):
            getattr(mc.Materials, name)(given)
    with pytest.raises(ValueError, match="pressure_mpa is 10000000; it must be -100 to 1000 MPa: 1e7 Pa are 10 MPa"):
        mc.Test.triaxial(1e7)


def test_per_cent_pans_and_tables_with_headings_are_sieve_tables():
    """The cases: 'Pan' could not be converted to a float, and 100 was refused as a share only when packing."""

    class Frame(dict):
        columns = property(list)

    sizes, shares = [16, 8, 4, "Pan"], [1.0, 0.6, 0.2, 0.0]
    wanted = mc.Grading.sieves([16, 8, 4], [1.0, 0.6, 0.2])
    percent = mc.Grading.sieves([16, 8, 4], passing_percent=[100, 60, 20])
    assert mc.Grading.sieves(sizes, shares) == wanted
    assert mc.Grading.sieves(np.array([sizes, shares], object).T) == wanted
    assert mc.Grading.sieves(Frame({"Sieve": sizes, "Passing": shares})) == wanted
    for heading in ("Passing (%)", "percent finer", "Passing, per cent"):
        assert mc.Grading.sieves(Frame({"mm": sizes, heading: [100, 60, 20, 0]})) == percent
    assert mc.Grading.sieves([16, 8, "tray"], [1.0, 0.6, 0.0]) == mc.Grading.sieves([16, 8], [1.0, 0.6])
    pandas = pytest.importorskip("pandas")
    assert mc.Grading.sieves(pandas.DataFrame({"mm": sizes, "Passing (%)": [100, 60, 20, 0]})) == percent
    # A sheet of a laboratory as a frame is read as its file is.
    for library in (pandas, pytest.importorskip("polars")):
        sheet = library.DataFrame({"Sieve (mm)": ["16", "8", "4", "Pan"], "Retained (g)": [0.0, 400.0, 400.0, 200.0]})
        of_sheet = mc.Grading.table(sheet, 4, 16, form="raw")
        assert of_sheet["curve"] == wanted["curve"] and (of_sheet["size"], of_sheet["form"]) == ("sieve", "raw")
        with pytest.raises(ValueError, match="fits no reading|no number"):
            mc.Grading.table(library.DataFrame({"Sieve (mm)": [16.0, 8.0, 4.0], "Passing (%)": [100.0, None, 20.0]}), 4, 16)
    # Shares that were retained, taken as passing, gave another grading without a word.
    for heading in ["Retained (%)", "Mass retained (g)", "Weight", "Rückstand in %"]:
        with pytest.raises(ValueError, match=r"and no passing; read the table by Grading.table\(table,"):
            mc.Grading.sieves(pandas.DataFrame({"mm": sizes, heading: [0, 40, 40, 20]}))
    with pytest.raises(ValueError, match=r"passing goes up to 100: per cent\? Write Grading.sieves\(sieves, passing_percent="):
        mc.Grading.sieves([16, 8, 4], [100, 60, 20])
    with pytest.raises(ValueError, match=r"sieve_mm has 'Soil' in row 2, which is no number; .*; Grading.table\(file\) reads the sheet"):
        mc.Grading.sieves([16, "Soil"], [1, 0.5])
    # Missing values became NaN in the spec, and those of pandas a TypeError.
    for missing in [None, float("nan"), pandas.NA, float("inf"), "NA", "", "-"]:
        frame = pandas.DataFrame({"mm": [16.0, 8.0, 4.0, 2.0, "Pan"], "%": [100.0, 60.0, missing, 20.0, 0.0]}, dtype=object)
        with pytest.raises(ValueError, match="column '%' has .* in row 3, which is no number; fill it"):
            mc.Grading.sieves(frame)
        with pytest.raises(ValueError, match="the table, with its headings as line 1: .*line 4: "):
            mc.Grading.table(frame, 4, 16)
        with pytest.raises(ValueError, match="column 'mm' has .* in row 1, which is no number"):
            mc.Grading.sieves(pandas.DataFrame({"mm": [missing, 8.0], "%": [100.0, 60.0]}, dtype=object))
        with pytest.raises(ValueError, match="passing has .* in row 2"):
            mc.Grading.sieves([2, 4, 8], [0.2, missing, 1])
    with pytest.raises(ValueError, match="the table has 3 columns; give two"):
        mc.Grading.sieves(Frame({"mm": sizes, "a": shares, "b": shares}))


def test_a_class_of_concrete_is_a_mean_strength():
    """The case: fcm is "C30"; it must be a number."""
    for name in ("C30", "c30/37", " C30/37 "):
        assert mc.Materials.for_concrete(name, rock="basalt") == mc.Materials.for_concrete(38, rock="basalt")
    assert mc.Materials.for_concrete("M40") == mc.Materials.for_mortar(40)
    for name in ("30", "C", "C30/", "X40", ""):
        with pytest.raises(ValueError, match="no class of concrete, as C30 or C30/37, .* a number is the mean strength in MPa, 38"):
            mc.Materials.for_concrete(name)


def test_threads_change_nothing_and_a_time_limit_ends_a_packing():
    spec = {"specimen": mc.Specimen.cube(40), "fraction": 0.3, "grading": {"d_max_mm": 12.0}}
    assert mc.pack(spec, threads=1) == mc.pack(spec, threads=2)
    hopeless = {"specimen": mc.Specimen.cube(60), "fraction": 0.7}
    with pytest.warns(UserWarning):
        packing = mc.pack(hopeless, time_limit=0.2)
    assert packing.report()["stop_reason"] in ("time-limit", "jammed")
    for wrong, message in (({"threads": 0}, "threads is 0"), ({"time_limit": -1.0}, "^time_limit is -1")):
        with pytest.raises(ValueError, match=message):
            mc.pack(spec, **wrong)
    with pytest.raises(TypeError, match="time_limit is of type str; it must be a number of seconds"):
        mc.pack(spec, time_limit="1 s")


def test_reading_a_surface_is_a_stage_and_a_time_limit_ends_it(packing, tmp_path):
    """Of a file and of a dict; a fraction that is given or read is the whole from the first call on."""
    packing.write(tmp_path / "grains.stl")
    sizes = mc.Grading.fuller(2, 3)
    spec = {"specimen": mc.Specimen.stl(tmp_path / "grains.stl"), "fraction": 0.02, "grading": sizes}
    (tmp_path / "spec.toml").write_text(
        "fraction = 0.02\nspecimen = { kind = 'mesh', file = 'grains.stl' }\n[grading]\nd_min_mm = 2\nd_max_mm = 3\n"
    )
    silent = mc.pack(spec, fraction=0.01)
    for given in (spec, tmp_path / "spec.toml"):
        seen = []
        inside = mc.pack(given, fraction=0.01, progress=lambda *told, stage: seen.append((*told, stage)))
        assert inside == silent
        assert {total for _, total, _ in seen} == {0.01}
        assert [done for done, *_ in seen] == sorted(done for done, *_ in seen)
        stages = list(dict.fromkeys(stage for *_, stage in seen))
        assert stages[0] == "read" and stages == [stage for stage in ("read", "take", "place", "prove") if stage in stages]
        with pytest.raises(TimeoutError, match="time_limit is 0.001, which was over before the specimen's surface was proved"):
            mc.pack(given, time_limit=0.001)
    inside.write(tmp_path / "inside.json")
    seen = []
    assert mc.load(tmp_path / "inside.json", progress=lambda *told, stage: seen.append((*told, stage))) == inside
    assert seen[-1] == (1.0, 1.0, "read") and [done for done, *_ in seen] == sorted(done for done, *_ in seen)
    # Without a surface there is no such stage.
    stages = []
    mc.pack({"specimen": mc.Specimen.cube(40)}, progress=lambda *_, stage: stages.append(stage))
    assert "read" not in stages


def test_bodies_of_the_package_collide():
    spec = {"specimen": mc.Specimen.cube(40), "fraction": 0.2, "grading": {"d_max_mm": 12.0}}
    packing = mc.pack(spec)
    a, b = packing.aggregates[:2]
    assert not mc.gjk.intersects(a, b)
    assert mc.gjk.intersects(a, a.body)
    assert mc.gjk.distance(a, b) == mc.gjk.distance(a.vertices, b.vertices) > 0.0
    assert mc.gjk.intersects_many(a, list(packing.aggregates)).sum() == 1


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "powershell", "elvish"])
def test_shells_know_every_command_and_flag(run, shell):
    script = run("completions", shell)
    assert script.returncode == 0
    # clap completes values in three of the shells.
    values = ["take-and-place"] if shell in ("bash", "zsh", "fish") else []
    for word in ("pack", "study", "element-size-mm", "retry-failed", *values):
        assert word in script.stdout, word


def test_the_manual_has_a_page_for_every_command(run, tmp_path):
    told = run("man", ".")
    assert told.returncode == 0 and "pages to ." in told.stderr
    commands = re.findall(r"^  ([a-z]+)  ", run("--help").stdout, re.MULTILINE)
    names = {path.name for path in tmp_path.glob("*.1")}
    assert names == {"mesocrete.1", *(f"mesocrete-{name}.1" for name in commands if name != "help")}
    assert "element\\-size\\-mm" in (tmp_path / "mesocrete-mesh.1").read_text(encoding="utf-8")
