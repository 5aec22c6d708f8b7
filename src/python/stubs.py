"""Writes the stubs of the built package:   stubs.py BUILD/package/procam

They are made from what the module tells of itself: classes, properties and signatures in docstrings.
"""

import inspect
import pathlib
import re
import sys

HEADER = """# Made from the built module by src/python/stubs.py.
import os
import pathlib
import types
from typing import Any, Callable, ClassVar, Iterable, Mapping, Optional, Sequence, Union, overload

import numpy
import numpy.typing

import procam
"""
ARRAY = re.compile(r"numpy\.ndarray(\[[^\[\]]*(\[[^\[\]]*\])?\])?")


def submodules():
    """Names of the extension's own modules, which have no file."""
    return sorted(name.split(".")[1] for name, module in sys.modules.items()
                  if name.startswith("procam.") and not getattr(module, "__file__", None))


def array_type(match):
    """"numpy.ndarray[numpy.float64[n, 2]]" -> an array of that element; checkers know no shapes."""
    element = re.match(r"\[(numpy\.\w+|bool)\[", match.group(1) or "")
    name = element.group(1).replace("bool", "numpy.bool_") if element else "Any"
    return f"numpy.typing.NDArray[{name}]"


def python_type(text, result):
    """A type of pybind11's signatures, as a result or as an argument."""
    text = ARRAY.sub(array_type if result else "numpy.typing.ArrayLike", text)
    text = re.sub(r"procam\._procam\.", "procam.", text)
    text = re.sub(r"flags\.\w+(, )?", "", text)
    if result:
        text = re.sub(r"\bSequence\[", "list[", text)
        text = re.sub(r"os\.PathLike|object<PathLike>", "pathlib.Path", text)
    else:
        text = text.replace("os.PathLike", "Union[str, os.PathLike[str]]")
        text = re.sub(r"\bList\[", "Sequence[", text)
        text = re.sub(r"\bDict\[", "Mapping[", text)
        text = text.replace("capsule", "Any")
    text = re.sub(r"\b(List|Dict|Tuple)\[", lambda m: m.group(1).lower() + "[", text)
    text = re.sub(r"\bstd::nullopt_t\b", "None", text)
    text = re.sub(r"(list|Sequence|Mapping)\[([^\[\]]*?)\[\d+\]\]", r"\1[\2]", text)
    text = re.sub(r"\[(float|int|procam[\w.]*|numpy[\w.\[\], ]*)\[\d+\]\]", r"[\1]", text)
    if "::" in text:
        raise SystemExit(f"stubs: a type of C++ without a name in Python: {text}")
    return {"dict": "dict[Any, Any]", "list": "list[Any]", "tuple": "tuple[Any, ...]", "iterable": "Iterable[Any]", "Iterable": "Iterable[Any]", "handle": "Any", "object": "Any", "args": "Any", "kwargs": "Any"}.get(text, text)


def read_only(text):
    """A field's type: its lists are tuples, its dictionaries cannot be changed."""
    out, closing = "", []
    i = 0
    while i < len(text):
        opened = re.match(r"\w*\[", text[i:])
        if opened:
            word = opened.group(0)
            closing.append(", ...]" if word == "list[" else "]")
            out += {"list[": "tuple[", "dict[": "Mapping["}.get(word, word)
            i += len(word)
        elif text[i] == "]":
            out += closing.pop()
            i += 1
        else:
            word = re.match(r"\w+|.", text[i:]).group(0)
            out += word
            i += len(word)
    return out


def split_arguments(text):
    """By commas outside of brackets and quotes."""
    parts, depth, quote, start = [], 0, "", 0
    for i, c in enumerate(text):
        if quote:
            quote = "" if c == quote else quote
        elif c in "'\"":
            quote = c
        elif c in "[({<":
            depth += 1
        elif c in "])}" or (c == ">" and text[i - 1] != "-"):
            depth -= 1
        elif c == "," and depth == 0:
            parts.append(text[start:i])
            start = i + 1
    parts.append(text[start:])
    return [part.strip() for part in parts if part.strip()]


def signatures(doc, name):
    """(arguments, result, text) of each overload, from a docstring of pybind11."""
    lines = (doc or "").split("\n")
    found = []
    pattern = re.compile(r"^(?:\d+\. )?" + re.escape(name) + r"\((.*)\) -> (.*)$")
    for line in lines:
        match = pattern.match(line)
        if match:
            found.append([match.group(1), match.group(2), []])
        elif found and line != "Overloaded function.":
            found[-1][2].append(line)
    return [(arguments, result, "\n".join(text).strip()) for arguments, result, text in found]


def parameter(text):
    if text.startswith("*"):
        return text.split(":")[0] + ": Any"
    name, _, rest = text.partition(":")
    kind, default, _ = rest.partition(" = ")
    if name == "self":
        return "self"
    return f"{name}: {python_type(kind.strip(), False)}" + (" = ..." if default else "")


def quoted(text, indent):
    if not text:
        return f"{indent}    ..."
    text = text.replace("\\", "\\\\").replace('"""', "'''")
    text = text.replace("\n", f"\n{indent}    ").rstrip()
    return f'{indent}    """' + text + (f"\n{indent}    " if text.endswith('"') else "") + '"""'


def function_lines(name, function, indent, static=False):
    overloads = signatures(function.__doc__, name)
    if not overloads:
        raise SystemExit(f"stubs: {name} has no signature: {function.__doc__!r}")
    lines = []
    for arguments, result, text in overloads:
        if len(overloads) > 1:
            lines.append(f"{indent}@overload")
        if static:
            lines.append(f"{indent}@staticmethod")
        parameters = [parameter(one) for one in split_arguments(arguments)]
        if name == "__eq__":
            parameters = ["self", "other: object"]
        lines.append(f"{indent}def {name}({', '.join(parameters)}) -> {python_type(result, True)}:")
        lines.append(quoted(text, indent))
    return lines


def class_lines(name, cls, indent):
    if issubclass(cls, RuntimeError):
        fields = ("kind: procam.ErrorKind", "subject: str", "what_failed: str", "why: str", "cause: str", "next: str",
                  "next_step: str")
        return [f"{indent}class {name}(RuntimeError):", quoted(cls.__doc__, indent)] + [f"{indent}    {f}" for f in fields]
    bases = [b for b in cls.__bases__ if b.__module__.startswith("procam")]
    base = f"({', '.join(f'{b.__module__}.{b.__qualname__}' for b in bases)})" if bases else ""
    body = [f"{indent}class {name}{base}:", quoted(cls.__doc__, indent)]
    inner = indent + "    "
    members = getattr(cls, "__members__", None)
    if members is not None:
        body += [f"{inner}{one}: ClassVar[{cls.__module__}.{cls.__qualname__}]" for one in members]
        body += [f"{inner}__members__: ClassVar[dict[str, {cls.__module__}.{cls.__qualname__}]]",
                 f"{inner}def __init__(self, value: int) -> None: ...",
                 f"{inner}def __int__(self) -> int: ...", f"{inner}def __index__(self) -> int: ...",
                 f"{inner}@property", f"{inner}def name(self) -> str: ...",
                 f"{inner}@property", f"{inner}def value(self) -> int: ..."]
        return body
    for key, value in vars(cls).items():
        if inspect.isclass(value):
            body += class_lines(key, value, inner)
        elif isinstance(value, property):
            found = re.search(r"-> (.*)$", (value.fget.__doc__ or "").split("\n")[0])
            kind = python_type(found.group(1), True) if found else "Any"
            kind = read_only(kind) if found and "[" in found.group(1) else kind
            taken = "Any" if "numpy" in kind or "[" in kind or kind == "Any" else kind
            body += [f"{inner}@property", f"{inner}def {key}(self) -> {kind}:", quoted(value.__doc__, inner)]
            if value.fset is not None:
                body += [f"{inner}@{key}.setter", f"{inner}def {key}(self, value: {taken}) -> None: ..."]
        elif isinstance(value, staticmethod):
            body += function_lines(key, value.__func__, inner, static=True)
        elif key in ("__copy__", "__deepcopy__"):
            memo = ", memo: dict[Any, Any]" if key == "__deepcopy__" else ""
            body += [f"{inner}def {key}(self{memo}) -> {cls.__module__}.{cls.__qualname__}: ..."]
        elif key == "__init__" or (inspect.isroutine(value) and (not key.startswith("_") or key in (
                "__mul__", "__call__", "__eq__"))):
            if signatures(value.__doc__, key):
                body += function_lines(key, value, inner)
    return body


def module_text(module):
    lines = [HEADER]
    if module.__name__ == "procam":
        lines += [f"from . import {one} as {one}" for one in submodules()] + ["", "__version__: str"]
    own = {k: v for k, v in vars(module).items() if not k.startswith("_") and not inspect.ismodule(v)}
    for name, value in own.items():
        if inspect.isclass(value):
            lines += [""] + class_lines(name, value, "")
        elif inspect.isroutine(value):
            lines += function_lines(name, value, "")
        elif isinstance(value, (int, float, str)):
            lines.append(f"{name}: {type(value).__name__}")
    return "\n".join(lines) + "\n"


def main():
    folder = pathlib.Path(sys.argv[1])
    sys.path[0] = str(folder.parent)  # not the sources beside this script
    import procam

    for name in submodules():
        (folder / f"{name}.pyi").write_text(module_text(sys.modules[f"procam.{name}"]))
    (folder / "__init__.pyi").write_text(module_text(procam))


if __name__ == "__main__":
    main()
