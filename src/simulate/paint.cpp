#include "paint.hpp"

namespace procam::simulate::internal {
namespace {

/// Width of the box along each axis that has the variance of the parallelogram (across, down).
Vec2 box_of(const Vec2& across, const Vec2& down) {
  return Vec2(std::hypot(across.x(), down.x()), std::hypot(across.y(), down.y()));
}

bool is_albedo(double albedo) {
  return albedo >= 0 && albedo <= 1;
}

}  // namespace

PreparedPaint::PreparedPaint(const Body& body) : shape_(&body.shape), front_(side_of(body)), back_(front_) {
  if (body.back_albedo) {
    require(is_albedo(*body.back_albedo),
            "simulate: the back albedo of body '" + body.name + "' is not in 0..1");
    back_ = *body.back_albedo;
  }
}

PreparedPaint::Side PreparedPaint::side_of(const Body& body) {
  if (const auto* picture = std::get_if<Picture>(&body.paint)) {
    require(is_albedo(picture->white) && is_albedo(picture->black),
            "simulate: an albedo of body '" + body.name + "' is not in 0..1");
    return Print{SummedPicture(picture->image), picture->white, picture->black};
  }
  if (const auto* board = std::get_if<PrintedBoard>(&body.paint)) {
    require(std::holds_alternative<Rectangle>(body.shape) || std::holds_alternative<Polygon>(body.shape),
            "simulate: body '" + body.name + "' is not flat and carries a board's print; use a Picture");
    return Paper(*board);
  }
  const double albedo = std::get<double>(body.paint);
  require(is_albedo(albedo), "simulate: the albedo of body '" + body.name + "' is not in 0..1");
  return albedo;
}

double PreparedPaint::albedo(bool front, const Vec3& point, const Vec3& across, const Vec3& down) const {
  const Side& side = front ? front_ : back_;
  if (const auto* paper = std::get_if<Paper>(&side))
    return paper->albedo(point.head<2>(), box_of(across.head<2>(), down.head<2>()));
  if (const auto* print = std::get_if<Print>(&side)) {
    const ShapeUv at = uv_of(*shape_, point);
    const Vec2 texels(print->picture.width(), print->picture.height());
    const Vec2 middle = at.uv.cwiseProduct(texels);
    const Vec2 half = 0.5 * box_of(at.uv_by_point * across, at.uv_by_point * down).cwiseProduct(texels);
    return print->black + (print->white - print->black) * print->picture.mean(middle - half, middle + half);
  }
  return std::get<double>(side);
}

}  // namespace procam::simulate::internal
