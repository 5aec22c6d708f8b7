#pragma once
/// A room made ready for the rays of one eye (a camera, or a projector: its shadows are what it does not
/// see).
///
/// The eye's picture is cut into tiles, and every tile knows which bodies reach into the cone of its rays:
/// most rays are tested against one or two bodies, however many there are.
#include <array>
#include <cstdint>
#include <vector>

#include "paint.hpp"
#include "procam/core/lens/camera.hpp"
#include "shape.hpp"

namespace procam::simulate::internal {

/// Bodies by number, upwards.
using Candidates = std::vector<std::uint16_t>;

/// Common to all eyes.
struct PreparedRoom {
  /// Throws std::invalid_argument for bodies that cannot be, or more than 32767 of them.
  explicit PreparedRoom(const Room& source);

  const Room* room;  ///< must outlive this
  std::vector<PreparedPaint> paints;
  std::vector<Points3> hulls_in_room;
  Candidates all;
};

struct BodyHit {
  int body = -1;
  double s = 0;  ///< point in the eye's frame = s * direction
  Spot spot_in_body = {};
};

/// Four directions round a cell. What holds for them holds for all rays between (positive combinations), as
/// all that is asked of flat bodies is linear in the direction.
using CellRays = std::array<Vec3, 4>;

/// Of how many of a cell's rays.
enum class Share { kNone, kSome, kAll };

class Caster {
 public:
  Caster(const PreparedRoom& room, const Pose& room_from_eye);

  /// The first body that eye * direction meets, s > 0; body -1 where it meets none.
  BodyHit nearest(const Vec3& direction_in_eye, const Candidates& candidates) const {
    BodyHit hit;
    double limit = std::numeric_limits<double>::infinity();
    bool on_backdrop = false;
    for (const std::uint16_t i : candidates) {
      const Seen& seen = seen_[i];
      if (hit.body >= 0 && seen.backdrop != on_backdrop) {
        if (seen.backdrop) continue;
        limit = std::numeric_limits<double>::infinity();
      }
      const Meeting met = meet_body(seen, direction_in_eye, limit);
      if (!met.met()) {
        if (on_backdrop) limit = hit.s * (1 + 1e-7);
        continue;
      }
      hit = {int(i), met.s, met.spot};
      on_backdrop = seen.backdrop;
      limit = met.s * (1 + 1e-7);  // in one plane the later body wins
    }
    return hit;
  }
  /// Does anything stand between the eye and a point of a body (not the point's own surface)? A backdrop's
  /// point is hidden by what lies behind it as well.
  bool is_hidden(const Vec3& point_in_eye, int of_body, const Candidates& candidates) const {
    const bool backdrop = seen_[std::size_t(of_body)].backdrop;
    const double to = backdrop ? std::numeric_limits<double>::infinity() : 1 - 1e-6;
    for (const std::uint16_t i : candidates)
      if (hides(seen_[i], point_in_eye, to)) return true;
    return false;
  }

  /// The body that all rays of a cell meet first, -1 where none of them meets any; nullopt where they may
  /// differ.
  std::optional<int> first_of(const CellRays& directions_in_eye, const Candidates& candidates) const;
  /// is_hidden() for the points between four.
  Share hidden(const CellRays& points_in_eye, int of_body, const Candidates& candidates) const;

  const Pose& room_from_eye() const { return room_from_eye_; }
  const Vec3& eye_in_body(int body) const { return seen_[std::size_t(body)].eye_in_body; }
  /// Of a ray's direction, to a flat body's plane.
  double lengths_to_plane(int body, const Vec3& direction_in_eye) const {
    const Seen& seen = seen_[std::size_t(body)];
    return -seen.eye_in_body.z() / seen.z_in_eye.dot(direction_in_eye);
  }
  /// A direction in a body's frame.
  Vec3 in_body(int body, const Vec3& direction_in_eye) const {
    return seen_[std::size_t(body)].in_body(direction_in_eye);
  }

 private:
  struct Seen {
    const Body* body;
    const Rectangle* rectangle;  ///< the whole body, if it is one
    const MeshTree* mesh;        ///< likewise
    bool backdrop;
    std::optional<Rectangle> bounds;  ///< of a flat shape
    bool convex;                      ///< of a flat body
    Points3 hull_in_eye;              ///< of a round shape
    Vec3 x_in_eye, y_in_eye, z_in_eye;
    Vec3 eye_in_body;

    Vec3 in_body(const Vec3& d) const { return Vec3(x_in_eye.dot(d), y_in_eye.dot(d), z_in_eye.dot(d)); }
  };
  static Meeting meet_body(const Seen& seen, const Vec3& d, double to) {
    if (seen.rectangle == nullptr) return meet(*seen.body, seen.eye_in_body, seen.in_body(d), 0, to);
    // As meet_flat(), but most rays that miss are done after the first line.
    const double s = -seen.eye_in_body.z() / seen.z_in_eye.dot(d);
    if (!(s > 0 && s < to)) return {};
    const double x = seen.eye_in_body.x() + s * seen.x_in_eye.dot(d);
    const double y = seen.eye_in_body.y() + s * seen.y_in_eye.dot(d);
    if (!covers(*seen.rectangle, x, y)) return {};
    return {s, {Vec3(x, y, 0)}};
  }
  static bool hides(const Seen& seen, const Vec3& d, double to) {
    if (seen.backdrop) return false;
    if (seen.mesh != nullptr) return seen.mesh->meets(seen.eye_in_body, seen.in_body(d), 0, to);
    return meet_body(seen, d, to).met();
  }

  /// Which of a cell's rays meet a flat body, and 1 / s of its plane along the four. Of a round body: nothing
  /// is known, or that none meets it.
  struct Across {
    Share met;
    std::array<double, 4> nearness;
  };
  static Across across(const Seen& seen, const CellRays& directions);

  Pose room_from_eye_;
  std::vector<Seen> seen_;
};

/// The rays of a rectangle of pixels, by four planes through the eye.
struct TileCone {
  bool known = false;  ///< false where the lens has no ray for a corner: nothing can be skipped
  std::array<Vec3, 4> inward;
  Vec3 middle;
  double margin = 0;  ///< radians, for the sides' bulge by the lens
};
TileCone cone_of(const Camera& device, const Vec2& low, const Vec2& high);

/// How far an eye strays from the pose that its tiles were made for (a rolling shutter).
struct Slack {
  double angle = 0, shift = 0;  ///< radians, metres
};

/// Which bodies may be met within each cone.
class TileIndex {
 public:
  /// Tiles of `tile` x `tile` pixels over [low, high).
  TileIndex(const Camera& device, const Vec2& low, const Vec2& high, int tile);

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  /// Of the tiles in rows [begin, end), row by row.
  std::vector<Candidates> candidates(const PreparedRoom& room, const Pose& room_from_eye, int begin, int end,
                                     const Slack& slack = {}) const;
  /// The tile of a pixel in [low, high).
  int at(const Vec2& pixel) const {
    return int((pixel.y() - low_.y()) / tile_) * columns_ + int((pixel.x() - low_.x()) / tile_);
  }
  /// Does the box of pixels lie beyond one side of the picture?
  bool is_beside(const Vec2& low, const Vec2& high) const {
    return high.x() < low_.x() || high.y() < low_.y() || low.x() >= high_.x() || low.y() >= high_.y();
  }
  bool contains(const Vec2& pixel) const {
    return pixel.x() >= low_.x() && pixel.y() >= low_.y() && pixel.x() < high_.x() && pixel.y() < high_.y();
  }

 private:
  Vec2 low_, high_;
  double tile_;
  int columns_, rows_;
  std::vector<TileCone> cones_;
};

}  // namespace procam::simulate::internal
