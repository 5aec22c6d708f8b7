"""A show from Python: it ends by time, by its listener and by Ctrl-C."""

import signal
import time

import numpy
import pytest

import procam


@pytest.fixture
def options(tmp_path, calibrated):
    picture = numpy.random.default_rng(1).integers(0, 256, (60, 80, 3), dtype=numpy.uint8)
    procam.io.save_image(tmp_path / "picture.png", picture)
    wall = procam.PlanarSurface(frame="projector", frame_from_surface=procam.Pose([0, 0, 0, 1], [-0.3, -0.35, 2.0]),
                                content=[(0, 0), (1, 0), (1, 1), (0, 1)], points=[(0, 0), (0.8, 0), (0.8, 0.5), (0, 0.5)])
    procam.io.save_surfaces(tmp_path / "surfaces.json", procam.SurfaceSet([procam.Surface(name="wall", geometry=wall)]))
    return procam.show.ShowOptions(surfaces=str(tmp_path / "surfaces.json"), contents={"wall": str(tmp_path / "picture.png")},
                                   output="none", control="off", fps=20.0, duration_s=0.5)


def test_a_show_ends_by_time(calibrated, options):
    report = procam.show.run(calibrated.rig, options)
    assert 5 <= report.metrics.frames + report.metrics.dropped <= 20
    assert report.metrics.draw.count() == report.metrics.frames


def test_a_listener_hears_of_frames_and_ends_the_show(calibrated, options):
    class Enough(Exception):
        pass

    class Listener(procam.show.ShowListener):
        def __init__(self):
            super().__init__()
            self.frames = []

        def on_frame(self, report):
            self.frames.append(report.metrics.frames)
            if report.metrics.frames >= 3:
                raise Enough

    options.duration_s = 60.0
    listener = Listener()
    with pytest.raises(Enough):
        procam.show.run(calibrated.rig, options, listener)
    assert listener.frames[-1] == 3


def test_control_c_ends_a_show(calibrated, options):
    options.duration_s = 60.0
    begin = time.monotonic()
    signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
    signal.setitimer(signal.ITIMER_REAL, 0.4)
    with pytest.raises(KeyboardInterrupt):
        procam.show.run(calibrated.rig, options)
    assert time.monotonic() - begin < 20
    signal.signal(signal.SIGALRM, signal.SIG_DFL)


def test_options_survive_their_file(options, tmp_path):
    procam.show.save_options(tmp_path / "show.json", options)
    again = procam.show.load_options(tmp_path / "show.json")
    assert again.fps == 20.0 and dict(again.contents) == dict(options.contents)
    with pytest.raises(TypeError):
        again.contents["wall"] = "other.png"


def test_a_show_becomes_files(tmp_path, projector):
    rig = procam.Rig(projectors=[procam.RigProjector("beamer", projector)])
    surface = procam.Surface(name="wall", geometry=procam.PlanarSurface(
        frame="projector", frame_from_surface=procam.Pose([0, 0, 0, 1], [-0.4, -0.9, 2.0]),
        content=[(0, 0), (1, 0), (1, 1), (0, 1)], points=[(0, 0), (0.8, 0), (0.8, 0.5), (0, 0.5)]))
    solved = procam.surface.solve_surfaces(procam.SurfaceSet([surface]), rig.projector())
    picture = numpy.full((50, 80, 3), (10, 200, 90), numpy.uint8)
    procam.io.save_image(tmp_path / "picture.png", picture)
    options = procam.show.FrameFilesOptions(output=str(tmp_path / "frame.png"), contents={"wall": str(tmp_path / "picture.png")})
    calls = []
    report = procam.show.write_frames(rig, solved, options, lambda done, total: calls.append((done, total)))
    assert report.frames == 1 and report.surfaces == ("wall",) and calls == [(0, 1)]
    frame = procam.io.load_image(tmp_path / "frame.png").image
    want = procam.render.render(procam.Scene([procam.SceneItem(solved.surfaces[0].placement, picture)]), projector)
    assert (frame == want).all()
    options.output = str(tmp_path / "frame.txt")
    with pytest.raises(procam.Error):
        procam.show.write_frames(rig, solved, options)
    assert procam.show.to_jpeg(picture, 40)[:2] == b"\xff\xd8"
    assert procam.show.identification(procam.ImageSize(64, 48), 2, "left").shape == (48, 64, 3)
    assert procam.show.parse_screen("left=1").projector == "left"
