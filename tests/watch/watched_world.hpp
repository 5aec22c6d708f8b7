#pragma once
/// A rig before one wall or a corner, contents that are drawn for it, and the camera that sees them: noise, gamma,
/// vignetting, glare, blur, distortion of both lenses (also terms that the rig does not know), a textured wall, a person who
/// walks by and throws a shadow, the room's light.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/geometry/se3.hpp"
#include "procam/render/cpu.hpp"
#include "procam/simulate/live_view.hpp"
#include "procam/watch/marks.hpp"
#include "procam/watch/watch.hpp"

namespace procam::watch::test {

inline Rig watched_rig() {
  Rig rig;
  const Camera camera{{640, 480}, {640, 633, 322, 251, 0.4}, BrownConrady{{-0.17, 0.05, 0.0009, -0.0006, 0}}};
  const Camera inverse{
      {1024, 768}, {1490, 1478, 530, 702, -0.8}, BrownConrady{{-0.04, 0.01, -0.0005, 0.0006, 0}}};
  Vec6 projector_pose;
  projector_pose << -0.11, -0.10, 0.02, 0.31, 0.05, 0.03;
  rig.cameras.push_back({"camera", camera, Pose()});
  rig.projectors.push_back({"projector", {inverse}, se3_exp(projector_pose)});
  return rig;
}

/// The optical frame z forward, x right, y down: a wall 2.1 m ahead, turned a little; or two that meet.
struct Wall {
  std::string name;
  Pose rig_from_surface;
  Vec2 size;  ///< of the content, metres, from the surface's origin
};

inline std::vector<Wall> one_wall() {
  return {{"wall", Pose(so3_exp(Vec3(0.07, 0.16, -0.02)), Vec3(-0.52, -0.60, 2.15)), Vec2(1.15, 0.82)}};
}
/// Two walls that meet at about 100 degrees along a nearly vertical line.
inline std::vector<Wall> corner() {
  return {{"left", Pose(so3_exp(Vec3(0.05, -0.72, 0.01)), Vec3(-0.60, -0.55, 1.78)), Vec2(0.74, 0.78)},
          {"right", Pose(so3_exp(Vec3(0.03, 0.66, -0.02)), Vec3(0.02, -0.57, 2.33)), Vec2(0.72, 0.74)}};
}

/// Values of a smooth random field, 0..1: lattice noise of several octaves.
inline double field(double x, double y, std::uint64_t seed) {
  const auto value = [&](int i, int j) {
    std::uint64_t h = seed * 0x9E3779B97F4A7C15ull + std::uint64_t(i + 4096) * 0xC2B2AE3D27D4EB4Full +
                      std::uint64_t(j + 4096) * 0x165667B19E3779F9ull;
    h ^= h >> 31, h *= 0xBF58476D1CE4E5B9ull, h ^= h >> 29;
    return double(h >> 11) / 9007199254740992.0;
  };
  const int i = int(std::floor(x)), j = int(std::floor(y));
  double u = x - i, v = y - j;
  u *= u * (3 - 2 * u), v *= v * (3 - 2 * v);
  return (1 - v) * ((1 - u) * value(i, j) + u * value(i + 1, j)) +
         v * ((1 - u) * value(i, j + 1) + u * value(i + 1, j + 1));
}
inline double octaves(double x, double y, std::uint64_t seed) {
  return 0.5 * field(x, y, seed) + 0.3 * field(2.1 * x, 2.1 * y, seed + 1) +
         0.2 * field(4.3 * x, 4.3 * y, seed + 2);
}

enum class Content { kVideo, kScroll, kSlides, kDarkGame, kPlain };
inline const char* name_of(Content content) {
  static const char* const names[] = {"video", "scroll", "slides", "dark game", "plain"};
  return names[int(content)];
}

/// A picture of the content at a time, RGB.
inline ImageU8 picture(Content content, double time, std::uint64_t seed,
                       const std::array<int, 3>& plain = {40, 90, 170}) {
  ImageU8 image(384, 272, 3);
  const int scene = int(time / 7);  // cuts
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      double grey[3] = {0, 0, 0};
      if (content == Content::kVideo || content == Content::kScroll) {
        const double way = content == Content::kScroll ? 40 * time : 12 * std::sin(0.7 * time);
        const auto s = seed + std::uint64_t(scene) * 31;
        for (int c = 0; c < 3; ++c) {
          const double v =
              octaves((x + way) / 22.0, (y + 6 * std::cos(0.4 * time)) / 22.0, s + std::uint64_t(c) * 7);
          grey[c] = 255 * std::clamp(1.7 * (v - 0.22), 0.0, 1.0);
        }
        const double ball =
            std::hypot(x - 190 - 120 * std::sin(0.9 * time), y - 130 - 60 * std::cos(1.3 * time));
        if (ball < 24) grey[0] = 230, grey[1] = 180, grey[2] = 60;
      } else if (content == Content::kSlides) {
        const int slide = int(time / 20);
        const bool title = y > 22 && y < 44 && x > 20 && x < 240;
        const int line = (y - 66) / 17, inside = (y - 66) % 17;
        const int letter = x / 5;
        const bool ink = y > 66 && line < 10 && inside < 8 && x > 24 &&
                         x < 150 + int(180 * field(line, slide, seed)) &&
                         field(letter * 1.0, line * 3.0 + slide * 40, seed + 3) > 0.45 && x % 5 != 0;
        for (double& c : grey) c = title ? 40 : ink ? 25 : 235;
        if (title) grey[2] = 120;
      } else if (content == Content::kDarkGame) {
        for (int k = 0; k < 9; ++k) {
          const double cx = 192 + 170 * std::sin(0.31 * time * (1 + 0.13 * k) + 2.4 * k + double(seed)),
                       cy = 136 + 110 * std::cos(0.27 * time * (1 + 0.21 * k) + 1.7 * k);
          const double d = std::max(std::abs(x - cx), std::abs(y - cy) * 0.8);
          if (d < 7 + k % 3 * 4) grey[k % 3] = 200, grey[(k + 1) % 3] = 90;
        }
        if (y < 20 && x > 12 && x < 90 && field(x / 4, 0, seed) > 0.5) grey[0] = grey[1] = grey[2] = 150;
        if (y > 250 && x > 250 && x < 370 && field(x / 5, 3, seed) > 0.5) grey[1] = 170;
        for (double& c : grey) c = std::max(c, 6 * octaves(x / 30.0, y / 30.0, seed));
      } else {
        std::copy(plain.begin(), plain.end(), grey);
      }
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = std::uint8_t(std::lround(grey[c]));
    }
  return image;
}

/// A camera of everyday quality; exposure 0: by its first image.
inline simulate::LiveViewOptions everyday_camera(double exposure, double gamma, double noise,
                                                 std::uint64_t seed) {
  simulate::LiveViewOptions seen;
  seen.view.exposure = exposure;
  seen.view.brightest_grey = 210;
  seen.view.camera_blur_px = 0.6;
  seen.view.vignetting = 3;
  seen.view.gamma = gamma;
  seen.view.noise = {noise, 0.02};
  seen.view.seed = seed;
  seen.view.threads = 1;
  seen.view.adaptive = true;
  seen.glare = 0.02;
  return seen;
}
/// A projector's light as the room gets it.
inline simulate::RoomLight everyday_light(const Projector& projector, const Pose& room_from_projector) {
  simulate::RoomLight light{projector, room_from_projector, {}};
  light.gamma = simulate::kSrgb;
  light.black = 0.001;
  light.blur_px = 0.7;
  return light;
}

struct WorldOptions {
  std::vector<Wall> walls = one_wall();
  Content content = Content::kVideo;
  std::array<int, 3> plain = {40, 90, 170};  ///< of Content::kPlain
  bool marks = false;                        ///< watch::Marks where the content has no texture
  std::uint64_t seed = 1;
  double ambient = 0.06;
  double gamma = 2.2;         ///< of the camera
  double noise = 2;           ///< grey levels^2 at black; shot noise beside it
  double wall_texture = 0.1;  ///< of the albedo
  bool person = false;        ///< walks through
  double lens_error = 0;      ///< k3 of both lenses that the rig does not know
  double late = 0;            ///< the camera sees this much later than it says, seconds
  std::optional<std::size_t> of_another =
      {};  ///< a wall that another projector lights with its own film; dark here
};

/// The true world. What has moved is set from outside.
class WatchedWorld {
 public:
  explicit WatchedWorld(const WorldOptions& options) : options_(options), rig_(watched_rig()) {}

  const Rig& rig() const { return rig_; }
  /// What the show believes.
  std::vector<WatchedSurface> surfaces() const {
    std::vector<WatchedSurface> surfaces;
    for (const Wall& wall : options_.walls)
      surfaces.push_back({wall.name,
                          wall.rig_from_surface,
                          {Vec2(0, 0), Vec2(wall.size.x(), 0), wall.size, Vec2(0, wall.size.y())}});
    return surfaces;
  }

  Vec6 projector_moved = Vec6::Zero();  ///< left increment of rig_from_projector
  std::vector<Vec6> walls_moved = std::vector<Vec6>(4, Vec6::Zero());
  double ambient_factor = 1;
  bool covered = false, projector_off = false;
  /// What is drawn for: the projector as the show knows it (a correction).
  Pose believed_rig_from_projector = watched_rig().projector().rig_from_projector;

  /// The frame that is shown at a time (60 a second).
  ImageU8 frame(double time) {
    const long number = std::lround(std::floor(time * 60));
    const bool still = options_.content == Content::kSlides || options_.content == Content::kPlain;
    const long key = still ? long(time / 20) : number;
    for (const Drawn& drawn : drawn_)
      if (drawn.key == key &&
          drawn.rig_from_projector.translation == believed_rig_from_projector.translation &&
          drawn.rig_from_projector.rotation.coeffs() == believed_rig_from_projector.rotation.coeffs())
        return drawn.frame;
    drawn_[0] = std::move(drawn_[1]);
    drawn_[1] = {key, believed_rig_from_projector, draw(still ? time : double(number) / 60)};
    return drawn_[1].frame;
  }
  ImageU8 draw(double time) {
    const ImageU8 content = picture(options_.content, time, options_.seed, options_.plain);
    Scene scene;
    for (std::size_t i = 0; i < options_.walls.size(); ++i)
      if (i != options_.of_another) add(options_.walls[i], believed_rig_from_projector, content, scene);
    ImageU8 drawn = rendered(scene);
    if (options_.marks) marks_.draw(time, scene, rig_.projector().projector, drawn);
    return drawn;
  }

  /// What the camera records of the light of a time.
  ImageU8 image(ViewU8 frame, double time) {
    if (covered) {
      ImageU8 dark(rig_.camera().camera.size, 1);
      for (int y = 0; y < dark.height(); ++y)
        for (int x = 0; x < dark.width(); ++x)
          dark.at(x, y) = std::uint8_t((x * 7 + y * 13 + int(time * 50)) % 3);
      return dark;
    }
    const simulate::LiveView& view = view_at(time);
    const ImageU8 dark(frame.size(), 1);
    std::vector<std::shared_ptr<const simulate::LiveView::Light>> lights = {
        view.light_of(projector_off ? dark.view() : frame)};
    if (options_.of_another) {
      const ImageU8 content = picture(Content::kVideo, time + 3, options_.seed + 50);
      Scene scene;
      add(options_.walls[*options_.of_another], rig_from_other(), content, scene);
      lights.push_back(view.light_of(rendered(scene), 1));
    }
    return view.capture(lights, ++images_);
  }

 private:
  /// The other robot stands beside.
  Pose rig_from_other() const {
    return Pose(so3_exp(Vec3(0.02, -0.2, 0.03)), Vec3(0.45, 0.05, -0.1)) *
           rig_.projector().rig_from_projector;
  }
  void add(const Wall& wall, const Pose& rig_from_projector, const ImageU8& content, Scene& scene) {
    PlacedPlane placed;
    placed.plane_from_content = Vec3(wall.size.x(), wall.size.y(), 1).asDiagonal();
    placed.projector_from_surface = rig_from_projector.inverse() * wall.rig_from_surface;
    scene.items.push_back({placed, content.view(), ++revisions_});  // pictures share the same memory in turn
  }
  ImageU8 rendered(const Scene& scene) {
    ImageU8 drawn(rig_.projector().projector.size(), 3);
    renderer_.render(scene, rig_.projector().projector, drawn);
    return drawn;
  }
  const simulate::LiveView& view_at(double time) {
    // A person crosses in eight seconds, half a metre before the wall, and comes back after twelve.
    const double crossing = std::fmod(time, 12);
    const int step = options_.person && crossing < 8 ? int(crossing * 4) : -1;
    std::vector<double> key = {double(step), ambient_factor};
    for (int k = 0; k < 6; ++k) key.push_back(projector_moved[k]);
    for (const Vec6& moved : walls_moved)
      for (int k = 0; k < 6; ++k) key.push_back(moved[k]);
    if (views_.size() > 40 && views_.count(key) == 0) views_.clear();  // a drift has a view for each image
    std::unique_ptr<simulate::LiveView>& view = views_[key];
    if (view) return *view;
    simulate::Room room;
    room.ambient = options_.ambient * ambient_factor;
    for (std::size_t i = 0; i < options_.walls.size(); ++i) {
      const Wall& wall = options_.walls[i];
      simulate::Texture paint{ImageU8(200, 200), 0.8, 0.8 * (1 - options_.wall_texture)};
      for (int y = 0; y < 200; ++y)
        for (int x = 0; x < 200; ++x)
          paint.image.at(x, y) = std::uint8_t(255 * octaves(x / 6.0, y / 6.0, 99 + i));
      const double out = options_.walls.size() > 1 ? 0.02 : 0.5;
      room.bodies.push_back({wall.name, simulate::Rectangle{Vec2(-out, -0.4), wall.size + Vec2(out, 0.4)},
                             se3_exp(walls_moved[i]) * wall.rig_from_surface, paint});
    }
    if (step >= 0)
      room.bodies.push_back({"person", simulate::Rectangle{Vec2(-0.17, -0.55), Vec2(0.17, 1.0)},
                             Pose(so3_exp(Vec3(0, 0.1, 0)), Vec3(-0.9 + 0.055 * step, 0.05, 1.5)), 0.35});
    Camera camera = rig_.camera().camera, inverse = rig_.projector().projector.inverse_camera;
    std::get<BrownConrady>(camera.distortion).coefficients[4] += options_.lens_error;
    std::get<BrownConrady>(inverse.distortion).coefficients[4] -= options_.lens_error;
    std::vector<simulate::RoomLight> lights = {
        everyday_light({inverse}, se3_exp(projector_moved) * rig_.projector().rig_from_projector)};
    if (options_.of_another) lights.push_back(everyday_light({inverse}, rig_from_other()));
    view = std::make_unique<simulate::LiveView>(
        room, camera, Pose(), lights,
        everyday_camera(exposure_, options_.gamma, options_.noise, options_.seed));
    exposure_ = view->exposure();
    return *view;
  }

  WorldOptions options_;
  Rig rig_;
  render::CpuRenderer renderer_{[] {
    render::RenderOptions one;
    one.threads = 1;
    return one;
  }()};
  Marks marks_;
  std::uint64_t revisions_ = 0;
  struct Drawn {
    long key = -1;
    Pose rig_from_projector;
    ImageU8 frame;
  };
  Drawn drawn_[2];
  std::map<std::vector<double>, std::unique_ptr<simulate::LiveView>> views_;
  double exposure_ = 0;
  std::uint64_t images_ = 0;
};

/// Of the light of each cell from its place on the wall, metres RMS, with the full models.
inline double true_error(const Watch& watch, const WatchedWorld& world, const WorldOptions& options) {
  const Pose rig_from_projector = se3_exp(world.projector_moved) * world.rig().projector().rig_from_projector;
  double square = 0;
  for (const LitCell& cell : watch.geometry().cells) {
    const Plane wall = Plane::of_xy(options.walls[std::size_t(cell.surface)].rig_from_surface);
    const Ray ray = rig_from_projector * *world.rig().projector().projector.emit(cell.projector_pixel);
    square += (*intersect(ray, wall) - cell.point_in_rig).squaredNorm();
  }
  return std::sqrt(square / double(watch.geometry().cells.size()));
}

}  // namespace procam::watch::test
