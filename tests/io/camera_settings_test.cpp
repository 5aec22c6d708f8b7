// Each program's own formula, restated from its source or manual, puts points of the room onto the pixels
// that procam's projector lights them with.
#include "procam/io/exchange/camera_settings.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "support/expect_error.hpp"
#include "support/lopsided.hpp"

namespace procam::io {
namespace {

/// Unequal focal lengths, the whole picture above the optical axis, off to one side.
RigProjector shifted_projector(double skew = 0, Distortion distortion = NoDistortion{}) {
  RigProjector projector;
  projector.name = "beamer";
  projector.projector = {Camera{{1024, 768}, {1880.7, 1846.2, 497.3, 851.6, skew}, distortion}};
  return projector;
}

Pose world_from_beamer() {
  return test::lopsided_pose();
}

/// Normalised device coordinates (x right, y up, -1..1) -> pixel of a picture that is stretched to 1024 x
/// 768.
Vec2 pixel_from_ndc(const Vec2& ndc) {
  return Vec2((ndc.x() + 1) / 2 * 1024 - 0.5, (1 - ndc.y()) / 2 * 768 - 0.5);
}

/// The ratio of the picture's sides as the program computes it, from whole pixels.
double aspect(const CameraSettings& settings) {
  return double(settings.render_size.width) / settings.render_size.height;
}

const std::vector<double>& values(const CameraSettings& settings, const char* name) {
  return settings.values.at(name);
}

Vec3 vec3(const std::vector<double>& v, std::size_t from = 0) {
  return Vec3(v[from], v[from + 1], v[from + 2]);
}

/// glFrustum's projection of a point in an OpenGL eye frame (x right, y up, z backward).
Vec2 project_frustum(double l, double r, double b, double t, double near, const Vec3& p) {
  const double x = (2 * near / (r - l) * p.x() + (r + l) / (r - l) * p.z()) / -p.z();
  const double y = (2 * near / (t - b) * p.y() + (t + b) / (t - b) * p.z()) / -p.z();
  return Vec2(x, y);
}

/// Camera.projectionMatrix, row by row; camera space as OpenGL's (Unity's manual,
/// Camera.worldToCameraMatrix). World: ROS's (x, y, z) is (-y, z, x) in Unity.
Vec2 unity(const CameraSettings& s, const Vec3& ros) {
  const auto& q = values(s, "rotation");
  const Vec3 in_unity(-ros.y(), ros.z(), ros.x());
  const Vec3 local =
      Eigen::Quaterniond(q[3], q[0], q[1], q[2]).conjugate() * (in_unity - vec3(values(s, "position")));
  const auto& m = values(s, "projectionMatrix");
  const Vec4 eye(local.x(), local.y(), -local.z(), 1);
  Vec4 clip;
  for (std::size_t row = 0; row < 4; ++row)
    clip[Eigen::Index(row)] = Vec4(m[4 * row], m[4 * row + 1], m[4 * row + 2], m[4 * row + 3]).dot(eye);
  EXPECT_GT(clip.z() / clip.w(), -1);
  EXPECT_LT(clip.z() / clip.w(), 1);
  return pixel_from_ndc(clip.head<2>() / clip.w());
}

/// The physical camera: focal length and sensor give the field of view, lensShift moves the picture's area by
/// that many pictures (Unity's manual, "Physical Camera"; Gate Fit "None" fills the screen with the sensor).
Vec2 unity_physical(const CameraSettings& s, const Vec3& ros) {
  const auto& q = values(s, "rotation");
  const Vec3 in_unity(-ros.y(), ros.z(), ros.x());
  const Vec3 local =
      Eigen::Quaterniond(q[3], q[0], q[1], q[2]).conjugate() * (in_unity - vec3(values(s, "position")));
  const double near = values(s, "nearClipPlane")[0], scale = near / values(s, "focalLength")[0];
  const double w = values(s, "sensorSize")[0] * scale, h = values(s, "sensorSize")[1] * scale;
  const double x = values(s, "lensShift")[0] * w, y = values(s, "lensShift")[1] * h;
  return pixel_from_ndc(project_frustum(x - w / 2, x + w / 2, y - h / 2, y + h / 2, near,
                                        Vec3(local.x(), local.y(), -local.z())));
}

/// FRotationMatrix; UCineCameraComponent's horizontal field of view and projection offsets; the off-centre
/// terms of FMinimalViewInfo::CalculateProjectionMatrixGivenView (M[2][0] = -offset x, row vectors). World:
/// ROS's (x, y, z) is (x, -y, z) in Unreal, centimetres.
Vec2 unreal(const CameraSettings& s, const Vec3& ros) {
  const Vec3 in_unreal(100 * ros.x(), -100 * ros.y(), 100 * ros.z());
  const auto& rotator = values(s, "rotation");
  const double sr = std::sin(rotator[0] * kDegree), cr = std::cos(rotator[0] * kDegree);
  const double sp = std::sin(rotator[1] * kDegree), cp = std::cos(rotator[1] * kDegree);
  const double sy = std::sin(rotator[2] * kDegree), cy = std::cos(rotator[2] * kDegree);
  const Vec3 x_axis(cp * cy, cp * sy, sp);
  const Vec3 y_axis(sr * sp * cy - cr * sy, sr * sp * sy + cr * cy, -sr * cp);
  const Vec3 z_axis(-(cr * sp * cy + sr * sy), cy * sr - cr * sp * sy, cr * cp);
  const Vec3 d = in_unreal - vec3(values(s, "location"));
  const Vec3 view(d.dot(y_axis), d.dot(z_axis), d.dot(x_axis));  // right, up, forward
  const double width = values(s, "sensor_width")[0], height = values(s, "sensor_height")[0];
  const double half_fov = std::atan(width / (2 * values(s, "current_focal_length")[0]));
  const double offset_x = 2 * values(s, "sensor_horizontal_offset")[0] / width;
  const double offset_y = 2 * values(s, "sensor_vertical_offset")[0] / height;
  const double x_scale = 1 / std::tan(half_fov), y_scale = x_scale * aspect(s);
  EXPECT_NEAR(aspect(s), width / height, 1e-6) << "no black bars beside the sensor's picture";
  return pixel_from_ndc(
      Vec2(x_scale * view.x() / view.z() - offset_x, y_scale * view.y() / view.z() - offset_y));
}

/// Projection::set_frustum(size, aspect, offset, near, far, flip_fov = false) of core/math/projection.cpp.
/// World: ROS's (x, y, z) is (-y, z, -x) in Godot.
Vec2 godot(const CameraSettings& s, const Vec3& ros) {
  const auto& t = values(s, "global_transform");
  Mat3 basis;
  basis << vec3(t, 0), vec3(t, 3), vec3(t, 6);
  const Vec3 local = basis.inverse() * (Vec3(-ros.y(), ros.z(), -ros.x()) - vec3(t, 9));
  const double a = aspect(s), size = values(s, "size")[0] * a;
  const double x = values(s, "frustum_offset")[0], y = values(s, "frustum_offset")[1];
  return pixel_from_ndc(project_frustum(-size / 2 + x, size / 2 + x, -size / a / 2 + y, size / a / 2 + y,
                                        values(s, "near")[0], local));
}

/// BKE_camera_params_compute_viewplane() of source/blender/blenkernel/intern/camera.cc, horizontal sensor
/// fit.
Vec2 blender(const CameraSettings& s, const Vec3& ros) {
  const auto& m = values(s, "matrix_world");
  Mat3 axes;
  axes << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
  const Vec3 local = axes.transpose() * (ros - Vec3(m[3], m[7], m[11]));
  const double winx = values(s, "resolution")[0], winy = values(s, "resolution")[1];
  const double ycor = values(s, "pixel_aspect")[1] / values(s, "pixel_aspect")[0];
  EXPECT_GE(std::min(values(s, "pixel_aspect")[0], values(s, "pixel_aspect")[1]), 1)
      << "Blender's lower limit";
  const double near = values(s, "clip")[0], viewfac = winx;
  const double pixsize = values(s, "sensor_width")[0] * near / values(s, "lens")[0] / viewfac;
  const double dx = values(s, "shift_x")[0] * viewfac, dy = values(s, "shift_y")[0] * viewfac;
  return pixel_from_ndc(project_frustum((-0.5 * winx + dx) * pixsize, (0.5 * winx + dx) * pixsize,
                                        (-0.5 * ycor * winy + dy) * pixsize,
                                        (0.5 * ycor * winy + dy) * pixsize, near, local));
}

/// Camera::computeProjectionMatrix() of Splash's camera.cpp, and glm::lookAt(eye, target, up).
Vec2 splash(const CameraSettings& s, const Vec3& ros) {
  const Vec3 eye = vec3(values(s, "eye"));
  const Vec3 f = (vec3(values(s, "target")) - eye).normalized();
  const Vec3 side = f.cross(vec3(values(s, "up"))).normalized(), up = side.cross(f);
  const Vec3 local((ros - eye).dot(side), (ros - eye).dot(up), -(ros - eye).dot(f));
  const double n = 0.1, cx = values(s, "principalPoint")[0], cy = values(s, "principalPoint")[1];
  const double top = n * std::tan(values(s, "fov")[0] * kPi / 360), bottom = -top;
  const double right = top * aspect(s), left = bottom * aspect(s);
  return pixel_from_ndc(
      project_frustum(left - (cx - 0.5) * (right - left), right - (cx - 0.5) * (right - left),
                      bottom - (cy - 0.5) * (top - bottom), top - (cy - 0.5) * (top - bottom), n, local));
}

/// BaseViewport::setViewPlaneCoordsUsingFOVs() and Projection::calculateProjection() of SGCT: the frustum
/// from the user's eye through the plane's corners. down and left change their sign where the file is read.
/// World: ROS's (x, y, z) is (-y, z, -x) in SGCT.
Vec2 sgct(const CameraSettings& s, const Vec3& ros) {
  const auto& fov = values(s, "fov");
  const double down = std::tan(-fov[0] * kDegree), left = std::tan(-fov[1] * kDegree);
  const double right = std::tan(fov[2] * kDegree), up = std::tan(fov[3] * kDegree);
  const auto& q = values(s, "orientation");
  const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
  const double distance = 10;
  const Vec3 eye = vec3(values(s, "position")), offset = vec3(values(s, "offset"));
  const auto corner = [&](double x, double y) {
    return Vec3(rotation * (distance * Vec3(x, y, -1)) + offset - eye);
  };
  const Vec3 lower_left = corner(left, down), upper_left = corner(left, up), upper_right = corner(right, up);
  const Vec3 x_axis = (upper_right - upper_left).normalized(),
             y_axis = (upper_left - lower_left).normalized();
  const Vec3 z_axis = x_axis.cross(y_axis);
  const Vec3 d = Vec3(-ros.y(), ros.z(), -ros.x()) - eye;
  return pixel_from_ndc(project_frustum(
      lower_left.dot(x_axis), upper_right.dot(x_axis), lower_left.dot(y_axis), upper_right.dot(y_axis),
      -lower_left.dot(z_axis), Vec3(d.dot(x_axis), d.dot(y_axis), d.dot(z_axis))));
}

/// The rows of a matrix, for column vectors.
Mat4 matrix_called(const CameraSettings& s, const char* name) {
  Mat4 m;
  for (Eigen::Index i = 0; i < 16; ++i) m(i / 4, i % 4) = values(s, name)[std::size_t(i)];
  return m;
}

/// OpenGL 2.1's fixed function: clip = projection * modelview * point. World: ROS's (x, y, z) is (-y, z, -x) here.
Vec2 opengl(const CameraSettings& s, const Vec3& ros) {
  const Vec4 clip = matrix_called(s, "projection_matrix") * matrix_called(s, "view_matrix") *
                    Vec4(-ros.y(), ros.z(), -ros.x(), 1);
  EXPECT_LT(std::abs(clip.z()), clip.w()) << "between the clip planes";
  return pixel_from_ndc(clip.head<2>() / clip.w());
}

/// glFrustum in the projection's place: without the skew.
Vec2 opengl_frustum(const CameraSettings& s, const Vec3& ros) {
  const Vec4 eye = matrix_called(s, "view_matrix") * Vec4(-ros.y(), ros.z(), -ros.x(), 1);
  const auto& f = values(s, "frustum");
  return pixel_from_ndc(project_frustum(f[0], f[1], f[2], f[3], f[4], eye.head<3>()));
}

struct Program {
  CameraProgram program;
  Vec2 (*project)(const CameraSettings&, const Vec3&);
  bool has_skew;
};

const Program kAll[] = {{CameraProgram::kUnity, unity, true},
                        {CameraProgram::kUnity, unity_physical, false},
                        {CameraProgram::kUnreal, unreal, false},
                        {CameraProgram::kGodot, godot, false},
                        {CameraProgram::kBlender, blender, false},
                        {CameraProgram::kSplash, splash, false},
                        {CameraProgram::kSgct, sgct, false},
                        {CameraProgram::kOpenGl, opengl, true},
                        {CameraProgram::kOpenGl, opengl_frustum, false}};

/// The largest distance between the program's pixels and the projector's, over points of the room.
double largest_distance(const Program& program, const RigProjector& projector) {
  const CameraSettings settings =
      camera_settings(program.program, projector, world_from_beamer(), WorldUp::kZ);
  std::mt19937_64 random(7);
  double largest = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec2 pixel(test::uniform(random, -0.5, 1023.5), test::uniform(random, -0.5, 767.5));
    const Vec3 point_in_world = world_from_beamer() * Vec3(projector.projector.emit(pixel)->direction *
                                                           test::uniform(random, 0.5, 9));
    largest = std::max(largest, (program.project(settings, point_in_world) - pixel).norm());
  }
  return largest;
}

TEST(CameraSettings, EveryProgramLightsTheSamePixels) {
  for (const Program& program : kAll)
    EXPECT_LT(largest_distance(program, shifted_projector()), 1e-3) << int(program.program);
}

TEST(CameraSettings, PortraitPicturesToo) {
  RigProjector portrait = shifted_projector();
  portrait.projector.inverse_camera.intrinsics = {1780.7, 1846.2, 640.3, -51.6,
                                                  0};  // axis above, to the right
  for (const Program& program : kAll) EXPECT_LT(largest_distance(program, portrait), 1e-3);
}

TEST(CameraSettings, SkewIsExactInMatricesAndNamedWhereItIsLost) {
  const RigProjector projector = shifted_projector(5);
  const double stated = 5 * 0.5 * 768 / 1846.2;  // at the edges of rows; none on the middle row
  for (const Program& program : kAll) {
    const CameraSettings settings =
        camera_settings(program.program, projector, world_from_beamer(), WorldUp::kZ);
    const double distance = largest_distance(program, projector);
    if (program.has_skew) {
      EXPECT_LT(distance, 1e-3);
      continue;
    }
    EXPECT_LT(distance, stated + 1e-3);
    EXPECT_GT(distance, 0.9 * stated);
    // The matrix has the skew.
    if (program.program == CameraProgram::kUnity || program.program == CameraProgram::kOpenGl) continue;
    ASSERT_TRUE(settings.diagnostics.find("skew_lost")) << int(program.program);
    EXPECT_TRUE(test::contains(settings.diagnostics.find("skew_lost")->message, "up to 1.04 pixels"));
  }
}

TEST(CameraSettings, DistortionIsNamedWithItsSize) {
  const auto settings =
      camera_settings(CameraProgram::kUnity, shifted_projector(0, BrownConrady{{-0.2, 0.03, 0, 0, 0}}),
                      world_from_beamer(), WorldUp::kZ);
  ASSERT_TRUE(settings.diagnostics.find("distortion_lost"));
  EXPECT_FALSE(camera_settings(CameraProgram::kUnity, shifted_projector(), world_from_beamer(), WorldUp::kZ)
                   .diagnostics.find("distortion_lost"));
}

TEST(CameraSettings, DrawsTheProjectorsSizeWherePixelsAreSquareOrMayBeOblong) {
  EXPECT_EQ(camera_settings(CameraProgram::kBlender, shifted_projector(), Pose(), WorldUp::kZ).render_size,
            (ImageSize{1024, 768}));
  RigProjector square = shifted_projector();
  square.projector.inverse_camera.intrinsics.fy = square.projector.inverse_camera.intrinsics.fx;
  EXPECT_EQ(camera_settings(CameraProgram::kGodot, square, Pose(), WorldUp::kZ).render_size,
            (ImageSize{1024, 768}));
  const CameraSettings oblong =
      camera_settings(CameraProgram::kGodot, shifted_projector(), Pose(), WorldUp::kZ);
  EXPECT_GT(oblong.render_size.width, 1024);
  EXPECT_TRUE(oblong.diagnostics.find("render_size"));
}

// Its camera keeps the size it had, and looks elsewhere.
TEST(CameraSettings, SaysWhatGodot3WillNotTake) {
  const auto settings_with = [](double near) {
    return camera_settings(CameraProgram::kGodot, shifted_projector(), Pose(), WorldUp::kZ, {near, 100});
  };
  const CameraSettings near = settings_with(0.1);
  ASSERT_TRUE(near.diagnostics.find("godot_3_size"));
  EXPECT_TRUE(test::contains(near.text, "--near 25cm")) << near.text;  // 0.1 m * 1846.2 / 768 = 0.2404 m
  EXPECT_FALSE(settings_with(0.25).diagnostics.find("godot_3_size"));
}

// The same room with another axis upwards gives the same picture.
TEST(CameraSettings, WorldUpTurnsTheRoomUpright) {
  const Vec3 ahead_left_up(3, 1, 0.5);  // ROS: x forward, y left, z up
  const auto at = [&](WorldUp up, const Vec3& point) {
    return Vec3(program_from_world({Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()}, up) * point);
  };
  EXPECT_EQ(at(WorldUp::kZ, ahead_left_up), Vec3(-1, 0.5, 3));           // right, up, forward
  EXPECT_EQ(at(WorldUp::kY, Vec3(-1, 0.5, -3)), Vec3(-1, 0.5, 3));       // OpenGL
  EXPECT_EQ(at(WorldUp::kMinusY, Vec3(-1, -0.5, 3)), Vec3(-1, 0.5, 3));  // optical
  EXPECT_EQ(parse_world_up("-y"), WorldUp::kMinusY);
  EXPECT_ERROR(parse_world_up("up"), kInput, "give z, y or -y");
}

TEST(CameraSettings, TextSaysEveryNumberAndItsConventions) {
  for (const char* name : {"unity", "unreal", "godot", "blender", "splash", "sgct", "opengl"}) {
    const CameraSettings settings =
        camera_settings(parse_camera_program(name), shifted_projector(), world_from_beamer(), WorldUp::kZ);
    EXPECT_TRUE(test::contains(settings.text, "World: ")) << settings.text;
    EXPECT_TRUE(test::contains(settings.text, "-handed")) << settings.text;
    EXPECT_FALSE(test::contains(settings.text, "@")) << settings.text;
  }
  EXPECT_ERROR(parse_camera_program("maya"), kInput, "give unity, unreal");
  EXPECT_THROW(camera_settings(CameraProgram::kUnity, shifted_projector(), Pose(), WorldUp::kZ, {1, 1}),
               std::invalid_argument);
}

}  // namespace
}  // namespace procam::io
