"""Errors that a person must act on, a caller's bugs, and interruptions."""

import gc
import os
import re
import resource
import select
import signal
import sys
import threading
import time

import numpy
import pytest

import procam


def test_an_error_has_its_three_parts_and_its_kind(tmp_path):
    path = tmp_path / "rig.json"
    path.write_text('{"format": "procam-rig", "version": 1}')
    with pytest.raises(procam.Error) as caught:
        procam.io.load_rig(path)
    error = caught.value
    assert error.kind == procam.ErrorKind.kInput
    assert str(path) in error.subject
    assert error.subject == error.what_failed and error.why == error.cause and error.next == error.next_step
    assert str(error) == f"{error.subject}: {error.why}; {error.next}"
    assert isinstance(error, RuntimeError)


def test_a_missing_file_is_an_error_of_files(tmp_path):
    with pytest.raises(procam.Error) as caught:
        procam.io.load_rig(tmp_path / "no.json")
    assert caught.value.kind == procam.ErrorKind.kIo


def test_degenerate_points_are_an_error(projector):
    line = numpy.array([[0, 0], [1, 1], [2, 2], [3, 3.0]])
    with pytest.raises(procam.Error) as caught:
        procam.fit_homography(line, line)
    assert caught.value.kind == procam.ErrorKind.kDegenerate


def test_a_bug_of_the_caller_is_a_value_error():
    with pytest.raises(ValueError, match="Image|size|pixel|focal"):
        procam.depth.RayTable(procam.Camera())


def test_arguments_of_other_types_are_type_errors(contents):
    with pytest.raises(TypeError, match="correspondences"):
        procam.calibrate.calibrate_rig(None)
    with pytest.raises(TypeError, match="options"):
        procam.calibrate.calibrate_rig(contents.correspondences, 3)
    with pytest.raises(TypeError):
        procam.session.open(None)


def test_progress_is_told_and_its_exception_passes_through(captures):
    plan = procam.session.open(captures)
    views = []
    procam.session.read(plan, lambda view, done, total: views.append((view, total)))
    assert len(views) == 4 and all(total == 4 for _, total in views)

    class Enough(Exception):
        pass

    def stop(view, done, total):
        raise Enough(view)

    with pytest.raises(Enough):
        procam.session.read(plan, stop)


def test_progress_of_a_calibration(contents):
    steps = []
    options = procam.calibrate.Options()
    options.progress = lambda step, share: steps.append((step, share))
    procam.calibrate.calibrate_rig(contents.correspondences, options)
    assert steps and all(0 <= share <= 1 for _, share in steps)


def interrupt_soon(after):
    thread = threading.Timer(after, lambda: os.kill(os.getpid(), signal.SIGINT))
    thread.start()
    return thread


@pytest.mark.parametrize("work", ["read", "calibrate"])
def test_control_c_interrupts(captures, contents, work):
    plan = procam.session.open(captures)
    options = procam.calibrate.Options(outlier_sigmas=3.0)
    options.camera.choose = options.projector.choose = True

    def long_work():
        # Once may be too short for the signal.
        for _ in range(200):
            if work == "read":
                procam.session.read(plan)
            else:
                procam.calibrate.calibrate_rig(contents.correspondences, options)

    thread = interrupt_soon(0.3)
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        long_work()
    thread.join()
    assert time.monotonic() - begin < 60


def test_an_interruption_reaches_into_a_call(contents):
    """The signal is seen by the call itself, not by the interpreter after it."""
    options = procam.calibrate.Options()
    calls = []

    def raise_signal(step, share):
        calls.append(step)
        signal.raise_signal(signal.SIGINT)

    options.progress = raise_signal
    with pytest.raises(KeyboardInterrupt):
        procam.calibrate.calibrate_rig(contents.correspondences, options)
    assert len(calls) == 1


# The extension's own modules have no file.
SUBMODULES = sorted(name.split(".")[1] for name, module in sys.modules.items()
                    if name.startswith("procam.") and not getattr(module, "__file__", None))
ABUSE = [None, numpy.nan, -1, "", [], numpy.zeros((0, 0), numpy.uint8), numpy.full((3, 3), numpy.nan)]


@pytest.mark.parametrize("module", ["", *SUBMODULES])
def test_no_function_crashes_on_nonsense(module, tmp_path, monkeypatch):
    """Every function with none to four arguments of nonsense: an exception of Python or a result, no crash."""
    monkeypatch.chdir(tmp_path)
    scope = getattr(procam, module) if module else procam
    called = 0
    for name, function in vars(scope).items():
        if name.startswith("_") or isinstance(function, type) or not callable(function):
            continue
        for value in ABUSE:
            for count in range(5):
                try:
                    function(*[value] * count)
                except (TypeError, ValueError, OverflowError, procam.Error, IndexError):
                    pass
                called += 1
    assert called > 50


def test_default_objects_do_not_crash():
    """Every class that can be made without arguments: its methods without arguments, its text, its copy."""
    import copy

    made = 0
    for scope in [procam, *(getattr(procam, name) for name in ("analyze", "calibrate", "depth", "detect", "io", "pattern",
                                                               "render", "session", "simulate", "surface", "track"))]:
        for name, cls in vars(scope).items():
            if not isinstance(cls, type) or issubclass(cls, Exception) or hasattr(cls, "__members__"):
                continue
            try:
                one = cls()
            except (TypeError, NotImplementedError):
                continue
            made += 1
            assert repr(one)
            try:
                copy.copy(one)
            except TypeError:
                pass
            for key in dir(one):
                if key.startswith("_"):
                    continue
                try:
                    value = getattr(one, key)
                    if callable(value):
                        value()
                except (TypeError, ValueError, RuntimeError, IndexError):
                    pass
    assert made > 150


def default_objects():
    """One object of each class that can be made without arguments, by its name in signatures."""
    made = {}

    def add(cls):
        for inner in vars(cls).values():
            if isinstance(inner, type):
                add(inner)
        if hasattr(cls, "__members__"):
            made[f"{cls.__module__}.{cls.__qualname__}"] = next(iter(cls.__members__.values()))
            return
        try:
            made[f"{cls.__module__}.{cls.__qualname__}"] = cls()
        except (TypeError, NotImplementedError):
            pass

    for scope in [procam, *(getattr(procam, name) for name in SUBMODULES)]:
        for value in vars(scope).values():
            if isinstance(value, type) and not issubclass(value, Exception):
                add(value)
    made["procam.depth.RayTable"] = procam.depth.RayTable(
        procam.Camera(procam.ImageSize(8, 6), procam.Intrinsics(fx=5, fy=5, cx=3, cy=2)))
    made["procam.depth.DepthImage"] = procam.depth.DepthImage(numpy.zeros((6, 8), numpy.float32))
    return made


def arguments_for(signature, made, variant):
    """Values for a signature of pybind11: default objects, and of the other types empty, zero, negative or large ones."""
    values = []
    for name, kind in re.findall(r"(\w+): ([^,()]*(?:\[[^()]*?\])?[^,()=]*)(?: = [^,]*(?:\([^()]*\))?)?(?:, |$)", signature):
        kind = kind.strip()
        if name == "self":
            continue
        if kind in made:
            values.append(made[kind])
        elif kind.startswith("Union["):
            values.append(next((made[one] for one in re.findall(r"procam[\w.]*", kind) if one in made), None))
        elif kind == "int":
            values.append((0, -1, 1 << 30, 3)[variant])
        elif kind == "float":
            values.append((0.0, -1.0, numpy.nan, 1.0)[variant])
        elif kind == "bool":
            values.append(bool(variant))
        elif kind in ("str", "os.PathLike"):
            values.append(("", "nothing.json", "x" * 300, "0")[variant])
        elif kind.startswith("List"):
            inner = re.match(r"List\[(.*)\]$", kind)
            item = made.get(inner.group(1)) if inner else None
            values.append([] if variant < 2 or item is None else [item, item])
        elif kind.startswith("numpy.ndarray["):
            shape = [int(n) if n.isdigit() else (0, 1, 4, 5)[variant] for n in re.findall(r"(?<=[\[ ])(\d+|[nm])(?=[,\]])", kind)]
            shape = shape[:1] if kind.endswith(", 1]]") else shape
            values.append(numpy.full(shape, (0.0, 1.0, numpy.nan, -1e9)[variant]))
        elif kind == "numpy.ndarray":
            values.append(numpy.zeros(((0, 0), (1, 1), (6, 8), (6, 8, 3))[variant], numpy.uint8))
        else:
            values.append(None)
    return values


@pytest.mark.parametrize("variant", range(4))
@pytest.mark.parametrize("module", ["", *SUBMODULES])
def test_no_function_crashes_on_empty_objects(module, variant, tmp_path, monkeypatch):
    """Functions and methods with arguments of the right types that are empty, zero, negative, large or not numbers."""
    monkeypatch.chdir(tmp_path)
    scope = getattr(procam, module) if module else procam
    made = default_objects()
    calls = []

    def add(function, where, *first):
        if where in ("run", "replay", "write_simulated_session"):
            return  # they work for long, and have tests of their own
        for line in (function.__doc__ or "").split("\n"):
            signature = re.match(r"(?:\d+\. )?\w+\((.*)\) -> ", line)
            if signature:
                calls.append((where, function, [*first, *arguments_for(signature.group(1), made, variant)]))

    for name, value in list(vars(scope).items()):
        if name.startswith("_"):
            continue
        if not isinstance(value, type):
            if callable(value):
                add(value, name)
        elif not issubclass(value, Exception) and not hasattr(value, "__members__"):
            one = made.get(f"{value.__module__}.{value.__qualname__}")
            if one is None:
                continue
            for key, method in vars(value).items():
                if not key.startswith("_") and callable(method) and not isinstance(method, type):
                    add(method, f"{name}.{key}", one)
    assert calls
    crashed = []
    begin = 0
    while begin < len(calls):
        at, status = run_in_child(calls[begin:])
        if at is None:
            break
        where, _, values = calls[begin + at]
        # Some do work for long.
        if status not in (signal.SIGALRM, signal.SIGKILL):
            crashed.append(f"{where}{tuple(values)}: status {status}"[:300])
        begin += at + 1
    assert not crashed, "\n".join(crashed)


def run_in_child(calls, seconds=1.0):
    """Runs the calls in a forked process, each for a limited time. Returns the first that ended the process, and how."""
    reader, writer = os.pipe()
    # Garbage that is freed by the child would wait for threads that a forked process does not have.
    gc.disable()
    child = os.fork()
    if child == 0:
        status = 1
        try:
            os.close(reader)
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGALRM])
            resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
            for where, function, values in calls:
                os.write(writer, b".")
                signal.setitimer(signal.ITIMER_REAL, seconds)
                try:
                    function(*values)
                except (TypeError, ValueError, OverflowError, RuntimeError, IndexError, MemoryError):
                    pass
                except BaseException as error:  # noqa: B902
                    print(where, repr(error), flush=True)
                    break
            else:
                status = 0
        finally:
            os._exit(status)
    gc.enable()
    os.close(writer)
    begun = 0
    while True:
        # A call that the alarm does not end, in a system call that cannot be interrupted say, is killed.
        if select.select([reader], [], [], 20 * seconds)[0]:
            begun += len(byte := os.read(reader, 1))
            if not byte:
                break
        else:
            os.kill(child, signal.SIGKILL)
    os.close(reader)
    _, status = os.waitpid(child, 0)
    return (None if status == 0 else begun - 1), status


def test_messages_name_types_of_python():
    with pytest.raises(TypeError, match="Camera: size: expected ImageSize, found int"):
        procam.Camera(size=3)
    with pytest.raises(TypeError, match="distortion: expected Union.NoDistortion, BrownConrady, .*found int"):
        procam.Camera(distortion=3)
    with pytest.raises(ValueError, match="ImageSize: width: 1000000000000 is out of range"):
        procam.ImageSize(10**12, 480)


def test_names_of_files_need_not_be_utf_8(tmp_path):
    with pytest.raises(procam.Error) as caught:
        procam.io.load_rig(str(tmp_path) + "/a\udcff.json")
    assert caught.value.kind == procam.ErrorKind.kIo
    assert caught.value.subject.endswith("a\\xff.json")
