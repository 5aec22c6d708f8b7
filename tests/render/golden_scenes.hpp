#pragma once
/// One small frame of every kind of surface and filter, for every renderer to draw (render/golden.hpp).
#include <functional>
#include <memory>

#include "procam/render/viewer.hpp"
#include "procam/surface/lay_out.hpp"
#include "render/rooms.hpp"

namespace procam {

/// Whoever draws it has what its views look at.
struct GoldenScene {
  std::string name;
  render::RenderOptions options;
  Projector projector;
  Scene scene;
  std::shared_ptr<const void> keeps;
};

/// Whole numbers alone, the same everywhere: tiles of one colour each with a number of fine lines across, a
/// white rim, and its first corner red. With alpha: clear, half and solid stripes.
inline ImageU8 golden_picture(int width, int height, int channels) {
  ImageU8 image(width, height, channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int i = 8 * x / width, j = 6 * y / height, n = (7 * i + 3 * j) % 8;
      const bool rim = std::min({x, y, width - 1 - x, height - 1 - y}) < width / 48 + 1;
      const bool line = (i + j) % 3 == 0 && (x * 96 / width) % 2 == 0,
                 corner = x < width / 10 && y < height / 10;
      const int colour[3] = {40 + 25 * n, 230 - 27 * n, (n % 3) * 100};
      for (int c = 0; c < channels; ++c) {
        int value = c == 3 ? (j % 3 == 0 ? 255 : j % 3 == 1 ? 128 : 0) : line ? 20 : colour[c];
        if (rim) value = 255;
        if (corner) value = c == 0 || c == 3 ? 255 : 0;
        image.at(x, y, c) = std::uint8_t(value);
      }
    }
  return image;
}

inline Projector golden_projector(bool lens) {
  const Distortion distortion = lens ? brown(-0.19) : Distortion(NoDistortion{});
  return {Camera{{160, 120}, {251, 246, 75.3, 131.6, 0.8}, distortion}};
}

inline std::vector<GoldenScene> golden_scenes() {
  struct Pictures {
    ImageU8 fine = golden_picture(480, 360, 3), coarse = golden_picture(64, 48, 3),
            grey = golden_picture(96, 72, 1), alpha = golden_picture(192, 144, 4), mask{64, 48},
            white{1, 1, 1, 255};
    std::vector<surface::LaidOut> laid;
    std::vector<render::ViewerScene> viewer;
  };
  const auto keeps = std::make_shared<Pictures>();
  for (int y = 0; y < 48; ++y)
    for (int x = 0; x < 64; ++x)
      keeps->mask.at(x, y) = std::uint8_t((x / 8 + y / 8) % 2 == 0 ? 255 : std::min(255, 4 * x));
  std::vector<GoldenScene> scenes;
  const auto filtered = [](render::Filter filter, bool light) {
    render::RenderOptions chosen;
    chosen.filter = filter;
    chosen.linear_light = light;
    return chosen;
  };
  const auto area = filtered(render::Filter::kArea, true), plain = filtered(render::Filter::kBilinear, true),
             numbers = filtered(render::Filter::kArea, false),
             values = filtered(render::Filter::kBilinear, false);
  const auto add = [&](const std::string& name, const render::RenderOptions& options, bool lens,
                       std::vector<SceneItem> items) {
    GoldenScene one{name, options, golden_projector(lens), {}, keeps};
    one.scene.items = std::move(items);
    one.scene.background[0] = 30, one.scene.background[1] = 36, one.scene.background[2] = 60;
    scenes.push_back(std::move(one));
  };
  const Projector p = golden_projector(true);
  const auto sheet = [&](double width, double height, double distance, double incidence, const Vec2& middle) {
    return tilted_sheet(p, width, height, distance, incidence, middle).placement;
  };
  const Vec2 middle(80, 60);
  const PlacedPlane facing = sheet(0.85, 0.62, 1.7, 25, middle), grazing = sheet(2.2, 0.9, 2.2, 66, middle);

  add("plane_area", area, true, {{facing, keeps->fine}});
  add("plane_bilinear", plain, true, {{facing, keeps->fine}});
  add("plane_grazing_area", area, true, {{grazing, keeps->fine}});
  add("plane_grazing_bilinear", plain, false, {{grazing, keeps->fine}});
  add("plane_magnified", area, false, {{sheet(1.5, 1.1, 1.6, 20, Vec2(60, 40)), keeps->coarse}});
  add("plane_grey_numbers_area", numbers, true, {{facing, keeps->grey}});
  add("plane_values_bilinear", values, true, {{facing, keeps->fine}});

  PlacedPixels pixels;
  pixels.pixel_from_content << 110, 14, 22, -8, 84, 20, 0.1, 0.06, 1;
  add("pixels_area", area, true, {{pixels, keeps->fine}});

  // A polygon with a hole, fitted into it.
  Surface polygon;
  polygon.name = "polygon";
  polygon.layout.fit = Fit::kCover;
  polygon.shape.outline = {{0.02, 0.1}, {0.6, 0}, {1, 0.45}, {0.7, 1}, {0.1, 0.8}};
  polygon.shape.holes = {Points2{{0.4, 0.35}, {0.62, 0.4}, {0.5, 0.65}}};
  keeps->laid.push_back(surface::lay_out(facing, polygon, keeps->fine.size()));
  SceneItem outlined{keeps->laid[0].placement, keeps->laid[0].part(keeps->fine)};
  outlined.mask = keeps->laid[0].mask;
  add("polygon_with_hole_area", area, true, {outlined});
  add("polygon_with_hole_values", values, true, {outlined});

  const auto turned = [](double x, double y, double z) {
    return Mat3((Eigen::AngleAxisd(x, Vec3::UnitX()) * Eigen::AngleAxisd(y, Vec3::UnitY()) *
                 Eigen::AngleAxisd(z, Vec3::UnitZ()))
                    .toRotationMatrix());
  };
  const auto placed = [&](const SurfaceGeometry& geometry, double distance, const Mat3& rotation) {
    return PlacedMesh{mesh_of(Surface{"shape", geometry, {}, ""}),
                      Pose(rotation, distance * p.emit(middle)->direction)};
  };
  CylinderSurface column;
  column.radius = 0.29;
  column.left = -1.3;
  column.right = 1.2;
  column.top = -0.22;
  column.bottom = 0.25;
  CylinderSurface niche = column;
  niche.radius = 0.5;
  niche.left = -0.7;
  niche.right = 0.8;
  niche.seen_from = SeenFrom::kInside;
  SphereSurface globe;
  globe.radius = 0.27;
  globe.left = -2.1;
  globe.right = 1.9;
  globe.top = 1.4;
  globe.bottom = -1.2;
  GridSurface grid;
  grid.columns = 5;
  grid.rows = 4;
  const double bumps[] = {0, 0.06, -0.04, 0.07, 0.02};
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 5; ++i)
      grid.points.emplace_back(0.19 * i - 0.39, 0.18 * j - 0.28, bumps[(2 * i + 3 * j) % 5]);
  BezierSurface bezier;
  bezier.columns = 4;
  bezier.rows = 3;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 4; ++i)
      bezier.control_points.emplace_back(0.25 * i - 0.4, 0.27 * j - 0.3, 3 * bumps[(i + 2 * j) % 5]);
  add("column_area", area, true, {{placed(column, 1.7, turned(0.2, -0.15, 0.1)), keeps->fine}});
  add("niche_bilinear", plain, true, {{placed(niche, 1.4, turned(-0.1, 0.2, -0.12)), keeps->fine}});
  const PlacedMesh ball = placed(globe, 1.5, turned(0.3, 0.1, 0.2));
  add("globe_area", area, true, {{ball, keeps->fine}});
  add("globe_bilinear", plain, false, {{ball, keeps->fine}});
  add("globe_values", values, true, {{ball, keeps->fine}});
  add("grid_area", area, true, {{placed(grid, 1.6, turned(0.3, 0.4, 0.1)), keeps->fine}});
  add("bezier_area", area, true, {{placed(bezier, 1.6, turned(-0.3, 0.3, -0.1)), keeps->fine}});

  // As a scanner gives it: triangles of both senses, one that stands out and hides others.
  Mesh scan;
  for (int j = 0; j < 5; ++j)
    for (int i = 0; i < 6; ++i) {
      scan.vertices.emplace_back(0.18 * i - 0.45, 0.16 * j - 0.33,
                                 i == 3 && j == 2 ? -0.3 : bumps[(i * i + j) % 5]);
      scan.uv.emplace_back(i / 5.0, j / 4.0);
    }
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 5; ++i) {
      const int a = 6 * j + i;
      scan.triangles.push_back({a, a + 1, a + 6});
      scan.triangles.push_back({a + 7, a + 1, a + 6});
    }
  const PlacedMesh scanned{std::make_shared<const Mesh>(scan),
                           Pose(turned(0.2, 0.7, 0.1), 1.6 * p.emit(middle)->direction)};
  add("mesh_area", area, true, {{scanned, keeps->fine}});
  add("mesh_bilinear", plain, true, {{scanned, keeps->fine}});
  add("mesh_numbers", numbers, false, {{scanned, keeps->fine}});

  // As a depth camera sees a step: every second pixel a vertex, uv by the picture's place.
  Mesh depth;
  for (int j = 0; j < 13; ++j)
    for (int i = 0; i < 17; ++i) {
      const double z = (i < 9 ? 1.9 : 1.55) + 0.01 * ((i * j) % 3);
      depth.vertices.emplace_back((i - 8) * 0.06 * z, (j - 6) * 0.06 * z - 0.42, z);
      depth.uv.emplace_back(i / 16.0, j / 12.0);
    }
  for (int j = 0; j < 12; ++j)
    for (int i = 0; i < 16; ++i) {
      if (i == 8) continue;  // the jump
      const int a = 17 * j + i;
      depth.triangles.push_back({a, a + 1, a + 17});
      depth.triangles.push_back({a + 18, a + 17, a + 1});
    }
  add("depth_mesh_area", area, true,
      {{PlacedMesh{std::make_shared<const Mesh>(depth), Pose(turned(0.05, 0.1, 0.02), Vec3(0, 0, 0))},
        keeps->fine}});

  // Alpha and masks; what hides what.
  SceneItem glass{sheet(0.6, 0.45, 1.3, 30, Vec2(95, 70)), keeps->alpha}, wall{facing, keeps->fine},
      sphere{ball, keeps->fine};
  add("alpha_before_plane", area, true, {glass, wall});
  SceneItem masked_wall = wall, masked_ball = sphere;
  masked_wall.mask = masked_ball.mask = keeps->mask;
  add("masked_plane_area", area, true, {masked_wall});
  add("masked_globe_area", area, true, {masked_ball});
  add("masked_globe_bilinear", plain, true, {masked_ball});
  add("planes_cut_each_other", area, true, {wall, {sheet(0.5, 0.5, 1.68, 62, Vec2(85, 62)), keeps->coarse}});
  SphereSurface small = globe;
  small.radius = 0.14;
  add("globe_before_wall", area, true, {{placed(small, 1.3, turned(0.1, 0.4, 0)), keeps->alpha}, wall});
  add("masked_globe_before_masked_wall_values", values, true, {masked_ball, masked_wall});

  // A globe behind a wall and a post, as an eye beside the projector sees it.
  Scene room, content;
  CylinderSurface post = column;
  post.radius = 0.07;
  room.items = {{sheet(1.1, 0.8, 1.7, 35, middle), keeps->white},
                {placed(post, 1.25, turned(0.1, 0, 0.05)), keeps->white}};
  content.items = {{sheet(3, 2.2, 3.1, 10, middle), keeps->fine},
                   {placed(globe, 2.4, turned(0.3, 0.5, 0)), keeps->fine}};
  const render::Viewpoint eye = render::viewer_eye(Vec3(0.3, -0.12, 0.1), room, p)->viewpoint;
  keeps->viewer.push_back(render::viewer_scene(room, p, eye));
  render::render(render::seen_from(eye.camera_from_projector, content), Projector{eye.camera},
                 keeps->viewer[0].picture);
  add("viewer", area, true, keeps->viewer[0].scene.items);
  return scenes;
}

}  // namespace procam
