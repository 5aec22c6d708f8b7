#include "caster.hpp"

#include <algorithm>

namespace procam::simulate::internal {

PreparedRoom::PreparedRoom(const Room& source) : room(&source) {
  require(source.bodies.size() < 32768, "simulate: more than 32767 bodies in the room");
  require(source.ambient >= 0, "simulate: the room's ambient light is negative");
  for (std::size_t i = 0; i < source.bodies.size(); ++i) {
    const Body& body = source.bodies[i];
    check_shape(body.name, body.shape);
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
    seen_.push_back({&body.shape, std::get_if<Rectangle>(&body.shape), axes.col(0), axes.col(1), axes.col(2),
                     body_from_eye.translation});
  }
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

  // A body may be left out when all its corners lie beyond one plane.
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
