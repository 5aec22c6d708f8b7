#include "procam/render/viewer.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "footprint.hpp"
#include "procam/core/base/stats.hpp"
#include "room_seen.hpp"

namespace procam::render {

namespace {

/// The point where a ray meets a facet's plane; nearness . X = 1 on it.
Vec3 landing(const Facet& facet, const Vec3& d) {
  return d / double(along(facet.nearness, d));
}

/// What the light of a projector pixel meets.
struct Lit {
  Vec3 centre, right, down;  ///< in the eye's frame: the pixel's middle, and those of its sides
};

/// On a grid over the picture, its rim included.
std::vector<Lit> lit_places(const RoomSeen& room, const Projector& projector,
                            const Pose& eye_from_projector) {
  constexpr int kAcross = 96, kDown = 64;
  const ImageSize size = projector.size();
  std::vector<Lit> places;
  for (int j = 0; j <= kDown; ++j)
    for (int i = 0; i <= kAcross; ++i) {
      const Vec2 pixel(double(size.width) * i / kAcross - 0.5, double(size.height) * j / kDown - 0.5);
      const int x = std::min(int(pixel.x() + 0.5), size.width - 1),
                y = std::min(int(pixel.y() + 0.5), size.height - 1);
      const auto ray = projector.emit(pixel), right = projector.emit(pixel + Vec2(0.5, 0)),
                 down = projector.emit(pixel + Vec2(0, 0.5));
      if (!ray || !right || !down) continue;
      const Facet* facet = room.along_ray(x, y, ray->direction);
      if (!facet || !(along(facet->nearness, right->direction) > 0) ||
          !(along(facet->nearness, down->direction) > 0))
        continue;
      places.push_back({eye_from_projector * landing(*facet, ray->direction),
                        eye_from_projector * landing(*facet, right->direction),
                        eye_from_projector * landing(*facet, down->direction)});
    }
  return places;
}

/// An optical frame that looks along `forward`, its y as near as it can be to `down`.
Mat3 looking_along(const Vec3& forward, Vec3 down) {
  if (down.cross(forward).norm() < 1e-3) down = std::abs(forward.x()) < 0.7 ? Vec3::UnitX() : Vec3::UnitZ();
  Mat3 eye_from_frame;
  eye_from_frame.row(2) = forward.normalized();
  eye_from_frame.row(0) = down.cross(forward).normalized();
  eye_from_frame.row(1) = eye_from_frame.row(2).cross(eye_from_frame.row(0));
  return eye_from_frame;
}

/// The content's area of a plane as two triangles or so; what lies beyond the plane's horizon is cut off.
Mesh area_of(const PlacedPlane& placed) {
  std::vector<Vec3> corners;  // homogeneous
  for (const Vec2& uv : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)})
    corners.push_back(placed.plane_from_content * uv.homogeneous());
  double most = 0;
  for (const Vec3& corner : corners) most = std::max(most, corner.z());
  const double least = 1e-6 * most;
  Mesh mesh;
  const auto add = [&](const Vec3& corner) {
    mesh.vertices.emplace_back(corner.x() / corner.z(), corner.y() / corner.z(), 0);
    mesh.uv.push_back(Vec2::Zero());
  };
  for (std::size_t i = 0; i < 4 && most > 0; ++i) {
    const Vec3 &a = corners[i], &b = corners[(i + 1) % 4];
    if (a.z() >= least) add(a);
    if ((a.z() >= least) != (b.z() >= least)) add(Vec3(a + (least - a.z()) / (b.z() - a.z()) * (b - a)));
  }
  for (int i = 2; i < int(mesh.vertices.size()); ++i) mesh.triangles.push_back({0, i - 1, i});
  return mesh;
}

/// A real surface as triangles that show the eye's picture.
PlacedMesh under_picture(PlacedMesh placed, const Viewpoint& eye) {
  const Intrinsics& k = eye.camera.intrinsics;
  const ImageSize size = eye.camera.size;
  Mat3 content_from_pixel;  // u = (x + 1/2) / W
  content_from_pixel << 1.0 / size.width, 0, 0.5 / size.width, 0, 1.0 / size.height, 0.5 / size.height, 0, 0,
      1;
  placed.content_from_point = content_from_pixel * k.matrix() *
                              (eye.camera_from_projector * placed.projector_from_surface).matrix34();
  return placed;
}

/// In the projector's frame.
PlacedMesh as_one(const std::vector<PlacedMesh>& parts) {
  Mesh all;
  for (const PlacedMesh& part : parts) {
    const int first = int(all.vertices.size());
    for (const Vec3& vertex : part.mesh->vertices)
      all.vertices.push_back(part.projector_from_surface * vertex);
    for (const std::array<int, 3>& t : part.mesh->triangles)
      all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  all.uv.resize(all.vertices.size(), Vec2::Zero());  // the picture comes by projection
  return {std::make_shared<const Mesh>(std::move(all)), Pose::identity()};
}

/// A surface's outline and holes as the eye sees them, alone in the world.
ImageU8 mask_from(const Viewpoint& eye, const SceneItem& item, RenderOptions options) {
  static const ImageU8 white(1, 1, 1, 255);
  Scene alone;
  alone.items.push_back({item.placement, white});
  alone.items.back().mask = item.mask;
  options.linear_light = false;  // shares
  const ImageU8 drawn = render(seen_from(eye.camera_from_projector, alone), Projector{eye.camera}, options);
  ImageU8 mask(drawn.size());
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x) mask.at(x, y) = drawn.at(x, y, 0);
  return mask;
}

/// How much of the light of each projector pixel the eye sees: 255 where all, and where there is nothing.
class SeenByEye {
 public:
  SeenByEye(const Scene& room, const Projector& projector, const Viewpoint& eye, Workers& workers)
      : projector_(projector),
        eye_(eye),
        lit_(room, projector, workers),
        before_eye_(seen_from(eye.camera_from_projector, room), Projector{eye.camera}, workers),
        seen_(projector.size()) {
    lit_.find_nearest(workers);
    before_eye_.find_nearest(workers);
    workers.run(seen_.height(), [&](int y) { look_at_middles(y); });
    ImageU8 refined = seen_;
    workers.run(seen_.height(), [&](int y) { refine(y, refined); });
    seen_ = std::move(refined);
  }

  const ImageU8& seen() const { return seen_; }
  bool is_lit(int x, int y) const { return lit_.at(x, y) != nullptr; }

 private:
  template <bool kExactly>
  bool sees(const Facet& facet, const Vec3& ray) const {
    const Vec3 point_in_eye = eye_.camera_from_projector * landing(facet, ray);
    if (!point_in_eye.allFinite()) return false;
    const std::optional<Vec2> pixel = eye_.camera.project(point_in_eye);
    if (!pixel || !eye_.camera.size.contains(*pixel)) return false;
    return kExactly ? !before_eye_.hides_exactly(*pixel, point_in_eye)
                    : !before_eye_.hides(*pixel, point_in_eye);
  }
  void look_at_middles(int y) {
    const TileGrid grid = lit_.lens().grid();
    std::fill_n(seen_.row(y), seen_.width(), std::uint8_t(255));
    for (int tile = 0; tile < grid.across(); ++tile)
      for (const LensPiece& piece : lit_.lens().pieces(tile, y / kTileHeight)) {
        const PixelRect& r = piece.rect;
        if (y < r.y0 || y >= r.y1) continue;
        const Quadratic3 row = piece.direction_from_pixel.row(r.t(y));
        for (int x = r.x0; x < r.x1; ++x) {
          const Facet* facet = lit_.at(x, y);
          if (!facet) continue;
          const double s = r.s(x);
          seen_.at(x, y) = sees<false>(*facet, row[0] + s * (row[1] + s * row[2])) ? 255 : 0;
        }
      }
  }
  /// Pixels beside which another is seen otherwise.
  bool is_border(int x, int y) const {
    const std::uint8_t here = seen_.at(x, y);
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const int i = x + dx, j = y + dy;
        if (i >= 0 && j >= 0 && i < seen_.width() && j < seen_.height() && seen_.at(i, j) != here)
          return true;
      }
    return false;
  }
  void refine(int y, ImageU8& refined) const {
    constexpr int kSide = 4;
    for (int x = 0; x < seen_.width(); ++x) {
      if (!is_border(x, y)) continue;
      int lit = 0, seen = 0;
      for (int j = 0; j < kSide; ++j)
        for (int i = 0; i < kSide; ++i) {
          const auto ray = projector_.emit(Vec2(x + (i + 0.5) / kSide - 0.5, y + (j + 0.5) / kSide - 0.5));
          const Facet* facet = ray ? lit_.along_ray(x, y, ray->direction) : nullptr;
          if (!facet) continue;
          ++lit;
          seen += sees<true>(*facet, ray->direction);
        }
      if (lit > 0) refined.at(x, y) = std::uint8_t((255 * seen + lit / 2) / lit);
    }
  }

  const Projector& projector_;
  const Viewpoint& eye_;
  RoomSeen lit_, before_eye_;
  ImageU8 seen_;
};

/// `finest`, pixels, or as much of it as a picture of this span on the plane z = 1 may have; then the eye says so.
double choose_focal_length(double finest, const Vec2& span, double max_pixels, ViewerEye& eye) {
  const double most =
      std::min(std::sqrt(max_pixels / (span.x() * span.y())), 16384 / std::max(span.x(), span.y()));
  if (!(finest > most)) return finest;
  eye.finest_share = most / finest;
  if (eye.finest_share < 0.5)
    eye.diagnostics.warn("viewer_picture_coarse",
                         "the eye's picture would need more pixels than it may have: it has " +
                             std::to_string(eye.finest_share) +
                             " a projector pixel where the projector is finest; stand nearer to what is lit, "
                             "or light less of the room");
  return most;
}

/// Black over what the eye does not see, as the last item.
void cover_unseen(const SeenByEye& by_eye, ImageSize projector_size, ViewerScene& shown) {
  shown.unseen = ImageU8(projector_size);
  double seen = 0, lit = 0;
  PixelRect dark{shown.unseen.width(), shown.unseen.height(), 0, 0};  // holds all that is not seen
  for (int y = 0; y < shown.unseen.height(); ++y)
    for (int x = 0; x < shown.unseen.width(); ++x) {
      const std::uint8_t here = by_eye.seen().at(x, y);
      shown.unseen.at(x, y) = std::uint8_t(255 - here);
      lit += by_eye.is_lit(x, y);
      seen += by_eye.is_lit(x, y) ? here / 255.0 : 0;
      if (here == 255) continue;
      dark = {std::min(dark.x0, x), std::min(dark.y0, y), std::max(dark.x1, x + 1), std::max(dark.y1, y + 1)};
    }
  shown.seen_share = lit > 0 ? seen / lit : 0;
  if (dark.x0 >= dark.x1) return;
  shown.black = ImageU8(1, 1, 1);
  PlacedPixels sheet;
  sheet.pixel_from_content << dark.width(), 0, dark.x0 - 0.5, 0, dark.height(), dark.y0 - 0.5, 0, 0, 1;
  SceneItem over;
  over.placement = sheet;
  over.content = shown.black;
  over.mask =
      ViewU8(&shown.unseen.at(dark.x0, dark.y0), dark.width(), dark.height(), 1, shown.unseen.width());
  shown.scene.items.push_back(over);
}

}  // namespace

std::optional<ViewerEye> viewer_eye(const Vec3& eye_in_projector, const Scene& room,
                                    const Projector& projector, const ViewerEyeOptions& options) {
  require(eye_in_projector.allFinite(), "viewer_eye: the eye's place is not finite");
  require(options.widest_deg > 0 && options.widest_deg <= 170 && options.max_pixels > 0,
          "viewer_eye: widest_deg must be in (0, 170], max_pixels positive");
  Workers workers(0);
  const RoomSeen lit(room, projector, workers);
  const std::vector<Lit> around = lit_places(lit, projector, Pose(Mat3(Mat3::Identity()), -eye_in_projector));
  Vec3 forward = Vec3::Zero();
  for (const Lit& place : around)
    if (place.centre.norm() > 1e-6) forward += place.centre.normalized();
  if (!(forward.norm() > 1e-6)) return std::nullopt;
  const double max_tan = std::tan(0.5 * options.widest_deg * kPi / 180);
  const Mat3 rotation = looking_along(forward, Vec3::UnitY());
  Vec2 low(1e9, 1e9), high(-1e9, -1e9);
  std::vector<double> finest;
  bool cut = false;
  const auto on_picture = [](const Vec3& p) { return Vec2(p.head<2>() / p.z()); };
  for (const Lit& place : around) {
    const Vec3 p = rotation * place.centre, right = rotation * place.right, down = rotation * place.down;
    if (!(p.head<2>().norm() < max_tan * p.z()) || !(right.z() > 0) || !(down.z() > 0)) {
      cut = true;
      continue;
    }
    const Vec2 at = on_picture(p);
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
    const double narrow =
        std::sqrt(pixel_size(2 * (on_picture(right) - at), 2 * (on_picture(down) - at)).narrow_squared);
    if (narrow > 0) finest.push_back(narrow);
  }
  if (finest.empty()) return std::nullopt;
  const double fine = at_rank(finest, finest.size() / 20);
  // A step of the grid more on each side: light ends between its points.
  const Vec2 margin = Vec2::Constant(2 * fine) + 0.02 * (high - low);
  low -= margin;
  high += margin;
  const Vec2 span = high - low;
  ViewerEye eye;
  const double f = choose_focal_length(1 / fine, span, options.max_pixels, eye);
  if (cut)
    eye.diagnostics.warn("viewer_field_cut",
                         "part of the light lands behind the viewer or too far to the side for one picture, "
                         "and stays dark; stand farther back, or turn to it");
  Camera& camera = eye.viewpoint.camera;
  camera.size = {std::max(1, int(std::ceil(span.x() * f))), std::max(1, int(std::ceil(span.y() * f)))};
  camera.intrinsics.fx = camera.intrinsics.fy = f;
  camera.intrinsics.cx = -low.x() * f - 0.5;
  camera.intrinsics.cy = -low.y() * f - 0.5;
  eye.viewpoint.camera_from_projector = Pose(rotation, -(rotation * eye_in_projector));
  return eye;
}

ViewerScene viewer_scene(const Scene& room, const Projector& projector, const Viewpoint& eye,
                         const RenderOptions& options) {
  require(std::holds_alternative<NoDistortion>(eye.camera.distortion),
          "viewer_scene: the eye's picture is one without lens distortion");
  require(eye.camera.size.width > 0 && eye.camera.size.height > 0, "viewer_scene: the eye has no picture");
  ViewerScene shown;
  shown.picture = ImageU8(eye.camera.size, 3);
  std::copy_n(room.background, 3, shown.scene.background);
  for (const SceneItem& item : room.items)  // they stay where they are from here on
    if (!item.mask.empty() && !std::holds_alternative<PlacedPixels>(item.placement))
      shown.masks.push_back(mask_from(eye, item, options));
  std::vector<PlacedMesh> whole;
  std::size_t mask = 0;
  const auto light_up = [&](PlacedMesh placed, ViewU8 its_mask) {
    SceneItem lit;
    lit.placement = under_picture(std::move(placed), eye);
    lit.content = shown.picture;
    lit.mask = its_mask;
    shown.scene.items.push_back(lit);
  };
  for (const SceneItem& item : room.items) {
    PlacedMesh placed;
    if (const auto* plane = std::get_if<PlacedPlane>(&item.placement))
      placed = {std::make_shared<const Mesh>(area_of(*plane)), plane->projector_from_surface};
    else if (const auto* mesh = std::get_if<PlacedMesh>(&item.placement))
      placed = *mesh;
    else
      continue;
    if (item.mask.empty())
      whole.push_back(std::move(placed));
    else
      light_up(std::move(placed), shown.masks[mask++]);
  }
  // They show one picture, so they may as well be one surface, which is drawn faster.
  if (!whole.empty()) light_up(whole.size() == 1 ? whole.front() : as_one(whole), {});

  Workers workers(options.threads);
  cover_unseen(SeenByEye(room, projector, eye, workers), projector.size(), shown);
  return shown;
}

}  // namespace procam::render
