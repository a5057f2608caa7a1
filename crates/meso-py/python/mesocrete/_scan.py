"""Grey images as a CT scanner records them: partial volume, blur, noise and rings over the exact geometry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._mesocrete import Packing

# Grey values from 0 to 1, in the order of attenuation of limestone concrete: air, porous ITZ, mortar, aggregate, steel.
_GREY = {"outside": 0.02, "void": 0.05, "itz": 0.38, "mortar": 0.45, "aggregate": 0.65, "fibre": 1.0}
_LABELS = {"mortar": 0, "itz": 1, "aggregate": 2, "void": 3, "fibre": 4, "outside": 255}
# Specimens that fill their bounding box.
_FULL = ("cube", "box", "prism")
_OPTIONS = ("blur", "noise", "rings", "partial_volume", "grey")


def scan(
    packing: Packing,
    h: float | None = None,
    *,
    shape: int | Sequence[int] | None = None,
    seed: int = 0,
    blur: float = 0.7,
    noise: float = 0.04,
    rings: float = 0.02,
    partial_volume: bool = True,
    grey: Mapping[str, float] | None = None,
) -> NDArray[np.uint8]:
    """Return a packing as a CT scanner would record it.

    Parameters
    ----------
    packing : Packing
        What is scanned.
    h, shape
        Edge of a voxel, mm, or number of voxels, as for `Packing.voxelize`.
    seed : int
        Seed of noise and rings.
    blur : float
        Standard deviation of a Gaussian blur, voxels; 0 for none. It needs scipy.
    noise : float
        Standard deviation of white noise, as a share of the grey range.
    rings : float
        Standard deviation of the rings about the z axis, one for each radius and layer, as a share of the grey range.
    partial_volume : bool
        Whether a voxel mixes the grey values of its phases by their exact shares of its volume. Without, its centre decides.
    grey : dict, optional
        Grey values from 0 to 1 of "outside", "void", "itz", "mortar", "aggregate" and "fibre", for those that differ from
        the default.

    Returns
    -------
    ndarray, shape (nz, ny, nx), uint8

    Raises
    ------
    ValueError
        Names the option, its value and the accepted range.
    ImportError
        Where `blur` needs scipy, which is not installed.
    """
    values = _checked(grey, blur=blur, noise=noise, rings=rings)
    size = {"h": h} if shape is None else {"shape": shape}
    image = _mixed(packing, values, size) if partial_volume else _plain(packing, values, size)
    if blur > 0:
        image = _blurred(image, blur)
    random = np.random.default_rng(seed)
    if noise > 0:
        image += np.float32(noise) * random.standard_normal(image.shape, dtype=np.float32)
    if rings > 0:
        image += _rings(image.shape, rings, random)
    return np.rint(255 * np.clip(image, 0, 1)).astype(np.uint8)


def checked_options(options: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the keywords of `scan` that a data set passes on; raises for others, and for values out of range."""
    given = dict(options or {})
    wrong = sorted(set(given) - set(_OPTIONS))
    if wrong:
        message = f"scan has {wrong[0]!r}; it must be one of {', '.join(_OPTIONS)}"
        raise ValueError(message)
    _checked(given.get("grey"), **{name: given[name] for name in ("blur", "noise", "rings") if name in given})
    return given


def _checked(grey: Mapping[str, float] | None, **widths: float) -> dict[str, float]:
    """Return all grey values; raises ValueError for values out of range."""
    for name, width in widths.items():
        if not 0 <= width < (100 if name == "blur" else 1):
            message = f"{name} is {width}; it must be 0 or more, and below {100 if name == 'blur' else 1}"
            raise ValueError(message)
    values = {**_GREY, **(grey or {})}
    for name, value in values.items():
        if name not in _GREY:
            message = f"grey has {name!r}; it must be one of {', '.join(_GREY)}"
            raise ValueError(message)
        if not 0 <= value <= 1:
            message = f"grey[{name!r}] is {value}; it must lie within 0 and 1"
            raise ValueError(message)
    return values


def _plain(packing: Packing, values: Mapping[str, float], size: Mapping[str, Any]) -> NDArray[np.float32]:
    """Return the grey value of the phase at each centre."""
    table = np.zeros(256, dtype=np.float32)
    for name, label in _LABELS.items():
        table[label] = values[name]
    image: NDArray[np.float32] = table[packing.voxelize(what="phase", **size)]
    return image


def _mixed(packing: Packing, values: Mapping[str, float], size: Mapping[str, Any]) -> NDArray[np.float32]:
    """Return the mean grey value of each voxel, by the exact shares of the phases."""
    mortar = values["mortar"]
    image: NDArray[np.float32] = packing.voxelize(what="share", of="core", **size)
    image *= np.float32(values["aggregate"] - mortar)
    kinds: list[Any] = ["itz", *sorted({body.phase for body in packing.inclusions})]
    for kind in kinds:
        image += np.float32(values[kind] - mortar) * packing.voxelize(what="share", of=kind, **size)
    image += np.float32(mortar)
    if packing.spec.specimen["kind"] not in _FULL:
        image[packing.voxelize(what="phase", **size) == _LABELS["outside"]] = values["outside"]
    return image


def _blurred(image: NDArray[np.float32], width: float) -> NDArray[np.float32]:
    try:
        from scipy import ndimage  # type: ignore[import-not-found, import-untyped, unused-ignore]
    except ImportError as error:
        message = "blur needs scipy, which is not installed; get it with: pip install scipy, or take blur=0"
        raise ImportError(message) from error
    blurred: NDArray[np.float32] = ndimage.gaussian_filter(image, width, mode="nearest", truncate=3.0)
    return blurred


def _rings(shape: Sequence[int], width: float, random: np.random.Generator) -> NDArray[np.float32]:
    """Return an offset for each radius and layer: each pixel of the detector has a gain of its own."""
    layers, rows, columns = shape
    y, x = np.ogrid[:rows, :columns]
    radius = np.hypot(y - (rows - 1) / 2, x - (columns - 1) / 2).astype(np.intp)
    offsets = np.float32(width) * random.standard_normal((layers, int(radius.max()) + 1), dtype=np.float32)
    rings: NDArray[np.float32] = offsets[:, radius]
    return rings
