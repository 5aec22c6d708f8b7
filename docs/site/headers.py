#!/usr/bin/env python3
"""Copies headers with their comments as Doxygen reads them:   headers.py INCLUDE COPY

procam's comments are plain text: the first block of a header describes the file, what is indented is a formula or an
example, words in backticks are code, and nothing else is markup.
"""
import pathlib
import re
import sys

INDENTED = re.compile(r"^(\s*///)( {3,})(\S.*)$")


def escaped(text):
    """A line of a comment: characters that Doxygen would take for commands or HTML, and code in backticks."""
    parts = text.split("`")
    if len(parts) % 2 == 0:  # a backtick without a partner on this line
        parts = ["'".join(parts)]
    for i, part in enumerate(parts):
        part = re.sub(r"([\\@#&<>%\"$])", r"\\\1", part)
        parts[i] = f"<tt>{part}</tt>" if i % 2 else part
    return "".join(parts).replace("::", "\\::")


def filtered(lines):
    """Lines of a header, with commands for Doxygen in its comments."""
    result, in_block, file_described = [], False, False
    for number, line in enumerate(lines):
        comment = re.match(r"^(\s*)///( ?)(.*)$", line)
        if not comment:
            if in_block:
                result[-1] += " @endverbatim"
                in_block = False
            trailing = re.match(r"^(.*\S\s*)///<(.*)$", line)
            result.append(trailing.group(1) + "///<" + escaped(trailing.group(2)) if trailing else line)
            continue
        indent = comment.group(1)
        if not file_described:
            file_described = True
            if number <= 2:
                result.append(f"{indent}/// @file")
                result.append(f"{indent}///")
        formula = INDENTED.match(line)
        if formula and not line.lstrip().startswith("///<"):
            if not in_block:
                result.append(f"{indent}/// @verbatim")
                in_block = True
            result.append(f"{indent}/// {formula.group(2)[1:]}{formula.group(3)}")
            continue
        if in_block:
            result.append(f"{indent}/// @endverbatim")
            in_block = False
        result.append(f"{indent}///{comment.group(2)}{escaped(comment.group(3))}")
    return result


def main():
    root, copy = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    for path in sorted(root.rglob("*.hpp")):
        target = copy / path.relative_to(root)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text("\n".join(filtered(path.read_text(encoding="utf-8").split("\n"))), encoding="utf-8")


if __name__ == "__main__":
    main()
