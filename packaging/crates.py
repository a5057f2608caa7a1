#!/usr/bin/env python3
"""Publishes the crates of the workspace that their registry lacks, each after those that it needs.

    python3 packaging/crates.py              # lists the crates that are published, in order
    python3 packaging/crates.py --publish    # publishes the versions that are missing; may be repeated after a failure

The list comes from `cargo metadata`: every member of the workspace, unless its manifest has `publish = false`.
"""

import json
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def crates() -> list[tuple[str, str]]:
    """List name and version of each crate that is published, dependencies first."""
    command = ["cargo", "metadata", "--format-version", "1", "--no-deps", "--locked"]
    read = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    # `publish = false` reads as an empty list of registries.
    members = {package["name"]: package for package in json.loads(read.stdout)["packages"] if package["publish"] != []}
    needs = {name: {d["name"] for d in package["dependencies"] if d["kind"] != "dev"} for name, package in members.items()}
    return [(name, members[name]["version"]) for name in TopologicalSorter(needs).static_order() if name in members]


def is_published(name: str, version: str) -> bool:
    """Tell whether crates.io has a version."""
    command = ["cargo", "info", "--quiet", "--registry", "crates-io", f"{name}@{version}"]
    return subprocess.run(command, check=False, capture_output=True).returncode == 0


def main() -> int:
    """List the crates, or publish them."""
    if sys.argv[1:] != ["--publish"]:
        print(*(f"{name} {version}" for name, version in crates()), sep="\n")
        return 0
    for name, version in crates():
        if is_published(name, version):
            print(f"{name} {version} is there already")
        elif subprocess.run(["cargo", "publish", "--locked", "-p", name], cwd=ROOT, check=False).returncode != 0:
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
