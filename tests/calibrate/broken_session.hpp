#pragma once
/// A good session in numbers, and ways to break it, each named by a step in JSON: {"op": "move_board", "view": 3, ...}.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "procam/analyze/light_error.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "support/numeric_world.hpp"

namespace procam::calibrate {

using nlohmann::json;

inline Vec3 vector_of(const json& numbers) {
  return Vec3(numbers[0].get<double>(), numbers[1].get<double>(), numbers[2].get<double>());
}

inline Pose motion_of(const json& step) {
  return {so3_exp<double>(kDegree * vector_of(step.value("deg", json{0, 0, 0}))),
          1e-3 * vector_of(step.value("mm", json{0, 0, 0}))};
}

/// The session while it is being broken.
struct Session {
  test::NumericWorld world;
  Correspondences data;
  std::mt19937_64 random{99};
  /// Between file and light, in all views: what the rig has to account for, and so part of the truth.
  std::function<Vec2(const Vec2&)> light_of_pixel = [](const Vec2& pixel) { return pixel; };

  double normal() { return std::normal_distribution<double>()(random); }
  int device(const json& step) const { return step.at("device") == "camera" ? 0 : 1; }
  std::vector<std::size_t> views(const json& step) const {
    std::vector<std::size_t> chosen;
    if (step.contains("view")) return {step.at("view").get<std::size_t>()};
    for (std::size_t v = step.value("from", 0u); v < data.views.size(); ++v) chosen.push_back(v);
    return chosen;
  }
  std::vector<Observation>& seen(std::size_t view, int of) {
    return data.views[view].observations[std::size_t(of)];
  }

  /// What one device sees of one view, anew: another world in part, the same noise level.
  void see_again(std::size_t view, int of, const test::NumericWorld& other, std::uint64_t seed) {
    seen(view, of) = other.correspondences(seed).views[view].observations[std::size_t(of)];
  }
};

inline void apply(Session& s, const json& step) {
  const std::string op = step.at("op");
  const auto each_pixel = [&](auto change) {
    for (const std::size_t v : s.views(step))
      for (Observation& o : s.seen(v, s.device(step))) change(o);
  };
  if (op == "keep_views") {
    s.data.views.resize(step.at("count"));
  } else if (op == "same_pose") {  // the board never moved
    for (Pose& pose : s.world.camera_from_board) pose = s.world.camera_from_board.front();
    s.data = s.world.correspondences(5);
  } else if (op == "parallel") {  // moved, never tilted
    for (Pose& pose : s.world.camera_from_board)
      pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(kDegree * step.value("roll", 0.0), Vec3::UnitZ()));
    s.data = s.world.correspondences(5);
  } else if (op == "far_and_central") {  // a stamp in the middle of the picture
    for (Pose& pose : s.world.camera_from_board) {
      const double z = step.at("metres");
      pose.translation = Vec3(-0.14, -0.09, z);
    }
    s.data = s.world.correspondences(5);
  } else if (op == "small_in_the_centre") {  // tilted, but small and never near an edge
    for (Pose& pose : s.world.camera_from_board)
      pose.translation = vector_of(step.at("metres")) - pose.rotation * Vec3(0.14, 0.0875, 0);
    s.data = s.world.correspondences(5);
  } else if (op == "tilt_about") {  // one axis alone
    const Vec3 axis = vector_of(step.at("axis"));
    for (Pose& pose : s.world.camera_from_board)
      pose.rotation = so3_exp<double>(Vec3(so3_log(pose.rotation).dot(axis) * axis));
    s.data = s.world.correspondences(5);
  } else if (op == "scale_tilts") {  // almost no tilt
    for (Pose& pose : s.world.camera_from_board)
      pose.rotation = so3_exp<double>(step.at("factor").get<double>() * so3_log(pose.rotation));
    s.data = s.world.correspondences(5);
  } else if (op == "scale_motions") {  // all poses lie near the first
    const Pose first = s.world.camera_from_board.front();
    const double factor = step.at("factor");
    for (Pose& pose : s.world.camera_from_board) {
      const Pose motion = first.inverse() * pose;
      pose = first * Pose(so3_exp<double>(factor * so3_log(motion.rotation)), factor * motion.translation);
    }
    s.data = s.world.correspondences(5);
  } else if (op == "drift_projector") {  // from view to view, as a clamp that gives way
    for (std::size_t v = 0; v < s.data.views.size(); ++v) {
      test::NumericWorld moved = s.world;
      const double share = double(v) / double(s.data.views.size() - 1);
      const Pose whole = motion_of(step);
      moved.projector_from_camera =
          Pose(so3_exp<double>(share * so3_log(whole.rotation)), share * whole.translation) *
          moved.projector_from_camera;
      s.see_again(v, 1, moved, 7);
    }
  } else if (op == "drift_zoom") {  // from view to view, as a lens that warms up
    for (std::size_t v = 0; v < s.data.views.size(); ++v) {
      const double share = double(v) / double(s.data.views.size() - 1);
      apply(s, {{"op", "zoom"},
                {"device", step.at("device")},
                {"view", v},
                {"factor", 1 + share * (step.at("factor").get<double>() - 1)}});
    }
  } else if (op == "shift_order") {  // a column was missed
    const int columns = std::get<Chessboard>(s.data.board).columns;
    for (const std::size_t v : s.views(step)) {
      std::vector<Observation>& seen = s.seen(v, s.device(step));
      for (Observation& o : seen) o.point += 1;
      seen.erase(std::remove_if(seen.begin(), seen.end(),
                                [&](const Observation& o) { return o.point % columns == 0; }),
                 seen.end());
    }
  } else if (op == "move_board") {  // between the camera's picture and the patterns
    test::NumericWorld moved = s.world;
    for (const std::size_t v : s.views(step)) {
      moved.camera_from_board[v] = moved.camera_from_board[v] * motion_of(step);
      s.see_again(v, 1, moved, 6);
    }
  } else if (op == "move_projector") {
    test::NumericWorld moved = s.world;
    moved.projector_from_camera = motion_of(step) * moved.projector_from_camera;
    for (const std::size_t v : s.views(step)) s.see_again(v, 1, moved, 7);
  } else if (op == "stale") {  // the patterns of another view
    s.seen(step.at("view"), 1) = s.seen(step.at("of"), 1);
  } else if (op == "swap") {
    std::swap(s.seen(step.at("view"), s.device(step)), s.seen(step.at("with"), s.device(step)));
  } else if (op == "turn") {  // by 180 degrees
    each_pixel([&](Observation& o) { o.point = int(points_in_board(s.data.board).size()) - 1 - o.point; });
  } else if (op == "mirror_order") {  // each row read backwards
    const int columns = std::get<Chessboard>(s.data.board).columns;
    each_pixel([&](Observation& o) { o.point += columns - 1 - 2 * (o.point % columns); });
  } else if (op == "mirror_pixels") {
    const double last = s.data.devices[std::size_t(s.device(step))].size.width - 1.0;
    each_pixel([&](Observation& o) { o.pixel.x() = last - o.pixel.x(); });
  } else if (op == "swap_axes") {
    each_pixel([&](Observation& o) { o.pixel = Vec2(o.pixel.y(), o.pixel.x()); });
  } else if (op == "scale_pixels") {
    const Vec2 factors(step.at("x"), step.at("y"));
    each_pixel([&](Observation& o) { o.pixel = o.pixel.cwiseProduct(factors); });
    if (s.device(step) == 1)
      s.light_of_pixel = [factors](const Vec2& pixel) -> Vec2 { return pixel.cwiseQuotient(factors); };
  } else if (op == "keystone") {  // the projector's own correction, switched on
    const double strength = step.at("strength").get<double>() / 768;
    each_pixel([&](Observation& o) { o.pixel /= 1 + strength * o.pixel.y(); });
    s.light_of_pixel = [strength](const Vec2& pixel) -> Vec2 { return pixel / (1 - strength * pixel.y()); };
  } else if (op == "zoom") {  // about the picture's middle
    const ImageSize size = s.data.devices[std::size_t(s.device(step))].size;
    const Vec2 middle(0.5 * size.width, 0.5 * size.height);
    each_pixel(
        [&](Observation& o) { o.pixel = middle + step.at("factor").get<double>() * (o.pixel - middle); });
  } else if (op == "noise") {
    each_pixel([&](Observation& o) {
      o.pixel += step.at("px").get<double>() * Vec2{s.normal(), s.normal()};
    });
  } else if (op == "outliers") {
    std::uniform_real_distribution<double> share;
    each_pixel([&](Observation& o) {
      if (share(s.random) < step.at("share").get<double>())
        o.pixel += step.at("px").get<double>() * Vec2{s.normal(), s.normal()};
    });
  } else if (op == "rescaled_board") {  // a view of another print
    test::NumericWorld other = s.world;
    std::get<Chessboard>(other.board).square_size *= step.at("factor").get<double>();
    for (const std::size_t v : s.views(step))
      for (const int d : {0, 1}) s.see_again(v, d, other, 8);
  } else if (op == "keep_points") {
    for (const std::size_t v : s.views(step)) s.seen(v, s.device(step)).resize(step.at("count"));
  } else if (op == "one_row") {
    const int columns = std::get<Chessboard>(s.data.board).columns;
    for (const std::size_t v : s.views(step))
      for (const int d : {0, 1}) s.seen(v, d).resize(std::size_t(columns));
  } else if (op == "resampled") {  // nearest pixel of another resolution
    const double factor = step.at("factor");
    each_pixel([&](Observation& o) { o.pixel = (factor * o.pixel).array().round() / factor; });
  } else if (op == "bend") {
    for (const Vec3& p : points_in_board(s.world.board))
      s.world.bend.emplace_back(
          0, 0, 1e-3 * step.at("mm").get<double>() * std::sin(30 * p.x()) * std::cos(25 * p.y()));
    s.data = s.world.correspondences(5);
  } else if (op == "flutter") {  // another bend in every view
    for (std::size_t v = 0; v < s.data.views.size(); ++v) {
      test::NumericWorld bent = s.world;
      const double height = 1e-3 * step.at("mm").get<double>() * s.normal(), phase = s.normal();
      for (const Vec3& p : points_in_board(s.world.board))
        bent.bend.emplace_back(0, 0, height * std::cos(12 * p.x() + 9 * p.y() + phase));
      for (const int d : {0, 1}) s.see_again(v, d, bent, 9);
    }
  } else {
    FAIL() << "no such way to break a session: " << op;
  }
}

inline void expect_finite(const CalibrationResult& result) {
  for (const RigCamera& camera : result.rig.cameras) EXPECT_TRUE(parameters_of(camera.camera).allFinite());
  for (const RigProjector& projector : result.rig.projectors)
    EXPECT_TRUE(parameters_of(projector.projector.inverse_camera).allFinite());
  EXPECT_TRUE(result.rig.covariance.matrix.allFinite());
  for (const Residual& r : result.residuals) EXPECT_TRUE(r.residual.allFinite());
  EXPECT_TRUE(std::isfinite(result.joint_rms_px));
}

/// All that a person gets to read.
inline std::string words_of(const CalibrationResult& result) {
  std::string words;
  for (const Diagnostic& d : result.diagnostics.items) words += d.message + "\n";
  for (const Gate& gate : result.rig.quality.gates)
    if (!gate.passed) words += gate.name + ": " + gate.detail + "\n";
  return words;
}

/// Light on a wall 2 m before the projector, RMS over what both rigs light of it, in mm.
struct LightErrors {
  double actual = 0, predicted = 0;
};
inline LightErrors light_errors(const Session& session, const CalibrationResult& result) {
  const Pose camera_from_projector = session.world.projector_from_camera.inverse();
  const Pose projector_from_estimate =
      camera_from_projector.inverse() * result.rig.projector().rig_from_projector;
  const Projector &actual = session.world.projector, &estimate = result.rig.projector().projector;
  const Plane wall{Vec3(0, 0, 1), -2.0};
  double squares = 0;
  int count = 0;
  for (double y = 0.05; y < 1; y += 0.1)
    for (double x = 0.05; x < 1; x += 0.1) {
      const Vec2 pixel(x * actual.size().width, y * actual.size().height);
      const auto light = actual.emit(session.light_of_pixel(pixel)), believed = estimate.emit(pixel);
      if (!light || !believed) continue;
      const auto lands = intersect(*light, wall),
                 expected = intersect(projector_from_estimate * *believed, wall);
      if (!lands || !expected) continue;
      squares += 1e6 * (*lands - *expected).squaredNorm();
      ++count;
    }
  return {count > 50 ? std::sqrt(squares / count) : std::numeric_limits<double>::infinity(),
          analyze::predicted_light_error(result.rig, 2).rms_mm};
}

}  // namespace procam::calibrate
