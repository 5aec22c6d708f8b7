#include "plane_layer.hpp"

#include <limits>
#include <utility>

namespace procam::render {

namespace {

constexpr std::uint8_t kOutside = 0, kTouched = 1, kFilled = 2;

Footprint footprint_at(const Patch& q, const PixelRect& rect, int x, int y) {
  const double s = rect.s(x), ds = 2.0 / rect.width(), dt = 2.0 / rect.height();
  const Quadratic3 row = q.row(rect.t(y)), down = q.row_slope(rect.t(y));
  return {row[0] + s * (row[1] + s * row[2]), ds * (row[1] + 2 * s * row[2]),
          dt * (down[0] + s * (down[1] + s * down[2]))};
}

/// Within [-1, 1]; NaN too.
double limited(double x) {
  return x > -1 ? std::min(x, 1.0) : -1;
}

/// How far inside each border (u = 0, u = 1, v = 0, v = 1) a pixel's furthest and nearest corners are: the
/// combinations q_x, q_z - q_x, q_y, q_z - q_y, positive inside.
struct Margins {
  float low[4], high[4];
};

/// Those of a row's pixels.
class RowMargins {
 public:
  explicit RowMargins(const RowMap& row) : s0_(row.s0), ds_(row.ds) {
    const auto combine = [](const float(&of)[12], float(&to)[3][4]) {
      for (int power = 0; power < 3; ++power) {
        const float* from = of + 3 * power;
        to[power][0] = from[0];
        to[power][1] = from[2] - from[0];
        to[power][2] = from[1];
        to[power][3] = from[2] - from[1];
      }
    };
    combine(row.q, q_);
    combine(row.down, down_);
    square_term_ = std::fabs(row.q[6]) + std::fabs(row.q[7]) + std::fabs(row.q[8]);
  }

  Margins at(int i) const {
    const float s = s0_ + float(i) * ds_;
    Margins margins;
    for (int k = 0; k < 4; ++k) {
      const float value = q_[0][k] + s * (q_[1][k] + s * q_[2][k]);
      const float right = ds_ * (q_[1][k] + 2 * s * q_[2][k]);
      const float down = down_[0][k] + s * (down_[1][k] + s * down_[2][k]);
      const float reach = 0.5f * (std::fabs(right) + std::fabs(down));
      margins.low[k] = value - reach;
      margins.high[k] = value + reach;
    }
    return margins;
  }

  /// How far margins of `count` pixels may leave the line between those of the first and the last.
  float bend(int count) const {
    // A quadratic leaves the line between two ends by at most a quarter of its square term times the squared
    // distance; margins combine two of three, and the slopes in them bend less.
    const float step = count > 1 ? ds_ * float(count) : 0;
    return step * step * square_term_;
  }

 private:
  float s0_, ds_, square_term_;
  float q_[3][4], down_[3][4];
};

/// Are pixels with margins between a and b, give or take `bend`, all outside, all filled, or touched (some
/// may be)?
std::uint8_t class_of(const Margins& a, const Margins& b, float bend) {
  // All four without a branch, in one vector.
  int outside = 0, filled = 1;
  for (int k = 0; k < 4; ++k) {
    outside |= !(std::max(a.high[k], b.high[k]) + bend > 0);
    filled &= std::min(a.low[k], b.low[k]) - bend >= 0;
  }
  return outside != 0 ? kOutside : filled != 0 ? kFilled : kTouched;
}

/// Of a tile's row.
struct RowClasses {
  RowBits touched, filled;  ///< what is filled is touched as well

  void set(int begin, int end, std::uint8_t all) {
    if (all >= kTouched) touched.set(begin, end);
    if (all == kFilled) filled.set(begin, end);
  }
};

/// Pixels [begin, end) of a row, whose ends have these margins: all together where nothing happens between
/// the ends, else half by half.
void classify(const RowMargins& row, int begin, int end, const Margins& at_begin, const Margins& at_end,
              RowClasses& classes) {
  const std::uint8_t all = class_of(at_begin, at_end, row.bend(end - begin));
  if (all != kTouched || end - begin == 1) return classes.set(begin, end, all);
  const int middle = (begin + end) / 2;
  const bool two = end - begin == 2;
  classify(row, begin, middle, at_begin, two ? at_begin : row.at(middle - 1), classes);
  classify(row, middle, end, two ? at_end : row.at(middle), at_end, classes);
}

void classify_row(const RowMargins& row, int begin, int end, RowClasses& classes) {
  classify(row, begin, end, row.at(begin), row.at(end - 1), classes);
}

}  // namespace

RowMap PlaneLayer::Piece::row(int y, const float (&scale)[12], bool slopes) const {
  const float t = t0 + float(y) * dt;
  RowMap map;
  map.s0 = s0;
  map.ds = ds;
  for (int n = 0; n < 12; ++n) map.q[n] = scale[n] * (q[0][n] + t * (q[1][n] + t * q[2][n]));
  if (slopes)
    for (int n = 0; n < 12; ++n) map.down[n] = scale[n] * dt * (q[1][n] + 2 * t * q[2][n]);
  return map;
}

bool PlaneLayer::update(const PlaneView& view, const LensMap& lens, bool same_lens, bool area,
                        Workers& workers) {
  if (same_lens && !bands_.empty() && view == view_) return false;
  view_ = view;
  bands_.resize(std::size_t(lens.grid().down()));
  workers.run(lens.grid().down(), [&](int y) { make_band(y, lens, area); });
  return true;
}

int PlaneLayer::levels_of_taps(std::array<FilterGrid, kTileHeight / kStrip> MapTile::*taps_of) const {
  int coarsest = 0;
  for (const Band& band : bands_)
    for (const MapTile& tile : band.tiles)
      for (const FilterGrid& taps : tile.*taps_of) coarsest = std::max(coarsest, taps.level);
  return coarsest + 1;
}

bool PlaneLayer::overlaps(const PlaneLayer& other, int tile_x, int tile_y) const {
  const MapTile *a = map_tile(tile_x, tile_y), *b = other.map_tile(tile_x, tile_y);
  if (!a || !b) return false;
  const auto meet = [](int begin, int end, int other_begin, int other_end) {
    return std::max(begin, other_begin) < std::min(end, other_end);
  };
  for (std::size_t y = 0; y < a->spans.size(); ++y) {
    const Span &p = a->spans[y], &q = b->spans[y];
    if (meet(p.full_begin, p.full_end, q.begin, q.end) || meet(p.begin, p.end, q.full_begin, q.full_end))
      return true;
  }
  return false;
}

void PlaneLayer::make_band(int y, const LensMap& lens, bool area) {
  Band& band = bands_[std::size_t(y)];
  band.tiles.clear();
  band.pieces.clear();
  band.border.clear();
  for (int x = 0; x < lens.grid().across(); ++x) {
    const PixelRect rect = lens.grid().tile(x, y);
    MapTile tile;
    if (view_.through_lens) {
      const std::vector<LensPiece>& pieces = lens.pieces(x, y);
      tile = make_tile(rect, pieces.data(), pieces.size(), area, band);
    } else {
      const LensPiece pixels{rect, Patch::of_pixels(rect)};
      tile = make_tile(rect, &pixels, 1, area, band);
    }
    if (band.tiles.empty() && !tile.drawn) continue;
    if (band.tiles.empty()) band.first = x;
    band.tiles.push_back(tile);
  }
  while (!band.tiles.empty() && !band.tiles.back().drawn) band.tiles.pop_back();
}

bool PlaneLayer::add_piece(const LensPiece& of_lens, const PixelRect& tile, Band& band) const {
  const Patch q = view_.content_from_direction * of_lens.direction_from_pixel;
  // How far inside each border, as Margins: bounds over the piece.
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Eigen::Array4d low = Eigen::Array4d::Constant(kFar), high = -low;
  for (const Vec3& b : q.bernstein()) {
    const Eigen::Array4d inside(b.x(), b.z() - b.x(), b.y(), b.z() - b.y());
    low = low.min(inside);
    high = high.max(inside);
  }
  const bool filled = (low > 0).all(), outside = !(high > 0).all();
  if (outside) return false;
  Piece piece;
  const PixelRect& r = of_lens.rect;
  piece.rect = {r.x0 - tile.x0, r.y0 - tile.y0, r.x1 - tile.x0, r.y1 - tile.y0};
  for (std::size_t j = 0; j < 3; ++j)
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) piece.q[j][3 * i + k] = float(q.c[j][i][Eigen::Index(k)]);
  piece.s0 = float(piece.rect.s(0));
  piece.ds = 2.0f / float(piece.rect.width());
  piece.t0 = float(piece.rect.t(0));
  piece.dt = 2.0f / float(piece.rect.height());
  band.pieces.push_back(piece);
  band.drawn.push_back({q, piece.rect, filled});
  return filled;
}

Footprint PlaneLayer::drawn_at(const std::vector<DrawnPiece>& drawn, int x, int y) {
  for (const DrawnPiece& d : drawn)
    if (x >= d.rect.x0 && x < d.rect.x1 && y >= d.rect.y0 && y < d.rect.y1)
      return footprint_at(d.q, d.rect, x, y);
  return {Vec3(0.5, 0.5, 1), Vec3::Zero(), Vec3::Zero()};  // between pieces: nothing is drawn
}

void PlaneLayer::find_spans(const PixelRect& rect, MapTile& tile, Band& band) {
  constexpr float kScale[12] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  std::array<RowClasses, kTileHeight> classes;
  for (std::size_t n = 0; n < band.drawn.size(); ++n) {
    const PixelRect& r = band.drawn[n].rect;
    for (int y = r.y0; y < r.y1; ++y) {
      RowClasses& row = classes[std::size_t(y)];
      if (band.drawn[n].filled)
        row.set(r.x0, r.x1, kFilled);
      else
        classify_row(RowMargins(band.pieces[tile.first_piece + n].row(y, kScale, true)), r.x0, r.x1, row);
    }
  }
  for (int y = 0; y < rect.height(); ++y) {
    const RowClasses& row = classes[std::size_t(y)];
    const int width = rect.width(), begin = row.touched.first(0, width);
    if (begin == width) continue;
    const int end = row.touched.end(), full_begin = row.filled.first(begin, end),
              full_end = (~row.filled).first(full_begin, end);
    tile.drawn = true;
    tile.spans[std::size_t(y)] = {std::uint16_t(begin), std::uint16_t(end), std::uint16_t(full_begin),
                                  std::uint16_t(full_end), std::uint32_t(band.border.size())};
    for (const auto& [first, last] : {std::pair(begin, full_begin), std::pair(full_end, end)})
      for (int x = first; x < last; ++x)
        band.border.push_back(
            Light(row.touched[x] ? std::lround(kFull * coverage(drawn_at(band.drawn, x, y)).area) : 0));
  }
}

void PlaneLayer::choose_strips(const MapTile& tile, const std::vector<DrawnPiece>& drawn, int height,
                               ImageSize content, std::array<FilterGrid, kTileHeight / kStrip>& taps) {
  const int levels = levels_of(content);
  for (int strip = 0; strip * kStrip < height; ++strip) {
    PixelSize finest, largest, typical;
    bool any = false;
    const int y0 = strip * kStrip, y1 = std::min(y0 + kStrip, height) - 1;
    for (const int y : {y0, y1, (y0 + y1) / 2}) {
      const Span& span = tile.spans[std::size_t(y)];
      if (span.begin == span.end) continue;
      for (const int x : {int(span.begin), span.end - 1, (span.begin + span.end) / 2}) {
        const Footprint f = drawn_at(drawn, x, y);
        if (!(f.centre.z() > 0)) continue;
        typical = pixel_size(f, Vec2::Zero(), content);
        if (!any) finest = largest = typical;
        any = true;
        finest.narrow_squared = std::min(finest.narrow_squared, typical.narrow_squared);
        largest.xx = std::max(largest.xx, typical.xx);
        largest.yy = std::max(largest.yy, typical.yy);
      }
    }
    if (any) taps[std::size_t(strip)] = choose_taps(typical, finest, largest, levels);
  }
}

PlaneLayer::MapTile PlaneLayer::make_tile(const PixelRect& rect, const LensPiece* pieces, std::size_t count,
                                          bool area, Band& band) {
  MapTile tile;
  tile.first_piece = std::uint32_t(band.pieces.size());
  int filled_pixels = 0;
  const std::vector<DrawnPiece>& drawn = band.drawn;
  band.drawn.clear();
  for (std::size_t n = 0; n < count; ++n)
    if (add_piece(pieces[n], rect, band))
      filled_pixels += drawn.back().rect.width() * drawn.back().rect.height();
  if (drawn.empty()) return tile;
  tile.pieces = std::uint32_t(drawn.size());
  tile.drawn = tile.whole = filled_pixels == rect.width() * rect.height();
  if (tile.whole)
    for (int y = 0; y < rect.height(); ++y) {
      Span& span = tile.spans[std::size_t(y)];
      span.full_end = span.end = std::uint16_t(rect.width());
    }
  else
    find_spans(rect, tile, band);
  if (!tile.drawn) {
    band.pieces.resize(tile.first_piece);
    return tile;
  }
  const Footprint middle = drawn_at(drawn, rect.width() / 2, rect.height() / 2);
  if (middle.centre.z() > 0) {
    const Vec3 step = middle.slope_y - middle.slope_y.z() / middle.centre.z() * middle.centre;
    tile.u_down = float(limited(step.x() / middle.centre.z()));
    tile.v_down = float(limited(step.y() / middle.centre.z()));
  }
  if (!area) return tile;
  choose_strips(tile, drawn, rect.height(), view_.content, tile.taps);
  if (view_.mask.width > 0) choose_strips(tile, drawn, rect.height(), view_.mask, tile.mask_taps);
  return tile;
}

template <typename Pixel>
void PlaneLayer::sample_row(const TileRow& tile_row, const TexelsView<Pixel>& level, const FilterGrid& taps,
                            const Kernels& kernels, RowMemory<Pixel>& memory, Pixel* to) const {
  const auto& [map, band, y] = tile_row;
  constexpr bool kLight = std::is_same_v<Pixel, Light>;
  const Span& span = map.spans[std::size_t(y)];
  const float w = float(level.width), h = float(level.height);
  const float across = kLight ? w : kStepsAcross * w, down = kLight ? h : kStepsDown * h;
  const float scale[12] = {across, down, 1, across, down, 1, across, down, 1, 0, 0, 0};
  const bool slopes = kLight && taps.across * taps.down > 1;
  const std::ptrdiff_t soon = std::ptrdiff_t(kRowsAhead * map.v_down * h) * level.stride +
                              std::ptrdiff_t(kRowsAhead * map.u_down * w);
  int found = 0;
  // From left to right: pixels are written in whole groups, beyond a piece's end as well.
  for (std::uint32_t n = 0; n < map.pieces; ++n) {
    const Piece& piece = band.pieces[map.first_piece + n];
    const int begin = std::max<int>(span.begin, piece.rect.x0), end = std::min<int>(span.end, piece.rect.x1);
    if (y < piece.rect.y0 || y >= piece.rect.y1 || begin >= end) continue;
    const RowMap row = piece.row(y, scale, slopes);
    if constexpr (kLight) {
      kernels.locate(row, begin, end, slopes, memory);
    } else {
      memory.clear(found, begin - span.begin);  // between pieces nothing is drawn
      kernels.find_cells(level, row, begin, end, begin - span.begin, memory);
      found = end - span.begin;
    }
  }
  const int count = span.end - span.begin;
  if constexpr (kLight) {
    memory.soon = soon;
    kernels.sample_light(level, taps, memory, span.begin, count, to);
  } else {
    memory.clear(found, (count + 15) / 16 * 16);
    kernels.sample_cells(level, memory, soon, count, to);
  }
}

template <typename Texture>
void PlaneLayer::draw(const Texture& texture, const Texture* mask, const Kernels& kernels,
                      Tile<typename Texture::Pixel>& tile) const {
  using Pixel = typename Texture::Pixel;
  const MapTile* const map = map_tile(tile.x, tile.y);
  if (!map) return;
  const Band& band = bands_[std::size_t(tile.y)];
  const bool opaque = texture.opaque() && !mask;
  RowMemory<Pixel> memory;
  alignas(32) Pixel drawn[kRowRoom * 4], alpha[kRowRoom * 4];
  for (int y = 0; y < tile.rect.height(); ++y) {
    const Span& span = map->spans[std::size_t(y)];
    const int count = span.end - span.begin;
    if (count == 0) continue;
    const FilterGrid& taps = map->taps[std::size_t(y / kStrip)];
    Pixel* const there = tile.row(y) + 4 * span.begin;
    const bool replaces = opaque && span.full_begin == 0 && span.full_end == kTileWidth;
    Pixel* const to = replaces ? there : drawn;
    sample_row({*map, band, y}, texture.level(taps.level), taps, kernels, memory, to);
    if (replaces) continue;
    if (mask) {
      const FilterGrid& mask_taps = map->mask_taps[std::size_t(y / kStrip)];
      sample_row({*map, band, y}, mask->level(mask_taps.level), mask_taps, kernels, memory, alpha);
      give_alpha(kernels, alpha, count, drawn);
    }

    const int full = span.full_begin - span.begin, full_count = span.full_end - span.full_begin;
    if (opaque)
      std::copy_n(drawn + 4 * full, 4 * full_count, there + 4 * full);
    else
      over(kernels, drawn + 4 * full, full_count, there + 4 * full);
    if (full_count == count) continue;
    const Light* share = band.border.data() + span.first_border;
    // What the border's pixels show of it, left and right of those that are filled.
    for (const auto& [first, last] : {std::pair(0, full), std::pair(full + full_count, count)}) {
      for (int i = first; i < last; ++i, ++share)
        for (int k = 0; k < 4; ++k) drawn[4 * i + k] = Pixel((drawn[4 * i + k] * *share + kFull / 2) / kFull);
      over(kernels, drawn + 4 * first, last - first, there + 4 * first);
    }
  }
}

template void PlaneLayer::draw(const LightTexture&, const LightTexture*, const Kernels&, Tile<Light>&) const;
template void PlaneLayer::draw(const ValueTexture&, const ValueTexture*, const Kernels&, Tile<Value>&) const;

}  // namespace procam::render
