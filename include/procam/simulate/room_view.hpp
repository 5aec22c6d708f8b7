#pragma once
/// What a camera records in a room, lit by projectors and by the room's own light; and the truth beside it.
///
///   light(u, v) = (black + (1 - black) (frame / 255)^gamma_l) * tent * disc_l * gaussian(blur_l)
///                                                                                  (u, v) projector pixel
///   level       = albedo * (ambient + sum over lights: intensity * light * cos / d^2) + indirect
///                                                       mean over samples_per_axis^2 rays a pixel
///   linear      = exposure * cos(field angle)^vignetting * (level * disc * gaussian(camera_blur)) + noise
///   grey        = round(255 * (clamp(linear, 0, 255) / 255)^(1 / gamma))
///
/// Out of focus the light of a point fills a disc (ThinLens): exact on surfaces that are smooth over its
/// width; at an outline what is farther is continued behind what is nearer as it looks beside it. Shadows
/// stay sharp.
///
/// Indirect light (Room::indirect) is that of one other surface: the diffuse light of all surfaces that the projectors light
/// (albedo * E, E = integral of albedo' * light * cos cos' / (pi r^2)), the mirror images that glossy bodies show to the camera, the
/// light that they throw on, and their highlights. Of diffuse light the projectors' frames count as blocks of 16 pixels or more.
///
/// Colour: red, green and blue light, each with its own albedo where a picture has colour; a grey frame and
/// the room's light are white. A colour camera's filters are not the lamp's: each channel sees `crosstalk` of
/// the neighbouring colour (red - green - blue); a grey one sees all three alike. White is 1 in every
/// channel.
///
/// Light goes through the full lens model of the projector and throws shadows. Tiles of pictures and prints
/// are integrated over each ray's share of the camera pixel, so their edges lie right to a few thousandths of
/// a pixel; outlines of bodies and shadows are sampled, right to 1 / samples_per_axis of a pixel in one row
/// and better along an edge that crosses rows and columns.
///
/// With a rolling shutter, row y is seen at time + y * row_time, by devices that may move: every row has its
/// own poses, in the picture and in the truth.
#include <cstdint>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/lens/projector.hpp"
#include "procam/core/rig/decoded_map.hpp"
#include "procam/simulate/motion.hpp"
#include "procam/simulate/room.hpp"
#include "procam/simulate/thin_lens.hpp"

namespace procam::simulate {

/// As a gamma: the curve of sRGB (IEC 61966-2-1).
inline constexpr double kSrgb = 0;

struct RoomLight {
  Projector projector;
  Motion room_from_projector;
  std::vector<ImageU8> frames;  ///< grey, or red, green, blue; the projector's size
  double intensity = 1;         ///< irradiance of full light at one metre, straight on
  ThinLens lens = {};
  double blur_px = 0;  ///< sigma of the lens in focus, projector pixels
  double gamma = 1;    ///< light = (value / 255)^gamma; kSrgb
  double black = 0;    ///< light of value 0: 0.001 for a contrast of 1000 : 1
};

struct RoomViewOptions {
  /// Grey levels per unit of albedo * irradiance. 0: such that the brightest pixel reads `brightest_grey`
  /// (before vignetting and gamma) under the full light of all projectors.
  double exposure = 0;
  double brightest_grey = 200;
  bool colour = false;        ///< captures of three channels
  double crosstalk = 0.1;     ///< share of a neighbouring colour's light, colour captures only
  ThinLens lens = {};         ///< of the camera
  double camera_blur_px = 0;  ///< sigma of the camera's lens in focus, camera pixels
  double vignetting = 0;      ///< power of the cosine of the field angle; 4: the natural law of a simple lens
  double gamma = 1;           ///< of the camera; 1: linear; kSrgb
  NoiseModel noise{0, 0};     ///< Gaussian; variance of the linear grey value
  std::uint64_t seed = 0;     ///< of the noise
  int samples_per_axis = 2;   ///< rays a camera pixel, squared
  /// Cast all rays only where a neighbouring pixel sees another body, bend or light; elsewhere one, and the
  /// others are followed on the plane that it meets. With bodies that are not flat several times as fast;
  /// what is thinner than a pixel may be missed. Not with a rolling shutter.
  bool adaptive = false;
  int threads = 0;      ///< 0: as many as the machine has. The result does not depend on it
  double time = 0;      ///< of the first row, seconds
  double row_time = 0;  ///< from one row to the next, seconds; 0: all rows at once
};

/// What the centre of each pixel sees.
struct RoomTruth {
  Image<std::int16_t> body;         ///< number in the room; -1: nothing
  ImageF depth;                     ///< z in the camera's frame, metres; 0: nothing
  ImageF point_in_room;             ///< three channels, metres
  std::vector<ProjectorMap> light;  ///< by light: the projector pixel that lights the point
};

struct RoomView {
  std::vector<ImageU8> captures;  ///< one a frame; one without projectors
  double exposure = 0;            ///< the one used
  RoomTruth truth;

  const ImageU8& image() const { return captures.front(); }
};

/// All lights show the same number of frames, at the same time; noise differs from frame to frame. Throws
/// std::invalid_argument for frames of another size or number, options out of range, bodies that cannot be,
/// or (exposure 0) a view without any light.
PROCAM_EXPORT RoomView room_view(const Room& room, const Camera& camera, const Motion& room_from_camera,
                                 const std::vector<RoomLight>& lights, const RoomViewOptions& options = {});

}  // namespace procam::simulate
