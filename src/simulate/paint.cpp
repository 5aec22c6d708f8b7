#include "paint.hpp"

namespace procam::simulate::internal {
namespace {

/// Width of the box along each axis that has the variance of the parallelogram (across, down).
Vec2 box_of(const Vec2& across, const Vec2& down) {
  return Vec2(std::sqrt(across.x() * across.x() + down.x() * down.x()),
              std::sqrt(across.y() * across.y() + down.y() * down.y()));
}

ImageU8 channel_of(const ImageU8& image, int channel) {
  ImageU8 one(image.size());
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) one.at(x, y) = image.at(x, y, channel);
  return one;
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
  if (const auto* picture = std::get_if<Texture>(&body.paint)) {
    require(is_albedo(picture->white) && is_albedo(picture->black),
            "simulate: an albedo of body '" + body.name + "' is not in 0..1");
    const int channels = picture->image.channels();
    require(channels == 1 || channels == 3,
            "simulate: the picture of body '" + body.name + "' has neither one channel nor three");
    Print print{{}, picture->white, picture->black};
    for (int c = 0; c < channels; ++c) print.channels.emplace_back(channel_of(picture->image, c));
    return print;
  }
  if (const auto* board = std::get_if<PrintedBoard>(&body.paint)) {
    require(std::holds_alternative<Rectangle>(body.shape) || std::holds_alternative<Polygon>(body.shape),
            "simulate: body '" + body.name + "' is not flat and carries a board's print; use a Texture");
    return Paper(*board);
  }
  const double albedo = std::get<double>(body.paint);
  require(is_albedo(albedo), "simulate: the albedo of body '" + body.name + "' is not in 0..1");
  return albedo;
}

bool PreparedPaint::is_coloured() const {
  const auto coloured = [](const Side& side) {
    const auto* print = std::get_if<Print>(&side);
    return print != nullptr && print->channels.size() > 1;
  };
  return coloured(front_) || coloured(back_);
}

Bands PreparedPaint::albedo(bool front, const Spot& spot, const Footprint& share) const {
  const Side& side = front ? front_ : back_;
  const auto without_colour = [](double albedo) { return Bands{albedo, albedo, albedo}; };
  if (const auto* paper = std::get_if<Paper>(&side))
    return without_colour(
        paper->albedo(spot.point.head<2>(), box_of(share.across.head<2>(), share.down.head<2>())));
  if (const auto* print = std::get_if<Print>(&side)) {
    const ShapeUv at = uv_of(*shape_, spot);
    const Vec2 texels(print->channels[0].width(), print->channels[0].height());
    const Vec2 middle = at.uv.cwiseProduct(texels);
    const Vec2 half =
        0.5 * box_of(at.uv_by_point * share.across, at.uv_by_point * share.down).cwiseProduct(texels);
    const auto in = [&](std::size_t channel) {
      return print->black +
             (print->white - print->black) * print->channels[channel].mean(middle - half, middle + half);
    };
    return print->channels.size() == 1 ? without_colour(in(0)) : Bands{in(0), in(1), in(2)};
  }
  return without_colour(std::get<double>(side));
}

}  // namespace procam::simulate::internal
