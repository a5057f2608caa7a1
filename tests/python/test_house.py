"""The bars on how the source is built hold: tests/house.py counts, here they are compared."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import house  # noqa: E402


@pytest.mark.parametrize("figure", house.figures(), ids=lambda figure: figure.name)
def test_the_source_keeps_its_bars(figure: house.Figure) -> None:
    """A figure above its bar names the places that it counts."""
    assert figure.count <= figure.most, "\n".join(figure.places)


def test_a_comment_that_leans_on_the_line_above_is_counted(tmp_path: Path) -> None:
    """So that the bar cannot hold by counting nothing."""
    source = tmp_path / "a.rs"
    source.write_text("/// The same within 2e-18. Of none, all cores.\n/// A value.\nfn a() {}\n", encoding="utf-8")
    house.ROOT, root = tmp_path, house.ROOT
    try:
        sentences = list(house.comments(source))
    finally:
        house.ROOT = root
    assert [bool(house.LEANING.match(said)) for _, said in sentences] == [True, True, False]
