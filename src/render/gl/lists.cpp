/// Packs facets, tiles and draw steps into the textures that the shaders read.
#include <cstring>

#include "state.hpp"

namespace procam::render_gl {

using render::FacetBox;
using render::FilterGrid;
using render::Layer;
using render::TileSteps;

namespace {

std::int32_t bits(float value) {
  std::int32_t result = 0;
  std::memcpy(&result, &value, sizeof result);
  return result;
}
Int4 packed(const FilterGrid& taps) {
  return {taps.level, taps.across | taps.down << 16, bits(taps.share_across), bits(taps.share_down)};
}

void add_numbers(const render::Facet& facet, std::vector<Float4>& to) {
  const auto& m = facet.content;
  const auto& b = facet.borders;
  for (int k = 0; k < 3; ++k) to.push_back({b[k][0], b[k][1], b[k][2], facet.nearness[k]});
  for (int k = 0; k < 3; ++k) to.push_back({m[k][0], m[k][1], m[k][2], b[3][k]});
}

/// One more on each side: corners of packed boxes are not below 0.
Int4 packed_box(const FacetBox& box, std::size_t first_facet) {
  return {(box.x0 + 1) | (box.y0 + 1) << 16, (box.x1 + 1) | (box.y1 + 1) << 16,
          std::int32_t(first_facet) + box.facet, 0};
}

}  // namespace

void GlRenderer::State::write_numbers() {
  std::size_t count = 0;
  bool moved = false;
  for (std::size_t i = 0; i < items_.size(); ++i) {
    Item& item = items_[i];
    const std::size_t facets = layers_[i].is_mesh() ? layers_[i].room->facets().size() : 1;
    moved = moved || item.first_facet != count || item.facets != facets;
    item.first_facet = count;
    item.facets = facets;
    count += facets;
  }
  const bool lost = on_card_->numbers.reserve(count * kFacetTexels, row_bits_, max_rows_);
  for (std::size_t i = 0; i < items_.size(); ++i) {
    if (!items_[i].new_map && !moved && !lost) continue;
    numbers_.clear();
    const Layer& layer = layers_[i];
    if (layer.room && !layer.room->facets().empty()) {
      for (const render::Facet& facet : layer.room->facets()) add_numbers(facet, numbers_);
    } else if (!layer.is_mesh()) {
      render::Facet facet{};
      const Mat3& m = layer.plane.view().content_from_direction;
      for (int k = 0; k < 9; ++k) facet.content[k / 3][k % 3] = float(m(k / 3, k % 3));
      add_numbers(facet, numbers_);
    }
    on_card_->numbers.write(items_[i].first_facet * kFacetTexels, numbers_.size(), numbers_.data());
  }
}

void GlRenderer::State::place_contents() {
  content_texels_ = 0;
  for (Item& item : items_)
    for (Shown* const shown : item.records()) {
      shown->first_texel.clear();
      for (int l = 0; l < shown->levels(); ++l) {
        const auto level = shown->light.level(l);
        shown->first_texel.push_back(content_texels_);
        const std::size_t texels = std::size_t(level.stride) * std::size_t(level.height + 1);
        const std::size_t row = std::size_t(1) << row_bits_;
        content_texels_ += (texels + row - 1) / row * row;
      }
    }
  moved_contents_ = true;
}

void GlRenderer::State::write_lists() {
  place_contents();
  const render::TileGrid grid = lens_.grid();
  lists_.clear();
  lists_.resize(items_.size() * 2 * kRecordTexels);
  for (std::size_t i = 0; i < items_.size(); ++i) {
    const Item& item = items_[i];
    const Layer& layer = layers_[i];
    const bool through_lens = layer.room || layer.plane.view().through_lens;
    for (std::size_t n = 0; n < 2; ++n) {
      const Shown& shown = *item.records()[n];
      Int4* const record = &lists_[(2 * i + n) * kRecordTexels];
      record[0] = {0, 0, shown.levels(), 0};
      for (int l = 0; l < shown.levels(); ++l) {
        const auto level = shown.light.level(l);
        record[1 + l] = {std::int32_t(shown.first_texel[std::size_t(l)]), level.width, level.height,
                         level.stride};
      }
    }
    Int4& head = lists_[2 * i * kRecordTexels];
    head[0] = std::int32_t(item.first_facet);
    head[1] = (item.opaque() ? kOpaque : 0) | (layer.is_mesh() ? kMesh : 0) |
              (through_lens ? 0 : kNotThroughLens) | (item.mask.view.empty() ? 0 : kMasked);
  }
  first_tile_ = lists_.size();
  lists_.resize(first_tile_ + std::size_t(grid.across()) * std::size_t(grid.down()));
  cast_at_.assign(items_.size(), false);
  for (int y = 0; y < grid.down(); ++y)
    for (int x = 0; x < grid.across(); ++x) add_tile(x, y);
  // Those cast at have a layer of the hits, and the same of the taps; the taps of masks come after all
  // these.
  layers_cast_ = 0;
  for (std::size_t i = 0; i < items_.size(); ++i)
    if (cast_at_[i])
      lists_[2 * i * kRecordTexels][3] = items_[i].layer = items_[i].picture.layer = layers_cast_++;
  tap_layers_ = layers_cast_;
  for (std::size_t i = 0; i < items_.size(); ++i)
    if (cast_at_[i] && !items_[i].mask.view.empty())
      lists_[(2 * i + 1) * kRecordTexels][3] = items_[i].mask.layer = tap_layers_++;
  first_box_.assign(items_.size(), 0);
  for (std::size_t i = 0; i < items_.size(); ++i) {
    if (!layers_[i].is_mesh()) continue;
    first_box_[i] = lists_.size();
    for (const FacetBox& box : layers_[i].room->boxes())
      lists_.push_back(packed_box(box, items_[i].first_facet));
  }
  on_card_->lists.reserve(lists_.size(), row_bits_, max_rows_);
  on_card_->lists.write(0, lists_.size(), lists_.data());
}

void GlRenderer::State::add_tile(int x, int y) {
  const std::vector<int>& steps = steps_.find(layers_, lens_, x, y);
  // What an opaque plane hides all over the tile is skipped.
  std::size_t first = steps.size();
  bool in_cast = false, hidden = false;
  while (first > 0 && !hidden) {
    const int step = steps[--first];
    if (step == TileSteps::kCast)
      in_cast = !in_cast;
    else
      hidden =
          !in_cast && items_[std::size_t(step)].opaque() && layers_[std::size_t(step)].plane.covers(x, y);
  }
  const std::size_t begin = lists_.size();
  for (std::size_t i = first; i < steps.size(); ++i) {
    if (steps[i] != TileSteps::kCast) {
      const bool whole = layers_[std::size_t(steps[i])].plane.covers(x, y);
      lists_.push_back({steps[i], 0, whole, 0});
      continue;
    }
    const std::size_t head = lists_.size();
    lists_.push_back({-1, 0, 0, 0});
    for (++i; steps[i] != TileSteps::kCast; ++i) {
      lists_.push_back({steps[i], 0, 0, 0});
      ++lists_[head][1];
      cast_at_[std::size_t(steps[i])] = true;
    }
  }
  const std::size_t end = lists_.size();
  lists_[first_tile_ + std::size_t(y * lens_.grid().across() + x)] = {std::int32_t(begin),
                                                                      std::int32_t(end - begin), 0, 0};
  for (std::size_t at = begin; at < end; ++at) {
    const int cast = lists_[at][0] < 0 ? lists_[at][1] : -1;
    if (cast < 0) {
      const auto item = std::size_t(lists_[at][0]);
      lists_[at][1] = std::int32_t(lists_.size());
      for (const FilterGrid& taps : layers_[item].plane.taps(x, y)) lists_.push_back(packed(taps));
      for (const FilterGrid& taps : layers_[item].plane.mask_taps(x, y)) lists_.push_back(packed(taps));
      continue;
    }
    for (int n = 0; n < cast; ++n) {
      ++at;
      const auto item = std::size_t(lists_[at][0]);
      lists_[at][1] = std::int32_t(lists_.size());
      add_boxes(layers_[item].room->boxes(x, y), items_[item].first_facet, lens_.grid().tile(x, y));
    }
  }
}

void GlRenderer::State::add_boxes(const render::FacetBoxes& boxes, std::size_t first_facet,
                                  const render::PixelRect& tile) {
  constexpr int kAcross = render::kTileWidth / kBlocksAcross, kDown = render::kTileHeight / kBlocksDown;
  const std::size_t blocks = lists_.size();
  lists_.resize(blocks + kBlocksAcross * kBlocksDown, Int4{0, 0, 0, 0});
  const auto for_blocks = [&](const FacetBox& box, const auto& visit) {
    // A pixel may be touched whose middle is not.
    const int x0 = std::max(box.x0 - 1 - tile.x0, 0) / kAcross,
              y0 = std::max(box.y0 - 1 - tile.y0, 0) / kDown;
    const int x1 = std::min((box.x1 - tile.x0) / kAcross + 1, kBlocksAcross),
              y1 = std::min((box.y1 - tile.y0) / kDown + 1, kBlocksDown);
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) visit(blocks + std::size_t(y * kBlocksAcross + x));
  };
  for (const FacetBox& box : boxes) for_blocks(box, [&](std::size_t block) { ++lists_[block][1]; });
  std::size_t end = lists_.size();
  for (std::size_t block = blocks; block < lists_.size(); ++block) {
    lists_[block][0] = std::int32_t(end);
    end += std::size_t(std::exchange(lists_[block][1], 0));
  }
  lists_.resize(end);
  for (const FacetBox& box : boxes)
    for_blocks(box, [&](std::size_t block) {
      lists_[std::size_t(lists_[block][0] + lists_[block][1]++)] = packed_box(box, first_facet);
    });
}

}  // namespace procam::render_gl
