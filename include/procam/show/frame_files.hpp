#pragma once
/// The frames of a projector as files, without a display: pictures, videos and colours on solved surfaces.
///
///   show::FrameFilesOptions options;
///   options.contents = {{"wall", "picture.png"}};
///   options.output = "frame.png";
///   show::write_frames(rig, io::load_solved_surfaces("solved.json"), options);
///
/// The frames are those that run() shows at the same times. For a viewer (render/viewer.hpp) content lies on
/// virtual surfaces instead, and the solved ones catch the light.
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"
#include "procam/render/renderer.hpp"
#include "procam/surface/blend.hpp"

namespace procam::show {

/// Virtual surfaces, drawn so that an eye sees them at their places behind or before the real ones.
struct ViewerInput {
  Vec3 eye = Vec3::Zero();       ///< metres, in the world; in the rig where the real surfaces have no world
  std::filesystem::path things;  ///< surface definitions in metres
};

struct FrameFilesOptions {
  /// A frame: .png, or its light as floats: .exr. With `seconds` frames, "frame_%04d.png" or .exr, or a video:
  /// .mkv (lossless), .mp4, .avi.
  std::string output;
  double time_s = 0;   ///< of the first frame since the content began
  double seconds = 0;  ///< 0: one frame
  double fps = 25;
  std::map<std::string, std::string> contents;   ///< by surface, instead of its own
  std::map<std::string, ContentLayout> layouts;  ///< likewise
  std::filesystem::path folder;                  ///< the surfaces' own contents are relative to it
  std::optional<ViewerInput> viewer;
  std::optional<surface::BlendedSets> blend;  ///< this projector's set and map first
  double gamma = 0;                           ///< of the projector, light = value^gamma; 0: sRGB
  std::string renderer = "cpu";               ///< cpu or gl
  render::RenderOptions rendering;
  std::string
      preview;  ///< also a picture of the room, .png: of the viewer, or of a person facing the surfaces
  std::string weights;  ///< also the weights of `blend`, .png (8 bits) or .pfm
};

struct FrameFilesReport {
  int frames = 0;
  std::vector<std::string> surfaces;  ///< with content
  std::vector<std::string> contents;  ///< theirs: "picture.png, 800x600"
  std::vector<std::string> files;
  std::string device;  ///< of the renderer
  /// Of the light on the surfaces, what the viewer sees; the size of the viewer's picture.
  std::optional<double> seen_share;
  ImageSize viewer_size;
  Diagnostics diagnostics;
};

/// Called before each frame: number done, number of all.
using FrameProgress = std::function<void(int done, int total)>;

/// Every file appears whole or not at all. Throws Error(kInput) for options that contradict each other and for
/// names of other kinds of file, Error(kDegenerate) for a viewer who sees none of the light, Error(kIo).
PROCAM_EXPORT FrameFilesReport write_frames(const Rig& rig, const SolvedSurfaceSet& solved,
                                            const FrameFilesOptions& options,
                                            const FrameProgress& progress = {});

}  // namespace procam::show
