"""What help() tells of every public name: words, shapes of arrays, units of numbers, and nothing of C++."""

import inspect
import re

import procam

SIGNATURE = re.compile(r"^\s*(?:\d+\. )?\w+\(.*\) -> .*$|^\w+\(\*args, \*\*kwargs\)$|^Overloaded function\.$", re.M)
OF_CPP = re.compile(r"\bnullopt\b|\bnullptr\b|std::|procam::|\bThrows\b|top of this file|as in the table")


def words(doc):
    """A docstring without signatures and lists of enumerators."""
    return SIGNATURE.sub("", doc or "").split("Members:")[0].strip()


def names():
    """(full name, object) of all that is public."""
    found = []

    def look(where, members):
        for key, value in members.items():
            if key.startswith("_") or inspect.ismodule(value):
                continue
            found.append((f"{where}.{key}", value))
            if isinstance(value, type):
                look(f"{where}.{key}", vars(value))

    modules = [procam, *(value for value in vars(procam).values() if inspect.ismodule(value) and value.__name__.startswith("procam."))]
    for module in modules:
        if module.__name__ != "procam._procam":
            look(module.__name__, vars(module))
    return found


def callables():
    return [(name, value) for name, value in names() if callable(value) and not isinstance(value, type)]


def fields():
    """(name, docstring, type as in signatures) of the fields of structs."""
    for name, value in names():
        if isinstance(value, property) and not name.endswith((".name", ".value")):
            yield name, value.__doc__ or "", (value.fget.__doc__ or "").strip().split("-> ")[-1]


def test_every_class_and_function_says_what_it_is():
    silent = [name for name, value in names() if callable(value) and not words(value.__doc__)]
    assert not silent, f"{len(silent)} without a docstring: {', '.join(silent)}"
    assert len(names()) > 2500


def test_arrays_in_signatures_have_a_type_and_a_shape():
    bare = [name for name, value in callables() if re.search(r"numpy\.ndarray(?!\[)", value.__doc__ or "")]
    assert not bare, ", ".join(bare)


def test_arrays_among_fields_have_a_type_and_a_shape():
    bare = [name for name, doc, kind in fields() if "numpy.ndarray" in kind and not re.search(r"\w+ \([\w, ]+\)", doc)]
    assert not bare, ", ".join(bare)


def test_numbers_among_fields_have_a_unit_or_a_meaning():
    bare = [name for name, doc, kind in fields() if kind in ("float", "Optional[float]") and not doc]
    assert not bare, ", ".join(bare)


def test_docstrings_are_of_python():
    foreign = [f"{name}: {OF_CPP.search(value.__doc__).group(0)}" for name, value in names()
               if value.__doc__ and OF_CPP.search(words(value.__doc__))]
    assert not foreign, "\n".join(foreign)
