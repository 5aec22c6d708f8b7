#include "lens_map.hpp"

#include <Eigen/LU>
#include <optional>

#include "procam/render/cpu.hpp"

namespace procam::render {

namespace {

std::optional<Vec3> direction(const Projector& projector, const Vec2& pixel) {
  const std::optional<Ray> ray = projector.emit(pixel);
  if (!ray) return std::nullopt;
  return ray->direction;
}

/// Largest distance, in pixels, between a pixel and where the lens model sends the patch's direction for it,
/// is within the tolerance.
bool faithful(const Projector& projector, const PixelRect& rect, const Patch& patch) {
  // A cubic remainder s^3 - s is largest at 1/sqrt(3); on the borders and on the middle lines as well.
  constexpr double kWorst = 0.57735;
  for (const double t : {-1.0, -kWorst, 0.0, kWorst, 1.0})
    for (const double s : {-1.0, -kWorst, 0.0, kWorst, 1.0}) {
      if (std::abs(s) != kWorst && std::abs(t) != kWorst) continue;  // a node: exact
      const std::optional<Vec2> pixel = projector.project(patch.at(s, t));
      if (!pixel || !((*pixel - rect.pixel(s, t)).norm() < kLensTolerancePx)) return false;
    }
  return true;
}

/// One pixel, linear: from its centre and the middles of its four sides.
void add_single(const Projector& projector, const PixelRect& rect, std::vector<LensPiece>& pieces) {
  const auto centre = direction(projector, rect.pixel(0, 0));
  const auto left = direction(projector, rect.pixel(-1, 0)), right = direction(projector, rect.pixel(1, 0));
  const auto top = direction(projector, rect.pixel(0, -1)), bottom = direction(projector, rect.pixel(0, 1));
  if (!centre || !left || !right || !top || !bottom) return;
  Patch patch;
  for (Quadratic3& row : patch.c) row.fill(Vec3::Zero());
  patch.c[0][0] = *centre;
  patch.c[0][1] = 0.5 * (*right - *left);
  patch.c[1][0] = 0.5 * (*bottom - *top);
  pieces.push_back({rect, patch});
}

void add(const Projector& projector, const PixelRect& rect, std::vector<LensPiece>& pieces) {
  if (rect.width() <= 0 || rect.height() <= 0) return;
  if (rect.width() == 1 && rect.height() == 1) return add_single(projector, rect, pieces);
  std::array<Vec3, 9> nodes;
  int known = 0;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i)
      if (const auto d = direction(projector, rect.pixel(i - 1, j - 1))) {
        nodes[std::size_t(3 * j + i)] = *d;
        ++known;
      }
  if (known == 0) return;  // beyond the lens model
  if (known == 9) {
    const Patch patch = Patch::through(nodes);
    if (faithful(projector, rect, patch)) {
      pieces.push_back({rect, patch});
      return;
    }
  }
  const int x = (rect.x0 + rect.x1) / 2, y = (rect.y0 + rect.y1) / 2;
  add(projector, {rect.x0, rect.y0, x, y}, pieces);
  add(projector, {x, rect.y0, rect.x1, y}, pieces);
  add(projector, {rect.x0, y, x, rect.y1}, pieces);
  add(projector, {x, y, rect.x1, rect.y1}, pieces);
}

void add_tile(const Projector& projector, const PixelRect& rect, std::vector<LensPiece>& pieces) {
  if (std::holds_alternative<NoDistortion>(projector.inverse_camera.distortion)) {
    const Mat3 normalized_from_pixel = projector.inverse_camera.intrinsics.matrix().inverse();
    pieces.push_back({rect, normalized_from_pixel * Patch::of_pixels(rect)});
  } else {
    // As large as pieces usefully are.
    for (int x = rect.x0; x < rect.x1; x += 2 * kTileHeight)
      add(projector, {x, rect.y0, std::min(x + 2 * kTileHeight, rect.x1), rect.y1}, pieces);
  }
}

bool same(const Projector& a, const Projector& b) {
  const Camera &p = a.inverse_camera, &q = b.inverse_camera;
  return p.size == q.size && p.intrinsics.to_array() == q.intrinsics.to_array() &&
         p.distortion.index() == q.distortion.index() &&
         std::visit(
             [&](const auto& model) {
               return model.coefficients ==
                      std::get<std::decay_t<decltype(model)>>(q.distortion).coefficients;
             },
             p.distortion);
}

}  // namespace

bool LensMap::update(const Projector& projector, Workers& workers) {
  if (!pieces_.empty() && same(projector, projector_)) return false;
  projector_ = projector;
  const TileGrid tiles = grid();
  pieces_.resize(std::size_t(tiles.across() * tiles.down()));
  workers.run(tiles.down(), [&](int y) {
    for (int x = 0; x < tiles.across(); ++x) {
      std::vector<LensPiece>& pieces = pieces_[std::size_t(y * tiles.across() + x)];
      pieces.clear();
      add_tile(projector, tiles.tile(x, y), pieces);
    }
  });
  return true;
}

}  // namespace procam::render
