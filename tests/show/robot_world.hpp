#pragma once
/// A robot with a rig before walls that it knows, a localiser whose error changes slowly, and a camera of the rig that sees
/// where the light lands. The show follows the localiser alone, or with track::PoseCorrection.
#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include "procam/core/geometry/plane.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/track/locate.hpp"
#include "procam/track/pose_correction.hpp"
#include "rig_sights.hpp"
#include "watch/watched_world.hpp"

namespace procam::show::test {

/// The base has x ahead and z up, the rig's frame is its camera's, 0.7 m above.
inline Pose base_from_rig() {
  Mat3 axes;
  axes.col(0) = -Vec3::UnitY(), axes.col(1) = -Vec3::UnitZ(), axes.col(2) = Vec3::UnitX();
  return Pose(Eigen::Quaterniond(axes) * so3_exp(Vec3(0.03, -0.02, 0.01)), Vec3(0.1, 0.02, 0.7));
}

/// A wall with a picture on it; the world's z is up.
struct Mural {
  std::string name;
  Pose world_from_surface;
  Vec2 size;  ///< metres, from the surface's origin
};
/// x to the right and y down for somebody who looks along `towards`.
inline Mural mural(const std::string& name, const Vec3& upper_left, double towards, const Vec2& size) {
  const Vec3 ahead(std::cos(towards), std::sin(towards), 0), right = ahead.cross(Vec3::UnitZ());
  Mat3 axes;
  axes.col(0) = right, axes.col(1) = -Vec3::UnitZ(), axes.col(2) = ahead;
  return {name, Pose(Eigen::Quaterniond(axes), upper_left), size};
}
inline std::vector<Mural> flat_wall() {
  return {mural("wall", Vec3(2.25, 2.0, 1.40), 0.12, Vec2(4.0, 0.98))};
}
/// Two walls that meet ahead of the robot at 100 degrees.
inline std::vector<Mural> corner_walls() {
  const double half = 40 * kDegree;
  const Vec3 edge(2.35, 0.05, 1.40), left(std::cos(half), std::sin(half), 0);
  const Mural of_left = mural("left", edge, half, Vec2(2.0, 0.98));
  const Vec3 right_of_left = of_left.world_from_surface.rotation * Vec3::UnitX();
  return {mural("left", edge - 2.0 * right_of_left, half, Vec2(2.0, 0.98)),
          mural("right", edge, -half, Vec2(2.0, 0.98))};
}

/// One wall, of which two robots light a half each. They meet at the origin of the second one.
inline std::vector<Mural> two_halves() {
  const Mural left = mural("left", Vec3(2.25, 2.0, 1.40), 0.05, Vec2(2.0, 0.98));
  return {left, mural("right", left.world_from_surface * Vec3(2.0, 0, 0), 0.05, Vec2(2.0, 0.98))};
}

/// A robot that stands beside and lights one wall with other pictures.
struct Neighbour {
  Pose world_from_base;
  std::size_t wall = 0;
};

struct RobotConditions {
  std::vector<Mural> walls = flat_wall();
  std::optional<std::size_t> lights;   ///< the wall that it lights and watches; empty: all
  std::optional<Neighbour> neighbour;  ///< its light is in the camera's images
  Pose world_from_start = Pose();      ///< before the path
  watch::test::Content content = watch::test::Content::kSlides;
  bool markers = false;        ///< two of 150 mm on the first wall, or one on each half, known
  double speed = 0, turn = 0;  ///< largest, m/s and rad/s, to and fro; 0: it stands
  double position_sigma = 0.02, rotation_sigma = 1 * kDegree, correlation = 3;  ///< of the localiser
  double rate = 10, latency = 0.05;
  bool odometry = false;  ///< messages state the twist, with 0.02 m/s and 0.02 rad/s of noise
  double odometry_scale =
      1;  ///< stated by true twist: wheels of another diameter, and a floor on which they slip
  double camera_rate = 10, camera_latency = 0.04, looking = 0.02, delay = 0.035;  ///< seconds
  double lens_error = 0;
  std::uint64_t seed = 1;
};

/// Errors of the light over the frames, metres^2, and what the correction did.
struct RobotRun {
  std::vector<double> time, with_mm, without_mm;  ///< RMS over the lit part of the walls, a frame
  /// The point where the halves meet, drawn by this robot: by how much its light is off along the wall, and the covariance that
  /// the pose states for it, metres^2.
  std::vector<Vec2> edge_off;
  std::vector<Mat2> edge_covariance;
  std::vector<bool> edge_lit;  ///< the point is in the projector's frame
  std::uint64_t taken = 0, refused = 0, markers = 0;
  static double rms(const std::vector<double>& mm) {
    double sum = 0;
    for (const double one : mm) sum += one * one;
    return std::sqrt(sum / double(std::max<std::size_t>(1, mm.size())));
  }
};

class RobotWorld {
 public:
  explicit RobotWorld(const RobotConditions& given) : c_(given), rig_(watch::test::watched_rig()) {
    map_.dictionary = MarkerDictionary::kAprilTag36h11;
    cells_ = detect::marker_cells(map_.dictionary);
    if (!c_.markers) return;
    const bool halves = c_.lights.has_value();
    const auto place = [&](int id, const Mural& wall, const Vec2& at) {
      map_.markers.push_back(
          {id, 0.15,
           wall.world_from_surface * Pose(Eigen::Quaterniond::Identity(),
                                          Vec3(at.x() * wall.size.x(), at.y() * wall.size.y(), 0))});
    };
    place(5, c_.walls.front(), halves ? Vec2(0.86, 0.3) : Vec2(0.38, 0.3));
    place(9, c_.walls.back(), halves ? Vec2(0.14, 0.7) : Vec2(0.62, 0.7));
    if (!halves) return;
    place(12, c_.walls.front(), Vec2(0.63, 0.72));
    place(14, c_.walls.back(), Vec2(0.37, 0.26));
  }

  RobotRun run(double seconds);

  Pose world_from_base(double t) const {
    if (c_.speed <= 0) return c_.world_from_start * Pose(so3_exp(Vec3(0, 0, 0.03)), Vec3(0.05, -0.1, 0));
    const double omega = 1.1, phase = 0.7 * double(c_.seed);
    const double way = c_.speed / omega * std::sin(omega * t + phase),
                 turn = c_.turn / omega * std::sin(omega * t + phase + 0.4);
    return c_.world_from_start *
           Pose(so3_exp(Vec3(0, 0, 0.03 - turn)), Vec3(0.05 + 0.3 * way, -0.1 + 0.95 * way, 0));
  }

 private:
  Pose world_from_projector(const Pose& world_from_base) const {
    return world_from_base * base_from_rig() * rig_.projector().rig_from_projector;
  }
  std::vector<watch::WatchedSurface> surfaces(const Pose& world_from_base) const {
    const Pose rig_from_world = (world_from_base * base_from_rig()).inverse();
    std::vector<watch::WatchedSurface> result;
    for (std::size_t i = 0; i < c_.walls.size(); ++i) {
      const Mural& wall = c_.walls[i];
      if (!c_.lights || *c_.lights == i)
        result.push_back({wall.name,
                          rig_from_world * wall.world_from_surface,
                          {Vec2(0, 0), Vec2(wall.size.x(), 0), wall.size, Vec2(0, wall.size.y())}});
    }
    return result;
  }
  ImageU8 draw(const Pose& world_from_base, double time, std::optional<std::size_t> lights,
               std::uint64_t picture) {
    // Of the wall's length three pictures.
    const ImageU8 one = watch::test::picture(c_.content, time, picture);
    ImageU8 wide(3 * one.width(), one.height(), 3);
    for (int y = 0; y < one.height(); ++y)
      for (int k = 0; k < 3; ++k)
        std::copy_n(&one.at(0, y, 0), 3 * one.width(), &wide.at(k * one.width(), y, 0));
    Scene scene;
    ++revisions_;  // pictures have the same memory one after the other
    for (std::size_t i = 0; i < c_.walls.size(); ++i) {
      if (lights && *lights != i) continue;
      const Mural& wall = c_.walls[i];
      PlacedPlane placed;
      placed.plane_from_content = Vec3(wall.size.x(), wall.size.y(), 1).asDiagonal();
      placed.projector_from_surface =
          world_from_projector(world_from_base).inverse() * wall.world_from_surface;
      scene.items.push_back({placed, wide.view(), revisions_});
    }
    ImageU8 drawn(rig_.projector().projector.size(), 3);
    renderer_.render(scene, rig_.projector().projector, drawn);
    return drawn;
  }
  const simulate::LiveView& view(const Pose& world_from_base);
  double error_mm(const Pose& truth, const Pose& believed) const;
  ImageU8 capture(const Pose& truth, const ImageU8& frame, double time);
  Vec2 edge_off(const Pose& truth, const Pose& believed) const;
  void note_edge(const Pose& truth, const track::TrackedPose& believed, RobotRun& run) const;

  RobotConditions c_;
  std::uint64_t revisions_ = 0;
  Rig rig_;
  MarkerMap map_;
  MarkerCells cells_;
  render::CpuRenderer renderer_{[] {
    render::RenderOptions one;
    one.threads = 1;
    return one;
  }()};
  std::unique_ptr<simulate::LiveView> view_;
  Pose seen_from_;
  double exposure_ = 0;
  std::uint64_t images_ = 0;
};

inline const simulate::LiveView& RobotWorld::view(const Pose& world_from_base) {
  if (view_ && (seen_from_.inverse() * world_from_base).matrix().isIdentity(1e-12)) return *view_;
  simulate::Room room;
  room.ambient = 0.06;
  for (std::size_t i = 0; i < c_.walls.size(); ++i) {
    simulate::Texture paint{ImageU8(400, 100), 0.8, 0.72};
    for (int y = 0; y < 100; ++y)
      for (int x = 0; x < 400; ++x)
        paint.image.at(x, y) = std::uint8_t(255 * watch::test::octaves(x / 6.0, y / 6.0, 99 + i));
    const double out = c_.walls.size() > 1 ? 0 : 0.5;
    room.bodies.push_back({c_.walls[i].name,
                           simulate::Rectangle{Vec2(-out, -0.4), c_.walls[i].size + Vec2(out, 0.4)},
                           c_.walls[i].world_from_surface, paint});
  }
  for (const PlacedMarker& marker : map_.markers) {
    PlacedMarker before = marker;
    before.world_from_marker =
        marker.world_from_marker * Pose(Eigen::Quaterniond::Identity(), Vec3(0, 0, -2e-4));
    room.bodies.push_back(simulate::marker_sheet(before, cells_, Pose(), 1));
  }
  Camera inverse = rig_.projector().projector.inverse_camera;
  std::get<BrownConrady>(inverse.distortion).coefficients[4] -= c_.lens_error;
  std::vector<simulate::RoomLight> lights = {
      watch::test::everyday_light({inverse}, world_from_projector(world_from_base))};
  if (c_.neighbour)
    lights.push_back(
        watch::test::everyday_light({inverse}, world_from_projector(c_.neighbour->world_from_base)));
  view_ =
      std::make_unique<simulate::LiveView>(room, rig_.camera().camera, world_from_base * base_from_rig(),
                                           lights, watch::test::everyday_camera(exposure_, 2.2, 2, c_.seed));
  exposure_ = view_->exposure();
  seen_from_ = world_from_base;
  return *view_;
}

/// With the light of the neighbour, whose pictures are others.
inline ImageU8 RobotWorld::capture(const Pose& truth, const ImageU8& frame, double time) {
  const simulate::LiveView& seen = view(truth);
  std::vector<std::shared_ptr<const simulate::LiveView::Light>> lights = {seen.light_of(frame)};
  if (c_.neighbour)
    lights.push_back(
        seen.light_of(draw(c_.neighbour->world_from_base, time, c_.neighbour->wall, c_.seed + 100), 1));
  return seen.capture(lights, ++images_);
}

/// Of the middle of the line where two halves meet: the light of the pixel that is drawn for it, in the wall's x and y.
inline Vec2 RobotWorld::edge_off(const Pose& truth, const Pose& believed) const {
  const Mural& right = c_.walls.back();
  const Vec3 edge = right.world_from_surface * Vec3(0, right.size.y() / 2, 0);
  const Vec3 in_projector = world_from_projector(believed).inverse() * edge;
  const Pose is = world_from_projector(truth);
  // Projector and inverse camera are the same: the ray of the pixel is the direction to the point.
  const auto lit =
      intersect(is * Ray{Vec3::Zero(), in_projector.normalized()}, Plane::of_xy(right.world_from_surface));
  if (!lit) return Vec2::Constant(INFINITY);
  return (right.world_from_surface.inverse() * *lit).head<2>() - Vec2(0, right.size.y() / 2);
}

inline void RobotWorld::note_edge(const Pose& truth, const track::TrackedPose& believed,
                                  RobotRun& run) const {
  const double h = 1e-6;
  const Pose& pose = believed.frame_from_child;
  Eigen::Matrix<double, 2, 6> slope;
  for (int k = 0; k < 6; ++k) {
    const Vec6 step = h * Vec6::Unit(k);
    slope.col(k) =
        (edge_off(se3_exp(step) * pose, pose) - edge_off(se3_exp(Vec6(-step)) * pose, pose)) / (2 * h);
  }
  const Mural& right = c_.walls.back();
  const Projector& projector = rig_.projector().projector;
  const auto pixel = projector.project(Vec3(world_from_projector(pose).inverse() *
                                            (right.world_from_surface * Vec3(0, right.size.y() / 2, 0))));
  run.edge_lit.push_back(pixel && projector.size().contains(*pixel));
  run.edge_off.push_back(edge_off(truth, pose));
  run.edge_covariance.push_back(slope * believed.covariance * slope.transpose());
}

/// Of the light of a grid of pixels, between where it is and where the show has it, RMS.
inline double RobotWorld::error_mm(const Pose& truth, const Pose& believed) const {
  const Projector& projector = rig_.projector().projector;
  const Pose is = world_from_projector(truth), meant = world_from_projector(believed);
  double sum = 0;
  int count = 0;
  for (int j = 0; j < 7; ++j)
    for (int i = 0; i < 9; ++i) {
      const auto ray = projector.emit(Vec2(60 + 113 * i, 50 + 111 * j));
      if (!ray) continue;
      double nearest = INFINITY;
      const Mural* lit = nullptr;
      Vec3 at;
      for (const Mural& wall : c_.walls) {
        const auto point = intersect(is * *ray, Plane::of_xy(wall.world_from_surface));
        if (!point) continue;
        const Vec3 own = wall.world_from_surface.inverse() * *point;
        const double far = (*point - is.translation).norm();
        if (own.x() < 0 || own.y() < 0 || own.x() > wall.size.x() || own.y() > wall.size.y() || far > nearest)
          continue;
        nearest = far, lit = &wall, at = *point;
      }
      if (lit == nullptr) continue;
      const auto drawn = intersect(meant * *ray, Plane::of_xy(lit->world_from_surface));
      if (!drawn) continue;
      sum += (*drawn - at).squaredNorm();
      ++count;
    }
  return 1e3 * std::sqrt(sum / std::max(1, count));
}

inline RobotRun RobotWorld::run(double seconds) {
  constexpr double kBegin = 100;  // the clock of a machine that has run for a while
  std::mt19937_64 random(c_.seed * 7919 + 3);
  std::mt19937_64 random_of_odometry(c_.seed * 7919 + 4);  // the localiser's error does not depend on it
  std::normal_distribution<double> normal, normal_of_odometry;
  const Vec3 sigma(c_.position_sigma, c_.position_sigma, c_.rotation_sigma);
  Vec3 off = sigma.cwiseProduct(Vec3(normal(random), normal(random), normal(random)));
  const double phi = std::exp(-1 / c_.rate / c_.correlation);

  track::PoseCorrectionOptions options;
  options.child_from_rig = base_from_rig();
  options.track.delay = c_.latency;
  track::PoseCorrection correction(options);
  track::PoseTrack alone(options.track), with(options.track);
  watch::WatchOptions watching;
  watching.locates_rig = true;
  watch::Watch watcher(rig_.camera(), rig_.projector(), watching);

  struct Later {
    double when;
    std::function<void()> act;
  };
  std::deque<Later> later;
  const auto at = [&](double when, std::function<void()> act) {
    const auto place =
        std::find_if(later.begin(), later.end(), [&](const Later& one) { return one.when > when; });
    later.insert(place, {when, std::move(act)});
  };
  RobotRun run;
  double next_message = kBegin, next_image = kBegin + 0.33;
  const auto give = [&](const std::vector<track::PoseSight>& sights) {
    if (const auto pose = correction.add(sights)) with.add(*pose);
  };
  for (double light = kBegin + 0.2; light < kBegin + seconds; light += 1 / 30.0) {
    const double now = light - c_.delay;
    for (; next_message + c_.latency <= now; next_message += 1 / c_.rate) {
      for (int k = 0; k < 3; ++k)
        off[k] = phi * off[k] + std::sqrt(1 - phi * phi) * sigma[k] * normal(random);
      const Pose truth = world_from_base(next_message);
      track::StampedPose message;
      message.arrival = next_message + c_.latency;
      message.frame = "map", message.child = "base";
      message.frame_from_child =
          Pose(so3_exp(Vec3(0, 0, off.z())) * truth.rotation, truth.translation + Vec3(off.x(), off.y(), 0));
      if (c_.odometry) {
        const Vec6 way =
            se3_log(Pose(world_from_base(next_message - 0.01).inverse() * world_from_base(next_message)));
        Vec6 noise;
        noise << 0, 0, 0.02 * normal_of_odometry(random_of_odometry),
            0.02 * normal_of_odometry(random_of_odometry), 0, 0;
        message.twist = Vec6(c_.odometry_scale * way / 0.01 + noise);
      }
      // In its turn with the images.
      at(message.arrival, [=, &alone, &correction, &with] {
        alone.add(message);
        if (const auto pose = correction.add(message)) with.add(*pose);
      });
    }
    for (; !later.empty() && later.front().when <= now; later.pop_front()) later.front().act();
    const track::TrackedPose believed = with.at(light), poor = alone.at(light);
    if (believed.state == track::TrackState::kNone) continue;
    const Pose truth = world_from_base(light);
    if (light > kBegin + 2) {
      run.time.push_back(light - kBegin);
      run.with_mm.push_back(error_mm(truth, believed.frame_from_child));
      run.without_mm.push_back(error_mm(truth, poor.frame_from_child));
      note_edge(truth, believed, run);
    }
    if (light < next_image) continue;
    next_image += 1 / c_.camera_rate;
    // The frame that is drawn for this light, and the camera's image of it.
    const Pose drawn_for = believed.frame_from_child;
    const ImageU8 frame = draw(drawn_for, light, c_.lights, c_.seed),
                  next = draw(drawn_for, light + 1 / 60.0, c_.lights, c_.seed);
    const ImageU8 image = capture(truth, frame, light);
    watcher.place(surfaces(drawn_for));
    const watch::WatchReport report = watcher.add(light, {frame, next, 0, 1 / 60.0}, image);
    std::vector<track::PoseSight> sights;
    if (report.rig && report.rig->cells > 0)
      sights.push_back({light, drawn_for * base_from_rig(), report.rig->information, report.rig->score});
    if (!map_.markers.empty())
      if (const auto sight =
              sight_of_markers(detect::detect_marker_edges(image, cells_, {rig_.camera().camera}), light,
                               rig_.camera(), map_, drawn_for * base_from_rig())) {
        sights.push_back(*sight);
        ++run.markers;
      }
    at(light + c_.camera_latency + c_.looking, [=] { give(sights); });
  }
  run.taken = correction.status().taken;
  run.refused = correction.status().refused;
  return run;
}

}  // namespace procam::show::test
