"""The fingerprint of a function: another one where the function, or a value that it uses, has changed.

A fingerprint is a hash over code and values: byte code with its constants, default arguments, closures, the globals that the
code names, attributes of modules and classes, the state of bound objects, arguments of partials. Packages that are installed
count by name and version. Files, the environment and modules found at run time are not seen. A value without a content that
can be read, like a lock, is an error: a guess might take old results for new ones.
"""

from __future__ import annotations

import dis
import functools
import hashlib
import importlib
import importlib.util
import struct
import sys
import sysconfig
import types
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

# Entries of a class that say nothing about its behaviour, or whose order changes from run to run.
_CLASS_NOISE = {
    "__dict__", "__weakref__", "__doc__", "__module__", "__annotations__", "__annotate__", "__annotate_func__",
    "__annotations_cache__", "__firstlineno__", "__static_attributes__", "__abstractmethods__", "_abc_impl",
    "__parameters__", "__orig_bases__",
}  # fmt: skip
_LIBRARY = Path(sysconfig.get_path("stdlib")).resolve()
# Flag of a class that Python code made (Py_TPFLAGS_HEAPTYPE).
_HEAP_TYPE = 1 << 9
# Functions and methods that C implements.
_BUILTINS: tuple[type, ...] = (types.BuiltinFunctionType, types.MethodDescriptorType, types.WrapperDescriptorType, types.MethodWrapperType, types.ClassMethodDescriptorType)
_SLOTS: tuple[type, ...] = (types.MemberDescriptorType, types.GetSetDescriptorType)


def fingerprint(then: Callable[..., Any] | None, version: str | int | None = None) -> str:
    """Name the work of a function: by `version` if there is one, else by its content; "" for no function.

    Raises TypeError for a function that uses a value without readable content.
    """
    if version is not None and (isinstance(version, bool) or not isinstance(version, (str, int))):
        message = f"version is of type {type(version).__name__}; it must be a str or an int"
        raise TypeError(message)
    if then is None:
        if version is not None:
            message = f"version is {version!r}, but there is no function then that it could be of"
            raise ValueError(message)
        return ""
    if not callable(then):
        message = f"then is of type {type(then).__name__}; it must be a callable that takes (packing) or (packing, folder)"
        raise TypeError(message)
    if version is not None:
        return f"{_name(then)}:version {version}"
    return f"{_name(then)}:{_Reader().digest(then, 'then').hex()[:32]}"


def _name(then: Any) -> str:
    while isinstance(then, functools.partial):
        then = then.func
    named = then if hasattr(then, "__qualname__") else type(then)
    return f"{getattr(named, '__module__', '')}.{named.__qualname__}"


class _Reader:
    """Hashes values by their content, each object once."""

    def __init__(self) -> None:
        self._known: dict[int, bytes] = {}
        self._depth = 0
        # Objects made on the way keep their identity as long as this lives.
        self._alive: list[object] = []

    def digest(self, value: Any, place: str) -> bytes:
        """Hash a value; `place` says in messages where it was found."""
        key = id(value)
        if key not in self._known:
            self._alive.append(value)
            self._depth += 1
            # A value that holds itself is met again before its hash is known.
            self._known[key] = b"cycle" + struct.pack("<q", self._depth)
            self._known[key] = self._content(value, place)
            self._depth -= 1
        return self._known[key]

    def _content(self, value: Any, place: str) -> bytes:
        kind = type(value)
        if value is None or value is Ellipsis or value is NotImplemented or kind in (bool, int, complex, str, range, slice):
            return _hash(kind.__name__, ascii(value))
        if kind is float:
            return _hash("float", struct.pack("<d", value))
        if kind in (bytes, bytearray):
            return _hash(kind.__name__, bytes(value))
        if kind in (list, tuple):
            return _hash(kind.__name__, *(self.digest(item, f"{place}[{i}]") for i, item in enumerate(value)))
        if kind in (set, frozenset):
            return _hash(kind.__name__, *sorted(self.digest(item, f"an item of {place}") for item in value))
        if kind is dict or kind is types.MappingProxyType:
            return self._mapping(value, place)
        read = self._callable(value, place) or self._by_type(value, place)
        return self._reduced(value, place) if read is None else read

    def _mapping(self, value: Mapping[Any, Any], place: str) -> bytes:
        pairs = ((self.digest(key, f"a key of {place}"), self.digest(item, f"{place}[{key!r}]")) for key, item in value.items())
        return _hash("dict", *(part for pair in sorted(pairs) for part in pair))

    def _callable(self, value: Any, place: str) -> bytes | None:
        """Hash a callable; None for other values."""
        if isinstance(value, types.FunctionType):
            return self._function(value, place)
        if isinstance(value, types.MethodType):
            return _hash("method", self.digest(value.__func__, place), self.digest(value.__self__, f"the object of {place}"))
        if isinstance(value, functools.partial):
            state = (value.func, value.args, value.keywords)
            return _hash("partial", *(self.digest(part, f"an argument of {place}") for part in state))
        if isinstance(value, (staticmethod, classmethod)):
            return _hash(type(value).__name__, self.digest(value.__func__, place))
        if isinstance(value, property):
            return _hash("property", *(self.digest(part, place) for part in (value.fget, value.fset, value.fdel)))
        if isinstance(value, functools.cached_property):
            return _hash("property", self.digest(value.func, place))
        if isinstance(value, _BUILTINS):
            return self._builtin(value, place)
        # functools.lru_cache and the like: a cache is no part of the function.
        if not isinstance(value, type) and type(value).__module__ == "functools" and hasattr(value, "__wrapped__"):
            return _hash("wrapper", self.digest(value.__wrapped__, place))
        return None

    def _builtin(self, value: Any, place: str) -> bytes:
        owner = getattr(value, "__self__", None)
        is_bound = owner is not None and not isinstance(owner, (types.ModuleType, type))
        state = self.digest(owner, f"the object of {place}") if is_bound else b""
        return _hash("builtin", str(getattr(value, "__module__", "")), value.__qualname__, state)

    def _by_type(self, value: Any, place: str) -> bytes | None:
        """Hash code, modules, classes and arrays; None for other values."""
        if isinstance(value, types.CodeType):
            return self._code(value, place)
        if isinstance(value, types.ModuleType):
            return _hash("module", value.__name__, _version(value.__name__))
        if isinstance(value, type):
            return self._class(value, place)
        if isinstance(value, _SLOTS):
            return _hash("slot", str(getattr(value, "__qualname__", "")))
        if isinstance(value, types.CellType):
            return self.digest(_cell(value), place)
        if type(value).__module__ == "numpy" and type(value).__name__ == "ndarray":
            return self._array(value, place)
        return None

    def _array(self, value: Any, place: str) -> bytes:
        if value.dtype.hasobject:
            return _hash("array", str(value.shape), self.digest(value.tolist(), place))
        return _hash("array", str(value.dtype.descr), str(value.shape), value.tobytes())

    def _function(self, function: types.FunctionType, place: str) -> bytes:
        if _is_installed(function.__module__):
            return _hash("function", function.__module__, function.__qualname__, _version(function.__module__))
        cells = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
        return _hash(
            "function",
            self.digest(function.__code__, place),
            self.digest(function.__defaults__, f"the defaults of {place}"),
            self.digest(function.__kwdefaults__, f"the defaults of {place}"),
            *(self.digest(_cell(cell), f"{name!r} in {place}") for name, cell in cells),
            *(self._used(function, place)),
            self.digest({k: v for k, v in vars(function).items() if k != "__wrapped__"}, f"an attribute of {place}"),
        )

    def _code(self, code: types.CodeType, place: str) -> bytes:
        """Hash code without its file name and lines."""
        shape = (code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags)
        names = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
        constants = (self.digest(item, place) for item in code.co_consts)
        return _hash("code", repr((shape, names)), code.co_code, getattr(code, "co_exceptiontable", b""), *constants)

    def _used(self, function: types.FunctionType, place: str) -> Iterable[bytes]:
        """Hash the globals and modules that a function names, and the attributes of modules that it may read."""
        names = _Names(function.__code__, function.__globals__.get("__package__") or "")
        for name in sorted(names.globals):
            if name in function.__globals__:
                yield _hash(name, self._global(function.__globals__[name], names.attributes, f"the global {name!r}"))
        for name in sorted(names.modules):
            yield _hash(name, self._global(_imported(name), names.attributes, f"the module {name}"))

    def _global(self, value: Any, attributes: set[str], place: str) -> bytes:
        if not isinstance(value, types.ModuleType) or _is_installed(value.__name__):
            return self.digest(value, place)
        # A module of the user: the code may read any of its attributes that it names, through submodules, too.
        used = sorted(attributes & vars(value).keys())
        return _hash(value.__name__, *(_hash(name, self._member(value, name, attributes)) for name in used))

    def _member(self, module: types.ModuleType, name: str, attributes: set[str]) -> bytes:
        value, place = vars(module)[name], f"{module.__name__}.{name}"
        is_part = isinstance(value, types.ModuleType) and value.__name__.startswith(f"{module.__name__}.")
        return self._global(value, attributes - {name}, place) if is_part else self.digest(value, place)

    def _class(self, value: type, place: str) -> bytes:
        module = value.__module__
        # A class of C may have no module, and one that `exec` made may claim to be Python's.
        is_made_here = module == "builtins" and bool(value.__flags__ & _HEAP_TYPE)
        if not isinstance(module, str) or (_is_installed(module) and not is_made_here):
            return _hash("class", value.__qualname__, *((module, _version(module)) if isinstance(module, str) else ()))
        entries = {name: item for name, item in vars(value).items() if name not in _CLASS_NOISE}
        members = (_hash(name, self.digest(item, f"{value.__qualname__}.{name}")) for name, item in sorted(entries.items()))
        bases = (self.digest(base, place) for base in (*value.__bases__, type(value)))
        return _hash("class", value.__qualname__, *bases, *members)

    def _reduced(self, value: Any, place: str) -> bytes:
        """Hash an object by its class and the state that `pickle` would keep."""
        try:
            parts = value.__reduce_ex__(4)
        except Exception as error:
            message = f"{place} is of type {type(value).__name__}, whose content cannot be read ({error})"
            raise TypeError(f"{message}; give version=, and another one after each change of then") from error
        own = self.digest(type(value), f"the class of {place}")
        if isinstance(parts, str):
            return _hash("named", own, parts)
        content = [list(part) if hasattr(part, "__next__") else part for part in parts]
        return _hash("object", own, *(self.digest(part, place) for part in content))


class _Names:
    """Names in a function's code and in the functions inside it."""

    def __init__(self, code: types.CodeType, package: str) -> None:
        self.globals: set[str] = set()
        self.attributes: set[str] = set()
        self.modules: set[str] = set()
        self._package = package
        self._read(code)

    def _read(self, code: types.CodeType) -> None:
        constants: list[Any] = [0, 0]
        for step in dis.get_instructions(code):
            if step.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
                self.globals.add(step.argval)
            elif step.opname == "IMPORT_NAME":
                self._import(step.argval, constants[-2])
            elif isinstance(step.argval, str) and step.opname != "LOAD_CONST":
                self.attributes.add(step.argval)
            if step.opname.startswith(("LOAD_CONST", "LOAD_SMALL_INT")):
                constants.append(step.argval)
                self._text(step.argval)
        for item in code.co_consts:
            if isinstance(item, types.CodeType):
                self._read(item)

    def _text(self, value: Any) -> None:
        """Count names in `getattr(module, "name")`, too."""
        if isinstance(value, str):
            self.attributes.add(value)

    def _import(self, name: str, level: Any) -> None:
        """Add a module and those above it: `import a.b` gives `a`, and `from a import b` may give a module."""
        full = "." * level + name if isinstance(level, int) else name
        try:
            full = importlib.util.resolve_name(full, self._package)
        except ImportError:
            return
        parts = full.split(".")
        self.modules |= {".".join(parts[: i + 1]) for i in range(len(parts))}


def _imported(name: str) -> types.ModuleType | None:
    """Return a module, which the function itself would import; None where it cannot be imported."""
    try:
        return importlib.import_module(name)
    except Exception:
        return None


def _cell(cell: types.CellType) -> Any:
    try:
        return cell.cell_contents
    except ValueError:
        return None


def _is_installed(module: str | None) -> bool:
    """Return whether a module is of Python or of an installed package, whose version stands for its content."""
    if module is None or module == "__main__":
        return False
    if module in sys.builtin_module_names or module.partition(".")[0] == "mesocrete":
        return True
    found = sys.modules.get(module.partition(".")[0])
    if found is None:
        return False
    spec = getattr(found, "__spec__", None)
    if spec is not None and spec.origin in ("built-in", "frozen"):
        return True
    places = [getattr(found, "__file__", None) or "", *getattr(found, "__path__", ())]
    return any(_is_library(Path(place).resolve()) for place in places if place)


def _is_library(path: Path) -> bool:
    return not {"site-packages", "dist-packages"}.isdisjoint(path.parts) or path.is_relative_to(_LIBRARY)


def _version(module: str) -> str:
    """Return the version of the package that a module is in; Python's own for its library."""
    top = sys.modules.get(module.partition(".")[0])
    return str(getattr(top, "__version__", sys.version_info[:3]))


def _hash(*parts: str | bytes) -> bytes:
    """Hash texts and bytes so that no two lists of parts give one text."""
    found = hashlib.sha256()
    for part in parts:
        data = part.encode("utf-8", "surrogatepass") if isinstance(part, str) else part
        found.update(struct.pack("<q", len(data)))
        found.update(data)
    return found.digest()
