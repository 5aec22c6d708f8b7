#include "caster.hpp"

#include <algorithm>

namespace procam::simulate::internal {

PreparedRoom::PreparedRoom(const Room& source) : room(&source) {
  require(source.bodies.size() < 32768, "simulate: more than 32767 bodies in the room");
  require(source.ambient >= 0, "simulate: the room's ambient light is negative");
  for (std::size_t i = 0; i < source.bodies.size(); ++i) {
    const Body& body = source.bodies[i];
    check_body(body);
    require(body.room_from_body.is_finite(), "simulate: the place of body '" + body.name + "' is not finite");
    paints.emplace_back(body);
    Points3& hull = hulls_in_room.emplace_back(hull_of(body.shape));
    for (Vec3& corner : hull) corner = body.room_from_body * corner;
    all.push_back(std::uint16_t(i));
  }
}

Caster::Caster(const PreparedRoom& room, const Pose& room_from_eye) : room_from_eye_(room_from_eye) {
  seen_.reserve(room.room->bodies.size());
  for (const Body& body : room.room->bodies) {
    const Pose body_from_eye = body.room_from_body.inverse() * room_from_eye;
    const Mat3 axes = body_from_eye.rotation_matrix().transpose();
    Seen& seen = seen_.emplace_back();
    seen.body = &body;
    seen.rectangle = body.cutout ? nullptr : std::get_if<Rectangle>(&body.shape);
    const auto* mesh = body.cutout ? nullptr : std::get_if<TriangleMesh>(&body.shape);
    seen.mesh = mesh ? &mesh->tree() : nullptr;
    seen.backdrop = body.backdrop;
    seen.bounds = flat_bounds(body.shape);
    seen.convex = !body.cutout && is_convex(body.shape);
    if (!seen.bounds)
      for (const Vec3& corner : hull_of(body.shape))
        seen.hull_in_eye.push_back(body_from_eye.inverse() * corner);
    seen.x_in_eye = axes.col(0);
    seen.y_in_eye = axes.col(1);
    seen.z_in_eye = axes.col(2);
    seen.eye_in_body = body_from_eye.translation;
  }
}

namespace {

/// Does a body of these corners lie wholly beyond one side of the rays' pyramid?
bool is_beside(const Points3& hull, const CellRays& d) {
  const Vec3 middle = d[0] + d[1] + d[2] + d[3];
  constexpr std::size_t kRound[5] = {0, 1, 3, 2, 0};
  for (std::size_t k = 0; k < 4; ++k) {
    Vec3 inward = d[kRound[k]].cross(d[kRound[k + 1]]);
    if (inward.dot(middle) < 0) inward = -inward;
    if (std::all_of(hull.begin(), hull.end(), [&](const Vec3& p) { return inward.dot(p) < 0; })) return true;
  }
  return false;
}

}  // namespace

Caster::Across Caster::across(const Seen& seen, const CellRays& directions) {
  if (!seen.bounds) {
    Across round;
    round.met = is_beside(seen.hull_in_eye, directions) ? Share::kNone : Share::kSome;
    round.nearness.fill(std::numeric_limits<double>::infinity());
    return round;
  }
  const Vec3& eye = seen.eye_in_body;
  const Rectangle& r = *seen.bounds;
  Across across;
  // A ray meets the rectangle where all of these are positive, and each is linear in the direction.
  std::array<bool, 5> beyond;
  beyond.fill(true);
  bool inside = true;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3 d = seen.in_body(directions[k]);
    const double w = -d.z() / eye.z(), x = eye.x() * w + d.x(), y = eye.y() * w + d.y();
    const std::array<double, 5> within = {w, x - r.low.x() * w, r.high.x() * w - x, y - r.low.y() * w,
                                          r.high.y() * w - y};
    for (std::size_t j = 0; j < 5; ++j) {
      beyond[j] = beyond[j] && within[j] < 0;
      inside = inside && within[j] > 0;
    }
    if (inside && seen.rectangle == nullptr)
      inside = seen.convex && covers(std::get<Polygon>(seen.body->shape), x / w, y / w);
    across.nearness[k] = w;
  }
  const bool none = beyond[0] || beyond[1] || beyond[2] || beyond[3] || beyond[4];
  across.met = none ? Share::kNone : inside ? Share::kAll : Share::kSome;
  return across;
}

std::optional<int> Caster::first_of(const CellRays& directions, const Candidates& candidates) const {
  constexpr std::size_t kMax = 12;
  std::array<Across, kMax> met;
  if (candidates.size() > kMax) return std::nullopt;
  for (std::size_t i = 0; i < candidates.size(); ++i) met[i] = across(seen_[candidates[i]], directions);
  // Backdrops are behind all else.
  for (const bool backdrop : {false, true}) {
    const auto is_asked = [&](std::size_t i) {
      return seen_[candidates[i]].backdrop == backdrop && met[i].met != Share::kNone;
    };
    std::optional<std::size_t> first;
    bool any = false;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (!is_asked(i)) continue;
      any = true;
      if (met[i].met == Share::kAll && (!first || met[i].nearness[0] * (1 + 1e-7) > met[*first].nearness[0]))
        first = i;
    }
    if (!any) continue;
    if (!first) return std::nullopt;
    // Nothing else may be met before it; in one plane the later body wins, as in nearest().
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      if (i == *first || !is_asked(i)) continue;
      for (std::size_t k = 0; k < 4; ++k) {
        const double other = met[i].nearness[k], mine = met[*first].nearness[k];
        if (!(i < *first ? mine * (1 + 1e-7) > other : other * (1 + 1e-7) <= mine)) return std::nullopt;
      }
    }
    return int(candidates[*first]);
  }
  return -1;
}

Share Caster::hidden(const CellRays& points, int of_body, const Candidates& candidates) const {
  const double least = seen_[std::size_t(of_body)].backdrop ? 0 : 1 + 1e-6;  // of 1 / s, as in is_hidden()
  Share share = Share::kNone;
  for (const std::uint16_t i : candidates) {
    if (seen_[i].backdrop) continue;
    const Across body = across(seen_[i], points);
    const auto before = [least](double nearness) { return nearness > least; };
    if (body.met == Share::kNone || std::none_of(body.nearness.begin(), body.nearness.end(), before))
      continue;
    if (body.met == Share::kAll && std::all_of(body.nearness.begin(), body.nearness.end(), before))
      return Share::kAll;
    share = Share::kSome;
  }
  return share;
}

TileCone cone_of(const Camera& device, const Vec2& low, const Vec2& high) {
  // Eight points round the tile, clockwise from its first corner: corners at the even places.
  std::array<Vec3, 8> rim;
  const double x[3] = {low.x(), 0.5 * (low.x() + high.x()), high.x()};
  const double y[3] = {low.y(), 0.5 * (low.y() + high.y()), high.y()};
  constexpr int kColumn[8] = {0, 1, 2, 2, 2, 1, 0, 0}, kRow[8] = {0, 0, 0, 1, 2, 2, 2, 1};
  TileCone cone;
  for (std::size_t i = 0; i < 8; ++i) {
    const std::optional<Vec3> direction = device.unproject(Vec2(x[kColumn[i]], y[kRow[i]]));
    if (!direction) return cone;
    rim[i] = *direction;
  }
  cone.middle = (rim[0] + rim[2] + rim[4] + rim[6]).normalized();
  double bulge = 0, wide = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    Vec3 inward = rim[2 * i].cross(rim[(2 * i + 2) % 8]).normalized();
    if (inward.dot(cone.middle) < 0) inward = -inward;
    cone.inward[i] = inward;
    for (const Vec3& direction : rim) bulge = std::max(bulge, -inward.dot(direction));
    wide = std::max(wide, (rim[2 * i] - cone.middle).norm());
  }
  // A parabola's worst place need not be the middle of a side, hence twice and a little of the width.
  cone.margin = 2 * bulge + 0.05 * wide;
  cone.known = wide < 1;
  return cone;
}

TileIndex::TileIndex(const Camera& device, const Vec2& low, const Vec2& high, int tile)
    : low_(low),
      high_(high),
      tile_(tile),
      columns_(int(std::ceil((high.x() - low.x()) / tile))),
      rows_(int(std::ceil((high.y() - low.y()) / tile))) {
  cones_.reserve(std::size_t(columns_) * std::size_t(rows_));
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column) {
      const Vec2 corner = low + tile * Vec2(column, row);
      cones_.push_back(cone_of(device, corner, (corner + Vec2::Constant(tile)).cwiseMin(high)));
    }
}

std::vector<Candidates> TileIndex::candidates(const PreparedRoom& room, const Pose& room_from_eye, int begin,
                                              int end, const Slack& slack) const {
  const Pose eye_from_room = room_from_eye.inverse();
  std::vector<Points3> hulls = room.hulls_in_room;
  for (Points3& hull : hulls)
    for (Vec3& corner : hull) corner = eye_from_room * corner;

  // A body is skipped when all its corners lie beyond one plane.
  const auto reaches_into = [&](const Points3& hull, const TileCone& cone) {
    const auto beyond = [&](const Vec3& inward, double margin) {
      return std::all_of(hull.begin(), hull.end(), [&](const Vec3& p) {
        return inward.dot(p) < -(slack.shift + (margin + slack.angle) * p.norm());
      });
    };
    return !beyond(cone.middle, 0) &&
           std::none_of(cone.inward.begin(), cone.inward.end(),
                        [&](const Vec3& inward) { return beyond(inward, cone.margin); });
  };
  std::vector<Candidates> found;
  for (int i = begin * columns_; i < end * columns_; ++i) {
    const TileCone& cone = cones_[std::size_t(i)];
    Candidates& in_tile = found.emplace_back();
    for (const std::uint16_t body : room.all)
      if (!cone.known || reaches_into(hulls[body], cone)) in_tile.push_back(body);
  }
  return found;
}

}  // namespace procam::simulate::internal
