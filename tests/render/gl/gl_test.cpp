/// GlRenderer draws what CpuRenderer draws: within 2 of 255 on 99.9 % of the pixels.
#include "procam/render/gl.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <random>

#include "procam/io/image/images.hpp"
#include "render/rooms.hpp"

namespace procam {
namespace {

using render::CpuRenderer;
using render::Filter;
using render::RenderOptions;
using render::RenderWork;
using render_gl::GlRenderer;

constexpr ImageSize kFrame{240, 160};  // drawn without a graphics card, pixels are dear
constexpr int kMaxApart = 2;           // of 255
constexpr double kMaxPixels = 1e-3;    // of the frame

Projector projector(bool lens) {
  Projector p{Camera{kFrame, {440, 430, 125.4, 201.1, 0.8}, NoDistortion{}}};
  if (lens) p.inverse_camera.distortion = brown(-0.19);
  return p;
}

/// Clouds, lines of one texel and hard edges; the last channel of four is a soft alpha.
ImageU8 picture(int width, int height, int channels, unsigned seed) {
  ImageU8 image(width, height, channels);
  std::mt19937 random(seed);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c) {
        double value = 120 + 60 * std::sin(0.031 * x + c) * std::cos(0.023 * y - c);
        if ((x / 37 + y / 29) % 3 == 0) value = (x + c * y) % 2 ? 250 : 5;
        if ((x / 50 + y / 60) % 4 == 1) value += int(random() % 80) - 40;
        image.at(x, y, c) = std::uint8_t(std::min(255.0, std::max(0.0, value)));
        if (c == 3)
          image.at(x, y, c) =
              std::uint8_t(std::min(255, 20 + std::min({x, y, width - 1 - x, height - 1 - y})));
      }
  return image;
}

/// Draws by both, and says how they differ; the pictures are written where they do (PROCAM_TEST_OUTPUT, else
/// the working directory).
void expect_same(const ImageU8& gl, const ImageU8& cpu, const std::string& name) {
  ASSERT_EQ(gl.size(), cpu.size());
  int apart = 0, most = 0, lit = 0;
  ImageU8 difference(gl.size(), 3);
  for (int y = 0; y < gl.height(); ++y)
    for (int x = 0; x < gl.width(); ++x) {
      int worst = 0;
      for (int c = 0; c < 3; ++c) {
        const int d = std::abs(gl.at(x, y, c) - cpu.at(x, y, c));
        difference.at(x, y, c) = std::uint8_t(std::min(255, 40 * d));
        worst = std::max(worst, d);
        lit += cpu.at(x, y, c) > 60;
      }
      apart += worst > kMaxApart;
      most = std::max(most, worst);
    }
  EXPECT_GT(lit, gl.width() * gl.height() / 10) << name << ": almost nothing is drawn";
  EXPECT_LE(apart, kMaxPixels * gl.width() * gl.height()) << name << ": at most " << most << " apart";
  if (apart <= kMaxPixels * gl.width() * gl.height()) return;
  const char* const folder = std::getenv("PROCAM_TEST_OUTPUT");
  const std::string path = (folder ? std::string(folder) + "/" : "") + "render_gl_" + name;
  io::save_image(path + "_gl.png", gl);
  io::save_image(path + "_cpu.png", cpu);
  io::save_image(path + "_difference.png", difference);
  ADD_FAILURE() << "see " << path << "_*.png (differences 40 times)";
}

RenderOptions drawn_with(Filter filter, bool linear_light) {
  RenderOptions options;
  options.filter = filter;
  options.linear_light = linear_light;
  return options;
}

using SceneFor = std::function<Scene(const Projector&)>;

void expect_same_with(GlRenderer& renderer, const RenderOptions& options, bool lens, const SceneFor& scene,
                      const std::string& name) {
  const Projector p = projector(lens);
  const Scene shown = scene(p);
  ImageU8 gl(kFrame, 3);
  renderer.render(shown, p, gl);
  expect_same(gl, render::render(shown, p, options),
              name + (lens ? "_lens" : "") + (options.filter == Filter::kArea ? "_area" : "_bilinear") +
                  (options.linear_light ? "_light" : "_values"));
}

const ImageU8& large() {
  static const ImageU8 image = picture(451, 330, 3, 1);
  return image;
}
const ImageU8& small() {
  static const ImageU8 image = picture(150, 120, 3, 2);
  return image;
}
const ImageU8& glass() {
  static const ImageU8 image = picture(333, 250, 4, 3);
  return image;
}

Sheet sheet(const Projector& p, double width, double height, double distance, double incidence_deg,
            const Vec2& middle = Vec2(125, 75)) {
  return tilted_sheet(p, width, height, distance, incidence_deg, middle);
}

Scene plane(const Projector& p) {
  Scene scene;
  scene.background[0] = 20, scene.background[2] = 160;
  scene.items = {{sheet(p, 0.7, 0.6, 1.6, 60).placement, large()}};
  return scene;
}

Scene pixel_surfaces(const Projector&) {
  PlacedPixels placed;
  placed.pixel_from_content << 205, 16, 20.3, -10, 130, 15.2, 0.1, 0.05, 1;
  Scene scene;
  scene.items = {{placed, large()}};
  placed.pixel_from_content << 105, 16, -10.3, -10, 80, 105.2, 0.1, 0.05, 1;
  scene.items.push_back({placed, glass()});
  return scene;
}

Pose facing(const Projector& p, double distance, const Vec3& turn) {
  const Mat3 rotation =
      (Eigen::AngleAxisd(turn.x(), Vec3::UnitX()) * Eigen::AngleAxisd(turn.y(), Vec3::UnitY()) *
       Eigen::AngleAxisd(turn.z(), Vec3::UnitZ()))
          .toRotationMatrix();
  return Pose(rotation, distance * p.emit(Vec2(125, 75))->direction);
}

/// What a depth camera sees of a heap: steps between near and far, noise, and the projector's own corner
/// behind it.
std::shared_ptr<const Mesh> heap() {
  constexpr int kAcross = 24, kDown = 18;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> noise(-0.004, 0.004);
  Mesh mesh;
  for (int j = 0; j <= kDown; ++j)
    for (int i = 0; i <= kAcross; ++i) {
      const double u = double(i) / kAcross, v = double(j) / kDown;
      const bool near = std::hypot(u - 0.4, v - 0.5) < 0.22;
      mesh.vertices.emplace_back(1.1 * (u - 0.5), 0.8 * (v - 0.5), (near ? -0.3 : 0.0) + noise(random));
      mesh.uv.emplace_back(u, v);
    }
  for (int j = 0; j < kDown; ++j)
    for (int i = 0; i < kAcross; ++i) {
      const int a = j * (kAcross + 1) + i, b = a + 1, c = a + kAcross + 1;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({c + 1, c, b});
    }
  // One large triangle that passes beside and behind the projector.
  const int first = int(mesh.vertices.size());
  mesh.vertices.emplace_back(-1.3, 0.9, -3.0);
  mesh.vertices.emplace_back(2.1, 1.0, 0.4);
  mesh.vertices.emplace_back(-1.4, 1.1, 0.5);
  for (const Vec2& uv : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1)}) mesh.uv.push_back(uv);
  mesh.triangles.push_back({first, first + 1, first + 2});
  return std::make_shared<const Mesh>(mesh);
}

struct Shaped {
  const char* name;
  std::shared_ptr<const Mesh> mesh;
  Pose projector_from_surface;
};

/// Every kind that is drawn as triangles.
std::vector<Shaped> shapes() {
  CylinderSurface column;
  column.radius = 0.31;
  column.left = -1.2;
  column.right = 1.4;
  column.top = -0.21;
  column.bottom = 0.24;
  SphereSurface globe;
  globe.radius = 0.27;
  globe.left = -2.1;
  globe.right = 1.9;
  globe.top = 1.3;
  globe.bottom = -1.2;
  GridSurface grid;
  grid.columns = 5;
  grid.rows = 4;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 5; ++i)
      grid.points.emplace_back(0.17 * i - 0.4, 0.16 * j - 0.3, 0.05 * std::sin(1.3 * i + j));
  BezierSurface bezier;
  bezier.columns = 4;
  bezier.rows = 3;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 4; ++i)
      bezier.control_points.emplace_back(0.24 * i - 0.4, 0.25 * j - 0.3, 0.15 * std::cos(1.9 * i - j));
  const Projector p = projector(false);
  const auto triangles = [](const SurfaceGeometry& geometry) {
    return mesh_of(Surface{"shape", geometry, {}, ""});
  };
  return {{"column", triangles(column), facing(p, 1.7, {0.2, -0.15, 0.1})},
          {"globe", triangles(globe), facing(p, 1.6, {0.3, 0.1, 0.2})},
          {"grid", triangles(grid), facing(p, 1.7, {0.3, 0.4, 0.1})},
          {"bezier", triangles(bezier), facing(p, 1.6, {-0.3, 0.3, -0.1})},
          {"heap", heap(), facing(p, 1.7, {0.3, -0.3, 0.1})}};
}

/// A wall, a poster on it, a sheet that cuts through both, a glass globe before them, a heap behind, and a
/// sticker in the middle of the list.
Scene full_room(const Projector& p) {
  Scene scene;
  scene.background[0] = 40, scene.background[1] = 30, scene.background[2] = 90;
  const Sheet wall = sheet(p, 1.3, 0.9, 2.0, 25);
  Sheet poster = wall;
  poster.placement.plane_from_content.leftCols<2>() *= 0.6;
  SphereSurface globe;
  globe.radius = 0.16;
  globe.left = -kPi;
  globe.right = kPi;
  globe.top = kPi / 2;
  globe.bottom = -kPi / 2;
  PlacedPixels sticker;
  sticker.pixel_from_content << 45, 5, 145, -4, 30, 20, 0, 0, 1;
  scene.items = {
      {wall.placement, large()},
      {poster.placement, small()},
      {sheet(p, 0.5, 0.6, 1.95, 50, Vec2(60, 80)).placement, small()},
      {sticker, glass()},
      {PlacedMesh{mesh_of(Surface{"globe", globe, {}, ""}), facing(p, 1.4, {0.4, 0.2, 0.1})}, glass()},
      {PlacedMesh{heap(), facing(p, 2.3, {0.1, -0.3, 0.1})}, small()},
      {sheet(p, 0.3, 0.3, 1.2, 15, Vec2(200, 130)).placement, glass()}};
  return scene;
}

/// A patch in projector pixels in the place of the sticker, and one on top of all.
Scene room_with_patches(const Projector& p) {
  PixelSurface patch;
  patch.shape = PixelShape::kBezier;
  patch.columns = patch.rows = 3;
  patch.pixels = {{120, 30}, {170, 5},   {230, 42},  {100, 70}, {180, 100},
                  {215, 66}, {128, 120}, {160, 140}, {236, 118}};
  Scene scene = full_room(p);
  const auto placed = [&] {
    return PlacedPixels{Mat3::Identity(), mesh_of(Surface{"patch", patch, {}, ""})};
  };
  scene.items[3].placement = placed();
  patch.shape = PixelShape::kGrid;
  for (Vec2& pixel : patch.pixels) pixel = Vec2(40, 60) + 0.4 * pixel;
  scene.items.push_back({placed(), small()});
  return scene;
}

/// Soft and hard, and nowhere the same on both sides; in memory wider than its rows.
ViewU8 mask() {
  static const ImageU8 image = [] {
    ImageU8 made(219, 85);
    for (int y = 0; y < 85; ++y)
      for (int x = 0; x < 219; ++x)
        made.at(x, y) = std::uint8_t((x / 17 + y / 11) % 3 == 0 ? 255 : (x + 2 * y) % 256);
    return made;
  }();
  return {image.data() + 3, 210, 85, 1, 219};
}

Scene masked_plane(const Projector& p) {
  Scene scene = plane(p);
  scene.items[0].mask = mask();
  return scene;
}

/// Masks on a plane among others, one that is cut through, a pixel surface, a ball and a heap.
Scene masked_room(const Projector& p) {
  Scene scene = full_room(p);
  for (const std::size_t i : {1, 2, 3, 4, 5}) scene.items[i].mask = mask();
  return scene;
}

/// Upright slats, now near, now far, of two or three pixels each: nearly every pixel holds an edge, and each
/// slat shows all of its content and mask.
Scene masked_slats(const Projector& p) {
  Mesh mesh;
  constexpr int kSlats = 80;
  for (int i = 0; i < kSlats; ++i) {
    const double x = 0.0096 * (i - kSlats / 2), z = i % 2 == 0 ? 0.0 : 0.25;
    const int first = int(mesh.vertices.size());
    for (const double v : {0.0, 1.0})
      for (const double u : {0.0, 1.0}) {
        mesh.vertices.emplace_back(x + 0.011 * u, 0.5 * v - 0.3, z);
        mesh.uv.emplace_back(u, v);
      }
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first + 1, first + 3, first + 2});
  }
  Scene scene;
  scene.background[0] = 40, scene.background[2] = 120;
  scene.items = {{PlacedMesh{std::make_shared<const Mesh>(mesh), facing(p, 1.6, {0.05, 0.1, 0.12})}, large()},
                 {sheet(p, 0.9, 0.5, 2.1, 20).placement, small()}};
  scene.items[0].mask = scene.items[1].mask = mask();
  return scene;
}

/// Drivers compile programs for each renderer, and without a card frames are slow: one renderer, each scene
/// once.
void expect_every_kind_the_same(const RenderOptions& options, bool lens) {
  GlRenderer renderer(options);
  expect_same_with(renderer, options, lens, plane, "plane");
  expect_same_with(renderer, options, lens, pixel_surfaces, "pixels");
  for (const Shaped& shape : shapes()) {
    Scene scene;
    scene.background[1] = 60;
    scene.items = {{PlacedMesh{shape.mesh, shape.projector_from_surface}, large()}};
    expect_same_with(
        renderer, options, lens, [&](const Projector&) { return scene; }, shape.name);
  }
  expect_same_with(renderer, options, lens, full_room, "room");
  expect_same_with(renderer, options, lens, room_with_patches, "room_with_patches");
  expect_same_with(renderer, options, lens, masked_plane, "masked_plane");
  expect_same_with(renderer, options, lens, masked_room, "masked_room");
  expect_same_with(renderer, options, lens, masked_slats, "masked_slats");
}

TEST(GlRenderer, DrawsEveryKindOfSurfaceAveraged) {
  expect_every_kind_the_same(drawn_with(Filter::kArea, true), true);
}

TEST(GlRenderer, DrawsEveryKindOfSurfaceInterpolated) {
  expect_every_kind_the_same(drawn_with(Filter::kBilinear, true), false);
}

TEST(GlRenderer, DrawsValuesThatAreNoColours) {
  for (const Filter filter : {Filter::kArea, Filter::kBilinear}) {
    const RenderOptions options = drawn_with(filter, false);
    GlRenderer renderer(options);
    expect_same_with(renderer, options, filter == Filter::kBilinear, masked_room, "masked_room");
  }
}

// Each frame is compared with that of a CPU renderer that knows nothing of the frames before.
TEST(GlRenderer, MakesAnewWhatChanged) {
  Projector p = projector(true);
  p.inverse_camera.size = {170, 120};  // the middle of things
  Scene scene = full_room(p);
  scene.items.resize(5);
  ImageU8 poster = small();
  scene.items[1].content = poster;
  GlRenderer renderer;
  const auto work = [&](const char* name) {
    ImageU8 gl(p.size(), 3);
    const RenderWork done = renderer.render(scene, p, gl);
    expect_same(gl, render::render(scene, p), std::string("changed_") + name);
    return std::make_pair(done.contents, done.maps);
  };
  EXPECT_EQ(work("first"), std::make_pair(5, 5));
  EXPECT_EQ(work("nothing"), std::make_pair(0, 0));
  std::get<PlacedMesh>(scene.items[4].placement).projector_from_surface.translation.x() += 0.03;
  EXPECT_EQ(work("globe"), std::make_pair(0, 1));
  std::get<PlacedPlane>(scene.items[2].placement).projector_from_surface.translation.y() -= 0.02;
  EXPECT_EQ(work("sheet"), std::make_pair(0, 1));
  const ImageU8 other = picture(150, 120, 3, 9);  // into the same memory
  std::copy_n(other.data(), 150 * 120 * 3, poster.data());
  ++scene.items[1].content_revision;
  EXPECT_EQ(work("poster"), std::make_pair(1, 0));
  scene.items[1].content = glass();  // another size, and no longer opaque
  EXPECT_EQ(work("glass").first, 1);
  ImageU8 alpha(30, 20, 1, 90);
  scene.items[0].mask = scene.items[4].mask = alpha;
  EXPECT_EQ(work("masked"), std::make_pair(2, 1));  // a mesh's map knows no pictures
  alpha.at(7, 9) = 255;
  ++scene.items[4].mask_revision;
  EXPECT_EQ(work("mask").first, 1);
  scene.items[0].mask = {};
  EXPECT_EQ(work("unmasked"), std::make_pair(0, 1));
  // Bent by hand, and the bend undone: the same homography as before is another map than the triangles'.
  const Placement flat = scene.items[3].placement;
  scene.items[3].placement = room_with_patches(p).items[3].placement;
  EXPECT_EQ(work("bent").second, 1);
  EXPECT_EQ(work("bent_still"), std::make_pair(0, 0));
  scene.items[3].placement = flat;
  EXPECT_EQ(work("flat_again").second, 1);
  scene.items.erase(scene.items.begin() + 2);
  work("fewer");
  p.inverse_camera.size = {140, 110};
  EXPECT_EQ(work("smaller").second, 4);
  p.inverse_camera.distortion = NoDistortion{};
  EXPECT_EQ(work("pinhole").second, 4);
}

TEST(GlRenderer, RefusesWhatTheCpuRendererRefuses) {
  GlRenderer renderer;
  const Projector p = projector(false);
  ImageU8 grey(kFrame, 1), other({10, 10}, 3), frame(kFrame, 3);
  EXPECT_THROW(renderer.render({}, p, grey), std::invalid_argument);
  EXPECT_THROW(renderer.render({}, p, other), std::invalid_argument);
  const ImageU8 two(8, 8, 2);
  Scene scene;
  scene.items = {{PlacedPixels{}, two}};
  EXPECT_THROW(renderer.render(scene, p, frame), std::invalid_argument);
  EXPECT_THROW(renderer.draw({}, p, 1000), std::invalid_argument) << "it has no window";
  EXPECT_FALSE(renderer.device().empty());
}

}  // namespace
}  // namespace procam
