"""The stages one by one: patterns, detection, poses in time, depth, simulation, files, patterns in Python."""

import copy
import json

import numpy
import pytest

import procam


def world(seed=4):
    return procam.simulate.make_session(procam.simulate.Level.kEasy, seed)


def test_gray_code_frames_decode_from_arrays():
    code = procam.pattern.GrayCode(procam.ImageSize(60, 44), 1)
    frames = procam.pattern.frames(code)
    assert len(frames) == procam.pattern.frame_count(code)
    assert all(frame.shape == (44, 60) and frame.dtype == numpy.uint8 for frame in frames)
    # A camera that sees each projector pixel twice across and three times down.
    captures = [numpy.repeat(numpy.repeat(frame, 3, axis=0), 2, axis=1) for frame in frames]
    decoded = procam.pattern.decode(captures, code)
    assert decoded.columns.shape == (132, 120) and decoded.columns.dtype == numpy.int16
    assert decoded.camera_size() == procam.ImageSize(120, 132)
    want = numpy.repeat(numpy.arange(60), 2)[None, :].repeat(132, axis=0)
    assert (decoded.columns == want).mean() > 0.95
    with pytest.raises((ValueError, procam.Error)):
        procam.pattern.decode(captures[:-1], code)
    with pytest.raises(TypeError, match="decode: captures: expected uint8 array"):
        procam.pattern.decode([frame.astype(float) for frame in captures], code)
    with pytest.raises(TypeError, match="decode: captures: expected sequence"):
        procam.pattern.decode(5, code)
    # Elements that live only as long as the sequence hands them out.
    class Handed:
        def __len__(self):
            return len(captures)

        def __getitem__(self, i):
            return captures[range(len(captures))[i]].copy()

    again = procam.pattern.decode(Handed(), code)
    assert (again.columns == decoded.columns).all()


def test_phase_shift_frames():
    shift = procam.pattern.PhaseShift(procam.ImageSize(64, 48), 16)
    frames = procam.pattern.frames(shift)
    assert len(frames) == procam.pattern.frame_count(shift)
    light = procam.pattern.decode([numpy.kron(frame, numpy.ones((2, 2), numpy.uint8)) for frame in frames], shift)
    assert light.pixel.shape[:2] == (96, 128)


def test_a_board_is_found_where_it_is():
    session = world()
    view = session.views[0]
    image = procam.simulate.capture_view(session, 0, [numpy.full((768, 1024), 255, numpy.uint8)])[0]
    size = view.rig.projector().projector.size()
    assert (size.width, size.height) == (1024, 768)
    detections = procam.detect.detect_board(image, session.stated_board)
    truth = {one.point: one.pixel for one in procam.simulate.board_in_camera(view)}
    assert len(detections.observations) > 20
    errors = [numpy.linalg.norm(one.pixel - truth[one.point]) for one in detections.observations]
    assert numpy.sqrt(numpy.mean(numpy.square(errors))) < 0.2
    blank = procam.detect.detect_board(numpy.zeros_like(image), session.stated_board)
    assert not blank.observations and blank.diagnostics.items


def test_poses_are_tracked_and_predicted():
    track = procam.track.PoseTrack(procam.track.TrackOptions(frame="world", child="rig"))
    speed = 0.4
    for i in range(100):
        pose = procam.Pose([0, 0, 0, 1], [speed * i * 0.02, 0, 0])
        track.add(procam.track.StampedPose(stamp=i * 0.02, arrival=100 + i * 0.02, frame="world", child="rig", frame_from_child=pose))
    assert track.faults().taken == 100
    now = track.at(100 + 99 * 0.02 + 0.05)
    assert now.state == procam.track.TrackState.kFresh
    assert now.frame_from_child.translation[0] == pytest.approx(speed * (99 * 0.02 + 0.05), abs=0.02)
    assert now.covariance.shape == (6, 6)
    line = procam.track.to_json_line(procam.track.StampedPose(stamp=1.5, frame="world", child="rig"))
    parsed = procam.track.parse_poses(line)
    assert parsed.poses[0].stamp == 1.5 and parsed.malformed == 0
    assert isinstance(procam.track.to_binary(parsed.poses[0]), bytes)


def test_an_image_corrects_the_poses_of_a_localiser():
    """The localiser is 20 mm off along x; an image that sees all directions says so."""
    base_from_rig = procam.Pose([-0.5, 0.5, -0.5, 0.5], [0.2, -0.07, 0.8])
    off = procam.Pose([0, 0, 0, 1], [0.02, 0, 0])
    options = procam.track.PoseCorrectionOptions(child_from_rig=base_from_rig, position_sigma=0.03)
    correction = procam.track.PoseCorrection(options)
    with pytest.raises(ValueError):
        procam.track.PoseCorrection(procam.track.PoseCorrectionOptions(correlation=-1))
    said = None
    for i in range(20):
        message = procam.track.StampedPose(arrival=10 + 0.1 * i, frame="map", child="base", frame_from_child=off)
        said = correction.add(message)
    assert said.frame_from_child.translation[0] == pytest.approx(0.02, abs=1e-6)  # no image yet: handed on
    seen = off * base_from_rig
    increment = procam.se3_log(base_from_rig.inverse() * seen)
    information = 1e8 * numpy.eye(6)
    sight = procam.track.PoseSight(time=11.9, world_from_rig=seen, information=information, score=information @ increment)
    corrected = correction.add(sight)
    assert corrected.frame_from_child.translation[0] == pytest.approx(0, abs=2e-4)
    status = correction.status()
    assert status.taken == 1 and status.refused == 0 and status.error[3] == pytest.approx(-0.02, abs=2e-4)
    assert correction.add([sight, sight]).arrival == pytest.approx(corrected.arrival)
    assert correction.status().taken == 3


def test_markers_place_the_camera():
    session = world()
    camera = session.views[0].rig.camera().camera
    cells = procam.detect.marker_cells(procam.MarkerDictionary.k4x4_50)
    marker = procam.PlacedMarker(id=3, size=0.2, world_from_marker=procam.Pose())
    camera_from_world = procam.se3_exp([0.2, -0.3, 0.1, 0, 0, 0])
    camera_from_world.translation = [0.05, -0.02, 1.4]
    image = procam.simulate.marker_view(camera, camera_from_world, [marker], cells)
    found = procam.detect.detect_marker_edges(image, cells, procam.detect.MarkerEdgeOptions(camera=camera))
    assert [one.id for one in found.markers] == [3]
    marker_map = procam.MarkerMap(dictionary=procam.MarkerDictionary.k4x4_50, markers=[marker])
    located = procam.track.locate(found, camera, marker_map)
    error = procam.se3_log(located.camera_from_world * camera_from_world.inverse())
    assert numpy.linalg.norm(error[:3]) < 0.02 and numpy.linalg.norm(error[3:]) < 0.02


def test_planes_of_a_depth_image():
    intrinsics = procam.Intrinsics(fx=285.0, fy=285.0, cx=159.5, cy=119.5)
    camera = procam.Camera(procam.ImageSize(320, 240), intrinsics)
    rays = procam.depth.RayTable(camera)
    depth = numpy.full((240, 320), 2.0, numpy.float32)
    depth += numpy.random.default_rng(5).normal(0, 0.002, depth.shape).astype(numpy.float32)
    planes = procam.depth.find_planes(procam.depth.DepthImage(depth), rays)
    assert len(planes.planes) == 1
    plane = planes.planes[0].estimate.plane
    assert abs(plane.normal[2]) == pytest.approx(1, abs=1e-3) and abs(plane.offset) == pytest.approx(2.0, abs=0.005)
    units = (depth * 1000).astype(numpy.uint16)
    again = procam.depth.find_planes(procam.depth.DepthImage(units, 0.001), rays)
    assert len(again.planes) == 1
    image = procam.depth.DepthImage(units.copy(), 0.001)
    assert image.at(5, 6) == pytest.approx(units[6, 5] * 0.001)
    with pytest.raises(ValueError):
        image.at(320, 0)
    with pytest.raises(TypeError, match="DepthImage: pixels"):
        procam.depth.DepthImage(units.astype(numpy.float64))


def test_blending_two_projectors(projector):
    surface = procam.Surface(name="wall", geometry=procam.PlanarSurface(
        frame="projector", frame_from_surface=procam.Pose([0, 0, 0, 1], [-0.4, -0.9, 2.0]),
        content=[(0, 0), (1, 0), (1, 1), (0, 1)], points=[(0, 0), (0.8, 0), (0.8, 0.5), (0, 0.5)]))
    solved = procam.surface.solve_surfaces(procam.SurfaceSet([surface]), procam.RigProjector("a", projector, procam.Pose()))
    one = procam.surface.BlendInput(projector, solved)
    blend = procam.surface.blend_maps([one, one])
    assert len(blend.maps) == 2
    weights = [each.weight for each in blend.maps]
    lit = weights[0] > 0
    assert lit.any() and numpy.allclose((weights[0] + weights[1])[lit], 1, atol=1e-3)
    frame = numpy.full((400, 640, 3), 200, numpy.uint8)
    procam.surface.apply_blend(blend.maps[0], frame)
    assert frame.max() <= 200 and (frame < 200).any()
    part = procam.surface.VisiblePart(solved, projector)
    assert 0 < part.share() < 1
    warp = procam.surface.warp_map(solved.surfaces[0].placement, projector)
    assert warp.content.shape == (400, 640, 3)  # x, y, shown


def test_a_blend_is_made_ready_for_many_frames(projector):
    surface = procam.Surface(name="wall", geometry=procam.PlanarSurface(
        frame="projector", frame_from_surface=procam.Pose([0, 0, 0, 1], [-0.4, -0.9, 2.0]),
        content=[(0, 0), (1, 0), (1, 1), (0, 1)], points=[(0, 0), (0.8, 0), (0.8, 0.5), (0, 0.5)]))
    solved = procam.surface.solve_surfaces(procam.SurfaceSet([surface]), procam.RigProjector("a", projector, procam.Pose()))
    one = procam.surface.BlendInput(projector, solved)
    blend = procam.surface.blend_maps([one, one]).maps[0]
    size = projector.size()
    ready = procam.surface.FrameBlend(blend, gamma=2.2)
    assert ready.size() == size and 0 < ready.changed_share() <= 1
    want = numpy.random.default_rng(4).integers(0, 256, (size.height, size.width, 3), dtype=numpy.uint8)
    frame, halves = want.copy(), want.copy()
    procam.surface.apply_blend(blend, want, gamma=2.2)
    ready.apply(frame)
    assert (frame == want).all()
    ready.apply(halves, 0, 100)
    ready.apply(halves, 100, size.height)
    assert (halves == want).all()
    with pytest.raises(ValueError):
        ready.apply(numpy.zeros((10, 10, 3), numpy.uint8))
    with pytest.raises(ValueError):
        ready.apply(frame, 0, size.height + 1)


def test_a_camera_sees_a_show_frame_by_frame():
    simulate = procam.simulate
    camera = procam.Camera(procam.ImageSize(120, 90), procam.Intrinsics(100, 102, 58, 47))
    projector = procam.Projector(procam.Camera(procam.ImageSize(64, 48), procam.Intrinsics(70, 71, 30, 25)))
    wall = simulate.Body("wall", simulate.Rectangle([-2.0, -2.0], [2.0, 2.0]), procam.Pose([0, 0, 0, 1], [0, 0, 2.0]), 0.8)
    room = simulate.Room(bodies=[wall], ambient=0.05)
    light = simulate.RoomLight(projector=projector, room_from_projector=procam.Pose([0, 0, 0, 1], [0.1, 0, 0]))
    noisy = simulate.RoomViewOptions(noise=procam.NoiseModel(at_black=4.0, per_level=0.02))
    view = simulate.LiveView(room, camera, procam.Pose(), [light], simulate.LiveViewOptions(view=noisy))
    assert view.exposure() > 0
    assert view.light().pixel.shape == (90, 120, 2)
    left = numpy.zeros((48, 64), numpy.uint8)
    left[:, :32] = 255
    seen = view.capture([view.light_of(left)], 1)
    assert seen.shape == (90, 120) and seen.dtype == numpy.uint8
    lit = view.light().lit == 1
    bright = lit & (view.light().pixel[:, :, 0] < 28)
    dark = lit & (view.light().pixel[:, :, 0] > 36)
    assert bright.sum() > 500 and dark.sum() > 500
    assert seen[bright].mean() > 3 * seen[dark].mean()
    # Noise alone differs by the number.
    again = view.capture([view.light_of(left)], 1)
    other = view.capture([view.light_of(left)], 2)
    assert (again == seen).all() and (other != seen).any()
    with pytest.raises(ValueError, match="no projector of that number"):
        view.light(3)
    with pytest.raises(ValueError):
        view.capture([], 1)
    with pytest.raises(ValueError):
        view.light_of(numpy.zeros((10, 10), numpy.uint8))


def test_files_come_back(tmp_path):
    board = procam.CharucoBoard(columns=7, rows=5, square_size=0.03, marker_size=0.02)
    procam.io.save_board(tmp_path / "board.json", board)
    assert procam.io.load_board(tmp_path / "board.json") == board
    rng = numpy.random.default_rng(0)
    image = rng.integers(0, 256, (20, 31, 3), dtype=numpy.uint8)
    procam.io.save_image(tmp_path / "image.png", image)
    assert (procam.io.load_image(tmp_path / "image.png").image == image).all()
    depth = rng.integers(0, 5000, (20, 31), dtype=numpy.uint16)
    procam.io.save_depth(tmp_path / "depth.png", depth)
    assert (procam.io.load_depth(tmp_path / "depth.png") == depth).all()
    assert procam.io.encode_png(image)[:4] == b"\x89PNG"
    sequence = procam.pattern.sequence(procam.pattern.PhaseShift(procam.ImageSize(64, 48), 16))
    procam.io.save_pattern(tmp_path / "pattern.json", sequence)
    assert len(procam.io.load_pattern(tmp_path / "pattern.json").frames) == len(sequence.frames)
    assert procam.io.parse_size("640x400") == procam.ImageSize(640, 400)


def test_boards_are_variants():
    board = procam.Chessboard(9, 6, 0.025)
    assert procam.points_in_board(board).shape == (54, 3)
    correspondences = procam.Correspondences(board=board)
    assert correspondences.board == board
    with pytest.raises(TypeError):
        correspondences.board = 5


class Inverted(procam.session.SessionPattern):
    """The Gray code in another order: captures come last frame first."""

    def __init__(self, size):
        super().__init__()
        self.gray = procam.session.make_pattern("gray", size)
        self.reads = []

    def text(self):
        return self.gray.text()

    def describe(self):
        return "last frame first"

    def frames(self):
        return self.gray.frames()[::-1]

    def frame_count(self):
        return self.gray.frame_count()

    def read(self, view_name, captures, board):
        self.reads.append(view_name)
        return self.gray.read(view_name, captures[::-1], board)


def test_a_pattern_of_python_reads_a_session(captures, contents, tmp_path):
    import shutil

    folder = tmp_path / "session"
    shutil.copytree(captures, folder)
    for view in sorted(folder.glob("view_*")):
        frames = sorted(view.glob("frame_*.png"))
        data = [frame.read_bytes() for frame in frames]
        for frame, bytes_ in zip(frames, reversed(data)):
            frame.write_bytes(bytes_)
    plan = procam.session.open(folder)
    pattern = Inverted(plan.projectors[0].size)
    plan.projectors[0].pattern = pattern
    assert plan.projectors[0].pattern is pattern
    read = procam.session.read(plan)
    assert sorted(pattern.reads) == ["view_00", "view_01", "view_02", "view_03"]
    for mine, want in zip(read.correspondences.views, contents.correspondences.views):
        assert mine.name == want.name
        assert len(mine.observations[1]) == len(want.observations[1]) > 10
        for a, b in zip(mine.observations[1], want.observations[1]):
            assert (a.pixel == b.pixel).all()


def test_an_exception_of_a_pattern_of_python_passes_through(captures):
    class Broken(Inverted):
        def read(self, view_name, captures, board):
            raise LookupError(view_name)

    plan = procam.session.open(captures)
    plan.projectors[0].pattern = Broken(plan.projectors[0].size)
    with pytest.raises(LookupError, match="view_0"):
        procam.session.read(plan)
    with pytest.raises(TypeError, match="SessionPattern"):
        plan.projectors[0].pattern = 5


def test_a_pattern_that_lacks_a_method_is_an_error():
    class Empty(procam.session.SessionPattern):
        pass

    with pytest.raises(RuntimeError, match="frames"):
        Empty().frames()


def test_a_scan_of_exact_light_is_exact(tmp_path):
    rig = procam.simulate.make_session(procam.simulate.Level.kPaper, 3).rig()
    camera, projector = rig.camera(), rig.projector()
    rays = procam.scan.pixel_rays(camera.camera).astype(float)
    height, width = rays.shape[:2]
    points = numpy.dstack([rays, numpy.ones((height, width))]).reshape(-1, 3) * 1.6
    rig_from_camera = camera.rig_from_camera.matrix()
    projector_from_rig = numpy.linalg.inv(projector.rig_from_projector.matrix())
    moved = points @ (projector_from_rig @ rig_from_camera)[:3, :3].T + (projector_from_rig @ rig_from_camera)[:3, 3]
    pixels, seen = projector.projector.project_points(moved)
    size = projector.projector.size()
    lit = seen & (pixels > -0.5).all(axis=1) & (pixels < [size.width - 0.5, size.height - 0.5]).all(axis=1)
    assert lit.sum() > 10000
    light = procam.LightMap()
    light.projector_size = size
    light.pixel = numpy.where(lit[:, None], pixels, 0).reshape(height, width, 2).astype(numpy.float32)
    light.sigma = numpy.where(lit[:, None], 0.05, 0).repeat(2, axis=1).reshape(height, width, 2).astype(numpy.float32)
    scan = procam.scan.measure_depth(light, rig)
    measured = scan.depth > 0
    assert measured.sum() > 0.999 * lit.sum()
    assert abs(scan.depth[measured] - 1.6).max() < 1e-3
    error = procam.scan.compare(scan, numpy.full((height, width), 1.6, numpy.float32))
    assert error.rms < 2e-4 and error.outliers == 0
    mesh = procam.scan.mesh_of(scan)
    assert 2 <= len(mesh.triangles) < measured.sum() / 4
    procam.io.save_mesh(tmp_path / "scan.ply", mesh)
    procam.io.save_points(tmp_path / "scan.pcd", procam.scan.point_cloud(scan))
    assert (tmp_path / "scan.pcd").stat().st_size > 28 * measured.sum()


def test_the_mount_of_a_rig_from_a_drive():
    simulate = procam.simulate
    options = simulate.MountDriveOptions()
    options.seed = 11
    made = simulate.mount_drive(simulate.random_walk(0.5, 15.0, 11), options)
    true = made.sightings.base_from_rig.translation
    data = procam.MountData()
    data.base = [procam.BasePose(p.stamp, p.frame_from_child) for p in made.base]
    data.sightings = [procam.MarkerSighting(s.stamp, s.frame, procam.PoseWithCovariance(s.frame_from_child, s.covariance))
                      for s in made.sightings.messages]
    wanted = procam.calibrate.MountOptions()
    with pytest.raises(procam.Error, match="height"):
        procam.calibrate.calibrate_mount(data, wanted)
    wanted.height = procam.calibrate.MountHeight(true[2], 0.002)
    found = procam.calibrate.calibrate_mount(data, wanted)
    assert found.unobservable() == ["height"]
    assert abs(found.base_from_rig.pose.translation - true).max() < 0.01
    assert abs(found.time_offset - made.time_offset) < 0.01
    assert "<svg" in procam.report.mount_picture(found, data)


def test_a_plane_by_the_light_of_the_rig(projector, tmp_path):
    camera = procam.RigCamera("camera", procam.Camera(procam.ImageSize(640, 480), procam.Intrinsics(640, 633, 322, 251, 0.4),
                                                      procam.BrownConrady([-0.17, 0.05, 0.0009, -0.0006, 0])), procam.Pose())
    light = procam.RigProjector("projector", projector, procam.se3_exp([0.02, -0.1, 0.01, 0.3, 0.05, 0.02]))
    wall = procam.Plane.through([0.1, 0, 2], [0.3, 0.1, -1])
    points = []
    for u in range(40, 640, 80):
        for v in range(30, 400, 60):
            point = procam.LightPoint()
            point.projector_pixel = [u, v]
            ray = light.rig_from_projector * projector.emit([u, v])
            point.camera_pixel = camera.camera.project(procam.intersect(ray, wall))
            points.append(point)
    seen = procam.track.sight_plane(points, camera, light)
    assert seen.used == len(points) and list(seen.rejected) == []
    found = procam.Plane.of_xy(seen.plane_from_rig.pose.inverse())
    assert abs(found.normal - wall.normal).max() < 1e-9 and abs(found.offset - wall.offset) < 1e-9
    frame = procam.session.still_frame("markers", projector.size())
    assert frame.shape[:2] == (400, 640)
    images = procam.session.LightImages()
    images.folder = tmp_path
    with pytest.raises(procam.Error, match="holds no image"):
        procam.session.planes_in_light(images, camera, light)


def light_on(room, rig_camera, projector, capture, random):
    """The light map that a camera at this place reads, with noise of 0.05 px."""
    size = projector.projector.size()
    white = numpy.full((size.height, size.width), 255, numpy.uint8)
    seen = procam.simulate.scan_view(capture, room, rig_camera, projector, [white]).truth.light[0]
    lit = seen.lit > 0
    light = procam.LightMap()
    light.projector_size = size
    noise = random.normal(0, 0.05, seen.pixel.shape)
    light.pixel = numpy.where(lit[..., None], seen.pixel + noise, 0).astype(numpy.float32)
    light.sigma = numpy.where(lit[..., None], 0.05, 0).repeat(2, axis=2).astype(numpy.float32)
    return light


def test_a_rig_from_the_light_on_a_room():
    room, simulate = procam.room, procam.simulate
    session = simulate.make_session(simulate.Level.kPaper, 3)
    rig, corner = session.rig(), simulate.scan_scene("corner")
    projector = rig.projector()
    capture = copy.copy(session.capture)
    capture.samples_per_axis = 1
    random, lights = numpy.random.default_rng(5), []
    for view in (0, 1):
        camera = copy.copy(rig.camera())
        camera.rig_from_camera = simulate.moved_camera(camera.rig_from_camera, view)
        lights.append(room.PositionLight("camera", f"view_{view}", "projector", light_on(corner, camera, projector, capture, random)))
    points = room.room_points(lights, room.RoomPointsOptions(points_a_map=1500))
    assert len(points.points) > 500 and len(points.positions) == 2
    known = numpy.linalg.norm(rig.camera().rig_from_camera.translation - projector.rig_from_projector.translation)
    options = room.RoomOptions(cameras={"camera": room.CameraLens(rig.camera().camera, sigma=0.0)},
                               distances=[room.KnownDistance(devices=["camera", "projector"], length=known, sigma=1e-4)])
    result = room.calibrate_room(points, options)
    found = result.rig.projector().projector.inverse_camera.intrinsics
    truth = projector.projector.inverse_camera.intrinsics
    assert abs(found.fx / truth.fx - 1) < 2e-3 and abs(found.cy - truth.cy) < 4
    # Fitted over 5 x 5 pixels.
    assert 0.005 < result.rms_px < 0.02 and not result.planar and len(result.walls.points) == result.points
    deviations = room.deviations(result.rig, rig)
    assert {d.name for d in deviations} >= {"projector.fx", "projector.skew"}
    # Of 16 numbers, one beyond 4.5 deviations once in 10^4 rigs.
    assert max(abs(d.sigmas()) for d in deviations) < 4.5
    report = procam.report.RoomReport(result, deviations, 1.0)
    assert "held_out_px" in procam.report.to_json(report) and json.loads(procam.report.to_json(report))
    assert any("projector" in line for line in procam.report.lines(report))
    assert procam.report.room_calibration_picture(result).ndim == 3

    with pytest.raises(ValueError, match="no known distance"):
        room.calibrate_room(points, room.RoomOptions(cameras=options.cameras))
