#include <algorithm>
#include <cmath>

#include "kernels.hpp"

namespace procam::render {

namespace {

void locate(const RowMap& row, int begin, int end, bool slopes, Points& points) {
  for (int i = begin; i < end; ++i) {
    const float s = row.s0 + float(i) * row.ds;
    float q[3];
    for (int k = 0; k < 3; ++k) q[k] = row.q[k] + s * (row.q[3 + k] + s * row.q[6 + k]);
    const float inverse = 1.0f / (q[2] > kMinDepth ? q[2] : kMinDepth);
    const float u = q[0] * inverse, v = q[1] * inverse;
    points.u[i] = u;
    points.v[i] = v;
    if (!slopes) continue;
    float right[3], down[3];
    for (int k = 0; k < 3; ++k) {
      right[k] = row.ds * (row.q[3 + k] + (s + s) * row.q[6 + k]);
      down[k] = row.down[k] + s * (row.down[3 + k] + s * row.down[6 + k]);
    }
    points.u_x[i] = (right[0] - u * right[2]) * inverse;
    points.v_x[i] = (right[1] - v * right[2]) * inverse;
    points.u_y[i] = (down[0] - u * down[2]) * inverse;
    points.v_y[i] = (down[1] - v * down[2]) * inverse;
  }
}

/// From the content's corner to texel centres, inside the first and last of them. NaN: the first.
float inside(float position, int size) {
  const float p = position - 0.5f;
  const float low = p > 0 ? p : 0.0f;
  return low < float(size - 1) ? low : float(size - 1);
}

/// The nearest whole number, of two the even one.
int nearest(float x) {
  constexpr float kWholeOnly = 3 << 22;  // so large that floats have no fractions
  return int((x + kWholeOnly) - kWholeOnly);
}

/// Beyond a border, as far inside it.
float mirrored(float position, int size) {
  const float p = std::fabs(position), other = float(2 * size) - p;
  return p < other ? p : other;
}

void add_cell(const TexelsView<Value>& texels, float u_from_corner, float v_from_corner, int at,
              RowCells& cells) {
  const float u = inside(u_from_corner, texels.width), v = inside(v_from_corner, texels.height);
  const int x = int(u), y = int(v);
  const int right = nearest((u - float(x)) * kStepsAcross);
  cells.offset[at] = y * texels.stride + x;
  cells.shares[at] = (128 - right) | right << 8;
  cells.down[at] = int((v - float(y)) * 32768.0f);
}

void find_cells(const TexelsView<Value>& texels, const RowMap& row, int begin, int end, int at,
                RowCells& cells) {
  Points points;
  locate(row, begin, end, false, points);
  // Powers of two: exact.
  for (int i = begin; i < end; ++i)
    add_cell(texels, points.u[i] / kStepsAcross, points.v[i] / kStepsDown, at++, cells);
}

void sample_cells(const TexelsView<Value>& texels, const RowCells& cells, std::ptrdiff_t, int count,
                  Value* to) {
  for (int i = 0; i < count; ++i) {
    const int left = cells.shares[i] & 255, right = cells.shares[i] >> 8, down = cells.down[i];
    const Value* upper = texels.data + std::ptrdiff_t(cells.offset[i]) * 4;
    const Value* lower = upper + std::ptrdiff_t(texels.stride) * 4;
    for (int k = 0; k < 4; ++k) {
      const auto blend = [&](const Value* row) {
        return left * std::int8_t(row[k]) + right * std::int8_t(row[k + 4]);
      };
      const int a = blend(upper), b = blend(lower);
      *to++ = Value(((a + (((b - a) * down + 0x4000) >> 15) + 64) >> 7) ^ 0x80);
    }
  }
}

void sample_values(const TexelsView<Value>& texels, const Points& points, int begin, int count, Value* to) {
  RowCells cells;
  for (int i = 0; i < count; ++i) add_cell(texels, points.u[begin + i], points.v[begin + i], i, cells);
  sample_cells(texels, cells, points.soon, count, to);
}

void sample_light(const TexelsView<Light>& texels, const FilterGrid& taps, const Points& points, int begin,
                  int count, Light* to) {
  const float step_across = taps.share_across / float(taps.across),
              step_down = taps.share_down / float(taps.down);
  const float inverse = 1.0f / float(512 * taps.across * taps.down);
  for (int i = begin; i < begin + count; ++i) {
    std::int32_t sum[4] = {};
    for (int n = 0; n < taps.down; ++n) {
      const float dy = (float(n) - 0.5f * float(taps.down - 1)) * step_down;
      const float u_row = points.u[i] + dy * points.u_y[i], v_row = points.v[i] + dy * points.v_y[i];
      for (int m = 0; m < taps.across; ++m) {
        const float dx = (float(m) - 0.5f * float(taps.across - 1)) * step_across;
        const float u = inside(mirrored(u_row + dx * points.u_x[i], texels.width), texels.width);
        const float v = inside(mirrored(v_row + dx * points.v_x[i], texels.height), texels.height);
        const int x = int(u), y = int(v);
        const int right = nearest((u - float(x)) * 512.0f), down = int((v - float(y)) * 32768.0f);
        const Light* upper = texels.data + (std::ptrdiff_t(y) * texels.stride + x) * 4;
        const Light* lower = upper + std::ptrdiff_t(texels.stride) * 4;
        for (int k = 0; k < 4; ++k) {
          const auto blend = [&](int j) {
            return upper[j] + (((lower[j] - upper[j]) * down + 0x4000) >> 15);
          };
          sum[k] += (512 - right) * blend(k) + right * blend(k + 4);
        }
      }
    }
    for (int k = 0; k < 4; ++k) *to++ = Light(std::lrint(float(sum[k]) * inverse));
  }
}

void values_over(const Value* drawn, int count, Value* there) {
  for (int i = 0; i < 4 * count; i += 4)
    for (int k = 0; k < 4; ++k) {
      const int product = there[i + k] * (255 - drawn[i + 3]) + 128;  // / 255, rounded
      there[i + k] = Value(std::min(255, drawn[i + k] + ((product + (product >> 8)) >> 8)));
    }
}

void light_over(const Light* drawn, int count, Light* there) {
  for (int i = 0; i < 4 * count; i += 4) {
    const int rest = kFull - drawn[i + 3], share = rest + (rest >> 8);  // of 2^15
    for (int k = 0; k < 4; ++k) {
      const int sum = drawn[i + k] + ((there[i + k] * share + 0x4000) >> 15);
      there[i + k] = Light(std::min(sum, kFull));
    }
  }
}

template <int kWhole, typename Pixel>
void give_alpha_plainly(const Pixel* mask, int count, Pixel* drawn) {
  for (int i = 0; i < count; ++i, mask += 4, drawn += 4)
    for (int k = 0; k < 4; ++k) drawn[k] = Pixel((drawn[k] * int(mask[3]) + kWhole / 2) / kWhole);
}

void values_to_rgb(const Value* from, int count, std::uint8_t* to) {
  for (int i = 0; i < count; ++i, from += 4)
    for (int k = 0; k < 3; ++k) *to++ = from[k];
}

void rgb_to_texels(const std::uint8_t* from, int count, Value* to) {
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) *to++ = Value(*from++ ^ 0x80);
    *to++ = 255 ^ 0x80;
  }
}

float dot(const float* f, float x, float y, float z) {
  return f[0] * x + f[1] * y + f[2] * z;
}

void follow(const RowMap& row, int first, int count, Rays& rays) {
  const float* const q = row.q;
  for (int i = 0; i < count; ++i) {
    const float s = row.s0 + float(i) * row.ds;
    rays.x[first + i] = q[0] + s * (q[3] + s * q[6]);
    rays.y[first + i] = q[1] + s * (q[4] + s * q[7]);
    rays.z[first + i] = q[2] + s * (q[5] + s * q[8]);
  }
}

void find_slopes(const Rays& rays, int step, int first, int count, Rays& slopes) {
  for (int at = first; at < first + count; ++at) {
    const bool forward = rays.x[at + step] == rays.x[at + step],
               backward = rays.x[at - step] == rays.x[at - step];
    const int ahead = forward ? at + step : at, back = backward ? at - step : at;
    const float share = forward && backward ? 0.5f : 1.0f;
    slopes.x[at] = share * (rays.x[ahead] - rays.x[back]);
    slopes.y[at] = share * (rays.y[ahead] - rays.y[back]);
    slopes.z[at] = share * (rays.z[ahead] - rays.z[back]);
  }
}

void cast(const Facet* facets, int borders, const FacetBox* boxes, std::size_t count, int x, int y,
          const Rays& rays, Hits& hits) {
  for (std::size_t n = 0; n < count; ++n) {
    const FacetBox& box = boxes[n];
    const Facet& facet = facets[box.facet];
    const int x0 = std::max(box.x0 - x, -1), x1 = std::min(box.x1 - x, kTileWidth + 1);
    const int y0 = std::max(box.y0 - y, -1), y1 = std::min(box.y1 - y, kTileHeight + 1);
    for (int row = y0; row < y1; ++row)
      for (int at = ray_place(x0, row); at < ray_place(x1, row); ++at) {  // NaN compares false
        bool inside = true;
        for (int k = 0; k < borders && inside; ++k)
          inside = dot(facet.borders[k], rays.x[at], rays.y[at], rays.z[at]) >= 0;
        if (!inside) continue;
        const float nearness = dot(facet.nearness, rays.x[at], rays.y[at], rays.z[at]);
        if (!(nearness > hits.nearness[at])) continue;
        hits.nearness[at] = nearness;
        hits.facet[at] = box.facet;
      }
  }
}

void find_steps(const Facet* facets, const Rays& rays, const Hits& hits, int first, int count, float step,
                RowBits& met, RowBits& edges) {
  for (int i = 0; i < count; ++i) {
    const int at = first + i;
    const std::int32_t mine = hits.facet[at];
    if (mine >= 0) met.set(i);
    if (!(rays.x[at] == rays.x[at])) continue;
    for (const int by : kNeighbours) {
      const int other = at + by;
      const std::int32_t its = hits.facet[other];
      const float x = rays.x[other], y = rays.y[other], z = rays.z[other];
      if (!(x == x) || mine == its) continue;
      const auto is_smooth = [&](float nearness, float within) {
        return std::fabs(nearness - hits.nearness[other]) <= within * hits.nearness[other];
      };
      if (mine < 0 || its < 0 ||
          (!is_smooth(hits.nearness[at], kLevel * step) &&
           !is_smooth(dot(facets[mine].nearness, x, y, z), step)))
        edges.set(i);
    }
  }
}

void look(const Facet* facets, const Rays& rays, const Rays& right, const Rays& down, const Hits& hits,
          int first, int count, bool slopes, TexCoords& texcoords) {
  for (int i = 0; i < count; ++i) {
    const int at = first + i;
    if (hits.facet[at] < 0) {
      for (auto& row : texcoords.of) row[i] = 0;
      continue;
    }
    const Facet& facet = facets[hits.facet[at]];
    const auto of = [&](const Rays& d, float(&q)[3]) {
      for (int k = 0; k < 3; ++k) q[k] = dot(facet.content[k], d.x[at], d.y[at], d.z[at]);
    };
    float q[3], q_x[3], q_y[3];
    of(rays, q);
    const float inverse = 1.0f / q[2], u = q[0] * inverse, v = q[1] * inverse;
    // Far beyond the content nothing changes any more, but floats must hold it.
    const auto held = [](float value) {
      const float above = value > -1e6f ? value : -1e6f;
      return above < 1e6f ? above : 1e6f;
    };
    texcoords.of[0][i] = held(u);
    texcoords.of[1][i] = held(v);
    if (!slopes) continue;
    of(right, q_x);
    of(down, q_y);
    // Where light grazes, a step of a pixel may pass the horizon: keep to the way there.
    const float reach = 0.5f * (std::fabs(q_x[2]) + std::fabs(q_y[2])), most = 0.9f * q[2];
    const float scale = reach > most ? most / reach * inverse : inverse;
    texcoords.of[2][i] = held((q_x[0] - u * q_x[2]) * scale);
    texcoords.of[3][i] = held((q_x[1] - v * q_x[2]) * scale);
    texcoords.of[4][i] = held((q_y[0] - u * q_y[2]) * scale);
    texcoords.of[5][i] = held((q_y[1] - v * q_y[2]) * scale);
  }
}

}  // namespace

const Kernels kPlainKernels{locate,
                            sample_values,
                            find_cells,
                            sample_cells,
                            sample_light,
                            values_over,
                            light_over,
                            give_alpha_plainly<255>,
                            give_alpha_plainly<kFull>,
                            values_to_rgb,
                            rgb_to_texels,
                            follow,
                            find_slopes,
                            cast,
                            find_steps,
                            look};

}  // namespace procam::render
