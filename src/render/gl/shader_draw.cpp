#include "shaders.hpp"

namespace procam::render_gl {

const char* const kDraw = R"(
uniform bool u_area;
uniform ivec3 u_background;
uniform highp isampler2D u_edges;
uniform highp isampler2DArray u_taps;
uniform highp usampler2D u_values;
layout(location = 0) out vec4 colour;

// The share of the pixel inside the content: its square clipped by the four borders (coverage() in
// src/render/footprint.cpp).
float coverage(Footprint f) {
  vec2 polygon[8], clipped[8];
  polygon[0] = vec2(-0.5);
  polygon[1] = vec2(0.5, -0.5);
  polygon[2] = vec2(0.5);
  polygon[3] = vec2(-0.5, 0.5);
  int count = 4;
  for (int k = 0; k < 4; ++k) {
    int axis = k >> 1;
    vec3 along = k == 0   ? vec3(f.centre.x, f.right.x, f.down.x)
                 : k == 2 ? vec3(f.centre.y, f.right.y, f.down.y)
                 : k == 1 ? vec3(f.centre.z - f.centre.x, f.right.z - f.right.x, f.down.z - f.down.x)
                          : vec3(f.centre.z - f.centre.y, f.right.z - f.right.y, f.down.z - f.down.y);
    int kept = 0;
    for (int i = 0; i < count; ++i) {
      vec2 a = polygon[i], b = polygon[i + 1 == count ? 0 : i + 1];
      float side_a = dot(along, vec3(1.0, a)), side_b = dot(along, vec3(1.0, b));
      if (side_a >= 0.0) clipped[kept++] = a;
      if ((side_a >= 0.0) != (side_b >= 0.0)) clipped[kept++] = a + side_a / (side_a - side_b) * (b - a);
    }
    if (kept < 3) return 0.0;
    for (int i = 0; i < kept; ++i) polygon[i] = clipped[i];
    count = kept;
  }
  float twice_area = 0.0;
  for (int i = 0; i < count; ++i) {
    vec2 a = polygon[i], b = polygon[i + 1 == count ? 0 : i + 1];
    twice_area += a.x * b.y - a.y * b.x;
  }
  return clamp(0.5 * twice_area, 0.0, 1.0);
}

// How far inside the borders the pixel's furthest corner is, and its nearest.
void margins(Footprint f, out float low, out float high) {
  vec2 reach = 0.5 * (abs(f.right.xy) + abs(f.down.xy));
  vec2 other = 0.5 * (abs(f.right.zz - f.right.xy) + abs(f.down.zz - f.down.xy));
  vec2 far = f.centre.zz - f.centre.xy;
  vec2 lows = min(f.centre.xy - reach, far - other), highs = min(f.centre.xy + reach, far + other);
  low = min(lows.x, lows.y);
  high = min(highs.x, highs.y);
}

ivec4 with_plane(ivec4 step_now, ivec2 pixel, vec3 d, vec3 right, vec3 down, bool seen, ivec4 there) {
  ivec4 item = item_of(step_now.x);
  if ((item.y & 4) != 0) {
    d = vec3(vec2(pixel), 1.0);
    right = vec3(1.0, 0.0, 0.0);
    down = vec3(0.0, 1.0, 0.0);
  } else if (!seen) {
    return there;
  }
  Footprint f = footprint_of(item.x, d, right, down);
  float part = 1.0;
  if (step_now.z == 0) {
    float low, high;
    margins(f, low, high);
    if (!(high > 0.0)) return there;
    if (low < 0.0) part = coverage(f);
  }
  int taps = step_now.y + (pixel.y % kTile.y) / 8;
  ivec4 drawn = light_of(step_now.x, unpack_taps(list(taps)), unpack_taps(list(taps + 2)), f, 1e-9);
  if (part < 1.0) drawn = (drawn * int(float(kFull) * part + 0.5) + kFull / 2) / kFull;
  return over(drawn, there);
}

const int kMaxLayers = 8;  // surfaces over each other in one pixel: the farthest beyond that are skipped

ivec4 with_even(int first, int count, ivec2 pixel, vec3 d, vec3 right, vec3 down, ivec4 there) {
  int items[kMaxLayers], facets[kMaxLayers], order[kMaxLayers];
  float nearness[kMaxLayers];
  int met = 0;
  for (int a = 0; a < count; ++a) {
    float mine;
    int item = list(first + a).x, facet = hit_of(item_of(item), pixel, mine);
    if (facet < 0) continue;
    int at = min(met, kMaxLayers - 1);
    if (met == kMaxLayers && !before(a, mine, order[at], nearness[at])) continue;
    for (; at > 0 && before(a, mine, order[at - 1], nearness[at - 1]); --at) {
      items[at] = items[at - 1];
      facets[at] = facets[at - 1];
      order[at] = order[at - 1];
      nearness[at] = nearness[at - 1];
    }
    items[at] = item;
    facets[at] = facet;
    order[at] = a;
    nearness[at] = mine;
    met = min(met + 1, kMaxLayers);
  }
  int last = 0;  // the first opaque one hides the others
  while (last < met && (item_of(items[last]).y & 1) == 0) ++last;
  for (int i = min(last, met - 1); i >= 0; --i) {
    Footprint f = footprint_of(facets[i], d, right, down);
    keep_in_front(f);
    ivec4 item = item_of(items[i]);
    FilterGrid taps = kOneTap, mask_taps = kOneTap;
    if (u_area) taps = unpack_taps(texelFetch(u_taps, ivec3(pixel / ivec2(16, 8), item.w), 0));
    if (u_area && (item.y & 8) != 0)
      mask_taps =
          unpack_taps(texelFetch(u_taps, ivec3(pixel / ivec2(16, 8), record_of(2 * items[i] + 1).w), 0));
    there = over(light_of(items[i], taps, mask_taps, f, 0.0), there);
  }
  return there;
}

#ifdef EDGES
const int kSub = 16, kMaxShown = 24;

vec2 place_of(int k) {  // in the pixel
  return vec2((float(k) + 0.5) / 16.0, (float(4 * (k % 4) + k / 4) + 0.5) / 16.0) - 0.5;
}

// MeshCaster::add_edge, MeshTile::draw_edge
ivec4 with_edge(int first, int count, ivec2 pixel, vec3 d, vec3 right, vec3 down, ivec4 there) {
  int shown_item[kMaxShown], shown_facet[kMaxShown], shown_count[kMaxShown], shown = 0;
  vec2 shown_sum[kMaxShown];
  int met[kSub], which[kSub * kMaxLayers];
  float nearness[kSub * kMaxLayers];
  for (int k = 0; k < kSub; ++k) met[k] = 0;
  for (int a = 0; a < count; ++a) {
    ivec4 step_now = list(first + a), item = item_of(step_now.x);
    int facets[kSub];
    float nearest[kSub];
    for (int k = 0; k < kSub; ++k) {
      facets[k] = -1;
      nearest[k] = 0.0;
    }
    ivec2 block = pixel % kTile / ivec2(16, 8), boxes = list(step_now.y + 8 * block.y + block.x).xy;
    for (int i = 0; i < boxes.y; ++i) {
      ivec4 box = list(boxes.x + i);
      ivec2 low = ivec2(box.x & 0xffff, box.x >> 16), high = ivec2(box.y & 0xffff, box.y >> 16);
      if (any(lessThan(pixel + 2, low)) || any(greaterThanEqual(pixel, high))) continue;
      int row = kFacetTexels * box.z;
      vec4 p = number(row), q = number(row + 1), r = number(row + 2);
      vec3 last = r.xyz, plane = vec3(p.w, q.w, r.w);
      if ((item.y & 2) == 0) last = vec3(number(row + 3).w, number(row + 4).w, number(row + 5).w);
      for (int k = 0; k < kSub; ++k) {
        vec2 at = place_of(k);
        vec3 e = d + at.x * right + at.y * down;
        float mine = dot(plane, e);
        if (dot(p.xyz, e) < 0.0 || dot(q.xyz, e) < 0.0 || dot(r.xyz, e) < 0.0 || dot(last, e) < 0.0 ||
            !(mine > nearest[k]))
          continue;
        nearest[k] = mine;
        facets[k] = box.z;
      }
    }
    for (int k = 0; k < kSub; ++k) {
      if (facets[k] < 0) continue;
      int s = 0;
      while (s < shown && (shown_item[s] != a || shown_facet[s] != facets[k])) ++s;
      if (s == kMaxShown || met[k] == kMaxLayers) continue;
      if (s == shown) {
        shown_item[s] = a;
        shown_facet[s] = facets[k];
        shown_count[s] = 0;
        shown_sum[s] = vec2(0.0);
        ++shown;
      }
      ++shown_count[s];
      shown_sum[s] += place_of(k);
      int at = kMaxLayers * k + met[k];
      for (; at > kMaxLayers * k && before(a, nearest[k], shown_item[which[at - 1]], nearness[at - 1]);
           --at) {
        which[at] = which[at - 1];
        nearness[at] = nearness[at - 1];
      }
      which[at] = s;
      nearness[at] = nearest[k];
      ++met[k];
    }
  }
  ivec4 light[kMaxShown];
  for (int s = 0; s < shown; ++s) {
    int item = list(first + shown_item[s]).x;
    vec2 at = shown_sum[s] / float(shown_count[s]);
    Footprint f = footprint_of(shown_facet[s], d + at.x * right + at.y * down, right, down);
    keep_in_front(f);
    FilterGrid taps[2] = FilterGrid[2](kOneTap, kOneTap);
    for (int n = 0; u_area && n < ((item_of(item).y & 8) != 0 ? 2 : 1); ++n) {
      vec3 size = size_of(f, level_of(2 * item + n, 0).yz);
      taps[n] = choose_taps(size.xy, size.z, size.xy, record_of(2 * item + n).z);
    }
    light[s] = light_of(item, taps[0], taps[1], f, 0.0);
  }
  ivec4 sum = ivec4(0);
  for (int k = 0; k < kSub; ++k) {
    ivec4 seen = there;
    for (int i = met[k] - 1; i >= 0; --i) seen = over(light[which[kMaxLayers * k + i]], seen);
    sum += seen;
  }
  return (sum + kSub / 2) / kSub;
}
#endif

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
#ifdef EDGES
  int edges = texelFetch(u_edges, pixel, 0).x;
#endif
  vec3 d;
  bool seen = ray_of(pixel, d);
  vec3 right = vec3(0.0), down = vec3(0.0);
  if (seen) {
    right = slope_of(pixel, ivec2(1, 0), d);
    down = slope_of(pixel, ivec2(0, 1), d);
  }
  ivec4 light = ivec4(u_background, kFull);
  ivec2 steps = steps_of(pixel);
  int group = 0;
  for (int i = 0; i < steps.y; ++i) {
    ivec4 step_now = list(steps.x + i);
    if (step_now.x >= 0) {
      light = with_plane(step_now, pixel, d, right, down, seen, light);
      continue;
    }
    if (seen) {
#ifdef EDGES
      if ((edges >> min(group, kMaxGroups - 1) & 1) != 0)
        light = with_edge(steps.x + i + 1, step_now.y, pixel, d, right, down, light);
      else
#endif
        light = with_even(steps.x + i + 1, step_now.y, pixel, d, right, down, light);
    }
    ++group;
    i += step_now.y;
  }
  ivec3 at = (light.xyz + 2) / 4;  // LightCurve::value
  colour = vec4(vec3(texelFetch(u_values, place(at.x), 0).x, texelFetch(u_values, place(at.y), 0).x,
                     texelFetch(u_values, place(at.z), 0).x) / 255.0, 1.0);
}
)";

}  // namespace procam::render_gl
