"""The script beside a deck, which writes curve.csv from a job's results, run with a stand-in for Abaqus' module."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

STAND_IN = Path(__file__).parent / "odb_stand_in"
COLUMNS = ["strain", "stress_mpa", "kinetic", "internal", "external", "friction_work", "hourglass"]


@pytest.fixture
def mesh(packing):
    """A coarse mesh of tetrahedra whose aggregates share no nodes."""
    return packing.mesh(method="lattice", element_size=4, itz="smeared", joined="mortar", volumes="exact", accept_phase_error=True)


def results(top, force=-45.0, way=-0.03):
    """A database of three times: the plate's force (N) and way (mm) grow with time, energies come at half the times."""
    pairs = lambda last: [[0.0, 0.0], [0.01, last / 2], [0.02, last]]  # noqa: E731
    energies = {"ALLKE": 2.0, "ALLIE": 40.0, "ALLWK": 43.0, "ALLFD": 1.0, "ALLAE": 0.5}
    return {
        "Step-1": {
            f"Node ASSEMBLY.{top - 1}": {"RF3_ANTIALIASING": pairs(-force), "U3_ANTIALIASING": pairs(0.0)},
            f"Node ASSEMBLY.{top}": {"RF3_ANTIALIASING": pairs(force), "U3_ANTIALIASING": pairs(way)},
            "Assembly ASSEMBLY": {name: [[0.0, 0.0], [0.02, last]] for name, last in energies.items()},
        }
    }


def run(folder, script, *arguments):
    """Run the script as `abaqus python` would."""
    environment = dict(os.environ, PYTHONPATH=str(STAND_IN))
    command = [sys.executable, str(script), *arguments]
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(("analysis", "sense"), [("compression", -1.0), ("tension", 1.0)])
def test_the_script_writes_the_columns_of_solve(tmp_path, mesh, analysis, sense):
    mesh.write(tmp_path / "test.inp", analysis=analysis)
    top = len(mesh.points) + 2
    (tmp_path / "job.odb").write_text(json.dumps(results(top, force=45.0 * sense, way=0.03 * sense)))
    done = run(tmp_path, tmp_path / "test_curve.py", "job.odb")
    assert done.returncode == 0, done.stderr
    with (tmp_path / "curve.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == COLUMNS
    assert len(rows) == 3
    height = mesh.points[:, 2].max() - mesh.points[:, 2].min()
    area = (mesh.points[:, 0].max() - mesh.points[:, 0].min()) * (mesh.points[:, 1].max() - mesh.points[:, 1].min())
    last = {name: float(value) for name, value in rows[-1].items()}
    assert last["strain"] == pytest.approx(0.03 / height, rel=1e-6)
    assert last["stress_mpa"] == pytest.approx(45.0 / area, rel=1e-6)
    assert [last[name] for name in COLUMNS[2:]] == [2.0, 40.0, 43.0, 1.0, 0.5]
    # Energies are taken at the force's times.
    assert float(rows[1]["internal"]) == pytest.approx(20.0)
    assert "kinetic over internal energy at the peak 5 %" in done.stdout


def test_results_of_another_deck_are_refused(tmp_path, mesh):
    mesh.write(tmp_path / "test.inp", analysis="compression")
    (tmp_path / "job.odb").write_text(json.dumps(results(7)))
    done = run(tmp_path, tmp_path / "test_curve.py", "job.odb", "out.csv")
    assert done.returncode != 0
    assert "is it of this deck" in done.stderr
    assert not (tmp_path / "out.csv").exists()


def test_only_decks_with_a_curve_have_a_script(tmp_path, mesh):
    mesh.write(tmp_path / "elastic.inp", analysis="elastic")
    mesh.write(tmp_path / "geometry.inp", geometry_only=True)
    with pytest.raises(ValueError, match="analysis is compression; geometry_only leaves it out"):
        mesh.write(tmp_path / "both.inp", analysis="compression", geometry_only=True)
    with pytest.raises(ValueError, match="only an .inp or a .k takes keywords of a deck"):
        mesh.write(tmp_path / "mesh.vtu", analysis="compression")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["elastic.inp", "geometry.inp"]


def test_an_analysis_of_joined_aggregates_is_refused(tmp_path, packing):
    joined = packing.mesh(method="lattice", element_size=4, itz="none")
    with pytest.raises(ValueError, match="an elastic skeleton that never breaks"):
        joined.write(tmp_path / "test.inp", analysis="compression")
    with pytest.warns(UserWarning, match="without an ITZ"):
        joined.write(tmp_path / "test.inp", analysis="compression", allow_joined=True)


def test_mass_scaling_grows_with_the_step(mesh):
    short, long = mesh.mass_scaling(1e-7), mesh.mass_scaling(5e-7)
    assert 1.0 <= short["factor"] < long["factor"]
    assert {phase["phase"] for phase in long["phases"]} == {"AGGREGATE", "ITZ", "MORTAR"}
    with pytest.raises(ValueError, match="time_step_s is"):
        mesh.mass_scaling(0.0)
