"""Images, points and matrices between numpy and the library; what is refused, and how."""

import copy
import pickle

import numpy
import pytest

import procam


def test_points_of_another_shape_are_refused_with_the_argument_and_both_shapes():
    points = numpy.zeros((4, 3))
    with pytest.raises(ValueError, match=r"fit_homography: source: expected float64 array of shape \(n, 2\), "
                                         r"found float64 array of shape \(4, 3\)"):
        procam.fit_homography(points, numpy.zeros((4, 2)))


@pytest.mark.parametrize("wrong", ["text", {"a": 1}, None, numpy.zeros((4, 2), complex), object(), numpy.array(["a", "b"])])
def test_points_of_another_type_are_refused(wrong):
    with pytest.raises(TypeError, match="fit_homography: source: expected float64 array"):
        procam.fit_homography(wrong, numpy.zeros((4, 2)))


@pytest.mark.parametrize("dtype", [numpy.float64, numpy.float32, numpy.int32, numpy.uint8, ">f8"])
def test_points_of_other_number_types_are_converted(dtype):
    square = numpy.array([[0, 0], [8, 0], [8, 6], [0, 6]])
    fit = procam.fit_homography(square.astype(dtype), 3.0 * square + [5, 7])
    pixel = fit.destination_from_source.apply([1, 2])
    assert numpy.allclose(pixel, [8, 13], atol=1e-9)


def test_lists_are_points():
    fit = procam.fit_homography([(0, 0), (8, 0), (8, 6), (0, 6)], [(1, 1), (9, 1), (9, 7), (1, 7)])
    assert numpy.allclose(fit.residuals, 0, atol=1e-9)
    assert fit.residuals.shape == (4, 2)


@pytest.mark.parametrize("bad", [numpy.nan, numpy.inf])
def test_points_that_are_not_finite_are_refused_by_the_library(bad):
    square = numpy.array([[0, 0], [8, 0], [8, 6], [0, bad]])
    with pytest.raises((ValueError, procam.Error)):
        procam.fit_homography(square, square)


def test_no_points_are_refused_by_the_library():
    with pytest.raises((ValueError, procam.Error)):
        procam.fit_homography(numpy.zeros((0, 2)), numpy.zeros((0, 2)))


@pytest.mark.parametrize("wrong, found", [
    (numpy.zeros((4, 5), numpy.float64), "float64 array"),
    (numpy.zeros((4, 5), numpy.int8), "int8 array"),
    ([[1, 2], [3, 4]], "list"),
    (None, "None"),
    ("picture.png", "str"),
])
def test_images_of_another_type_are_refused(wrong, found):
    with pytest.raises(TypeError, match=f"to_gray: image: expected uint8 array of shape .*, found {found}"):
        procam.io.to_gray(wrong)


@pytest.mark.parametrize("shape", [(5,), (2, 3, 4, 1), (), (4, 5, 0)])
def test_images_of_another_shape_are_refused(shape):
    with pytest.raises(ValueError, match="to_gray: image: expected uint8 array"):
        procam.io.to_gray(numpy.zeros(shape, numpy.uint8))


def test_an_image_in_any_layout_reads_the_same():
    rng = numpy.random.default_rng(1)
    image = rng.integers(0, 256, (40, 61, 3), dtype=numpy.uint8)
    want = procam.io.to_gray(image)
    assert want.shape == (40, 61) and want.dtype == numpy.uint8
    wide = numpy.zeros((40, 100, 3), numpy.uint8)
    wide[:, 20:81] = image
    layouts = {
        "rows apart": wide[:, 20:81],
        "every second row": numpy.repeat(image, 2, axis=0)[::2],
        "Fortran order": numpy.asfortranarray(image),
        "upside down": image[::-1].copy()[::-1],
        "mirrored": image[:, ::-1].copy()[:, ::-1],
        "channels turned": image[..., ::-1].copy()[..., ::-1],
    }
    for name, view in layouts.items():
        assert (view == image).all(), name
        assert (procam.io.to_gray(view) == want).all(), name
    read_only = image.copy()
    read_only.setflags(write=False)
    assert (procam.io.to_gray(read_only) == want).all()


def test_an_array_from_the_library_owns_its_pixels():
    image = procam.io.to_gray(numpy.full((300, 400, 3), 77, numpy.uint8))
    assert image.flags.writeable and image.flags.c_contiguous
    image[:] = 5
    assert image.sum() == 5 * 300 * 400
    part = image[10:20]
    del image
    assert (part == 5).all()


def test_a_frame_is_drawn_into_an_array_in_place(scene, projector):
    want = procam.render.render(scene, projector)
    assert want.shape == (400, 640, 3) and want.dtype == numpy.uint8
    around = numpy.full((402, 650, 3), 99, numpy.uint8)
    assert procam.render.render(scene, projector, around[1:401, 5:645]) is None
    assert (around[1:401, 5:645] == want).all()
    around[1:401, 5:645] = 99
    assert (around == 99).all()


@pytest.mark.parametrize("wrong", [
    numpy.zeros((400, 640, 3), numpy.float32),
    numpy.zeros((3, 640, 400), numpy.uint8).T,
    numpy.zeros((400, 640, 3), numpy.uint8)[::-1],
])
def test_an_array_that_cannot_be_drawn_into_is_refused(scene, projector, wrong):
    with pytest.raises(TypeError, match="render: frame: expected writable uint8 array"):
        procam.render.render(scene, projector, wrong)


def test_a_read_only_array_is_refused(scene, projector):
    frame = numpy.zeros((400, 640, 3), numpy.uint8)
    frame.setflags(write=False)
    with pytest.raises(TypeError, match="read-only"):
        procam.render.render(scene, projector, frame)


@pytest.mark.parametrize("shape", [(640, 400, 3), (400, 640), (400, 640, 4), (0, 0, 3)])
def test_a_frame_of_another_size_is_refused_by_the_library(scene, projector, shape):
    with pytest.raises(ValueError):
        procam.render.render(scene, projector, numpy.zeros(shape, numpy.uint8))


def test_a_vector_field_is_part_of_its_struct():
    pose = procam.Pose()
    pose.translation[1] = 4.0
    assert pose.matrix()[1, 3] == 4.0
    pose.translation = [1, 2, 3]
    assert (pose.translation == [1, 2, 3]).all()
    with pytest.raises(ValueError, match=r"Pose: translation: expected float64 array of shape \(3,\), found .*\(2,\)"):
        pose.translation = numpy.zeros(2)
    translation = pose.translation
    del pose
    assert (translation == [1, 2, 3]).all()


def test_a_list_field_is_a_copy_that_cannot_be_changed():
    mesh = procam.Mesh(vertices=numpy.eye(3), triangles=[[0, 1, 2]])
    with pytest.raises(ValueError):
        mesh.vertices[0, 0] = 5
    mesh.vertices = 2 * mesh.vertices
    assert (mesh.vertices == 2 * numpy.eye(3)).all()
    surfaces = procam.SurfaceSet()
    with pytest.raises(AttributeError):
        surfaces.surfaces.append(procam.Surface())
    surfaces.surfaces = [*surfaces.surfaces, procam.Surface(name="wall")]
    assert [one.name for one in surfaces.surfaces] == ["wall"]


def test_structs_are_made_with_their_fields():
    assert procam.ImageSize(640, height=400) == procam.ImageSize(width=640, height=400)
    with pytest.raises(TypeError, match="ImageSize: no field 'depth'; its fields are width, height"):
        procam.ImageSize(depth=3)
    with pytest.raises(TypeError, match="at most 2 fields"):
        procam.ImageSize(1, 2, 3)
    with pytest.raises(TypeError, match="given twice"):
        procam.ImageSize(1, width=2)
    assert repr(procam.ImageSize(3, 4)) == "ImageSize(width=3, height=4)"


def test_points_go_through_a_lens_together(projector):
    points = numpy.random.default_rng(2).uniform([-1, -1, -0.5], [1, 1, 3], (50, 3))
    pixels, seen = projector.project_points(points)
    assert pixels.shape == (50, 2) and seen.shape == (50,) and 0 < seen.sum() < 50
    for point, pixel, is_seen in zip(points, pixels, seen):
        one = projector.project(point)
        assert (one is not None) == is_seen
        assert numpy.isnan(pixel).all() if one is None else (pixel == one).all()


def test_quaternions_read_x_y_z_w():
    pose = procam.Pose([0, 0, numpy.sqrt(0.5), numpy.sqrt(0.5)], [0, 0, 0])
    assert numpy.allclose(pose * [1, 0, 0], [0, 1, 0])
    assert numpy.allclose(procam.se3_log(pose), [0, 0, numpy.pi / 2, 0, 0, 0])
    assert numpy.allclose((pose * pose.inverse()).matrix(), numpy.eye(4))


def test_a_quaternion_is_brought_to_unit_length():
    pose = procam.Pose([0, 0, 3, 4], [1, 2, 3])
    assert numpy.allclose(pose.rotation, [0, 0, 0.6, 0.8])
    assert numpy.allclose(procam.Pose.from_rotation_matrix(pose.rotation_matrix(), [1, 2, 3]).matrix(), pose.matrix())


def test_matrices_that_are_no_rotation_are_refused():
    """They were poses of the nearest quaternion: a scaled or mirrored matrix went unnoticed."""
    mirrored = numpy.diag([1.0, 1, -1, 1])
    for wrong in (2 * numpy.eye(4), mirrored, numpy.full((4, 4), numpy.nan)):
        with pytest.raises(ValueError, match="from_matrix: matrix"):
            procam.Pose.from_matrix(wrong)
    for wrong in (2 * numpy.eye(3), mirrored[1:, 1:], numpy.zeros((3, 3))):
        with pytest.raises(ValueError, match="from_rotation_matrix: rotation: the rotation is not orthonormal"):
            procam.Pose.from_rotation_matrix(wrong, [0, 0, 0])
    for wrong in ([0, 0, 0, 0], [0, 0, 0, numpy.nan], [0, numpy.inf, 0, 1]):
        with pytest.raises(ValueError, match="Pose: rotation: a quaternion of length 0, or not finite"):
            procam.Pose(wrong, [0, 0, 0])
    turned = procam.Pose([0.1, 0.2, 0.3, 0.9], [1, 2, 3])
    again = procam.Pose.from_matrix(turned.matrix())
    assert numpy.abs(again.matrix() - turned.matrix()).max() < 1e-15


def structs(contents):
    camera = procam.Camera(procam.ImageSize(640, 480), procam.Intrinsics(500, 510, 320, 700, 0.5),
                           procam.BrownConrady((0.1, 0.2, 0.001, 0.002, 0.3)))
    rig = procam.Rig(cameras=[procam.RigCamera("left", camera, procam.Pose([0, 0, 0, 1], [1, 2, 3]))],
                     projectors=[procam.RigProjector("beamer", procam.Projector(camera))])
    return [camera, camera.intrinsics, procam.Pose([0.1, 0.2, 0.3, 0.9], [1, 2, 3]), rig, contents.correspondences,
            procam.Chessboard(9, 6, 0.025), procam.calibrate.Options(), procam.render.RenderOptions(threads=2),
            procam.FrameTree.Link("a", "b")]


def test_structs_are_equal_by_their_fields(contents):
    for one, same in zip(structs(contents), structs(contents)):
        assert one == same and not one != same, type(one)
        assert one == copy.deepcopy(one)
    camera = structs(contents)[0]
    other = copy.deepcopy(camera)
    other.intrinsics.cy = 701
    assert camera != other
    assert procam.Pose() != procam.ImageSize() and procam.Pose() != 3 and procam.Pose() is not None
    # What has a state is itself alone.
    renderers = [procam.render.CpuRenderer(), procam.render.CpuRenderer()]
    assert renderers[0] == renderers[0] and renderers[0] != renderers[1]


def test_structs_go_through_pickle(contents):
    for one in structs(contents):
        assert pickle.loads(pickle.dumps(one)) == one, type(one)
    with pytest.raises(TypeError):
        pickle.dumps(procam.render.CpuRenderer())
