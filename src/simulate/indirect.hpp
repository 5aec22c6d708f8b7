#pragma once
/// Light that reaches what the camera sees by way of one other surface.
///
/// Mirrored: a flat body with a gloss shows the room's mirror image to the camera, throws the projector's light on, and
/// has a highlight. Each is one more sample of the pixel's centre, at the projector pixel that its path ends in.
///
/// Diffuse: the light of a block of projector pixels, of flux F, is reflected by the surface that it falls on, and is
/// received at a point as
///
///   E = albedo F cos cos' / (pi r^2 + A),   A the block's area on its surface,
///
/// that of a Lambertian disc (exact on its axis). Blocks are as small as their distance from the point requires, 16
/// projector pixels at least. E is computed at every eighth camera pixel, and interpolated between those on the same body.
#include "light_field.hpp"
#include "room_sampling.hpp"

namespace procam::simulate::internal {

/// Points that receive light stand so far before their surface, metres, so that it does not hide light from them.
constexpr double kBeforeSurface = 1e-5;

/// Appends a sample for each pixel and light that takes part; `shown` then has the frames of these, too. Devices stand still.
void add_mirrored_light(const Room& room, const Camera& camera, const Pose& room_from_camera,
                        const std::vector<RoomLight>& lights, int threads, RoomSamples& samples,
                        std::vector<ShownFrames>& shown);

/// Sets SampledView::received. Needs the view's albedo.
void add_diffuse_light(const Room& room, const Camera& camera, const Pose& room_from_camera,
                       const std::vector<RoomLight>& lights, int threads, RoomSamples& samples);

}  // namespace procam::simulate::internal
