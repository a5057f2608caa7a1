"""The test itself from Python: arrays, figures, files, and how a long one is stopped."""

import csv
import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import mesocrete as mc

CUBE = {
    "specimen": {"kind": "cube", "side_mm": 24.0},
    "fraction": 0.3,
    "seed": 3,
    "grading": {"d_min_mm": 4.0, "d_max_mm": 10.0},
    "placement": {"min_gap_mm": 0.5},
}
# A test of a moment.
QUICK = {"strain": 0.004, "materials": {"mortar_strength": {"crushing_energy_n_per_mm": 0.5}}}


@pytest.fixture(scope="module")
def mesh():
    return mc.pack(CUBE).mesh(method="lattice", element_size=3.0, itz="smeared", joined="mortar", accept_phase_error=True)


@pytest.fixture(scope="module")
def response(mesh):
    return mesh.solve(friction=0.1, frames=2, control="steady", **QUICK)


# The case: in elements of 3 mm a third of these aggregates is lost, and `solve` gave a strength.
WRONG = {
    "specimen": {"kind": "cube", "side_mm": 30.0},
    "fraction": 0.4,
    "grading": {"d_min_mm": 5.0, "d_max_mm": 10.0},
}


def test_a_wrong_mesh_gets_the_answer_of_the_command(tmp_path):
    packing = mc.pack(WRONG, for_test=True, element_size=3.0)
    packing.write(tmp_path / "model.json")
    command = [sys.executable, "-m", "mesocrete", "solve", "model.json", "-o", "out", "--element-size-mm", "3"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert run.returncode == 1
    said = next(line for line in run.stderr.splitlines() if line.startswith("error: "))
    said = said.removeprefix("error: ").replace("--element-size-mm", "element_size")
    said = said.replace("--accept-phase-error accepts", "accept_phase_error=True accepts")
    with pytest.raises(ValueError, match="where 10 % are accepted") as caught:
        packing.mesh(for_test=True, element_size=3.0)
    assert str(caught.value) == said


def test_an_accepted_mesh_warns_before_the_test_and_marks_its_response():
    mesh = mc.pack(WRONG, for_test=True, element_size=3.0).mesh(for_test=True, element_size=3.0, accept_phase_error=True)
    with pytest.warns(UserWarning, match="mesh too coarse: aggregate -31 %; .* became mortar"):
        response = mesh.solve(strain=0.0002)
    assert ", mesh too coarse: aggregate -31 %," in repr(response)
    assert response.result["flags"] == ["mesh too coarse: aggregate -31 %"]


def test_an_automatic_element_size_keeps_the_phases():
    packing = mc.pack(WRONG, for_test=True, element_size="auto")
    mesh = packing.mesh(for_test=True, element_size="auto")
    volumes = mesh.volumes()
    assert volumes["aggregate"] / 30.0**3 == pytest.approx(0.4, rel=0.05)


def test_the_curve_is_a_dict_of_arrays(response):
    curve, result = response.curve, response.result
    assert {"strain", "stress_mpa", "kinetic", "internal", "external", "friction_work", "hourglass"} <= set(curve)
    assert {len(column) for column in curve.values()} == {len(curve["strain"])}
    assert all(column.dtype == np.float64 and np.isfinite(column).all() for column in curve.values())
    assert (np.diff(curve["strain"]) > 0).all()
    assert curve["stress_mpa"].max() == result["peak_mpa"]
    assert curve["strain"][-1] == pytest.approx(0.004, rel=0.01)
    lost = curve["external"] - curve["internal"] - curve["kinetic"] - curve["friction_work"]
    assert abs(lost).max() < 1e-3 * curve["external"].max()


def test_a_mesh_for_a_test_gives_the_curve_of_the_command(tmp_path):
    packing = mc.pack(CUBE)
    packing.write(tmp_path / "model.json")
    asked = ["--element-size-mm", "3", "--strain", "0.001", "--frames", "1", "--quiet", "--accept-phase-error"]
    command = [sys.executable, "-m", "mesocrete", "solve", "model.json", "-o", "out", *asked]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, timeout=120)
    mesh = packing.mesh(for_test=True, element_size=3.0, accept_phase_error=True)
    mesh.solve(strain=0.001, frames=1).write(tmp_path / "python")
    curves = [(tmp_path / folder / "curve.csv").read_bytes() for folder in ("out", "python")]
    assert curves[0] == curves[1]
    # Options that are given count.
    other = packing.mesh(for_test=True, element_size=3.0, narrow_gaps="keep", accept_phase_error=True)
    assert len(other) < len(mesh)


def test_the_result_has_the_keys_of_the_file(response):
    result = response.result
    assert (result["test"], result["friction"], result["ended"]) == ("compression", 0.1, "completed")
    assert 15 < result["peak_mpa"] < 80
    assert 20_000 < result["modulus_mpa"] < 50_000
    assert [frame["file"] for frame in result["frames"]] == ["frame_0001.vtu", "frame_0002.vtu"]
    assert {phase["name"] for phase in result["phases"]} == {"aggregate", "itz", "mortar"}


def test_frames_hold_the_fields(mesh, response):
    first, second = response.frames
    assert first.strain < second.strain == response.last.strain
    assert second.displacement.shape == mesh.points.shape
    assert second.stress.shape == (len(mesh), 6)
    assert (second.damage >= first.damage - 1e-6).mean() > 0.95
    assert second.damage.max() > 0.5
    assert second.damage[second.phase == 2].max() == 0
    # The mean axial stress of the cells is the plates' own.
    points, cells = mesh.points, mesh.cells
    edges = points[cells[:, 1:]] - points[cells[:, :1]]
    volume = abs(np.linalg.det(edges)) / 6
    mean = -(second.stress[:, 2] * volume).sum() / volume.sum()
    assert mean == pytest.approx(second.stress_mpa, rel=0.05)
    # The upper nodes went down by the strain times the height; those of broken pieces may leave the plate.
    top = points[:, 2] == points[:, 2].max()
    assert -np.median(second.displacement[top, 2]) == pytest.approx(second.strain * 24, rel=0.02)
    assert -second.displacement[top, 2].max() == pytest.approx(second.strain * 24, rel=0.02)


def test_damage_is_at_most_what_its_parts_leave_and_comes_with_cracks(mesh, response):
    assert isinstance(response, mc.Response) and all(isinstance(frame, mc.Frame) for frame in response.frames)
    first, second = response.frames
    assert 0 < first.time_s < second.time_s
    for part in (second.damage_tension, second.damage_compression):
        assert part.shape == second.damage.shape and part.min() >= 0 and part.max() <= 1
    # Cracks that are pressed shut take no stiffness away, so damage may lie below that in tension. Means over patches obey
    # what is linear.
    parts = second.damage_tension + second.damage_compression
    assert (second.damage <= parts + 1e-6).all() and (second.damage >= second.damage_compression - 1e-6).all()
    last = mesh.solve(friction=0.1, frames=1, smoothing="none", **QUICK).last
    left = (1 - last.damage_tension) * (1 - last.damage_compression)
    assert (last.damage <= 1 - left + 1e-6).all() and (last.damage >= last.damage_compression - 1e-6).all()
    opening = second.crack_opening_mm
    assert opening.max() > 0 and (second.damage_tension[opening > 1e-3] > 0).all()


def test_threads_change_nothing(mesh, response):
    for threads in (1, 2):
        again = mesh.solve(friction=0.1, control="steady", threads=threads, **QUICK)
        assert all((again.curve[name] == column).all() for name, column in response.curve.items())
        assert (again.last.damage == response.last.damage).all()


def test_a_device_changes_nothing(mesh, response):
    try:
        again = mesh.solve(friction=0.1, frames=2, control="steady", device="gpu", **QUICK)
    except ValueError as missing:
        pytest.skip(str(missing))
    assert all((again.curve[name] == column).all() for name, column in response.curve.items())


def test_files_are_those_of_the_command(response, tmp_path):
    folder = tmp_path / "out"
    response.write(folder)
    names = ["curve.csv", "frame_0001.vtu", "frame_0002.vtu", "frames.pvd", "result.html", "result.json"]
    assert sorted(path.name for path in folder.iterdir()) == names
    assert json.loads((folder / "result.json").read_text()) == response.result
    with (folder / "curve.csv").open() as file:
        rows = list(csv.DictReader(file))
    for name, column in response.curve.items():
        assert [float(row[name]) for row in rows] == column.tolist()
    with pytest.raises(FileExistsError, match=r"exists; overwrite=True replaces it"):
        response.write(folder, overwrite=False)
    with pytest.raises(FileNotFoundError):
        response.write(tmp_path / "none" / "out")


def test_frames_open_in_pyvista(response, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    response.write(tmp_path)
    reader = pyvista.get_reader(tmp_path / "frames.pvd")
    assert reader.time_values == [frame.strain for frame in response.frames]
    reader.set_active_time_value(reader.time_values[-1])
    read, made = reader.read()[0], response.to_pyvista(-1)
    assert read.n_cells == made.n_cells
    assert set(made.cell_data.keys()) == set(read.cell_data.keys())
    for name in made.cell_data.keys():
        assert (read.cell_data[name] == made.cell_data[name]).all(), name
    assert (read.point_data["displacement_mm"] == made.point_data["displacement_mm"]).all()
    assert (response.to_pyvista().cell_data["damage"] == response.last.damage).all()


def test_frames_open_in_meshio(response, tmp_path):
    meshio = pytest.importorskip("meshio")
    response.write(tmp_path)
    read = meshio.read(tmp_path / "frame_0002.vtu")
    assert (read.cell_data["stress_mpa"][0] == response.last.stress).all()


def test_the_curve_is_plotted(response):
    pytest.importorskip("matplotlib").use("Agg")
    axes = response.plot()
    assert axes.lines[0].get_ydata().max() == response.result["peak_mpa"]
    assert axes.get_legend().get_texts()[0].get_text().startswith("peak ")


def test_tension_pulls(mesh):
    result = mesh.solve("tension").result
    assert result["test"] == "tension"
    assert 1.5 < result["peak_mpa"] < 4


def test_strains_of_tetrahedra_are_smoothed_which_takes_strength_that_the_elements_add(mesh):
    plain, smoothed = mesh.solve(smoothing="none").result, mesh.solve().result
    assert (plain["smoothing"], smoothed["smoothing"]) == ("none", "edges")
    assert 0.6 * plain["peak_mpa"] < smoothed["peak_mpa"] < 0.98 * plain["peak_mpa"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"friction": -1.0}, "friction is -1; it must be 0 to 10"),
        ({"strain": 0.0}, "strain is 0; it must be 1e-12 to 0.1"),
        ({"test": "pulling"}, "test is .pulling.; .*compression"),
        ({"test": "bending"}, "a beam must be longer than 10/9 of its depth"),
        ({"law": "steel"}, "law is .steel.; .*elastic"),
        ({"smoothing": "nodes"}, "smoothing is .nodes.; .*edges"),
        ({"frictoin": 0.1}, "frictoin is not a known key; did you mean friction"),
        ({"materials": {"mortar": {"poisson_ratio": 0.7}}}, "materials.mortar.poisson_ratio is 0.7"),
        ({"threads": 0}, "threads is 0; it must be an int from 1 to 1024"),
        ({"time_step_s": 1.0}, "time_step_s is 1"),
        ({"device": "abacus"}, "abacus.* is no device; take cpu, gpu, cuda:N or opencl:N"),
        ({"device": "cuda:99"}, "there is no device cuda:99; .*or take the device cpu"),
    ],
)
def test_values_that_cannot_be_are_named(mesh, options, message):
    with pytest.raises(ValueError, match=message):
        mesh.solve(**options)


def test_much_added_mass_warns_and_more_is_refused_with_the_step_that_would_do(mesh):
    """The case: a step with forty times the mass gave a curve without a word."""
    heavy = {"strain": 1e-5, "duration_s": 1e-4, "frames": 0}
    response = mesh.solve(time_step_s=1e-6, **heavy)
    assert any("times the mass" in flag for flag in response.result["flags"])
    [told] = [warning for warning in response.result["warnings"] if "times the mass" in warning]
    fits = float(told.split("time_step_s = ")[1].split(",")[0])
    lighter = mesh.solve(time_step_s=fits, **heavy).result
    assert lighter["added_mass_percent"] <= 20 and not any("mass" in flag for flag in lighter["flags"])
    with pytest.raises(ValueError, match=r"time_step_s is .*; it needs \d+ times the mass: inertia would carry this test; take"):
        mesh.solve(time_step_s=1e-5, strain=1e-4, duration_s=0.01)


def test_wrong_types_are_named(mesh):
    with pytest.raises(TypeError, match="friction"):
        mesh.solve(friction="rough")
    with pytest.raises(TypeError, match="progress"):
        mesh.solve(progress=3)


def test_second_order_is_refused():
    mesh = mc.pack(CUBE).mesh(method="lattice", element_size=6.0, itz="none", order=2, accept_phase_error=True)
    with pytest.raises(ValueError, match="second order"):
        mesh.solve()


def test_there_is_no_frame_that_was_not_asked_for(mesh, response):
    for place in (2, -3):
        with pytest.raises(IndexError, match=f"there is no frame {place}; this test has 2"):
            response.to_pyvista(place)


def test_progress_is_told_and_can_stop(mesh):
    told = []

    def progress(strain, target):
        told.append((strain, target))
        return strain < 0.001

    response = mesh.solve(progress=progress, time_step_s=2e-8, **QUICK)
    assert response.result["ended"] == "stopped"
    assert all(target == 0.004 for _, target in told)
    assert 0.0005 < response.curve["strain"][-1] < 0.003
    assert len(response.curve["strain"]) > 10


@pytest.mark.skipif(os.name == "nt", reason="sends POSIX signals")
def test_ctrl_c_ends_the_test_within_half_a_second(mesh):
    sent = []

    def send():
        sent.append(time.process_time())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.7, send)
    timer.start()
    with pytest.raises(KeyboardInterrupt) as stopped:
        mesh.solve(time_step_s=1e-9, threads=1)
    # Of CPU time, which other work on the machine does not take.
    assert time.process_time() - sent[0] < 0.5
    timer.join()
    # The curve so far is kept.
    response = stopped.value.response
    assert response.result["ended"] == "stopped"
    assert np.isfinite(response.curve["stress_mpa"]).all()
    # Nothing goes on behind our back.
    time.sleep(0.3)
    before = time.process_time()
    time.sleep(0.3)
    assert time.process_time() - before < 0.1


def test_frames_are_pickled_with_their_fields(response):
    for frame in (*response.frames, response.last):
        again = pickle.loads(pickle.dumps(frame))
        assert (again.strain, again.stress_mpa, again.time_s) == (frame.strain, frame.stress_mpa, frame.time_s)
        cells = ("damage", "damage_tension", "damage_compression", "crack_opening_mm", "stiffness_left", "phase")
        for name in ("displacement", "stress", "crack_strain", *cells):
            assert np.array_equal(getattr(again, name), getattr(frame, name)), name


def test_notebooks_show_a_response_with_its_curve(response):
    shown = response._repr_html_()
    assert "<polyline points='" in shown and f"{response.result['peak_mpa']:.2f} MPa" in shown


def files(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("extra", [{}, {"gauges": [{"kind": "lateral-strain", "name": "wide"}]}])
def test_a_response_is_pickled_with_all_that_it_writes(mesh, response, extra, tmp_path):
    """The case: studies on other machines could hand their results back as files only."""
    if extra:
        response = mesh.solve(strain=0.0005, frames=1, **extra)
    again = pickle.loads(pickle.dumps(response))
    assert repr(again) == repr(response) and again.result == response.result
    assert list(again.curve) == list(response.curve)
    for name, column in response.curve.items():
        assert np.array_equal(again.curve[name], column), name
    assert len(again.frames) == len(response.frames)
    for name in ("displacement", "stress", "damage"):
        assert np.array_equal(getattr(again.last, name), getattr(response.last, name))
    response.write(tmp_path / "first")
    again.write(tmp_path / "again")
    assert files(tmp_path / "first") == files(tmp_path / "again")


def test_damaged_pickles_of_a_response_are_refused(response):
    """Values that do not fit each other must not reach the page or the curve."""
    restore, contents = response.__reduce__()
    short = contents[2][:-11]
    wrong = {2: short[:0], 3: np.ones(1), 4: "{}", 7: ("{}", "nonsense")}
    for place, value in wrong.items():
        changed = [*contents]
        changed[place] = value
        if place == 2:
            changed[3] = np.ones(3)
        with pytest.raises(ValueError, match="the pickle is damaged"):
            restore(*changed)
    frame = (contents[5][0][0], [values[:-1] for values in contents[5][0][1]])
    with pytest.raises(ValueError, match="its fields do not fit its mesh"):
        restore(*contents[:5], [frame], *contents[6:])


def test_materials_of_a_concrete_and_of_its_mortar_are_those_of_a_test():
    concrete = mc.Materials.for_concrete(38, rock="basalt")
    assert concrete["aggregate"]["youngs_modulus_mpa"] == 73_000.0
    softer = mc.Materials.for_concrete(38, rock="sandstone", fraction=0.3)
    assert softer["mortar"]["youngs_modulus_mpa"] < concrete["mortar"]["youngs_modulus_mpa"]
    mortar = mc.Materials.for_mortar(40)
    assert mortar["mortar_strength"]["compressive_mpa"] == pytest.approx(40)
    with pytest.raises(ValueError, match="fcm is 5; it must be 20 to 128"):
        mc.Materials.for_concrete(5)
    with pytest.raises(ValueError, match="rock"):
        mc.Materials.for_concrete(38, rock="cheese")


def test_strengths_that_scatter_are_a_field_of_frames_and_of_their_pickles(mesh):
    scatter = {"coefficient_of_variation": 0.2, "correlation_length_mm": 20.0}
    response = mesh.solve(strain=0.001, frames=1, materials={"scatter": scatter})
    frame = response.frames[0]
    grains = frame.phase == 2
    assert (frame.strength_factor[grains] == 1).all()
    assert 0.02 < frame.strength_factor[~grains].std() < 0.4
    assert (pickle.loads(pickle.dumps(response)).frames[0].strength_factor == frame.strength_factor).all()
    assert (mesh.solve(strain=0.001, frames=1).frames[0].strength_factor == 1).all()
    with pytest.raises(ValueError, match="scatter.correlation_length_mm is 0.1; with elements of"):
        mesh.solve(strain=0.001, materials={"scatter": scatter | {"correlation_length_mm": 0.1}})


def test_materials_of_a_concrete_solve(mesh):
    response = mesh.solve(strain=0.002, materials=mc.Materials.for_concrete(38))
    assert response.result["peak_mpa"] > 10
    assert response.result["broken_stone"] is None
    weak = {"tensile_mpa": 0.4, "compressive_mpa": 5.0, "peak_strain": 0.003, "crushing_energy_n_per_mm": 0.5}
    broken = mesh.solve(strain=0.006, materials={"aggregate_strength": weak}).result
    assert broken["broken_stone"] is not None
    assert broken["energy_beyond_peak_until"] >= 0.2


def test_named_tests_are_keywords_of_solve(mesh):
    made = [
        mc.Test.compression(0.005),
        mc.Test.tension(),
        mc.Test.triaxial(5.0),
        mc.Test.biaxial(0.5),
        mc.Test.cyclic([(0.001, "strain"), (0.0005, "strain")]),
        mc.Test.splitting(),
        mc.Test.bending(),
        mc.Test.four_point(),
        mc.Test.shear(),
        mc.Test.expansion(mortar=-1e-4),
        mc.Test.hopkinson(),
        mc.Test.hopkinson_splitting(),
        mc.Test.spall(),
        mc.Test.drop(),
        mc.Test.impact(),
    ]
    names = ["compression", "tension", "triaxial", "biaxial", "cyclic", "splitting", "bending", "four-point", "shear", "expansion"]
    names += ["hopkinson", "hopkinson-splitting", "spall", "drop", "impact"]
    assert [test["test"] for test in made] == names
    pressed = mesh.solve(**mc.Test.triaxial(5.0, strain=0.001))
    assert pressed.result["test"] == "triaxial" and pressed.result["peak_mpa"] > 5.0


def test_a_named_test_is_the_argument_of_solve_and_its_words_and_values_are_checked_at_once(mesh):
    quick = {"duration_s": 1e-5, "strain": 1e-5}
    pressed = mesh.solve(test=mc.Test.triaxial(pressure_mpa=4.0, strain=0.1), **quick).result
    assert (pressed["test"], pressed["pressure_mpa"], pressed["friction"]) == ("triaxial", 4.0, 0.1)
    assert [support["name"] for support in pressed["supports"]] == ["bottom", "top", "mantle"]
    # The case: these gave a dict.
    with pytest.raises(ValueError, match="pressure is not a known key; did you mean pressure_mpa"):
        mc.Test.triaxial(pressure=10.0)
    with pytest.raises(ValueError, match="strian"):
        mc.Test.cyclic([(0.001, "strian")])
    with pytest.raises(ValueError, match="pressure_mpa is -101; it must be -100 to 1000"):
        mc.Test.triaxial(-101.0)
    with pytest.raises(TypeError):
        mesh.solve(test=3)


def test_the_kind_of_a_test_file_names_the_test_and_a_test_named_twice_is_refused(mesh, tmp_path):
    # The case: `kind` was dropped, and each of these was compression.
    quick = {"duration_s": 1e-5, "strain": 1e-5}
    asked = [((), {"kind": "tension"}), (({"kind": "tension"},), {}), (({"kind": "tension", "test": None},), {})]
    assert [mesh.solve(*given, **words, **quick).result["test"] for given, words in asked] == ["tension"] * 3
    assert mesh.solve(kind=None, **quick).result["test"] == "compression"
    decks = [tmp_path / name for name in ("kind.inp", "test.inp", "usual.inp")]
    for path, test in zip(decks, ({"kind": "tension"}, "tension", "compression"), strict=True):
        mesh.write(path, test=test)
    by_kind, by_name, usual = (path.read_bytes() for path in decks)
    assert by_kind == by_name != usual
    twice = "test and kind are two words for one thing; leave one of them out"
    for given, words in [(("tension",), {"kind": "tension"}), (({"test": "tension", "kind": "shear"},), {})]:
        with pytest.raises(ValueError, match=twice):
            mesh.solve(*given, **words)
    with pytest.raises(ValueError, match=twice):
        mc.Test.tension(kind="compression")
    with pytest.raises(ValueError, match='^kind is "shaer"; it must be one of "compression"'):
        mesh.solve(kind="shaer")
    for words, begin in [({"test": "shear"}, "test is shear"), ({"kind": "shear"}, "kind is shear")]:
        with pytest.raises(ValueError, match=f"^{begin}; the specimen has no two notches"):
            mesh.solve(**words)
    with pytest.raises(ValueError, match="^element_size and element_size_mm are two words for one thing"):
        mc.pack({"specimen": mc.Specimen.cube(20)}, fraction=0.05).mesh(element_size=5, element_size_mm=2)


def test_a_free_expansion_has_strains_and_no_strength(mesh):
    """The case: the title said "0.00 MPa at a strain of 0.00000", and no figure was a strain."""
    swollen = mesh.solve(test=mc.Test.expansion(aggregate=1e-4, mortar=1e-4, itz=1e-4))
    strains = swollen.result["strains_at_end"]
    assert set(strains) == {"strain_x", "strain_y", "strain_z"}
    assert all(abs(strain / 1e-4 - 1) < 0.02 for strain in strains.values()), strains
    assert repr(swollen).startswith("Response(mean strain_x ")
    assert "MPa" not in repr(swollen)


def test_a_course_comes_from_a_table_and_phases_below_a_layer_have_their_own(mesh, tmp_path, monkeypatch):
    """The case: mortar could not shrink in a layer while the aggregates grew in the whole specimen."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "drying.csv").write_text("time;strain\n0;0\n28;-0,0002\n")
    dried = mesh.solve(test=mc.Test.expansion("drying.csv", 1e-4, layer_mm=4.0, below={"aggregate": 1e-4}), law="elastic").result
    assert dried["expansion"]["mortar"] == [[28.0, -2e-4]] and dried["expansion"]["below"]["aggregate"] == 1e-4
    whole = mesh.solve(test=mc.Test.expansion(0.0, 1e-4), law="elastic").result
    assert dried["strains_at_end"]["strain_z"] < whole["strains_at_end"]["strain_z"] - 3e-5
    (tmp_path / "drying.csv").write_text("time,strain\n28,-300\n")
    with pytest.raises(ValueError, match=r"expansion.mortar is drying.csv; its line 2 has -300 in the column strain; it must be"):
        mc.Test.expansion("drying.csv")
    with pytest.raises(ValueError, match=r"expansion.aggregate is none.csv; none.csv: "):
        mc.Test.expansion(0.0, "none.csv")
    with pytest.raises(ValueError, match="expansion.below is 0; strains lie below a layer only with layer_mm"):
        mc.Test.expansion(below={"aggregate": 0.0})


def test_a_test_that_is_not_quasi_static_warns_and_has_a_flag(mesh):
    """The case: 46 % of kinetic energy were no word in Python."""
    with pytest.warns(UserWarning, match="not quasi-static before its peak"):
        fast = mesh.solve(duration_s=2e-5)
    assert any(flag.startswith("not quasi-static (") for flag in fast.result["flags"])
    assert "not quasi-static (" in repr(fast)


KINDS = ["compression", "tension", "triaxial", "biaxial", "cyclic", "splitting", "bending", "four-point", "shear", "expansion"]
KINDS += ["hopkinson", "hopkinson-splitting", "spall", "drop", "impact"]


@pytest.fixture(scope="module")
def bodies():
    """Return coarse meshes: a cube, beams, and a prism with two notches."""
    prism = {"kind": "notched-prism", "width_mm": 9.0, "notch_depth_mm": 3.0, "notch_width_mm": 3.0}
    specimens = {
        "cube": {"kind": "cube", "side_mm": 15.0},
        "bending": prism | {"length_mm": 36.0, "depth_mm": 12.0},
        "four-point": {"kind": "prism", "width_mm": 9.0, "length_mm": 36.0, "depth_mm": 12.0},
        "shear": prism | {"length_mm": 24.0, "depth_mm": 24.0, "upper_notch_depth_mm": 3.0},
    }
    options = {"method": "lattice", "element_size": 3.0, "itz": "none", "joined": "mortar", "accept_phase_error": True}
    grading = {"d_min_mm": 6.0, "d_max_mm": 8.0}
    packed = {name: mc.pack({"specimen": specimen, "fraction": 0.1, "grading": grading}) for name, specimen in specimens.items()}
    return {name: packing.mesh(**options) for name, packing in packed.items()}


@pytest.mark.skipif(os.name == "nt", reason="sends POSIX signals")
@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("kind", KINDS)
def test_ctrl_c_keeps_the_curve_and_the_page_of_a_test_of_every_kind(bodies, kind, tmp_path):
    """The case: no test but compression was stopped from Python."""
    told = []

    def progress(*state):
        told.append(state)
        if len(told) == 3:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt) as stopped:
        bodies.get(kind, bodies["cube"]).solve(test=kind, progress=progress, time_step_s=2e-9)
    response = stopped.value.response
    result = response.result
    assert (result["test"], result["ended"]) == (kind, "stopped") and result["steps"] < result["steps_planned"]
    assert all(np.isfinite(column).all() for column in response.curve.values())
    assert set(result.get("columns", [])) < set(response.curve)
    response.write(tmp_path)
    assert (tmp_path / "result.html").read_text(encoding="utf-8").endswith("</html>\n")


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("kind", KINDS)
def test_the_page_of_a_test_of_every_kind_draws_its_gauges(bodies, kind, tmp_path):
    response = bodies.get(kind, bodies["cube"]).solve(test=kind, duration_s=1e-4, frames=1)
    assert response.result["ended"] == "completed"
    response.write(tmp_path)
    page = (tmp_path / "result.html").read_text(encoding="utf-8")
    assert f"<h1>{kind.capitalize()}" in page and 'type="range"' in page
    columns = response.result.get("columns", [])
    assert bool(columns) == (kind not in ("compression", "tension"))
    assert all(column in page for column in columns), columns
