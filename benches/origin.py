"""Where a measured row comes from: machine, date and commit, as every table under results/ ends."""

import datetime
import os
import platform
import subprocess
from pathlib import Path

RESULTS = Path(__file__).parent / "results"


def machine():
    """Name the processor and its threads."""
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    names = [line.split(": ")[1] for line in lines if line.startswith("model name")]
    return f"{names[0] if names else platform.processor()} {os.cpu_count()} threads".replace(",", " ")


def origin():
    """Join machine, date and commit as the last three columns of a row."""
    command = ["git", "rev-parse", "--short", "HEAD"]
    commit = subprocess.run(command, cwd=RESULTS, capture_output=True, text=True, check=False).stdout.strip()
    return f"{machine()},{datetime.datetime.now(datetime.timezone.utc):%Y-%m-%d},{commit or 'unknown'}"
