#include "procam/report/mount.hpp"

#include <algorithm>
#include <cmath>

#include "fields.hpp"
#include "html.hpp"
#include "procam/core/base/closed_form.hpp"

namespace procam::report {

using calibrate::MountCarrier;
using calibrate::MountDirection;
using calibrate::MountEvent;
using calibrate::MountMarker;
using calibrate::MountPlane;
using calibrate::MountResult;

namespace {

bool is_angle(std::size_t direction) {
  return direction < 3 || direction == 7;
}

const char* carrier_name(MountCarrier carrier) {
  return carrier == MountCarrier::kFlange ? "flange" : carrier == MountCarrier::kHead ? "head" : "base";
}

std::string kind_name(MountEvent::Kind kind) {
  return kind == MountEvent::Kind::kRigBumped ? "rig_bumped" : "localiser_jumped";
}

Vec3 rotation_deg(const Pose& pose) {
  return so3_log(pose.rotation) / kDegree;
}

/// The rotation against which the angles of the first camera count, Rz(yaw) Ry(pitch) Rx(roll): on a base it looks along
/// x (yaw to the left, pitch down, roll clockwise), on a flange it has the flange's axes, on a head it looks along the
/// common perpendicular of the axes with the tilt axis to its right.
Mat3 usual_rotation(MountCarrier carrier) {
  Mat3 usual = Mat3::Identity();
  if (carrier == MountCarrier::kBase) usual << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  if (carrier == MountCarrier::kHead) usual << 0, 0, 1, 0, -1, 0, 1, 0, 0;
  return usual;
}

/// A head whose tilt grows downwards has the camera along the perpendicular's other direction.
double within_right_angle(double degrees) {
  return degrees > 90 ? degrees - 180 : degrees < -90 ? degrees + 180 : degrees;
}

/// Of each direction its value: degrees and millimetres. The tilt zero is the reported tilt at which the camera looks
/// along the common perpendicular of the axes: level, if the pan axis is upright.
std::vector<double> direction_values(const MountResult& result) {
  const Pose& mount = result.base_from_rig.pose;
  const Mat3 r = mount.rotation_matrix() * usual_rotation(result.carrier).transpose();
  double yaw = std::atan2(r(1, 0), r(0, 0)) / kDegree,
         pitch = std::asin(std::clamp(-r(2, 0), -1.0, 1.0)) / kDegree,
         roll = std::atan2(r(2, 1), r(2, 2)) / kDegree;
  if (result.carrier == MountCarrier::kHead) yaw = within_right_angle(-yaw), roll = within_right_angle(roll);
  const Vec3 at = 1e3 * mount.translation;
  std::vector<double> values{roll, pitch, yaw, at.x(), at.y(), at.z()};
  if (result.axes) {
    values.push_back(1e3 * result.axes->offset);
    values.push_back(result.axes->angle / kDegree);
  }
  return values;
}

/// The reported pan at which the camera, level, looks along the world's x axis; degrees.
double pan_zero(const MountResult& result) {
  const Pose& world_from_head = result.world_from_base->pose;
  const Vec3 sight = result.base_from_rig.pose.rotate(Vec3::UnitZ());
  const Vec3 x = world_from_head.rotation.conjugate() * Vec3::UnitX();
  const double ahead = std::atan2(x.y(), x.x()) - (sight.x() < 0 ? kPi : 0);
  return std::remainder(ahead, 2 * kPi) / kDegree;
}

}  // namespace

static void fields(Fields& f, const MountDirection& direction) {
  f.field("name", direction.name);
  f.field("sigma", direction.sigma);
  f.field("sigma_of_drive", direction.sigma_data);
  f.field("observable", direction.observable);
}

static void fields(Fields& f, const MountMarker& marker) {
  const PoseWithCovariance& pose = marker.world_from_marker;
  f.field("name", marker.name);
  f.field("translation", Vec3(pose.pose.translation));
  f.field("rotation_xyzw", Vec4(pose.pose.rotation.coeffs()));
  f.field("position_sigma", Vec3(point_covariance(pose, Vec3::Zero()).diagonal().cwiseMax(0).cwiseSqrt()));
}

static void fields(Fields& f, const MountPlane& plane) {
  f.field("name", plane.name);
  f.field("translation", Vec3(plane.world_from_plane.translation));
  f.field("normal", plane.world_from_plane.rotate(Vec3::UnitZ()));
  f.field("tilt_and_distance_sigma", Vec3(plane.covariance.diagonal().cwiseMax(0).cwiseSqrt()));
}

static void fields(Fields& f, const MountEvent& event) {
  f.field("kind", kind_name(event.kind));
  f.field("time", event.time);
  f.field("translation_mm", Vec3(1e3 * event.change.translation));
  f.field("rotation_deg", rotation_deg(event.change));
  f.field("chi2", event.chi2);
  f.field("other_chi2", event.other_chi2);
}

static void fields(Fields& f, const MountResult::PlaneSensor& sensor) {
  const Vec4 sigma = sensor.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  f.field("scale", sensor.scale);
  f.field("scale_sigma", sigma[0]);
  f.field("turn_deg", Vec3(sensor.turn / kDegree));
  f.field("turn_sigma_deg", Vec3(sigma.tail<3>() / kDegree));
}

static void fields(Fields& f, const MountResult& result) {
  f.field("carrier", std::string(carrier_name(result.carrier)));
  const Pose& mount = result.base_from_rig.pose;
  f.object("base_from_rig", [&](Fields& pose) {
    pose.field("translation", mount.translation);
    pose.field("rotation_xyzw", Vec4(mount.rotation.coeffs()));
    const std::vector<double> values = direction_values(result);
    pose.field("roll_pitch_yaw_deg", Vec3(values[0], values[1], values[2]));
  });
  if (result.axes)
    f.object("axes", [&](Fields& axes) {
      axes.field("offset", result.axes->offset);
      axes.field("angle_deg", result.axes->angle / kDegree);
      if (result.world_from_base) axes.field("pan_zero_deg", pan_zero(result));
    });
  if (result.world_from_base)
    f.object("world_from_base", [&](Fields& pose) {
      pose.field("translation", result.world_from_base->pose.translation);
      pose.field("rotation_xyzw", Vec4(result.world_from_base->pose.rotation.coeffs()));
    });
  f.field("directions", result.directions);
  f.field("unobservable", result.unobservable());
  f.field("planar", result.planar);
  f.field("time_offset", result.time_offset);
  f.field("time_offset_sigma", result.time_offset_sigma);
  f.field("scale", result.scale);
  f.field("scale_sigma", result.scale_sigma);
  f.field("position_sigma", result.position_sigma);
  f.field("rotation_sigma_deg", result.rotation_sigma / kDegree);
  f.field("correlation", result.correlation);
  f.field("floor_sigma", result.floor_sigma);
  f.field("floor_tilt_sigma_deg", result.floor_tilt_sigma / kDegree);
  f.field("sighting_factor", result.sighting_factor);
  f.field("plane_factor", result.plane_factor);
  f.field("base_poses_used", result.base_poses_used);
  f.field("base_poses_rejected", result.rejected_base_poses.size());
  f.field("sightings_used", result.sightings_used);
  f.field("sightings_rejected", result.rejected_sightings.size());
  f.field("sightings_outside", result.sightings_outside);
  f.field("events", result.events);
  f.field("markers", result.markers);
  f.field("planes", result.planes);
  if (result.plane_sensor)
    f.object("plane_sensor", [&](Fields& sensor) { fields(sensor, *result.plane_sensor); });
}

std::string to_json(const MountResult& result) {
  return text(json(result));
}

namespace {

/// "8 markers and 5 planes".
std::string seen_things(const MountResult& result) {
  const std::string markers = std::to_string(result.markers.size()) + " markers",
                    planes = std::to_string(result.planes.size()) + " planes";
  return result.planes.empty() ? markers : result.markers.empty() ? planes : markers + " and " + planes;
}

/// "; of the sightings 0.98 times their covariance".
std::string noise_of_sightings(const MountResult& result) {
  std::string text;
  if (!result.markers.empty())
    text += format("; of the sightings %.2f times their covariance", result.sighting_factor);
  if (!result.planes.empty()) text += format("; of the planes %.2f times theirs", result.plane_factor);
  return text;
}

}  // namespace

std::vector<std::string> lines(const MountResult& result) {
  const bool base = result.carrier == MountCarrier::kBase, of_head = result.axes.has_value();
  std::vector<std::string> lines{format("%zu %s and %zu sightings of %s", result.base_poses_used,
                                        base      ? "base poses"
                                        : of_head ? "angles"
                                                  : "arm poses",
                                        result.sightings_used, seen_things(result).c_str())};
  if (base) lines[0] += result.planar ? "; the base moves in a plane" : "; the base moves in space";
  lines.push_back(base      ? "base_from_rig        value      sigma   sigma of the drive alone"
                  : of_head ? "tilt_from_rig        value      sigma   sigma of the motion alone"
                            : "flange_from_rig      value      sigma   sigma of the motion alone");
  const std::vector<double> values = direction_values(result);
  for (std::size_t i = 0; i < result.directions.size(); ++i) {
    const MountDirection& direction = result.directions[i];
    const char* const unit = is_angle(i) ? "deg" : "mm";
    const double scale = is_angle(i) ? 1 / kDegree : 1e3;
    const std::string drive = direction.observable ? format("%8.3f %s", scale * direction.sigma_data, unit)
                                                   : "not observable: as stated";
    lines.push_back(format("  %-11s %9.3f %10.3f %-3s  %s", direction.name.c_str(), values[i],
                           scale * direction.sigma, unit, drive.c_str()));
  }
  if (result.world_from_base) {
    const PoseWithCovariance& world = *result.world_from_base;
    const Vec3 at = 1e3 * world.pose.translation,
               sigma = 1e3 * point_covariance(world, Vec3::Zero()).diagonal().cwiseMax(0).cwiseSqrt();
    lines.push_back(format("%s in the world at %.1f, %.1f, %.1f mm, +- %.1f, %.1f, %.1f mm",
                           of_head ? "head" : "arm's base", at.x(), at.y(), at.z(), sigma.x(), sigma.y(),
                           sigma.z()));
    if (of_head)
      lines.push_back(format("it looks along the world's x axis at pan %.2f deg", pan_zero(result)));
  }
  if (result.time_offset_sigma > 0)
    lines.push_back(format("time offset %.1f +- %.1f ms (%s stamps %s against the camera's)",
                           1e3 * result.time_offset, 1e3 * result.time_offset_sigma,
                           base      ? "localiser's"
                           : of_head ? "head's"
                                     : "arm's",
                           result.time_offset >= 0 ? "late" : "early"));
  const std::string of_sightings = noise_of_sightings(result);
  if (of_head)
    lines.push_back(format("noise of the angles %.3f deg; runout of the axes %.3f mm",
                           result.rotation_sigma / kDegree, 1e3 * result.position_sigma) +
                    of_sightings);
  else
    lines.push_back(
        format(base ? "noise of the localiser %.1f mm, %.2f deg" : "noise of the arm %.2f mm, %.3f deg",
               1e3 * result.position_sigma, result.rotation_sigma / kDegree) +
        of_sightings);
  if (result.plane_sensor)
    lines.push_back(format("distances of planes %+.2f +- %.2f %% off", 100 * (result.plane_sensor->scale - 1),
                           100 * std::sqrt(result.plane_sensor->covariance(0, 0))));
  if (result.planar)
    lines.push_back(format("the floor is uneven by %.2f mm and %.3f deg", 1e3 * result.floor_sigma,
                           result.floor_tilt_sigma / kDegree));
  return lines;
}

namespace {

constexpr double kSide = 560, kInset = 400, kRim = 34, kFoot = 64;

/// World metres to picture units, x right and y up.
struct Above {
  Vec2 low, high;
  double scale = 1;
  Vec2 at(const Vec2& p) const {
    return {kRim + scale * (p.x() - low.x()), kRim + scale * (high.y() - p.y())};
  }
};

/// The reported poses of a base or a flange; of a head the poses of the rig on it.
std::vector<BasePose> shown_poses(const MountResult& result, const MountData& data) {
  if (result.carrier != MountCarrier::kHead) return data.base;
  std::vector<BasePose> poses;
  for (const BasePose& pose : result.path)
    poses.push_back({pose.time, pose.world_from_base * result.base_from_rig.pose});
  return poses;
}

/// Where the first camera of a head looks, every now and then.
std::string sights(const std::vector<BasePose>& rig, const Above& above) {
  Marks marks;
  const std::size_t step = 1 + rig.size() / 80;
  for (std::size_t i = 0; i < rig.size(); i += step) {
    const Vec3 from = rig[i].world_from_base.translation, to = rig[i].world_from_base * Vec3(0, 0, 0.6);
    marks.line(above.at(from.head<2>()), above.at(to.head<2>()));
  }
  return marks.path("stroke=\"#b0620f\" stroke-opacity=\"0.35\" stroke-width=\"1\" fill=\"none\"");
}

bool is_upright(const MountPlane& plane) {
  return std::abs(plane.world_from_plane.rotate(Vec3::UnitZ()).z()) < 0.5;
}

/// Of a wall the point nearest to the middle of the drive.
Vec3 nearest_of(const MountPlane& plane, const MountData& data) {
  Vec3 middle = Vec3::Zero();
  for (const BasePose& pose : data.base)
    middle += pose.world_from_base.translation / double(data.base.size());
  const Vec3 normal = plane.world_from_plane.rotate(Vec3::UnitZ());
  return middle - normal.dot(middle - plane.world_from_plane.translation) * normal;
}

Above frame_around(const MountResult& result, const MountData& data) {
  Above above{Vec2::Constant(1e300), Vec2::Constant(-1e300)};
  const auto include = [&](const Vec3& p) {
    above.low = above.low.cwiseMin(p.head<2>());
    above.high = above.high.cwiseMax(p.head<2>());
  };
  for (const BasePose& pose : shown_poses(result, data)) include(pose.world_from_base.translation);
  for (const MountMarker& marker : result.markers) include(marker.world_from_marker.pose.translation);
  for (const MountPlane& plane : result.planes)
    if (is_upright(plane)) include(nearest_of(plane, data));
  const double extent = std::max(0.5, (above.high - above.low).maxCoeff());
  const Vec2 middle = 0.5 * (above.low + above.high);
  above.low = middle - Vec2::Constant(0.53 * extent);
  above.high = middle + Vec2::Constant(0.53 * extent);
  above.scale = (kSide - 2 * kRim) / (above.high.x() - above.low.x());
  return above;
}

const char* const kText = "font-family=\"sans-serif\" font-size=\"13\" fill=\"#222\"";

std::string path_of(const std::vector<BasePose>& poses, const Above& above) {
  std::string d;
  const std::size_t step = poses.size() > 300 ? 3 : 1;
  for (std::size_t i = 0; i < poses.size(); i += step)
    d += (i == 0 ? "M" : "L") + position(above.at(poses[i].world_from_base.translation.head<2>()));
  return d;
}

std::string drive_from_above(const MountResult& result, const MountData& data) {
  const Above above = frame_around(result, data);
  Marks reported;
  const std::vector<BasePose> poses = shown_poses(result, data);
  for (const BasePose& pose : poses) reported.dot(above.at(pose.world_from_base.translation.head<2>()));
  std::string drawing = result.axes ? sights(poses, above) : "";
  drawing += reported.path("stroke=\"#9fb4cc\" stroke-width=\"2.4\" stroke-linecap=\"round\"");
  if (!result.axes)
    drawing += element(
        "path",
        "d=\"" + path_of(result.path, above) + "\" fill=\"none\" stroke=\"#1c4f8f\" stroke-width=\"1.4\"",
        "");
  for (const MountMarker& marker : result.markers) {
    const Pose& pose = marker.world_from_marker.pose;
    const Vec3 half = 0.5 * 0.16 * pose.rotate(Vec3::UnitX());
    const double least = 7 / above.scale;  // visible at any scale
    const Vec2 along = half.head<2>() * std::max(1.0, least / std::max(half.head<2>().norm(), 1e-6));
    const Vec2 at = pose.translation.head<2>(), front = at - 0.15 * pose.rotate(Vec3::UnitZ()).head<2>();
    Marks marks;
    marks.line(above.at(at - along), above.at(at + along));
    marks.line(above.at(at), above.at(front));
    drawing += marks.path("stroke=\"#1b7f3b\" stroke-width=\"3\" fill=\"none\"");
    drawing += label(above.at(at) + Vec2(6, -6), kText, marker.name);
  }
  for (const MountPlane& plane : result.planes) {
    if (!is_upright(plane)) continue;
    const Vec2 at = nearest_of(plane, data).head<2>();
    const Vec3 normal = plane.world_from_plane.rotate(Vec3::UnitZ());
    const Vec2 along = 0.18 * (above.high.x() - above.low.x()) * Vec2(-normal.y(), normal.x()).normalized();
    Marks wall;
    wall.line(above.at(at - along), above.at(at + along));
    drawing += wall.path("stroke=\"#1b7f3b\" stroke-width=\"3\" fill=\"none\"");
    drawing += label(above.at(at) + Vec2(6, -6 - 16 * normal.y()), kText, plane.name);  // into the room
  }
  for (const MountEvent& event : result.events) {
    const auto after = std::lower_bound(result.path.begin(), result.path.end(), event.time,
                                        [](const BasePose& pose, double time) { return pose.time < time; });
    if (after == result.path.end()) continue;
    const Vec2 at = above.at(after->world_from_base.translation.head<2>());
    drawing += circle("fill=\"none\" stroke=\"#c62f2f\" stroke-width=\"2\"", at, 8);
    drawing += label(at + Vec2(12, 4), kText,
                     event.kind == MountEvent::Kind::kRigBumped ? "rig bumped" : "localiser jumped");
  }
  const double ruler = round_step(0.35 * (above.high.x() - above.low.x()));
  Marks bar;
  bar.line(Vec2(kRim, kSide + 6), Vec2(kRim + above.scale * ruler, kSide + 6));
  drawing += bar.path("stroke=\"#222\" stroke-width=\"3\" fill=\"none\"");
  drawing += label(Vec2(kRim + above.scale * ruler + 10, kSide + 11), kText, shortest(ruler) + " m");
  drawing += label(Vec2(kRim, kSide + 32), kText,
                   result.carrier == MountCarrier::kBase
                       ? "The drive from above: localiser (dots), path (line), " +
                             std::string(result.planes.empty()    ? "markers"
                                         : result.markers.empty() ? "walls"
                                                                  : "markers and walls") +
                             " (green)"
                   : result.axes ? "From above: where the rig on the head looks (brown), markers (green)"
                                 : "From above: arm's poses (dots), path (line), markers (green)");
  return drawing;
}

std::string mount_from_above(const MountResult& result) {
  const Vec2 origin(kSide + 0.5 * kInset, 0.5 * kSide);
  const Pose& mount = result.base_from_rig.pose;
  const double reach = std::max(0.3, mount.translation.head<2>().norm()), scale = 0.36 * kInset / reach;
  const auto at = [&](const Vec2& p) { return Vec2(origin + scale * Vec2(-p.y(), -p.x())); };  // x ahead: up
  const Vec2 rig = mount.translation.head<2>();
  Marks axes, sight;
  axes.line(at(Vec2::Zero()), at(Vec2(0.5 * reach, 0)));
  axes.line(at(Vec2::Zero()), at(Vec2(0, 0.5 * reach)));
  Vec2 ahead = mount.rotate(Vec3::UnitZ()).head<2>();
  if (ahead.norm() > 1e-6) ahead.normalize();
  sight.line(at(rig), at(rig + 0.4 * reach * ahead));
  std::string drawing = axes.path("stroke=\"#222\" stroke-width=\"2\" fill=\"none\"");
  drawing += label(at(Vec2(0.5 * reach, 0)) + Vec2(-14, 4), kText, "x");
  drawing += label(at(Vec2(0, 0.5 * reach)) + Vec2(-6, 18), kText, "y");
  drawing += label(at(Vec2::Zero()) + Vec2(6, 18), kText, carrier_name(result.carrier));
  drawing += sight.path("stroke=\"#b0620f\" stroke-width=\"2\" stroke-dasharray=\"5 4\" fill=\"none\"");
  const Mat2 covariance = point_covariance(result.base_from_rig, Vec3::Zero()).topLeftCorner<2, 2>();
  const SymmetricEigen2 eigen = symmetric_eigen(covariance);
  constexpr double kChiSquare95 = 5.991464547107979;
  const auto half = [&](int i) { return std::sqrt(kChiSquare95 * std::max(eigen.values[i], 0.0)); };
  const double larger = std::max({half(0), half(1), 1e-6});
  const double magnified = std::max(1.0, round_step(0.28 * reach / larger));
  const Vec2 axis(-eigen.vectors(1, 0), -eigen.vectors(0, 0));
  drawing +=
      element("ellipse",
              "rx=\"" + fixed(scale * magnified * half(0), 2) + "\" ry=\"" +
                  fixed(scale * magnified * half(1), 2) + "\" transform=\"translate(" + position(at(rig)) +
                  ") rotate(" + fixed(std::atan2(axis.y(), axis.x()) / kDegree, 1) +
                  ")\" fill=\"#b0620f\" fill-opacity=\"0.25\" stroke=\"#b0620f\"",
              "");
  drawing += circle("fill=\"#b0620f\"", at(rig), 3.5);
  drawing += label(at(rig) + Vec2(8, 18), kText, "rig");
  const double left = kSide + 10;
  drawing += label(Vec2(left, kSide + 11), kText,
                   format("x %.1f +- %.1f mm, y %.1f +- %.1f mm", 1e3 * mount.translation.x(),
                          1e3 * std::sqrt(covariance(0, 0)), 1e3 * mount.translation.y(),
                          1e3 * std::sqrt(covariance(1, 1))));
  drawing +=
      label(Vec2(left, kSide + 32), kText,
            (result.axes ? "The rig from the side; 95 % region "
                         : "The rig on the " + std::string(carrier_name(result.carrier)) + "; 95 % region ") +
                shortest(magnified) + " times larger");
  return drawing;
}

}  // namespace

std::string mount_picture(const MountResult& result, const MountData& data) {
  require(!(data.base.empty() && data.angles.empty()) && !result.path.empty(),
          "mount_picture: there is no drive");
  const Vec2 size(kSide + kInset, kSide + kFoot);
  std::string picture = svg(box(Vec2::Zero(), size), "The drive and the pose of the rig on its base",
                            rectangle("fill=\"#fff\"", Vec2::Zero(), size) + drive_from_above(result, data) +
                                mount_from_above(result));
  picture.insert(picture.find("<svg") + 4, " xmlns=\"http://www.w3.org/2000/svg\"");
  return picture + "\n";
}

}  // namespace procam::report
