"""procam.watch and procam.people: a bump of the projector is found in camera images; skeletons are read, tracked and masked."""

import json

import numpy
import pytest

import procam
from procam import people, simulate, watch


def turned(vector):
    """A quaternion (x, y, z, w) from a rotation vector."""
    vector = numpy.asarray(vector, float)
    angle = numpy.linalg.norm(vector)
    return numpy.append(numpy.sin(angle / 2) * vector / angle, numpy.cos(angle / 2))


def posed(vector, translation):
    pose = procam.Pose()
    pose.rotation = turned(vector)
    pose.translation = numpy.asarray(translation, float)
    return pose


def rig():
    camera = procam.Camera(procam.ImageSize(640, 480), procam.Intrinsics(640, 633, 322, 251, 0.4), procam.NoDistortion())
    inverse = procam.Camera(procam.ImageSize(512, 384), procam.Intrinsics(745, 739, 265, 291, -0.8), procam.NoDistortion())
    made = procam.Rig()
    made.cameras = [procam.RigCamera("camera", camera, procam.Pose())]
    made.projectors = [procam.RigProjector("projector", procam.Projector(inverse), posed([-0.06, -0.10, 0.02], [0.31, 0.05, 0.03]))]
    return made


WALL = posed([0.07, 0.16, -0.02], [-0.52, -0.42, 2.15])
SIZE = (1.0, 0.7)


def content(seed):
    coarse = numpy.random.default_rng(seed).integers(0, 256, (21, 30), dtype=numpy.uint8)
    return numpy.repeat(numpy.repeat(coarse, 10, axis=0), 10, axis=1)


def watched(seed, true_rig, frames=1):
    """Frame and camera image of a simulated wall, lit by the true rig with the frame that `rig()` draws."""
    believed = rig().projector()
    surface = procam.Surface()
    surface.name = "wall"
    planar = procam.PlanarSurface()
    planar.frame = "rig"
    planar.frame_from_surface = WALL
    planar.content = numpy.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
    planar.points = numpy.array([[0, 0], [SIZE[0], 0], SIZE, [0, SIZE[1]]], float)
    surface.geometry = planar
    surfaces = procam.SurfaceSet()
    surfaces.surfaces = [surface]
    solved = procam.surface.solve_surfaces(surfaces, believed)
    frame = procam.render.render(procam.Scene([procam.SceneItem(solved.surfaces[0].placement, content(seed))]),
                                 believed.projector)
    room = simulate.Room()
    room.ambient = 0.05
    room.bodies = [simulate.Body("wall", simulate.Rectangle(numpy.array([-1.0, -1.0]), numpy.array([2.0, 2.0])), WALL, 0.8)]
    light = simulate.RoomLight()
    light.projector = true_rig.projector().projector
    light.room_from_projector = true_rig.projector().rig_from_projector
    light.frames = [frame]
    seen = simulate.preview(room, [light], true_rig.camera().camera, procam.Pose())
    grey = numpy.ascontiguousarray(numpy.round(numpy.asarray(seen, float).mean(axis=2)).astype(numpy.uint8))
    return solved, frame, grey


def report_of(true_rig):
    solved, *_ = watched(0, true_rig)
    options = watch.WatchOptions()
    # The preview encodes sRGB, near a power of 2.2; no defocus and no noise.
    options.compare.tone.gamma = 2.2
    observer = watch.Watch(rig().camera(), rig().projector(), options)
    surfaces = watch.watched_surfaces(solved, rig().projector())
    assert [one.name for one in surfaces] == ["wall"]
    observer.place(surfaces)
    assert len(observer.geometry().cells) > 50
    assert observer.geometry().node_pixel.shape[2] == 2
    images = [watched(seed, true_rig)[1:] for seed in range(4)]
    report = None
    for i in range(60):
        frame, image = images[i % 4]
        report = observer.add(0.2 * i, watch.ShownLight(frame), image)
    return observer, report


def test_nothing_has_moved():
    observer, report = report_of(rig())
    assert report.state == watch.WatchState.kOk, report.sentence
    assert not watch.correction_of(report, observer.projector()).is_possible()


def test_a_bump_of_the_projector_is_found_and_corrected():
    bumped = rig()
    projector = bumped.projectors[0]
    projector.rig_from_projector = posed([0.004, -0.003, 0.002], [0.002, -0.001, 0.001]) * projector.rig_from_projector
    bumped.projectors = [projector]
    observer, report = report_of(bumped)
    assert report.is_alarm, report.sentence
    assert 0.004 < report.error < 0.02
    causes = report.estimate.plausible()
    assert watch.MovedThing.kProjector in [one.thing for one in causes]
    found = next(one for one in causes if one.thing == watch.MovedThing.kProjector)
    assert found.moved.shape == (6,) and found.covariance.shape == (6, 6)
    # Light error that is left: pixels of the true projector, seen by the corrected one.
    observer.correct(projector)
    assert observer.projector().rig_from_projector.translation == pytest.approx(projector.rig_from_projector.translation)
    glide = watch.Glide(rig().projector().rig_from_projector, projector.rig_from_projector, 0.01, 5.0)
    assert not glide.is_over(5.5) and glide.is_over(7.1)
    assert glide.at(8).translation == pytest.approx(projector.rig_from_projector.translation)


def test_shown_light_names_a_wrong_frame():
    with pytest.raises(TypeError, match="ShownLight: frame: expected uint8 array"):
        watch.ShownLight(numpy.zeros((4, 4), float))
    observer = watch.Watch(rig().camera(), rig().projector())
    with pytest.raises(ValueError):
        observer.add(0, watch.ShownLight(numpy.zeros((10, 12), numpy.uint8)), numpy.zeros((480, 640), numpy.uint8))
    # A light keeps its array.
    light = watch.ShownLight(numpy.zeros((384, 512, 3), numpy.uint8)[:, ::-1])
    observer.add(0, light, numpy.zeros((480, 640), numpy.uint8))


def skeleton(x):
    person = people.Skeleton()
    person[people.Joint.kHead] = people.SeenJoint(numpy.array([x, -0.6, 2.0]), 0.9)
    person[people.Joint.kRightHand] = people.SeenJoint(numpy.array([x + 0.3, -0.1, 1.6]))
    return person


def test_skeletons_are_read_and_tracked():
    frame = people.SkeletonFrame(stamp=2.5, frame="sensor", people=[skeleton(0.4)])
    line = people.to_json_line(frame)
    parsed = people.parse_skeletons(line + "no json\n")
    assert parsed.malformed == 1 and len(parsed.frames) == 1
    again = parsed.frames[0].people[0]
    assert again.position(people.Joint.kHead) == pytest.approx([0.4, -0.6, 2.0])
    assert again[people.Joint.kLeftHand] is None
    assert people.hand_of(again, people.Side.kRight) == pytest.approx([0.7, -0.1, 1.6])
    assert people.why_refused(parsed.frames[0]) is None
    far = people.SkeletonFrame(people=[skeleton(30.0)])
    assert people.why_refused(far)

    track = people.PeopleTrack()
    for i in range(20):
        assert track.add(people.SkeletonFrame(stamp=i / 30, arrival=i / 30 + 0.02, people=[skeleton(0.4 + 0.01 * i)]))
    seen = track.at(20 / 30)
    assert len(seen) == 1 and seen[0].sightings == 20
    assert seen[0].skeleton.position(people.Joint.kHead)[0] == pytest.approx(0.6, abs=0.02)
    assert people.find_person(seen, seen[0].number).number == seen[0].number
    assert people.find_person(seen, None) is None


def test_heads_are_kept_dark():
    lamp = rig().projector().projector
    frame = numpy.full((384, 512, 3), 255, numpy.uint8)
    track = people.PeopleTrack()
    person = people.Skeleton()
    person[people.Joint.kHead] = people.SeenJoint(numpy.array([0.1, -0.2, 2.0]))
    track.add(people.SkeletonFrame(stamp=1.0, arrival=1.0, people=[person]))
    result = people.darken_heads(frame, lamp, procam.Pose(), track, 1.05)
    assert result.masked == 1 and not result.blanked
    x, y = numpy.round(lamp.project(numpy.array([0.1, -0.2, 2.0]))).astype(int)
    assert not frame[y, x].any() and frame[383, 0].all()
    assert people.darken_heads(frame, lamp, procam.Pose(), track, 9.0).blanked


def test_hands_and_zones():
    zone = people.Zone(numpy.array([[0, 0], [0.4, 0], [0.4, 0.3], [0, 0.3]]))
    Event = people.Zone.Event
    assert zone.update(numpy.array([0.2, 0.15]), 1.0) == Event.kEntered
    assert zone.update(numpy.array([0.2, 0.15]), 2.1) == Event.kDwelled
    assert zone.update(None, 2.2) == Event.kNone and zone.is_inside()
    assert zone.update(None, 2.6) == Event.kLeft
    touch = people.Touch()
    near = people.on_surface(numpy.array([0.1, 0.2, -0.05]), procam.Pose())
    assert near.distance == pytest.approx(0.05) and touch.update(near) and not touch.update(None)


def test_somebody_before_the_wall_is_kept_dark():
    camera = procam.Camera(procam.ImageSize(160, 120), procam.Intrinsics(150, 148, 81, 57, 0), procam.NoDistortion())
    background = numpy.full((120, 160), 3.0, numpy.float32)
    depth = background.copy()
    depth[40:80, 60:90] = 1.5
    seen = people.find_silhouettes(camera, depth, background)
    assert len(seen.seen) > 3 and seen.seen[0].middle[2] == pytest.approx(1.5, abs=0.1)
    frame = numpy.full((384, 512, 3), 255, numpy.uint8)
    result = people.darken_silhouettes(frame, rig().projector().projector, procam.Pose(), seen, 0.05)
    assert result.masked > 0 and (frame == 0).any() and not result.blanked
    with pytest.raises(ValueError):
        people.find_silhouettes(camera, depth[:-1], background)


def test_other_programs_joints():
    text = json.dumps({"people": [{"pose_keypoints_2d": [100, 50, 0.9] + [0, 0, 0] * 24}]})
    seen = people.parse_openpose(text)
    assert seen.why == "" and len(seen.people) == 1
    camera = rig().camera().camera
    lifted = people.lifted(seen.people[0], camera, lambda pixel: 2.0)
    assert lifted.position(people.Joint.kNose)[2] == pytest.approx(2.0)
    assert people.parse_openpose("{").why
