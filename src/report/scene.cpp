#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "html.hpp"
#include "pictures.hpp"

namespace procam::report {

using analyze::NextView;
namespace {

using calibrate::CalibrationResult;

constexpr double kWidth = 900, kHeight = 540, kMargin = 36;
constexpr double kScaleBarRoom = 36;  ///< below the picture, for the scale bar

/// Orthographic: x to the right, y (down in the rig's frame) down, seen from `yaw` around and `pitch` above.
/// The page's script uses the same equations.
struct Viewpoint {
  double yaw = 0.6, pitch = 0.42;
  double scale = 1;  ///< SVG units a metre
  Vec3 centre = Vec3::Zero();
  Vec2 middle = 0.5 * Vec2(kWidth, kHeight);

  Vec2 flat(const Vec3& point_in_rig) const {
    const Vec3 p = point_in_rig - centre;
    const double right = std::cos(yaw) * p.x() - std::sin(yaw) * p.z();
    const double depth = std::sin(yaw) * p.x() + std::cos(yaw) * p.z();
    return Vec2(right, std::cos(pitch) * p.y() - std::sin(pitch) * depth);
  }
  double depth(const Vec3& point_in_rig) const {
    return std::cos(pitch) * (std::sin(yaw) * point_in_rig.x() + std::cos(yaw) * point_in_rig.z()) +
           std::sin(pitch) * point_in_rig.y();
  }
  Vec2 operator()(const Vec3& point_in_rig) const { return middle + scale * flat(point_in_rig); }

  /// So that all points lie inside the picture.
  static Viewpoint fitted(const Points3& points) {
    Viewpoint view;
    Vec3 low = points.front(), high = points.front();
    for (const Vec3& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
    view.centre = 0.5 * (low + high);
    Vec2 flat_low = view.flat(points.front()), flat_high = flat_low;
    for (const Vec3& p : points)
      flat_low = flat_low.cwiseMin(view.flat(p)), flat_high = flat_high.cwiseMax(view.flat(p));
    const Vec2 span = (flat_high - flat_low).cwiseMax(1e-6);
    view.scale = std::min((kWidth - 2 * kMargin) / span.x(), (kHeight - 2 * kMargin) / span.y());
    view.middle -= 0.5 * view.scale * (flat_low + flat_high);
    return view;
  }
};

/// Shapes that carry their points in space (whole millimetres) beside their drawing, for the script.
class Scene {
 public:
  explicit Scene(const Viewpoint& view) : view_(view) {}

  void shape(const std::vector<Points3>& lines, bool closed, const std::string& attributes,
             const std::string& tip = "") {
    std::string d, points;
    for (const Points3& line : lines) {
      if (!points.empty()) points += ';';
      for (std::size_t i = 0; i < line.size(); ++i) {
        d += (i == 0 ? "M" : "L") + position(view_(line[i]));
        points += (i == 0 ? "" : " ") + millimetres(line[i]);
      }
      if (closed) d += 'Z';
    }
    content_ += "<path " + attributes + (closed ? " data-closed=\"1\"" : "") + " data-p=\"" + points +
                "\" d=\"" + d + "\"";
    content_ += tip.empty() ? "/>\n" : ">" + element("title", "", escaped(tip)) + "</path>\n";
  }

  void words(const Vec3& at, const std::string& attributes, const std::string& text) {
    content_ += label(view_(at), "data-p=\"" + millimetres(at) + "\" " + attributes, text) + "\n";
  }

  void raw(const std::string& svg) { content_ += svg; }
  const std::string& content() const { return content_; }

 private:
  static std::string millimetres(const Vec3& p) {
    return fixed(1e3 * p.x(), 0) + " " + fixed(1e3 * p.y(), 0) + " " + fixed(1e3 * p.z(), 0);
  }

  const Viewpoint& view_;
  std::string content_;
};

Points3 rectangle_in_board(double left, double top, double right, double bottom) {
  return {Vec3(left, top, 0), Vec3(right, top, 0), Vec3(right, bottom, 0), Vec3(left, bottom, 0)};
}

/// The printed sheet: its outline and its dark squares, in the board's frame.
struct DrawnSheet {
  Points3 outline;
  std::vector<Points3> dark;
};

/// A chequered field whose inner corners begin one square inside it.
DrawnSheet chequered(int columns, int rows, double s, bool dark_first) {
  DrawnSheet sheet{rectangle_in_board(-s, -s, columns * s, rows * s), {}};
  for (int row = -1; row < rows; ++row)
    for (int column = -1; column < columns; ++column)
      if (((row + column) % 2 == 0) == dark_first)
        sheet.dark.push_back(rectangle_in_board(column * s, row * s, (column + 1) * s, (row + 1) * s));
  return sheet;
}

DrawnSheet sheet_of(const Chessboard& board) {
  return chequered(board.columns, board.rows, board.square_size, true);
}

/// Without its markers, which are too fine here.
DrawnSheet sheet_of(const CharucoBoard& board) {
  return chequered(board.columns - 1, board.rows - 1, board.square_size, !board.marker_first);
}

DrawnSheet sheet_of(const MarkerGrid& board) {
  const double m = board.marker_size, gap = board.gap, step = m + gap;
  DrawnSheet sheet{rectangle_in_board(-gap, -gap, board.columns * step, board.rows * step), {}};
  for (int id = 0; id < board.marker_count(); ++id) {
    const Vec2 first = board.marker_in_board(id);
    sheet.dark.push_back(rectangle_in_board(first.x(), first.y(), first.x() + m, first.y() + m));
  }
  return sheet;
}

DrawnSheet sheet_of(const AprilGrid& board) {
  const double tag = board.tag_size, gap = board.gap(), step = tag + gap;
  DrawnSheet sheet{rectangle_in_board(-gap, -gap, board.columns * step, board.rows * step), {}};
  for (int id = 0; id < board.marker_count(); ++id) {
    const Vec2 first = board.marker_in_board(id);
    sheet.dark.push_back(rectangle_in_board(first.x(), first.y(), first.x() + tag, first.y() + tag));
  }
  return sheet;
}

/// Its circles as octagons.
DrawnSheet sheet_of(const CircleGrid& board) {
  const Vec3 last = board.point_in_board(board.size() - 1);
  const double right = last.x() + (board.asymmetric && board.rows % 2 == 1 ? board.spacing : 0);
  const double rim = board.spacing;
  DrawnSheet sheet{rectangle_in_board(-rim, -rim, right + rim, last.y() + rim), {}};
  for (const Vec3& centre : points_in_board(board)) {
    Points3& octagon = sheet.dark.emplace_back();
    for (int i = 0; i < 8; ++i)
      octagon.push_back(centre + 0.5 * board.diameter *
                                     Vec3(std::cos(i * EIGEN_PI / 4), std::sin(i * EIGEN_PI / 4), 0));
  }
  return sheet;
}

Points3 moved(const Pose& rig_from_thing, Points3 points) {
  for (Vec3& p : points) p = rig_from_thing * p;
  return points;
}

struct Body {
  std::string name;
  bool light = false;
  Camera lens;
  Pose rig_from_device;
};

std::vector<Body> bodies_of(const Rig& rig) {
  std::vector<Body> bodies;
  for (const RigCamera& c : rig.cameras) bodies.push_back({c.name, false, c.camera, c.rig_from_camera});
  for (const RigProjector& p : rig.projectors)
    bodies.push_back({p.name, true, p.projector.inverse_camera, p.rig_from_projector});
  const auto nowhere = [](const Body& b) { return !b.rig_from_device.is_finite(); };
  bodies.erase(std::remove_if(bodies.begin(), bodies.end(), nowhere), bodies.end());
  return bodies;
}

/// The picture's four corners at a depth, in the rig's frame; fewer where the lens has no inverse.
Points3 picture_at(const Body& body, double depth) {
  const double right = body.lens.size.width - 0.5, bottom = body.lens.size.height - 0.5;
  Points3 corners;
  for (const Vec2& pixel : {Vec2(-0.5, -0.5), Vec2(right, -0.5), Vec2(right, bottom), Vec2(-0.5, bottom)})
    if (const auto bearing = body.lens.unproject(pixel); bearing && bearing->z() > 1e-3)
      corners.push_back(body.rig_from_device * Vec3(*bearing * (depth / bearing->z())));
  return corners;
}

void draw_body(Scene& scene, const Body& body, double near, double far) {
  const Vec3& origin = body.rig_from_device.translation;
  const std::string kind = body.light ? "light" : "sight";
  const Points3 close = picture_at(body, near), distant = picture_at(body, far);
  std::vector<Points3> rays;
  for (const Vec3& corner : distant) rays.push_back({origin, corner});
  if (!rays.empty()) scene.shape(rays, false, "class=\"ray " + kind + "\"");
  std::vector<Points3> sides;
  for (std::size_t i = 0; i < close.size(); ++i)
    sides.push_back({origin, close[i], close[(i + 1) % close.size()]});
  if (!sides.empty()) scene.shape(sides, true, "class=\"body " + kind + "\"", body.name);
  scene.words(origin, "class=\"tick halo " + kind + "\" text-anchor=\"middle\" dy=\"18\"", body.name);
}

void draw_axes(Scene& scene, double length) {
  const std::vector<std::pair<std::string, Vec3>> axes = {
      {"x", Vec3::UnitX()}, {"y", Vec3::UnitY()}, {"z", Vec3::UnitZ()}};
  for (const auto& [name, direction] : axes) {
    scene.shape({{Vec3::Zero(), length * direction}}, false, "class=\"axis-" + name + "\"");
    scene.words(1.12 * length * direction, "class=\"tick halo\" text-anchor=\"middle\" dy=\"4\"", name);
  }
}

void draw_scale(Scene& scene, const Viewpoint& view, double metres) {
  const Vec2 at(kMargin / 2, kHeight + kScaleBarRoom / 2), end = at + Vec2(metres * view.scale, 0);
  Marks bar;
  bar.line(at, end);
  scene.raw(bar.path("class=\"bar\"") +
            label(end + Vec2(8, 0), "class=\"tick\" dy=\"4\"", shortest(1e3 * metres) + " mm") + "\n");
}

void add_bodies(Points3& extent, const std::vector<Body>& bodies, double near, double axis) {
  for (int i = 0; i < 3; ++i) extent.push_back(axis * Vec3::Unit(i));
  for (const Body& body : bodies) {
    extent.push_back(body.rig_from_device.translation);
    for (const Vec3& corner : picture_at(body, near)) extent.push_back(corner);
  }
}

/// How large the devices are drawn, metres: their pyramid, the reach of their rays, the axes.
struct BodySizes {
  double near = 0, far = 0, axis = 0;
};

/// With the devices, axes and scale, as a figure that the page's script can turn.
std::string finished(Scene& scene, const Viewpoint& viewpoint, const std::vector<Body>& bodies,
                     const BodySizes& sizes, const std::string& name, const std::string& caption) {
  for (const Body& body : bodies) draw_body(scene, body, sizes.near, sizes.far);
  draw_axes(scene, sizes.axis);
  const double bar = round_step(0.16 * kWidth / viewpoint.scale);
  draw_scale(scene, viewpoint, bar);

  // What the script needs to turn the picture, lengths in space in millimetres.
  const Vec3& c = viewpoint.centre;
  std::string data = fixed(viewpoint.yaw, 3) + " " + fixed(viewpoint.pitch, 3);
  for (const double value : {1e3 * c.x(), 1e3 * c.y(), 1e3 * c.z(), kWidth, kHeight, kMargin, 1e3 * bar})
    data += " " + shortest(value);
  return element("figure", "class=\"wide\"",
                 "\n" +
                     element("svg",
                             "id=\"rig\" tabindex=\"0\" role=\"img\" aria-label=\"" + name +
                                 "\" viewBox=\"0 0 " + coordinate(kWidth) + " " +
                                 coordinate(kHeight + kScaleBarRoom) + "\" data-view=\"" + data + "\"",
                             "\n" + scene.content()) +
                     element("figcaption", "",
                             caption + " Axes: the rig's frame (x right, y down, z forward). "
                                       "<span id=\"turn\">Drawn without perspective.</span>")) +
         "\n";
}

}  // namespace

std::string rig_in_space(const CalibrationResult& result, const Board& board,
                         const std::optional<NextView>& next) {
  const DrawnSheet sheet = std::visit([](const auto& layout) { return sheet_of(layout); }, board);
  const std::vector<Body> bodies = bodies_of(result.rig);

  std::vector<int> drawn;
  std::vector<double> distances;
  Points3 extent = {Vec3::Zero()};
  for (std::size_t v = 0; v < result.views.size(); ++v) {
    const calibrate::ViewResult& view = result.views[v];
    if (!view.used || !view.rig_from_board.is_finite()) continue;
    drawn.push_back(int(v));
    const Points3 outline = moved(view.rig_from_board, sheet.outline);
    distances.push_back((0.25 * (outline[0] + outline[1] + outline[2] + outline[3])).norm());
    extent.insert(extent.end(), outline.begin(), outline.end());
  }
  if (drawn.empty() || bodies.empty()) return "";
  const Points3 outline_next = next ? moved(next->rig_from_board, sheet.outline) : Points3();
  extent.insert(extent.end(), outline_next.begin(), outline_next.end());
  std::sort(distances.begin(), distances.end());
  const double near = 0.25 * distances[distances.size() / 2], far = distances.back(), axis = 0.6 * near;
  add_bodies(extent, bodies, near, axis);

  const Viewpoint viewpoint = Viewpoint::fitted(extent);
  Scene scene(viewpoint);
  // Far boards first, so that near ones lie over them.
  const auto depth = [&](int v) {
    return viewpoint.depth(result.views[std::size_t(v)].rig_from_board * sheet.outline.front());
  };
  std::stable_sort(drawn.begin(), drawn.end(), [&](int a, int b) { return depth(a) > depth(b); });
  for (const int v : drawn) {
    const calibrate::ViewResult& view = result.views[std::size_t(v)];
    const std::string color = view_color(v);
    scene.raw("<g class=\"board\">");
    scene.shape({moved(view.rig_from_board, sheet.outline)}, true, "class=\"sheet\" stroke=\"" + color + "\"",
                view.name);
    std::vector<Points3> dark;
    for (const Points3& square : sheet.dark) dark.push_back(moved(view.rig_from_board, square));
    scene.shape(dark, true, "class=\"dark\" fill=\"" + color + "\"");
    scene.raw("</g>\n");
  }
  if (next) {
    scene.shape({outline_next}, true, "class=\"sheet next\"", "where the board should come next");
    scene.words(outline_next.front(), "class=\"tick halo accent\"", "next");
  }
  return finished(
      scene, viewpoint, bodies, {near, far, axis}, "The rig and the boards in space",
      "Check: does this look like your set-up? Boards should be at several distances, tilted about both axes "
      "and inside both fields of view." +
          std::string(next ? " Dashed: the view to add next." : ""));
}

std::string surfaces_in_space(const Rig& rig, const std::vector<SpaceOutline>& outlines,
                              const std::string& caption) {
  const std::vector<Body> bodies = bodies_of(rig);
  Points3 extent = {Vec3::Zero()};
  std::vector<double> distances;
  for (const SpaceOutline& outline : outlines) {
    if (outline.corners_in_rig.empty()) continue;
    Vec3 middle = Vec3::Zero();
    for (const Vec3& corner : outline.corners_in_rig) {
      if (!corner.allFinite()) return "";
      middle += corner / double(outline.corners_in_rig.size());
      extent.push_back(corner);
    }
    distances.push_back(middle.norm());
  }
  if (bodies.empty() || distances.empty()) return "";
  std::sort(distances.begin(), distances.end());
  const double near = 0.15 * distances[distances.size() / 2], far = distances.back(), axis = 0.6 * near;
  add_bodies(extent, bodies, near, axis);
  const Viewpoint viewpoint = Viewpoint::fitted(extent);
  Scene scene(viewpoint);
  std::vector<const SpaceOutline*> order;
  for (const SpaceOutline& outline : outlines)
    if (!outline.corners_in_rig.empty()) order.push_back(&outline);
  std::stable_sort(order.begin(), order.end(), [&](const SpaceOutline* a, const SpaceOutline* b) {
    return viewpoint.depth(a->corners_in_rig.front()) > viewpoint.depth(b->corners_in_rig.front());
  });
  for (const SpaceOutline* outline : order) {
    scene.raw("<g class=\"board\">");
    scene.shape({outline->corners_in_rig}, true, "class=\"sheet\" stroke=\"" + outline->color + "\"",
                outline->name);
    scene.raw("</g>\n");
  }
  return finished(scene, viewpoint, bodies, {near, far, axis}, "The rig and the surfaces in space", caption);
}

}  // namespace procam::report
