"""Executes a notebook from its first cell to its last, as Jupyter does:   run_notebook.py notebook.ipynb OUTPUT LINE

Prints the text that its cells print. Ends with an error if a cell does, if no text matches LINE (a regular expression),
or if a figure of the notebook is not in OUTPUT.
"""

import os
import pathlib
import re
import sys

import nbclient
import nbformat


def main():
    notebook, output = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    output.mkdir(parents=True, exist_ok=True)
    os.environ["OUTPUT"] = str(output)
    document = nbformat.read(notebook, as_version=4)
    nbformat.validate(document)
    source = "".join(cell.source for cell in document.cells)
    figures = [output / name for name in re.findall(r'OUTPUT / "([^"]+)"', source)]
    for figure in figures:
        figure.unlink(missing_ok=True)
    client = nbclient.NotebookClient(document, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(notebook.parent)}})
    client.execute()
    text = "".join(part.get("text", "") for cell in document.cells for part in cell.get("outputs", []))
    print(text)
    if not re.search(sys.argv[3], text):
        sys.exit(f"{notebook.name}: no cell printed {sys.argv[3]!r}")
    missing = [str(figure) for figure in figures if not figure.exists() or figure.stat().st_size == 0]
    if missing or not figures:
        sys.exit(f"{notebook.name}: not written: {missing}")


if __name__ == "__main__":
    main()
