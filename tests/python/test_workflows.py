"""The workflows run only code that is fixed by its hash, with no more rights than they need; the suite names what it skips."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))


def steps(text: str) -> list[str]:
    """Split a workflow at its steps."""
    return re.split(r"^ +- (?=\w+:)", text, flags=re.MULTILINE)[1:]


@pytest.fixture(params=WORKFLOWS, ids=lambda path: path.name)
def workflow(request):
    return request.param.read_text(encoding="utf-8")


def test_every_action_is_pinned_by_a_commit_beside_its_version(workflow):
    uses = re.findall(r"^.*\buses:.*$", workflow, re.MULTILINE)
    assert uses
    pinned = re.compile(r" *(- )?uses: [\w.-]+/[\w./-]+@[0-9a-f]{40} # (v\d+\.\d+\.\d+|stable)")
    assert [line for line in uses if not pinned.fullmatch(line)] == []


def test_an_action_has_one_commit_in_all_workflows():
    commits = {}
    for path in WORKFLOWS:
        for name, commit in re.findall(r"uses: (\S+)@([0-9a-f]{40})", path.read_text(encoding="utf-8")):
            commits.setdefault(name, set()).add(commit)
    assert {name: found for name, found in commits.items() if len(found) > 1} == {}


def test_programs_built_from_a_registry_have_a_version(workflow):
    assert "@latest" not in workflow


def test_a_checkout_leaves_no_credentials_behind(workflow):
    checkouts = [step for step in steps(workflow) if "actions/checkout@" in step]
    assert [step for step in checkouts if "persist-credentials: false" not in step] == []


def test_jobs_read_the_repository_unless_they_publish(workflow):
    head, jobs = workflow.split("\njobs:\n")
    assert re.search(r"^permissions:\n  contents: read$", head, re.MULTILINE)
    for job in re.split(r"^  (?=\w+:$)", jobs, flags=re.MULTILINE)[1:]:
        assert "write" not in job.split("steps:")[0] or re.search(r"\n    environment:", job), job.splitlines()[0]


def test_a_release_may_be_repeated_after_a_failure():
    text = (ROOT / ".github" / "workflows" / "release.yml").read_text(encoding="utf-8")
    assert "skip-existing: true" in text
    assert "gh release upload" in text and "--clobber" in text
    # What cannot be withdrawn comes last.
    assert text.index("gh-action-pypi-publish") < text.index("gh release create") < text.index("packaging/crates.py --publish")


def test_the_published_crates_are_those_of_the_workspace_in_order():
    tomllib = pytest.importorskip("tomllib", reason="Python 3.10 reads no TOML")
    listed = subprocess.run([sys.executable, ROOT / "packaging" / "crates.py"], check=True, capture_output=True, text=True)
    names = [line.split()[0] for line in listed.stdout.splitlines()]
    manifests = [tomllib.loads(path.read_text(encoding="utf-8")) for path in (ROOT / "crates").glob("*/Cargo.toml")]
    published = {m["package"]["name"]: m for m in manifests if m["package"].get("publish", True)}
    assert set(names) == set(published)
    for name, manifest in published.items():
        needed = [other for other in manifest.get("dependencies", {}) if other in published]
        assert all(names.index(other) < names.index(name) for other in needed), name


def test_the_site_is_built_where_its_settings_change():
    assert '"site/mkdocs.yml"' in (ROOT / ".github" / "workflows" / "docs.yml").read_text(encoding="utf-8")


def test_the_suite_ends_with_the_stages_that_it_skipped(capsys, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "tests"))
    monkeypatch.setenv("PATH", "")
    suite = pytest.importorskip("run")
    monkeypatch.setattr(suite, "SKIPPED", [])
    assert suite.supply_chain(slow=False) == []
    assert suite.summarise([], 1.0) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("skipped advisories, licences and sources of dependencies: no cargo-deny")
    assert "skipped gmsh reading our meshes (PyPI or Debian: gmsh): no gmsh" in lines
    assert lines[-1] == "all stages in 1 s; everything passed"
