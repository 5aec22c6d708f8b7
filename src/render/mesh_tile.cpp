#include "mesh_tile.hpp"

#include <cmath>
#include <limits>

namespace procam::render {

namespace {

constexpr float kStep = 0.02f;  ///< share of the distance by which a mesh's depth may jump within one surface
constexpr int kSub = 16;        ///< casts for an edge pixel

/// 16 sub-pixel offsets (N-rooks pattern).
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
  if (std::abs(nearness_a - nearness_b) <= kCoplanarTolerance * std::max(nearness_a, nearness_b))
    return a > b;
  return nearness_a > nearness_b;
}

/// At grazing angles: limits the pixel step so that the footprint stays in front of the horizon.
void keep_in_front(Footprint& f) {
  const double reach = 0.5 * (std::abs(f.slope_x.z()) + std::abs(f.slope_y.z())), most = 0.9 * f.centre.z();
  if (!(reach > most)) return;
  f.slope_x *= most / reach;
  f.slope_y *= most / reach;
}

/// Where a footprint's middle looks, as fractions of the content.
void look(const Footprint& f, float (&texcoords)[6]) {
  const double inverse = 1 / f.centre.z(), u = f.centre.x() * inverse, v = f.centre.y() * inverse;
  // Far beyond the content nothing changes any more, but floats must hold it.
  const auto held = [](double value) { return float(std::min(std::max(value, -1e6), 1e6)); };
  texcoords[0] = held(u);
  texcoords[1] = held(v);
  texcoords[2] = held((f.slope_x.x() - u * f.slope_x.z()) * inverse);
  texcoords[3] = held((f.slope_x.y() - v * f.slope_x.z()) * inverse);
  texcoords[4] = held((f.slope_y.x() - u * f.slope_y.z()) * inverse);
  texcoords[5] = held((f.slope_y.y() - v * f.slope_y.z()) * inverse);
}

/// Asks for memory that is read soon.
void fetch_numbers(const float* numbers, int count) {
  constexpr int kLine = 16;  // of them
  for (int i = 0; i < count; i += kLine) __builtin_prefetch(numbers + i);
}

/// Numbers of Points in the order of TexCoords.
float* numbers(Points& points, int k) {
  float* const all[6] = {points.u, points.v, points.u_x, points.v_x, points.u_y, points.v_y};
  return all[k];
}

}  // namespace

// Drawing: what was cast, sampled.

/// The even pixels of a row; `run` walks through runs_.
template <typename Texture>
void MeshTile::draw_row(const std::vector<ItemTextures<Texture>>& textures, int y, const std::uint16_t*& run,
                        const Kernels& kernels, RoomRows<typename Texture::Pixel>& rows,
                        Tile<typename Texture::Pixel>& tile) const {
  using Pixel = typename Texture::Pixel;
  const std::size_t count = textures.size();
  for (std::size_t a = 0; a < count; ++a) {
    const Row& row = rows_[std::size_t(y) * count + a];
    const int length = row.end - row.begin;
    Pixel* const drawn = rows.drawn.data() + a * kRowRoom * 4;
    // What is wanted ahead: where the row below looks, about as far from here as the row above.
    const Row& above = rows_[std::size_t(std::max(y - 1, 0)) * count + a];
    const int both = std::max(row.begin, above.begin);
    float ahead[2] = {};
    for (int k = 0; k < 2 && both < std::min(row.end, above.end); ++k)
      ahead[k] = points_[row.first + std::size_t(k * length + both - row.begin)] -
                 points_[above.first + std::size_t(k * (above.end - above.begin) + both - above.begin)];
    if (const std::size_t next = std::size_t(y + 1) * count + a; next < rows_.size())
      fetch_numbers(points_.data() + rows_[next].first, texcoords_ * (rows_[next].end - rows_[next].begin));
    // From left to right: samples are written in whole groups, beyond the block's end as well.
    for (int begin = row.begin; begin < row.end;) {
      const int block = begin / kBlock;
      const int end =
          texcoords_ > 2 ? std::min<int>((block + 1) * kBlock, row.end) : row.end;  // the same samples
      const std::size_t n = (std::size_t(y / kStrip) * count + a) * kBlocks + std::size_t(block);
      const auto sample_block = [&](const Texture& texture, const FilterGrid& taps, Pixel* into) {
        const TexelsView<Pixel> level = texture.level(taps.level);
        const float size[2] = {float(level.width), float(level.height)};
        rows.points.soon = std::ptrdiff_t(kRowsAhead * ahead[1] * size[1]) * level.stride +
                           std::ptrdiff_t(kRowsAhead * ahead[0] * size[0]);
        const float* from = points_.data() + row.first + (begin - row.begin);
        for (int k = 0; k < texcoords_; ++k, from += length) {
          float* const to = numbers(rows.points, k) + begin;
          for (int i = 0; i < end - begin; ++i) to[i] = from[i] * size[k % 2];
        }
        sample(kernels, level, taps, {rows.points, begin, end - begin}, into);
      };
      sample_block(*textures[a].content, taps_[n], drawn + 4 * begin);
      if (textures[a].mask) {
        Pixel alpha[4 * kRowRoom];
        sample_block(*textures[a].mask, mask_taps_[n], alpha);
        give_alpha(kernels, alpha, end - begin, drawn + 4 * begin);
      }
      begin = end;
    }
  }
  for (int x = 0; x < tile.rect.width();) {
    const int pixels = run[0], shown = run[1];
    run += 2;
    for (int i = 0; i < shown; ++i) {
      const std::size_t a = *run++;
      const Pixel* const from = rows.drawn.data() + (a * kRowRoom + std::size_t(x)) * 4;
      Pixel* const there = tile.row(y) + 4 * x;
      if (textures[a].opaque())
        std::copy_n(from, 4 * pixels, there);
      else
        over(kernels, from, pixels, there);
    }
    x += pixels;
  }
}

template <typename Texture>
void MeshTile::draw_edge(const std::vector<ItemTextures<Texture>>& textures, const Edge& edge,
                         const Kernels& kernels, RoomRows<typename Texture::Pixel>& rows,
                         Tile<typename Texture::Pixel>& tile) const {
  using Pixel = typename Texture::Pixel;
  Pixel lights[kMaxParts][4];
  for (std::uint32_t i = 0; i < edge.parts; ++i) {
    const Part& part = parts_[edge.first_part + i];
    const auto sample_part = [&](const Texture& texture, const FilterGrid& taps, Pixel* to) {
      const TexelsView<Pixel> level = texture.level(taps.level);
      const float size[2] = {float(level.width), float(level.height)};
      for (int k = 0; k < 6; ++k) numbers(rows.points, k)[0] = part.texcoords[k] * size[k % 2];
      sample(kernels, level, taps, {rows.points, 0, 1}, to);
    };
    const ItemTextures<Texture>& shown = textures[std::size_t(part.item)];
    Pixel drawn[4 * kLanes], alpha[4 * kLanes];
    sample_part(*shown.content, part.taps, drawn);
    if (shown.mask) {
      sample_part(*shown.mask, part.mask_taps, alpha);
      give_alpha(kernels, alpha, 1, drawn);
    }
    std::copy_n(drawn, 4, lights[i]);
  }
  Pixel* const there = tile.row(edge.y) + 4 * edge.x;
  const std::uint8_t* order = orders_.data() + edge.first_order;
  int sum[4] = {};
  for (int k = 0; k < kSub; ++k) {
    Pixel light[4];
    std::copy_n(there, 4, light);
    for (int left = *order++; left > 0; --left) over(kernels, lights[*order++], 1, light);
    for (int c = 0; c < 4; ++c) sum[c] += light[c];
  }
  for (int c = 0; c < 4; ++c) there[c] = Pixel((sum[c] + kSub / 2) / kSub);
}

template <typename Texture>
void MeshTile::draw(const std::vector<ItemTextures<Texture>>& textures, const Kernels& kernels,
                    RoomRows<typename Texture::Pixel>& rows, Tile<typename Texture::Pixel>& tile) const {
  rows.drawn.resize(textures.size() * kRowRoom * 4);
  const std::uint16_t* run = runs_.data();
  for (int y = 0; y < tile.rect.height(); ++y) draw_row(textures, y, run, kernels, rows, tile);
  for (const Edge& edge : edges_) draw_edge(textures, edge, kernels, rows, tile);
}

template void MeshTile::draw(const std::vector<ItemTextures<LightTexture>>&, const Kernels&, RoomRows<Light>&,
                             Tile<Light>&) const;
template void MeshTile::draw(const std::vector<ItemTextures<ValueTexture>>&, const Kernels&, RoomRows<Value>&,
                             Tile<Value>&) const;

// Casting.

/// The rays of a piece; at the tile's rim also of the pixel beyond it.
void MeshCaster::follow(const LensPiece& piece, const PixelRect& rect, const Kernels& kernels) {
  const PixelRect& r = piece.rect;
  const int x0 = r.x0 - (r.x0 == rect.x0), x1 = r.x1 + (r.x1 == rect.x1);
  const int y0 = r.y0 - (r.y0 == rect.y0), y1 = r.y1 + (r.y1 == rect.y1);
  RowMap map{float(r.s(x0)), float(2.0 / r.width()), {}, {}};
  for (int y = y0; y < y1; ++y) {
    const Quadratic3 row = piece.direction_from_pixel.row(r.t(y));
    for (int power = 0; power < 3; ++power)
      for (int k = 0; k < 3; ++k) map.q[3 * power + k] = float(row[std::size_t(power)][k]);
    kernels.follow(map, ray_place(x0 - rect.x0, y - rect.y0), x1 - x0, rays_);
  }
}

void MeshCaster::find_hits(const MeshLayer& layer, const GridTile& tile, const Kernels& kernels,
                           Hits& hits) const {
  std::fill(std::begin(hits.nearness), std::end(hits.nearness), 0.0f);
  std::fill(std::begin(hits.facet), std::end(hits.facet), -1);
  const FacetBoxes boxes = layer.boxes(tile.x, tile.y);
  kernels.cast(layer.facets().data(), layer.borders(), boxes.data, boxes.count, tile.rect.x0, tile.rect.y0,
               rays_, hits);
}

void MeshCaster::nearest_first(std::vector<Fragment>& fragments) {  // a handful
  for (std::size_t i = 1; i < fragments.size(); ++i)
    for (std::size_t j = i; j > 0 && before(fragments[j].item, fragments[j].nearness, fragments[j - 1].item,
                                            fragments[j - 1].nearness);
         --j)
      std::swap(fragments[j], fragments[j - 1]);
}

/// Do the pixel's neighbours see the same surfaces in the same order? Each surface by itself goes on smoothly
/// (Kernels::find_steps).
bool MeshCaster::is_even(const std::vector<CastItem>& items, int at) const {
  for (const int step : kNeighbours) {
    const int other = at + step;
    if (!known(other)) continue;
    for (std::size_t a = 1; a < items.size(); ++a)
      for (std::size_t b = 0; b < a; ++b)
        if (hits_[a].facet[at] >= 0 && hits_[b].facet[at] >= 0 &&
            before(int(a), hits_[a].nearness[at], int(b), hits_[b].nearness[at]) !=
                before(int(a), hits_[a].nearness[other], int(b), hits_[b].nearness[other]))
          return false;
  }
  return true;
}

bool MeshCaster::is_visible(const std::vector<CastItem>& items, int item, int at) const {
  const Hits& own = hits_[std::size_t(item)];
  if (own.facet[at] < 0) return false;
  if (items.size() == 1) return true;
  for (std::size_t b = 0; b < items.size(); ++b)
    if (int(b) != item && items[b].opaque && hits_[b].facet[at] >= 0 &&
        before(int(b), hits_[b].nearness[at], item, own.nearness[at]))
      return false;
  return true;
}

/// What the sub-pixels of pixel (x, y) of the tile hit.
void MeshCaster::find_sub_hits(const MeshLayer& layer, const Kernels& kernels, int x, int y,
                               const GridTile& tile) {
  sub_boxes_.clear();
  for (const FacetBox& box : layer.boxes(tile.x, tile.y))
    if (MeshLayer::touches(box, x + tile.rect.x0, y + tile.rect.y0))
      sub_boxes_.push_back({0, 0, kSub, 1, box.facet});
  std::fill_n(sub_hits_.nearness + ray_place(0, 0), kSub, 0.0f);
  std::fill_n(sub_hits_.facet + ray_place(0, 0), kSub, -1);
  kernels.cast(layer.facets().data(), layer.borders(), sub_boxes_.data(), sub_boxes_.size(), 0, 0, sub_rays_,
               sub_hits_);
}

void MeshCaster::add_edge(const Kernels& kernels, int x, int y, bool area, const GridTile& tile,
                          MeshTile& to) {
  const std::vector<CastItem>& items = to.items_;
  const int at = ray_place(x, y);
  const Vec3 centre = ray(at), by_x = slope(at, 1), by_y = slope(at, kRayAcross);
  for (int k = 0; k < kSub; ++k) {
    const Vec3 d = centre + kSubPixels.x[k] * by_x + kSubPixels.y[k] * by_y;
    sub_rays_.x[ray_place(k, 0)] = float(d.x());
    sub_rays_.y[ray_place(k, 0)] = float(d.y());
    sub_rays_.z[ray_place(k, 0)] = float(d.z());
  }
  for (std::vector<Fragment>& met : sub_fragments_) met.clear();
  for (std::size_t a = 0; a < items.size(); ++a) {
    find_sub_hits(*items[a].layer, kernels, x, y, tile);
    for (int k = 0; k < kSub; ++k)
      if (const int facet = sub_hits_.facet[ray_place(k, 0)]; facet >= 0)
        sub_fragments_[k].push_back({int(a), facet, sub_hits_.nearness[ray_place(k, 0)]});
  }

  // What each sub-pixel meets, nearest first. Each facet is looked at once, about the middle of where it is
  // met.
  struct Shown {
    int item, facet, count;
    Vec2 sum;
  };
  constexpr std::size_t kMax = MeshTile::kMaxParts;
  Shown shown[kMax];
  std::size_t shown_count = 0;
  to.edges_.push_back({std::uint8_t(x), std::uint8_t(y), std::uint32_t(to.parts_.size()), 0,
                       std::uint32_t(to.orders_.size())});
  for (int k = 0; k < kSub; ++k) {
    nearest_first(sub_fragments_[k]);
    const std::size_t head = to.orders_.size();
    to.orders_.push_back(0);
    for (const Fragment& f : sub_fragments_[k]) {
      std::size_t i = 0;
      while (i < shown_count && (shown[i].item != f.item || shown[i].facet != f.facet)) ++i;
      if (i == kMax) continue;
      if (i == shown_count) shown[shown_count++] = {f.item, f.facet, 0, Vec2::Zero()};
      shown[i].sum += Vec2(kSubPixels.x[k], kSubPixels.y[k]);
      ++shown[i].count;
      to.orders_.push_back(std::uint8_t(i));
      ++to.orders_[head];
    }
    std::reverse(to.orders_.begin() + std::ptrdiff_t(head) + 1, to.orders_.end());
  }
  for (std::size_t i = 0; i < shown_count; ++i) {
    const Shown& s = shown[i];
    const CastItem& item = items[std::size_t(s.item)];
    const auto& content = item.layer->facets()[std::size_t(s.facet)].content;
    Mat3 content_from_direction;
    for (int k = 0; k < 9; ++k) content_from_direction(k / 3, k % 3) = double(content[k / 3][k % 3]);
    const Vec2 where = s.sum / s.count;
    Footprint f{content_from_direction * (centre + where.x() * by_x + where.y() * by_y),
                content_from_direction * by_x, content_from_direction * by_y};
    keep_in_front(f);
    MeshTile::Part part{s.item, {}, {}, {}};
    const auto choose = [&](ImageSize of_content, int levels) {
      const PixelSize size = pixel_size(f, Vec2::Zero(), of_content);
      return choose_taps(size, size, size, levels);
    };
    if (area) part.taps = choose(item.content, item.levels);
    if (area && item.mask.width > 0) part.mask_taps = choose(item.mask, item.mask_levels);
    look(f, part.texcoords);
    to.parts_.push_back(part);
  }
  to.edges_.back().parts = std::uint32_t(shown_count);
}

/// How the pixels of a block look at an item's content or mask: the same samples for all of them. At a curved
/// surface's limb a few pixels hold very much of it; they may alias a little, rather than blur the others.
/// `rows` is the strip's first.
FilterGrid MeshCaster::taps_of(ImageSize content, int levels, const Hits& hits, const TexCoords* rows,
                               const PixelRect& block) const {
  constexpr double kMaxOfTypical = 9;  // squared sides
  const double width = content.width, height = content.height;
  PixelSize finest, largest, typical;
  double product_xx = 1, product_yy = 1;  // of 18 at most: no overflow
  int count = 0;
  for (int y = block.y0; y < block.y1; y += 3)
    for (int x = block.x0 + y % 3; x < block.x1; x += 3) {
      if (hits.facet[ray_place(x, y)] < 0) continue;
      const TexCoords& texcoords = rows[y - block.y0];
      const Vec2 right(width * texcoords.of[2][x], height * texcoords.of[3][x]),
          down(width * texcoords.of[4][x], height * texcoords.of[5][x]);
      const PixelSize size = pixel_size(right, down);
      if (count++ == 0) finest = largest = size;
      finest.narrow_squared = std::min(finest.narrow_squared, size.narrow_squared);
      largest.xx = std::max(largest.xx, size.xx);
      largest.yy = std::max(largest.yy, size.yy);
      product_xx *= std::min(std::max(size.xx, 1e-12), 1e16);
      product_yy *= std::min(std::max(size.yy, 1e-12), 1e16);
    }
  if (count == 0) return {};
  typical.xx = std::pow(product_xx, 1.0 / count);
  typical.yy = std::pow(product_yy, 1.0 / count);
  largest.xx = std::min(largest.xx, kMaxOfTypical * typical.xx);
  largest.yy = std::min(largest.yy, kMaxOfTypical * typical.yy);
  return choose_taps(typical, finest, largest, levels);
}

/// Texture coordinates of a row's items, from the first to the last pixel drawn. texcoords_ begin with the
/// row's.
void MeshCaster::add_row(const std::vector<CastItem>& items, int y, int width, const RowBits& edges,
                         MeshTile& to) {
  for (std::size_t a = 0; a < items.size(); ++a) {
    int begin = 0, end = width;
    const auto is_drawn = [&](int x) {
      return !edges[x] && (items.size() == 1 ? met_[x] : is_visible(items, int(a), ray_place(x, y)));
    };
    while (begin < end && !is_drawn(begin)) ++begin;
    while (begin < end && !is_drawn(end - 1)) --end;
    to.rows_.push_back({std::uint8_t(begin), std::uint8_t(end), std::uint32_t(to.points_.size())});
    const TexCoords& texcoords = texcoords_[a * MeshTile::kStrip + std::size_t(y % MeshTile::kStrip)];
    for (int k = 0; k < to.texcoords_; ++k)
      to.points_.insert(to.points_.end(), texcoords.of[k] + begin, texcoords.of[k] + end);
  }
}

/// What lies over what in a row, less the edges.
void MeshCaster::add_runs(const std::vector<CastItem>& items, int y, int width, const RowBits& edges,
                          MeshTile& to) {
  if (items.size() == 1) {
    const RowBits shown = met_ & ~edges, hidden = ~shown;
    for (int x = 0; x < width;) {
      const bool is_shown = shown[x];
      const int end = (is_shown ? hidden : shown).first(x, width);
      to.runs_.push_back(std::uint16_t(end - x));
      to.runs_.push_back(is_shown);
      if (is_shown) to.runs_.push_back(0);
      x = end;
    }
    return;
  }
  std::size_t last = 0;  // the last run
  for (int x = 0; x < width; ++x) {
    fragments_.clear();
    for (int a = 0; !edges[x] && a < int(items.size()); ++a)
      if (is_visible(items, a, ray_place(x, y)))
        fragments_.push_back({a, 0, hits_[std::size_t(a)].nearness[ray_place(x, y)]});
    nearest_first(fragments_);
    const std::size_t count = fragments_.size();
    bool same = x > 0 && to.runs_[last + 1] == count;
    for (std::size_t i = 0; same && i < count; ++i)
      same = to.runs_[last + 2 + i] == fragments_[count - 1 - i].item;
    if (same) {
      ++to.runs_[last];
      continue;
    }
    last = to.runs_.size();
    to.runs_.push_back(1);
    to.runs_.push_back(std::uint16_t(count));
    for (std::size_t i = count; i > 0; --i) to.runs_.push_back(std::uint16_t(fragments_[i - 1].item));
  }
}

void MeshCaster::cast(const std::vector<CastItem>& items, const std::vector<LensPiece>& pieces, bool area,
                      const Kernels& kernels, const GridTile& tile, MeshTile& to) {
  const PixelRect& rect = tile.rect;
  to.items_ = items;
  to.cast_ = true;
  to.texcoords_ = area ? 6 : 2;
  to.rows_.clear();
  to.points_.clear();
  to.runs_.clear();
  to.edges_.clear();
  to.parts_.clear();
  to.orders_.clear();
  to.taps_.assign(std::size_t(MeshTile::kStrips) * items.size() * MeshTile::kBlocks, {});
  to.mask_taps_ = to.taps_;

  std::fill(std::begin(rays_.x), std::end(rays_.x), std::numeric_limits<float>::quiet_NaN());
  for (const LensPiece& piece : pieces) follow(piece, rect, kernels);
  for (int y = 0; area && y < rect.height(); ++y) {
    kernels.find_slopes(rays_, 1, ray_place(0, y), rect.width(), right_);
    kernels.find_slopes(rays_, kRayAcross, ray_place(0, y), rect.width(), down_);
  }
  if (hits_.size() < items.size()) hits_.resize(items.size());
  if (texcoords_.size() < items.size() * MeshTile::kStrip) texcoords_.resize(items.size() * MeshTile::kStrip);
  for (std::size_t a = 0; a < items.size(); ++a) find_hits(*items[a].layer, tile, kernels, hits_[a]);

  const int width = rect.width();
  for (int y = 0; y < rect.height(); ++y) {
    if (y % MeshTile::kStrip == 0) {
      const int last = std::min(y + MeshTile::kStrip, rect.height());
      for (std::size_t a = 0; a < items.size(); ++a) {
        TexCoords* const rows = &texcoords_[a * MeshTile::kStrip];
        for (int row = y; row < last; ++row)
          kernels.look(items[a].layer->facets().data(), rays_, right_, down_, hits_[a], ray_place(0, row),
                       width, area, rows[row - y]);
        for (int block = 0; area && block * MeshTile::kBlock < width; ++block) {
          const CastItem& item = items[a];
          const std::size_t n =
              (std::size_t(y / MeshTile::kStrip) * items.size() + a) * MeshTile::kBlocks + std::size_t(block);
          const PixelRect pixels{block * MeshTile::kBlock, y, std::min((block + 1) * MeshTile::kBlock, width),
                                 last};
          to.taps_[n] = taps_of(item.content, item.levels, hits_[a], rows, pixels);
          if (item.mask.width > 0)
            to.mask_taps_[n] = taps_of(item.mask, item.mask_levels, hits_[a], rows, pixels);
        }
      }
    }
    met_ = {};
    RowBits edges;
    for (std::size_t a = 0; a < items.size(); ++a)
      kernels.find_steps(items[a].layer->facets().data(), rays_, hits_[a], ray_place(0, y), width, kStep,
                         met_, edges);
    for (int x = 0; items.size() > 1 && x < width; ++x)
      if (!edges[x] && known(ray_place(x, y)) && !is_even(items, ray_place(x, y))) edges.set(x);
    add_row(items, y, width, edges, to);
    add_runs(items, y, width, edges, to);
    for (int x = edges.first(0, width); x < width; x = edges.first(x + 1, width))
      add_edge(kernels, x, y, area, tile, to);
  }
}

}  // namespace procam::render
