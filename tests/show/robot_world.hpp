#pragma once
/// A robot with a rig before walls that it knows, a localiser whose error changes slowly, and a camera of the rig that sees
/// where the light lands. The show follows the localiser alone, or with track::PoseCorrection.
#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <random>

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

struct RobotConditions {
  std::vector<Mural> walls = flat_wall();
  watch::test::Content content = watch::test::Content::kSlides;
  bool markers = false;        ///< two of 150 mm on the first wall, known
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
  std::uint64_t taken = 0, refused = 0, markers = 0;
  double predicted_mm = 0;
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
    const Mural& wall = c_.walls.front();
    for (const auto& [id, at] : {std::pair(5, Vec2(0.38, 0.3)), std::pair(9, Vec2(0.62, 0.7))})
      map_.markers.push_back(
          {id, 0.15,
           wall.world_from_surface * Pose(Eigen::Quaterniond::Identity(),
                                          Vec3(at.x() * wall.size.x(), at.y() * wall.size.y(), 0))});
  }

  RobotRun run(double seconds);

  Pose world_from_base(double t) const {
    if (c_.speed <= 0) return Pose(so3_exp(Vec3(0, 0, 0.03)), Vec3(0.05, -0.1, 0));
    const double omega = 1.1, phase = 0.7 * double(c_.seed);
    const double way = c_.speed / omega * std::sin(omega * t + phase),
                 turn = c_.turn / omega * std::sin(omega * t + phase + 0.4);
    return Pose(so3_exp(Vec3(0, 0, 0.03 - turn)), Vec3(0.05 + 0.3 * way, -0.1 + 0.95 * way, 0));
  }

 private:
  Pose world_from_projector(const Pose& world_from_base) const {
    return world_from_base * base_from_rig() * rig_.projector().rig_from_projector;
  }
  std::vector<watch::WatchedSurface> surfaces(const Pose& world_from_base) const {
    const Pose rig_from_world = (world_from_base * base_from_rig()).inverse();
    std::vector<watch::WatchedSurface> result;
    for (const Mural& wall : c_.walls)
      result.push_back({wall.name,
                        rig_from_world * wall.world_from_surface,
                        {Vec2(0, 0), Vec2(wall.size.x(), 0), wall.size, Vec2(0, wall.size.y())}});
    return result;
  }
  ImageU8 draw(const Pose& world_from_base, double time) {
    // Of the wall's length three pictures.
    const ImageU8 one = watch::test::picture(c_.content, time, c_.seed);
    ImageU8 wide(3 * one.width(), one.height(), 3);
    for (int y = 0; y < one.height(); ++y)
      for (int k = 0; k < 3; ++k)
        std::copy_n(&one.at(0, y, 0), 3 * one.width(), &wide.at(k * one.width(), y, 0));
    Scene scene;
    ++revisions_;  // pictures have the same memory one after the other
    for (const Mural& wall : c_.walls) {
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
  view_ = std::make_unique<simulate::LiveView>(
      room, rig_.camera().camera, world_from_base * base_from_rig(),
      watch::test::everyday_light({inverse}, world_from_projector(world_from_base)),
      watch::test::everyday_camera(exposure_, 2.2, 2, c_.seed));
  exposure_ = view_->exposure();
  seen_from_ = world_from_base;
  return *view_;
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
    }
    if (light < next_image) continue;
    next_image += 1 / c_.camera_rate;
    // The frame that is drawn for this light, and the camera's image of it.
    const Pose drawn_for = believed.frame_from_child;
    const ImageU8 frame = draw(drawn_for, light), next = draw(drawn_for, light + 1 / 60.0);
    const ImageU8 image = view(truth).capture(frame, ++images_);
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
