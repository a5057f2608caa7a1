"""TEST.toml files with and without contradictions, for `border.py contradictions`.

The judge is a small set of rules of its own, from docs/tests.md: what of a file contradicts itself, and whom the refusal has to name.
Each file is tested on a cube of 24 mm in voxels of 6 mm, whose rows of nodes lie at -12, -6, 0, 6 and 12 mm.
"""

import itertools
import json

import numpy as np

SIDES = [f"{axis}-{end}" for axis in "xyz" for end in ("min", "max")]
NAMES = ["alder", "birch", "cedar", "dogwood", "elm", "fir", "ginkgo"]
# Strips of 9 mm: their places, and their rows of nodes.
STRIPS = {-9.5: {-12, -6}, 0.0: {0}, 9.5: {6, 12}}
ROWS = {-12, -6, 0, 6, 12}
SPEC = """seed = 1
fraction = 0.05
specimen = { kind = "cube", side_mm = 24 }
grading = { d_min_mm = 8, d_max_mm = 9 }
itz = { thickness_mm = [0, 0] }
"""


def sides_of(support):
    return {side for side in SIDES if side[0] != "z"} if support["on"] == "mantle" else {support["on"]}


def nodes_of(support, side):
    """The grid points of a side that a support meets."""
    rows = {axis: ROWS for axis in "xyz"}
    rows[side[0]] = {-12 if side.endswith("min") else 12}
    if "strip" in support:
        rows[support["strip"]["axis"]] = rows[support["strip"]["axis"]] & STRIPS[support["strip"]["at_mm"]]
    return set(itertools.product(rows["x"], rows["y"], rows["z"]))


def is_servo(support):
    return support["rule"] == "plate" and (support.get("pressure_mpa", 0) != 0 or support.get("stress_ratio", 0) != 0)


def places(support):
    """The displacement that a support gives its nodes, by axis; a servo's is its own."""
    if support["rule"] == "pressure":
        return {}
    own, way = support["on"][0], support.get("moves", 0)
    given = {axis: 0 for axis in "xyz"} if support["rule"] == "glued" else {}
    return {**given, own: support["name"] if is_servo(support) else way}


def pair_contradicts(a, b):
    """Two supports contradict on a common side, or where a glued edge is moved by the other. Pressures hold no node: two of
    them add up, and a plate leaves one nothing only if it covers the whole side."""
    common, pressures = sides_of(a) & sides_of(b), [s for s in (a, b) if s["rule"] == "pressure"]
    if pressures:
        return bool(common) and len(pressures) == 1 and not ("strip" in a or "strip" in b)
    if common:
        return any(nodes_of(a, side) & nodes_of(b, side) for side in common)
    if "glued" not in (a["rule"], b["rule"]):
        return False
    shared = nodes_of(a, a["on"]) & nodes_of(b, b["on"])
    of_a, of_b = places(a), places(b)
    return bool(shared) and any(of_a[axis] != of_b[axis] for axis in of_a.keys() & of_b.keys())


def contradictions(test):
    """Whom a refusal has to name, one set of words for each contradiction."""
    supports = test.get("supports", [])
    for a, b in itertools.combinations(supports, 2):
        if a["name"] == b["name"]:
            yield {a["name"]}
        elif pair_contradicts(a, b):
            yield {a["name"], b["name"]}
    for s in supports:
        if s.get("friction", 0) != 0 and s["rule"] != "plate":
            yield {"friction", s["name"]}
        if s.get("moves", 0) != 0 and s["rule"] == "pressure":
            yield {"moves", s["name"]}
        if "strip" in s and (s["rule"] == "pressure" or is_servo(s)):
            yield {"strip", s["name"]}
        if "strip" in s and s["strip"]["axis"] == s["on"][0]:
            yield {"strip", s["name"]}
        if s["on"] == "mantle" and s["rule"] != "pressure":
            yield {"mantle", s["name"]}
    for key, kinds in {"pressure_mpa": ["triaxial"], "stress_ratio": ["biaxial"], "span_mm": ["bending", "four-point"], "strip_mm": ["splitting", "bending", "four-point"]}.items():
        if key in test and (test["kind"] not in kinds or supports):
            yield {key}
    for gauge in test.get("gauges", []):
        if gauge["kind"] == "lvdt" and gauge["from_mm"] >= gauge["to_mm"]:
            yield {gauge["name"]}
    names = [gauge["name"] for gauge in test.get("gauges", [])]
    yield from ({name} for name in set(names) if names.count(name) > 1)
    expansion = test.get("expansion", {})
    if "fibre" in expansion:
        yield {"fibre"}
    if "layer_mm" not in expansion:
        yield from ({key} for key in ("layer_on", "below") if key in expansion)


def support(rng, name, on=None):
    found = {"name": name, "on": on or str(rng.choice(SIDES)), "rule": str(rng.choice(["plate", "plate", "glued", "pressure"]))}
    if found["rule"] == "pressure":
        found["pressure_mpa"] = float(rng.choice([0.5, 1.0, 2.0]))
        if rng.random() < 0.4:
            found["on"] = "mantle"
    elif rng.random() < 0.45:
        axis = str(rng.choice([axis for axis in "xyz" if axis != found["on"][0]]))
        found["strip"] = {"axis": axis, "at_mm": float(rng.choice(list(STRIPS))), "width_mm": 9.0}
    if found["rule"] != "pressure" and rng.random() < 0.35:
        found["moves"] = float(rng.choice([0.5, -0.5, 1.0]))
    if found["rule"] == "plate" and rng.random() < 0.4:
        found["friction"] = 0.1
    if found["rule"] == "plate" and "strip" not in found and rng.random() < 0.15:
        found["pressure_mpa"] = 0.5
        found.pop("moves", None)
    return found


def draw(rng):
    """A test: two supports that press or pull along z, and what comes by chance."""
    if rng.random() < 0.25:
        test = {"kind": str(rng.choice(["compression", "tension", "triaxial", "biaxial", "cyclic"])), "strain": 2e-5}
        wrong = rng.random() < 0.5
        own = {"triaxial": ("pressure_mpa", 2.0), "biaxial": ("stress_ratio", 0.5)}
        if wrong:
            key, value = [("pressure_mpa", 2.0), ("stress_ratio", 0.5), ("span_mm", 20.0), ("strip_mm", 9.0)][rng.integers(4)]
            test[key] = value
        elif test["kind"] in own:
            test[own[test["kind"]][0]] = own[test["kind"]][1]
    else:
        rule = str(rng.choice(["plate", "glued"]))
        way = -1.0 if rule == "plate" else 1.0
        names = list(rng.permutation(NAMES))
        test = {"kind": "compression" if rule == "plate" else "tension", "strain": 2e-5}
        test["supports"] = [{"name": str(names[0]), "on": "z-min", "rule": rule}, {"name": str(names[1]), "on": "z-max", "rule": rule, "moves": way}]
        if rule == "plate" and rng.random() < 0.3:
            for each in test["supports"]:
                each["strip"] = {"axis": "x", "at_mm": 0.0, "width_mm": 9.0}
        for k in range(int(rng.integers(0, 3))):
            test["supports"].append(support(rng, str(names[2 + k])))
        chosen = test["supports"][rng.integers(len(test["supports"]))]
        spoiled = rng.random()
        if spoiled < 0.08:
            chosen["friction"] = 0.2
        elif spoiled < 0.14 and chosen["rule"] == "pressure":
            chosen["moves"] = 0.5
        elif spoiled < 0.20:
            chosen["name"] = test["supports"][0]["name"] if chosen is not test["supports"][0] else test["supports"][1]["name"]
        elif spoiled < 0.24:
            chosen["on"] = "mantle"
        rng.shuffle(test["supports"])
    draw = rng.random()
    if draw < 0.15:
        low, high = sorted(rng.uniform(2, 22, 2).round(1))
        low, high = (low, max(high, low + 8)) if high < 16 else (min(low, high - 8), high)
        ends = (low, high) if rng.random() < 0.6 else (high, low)
        test["gauges"] = [{"kind": "lvdt", "name": "gap", "axis": "z", "from_mm": float(ends[0]), "to_mm": float(ends[1])}]
    elif draw < 0.25:
        test["gauges"] = [{"kind": "sides", "name": "wide", "axis": str(axis)} for axis in rng.choice(list("xy"), rng.integers(1, 3))]
    elif draw < 0.4:
        test["expansion"] = {"aggregate": 1e-5}
        spoiled = rng.random()
        if spoiled < 0.25:
            test["expansion"]["fibre"] = 1e-5
        elif spoiled < 0.5:
            test["expansion"]["layer_on"] = ["x-max"]
        elif spoiled < 0.75:
            test["expansion"].update(layer_mm=7.0, layer_on=["x-max"])
        else:
            test["expansion"]["below"] = {"mortar": 1e-5}
    return test


def inline(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {inline(of)}" for key, of in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(inline, value)) + "]"
    return json.dumps(value)


def contradicted(run, command, number, folder):
    """One TEST.toml: the outcome in words, and the faults."""
    rng = np.random.default_rng([7, number])
    test = draw(rng)
    text = "".join(f"{key} = {inline(value)}\n" for key, value in test.items())
    (folder / "TEST.toml").write_text(text)
    (folder / "spec.toml").write_text(SPEC)
    options = ["--method", "voxel", "--element-size-mm", 6, "--accept-phase-error"]
    found = run(command, "solve", folder / "spec.toml", "--test", folder / "TEST.toml", *options, "-qfo", folder / "out")
    wanted = list(contradictions(test))
    if found.returncode not in (0, 1, 2) or "panicked" in found.stderr:
        return "broken", [f"exit code {found.returncode}: {found.stderr[-300:]}\n{text}"]
    # A test of few elements that shakes ends with an error and its curve: it was taken.
    was_run = (folder / "out" / "result.json").exists()
    if not wanted:
        return ("sound, run" if was_run else "sound, refused"), [] if was_run else [f"refused: {found.stderr[-400:]}\n{text}"]
    if was_run:
        return "contradictory, run", [f"run, though {wanted} contradict\n{text}"]
    is_named = any(all(word in found.stderr for word in words) for words in wanted)
    return "contradictory, refused", [] if is_named else [f"names none of {wanted}: {found.stderr[-300:]}\n{text}"]
