"""The commands in the documents, checked against the tools of the build, and run where that needs no hardware.

    commands.py check  SOURCE TOOLS EXAMPLES            every tool and option that a document names exists
    commands.py run    SOURCE TOOLS EXAMPLES SESSION    the commands, each page in its own folder of simulated input;
                                                        exit code 5, a failed quality check of the small session, is accepted;
                                                        a ```text block after commands is part of their output, in its order:
                                                        the same words, and numbers within 30 % or one unit of their last
                                                        digit; "..." stands for any lines

A command stands in a ```sh block, or in a line as `tool --option ...`.
"""

import array
import os
import pathlib
import re
import shlex
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib

# Prepared files that a page makes itself. A command that matches the reasons below is checked for its options alone.
MADE = {
    "docs/calibration.md": ["calibrated.json"],
    "docs/depth.md": ["surfaces.json", "solved.json"],
    "docs/locate.md": ["session", "pose.json"],
    "docs/mount.md": ["mount.json"],
    "docs/room.md": ["scan", "surfaces.json"],
    "docs/scan.md": ["surfaces.json", "solved.json"],
    "docs/surfaces.md": ["solved.json"],
    "docs/verify.md": ["session"],
}
OTHER_SAMPLES = {"docs/calibrate.md": "of a session that takes a minute to simulate"}
NOT_RUN = {
    r"^simulate-captures --seed 7 --level paper --board charuco": "a minute",
    r"^simulate-captures --seed 7 (-o session|--views 1 --bump)|--captures after": "a minute: examples/run.sh does the same",
    r"^simulate-captures --seed 3 |--captures fleet": "minutes: tests/e2e/fleet_route_test.cpp, tests/e2e/board_kinds_test.cpp",
    r"capture-session|--display 1|--list-displays|studio|stage/|--screen|camera:0|\bdepth(-shape)?:": "hardware or a person",
    r"^(scan-surfaces|calibrate-room) .*(scan_1|left)": "several stations or cameras: tests/e2e/scan_route_test.cpp, tests/e2e/room_route_test.cpp",
    r"ros2:|log:run": "a graph of several programs: tests/e2e/ros2_route_test.cpp",
    r"--group|--fleet": "several hosts: tests/e2e/group_route_test.cpp, tests/e2e/robot_fleet_route_test.cpp",
    r"^project-live .*--pose-source|^simulate-robot .*--to udp": "two programs at a time: tests/e2e/live_route_test.cpp",
    r"--captures check": "captures of a person: tests/e2e/verify_route_test.cpp",
    r"--captures graycode": "real captures: tests/e2e/real_captures_test.cpp",
    r"--mirror-view": "captures through a mirror: tests/e2e/mirror_route_test.cpp",
    r"--points (room|wall)": "measured points: tests/e2e/points_route_test.cpp",
    r"--pattern pattern.json|--decoded maps": "another program's captures: tests/e2e/decoded_route_test.cpp",
    r"chessboard:9x6:36mm": "photographs: tests/e2e/shown_views_test.cpp",
    r"^calibrate-mount .*--(images|depth|light)|--save-(depth|light)": "images of a drive: tests/e2e/mount_route_test.cpp reads some",
    r"^align-maps ": "two robots' maps: tests/e2e/align_maps_route_test.cpp",
    r"\$inputs": "several processes: tests/e2e/draw_route_test.cpp",
    r"camchain": "another program's file: tests/e2e/exchange_route_test.cpp",
    r"--blend|--projector (left|right)": "several projectors: tests/e2e/content_route_test.cpp",
    r"--virtual": "a file of virtual objects: tests/e2e/viewer_route_test.cpp",
    r"^(bench_|test_|air_hockey|exercise)": "a program of the tests or examples",
    r"--duration 10s": "a long video: tests/e2e/content_route_test.cpp",
}


def blocks(text):
    """The shell commands of a document, continued lines joined."""
    for block in re.findall(r"^```sh\n(.*?)^```", text, re.M | re.S):
        for line in re.sub(r"\\\n\s*", " ", block).split("\n"):
            if line.strip():
                yield line.strip()


def samples(text):
    """Commands of each ```sh block, and the lines of the ```text block that follows it (none without one)."""
    for block, sample in re.findall(r"^```sh\n(.*?)^```\n(?:\s*```text\n(.*?)^```)?", text, re.M | re.S):
        yield list(blocks("```sh\n" + block + "```")), sample.splitlines()


NUMBER = r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"


def alike(sample, line):
    """The same words, and numbers that agree within the tolerance."""
    if re.split(NUMBER, " ".join(sample.split())) != re.split(NUMBER, " ".join(line.split())):
        return False
    for a, b in zip(re.findall(NUMBER, sample), re.findall(NUMBER, line)):
        unit = 10.0 ** -len(a.partition("e")[0].partition(".")[2])
        if abs(float(a) - float(b)) > max(1.01 * unit if "e" not in a else 0, 0.3 * abs(float(a))):
            return False
    return True


def missing(sample, output):
    """The first line of the sample that is not in the output, after the lines before it."""
    lines = iter(output.splitlines())
    for expected in sample:
        if expected.strip() != "..." and not any(alike(expected, line) for line in lines):
            return expected
    return None


def inline(text):
    return re.findall(r"`((?:procam )?[a-z]+(?:-[a-z]+)+ -[^`]*)`", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S))


def words(command):
    """Arguments of each program of a line; comments and redirections omitted."""
    lexer = shlex.shlex(command, posix=True, punctuation_chars="|&;<>()")
    lexer.whitespace_split = True
    lexer.commenters = "#"
    one = []
    for word in lexer:
        if re.fullmatch(r"[|&;<>()]+", word):
            yield one
            one = []
        else:
            one.append(word)
    yield one


class Tools:
    def __init__(self, folders):
        self.programs = {}
        for folder in folders:
            for path in sorted(pathlib.Path(folder).rglob("*")):
                if path.is_file() and path.stat().st_mode & 0o111 and "." not in path.name:
                    self.programs.setdefault(path.name, path)
        self.known = {}

    def options(self, name):
        if name not in self.known:
            text = subprocess.run([self.programs[name], "--help"], capture_output=True, text=True, timeout=60).stdout
            self.known[name] = set(re.findall(r"(?<![\w-])(--?[a-zA-Z][\w-]*)", text))
        return self.known[name]


def problems(tools, command):
    for line in words(command):
        line = line[1:] if line[:1] == ["sudo"] else line
        if line[:1] == ["procam"] and len(line) > 1 and not line[1].startswith("-"):
            name = line[1] if line[1] in tools.programs else "procam-" + line[1]
            if name not in tools.programs:
                yield f"procam has no tool '{line[1]}'"
                continue
        elif line and line[0] in tools.programs:
            name = line[0]
        else:
            if line and re.fullmatch(r"(?:[a-z]+-)+[a-z]+", line[0]) and line[0] not in ("apt-get",):
                yield f"there is no tool '{line[0]}'"
            continue
        for word in line[1:]:
            option = re.match(r"--?[a-zA-Z][\w-]*", word)
            if option and option.group() not in tools.options(name):
                yield f"{name} has no option '{option.group()}'"


def pages(source):
    for path in [source / "README.md", *sorted(source.glob("docs/*.md")), *sorted(source.glob("examples/*/README.md"))]:
        yield str(path.relative_to(source)), path.read_text()


def examples(text):
    """The commands below "Try:" of a tool's help."""
    block = re.search(r"^Try:\n((?:  .*\n)+)", text, re.M)
    return [line.strip() for line in (block.group(1) if block else "").split("\n") if line and not line.startswith("  #")]


def check_help(source, tools):
    """Every tool of the table in docs/README.md prints three examples, with options that exist."""
    table = (source / "docs/README.md").read_text().split("## The tools")[1]
    for name in re.findall(r"^\|[^|]*\| `((?:procam )?[a-z-]+)` \|", table, re.M):
        program = name.replace("procam ", "procam-")
        shown = examples(subprocess.run([tools.programs[program], "--help"], capture_output=True, text=True, timeout=60).stdout)
        if len(shown) != 3:
            yield f"{program} --help: {len(shown)} examples, not 3"
        for command in shown:
            yield from (f"{program} --help: {problem}: {command}" for problem in problems(tools, command))


def check(source, tools):
    bad, count = list(check_help(source, tools)), 0
    for name, text in pages(source):
        for command in [*blocks(text), *inline(text)]:
            count += 1
            bad += [f"{name}: {problem}: {command}" for problem in problems(tools, command)]
    print(f"{count} commands")
    print("\n".join(bad))
    return count > 100 and not bad


def save_depth_png(pfm, png):
    """The depths in metres as whole millimetres of 16 bits."""
    kind, size, scale, data = pfm.read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    depths = array.array("f", data)
    if (float(scale) < 0) != (sys.byteorder == "little"):
        depths.byteswap()
    mm = array.array("H", (round(1000 * d) if 0 < d < 65 else 0 for d in depths))
    if sys.byteorder == "little":
        mm.byteswap()
    rows = [b"\0" + mm[y * width:(y + 1) * width].tobytes() for y in reversed(range(height))]  # a PFM begins at the bottom

    def chunk(name, content):
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    png.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)) +
                    chunk(b"IDAT", zlib.compress(b"".join(rows), 1)) + chunk(b"IEND", b""))


def prepare(folder, source, tools, session):
    """The files that the documents' commands name, of one simulated rig."""
    shutil.copytree(session, folder / "session")
    shutil.copy(session / "truth.json", folder / "rig.json")
    shutil.copy(source / "examples/data/surfaces.json", folder / "surfaces.json")
    shutil.copy(source / "examples/data/test_card.png", folder / "picture.png")
    for command in ["solve-surfaces --rig rig.json --surfaces surfaces.json -o solved.json",
                    "calibrate-projector --captures session --write-observations found.csv -o calibrated.json",
                    "simulate-captures --seed 7 --level easy --room corner --views 2 -o room"]:
        subprocess.run([tools.programs[command.split()[0]], *command.split()[1:]], cwd=folder, check=True, capture_output=True)
    shutil.copy(folder / "room/truth.json", folder / "camera.json")
    save_depth_png(folder / "room/view_00/truth_depth.pfm", folder / "depth.png")
    shutil.copytree(folder / "room", folder / "scan", ignore=lambda _, names: [n for n in names if n == "view_01"])
    pose = ('{"format": "procam-pose", "version": 1, "target": "projector", "source": "world", '
            '"translation": [0.1, 0.2, 0.3], "rotation_xyzw": [0, 0, 0, 1]}')
    for name in ["pose.json", "projector_from_world.json"]:
        (folder / name).write_text(pose)
    (folder / "mount.json").write_text(pose.replace('"projector"', '"base"').replace('"world"', '"rig"'))


def lay_out(stage, folder, without):
    """The prepared files in a page's folder. Links: tools write anew and rename, so that no file changes for other pages."""
    shutil.copytree(stage, folder, copy_function=os.link)
    for name in without:
        path = folder / name
        shutil.rmtree(path) if path.is_dir() else path.unlink()


def run(source, tools, session):
    bad = [f"NOT_RUN names {path}, which does not exist" for why in NOT_RUN.values() for path in re.findall(r"tests/\S+\.cpp", why)
           if not (source / path).is_file()]
    count = 0
    with tempfile.TemporaryDirectory() as scratch:
        stage = pathlib.Path(scratch) / "stage"
        stage.mkdir()
        prepare(stage, source, tools, session)
        for name, text in pages(source):
            folder = pathlib.Path(scratch) / name.replace("/", "_")
            for commands, sample in samples(text):
                output = ""
                for command in commands:
                    program = next((line for line in words(command) if line), [""])
                    if program[0] not in tools.programs or any(re.search(key, command) for key in NOT_RUN):
                        continue
                    if not folder.exists():
                        lay_out(stage, folder, MADE.get(name, []))
                    done = subprocess.run([tools.programs[program[0]], *program[1:]], cwd=folder, capture_output=True, text=True,
                                          stdin=subprocess.DEVNULL, timeout=300)
                    count += 1
                    output += done.stdout
                    print(f"{done.returncode} {name}: {command}")
                    if done.returncode not in (0, 5):
                        bad.append(f"{name}: {command}\n{done.stdout[-1500:]}{done.stderr[-1500:]}")
                # Without output, no command of the block was run.
                line = None if name in OTHER_SAMPLES or not output else missing(sample, output)
                if line is not None:
                    bad.append(f"{name}: the output has no line like this one:\n{line}\nbut is:\n{output[-3000:]}")
    print(f"{count} commands run")
    print("\n".join(bad))
    return count > 10 and not bad


def main():
    mode, source, *folders = sys.argv[1:]
    source = pathlib.Path(source)
    tools = Tools(folders[:2])
    good = check(source, tools) if mode == "check" else run(source, tools, pathlib.Path(folders[2]))
    sys.exit(0 if good else 1)


main()
