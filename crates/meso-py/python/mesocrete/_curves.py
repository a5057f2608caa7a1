"""Mean curves of repeated tests with their scatter, and a figure of them in the style of a paper."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._frames import framing
from ._study import Study
from ._views import _need

_CURVE, _RECORD = "curve.csv", "case.json"
# Labels of quantities, and the factor to the unit of each.
_LABELS = {"strain": ("strain, ‰", 1000.0), "stress_mpa": ("stress, MPa", 1.0)}
# Widths of a column and of a page in most journals, and the golden section for the height.
_COLUMN_MM, _HEIGHT = 85.0, 0.68
# Colours that remain apart for the colour-blind and in grey (M. Okabe, K. Ito, 2008), and lines that do without colours.
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
_LINES = ("-", "--", "-.", ":")
_STYLE = {
    "axes.labelsize": 8,
    "axes.linewidth": 0.6,
    "font.family": "sans-serif",
    "font.size": 8,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "lines.linewidth": 1.2,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    "svg.hashsalt": "mesocrete",
    "xtick.direction": "in",
    "xtick.labelsize": 7,
    "ytick.direction": "in",
    "ytick.labelsize": 7,
}


class Curves:
    """Mean curves of a study, one for each combination of the other axes; `mean_curves` returns one."""

    def __init__(self, x: str, y: str, groups: Sequence[tuple[dict[str, Any], NDArray[np.float64], NDArray[np.float64]]]) -> None:
        """Take the name of each quantity, and of each group its values, its grid and its curves, one a row."""
        self.x, self.y = x, y
        self._groups = list(groups)

    def __len__(self) -> int:
        """Return the number of mean curves."""
        return len(self._groups)

    @property
    def values(self) -> list[dict[str, Any]]:
        """Values of the other axes, of each mean curve."""
        return [dict(values) for values, _, _ in self._groups]

    def table(self, frame: str | None = None) -> Any:
        """Return one row a point: the other axes, `x`, `n`, `mean`, `std`, `min` and `max`; a dict of arrays, or a frame.

        `std` is that of the sample, NaN of one curve. `frame` is "pandas" or "polars".
        """
        framed = framing(frame)
        rows = [_rows(*group, self.x) for group in self._groups]
        return framed({name: np.concatenate([row[name] for row in rows]) for name in rows[0]})

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the table as `.csv`, or the figure as `.pdf`, `.svg` or `.png`: the same bytes each time."""
        path = Path(path)
        if path.suffix.lower() == ".csv":
            table = self.table()
            with path.open("w", newline="", encoding="utf-8") as file:
                writer = csv.writer(file, lineterminator="\n")
                writer.writerow(table)
                writer.writerows(zip(*(column.tolist() for column in table.values()), strict=True))
            return
        if path.suffix.lower() not in (".pdf", ".svg", ".png"):
            message = f"{path} ends in {path.suffix or 'nothing'}; it must end in .csv, .pdf, .svg or .png"
            raise ValueError(message)
        pyplot = _need("matplotlib.pyplot", "plot")
        undated = {".pdf": {"CreationDate": None}, ".svg": {"Date": None}}.get(path.suffix.lower())
        with pyplot.rc_context(_STYLE):
            axes = self.plot()
            axes.figure.savefig(path, dpi=600, metadata=undated)
            pyplot.close(axes.figure)

    def plot(self, ax: Any = None, *, band: str = "std", width_mm: float = _COLUMN_MM) -> Any:
        """Draw each mean with its band on `ax`, or on a new figure of the width of a column; return the axes.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to draw; absent: a figure in the style of a paper.
        band : {"std", "range", "none"}
            One standard deviation to each side, from the lowest to the highest curve, or nothing.
        width_mm : float
            Width of a new figure, mm.
        """
        if band not in ("std", "range", "none"):
            message = f'band is {band!r}; it must be "std", "range" or "none"'
            raise ValueError(message)
        pyplot = _need("matplotlib.pyplot", "plot")
        with pyplot.rc_context(_STYLE):
            if ax is None:
                inches = width_mm / 25.4
                _, ax = pyplot.subplots(figsize=(inches, _HEIGHT * inches), layout="constrained")
                ax.spines[["top", "right"]].set_visible(False)
            (label_x, unit_x), (label_y, unit_y) = (_LABELS.get(name, (name, 1.0)) for name in (self.x, self.y))
            for i, (values, along, curves) in enumerate(self._groups):
                grid, sample = unit_x * along, unit_y * curves
                colour, line = _COLOURS[i % len(_COLOURS)], _LINES[i % len(_LINES)]
                mean = sample.mean(axis=0)
                ax.plot(grid, mean, line, color=colour, label=_label(values, len(sample)))
                if band != "none" and len(sample) > 1:
                    ax.fill_between(grid, *_band(sample, mean, band), color=colour, alpha=0.2, linewidth=0)
            ax.set(xlabel=label_x, ylabel=label_y)
            ax.set_xlim(left=0)
            ax.set_ylim(bottom=0)
            ax.legend()
        return ax

    def __repr__(self) -> str:
        """Count the curves."""
        return f"Curves({len(self)} means of {sum(len(sample) for _, _, sample in self._groups)} tests, {self.y} over {self.x})"


def mean_curves(
    study: Study | str | os.PathLike[str],
    replicate: str = "seed",
    *,
    x: str = "strain",
    y: str = "stress_mpa",
    points: int = 201,
) -> Curves:
    """Return the mean curve over an axis of a study, for each combination of the others.

    Parameters
    ----------
    study : Study or path
        A study of tests, or its folder, as `mesocrete study` with `[solve]` makes it: cases with a `curve.csv`. Failed cases
        do not count.
    replicate : str
        The axis whose cases are repetitions; beside `seed`, seeds of `[materials.scatter]` are repetitions, too.
    x, y : str
        Columns of `curve.csv`; `x` must not fall.
    points : int
        Number of points from 0 to the end of the shortest curve of a group.

    Returns
    -------
    Curves

    Raises
    ------
    FileNotFoundError
        Where no case has a curve.
    ValueError
        For a column that is not there, and for curves whose `x` falls, as in a cyclic test.
    """
    if points < 2:
        message = f"points is {points}; it must be 2 or more"
        raise ValueError(message)

    def is_repeated(key: str) -> bool:
        return key == replicate or (replicate == "seed" and key.endswith("materials.scatter.seed"))

    root = study.out if isinstance(study, Study) else Path(study)
    groups: dict[str, tuple[dict[str, Any], list[tuple[NDArray[np.float64], NDArray[np.float64]]]]] = {}
    for record in _records(study, root):
        others = {key: value for key, value in record["values"].items() if not is_repeated(key)}
        _, found = groups.setdefault(json.dumps(others, sort_keys=True), (others, []))
        found.append(_curve(root / record["case"] / _CURVE, x, y))
    if not groups:
        message = f"no finished case in {root} has a {_CURVE}; a study with [solve], or response.write(folder), makes it, and the layout folders keeps it"
        raise FileNotFoundError(message)
    return Curves(x, y, [_group(others, found, points) for others, found in groups.values()])


def _records(study: Study | str | os.PathLike[str], root: Path) -> list[Mapping[str, Any]]:
    """Return the records of the cases with a curve, in the order of the study, or of the folders' values."""
    if isinstance(study, Study):
        records: list[Mapping[str, Any]] = list(study.results)
    else:
        found = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(root.glob(f"*/{_RECORD}"))]
        records = sorted(found, key=lambda record: [_order(value) for value in record["values"].values()])
    return [record for record in records if record["status"] == "done" and (root / record["case"] / _CURVE).is_file()]


def _order(value: Any) -> tuple[float, str]:
    return (float(value), "") if isinstance(value, int | float) else (0.0, json.dumps(value))


def _curve(path: Path, x: str, y: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    with path.open(encoding="utf-8") as file:
        names = file.readline().strip().split(",")
        rows = np.loadtxt(file, delimiter=",", ndmin=2)
    for name in (x, y):
        if name not in names:
            message = f"{path} has no column {name!r}; it has {', '.join(names)}"
            raise ValueError(message)
    along, value = rows[:, names.index(x)], rows[:, names.index(y)]
    if (np.diff(along) < 0).any():
        message = f"{path}: {x} falls, so that curves have no mean over it; choose another x"
        raise ValueError(message)
    return along, value


def _group(
    others: dict[str, Any], curves: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]], points: int
) -> tuple[dict[str, Any], NDArray[np.float64], NDArray[np.float64]]:
    grid = np.linspace(0.0, min(along[-1] for along, _ in curves), points)
    return others, grid, np.array([np.interp(grid, along, value) for along, value in curves])


def _rows(values: Mapping[str, Any], grid: NDArray[np.float64], sample: NDArray[np.float64], x: str) -> dict[str, Any]:
    n, nothing = len(sample), np.full(len(grid), np.nan)
    columns = {key: np.full(len(grid), value if np.isscalar(value) else json.dumps(value)) for key, value in values.items()}
    return {
        **columns,
        x: grid,
        "n": np.full(len(grid), n),
        "mean": sample.mean(axis=0),
        "std": sample.std(axis=0, ddof=1) if n > 1 else nothing,
        "min": sample.min(axis=0),
        "max": sample.max(axis=0),
    }


def _band(sample: NDArray[np.float64], mean: NDArray[np.float64], band: str) -> tuple[Any, Any]:
    if band == "range":
        return sample.min(axis=0), sample.max(axis=0)
    std = sample.std(axis=0, ddof=1)
    return mean - std, mean + std


def _label(values: Mapping[str, Any], n: int) -> str:
    named = ", ".join(f"{key.rpartition('.')[2].replace('_', ' ')} {value}" for key, value in values.items())
    return f"{named or 'mean'} (n = {n})"
