#include "plane_layer.hpp"

#include <cstring>

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

Margins margins_at(const RowMap& row, int i) {
  const float s = row.s0 + float(i) * row.ds;
  float q[3], right[3], down[3];
  for (int k = 0; k < 3; ++k) {
    q[k] = row.q[k] + s * (row.q[3 + k] + s * row.q[6 + k]);
    right[k] = row.ds * (row.q[3 + k] + 2 * s * row.q[6 + k]);
    down[k] = row.down[k] + s * (row.down[3 + k] + s * row.down[6 + k]);
  }
  Margins margins;
  for (int k = 0; k < 2; ++k) {
    const float reach = 0.5f * (std::fabs(right[k]) + std::fabs(down[k]));
    const float other = 0.5f * (std::fabs(right[2] - right[k]) + std::fabs(down[2] - down[k]));
    margins.low[2 * k] = q[k] - reach;
    margins.high[2 * k] = q[k] + reach;
    margins.low[2 * k + 1] = q[2] - q[k] - other;
    margins.high[2 * k + 1] = q[2] - q[k] + other;
  }
  return margins;
}

/// Are pixels with margins between a and b, give or take `bend`, all outside, all filled, or touched (some
/// may be)?
std::uint8_t class_of(const Margins& a, const Margins& b, float bend) {
  bool outside = false, filled = true;
  for (int k = 0; k < 4; ++k) {
    outside = outside || !(std::max(a.high[k], b.high[k]) + bend > 0);
    filled = filled && std::min(a.low[k], b.low[k]) - bend >= 0;
  }
  return outside ? kOutside : filled ? kFilled : kTouched;
}

/// Pixels [begin, end) of a row, in groups where nothing happens between the ends.
void classify(const RowMap& row, int begin, int end, std::uint8_t* classes) {
  // A quadratic leaves the line between two ends by at most a quarter of its square term times the squared
  // distance; margins combine two of three, and the slopes in them bend less.
  const float step = row.ds * float(kLanes);
  const float bend = step * step * (std::fabs(row.q[6]) + std::fabs(row.q[7]) + std::fabs(row.q[8]));
  for (int i = begin; i < end; i += kLanes) {
    const int last = std::min(i + kLanes, end) - 1;
    const std::uint8_t all = class_of(margins_at(row, i), margins_at(row, last), bend);
    for (int x = i; x <= last; ++x) {
      if (all != kTouched) {
        classes[x] = all;
        continue;
      }
      const Margins own = margins_at(row, x);
      classes[x] = class_of(own, own, 0);
    }
  }
}

}  // namespace

/// The classes of a tile's pixels.
struct PlaneLayer::Classes {
  std::uint8_t of[kTileHeight][kTileWidth] = {};
};

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

int PlaneLayer::levels_of_taps(std::array<Taps, kTileHeight / kStrip> MapTile::*taps_of) const {
  int coarsest = 0;
  for (const Band& band : bands_)
    for (const MapTile& tile : band.tiles)
      for (const Taps& taps : tile.*taps_of) coarsest = std::max(coarsest, taps.level);
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

PlaneLayer::MapTile PlaneLayer::make_tile(const PixelRect& rect, const LensPiece* pieces, std::size_t count,
                                          bool area, Band& band) {
  MapTile tile;
  tile.first_piece = std::uint32_t(band.pieces.size());
  constexpr float kScale[12] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  Classes classes;
  int filled_pixels = 0;
  std::vector<DrawnPiece>& drawn = band.drawn;
  drawn.clear();
  for (std::size_t n = 0; n < count; ++n) {
    const Patch q = view_.content_from_direction * pieces[n].direction_from_pixel;
    bool filled = true, outside = false;
    for (const Eigen::RowVector3d& border : border_combinations()) {
      const Patch::Bounds bounds = q.bounds(border);
      outside = outside || !(bounds.high > 0);
      filled = filled && bounds.low > 0;
    }
    if (outside) continue;
    Piece piece;
    const PixelRect& r = pieces[n].rect;
    piece.rect = {r.x0 - rect.x0, r.y0 - rect.y0, r.x1 - rect.x0, r.y1 - rect.y0};
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k) piece.q[j][3 * i + k] = float(q.c[j][i][Eigen::Index(k)]);
    piece.s0 = float(piece.rect.s(0));
    piece.ds = 2.0f / float(piece.rect.width());
    piece.t0 = float(piece.rect.t(0));
    piece.dt = 2.0f / float(piece.rect.height());
    for (int y = piece.rect.y0; y < piece.rect.y1; ++y) {
      std::uint8_t* const row = classes.of[y];
      if (filled)
        std::fill(row + piece.rect.x0, row + piece.rect.x1, kFilled);
      else
        classify(piece.row(y, kScale, true), piece.rect.x0, piece.rect.x1, row);
    }
    filled_pixels += filled ? piece.rect.width() * piece.rect.height() : 0;
    band.pieces.push_back(piece);
    drawn.push_back({q, piece.rect});
  }
  tile.pieces = std::uint32_t(drawn.size());
  tile.whole = filled_pixels == rect.width() * rect.height();

  const auto at = [&](int x, int y) {
    for (const DrawnPiece& d : drawn)
      if (x >= d.rect.x0 && x < d.rect.x1 && y >= d.rect.y0 && y < d.rect.y1)
        return footprint_at(d.q, d.rect, x, y);
    return Footprint{Vec3(0.5, 0.5, 1), Vec3::Zero(), Vec3::Zero()};  // between pieces: nothing is drawn
  };
  tile.drawn = tile.whole;
  for (int y = 0; y < rect.height(); ++y) {
    Span& span = tile.spans[std::size_t(y)];
    if (tile.whole) {
      span.full_end = span.end = std::uint16_t(rect.width());
      continue;
    }
    const std::uint8_t* const row = classes.of[y];
    const auto is = [&](std::uint8_t wanted, int x) { return row[x] >= wanted; };
    int begin = 0, end = rect.width();
    while (begin < end && !is(kTouched, begin)) ++begin;
    if (begin == end) continue;
    while (!is(kTouched, end - 1)) --end;
    int full_begin = begin;
    while (full_begin < end && !is(kFilled, full_begin)) ++full_begin;
    int full_end = full_begin;
    while (full_end < end && is(kFilled, full_end)) ++full_end;
    tile.drawn = true;
    span = {std::uint16_t(begin), std::uint16_t(end), std::uint16_t(full_begin), std::uint16_t(full_end),
            std::uint32_t(band.border.size())};
    for (int x = begin; x < end; ++x)
      if (x < full_begin || x >= full_end)
        band.border.push_back(Light(is(kTouched, x) ? std::lround(kFull * coverage(at(x, y)).area) : 0));
  }
  if (!tile.drawn) {
    band.pieces.resize(tile.first_piece);
    return tile;
  }
  const Footprint middle = at(rect.width() / 2, rect.height() / 2);
  if (middle.centre.z() > 0) {
    const Vec3 step = middle.slope_y - middle.slope_y.z() / middle.centre.z() * middle.centre;
    tile.u_down = float(limited(step.x() / middle.centre.z()));
    tile.v_down = float(limited(step.y() / middle.centre.z()));
  }
  if (!area) return tile;

  const auto choose = [&](ImageSize content, std::array<Taps, kTileHeight / kStrip>& taps) {
    const int levels = levels_of(content);
    for (int strip = 0; strip * kStrip < rect.height(); ++strip) {
      PixelSize finest, largest, typical;
      bool any = false;
      const int y0 = strip * kStrip, y1 = std::min(y0 + kStrip, rect.height()) - 1;
      for (const int y : {y0, y1, (y0 + y1) / 2}) {
        const Span& span = tile.spans[std::size_t(y)];
        if (span.begin == span.end) continue;
        for (const int x : {int(span.begin), span.end - 1, (span.begin + span.end) / 2}) {
          const Footprint f = at(x, y);
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
  };
  choose(view_.content, tile.taps);
  if (view_.mask.width > 0) choose(view_.mask, tile.mask_taps);
  return tile;
}

template <typename Pixel>
void PlaneLayer::sample_row(const MapTile& map, const Band& band, int y, const TexelsView<Pixel>& level,
                            const Taps& taps, const Kernels& kernels, Points& points, Pixel* to) const {
  constexpr bool kLight = std::is_same_v<Pixel, Light>;
  const Span& span = map.spans[std::size_t(y)];
  const float w = float(level.width), h = float(level.height);
  const float across = kLight ? w : kStepsAcross * w, down = kLight ? h : kStepsDown * h;
  const float scale[12] = {across, down, 1, across, down, 1, across, down, 1, 0, 0, 0};
  const bool slopes = kLight && taps.across * taps.down > 1;
  const std::ptrdiff_t soon = std::ptrdiff_t(kRowsAhead * map.v_down * h) * level.stride +
                              std::ptrdiff_t(kRowsAhead * map.u_down * w);
  RowCells cells;
  int found = 0;
  // From left to right: pixels are written in whole groups, beyond a piece's end as well.
  for (std::uint32_t n = 0; n < map.pieces; ++n) {
    const Piece& piece = band.pieces[map.first_piece + n];
    const int begin = std::max<int>(span.begin, piece.rect.x0), end = std::min<int>(span.end, piece.rect.x1);
    if (y < piece.rect.y0 || y >= piece.rect.y1 || begin >= end) continue;
    const RowMap row = piece.row(y, scale, slopes);
    if constexpr (kLight) {
      kernels.locate(row, begin, end, slopes, points);
    } else {
      cells.clear(found, begin - span.begin);  // between pieces nothing is drawn
      kernels.find_cells(level, row, begin, end, begin - span.begin, cells);
      found = end - span.begin;
    }
  }
  const int count = span.end - span.begin;
  if constexpr (kLight) {
    points.soon = soon;
    kernels.sample_light(level, taps, points, span.begin, count, to);
  } else {
    cells.clear(found, (count + 15) / 16 * 16);
    kernels.sample_cells(level, cells, soon, count, to);
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
  Points points;
  alignas(32) Pixel drawn[kRowRoom * 4], alpha[kRowRoom * 4];
  for (int y = 0; y < tile.rect.height(); ++y) {
    const Span& span = map->spans[std::size_t(y)];
    const int count = span.end - span.begin;
    if (count == 0) continue;
    const Taps& taps = map->taps[std::size_t(y / kStrip)];
    Pixel* const there = tile.row(y) + 4 * span.begin;
    const bool replaces = opaque && span.full_begin == 0 && span.full_end == kTileWidth;
    Pixel* const to = replaces ? there : drawn;
    sample_row(*map, band, y, texture.level(taps.level), taps, kernels, points, to);
    if (replaces) continue;
    if (mask) {
      const Taps& mask_taps = map->mask_taps[std::size_t(y / kStrip)];
      sample_row(*map, band, y, mask->level(mask_taps.level), mask_taps, kernels, points, alpha);
      give_alpha(kernels, alpha, count, drawn);
    }

    const int full = span.full_begin - span.begin, full_count = span.full_end - span.full_begin;
    if (opaque)
      std::copy_n(drawn + 4 * full, 4 * full_count, there + 4 * full);
    else
      over(kernels, drawn + 4 * full, full_count, there + 4 * full);
    if (full_count == count) continue;
    const Light* share = band.border.data() + span.first_border;
    for (int i = 0; i < count; ++i) {
      if (i >= full && i < full + full_count) continue;
      Pixel part[4];
      for (int k = 0; k < 4; ++k) part[k] = Pixel((drawn[4 * i + k] * *share + kFull / 2) / kFull);
      over(kernels, part, 1, there + 4 * i);
      ++share;
    }
  }
}

template void PlaneLayer::draw(const LightTexture&, const LightTexture*, const Kernels&, Tile<Light>&) const;
template void PlaneLayer::draw(const ValueTexture&, const ValueTexture*, const Kernels&, Tile<Value>&) const;

}  // namespace procam::render
