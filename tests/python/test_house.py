"""The bars on how the source is built hold: tools/house.py counts, here they are compared."""

import re
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools"))
import house  # noqa: E402


@pytest.mark.parametrize("figure", house.figures(), ids=lambda figure: figure.name)
def test_the_source_keeps_its_bars(figure: house.Figure) -> None:
    """A figure above its bar names the places that it counts."""
    assert figure.count <= figure.bar, "\n".join(figure.places)


def test_the_text_of_a_law_exists_once() -> None:
    """Kernels are traced from the laws: meso-gpu has none of their constants, and its kernel none of their functions."""
    element, gpu = house.CRATES / "meso-element" / "src", house.CRATES / "meso-gpu" / "src"
    laws = [*(element / "law").glob("*.rs"), element / "face.rs"]
    kernel = gpu / "kernel.cl"
    constants = set().union(*map(fractions, laws))
    assert len(constants) > 50, "constants of the laws are found"
    for path in [kernel, *gpu.rglob("*.rs")]:
        assert fractions(path) & constants == set(), path
    for word in ("exp", "log", "pow", "strength", "damage", "yield", "Young", "Poisson"):
        assert not re.search(rf"\b{word}\w*", house.text_of(kernel)), word


def fractions(path: Path) -> set[float]:
    """Read the numbers of a file's code that are no whole ones; a half is geometry's, too."""
    text = house.TESTS.split(re.sub(r"//[^\n]*|/\*.*?\*/", "", house.text_of(path), flags=re.DOTALL))[0]
    numbers = re.findall(r"(?<![\w.])\d[\d_]*(?:\.\d+)?(?:e-?\d+)?(?![\w.])", text)
    values = {float(number.replace("_", "")) for number in numbers}
    return {value for value in values if value % 1 not in (0, 0.5)}


def test_names_of_tests_name_their_subject() -> None:
    """A name that begins with a pronoun cannot be read alone."""
    paths = [path for path in (house.ROOT / "tests").rglob("*.*") if path.suffix in (".rs", ".py")]
    text = "\n".join(map(house.text_of, [*paths, *house.sources()]))
    names = re.findall(r"#\[test\]\s+(?:#\[.*\]\s+)*fn (\w+)|^def test_(\w+)", text, re.MULTILINE)
    assert len(names) > 1000
    assert [name for pair in names for name in pair if re.match("(what|that|those|of|as|it|this|they|these)_", name)] == []
