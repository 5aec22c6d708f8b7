#include "procam/session/projected_board.hpp"

#include "procam/io/files.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/io/session/pattern_file.hpp"
#include "procam/io/text.hpp"

namespace procam::session {
namespace {

namespace fs = std::filesystem;

/// What session.json in the folder, or in the one above, states.
std::string stated_pattern(const fs::path& captures) {
  const fs::path folder = captures.lexically_normal();
  for (const fs::path& place :
       {folder, (folder.filename().empty() ? folder.parent_path() : folder).parent_path()})
    if (const auto session = io::load_session(place.empty() ? fs::path(".") : place))
      if (!session->pattern.empty()) return session->pattern;
  throw Error(ErrorKind::kInput, captures.string(), "no session.json there or above says what was shown",
              "give --pattern, e.g. --pattern charuco");
}

}  // namespace

ProjectedBoardCapture read_projected_board(const fs::path& captures, const std::string& pattern_text,
                                           ImageSize projector_size, ImageSize camera_size) {
  ProjectedBoardCapture result;
  result.pattern = pattern_text.empty() ? stated_pattern(captures) : pattern_text;
  const auto pattern = make_pattern(result.pattern, projector_size);
  if (!pattern->on_blank_paper())
    throw Error(ErrorKind::kInput, "pattern '" + result.pattern + "'", "it is not a projected board",
                "show one of chessboard, charuco, markers, circles (charuco: any part of it is enough)");
  const io::CaptureFolder folder =
      io::load_capture_folder(captures, pattern->frame_count(), pattern->channels());
  const ImageSize size = folder.frames.front().size();
  if (size != camera_size)
    throw Error(ErrorKind::kInput, captures.string(),
                "its pictures have " + io::format_size(size) + " pixels, the rig's camera " +
                    io::format_size(camera_size),
                "use pictures of that camera in the mode in which it was calibrated, neither scaled nor cut");
  const auto light = pattern->read_light({folder.frames.begin(), folder.frames.end()});
  if (light->points.empty())
    throw Error(
        ErrorKind::kInput, captures.string(),
        "the pattern " + result.pattern + " is not found in it" +
            (light->diagnostics.items.empty() ? "" : " (" + light->diagnostics.items.front().message + ")"),
        "give the --pattern that was shown, and let the camera see it sharp and bright");
  result.light = *light;
  result.light.diagnostics.append(folder.diagnostics);
  for (const fs::path& file : folder.files)
    result.inputs.push_back({file.string(), io::sha256_of_file(file)});
  return result;
}

}  // namespace procam::session
