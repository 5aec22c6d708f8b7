#include "procam/io/exchange/camera_settings.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdio>

#include "document/number.hpp"
#include "procam/core/lens/frustum.hpp"

namespace procam::io {
namespace {

constexpr double kSensorWidthMm = 36;  ///< a free choice: only its ratio to the focal length matters

constexpr std::array<const char*, 7> kPrograms{"unity",  "unreal", "godot", "blender",
                                               "splash", "sgct",   "opengl"};

/// The text as it grows, and its numbers as they read there.
class SettingsText {
 public:
  explicit SettingsText(CameraSettings& settings) : settings_(settings) {}

  void line(const std::string& text) { settings_.text += text + "\n"; }
  /// `pattern` with '@' for each number in turn.
  void set(const std::string& name, const std::vector<double>& values, const std::string& pattern) {
    std::size_t next = 0;
    for (const char c : pattern) {
      if (c != '@') {
        settings_.text += c;
        continue;
      }
      const std::string number = format_number(values.at(next) == 0 ? 0.0 : values.at(next));
      settings_.text += number;
      settings_.values[name].push_back(values[next++]);
    }
    settings_.text += "\n";
    require(next == values.size(), "camera_settings: '" + name + "' has another number of values");
  }

 private:
  CameraSettings& settings_;
};

std::vector<double> numbers(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

/// Common input of the exporters: a pinhole camera in the program's axes.
struct CameraView {
  ImageSize size;
  Intrinsics k;
  ClipPlanes clip;
  Vec3 eye;                  ///< metres
  Vec3 right, up, forward;   ///< the picture's, unit
  double width_over_height;  ///< of the picture in the room, as light
  Vec2 axis;                 ///< where the optical axis pierces the picture, as a fraction from its top left

  /// Columns: the camera's own x right, y up, z backward (Blender, Godot, SGCT).
  Mat3 backward_axes() const {
    Mat3 axes;
    axes << right, up, -forward;
    return axes;
  }
};

CameraView view_of(const RigProjector& projector, const Intrinsics& k, const Pose& world_from_projector,
                   const Directions& in_program, WorldUp up, ClipPlanes clip) {
  const Mat3 to_program = program_from_world(in_program, up);
  const Mat3 axes = to_program * world_from_projector.rotation_matrix();
  const ImageSize size = projector.projector.size();
  CameraView view;
  view.size = size;
  view.k = k;
  view.clip = clip;
  view.eye = to_program * world_from_projector.translation;
  view.right = axes.col(0);
  view.up = -axes.col(1);
  view.forward = axes.col(2);
  view.width_over_height = (size.width / k.fx) / (size.height / k.fy);
  view.axis = Vec2((k.cx + 0.5) / size.width, (k.cy + 0.5) / size.height);
  return view;
}

/// The nearest pinhole without skew: the pixels of the middle row stay where they are.
Intrinsics without_skew(Intrinsics k, ImageSize size) {
  k.cx += k.skew * (0.5 * (size.height - 1) - k.cy) / k.fy;
  k.skew = 0;
  return k;
}

/// The smallest whole size from the projector's own upwards whose sides have this ratio to 2e-4 pixels.
ImageSize render_size(ImageSize projector, double width_over_height) {
  ImageSize best;
  double min_error = 1;
  for (int height = projector.height; height <= 3 * projector.height; ++height) {
    const int width = int(std::lround(width_over_height * height));
    const double error = std::abs(width / (width_over_height * height) - 1) * projector.width;
    if (width < projector.width || !(error < min_error)) continue;
    best = {width, height};
    min_error = error;
    if (error < 2e-4) break;
  }
  return best;
}

std::string rounded_px(double pixels) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", pixels);
  return std::string(text) + " pixels";
}

void report_losses(const RigProjector& projector, bool skew_is_lost, Diagnostics& diagnostics) {
  const Camera& lens = projector.projector.inverse_camera;
  const char* const next = "; draw through a warp map where that matters (export-warp)";
  if (skew_is_lost && lens.intrinsics.skew != 0)
    diagnostics.warn("skew_lost", "the target program cannot model skew: up to " +
                                      rounded_px(std::abs(lens.intrinsics.skew) * 0.5 * lens.size.height /
                                                 lens.intrinsics.fy) +
                                      " error at the top and bottom edges" + next);
  double largest = 0;
  for (int j = 0; j <= 16; ++j)
    for (int i = 0; i <= 16; ++i) {
      const Vec2 pixel(i * (lens.size.width - 1) / 16.0, j * (lens.size.height - 1) / 16.0);
      const std::optional<Vec3> bearing = lens.unproject(pixel);
      if (!bearing || !(bearing->z() > 0)) continue;
      largest =
          std::max(largest, (lens.intrinsics.pixel_from_normalized(bearing->hnormalized()) - pixel).norm());
    }
  if (largest > 0.005)
    diagnostics.warn("distortion_lost", "the target program cannot model lens distortion: up to " +
                                            rounded_px(largest) + " error" + next);
}

void say_render_size(CameraSettings& settings, ImageSize projector) {
  if (settings.render_size == projector) return;
  settings.diagnostics.note("render_size",
                            "the projector's pixels are not square: draw a picture of " +
                                std::to_string(settings.render_size.width) + " x " +
                                std::to_string(settings.render_size.height) +
                                " pixels and let the output stretch it to the projector's size");
}

std::string size_text(ImageSize size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height);
}

void write_unity(const CameraView& view, const Intrinsics& exact, SettingsText& text) {
  const double focal_mm = view.k.fx * kSensorWidthMm / view.size.width;
  text.line(
      "// Unity (C#). World: x right, y up, z forward, left-handed, metres. The camera looks along its z.");
  text.line(
      "// The physical camera is for the inspector; projectionMatrix, set last, is exact and has the skew.");
  text.line(
      "// Its rows are as written, for column vectors, in OpenGL's clip space (Unity turns it into the");
  text.line(
      "// graphics card's own). lensShift is in pictures: positive x moves the picture's area to the right,");
  text.line("// y upwards.");
  text.set("nearClipPlane", {view.clip.near}, "camera.nearClipPlane = @f;");
  text.set("farClipPlane", {view.clip.far}, "camera.farClipPlane = @f;");
  text.line("camera.usePhysicalProperties = true;");
  text.line("camera.gateFit = Camera.GateFitMode.None;");
  text.set("sensorSize", {kSensorWidthMm, focal_mm * view.size.height / view.k.fy},
           "camera.sensorSize = new Vector2(@f, @f);  // mm");
  text.set("focalLength", {focal_mm}, "camera.focalLength = @f;  // mm");
  text.set("lensShift", {0.5 - view.axis.x(), view.axis.y() - 0.5},
           "camera.lensShift = new Vector2(@f, @f);");
  const Mat4 m = clip_from_eye(exact, view.size, view.clip.near, view.clip.far, GraphicsApi::kOpenGL);
  text.line("var m = new Matrix4x4();");
  for (int row = 0; row < 4; ++row)
    text.set("projectionMatrix", {m(row, 0), m(row, 1), m(row, 2), m(row, 3)},
             "m.SetRow(" + std::to_string(row) + ", new Vector4(@f, @f, @f, @f));");
  text.line("camera.projectionMatrix = m;");
  Mat3 axes;
  axes << view.right, view.up, view.forward;
  const Eigen::Quaterniond q(axes);
  text.set("position", numbers(view.eye), "camera.transform.position = new Vector3(@f, @f, @f);");
  text.set("rotation", {q.x(), q.y(), q.z(), q.w()},
           "camera.transform.rotation = new Quaternion(@f, @f, @f, @f);  // x y z w");
}

void write_unreal(const CameraView& view, ImageSize render, SettingsText& text) {
  const double focal_mm = view.k.fx * kSensorWidthMm / view.size.width;
  const double sensor_height_mm = kSensorWidthMm / view.width_over_height;
  const double degrees = 1 / kDegree;
  text.line(
      "# Unreal Engine 5.5 or later (Python in the editor; a CineCameraActor). World: x forward, y right,");
  text.line("# z up, left-handed, centimetres. The camera looks along its x. Offsets of the filmback in mm:");
  text.line("# positive moves the picture's area to the right and upwards. The far plane is infinite.");
  text.line("# Render " + size_text(render) + " pixels.");
  text.line("camera = actor.get_cine_camera_component()");
  text.line("filmback = unreal.CameraFilmbackSettings()");
  text.set("sensor_width", {kSensorWidthMm}, "filmback.sensor_width = @");
  text.set("sensor_height", {sensor_height_mm}, "filmback.sensor_height = @");
  text.set("sensor_horizontal_offset", {(0.5 - view.axis.x()) * kSensorWidthMm},
           "filmback.sensor_horizontal_offset = @");
  text.set("sensor_vertical_offset", {(view.axis.y() - 0.5) * sensor_height_mm},
           "filmback.sensor_vertical_offset = @");
  text.line("camera.set_editor_property('filmback', filmback)");
  text.set("current_focal_length", {focal_mm}, "camera.set_editor_property('current_focal_length', @)");
  text.line("camera.set_editor_property('override_custom_near_clipping_plane', True)");
  text.set("custom_near_clipping_plane", {100 * view.clip.near},
           "camera.set_editor_property('custom_near_clipping_plane', @)  # cm");
  // FRotator: x axis (CP CY, CP SY, SP), y axis with z component -SR CP, z axis with z component CR CP.
  const Vec3 &x = view.forward, &y = view.right, &z = view.up;
  text.set("location", numbers(100 * view.eye),
           "actor.set_actor_location(unreal.Vector(@, @, @), False, False)");
  text.set("rotation",
           {degrees * std::atan2(-y.z(), z.z()), degrees * std::asin(std::clamp(x.z(), -1.0, 1.0)),
            degrees * std::atan2(x.y(), x.x())},
           "actor.set_actor_rotation(unreal.Rotator(roll=@, pitch=@, yaw=@), False)");
}

/// Godot 3 refuses a smaller size (scene/3d/camera.cpp, Camera::set_size) and looks elsewhere.
constexpr double kMinGodot3Size = 0.1;

void write_godot(const CameraView& view, ImageSize render, SettingsText& text, Diagnostics& diagnostics) {
  const double size = view.clip.near * view.size.height / view.k.fy;
  text.line(
      "# Godot 4 (GDScript, Camera3D; Godot 3: Camera, and Transform for Transform3D). World: x right,");
  text.line(
      "# y up, z backward, right-handed, metres. The camera looks along its -z. size is the height of the");
  text.line(
      "# near plane, frustum_offset in the near plane: positive moves the picture's area right and upwards.");
  text.line("# Render in a viewport of " + size_text(render) + " pixels.");
  if (size < kMinGodot3Size) {
    char centimetres[16];
    std::snprintf(centimetres, sizeof centimetres, "%.0fcm",
                  std::ceil(100 * view.clip.near * kMinGodot3Size / size));
    const std::string advice = std::string("Godot 3 takes no size below 0.1 m: there, --near ") + centimetres;
    diagnostics.note("godot_3_size", advice);
    text.line("# " + advice + ".");
  }
  text.line("camera.projection = Camera3D.PROJECTION_FRUSTUM");
  text.line("camera.keep_aspect = Camera3D.KEEP_HEIGHT");
  text.set("near", {view.clip.near}, "camera.near = @");
  text.set("far", {view.clip.far}, "camera.far = @");
  text.set("size", {size}, "camera.size = @");
  text.set("frustum_offset",
           {(0.5 - view.axis.x()) * size * view.width_over_height, (view.axis.y() - 0.5) * size},
           "camera.frustum_offset = Vector2(@, @)");
  std::vector<double> transform = numbers(view.right);
  for (const Vec3& column : {view.up, Vec3(-view.forward), view.eye})
    for (const double number : numbers(column)) transform.push_back(number);
  text.set("global_transform", transform,
           "camera.global_transform = Transform3D(Vector3(@, @, @), Vector3(@, @, @), Vector3(@, @, @), "
           "Vector3(@, @, @))  # columns x, y, z, origin");
}

void write_blender(const CameraView& view, SettingsText& text) {
  const double aspect = view.k.fx / view.k.fy;  // Blender wants neither side below 1
  text.line(
      "# Blender (Python). World: z up, x forward, y left, right-handed, metres. The camera looks along its");
  text.line(
      "# -z, y up. shift_x and shift_y are in pictures' widths, both: positive moves the picture's area to");
  text.line("# the right and upwards. matrix_world: rows as written, for column vectors.");
  text.line("render = bpy.context.scene.render");
  text.set("resolution", {double(view.size.width), double(view.size.height)},
           "render.resolution_x, render.resolution_y, render.resolution_percentage = @, @, 100");
  text.set("pixel_aspect", {std::max(1.0, 1 / aspect), std::max(1.0, aspect)},
           "render.pixel_aspect_x, render.pixel_aspect_y = @, @");
  text.line("camera.data.type = 'PERSP'");
  text.line("camera.data.sensor_fit = 'HORIZONTAL'");
  text.set("sensor_width", {kSensorWidthMm}, "camera.data.sensor_width = @  # mm");
  text.set("lens", {view.k.fx * kSensorWidthMm / view.size.width}, "camera.data.lens = @  # mm");
  text.set("shift_x", {0.5 - view.axis.x()}, "camera.data.shift_x = @");
  text.set("shift_y", {(view.axis.y() - 0.5) * view.size.height * aspect / view.size.width},
           "camera.data.shift_y = @");
  text.set("clip", {view.clip.near, view.clip.far}, "camera.data.clip_start, camera.data.clip_end = @, @");
  const Mat3 axes = view.backward_axes();
  std::vector<double> matrix;
  for (int row = 0; row < 3; ++row)
    matrix.insert(matrix.end(), {axes(row, 0), axes(row, 1), axes(row, 2), view.eye[row]});
  text.set(
      "matrix_world", matrix,
      "camera.matrix_world = mathutils.Matrix(((@, @, @, @), (@, @, @, @), (@, @, @, @), (0, 0, 0, 1)))");
}

void write_splash(const CameraView& view, ImageSize render, SettingsText& text) {
  const Vec3 target = view.eye + view.forward;
  text.line(
      "// Splash (a camera's attributes in the configuration). World: z up, right-handed, metres, as the");
  text.line(
      "// meshes have it. fov is vertical, degrees; principalPoint a fraction of the picture, from its left");
  text.line(
      "// and from its bottom. Near and far planes are Splash's own. Give the window the projector's size.");
  text.set("size", {double(render.width), double(render.height)}, "\"size\": [@, @],");
  text.set("fov", {2 * std::atan(0.5 * view.size.height / view.k.fy) / kDegree}, "\"fov\": [@],");
  text.set("principalPoint", {view.axis.x(), 1 - view.axis.y()}, "\"principalPoint\": [@, @],");
  text.set("eye", numbers(view.eye), "\"eye\": [@, @, @],");
  text.set("target", numbers(target), "\"target\": [@, @, @],");
  text.set("up", numbers(view.up), "\"up\": [@, @, @]");
}

void write_sgct(const CameraView& view, SettingsText& text) {
  const auto angle = [](double tangent) { return std::atan(tangent) / kDegree; };
  const double w = view.size.width / view.k.fx, h = view.size.height / view.k.fy;  // at distance 1
  const Eigen::Quaterniond q(view.backward_axes());
  text.line(
      "// SGCT (JSON configuration, a user and a viewport's projection). World: x right, y up, z backward,");
  text.line(
      "// right-handed, metres. The camera looks along its -z. Angles in degrees from the optical axis to "
      "the");
  text.line(
      "// picture's edges, each positive outwards: down is negative where the whole picture lies above the");
  text.line("// axis. orientation turns the camera into the world. Clip planes are the application's own.");
  text.set("position", numbers(view.eye), "\"users\": [{ \"position\": { \"x\": @, \"y\": @, \"z\": @ } }]");
  text.line("\"projection\": {");
  text.line("  \"type\": \"PlanarProjection\",");
  text.set("fov",
           {angle((1 - view.axis.y()) * h), angle(view.axis.x() * w), angle((1 - view.axis.x()) * w),
            angle(view.axis.y() * h)},
           "  \"fov\": { \"down\": @, \"left\": @, \"right\": @, \"up\": @ },");
  text.set("offset", numbers(view.eye), "  \"offset\": { \"x\": @, \"y\": @, \"z\": @ },");
  text.set("orientation", {q.x(), q.y(), q.z(), q.w()},
           "  \"orientation\": { \"x\": @, \"y\": @, \"z\": @, \"w\": @ }");
  text.line("}");
}

void write_opengl(const CameraView& view, const Intrinsics& exact, SettingsText& text) {
  const ClipPlanes clip = view.clip;
  const Frustum f = frustum(view.k, view.size, clip.near, clip.far);
  const Mat4 projection = clip_from_eye(exact, view.size, clip.near, clip.far, GraphicsApi::kOpenGL);
  Mat4 eye_from_world = Mat4::Identity();
  eye_from_world.topLeftCorner<3, 3>() = view.backward_axes().transpose();
  eye_from_world.topRightCorner<3, 1>() = -view.backward_axes().transpose() * view.eye;
  text.line(
      "// OpenGL. World: x right, y up, z backward, right-handed, metres; the eye likewise. glFrustum has no skew;");
  text.line(
      "// the projection matrix has it. Matrices: rows as written, for column vectors; OpenGL's functions");
  text.line(
      "// take them column by column (transpose = GL_TRUE of glUniformMatrix4fv takes them as written).");
  text.set("frustum", {f.left, f.right, f.bottom, f.top, f.near, f.far}, "glFrustum(@, @, @, @, @, @);");
  const auto set_matrix = [&](const std::string& name, const Mat4& m) {
    text.line("double " + name + "[16] = {");
    for (int row = 0; row < 4; ++row)
      text.set(name, {m(row, 0), m(row, 1), m(row, 2), m(row, 3)},
               row < 3 ? "    @, @, @, @," : "    @, @, @, @};");
  };
  set_matrix("projection_matrix", projection);
  set_matrix("view_matrix", eye_from_world);
}

/// What right, up and forward are in each program's world.
Directions directions_of(CameraProgram program) {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  switch (program) {
    case CameraProgram::kUnity:
      return {x, y, z};
    case CameraProgram::kUnreal:
      return {y, z, x};
    case CameraProgram::kBlender:
    case CameraProgram::kSplash:
      return {-y, z, x};
    case CameraProgram::kGodot:
    case CameraProgram::kSgct:
    case CameraProgram::kOpenGl:
      break;
  }
  return {x, y, -z};
}

}  // namespace

CameraProgram parse_camera_program(const std::string& name) {
  for (std::size_t i = 0; i < kPrograms.size(); ++i)
    if (name == kPrograms[i]) return CameraProgram(i);
  throw Error(
      ErrorKind::kInput, "'" + name + "'", "there are no camera settings for it",
      "give unity, unreal, godot, blender, splash, sgct or opengl; for ros, opencv, kalibr, mrcal, colmap, urdf, "
      "sdf and gltf use procam convert");
}

CameraSettings camera_settings(CameraProgram program, const RigProjector& projector,
                               const Pose& world_from_projector, WorldUp up, ClipPlanes clip) {
  const Camera& lens = projector.projector.inverse_camera;
  internal::require_frustum(lens.intrinsics, lens.size, clip.near, clip.far);
  const Intrinsics k = without_skew(lens.intrinsics, lens.size);
  const CameraView view = view_of(projector, k, world_from_projector, directions_of(program), up, clip);
  const bool square_only = program == CameraProgram::kUnreal || program == CameraProgram::kGodot ||
                           program == CameraProgram::kSplash;
  CameraSettings settings;
  settings.render_size = square_only ? render_size(view.size, view.width_over_height) : view.size;
  const bool has_skew = program == CameraProgram::kUnity || program == CameraProgram::kOpenGl;
  report_losses(projector, !has_skew, settings.diagnostics);
  say_render_size(settings, view.size);
  SettingsText text(settings);
  switch (program) {
    case CameraProgram::kUnity:
      write_unity(view, lens.intrinsics, text);
      break;
    case CameraProgram::kUnreal:
      write_unreal(view, settings.render_size, text);
      break;
    case CameraProgram::kGodot:
      write_godot(view, settings.render_size, text, settings.diagnostics);
      break;
    case CameraProgram::kBlender:
      write_blender(view, text);
      break;
    case CameraProgram::kSplash:
      write_splash(view, settings.render_size, text);
      break;
    case CameraProgram::kSgct:
      write_sgct(view, text);
      break;
    case CameraProgram::kOpenGl:
      write_opengl(view, lens.intrinsics, text);
      break;
  }
  return settings;
}

}  // namespace procam::io
