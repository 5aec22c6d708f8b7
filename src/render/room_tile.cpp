#include "room_tile.hpp"

#include <cmath>
#include <limits>

namespace procam::render {

namespace {

constexpr float kStep = 0.02f;  ///< share of the distance by which a mesh's depth may jump within one surface
constexpr int kSub = 16;        ///< casts for an edge pixel

/// Their places in the pixel, no two in one row or column.
struct SubPixels {
  double x[kSub], y[kSub];
};
constexpr SubPixels kSubPixels = [] {
  SubPixels places{};
  for (int i = 0; i < kSub; ++i) {
    places.x[i] = (i + 0.5) / kSub - 0.5;
    places.y[i] = (4 * (i % 4) + i / 4 + 0.5) / kSub - 0.5;
  }
  return places;
}();

/// Does item a, at its nearness, lie before item b?
bool before(int a, float nearness_a, int b, float nearness_b) {
  if (std::abs(nearness_a - nearness_b) <= kTogether * std::max(nearness_a, nearness_b)) return a > b;
  return nearness_a > nearness_b;
}

int levels_made(const LightTexture& texture) {
  return texture.levels();
}
int levels_made(const ValueTexture&) {
  return 1;
}

/// Where light grazes, a step of a pixel may pass the horizon: keep to the way there.
void keep_in_front(Footprint& f) {
  const double reach = 0.5 * (std::abs(f.slope_x.z()) + std::abs(f.slope_y.z())), most = 0.9 * f.centre.z();
  if (!(reach > most)) return;
  f.slope_x *= most / reach;
  f.slope_y *= most / reach;
}

/// The i-th of `points` looks at the footprint's middle, in a level of the content.
template <typename Pixel>
void look(const Footprint& f, const TexelsView<Pixel>& level, int i, Points& points) {
  const double inverse = 1 / f.centre.z(), u = f.centre.x() * inverse, v = f.centre.y() * inverse;
  // Far beyond the content nothing changes any more, but floats must hold it.
  const auto held = [](double value) { return float(std::min(std::max(value, -1e6), 1e6)); };
  points.u[i] = held(u * level.width);
  points.v[i] = held(v * level.height);
  points.u_x[i] = held((f.slope_x.x() - u * f.slope_x.z()) * inverse * level.width);
  points.v_x[i] = held((f.slope_x.y() - v * f.slope_x.z()) * inverse * level.height);
  points.u_y[i] = held((f.slope_y.x() - u * f.slope_y.z()) * inverse * level.width);
  points.v_y[i] = held((f.slope_y.y() - v * f.slope_y.z()) * inverse * level.height);
}

}  // namespace

/// Change of the ray by one pixel: half the way between the neighbours, or as far as there are any.
Vec3 RoomTile::slope(int at, int step) const {
  const bool forward = known(at + step), backward = known(at - step);
  const Vec3 difference = ray(forward ? at + step : at) - ray(backward ? at - step : at);
  return forward && backward ? Vec3(0.5 * difference) : difference;
}

Footprint RoomTile::footprint(const Facet& facet, int at) const {
  Footprint f{facet.content_from_direction * ray(at), facet.content_from_direction * slope(at, 1),
              facet.content_from_direction * slope(at, kAcross)};
  keep_in_front(f);
  return f;
}

/// The rays of a piece; at the tile's rim also of the pixel beyond it.
void RoomTile::follow(const LensPiece& piece, const PixelRect& rect) {
  const PixelRect& r = piece.rect;
  const int x0 = r.x0 - (r.x0 == rect.x0), x1 = r.x1 + (r.x1 == rect.x1);
  const int y0 = r.y0 - (r.y0 == rect.y0), y1 = r.y1 + (r.y1 == rect.y1);
  for (int y = y0; y < y1; ++y) {
    const Quadratic3 row = piece.direction_from_pixel.row(r.t(y));
    int at = place(x0 - rect.x0, y - rect.y0);
    for (int x = x0; x < x1; ++x, ++at) {
      const double s = r.s(x);
      const Vec3 d = row[0] + s * (row[1] + s * row[2]);
      x_[at] = float(d.x());
      y_[at] = float(d.y());
      z_[at] = float(d.z());
    }
  }
}

void RoomTile::cast(const RoomLayer& layer, int tile_x, int tile_y, const PixelRect& rect, Hits& hits) {
  std::fill(std::begin(hits.nearness), std::end(hits.nearness), 0.0f);
  std::fill(std::begin(hits.facet), std::end(hits.facet), -1);
  for (const FacetBox& box : layer.boxes(tile_x, tile_y)) {
    const Facet& f = layer.facets()[std::size_t(box.facet)];
    const int x0 = std::max(box.x0, rect.x0) - rect.x0 - 1, x1 = std::min(box.x1, rect.x1) - rect.x0 + 1;
    const int y0 = std::max(box.y0, rect.y0) - rect.y0 - 1, y1 = std::min(box.y1, rect.y1) - rect.y0 + 1;
    const auto& b = f.borders;
    const auto& n = f.nearness;
    for (int y = y0; y < y1; ++y) {
      const int begin = place(x0, y), end = place(x1, y);
      for (int at = begin; at < end; ++at) {  // without a branch, for vectors; NaN compares false
        const float x = x_[at], down = y_[at], z = z_[at];
        const float e0 = b[0][0] * x + b[0][1] * down + b[0][2] * z,
                    e1 = b[1][0] * x + b[1][1] * down + b[1][2] * z,
                    e2 = b[2][0] * x + b[2][1] * down + b[2][2] * z,
                    e3 = b[3][0] * x + b[3][1] * down + b[3][2] * z;
        const float nearness = n[0] * x + n[1] * down + n[2] * z;
        const bool nearer = (e0 >= 0) & (e1 >= 0) & (e2 >= 0) & (e3 >= 0) & (nearness > hits.nearness[at]);
        hits.nearness[at] = nearer ? nearness : hits.nearness[at];
        hits.facet[at] = nearer ? box.facet : hits.facet[at];
      }
    }
  }
}

void RoomTile::nearest_first(std::vector<Fragment>& fragments) {  // a handful
  for (std::size_t i = 1; i < fragments.size(); ++i)
    for (std::size_t j = i; j > 0 && before(fragments[j].item, fragments[j].nearness, fragments[j - 1].item,
                                            fragments[j - 1].nearness);
         --j)
      std::swap(fragments[j], fragments[j - 1]);
}

/// Do the pixel's neighbours see the same surfaces in the same order?
template <typename Texture>
bool RoomTile::is_even(const std::vector<RoomItem<Texture>>& items, int at) const {
  for (const int step : {-kAcross - 1, -kAcross, -kAcross + 1, -1, 1, kAcross - 1, kAcross, kAcross + 1}) {
    const int other = at + step;
    if (!known(other)) continue;
    for (std::size_t a = 0; a < items.size(); ++a) {
      const std::int32_t mine = hits_[a].facet[at], its = hits_[a].facet[other];
      if ((mine < 0) != (its < 0)) return false;
      if (mine < 0) continue;
      const float nearness = hits_[a].nearness[at], its_nearness = hits_[a].nearness[other];
      if (mine != its) {
        // The same smooth surface, or one part of it before another?
        const float expected = along(items[a].layer->facets()[std::size_t(mine)].nearness, ray(other));
        if (!(std::abs(expected - its_nearness) <= kStep * its_nearness)) return false;
      }
      for (std::size_t b = 0; b < a; ++b)
        if (hits_[b].facet[at] >= 0 && hits_[b].facet[other] >= 0 &&
            before(int(a), nearness, int(b), hits_[b].nearness[at]) !=
                before(int(a), its_nearness, int(b), hits_[b].nearness[other]))
          return false;
    }
  }
  return true;
}

template <typename Texture>
void RoomTile::draw_edge(const std::vector<RoomItem<Texture>>& items, int x, int y, bool area,
                         const Kernels& kernels, Tile<typename Texture::Pixel>& tile) {
  using Pixel = typename Texture::Pixel;
  const int at = place(x, y);
  const Vec3 centre = ray(at), right = slope(at, 1), down = slope(at, kAcross);
  candidates_.clear();
  for (std::size_t a = 0; a < items.size(); ++a)
    for (const FacetBox& box : items[a].layer->boxes(tile.x, tile.y))
      if (x + tile.rect.x0 >= box.x0 && x + tile.rect.x0 < box.x1 && y + tile.rect.y0 >= box.y0 &&
          y + tile.rect.y0 < box.y1)
        candidates_.push_back({int(a), box.facet, 0});

  // What each sub-pixel meets, nearest first. Each facet is looked at once, about the middle of where it is
  // met.
  struct Shown {
    int item, facet, count;
    Vec2 sum;
    Pixel light[4];
  };
  constexpr std::size_t kMost = 24;  // more facets than that in one pixel: the rest are left out
  Shown shown[kMost];
  std::size_t shown_count = 0;
  std::uint8_t order[kSub][kMost];
  std::size_t met[kSub] = {};
  for (std::size_t k = 0; k < kSub; ++k) {
    const Vec2 where(kSubPixels.x[k], kSubPixels.y[k]);
    const Vec3 d = centre + where.x() * right + where.y() * down;
    fragments_.clear();
    for (const Fragment& candidate : candidates_) {
      const Facet& facet = items[std::size_t(candidate.item)].layer->facets()[std::size_t(candidate.facet)];
      if (!meets(facet, d)) continue;
      const Fragment fragment{candidate.item, candidate.facet, along(facet.nearness, d)};
      if (fragments_.empty() || fragments_.back().item != fragment.item)
        fragments_.push_back(fragment);
      else if (fragment.nearness > fragments_.back().nearness)
        fragments_.back() = fragment;
    }
    nearest_first(fragments_);
    for (const Fragment& f : fragments_) {
      std::size_t i = 0;
      while (i < shown_count && (shown[i].item != f.item || shown[i].facet != f.facet)) ++i;
      if (i == kMost) continue;
      if (i == shown_count) shown[shown_count++] = {f.item, f.facet, 0, Vec2::Zero(), {}};
      shown[i].sum += where;
      ++shown[i].count;
      order[k][met[k]++] = std::uint8_t(i);
    }
  }
  for (std::size_t i = 0; i < shown_count; ++i) {
    Shown& s = shown[i];
    const RoomItem<Texture>& item = items[std::size_t(s.item)];
    const Facet& facet = item.layer->facets()[std::size_t(s.facet)];
    const Vec2 where = s.sum / s.count;
    Footprint f{facet.content_from_direction * (centre + where.x() * right + where.y() * down),
                facet.content_from_direction * right, facet.content_from_direction * down};
    keep_in_front(f);
    Taps taps;
    if (area) {
      const TexelsView<Pixel> finest = item.texture->level(0);
      const PixelSize size = pixel_size(f, Vec2::Zero(), {finest.width, finest.height});
      taps = choose_taps(size, size, size, levels_made(*item.texture));
    }
    Points points;
    Pixel drawn[4 * kLanes];
    const TexelsView<Pixel> level = item.texture->level(taps.level);
    look(f, level, 0, points);
    sample(kernels, level, taps, points, 0, 1, drawn);
    if (item.mask) {
      Pixel alpha[4 * kLanes];
      Taps mask_taps;
      if (area) {
        const TexelsView<Pixel> finest = item.mask->level(0);
        const PixelSize size = pixel_size(f, Vec2::Zero(), {finest.width, finest.height});
        mask_taps = choose_taps(size, size, size, levels_made(*item.mask));
      }
      const TexelsView<Pixel> mask_level = item.mask->level(mask_taps.level);
      look(f, mask_level, 0, points);
      sample(kernels, mask_level, mask_taps, points, 0, 1, alpha);
      give_alpha(alpha, 1, drawn);
    }
    std::copy_n(drawn, 4, s.light);
  }
  Pixel* const there = tile.row(y) + 4 * x;
  int sum[4] = {};
  for (std::size_t k = 0; k < kSub; ++k) {
    Pixel light[4];
    std::copy_n(there, 4, light);
    for (std::size_t i = met[k]; i > 0; --i) over(kernels, shown[order[k][i - 1]].light, 1, light);
    for (int c = 0; c < 4; ++c) sum[c] += light[c];
  }
  for (int c = 0; c < 4; ++c) there[c] = Pixel((sum[c] + kSub / 2) / kSub);
}

/// How the pixels of a block look at an item's content: the same samples for all of them. At a curved
/// surface's limb a few pixels hold very much of it; they may alias a little, rather than blur the others.
template <typename Texture>
Taps RoomTile::taps_of(const RoomLayer& layer, const Texture& texture, const Hits& hits,
                       const PixelRect& block) const {
  constexpr double kMostOfTypical = 9;  // squared sides
  const TexelsView<typename Texture::Pixel> content = texture.level(0);
  PixelSize finest, largest, typical;
  double log_xx = 0, log_yy = 0;
  int count = 0;
  for (int y = block.y0; y < block.y1; y += 3)
    for (int x = block.x0 + y % 3; x < block.x1; x += 3) {
      const int at = place(x, y);
      if (hits.facet[at] < 0) continue;
      const Footprint f = footprint(layer.facets()[std::size_t(hits.facet[at])], at);
      const PixelSize size = pixel_size(f, Vec2::Zero(), {content.width, content.height});
      if (count++ == 0) finest = largest = size;
      finest.narrow_squared = std::min(finest.narrow_squared, size.narrow_squared);
      largest.xx = std::max(largest.xx, size.xx);
      largest.yy = std::max(largest.yy, size.yy);
      log_xx += std::log(std::max(size.xx, 1e-12));
      log_yy += std::log(std::max(size.yy, 1e-12));
    }
  if (count == 0) return {};
  typical.xx = std::exp(log_xx / count);
  typical.yy = std::exp(log_yy / count);
  largest.xx = std::min(largest.xx, kMostOfTypical * typical.xx);
  largest.yy = std::min(largest.yy, kMostOfTypical * typical.yy);
  return choose_taps(typical, finest, largest, levels_made(texture));
}

/// The even pixels of a row; the others are marked in `edge`.
template <typename Texture>
void RoomTile::draw_row(const std::vector<RoomItem<Texture>>& items, int y, const bool (&edge)[kTileWidth],
                        const Kernels& kernels, Tile<typename Texture::Pixel>& tile) {
  using Pixel = typename Texture::Pixel;
  const int width = tile.rect.width(), items_count = int(items.size());
  const auto is_visible = [&](int a, int at) {
    if (hits_[std::size_t(a)].facet[at] < 0) return false;
    for (int b = 0; b < items_count; ++b)
      if (b != a && items[std::size_t(b)].opaque() && hits_[std::size_t(b)].facet[at] >= 0 &&
          before(b, hits_[std::size_t(b)].nearness[at], a, hits_[std::size_t(a)].nearness[at]))
        return false;
    return true;
  };
  std::vector<Pixel>& drawn = drawn_pixels<Pixel>();
  drawn.resize(items.size() * kRowRoom * 4);
  Points points;
  for (int a = 0; a < items_count; ++a) {
    const RoomItem<Texture>& item = items[std::size_t(a)];
    // From left to right: samples are written in whole groups, beyond the block's end as well.
    for (int block = 0; block * kBlock < width; ++block) {
      const Taps& taps = taps_[std::size_t(a * kBlocks + block)];
      const TexelsView<Pixel> level = item.texture->level(taps.level);
      int begin = width, end = 0;
      for (int x = block * kBlock; x < std::min((block + 1) * kBlock, width); ++x) {
        const int at = place(x, y);
        if (edge[x] || !is_visible(a, at)) {
          points.u[x] = points.v[x] = points.u_x[x] = points.v_x[x] = points.u_y[x] = points.v_y[x] = 0;
          continue;
        }
        begin = std::min(begin, x);
        end = x + 1;
        look(footprint(item.layer->facets()[std::size_t(hits_[std::size_t(a)].facet[at])], at), level, x,
             points);
      }
      if (begin >= end) continue;
      Pixel* const to = drawn.data() + (std::size_t(a) * kRowRoom + std::size_t(begin)) * 4;
      sample(kernels, level, taps, points, begin, end - begin, to);
      if (!item.mask) continue;
      const Taps& mask_taps = mask_taps_[std::size_t(a * kBlocks + block)];
      const TexelsView<Pixel> mask_level = item.mask->level(mask_taps.level);
      for (int x = begin; x < end; ++x)
        if (const int at = place(x, y); !edge[x] && is_visible(a, at))
          look(footprint(item.layer->facets()[std::size_t(hits_[std::size_t(a)].facet[at])], at), mask_level,
               x, points);
      Pixel alpha[kRowRoom * 4];
      sample(kernels, mask_level, mask_taps, points, begin, end - begin, alpha);
      give_alpha(alpha, end - begin, to);
    }
  }
  for (int x = 0; x < width; ++x) {
    if (edge[x]) continue;
    const int at = place(x, y);
    fragments_.clear();
    for (int a = 0; a < items_count; ++a)
      if (is_visible(a, at)) fragments_.push_back({a, 0, hits_[std::size_t(a)].nearness[at]});
    nearest_first(fragments_);
    Pixel* const there = tile.row(y) + 4 * x;
    for (std::size_t i = fragments_.size(); i > 0; --i) {
      const auto a = std::size_t(fragments_[i - 1].item);
      const Pixel* const from = drawn.data() + (a * kRowRoom + std::size_t(x)) * 4;
      if (items[a].opaque())
        std::copy_n(from, 4, there);
      else
        over(kernels, from, 1, there);
    }
  }
}

template <typename Texture>
void RoomTile::draw(const std::vector<RoomItem<Texture>>& items, const std::vector<LensPiece>& pieces,
                    bool area, const Kernels& kernels, Tile<typename Texture::Pixel>& tile) {
  std::fill(std::begin(x_), std::end(x_), std::numeric_limits<float>::quiet_NaN());
  for (const LensPiece& piece : pieces) follow(piece, tile.rect);
  if (hits_.size() < items.size()) hits_.resize(items.size());
  for (std::size_t a = 0; a < items.size(); ++a) cast(*items[a].layer, tile.x, tile.y, tile.rect, hits_[a]);
  taps_.assign(items.size() * kBlocks, {});
  mask_taps_.assign(items.size() * kBlocks, {});
  for (int y = 0; y < tile.rect.height(); ++y) {
    if (area && y % kStrip == 0)
      for (std::size_t a = 0; a < items.size(); ++a)
        for (int block = 0; block * kBlock < tile.rect.width(); ++block) {
          const RoomItem<Texture>& item = items[a];
          const std::size_t n = a * kBlocks + std::size_t(block);
          const PixelRect pixels{block * kBlock, y, std::min((block + 1) * kBlock, tile.rect.width()),
                                 std::min(y + kStrip, tile.rect.height())};
          taps_[n] = taps_of(*item.layer, *item.texture, hits_[a], pixels);
          if (item.mask) mask_taps_[n] = taps_of(*item.layer, *item.mask, hits_[a], pixels);
        }
    bool edge[kTileWidth] = {};
    for (int x = 0; x < tile.rect.width(); ++x) edge[x] = known(place(x, y)) && !is_even(items, place(x, y));
    draw_row(items, y, edge, kernels, tile);
    for (int x = 0; x < tile.rect.width(); ++x)
      if (edge[x]) draw_edge(items, x, y, area, kernels, tile);
  }
}

template void RoomTile::draw(const std::vector<RoomItem<LightTexture>>&, const std::vector<LensPiece>&, bool,
                             const Kernels&, Tile<Light>&);
template void RoomTile::draw(const std::vector<RoomItem<ValueTexture>>&, const std::vector<LensPiece>&, bool,
                             const Kernels&, Tile<Value>&);

}  // namespace procam::render
