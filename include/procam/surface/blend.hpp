#pragma once
/// Several projectors on the same surfaces: what each must do to its picture so that together they look like
/// one.
///
///   std::vector<BlendInput> projectors{{left, solved_for_left}, {right, solved_for_right}};
///   const Blend blend = surface::blend_maps(projectors);
///   surface::apply_blend(blend.maps[0], frame_of_left);
///
/// In linear light, with E_i the light that white of projector i brings to a place of the surface, b_i the
/// share of it that its black still brings and v_i what it is asked for (0..1), the place shows sum E_i (b_i
/// + (1 - b_i) v_i) over the projectors whose light really reaches it: inside their pictures, on the side
/// that they light, and with nothing before it (their own nearest surface there, within a hundredth of the
/// distance). For content of light L it shall show the same everywhere,
///
///   E_0 (B + (1 - B) L),     B = max S / E_0,     S = sum b_i E_i:
///
/// black is lifted to that of the darkest place that can be had everywhere, the overlap's. With weights
/// w_i >= 0, sum w_i = 1, projector i shows v_i = gain L + lift:
///
///   gain = w_i E_0 (1 - B) / ((1 - b_i) E_i),     lift = w_i (E_0 B - S) / ((1 - b_i) E_i).
///
/// Weights: w_i = d_i^2 / sum d_j^2, with d_i = 16 x (1 - x) y (1 - y) t (2 - t) for a place at (x, y) of
/// projector i's picture (0..1), t its distance from the border of a shadow that one surface throws on
/// another, in pixels along the surfaces over half the picture's shorter side, at most 1. So a projector's
/// part comes down to zero, level, where its light ends, and steps nowhere but where two pictures' borders
/// cross; where it is alone it is 1. (After R. Raskar et al., Multi-projector displays using camera-based
/// registration, 1999, whose feathering by the distance to the nearest border has creases, and knows no
/// shadows.)
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/lens/projector.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::surface {

struct BlendInput {
  Projector projector;
  /// Its surfaces; those of the same name in the others' sets are the same. Pixel surfaces have no place in
  /// the room and are left as they are.
  const SolvedSurfaceSet* surfaces = nullptr;
  double brightness = 1;  ///< light of its white, to a common factor (lumens)
  double black = 0;       ///< light of its black over that of its white: 0.001 for a contrast of 1000 : 1
};

struct BlendOptions {
  /// Off: E_i = 1, as for projectors alike and side by side. On: E_i is the projector's brightness over the
  /// area that its pixel covers there, which holds distance and incidence (cos / d^2) and the lens, times the
  /// surface's reflectance. It makes places as dark as the darkest; see `min_gain`.
  bool compensate = false;
  /// E_0 is what 99 % of a surface can show, but no less than this share of what its brightest 1 % could:
  /// darker places stay darker.
  double min_gain = 0.3;
  /// One E_0 for all surfaces, as for the walls of a room; else one for each.
  bool one_level = false;
  /// Reflectance as captured, over the content's area of surfaces by name: one channel, linear, to a common
  /// factor. Needs `compensate`.
  std::map<std::string, ViewF> reflectance;
  /// The map of this projector alone (its place among the projectors), for less time; those of the others stay empty.
  std::optional<std::size_t> only = {};
  int threads = 0;  ///< 0: as many as the machine has
};

/// Of each of the projector's pixels, one channel each; where no surface is, nor beside the pixel: 0, 1, 0.
struct BlendMap {
  ImageF weight, gain, lift;
};

struct Blend {
  std::vector<BlendMap> maps;  ///< in the order of the projectors
  Diagnostics diagnostics;     ///< "no_place" for pixel surfaces, "stays_dark" where min_gain held E_0 up
  /// Of each projector with a map: those whose light reaches a place that it lights as well.
  std::vector<std::vector<std::size_t>> neighbours = {};
};

/// What each projector of a group shows, and its maps, in one order.
struct BlendedSets {
  std::vector<SolvedSurfaceSet> sets;
  std::vector<BlendMap> maps;
  std::vector<double> brightness, black;
};

/// Throws std::invalid_argument for options out of range: brightness > 0, 0 <= black < 1, 0 < min_gain <=
/// 1, reflectance pictures with one channel and numbers of 0 or more, `only` one of the projectors.
PROCAM_EXPORT Blend blend_maps(const std::vector<BlendInput>& projectors, const BlendOptions& options = {});

/// Frame values (RGB, sRGB) as they were drawn -> as they must be shown: decoded, gain and lift, encoded for
/// a projector that makes light of values as value^gamma; 0: as sRGB.
PROCAM_EXPORT void apply_blend(const BlendMap& map, ImageView<std::uint8_t> frame, double gamma = 0);

/// A map made ready for frame after frame: tables of values, and the pixels that it changes.
class PROCAM_EXPORT FrameBlend {
 public:
  /// Throws std::invalid_argument as apply_blend() does.
  explicit FrameBlend(const BlendMap& map, double gamma = 0);

  ImageSize size() const { return size_; }
  /// Of all pixels, those that it changes.
  double changed_share() const;
  /// apply_blend() of that map on the rows [first, last) of a frame, bit for bit. Throws std::invalid_argument for a frame
  /// of another size or without 3 channels, and for rows that it does not have.
  void apply(ImageView<std::uint8_t> frame, int first, int last) const;

 private:
  struct Run {
    int x = 0, count = 0;
    std::size_t at = 0;  ///< of its gains and lifts
  };
  ImageSize size_;
  std::vector<Run> runs_;
  std::vector<std::size_t> first_run_;  ///< of each row, and the end
  std::vector<float> gain_, lift_;
  std::vector<float> light_;         ///< of a value
  std::vector<std::uint8_t> value_;  ///< of the root of light, in equal steps
};

/// The same for a frame of light, 0..1, which stays light.
PROCAM_EXPORT void apply_blend(const BlendMap& map, ImageView<float> frame);

}  // namespace procam::surface
