#pragma once
/// What every renderer offers: render::CpuRenderer (cpu.hpp) and render_gl::GlRenderer (gl.hpp).
#include <cstdint>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/lens/projector.hpp"
#include "procam/core/surface/scene.hpp"

namespace procam::render {

enum class Filter {
  kArea,      ///< the mean over the pixel's footprint: no aliasing
  kBilinear,  ///< one sample at the pixel's centre, as most warps do: faster, and aliases where it minifies
};

struct RenderOptions {
  Filter filter = Filter::kArea;
  /// Average light rather than numbers: 8-bit values are taken as sRGB, decoded, averaged, encoded. A wall
  /// averages light, so fine black and white lines seen from afar keep their brightness only this way. Off
  /// for content whose numbers are not colours (codes, masks), which is then averaged as it stands; with
  /// Filter::kBilinear that is the fastest way to draw.
  bool linear_light = true;
  int threads = 0;  ///< 0: as many as the machine has
  /// Vectors of at most so many bits, of those that the machine has: 512 (AVX-512), 256 (AVX2; on ARM
  /// NEON) or 0 (plain code). Fewer are slower; for comparing, as the pixels are the same.
  int vector_bits = 512;
};

/// What had to be made anew for a frame; nothing for a scene that stands still.
struct RenderWork {
  int contents = 0;  ///< pictures prepared for sampling
  int maps = 0;      ///< surfaces whose way to the pixels was found
};

/// Draws frame after frame and keeps what the next one can use. Belongs to one thread at a time.
class PROCAM_EXPORT Renderer {
 public:
  virtual ~Renderer() = default;

  /// Draws into a frame of the projector's size with 3 channels (RGB); every pixel is written. Throws
  /// std::invalid_argument for a frame of another shape or content that is empty or has 2 or more than 4
  /// channels, and Error(kInput) for more than the largest of either.
  virtual RenderWork render(const Scene& scene, const Projector& projector,
                            ImageView<std::uint8_t> frame) = 0;

  /// The same as light, 0 dark .. 1 full. Throws Error(kUnsupported) where the renderer's frames have 8 bits.
  virtual RenderWork render(const Scene& scene, const Projector& projector, ImageView<float> frame) = 0;

  /// Where frames are drawn: "cpu", or the graphics driver's name and version.
  virtual std::string device() const = 0;
};

}  // namespace procam::render
