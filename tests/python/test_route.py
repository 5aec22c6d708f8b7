"""The route from captures to a frame and its predicted error, against the tools."""

import os
import pathlib
import subprocess

import numpy
import pytest

import procam


@pytest.fixture
def epoch(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")


def test_the_rig_is_that_of_the_tool_byte_for_byte(captures, tools, tmp_path, epoch):
    subprocess.run([tools / "calibrate-projector", "--captures", captures, "-o", tmp_path / "tool.json"], check=True,
                   capture_output=True)
    contents = procam.session.read(procam.session.open(captures))
    options = procam.calibrate.Options()
    options.camera.choose = options.projector.choose = True
    result = procam.calibrate.calibrate_rig(contents.correspondences, options)
    procam.analyze.check_predicted_errors(result)
    result.rig.provenance = procam.session.provenance(contents, "calibrate-projector")
    procam.io.save_rig(tmp_path / "python.json", result.rig)
    assert (tmp_path / "python.json").read_bytes() == (tmp_path / "tool.json").read_bytes()


def test_a_rig_survives_its_file(calibrated, tmp_path):
    procam.io.save_rig(tmp_path / "rig.json", calibrated.rig)
    rig = procam.io.load_rig(str(tmp_path / "rig.json"))
    assert rig.projector().projector.inverse_camera.intrinsics.fx == calibrated.rig.projector().projector.inverse_camera.intrinsics.fx
    assert rig.covariance.sigma("projector.fx") == pytest.approx(calibrated.rig.covariance.sigma("projector.fx"), rel=1e-12)
    assert rig.covariance.sigma("projector.fx") > 0
    assert rig.covariance.matrix.shape == (len(rig.covariance.names),) * 2


def test_the_calibration_is_that_of_the_truth_within_its_sigmas(captures, calibrated):
    truth = procam.io.load_rig(captures / "truth.json")
    within = procam.analyze.parameters_within_truth(calibrated.rig, truth)
    assert within.parameters > 10
    assert within.inside_3_sigma >= 0.8 * within.parameters
    for view in calibrated.views:
        assert numpy.linalg.eigvalsh(view.rig_from_board_covariance).min() > -1e-12
        assert len(view.rms_px) == 2


def wall_surface(rig):
    """A board of 0.8 m x 0.5 m on a wall 2 m before the projector, askew."""
    projector_from_wall = procam.Pose([0, 0, 0, 1], [-0.3, -0.35, 2.0]) * procam.se3_exp([0.1, 0.2, 0, 0, 0, 0])
    surface = procam.Surface(name="wall")
    geometry = procam.PlanarSurface()
    geometry.frame = "projector"
    geometry.frame_from_surface = projector_from_wall
    geometry.content = [(0, 0), (1, 0), (1, 1), (0, 1)]
    geometry.points = [(0, 0), (0.8, 0), (0.8, 0.5), (0, 0.5)]
    surface.geometry = geometry
    return procam.SurfaceSet([surface])


def test_a_rendered_frame_is_that_of_the_tool(calibrated, tools, tmp_path):
    rig = calibrated.rig
    procam.io.save_rig(tmp_path / "rig.json", rig)
    surfaces = wall_surface(rig)
    procam.io.save_surfaces(tmp_path / "surfaces.json", surfaces)
    rig = procam.io.load_rig(tmp_path / "rig.json")
    solved = procam.surface.solve_surfaces(procam.io.load_surfaces(tmp_path / "surfaces.json"), rig.projector())
    assert [one.name for one in [solved.surfaces[0].surface]] == ["wall"]
    assert solved.surfaces[0].visibility.covered_share > 0.9
    picture = numpy.random.default_rng(1).integers(0, 256, (120, 200, 3), dtype=numpy.uint8)
    procam.io.save_image(tmp_path / "picture.png", picture)
    scene = procam.Scene([procam.SceneItem(solved.surfaces[0].placement, picture)])
    frame = procam.render.render(scene, rig.projector().projector)
    assert frame.shape == (rig.projector().projector.size().height, rig.projector().projector.size().width, 3)
    assert frame.any()

    subprocess.run([tools / "solve-surfaces", "--rig", tmp_path / "rig.json", "--surfaces", tmp_path / "surfaces.json",
                    "-o", tmp_path / "solved.json"], check=True, capture_output=True)
    subprocess.run([tools / "render-to-image", "--rig", tmp_path / "rig.json", "--surfaces", tmp_path / "solved.json",
                    "--content", f"wall={tmp_path / 'picture.png'}", "-o", tmp_path / "frame.png"], check=True, capture_output=True)
    of_the_tool = procam.io.load_image(tmp_path / "frame.png").image
    assert (frame == of_the_tool).all()


def test_renderer_frame_after_frame(scene, projector):
    renderer = procam.render.CpuRenderer()
    frame = numpy.zeros((400, 640, 3), numpy.uint8)
    work = renderer.render(scene, projector, frame)
    assert work.contents == 1 and work.maps == 1
    first = frame.copy()
    assert renderer.render(scene, projector, frame).contents == 0
    assert (frame == first).all()
    # Another array in the same item, which may have the memory of an old one, is another picture.
    for grey in (0, 255, 80, 200):
        scene.items[0].content = numpy.full((90, 160, 3), grey, numpy.uint8)
        renderer.render(scene, projector, frame)
        assert (frame == procam.render.render(scene, projector)).all()
    # Pixels that change behind an equal revision are not looked at; with another one they are.
    scene.items[0].content[:] = 7
    scene.items[0].content_revision += 1
    renderer.render(scene, projector, frame)
    assert (frame == procam.render.render(scene, projector)).all()
    light = numpy.zeros((400, 640, 3), numpy.float32)
    renderer.render_light(scene, projector, light)
    assert 0 < light.max() <= 1


def test_prediction_and_draws_agree(calibrated):
    rig = calibrated.rig
    rig_from_wall = rig.projector().rig_from_projector * procam.Pose([0, 0, 0, 1], [-0.4, -0.5, 2.0])
    path = procam.analyze.light_path(rig.projector(), "rig", rig_from_wall)
    sources = procam.analyze.ErrorSources(calibration=rig.covariance)
    plane_from_content = numpy.diag([0.8, 0.6, 1.0])
    prediction = procam.analyze.predict_surface("wall", path, plane_from_content, sources,
                                                procam.analyze.MonteCarloOptions(draws=20000, seed=3))
    assert prediction.surface == "wall"
    assert 0 < prediction.rms_mm < prediction.worst_mm
    # 20000 draws: 1 % of a standard deviation; the linear prediction is right to a few percent more.
    assert prediction.drawn_rms_mm == pytest.approx(prediction.rms_mm, rel=0.05)
    assert prediction.causes and prediction.causes[0].rms_mm > 0
    spread = procam.analyze.monte_carlo_landing(path, sources, [(0.4, 0.3), (0.1, 0.2)],
                                                procam.analyze.MonteCarloOptions(draws=5000, seed=3))
    assert len(spread) == 2 and spread[0].covariance.shape == (2, 2) and spread[0].rms() > 0


def test_matrix_for_another_renderer(projector):
    k = projector.inverse_camera.intrinsics
    clip = procam.clip_from_eye(k, projector.size(), 0.1, 10, procam.GraphicsApi.kOpenGL)
    eye = procam.eye_from_optical(procam.GraphicsApi.kOpenGL)
    point = numpy.array([0.2, -0.1, 2.0, 1.0])
    x, y, z, w = clip @ eye @ point
    pixel = [((x / w + 1) / 2) * 640 - 0.5, ((1 - y / w) / 2) * 400 - 0.5]
    assert numpy.allclose(pixel, (k.matrix() @ (point[:3] / point[2]))[:2], atol=1e-9)
    assert -1 < z / w < 1


def test_verify_of_an_exact_scene_has_no_alarm(calibrated):
    rig = calibrated.rig
    rig_from_surface = rig.projector().rig_from_projector * procam.Pose([0, 0, 0, 1], [-0.4, -0.4, 2.2])
    surface = procam.analyze.StatedSurface(name="wall", rig_from_surface=procam.PoseWithCovariance(rig_from_surface))
    marks = []
    camera, projector = rig.camera(), rig.projector()
    for x in numpy.linspace(0.1, 0.6, 5):
        for y in numpy.linspace(0.1, 0.5, 4):
            point = rig_from_surface * [x, y, 0]
            pixel = projector.projector.project(projector.rig_from_projector.inverse() * point)
            seen = camera.camera.project(camera.rig_from_camera.inverse() * point)
            if pixel is None or seen is None:
                continue
            marks.append(procam.LightPoint(projector=0, projector_pixel=pixel, camera=0, camera_pixel=seen,
                                           camera_covariance=0.01 * numpy.eye(2), point=len(marks)))
    result = procam.analyze.verify(rig, camera, projector, surface, marks)
    assert result.used == len(marks) and not result.alarm
    assert result.rms < 1e-6
    assert procam.report.lines(result)


def test_real_captures_give_the_rig_of_the_tool_byte_for_byte(tools, tmp_path, epoch):
    """Five views of a camera and a projector, in PROCAM_TEST_DATA; ninety 1-megapixel captures and more."""
    captures = pathlib.Path(os.environ.get("PROCAM_TEST_DATA", pathlib.Path(os.environ["PROCAM_SOURCE_DIR"]) / "../shared/data")) / "graycode"
    if not (captures / "capture_0").exists():
        pytest.skip(f"no real captures in {captures}: set PROCAM_TEST_DATA")
    run = subprocess.run([tools / "calibrate-projector", "--captures", captures, "--pattern", "gray", "--projector-size", "1024x768",
                          "--board", "chessboard:7x9:75mm", "-o", tmp_path / "tool.json"], capture_output=True, check=False)
    assert run.returncode == 0, run.stderr
    stated = procam.io.SessionInfo(pattern="gray", projector_size=procam.ImageSize(1024, 768),
                                   board=procam.io.read_board("chessboard:7x9:75mm"))
    contents = procam.session.read(procam.session.open(captures, procam.session.OpenOptions(stated=stated)))
    options = procam.calibrate.Options()
    options.camera.choose = options.projector.choose = True
    result = procam.calibrate.calibrate_rig(contents.correspondences, options)
    procam.analyze.check_predicted_errors(result)
    result.rig.provenance = procam.session.provenance(contents, "calibrate-projector")
    procam.io.save_rig(tmp_path / "python.json", result.rig)
    assert (tmp_path / "python.json").read_bytes() == (tmp_path / "tool.json").read_bytes()


def test_tables_are_arrays_of_records(calibrated, tmp_path):
    tables = procam.report.calibration_tables(calibrated)
    procam.report.save_files(tmp_path / "data", tables)
    residuals = numpy.load(tmp_path / "data/residuals.npy")
    assert residuals.shape == (len(calibrated.residuals),)
    assert residuals["view"][0] == calibrated.views[calibrated.residuals[0].view].name
    assert residuals["point"].dtype.kind == "i"
    assert residuals["residual_x"][3] == pytest.approx(calibrated.residuals[3].residual[0], abs=1e-10)
    parameters = numpy.load(tmp_path / "data/parameters.npy")
    fx = calibrated.rig.projector().projector.inverse_camera.intrinsics.fx
    assert parameters["value"][parameters["name"] == "projector.fx"][0] == pytest.approx(fx, rel=1e-10)
    covariance = numpy.load(tmp_path / "data/covariance.npy")
    matrix = numpy.array([[row[name] for name in covariance["name"]] for row in covariance])
    assert numpy.allclose(matrix, calibrated.rig.covariance.matrix, rtol=1e-9)
    # Signs beyond ASCII need another version of the format.
    procam.report.save_files(tmp_path / "data", [procam.report.TextFile(name="w.csv", text="wänd,\"it's\"\nzürich,\u4e2d\n")])
    assert numpy.load(tmp_path / "data/w.npy").tolist() == [("zürich", "\u4e2d")]
    assert numpy.load(tmp_path / "data/w.npy").dtype.names == ("wänd", "it's")
