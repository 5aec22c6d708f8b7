#pragma once
/// Simulated rooms with the truth of each plane, and how well find_planes() did in them.
#include <algorithm>
#include <limits>
#include <random>

#include <Eigen/LU>

#include "../simulate/rooms.hpp"
#include "plane_estimate.hpp"
#include "procam/depth/planes.hpp"
#include "procam/simulate/depth_view.hpp"
#include "support/lopsided.hpp"

namespace procam::depth::test {

using procam::test::uniform;
using simulate::test::hung;
using simulate::test::looking_at;

inline simulate::DepthSensor lopsided_sensor(ImageSize size = {640, 480}) {
  const double k = size.width / 640.0;
  simulate::DepthSensor sensor;
  sensor.camera = {size,
                   {585 * k, 579 * k, 317.2 * k, 243.1 * k, 0.4 * k},
                   BrownConrady{{0.04, -0.08, 0.001, -0.0006, 0}}};
  return sensor;
}

struct SeenRoom {
  simulate::Room room;
  Pose room_from_camera;
};

/// Walls, floor, ceiling, a table, two boxes and a column, z up.
inline SeenRoom random_room(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto u = [&](double low, double high) { return uniform(random, low, high); };
  SeenRoom out;
  const double w = u(3, 6), d = u(3, 5), h = u(2.4, 3);
  const Pose turn(so3_exp(Vec3(0, 0, u(-0.5, 0.5))), Vec3::Zero());
  const auto add = [&](simulate::Body body) {
    body.room_from_body = turn * body.room_from_body;
    out.room.bodies.push_back(body);
  };
  add(hung("far wall", Vec3(0, d, h / 2), Vec3(0, -1, 0), Vec2(w, h), 0.6));
  add(hung("left wall", Vec3(-w / 2, d / 2, h / 2), Vec3(1, 0, 0), Vec2(d, h), 0.6));
  add(hung("right wall", Vec3(w / 2, d / 2, h / 2), Vec3(-1, 0, 0), Vec2(d, h), 0.6));
  add(hung("floor", Vec3(0, d / 2, 0), Vec3(0, 0, 1), Vec2(w, d), 0.6));
  add(hung("ceiling", Vec3(0, d / 2, h), Vec3(0, 0, -1), Vec2(w, d), 0.6));
  const Vec3 table(u(-1, 1), u(1.5, d - 0.8), 0.74);
  add(hung("table", table, Vec3(0, 0, 1), Vec2(u(0.8, 1.6), u(0.5, 0.9)), 0.6, u(-0.4, 0.4)));
  for (int i = 0; i < 2; ++i) {
    const Pose place(so3_exp(Vec3(0, 0, u(-1, 1))), Vec3(u(-1.5, 1.5), u(1.5, d - 1), 0));
    for (const auto& face : simulate::box("box", place, Vec3(u(0.3, 0.8), u(0.3, 0.6), u(0.3, 1.2)), 0.6))
      add(face);
  }
  add({"column", simulate::Cylinder{u(0.12, 0.35), 0, h},
       Pose(Eigen::Quaterniond::Identity(), Vec3(u(-1.4, 1.4), u(1.5, d - 0.3), 0)), 0.6});
  const Vec3 eye(u(-0.5, 0.5), u(-0.2, 0.4), u(0.8, 1.7));
  out.room_from_camera = looking_at(eye, Vec3(u(-0.6, 0.6), 3, u(0.6, 1.4)), u(-0.08, 0.08));
  return out;
}

/// Noise of 1.2 to 2 times the model's, a tenth of the readings lost, edges of twice the usual width, a range
/// of 7 m, glass-like losses where the view is grazing; a lens as above.
inline simulate::DepthSensor hard_sensor(std::uint64_t seed) {
  std::mt19937_64 random(seed + 7000);
  simulate::DepthSensor sensor = lopsided_sensor();
  sensor.axial_noise = uniform(random, 1.2, 2);
  sensor.edge_noise = uniform(random, 1, 2);
  sensor.dropout = uniform(random, 0.02, 0.15);
  sensor.grazing = uniform(random, 1.2, 1.4);
  sensor.farthest = 7;
  return sensor;
}

/// A larger room, seen from a camera held by hand (pitch and roll up to 25 degrees): walls that end before
/// the corner or have an opening, a pillar, panels at any angle, shelves, several boxes and round things.
inline SeenRoom hard_room(std::uint64_t seed) {
  std::mt19937_64 random(seed + 5000);
  const auto u = [&](double low, double high) { return uniform(random, low, high); };
  SeenRoom out;
  const double w = u(3.5, 7), d = u(3.5, 6.5), h = u(2.4, 3.4);
  const Pose turn(so3_exp(Vec3(0, 0, u(-0.7, 0.7))), Vec3::Zero());
  const auto add = [&](simulate::Body body) {
    body.room_from_body = turn * body.room_from_body;
    out.room.bodies.push_back(body);
  };
  // The far wall with an opening, behind which another wall stands.
  const double door = u(-w / 4, w / 4), half = u(0.3, 0.5);
  add(hung("far wall, left", Vec3(0.5 * (door - half - w / 2), d, h / 2), Vec3(0, -1, 0),
           Vec2(door - half + w / 2, h), 0.6));
  add(hung("far wall, right", Vec3(0.5 * (door + half + w / 2), d, h / 2), Vec3(0, -1, 0),
           Vec2(w / 2 - door - half, h), 0.6));
  add(hung("behind", Vec3(0, d + u(0.6, 1.5), h / 2), Vec3(u(-0.2, 0.2), -1, 0), Vec2(w, h), 0.6));
  const double left = u(0.5, 1), right = u(0.5, 1);  // share of the walls that is there
  add(hung("left wall", Vec3(-w / 2, d * (1 - left / 2), h / 2), Vec3(1, 0, 0), Vec2(d * left, h), 0.6));
  add(hung("right wall", Vec3(w / 2, d * (1 - right / 2), h / 2), Vec3(-1, 0, 0), Vec2(d * right, h), 0.6));
  add(hung("floor", Vec3(0, d / 2, 0), Vec3(0, 0, 1), Vec2(w, d), 0.6));
  add(hung("ceiling", Vec3(0, d / 2, h), Vec3(0, 0, -1), Vec2(w, d), 0.6));
  const Vec3 table(u(-1, 1), u(1.5, d - 0.8), u(0.45, 0.9));
  add(hung("table", table, Vec3(0, 0, 1), Vec2(u(0.6, 1.6), u(0.5, 0.9)), 0.6, u(-0.8, 0.8)));
  for (int i = 0; i < 2; ++i)
    add(hung("shelf", Vec3(u(-w / 2 + 0.5, w / 2 - 0.5), d - 0.18, u(0.5, 1.6)), Vec3(0, 0, 1),
             Vec2(u(0.6, 1.2), 0.35), 0.6));
  for (int i = 0; i < 2; ++i)
    add(hung("panel", Vec3(u(-1.5, 1.5), u(1.5, d - 0.5), u(0.4, 1.8)),
             Vec3(u(-1, 1), u(-1, -0.3), u(-0.5, 0.7)), Vec2(u(0.4, 1), u(0.4, 1)), 0.6, u(-1, 1)));
  for (int i = 0; i < 4; ++i) {
    const Pose place(so3_exp(Vec3(0, 0, u(-1, 1))), Vec3(u(-2, 2), u(1.5, d - 0.5), 0));
    for (const auto& face : simulate::box("box", place, Vec3(u(0.25, 0.8), u(0.25, 0.6), u(0.25, 1.4)), 0.6))
      add(face);
  }
  const Pose pillar(so3_exp(Vec3(0, 0, u(-0.3, 0.3))), Vec3(u(-2, 2), u(2, d - 0.3), 0));
  for (const auto& face : simulate::box("pillar", pillar, Vec3(u(0.25, 0.4), u(0.25, 0.4), h), 0.6))
    add(face);
  add({"column", simulate::Cylinder{u(0.1, 0.35), 0, h},
       Pose(Eigen::Quaterniond::Identity(), Vec3(u(-1.8, 1.8), u(1.5, d - 0.3), 0)), 0.6});
  for (int i = 0; i < 3; ++i)
    add({"ball", simulate::Sphere{u(0.08, 0.3)},
         Pose(Eigen::Quaterniond::Identity(), Vec3(u(-1.5, 1.5), u(1.2, d - 0.3), u(0.2, 1.6))), 0.6});
  const Vec3 eye(u(-0.8, 0.8), u(-0.2, 0.4), u(0.6, 1.9));
  out.room_from_camera = looking_at(eye, Vec3(u(-1, 1), 3, u(0, 2.2)), u(-0.4, 0.4));
  return out;
}

struct Score {
  int there = 0, found = 0;                  ///< true planes of which 0.1 m2 or more are seen
  int determined = 0, determined_found = 0;  ///< of these, those that the readings determine
  int planes = 0, wrong = 0;                 ///< reported ones
  int inside = 0;                            ///< truths in the 95 % region
  std::vector<double> angles_deg, offsets;

  static double median(std::vector<double> values) {
    if (values.empty()) return 0;
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  }
};

/// The angle that white noise of the sensor leaves a plane uncertain by, radians: the larger standard
/// deviation of the normal, from the inverse of its normal matrix in inverse depth.
inline double normal_bound(const Plane& plane, const Mat3& information) {
  const Vec3 t = -plane.normal / plane.offset;
  const auto turns = turns_of(t.normalized());
  const Mat2 c = turns.transpose() * information.inverse() * turns / t.squaredNorm();
  const double half = 0.5 * c.trace();
  const double square = half + std::sqrt(std::max(half * half - c.determinant(), 0.0));
  return square > 0 ? std::sqrt(square) : std::numeric_limits<double>::infinity();
}

/// The readings determine a plane when they hold as many as 9 cells that lie 4 pixels or more inside of what
/// is seen of it (farther than the sensor's lateral noise reaches), and these leave its normal less than 2
/// degrees uncertain (5 degrees at 99 %).
inline constexpr double kDeterminedReadings = 9 * 64, kDeterminedNormal = 2 * kDegree;
inline constexpr int kBesideAnother = 4;

/// Coplanar bodies (a wall left and right of a door) are one plane. A reported plane is right when more than
/// 70 % of its pixels are of one flat body, less than 5 degrees and 50 mm from it; it finds that body, and
/// every other half of which it covers. `find` makes Planes of a DepthImage and a RayTable.
template <typename Find>
void add_score(const SeenRoom& seen, const simulate::DepthSensor& sensor, std::uint64_t seed, Score& score,
               const Find& find) {
  const simulate::DepthView view = simulate::depth_view(seen.room, sensor, seen.room_from_camera, seed);
  const RayTable rays(sensor.camera);
  const Planes found = find(DepthImage(view.mm.view(), 0.001), rays);
  const auto& bodies = seen.room.bodies;
  const std::size_t n = bodies.size();
  const Intrinsics& k = sensor.camera.intrinsics;
  std::vector<double> area(n), pixels(n);
  std::vector<Plane> truth;
  for (const auto& body : bodies)
    truth.push_back(seen.room_from_camera.inverse() * Plane::of_xy(body.room_from_body));
  const auto flat = [&](std::size_t b) {
    return b < n && std::holds_alternative<simulate::Rectangle>(bodies[b].shape);
  };
  std::vector<std::size_t> first(n);  // of the bodies in one plane
  for (std::size_t b = 0; b < n; ++b) {
    first[b] = b;
    for (std::size_t a = 0; a < b && flat(b) && first[b] == b; ++a)
      if (flat(a) &&
          (truth[a].normal - truth[b].normal).norm() + std::abs(truth[a].offset - truth[b].offset) < 1e-9)
        first[b] = a;
  }
  const auto body_at = [&](int x, int y) {
    const int body = view.body.at(x, y);
    return body < 0 ? -1 : int(first[std::size_t(body)]);
  };
  const auto is_inside = [&](int x, int y, int body) {
    for (int d = -kBesideAnother; d <= kBesideAnother; ++d)
      if (body_at(std::clamp(x + d, 0, view.mm.width() - 1), y) != body ||
          body_at(x, std::clamp(y + d, 0, view.mm.height() - 1)) != body)
        return false;
    return true;
  };
  std::vector<double> inside(n);
  std::vector<Mat3> information(n, Mat3::Zero());
  std::vector<std::vector<double>> shared(found.planes.size(), std::vector<double>(n + 1));
  for (int y = 0; y < view.mm.height(); ++y)
    for (int x = 0; x < view.mm.width(); ++x) {
      const int body = body_at(x, y), label = found.labels.at(x, y);
      if (body >= 0 && view.mm.at(x, y) > 0) {
        const double z = double(view.true_metres.at(x, y));
        area[std::size_t(body)] += z * z * z / (std::abs(truth[std::size_t(body)].offset) * k.fx * k.fy);
        pixels[std::size_t(body)] += 1;
        if (is_inside(x, y, body)) {
          const double sigma =
              sensor.axial_noise * simulate::axial_sigma(z, double(view.angle.at(x, y))) / (z * z);
          const Vec3 ray(double(rays.u(x, y)), double(rays.v(x, y)), 1);
          information[std::size_t(body)] += ray * ray.transpose() / (sigma * sigma);
          inside[std::size_t(body)] += 1;
        }
      }
      if (label >= 0 && label < int(found.planes.size()))
        shared[std::size_t(label)][body < 0 ? n : std::size_t(body)] += 1;
    }
  std::vector<char> got(n);
  for (std::size_t i = 0; i < found.planes.size(); ++i) {
    const DetectedPlane& plane = found.planes[i];
    const auto most = std::size_t(std::max_element(shared[i].begin(), shared[i].end()) - shared[i].begin());
    ++score.planes;
    bool right = flat(most) && shared[i][most] > 0.7 * plane.pixels;
    if (right) {
      const Plane& t = truth[most];
      const double side = plane.estimate.plane.normal.dot(t.normal) < 0 ? -1 : 1;
      const double cosine = side * plane.estimate.plane.normal.dot(t.normal);
      const double angle = std::acos(std::min(cosine, 1.0)) / kDegree;
      right = angle < 5 && std::abs(t.signed_distance(plane.middle)) < 0.05;
      if (right) {
        score.angles_deg.push_back(angle);
        score.offsets.push_back(std::abs(side * t.offset - plane.estimate.plane.offset));
        score.inside += squared_sigmas(plane.estimate, t) < 7.81;  // 95 % of chi-square with 3
        got[most] = 1;
        for (std::size_t b = 0; b < n; ++b)
          if (shared[i][b] > 0.5 * pixels[b]) got[b] = 1;
      }
    }
    score.wrong += !right;
  }
  for (std::size_t b = 0; b < n; ++b)
    if (flat(b) && area[b] >= 0.1) {
      ++score.there;
      score.found += got[b];
      const bool is_determined =
          inside[b] >= kDeterminedReadings && normal_bound(truth[b], information[b]) < kDeterminedNormal;
      score.determined += is_determined;
      score.determined_found += is_determined && got[b];
    }
}

inline void add_score(const SeenRoom& seen, const simulate::DepthSensor& sensor, std::uint64_t seed,
                      Score& score) {
  add_score(seen, sensor, seed, score,
            [](const DepthImage& image, const RayTable& rays) { return find_planes(image, rays); });
}

}  // namespace procam::depth::test
