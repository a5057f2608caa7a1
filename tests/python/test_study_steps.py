"""Steps of a study and fits by keyword: the bytes, columns and refusals of the command."""

import concurrent.futures
import json
import math
import multiprocessing
import subprocess
from pathlib import Path

import pytest

import mesocrete as mc

REFUSALS = json.loads((Path(__file__).parents[1] / "refusals.json").read_text(encoding="utf-8"))
STEP_OF = {"mesh": "mesh", "deck": "mesh", "solve": "solve", "effective": "effective"}
TINY = {"specimen": {"kind": "cube", "side_mm": 20}, "fraction": 0.2, "grading": {"d_min_mm": 5, "d_max_mm": 8}}
COARSE = {"element_size_mm": 4, "accept_phase_error": True}
STEPS = {
    "mesh": {"output": ["m.inp", "m.vtu"], "analysis": "tension", **COARSE},
    "solve": {"frames": 1, "duration": 2e-3, "law": "elastic", **COARSE},
    "effective": {"what": "conductivity", "voxel_size_mm": 4, "no_fields": True},
}
OVER = {"seed": [1, 2], "solve.friction": [0.0, 0.3]}
# Files with times in them.
TIMED = {"result.json", "result.html", "effective.json", "effective.html"}


def toml() -> str:
    """Return the study as a file of the command."""
    lines = ["outputs = ['grains.csv']", "spec = 'small.toml'", "[over]"]
    lines += [f"{key} = {json.dumps(values)}" for key, values in OVER.items()]
    for name, options in STEPS.items():
        lines += [f"[{name}]", *(f"{key} = {json.dumps(value)}" for key, value in options.items())]
    return "\n".join(lines) + "\n"


def contents(out):
    """Read every file of a study, but for times, and for the records, which have the lengths of files with times."""
    skipped = TIMED | {"case.json"}
    files = [path for path in sorted(out.rglob("*")) if path.is_file() and path.name not in skipped]
    return {str(path.relative_to(out)): path.read_bytes() for path in files if not path.name.startswith(".")}


def grains(packing, folder):
    """Count what there is after all steps."""
    return {"grains": len(packing), "curves": len(list(folder.glob("curve.csv")))}


@pytest.fixture(scope="module")
def by_command(command, tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    spec = "fraction = 0.2\nspecimen = { kind = 'cube', side_mm = 20 }\ngrading = { d_min_mm = 5, d_max_mm = 8 }\n"
    (folder / "small.toml").write_text(spec)
    (folder / "STUDY.toml").write_text(toml())
    subprocess.run([command, "study", "STUDY.toml", "-q", "-o", "s"], cwd=folder, check=True, capture_output=True)
    return folder


def test_steps_by_keyword_give_the_files_and_the_table_of_the_command(by_command, tmp_path):
    out = tmp_path / "s"
    study = mc.study(TINY, OVER, **STEPS, outputs=["grains.csv"], out=out)
    assert not study.failures
    assert contents(out) == contents(by_command / "s")
    assert (study.table()["solve.peak_mpa"] > 0).all() and (study.table()["effective.conductivity.tensor.xx"] > 1).all()
    records = {record["case"]: record for record in study.results}
    for case, record in records.items():
        kept = json.loads((by_command / "s" / case / "case.json").read_text())
        assert {**record, "files": 0, "sha256": 0} == {**kept, "files": 0, "sha256": 0}


def test_a_study_file_is_the_same_study_on_a_pool_of_processes(by_command, tmp_path):
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as pool:
        study = mc.study(by_command / "STUDY.toml", out=tmp_path / "s", executor=pool)
    assert contents(study.out) == contents(by_command / "s")
    with pytest.raises(ValueError, match="is a study, which has its own steps and axes"):
        mc.study(by_command / "STUDY.toml", {"seed": [1]})
    (tmp_path / "W.toml").write_text("[solve]\nfriction = -1\n")
    with pytest.raises(ValueError, match=r"W.toml: line 2: \[solve\] friction is -1; it must be 0 to 10"):
        mc.study(tmp_path / "W.toml", out=tmp_path / "w")


def test_then_comes_after_the_steps_and_its_columns_stand_beside_theirs(tmp_path):
    study = mc.study(TINY, solve=STEPS["solve"], then=grains, model="none", out=tmp_path / "s")
    table = study.table()
    assert table["curves"] == [1] and table["grains"] == table["aggregates"] and table["solve.peak_mpa"] > 0
    # The packing that was tested, with its gaps.
    assert study.packing(0).fraction == table["fraction"] and len(study.packing(0)) == table["grains"]


def test_a_test_with_errors_fails_its_case_and_keeps_its_warnings(tmp_path):
    study = mc.study(TINY, solve={**COARSE, "duration_s": 1e-5}, out=tmp_path / "s")
    (record,) = study.results
    assert "kinetic energy" in record["error"] and any("not quasi-static" in text for text in record["warnings"])


def test_a_study_of_fast_tests_has_their_figures_and_mean_waves_over_time(tmp_path):
    test = {"kind": "hopkinson", "speed_m_per_s": 8.0, "pulse_s": 2e-5, "rise_s": 5e-6}
    fast = {"test": test, "frames": 1, **COARSE}
    study = mc.study(TINY, {"seed": [1, 2], "solve.rate_effect": [False, True]}, solve=fast, out=tmp_path / "s")
    assert not study.failures
    table = study.table()
    at_rest, rated = (table["solve.peak_mpa"][table["solve.rate_effect"] == is_rated] for is_rated in (False, True))
    assert (rated > 1.02 * at_rest).all()
    waves = mc.mean_curves(study, x="time_s", y="input_in_mpa")
    # Half of rho c v_0 comes along a bar from a striker of the same bar.
    assert len(waves) == 2 and max(waves.table()["mean"]) == pytest.approx(math.sqrt(2.1e5 * 7.85e-9) * 8e3 / 2, rel=0.02)


@pytest.mark.parametrize("row", [row for row in REFUSALS if row["verb"] in STEP_OF and "by" not in row], ids=lambda row: f"{row['verb']}-{'-'.join(row['options'])}")
def test_a_wrong_combination_is_refused_by_the_entry_of_a_study(row, tmp_path):
    section = STEP_OF[row["verb"]]
    output = {"deck": {"output": "m.inp"}, "mesh": {"output": "m.vtu"}}.get(row["verb"], {})
    with pytest.raises(ValueError) as caught:
        mc.study(TINY, **{section: {**row["options"], **output}}, out=tmp_path / "s")
    assert str(caught.value).startswith(f'{section}["{row["wrong"].removesuffix("_mm")}"] {row["said"]}')
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"over": {"solve.friction": [0.1]}}, r"solve.friction changes \[solve\], which is not there; add it"),
        ({"solve": {"frictoin": 0.1}}, r'solve\["frictoin"\] is not known; did you mean solve\["friction"\]\?'),
        ({"solve": {"element_size": "small"}}, r'solve\["element_size"\] cannot be read: a number or auto'),
        ({"solve": {"element_size": 2, "element_size_mm": 3}}, r'solve\["element_size"\] is given twice'),
        ({"mesh": {}}, r'mesh\["output"\] is missing; name the files of the mesh'),
        ({"solve": {"materials": {"mortar": {"youngs_modulus_mpa": -1}}}}, r"youngs_modulus_mpa is -1"),
        ({"outputs": ["curve.csv"], "solve": COARSE}, r'outputs has "curve.csv", which \[solve\] writes, too'),
    ],
)
def test_wrong_steps_are_refused_before_the_first_case(options, said, tmp_path):
    with pytest.raises(ValueError, match=said):
        mc.study(TINY, **options, out=tmp_path / "s")
    assert not list(tmp_path.iterdir())


def test_a_fit_by_keyword_is_the_fit_of_the_command(command, tmp_path):
    (tmp_path / "SPEC.toml").write_text(
        "seed = 3\nfraction = 0.2\nspecimen = { kind = 'cube', side_mm = 20 }\ngrading = { d_min_mm = 5, d_max_mm = 8 }\n"
    )
    rows = [(0, 0), (0.001, 20), (0.002, 30), (0.004, 10)]
    (tmp_path / "curve.csv").write_text("strain,stress_mpa\n" + "".join(f"{a},{b}\n" for a, b in rows))
    flags = ["--seeds", "1", "--steps", "0", "--element-size-mm", "5", "--accept-phase-error", "-q", "-o", "f"]
    subprocess.run([command, "fit", "curve.csv", "SPEC.toml", *flags], cwd=tmp_path, check=True, capture_output=True)
    options = {"seeds": 1, "steps": 0, "element_size": 5, "accept_phase_error": True}
    fit = mc.fit(rows, tmp_path / "SPEC.toml", **options, out=tmp_path / "g")
    assert isinstance(fit, mc.Fit)
    assert fit.report == json.loads((tmp_path / "f" / "fit.json").read_text())
    cases = [sorted(path.name for path in (tmp_path / name / "cases").iterdir() if path.is_dir()) for name in "fg"]
    assert cases[0] == cases[1] and len(cases[0]) == 5
    strength = fit.parameters["compressive_mpa"]["value"]
    assert fit.materials["mortar_strength"]["compressive_mpa"] == strength > 1
    assert mc.fit({"strain": [row[0] for row in rows], "stress_mpa": [row[1] for row in rows]}, tmp_path / "SPEC.toml",
                  **options, out=tmp_path / "g").report == fit.report  # fmt: skip
    for wrong, said in [
        ({"seeds": 0}, "seeds is 0; it must be a whole number from 1 to 10000"),
        ({"friction": -1.0}, "friction is -1; it must be 0 to 10"),
        ({"element_size": -1.0}, "element_size is -1; it must lie within"),
    ]:
        with pytest.raises(ValueError, match=said):
            mc.fit(rows, tmp_path / "SPEC.toml", **{**options, **wrong}, out=tmp_path / "h")
    with pytest.raises(ValueError, match="curve: it must rise from its first row to a peak"):
        mc.fit([(0, 0), (0.001, 0)], TINY, out=tmp_path / "h")
    assert not (tmp_path / "h").exists()
