"""Results of `then` are those of the function that was given, and none is lost. Cases: stale_then.py and then_results.py."""

import copy
import datetime
import functools
import json
import subprocess
import sys
import threading
import types

import numpy as np
import pytest

import mesocrete as mc
from mesocrete._fingerprint import fingerprint

TINY = {"specimen": {"kind": "cube", "side_mm": 20.0}, "fraction": 0.2, "grading": {"d_min_mm": 5, "d_max_mm": 8}}
FACTOR = 1


def closure(k):
    def then(packing):
        return {"v": k}

    return then


def nested(k):
    def then(packing):
        return {"v": [k() for _ in range(2)][0]}

    return then


def default(k):
    def then(packing, *, k=k):
        return {"v": k}

    return then


def positional(k):
    def then(packing=None, k=k):
        return {"v": k}

    return then


class Thing:
    def __init__(self, k):
        self.k = k

    def __call__(self, packing):
        return {"v": self.k}

    def then(self, packing):
        return {"v": self.k}


class Slotted:
    __slots__ = ("k",)

    def __init__(self, k):
        self.k = k

    def __call__(self, packing):
        return {"v": self.k}


def written(source, name="then", **names):
    """Make a function, or a class, from its source."""
    exec(source, names)  # noqa: S102
    return names[name]


def rewritten(k):
    return written(f"class Thing:\n def __call__(self, packing): return {{'v': {k}}}", "Thing")()


def inherited(k):
    return written(f"class A:\n def f(self): return {k}\nclass B(A):\n def __call__(self, packing): return {{'v': self.f()}}", "B")()


def helper(k):
    return written(f"def g(): return {k}\ndef then(packing): return {{'v': g()}}")


def deep_helper(k):
    return written(f"F = {k}\ndef h(): return F\ndef g(): return h()\ndef then(packing): return (lambda: {{'v': g()}})()")


def of_module(k):
    module = types.ModuleType("helpers_of_a_test")
    exec(f"F = {k}\ndef g(): return F", vars(module))  # noqa: S102
    return written("def then(packing): return {'v': helpers.g()}", helpers=module)


def class_attribute(k):
    return written(f"class C:\n F = {k}\n @classmethod\n def f(cls): return cls.F\ndef then(packing): return {{'v': C.f()}}")


def attribute(k):
    then = written("def then(packing): return {'v': then.k}")
    then.k = k
    return then


def decorated(k):
    def double(function):
        @functools.wraps(function)
        def wrapper(packing):
            return function(packing)

        return wrapper

    return double(closure(k))


def summed(packing, data):
    return {"v": float(np.sum(data))}


def array(k):
    data = np.zeros(5000)
    data[0], data[2500] = 1, k
    return data


CHANGED = {
    "a closure": closure,
    "a function in a closure": lambda k: nested(lambda: k),
    "a default argument": default,
    "a positional default": positional,
    "an object": Thing,
    "an object with slots": Slotted,
    "a bound method": lambda k: Thing(k).then,
    "a partial of a long array": lambda k: functools.partial(summed, data=array(k)),
    "a partial of a partial": lambda k: functools.partial(functools.partial(summed), array(k)),
    "a partial of a dict of arrays": lambda k: functools.partial(lambda packing, d: {"v": d["a"].sum()}, d={"a": array(k)}),
    "__call__ rewritten": rewritten,
    "a base class rewritten": inherited,
    "a helper": helper,
    "a helper's helper's global": deep_helper,
    "a module of the user": of_module,
    "an attribute of a class": class_attribute,
    "an attribute of the function": attribute,
    "a decorated function": decorated,
    "a cached function": lambda k: functools.lru_cache(closure(k)),
    "a constant": lambda k: written(f"def then(packing): return {{'v': {k}}}"),
    "an operator": lambda k: written(f"def then(packing): return {{'v': 5 {'+-'[k == 2]} 1}}"),
    "a set": lambda k: closure({"a", "b", str(k)}),
    "a random generator": lambda k: closure(np.random.default_rng(k)),
    "a spec": lambda k: closure(mc.Spec(seed=k)),
    "a date": lambda k: closure(datetime.date(2000, 1, k)),
    "a table of objects": lambda k: closure(np.array([{"k": k}], dtype=object)),
}


@pytest.mark.parametrize("made", CHANGED.values(), ids=CHANGED.keys())
def test_a_changed_function_has_another_fingerprint_and_an_equal_one_the_same(made):
    first, second = fingerprint(made(1)), fingerprint(made(2))
    assert first != second
    assert fingerprint(made(1)) == first


def test_lambdas_of_one_line_differ():
    first, second = lambda p: {"v": 1}, lambda p: {"v": 2}
    assert fingerprint(first) != fingerprint(second)


def test_a_changed_global_changes_the_fingerprint(monkeypatch):
    def then(packing):
        return {"v": FACTOR}

    before = fingerprint(then)
    monkeypatch.setattr(sys.modules[__name__], "FACTOR", 2)
    assert fingerprint(then) != before


def test_a_module_that_the_function_imports_counts(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))

    def prints(text):
        (tmp_path / "imported_by_then.py").write_text(text, encoding="utf-8")
        sys.modules.pop("imported_by_then", None)
        sys.path_importer_cache.clear()
        names = {}
        exec("def then(p):\n import imported_by_then as m\n return m.f()\ndef other(p):\n from imported_by_then import f\n return f()", names)  # noqa: S102
        return fingerprint(names["then"]), fingerprint(names["other"])

    first, changed = prints("def f(): return 1"), prints("def f(): return 22")
    assert first[0] != changed[0] and first[1] != changed[1]


def test_values_that_change_nothing_keep_the_fingerprint():
    data = {"a": 1, "b": [1.5, None], "c": {"x", "y", "z"}}
    turned = dict(reversed(copy.deepcopy(data).items()))
    assert fingerprint(closure(data)) == fingerprint(closure(turned))
    moved = written("\n\n\ndef then(packing):\n    # A comment.\n    return {'v': 1}")
    assert fingerprint(moved) == fingerprint(written("def then(packing): return {'v': 1}"))


def test_a_fingerprint_is_the_same_in_every_process(tmp_path):
    (tmp_path / "work.py").write_text(
        "import numpy as np\nimport mesocrete as mc\nfrom mesocrete._fingerprint import fingerprint\n"
        "NAMES = {'a', 'b', 'c', 'd'}\nclass Scale:\n    def __init__(self): self.f = {'x': 2.0}\n    def of(self, v): return v * self.f['x']\n"
        "SCALE = Scale()\ndef deep(n): return deep(n - 1) if n else len(NAMES)\n"
        "def then(packing):\n    if packing.seed in {1, 2, 3}:\n        return {'v': SCALE.of(np.sqrt(deep(3)))}\n    return {}\n"
        "print(fingerprint(then))\n",
        encoding="utf-8",
    )
    told = {
        subprocess.run([sys.executable, "work.py"], cwd=tmp_path, env={"PYTHONHASHSEED": str(seed)}, check=True, capture_output=True).stdout
        for seed in range(4)
    }
    assert len(told) == 1


def test_a_value_without_readable_content_asks_for_a_version(tmp_path):
    lock = threading.Lock()

    def then(packing):
        with lock:
            return {"v": 1}

    with pytest.raises(TypeError, match="'lock' in then is of type lock, whose content cannot be read .*; give version="):
        mc.study(TINY, {"seed": [1]}, then=then, out=tmp_path / "s")
    assert not (tmp_path / "s").exists()
    study = mc.study(TINY, {"seed": [1]}, then=then, version=1, out=tmp_path / "s")
    assert study.table()["v"].tolist() == [1]


def test_results_are_kept_under_the_version_of_a_function(tmp_path):
    def value(k, version):
        return mc.study(TINY, {"seed": [1]}, then=closure(k), version=version, out=tmp_path / "s").table()["v"].tolist()

    assert value(1, "a") == [1]
    assert value(2, "a") == [1], "the version says that nothing has changed"
    assert value(2, "b") == [2]
    with pytest.raises(ValueError, match="version is 'a', but there is no function then"):
        mc.study(TINY, {"seed": [1]}, version="a", out=tmp_path / "s")
    with pytest.raises(TypeError, match="version is of type float; it must be a str or an int"):
        mc.study(TINY, {"seed": [1]}, then=closure(1), version=1.5, out=tmp_path / "s")


@pytest.mark.parametrize("made", [closure, default, Thing, lambda k: Thing(k).then, helper])
def test_a_study_applies_the_function_that_it_got(tmp_path, made):
    for k in (1, 2, 1):
        assert mc.study(TINY, {"seed": [1]}, then=made(k), out=tmp_path / "s").table()["v"].tolist() == [k]


class Silent(Exception):
    def __str__(self):
        raise ValueError


def raises(error):
    raise error


UNKEPT = {
    "bytes": b"x",
    "a complex number": 1j,
    "an object": object(),
    "a large number": 10**30,
    "a negative large number": -(2**63) - 1,
    "a set": {1, 2},
    "half a character": "\ud800",
    "a name of half a character": {"\ud800": 1},
    "a date": datetime.datetime(2000, 1, 1),
    "a moment of numpy": np.datetime64("2000-01-01"),
    "infinity": float("inf"),
    "an infinite array": np.array([1.0, -np.inf]),
    "a range": range(3),
    "a function": len,
    "two names that are one as text": {1: "a", "1": "b"},
    "two names that are one in the table": {"x.y": 1, "x": {"y": 2}},
    "a complex array": np.array([1j]),
}


@pytest.mark.parametrize("value", UNKEPT.values(), ids=UNKEPT.keys())
def test_a_result_that_json_cannot_hold_fails_its_case_and_no_other(tmp_path, value):
    def then(packing):
        return {"a": value if packing.seed == 2 else packing.seed}

    for _ in range(2):
        study = mc.study(TINY, {"seed": [1, 2, 3]}, then=then, version=1, out=tmp_path / "s")
        assert study.table()["status"].tolist() == ["done", "failed", "done"]
        (message,) = study.failures.values()
        assert "a" in message and message.isprintable()
        assert [record["results"] for record in study.results] == [{"a": 1}, {}, {"a": 3}]


@pytest.mark.parametrize("error", [Silent(), ValueError("\ud800"), RecursionError("deep")])
def test_any_error_is_kept_with_a_message(tmp_path, error):
    study = mc.study(TINY, {"seed": [1, 2]}, then=lambda p: raises(error) if p.seed == 1 else {"v": 1}, version=1, out=tmp_path / "s")
    assert study.table()["status"].tolist() == ["failed", "done"]
    assert next(iter(study.failures.values())).startswith(type(error).__name__)


def test_a_result_that_holds_itself_fails_its_case(tmp_path):
    held = []
    held.append(held)
    study = mc.study(TINY, {"seed": [1]}, then=lambda _: held, version=1, out=tmp_path / "s")
    assert next(iter(study.failures.values())).startswith("RecursionError")


def test_no_value_is_lost_or_rounded(tmp_path):
    large = [2**63, 2**53 + 1, -(2**63)]

    def then(packing):
        n = packing.seed
        results = {"n": large[n - 1], "seed": n, "result.seed": -n, "status": "mine", "gap": math_nan if n == 2 else 2**53 + n}
        return results | {"mixed": 2**53 + 1 if n == 1 else 0.5, "list": [1, None, float("nan")], "no": None}

    math_nan = float("nan")
    study = mc.study(TINY, {"seed": [1, 2, 3]}, then=then, out=tmp_path / "s")
    table = study.table()
    assert table["n"].tolist() == large
    assert table["seed"].tolist() == table["result.result.seed"].tolist() == [1, 2, 3]
    assert table["result.seed"].tolist() == [-1, -2, -3]
    assert table["result.status"].tolist() == ["mine"] * 3
    assert table["gap"].tolist() == [2**53 + 1, None, 2**53 + 3]
    assert table["mixed"].tolist() == ["9007199254740993", "0.5", "0.5"]
    assert study.results[0]["results"]["list"] == [1, None, None] and "no" not in table
    text = (tmp_path / "s" / "table.csv").read_text(encoding="utf-8")
    assert all(str(number) in text for number in [*large, 2**53 + 3])


@pytest.mark.parametrize("library", ["pandas", "polars"])
def test_large_numbers_stay_whole_in_frames(tmp_path, library):
    pytest.importorskip(library)
    study = mc.study(TINY, {"seed": [1, 2**63 + 1]}, then=lambda p: {"v": None if p.seed == 1 else 2**53 + 1}, out=tmp_path / "s")
    frame = study.table(library)
    assert [int(value) for value in frame["seed"].to_list()] == [1, 2**63 + 1]
    assert [None if value is None else int(value) for value in frame["v"].to_list()] == [None, 2**53 + 1]


def test_a_second_study_in_the_folder_is_refused_and_the_first_unharmed(tmp_path):
    refused = []

    def then(packing):
        script = f"import mesocrete as mc\nmc.study({TINY!r}, {{'seed': [1, 2]}}, out={str(tmp_path / 's')!r})"
        other = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
        refused.append(other.stderr.splitlines()[-1])
        with pytest.raises(BlockingIOError, match="is in use by "):
            mc.study(TINY, {"seed": [1]}, out=tmp_path / "s")
        return {"v": packing.seed}

    study = mc.study(TINY, {"seed": [1, 2]}, then=then, version=1, out=tmp_path / "s")
    assert study.table()["v"].tolist() == [1, 2]
    assert len(refused) == 2 and all(line.startswith("BlockingIOError: ") for line in refused)
    # The folder is free again, also after an error.
    mc.study(TINY, {"seed": [1, 2]}, out=tmp_path / "s")
    with pytest.raises(KeyboardInterrupt):
        mc.study(TINY, {"seed": [1, 2]}, then=lambda _: raises(KeyboardInterrupt()), version=2, out=tmp_path / "s")
    mc.study(TINY, {"seed": [1, 2]}, out=tmp_path / "s")


ORPHANS = """
import concurrent.futures, multiprocessing, os, signal, sys
import mesocrete as mc
spec = {"specimen": {"kind": "cube", "side_mm": 20.0}, "fraction": 0.2, "grading": {"d_min_mm": 5, "d_max_mm": 8}}
def kill(over, cases):
    if over == 3:
        print(*executor._processes, flush=True)
        os.kill(os.getpid(), signal.SIGKILL)
with concurrent.futures.ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("fork")) as executor:
    mc.study(spec, {"seed": range(40)}, out=sys.argv[1], executor=executor, progress=kill)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="forks and kills")
def test_workers_of_a_killed_study_do_not_keep_its_folder(tmp_path):
    killed = subprocess.Popen([sys.executable, "-c", ORPHANS, str(tmp_path / "s")], stdout=subprocess.PIPE, text=True)
    pids = [int(pid) for pid in killed.stdout.readline().split()]
    assert killed.wait() == -9 and len(pids) == 2
    try:
        study = mc.study(TINY, {"seed": range(40)}, out=tmp_path / "s")
    finally:
        for pid in pids:
            subprocess.run(["kill", "-9", str(pid)], check=False, capture_output=True)
    straight = mc.study(TINY, {"seed": range(40)}, out=tmp_path / "t")
    assert not study.failures
    assert json.dumps(study.results) == json.dumps(straight.results)
