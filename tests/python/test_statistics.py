"""The shape statistics against the same figures computed here, from vertices and triangles alone."""

import numpy as np
import pytest

import mesocrete as mc


def solid(aggregate):
    """Volume, area and inertia about the centroid, by tetrahedra from the mean of the vertices to every triangle."""
    points = aggregate.vertices - aggregate.vertices.mean(axis=0)
    a, b, c = (points[aggregate.triangles[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    volumes = np.einsum("ij,ij->i", a, cross) / 6
    volume = volumes.sum()
    centroid = ((a + b + c) / 4 * volumes[:, None]).sum(axis=0) / volume
    # Second moments by the rule of four points, exact for polynomials of the second degree.
    near, far = (5 - 5**0.5) / 20, (5 + 3 * 5**0.5) / 20
    moments = np.zeros((3, 3))
    for weights in [(near, near, near), (far, near, near), (near, far, near), (near, near, far)]:
        at = sum(w * p for w, p in zip(weights, (a, b, c))) - centroid
        moments += np.einsum("i,ij,ik->jk", volumes / 4, at, at)
    inertia = np.trace(moments) * np.eye(3) - moments
    return volume, np.linalg.norm(cross, axis=1).sum() / 2, inertia


def extents(aggregate, inertia):
    """Edges of the box along the principal axes, the longest first."""
    along = aggregate.vertices @ np.linalg.eigh(inertia)[1]
    return np.sort(np.ptp(along, axis=0))[::-1]


@pytest.fixture(scope="module", params=[{}, {"kind": "crushed"}], ids=["paper", "crushed"])
def packed(request):
    return mc.pack({"specimen": {"kind": "cube", "side_mm": 70.0}, "shape": request.param}, fraction=0.35, seed=3)


def test_shapes_and_zingg_counts_are_those_of_numpy(packed):
    shapes = packed.statistics(lines=64, points=64)["shapes"]
    bodies = [(aggregate, *solid(aggregate)) for aggregate in packed.aggregates]
    a, b, c = np.array([extents(aggregate, inertia) for aggregate, _, _, inertia in bodies]).T
    volume, area = np.array([[volume, area] for _, volume, area, _ in bodies]).T
    expected = {
        "length_mm": a,
        "elongation": b / a,
        "flatness": c / b,
        "wadell_sphericity": np.pi ** (1 / 3) * (6 * volume) ** (2 / 3) / area,
        "krumbein_sphericity": (b * c / a**2) ** (1 / 3),
        "convexity": np.ones(len(a)),
    }
    for name, values in expected.items():
        found = shapes[name]
        assert found["mean"] == pytest.approx(values.mean(), rel=1e-9), name
        assert found["sd"] == pytest.approx(values.std(), rel=1e-7), name
        assert [found["min"], found["max"]] == pytest.approx([values.min(), values.max()], rel=1e-9), name
        assert found["median"] == pytest.approx(np.median(values), rel=0.01), name
    long, flat = b / a <= 2 / 3, c / b <= 2 / 3
    counts = {"equant": ~long & ~flat, "disc": ~long & flat, "rod": long & ~flat, "blade": long & flat}
    assert {name: int(there.sum()) for name, there in counts.items()} == shapes["zingg"]
    assert min(shapes["zingg"].values()) > 5
    # No aggregate so near a limit that rounding would have a say.
    assert min(np.abs(b / a - 2 / 3).min(), np.abs(c / b - 2 / 3).min()) > 1e-9


def test_orientation_is_the_mean_of_the_longest_axes(packed):
    axes = [np.linalg.eigh(solid(aggregate)[2])[1][:, 0] for aggregate in packed.aggregates]
    tensor = np.mean([np.outer(axis, axis) for axis in axes], axis=0)
    found = packed.statistics(lines=64, points=64)["orientation"]
    assert np.allclose(found["tensor"], tensor, atol=1e-9)
    assert found["eigenvalues"] == pytest.approx(np.linalg.eigvalsh(tensor), abs=1e-9)
