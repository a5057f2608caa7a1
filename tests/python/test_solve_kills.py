"""Tests that are killed at random moments and resumed with any flags: the bytes of a straight run of these flags, or a refusal."""

import hashlib
import random
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="kills by signal")

SPEC = """fraction = 0.25
seed = 3
specimen = { kind = 'cube', side_mm = 24 }
grading = { d_min_mm = 5, d_max_mm = 10 }
placement = { min_gap_mm = 1 }
"""
CYCLIC = "kind = 'cyclic'\nstrain = 0.0015\n"
MATERIALS = "[materials.mortar_strength]\ncompressive_mpa = 30\n"
BASE = ["--element-size-mm", "3", "--strain", "0.0015", "--frames", "3"]
# Another test or another mesh each, but for the last ones, which change no byte.
OTHERS = [
    ["--friction", "0.2"],
    ["--strain", "0.0016"],
    ["--frames", "4"],
    ["--test", "tension"],
    ["--test", "cyclic.toml"],
    ["--law", "cdpm2"],
    ["--law", "meso"],
    ["--control", "steady"],
    ["--itz", "cohesive"],
    ["--element-size-mm", "3.5"],
    ["--materials", "weak.toml"],
    ["--smoothing", "none"],
    ["--method", "voxel"],
    ["--time-step", "2e-7"],
]
HARMLESS = [[], ["--threads", "1"], ["--threads", "3"], ["--device", "cpu"], ["--checkpoint", "0.05"]]
# These hold seconds.
TIMED = {"result.json", "result.html"}


class Ground:
    """A folder with a model, and the results of straight runs by their flags."""

    def __init__(self, command: str, place: Path):
        self.command, self.place = command, place
        self.straight: dict[tuple[str, ...], dict[str, str]] = {}
        for name, text in {"spec.toml": SPEC, "cyclic.toml": CYCLIC, "weak.toml": MATERIALS}.items():
            (place / name).write_text(text, encoding="utf-8")
        subprocess.run([command, "pack", "spec.toml", "-q", "-o", "m.json"], cwd=place, check=True)

    def words(self, flags: list[str], out: str) -> list[str]:
        """Return a command line; a flag that is given again replaces the one of the base."""
        base = [word for pair in zip(BASE[::2], BASE[1::2]) if pair[0] not in flags for word in pair]
        return [self.command, "solve", "m.json", "--accept-phase-error", "-q", "-o", out, *base, *flags]

    def expected(self, flags: list[str]) -> dict[str, str]:
        """Return the results of a straight run."""
        key = tuple(flags)
        if key not in self.straight:
            out = f"straight-{len(self.straight)}"
            ended = subprocess.run(self.words(flags, out), cwd=self.place, capture_output=True, text=True, check=False)
            assert ended.returncode == 0, ended.stderr
            self.straight[key] = contents(self.place / out)
        return self.straight[key]


def contents(out: Path) -> dict[str, str]:
    """Hash every file but timed, hidden and unfinished ones."""
    files = [path for path in sorted(out.iterdir()) if path.name not in TIMED and not path.name.startswith(".")]
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def campaign(command: str, place: Path, kills: int, seed: int) -> dict[str, int]:
    """Kill and resume until `kills` runs were killed; count how the others ended."""
    draw, ground, out = random.Random(seed), Ground(command, place), place / "out"
    counts = {"killed": 0, "resumed to the end": 0, "refused": 0, "begun": 0}
    # Flags of the test that the checkpoint may belong to: a new test that is killed early leaves the old checkpoint.
    owners: list[list[str]] = []
    while counts["killed"] < kills:
        resumes = (out / "checkpoint.bin").exists() and draw.random() < 0.9
        if not resumes or draw.random() < 0.3:
            flags = draw.choice([[], *OTHERS])
        else:
            flags = draw.choice(owners)
        before = contents(out) if resumes else {}
        words = ground.words(flags, "out") + draw.choice(HARMLESS)
        words += ["--resume"] if resumes else ["--force"]
        words += [] if "--checkpoint" in words else ["--checkpoint", "0"]
        if not resumes:
            others = [owner for owner in owners if owner != flags]
            owners = [*others, flags] if (out / "checkpoint.bin").exists() else [flags]
            counts["begun"] += 1
        process = subprocess.Popen(words, cwd=place, stderr=subprocess.PIPE, text=True)
        try:
            # One in six goes to its end.
            _, said = process.communicate(timeout=draw.uniform(0.05, 1.5) if draw.random() < 5 / 6 else None)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            counts["killed"] += 1
            continue
        if process.returncode == 0:
            # A run that resumes takes away the unfinished files of killed ones; a new one leaves them.
            unfinished = list(out.glob(".mesocrete-*.tmp"))
            assert not (resumes and unfinished), unfinished
            for left in unfinished:
                left.unlink()
            assert contents(out) == ground.expected(flags), words
            counts["resumed to the end"] += resumes
        else:
            assert resumes and owners != [flags], (words, said)
            owners = [owner for owner in owners if owner != flags]
            assert process.returncode == 1 and "checkpoint.bin: " in said, (words, said)
            assert contents(out) == before, words
            counts["refused"] += 1
    return counts


def test_ten_kills_leave_the_bytes_of_a_straight_run_or_a_refusal(command, tmp_path):
    campaign(command, tmp_path, 10, seed=1)


@pytest.mark.slow
def test_two_hundred_kills_leave_the_bytes_of_a_straight_run_or_a_refusal(command, tmp_path):
    counts = campaign(command, tmp_path, 200, seed=2)
    print(counts)
    assert counts["resumed to the end"] >= 10 and counts["refused"] >= 10, counts
