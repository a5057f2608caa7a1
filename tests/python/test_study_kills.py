"""Studies that are killed at random moments, and resumed with other flags: the same bytes, or a refusal."""

import json
import os
import random
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="kills by signal")

SPEC = """[spec]
fraction = 0.2
specimen = { kind = 'cube', side_mm = 20 }
grading = { d_min_mm = 5, d_max_mm = 8 }
"""
# Every one goes into the same folder; the first one is followed to its end.
STUDIES = {
    "a.toml": "outputs = ['grains.csv']\n" + SPEC + "[mesh]\noutput = 'deck.inp'\nelement-size-mm = 2\nitz = 'none'\naccept-phase-error = true\n[over]\nseed = { from = 1, to = 6 }\n",
    "longer.toml": "outputs = ['grains.csv']\n" + SPEC + "[mesh]\noutput = 'deck.inp'\nelement-size-mm = 2\nitz = 'none'\naccept-phase-error = true\n[over]\nseed = { from = 1, to = 8 }\n",
    "finer.toml": "outputs = ['grains.csv']\n" + SPEC + "[mesh]\noutput = 'deck.inp'\nelement-size-mm = 1.5\nitz = 'none'\naccept-phase-error = true\n[over]\nseed = { from = 1, to = 6 }\n",
    "test.toml": SPEC + "[solve]\nelement-size-mm = 4\nframes = 1\nstrain = 0.0002\n[over]\nseed = { from = 1, to = 3 }\n",
}
FLAGS = [[], ["--jobs", "2"], ["--threads", "1"], ["--jobs", "3", "--threads", "2"], ["--retry-failed"], ["--force"]]
# These hold seconds.
TIMED = {"result.json", "result.html", "mesh.json"}


def contents(out: Path) -> dict[str, object]:
    """Read the cases of a study that have a record: the bytes of their files, and the records without lengths."""
    found: dict[str, object] = {}
    for record in out.glob("*/case.json"):
        told = json.loads(record.read_text(encoding="utf-8"))
        found[f"{record.parent.name}/case.json"] = {k: v for k, v in told.items() if k not in ("files", "sha256")}
        for name in told["files"]:
            if name not in TIMED:
                found[f"{record.parent.name}/{name}"] = (record.parent / name).read_bytes()
    return found


def campaign(command: str, place: Path, kills: int, seed: int) -> None:
    """Kill and resume until `kills` runs were killed, then follow every study to its end."""
    draw, right = random.Random(seed), {}
    for name, text in STUDIES.items():
        (place / name).write_text(text, encoding="utf-8")
        straight = subprocess.run([command, "study", name, "-q", "-o", f"straight-{name}"], cwd=place, check=False)
        right |= contents(place / f"straight-{name}")
        assert straight.returncode in (0, 1)
    out, killed, refused = place / "study", 0, 0
    while killed < kills:
        name = draw.choice(list(STUDIES))
        words = [command, "study", name, "-q", "-o", "study", *draw.choice(FLAGS)]
        process = subprocess.Popen(words, cwd=place, stderr=subprocess.DEVNULL)
        if draw.random() < 0.2:
            time.sleep(0.01)
            # Processes of the same work share its cases; --force is other work.
            other = [word for word in words if word != "--force"] if "--force" in words else [*words, "--force"]
            second = subprocess.run(other, cwd=place, check=False, capture_output=True, text=True)
            refused += "is in use by " in second.stderr
        try:
            process.wait(draw.uniform(0.0, 0.5))
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            killed += 1
        for path, content in contents(out).items():
            assert content == right[path], f"{path} after {killed} kills, {words}"
    for name in STUDIES:
        subprocess.run([command, "study", name, "-q", "-o", "study", "--retry-failed"], cwd=place, check=False)
        tables = [(place / where / "table.csv").read_text(encoding="utf-8") for where in ("study", f"straight-{name}")]
        assert tables[0] == tables[1], name
    assert contents(out) == right
    assert refused >= kills // 50, "no other work met a first process"


# Runs in a name space of its own, where everyone may mount.
FULL = """
import errno, subprocess, sys
from pathlib import Path
import mesocrete as mc

SPEC = {"specimen": {"kind": "cube", "side_mm": 20}, "fraction": 0.2, "grading": {"d_min_mm": 5, "d_max_mm": 8}}
CURVE = [(0, 0), (0.001, 20), (0.002, 30), (0.004, 10)]
TIMED = {"result.json", "result.html", "case.json"}
place, command = Path(sys.argv[1]), sys.argv[2]


def small(size):
    subprocess.run(["mount", "-o", f"remount,size={size}", place / "small"], check=True)


def by_command(out):
    ended = subprocess.run([command, "study", "STUDY.toml", "-q", "-j", "2", "-o", out], cwd=place, capture_output=True, text=True)
    if "No space left" in ended.stderr and "the same command then goes on" in ended.stderr and ended.returncode == 1:
        raise OSError(errno.ENOSPC, "")
    assert ended.returncode == 0, ended.stderr


def curves(out):
    mc.fit(CURVE, SPEC, seeds=1, steps=0, element_size=5, accept_phase_error=True, out=out)


def volumes(out):
    mc.dataset(12, spec=SPEC, shape=30, what=["grain"], sink=out, jobs=2)


def written(packing, folder):
    (folder / "mine.bin").write_bytes(bytes(20_000))
    return len(packing)


def function(out):
    mc.study(SPEC, {"seed": range(8)}, then=written, version=1, out=out)


for work, size, timed in [(by_command, "200k", set()), (function, "100k", set()), (volumes, "100k", set()), (curves, "300k", TIMED)]:
    full, right = place / "small" / work.__name__, place / work.__name__
    work(right)
    small(size)
    try:
        work(full)
        raise SystemExit(f"{work.__name__}: {size} are enough")
    except OSError as error:
        assert error.errno == errno.ENOSPC, error
    small("50m")
    work(full)
    read = lambda out: {path.relative_to(out): path.read_bytes() for path in out.rglob("*") if path.is_file() and path.name not in timed}
    assert read(full) == read(right), work.__name__
    subprocess.run(["rm", "-r", full], check=True)
"""


@pytest.mark.skipif(shutil.which("unshare") is None, reason="unshare is not installed")
def test_a_full_disk_fails_no_case_and_the_same_call_goes_on(command, tmp_path):
    (tmp_path / "STUDY.toml").write_text(STUDIES["a.toml"], encoding="utf-8")
    (tmp_path / "small").mkdir()
    mounted = 'mount -t tmpfs none "$1/small" && touch "$1/mounted" && exec "$0" -c "$3" "$1" "$2"'
    words = ["unshare", "-rm", "sh", "-c", mounted, sys.executable, str(tmp_path), command, FULL]
    ended = subprocess.run(words, capture_output=True, text=True, timeout=120, check=False, env={**os.environ, "TMPDIR": str(tmp_path)})
    if not (tmp_path / "mounted").exists():
        pytest.skip("this machine lets nobody mount a tmpfs")
    assert ended.returncode == 0, ended.stderr


def test_ten_kills_leave_the_bytes_of_a_straight_run(command, tmp_path):
    campaign(command, tmp_path, 10, seed=1)


@pytest.mark.slow
def test_two_hundred_kills_leave_the_bytes_of_a_straight_run(command, tmp_path):
    campaign(command, tmp_path, 200, seed=2)
