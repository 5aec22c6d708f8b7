#include "procam/watch/marks.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "procam/core/geometry/plane.hpp"

namespace procam::watch {
namespace {

/// Content coordinates (u, v) of the marks.
constexpr double kColumns[] = {1 / 11.0, 4 / 11.0, 7 / 11.0, 10 / 11.0}, kRows[] = {1 / 8.0, 0.5, 7 / 8.0};

/// Texture is looked for in a square of kBlocks x kBlocks blocks, a quarter of the mark's diameter each.
constexpr int kBlocks = 12;
/// Smaller eigenvalue of the structure tensor over these blocks, per contrast^2: below it a mark is needed. A mark on grey
/// has about 12.
constexpr double kLittleTexture = 1, kClearTexture = 2;

std::array<Vec2, Marks::kMarksOfSurface> content_places() {
  std::array<Vec2, Marks::kMarksOfSurface> places;
  std::size_t count = 0;
  for (const double v : kRows)
    for (const double u : kColumns) {
      const bool is_inner = v == kRows[1] && (u == kColumns[1] || u == kColumns[2]);
      if (!is_inner) places[count++] = Vec2(u, v);
    }
  return places;
}

/// Content coordinates of a frame's pixel; nullopt where its light does not meet the plane.
std::optional<Vec2> content_at(const PlacedPlane& placed, const Projector& projector, const Vec2& pixel) {
  const std::optional<Ray> ray = projector.emit(pixel);
  if (!ray) return std::nullopt;
  const Ray own = placed.projector_from_surface.inverse() * *ray;
  if (!(std::abs(own.direction.z()) > 1e-9)) return std::nullopt;
  const Vec2 on_plane = own.at(-own.origin.z() / own.direction.z()).head<2>();
  return Vec2((placed.plane_from_content.inverse() * on_plane.homogeneous()).hnormalized());
}

/// Is the content shown there, at full strength?
bool is_shown(const SceneItem& item, const std::optional<Vec2>& content) {
  if (!content || !(content->minCoeff() >= 0) || !(content->maxCoeff() < 1)) return false;
  if (item.mask.empty()) return true;
  constexpr int kOpaque = 250;
  const Vec2 place = content->cwiseProduct(Vec2(item.mask.width, item.mask.height));
  return item.mask.row(int(place.y()))[int(place.x())] >= kOpaque;
}

/// The frame's pixel of a mark's centre; nullopt if the mark is omitted there.
std::optional<Vec2> mark_centre(const SceneItem& item, const Projector& projector, const Vec2& content,
                                double radius) {
  const auto* placed = std::get_if<PlacedPlane>(&item.placement);
  if (placed == nullptr) return std::nullopt;
  const Vec2 on_plane = (placed->plane_from_content * content.homogeneous()).hnormalized();
  const Vec3 point = placed->projector_from_surface * Vec3(on_plane.x(), on_plane.y(), 0);
  const std::optional<Vec2> centre = projector.project(point);
  if (!centre || !centre->allFinite()) return std::nullopt;
  for (const Vec2& side : {Vec2(1, 0), Vec2(0, 1), Vec2(-1, 0), Vec2(0, -1)}) {
    const Vec2 pixel = *centre + radius * side;
    if (!projector.size().contains(pixel)) return std::nullopt;
    if (!is_shown(item, content_at(*placed, projector, pixel))) return std::nullopt;
  }
  return centre;
}

/// Mean of all channels over a block; the block is clamped to the frame.
double block_mean(ViewU8 frame, double x, double y, int side) {
  const int left = std::clamp(int(std::lround(x)), 0, frame.width - side),
            top = std::clamp(int(std::lround(y)), 0, frame.height - side);
  int sum = 0;
  for (int j = top; j < top + side; ++j) {
    const std::uint8_t* in = frame.row(j) + left * frame.channels;
    for (int i = 0; i < side * frame.channels; ++i) sum += in[i];
  }
  return double(sum) / (side * side * frame.channels);
}

/// Smaller eigenvalue of the structure tensor around a mark, sRGB levels^2.
double structure_around(ViewU8 frame, const Vec2& centre, double diameter) {
  const int side = std::max(1, int(diameter / 4));
  if (frame.width < side * kBlocks || frame.height < side * kBlocks) return 0;
  std::array<std::array<double, kBlocks>, kBlocks> grey;
  for (int j = 0; j < kBlocks; ++j)
    for (int i = 0; i < kBlocks; ++i)
      grey[std::size_t(j)][std::size_t(i)] = block_mean(frame, centre.x() + side * (i - kBlocks / 2),
                                                        centre.y() + side * (j - kBlocks / 2), side);
  double xx = 0, xy = 0, yy = 0;
  for (std::size_t j = 1; j + 1 < kBlocks; ++j)
    for (std::size_t i = 1; i + 1 < kBlocks; ++i) {
      const double x = 0.5 * (grey[j][i + 1] - grey[j][i - 1]), y = 0.5 * (grey[j + 1][i] - grey[j - 1][i]);
      xx += x * x, xy += x * y, yy += y * y;
    }
  return 0.5 * (xx + yy) - std::hypot(0.5 * (xx - yy), xy);
}

/// Adds a disc whose quadrants are brighter and darker by `contrast` in turn.
void draw_mark(ImageView<std::uint8_t> frame, const Vec2& centre, double radius, double contrast) {
  const int left = std::max(0, int(std::floor(centre.x() - radius))),
            right = std::min(frame.width - 1, int(std::ceil(centre.x() + radius))),
            top = std::max(0, int(std::floor(centre.y() - radius))),
            bottom = std::min(frame.height - 1, int(std::ceil(centre.y() + radius)));
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x) {
      const Vec2 way = Vec2(x, y) - centre;
      const double disc = std::clamp(radius - way.norm() + 0.5, 0.0, 1.0);
      const double quadrant = std::clamp(2 * way.x(), -1.0, 1.0) * std::clamp(2 * way.y(), -1.0, 1.0);
      std::uint8_t* pixel = frame.row(y) + x * frame.channels;
      for (int c = 0; c < frame.channels; ++c)
        pixel[c] = std::uint8_t(std::lround(std::clamp(pixel[c] + contrast * disc * quadrant, 0.0, 255.0)));
    }
}

}  // namespace

Marks::Marks(const MarkOptions& options) : options_(options) {
  require(options.diameter > 0 && options.diameter < 0.5 && options.contrast > 0 && options.contrast <= 255 &&
              options.fade > 0,
          "Marks: options out of range");
}

void Marks::update(Mark& mark, const Vec2& centre, double seconds, ViewU8 frame) const {
  const double structure = structure_around(frame, centre, options_.diameter * frame.width);
  const double relative = structure / (options_.contrast * options_.contrast);
  if (!mark.is_known) {
    mark = {true, relative < kLittleTexture, relative < kLittleTexture ? 1.0 : 0.0};
    return;
  }
  if (relative < kLittleTexture) mark.is_needed = true;
  if (relative > kClearTexture) mark.is_needed = false;
  const double step = seconds / options_.fade;
  mark.strength = std::clamp(mark.strength + (mark.is_needed ? step : -step), 0.0, 1.0);
}

void Marks::draw(double time, const Scene& scene, const Projector& projector, ImageView<std::uint8_t> frame) {
  static const std::array<Vec2, kMarksOfSurface> places = content_places();
  const double seconds = std::clamp(time - time_, 0.0, options_.fade);
  time_ = time;
  marks_.resize(scene.items.size());
  const double radius = 0.5 * options_.diameter * frame.width;
  for (std::size_t i = 0; i < marks_.size(); ++i)
    for (std::size_t k = 0; k < places.size(); ++k) {
      Mark& mark = marks_[i][k];
      const std::optional<Vec2> centre = mark_centre(scene.items[i], projector, places[k], radius);
      if (!centre) {
        mark = {};
        continue;
      }
      update(mark, *centre, seconds, frame);
      if (mark.strength > 0) draw_mark(frame, *centre, radius, mark.strength * options_.contrast);
    }
}

}  // namespace procam::watch
