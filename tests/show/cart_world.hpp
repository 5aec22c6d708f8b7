#pragma once
/// A cart with a board on it that moves before a rig: the camera's images of it while a show projects on it, and where the
/// light of the content's corners lands on the true board.
///
/// The room is the cart: camera and projector move about it. Frames of 60 a second are drawn for the middle of their light.
/// The camera is free-running, 30 images a second.
#include <algorithm>
#include <cmath>
#include <ctime>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "procam/core/geometry/plane.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/device/content_source.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/render/cpu.hpp"
#include "procam/show/projection.hpp"
#include "procam/simulate/room_view.hpp"
#include "surface_source.hpp"

namespace procam::show::test {

inline Rig cart_rig() {
  Rig rig;
  const Camera camera{
      {1280, 960}, {1052, 1047, 633, 491, 0.4}, BrownConrady{{0.06, -0.12, 0.0010, -0.0007, 0}}};
  const Camera inverse{
      {640, 480}, {650, 644, 330, 381, -0.5}, BrownConrady{{-0.03, 0.01, -0.0005, 0.0006, 0}}};
  Vec6 projector_pose;
  projector_pose << -0.06, -0.05, 0.02, 0.31, 0.05, 0.03;
  rig.cameras.push_back({"camera", camera, Pose(so3_exp(Vec3(0.01, -0.02, 0.03)), Vec3(-0.02, 0.01, 0))});
  rig.projectors.push_back({"projector", {inverse}, se3_exp(projector_pose)});
  return rig;
}

struct CartConditions {
  Vec2 board{0.6, 0.4};   ///< metres; the content fills it
  MarkerMap map;          ///< in its frame
  double ambient = 0.05;  ///< the projector's full light at the cart is 0.2
  int marker_light = -1, search_light = 0;
  double exposure = 0.008, readout = 0, latency = 0.030, looking = 0.012, delay = 0.035;  ///< seconds
  double arrival_jitter = 0.001;  ///< seconds, uniform
  std::optional<track::Hinge> hinge = {};
  std::function<bool(double)> covered = [](double) { return false; };  ///< somebody stands before the camera
  track::Prediction prediction = track::Prediction::kAuto;
};

/// Two markers of 100 mm within the content.
inline MarkerMap two_markers() {
  MarkerMap map;
  map.dictionary = MarkerDictionary::kAprilTag36h11;
  map.markers = {{5, 0.1, Pose(Eigen::Quaterniond::Identity(), Vec3(0.085, 0.085, 0))},
                 {9, 0.1, Pose(so3_exp(Vec3(0, 0, 0.4)), Vec3(0.50, 0.30, 0))}};
  return map;
}
inline MarkerMap one_marker(double size) {
  MarkerMap map;
  map.dictionary = MarkerDictionary::kAprilTag36h11;
  map.markers = {{5, size, Pose(Eigen::Quaterniond::Identity(), Vec3(0.3, 0.2, 0))}};
  return map;
}

/// Uniform in 0..1, by number.
inline double drawn(std::uint64_t seed, std::uint64_t number) {
  std::uint64_t h = seed * 0x9E3779B97F4A7C15ull + number * 0xC2B2AE3D27D4EB4Full + 0x165667B19E3779F9ull;
  h ^= h >> 31, h *= 0xBF58476D1CE4E5B9ull, h ^= h >> 29, h *= 0x94D049BB133111EBull, h ^= h >> 32;
  return double(h >> 11) / 9007199254740992.0;
}

struct CartRun {
  std::vector<double> errors_mm;  ///< of each corner in the frame, each frame after the first second
  double predicted2 = 0;          ///< sum of the squares of the predicted errors, metres^2, a frame
  int frames = 0, fresh = 0;      ///< after the first second
  std::uint64_t images = 0, sightings = 0, refused = 0;
  int wrong = 0;        ///< sightings off by more than 20 mm or 4 degrees
  double noise_mm = 0;  ///< rms error of a sighting at the board's middle
  double look_s = 0;    ///< spent on images
  std::string why;
  double rms() const {
    double sum = 0;
    for (const double e : errors_mm) sum += e * e;
    return std::sqrt(sum / double(std::max<std::size_t>(1, errors_mm.size())));
  }
  double quantile(double q) const {
    if (errors_mm.empty()) return 0;
    std::vector<double> sorted = errors_mm;
    std::sort(sorted.begin(), sorted.end());
    return sorted[std::size_t(q * double(sorted.size() - 1))];
  }
};

class CartWorld {
 public:
  using Path = std::function<Pose(double)>;  ///< rig_from_board

  CartWorld(const CartConditions& conditions, Path path, std::uint64_t seed)
      : conditions_(conditions), path_(std::move(path)), seed_(seed), rig_(cart_rig()) {
    const MarkerCells cells = detect::marker_cells(conditions.map.dictionary);
    simulate::Body board{
        "board", simulate::Rectangle{Vec2(-0.02, -0.02), conditions.board + Vec2(0.02, 0.02)}, Pose(), 0.7};
    room_.bodies.push_back(board);
    simulate::Body wall{"wall", simulate::Rectangle{Vec2(-4, -3), Vec2(4, 3)},
                        Pose(so3_exp(Vec3(0.02, -0.03, 0)), Vec3(0, 0, 1.4)), 0.5};
    room_.bodies.push_back(wall);
    for (const PlacedMarker& marker : conditions.map.markers)
      room_.bodies.push_back(
          simulate::marker_sheet(marker, cells, Pose(Eigen::Quaterniond::Identity(), Vec3(0, 0, -1e-5)), 1));
    room_.ambient = conditions.ambient;
  }

  const Rig& rig() const { return rig_; }

  /// The camera's image of an exposure about `middle` while `frame_at` is shown.
  ImageU8 image(double middle, const std::function<const ImageU8&(double)>& frame_at,
                std::uint64_t number) const {
    const RigCamera& camera = rig_.camera();
    ImageU8 whole(camera.camera.size.width, camera.camera.size.height, 1, 70);
    constexpr int kParts = 2;
    int x0 = 1 << 20, y0 = 1 << 20, x1 = -1, y1 = -1;
    for (const double at : {middle - 0.02, middle + 0.02})
      for (const Vec2& uv : {Vec2(-0.05, -0.05), Vec2(1.05, -0.05), Vec2(1.05, 1.05), Vec2(-0.05, 1.05)}) {
        const auto pixel =
            camera.camera.project(camera.rig_from_camera.inverse() * path_(at) *
                                  Vec3(uv.x() * conditions_.board.x(), uv.y() * conditions_.board.y(), 0));
        if (!pixel) continue;
        x0 = std::min(x0, int(pixel->x())), x1 = std::max(x1, int(pixel->x()));
        y0 = std::min(y0, int(pixel->y())), y1 = std::max(y1, int(pixel->y()));
      }
    x0 = std::max(0, x0 - 8), y0 = std::max(0, y0 - 8);
    x1 = std::min(whole.width() - 1, x1 + 8), y1 = std::min(whole.height() - 1, y1 + 8);
    if (x1 - x0 < 16 || y1 - y0 < 16 || conditions_.covered(middle)) return whole;
    Camera part = camera.camera;
    part.size = {x1 - x0 + 1, y1 - y0 + 1};
    part.intrinsics.cx -= x0, part.intrinsics.cy -= y0;
    const double row_time = conditions_.readout / (whole.height() - 1);
    std::vector<int> sum(std::size_t(part.size.width) * std::size_t(part.size.height), 0);
    for (int k = 0; k < kParts; ++k) {
      const double at = middle + conditions_.exposure * ((k + 0.5) / kParts - 0.5);
      simulate::RoomViewOptions view;
      view.exposure = 200 / (0.8 * (conditions_.ambient + 0.2));
      view.camera_blur_px = 0.8;
      view.gamma = 2.2;
      view.noise = {kParts * 2.5, kParts * 0.015};
      view.seed = seed_ * 1000003 + kParts * number + std::uint64_t(k);
      view.threads = 1;
      view.adaptive = row_time == 0;
      view.time = at + row_time * (y0 - 0.5 * (whole.height() - 1));
      view.row_time = row_time;
      const auto board_from = [this](const Pose& rig_from_device) {
        return [this, rig_from_device](double time) { return path_(time).inverse() * rig_from_device; };
      };
      // Without a rolling shutter all is at one time: one pose is faster.
      const auto motion = [&](const Pose& rig_from_device) {
        return row_time > 0 ? simulate::Motion(board_from(rig_from_device))
                            : simulate::Motion(board_from(rig_from_device)(at));
      };
      simulate::RoomLight light;
      light.projector = rig_.projector().projector;
      light.room_from_projector = motion(rig_.projector().rig_from_projector);
      light.frames = {frame_at(at)};
      light.blur_px = 0.4;
      light.gamma = simulate::kSrgb;
      light.black = 0.001;
      const simulate::RoomView seen =
          simulate::room_view(room_, part, motion(camera.rig_from_camera), {light}, view);
      for (int y = 0; y < part.size.height; ++y)
        for (int x = 0; x < part.size.width; ++x)
          sum[std::size_t(y * part.size.width + x)] += seen.image().at(x, y);
    }
    for (int y = 0; y < part.size.height; ++y)
      for (int x = 0; x < part.size.width; ++x)
        whole.at(x0 + x, y0 + y) =
            std::uint8_t((sum[std::size_t(y * part.size.width + x)] + kParts / 2) / kParts);
    return whole;
  }

  CartRun run(double seconds, const ImageU8& content);

 private:
  Surface surface() const {
    PlanarSurface plane;
    plane.frame = "rig";
    plane.frame_from_surface = path_(0);
    plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const Vec2& b = conditions_.board;
    plane.points = {{0, 0}, {b.x(), 0}, b, {0, b.y()}};
    return {"cart", plane, {}, ""};
  }
  void add_errors(double light_time, const Projection& projection, CartRun& run) const;
  void judge(const track::StampedPose& message, double middle, CartRun& run) const;

  CartConditions conditions_;
  Path path_;
  std::uint64_t seed_;
  Rig rig_;
  simulate::Room room_;
};

/// Where the light of the corners lands.
inline void CartWorld::add_errors(double light_time, const Projection& projection, CartRun& run) const {
  const RigProjector& projector = rig_.projector();
  const Pose projector_from_true = projector.rig_from_projector.inverse() * path_(light_time);
  const auto& placed = std::get<PlacedPlane>(projection.solved().surfaces[0].placement);
  for (const Vec2& uv : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)}) {
    const Vec3 corner(uv.x() * conditions_.board.x(), uv.y() * conditions_.board.y(), 0);
    const auto pixel = projector.projector.project(placed.projector_from_surface * corner);
    if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() > 639 || pixel->y() > 479) continue;
    const auto landed = projector.projector.intersect(*pixel, Plane::of_xy(projector_from_true));
    if (landed) run.errors_mm.push_back(1e3 * (projector_from_true.inverse() * *landed - corner).norm());
  }
}

inline void CartWorld::judge(const track::StampedPose& message, double middle, CartRun& run) const {
  const double at = middle + (message.arrival - middle - conditions_.latency);
  const Pose truth = path_(at);
  const Vec3 centre(conditions_.board.x() / 2, conditions_.board.y() / 2, 0);
  const double off = (message.frame_from_child * centre - truth * centre).norm();
  const double turned = message.frame_from_child.rotation.angularDistance(truth.rotation);
  run.wrong += off > 0.02 || turned > 4 * M_PI / 180 ? 1 : 0;
  run.noise_mm += 1e6 * off * off;
}

inline CartRun CartWorld::run(double seconds, const ImageU8& content) {
  ProjectionOptions options;
  options.moving.surfaces = {{{"cart"}, conditions_.map}};
  options.moving.track.delay = conditions_.latency;
  options.moving.track.prediction = conditions_.prediction;
  options.moving.marker_light = conditions_.marker_light;
  options.moving.search_light = conditions_.search_light;
  render::RenderOptions rendering;
  rendering.threads = 1;
  rendering.filter = render::Filter::kBilinear;
  options.renderer = std::make_shared<render::CpuRenderer>(rendering);
  Projection projection(rig_, options);
  Show show;
  show.surfaces.surfaces = {surface()};
  show.contents = {device::still_content(content)};
  projection.set_show(std::move(show));
  SurfaceSourceOptions sighting;
  sighting.camera = rig_.camera();
  sighting.surfaces = {{"cart", conditions_.map, conditions_.hinge}};
  sighting.readout_s = conditions_.readout;
  SurfaceSights sights(sighting);

  CartRun run;
  constexpr double kBegin = 100;  // of the clock; 0 is no time
  struct Lit {
    double light_time;
    ImageU8 frame;
  };
  std::deque<Lit> lit;
  const ImageU8 black(640, 480, 3);
  const auto frame_at = [&](double time) -> const ImageU8& {
    for (const Lit& one : lit)
      if (std::abs(one.light_time - (time + kBegin)) <= 0.5 / 60 + 1e-9) return one.frame;
    return black;
  };
  const double phase = drawn(seed_, 1) / 30;
  std::uint64_t next_image = 0;
  for (int k = 0; k < int(60 * seconds); ++k) {
    const double light_time = k / 60.0, now = light_time - conditions_.delay;
    while (true) {
      const double middle = double(next_image) / 30 + phase,
                   arrival = middle + conditions_.latency +
                             conditions_.arrival_jitter * drawn(seed_, 100 + next_image);
      if (arrival + conditions_.looking > now) break;
      device::SeenFrame seen{image(middle, frame_at, next_image), kBegin + arrival};
      const std::clock_t begin = std::clock();
      std::vector<track::StampedPose> messages = sights.look_at(seen);
      run.look_s += double(std::clock() - begin) / CLOCKS_PER_SEC;
      for (const track::StampedPose& message : messages) {
        track::StampedPose in_path_time = message;
        in_path_time.arrival -= kBegin + (arrival - middle - conditions_.latency);
        judge(in_path_time, middle, run);
        projection.add_sighting(message);
      }
      ++next_image;
    }
    lit.push_back({kBegin + light_time, ImageU8(640, 480, 3)});
    if (lit.size() > 16) lit.pop_front();
    projection.draw(kBegin + light_time, light_time, lit.back().frame);
    const MovingState& state = projection.moving()[0];
    if (light_time < 1) continue;
    ++run.frames;
    run.fresh += state.seen.state == track::TrackState::kFresh ? 1 : 0;
    if (state.is_dark) continue;
    run.predicted2 += state.error * state.error;
    add_errors(light_time, projection, run);
  }
  run.images = next_image;
  run.sightings = sights.surfaces()[0].sightings;
  run.refused = sights.surfaces()[0].refused;
  run.why = sights.surfaces()[0].why;
  run.noise_mm = std::sqrt(run.noise_mm / double(std::max<std::uint64_t>(1, run.sightings)));
  return run;
}

}  // namespace procam::show::test
