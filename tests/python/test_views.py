"""Pictures, and what is said where the library for them is missing."""

import re
import subprocess
import sys

import numpy as np
import pytest

import mesocrete as mc


def test_counts_have_their_thousands_apart_where_people_read_them_and_only_there(tmp_path):
    packing = mc.pack({"specimen": mc.Specimen.box(60, 60, 120)}, fraction=0.4, seed=1)
    count = f"{len(packing):,}"
    assert re.fullmatch(r"\d,\d{3}", count)
    assert repr(packing).startswith(f"Packing({count} aggregates in a box")
    assert repr(packing.aggregates) == f"<{count} aggregates>"
    assert repr(mc.gjk.Bodies([body.vertices for body in packing.aggregates])) == f"Bodies({count} bodies)"
    assert f"<td>{count}</td>" in packing._repr_html_()
    packing.write(tmp_path / "model.html")
    page = (tmp_path / "model.html").read_text(encoding="utf-8")
    assert f"Packing of {count} aggregates" in page
    counted = [f"{c['aggregates']:,}" for c in packing.report()["classes"]]
    assert all(f"%<td>{number}\n" in page for number in counted)
    packing.write(tmp_path / "model.csv")
    last = (tmp_path / "model.csv").read_text(encoding="utf-8").splitlines()[-1]
    assert last.startswith(f"{len(packing) - 1},")


def test_pyvista_gets_closed_surfaces_with_their_data(packing):
    pytest.importorskip("pyvista")
    surface = packing.to_pyvista()
    assert surface.n_cells == sum(len(a.faces) for a in packing.aggregates)
    assert surface.n_open_edges == 0
    assert set(surface.cell_data.keys()) == {"aggregate", "class", "itz_thickness_mm"}
    first = surface.extract_cells(np.flatnonzero(surface.cell_data["aggregate"] == 0))
    assert first.n_points == len(packing.aggregates[0].vertices)


def test_plot_writes_a_picture_that_is_not_blank(packing, tmp_path):
    pytest.importorskip("pyvista")
    image = pytest.importorskip("matplotlib.image")
    if sys.platform == "linux" and not can_render():
        pytest.skip("VTK cannot render off screen here")
    packing.plot(screenshot=tmp_path / "packing.png")
    pixels = image.imread(tmp_path / "packing.png")
    assert pixels.std() > 0.05


def test_pictures_take_pyvistas_options_and_plotters(packing):
    pyvista = pytest.importorskip("pyvista")
    if sys.platform == "linux" and not can_render():
        pytest.skip("VTK cannot render off screen here")
    pixels = packing.plot(cut="z", itz=True, screenshot=True, window_size=(320, 240), background="black", cpos="xy")
    assert pixels.shape == (240, 320, 3) and (pixels[0, 0] == 0).all()
    plain = packing.plot(color="#ff0000", screenshot=True, window_size=(320, 240))
    assert (plain[..., 0] > plain[..., 1] + 50).any(), "a colour of one's own wins over the classes'"
    mesh = packing.mesh(element_size=5.0, accept_phase_error=True)
    plotter = pyvista.Plotter(shape=(1, 2), off_screen=True)
    assert packing.plot(plotter=plotter, scalars="itz_thickness_mm") is plotter
    plotter.subplot(0, 1)
    assert mesh.plot(cut=("x", 30.0), phases=["aggregate"], plotter=plotter, scalars="aggregate") is plotter
    assert plotter.screenshot(None).std() > 5
    plotter.close()


def can_render():
    """VTK may crash without a display or Mesa: ask in another process."""
    code = "import pyvista as p; q = p.Plotter(off_screen=True); q.add_mesh(p.Cube()); q.screenshot(None)"
    return subprocess.run([sys.executable, "-c", code], capture_output=True, timeout=120).returncode == 0


def test_plot_grading_draws_what_was_asked_and_what_was_reached(packing):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    from matplotlib import pyplot

    ax = packing.plot_grading(ax=pyplot.figure().add_subplot())
    asked, reached, sieved = ax.get_lines()
    assert asked.get_ydata()[0] == reached.get_ydata()[0] == 0.0
    assert [line.get_ydata()[-1] for line in (asked, reached, sieved)] == pytest.approx([100.0] * 3)
    at_limits = np.interp(np.log(reached.get_xdata()), np.log(asked.get_xdata()), asked.get_ydata())
    assert np.abs(at_limits - reached.get_ydata()).max() < 1.0
    assert ax.get_xlabel() == "longest axis, mm" and sieved.get_label() == "by sieve size"
    pyplot.close("all")


@pytest.mark.parametrize(("call", "module", "extra"), [("to_pyvista", "pyvista", "plot"), ("plot_grading", "matplotlib.pyplot", "plot")])
def test_a_missing_library_says_how_to_get_it(packing, monkeypatch, call, module, extra):
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(ImportError, match=rf"pip install 'mesocrete\[{extra}\]'"):
        getattr(packing, call)()


def test_a_cut_shows_grains_in_the_colours_of_the_legend(packing):
    """The case: every grain of a section had the colour that the legend gives to one size class."""
    pytest.importorskip("pyvista")
    if sys.platform == "linux" and not can_render():
        pytest.skip("VTK cannot render off screen here")
    from mesocrete._mesocrete import _colours
    from mesocrete._views import _section

    (low, high), classes = packing.bounds, _colours()[1]
    middle = (low[2] + high[2]) / 2
    body, shown = packing.section("z", middle, px=100, what="grain"), packing.section("z", middle, px=100) != 1
    plane = _section(packing, 2, middle, itz=True, by_class=True, px=100)
    colours = np.asarray(plane.cell_data["colour"]).reshape(*body.shape, 4)
    for number in np.unique(body[(body >= 0) & shown]):
        name = classes[packing.aggregates.size_class[number]]
        assert (colours[(body == number) & shown][:, :3] == list(bytes.fromhex(name[1:]))).all()
    assert len({packing.aggregates.size_class[number] for number in np.unique(body[body >= 0])}) > 1
    for cut in [float("nan"), ("z", float("nan")), ("z", "10 mm"), 10.0, "w", ("z",)]:
        with pytest.raises(ValueError, match="it must be one of 'x', 'y', 'z', or a pair"):
            packing.plot(cut=cut, screenshot=True)


def test_pictures_name_their_colours_and_measure_the_specimen(packing, tmp_path):
    """The case: no legend, no scale, and a mesh was a grey tower without an aggregate."""
    pyvista = pytest.importorskip("pyvista")
    if sys.platform == "linux" and not can_render():
        pytest.skip("VTK cannot render off screen here")
    view = {"screenshot": True, "window_size": (320, 240)}
    mesh = packing.mesh(element_size=5.0, accept_phase_error=True)
    assert (packing.plot(**view) != packing.plot(legend=False, **view)).any()
    whole, cut = (mesh.plot(cut=cut, legend=False, **view) for cut in (None, "y"))
    assert (whole != cut).any() and (mesh.plot(legend=False, **view) == cut).all()
    plotter = pyvista.Plotter(off_screen=True)
    mesh.plot(plotter=plotter, legend=True)
    assert {"legend: mortar", "legend: aggregate"} <= plotter.actors.keys()
    plotter.close()
    packing.screenshot(tmp_path / "a.png", cut="z")
    mesh.screenshot(tmp_path / "b.png", phases=["aggregate"])
    assert all((tmp_path / name).stat().st_size > 1000 for name in ("a.png", "b.png"))
