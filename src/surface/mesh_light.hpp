#pragma once
/// Where the light of a pixel meets a mesh first.
#include <Eigen/LU>
#include <array>
#include <vector>

#include "procam/core/lens/projector.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::surface {

/// A direction d meets the triangle with corners P_i where its homogeneous barycentric coordinates
/// b = [P_1 P_2 P_3]^-1 d are all >= 0, at 1 / sum b lengths of d (Olano and Greer, Triangle scan conversion
/// using 2D homogeneous coordinates, 1997). Each tile of pixels asks the triangles whose cone of directions
/// touches its own, so that no lens can bend one past the other.
class MeshLight {
 public:
  MeshLight(const Projector& projector, const PlacedMesh& placed);

  struct Hit {
    Vec2 uv;
    Vec3 point_in_projector;
  };
  /// The pixel must lie in the picture; nullopt where its light passes the mesh by.
  std::optional<Hit> hit(const Vec2& pixel) const;

 private:
  struct Triangle {
    Mat3 barycentric_from_direction;
    std::array<int, 3> corners;
  };

  const Projector& projector_;
  const PlacedMesh& placed_;
  int tiles_across_ = 0;
  std::vector<Triangle> triangles_;
  std::vector<std::vector<int>> of_tile_;
};

}  // namespace procam::surface
