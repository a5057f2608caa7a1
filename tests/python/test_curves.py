"""Mean curves of studies: their statistics, and figures that have the same bytes each time."""

import json

import numpy as np
import pytest

import mesocrete as mc


def case(root, seed, fraction, factor, *, end=0.004, status="done"):
    """A case of a study with a curve of two straight lines."""
    folder = root / f"seed-{seed}_fraction-{fraction}"
    folder.mkdir(parents=True)
    record = {"case": folder.name, "status": status, "values": {"fraction": fraction, "seed": seed}}
    (folder / "case.json").write_text(json.dumps(record))
    strain = np.linspace(0, end, 41)
    stress = factor * np.minimum(strain / 0.002, 2 - strain / 0.002) * 30
    rows = "\n".join(f"{a},{b}" for a, b in zip(strain, stress, strict=True))
    (folder / "curve.csv").write_text(f"strain,stress_mpa\n{rows}\n")


@pytest.fixture
def folder(tmp_path):
    for seed, factor in [(1, 0.9), (2, 1.0), (10, 1.1)]:
        case(tmp_path, seed, 0.3, factor, end=0.004 if seed > 1 else 0.003)
        case(tmp_path, seed, 0.4, 2 * factor)
    case(tmp_path, 11, 0.3, 9.0, status="failed")
    return tmp_path


def test_a_mean_curve_ends_with_its_shortest_and_counts_no_failure(folder):
    curves = mc.mean_curves(folder)
    table = curves.table()
    assert curves.values == [{"fraction": 0.3}, {"fraction": 0.4}] and len(curves) == 2
    first = table["fraction"] == 0.3
    assert table["strain"][first][-1] == 0.003 and table["strain"][~first][-1] == 0.004
    peak = np.argmin(np.abs(table["strain"] - 0.002 + 9 * ~first))
    found = [float(table[name][peak]) for name in ("n", "mean", "std", "min", "max")]
    # The peak lies between two points of the curves.
    assert np.allclose(found, [3, 30, 3, 27, 33], atol=0.5)


def test_figures_and_tables_of_curves_have_the_same_bytes(folder, tmp_path):
    pytest.importorskip("matplotlib", reason="needs matplotlib")
    curves = mc.mean_curves(folder)
    for suffix in ("csv", "pdf", "svg", "png"):
        for name in ("a", "b"):
            curves.write(tmp_path / f"{name}.{suffix}")
        assert (tmp_path / f"a.{suffix}").read_bytes() == (tmp_path / f"b.{suffix}").read_bytes()
    assert "fraction 0.3 (n = 3)" in (tmp_path / "a.svg").read_text(encoding="utf-8")
    assert (tmp_path / "a.csv").read_text().splitlines()[0] == "fraction,strain,n,mean,std,min,max"
    axes = curves.plot(band="range")
    assert len(axes.lines) == len(axes.collections) == 2
    assert axes.get_xlabel() == "strain, ‰" and abs(axes.figure.get_size_inches()[0] * 25.4 - 85) < 1e-9
    with pytest.raises(ValueError, match="it must end in .csv, .pdf, .svg or .png"):
        curves.write(tmp_path / "a.doc")
    with pytest.raises(ValueError, match='band is "?.*it must be "std"'):
        curves.plot(band="all")


def test_curves_that_cannot_be_averaged_are_named(folder, tmp_path):
    with pytest.raises(ValueError, match="has no column 'force'; it has strain, stress_mpa"):
        mc.mean_curves(folder, y="force")
    with pytest.raises(ValueError, match="stress_mpa falls, so that curves have no mean over it"):
        mc.mean_curves(folder, x="stress_mpa", y="strain")
    with pytest.raises(FileNotFoundError, match="no finished case in .* has a curve.csv"):
        mc.mean_curves(tmp_path / "nothing")


def test_a_study_of_tests_has_mean_curves(tmp_path):
    """`response.write(folder)` in `then` leaves what `mesocrete study` with `[solve]` leaves."""

    def then(packing, folder):
        mesh = packing.mesh(for_test=True, element_size=5.0, accept_phase_error=True)
        mesh.solve(law="elastic", strain=0.0002).write(folder)

    spec = {"specimen": mc.Specimen.cube(30), "fraction": 0.1, "grading": mc.Grading.fuller(8, 10)}
    study = mc.study(spec, {"seed": [1, 2]}, then=then, out=tmp_path / "s", version=1)
    assert not study.failures
    curves = mc.mean_curves(study, points=11)
    assert repr(curves) == "Curves(1 means of 2 tests, stress_mpa over strain)" and curves.table()["n"].tolist() == [2] * 11
    assert (np.diff(curves.table()["mean"]) > 0).all()
