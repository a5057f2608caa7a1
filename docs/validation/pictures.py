#!/usr/bin/env python3
"""Draws the curves of `run.py OUT` beside the points of experiments: `python3 docs/validation/pictures.py OUT IMAGES [SIDE_MM]`.

Specimens are 100 mm wide, or SIDE_MM. Needs matplotlib.
"""

import csv
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import run

# Height of the specimens of each published curve, mm.
TESTS = {"kupfer_uniaxial": ("Kupfer et al. 1969, 200 mm", 200.0), "karsan_jirsa_uniaxial": ("Karsan and Jirsa 1969, 82 mm", 82.0)}

# Names of cases in words.
LABELS = {
    "cube-0.1": "cube, friction 0.1",
    "cube-0.6": "cube, friction 0.6",
    "height-100": "cube, friction 0.005",
    "biaxial-1": "1 : 1",
    "biaxial-0.52": "1 : 0.52",
    "fraction-0.0": "mortar",
    **{f"fraction-0.{tenth}": f"packed {10 * tenth} %" for tenth in (2, 4, 6)},
    "tension-72": "tension",
}


def main() -> None:
    """Draw every picture that has curves."""
    out, images = (Path(word) for word in sys.argv[1:3])
    side = float(sys.argv[3]) if len(sys.argv) > 3 else run.SMALL_MM
    done = {case.name: curve for case in run.cases(side) if (curve := run.read(case, out))}
    curves(done, images / "validation-curve.png", ["cube-0.1", "height-100"])
    curves(done, images / "validation-friction.png", ["cube-0.1", "cube-0.6"])
    curves(done, images / "validation-fraction.png", [f"fraction-{share}" for share in ("0.0", "0.2", "0.4", "0.6")])
    curves(done, images / "validation-elements.png", [f"elements-{size}" for size in ("2.4", "2.0", "1.6")])
    curves(done, images / "validation-tension.png", ["tension-72"])
    curves(done, images / "validation-biaxial.png", ["height-100", "biaxial-1", "biaxial-0.52"])
    slender = [f"slenderness-{mu}-h{n}" for mu in ("0.005", "0.6") for n in (1, 2)]
    curves(done, images / "validation-slenderness.png", slender)
    beyond(done, images / "validation-height.png", side)
    bent(done, images / "validation-beams.png")


def curves(done: dict[str, run.Curve], path: Path, names: list[str]) -> None:
    """Stress over strain, one colour a case and one line a seed; uniaxial tests beside compression at low friction."""
    figure, axes = plt.subplots(figsize=(6, 4))
    drawn = False
    for number, name in enumerate(names):
        for seed in (1, 2, 3):
            if curve := done.get(f"{name}-{seed}"):
                label = LABELS.get(name, name) if seed == 1 else None
                axes.plot([1000 * e for e in curve.strain], curve.stress, f"C{number}", lw=1, label=label)
                drawn = True
    if path.stem == "validation-curve":
        for marker, (name, (label, _)) in zip("os", TESTS.items()):
            strain, stress = run.published(name)
            axes.plot([1000 * e for e in strain], stress, f"k{marker}", ms=3, mfc="none", label=label)
    save(figure, axes, path, "strain, per mille", "stress, MPa", drawn=drawn)


def beyond(done: dict[str, run.Curve], path: Path, side: float) -> None:
    """Stress over peak and displacement beyond the peak: prisms of three heights and one width, and tests."""
    figure, axes = plt.subplots(figsize=(6, 4))
    drawn = False
    for number, height in enumerate((50, 100, 200)):
        for seed in (1, 2, 3):
            if curve := done.get(f"height-{height}-{seed}"):
                top = curve.top
                way = [(e - curve.strain[top]) * curve.height for e in curve.strain[top:]]
                label = f"{side:g} mm wide, {side * height / 100:g} mm high" if seed == 1 else None
                axes.plot(way, [s / curve.peak for s in curve.stress[top:]], f"C{number}", lw=1, label=label)
                drawn = True
    for marker, (name, (label, height)) in zip("os", TESTS.items()):
        strain, stress = run.published(name)
        top = max(range(len(stress)), key=stress.__getitem__)
        way = [(e - strain[top]) * height for e in strain[top:]]
        axes.plot(way, [s / stress[top] for s in stress[top:]], f"k{marker}", ms=3, mfc="none", label=label)
    save(figure, axes, path, "displacement beyond the peak, mm", "stress over peak", drawn=drawn)


def bent(done: dict[str, run.Curve], path: Path) -> None:
    """Load over the opening of the mouth of three beams, one line a seed, in the envelopes of the tests."""
    figure, axes = plt.subplots(1, 3, figsize=(12, 3.6))
    drawn = False
    for one, (name, (_, beam)) in zip(axes, run.BEAMS.items()):
        tests = run.envelope(beam.published)
        one.fill_between(tests["cmod_mm"], tests["load_min_n"], tests["load_max_n"], color="0.8", label="tests")
        for seed in (1, 2, 3):
            if curve := done.get(f"beam-{name}-{seed}"):
                one.plot(curve.mouth, curve.load, f"C{seed - 1}", lw=1, label=f"seed {seed}")
                drawn = True
        one.set(title=name, xlim=(0, 0.12), ylim=0, xlabel="opening of the mouth, mm", ylabel="load, N")
        one.grid(alpha=0.3)
    save(figure, axes[0], path, "opening of the mouth, mm", "load, N", drawn=drawn)


def save(figure: plt.Figure, axes: plt.Axes, path: Path, x: str, y: str, *, drawn: bool) -> None:
    """Write a picture that has a curve."""
    axes.set(xlabel=x, ylabel=y)
    axes.grid(alpha=0.3)
    if drawn:
        axes.legend(fontsize=8)
        figure.savefig(path, dpi=110, bbox_inches="tight")
    plt.close(figure)


if __name__ == "__main__":
    main()
