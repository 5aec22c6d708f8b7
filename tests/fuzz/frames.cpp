// The same frame drawn twice: by every width of vectors, by a renderer that keeps what it can and by a new
// one, by OpenGL, and from the log of the run.
#include "draws.hpp"
#include "fuzz_target.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/render/cpu.hpp"
#include "procam/render/gl.hpp"
#include "procam/show/projection.hpp"
#include "procam/track/wire.hpp"
#include "render/kernels.hpp"
#include "show/run_log.hpp"
#include "targets.hpp"

namespace procam::fuzz {
namespace {

/// Noise, stripes or one colour; of alphas also none and all.
ImageU8 drawn_picture(Draws& draws, int channels) {
  ImageU8 picture(1 + int(draws.below(70)), 1 + int(draws.below(50)), channels);
  const std::size_t kind = draws.below(3);
  const int seed = int(draws.below(256));
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x)
      for (int c = 0; c < channels; ++c)
        picture.at(x, y, c) =
            std::uint8_t(kind == 0   ? (x * 2654435761u ^ y * 40503u ^ unsigned(c * 77 + seed)) >> 7
                         : kind == 1 ? (x / 3 + y / 2 + c) % 2 * 255
                                     : (c == 3 ? seed % 3 * 127 : seed));
  return picture;
}

/// -1 .. 1, in steps that are powers of two.
double unit(Draws& draws) {
  return (double(draws.below(65536)) - 32768) / 32768;
}
Vec3 drawn_vector(Draws& draws) {
  const double x = unit(draws), y = unit(draws);
  return {x, y, unit(draws)};
}

Projector drawn_projector(Draws& draws, ImageSize largest) {
  Projector projector;
  Camera& camera = projector.inverse_camera;
  camera.size = {1 + int(draws.below(std::size_t(largest.width))),
                 1 + int(draws.below(std::size_t(largest.height)))};
  const double focal = camera.size.width * (0.3 + 2 * std::abs(unit(draws)));
  camera.intrinsics = {focal, focal * (1 + 0.2 * unit(draws)), camera.size.width * (0.5 + 0.5 * unit(draws)),
                       camera.size.height * (0.5 + unit(draws)), 2 * unit(draws)};
  switch (draws.below(4)) {
    case 0:
      camera.distortion =
          BrownConrady{{0.3 * unit(draws), 0.1 * unit(draws), 0.003, -0.002, 0.01 * unit(draws)}};
      break;
    case 1:
      camera.distortion =
          RationalDistortion{{0.3 * unit(draws), 0.1, 0.001, -0.002, 0.01, 0.2 * unit(draws), 0, 0}};
      break;
    case 2:
      camera.distortion = FisheyeDistortion{{0.1 * unit(draws), 0.02 * unit(draws), 0, 0}};
      break;
    default:
      break;
  }
  return projector;
}

/// In front of the projector more often than not.
Pose drawn_pose(Draws& draws) {
  const bool is_usual = draws.below(4) != 0;
  const Vec3 turn = (is_usual ? 0.5 : 3) * drawn_vector(draws);
  const Vec3 shift = drawn_vector(draws);
  return Pose(so3_exp(turn), shift + (is_usual ? Vec3(-0.3, -0.3, 1.7) : Vec3(0, 0, 0)));
}

/// Content to `size`: with corners that moved a little, or any.
Mat3 drawn_homography(Draws& draws, const Vec2& size) {
  const bool is_usual = draws.below(4) != 0;
  Mat3 h = Mat3::Zero();
  if (is_usual) h.setIdentity();
  for (int i = 0; i < 9; ++i) h(i / 3, i % 3) += 0.3 * unit(draws);
  if (is_usual) h(2, 2) = 1;
  h.row(0) *= size.x();
  h.row(1) *= size.y();
  return h;
}

std::shared_ptr<const Mesh> drawn_mesh(Draws& draws) {
  Mesh mesh;
  const std::size_t count = 3 + draws.below(20);
  for (std::size_t i = 0; i < count; ++i) {
    mesh.vertices.push_back(drawn_vector(draws));
    const double u = unit(draws);
    mesh.uv.emplace_back(0.5 + u, 0.5 + unit(draws));
  }
  for (std::size_t i = 0, triangles = 1 + draws.below(24); i < triangles; ++i) {
    const int a = int(draws.below(count)), b = int(draws.below(count));
    mesh.triangles.push_back({a, b, int(draws.below(count))});
    if (fault_of(mesh)) mesh.triangles.pop_back();
  }
  if (mesh.triangles.empty()) return nullptr;
  return std::make_shared<const Mesh>(std::move(mesh));
}

/// As surfaces that were solved have it: the whole content is before the horizon, and none of it a line.
bool is_of_a_surface(const Mat3& h) {
  for (const Vec3& corner : {Vec3(0, 0, 1), Vec3(1, 0, 1), Vec3(1, 1, 1), Vec3(0, 1, 1)})
    if (!(h.row(2).dot(corner) > 0.1 * h.row(2).norm())) return false;
  return std::abs(h.determinant()) > 0.02 * h.row(0).norm() * h.row(1).norm() * h.row(2).norm();
}

/// Surfaces of all kinds, and the pictures on them.
struct DrawnScene {
  Projector projector;
  std::vector<ImageU8> pictures;
  Scene scene;

  explicit DrawnScene(Draws& draws) : projector(drawn_projector(draws, {300, 60})) {
    for (std::uint8_t& value : scene.background) value = std::uint8_t(draws.below(256));
    const std::size_t count = 1 + draws.below(4);
    pictures.reserve(2 * count);
    for (std::size_t i = 0; i < count; ++i) {
      SceneItem item;
      item.placement = placement(draws);
      constexpr int kChannels[] = {1, 3, 4};
      item.content = pictures.emplace_back(drawn_picture(draws, kChannels[draws.below(3)])).view();
      if (draws.below(3) == 0) item.mask = pictures.emplace_back(drawn_picture(draws, 1)).view();
      const auto* mesh = std::get_if<PlacedMesh>(&item.placement);
      if (mesh == nullptr || mesh->mesh) scene.items.push_back(item);
    }
  }

  /// Leaves only what a file of surfaces can lead to.
  void keep_solvable() {
    const auto is_odd = [](const SceneItem& item) {
      if (const auto* plane = std::get_if<PlacedPlane>(&item.placement))
        return !is_of_a_surface(plane->plane_from_content);
      if (const auto* pixels = std::get_if<PlacedPixels>(&item.placement))
        return !is_of_a_surface(pixels->pixel_from_content);
      return std::get<PlacedMesh>(item.placement).content_from_point.has_value();
    };
    scene.items.erase(std::remove_if(scene.items.begin(), scene.items.end(), is_odd), scene.items.end());
  }

  /// One of the surfaces moves.
  void move(Draws& draws) {
    if (scene.items.empty()) return;
    Placement& placement = scene.items[draws.below(scene.items.size())].placement;
    if (auto* plane = std::get_if<PlacedPlane>(&placement)) plane->projector_from_surface = drawn_pose(draws);
    if (auto* mesh = std::get_if<PlacedMesh>(&placement)) mesh->projector_from_surface = drawn_pose(draws);
    if (auto* pixels = std::get_if<PlacedPixels>(&placement)) pixels->pixel_from_content(0, 2) += 3.5;
  }

 private:
  Placement placement(Draws& draws) const {
    switch (draws.below(3)) {
      case 0:
        return PlacedPlane{drawn_homography(draws, Vec2(1, 0.7)), drawn_pose(draws)};
      case 1:
        return PlacedPixels{drawn_homography(draws, Vec2(projector.size().width, projector.size().height))};
      default: {
        PlacedMesh mesh{drawn_mesh(draws), drawn_pose(draws)};
        if (draws.below(4) == 0) {
          mesh.content_from_point.emplace();
          for (int i = 0; i < 12; ++i) (*mesh.content_from_point)(i / 4, i % 4) = unit(draws);
        }
        return mesh;
      }
    }
  }
};

render::RenderOptions drawn_options(Draws& draws) {
  render::RenderOptions options;
  options.filter = draws.yes() ? render::Filter::kArea : render::Filter::kBilinear;
  options.linear_light = draws.yes();
  options.threads = 1;
  return options;
}

void check_same_pixels(const ImageU8& a, const ImageU8& b, const char* what) {
  for (int y = 0; y < a.height(); ++y) {
    const auto [one, other] = std::mismatch(a.row(y), a.row(y) + 3 * a.width(), b.row(y));
    if (one == a.row(y) + 3 * a.width()) continue;
    check(false, what + std::string(": pixel ") + std::to_string((one - a.row(y)) / 3) + ", " +
                     std::to_string(y) + " is " + std::to_string(*one) + ", and " + std::to_string(*other));
  }
}

/// A picture with the copies of its last column and row that kernels read.
template <typename Pixel>
struct Texture {
  std::vector<Pixel> texels;
  render::TexelsView<Pixel> view;

  Texture(int width, int height, Draws& draws)
      : texels(std::size_t(width + 1) * std::size_t(height + 1) * 4) {
    const std::string_view pattern = draws.bytes(64);
    for (std::size_t i = 0; i < texels.size(); ++i) {
      const unsigned byte = pattern.empty() ? unsigned(i) : std::uint8_t(pattern[i * 7 % pattern.size()]);
      texels[i] = sizeof(Pixel) == 1 ? Pixel(byte) : Pixel(byte % 256 * 128);
    }
    view = {texels.data(), width, height, width + 1};
    for (int y = 0; y <= height; ++y)
      for (int x = 0; x <= width; ++x)
        std::copy_n(at(std::min(x, width - 1), std::min(y, height - 1)), 4, at(x, y));
  }
  Pixel* at(int x, int y) { return texels.data() + (std::ptrdiff_t(y) * view.stride + x) * 4; }
};

/// What `draw(kernels, to)` writes for `count` pixels is the same by all widths.
template <typename Pixel, typename Draw>
void check_same_by_all(int count, const std::vector<Pixel>& there, const char* what, const Draw& draw) {
  std::vector<Pixel> plain = there;
  draw(render::kPlainKernels, plain.data());
  for (const auto& [bits, gathers] : {std::pair(256, false), std::pair(512, false), std::pair(512, true)}) {
    std::vector<Pixel> wide = there;
    draw(render::kernels_for(bits, gathers), wide.data());
    check(std::equal(plain.begin(), plain.begin() + count, wide.begin()),
          std::string(what) + " differs by vectors of " + std::to_string(bits) + " bits");
  }
}

template <typename Pixel>
std::vector<Pixel> drawn_row(Draws& draws) {
  std::vector<Pixel> row(4 * render::kRowRoom);
  const std::string_view pattern = draws.bytes(48);
  const int whole = sizeof(Pixel) == 1 ? 255 : render::kFull;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const unsigned byte = pattern.empty() ? 0 : std::uint8_t(pattern[i * 5 % pattern.size()]);
    row[i] = Pixel(sizeof(Pixel) == 1 ? byte : std::min(byte * 128 + byte % 128, unsigned(whole)));
    if (i % 4 == 3 && byte % 3 == 0) row[i] = Pixel(whole);
  }
  return row;
}

}  // namespace

/// Rows of any values, positions and maps.
void kernels(std::string_view bytes) {
  using render::Kernels, render::Light, render::Value, render::kTileWidth;
  Draws draws(bytes);
  const int begin = int(draws.below(kTileWidth)),
            count = 1 + int(draws.below(std::size_t(kTileWidth - begin)));
  switch (draws.below(8)) {
    case 0: {
      const auto drawn = drawn_row<Value>(draws), there = drawn_row<Value>(draws);
      check_same_by_all(4 * count, there, "values_over",
                        [&](const Kernels& k, Value* to) { k.values_over(drawn.data(), count, to); });
      return check_same_by_all(4 * count, there, "values_alpha",
                               [&](const Kernels& k, Value* to) { k.values_alpha(drawn.data(), count, to); });
    }
    case 1: {
      const auto drawn = drawn_row<Light>(draws), there = drawn_row<Light>(draws);
      check_same_by_all(4 * count, there, "light_over",
                        [&](const Kernels& k, Light* to) { k.light_over(drawn.data(), count, to); });
      return check_same_by_all(4 * count, there, "light_alpha",
                               [&](const Kernels& k, Light* to) { k.light_alpha(drawn.data(), count, to); });
    }
    case 2: {
      const auto from = drawn_row<Value>(draws), there = drawn_row<Value>(draws);
      check_same_by_all(3 * count, there, "values_to_rgb",
                        [&](const Kernels& k, Value* to) { k.values_to_rgb(from.data(), count, to); });
      const std::vector<Value> exactly(from.begin(), from.begin() + 3 * count);
      return check_same_by_all(4 * count, there, "rgb_to_texels", [&](const Kernels& k, Value* to) {
        k.rgb_to_texels(exactly.data(), count, to);
      });
    }
    default:
      break;
  }
  const int width = 1 + int(draws.below(100)), height = 1 + int(draws.below(60));
  const auto number = [&] { return float(std::clamp(draws.number(), -3e38, 3e38)); };
  if (draws.yes()) {
    const Texture<Value> texture(width, height, draws);
    render::RowMap row{};
    row.s0 = -1;
    row.ds = 2.0f / kTileWidth;
    for (float& q : row.q) q = number();
    if (draws.yes()) row.q[6] = row.q[7] = row.q[8] = 0;
    return check_same_by_all<Value>(4 * count, std::vector<Value>(4 * render::kRowRoom), "sample_cells",
                                    [&](const Kernels& k, Value* to) {
                                      render::RowCells cells;
                                      k.find_cells(texture.view, row, begin, begin + count, 0, cells);
                                      cells.clear(count, (count + 15) / 16 * 16);
                                      k.sample_cells(texture.view, cells, 3, count, to);
                                    });
  }
  render::Points points;
  for (int i = begin; i < begin + count; ++i) {
    points.u[i] = number();
    points.v[i] = number();
  }
  if (draws.yes()) {
    const Texture<Value> texture(width, height, draws);
    return check_same_by_all<Value>(
        4 * count, std::vector<Value>(4 * render::kRowRoom), "sample_values",
        [&](const Kernels& k, Value* to) { k.sample_values(texture.view, points, begin, count, to); });
  }
  for (int i = begin; i < begin + count && !draws.empty(); ++i) {
    points.u_x[i] = number();
    points.v_y[i] = number();
  }
  const Texture<Light> texture(width, height, draws);
  const render::FilterGrid taps{0, 1 + int(draws.below(11)), 1 + int(draws.below(11)), float(unit(draws)),
                                float(unit(draws))};
  check_same_by_all<Light>(
      4 * count, std::vector<Light>(4 * render::kRowRoom), "sample_light",
      [&](const Kernels& k, Light* to) { k.sample_light(texture.view, taps, points, begin, count, to); });
}

/// Three frames, of which the last two are of a scene that moved: by every width, and by a renderer without a
/// past.
void vector_widths(std::string_view bytes) {
  Draws draws(bytes);
  render::RenderOptions options = drawn_options(draws);
  DrawnScene drawn(draws);
  std::vector<render::CpuRenderer> renderers;
  for (const int bits : {0, 256, 512}) {
    options.vector_bits = bits;
    renderers.emplace_back(options);
  }
  for (int frame = 0; frame < 3; ++frame) {
    const ImageU8 anew = render::render(drawn.scene, drawn.projector, options);
    for (render::CpuRenderer& renderer : renderers) {
      ImageU8 kept(drawn.projector.size(), 3, 99);
      renderer.render(drawn.scene, drawn.projector, kept);
      check_same_pixels(anew, kept, "by a new renderer, and by one that has drawn before");
    }
    if (frame == 0) drawn.move(draws);
  }
}

/// By OpenGL where there is any: within 2 of 255 but for some pixels, most of them on edges.
void renderers(std::string_view bytes) {
  Draws draws(bytes);
  const render::RenderOptions options = drawn_options(draws);
  DrawnScene drawn(draws);
  drawn.keep_solvable();
  static const bool has_gl = [] {
    try {
      return render_gl::open_renderer("gl") != nullptr;
    } catch (const Error&) {
      return false;
    }
  }();
  if (!has_gl) return;
  static std::unique_ptr<render::Renderer> by_options[2][2];
  std::unique_ptr<render::Renderer>& gl =
      by_options[options.filter == render::Filter::kArea ? 1 : 0][options.linear_light ? 1 : 0];
  if (!gl) gl = render_gl::open_renderer("gl", options);
  static std::uint64_t revision = 0;
  Scene scene = drawn.scene;
  for (SceneItem& item : scene.items) item.content_revision = item.mask_revision = ++revision;
  const ImageU8 by_cpu = render::render(scene, drawn.projector, options);
  ImageU8 by_gl(drawn.projector.size(), 3);
  gl->render(scene, drawn.projector, by_gl);
  int apart = 0;
  for (int y = 0; y < by_cpu.height(); ++y)
    for (int x = 0; x < by_cpu.width(); ++x) {
      int largest = 0;
      for (int c = 0; c < 3; ++c)
        largest = std::max(largest, std::abs(by_cpu.at(x, y, c) - by_gl.at(x, y, c)));
      apart += largest > 2 ? 1 : 0;
    }
  check(apart <= 20 + by_cpu.width() * by_cpu.height() / 50,
        std::to_string(apart) + " pixels differ by OpenGL");
}

namespace {

/// Around (0, 0, 2) in the frame that they are placed in.
SurfaceGeometry drawn_geometry(Draws& draws) {
  constexpr const char* kFrames[] = {"world", "world", "rig", "projector"};
  const Points2 content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const auto placed = [&](auto shape) {
    shape.frame = kFrames[draws.below(4)];
    const Vec3 turn = 0.5 * drawn_vector(draws);
    shape.frame_from_surface = Pose(so3_exp(turn), drawn_vector(draws) + Vec3(0, 0, 2));
    return shape;
  };
  switch (draws.below(4)) {
    case 0: {
      PixelSurface pixels{content, {}};
      for (const Vec2& uv : content) pixels.pixels.push_back(200 * uv + 90 * drawn_vector(draws).head<2>());
      return pixels;
    }
    case 1: {
      GridSurface grid;
      grid.columns = 3;
      grid.rows = 2;
      for (int i = 0; i < 6; ++i)
        grid.points.push_back(Vec3(0.4 * (i % 3), 0.5 * (i / 3), 0) + 0.1 * drawn_vector(draws));
      return placed(grid);
    }
    case 2: {
      CylinderSurface column;
      column.radius = 0.3 + 0.2 * unit(draws);
      column.left = -1 + 0.5 * unit(draws);
      column.right = 1 + 0.5 * unit(draws);
      column.top = -0.3;
      column.bottom = 0.4;
      return placed(column);
    }
    default: {
      PlanarSurface plane;
      plane.content = content;
      for (const Vec2& uv : content) plane.points.push_back(uv + 0.3 * drawn_vector(draws).head<2>());
      return placed(plane);
    }
  }
}

SurfaceSet drawn_surfaces(Draws& draws) {
  SurfaceSet set;
  for (std::size_t i = 0, count = 1 + draws.below(3); i < count; ++i)
    set.surfaces.push_back({"surface " + std::to_string(i), drawn_geometry(draws), {}, ""});
  return set;
}

/// One point moves, as by an editor: any number, not one that a file was read with.
void drag_point(SurfaceSet& set, Draws& draws) {
  if (set.surfaces.empty()) return;
  SurfaceGeometry& geometry = set.surfaces[draws.below(set.surfaces.size())].geometry;
  if (auto* plane = std::get_if<PlanarSurface>(&geometry))
    plane->points[draws.below(plane->points.size())] += drawn_vector(draws).head<2>() / 3;
  if (auto* pixels = std::get_if<PixelSurface>(&geometry))
    pixels->pixels[draws.below(pixels->pixels.size())] += drawn_vector(draws).head<2>() / 3;
}

/// As it comes from a socket: written by a sender, and parsed.
track::StampedPose received_message(Draws& draws, double time) {
  track::StampedPose message;
  message.frame = draws.below(8) == 0 ? "map" : "world";
  message.child = "base";
  const Vec3 turn = 0.4 * drawn_vector(draws);
  message.frame_from_child = Pose(so3_exp(turn), 0.3 * drawn_vector(draws));
  if (draws.below(4) != 0) message.stamp = 1.7e9 + time + 0.05 * unit(draws);
  if (draws.below(3) == 0) message.twist = (Vec6() << drawn_vector(draws), drawn_vector(draws)).finished();
  if (draws.below(3) == 0) message.angular_rate = drawn_vector(draws);
  if (draws.below(3) == 0) message.covariance = 1e-4 * (1.01 + unit(draws)) * Mat6::Identity();
  if (draws.below(3) == 0) message.sequence = std::uint32_t(draws.below(256));
  const track::Parsed parsed =
      track::parse_poses(draws.yes() ? track::to_json_line(message) : track::to_binary(message));
  check(parsed.poses.size() == 1, "a valid message is refused: " + parsed.why);
  track::StampedPose received = parsed.poses[0];
  received.arrival = time;
  return received;
}

}  // namespace

/// A run of poses, surfaces and pictures is recorded as it is drawn; drawn again from its log it shows the
/// same frames.
void replay(std::string_view bytes) {
  Draws draws(bytes);
  Rig rig;
  const Projector projector = drawn_projector(draws, {60, 40});
  const Vec3 turn = 0.2 * drawn_vector(draws);
  rig.projectors.push_back({"lamp", projector, Pose(so3_exp(turn), 0.2 * drawn_vector(draws))});
  const std::filesystem::path log = folder() / "replayed.log", surfaces = folder() / "surfaces.json";
  const auto projection = [&] {
    show::ProjectionOptions options;
    options.projector = "lamp";
    options.blank_on_stale = bytes.size() % 2 == 0;
    render::RenderOptions drawing;
    drawing.threads = 1;
    options.renderer = std::make_shared<render::CpuRenderer>(drawing);
    return show::Projection(rig, std::move(options));
  };
  const auto content = [](int seed) {
    ImageU8 picture(13 + seed, 11, 3);
    for (int i = 0; i < 33 * picture.width(); ++i) picture.data()[i] = std::uint8_t(i * 37 + seed);
    return std::shared_ptr<device::ContentSource>(device::still_content(std::move(picture)));
  };
  const auto show_of = [&](const SurfaceSet& set) {
    show::Show show;
    show.surfaces = set;
    for (std::size_t i = 0; i < set.surfaces.size(); ++i) show.contents.push_back(content(int(i)));
    return show;
  };
  ImageU8 frame(rig.projectors[0].projector.size(), 3);
  {
    show::Projection live = projection();
    show::RunRecorder recorder(log, "fuzzing");
    double time = 100 * unit(draws);
    long long number = 0;
    for (int i = 0; i < 60 && !draws.empty(); ++i) {
      time += draws.below(4) == 0 ? 2 * unit(draws) : 0.01 * double(draws.below(10));
      switch (draws.below(8)) {
        case 0: {
          // The log's digits are what both begin with.
          const SurfaceSet set =
              io::surfaces_from_text(io::surfaces_to_text(drawn_surfaces(draws)), surfaces);
          try {
            live.set_show(show_of(set));
          } catch (const Error&) {
            break;  // refused: the show from before goes on
          }
          recorder.record(live.show().surfaces);
          break;
        }
        case 1: {
          SurfaceSet set = live.show().surfaces;
          drag_point(set, draws);
          try {
            live.set_show(show_of(set));
          } catch (const Error&) {
            break;
          }
          recorder.record(live.show().surfaces);
          break;
        }
        case 2:
          live.set_picture(show::TestPattern(draws.below(3)));
          recorder.record(live.picture());
          break;
        case 3:
        case 4: {
          const show::DrawnFrame drawn = live.draw(time, time - 1, frame);
          check(drawn.pose.frame_from_child.translation.allFinite() && drawn.pose.covariance.allFinite() &&
                    std::isfinite(drawn.pose_error),
                "a drawn pose is not finite");
          recorder.record(show::RecordedFrame{number++, time, time - 1, show::fingerprint(frame.view())});
          break;
        }
        default: {
          const track::StampedPose message = received_message(draws, time);
          live.add(message);
          recorder.record(message);
        }
      }
    }
  }
  show::Projection again = projection();
  show::RunReader reader(log, surfaces);
  while (const std::optional<show::RunRecord> record = reader.next()) {
    if (const auto* set = std::get_if<SurfaceSet>(&*record)) again.set_show(show_of(*set));
    if (const auto* picture = std::get_if<show::TestPattern>(&*record)) again.set_picture(*picture);
    if (const auto* message = std::get_if<track::StampedPose>(&*record)) again.add(*message);
    if (const auto* recorded = std::get_if<show::RecordedFrame>(&*record)) {
      again.draw(recorded->light_time, recorded->content_time, frame);
      check(show::fingerprint(frame.view()) == recorded->fingerprint,
            "frame " + std::to_string(recorded->number) + " is another when the run is shown again");
    }
  }
}

}  // namespace procam::fuzz
