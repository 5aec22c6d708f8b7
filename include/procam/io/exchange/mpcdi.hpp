#pragma once
/// MPCDI, the Multiple Projection Common Data Interchange (VESA, version 2.0): projectors' warps, poses and
/// frusta, for Unreal's nDisplay, media servers and warping processors. Docs: docs/exchange.md.
///
/// An .mpcdi is a zip of mpcdi.xml, the warps as PFM and the alpha maps as PNG; an .mpcdi.xml is the first
/// alone. Four profiles:
///
/// | profile | a region has |
/// | 2d | `warp`: the content that each pixel shows |
/// | 3d | `warp` into the picture of a frustum seen from one eye (read, not written) |
/// | sl | shader lamps: the projector's own frustum and place, `positions`, and `distortion` |
/// | a3 | `positions`: where each pixel's light lands in the room |
///
/// What procam makes of the format's words (the standard leaves some to its readers; where two readers in the
/// field agree, so does this one):
/// - Frustum angles are seen from the projector, in degrees, right and up positive; the picture's edges lie
/// at
///   tan(leftAngle) .. tan(rightAngle) and tan(downAngle) .. tan(upAngle) at distance 1.
/// - The coordinate frame's pitch, yaw and roll vectors are the right, down and forward of a projector whose
///   angles are all zero. Then yaw turns it to the right, pitch up, roll its right side down, in this order:
///   world_from_projector = [pitch yaw roll] Ry(yaw) Rx(pitch) Rz(roll), Ry ... about the optical frame's
///   axes.
/// - Two-dimensional warps run upwards: (0, 0) is the content's bottom-left corner. Here they are WarpMap,
/// with
///   v downwards, converted at the boundary. A pixel that shows nothing is NaN.
/// - Positions are in metres here; the unit of the file is converted.
/// - No frustum can carry skew or distortion: sl has a distortion map for them (procam writes it always).
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/core/lens/projector.hpp"
#include "procam/core/surface/warp_map.hpp"

namespace procam::io {

enum class MpcdiProfile { k2d, k3d, kShaderLamps, kAdvanced3d };

/// "2d", "3d", "sl" or "a3", in any case; else Error(kInput).
PROCAM_EXPORT MpcdiProfile parse_mpcdi_profile(const std::string& text);

/// As in the file: degrees.
struct MpcdiFrustum {
  double yaw = 0, pitch = 0, roll = 0;
  double left = 0, right = 0, down = 0, up = 0;
};

/// As in the file: the place, metres, and the unit vectors that say what the world's axes are.
struct MpcdiFrame {
  Vec3 position = Vec3::Zero();
  Vec3 yaw = -Vec3::UnitY(), pitch = Vec3::UnitX(), roll = -Vec3::UnitZ();  ///< x right, y up, z backward
};

struct MpcdiRegion {
  std::string buffer, id;
  ImageSize size;
  double x = 0, y = 0, width = 1, height = 1;  ///< its part of the buffer, 0..1
  std::optional<MpcdiFrustum> frustum;
  std::optional<MpcdiFrame> frame;
  std::optional<WarpMap> warp;
  std::optional<ImageF> positions;    ///< 3 channels, metres; NaN where nothing is shown
  std::optional<WarpMap> distortion;  ///< where in the frustum's picture each pixel looks
  std::optional<ImageF> alpha;        ///< 1 channel, 0..1
  double alpha_gamma = 1;             ///< light = alpha ^ gamma
};

struct Mpcdi {
  MpcdiProfile profile = MpcdiProfile::k2d;
  std::string date;  ///< "2026-11-22 08:00:00"
  std::vector<MpcdiRegion> regions;
  Diagnostics diagnostics;  ///< of reading: notes "no_warp" for regions that have only a pose
};

/// The pinhole that the region's frustum and size describe; and where it stands. Throw Error(kInput) for a
/// region without one, Error(kUnsupported) for a left-handed coordinate frame.
PROCAM_EXPORT Projector projector_of(const MpcdiRegion& region);
PROCAM_EXPORT Pose world_from_projector(const MpcdiRegion& region);

/// Sets size, frustum, frame and distortion from a projector in a world of x right, y up, z backward (the
/// file's usual axes). The frustum is the smallest that holds all of the light; it is the projector itself,
/// to rounding, where the lens has neither skew nor distortion. Where it has, a warning "frustum_is_not_lens"
/// says by how many pixels the frustum alone is off.
PROCAM_EXPORT Diagnostics set_projector(MpcdiRegion& region, const Projector& projector,
                                        const Pose& world_from_projector);

/// .mpcdi or .mpcdi.xml, recognised by its contents. Names are taken in any case ("xResolution"). Only what
/// the XML names is unpacked, in memory. Throws Error(kInput), naming file and member or line, for archives
/// that are damaged, unpack to more than `largest_unpacked` or than they declare, have members outside the
/// archive (".."), lack a file, or whose maps have another size than their region or numbers that are none;
/// regions outside 0..1, absurd sizes. Error(kUnsupported) for an archive when procam was built without
/// libzip.
PROCAM_EXPORT Mpcdi load_mpcdi(const std::filesystem::path& path,
                               std::size_t largest_unpacked = limits::kFileBytes);

/// Writes profiles 2d, sl and a3, at once or not at all; the same data give the same bytes. The name must end
/// in .mpcdi. Throws std::invalid_argument for regions without what their profile needs, Error(kUnsupported)
/// for profile 3d, for another name, and when procam was built without libzip.
PROCAM_EXPORT void save_mpcdi(const std::filesystem::path& path, const Mpcdi& mpcdi);

}  // namespace procam::io
