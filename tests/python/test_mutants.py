"""The list of mutants fits the sources: a fault that has no place is never tried."""

import sys
from pathlib import Path

TOOLS = Path(__file__).resolve().parents[2] / "tools"
sys.path.insert(0, str(TOOLS))
import mutants  # noqa: E402


def test_every_mutant_has_exactly_one_place_in_the_sources():
    listed = mutants.read(TOOLS / "mutants.txt")
    assert len(listed) > 100
    texts = mutants.faulty(listed)
    for mutant in listed:
        assert f"crate::mutant::is({mutant.number})" in texts[Path(mutant.file)].decode(), mutant.right
