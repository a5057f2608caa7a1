#!/usr/bin/env python3
"""Runs every fuzz target, two at a time, and keeps a small corpus of each.

    python3 fuzz/run.py --seconds 60          # all targets, a minute each
    python3 fuzz/run.py --seconds 600 hull    # one of them

Needs cargo-fuzz and the nightly toolchain; without them it says so and ends with 0. A case that fails stays in
`fuzz/artifacts/`, and the exit code is 1.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

FUZZ = Path(__file__).resolve().parent
# What is kept of a corpus, in bytes and in cases: enough for each way through a reader.
KEPT, MOST = 25_000, 60
# Readers of small files; a saved model is larger.
LONGEST = {"saved-model": 30_000}


def main() -> int:
    """Build all targets, then run them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=int, default=60, help="for each target")
    parser.add_argument("--look", action="store_true", help="leave the corpora as they are: new cases go to fuzz/target/new")
    parser.add_argument("targets", nargs="*", help="all when absent")
    args = parser.parse_args()
    if missing := what_is_missing():
        print(f"skipped, for want of {missing}: the fuzz targets")
        return 0
    listed = re.findall(r'^\[\[bin\]\]\nname = "(.*)"', (FUZZ / "Cargo.toml").read_text(encoding="utf-8"), re.MULTILINE)
    if fuzz("build") != 0:
        return 1
    names = args.targets or listed
    # Each takes one core.
    with ThreadPoolExecutor(max_workers=min(2, os.cpu_count() or 1)) as pool:
        held = list(pool.map(lambda name: lasts(name, args.seconds, args.look), names))
    failed = [name for name, lasted in zip(names, held, strict=True) if not lasted]
    print(f"failed: {', '.join(failed)}" if failed else "every target held")
    return 1 if failed else 0


def what_is_missing() -> str:
    """Name the tool that is not installed."""
    if shutil.which("cargo-fuzz") is None:
        return "cargo-fuzz (cargo install cargo-fuzz)"
    listed = subprocess.run(["rustup", "toolchain", "list"], capture_output=True, text=True, check=False).stdout
    return "" if "nightly" in listed else "the nightly toolchain (rustup toolchain install nightly)"


def fuzz(verb: str, *words: str) -> int:
    """Run cargo-fuzz."""
    command = ["cargo", "+nightly", "fuzz", verb, "--fuzz-dir", str(FUZZ), "--codegen-units", "16", *words]
    return subprocess.run(command, cwd=FUZZ.parent, check=False).returncode


def lasts(name: str, seconds: int, look: bool) -> bool:
    """Fuzz one target and, unless it is a look only, trim its corpus; whether it held."""
    corpus, new = FUZZ / "corpus" / name, FUZZ / "target" / "new" / name
    # The first folder gets new cases, the other is read.
    folders = [new, corpus] if look else [corpus]
    for folder in folders:
        folder.mkdir(parents=True, exist_ok=True)
    limits = [f"-max_total_time={seconds}", f"-max_len={LONGEST.get(name, 8000)}", "-timeout=60", "-rss_limit_mb=4096"]
    held = fuzz("run", name, *map(str, folders), "--", *limits, "-print_final_stats=1") == 0
    if not look:
        trim(corpus)
    return held


def trim(corpus: Path) -> None:
    """Keep some of the cases, small and large ones alike, since libFuzzer keeps thousands."""
    cases = sorted(corpus.iterdir(), key=lambda path: (path.stat().st_size, path.name))
    kept, room = set(), KEPT
    for case in cases[:: -(-len(cases) // MOST)] if cases else []:
        room -= case.stat().st_size
        if room >= 0:
            kept.add(case)
    for case in set(cases) - kept:
        case.unlink()


if __name__ == "__main__":
    sys.exit(main())
