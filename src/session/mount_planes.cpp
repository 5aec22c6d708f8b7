#include "procam/session/mount_planes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/words.hpp"
#include "procam/depth/planes.hpp"
#include "procam/depth/sensor_check.hpp"
#include "procam/io/image/depth_file.hpp"
#include "procam/io/text.hpp"
#include "timed_images.hpp"

namespace procam::session {
namespace {

namespace fs = std::filesystem;

std::vector<std::pair<double, fs::path>> depth_files(const DepthImages& images) {
  return timed_images(images.folder, {".png", ".tif", ".tiff", ".pfm"});
}

/// z along the normal, from the middle of what is seen.
Pose camera_from_plane(const depth::DetectedPlane& plane) {
  return {rotation_between(Vec3::UnitZ(), plane.estimate.plane.normal), plane.middle};
}

/// Of the left increment of plane_from_camera, in the plane's frame. A point p of the camera is n . p + d above the plane;
/// with m the middle and e_1, e_2 the axes, tilt and height are
///   (e_2 . dn, -e_1 . dn, m . dn + dd).
Mat6 in_plane_frame(const depth::DetectedPlane& plane, const Pose& camera_from_plane) {
  const Mat3 axes = camera_from_plane.rotation_matrix();
  Eigen::Matrix<double, 3, 4> by = Eigen::Matrix<double, 3, 4>::Zero();
  by.row(0).head<3>() = axes.col(1);
  by.row(1).head<3>() = -axes.col(0);
  by.row(2) << plane.middle.transpose(), 1;
  const Mat3 own = by * plane.estimate.covariance * by.transpose();
  Mat6 covariance = Mat6::Identity();  // within the plane nothing is measured
  constexpr std::array<Eigen::Index, 3> kOff{0, 1, 5};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) covariance(kOff[i], kOff[j]) = own(Eigen::Index(i), Eigen::Index(j));
  return covariance;
}

bool is_well_known(const Mat6& covariance) {
  constexpr double kTilt = 2 * kDegree, kHeight = 0.03;
  return std::sqrt(std::max(covariance(0, 0), covariance(1, 1))) < kTilt &&
         std::sqrt(covariance(5, 5)) < kHeight;
}

void require_metres(const depth::DepthImage& image, const DepthImages& images, const fs::path& file) {
  constexpr double kNearest = 0.1, kFarthest = 15;
  const double median = depth::median_depth(image);
  if (median == 0 || (median > kNearest && median < kFarthest)) return;
  throw Error(ErrorKind::kInput, file.string(),
              "its median depth would be " + fixed(median, 3) + " m" +
                  (image.units.data ? " at " + io::format_length(images.metres_per_unit) + " a step" : ""),
              image.units.data ? "give the unit of its numbers, e.g. 1mm, or 0.2mm for 1/5000 m"
                               : "floats must be metres");
}

}  // namespace

ImageSize depth_image_size(const DepthImages& images) {
  const DepthPixels pixels = io::load_depth_pixels(depth_files(images).front().second);
  return depth::DepthImage(pixels, images.metres_per_unit).size();
}

PlaneSightings planes_in_depth(const DepthImages& images, const RigCamera& camera,
                               const ReadingProgress& progress) {
  const depth::SensorKind sensor = depth::sensor_kind(images.sensor);
  depth::PlaneOptions options;
  options.noise = sensor.noise;
  const depth::RayTable rays(camera.camera);
  const auto files = depth_files(images);
  PlaneSightings found;
  std::string fault;
  std::size_t faults = 0;
  for (const auto& [time, file] : files) {
    if (progress) progress(file.filename().string(), int(found.images), int(files.size()));
    ++found.images;
    const DepthPixels pixels = io::load_depth_pixels(file);
    const depth::DepthImage image(pixels, images.metres_per_unit);
    if (image.size() != camera.camera.size)
      throw Error(ErrorKind::kInput, file.string(),
                  "it has " + io::format_size(image.size()) + " pixels, the depth camera " +
                      io::format_size(camera.camera.size),
                  "give the depth camera's own calibration, in the mode of the images");
    require_metres(image, images, file);
    const depth::Planes planes = depth::find_planes(image, rays, options);
    if (const depth::SensorCheck check = depth::check_sensor(planes, image, rays, sensor);
        !check.fault.empty()) {
      ++faults;
      fault = check.fault + ": " + check.next;
    }
    const std::size_t before = found.sightings.size();
    for (const depth::DetectedPlane& plane : planes.planes) {
      const Pose from_plane = camera_from_plane(plane);
      const Mat6 covariance = in_plane_frame(plane, from_plane);
      if (!is_well_known(covariance)) continue;
      const Pose plane_from_rig = (camera.rig_from_camera * from_plane).inverse();
      found.sightings.push_back({time, "", {plane_from_rig.normalized(), covariance}, true});
    }
    if (found.sightings.size() == before) ++found.images_without_plane;
  }
  if (2 * faults > files.size())
    found.diagnostics.warn("sensor_model", images.folder.string() + ": of " + std::to_string(faults) +
                                               " of " + std::to_string(files.size()) + " images, " + fault);
  if (found.sightings.empty())
    throw Error(ErrorKind::kNotEnoughData, images.folder.string(),
                std::to_string(files.size()) + " images show no plane" +
                    (fault.empty() ? std::string() : "; " + fault),
                "check the depth camera's intrinsics, the unit and the kind of sensor");
  return found;
}

}  // namespace procam::session
