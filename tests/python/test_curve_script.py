"""The script beside a deck, which writes curve.csv from a job's results, run with stand-ins for the modules that read these."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

STAND_INS = [str(Path(__file__).parent / name) for name in ("odb_stand_in", "binout_stand_in")]
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
    """Run the script beside stand-ins of the modules that read results."""
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(STAND_INS))
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


def nodes_of(deck, number):
    """The nodes of a set of a `.k`, sorted."""
    sets = [lines.splitlines() for lines in deck.read_text().split("*") if lines.startswith("SET_NODE_LIST_TITLE")]
    lines = next(lines for lines in sets if int(lines[2][:10]) == number)
    return sorted(int(node) for line in lines[3:] for node in line.split())


@pytest.mark.parametrize(("analysis", "strain"), [("compression", 0.005), ("tension", 0.0005)])
def test_the_script_of_a_k_sums_the_forces_of_the_lower_support(tmp_path, mesh, analysis, strain):
    # The script opens its deck, and shares no name with that of an .inp.
    mesh.write(tmp_path / "test.inp", analysis=analysis)
    deck = tmp_path / 'tést "1".k'
    mesh.write(deck, analysis=analysis)
    deck.with_name('tést "1"_binout.py').rename(tmp_path / "test_binout.py")
    duration = float((tmp_path / "test_binout.py").read_text().split("DURATION_S = ")[1].split()[0])
    times = [0.0, duration / 2, duration]
    energies = {"kinetic_energy": 2, "internal_energy": 40, "external_work": 43, "sliding_interface_energy": 1, "hourglass_energy": 0.5}
    rows = {name: [0, last / 2, last] for name, last in energies.items()}
    if analysis == "compression":
        # Both sides of both contacts.
        forces = {"ids": [1, 1, 2, 2], "side": [0, 1, 0, 1], "time": times}
        forces["z_force"] = [[45 * k, -45 * k, -50 * k, 50 * k] for k in (0, 1, 2)]
        histories = {"rcforc": forces}
    else:
        nodes = nodes_of(deck, 11)
        forces = [[45 * k / len(nodes)] * len(nodes) + [1e6] for k in (0, 1, 2)]
        histories = {"bndout": {"velocity": {"nodes": {"ids": [*nodes, 10**7], "time": times, "z_force": forces}}}}
    (tmp_path / "binout0000").write_text(json.dumps({"glstat": {"time": times, **rows}, **histories}))
    done = run(tmp_path, tmp_path / "test_binout.py", "binout0000")
    assert done.returncode == 0, done.stderr
    with (tmp_path / "curve.csv").open() as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    assert list(rows[0]) == COLUMNS
    area = (mesh.points[:, 0].max() - mesh.points[:, 0].min()) * (mesh.points[:, 1].max() - mesh.points[:, 1].min())
    assert [row["strain"] for row in rows] == pytest.approx([0, strain / 2, strain])
    assert [row["stress_mpa"] for row in rows] == pytest.approx([0, 45 / area, 90 / area])
    assert [rows[-1][name] for name in COLUMNS[2:]] == [2, 40, 43, 1, 0.5]
    histories.get("rcforc", histories.get("bndout", {}).get("velocity", {}).get("nodes"))["ids"] = [7, 7, 8, 8]
    (tmp_path / "other").write_text(json.dumps({"glstat": {}, **histories}))
    assert "is it of this deck" in run(tmp_path, tmp_path / "test_binout.py", "other").stderr


def test_only_decks_with_a_curve_have_a_script(tmp_path, mesh):
    mesh.write(tmp_path / "elastic.inp", analysis="elastic")
    mesh.write(tmp_path / "geometry.inp", geometry_only=True)
    with pytest.raises(ValueError, match="analysis is compression; geometry_only leaves it out"):
        mesh.write(tmp_path / "both.inp", analysis="compression", geometry_only=True)
    with pytest.raises(ValueError, match="only an .inp or a .k takes keywords of a deck"):
        mesh.write(tmp_path / "mesh.vtu", analysis="compression")
    mesh.write(tmp_path / "striker.k", analysis="striker")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["elastic.inp", "geometry.inp", "striker.k"]


def test_a_script_goes_with_its_deck_and_no_script_of_a_user_does(mesh, tmp_path):
    """The case: a deck without a test had the script of the one before it; a user's own was replaced without a word."""
    mesh.write(tmp_path / "a.inp", analysis="tension", allow_joined=True)
    assert (tmp_path / "a_curve.py").exists()
    mesh.write(tmp_path / "a.inp")
    assert [file.name for file in tmp_path.iterdir()] == ["a.inp"]
    (tmp_path / "a_curve.py").write_text("mine")
    mesh.write(tmp_path / "a.inp")
    with pytest.raises(FileExistsError, match="a_curve.py is no script of mesocrete"):
        mesh.write(tmp_path / "a.inp", analysis="tension", allow_joined=True)
    assert (tmp_path / "a_curve.py").read_text() == "mine"


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
