#include "fields.hpp"
#include "procam/report/plan.hpp"

namespace procam::report {

static void fields(Fields& f, const analyze::ProjectionPlan::Illuminance& lux) {
  f.field("middle", lux.middle);
  f.field("darkest", lux.darkest);
  f.field("brightest", lux.brightest);
}

static void fields(Fields& f, const analyze::DepthOfField& field) {
  f.field("focus", field.focus);
  f.field("sharp", Vec2(field.near, field.far));
  f.field("picture", Vec2(field.nearest, field.farthest));
  f.field("blur_max_px", field.blur_max_px);
}

static void fields(Fields& f, const analyze::WallRectangle& rectangle) {
  f.field("centre", rectangle.centre);
  f.field("size", rectangle.size);
}

static void fields(Fields& f, const analyze::ProjectionPlan::TargetCoverage& target) {
  fields(f, target.rectangle);
  f.field("covered_share", target.covered_share);
  f.field("whole", target.whole);
}

static void fields(Fields& f, const analyze::ProjectionPlan& plan) {
  const char* const names[] = {"top_left", "top_right", "bottom_right", "bottom_left"};
  f.object("corners", [&](Fields& corners) {
    for (std::size_t i = 0; i < plan.corners.size(); ++i) corners.field(names[i], plan.corners[i]);
  });
  f.field("middle", plan.middle);
  f.field("mm_per_pixel", Vec2(plan.mm_per_pixel_min, plan.mm_per_pixel_max));
  f.field("incidence_deg", plan.incidence_deg);
  f.field("incidence_max_deg", plan.incidence_max_deg);
  f.optional("lux", plan.lux);
  f.optional("depth_of_field", plan.depth_of_field);
  f.object("text_height_mm", [&](Fields& height) {
    height.field("readable", 1e3 * plan.readable_text_height());
    height.field("by_pixels", 1e3 * plan.text_height_by_pixels);
    if (plan.text_height_by_eye) height.field("by_eye", 1e3 * *plan.text_height_by_eye);
  });
  f.field("undistorted", plan.undistorted);
  f.object("undistorted", [&](Fields& inside) { inside.field("pixel_share", plan.undistorted_pixel_share); });
  f.optional("target", plan.target);
}

std::string to_json(const analyze::ProjectionPlan& plan) {
  return text(json(plan));
}

std::vector<std::string> lines(const analyze::ProjectionPlan& plan) {
  std::vector<std::string> lines;
  for (const analyze::PlanFigure& figure : analyze::figures_of(plan))
    lines.push_back(format("%-15s %s", figure.name.c_str(), figure.value.c_str()));
  return lines;
}

}  // namespace procam::report
