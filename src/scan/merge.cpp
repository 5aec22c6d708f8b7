#include "procam/scan/merge.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "procam/core/base/parallel.hpp"
#include "procam/core/base/words.hpp"
#include "rig_error.hpp"
#include "surface_view.hpp"

namespace procam::scan {
namespace {

constexpr double kMinAgreement = 0.5;    // cosine between two normals of one surface
constexpr double kSeenThroughBy = 0.02;  // metres
constexpr double kBand = 1.03;           // of the quality: parts of two stations overlap by some pixels
constexpr int kMinKept = 200;            // pixels: fewer make no mesh
constexpr double kMaxContradictions = 0.01, kFailContradictions = 0.2;  // of the points

/// A scan in the world, without the rig's estimated error.
Scan placed(const Scan& scan, const Pose& world_from_rig, const VecX& rig_error, int threads) {
  Scan out = scan;
  const std::size_t count = std::size_t(scan.rig_modes.count()), stride = 1 + 4 * count;
  if (count > 0) {
    std::vector<float> cells;
    for (std::size_t at = 0; at < scan.rig_modes.nodes.size(); at += stride) {
      const float* node = &scan.rig_modes.nodes[at];
      double error = 0;
      for (std::size_t k = 0; k < count; ++k) error += double(node[4 + 4 * k]) * rig_error[Eigen::Index(k)];
      cells.insert(cells.end(), {node[0], float(error)});
    }
    const ImageF error = carried(scan.depth, cells, threads);
    for (int y = 0; y < scan.depth.height(); ++y)
      for (int x = 0; x < scan.depth.width(); ++x)
        if (scan.measured(x, y)) out.depth.at(x, y) = std::max(1e-3f, scan.depth.at(x, y) - error.at(x, y));
    out.camera = without_error(scan.camera, scan.rig_modes, rig_error);
  }
  out.camera.rig_from_camera = (world_from_rig * out.camera.rig_from_camera).normalized();
  return out;
}

/// How well a surface is seen: the smaller the better.
double quality(const SurfaceView& view, int x, int y) {
  const Vec3 ray = view.scan().camera.rig_from_camera.rotate(view.ray(x, y));
  const SurfacePoint at = view.at(x, y);
  return at.depth * at.depth * ray.norm() / std::max(0.02, std::abs(at.normal.dot(ray)));
}

/// What another scan measures of a point.
struct OtherMeasurement {
  int scan = 0;
  Eigen::Vector2i pixel;
  double gap = 0;    ///< of the point from its surface, along its normal
  double sigma = 0;  ///< of its noise along the normal
  Vec3 normal;
};

struct PlacedScan {
  int station = 0;
  Scan scan;
};

class Fusion {
 public:
  Fusion(const std::vector<PlacedScan>& scans, const std::vector<SurfaceView>& views,
         const Registration& registration, const MergeOptions& options)
      : scans_(scans), views_(views), registration_(registration), options_(options) {}

  /// What the scans of other stations measure of the pixel's point, on the same surface.
  std::vector<OtherMeasurement> others(std::size_t i, int x, int y) const {
    std::vector<OtherMeasurement> out;
    const SurfaceView& own = views_[i];
    const Vec3 point = own.measured_point(x, y);
    const bool has_plane = own.has_plane(x, y);
    const SurfacePoint plane = has_plane ? own.at(x, y) : SurfacePoint{};
    const double own_sigma = has_plane ? plane.sigma : double(scans_[i].scan.sigma.at(x, y));
    for (std::size_t k = 0; k < views_.size(); ++k) {
      if (scans_[k].station == scans_[i].station) continue;
      const std::optional<Eigen::Vector2i> pixel = views_[k].pixel_of(point);
      if (!pixel || !views_[k].has_plane(pixel->x(), pixel->y())) continue;
      const SurfacePoint seen = views_[k].at(pixel->x(), pixel->y());
      if (has_plane && seen.normal.dot(plane.normal) < kMinAgreement) continue;
      const double gap = seen.normal.dot(point - views_[k].measured_point(pixel->x(), pixel->y()));
      const double limit =
          std::max(options_.max_distance, options_.max_sigmas * std::hypot(own_sigma, seen.sigma));
      if (std::abs(gap) <= limit) out.push_back({int(k), *pixel, gap, seen.sigma, seen.normal});
    }
    return out;
  }

  /// Does another station measure what is well behind the point, around the pixel that would see it?
  bool contradicted(std::size_t i, int x, int y) const {
    const Vec3 point = views_[i].measured_point(x, y);
    for (std::size_t k = 0; k < views_.size(); ++k) {
      if (scans_[k].station == scans_[i].station) continue;
      const std::optional<Eigen::Vector2i> pixel = views_[k].pixel_of(point);
      if (!pixel) continue;
      const ImageF& depth = scans_[k].scan.depth;
      const double here = views_[k].depth_of(point) + kSeenThroughBy;
      bool through = true;
      for (int dy = -3; dy <= 3 && through; dy += 3)
        for (int dx = -3; dx <= 3 && through; dx += 3) {
          const int px = pixel->x() + dx, py = pixel->y() + dy;
          through = px >= 0 && py >= 0 && px < depth.width() && py < depth.height() &&
                    double(depth.at(px, py)) > here;
        }
      if (through) return true;
    }
    return false;
  }

  /// Depth and noise of a pixel, of all stations.
  void fuse(std::size_t i, int x, int y, const std::vector<OtherMeasurement>& others, FusedScan& out) const {
    const double sigma = double(scans_[i].scan.sigma.at(x, y));
    const Vec3 ray = scans_[i].scan.camera.rig_from_camera.rotate(views_[i].ray(x, y));
    double weights = 1 / (sigma * sigma), sum = 0;
    for (const OtherMeasurement& other : others) {
      const double along = other.normal.dot(ray);  // a change of depth moves so much along the normal
      const double weight = along * along / (other.sigma * other.sigma);
      weights += weight;
      sum -= weight * other.gap / along;
    }
    out.scan.depth.at(x, y) = float(double(scans_[i].scan.depth.at(x, y)) + sum / weights);
    out.scan.sigma.at(x, y) = float(1 / std::sqrt(weights));
  }

  /// Standard deviation of the fused depth by the poses and the rig; negative where it is not known.
  double common_sigma(std::size_t i, int x, int y) const {
    const Vec3 point = views_[i].measured_point(x, y);
    const Vec3 ray = scans_[i].scan.camera.rig_from_camera.rotate(views_[i].ray(x, y));
    const Vec3 normal = views_[i].has_plane(x, y) ? views_[i].at(x, y).normal : Vec3(-ray.normalized());
    const std::vector<OtherMeasurement> seen = others(i, x, y);
    const double own = std::abs(normal.dot(ray)) * double(scans_[i].scan.sigma.at(x, y));
    double weights = 1 / (own * own);
    for (const OtherMeasurement& other : seen) weights += 1 / (other.sigma * other.sigma);
    VecX j = VecX::Zero(registration_.covariance.rows());
    bool known = add(i, Vec2(x, y), double(scans_[i].scan.depth.at(x, y)), point, normal,
                     1 / (own * own * weights), j);
    for (const OtherMeasurement& other : seen)
      known = add(std::size_t(other.scan), other.pixel.cast<double>(),
                  double(scans_[std::size_t(other.scan)].scan.depth.at(other.pixel.x(), other.pixel.y())),
                  point, normal, 1 / (other.sigma * other.sigma * weights), j) &&
              known;
    if (!known) return -1;
    return std::sqrt(std::max(0.0, j.dot(registration_.covariance * j))) /
           std::max(0.05, std::abs(normal.dot(ray)));
  }

 private:
  /// The share of one scan in the derivative of the fused point along the normal.
  bool add(std::size_t i, const Vec2& pixel, double depth, const Vec3& point, const Vec3& normal,
           double share, VecX& j) const {
    Vec6 by_pose;
    by_pose << point.cross(normal), normal;
    j.segment<6>(6 * scans_[i].station) += share * by_pose;
    const RigModes& modes = scans_[i].scan.rig_modes;
    if (modes.count() == 0) return true;
    MatX errors;
    if (!rig_modes_at(modes, pixel, depth, errors)) return false;
    const Pose& pose = registration_.stations[std::size_t(scans_[i].station)].pose.pose;
    j.tail(modes.count()) -= share * errors.topRows<3>().transpose() * (pose.rotation.conjugate() * normal);
    return true;
  }

  const std::vector<PlacedScan>& scans_;
  const std::vector<SurfaceView>& views_;
  const Registration& registration_;
  const MergeOptions& options_;
};

/// Sums over the pixels of one row.
struct RowCounts {
  long pixels = 0, fused = 0, contradicted = 0, gaps = 0;
  double gap_squares = 0, expected_squares = 0;
};

/// Whether the pixel is kept in the mesh (with the band) and in the cloud.
struct Owner {
  bool in_band = true, is_best = true;
};

Owner owner_of(const std::vector<SurfaceView>& views, std::size_t i, int x, int y,
               const std::vector<OtherMeasurement>& others) {
  Owner out;
  if (others.empty()) return out;
  if (!views[i].has_plane(x, y)) return {false, false};
  const double own = quality(views[i], x, y);
  for (const OtherMeasurement& other : others) {
    const std::size_t k = std::size_t(other.scan);
    const double its = quality(views[k], other.pixel.x(), other.pixel.y());
    out.in_band = out.in_band && own <= kBand * its;
    out.is_best = out.is_best && (own < its || (own == its && i < k));
  }
  return out;
}

std::vector<RowCounts> fuse_scan(const Fusion& fusion, const std::vector<PlacedScan>& scans,
                                 const std::vector<SurfaceView>& views, std::size_t i, int threads,
                                 FusedScan& out, ImageF& best) {
  const Scan& scan = scans[i].scan;
  out.station = scans[i].station;
  out.scan = scan;
  out.kept = scan;
  best = scan.depth;
  std::vector<RowCounts> rows(std::size_t(scan.depth.height()));
  parallel_each(scan.depth.height(), threads, [&](int y) {
    RowCounts& counts = rows[std::size_t(y)];
    for (int x = 0; x < scan.depth.width(); ++x) {
      if (!scan.measured(x, y)) continue;
      const std::vector<OtherMeasurement> others = fusion.others(i, x, y);
      const Owner owner = owner_of(views, i, x, y, others);
      ++counts.pixels;
      counts.fused += !others.empty();
      counts.contradicted += others.empty() && fusion.contradicted(i, x, y);
      if (views[i].has_plane(x, y))
        for (const OtherMeasurement& other : others) {
          ++counts.gaps;
          counts.gap_squares += other.gap * other.gap;
          const double own = views[i].at(x, y).sigma;
          counts.expected_squares += other.sigma * other.sigma + own * own;
        }
      fusion.fuse(i, x, y, others, out);
      if (!owner.in_band) out.kept.depth.at(x, y) = 0;
      if (!owner.is_best) best.at(x, y) = 0;
    }
  });
  ImageF with_plane = scan.depth;
  for (int y = 0; y < scan.depth.height(); ++y)
    for (int x = 0; x < scan.depth.width(); ++x)
      if (!views[i].has_plane(x, y)) with_plane.at(x, y) = 0;
  std::vector<float> cells;
  const int columns = cell_columns(scan.depth.width()), cells_y = cell_rows(scan.depth.height());
  cells.resize(2 * std::size_t(columns) * std::size_t(cells_y), 0.0f);
  parallel_each(cells_y, threads, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      // A pixel with a normal where there is one: along the ray alone, the error of an oblique surface looks small.
      Eigen::Vector2i at = pixel_of_cell(with_plane, column, row);
      if (at.x() < 0) at = pixel_of_cell(scan.depth, column, row);
      if (at.x() < 0) continue;
      const double sigma = fusion.common_sigma(i, at.x(), at.y());
      if (sigma < 0) continue;
      float* cell = &cells[2 * (std::size_t(row) * std::size_t(columns) + std::size_t(column))];
      cell[0] = scan.depth.at(at.x(), at.y());
      cell[1] = float(sigma);
    }
  });
  out.scan.rig_sigma = carried(out.scan.depth, cells, threads);
  return rows;
}

/// The fused scan where `keep` is positive.
Scan masked(const Scan& fused, const ImageF& keep) {
  Scan out = fused;
  out.counts.measured = 0;
  for (int y = 0; y < keep.height(); ++y)
    for (int x = 0; x < keep.width(); ++x) {
      if (keep.at(x, y) > 0 && fused.measured(x, y)) {
        ++out.counts.measured;
        continue;
      }
      out.depth.at(x, y) = out.sigma.at(x, y) = out.rig_sigma.at(x, y) = 0;
    }
  return out;
}

void append_cloud(const Scan& best, PointCloud& all) {
  const PointCloud more = point_cloud(best);
  const Vec3 centre = best.camera.rig_from_camera.translation;
  for (std::size_t i = 0; i < more.points.size(); ++i) {
    all.points.push_back(more.points[i]);
    all.normals.push_back(more.normals[i]);
    const double cosine = std::abs(more.normals[i].dot((more.points[i] - centre).normalized()));
    all.sigma.push_back(more.sigma[i] * std::max(0.05, cosine));
  }
}

void append_mesh(const Mesh& more, Mesh& all) {
  const int first = int(all.vertices.size());
  all.vertices.insert(all.vertices.end(), more.vertices.begin(), more.vertices.end());
  all.uv.insert(all.uv.end(), more.uv.begin(), more.uv.end());
  for (const std::array<int, 3>& t : more.triangles)
    all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

/// Longitude and latitude as seen from a camera, from 0 to 1 over the mesh.
void set_content_coordinates(const Pose& world_from_camera, Mesh& mesh) {
  Vec2 low(1e9, 1e9), high(-1e9, -1e9);
  const Pose camera_from_world = world_from_camera.inverse();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vec3 p = camera_from_world * mesh.vertices[i];
    mesh.uv[i] = Vec2(std::atan2(p.x(), p.z()), std::atan2(p.y(), std::hypot(p.x(), p.z())));
    low = low.cwiseMin(mesh.uv[i]);
    high = high.cwiseMax(mesh.uv[i]);
  }
  const Vec2 extent = (high - low).cwiseMax(1e-9);
  for (Vec2& uv : mesh.uv) uv = (uv - low).cwiseQuotient(extent);
}

void mesh_all(const MeshOptions& options, MergedStations& out) {
  for (const FusedScan& fused : out.scans) {
    if (fused.kept.counts.measured < kMinKept) continue;
    append_mesh(mesh_of(fused.kept, options), out.mesh);
  }
  if (out.mesh.triangles.empty())
    throw Error(ErrorKind::kNotEnoughData, "stations", "no station has a part of a surface for a mesh",
                "use views with more of the room");
  set_content_coordinates(out.scans.front().scan.camera.rig_from_camera, out.mesh);
}

}  // namespace

MergedStations merge_stations(const std::vector<Station>& stations, const Registration& registration,
                              const MergeOptions& options) {
  require(stations.size() == registration.stations.size() && !stations.empty(),
          "merge_stations: the registration is of other stations");
  std::vector<PlacedScan> scans;
  for (std::size_t s = 0; s < stations.size(); ++s)
    for (const Scan& scan : stations[s].scans) {
      require(registration.rig_error.size() == scan.rig_modes.root.cols(),
              "merge_stations: the registration is of another rig");
      scans.push_back({int(s), placed(scan, registration.stations[s].pose.pose, registration.rig_error,
                                      options.threads)});
    }
  std::vector<SurfaceView> views;
  for (const PlacedScan& scan : scans) views.emplace_back(scan.scan, options.threads);
  const Fusion fusion(scans, views, registration, options);
  MergedStations out;
  RowCounts all;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    FusedScan fused;
    ImageF best;
    for (const RowCounts& row : fuse_scan(fusion, scans, views, i, options.threads, fused, best)) {
      all.pixels += row.pixels;
      all.fused += row.fused;
      all.contradicted += row.contradicted;
      all.gaps += row.gaps;
      all.gap_squares += row.gap_squares;
      all.expected_squares += row.expected_squares;
    }
    fused.kept = masked(fused.scan, fused.kept.depth);
    append_cloud(masked(fused.scan, best), out.cloud);
    out.cloud_station.resize(out.cloud.points.size(), fused.station);
    out.scans.push_back(std::move(fused));
  }
  out.fused_share = double(all.fused) / double(std::max(all.pixels, 1L));
  out.gap_before = std::sqrt(all.gap_squares / double(std::max(all.gaps, 1L)));
  out.gap_expected = std::sqrt(all.expected_squares / double(std::max(all.gaps, 1L)));
  out.contradictions = int(all.contradicted);
  if (double(all.contradicted) > kMaxContradictions * double(all.pixels))
    out.diagnostics.items.push_back(
        {double(all.contradicted) > kFailContradictions * double(all.pixels) ? Severity::kFailure
                                                                             : Severity::kWarning,
         "contradictions",
         percent(double(all.contradicted) / double(all.pixels), 1) +
             " of the points are seen through from another station: something stood elsewhere, or a "
             "pose is wrong"});
  mesh_all(options.mesh, out);
  return out;
}

}  // namespace procam::scan
