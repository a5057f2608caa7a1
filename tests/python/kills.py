"""Commands that are ended at random moments, and what they leave behind: nothing torn, nothing mixed, no program of theirs.

Every command replaces its outputs of a run before. Afterwards each output has the old content or the new one, and those of
one command agree. `pack` and `solve` keep what they have so far on the first INT: their files are read again. Only KILL
may fall between two names: then the first outputs are new and the others old, which is counted apart.
"""

import csv
import json
import os
import random
import shutil
import signal
import subprocess
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

SPEC = """fraction = 0.3
seed = {seed}
specimen = {{ kind = 'cube', side_mm = {side} }}
placement = {{ min_gap_mm = 0.3, wall_gap_mm = 0.3 }}
[grading]
d_min_mm = 6
d_max_mm = 12
classes_mm = [6, 9, 12]
"""
STUDY = """spec = 'spec.toml'
outputs = ['packing.csv']
[over]
seed = [1, 2, 3]
[mesh]
output = ['deck.inp']
element-size-mm = 2
"""
SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGKILL]


@dataclass(frozen=True)
class Job:
    """A command, the files that it writes, and whether a first INT keeps what there is so far."""

    name: str
    words: list[str]
    outputs: list[str]
    keeps: bool = False


JOBS = [
    Job("pack", ["pack", "spec.toml", "-f", "-o", "p.json", "-o", "p.csv", "-o", "p.vtu", "-o", "p.inp"], ["p.json", "p.csv", "p.vtu", "p.inp"], keeps=True),
    Job("mesh", ["mesh", "m.json", "-f", "--method", "lattice", "--element-size-mm", "4", "--accept-phase-error", "-o", "m.inp", "-o", "m.vtu", "-o", "m.msh"], ["m.inp", "m.vtu", "m.msh"]),
    Job("conforming", ["mesh", "m.json", "-f", "--method", "conforming", "--element-size-mm", "10", "-o", "g.inp", "-o", "g.msh"], ["g.inp", "g.msh"]),
    Job("convert", ["convert", "m.json", "-f", "-o", "c.vtu", "-o", "c.stl", "-o", "c.csv"], ["c.vtu", "c.stl", "c.csv"]),
    Job("report", ["report", "m.json", "-f", "-o", "r.html"], ["r.html"]),
    Job("solve", ["solve", "m.json", "-f", "--element-size-mm", "5", "--strain", "0.0005", "--accept-phase-error", "--frames", "2", "-o", "s"], ["s/curve.csv", "s/result.json", "s/result.html"], keeps=True),
    Job("study", ["study", "study.toml", "-o", "study"], []),
]


@dataclass
class Tally:
    """What was found, by the kind of fault."""

    moments: int = 0
    before_the_end: int = 0
    torn: list[str] = field(default_factory=list)
    mixed: list[str] = field(default_factory=list)
    between_names: list[str] = field(default_factory=list)
    left_over: list[str] = field(default_factory=list)
    children: list[str] = field(default_factory=list)

    def faults(self) -> list[str]:
        """Name all of them."""
        return [f"{kind}: {what}" for kind in ("torn", "mixed", "left_over", "children") for what in getattr(self, kind)]


class Ground:
    """A folder with a model and the outputs of runs before, and what whole runs take and give."""

    def __init__(self, command: str, folder: Path):
        self.command, self.folder = command, folder
        self.template = folder / "template"
        self.template.mkdir()
        (self.template / "spec.toml").write_text(SPEC.format(seed=1, side=30), encoding="utf-8")
        (self.template / "study.toml").write_text(STUDY, encoding="utf-8")
        (self.template / "s").mkdir()
        self.whole(["pack", "spec.toml", "-q", "-o", "m.json"], self.template)
        has_gmsh = shutil.which("gmsh") is not None
        self.jobs = [job for job in JOBS if job.name != "conforming" or has_gmsh]
        self.new, self.seconds = {}, {}
        for job in self.jobs:
            place = self.fresh()
            begun = time.monotonic()
            self.whole(job.words, place)
            self.seconds[job.name] = time.monotonic() - begun
            self.new[job.name] = {name: (place / name).read_bytes() for name in job.outputs}
            if job.name == "study":
                self.table = stable_rows(place)
            shutil.rmtree(place)

    def whole(self, words: list[str], place: Path) -> None:
        """Run a command to its end."""
        done = subprocess.run([self.command, *words], cwd=place, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{words}: {done.stderr}"

    def fresh(self) -> Path:
        """Copy the template."""
        return Path(shutil.copytree(self.template, Path(tempfile.mkdtemp(dir=self.folder)) / "place"))

    def strike(self, job: Job, number: int, moment: float, tally: Tally) -> None:
        """Start a command, end it after `moment` seconds, and look at what is left."""
        place = self.fresh()
        old = {name: b"old " + name.encode() for name in job.outputs}
        for name, content in old.items():
            (place / name).write_bytes(content)
        (place / "temporary").mkdir()
        process = subprocess.Popen(
            [self.command, *job.words],
            cwd=place,
            env=os.environ | {"TMPDIR": str(place / "temporary")},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        time.sleep(moment)
        still_runs = process.poll() is None
        tally.before_the_end += still_runs
        if not still_runs:
            # Whole runs were timed when the machine was busier: later moments shall not come too late as well.
            self.seconds[job.name] = min(moment, self.seconds[job.name])
        process.send_signal(number)
        process.wait(timeout=120)
        tally.moments += 1
        what = f"{job.name}, {signal.Signals(number).name} after {moment:.3f} s"
        tally.children += [f"{what}: {left}" for left in session(process.pid, patience=5.0)]
        if number != signal.SIGKILL:
            hidden = [path for path in place.rglob("*") if ".tmp" in path.name or path.parent.name == "temporary"]
            tally.left_over += [f"{what}: {path.name}" for path in hidden]
        if job.name == "study":
            self.look_at_study(place, what, tally)
        else:
            self.look(job, place, old, what, tally)
        shutil.rmtree(place.parent)

    def look(self, job: Job, place: Path, old: dict[str, bytes], what: str, tally: Tally) -> None:
        """Compare the outputs with the old ones and with those of a whole run."""
        state = {}
        for name, before in old.items():
            now = (place / name).read_bytes() if (place / name).exists() else b""
            is_new = now == self.new[job.name][name]
            state[name] = "old" if now == before else "new" if is_new else "other"
        if set(state.values()) <= {"old"} or set(state.values()) <= {"new"}:
            return
        if not job.keeps or "old" in state.values():
            kind = tally.torn if "other" in state.values() and not job.keeps else tally.mixed
            if "SIGKILL" in what and list(state.values()) == sorted(state.values()) and "other" not in state.values():
                kind = tally.between_names
            kind.append(f"{what}: {state}")
            return
        wrong = self.agree(job, place)
        if wrong:
            tally.torn.append(f"{what}: {wrong}")

    def agree(self, job: Job, place: Path) -> str:
        """Read the files of a run that kept what it had; what is wrong with them."""
        if job.name == "solve":
            json.loads((place / "s/result.json").read_text(encoding="utf-8"))
            rows = list(csv.reader((place / "s/curve.csv").read_text(encoding="utf-8").splitlines()))
            whole = (place / "s/result.html").read_bytes().rstrip().endswith(b"</html>")
            return "" if len({len(row) for row in rows}) == 1 and whole else "curve.csv or result.html is torn"
        self.whole(["convert", "p.json", "-o", "q.csv", "-o", "q.vtu"], place)
        self.whole(["mesh", "p.json", "-q", "-o", "q.inp"], place)
        same = [(place / f"p.{kind}").read_bytes() == (place / f"q.{kind}").read_bytes() for kind in ("csv", "vtu", "inp")]
        return "" if all(same) else "the files are not of the model beside them"

    def look_at_study(self, place: Path, what: str, tally: Tally) -> None:
        """Go on with the study: it ends as one that was never stopped."""
        self.whole(["study", "study.toml", "-o", "study", "-q"], place)
        if stable_rows(place) != self.table:
            tally.torn.append(f"{what}: another table.csv after it was gone on with")


def stable_rows(place: Path) -> list[list[str]]:
    """Read a study's table without its times."""
    rows = list(csv.reader((place / "study/table.csv").read_text(encoding="utf-8").splitlines()))
    kept = [i for i, name in enumerate(rows[0]) if "seconds" not in name]
    return [[row[i] for i in kept] for row in rows]


def session(leader: int, patience: float) -> list[str]:
    """Name what runs in the session of `leader` after `patience` seconds; on Linux alone."""
    deadline = time.monotonic() + patience
    while True:
        left = [name for pid in os.listdir("/proc") if pid.isdigit() for name in member(int(pid), leader)]
        if not left or time.monotonic() > deadline:
            return left
        time.sleep(0.01)


def member(pid: int, leader: int) -> list[str]:
    """Name a process where it belongs to the session of `leader` and still runs."""
    try:
        name, rest = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)
    except OSError:
        return []
    fields = rest.split()
    return [name.split("(", 1)[1]] if int(fields[3]) == leader and fields[0] not in "ZX" else []


def campaign(command: str, folder: Path, moments: int, seed: int = 1) -> Tally:
    """End commands at random moments of their runs."""
    ground, tally, chance = Ground(command, folder), Tally(), random.Random(seed)
    for i in range(moments):
        job, number = ground.jobs[i % len(ground.jobs)], SIGNALS[(i // len(ground.jobs)) % len(SIGNALS)]
        ground.strike(job, number, chance.uniform(0.0, 1.1 * ground.seconds[job.name]), tally)
    return tally
