#include "procam/simulate/depth_view.hpp"

#include <algorithm>
#include <cmath>

#include "caster.hpp"
#include "noise.hpp"
#include "procam/core/base/parallel.hpp"

namespace procam::simulate {
namespace {

constexpr int kDepthTile = 16;

void check_sensor(const DepthSensor& sensor) {
  require(sensor.nearest > 0 && sensor.farthest > sensor.nearest && sensor.farthest < 65.5,
          "depth_view: the range must be 0 < nearest < farthest < 65.5 m");
  require(sensor.grazing > 0 && sensor.disparity_step >= 0 && sensor.edge_noise >= 0 &&
              sensor.axial_noise >= 0 && sensor.dropout >= 0 && sensor.dropout <= 1,
          "depth_view: a negative angle, step, noise or dropout, or a dropout above 1");
  require(sensor.emitter_in_camera.allFinite(), "depth_view: the emitter's place is not finite");
  require(sensor.disparity_step == 0 || sensor.emitter_in_camera.norm() > 0,
          "depth_view: without a baseline there is no disparity to round");
}

/// The truth of a view.
DepthView true_view(const Room& room, const DepthSensor& sensor, const Pose& room_from_camera, int threads) {
  using namespace internal;
  const PreparedRoom prepared(room);
  const ImageSize size = sensor.camera.size;
  const Pose camera_from_emitter(Eigen::Quaterniond::Identity(), sensor.emitter_in_camera);
  const Caster eye(prepared, room_from_camera), emitter(prepared, room_from_camera * camera_from_emitter);
  const TileIndex tiles(sensor.camera, Vec2(-0.5, -0.5), Vec2(size.width - 0.5, size.height - 0.5),
                        kDepthTile);
  DepthView truth;
  truth.true_metres = ImageF(size);
  truth.body = Image<std::int16_t>(size, 1, std::int16_t(-1));
  truth.angle = ImageF(size);
  truth.shadowed = ImageU8(size);
  parallel_for(tiles.rows(), threads, [&](int begin, int end) {
    const std::vector<Candidates> candidates = tiles.candidates(prepared, room_from_camera, begin, end);
    for (int y = begin * kDepthTile; y < std::min(end * kDepthTile, size.height); ++y)
      for (int x = 0; x < size.width; ++x) {
        const std::optional<Vec3> direction = sensor.camera.unproject(Vec2(x, y));
        if (!direction) continue;
        const int tile = (y / kDepthTile - begin) * tiles.columns() + x / kDepthTile;
        const BodyHit hit = eye.nearest(*direction, candidates[std::size_t(tile)]);
        if (hit.body < 0) continue;
        const Vec3 point = hit.s * *direction;
        const Vec3 normal = outward(room.bodies[std::size_t(hit.body)].shape, hit.spot_in_body);
        const double toward_eye = normal.dot(eye.in_body(hit.body, *direction));
        const double toward_emitter = normal.dot(hit.spot_in_body.point - emitter.eye_in_body(hit.body));
        truth.body.at(x, y) = std::int16_t(hit.body);
        truth.true_metres.at(x, y) = float(point.z());
        truth.angle.at(x, y) = float(std::acos(std::min(std::abs(toward_eye), 1.0)));
        truth.shadowed.at(x, y) = toward_eye * toward_emitter <= 0 ||
                                  emitter.is_hidden(point - sensor.emitter_in_camera, hit.body, prepared.all);
      }
  });
  return truth;
}

/// The pixel whose depth is read at (x, y): itself, unless the jitter carries it onto another surface.
Vec2 read_at(const DepthView& truth, int x, int y, const Vec2& jitter) {
  const int to_x = std::clamp(int(std::lround(x + jitter.x())), 0, truth.body.width() - 1);
  const int to_y = std::clamp(int(std::lround(y + jitter.y())), 0, truth.body.height() - 1);
  return truth.body.at(to_x, to_y) == truth.body.at(x, y) ? Vec2(x, y) : Vec2(to_x, to_y);
}

}  // namespace

double axial_sigma(double z, double theta) {
  const double slant = theta / (M_PI_2 - theta);
  return 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4) + 0.0001 / std::sqrt(z) * slant * slant;
}

double lateral_sigma(double theta) {
  return 0.8 + 0.035 * theta / (M_PI_2 - theta);
}

DepthView depth_view(const Room& room, const DepthSensor& sensor, const Pose& room_from_camera,
                     std::uint64_t seed, int threads) {
  check_sensor(sensor);
  return read_again(true_view(room, sensor, room_from_camera, threads), sensor, seed);
}

DepthView read_again(DepthView view, const DepthSensor& sensor, std::uint64_t seed) {
  check_sensor(sensor);
  const ImageSize size = sensor.camera.size;
  for (const ImageSize of :
       {view.true_metres.size(), view.body.size(), view.angle.size(), view.shadowed.size()})
    require(of == size, "read_again: the view is not of this sensor: its images have other sizes");
  const std::vector<float>& normal = internal::normal_table();
  // Disparity in steps = this / z.
  const double steps_metre =
      sensor.disparity_step > 0
          ? sensor.camera.intrinsics.fx * sensor.emitter_in_camera.norm() / sensor.disparity_step
          : 0;
  view.metres = ImageF(size);
  view.mm = Image<std::uint16_t>(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      internal::Random random(seed, std::uint64_t(y), std::uint64_t(x));
      const std::uint64_t bits = random.next();
      const auto gauss = [&](int i) { return double(normal[bits >> (16 * i) & 0xffff]); };
      const double theta = view.angle.at(x, y);
      const double reach = sensor.edge_noise * lateral_sigma(std::min(theta, sensor.grazing));
      const Vec2 at = read_at(view, x, y, reach * Vec2{gauss(0), gauss(1)});
      const int from_x = int(at.x()), from_y = int(at.y());
      const double z = view.true_metres.at(from_x, from_y), turned = view.angle.at(from_x, from_y);
      if (view.body.at(from_x, from_y) < 0 || view.shadowed.at(from_x, from_y) || !(z > 0) ||
          turned > sensor.grazing || random.uniform(0, 1) < sensor.dropout)
        continue;
      const double sigma = sensor.axial_noise * axial_sigma(z, turned);
      const double rounding = steps_metre > 0 ? z * z / steps_metre : 0;  // metres a step
      double read = z + gauss(2) * std::sqrt(std::max(0.0, sigma * sigma - rounding * rounding / 12));
      if (steps_metre > 0 && read > 0) read = steps_metre / std::max(std::round(steps_metre / read), 1.0);
      if (!(read >= sensor.nearest && read <= sensor.farthest)) continue;
      view.metres.at(x, y) = float(read);
      view.mm.at(x, y) = std::uint16_t(std::lround(1000 * read));
    }
  return view;
}

}  // namespace procam::simulate
