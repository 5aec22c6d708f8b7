#include "shaders.hpp"

namespace procam::render_gl {

const char* const kWholeFrame = R"(
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}
)";

const char* const kCommon = R"(
// Memory: textures whose texels are counted row by row, 2^u_row_bits a row.
uniform highp isampler2D u_lists, u_content;
uniform highp sampler2D u_numbers;
uniform int u_row_bits;
ivec2 place(int at) { return ivec2(at & ((1 << u_row_bits) - 1), at >> u_row_bits); }
ivec4 list(int at) { return texelFetch(u_lists, place(at), 0); }
vec4 number(int at) { return texelFetch(u_numbers, place(at), 0); }
ivec4 texel(int at) { return texelFetch(u_content, place(at), 0); }

const int kFull = 32640;
const ivec2 kTile = ivec2(128, 16);
uniform ivec2 u_frame, u_tiles;
uniform int u_first_tile;
int tile_of(ivec2 pixel) { return pixel.y / kTile.y * u_tiles.x + pixel.x / kTile.x; }

// The ray of a pixel, also of those one beyond the frame; false where the lens has none.
uniform bool u_has_lens;
uniform highp sampler2D u_rays;
uniform mat3 u_direction_from_pixel;
bool ray_of(ivec2 pixel, out vec3 d) {
  if (u_has_lens) {
    vec4 ray = texelFetch(u_rays, pixel + 1, 0);
    d = ray.xyz;
    return ray.w > 0.5;
  }
  d = u_direction_from_pixel * vec3(vec2(pixel), 1.0);
  return true;
}
// Its change by one pixel: half the way between the neighbours, or as far as there are any.
vec3 slope_of(ivec2 pixel, ivec2 by, vec3 d) {
  if (!u_has_lens) return u_direction_from_pixel * vec3(vec2(by), 0.0);
  vec3 ahead, back;
  bool forward = ray_of(pixel + by, ahead), backward = ray_of(pixel - by, back);
  if (!forward) ahead = d;
  if (!backward) back = d;
  return forward && backward ? 0.5 * (ahead - back) : ahead - back;
}

// Facets (src/render/mesh_layer.hpp), kFacetTexels numbers each.
vec3 nearness_plane(int facet) {
  int at = kFacetTexels * facet;
  return vec3(number(at).w, number(at + 1).w, number(at + 2).w);
}
bool meets(int facet, vec3 d, out float nearness) {
  int at = kFacetTexels * facet;
  vec4 a = number(at), b = number(at + 1), c = number(at + 2);
  vec3 last = vec3(number(at + 3).w, number(at + 4).w, number(at + 5).w);
  nearness = dot(vec3(a.w, b.w, c.w), d);
  return dot(a.xyz, d) >= 0.0 && dot(b.xyz, d) >= 0.0 && dot(c.xyz, d) >= 0.0 && dot(last, d) >= 0.0 &&
         nearness > 0.0;
}
mat3 content_rows(int facet) {  // transposed: v * M^T = M v
  int at = kFacetTexels * facet + 3;
  return mat3(number(at).xyz, number(at + 1).xyz, number(at + 2).xyz);
}
// Does item a, at its nearness, lie before item b?
bool before(int a, float near_a, int b, float near_b) {
  if (abs(near_a - near_b) <= 1e-3 * max(near_a, near_b)) return a > b;
  return near_a > near_b;
}

// Items have two records, of the content and of the mask: (first facet, 1 opaque | 2 mesh | 4 not through the
// lens | 8 masked, levels, layer of the hits and taps), of a mask (-, -, levels, layer of the taps), then a
// level each: (first texel, width, height, texels a row).
ivec4 record_of(int record) { return list(kRecordTexels * record); }
ivec4 item_of(int item) { return record_of(2 * item); }
ivec4 level_of(int record, int level) { return list(kRecordTexels * record + 1 + level); }

// What an item in the room shows at a pixel: a facet (of all) and its nearness; -1: nothing.
uniform highp isampler2DArray u_hits;
int hit_of(ivec4 item, ivec2 pixel, out float nearness) {
  ivec2 hit = texelFetch(u_hits, ivec3(pixel + 1, item.w), 0).xy;
  nearness = intBitsToFloat(hit.y);
  return hit.x;
}

// Footprints (src/render/footprint.hpp): content coordinates over one pixel.
struct Footprint { vec3 centre, right, down; };
Footprint footprint_of(int facet, vec3 d, vec3 right, vec3 down) {
  mat3 rows = content_rows(facet);
  return Footprint(d * rows, right * rows, down * rows);
}
void keep_in_front(inout Footprint f) {
  float reach = 0.5 * (abs(f.right.z) + abs(f.down.z)), most = 0.9 * f.centre.z;
  if (!(reach > most)) return;
  f.right *= most / reach;
  f.down *= most / reach;
}
// (squared sides along x and y, squared narrowest width) in texels.
vec3 size_of(Footprint f, ivec2 content) {
  float inverse = 1.0 / f.centre.z;
  vec2 uv = inverse * f.centre.xy;
  vec2 x = inverse * vec2(content) * (f.right.xy - uv * f.right.z);
  vec2 y = inverse * vec2(content) * (f.down.xy - uv * f.down.z);
  float xx = dot(x, x), yy = dot(y, y), xy = dot(x, y), half_difference = 0.5 * (xx - yy);
  return vec3(xx, yy, max(0.0, 0.5 * (xx + yy) - sqrt(half_difference * half_difference + xy * xy)));
}
float spread_at_level(float squared, float one) {
  float width_squared = squared * min(1.0, max(0.0, squared - 1.0));
  return sqrt(max(0.0, width_squared - 3.0 * (one * one - 1.0)));
}
int samples(float spread, float one) {
  return 1 + int(min(1e6, ceil(max(0.0, 1.25 * spread / one - 1.0))));
}
float share(float squared, float one) {
  return squared > 0.0 ? spread_at_level(squared, one) / sqrt(squared) : 0.0;
}
struct FilterGrid { int level, across, down; vec2 shares; };
const FilterGrid kOneTap = FilterGrid(0, 1, 1, vec2(0.0));
FilterGrid choose_taps(vec2 typical, float finest, vec2 largest, int levels) {
  FilterGrid taps = kOneTap;
  if (!(largest.x > 1.0) && !(largest.y > 1.0)) return taps;
  for (;; ++taps.level) {
    float one = float(1 << taps.level);
    taps.across = samples(spread_at_level(largest.x, one), one);
    taps.down = samples(spread_at_level(largest.y, one), one);
    bool enough = finest < 36.0 * one * one && float(taps.across) * float(taps.down) <= 128.0;
    if (enough || taps.level + 1 >= levels) break;
  }
  taps.across = min(taps.across, 128);
  taps.down = min(taps.down, 128 / taps.across);
  float one = float(1 << taps.level);
  taps.shares = vec2(share(typical.x, one), share(typical.y, one));
  return taps;
}
ivec4 pack_taps(FilterGrid taps) {
  return ivec4(taps.level, taps.across | taps.down << 16, floatBitsToInt(taps.shares.x),
               floatBitsToInt(taps.shares.y));
}
FilterGrid unpack_taps(ivec4 p) {
  return FilterGrid(p.x, p.y & 0xffff, p.y >> 16, vec2(intBitsToFloat(p.z), intBitsToFloat(p.w)));
}

// Samples, in the integers of src/render/kernels_plain.cpp: light of 0..kFull.
uniform int u_right_steps;  // shares of a texel to the right: 512, or 128 for values
ivec4 mixed(ivec4 a, ivec4 b, int part) { return a + (((b - a) * part + 0x4000) >> 15); }
ivec4 bilinear(ivec4 level, vec2 position) {  // 512 times the light
  vec2 p = min(max(position - 0.5, vec2(0.0)), vec2(level.yz - 1));
  ivec2 cell = ivec2(p);
  vec2 part = p - vec2(cell);
  int right = int(roundEven(part.x * float(u_right_steps))) * (512 / u_right_steps);
  int down = int(part.y * 32768.0);
  int upper = level.x + cell.y * level.w + cell.x, lower = upper + level.w;
  return (512 - right) * mixed(texel(upper), texel(lower), down) +
         right * mixed(texel(upper + 1), texel(lower + 1), down);
}
// Far beyond the content nothing changes any more, but integers must hold it.
vec2 held(vec2 v) { return clamp(v, -1e6, 1e6); }
// Beyond a border, as far inside it; values have their last texel there.
vec2 mirrored(vec2 position, vec2 size) {
  if (u_right_steps != 512) return position;
  vec2 p = abs(position);
  return min(p, 2.0 * size - p);
}
ivec4 sampled(int record, FilterGrid taps, Footprint f, float min_depth) {
  ivec4 level = level_of(record, taps.level);
  vec2 size = vec2(level.yz);
  float inverse = 1.0 / max(f.centre.z, min_depth);
  vec2 uv = f.centre.xy * inverse, at = held(uv * size);
  vec2 right = held((f.right.xy - uv * f.right.z) * inverse * size);
  vec2 down = held((f.down.xy - uv * f.down.z) * inverse * size);
  vec2 step_by = taps.shares / vec2(taps.across, taps.down);
  ivec4 sum = ivec4(0);
  for (int n = 0; n < taps.down; ++n)
    for (int m = 0; m < taps.across; ++m) {
      float dx = (float(m) - 0.5 * float(taps.across - 1)) * step_by.x,
            dy = (float(n) - 0.5 * float(taps.down - 1)) * step_by.y;
      sum += bilinear(level, mirrored(at + dx * right + dy * down, size));
    }
  return ivec4(roundEven(vec4(sum) / float(512 * taps.across * taps.down)));
}
// An item's content, with the alpha of its mask. (A loop, since drivers write out each call.)
ivec4 light_of(int item, FilterGrid taps, FilterGrid mask_taps, Footprint f, float min_depth) {
  ivec4 light = ivec4(0);
  int records = (item_of(item).y & 8) != 0 ? 2 : 1;
  for (int n = 0; n < records; ++n) {
    ivec4 drawn = sampled(2 * item + n, n == 0 ? taps : mask_taps, f, min_depth);
    light = n == 0 ? drawn : (light * drawn.w + kFull / 2) / kFull;
  }
  return light;
}
ivec4 over(ivec4 drawn, ivec4 there) {
  int rest = kFull - drawn.w, part = rest + (rest >> 8);
  return min(drawn + ((there * part + 0x4000) >> 15), ivec4(kFull));
}

// A tile's steps: (first, count) in the lists. Each (item, taps, fills the tile, -), the taps being the
// content's two and the mask's two; or, before `count` items
// (item, blocks, -, -) that are cast at, (-1, count, -, -).
ivec2 steps_of(ivec2 pixel) { return list(u_first_tile + tile_of(pixel)).xy; }
)";

const char* const kFacetBoxes = R"(
uniform highp isampler2D u_lists;
uniform highp sampler2D u_numbers;
uniform int u_row_bits, u_first_box;
uniform ivec2 u_frame;
flat out int facet;
flat out vec3 border_a, border_b, border_c, nearness_plane_of;
ivec2 place(int at) { return ivec2(at & ((1 << u_row_bits) - 1), at >> u_row_bits); }
void main() {
  ivec4 box = texelFetch(u_lists, place(u_first_box + gl_InstanceID), 0);
  facet = box.z;
  vec4 a = texelFetch(u_numbers, place(kFacetTexels * facet), 0);
  vec4 b = texelFetch(u_numbers, place(kFacetTexels * facet + 1), 0);
  vec4 c = texelFetch(u_numbers, place(kFacetTexels * facet + 2), 0);
  border_a = a.xyz;
  border_b = b.xyz;
  border_c = c.xyz;
  nearness_plane_of = vec3(a.w, b.w, c.w);
  // The target has a rim of one pixel, as the boxes have.
  ivec2 begin = ivec2(box.x & 0xffff, box.x >> 16), end = ivec2(box.y & 0xffff, box.y >> 16);
  ivec2 corner = ivec2((gl_VertexID & 1) != 0 ? end.x : begin.x, (gl_VertexID & 2) != 0 ? end.y : begin.y);
  gl_Position = vec4(2.0 * vec2(corner) / vec2(u_frame + 2) - 1.0, 0.0, 1.0);
}
)";

const char* const kFindHits = R"(
flat in int facet;
flat in vec3 border_a, border_b, border_c, nearness_plane_of;
layout(location = 0) out highp ivec2 hit;
void main() {
  vec3 d;
  if (!ray_of(ivec2(gl_FragCoord.xy) - 1, d)) discard;
  float nearness = dot(nearness_plane_of, d);
  if (dot(border_a, d) < 0.0 || dot(border_b, d) < 0.0 || dot(border_c, d) < 0.0 || !(nearness > 0.0)) discard;
  hit = ivec2(facet, floatBitsToInt(nearness));
  gl_FragDepth = 1.0 / (1.0 + nearness);
}
)";

const char* const kFindPlaneHits = R"(
uniform int u_facet;
layout(location = 0) out highp ivec2 hit;
void main() {
  vec3 d;
  float nearness;
  bool met = ray_of(ivec2(gl_FragCoord.xy) - 1, d) && meets(u_facet, d, nearness);
  hit = met ? ivec2(u_facet, floatBitsToInt(nearness)) : ivec2(-1, 0);
}
)";

const char* const kFindEdges = R"(
layout(location = 0) out highp int edges;

// Do the pixel's neighbours see the same surfaces in the same order? (MeshCaster::is_even)
bool even(int first, int count, ivec2 pixel) {
  for (int a = 0; a < count; ++a) {
    ivec4 item = item_of(list(first + a).x);
    float mine_near, its_near, here, there;
    int mine = hit_of(item, pixel, mine_near);
    for (int n = 0; n < 9; ++n) {
      ivec2 other = pixel + ivec2(n % 3, n / 3) - 1;
      int its = hit_of(item, other, its_near);
      vec3 d;
      if (its != mine) {
        if (!ray_of(other, d)) continue;
        if (mine < 0 || its < 0) return false;
        float most = 0.02 * its_near, level = 0.0025 * its_near;  // kStep, kLevel * kStep
        if (!(abs(mine_near - its_near) <= level) && !(abs(dot(nearness_plane(mine), d) - its_near) <= most))
          return false;
      }
      if (mine < 0) continue;
      for (int b = 0; b < a; ++b) {
        ivec4 under = item_of(list(first + b).x);
        if (hit_of(under, other, there) >= 0 && hit_of(under, pixel, here) >= 0 &&
            before(a, mine_near, b, here) != before(a, its_near, b, there))
          return false;
      }
    }
  }
  return true;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  edges = 0;
  vec3 d;
  if (!ray_of(pixel, d)) discard;
  ivec2 steps = steps_of(pixel);
  int group = 0;
  for (int i = 0; i < steps.y; ++i) {
    ivec4 step_now = list(steps.x + i);
    if (step_now.x >= 0) continue;
    if (!even(steps.x + i + 1, step_now.y, pixel)) edges |= 1 << min(group, kMaxGroups - 1);
    ++group;
    i += step_now.y;
  }
  if (edges == 0) discard;
}
)";

const char* const kChooseTaps = R"(
uniform int u_item, u_record;
layout(location = 0) out highp ivec4 taps;

void main() {  // MeshCaster::taps_of; a fragment a block
  ivec2 block = ivec2(gl_FragCoord.xy), low = block * ivec2(16, 8), high = min(low + ivec2(16, 8), u_frame);
  ivec4 item = item_of(u_item);
  ivec2 content = level_of(u_record, 0).yz;
  float finest = 0.0;
  vec2 largest = vec2(0.0), logs = vec2(0.0);
  int count = 0;
  for (int y = low.y; y < high.y; y += 3)
    for (int x = low.x + (y & 15) % 3; x < high.x; x += 3) {
      vec3 d;
      float nearness;
      ivec2 pixel = ivec2(x, y);
      if (!ray_of(pixel, d)) continue;
      int facet = hit_of(item, pixel, nearness);
      if (facet < 0) continue;
      Footprint f =
          footprint_of(facet, d, slope_of(pixel, ivec2(1, 0), d), slope_of(pixel, ivec2(0, 1), d));
      keep_in_front(f);
      vec3 size = size_of(f, content);
      finest = count++ == 0 ? size.z : min(finest, size.z);
      largest = max(largest, size.xy);
      logs += log(max(size.xy, vec2(1e-12)));
    }
  taps = pack_taps(kOneTap);
  if (count == 0) return;
  vec2 typical = exp(logs / float(count));
  taps = pack_taps(choose_taps(typical, finest, min(largest, 9.0 * typical), record_of(u_record).z));
}
)";

const char* const kCopy = R"(
uniform highp sampler2D u_drawn;
uniform int u_rows;
layout(location = 0) out vec4 colour;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  colour = texelFetch(u_drawn, ivec2(pixel.x, u_rows - 1 - pixel.y), 0);
}
)";

}  // namespace procam::render_gl
