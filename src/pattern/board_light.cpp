#include "procam/pattern/board_light.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>

#include "print.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/geometry/homography.hpp"
#include "smooth_field.hpp"

namespace procam::pattern {
namespace {

constexpr std::size_t kEdgesForHomography = 50000;  // in the whole picture
constexpr std::ptrdiff_t kFewestInBoard = 30;       // of each axis
constexpr int kHomographyRounds = 12;
constexpr std::int64_t kRowKey = 1 << 20;  // of pitches: fewer columns than this
constexpr std::int64_t kStripeKey = kRowKey << 20;
constexpr int kFewestEdges = 8;  // in a quadrant beside a corner, of each axis

/// One projector coordinate that a camera position sees.
struct Measured {
  Vec2 camera_pixel;
  double coordinate = 0;
  StripeAxis axis = StripeAxis::kColumn;
  int stripe = 0;    ///< what errs together has one number
  double sigma = 0;  ///< projector pixels; with `scan`, camera pixels along it
  std::optional<ScanAxis> scan;
};

std::vector<Measured> measured_by(const std::vector<StripeEdge>& edges, int step) {
  std::vector<Measured> all;
  all.reserve(edges.size());
  for (const StripeEdge& e : edges)
    all.push_back({e.camera_pixel, e.projector_coordinate, e.axis,
                   int(std::lround((e.projector_coordinate + 0.5) / step)), e.sigma_px, e.scan});
  return all;
}

/// The decoded pixels on the print, columns first: whoever takes every n-th has both axes.
std::vector<Measured> measured_by(const LightMap& light, const Print& print) {
  std::vector<Measured> all;
  for (int d = 0; d < 2; ++d)
    for (int y = 0; y < light.camera_size().height; ++y)
      for (int x = 0; x < light.camera_size().width; ++x) {
        if (!light.decoded(x, y) || !print.clear(Vec2(x, y))) continue;
        const double coordinate = double(light.pixel.at(x, y, d));
        all.push_back({Vec2(x, y),
                       coordinate,
                       d == 0 ? StripeAxis::kColumn : StripeAxis::kRow,
                       int(std::floor((coordinate + 0.5) / light.period)),
                       double(light.sigma.at(x, y, d)),
                       {}});
      }
  return all;
}

/// One homography for the board's light from its stripe edges: the spline takes up what it leaves. A column
/// edge at p with coordinate u is one equation h1.p - u h3.p = 0, a row edge h2.p - v h3.p = 0 (the direct
/// linear transform, taken apart). Outliers are weighted down (Cauchy weights, rescaled every round); nullopt
/// where the edges carry no homography.
std::optional<Homography> projector_from_camera(const Print& print, const std::vector<Measured>& edges,
                                                ImageSize camera_size, ImageSize projector_size) {
  // Some thousand edges tell the homography well enough.
  std::vector<Measured> used;
  const std::size_t stride = 1 + edges.size() / kEdgesForHomography;
  for (std::size_t i = 0; i < edges.size(); i += stride)
    if (print.clear(edges[i].camera_pixel)) used.push_back(edges[i]);
  const auto columns = std::count_if(used.begin(), used.end(),
                                     [](const Measured& e) { return e.axis == StripeAxis::kColumn; });
  if (columns < kFewestInBoard || std::ptrdiff_t(used.size()) - columns < kFewestInBoard) return std::nullopt;

  // Coordinates of the order of one, for the eigenvalues' sake.
  const auto to_unit = [](ImageSize size) {
    const double scale = 2.0 / std::max(size.width, size.height);
    Mat3 m = Mat3::Identity() * scale;
    m.col(2) = Vec3(-0.5 * scale * size.width, -0.5 * scale * size.height, 1);
    return m;
  };
  const Mat3 unit_from_camera = to_unit(camera_size), unit_from_projector = to_unit(projector_size);
  Mat3 h = Mat3::Zero();
  std::vector<double> weights(used.size(), 1), sizes(used.size());
  for (int round = 0; round < kHomographyRounds; ++round) {
    Mat9 normal = Mat9::Zero();
    for (std::size_t i = 0; i < used.size(); ++i) {
      const int row = used[i].axis == StripeAxis::kColumn ? 0 : 1;
      const Vec3 p = unit_from_camera * used[i].camera_pixel.homogeneous();
      const double u = unit_from_projector(row, row) * used[i].coordinate + unit_from_projector(row, 2);
      Eigen::Matrix<double, 9, 1> equation = Eigen::Matrix<double, 9, 1>::Zero();
      equation.segment<3>(3 * row) = p;
      equation.tail<3>() = -u * p;
      normal.selfadjointView<Eigen::Lower>().rankUpdate(equation, weights[i]);
    }
    const Eigen::SelfAdjointEigenSolver<Mat9> eigen(normal);
    if (!(eigen.eigenvalues()[1] > 1e-9 * eigen.eigenvalues()[8])) return std::nullopt;
    h = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(eigen.eigenvectors().col(0).data());
    int behind = 0;
    for (std::size_t i = 0; i < used.size(); ++i) {
      const int row = used[i].axis == StripeAxis::kColumn ? 0 : 1;
      const Vec3 mapped = h * (unit_from_camera * used[i].camera_pixel.homogeneous());
      const double u = unit_from_projector(row, row) * used[i].coordinate + unit_from_projector(row, 2);
      behind += mapped.z() < 0;
      sizes[i] = std::abs(mapped[row] / mapped.z() - u);
      weights[i] = 1 / (mapped.z() * mapped.z());
    }
    if (2 * std::size_t(behind) > used.size()) h = -h;
    const double scale = std::max(median(sizes), 1e-9);
    for (std::size_t i = 0; i < used.size(); ++i) weights[i] /= 1 + (sizes[i] / scale) * (sizes[i] / scale);
  }
  const Mat3 map = unit_from_projector.inverse() * h * unit_from_camera;
  if (!map.allFinite() || map.determinant() == 0) return std::nullopt;
  return Homography(map);
}

/// The edges of one axis on the board as samples of what the homography leaves.
struct AxisLight {
  std::vector<FieldSample> samples;
  int group_count = 0;
};

AxisLight light_along(StripeAxis axis, const std::vector<Measured>& measured, const Print& print,
                      const Homography& projector_from_camera) {
  const int row = axis == StripeAxis::kColumn ? 0 : 1;
  AxisLight light;
  std::unordered_map<std::int64_t, int> groups;  // by stripe and pitch
  for (const Measured& one : measured) {
    if (one.axis != axis || !print.clear(one.camera_pixel)) continue;
    const auto at = print.place_at(one.camera_pixel);
    if (!at) continue;
    const auto mapped = projector_from_camera.apply(one.camera_pixel);
    if (!mapped) continue;
    FieldSample sample;
    sample.at = *at;
    sample.value = one.coordinate - (*mapped)[row];
    sample.sigma = one.sigma;
    if (one.scan)
      sample.sigma *= std::abs(
          projector_from_camera.jacobian(one.camera_pixel)(row, *one.scan == ScanAxis::kCameraX ? 0 : 1));
    if (!(sample.sigma > 0)) continue;
    sample.stripe = one.stripe;
    const std::int64_t key = sample.stripe * kStripeKey + std::int64_t(std::floor(at->y())) * kRowKey +
                             std::int64_t(std::floor(at->x()));
    sample.group = groups.emplace(key, int(groups.size())).first->second;
    light.samples.push_back(sample);
  }
  light.group_count = int(groups.size());
  return light;
}

/// Does light surround a place? Two quadrants of a pitch that face each other across it must both hold
/// samples (of a chessboard's corner: two squares). Both pairs need not: dark print may reflect too little to
/// be read.
class Surroundings {
 public:
  explicit Surroundings(const AxisLight& light) {
    for (const FieldSample& s : light.samples) cells_[cell_of(s.at)].push_back(s.at);
  }
  bool lit(const Vec2& place) const {
    int counts[2][2] = {};
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i) {
        const auto [column, row] = cell_of(place);
        const auto cell = cells_.find({column + i, row + j});
        if (cell == cells_.end()) continue;
        for (const Vec2& at : cell->second)
          if ((at - place).cwiseAbs().maxCoeff() < 1) ++counts[at.y() > place.y()][at.x() > place.x()];
      }
    return std::min(counts[0][0], counts[1][1]) >= kFewestEdges ||
           std::min(counts[0][1], counts[1][0]) >= kFewestEdges;
  }

 private:
  static std::pair<int, int> cell_of(const Vec2& at) {
    return {int(std::floor(at.x())), int(std::floor(at.y()))};
  }
  std::map<std::pair<int, int>, Points2> cells_;
};

Detections not_lit(ImageSize projector_size, const std::string& why) {
  Detections result;
  result.image_size = projector_size;
  result.diagnostics.warn("board_not_lit", why);
  return result;
}

const char* const kTooFewCorners = "fewer than four points of the board were found in the camera's image";

/// A board in a camera's image.
struct SeenBoard {
  const Detections& in_camera;
  const Board& board;
  const BoardPlace& place;
  const Print& print;
};

Detections project(const SeenBoard& seen_board, const std::vector<Measured>& measured,
                   ImageSize projector_size, const BoardLightOptions& options) {
  const auto& [in_camera, board, place, print] = seen_board;
  const auto base = projector_from_camera(print, measured, in_camera.image_size, projector_size);
  if (!base)
    return not_lit(projector_size,
                   "too little of the board carries readable light; light it fully by the projector, or "
                   "expose longer");

  std::vector<SmoothField> fields;
  std::vector<Surroundings> around;
  for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow}) {
    AxisLight seen = light_along(axis, measured, print, *base);
    fields.emplace_back(print.low(), print.high(), options.knot_pitches);
    if (int(seen.samples.size()) < 4 * fields.back().size())
      return not_lit(
          projector_size,
          "too little light was read on the board; light it fully by the projector, or expose longer");
    fields.back().fit(seen.samples, seen.group_count);
    around.emplace_back(seen);
  }

  Detections result;
  result.image_size = projector_size;
  const Points3 points = points_in_board(board);
  const double pitch = pitch_of(board);
  int unlit = 0;
  for (const Observation& corner : in_camera.observations) {
    const Vec2 printed = points[std::size_t(corner.point)].head<2>() / pitch;
    const auto at = place.at(corner.pixel);
    const auto mapped = base->apply(corner.pixel);
    if (!at || !mapped || !around[0].lit(printed) || !around[1].lit(printed)) {
      ++unlit;
      continue;
    }
    const Mat2 place_by_pixel = place.jacobian(corner.pixel);
    Mat2 jacobian = base->jacobian(corner.pixel);
    Observation lit;
    lit.point = corner.point;
    lit.correlated_with_camera = true;
    for (int d = 0; d < 2; ++d) {
      lit.pixel[d] = (*mapped)[d] + fields[std::size_t(d)].value(*at);
      jacobian.row(d) += fields[std::size_t(d)].gradient(*at).transpose() * place_by_pixel;
    }
    lit.covariance = jacobian * corner.covariance * jacobian.transpose();
    for (int d = 0; d < 2; ++d) lit.covariance(d, d) += fields[std::size_t(d)].variance(*at);
    result.observations.push_back(lit);
  }
  if (unlit > 0)
    result.diagnostics.warn("corners_not_lit",
                            std::to_string(unlit) + " of " + std::to_string(in_camera.observations.size()) +
                                " points are not surrounded by readable light and get no projector pixel");
  return result;
}

}  // namespace

ImageU8 readable_area(const Detections& in_camera, const Board& board, const BoardArtwork& artwork,
                      const BoardLightOptions& options) {
  const auto place = BoardPlace::fit(in_camera, board);
  if (!place) return ImageU8(in_camera.image_size, 1, 0);
  return Print(*place, in_camera, board, artwork, options.border_px).area();
}

Detections project_board(const Detections& in_camera, const Board& board, const BoardArtwork& artwork,
                         const DecodedMap& decoded, const std::vector<StripeEdge>& edges,
                         const BoardLightOptions& options) {
  require(in_camera.image_size == decoded.camera_size(),
          "project_board: detections and decoded map differ in size");
  const auto place = BoardPlace::fit(in_camera, board);
  if (!place) return not_lit(decoded.projector_size, kTooFewCorners);
  const Print print(*place, in_camera, board, artwork, options.border_px);
  return project({in_camera, board, *place, print}, measured_by(edges, decoded.step), decoded.projector_size,
                 options);
}

Detections project_board(const Detections& in_camera, const Board& board, const BoardArtwork& artwork,
                         const LightMap& light, const BoardLightOptions& options) {
  require(in_camera.image_size == light.camera_size(),
          "project_board: detections and light map differ in size");
  const auto place = BoardPlace::fit(in_camera, board);
  if (!place) return not_lit(light.projector_size, kTooFewCorners);
  const Print print(*place, in_camera, board, artwork, options.border_px);
  return project({in_camera, board, *place, print}, measured_by(light, print), light.projector_size, options);
}

}  // namespace procam::pattern
