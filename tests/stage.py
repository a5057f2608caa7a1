"""One command of tests/run.py: what it prints is shown and kept, so that the end can name the tests that failed."""

import os
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

ROOT = Path(__file__).resolve().parent.parent
COLOURS = re.compile(r"\x1b\[[0-9;]*m")
# Lists of cargo test, lines of pytest's summary, then what compilers and cargo call an error.
LISTS = re.compile(r"^failures:\n((?: {4}.+\n)+)", re.MULTILINE)
LINES = [re.compile(r"^(?:FAILED|ERROR) tests/.*", re.MULTILINE), re.compile(r"^error(?:\[E\d+\])?: .*", re.MULTILINE)]


@dataclass(frozen=True)
class Ended:
    """A command that has ended."""

    name: str
    code: int
    seconds: float
    cpu_seconds: float | None
    """Of the command and its children; None where the system does not count them (Windows)."""
    failures: list[str]
    """Names of the tests that failed, or its last lines; empty where it passed."""

    @property
    def times(self) -> str:
        """Say how long it took."""
        cpu = "" if self.cpu_seconds is None else f", {self.cpu_seconds:.0f} s of processor time"
        return f"{self.seconds:.0f} s{cpu}"


def run(name: str, command: list[str], *, live: bool = True) -> Ended:
    """Run one command from the project's root; show what it prints as it comes, or whole at its end."""
    print(f"== {name}{'' if live else ', in the background'}: {' '.join(command)}", flush=True)
    started = time.monotonic()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        path = Path(folder) / "output"
        # A file, not a pipe: a program that a test left behind would hold a pipe open.
        with path.open("wb") as sink, path.open("rb") as source:
            process = subprocess.Popen(command, cwd=ROOT, stdout=sink, stderr=subprocess.STDOUT)
            cpu_seconds = wait(process, source if live else None)
            show(source)
        text = path.read_text(encoding="utf-8", errors="replace")
    code = process.returncode
    ended = Ended(name, code, time.monotonic() - started, cpu_seconds, failures(text) if code else [])
    print(f"== {name}: {'ok' if code == 0 else f'FAILED ({code})'} in {ended.times}", flush=True)
    return ended


def wait(process: subprocess.Popen, source: BinaryIO | None) -> float | None:
    """Wait for a command's end and show meanwhile what it prints; its processor time in seconds."""
    while True:
        if hasattr(os, "wait4"):
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                process.returncode = os.waitstatus_to_exitcode(status)
                return usage.ru_utime + usage.ru_stime
        elif process.poll() is not None:
            return None
        if source:
            show(source)
        time.sleep(0.1)


def show(source: BinaryIO) -> None:
    """Show what was printed since the last look."""
    sys.stdout.flush()
    sys.stdout.buffer.write(source.read())
    sys.stdout.buffer.flush()


def failures(output: str) -> list[str]:
    """Name the tests that failed by what a command printed; its last lines where it names none."""
    output = COLOURS.sub("", output)
    listed = [line.strip() for names in LISTS.findall(output) for line in names.splitlines()]
    found = list(dict.fromkeys([*listed, *(line for lines in LINES for line in lines.findall(output))]))
    return found or [line for line in output.splitlines() if line.strip()][-5:]


def told_again(stages: list[Ended], room: int = 20) -> list[str]:
    """Lines that name what failed in each stage, `room` names at most in all."""
    failed = [stage for stage in stages if stage.code != 0]
    lines = []
    for stage in failed:
        share = max(2, room // len(failed))
        lines.append(f"failed in {stage.name}:")
        lines += [f"    {name[:150]}" for name in stage.failures[:share]]
        if len(stage.failures) > share:
            lines.append(f"    ... and {len(stage.failures) - share} more")
    return lines
