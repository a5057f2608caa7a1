"""The `mesocrete` command that the wheel installs: the binary's code, and the module's bytes."""

import hashlib
import json
import subprocess
import sys

import pytest

import mesocrete as mc


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.fixture
def spec_file(small_spec, tmp_path):
    path = tmp_path / "spec.toml"
    path.write_text(mc.Spec(**small_spec).to_toml(), encoding="utf-8")
    return path


def test_version_is_the_modules(run):
    assert run("--version").stdout.strip() == f"mesocrete {mc.__version__}"


def test_python_dash_m_is_the_same_command(run):
    process = subprocess.run([sys.executable, "-m", "mesocrete", "--help"], capture_output=True, text=True, timeout=60)
    assert process.returncode == 0
    assert process.stdout == run("--help").stdout
    assert "Usage: mesocrete" in process.stdout


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_command_and_module_write_the_same_bytes_on_any_number_of_threads(run, spec_file, packing, tmp_path, threads):
    outputs = [arg for extension in ("json", "vtu", "stl", "csv") for arg in ("-o", f"cli.{extension}")]
    process = run("pack", spec_file, "--seed", 7, "--threads", threads, *outputs)
    assert process.returncode == 0, process.stderr
    for extension in ("json", "vtu", "stl", "csv"):
        packing.write(tmp_path / f"py.{extension}")
        assert digest(tmp_path / f"cli.{extension}") == digest(tmp_path / f"py.{extension}"), extension


def test_the_module_loads_what_the_command_saved(run, spec_file, packing, tmp_path):
    assert run("pack", spec_file, "--seed", 7, "-o", "model.json").returncode == 0
    assert mc.load(tmp_path / "model.json") == packing


def test_the_summary_is_the_report(run, spec_file, packing):
    process = run("pack", spec_file, "--seed", 7, "-o", "model.json", "--quiet", "--summary-json", "-")
    summary, report = json.loads(process.stdout), packing.report()
    assert {k: v for k, v in summary.items() if k != "seconds"} == report


def test_exit_codes_pass_through(run):
    assert run("pack", "nowhere.toml").returncode in (1, 2)
    assert run("pack", "--fraction", "45").returncode == 2
    assert run("no-such-command").returncode == 2
    assert "Traceback" not in run("pack", "--fraction", "45").stderr


def test_output_into_a_closed_pipe_is_quiet(command, tmp_path):
    process = subprocess.run(
        f"'{command}' pack --help | head -n 1", shell=True, capture_output=True, text=True, cwd=tmp_path, timeout=60
    )
    assert process.stdout
    assert process.stderr == ""


@pytest.mark.parametrize("name", ["spec ü.toml", "-spec.toml"])
def test_names_of_any_letters_reach_the_command(run, spec_file, tmp_path, name):
    spec_file.rename(tmp_path / name)
    process = run("pack", "-o", "model.csv", "--fraction", 0.1, "--", name)
    assert process.returncode == 0, process.stderr
