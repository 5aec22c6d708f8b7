"""The public functions of the bound components against the Python package, and what every name of Python has."""

import os
import pathlib
import re

import procam

COMPONENTS = ("core", "pattern", "detect", "session", "calibrate", "surface", "render", "analyze", "track", "depth", "scan", "room",
              "simulate", "io", "report", "show", "people", "watch")
SOURCE = pathlib.Path(os.environ["PROCAM_SOURCE_DIR"])
EXCEPTIONS = pathlib.Path(__file__).with_name("not_in_python.txt")
RESERVED = {"from", "in", "is", "lambda", "pass", "None"}


def without_comments(text):
    text = re.sub(r"//[^\n]*|\bPROCAM_EXPORT\b", "", text)
    text = re.sub(r'"(?:[^"\\\n]|\\.)*"', '""', text)
    return re.sub(r"^[ \t]*#[^\n]*(?:\\\n[^\n]*)*", "", text, flags=re.M)


def statements(text):
    """(depth-first) pieces between ; { and }, with the braces: what a declaration looks like."""
    piece = ""
    parentheses = 0
    for c in text:
        if c in "([":
            parentheses += 1
        elif c in ")]":
            parentheses -= 1
        if parentheses == 0 and c in ";{}":
            yield piece.strip(), c
            piece = ""
        else:
            piece += c


def declarations(text):
    """("function" | "member" | "type", name, the type that it is a member of) of a public header."""
    stack = []  # of (kind, name, public)
    for piece, end in statements(without_comments(text)):
        inside = stack[-1] if stack else ("namespace", "", True)
        label = re.match(r"^(public|private|protected):\s*", piece)
        while label:
            if inside[0] == "type":
                stack[-1] = inside = (inside[0], inside[1], label.group(1) == "public")
            piece = piece[label.end():]
            label = re.match(r"^(public|private|protected):\s*", piece)
        hidden = any(kind == "body" or not public for kind, _, public in stack)
        if end == "{":
            opened = re.match(r"^(?:template\s*<.*>\s*)?(?:inline\s+)?(namespace|struct|class|enum(?: class| struct)?|union)\b\s*([\w:]*)",
                              piece, re.S)
            if opened and opened.group(1) == "namespace":
                name = opened.group(2)
                public = name.split("::")[-1] not in ("internal", "detail", "")
                stack.append(("namespace", name, public))
                continue
            if opened and "(" not in piece.split(":")[0]:
                name = opened.group(2)
                if not hidden:
                    yield "type", name, inside[1]
                kind = "body" if opened.group(1).startswith("enum") else "type"
                stack.append((kind, name, opened.group(1) != "class"))
                continue
        if not hidden and inside[0] in ("namespace", "type") and "(" in piece:
            head = re.sub(r"^template\s*<.*?>\s*(?=[\w:])", "", piece, flags=re.S)
            found = re.match(r"^(?:(?:inline|constexpr|static|virtual|explicit|friend|const|\[\[\w+\]\])\s+)*([\w:<>,\s&*.()\[\]=]*?)[\s&*](operator\s*\S+?|[\w]+)\s*\(", head, re.S)
            if found and "=" not in found.group(1) and found.group(1).strip() and not re.match(r"^(return|using|throw|typedef)\b", head):
                name = found.group(2)
                if not name.startswith("operator"):
                    yield ("member" if inside[0] == "type" else "function"), name, inside[1]
        if end == "{":
            stack.append(("body", "", True))
        elif end == "}" and stack:
            stack.pop()


def exceptions():
    """Patterns of not_in_python.txt, each with its reason: component.name or component.Type.name."""
    found = {}
    for line in EXCEPTIONS.read_text().splitlines():
        if line.strip() and not line.startswith("#"):
            name, _, reason = line.partition(": ")
            assert reason, f"{EXCEPTIONS.name}: {line} has no reason"
            found[name.strip()] = reason.strip()
    return found


def python_name(name):
    return name + "_" if name in RESERVED else name


def python_types():
    found = {}

    def add(cls):
        found.setdefault(cls.__name__, []).append(cls)
        for inner in vars(cls).values():
            if isinstance(inner, type):
                add(inner)

    for scope in [procam, *(getattr(procam, name) for name in COMPONENTS if name != "core")]:
        for value in vars(scope).values():
            if isinstance(value, type):
                add(value)
    return found


def compared():
    """(bound, missing) names as component.name or component.Type.name."""
    bound, missing = set(), set()
    types = python_types()
    for component in COMPONENTS:
        scope = procam if component == "core" else getattr(procam, component)
        for header in sorted((SOURCE / "include/procam" / component).rglob("*.hpp")):
            if {"detail", "costs"} & set(header.parts):
                continue
            for kind, name, owner in declarations(header.read_text()):
                if name in ("", "NumTraits", "ScalarBinaryOpTraits") or name.endswith("_"):
                    continue  # Eigen's, and members in lists of initialisers
                name = {"PoseT": "Pose", "IntrinsicsT": "Intrinsics"}.get(name, name)
                owner = {"PoseT": "Pose", "IntrinsicsT": "Intrinsics"}.get(owner, owner)
                if kind == "function":
                    there, full = hasattr(scope, python_name(name)), f"{component}.{name}"
                elif kind == "type":
                    there, full = name in types or hasattr(scope, name), f"{component}.{name}"
                else:
                    if name == owner:
                        continue
                    there = any(hasattr(cls, python_name(name)) for cls in types.get(owner, []))
                    full = f"{component}.{owner}.{name}"
                (bound if there else missing).add((kind, full))
    return bound, missing - bound


def test_the_public_functions_are_available():
    bound, missing = compared()
    excused = exceptions()

    def is_excused(full):
        parts = full.split(".")
        return full in excused or ".".join(parts[:2]) in excused

    functions = {full for kind, full in bound if kind == "function"}
    lacking = {full for kind, full in missing if kind == "function"}
    share = len(functions) / (len(functions) + len(lacking))
    members = {full for kind, full in bound if kind == "member"}
    lacking_members = {full for kind, full in missing if kind == "member"}
    types = {full for kind, full in bound if kind == "type"}
    lacking_types = {full for kind, full in missing if kind == "type"}
    print(f"\nfunctions {len(functions)} of {len(functions) + len(lacking)} ({100 * share:.1f} %), "
          f"types {len(types)} of {len(types) + len(lacking_types)}, "
          f"members {len(members)} of {len(members) + len(lacking_members)}")
    unexcused = sorted(full for _, full in missing if not is_excused(full))
    assert not unexcused, "neither in Python nor in not_in_python.txt: " + ", ".join(unexcused)
    # The parser sees the library: a tenth of it would mean that it has gone blind.
    assert len(functions) > 300 and len(members) > 150 and len(types) > 200
    # Without the excuses: the first level and the stages, and core, whose helpers of C++ are many.
    def covered(of_core):
        have = [full for full in functions if full.startswith("core.") == of_core]
        lack = [full for full in lacking if full.startswith("core.") == of_core]
        return len(have) / (len(have) + len(lack))

    print(f"without core {100 * covered(False):.1f} %, core {100 * covered(True):.1f} %")
    assert covered(False) >= 0.95
    assert covered(True) >= 0.6


def test_no_exception_is_stale():
    bound, missing = compared()
    names = {full for _, full in missing}
    names |= {".".join(full.split(".")[:2]) for full in names}
    assert not set(exceptions()) - names


def test_signatures_name_types_of_python():
    """A type of C++ in a signature is one that is not bound, or bound too late."""
    wrong = []

    def look(value, where):
        doc = getattr(value, "__doc__", "") or ""
        if isinstance(value, property):
            doc = value.fget.__doc__ or ""
        for line in doc.split("\n"):
            if "->" in line and "::" in line and "(" in line:
                wrong.append(f"{where}: {line}")

    def walk(cls, where):
        for key, value in vars(cls).items():
            if isinstance(value, type):
                walk(value, f"{where}.{key}")
            else:
                look(value, f"{where}.{key}")

    for scope in [procam, *(getattr(procam, name) for name in COMPONENTS if name != "core")]:
        for key, value in vars(scope).items():
            walk(value, key) if isinstance(value, type) else look(value, key)
    assert not wrong, "\n".join(wrong)
