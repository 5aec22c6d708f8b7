"""mypy over the stubs, over a file of uses, and over a file of mistakes, each of which it must find."""

import pathlib
import re
import subprocess
import sys


def mypy(*arguments):
    return subprocess.run([sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "--cache-dir",
                           sys.argv[2], *arguments], capture_output=True, text=True, check=False)


def main():
    here = pathlib.Path(__file__).parent
    package = pathlib.Path(sys.argv[1])
    # Overloads for arrays of several kinds look alike to a checker.
    stubs = mypy("--disable-error-code", "misc", "--disable-error-code", "override", *map(str, sorted(package.glob("*.pyi"))))
    uses = mypy(str(here / "typed_use.py"))
    failed = False
    for name, run in (("stubs", stubs), ("typed_use.py", uses)):
        if run.returncode != 0:
            print(f"{name}:\n{run.stdout}{run.stderr}")
            failed = True
    misuse = here / "typed_misuse.py"
    run = mypy(str(misuse))
    found = {int(line) for line in re.findall(r"typed_misuse\.py:(\d+): error", run.stdout)}
    wanted = {i for i, line in enumerate(misuse.read_text().splitlines(), 1) if line.endswith("# error")}
    if found != wanted:
        print(f"typed_misuse.py: errors wanted in lines {sorted(wanted)}, found in {sorted(found)}\n{run.stdout}{run.stderr}")
        failed = True
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
