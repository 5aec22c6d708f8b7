#include "procam/surface/blend.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <queue>

#include "positions.hpp"
#include "procam/core/base/parallel.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/surface/warp.hpp"

namespace procam::surface {

namespace {

constexpr double kJump = 0.01;     ///< share of the distance beyond which a step in depth throws a shadow
constexpr double kAtShadow = 0.5;  ///< px: distance of a pixel at a shadow's border
constexpr float kMinReflectance = 0.01F;

/// What the light of a projector meets, pixel by pixel.
struct View {
  const Projector* projector = nullptr;
  ImageSize size;
  int threads = 0;
  std::vector<int> surface;                                 ///< by its place in the list of names; -1: none
  std::vector<Eigen::Vector3f> point;                       ///< in the projector's frame
  std::vector<float> range;                                 ///< to it, metres
  std::vector<Eigen::Vector3f> area;                        ///< the pixel's area there, along the normal
  std::vector<float> from_shadow;                           ///< px
  std::vector<float> light;                                 ///< E
  std::vector<std::optional<Pose>> projector_from_surface;  ///< by the list of names

  std::size_t at(int x, int y) const { return std::size_t(y) * std::size_t(size.width) + std::size_t(x); }
  /// Is it one smooth surface from pixel i to pixel j, as far as shadows go?
  bool goes_on(std::size_t i, std::size_t j) const {
    if (surface[i] < 0 || surface[j] < 0) return false;
    const float a = range[i], b = range[j];
    return std::abs(a - b) <= float(kJump) * std::min(a, b);
  }
  double half_side() const { return 0.5 * std::min(size.width, size.height); }
  /// d of a pixel, so far from a shadow: smooth, and falling to zero in proportion to the distance.
  double distance(const Vec2& pixel, double to_shadow) const {
    const double x = (pixel.x() + 0.5) / size.width, y = (pixel.y() + 0.5) / size.height;
    const double t = std::min(1.0, to_shadow / half_side());
    return 16 * x * (1 - x) * y * (1 - y) * t * (2 - t);
  }
};

template <typename Work>
void each_row(const View& view, const Work& work) {
  parallel_for(view.size.height, view.threads, [&](int begin, int end) {
    for (int y = begin; y < end; ++y) work(y);
  });
}

float sample(ViewF picture, const Vec2& uv) {
  const auto place = [](double at, int count) {
    return std::min(std::max(at * count - 0.5, 0.0), count - 1.0);
  };
  const double x = place(uv.x(), picture.width), y = place(uv.y(), picture.height);
  const int x0 = int(x), y0 = int(y), x1 = std::min(x0 + 1, picture.width - 1),
            y1 = std::min(y0 + 1, picture.height - 1);
  const auto s = float(x - x0), t = float(y - y0);
  return (1 - t) * ((1 - s) * picture.at(x0, y0) + s * picture.at(x1, y0)) +
         t * ((1 - s) * picture.at(x0, y1) + s * picture.at(x1, y1));
}

/// Puts a surface where it is the nearest; where two lie together the later one shows.
void add_surface(const SolvedSurface& solved, int name, const ViewF* reflectance, const ImageF& directions,
                 View& view) {
  const ImageF positions = positions_along(directions, solved.placement, *view.projector, view.threads);
  std::optional<WarpMap> content;
  if (reflectance || !solved.surface.shape.is_whole()) content = warp_map(solved.placement, *view.projector);
  each_row(view, [&](int y) {
    for (int x = 0; x < view.size.width; ++x) {
      const Eigen::Vector3f point(positions.at(x, y, 0), positions.at(x, y, 1), positions.at(x, y, 2));
      if (!(point.squaredNorm() > 0)) continue;  // NaN too
      const std::size_t i = view.at(x, y);
      if (view.surface[i] >= 0 && point.norm() > 1.001F * view.range[i]) continue;
      if (content && (!content->shows(x, y) || !in_shape(solved.surface.shape, content->at(x, y)))) continue;
      view.surface[i] = name;
      view.point[i] = point;
      view.range[i] = point.norm();
      view.light[i] = reflectance ? std::max(kMinReflectance, sample(*reflectance, content->at(x, y))) : 1;
    }
  });
}

/// The area that each pixel covers, from where its neighbours' light lands.
void find_areas(View& view) {
  const auto step = [&](std::size_t i, bool before, bool after, std::size_t stride) -> Eigen::Vector3f {
    const bool back = before && view.surface[i - stride] == view.surface[i] && view.goes_on(i, i - stride);
    const bool on = after && view.surface[i + stride] == view.surface[i] && view.goes_on(i, i + stride);
    const Eigen::Vector3f& from = view.point[back ? i - stride : i];
    const Eigen::Vector3f& to = view.point[on ? i + stride : i];
    return (to - from) / (back && on ? 2.0F : 1.0F);
  };
  each_row(view, [&](int y) {
    for (int x = 0; x < view.size.width; ++x) {
      const std::size_t i = view.at(x, y);
      if (view.surface[i] < 0) continue;
      view.area[i] = step(i, x > 0, x + 1 < view.size.width, 1)
                         .cross(step(i, y > 0, y + 1 < view.size.height, std::size_t(view.size.width)));
    }
  });
}

/// A pixel without neighbours to tell its area is no better than one beside the surface.
void drop_unknown_areas(View& view) {
  for (std::size_t i = 0; i < view.surface.size(); ++i)
    if (!(view.area[i].squaredNorm() > 0)) {
      view.surface[i] = -1;
      view.range[i] = 0;
    }
}

/// How far, along the surfaces, each pixel is from the border of a shadow: from pixels beside which something
/// stands at least a hundredth nearer. Steps to the eight neighbours (8 % long at worst), as far as matters.
void find_shadows(View& view) {
  using Front = std::pair<float, std::size_t>;
  std::priority_queue<Front, std::vector<Front>, std::greater<>> front;
  const auto neighbours = [&](std::size_t i, auto&& visit) {
    const int x = int(i) % view.size.width, y = int(i) / view.size.width;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if ((dx != 0 || dy != 0) && x + dx >= 0 && y + dy >= 0 && x + dx < view.size.width &&
            y + dy < view.size.height)
          visit(view.at(x + dx, y + dy), dx != 0 && dy != 0 ? std::sqrt(2.0F) : 1.0F);
  };
  std::vector<char> at_shadow(view.surface.size(), 0);
  each_row(view, [&](int y) {
    const int first = std::max(y - 1, 0), last = std::min(y + 1, view.size.height - 1);
    for (int x = 0; x < view.size.width; ++x) {
      const std::size_t i = view.at(x, y);
      const float nearer = view.range[i] / (1 + float(kJump));  // without a surface 0: nothing is nearer
      bool found = false;
      for (int v = first; v <= last; ++v)
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, view.size.width - 1); ++u) {
          const float range = view.range[view.at(u, v)];
          found |= range > 0 && range < nearer;
        }
      at_shadow[i] = char(found);
    }
  });
  for (std::size_t i = 0; i < at_shadow.size(); ++i) {
    if (at_shadow[i] == 0) continue;
    view.from_shadow[i] = float(kAtShadow);
    front.emplace(view.from_shadow[i], i);
  }
  while (!front.empty()) {
    const float distance = front.top().first;
    const std::size_t i = front.top().second;
    front.pop();
    if (distance > view.from_shadow[i] || distance > view.half_side()) continue;
    neighbours(i, [&](std::size_t j, float step) {
      if (!view.goes_on(i, j) || !(distance + step < view.from_shadow[j])) return;
      view.from_shadow[j] = distance + step;
      front.emplace(view.from_shadow[j], j);
    });
  }
}

View look(const BlendInput& lit, const std::vector<std::string>& names, const BlendOptions& options) {
  View view;
  view.projector = &lit.projector;
  view.size = lit.projector.size();
  view.threads = options.threads;
  const std::size_t pixels = std::size_t(view.size.width) * std::size_t(view.size.height);
  view.surface.assign(pixels, -1);
  view.point.assign(pixels, Eigen::Vector3f::Zero());
  view.range.assign(pixels, 0);
  view.area.assign(pixels, Eigen::Vector3f::Zero());
  view.from_shadow.assign(pixels, std::numeric_limits<float>::infinity());
  view.light.assign(pixels, 1);
  view.projector_from_surface.resize(names.size());
  const ImageF directions = light_directions(lit.projector, options.threads);
  for (const SolvedSurface& solved : lit.surfaces->surfaces) {
    const auto pose = std::visit(
        [](const auto& placed) -> std::optional<Pose> {
          if constexpr (std::is_same_v<std::decay_t<decltype(placed)>, PlacedPixels>)
            return std::nullopt;
          else
            return placed.projector_from_surface;
        },
        solved.placement);
    if (!pose) continue;
    const auto name = std::size_t(std::find(names.begin(), names.end(), solved.surface.name) - names.begin());
    view.projector_from_surface[name] = pose;
    const auto reflectance = options.reflectance.find(solved.surface.name);
    add_surface(solved, int(name), reflectance == options.reflectance.end() ? nullptr : &reflectance->second,
                directions, view);
  }
  find_areas(view);
  drop_unknown_areas(view);
  find_shadows(view);
  for (std::size_t i = 0; i < pixels; ++i) {
    if (!options.compensate || view.surface[i] < 0) {
      view.light[i] = 1;
      continue;
    }
    view.light[i] *= float(lit.brightness / double(pixels)) / view.area[i].norm();
  }
  return view;
}

/// What a projector does to a place of a surface.
struct Reach {
  double distance = 0;  ///< d; 0: its light does not get there
  double light = 0;     ///< E there
};

/// At a point of surface `name`, in the projector's frame.
Reach reach(const View& view, int name, const Vec3& point) {
  const std::optional<Vec2> pixel = view.projector->project(point);
  if (!pixel || !view.size.contains(*pixel)) return {};
  const int x0 = int(std::floor(pixel->x())), y0 = int(std::floor(pixel->y()));
  const double range = point.norm();
  double sum = 0, from_shadow = 0, light = 0;
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx) {
      const int x = std::min(std::max(x0 + dx, 0), view.size.width - 1),
                y = std::min(std::max(y0 + dy, 0), view.size.height - 1);
      const std::size_t i = view.at(x, y);
      if (view.surface[i] != name || std::abs(double(view.range[i]) - range) > kJump * range) continue;
      const double weight = (1 - std::abs(pixel->x() - x0 - dx)) * (1 - std::abs(pixel->y() - y0 - dy));
      sum += weight;
      from_shadow += weight * std::min(double(view.from_shadow[i]), view.half_side());
      light += weight * double(view.light[i]);
    }
  if (!(sum > 0)) return {};
  return {view.distance(*pixel, from_shadow / sum), light / sum};
}

/// The light of one projector's pixel and what the others do to its place.
struct Sum {
  float weight = 1;  ///< w
  float black = 0;   ///< S
  float most = 0;    ///< light that they can give together with these weights: the least of E / w
};

/// Another projector and a surface that it lights too, as seen from the projector whose places are summed up.
struct Neighbour {
  std::size_t number = 0;
  Pose other_from_own;
  Vec3 lamp;  ///< where it stands
};

/// Of each surface: who else may light it.
std::vector<std::vector<Neighbour>> candidates(std::size_t own, const std::vector<View>& views) {
  const std::size_t names = views[own].projector_from_surface.size();
  std::vector<std::vector<Neighbour>> found(names);
  for (std::size_t name = 0; name < names; ++name) {
    const std::optional<Pose>& here = views[own].projector_from_surface[name];
    for (std::size_t j = 0; here && j < views.size(); ++j) {
      const std::optional<Pose>& other = views[j].projector_from_surface[name];
      if (j == own || !other) continue;
      found[name].push_back({j, *other * here->inverse(), *here * (other->inverse() * Vec3(0, 0, 0))});
    }
  }
  return found;
}

/// `reached`: sets those to 1 whose light reaches a place of the projector's.
std::vector<Sum> sum_up(std::size_t own, const std::vector<View>& views,
                        const std::vector<BlendInput>& projectors, std::vector<std::atomic<char>>& reached) {
  const View& view = views[own];
  std::vector<Sum> sums(view.surface.size());
  const std::vector<std::vector<Neighbour>> others = candidates(own, views);
  each_row(view, [&](int y) {
    for (int x = 0; x < view.size.width; ++x) {
      const std::size_t i = view.at(x, y);
      const int name = view.surface[i];
      if (name < 0) continue;
      const double d = view.distance(Vec2(x, y), double(view.from_shadow[i]));
      double squares = d * d;
      double least = double(view.light[i]) / squares;
      double black = projectors[own].black * double(view.light[i]);
      const Vec3 point = view.point[i].cast<double>(), normal = view.area[i].cast<double>();
      for (const Neighbour& other : others[std::size_t(name)]) {
        // It lights the other side.
        if (normal.dot(point) * normal.dot(point - other.lamp) < 0) continue;
        const Reach there = reach(views[other.number], name, other.other_from_own * point);
        if (!(there.distance > 0)) continue;
        reached[other.number].store(1, std::memory_order_relaxed);
        squares += there.distance * there.distance;
        least = std::min(least, there.light / (there.distance * there.distance));
        black += projectors[other.number].black * there.light;
      }
      sums[i] = {float(d * d / squares), float(black), float(least * squares)};
    }
  });
  return sums;
}

/// Pixels of which only a part lies on a surface have their middle beside it: they take what their neighbours
/// have.
void fill_rim(const std::vector<int>& surface, BlendMap& map) {
  const int width = map.weight.width(), height = map.weight.height();
  const auto on = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < width && y < height &&
           surface[std::size_t(y) * std::size_t(width) + std::size_t(x)] >= 0;
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (on(x, y)) continue;
      float weight = 0, gain = 0, lift = 0;
      int count = 0;
      for (int v = y - 1; v <= y + 1; ++v)
        for (int u = x - 1; u <= x + 1; ++u)
          if (on(u, v)) {
            weight += map.weight.at(u, v);
            gain += map.gain.at(u, v);
            lift += map.lift.at(u, v);
            ++count;
          }
      if (count == 0) continue;
      map.weight.at(x, y) = weight / float(count);
      map.gain.at(x, y) = gain / float(count);
      map.lift.at(x, y) = lift / float(count);
    }
}

void require_valid(const std::vector<BlendInput>& projectors, const BlendOptions& options) {
  require(!options.only || *options.only < projectors.size(), "blend_maps: 'only' is none of the projectors");
  require(options.min_gain > 0 && options.min_gain <= 1, "blend_maps: min_gain is not in (0, 1]");
  for (const auto& [name, picture] : options.reflectance) {
    bool good = picture.channels == 1 && !picture.empty() && options.compensate;
    for (int y = 0; good && y < picture.height; ++y)
      good = std::all_of(picture.row(y), picture.row(y) + picture.width,
                         [](float v) { return v >= 0 && v < 1e30F; });
    require(good, "blend_maps: the reflectance of '" + name +
                      "' is not one channel of numbers, or not compensated");
  }
  for (const BlendInput& lit : projectors)
    require(lit.surfaces && lit.brightness > 0 && lit.black >= 0 && lit.black < 1,
            "blend_maps: a projector without surfaces, with brightness 0 or less, or black outside [0, 1)");
}

/// Of all surfaces, each once.
std::vector<std::string> surface_names(const std::vector<BlendInput>& projectors, Diagnostics& diagnostics) {
  std::vector<std::string> names;
  for (const BlendInput& lit : projectors)
    for (const SolvedSurface& solved : lit.surfaces->surfaces) {
      const std::string& name = solved.surface.name;
      if (std::find(names.begin(), names.end(), name) != names.end()) continue;
      names.push_back(name);
      if (std::holds_alternative<PlacedPixels>(solved.placement))
        diagnostics.warn("no_place",
                         "surface '" + name +
                             "' is given in a projector's pixels, so where the others light it is "
                             "not known: it is not blended; define it in metres");
    }
  return names;
}

/// E_0 and B of each surface, or of all.
struct Levels {
  bool one_level = false;
  std::vector<double> level, black;

  std::size_t group(int surface) const { return one_level ? 0 : std::size_t(surface); }
};

Levels levels_of(const std::vector<View>& views, const std::vector<std::vector<Sum>>& sums,
                 const std::vector<std::string>& names, const BlendOptions& options,
                 Diagnostics& diagnostics) {
  const std::size_t groups = options.one_level ? 1 : names.size();
  Levels out{options.one_level, std::vector<double>(groups, 1), std::vector<double>(groups, 0)};
  std::vector<std::vector<float>> possible(groups);
  for (std::size_t p = 0; p < views.size() && options.compensate; ++p)
    for (std::size_t i = 0; i < sums[p].size(); ++i)
      if (views[p].surface[i] >= 0) possible[out.group(views[p].surface[i])].push_back(sums[p][i].most);
  for (std::size_t g = 0; g < groups; ++g) {
    if (!options.compensate || possible[g].empty()) continue;
    const double darkest = double(quantile(possible[g], 0.01)),
                 brightest = double(quantile(possible[g], 0.99));
    out.level[g] = std::max(darkest, options.min_gain * brightest);
    if (darkest < out.level[g])
      diagnostics.warn("stays_dark",
                       (options.one_level ? std::string("the surfaces' darkest places")
                                          : "surface '" + names[g] + "': its darkest places") +
                           " get " + std::to_string(int(std::lround(100 * darkest / brightest))) +
                           " % of the brightest's light; they stay darker than the rest, which is held at " +
                           std::to_string(int(std::lround(100 * options.min_gain))) +
                           " % (least gain): lower it for an even, darker picture");
  }
  for (std::size_t p = 0; p < views.size(); ++p)
    for (std::size_t i = 0; i < sums[p].size(); ++i)
      if (views[p].surface[i] >= 0) {
        const std::size_t g = out.group(views[p].surface[i]);
        out.black[g] = std::max(out.black[g], std::min(1.0, double(sums[p][i].black) / out.level[g]));
      }
  return out;
}

/// `full_white`: light of the projector's white over its black.
BlendMap map_of(const View& view, const std::vector<Sum>& sums, const Levels& levels, double full_white) {
  BlendMap map{ImageF(view.size), ImageF(view.size, 1, 1.0F), ImageF(view.size)};
  each_row(view, [&](int y) {
    for (int x = 0; x < view.size.width; ++x) {
      const std::size_t i = view.at(x, y);
      if (view.surface[i] < 0) continue;
      const std::size_t g = levels.group(view.surface[i]);
      const double level = levels.level[g], black = levels.black[g], w = double(sums[i].weight);
      const double full = full_white * double(view.light[i]);
      const double lift = std::min(1.0, std::max(0.0, w * (level * black - double(sums[i].black)) / full));
      map.weight.at(x, y) = float(w);
      map.lift.at(x, y) = float(lift);
      map.gain.at(x, y) = float(std::min(w * level * (1 - black) / full, 1 - lift));
    }
  });
  fill_rim(view.surface, map);
  return map;
}

}  // namespace

Blend blend_maps(const std::vector<BlendInput>& projectors, const BlendOptions& options) {
  require_valid(projectors, options);
  Blend blend;
  const std::vector<std::string> names = surface_names(projectors, blend.diagnostics);
  std::vector<View> views;
  views.reserve(projectors.size());
  for (const BlendInput& lit : projectors) views.push_back(look(lit, names, options));
  // Black and brightness are brought to a level of all places.
  const bool has_level =
      options.compensate ||
      std::any_of(projectors.begin(), projectors.end(), [](const BlendInput& lit) { return lit.black > 0; });
  const auto is_wanted = [&](std::size_t p) { return !options.only || *options.only == p; };
  std::vector<std::vector<Sum>> sums(views.size());
  blend.neighbours.resize(views.size());
  for (std::size_t p = 0; p < views.size(); ++p) {
    if (!is_wanted(p) && !has_level) continue;
    std::vector<std::atomic<char>> reached(views.size());
    sums[p] = sum_up(p, views, projectors, reached);
    for (std::size_t j = 0; j < views.size() && is_wanted(p); ++j)
      if (reached[j] != 0) blend.neighbours[p].push_back(j);
  }
  const Levels levels = levels_of(views, sums, names, options, blend.diagnostics);
  blend.maps.resize(views.size());
  for (std::size_t p = 0; p < views.size(); ++p)
    if (is_wanted(p)) blend.maps[p] = map_of(views[p], sums[p], levels, 1 - projectors[p].black);
  return blend;
}

}  // namespace procam::surface
