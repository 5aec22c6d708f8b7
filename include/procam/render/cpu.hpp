#pragma once
/// Draws a scene into a projector's frame on the CPU: the reference for every other renderer.
///
///   Scene scene;
///   scene.items.push_back({solved.placement, picture});
///   ImageU8 frame = render::render(scene, projector);
///
/// Each pixel's light is followed outwards: through the lens, onto the surface's plane, into the content.
/// With d the direction of the pixel's ray in the projector's frame, the content's homogeneous coordinates
/// are
///
///   q = (u, v, 1) / depth = plane_from_content^-1 [r1 r2 t]^-1 d,     projector_from_surface = [r1 r2 r3 |
///   t],
///
/// with q_3 > 0 exactly where the ray meets the surface in front of the projector: what lies behind or beyond
/// the horizon is not drawn. For flat pixel surfaces d = (x, y, 1) and q = pixel_from_content^-1 d. Skew and lens
/// distortion are followed to 1e-3 px (kLensTolerancePx; exact where the lens has none).
///
/// A pixel shows the mean of the content over the pixel's own footprint (perspective included), which has no
/// aliasing at grazing angles or strong minification; where the content is magnified or shown 1:1 it is
/// interpolated bilinearly, and 1:1 on the pixel grid comes out unchanged. Edges of the content are
/// antialiased by the exact share of the pixel that they cover. Content may carry straight alpha.
///
/// Frame after frame: a CpuRenderer keeps what does not change (docs/render.md has the cost of each).
///
/// Pixels: see docs/conventions.md. The pixels are the same for any number of threads and for any
/// vectors the machine has.
#include <memory>

#include "procam/core/base/export.hpp"
#include "procam/render/renderer.hpp"

namespace procam::render {

/// How far the lens map used for drawing may be from the projector's model, in projector pixels.
inline constexpr double kLensTolerancePx = 1e-3;

/// Throws Error(kInput) for a frame with a side above limits::kFrameSide; call it before taking memory for one.
PROCAM_EXPORT void require_drawable(ImageSize frame);

/// Draws frame after frame and keeps what the next one can use: pictures ready to be sampled, the lens map
/// and every surface's warp map, threads and memory. Nothing is allocated for a frame that needs nothing
/// anew, or whose new pictures have the size of the old; where pixels are cast at one by one (meshes, planes
/// that cut each other) memory is taken until there is enough.
///
/// Items are recognised by their place in the scene. A picture is prepared again when its view points
/// elsewhere or its content_revision differs; pixels changed behind an unchanged view and revision are
/// not noticed. A surface that moves makes its own map again, and no other; a change of the projector's
/// lens or size makes all. Tiles rendered by ray casting are cached once two consecutive frames needed
/// the same one.
class PROCAM_EXPORT CpuRenderer : public Renderer {
 public:
  explicit CpuRenderer(const RenderOptions& options = {});
  CpuRenderer(CpuRenderer&&) noexcept;
  CpuRenderer& operator=(CpuRenderer&&) noexcept;
  ~CpuRenderer() override;

  /// Draws into a frame of the projector's size with 3 channels (RGB); every pixel is written.
  /// Throws std::invalid_argument for a frame of another shape or content that is empty or has 2 or more than
  /// 4 channels, and Error(kInput) for more than the largest of either.
  RenderWork render(const Scene& scene, const Projector& projector, ImageView<std::uint8_t> frame) override;

  /// The same as light, 0 dark .. 1 full, in steps of 1/32640; with linear_light off the content's numbers as
  /// they stand.
  RenderWork render(const Scene& scene, const Projector& projector, ImageView<float> frame) override;

  std::string device() const override { return "cpu"; }

 private:
  class State;
  std::unique_ptr<State> state_;
};

/// One frame by a renderer of its own.
PROCAM_EXPORT void render(const Scene& scene, const Projector& projector, ImageView<std::uint8_t> frame,
                          const RenderOptions& options = {});

/// The same into a new frame.
PROCAM_EXPORT ImageU8 render(const Scene& scene, const Projector& projector,
                             const RenderOptions& options = {});

}  // namespace procam::render
