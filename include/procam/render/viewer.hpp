#pragma once
/// Content with depth for one viewer: a virtual scene projected onto the real surfaces of a room such that
/// a person at a known position sees it there, behind the walls, before them or across their corner.
///
///   const ViewerEye eye = *render::viewer_eye(eye_in_projector, room, projector);
///   ViewerScene shown = render::viewer_scene(room, projector, eye.viewpoint);
///   while (showing) {
///     // pass 1: the virtual scene, drawn from the eye
///     from_eye.render(seen_from(eye.viewpoint.camera_from_projector, content), {eye.viewpoint.camera},
///                     shown.picture);
///     shown.picture_changed();
///     // pass 2: that picture, through the projector's lens onto the room
///     onto_room.render(shown.scene, projector, frame);
///   }
///
/// (R. Raskar et al., The Office of the Future, SIGGRAPH 1998.) In pass 2 the light of a projector pixel
/// lands at X on the nearest real surface, and shows the place e of the eye's picture that X is seen at:
///
///   e = K_eye eye_from_projector X,
///
/// which is a projection on every facet of the room (PlacedMesh::content_from_point). So pass 2 is an
/// ordinary scene, for any renderer, with the exact lens, footprints and edges of the others. Several
/// projectors: each has a scene of its own from the same eye; blend them as usual.
///
/// What is left dark: light that lands where the eye does not see it, as another real surface, or another
/// part of the same, stands before it (else the nearer thing's picture would be repeated on the farther), and
/// light that lands behind the eye or outside its picture. Both from the exact facets, to a thousandth of the
/// distance; at such borders a pixel's share is taken by 16 casts. A real surface's outline and holes (its
/// item's mask, less than one half) let light and eye pass. A thin sheet with the eye on one side and the
/// projector on the other counts as a translucent screen, and shows the picture.
///
/// A real surface that is not among `room` is not known to be there. Pixel surfaces have no place in the room
/// and are skipped.
#include "procam/core/base/export.hpp"
#include "procam/core/lens/projector.hpp"
#include "procam/render/cpu.hpp"
#include "procam/render/viewpoint.hpp"

namespace procam::render {

struct ViewerEyeOptions {
  /// A picture on a plane cannot hold all directions: light that lands farther than half of this from the
  /// direction of its middle is left dark.
  double widest_deg = 140;
  /// Of the eye's picture. Enough for each projector pixel to see its own, save where one is very fine beside
  /// the others; with fewer the picture is coarser.
  int max_pixels = 16 << 20;
};

struct ViewerEye {
  Viewpoint viewpoint;
  /// Pixels of the eye's picture a projector pixel, along its finer side, where the projector is finest.
  double finest_share = 1;
  Diagnostics diagnostics;  ///< warnings "viewer_field_cut", "viewer_picture_coarse"
};

/// The picture of an eye that holds all that the projector lights of the room, such that the projector's
/// finest pixels (all but the finest twentieth) see a pixel of it each. nullopt where no light lands in
/// sight. The real surfaces are those of `room`; their content is not looked at.
PROCAM_EXPORT std::optional<ViewerEye> viewer_eye(const Vec3& eye_in_projector, const Scene& room,
                                                  const Projector& projector,
                                                  const ViewerEyeOptions& options = {});

/// Pass 2. The scene looks at the pictures beside it: it moves, and is not copied.
struct ViewerScene {
  Scene scene;
  ImageU8 picture;  ///< RGB, of the eye's camera: pass 1 draws here; black until then
  /// Of the projector's pixels whose light lands on the room, the share that the eye sees.
  double seen_share = 0;

  /// Call after the image was redrawn.
  void picture_changed() {
    for (SceneItem& item : scene.items)
      if (item.content.data == picture.data()) ++item.content_revision;
  }

  ViewerScene() = default;
  ViewerScene(ViewerScene&&) = default;
  ViewerScene& operator=(ViewerScene&&) = default;
  ViewerScene(const ViewerScene&) = delete;
  ViewerScene& operator=(const ViewerScene&) = delete;

  std::vector<ImageU8> masks;  ///< outlines and holes as the eye sees them
  ImageU8 unseen, black;       ///< what the last item, a sheet over the frame, leaves dark
};

/// Made anew when the eye, the projector or the room moves; a scene that is drawn for a moving eye every
/// frame costs one pass over the projector's pixels (docs/render.md).
PROCAM_EXPORT ViewerScene viewer_scene(const Scene& room, const Projector& projector, const Viewpoint& eye,
                                       const RenderOptions& options = {});

}  // namespace procam::render
