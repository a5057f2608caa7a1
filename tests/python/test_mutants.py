"""The list of mutants fits the sources: a fault that has no place is never tried."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))
import mutants  # noqa: E402


def test_the_right_of_every_mutant_stands_once_in_its_file():
    listed = mutants.read(ROOT / "tests" / "mutants.txt")
    assert len(listed) > 100
    homeless = []
    for mutant in listed:
        count = (ROOT / mutant.file).read_text(encoding="utf-8").count("".join(mutant.part()))
        if count != 1:
            homeless.append(f"{mutant.file} has {count} times: {mutant.right}")
    assert not homeless, "\n".join(homeless)
