"""Tables, arrays of properties, equal reports, and what a notebook shows."""

import csv
import sys
import xml.etree.ElementTree

import numpy as np
import pytest

import mesocrete as mc


def test_a_table_has_the_columns_and_values_of_the_csv(packing, tmp_path):
    """One row per body, number by number as in the file."""
    packing.write(tmp_path / "grains.csv")
    with (tmp_path / "grains.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    table = packing.table()
    assert set(rows[0]) | {"sieve_size_mm"} == set(table)
    assert {len(column) for column in table.values()} == {len(packing)}
    for name in set(rows[0]) - {"phase"}:
        assert np.allclose([float(row[name]) for row in rows], table[name], rtol=1e-14, atol=0), name
    assert list(table["phase"]) == [row["phase"] for row in rows]
    assert table["id"].dtype == np.int64 and table["volume_mm3"].dtype == np.float64


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_a_word_makes_a_frame_of_the_table(packing, library):
    """The columns, their order, values and kinds are those of the arrays."""
    module = pytest.importorskip(library)
    frame, table = packing.table(library), packing.table()
    assert isinstance(frame, module.DataFrame)
    assert list(frame.columns) == list(table) and frame.shape == (len(packing), len(table))
    for name, column in table.items():
        assert np.array_equal(frame[name].to_numpy().astype(column.dtype), column), name
        kind = str(frame[name].dtype).lower()
        assert kind == str(column.dtype) or (name == "phase" and kind.startswith(("str", "object"))), f"{name} is {kind}"
    assert packing.table(frame=library).equals(frame)


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_the_curve_of_a_test_is_a_frame_by_a_word(library):
    """It has the columns of `curve`."""
    module = pytest.importorskip(library)
    small = mc.pack({"specimen": {"kind": "cube", "side_mm": 20.0}, "fraction": 0.1}, seed=1)
    response = small.mesh(element_size=4.0, itz="none", accept_phase_error=True).solve(strain=0.0005)
    frame, curve = response.table(library), response.curve
    assert isinstance(frame, module.DataFrame) and list(frame.columns) == list(curve) == list(response.table())
    assert np.array_equal(frame["stress_mpa"].to_numpy(), curve["stress_mpa"]) and len(frame) > 10


def test_a_frame_that_cannot_be_had_is_refused_with_the_way_out(packing, monkeypatch):
    """Of a library that is missing, of a name that is none, and of a type that is no name."""
    for library in ("pandas", "polars", "xarray"):
        monkeypatch.setitem(sys.modules, library, None)
        with pytest.raises(ImportError, match=f"{library} is not installed; get it with: pip install {library}"):
            packing.table(library)
    with pytest.raises(ValueError, match='frame is "panda"; it must be "pandas", "polars", "xarray" or None'):
        packing.table("panda")
    with pytest.raises(TypeError, match="frame is of type bool; it must be"):
        packing.table(True)


def test_arrays_of_all_aggregates_are_those_of_each(packing):
    """No loop is needed."""
    aggregates = packing.aggregates
    for name in ("volume", "area", "size", "sieve_size", "itz_thickness", "size_class", "centroid"):
        values = getattr(aggregates, name)
        assert np.array_equal(values, np.array([getattr(a, name) for a in aggregates])), name
    assert aggregates.centroid.shape == (len(packing), 3)
    assert np.allclose(aggregates[0].centroid, aggregates[0].body.centroid)
    # A square hole passes nothing wider than the longest axis.
    assert (aggregates.sieve_size < aggregates.size).all()


def test_reports_of_equal_runs_are_equal(packing, small_spec):
    """Wall times are apart, under `work`."""
    again = mc.pack(small_spec, seed=7)
    assert again.report() == packing.report()
    assert again.work["seconds"].keys() == packing.work["seconds"].keys()


def test_a_notebook_gets_a_picture_and_the_figures(packing):
    """The HTML holds a section and the most important numbers."""
    html = packing._repr_html_()
    assert "data:image/svg+xml;base64," in html and f"{packing.fraction:.4f}" in html
    assert xml.etree.ElementTree.fromstring(packing._section_svg(2, 30.0)).tag.endswith("svg")
    assert f"{packing.fraction:.4f}," in repr(packing) and len(repr(packing)) < 80
    assert len(repr(packing.aggregates[0])) < 90


def test_plots_of_cuts_and_meshes_are_pictures(packing, tmp_path):
    """A cut, the ITZ and a mesh are drawn off screen."""
    pyvista = pytest.importorskip("pyvista")
    packing.plot(cut="z", itz=True, screenshot=tmp_path / "cut.png")
    packing.plot(cut=("x", 20.0), screenshot=tmp_path / "half.png")
    packing.plot(itz=True, screenshot=tmp_path / "cores.png")
    mesh = packing.mesh(element_size=3.0)
    mesh.plot(cut="y", screenshot=tmp_path / "mesh.png")
    assert mesh.plot(cut=("y", 29.5), plotter=pyvista.Plotter(off_screen=True)).bounds[3] == pytest.approx(29.5), "a cut is smooth"
    mesh.plot(phases=["aggregate"], screenshot=tmp_path / "aggregate.png")
    assert all((tmp_path / f"{name}.png").stat().st_size > 5000 for name in ("cut", "half", "cores", "mesh", "aggregate"))
    with pytest.raises(ValueError, match="cut is 'w'; it must be one of"):
        packing.plot(cut="w", screenshot=tmp_path / "w.png")
    with pytest.raises(ValueError, match="phases holds 'sand'; it may hold"):
        mesh.plot(phases=["sand"], screenshot=tmp_path / "w.png")


def test_the_default_mesh_has_the_phases_that_it_can_show(packing):
    """Voxels of 2 mm have no shell of a tenth; every phase is within 1 % of the exact one."""
    mesh = packing.mesh(element_size=2.0)
    assert set(np.unique(mesh.phase)) == {0, 2}
    assert mesh == packing.mesh(element_size=2.0, itz="none") == packing.mesh(element_size=2.0, itz=None)
    share = mesh.volumes()["aggregate"] / 60.0**3
    assert share == pytest.approx(packing.fraction, rel=0.01)


@pytest.mark.parametrize("subsamples", [2, 3, 5])
def test_subsamples_keep_the_volumes(packing, subsamples):
    """Sub-samples do not shrink the grains, as a majority would."""
    mesh = packing.mesh(element_size=2.0, itz="none", subsamples=subsamples)
    assert mesh.volumes()["aggregate"] / 60.0**3 == pytest.approx(packing.fraction, rel=6e-3)


def test_progress_never_falls_and_names_its_stages(small_spec):
    """`done` rises from stage to stage; most calls are above 0."""
    seen = []

    def progress(done, total, stage):
        seen.append((done / total, stage))

    packing = mc.pack(small_spec, fraction=0.6, progress=progress)
    shares = [share for share, _ in seen]
    assert shares == sorted(shares) and shares[-1] == pytest.approx(1.0)
    order = list(dict.fromkeys(stage for _, stage in seen))
    assert order == [stage for stage in ("take", "place", "prove") if stage in order]
    meshed, measured = [], []
    packing.mesh(method="lattice", element_size=4.0, accept_phase_error=True, progress=lambda done, total: meshed.append(done / total))
    packing.statistics(progress=lambda done, total: measured.append(done / total))
    for calls in (meshed, measured):
        assert calls == sorted(calls) and 0.0 < calls[-1] <= 1.0


def test_progress_true_draws_one_line_of_the_terminals_width(monkeypatch, capsys):
    """At 40 columns no line is longer; what is not a terminal gets no control characters."""
    from mesocrete import _progress

    bar = _progress.Bar()
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    monkeypatch.setenv("COLUMNS", "40")
    bar._drawn = -100.0
    bar(0.3, 0.6, "place")
    text = capsys.readouterr().err
    assert text.startswith("\r") and "50 %" in text and len(text) <= 40
    monkeypatch.setattr(sys.stderr, "isatty", lambda: False, raising=False)
    bar._drawn = -100.0
    bar(0.6, 0.6, "prove")
    assert capsys.readouterr().err.startswith("prove: 100 % after")
    packing = mc.pack({"specimen": {"kind": "cube", "side_mm": 30}, "fraction": 0.2}, progress=True)
    assert len(packing) > 0
