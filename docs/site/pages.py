#!/usr/bin/env python3
"""The sources of the site: the documents as they are, and the pages that are made from the tree.

    pages.py ROOT XML SOURCE [STUBS]

ROOT: the project. XML: of Doxygen. SOURCE: the folder to write for Sphinx. STUBS: __init__.pyi of the Python package; without it the page
of Python's reference says how to get it.
"""
import ast
import html
import pathlib
import re
import shutil
import sys

import cpp

COMPONENTS = [  # in the order of the pipeline, each with the document about it
    ("core", "pipeline"), ("pattern", "patterns"), ("detect", "boards"), ("io", "file-formats"), ("device", "capture"),
    ("surface", "surfaces"), ("depth", "depth"), ("render", "render"), ("calibrate", "calibration"), ("track", "locate"),
    ("dds", "ros2"), ("people", "people"), ("scan", "scan"), ("room", "room"), ("simulate", "simulate"), ("analyze", "error"), ("report", "verify"),
    ("session", "capture"), ("show", "live"), ("studio", "studio"),
]
GROUPS = [  # documents by what a reader wants; the rest follows under "More"
    ("Begin", ["README", "docs/README", "docs/first-wall", "docs/studio", "docs/mapping", "docs/ten-functions", "docs/python", "docs/packages", "docs/troubleshooting"]),
    ("Calibrate", ["docs/calibration", "docs/capture", "docs/patterns", "docs/boards", "docs/planning", "docs/verify", "docs/error",
                   "docs/photographs", "docs/exchange"]),
    ("Project", ["docs/surfaces", "docs/content", "docs/render", "docs/live", "docs/ros2", "docs/locate", "docs/people", "docs/depth", "docs/scan", "docs/room"]),
    ("Background", ["docs/pipeline", "docs/conventions", "docs/glossary", "docs/file-formats", "docs/matching", "docs/simulate",
                    "docs/references", "docs/stability", "docs/security", "docs/fuzzing", "docs/soak", "CONTRIBUTING", "SECURITY",
                    "CHANGELOG"]),
]


def heading(text, line="="):
    return f"{text}\n{line * len(text)}\n\n"


def link_to_site(text, name):
    """A document's text with its links to sources turned to pages of the site, and its diagram to Graphviz's."""
    up = "../" * name.count("/")
    text = re.sub(r"\]\((?:\.\./)*include/procam/([\w/]+)\.hpp(#[^)]*)?\)", rf"]({up}cpp/\1.rst)", text)
    text = re.sub(r"\]\((?:\.\./)*examples/?\)", f"]({up}examples.md)", text)

    def diagram(match):
        edges = re.sub(r"^\s*(\w+) --> (\w+)$", r"  \1 -> \2;", match.group(1), flags=re.M)
        return "```{graphviz}\ndigraph {\n  rankdir=BT; node [shape=box, fontname=sans]; bgcolor=transparent;\n" + edges + "}\n```"

    return re.sub(r"```mermaid\ngraph BT\n(.*?)```", diagram, text, flags=re.S)


def documents(root, source):
    """Copies the documents; the names that Sphinx knows them by."""
    names = ["README", "CHANGELOG", "CONTRIBUTING", "SECURITY"]
    names += [str(p.relative_to(root).with_suffix("")) for p in sorted((root / "docs").glob("*.md"))]
    names += [str(p.relative_to(root).with_suffix("")) for p in sorted((root / "examples").rglob("*.md"))]
    for name in names:
        target = source / f"{name}.md"
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(link_to_site((root / f"{name}.md").read_text(), name))
    for file in ("LICENSE", "CITATION.cff"):
        shutil.copy(root / file, source / file)
    for folder in ("docs/images", "docs/schema"):
        shutil.copytree(root / folder, source / folder)
    return names


def cpp_reference(root, source, xml):
    """A page a public header, and one a component."""
    reference = cpp.Reference(xml)
    index = heading("C++ reference")
    index += "Each component is a namespace, a folder of headers and a CMake target of its name; ``core`` is ``procam`` itself.\n\n"
    index += ".. toctree::\n   :maxdepth: 1\n\n"
    known = [component for component, _ in COMPONENTS]
    others = sorted(p.name for p in (root / "include/procam").iterdir() if p.is_dir() and p.name not in known)
    for component, document in COMPONENTS + [(name, "pipeline") for name in others]:
        headers = sorted(p.relative_to(root / "include/procam").with_suffix("") for p in (root / f"include/procam/{component}").rglob("*.hpp")
                         if "detail" not in p.parts)
        page = heading(f"procam::{component}")
        page += f"What it does: :doc:`/docs/{document}`. All headers at once: ``#include \"procam/{component}.hpp\"``. CMake: ``procam::{component}``.\n\n"
        page += ".. toctree::\n   :maxdepth: 1\n\n"
        for header in headers:
            page += f"   /cpp/{header}\n"
            file = source / f"cpp/{header}.rst"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(heading(str(header.relative_to(component))) + reference.page(f"{header}.hpp"))
        (source / f"cpp/{component}.rst").write_text(page)
        index += f"   {component}\n"
    (source / "cpp/index.rst").write_text(index)


def indented(text, by):
    return "".join((" " * by + line if line.strip() else "") + "\n" for line in text.split("\n"))


def literal(text):
    """A docstring as text that holds no markup: paragraphs, and indented lines as they are."""
    blocks = []  # (are its lines indented, lines)
    for line in text.strip("\n").split("\n"):
        kind = line.startswith("  ")
        if not line.strip():
            if blocks and blocks[-1][0] is not True:
                blocks.append((None, []))
            elif blocks:
                blocks[-1][1].append("")
        elif blocks and blocks[-1][0] is kind:
            blocks[-1][1].append(line)
        else:
            blocks.append((kind, [line]))
    result = []
    for kind, lines in blocks:
        if kind:
            result.append("::\n\n" + indented("\n".join(lines).rstrip(), 3).rstrip())
        elif len(lines) > 1 and all(re.match(r"[\w, ]+: ", line) for line in lines):  # a list of fields
            result.append("\n".join("| " + re.sub(r"([\\*`|_])", r"\\\1", line) for line in lines))
        elif lines:
            parts = " ".join(lines).split("`")
            for i, part in enumerate(parts):
                code = i % 2 and len(parts) % 2 and part.strip() == part != ""
                parts[i] = f"``{part}``\\ " if code else re.sub(r"([\\*`|_])", r"\\\1", part)
            result.append("".join(parts).strip())
    return "\n\n".join(result)


def python_entry(node, depth, known):
    """A function, class or constant of the stubs as directives of Sphinx. `known`: names that have an entry in the index; a
    further overload gets none."""
    pad = 3 * depth

    def index():
        fresh = node.name not in known
        known.add(node.name)
        return "" if fresh else "   :noindex:\n"

    if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
        decorators = {ast.unparse(d).split(".")[-1] for d in node.decorator_list}
        if node.name.startswith("_") and node.name != "__init__":
            return ""
        kind = "property" if decorators & {"property", "setter"} else "method" if depth else "function"
        if "setter" in decorators:
            return ""
        doc = ast.get_docstring(node) or ""
        if kind == "property":
            head = f".. py:property:: {node.name}\n"
            if node.returns:
                head += f"   :type: {ast.unparse(node.returns)}\n"
        else:
            arguments = ast.unparse(node.args)
            if depth and "staticmethod" not in decorators:
                arguments = re.sub(r"^(self|cls)(: [^,]+)?(, (/, )?)?", "", arguments)
            returns = f" -> {ast.unparse(node.returns)}" if node.returns and node.name != "__init__" else ""
            head = f".. py:{kind}:: {node.name}({arguments}){returns}\n"
            if "staticmethod" in decorators:
                head += "   :staticmethod:\n"
        return indented(head.rstrip() + "\n" + index() + "\n" + indented(literal(doc), 3), pad)
    if isinstance(node, ast.ClassDef):
        bases = [ast.unparse(b) for b in node.bases if ast.unparse(b) not in ("object",)]
        head = f".. py:class:: {node.name}\n\n" + indented(literal(ast.get_docstring(node) or ""), 3)
        if bases:
            head += "\n" + indented("Derived from " + ", ".join(f"``{b}``" for b in bases) + ".", 3)
        own = set()
        return indented(head, pad) + "\n" + "".join(python_entry(child, depth + 1, own) for child in node.body)
    if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and not node.target.id.startswith("_"):
        kind = "attribute" if depth else "data"
        return indented(f".. py:{kind}:: {node.target.id}\n   :type: {ast.unparse(node.annotation)}\n", pad)
    return ""


def python_reference(source, stubs):
    """A page a module of the package, from its stubs."""
    folder = source / "python"
    folder.mkdir()
    index = heading("Python reference") + ("The package has the names of the C++ library; what ``core`` has is at the top level. How to get it, arrays, "
                                           "errors: :doc:`/docs/python`.\n\n")
    if stubs is None:
        (folder / "index.rst").write_text(index + "This site was built without the Python package. ``scripts/site.sh`` reads "
                                          "its stubs from a build with ``-DPROCAM_BUILD_PYTHON=ON``.\n")
        return
    index += ".. toctree::\n   :maxdepth: 1\n\n"
    modules = [stubs] + sorted(p for p in stubs.parent.rglob("*.pyi") if p != stubs)
    for module in modules:
        name = "procam" if module == stubs else "procam." + str(module.relative_to(stubs.parent).with_suffix("")).replace("/__init__", "").replace("/", ".")
        tree = ast.parse(module.read_text())
        page = heading(name) + f".. py:module:: {name}\n\n"
        if ast.get_docstring(tree):
            page += literal(ast.get_docstring(tree)) + "\n\n"
        known = set()
        entries = [python_entry(node, 0, known) for node in tree.body]
        (folder / f"{name}.rst").write_text(page + "\n".join(entry for entry in entries if entry))
        index += f"   {name}\n"
    (folder / "index.rst").write_text(index)


def captions(root):
    """What the documents say about an image: its alternative text, by file, and the document."""
    found = {}
    for document in [root / "README.md", *sorted((root / "docs").glob("*.md"))]:
        for text, file in re.findall(r"!\[([^\]]*)\]\((?:docs/)?(images/[^)]+)\)", document.read_text()):
            found.setdefault(file, (re.sub(r"\s+", " ", text), str(document.relative_to(root).with_suffix(".html"))))
    return found


def gallery(root, source):
    """All images of the documents, of the renderer's tests, and of examples/run.sh where its output is in out/."""
    page = "# Gallery\n\n"

    def grid(figures):
        cells = "".join(f'<figure><a href="{link}"><img src="{file}" alt="{html.escape(text)}"></a><figcaption>{html.escape(text)}</figcaption></figure>\n'
                        for file, text, link in figures)
        return f'<div class="gallery">\n{cells}</div>\n\n'

    extra = source / "_extra/gallery"
    extra.mkdir(parents=True)

    def kept(path, prefix=""):
        shutil.copy(path, extra / (prefix + path.name))
        return f"gallery/{prefix}{path.name}"

    said = captions(root)
    figures = []
    for path in sorted((root / "docs/images").iterdir()):
        text, link = said.get(f"images/{path.name}", (path.stem.replace("_", " "), ""))
        file = kept(path)
        figures.append((file, text, link or file))
    page += grid(figures)
    golden = sorted((root / "tests/render/golden").glob("*.png"))
    if golden:
        page += "## What the renderers must draw\n\nSmall frames of each kind of surface and filter. Both renderers are compared with them.\n\n"
        page += grid([(kept(p, "golden_"), p.stem.replace("_", " "), f"gallery/golden_{p.name}") for p in golden])
    made = [p for p in sorted((root / "out").rglob("*")) if p.suffix in (".png", ".jpg", ".svg")] if (root / "out").is_dir() else []
    if made:
        page += "## The examples\n\nWritten by `examples/run.sh`.\n\n"
        page += grid([(kept(p, "out_" + str(p.parent.relative_to(root / "out")).replace("/", "_") + "_"), p.stem.replace("_", " "),
                       "gallery/out_" + str(p.parent.relative_to(root / "out")).replace("/", "_") + "_" + p.name) for p in made])
    (source / "gallery.md").write_text(page)


def examples(root, source):
    """The examples' programs in full."""
    page = "# Examples\n\nEach is a program that the tests build and run.\n\n"
    for path in sorted((root / "examples").glob("*/main.cpp")) + sorted((root / "examples/python").glob("*.py")):
        name = path.parent.name if path.name == "main.cpp" else path.stem
        language = "cpp" if path.suffix == ".cpp" else "python"
        page += f"## {name}\n\n```{language}\n{path.read_text().rstrip()}\n```\n\n"
    (source / "examples.md").write_text(page)


def index(root, source, names):
    """The first page: its text, and the documents by group."""
    page = (root / "docs/site/index.txt").read_text()
    listed = [name for _, group in GROUPS for name in group]
    rest = [name for name in names if name not in listed]
    for title, group in GROUPS + [("More", rest)]:
        group = [name for name in group if name in names]
        if group:
            page += f"\n```{{toctree}}\n:caption: {title}\n:hidden:\n\n" + "\n".join(group) + "\n```\n"
    page += "\n```{toctree}\n:caption: Reference\n:hidden:\n\ncpp/index\npython/index\nexamples\ngallery\n```\n"
    (source / "index.md").write_text(page)


def main():
    root, xml, source = (pathlib.Path(argument) for argument in sys.argv[1:4])
    stubs = pathlib.Path(sys.argv[4]) if len(sys.argv) > 4 else None
    shutil.rmtree(source, ignore_errors=True)
    source.mkdir(parents=True)
    names = documents(root, source)
    cpp_reference(root, source, xml)
    python_reference(source, stubs)
    gallery(root, source)
    examples(root, source)
    index(root, source, names)


if __name__ == "__main__":
    main()
