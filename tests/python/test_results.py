"""Results of benches say where, when and of which commit they were measured; every bench has a short run."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
# What the scripts share is no bench.
SCRIPTS = sorted(path for path in (ROOT / "benches").glob("*.py") if path.name != "origin.py")
BENCHES = [*sorted((ROOT / "benches").glob("*.rs")), *SCRIPTS]
RESULTS = sorted((ROOT / "benches" / "results").iterdir())
ORIGIN = re.compile(r"[^,]+,20\d\d-\d\d-\d\d,[0-9a-f]{7,}")


@pytest.mark.parametrize("path", RESULTS, ids=lambda path: path.name)
def test_every_result_has_its_machine_date_and_commit(path: Path) -> None:
    """A table in its last three columns, a picture in a comment at its end."""
    head, *lines = path.read_text(encoding="utf-8").splitlines()
    if path.suffix == ".csv":
        assert head.endswith(",machine,date,commit")
        assert lines
        origins = [",".join(line.split(",")[-3:]) for line in lines]
    else:
        assert path.suffix == ".svg"
        origins = re.findall("^<!-- (.*) -->$", lines[-1])
        assert origins
    assert [origin for origin in origins if not ORIGIN.fullmatch(origin)] == []


@pytest.mark.parametrize("path", BENCHES, ids=lambda path: path.name)
def test_every_bench_has_a_short_run_that_the_slow_tier_takes(path: Path) -> None:
    """`--quick` is told in the bench's first lines; `tests/run.py` runs each."""
    text = path.read_text(encoding="utf-8")
    assert "--quick" in "".join(re.findall(r'^//!.*\n|^"""(?:.|\n)*?"""', text, re.MULTILINE)), "its head names --quick"
    if path.suffix == ".rs":
        # Criterion knows the flag by itself.
        assert re.search(r"\b(?:count|quick)\(|criterion_main!", text), "its cases depend on --quick"
        manifests = [file.read_text(encoding="utf-8") for file in (ROOT / "crates").glob("*/Cargo.toml")]
        own = (ROOT / "benches" / "Cargo.toml").read_text(encoding="utf-8")
        assert any(f'path = "../../benches/{path.name}"' in manifest for manifest in manifests) or f'path = "{path.name}"' in own
    else:
        assert f'"{path.name}"' in (ROOT / "tests" / "run.py").read_text(encoding="utf-8")
