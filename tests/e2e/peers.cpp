#include "peers.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "procam/core/geometry/plane.hpp"

namespace procam::test {
namespace {

using Places = std::vector<std::vector<cv::Point3f>>;
using Pixels = std::vector<std::vector<cv::Point2f>>;

cv::Point2f to_cv(const Vec2& p) {
  return {float(p.x()), float(p.y())};
}
cv::Size to_cv(ImageSize size) {
  return {size.width, size.height};
}

cv::Mat to_cv(const ViewU8& image) {
  return {image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.row(0)),
          std::size_t(image.row(1) - image.row(0))};
}

std::vector<Observation> as_observations(const std::vector<cv::Point2f>& corners) {
  std::vector<Observation> observations;
  for (const cv::Point2f& corner : corners)
    observations.push_back({int(observations.size()), Vec2(corner.x, corner.y)});
  return observations;
}

constexpr int kFlags = cv::CALIB_FIX_K3;

struct Lens {
  cv::Mat k, d;
};

Camera to_camera(ImageSize size, const Lens& lens) {
  Camera camera{size, {}, BrownConrady{}};
  camera.intrinsics = {lens.k.at<double>(0, 0), lens.k.at<double>(1, 1), lens.k.at<double>(0, 2),
                       lens.k.at<double>(1, 2), 0};
  std::vector<double> coefficients(5);
  for (int i = 0; i < 5; ++i) coefficients[std::size_t(i)] = lens.d.at<double>(i);
  camera.distortion = with_coefficients(camera.distortion, coefficients);
  return camera;
}

Lens calibrated(const Places& places, const Pixels& pixels, ImageSize size) {
  Lens lens;
  std::vector<cv::Mat> r, t;
  cv::calibrateCamera(places, pixels, to_cv(size), lens.k, lens.d, r, t, kFlags);
  return lens;
}

/// All lenses refined together with the views: stereoCalibrate's best.
Rig stereo(const Places& places, const Pixels& in_camera, const Pixels& in_projector,
           const std::vector<Device>& devices, Lens camera, Lens projector) {
  cv::Mat r, t, e, f;
  cv::stereoCalibrate(places, in_camera, in_projector, camera.k, camera.d, projector.k, projector.d,
                      to_cv(devices[0].size), r, t, e, f, cv::CALIB_USE_INTRINSIC_GUESS | kFlags,
                      cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-9));
  Mat3 rotation;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) rotation(row, column) = r.at<double>(row, column);
  const Pose projector_from_camera(rotation, Vec3(t.at<double>(0), t.at<double>(1), t.at<double>(2)));
  Rig rig;
  rig.cameras.push_back({"camera", to_camera(devices[0].size, camera), Pose()});
  rig.projectors.push_back(
      {"projector", Projector{to_camera(devices[1].size, projector)}, projector_from_camera.inverse()});
  return rig;
}

/// The projector's pixel at a camera pixel, by a homography of the pixels decoded round it.
std::optional<Vec2> by_local_homography(const Vec2& corner, std::size_t view, const DecodedPixel& decoded) {
  constexpr int kHalf = 23;
  const int cx = int(std::lround(corner.x())), cy = int(std::lround(corner.y()));
  std::vector<cv::Point2f> from, to;
  for (int y = cy - kHalf; y <= cy + kHalf; ++y)
    for (int x = cx - kHalf; x <= cx + kHalf; ++x)
      if (const auto pixel = decoded(view, x, y)) {
        from.emplace_back(float(x), float(y));
        to.push_back(to_cv(*pixel));
      }
  if (from.size() < (2 * kHalf + 1) * (2 * kHalf + 1) / 2) return std::nullopt;
  const cv::Mat h = cv::findHomography(from, to, cv::RANSAC, 3);
  if (h.empty()) return std::nullopt;
  std::vector<cv::Point2f> pixel;
  cv::perspectiveTransform(std::vector<cv::Point2f>{to_cv(corner)}, pixel, h);
  return Vec2(pixel[0].x, pixel[0].y);
}

}  // namespace

Eigen::AlignedBox2d covered_core(const Correspondences& data) {
  std::vector<double> xs, ys;
  const auto add = [&](const Vec2& pixel) {
    xs.push_back(pixel.x());
    ys.push_back(pixel.y());
  };
  for (const View& view : data.views) {
    for (const Observation& o : view.observations[1]) add(o.pixel);
    for (const LightPoint& light : view.light_points) add(light.projector_pixel);
  }
  std::sort(xs.begin(), xs.end());
  std::sort(ys.begin(), ys.end());
  const std::size_t low = xs.size() / 20, high = xs.size() - 1 - low;
  return {Vec2(xs[low], ys[low]), Vec2(xs[high], ys[high])};
}

double light_rms_mm(const Rig& estimated, const Rig& truth, const Eigen::AlignedBox2d& core) {
  const RigProjector &a = estimated.projector(), &b = truth.projector();
  double sum = 0;
  int count = 0;
  for (const double distance : {1.0, 1.5, 2.0, 2.5, 3.0}) {
    const Plane wall = b.rig_from_projector * Plane{-Vec3::UnitZ(), distance};
    for (int j = 0; j <= 6; ++j)
      for (int i = 0; i <= 8; ++i) {
        const Vec2 pixel = core.min() + core.sizes().cwiseProduct(Vec2(i / 8.0, j / 6.0));
        const auto landed = [&](const RigProjector& device) {
          const auto ray = device.projector.emit(pixel);
          return ray ? intersect(device.rig_from_projector * *ray, wall) : std::nullopt;
        };
        const auto at_a = landed(a), at_b = landed(b);
        require(at_b.has_value(), "light_rms_mm: the true light misses the wall");
        sum += at_a ? (*at_a - *at_b).squaredNorm() : 1;  // light that is lost counts as a metre off
        ++count;
      }
  }
  return 1e3 * std::sqrt(sum / count);
}

std::vector<Observation> opencv_corners(const ViewU8& image, const Chessboard& board) {
  const cv::Mat view = to_cv(image);
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCorners(view, cv::Size(board.columns, board.rows), corners)) return {};
  cv::cornerSubPix(view, corners, cv::Size(11, 11), cv::Size(-1, -1),
                   cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.01));
  return as_observations(corners);
}

std::vector<Observation> opencv_corners_by_sectors(const ViewU8& image, const Chessboard& board) {
  std::vector<cv::Point2f> corners;
  if (!cv::findChessboardCornersSB(to_cv(image), cv::Size(board.columns, board.rows), corners,
                                   cv::CALIB_CB_ACCURACY))
    return {};
  return as_observations(corners);
}

Rig opencv_rig_of_gray_code(const Correspondences& data, const DecodedPixel& decoded) {
  const Points3 points = points_in_board(data.board);
  Places print, lit_places;
  Pixels in_camera, lit_in_camera, in_projector;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    print.emplace_back(), in_camera.emplace_back();
    std::vector<cv::Point3f> places;
    std::vector<cv::Point2f> seen, lit;
    for (const Observation& corner : data.views[v].observations[0]) {
      const Vec3& p = points[std::size_t(corner.point)];
      print.back().emplace_back(float(p.x()), float(p.y()), 0.f);
      in_camera.back().push_back(to_cv(corner.pixel));
      const auto pixel = by_local_homography(corner.pixel, v, decoded);
      if (!pixel) continue;
      places.push_back(print.back().back());
      seen.push_back(in_camera.back().back());
      lit.push_back(to_cv(*pixel));
    }
    if (places.size() < 6) continue;
    lit_places.push_back(places), lit_in_camera.push_back(seen), in_projector.push_back(lit);
  }
  const auto& devices = data.devices;
  return stereo(lit_places, lit_in_camera, in_projector, devices,
                calibrated(print, in_camera, devices[0].size),
                calibrated(lit_places, in_projector, devices[1].size));
}

Rig opencv_rig_of_light_points(const Correspondences& data) {
  const Points3 points = points_in_board(data.board);
  Places print;
  Pixels in_camera;
  for (const View& view : data.views) {
    print.emplace_back(), in_camera.emplace_back();
    for (const Observation& corner : view.observations[0]) {
      const Vec3& p = points[std::size_t(corner.point)];
      print.back().emplace_back(float(p.x()), float(p.y()), 0.f);
      in_camera.back().push_back(to_cv(corner.pixel));
    }
  }
  Lens camera;
  std::vector<cv::Mat> r, t;
  cv::calibrateCamera(print, in_camera, to_cv(data.devices[0].size), camera.k, camera.d, r, t, kFlags);

  Places places;
  Pixels seen, shown;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    if (data.views[v].light_points.empty()) continue;
    places.emplace_back(), seen.emplace_back(), shown.emplace_back();
    for (const LightPoint& light : data.views[v].light_points) {
      seen.back().push_back(to_cv(light.camera_pixel));
      shown.back().push_back(to_cv(light.projector_pixel));
    }
    std::vector<cv::Point2f> normalized;
    cv::undistortPoints(seen.back(), normalized, camera.k, camera.d);
    cv::Mat rotation;
    cv::Rodrigues(r[v], rotation);
    const cv::Mat origin = -rotation.t() * t[v];  // of the camera, in the board's frame
    for (const cv::Point2f& n : normalized) {
      const cv::Mat ray = rotation.t() * (cv::Mat_<double>(3, 1) << n.x, n.y, 1);
      const double s = -origin.at<double>(2) / ray.at<double>(2);
      places.back().emplace_back(float(origin.at<double>(0) + s * ray.at<double>(0)),
                                 float(origin.at<double>(1) + s * ray.at<double>(1)), 0.f);
    }
  }
  return stereo(places, seen, shown, data.devices, camera, calibrated(places, shown, data.devices[1].size));
}

Rig told_bundle(const Correspondences& given, const simulate::SimulatedSession& truth,
                const calibrate::Options& options) {
  Correspondences data = given;
  calibrate::BundleState state;
  const Rig& rig = truth.rig();
  state.lenses = {rig.camera().camera, rig.projector().projector.inverse_camera};
  state.device_from_rig = {Pose(), rig.projector().rig_from_projector.inverse()};
  state.points_in_board = points_in_board(data.board);
  for (const simulate::World& world : truth.views) state.rig_from_board.push_back(world.rig_from_board);
  const int num_points = int(state.points_in_board.size());
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    // A board that looks the same turned may have been found turned.
    View& view = data.views[v];
    double as_found = 0, turned = 0;
    for (const Observation& o : view.observations[0]) {
      const auto error = [&](int point) {
        const auto pixel =
            state.lenses[0].project(state.rig_from_board[v] * state.points_in_board[std::size_t(point)]);
        return pixel ? (*pixel - o.pixel).squaredNorm() : 1e6;
      };
      as_found += error(o.point), turned += error(num_points - 1 - o.point);
    }
    if (turned < as_found)
      for (auto& observations : view.observations)
        for (Observation& o : observations) o.point = num_points - 1 - o.point;
  }

  calibrate::UsedMask used = calibrate::use_all(data);
  for (int d = 0; d < 2; ++d) {
    std::vector<double> lengths;
    const auto each = [&](const auto& visit) {
      for (int v = 0; v < int(data.views.size()); ++v)
        for (const calibrate::Measurement& m : calibrate::measurements_of(data, v, d)) {
          const auto error = calibrate::reprojection_residual(state, m);
          visit(used[std::size_t(v)][std::size_t(d)][std::size_t(m.index)], error ? error->norm() : 1e6);
        }
    };
    each([&](char&, double length) { lengths.push_back(length); });
    std::nth_element(lengths.begin(), lengths.begin() + long(lengths.size() / 2), lengths.end());
    const double sigma = lengths[lengths.size() / 2] / 1.1774;  // of two Gaussian coordinates
    each([&](char& verdict, double length) { verdict = length <= 5 * sigma; });
  }

  calibrate::BundleOptions bundle;
  bundle.held = {options.camera.held, options.projector.held};
  bundle.noise.resize(2);
  bundle.hold_pose = {true, false};
  bundle.huber_sigmas = 0;
  const calibrate::BundleState solved = calibrate::bundle_adjust(data, used, state, bundle).state;
  Rig result;
  result.cameras.push_back({"camera", solved.lenses[0], Pose()});
  result.projectors.push_back(
      {"projector", Projector{solved.lenses[1]}, solved.device_from_rig[1].inverse()});
  return result;
}

}  // namespace procam::test
