#include "procam/depth/plane_map.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>
#include "plane_estimate.hpp"
#include "plane_kinds.hpp"
#include "upright_frame.hpp"

namespace procam::depth {
namespace {

/// Rasters end here; a plane is no larger than what is ever projected on.
constexpr int kMaxMapCells = 1 << 19;
/// A cell's free share at which content leaves it, and at which it may come back.
constexpr float kBlocked = 0.35f, kFree = 0.65f;
/// Share of a content's cells that may be blocked before it gives way: single cells flicker at edges.
constexpr double kBlockedShare = 0.01;
/// An unnamed plane that is not seen again within this time, seconds, was none.
constexpr double kForget = 2;

/// Makes the raster reach to low and high; its cells keep their places.
void extend(MapPlane& plane, const Vec2& low, const Vec2& high) {
  PlaneRaster& raster = plane.raster;
  const auto cells = [&](double metres) { return int(std::floor(metres / raster.cell)); };
  const int left = std::max(0, -cells(low.x() - raster.low.x())),
            top = std::max(0, -cells(low.y() - raster.low.y()));
  const int right = std::max(raster.free.width(), cells(high.x() - raster.low.x()) + 1);
  const int bottom = std::max(raster.free.height(), cells(high.y() - raster.low.y()) + 1);
  const long width = left + right, height = top + bottom;
  if ((left == 0 && top == 0 && right == raster.free.width() && bottom == raster.free.height()) ||
      width * height > kMaxMapCells)
    return;
  ImageU8 free(int(width), int(height), 1);
  ImageF share(int(width), int(height), 1, -1.0f);
  for (int j = 0; j < raster.free.height(); ++j)
    for (int i = 0; i < raster.free.width(); ++i) {
      free.at(i + left, j + top) = raster.free.at(i, j);
      share.at(i + left, j + top) = plane.free_share.at(i, j);
    }
  raster.low -= raster.cell * Vec2(left, top);
  raster.free = std::move(free);
  plane.free_share = std::move(share);
}

/// The part of a raster that a rectangle covers.
PlaneRaster cut(const PlaneRaster& raster, const FreeRectangle& rectangle) {
  const auto clamp = [](double at, int size) { return std::clamp(int(std::lround(at)), 0, size); };
  const Vec2 low = (rectangle.low - raster.low) / raster.cell,
             high = (rectangle.high - raster.low) / raster.cell;
  const int x0 = clamp(low.x(), raster.free.width()), x1 = clamp(high.x(), raster.free.width());
  const int y0 = clamp(low.y(), raster.free.height()), y1 = clamp(high.y(), raster.free.height());
  PlaneRaster out{raster.corner(x0, y0), raster.cell, ImageU8(std::max(x1 - x0, 0), std::max(y1 - y0, 0))};
  for (int j = y0; j < y1; ++j)
    for (int i = x0; i < x1; ++i) out.free.at(i - x0, j - y0) = raster.free.at(i, j);
  return out;
}

double free_share_of(const PlaneRaster& raster) {
  long count = 0;
  for (int j = 0; j < raster.free.height(); ++j)
    for (int i = 0; i < raster.free.width(); ++i) count += raster.free.at(i, j);
  const double all = double(raster.free.width()) * raster.free.height();
  return all > 0 ? double(count) / all : 0;
}

PlaneKind kind_of(const Plane& in_world, const Vec3& up) {
  const double rise = in_world.normal.dot(up);
  if (std::abs(rise) < std::sin(12 * kDegree)) return PlaneKind::kWall;
  if (rise > std::cos(12 * kDegree)) return PlaneKind::kTable;
  if (rise < -std::cos(12 * kDegree)) return PlaneKind::kCeiling;
  return PlaneKind::kSlope;
}

/// Planes move while nobody looks: `variance` more of each turn and of the offset.
void add_drift(PlaneEstimate& in_world, double variance) {
  const Vec3& n = in_world.plane.normal;
  in_world.covariance.topLeftCorner<3, 3>() += variance * (Mat3::Identity() - n * n.transpose());
  in_world.covariance(3, 3) += variance;
}

MapPlane new_plane(const PlaneEstimate& in_world, const Vec3& middle_in_world, const Vec3& forward_in_world,
                   const PlaneMapOptions& options) {
  MapPlane plane;
  plane.in_world = in_world;
  plane.kind = kind_of(in_world.plane, options.up_in_world);
  plane.world_from_plane =
      upright_frame(in_world.plane, middle_in_world, options.up_in_world, forward_in_world);
  plane.raster.cell = options.cell;
  plane.raster.free = ImageU8(1, 1);
  plane.free_share = ImageF(1, 1, 1, -1.0f);
  return plane;
}

/// Lowest and highest coordinates of a detected plane's pixels in the plane's own frame; low > high: none.
std::pair<Vec2, Vec2> seen_extent(const Planes& planes, int label, const RayTable& rays,
                                  const Pose& plane_from_camera) {
  const Plane& in_camera = planes.planes[std::size_t(label)].estimate.plane;
  Vec2 low = Vec2::Constant(1e9), high = Vec2::Constant(-1e9);
  for (int y = 0; y < rays.size().height; y += 4)
    for (int x = 0; x < rays.size().width; x += 4) {
      if (planes.labels.at(x, y) != label) continue;
      const Vec3 ray(double(rays.u(x, y)), double(rays.v(x, y)), 1);
      const double z = -in_camera.offset / in_camera.normal.dot(ray);
      if (!(z > 0 && z < 20)) continue;
      const Vec2 at = (plane_from_camera * Vec3(z * ray)).head<2>();
      low = low.cwiseMin(at);
      high = high.cwiseMax(at);
    }
  return {low, high};
}

}  // namespace

PlaneMap::PlaneMap(const PlaneMapOptions& options) : options_(options) {
  require(options.up_in_world.allFinite() && options.up_in_world.norm() > 0, "PlaneMap: up is no direction");
  require(options.min_observations >= 1 && options.free_space_tau > 0 && options.process_noise >= 0 &&
              options.largest_angle > 0 && options.largest_gap > 0 && options.cell > 0 && options.margin >= 0,
          "PlaneMap: free_space_tau, gates and cell must be positive");
  options_.up_in_world.normalize();
}

MapPlane* PlaneMap::match(const PlaneEstimate& in_world, const Vec3& middle_in_world) {
  MapPlane* best = nullptr;
  double least = 1;
  for (MapPlane& plane : planes_) {
    const Plane& known = plane.in_world.plane;
    const double cosine = known.normal.dot(in_world.plane.normal);
    const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
    const double gap = std::abs(known.signed_distance(middle_in_world));
    const Mat3 c = turn_covariance(plane.in_world) + turn_covariance(in_world);
    const double angle_gate = options_.largest_angle + 3 * std::sqrt(std::max(c(0, 0), c(1, 1)));
    // The gap is measured at the detection, not at the world's origin.
    Vec4 at;
    at << middle_in_world, 1;
    const double spread = at.dot((plane.in_world.covariance + in_world.covariance) * at);
    const double gap_gate = options_.largest_gap + 3 * std::sqrt(std::max(spread, 0.0));
    // Of several the nearest; believed ones before new ones.
    const double off = std::max(angle / angle_gate, gap / gap_gate) * (plane.name.empty() ? 1.0 : 0.7);
    if (angle < angle_gate && gap < gap_gate && off < least) least = off, best = &plane;
  }
  return best;
}

void PlaneMap::fuse(MapPlane& plane, const PlaneEstimate& seen) {
  PlaneEstimate& known = plane.in_world;
  const auto turns = turns_of(known.plane.normal);
  Eigen::Matrix<double, 3, 4> j = Eigen::Matrix<double, 3, 4>::Zero();
  j.topLeftCorner<2, 3>() = turns.transpose();
  j(2, 3) = 1;
  const Mat3 mine = turn_covariance(known), theirs = j * seen.covariance * j.transpose();
  Vec3 off;
  off << turns.transpose() * seen.plane.normal, seen.plane.offset - known.plane.offset;
  const Eigen::LDLT<Mat3> sum(mine + theirs);
  const Mat3 gain = sum.solve(mine).transpose();
  const Vec3 step = gain * off;
  Mat3 rest = mine - gain * mine;
  rest = 0.5 * (rest + rest.transpose()).eval();
  if (!step.allFinite() || !rest.allFinite()) return;
  known.plane.normal = (known.plane.normal + turns * step.head<2>()).normalized();
  known.plane.offset += step.z();
  Eigen::Matrix<double, 4, 3> back = Eigen::Matrix<double, 4, 3>::Zero();
  back.topLeftCorner<3, 2>() = turns;
  back(3, 2) = 1;
  known.covariance = back * rest * back.transpose();

  // The frame follows: its origin straight onto the plane, its axes by the smallest turn.
  const Vec3 z = -known.plane.normal, old_y = plane.world_from_plane.rotate(Vec3::UnitY());
  const Vec3 y = (old_y - z * z.dot(old_y)).normalized();
  Mat3 axes;
  axes << y.cross(z), y, z;
  const Vec3 origin = plane.world_from_plane.translation;
  plane.world_from_plane =
      Pose(axes, Vec3(origin - known.plane.normal * known.plane.signed_distance(origin)));
}

/// One depth image with its planes.
struct PlaneMap::Frame {
  const Planes& planes;
  const DepthImage& image;
  const RayTable& rays;
  const Pose& world_from_camera;
  const std::vector<int>& plane_of_label;  ///< indices of the map's planes
};

void PlaneMap::look(MapPlane& plane, int id, const Frame& frame, double blend) const {
  const auto& [planes, image, rays, world_from_camera, plane_of_label] = frame;
  const Pose camera_from_plane = world_from_camera.inverse() * plane.world_from_plane;
  const Mat3 r = camera_from_plane.rotation_matrix();
  // Seen from behind nothing is told.
  if (!(r.col(2).dot(camera_from_plane.translation) > 0)) return;
  const PlaneRaster& raster = plane.raster;
  const int width = rays.size().width, height = rays.size().height;
  for (int j = 0; j < raster.free.height(); ++j)
    for (int i = 0; i < raster.free.width(); ++i) {
      const Vec2 at = raster.corner(i, j) + Vec2::Constant(0.5 * raster.cell);
      const Vec3 p = r.leftCols<2>() * at + camera_from_plane.translation;
      if (!(p.z() > 0.1)) continue;
      const Vec2 pixel = rays.pixel_of(p.x() / p.z(), p.y() / p.z());
      if (!(pixel.x() > -0.5 && pixel.y() > -0.5 && pixel.x() < width - 0.5 && pixel.y() < height - 0.5))
        continue;
      const int x = int(pixel.x() + 0.5), y = int(pixel.y() + 0.5);
      const double z = double(image.at(x, y));
      if (!(z > 0)) continue;
      const int label = planes.labels.at(x, y);
      const bool own =
          label >= 0 && label < int(plane_of_label.size()) && plane_of_label[std::size_t(label)] == id;
      const double gate =
          3 * std::hypot(options_.noise.sigma(p.z()), options_.noise.correlated_sigma(p.z())) + raster.cell;
      const bool free = own || std::abs(z - p.z()) < gate;
      float& share = plane.free_share.at(i, j);
      if (share < 0) {
        if (own) share = 0.5f;  // free once it stays: what passes leaves no surface behind
      } else {
        share += float(blend) * (float(free) - share);
      }
      std::uint8_t& now = plane.raster.free.at(i, j);
      if (share >= kFree) now = 1;
      if (share >= 0 && share <= kBlocked) now = 0;
    }
}

void PlaneMap::choose_content(MapPlane& plane) const {
  if (!plane.home) {
    plane.home = largest_rectangle(plane.raster, options_.min_side, options_.margin);
    plane.content = plane.home;
    return;
  }
  if (1 - free_share_of(cut(plane.raster, *plane.home)) <= kBlockedShare) {
    plane.content = plane.home;
    return;
  }
  if (plane.content && 1 - free_share_of(cut(plane.raster, *plane.content)) <= kBlockedShare &&
      plane.content->area() < 0.999 * plane.home->area()) {
    // Smaller already, and nothing new stands in it: it stays, unless a fifth more has become free.
    const auto inside = largest_rectangle(cut(plane.raster, *plane.home), options_.min_side, options_.margin);
    if (!inside || inside->area() < 1.2 * plane.content->area()) return;
    plane.content = inside;
    return;
  }
  plane.content = largest_rectangle(cut(plane.raster, *plane.home), options_.min_side, options_.margin);
}

void PlaneMap::name_new(const Pose& world_from_camera) {
  std::vector<MapPlane*> fresh;
  const auto settled = [&](const MapPlane& plane, const FreeRectangle& content) {
    if (plane.seen >= 10 * options_.min_observations) return true;
    for (const Vec2& corner : {content.low, content.high}) {
      Vec4 at;
      at << plane.world_from_plane * Vec3(corner.x(), corner.y(), 0), 1;
      if (!(at.dot(plane.in_world.covariance * at) < options_.max_corner_sigma * options_.max_corner_sigma))
        return false;
    }
    return true;
  };
  for (MapPlane& plane : planes_) {
    if (!plane.name.empty() || plane.seen < options_.min_observations) continue;
    const auto content = largest_rectangle(plane.raster, options_.min_side, options_.margin);
    if (content && settled(plane, *content)) fresh.push_back(&plane);
  }
  const Pose camera_from_world = world_from_camera.inverse();
  const auto bearing = [&](const MapPlane* plane) {
    const Vec3 at = camera_from_world * plane->world_from_plane.translation;
    return std::atan2(at.x(), at.z());
  };
  std::stable_sort(fresh.begin(), fresh.end(),
                   [&](const MapPlane* a, const MapPlane* b) { return bearing(a) < bearing(b); });
  for (MapPlane* plane : fresh) {
    const int number = ++names_given_[std::size_t(plane->kind)];
    const bool alone = plane->kind == PlaneKind::kFloor || plane->kind == PlaneKind::kCeiling;
    plane->name = to_string(plane->kind);
    if (!alone || number > 1) plane->name += "_" + std::to_string(number);
  }
}

void PlaneMap::update(const Planes& planes, const DepthImage& image, const RayTable& rays,
                      const PoseWithCovariance& world_from_camera, double time) {
  require(image.size() == rays.size() && planes.labels.size() == rays.size(),
          "PlaneMap: image, labels and camera differ in size");
  require(
      world_from_camera.pose.is_finite() && world_from_camera.covariance.allFinite() && std::isfinite(time),
      "PlaneMap: pose, covariance and time must be finite");
  require(!started_ || time >= time_, "PlaneMap: time goes back");
  const double step = started_ ? time - time_ : 0;
  started_ = true;
  time_ = time;
  const Pose& pose = world_from_camera.pose;

  for (MapPlane& plane : planes_)
    add_drift(plane.in_world, options_.process_noise * options_.process_noise * step);

  const Vec3 up_in_camera = pose.inverse().rotate(options_.up_in_world);
  const std::vector<PlaneKind> kinds = kinds_of(planes, image, rays, up_in_camera);
  std::vector<int> plane_of_label(planes.planes.size(), -1);
  for (std::size_t i = 0; i < planes.planes.size(); ++i) {
    const DetectedPlane& detected = planes.planes[i];
    const PlaneEstimate in_world = transformed(pose, detected.estimate, world_from_camera.covariance);
    const Vec3 middle = pose * detected.middle;
    MapPlane* plane = match(in_world, middle);
    if (plane == nullptr) {
      planes_.push_back(new_plane(in_world, middle, pose.rotate(Vec3::UnitZ()), options_));
      plane = &planes_.back();
      if (kinds[i] == PlaneKind::kFloor) plane->kind = kinds[i];
    } else {
      fuse(*plane, in_world);
    }
    plane_of_label[i] = int(plane - planes_.data());
  }

  // What of each plane is seen, where it reaches farther than before, and what stands before it.
  const double blend = 1 - std::exp(-step / options_.free_space_tau);
  std::vector<char> seen(planes_.size());
  for (std::size_t i = 0; i < planes.planes.size(); ++i) {
    MapPlane& plane = planes_[std::size_t(plane_of_label[i])];
    seen[std::size_t(plane_of_label[i])] = 1;
    const auto [low, high] = seen_extent(planes, int(i), rays, plane.world_from_plane.inverse() * pose);
    if (low.x() <= high.x()) extend(plane, low, high);
  }
  for (std::size_t id = 0; id < planes_.size(); ++id) {
    MapPlane& plane = planes_[id];
    if (seen[id]) {
      ++plane.seen;
      plane.last_seen = time;
    }
    look(plane, int(id), {planes, image, rays, pose, plane_of_label}, blend);
  }
  planes_.erase(std::remove_if(planes_.begin(), planes_.end(),
                               [&](const MapPlane& plane) {
                                 return plane.name.empty() && time - plane.last_seen > kForget;
                               }),
                planes_.end());
  name_new(pose);
  for (MapPlane& plane : planes_)
    if (!plane.name.empty()) choose_content(plane);
}

SurfaceSet PlaneMap::surfaces() const {
  SurfaceSet set;
  for (const MapPlane& plane : planes_)
    if (!plane.name.empty() && plane.content)
      set.surfaces.push_back(
          {plane.name, planar_surface(plane.world_from_plane, *plane.content, "world"), {}, ""});
  return set;
}

void PlaneMap::replan() {
  for (MapPlane& plane : planes_) {
    plane.home.reset();
    plane.content.reset();
    if (!plane.name.empty()) choose_content(plane);
  }
}

}  // namespace procam::depth
