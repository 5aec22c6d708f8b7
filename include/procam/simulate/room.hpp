#pragma once
/// A room: any number of bodies that stand before each other, and what a ray meets there.
///
/// Every body is a shape in its own frame, its place, and its paint. Surfaces are Lambertian, flat ones may be glossy
/// beside. They light each other with Room::indirect alone. Both sides of a body are seen, but bodies are surfaces without a lid: a box is its six faces.
///
///   Rectangle, Polygon   on the plane z = 0, metres; a print there reads as on a board: x right, y down, z
///                        into the paper. u, v: from low to high of the (bounding) rectangle
///   Sphere               about the origin; longitude = atan2(y, x), latitude = asin(z / radius).
///                        u along the longitude, v along the latitude, from `from` to `to`
///   Cylinder             about the z axis from z = low to z = high; u along the longitude, v along z
///   TriangleMesh         any shape: scans, grids, Bezier patches (mesh_of(), core/surface/surface.hpp); its own u, v
///
/// Where two bodies lie in one plane (a sheet on a wall), the later in the list shows.
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/core/geometry/mesh.hpp"
#include "procam/core/geometry/ray.hpp"
#include "procam/simulate/world.hpp"

namespace procam::simulate {

namespace internal {
class MeshTree;
}

struct Rectangle {
  Vec2 low = Vec2::Zero(), high = Vec2::Ones();  ///< metres
};

/// Any simple polygon, three corners at least, either sense.
struct Polygon {
  Points2 corners;  ///< metres
};

/// A range of angles, radians, from < to <= from + 2 pi.
struct Arc {
  double from = -M_PI, to = M_PI;
};

/// A sphere, or the part of it within two ranges (a dome: latitude 0 .. pi/2).
struct Sphere {
  double radius = 1;
  Arc longitude = {};
  Arc latitude = {-M_PI_2, M_PI_2};
};

/// A tube without lids, or a part of its turn (a column, a niche, a curved screen).
struct Cylinder {
  double radius = 1, low = 0, high = 1;
  Arc longitude = {};
};

/// Triangles, both sides of which are seen. The painted side is the one from which u grows to the right and v
/// down; where u, v say nothing, the one from which a triangle's corners run clockwise. Light falls as on the
/// smooth surface that they stand for: where triangles meet at less than 30 degrees, the normal is
/// interpolated between their corners; sharper edges stay sharp. Copies share the mesh and the tree over it
/// by which a ray finds its triangle.
class PROCAM_EXPORT TriangleMesh {
 public:
  /// Throws Error(kInput) with the fault of a mesh that cannot be (fault_of).
  explicit TriangleMesh(std::shared_ptr<const Mesh> mesh);

  const Mesh& mesh() const;
  const internal::MeshTree& tree() const { return *tree_; }

 private:
  std::shared_ptr<const internal::MeshTree> tree_;
};

using Shape = std::variant<Rectangle, Polygon, Sphere, Cylinder, TriangleMesh>;

/// A picture, grey or red, green, blue, stretched over a body's u, v, its texels square tiles of one albedo:
/// black + (white - black) * value / 255. The texel (0, 0) begins at u = v = 0. At most 2^24 texels.
struct Texture {
  ImageU8 image;
  double white = 0.8, black = 0.06;
};

/// Albedo, 0..1: one number, a picture, or a board's print, whose frame is the body's (Rectangle and Polygon
/// only).
using Paint = std::variant<double, Texture, PrintedBoard>;

/// Holes and an outline: the body is there where the mask, one channel, linear between the middles of its
/// texels, is one half or more.
struct Cutout {
  ImageU8 mask;
  /// A homography from the shape's u, v to those of the mask, (0, 0) .. (1, 1) from corner to corner; nothing
  /// is there where its third number is not positive.
  Mat3 mask_from_uv = Mat3::Identity();
};

/// The polish of a flat body, beside its paint: a lacquered table, a window, a screen.
struct Gloss {
  double share = 0;  ///< of the light that it mirrors, whatever the angle; 0: none
  double spread =
      0.01;  ///< standard deviation of the mirrored directions, radians: the highlight's width; images are sharp
};

struct Body {
  std::string name;
  Shape shape;
  Pose room_from_body;
  Paint paint = 0.6;
  /// Albedo of the other side: of planes the side z > 0, of spheres and cylinders the inner one. None: as
  /// this side.
  std::optional<double> back_albedo = {};
  std::optional<Cutout> cutout = {};
  /// Behind everything, at any distance: seen and lit where eye and light meet nothing else, it hides
  /// nothing. The wall around a sheet, of unknown size.
  bool backdrop = false;
  Gloss gloss = {};  ///< of the front of a Rectangle or Polygon; seen with Room::indirect
};

struct PROCAM_EXPORT Room {
  std::vector<Body> bodies;
  double ambient = 0;  ///< irradiance on everything, in units of a projector's full light at one metre
  /// Surfaces light each other (room_view.hpp). Not with surfaces that have colour, nor with devices that move.
  bool indirect = false;

  /// The place in the list; throws Error(kInput) with the names there are.
  int index_of(const std::string& name) const;
};

/// A body's point at u, v: the other way round. Throws std::invalid_argument outside [0, 1], and where no
/// triangle of a mesh has them.
PROCAM_EXPORT Vec3 point_at(const Body& body, const Vec2& uv);

/// The six faces of a block from the origin of its frame to `size`, "NAME -x" .. "NAME +z", printed sides
/// outwards.
PROCAM_EXPORT std::vector<Body> box(const std::string& name, const Pose& room_from_box, const Vec3& size,
                                    const Paint& paint);

/// The sheet with its margin, placed by the board's frame.
PROCAM_EXPORT Body printed_sheet(const std::string& name, const PrintedBoard& board,
                                 const Pose& room_from_board);

/// A marker's sheet: the black square, and round it white paper of `rim_cells` cells. Its frame is the
/// marker's. Throws std::invalid_argument for a size that is not positive or an id that the codes lack.
PROCAM_EXPORT Body marker_sheet(const PlacedMarker& marker, const MarkerCells& codes,
                                const Pose& room_from_world = {}, int rim_cells = 2);

}  // namespace procam::simulate
