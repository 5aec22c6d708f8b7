#include "procam/analyze/planner.hpp"

#include <algorithm>
#include <limits>

#include "convex.hpp"
#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/words.hpp"

namespace procam::analyze {
namespace {

constexpr double kGrazingDeg =
    70;  ///< as for surfaces that are solved: errors of the pose grow with 1 / cos^2
constexpr double kHorizonDeg = 89.99;       ///< beyond, a picture ends thousands of distances away, or never
constexpr double kReadablePixels = 9;       ///< ISO 9241-3: 7 x 9 for text that is read
constexpr double kReadableArcMinutes = 16;  ///< ISO 9241-303

void require_positive(const std::string& what, double value, const std::string& unit,
                      const std::string& next) {
  if (value > 0 && std::isfinite(value)) return;
  throw Error(ErrorKind::kInput, what + " " + shortest(value) + unit,
              std::isfinite(value) ? "it must be above zero" : "it is not a finite number", next);
}

void require_usable(const Site& site) {
  if (!site.projector_from_wall.is_finite())
    throw Error(ErrorKind::kInput, "the projector's pose", "it is not finite", "give the pose in metres");
  if (!(site.projector_from_wall.inverse().translation.z() < 0))
    throw Error(ErrorKind::kInput, "the projector's pose", "the lens stands in the wall or behind it",
                "the wall's z axis points into the wall: place the lens at a negative z");
  if (site.target) {
    require_positive("target width", site.target->size.x(), " m", "give its size, e.g. 1.2mx0.8m");
    require_positive("target height", site.target->size.y(), " m", "give its size, e.g. 1.2mx0.8m");
    if (site.target->centre && !site.target->centre->allFinite())
      throw Error(ErrorKind::kInput, "the target's centre", "it is not finite",
                  "give metres to the right and down from the wall's origin");
  }
  if (site.viewer_distance)
    require_positive("viewer distance", *site.viewer_distance, " m", "give the reader's distance, e.g. 3m");
  if (site.text_height)
    require_positive("text height", *site.text_height, " m", "give the height of capitals, e.g. 20mm");
}

/// Top left, top right, bottom right, bottom left: the outer edges of the corner pixels.
Points2 picture_corners(ImageSize size) {
  const double right = size.width - 0.5, bottom = size.height - 0.5;
  return {Vec2(-0.5, -0.5), Vec2(right, -0.5), Vec2(right, bottom), Vec2(-0.5, bottom)};
}

Vec2 picture_middle(ImageSize size) {
  return Vec2(0.5 * (size.width - 1), 0.5 * (size.height - 1));
}

/// All four corners; the whole picture lands with them, being convex.
std::vector<LightOnWall> landed_corners(const Projector& projector, const Pose& projector_from_wall) {
  const char* const names[] = {"top left", "top right", "bottom right", "bottom left"};
  const Points2 pixels = picture_corners(projector.size());
  std::vector<LightOnWall> landed;
  std::string missing;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const auto light = light_on_wall(projector, projector_from_wall, pixels[i]);
    if (light && light->incidence_deg < kHorizonDeg)
      landed.push_back(*light);
    else
      missing += (missing.empty() ? "" : ", ") + std::string(names[i]);
  }
  if (landed.empty())
    throw Error(ErrorKind::kDegenerate, "the picture",
                "the projector looks away from the wall: no light meets it",
                "turn it towards the wall (yaw and pitch are counted from looking straight at it)");
  if (landed.size() < pixels.size())
    throw Error(ErrorKind::kDegenerate, "the picture's corner " + missing,
                "its light never meets the wall: the picture has no end there",
                "turn the projector more towards the wall, or choose a larger throw ratio");
  return landed;
}

void measure_pixels(ProjectionPlan& plan) {
  constexpr int kColumns = 32, kRows = 24;
  const ImageSize size = plan.projector.size();
  plan.mm_per_pixel_min = std::numeric_limits<double>::infinity();
  for (int j = 0; j <= kRows; ++j)
    for (int i = 0; i <= kColumns; ++i) {
      const Vec2 pixel(double(i) / kColumns * size.width - 0.5, double(j) / kRows * size.height - 0.5);
      const LightOnWall light = light_on_wall(plan.projector, plan.projector_from_wall, pixel).value();
      plan.mm_per_pixel_min = std::min(plan.mm_per_pixel_min, light.mm_per_pixel_min);
      plan.mm_per_pixel_max = std::max(plan.mm_per_pixel_max, light.mm_per_pixel_max);
    }
}

ProjectionPlan::Illuminance illuminance(double lumens, const LightOnWall& middle,
                                        const std::vector<LightOnWall>& corners) {
  ProjectionPlan::Illuminance lux{lumens * middle.lux_per_lumen, lumens * middle.lux_per_lumen, 0};
  for (const LightOnWall& corner : corners) {
    lux.darkest = std::min(lux.darkest, lumens * corner.lux_per_lumen);
    lux.brightest = std::max(lux.brightest, lumens * corner.lux_per_lumen);
  }
  return lux;
}

DepthOfField depth_of_field(const DataSheet& sheet, double focal_pixels, const LightOnWall& middle,
                            const std::vector<LightOnWall>& corners) {
  DepthOfField field;
  field.focus = field.nearest = field.farthest = middle.depth;
  for (const LightOnWall& corner : corners) {
    field.nearest = std::min(field.nearest, corner.depth);
    field.farthest = std::max(field.farthest, corner.depth);
  }
  // Blur b = reach |1/focus - 1/z|: `reach` is the hyperfocal distance for one pixel.
  const double reach = *sheet.focal_length / *sheet.f_number * focal_pixels;
  field.near = 1 / (1 / field.focus + 1 / reach);
  field.far =
      field.focus < reach ? 1 / (1 / field.focus - 1 / reach) : std::numeric_limits<double>::infinity();
  field.blur_max_px = reach * (1 / field.nearest - 1 / field.focus);
  return field;
}

double aspect_of(const Vec2& size) {
  return size.y() / size.x();
}

/// Metres, along the sides and diagonals of a part of the lit area.
double coarsest_pixel(const ProjectionPlan& plan, const Points2& part) {
  constexpr int kSteps = 8;
  double coarsest_mm = 0;
  for (const Vec2& from : part)
    for (const Vec2& to : part)
      for (int i = 0; i < kSteps; ++i) {
        const Vec2 at = from + double(i) / kSteps * (to - from);
        const auto pixel = plan.projector.project(plan.projector_from_wall * Vec3(at.x(), at.y(), 0));
        if (!pixel) continue;
        if (const auto light = light_on_wall(plan.projector, plan.projector_from_wall, *pixel))
          coarsest_mm = std::max(coarsest_mm, light->mm_per_pixel_max);
      }
  return 1e-3 * coarsest_mm;
}

/// Returns the target's lit part, or the picture where there is none.
Points2 place_rectangles(const std::optional<WallTarget>& target, ProjectionPlan& plan) {
  const ImageSize size = plan.projector.size();
  const double aspect = target ? aspect_of(target->size) : double(size.height) / size.width;
  const CentredWidth largest = largest_rectangle(plan.corners, aspect);
  plan.undistorted = {largest.centre, Vec2(largest.width, aspect * largest.width)};
  Points2 pixels;
  for (const Vec2& corner : plan.undistorted.corners())
    if (const auto pixel = plan.projector.project(plan.projector_from_wall * Vec3(corner.x(), corner.y(), 0)))
      pixels.push_back(*pixel);
  if (pixels.size() == 4)
    plan.undistorted_pixel_share = area(pixels) / (double(size.width) * double(size.height));

  if (!target) return plan.corners;
  ProjectionPlan::TargetCoverage coverage;
  coverage.rectangle = {target->centre.value_or(largest.centre), target->size};
  Points2 covered = coverage.rectangle.corners();
  for (const HalfPlane& side : half_planes(plan.corners)) covered = clipped(covered, side);
  if (covered.size() >= 3) coverage.covered_share = area(covered) / target->size.prod();
  coverage.whole = coverage.covered_share > 1 - 1e-9;
  plan.target = coverage;
  return covered.size() >= 3 ? covered : plan.corners;
}

std::string in_metres(double value) {
  return fixed(value, 2) + " m";
}
std::string in_mm(double value) {
  return significant(1e3 * value, 3) + " mm";
}

/// "1.20 m x 0.80 m, centre 0.15 m right, 0.30 m up"
std::string described(const WallRectangle& r) {
  const auto towards = [](double value, const char* positive, const char* negative) {
    return in_metres(std::abs(value)) + " " + (value < -0.005 ? negative : positive);
  };
  return in_metres(r.size.x()) + " x " + in_metres(r.size.y()) + ", centre " +
         towards(r.centre.x(), "right", "left") + ", " + towards(r.centre.y(), "down", "up");
}

/// Rounded down: what is not all lit does not read 100 %.
std::string lit_share(const ProjectionPlan::TargetCoverage& target) {
  return fixed(std::floor(100 * target.covered_share), 0) + " %";
}

std::string sharp_depths(const DepthOfField& field) {
  return in_metres(field.near) + " .. " + (std::isfinite(field.far) ? in_metres(field.far) : "infinity");
}

void judge(const DataSheet& sheet, const Site& site, ProjectionPlan& plan) {
  Diagnostics& diagnostics = plan.diagnostics;
  if (plan.incidence_max_deg > kGrazingDeg)
    diagnostics.warn("grazing",
                     "light meets the wall at " + fixed(plan.incidence_max_deg, 0) +
                         " degrees to its normal in the picture's worst corner: small errors of the "
                         "pose become large there; turn or move the projector towards the wall's front");
  if (plan.target && !plan.target->whole) {
    diagnostics.warn("target_not_covered",
                     (plan.target->covered_share > 0 ? "only " + lit_share(*plan.target) : "nothing") +
                         " of the target is lit; the largest rectangle of its shape inside the light is " +
                         described(plan.undistorted) +
                         ": move the target there, or the projector, or choose another throw ratio");
  }
  if (site.text_height && *site.text_height < plan.readable_text_height()) {
    const bool by_pixels = plan.readable_text_height() == plan.text_height_by_pixels;
    diagnostics.warn("text_unreadable",
                     "capitals of " + in_mm(*site.text_height) + " are below the " +
                         in_mm(plan.readable_text_height()) + " that " +
                         (by_pixels ? "nine of the coarsest pixels there need: more pixels or a "
                                      "smaller picture would help"
                                    : "the viewer needs: larger text or a nearer viewer "
                                      "would help"));
  }
  if (plan.depth_of_field && plan.depth_of_field->blur_max_px > 1) {
    const DepthOfField& field = *plan.depth_of_field;
    diagnostics.warn("out_of_focus",
                     "the picture reaches from " + in_metres(field.nearest) + " to " +
                         in_metres(field.farthest) + " of depth, and only " + sharp_depths(field) +
                         " is sharp to a pixel: a corner is blurred over " + fixed(field.blur_max_px, 1) +
                         " px even with the middle in focus; stand straighter before the wall or choose a "
                         "smaller aperture (a larger f-number)");
  }
  if (sheet.f_number.has_value() != sheet.focal_length.has_value())
    diagnostics.note("depth_of_field_unknown",
                     std::string("the depth of field needs the f-number and the focal length, and the ") +
                         (sheet.f_number ? "focal length" : "f-number") +
                         " is missing; makers print them side by side, as in F=2.0, f=14mm");
}

}  // namespace

Points2 WallRectangle::corners() const {
  const double x = 0.5 * size.x(), y = 0.5 * size.y();
  return {centre + Vec2(-x, -y), centre + Vec2(x, -y), centre + Vec2(x, y), centre + Vec2(-x, y)};
}

double ProjectionPlan::readable_text_height() const {
  return std::max(text_height_by_pixels, text_height_by_eye.value_or(0));
}

Projector projector_of(const DataSheet& sheet) {
  if (sheet.resolution.width < 1 || sheet.resolution.height < 1)
    throw Error(ErrorKind::kInput,
                "resolution " + std::to_string(sheet.resolution.width) + "x" +
                    std::to_string(sheet.resolution.height),
                "a picture has at least one pixel", "give width and height in pixels, e.g. 1280x800");
  require_positive("throw ratio", sheet.throw_ratio, "", "give distance over picture width, e.g. 0.8");
  if (!sheet.lens_shift.allFinite())
    throw Error(ErrorKind::kInput, "lens shift", "it is not finite",
                "give picture widths and heights, e.g. 0,0.5");
  if (sheet.lumens) require_positive("light", *sheet.lumens, " lm", "give lumens, e.g. 3000");
  if (sheet.f_number) require_positive("f-number", *sheet.f_number, "", "give the lens' f-number, e.g. 2.0");
  if (sheet.focal_length)
    require_positive("focal length", *sheet.focal_length, " m", "give the lens' focal length, e.g. 14mm");

  Projector projector;
  Camera& lens = projector.inverse_camera;
  lens.size = sheet.resolution;
  lens.distortion = NoDistortion{};
  const Vec2 size(sheet.resolution.width, sheet.resolution.height);
  const Vec2 axis = picture_middle(sheet.resolution) + sheet.lens_shift.cwiseProduct(size);
  const double focal = sheet.throw_ratio * size.x();
  lens.intrinsics = {focal, focal, axis.x(), axis.y(), 0};
  return projector;
}

Pose pose_before_wall(double distance, double yaw, double pitch, double roll) {
  require_positive("distance", distance, " m", "give the lens' distance from the wall, e.g. 1.5m");
  if (!Vec3(yaw, pitch, roll).allFinite())
    throw Error(ErrorKind::kInput, "the projector's angles", "they are not finite",
                "give degrees, e.g. 20deg");
  using Turn = Eigen::AngleAxisd;
  const Eigen::Quaterniond wall_from_projector_rotation =
      Turn(yaw, Vec3::UnitY()) * Turn(pitch, Vec3::UnitX()) * Turn(roll, Vec3::UnitZ());
  return Pose(wall_from_projector_rotation, Vec3(0, 0, -distance)).inverse();
}

std::optional<LightOnWall> light_on_wall(const Projector& projector, const Pose& projector_from_wall,
                                         const Vec2& pixel) {
  const Plane wall = Plane::of_xy(projector_from_wall);
  const std::optional<Vec3> landed = projector.intersect(pixel, wall);
  if (!landed || !(landed->z() > 0)) return std::nullopt;
  const Intrinsics& k = projector.inverse_camera.intrinsics;
  LightOnWall light;
  light.on_wall = (projector_from_wall.inverse() * *landed).head<2>();
  light.depth = landed->z();
  const double cosine = std::abs(wall.normal.dot(landed->normalized()));
  light.incidence_deg = std::acos(std::min(1.0, cosine)) / kDegree;

  const Vec3 d = *landed / landed->z();
  const double closing = wall.normal.dot(d);
  Mat2 metres_by_pixel;
  for (int axis = 0; axis < 2; ++axis) {
    const Vec3 dd = Vec3::Unit(axis) / (axis == 0 ? k.fx : k.fy);
    const Vec3 step = light.depth * (dd - d * (wall.normal.dot(dd) / closing));
    metres_by_pixel.col(axis) = (projector_from_wall.rotation.conjugate() * step).head<2>();
  }
  const Vec2 stretch = singular_values(metres_by_pixel);
  light.mm_per_pixel_max = 1e3 * stretch[0];
  light.mm_per_pixel_min = 1e3 * stretch[1];
  const ImageSize size = projector.size();
  light.lux_per_lumen = 1 / (double(size.width) * double(size.height) * stretch.prod());
  return light;
}

std::vector<PlanFigure> figures_of(const ProjectionPlan& plan) {
  require(plan.corners.size() == 4, "figures_of: a plan without corners");
  const auto side = [&](std::size_t i) {
    return in_metres((plan.corners[(i + 1) % 4] - plan.corners[i]).norm());
  };
  std::vector<PlanFigure> figures = {
      {"picture", "top " + side(0) + ", bottom " + side(2) + ", left " + side(3) + ", right " + side(1)},
      {"mm per pixel",
       significant(plan.mm_per_pixel_min, 3) + " .. " + significant(plan.mm_per_pixel_max, 3)},
      {"incidence", fixed(plan.incidence_deg, 1) + " deg in the middle, " + fixed(plan.incidence_max_deg, 1) +
                        " deg at worst"}};
  if (plan.lux)
    figures.push_back({"illuminance", fixed(plan.lux->middle, 0) + " lux in the middle, " +
                                          fixed(plan.lux->darkest, 0) + " .. " +
                                          fixed(plan.lux->brightest, 0) + " lux"});
  if (plan.depth_of_field) {
    const DepthOfField& field = *plan.depth_of_field;
    figures.push_back({"depth of field", sharp_depths(field) + ", picture " + in_metres(field.nearest) +
                                             " .. " + in_metres(field.farthest) + ", blur at most " +
                                             fixed(field.blur_max_px, 1) + " px"});
  }
  figures.push_back(
      {"readable text", "capitals of " + in_mm(plan.readable_text_height()) + " (by pixels " +
                            in_mm(plan.text_height_by_pixels) +
                            (plan.text_height_by_eye ? ", by eye " + in_mm(*plan.text_height_by_eye) : "") +
                            ")"});
  figures.push_back({"undistorted", described(plan.undistorted) + ", with " +
                                        fixed(100 * plan.undistorted_pixel_share, 0) + " % of the pixels"});
  if (plan.target)
    figures.push_back(
        {"target", described(plan.target->rectangle) + ", " +
                       (plan.target->whole ? "all of it lit" : lit_share(*plan.target) + " lit")});
  return figures;
}

ProjectionPlan plan_projection(const DataSheet& sheet, const Site& site) {
  require_usable(site);
  ProjectionPlan plan;
  plan.projector = projector_of(sheet);
  plan.projector_from_wall = site.projector_from_wall;
  const std::vector<LightOnWall> corners = landed_corners(plan.projector, plan.projector_from_wall);
  // Inside four corners whose rays meet the wall.
  const LightOnWall middle =
      light_on_wall(plan.projector, plan.projector_from_wall, picture_middle(sheet.resolution)).value();

  plan.middle = middle.on_wall;
  plan.incidence_deg = middle.incidence_deg;
  for (const LightOnWall& corner : corners) {
    plan.corners.push_back(corner.on_wall);
    plan.incidence_max_deg = std::max(plan.incidence_max_deg, corner.incidence_deg);
  }
  measure_pixels(plan);
  // Finer than light itself, and the sums below lose their digits.
  if (!(plan.mm_per_pixel_min > 1e-6) || !std::isfinite(plan.mm_per_pixel_max))
    throw Error(ErrorKind::kDegenerate, "the picture", "its pixels have no size that light could have",
                "check the throw ratio, the lens shift and the distance");
  if (sheet.lumens) plan.lux = illuminance(*sheet.lumens, middle, corners);
  if (sheet.f_number && sheet.focal_length)
    plan.depth_of_field = depth_of_field(sheet, plan.projector.inverse_camera.intrinsics.fx, middle, corners);
  const Points2 content = place_rectangles(site.target, plan);
  plan.text_height_by_pixels = kReadablePixels * coarsest_pixel(plan, content);
  if (site.viewer_distance)
    plan.text_height_by_eye = 2 * *site.viewer_distance * std::tan(0.5 * kReadableArcMinutes / 60 * kDegree);
  judge(sheet, site, plan);
  return plan;
}

}  // namespace procam::analyze
