#include "common/session_reader.hpp"

#include "procam/io/files.hpp"
#include "procam/io/text.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kViewsBeforeGivingUp = 3;

match::BoardView read_view(const SessionPlan& plan, const fs::path& folder, std::vector<InputFile>& inputs,
                           ImageSize& camera_size) {
  const io::CaptureFolder captures =
      io::load_capture_folder(folder, plan.pattern->frame_count(), plan.pattern->channels());
  for (const fs::path& file : captures.files)
    inputs.push_back({(folder.filename() / file.filename()).generic_string(), io::sha256_of_file(file)});
  const std::vector<ViewU8> frames(captures.frames.begin(), captures.frames.end());
  camera_size = frames.front().size();
  match::BoardView view = plan.pattern->read(folder.filename().string(), frames, plan.board);
  view.detections[kCameraDevice].diagnostics.append(captures.diagnostics);
  return view;
}

/// A board missed in one view is a warning; one found nowhere is a wrong --board or no board at all.
void require_board_somewhere(const SessionPlan& plan, const std::vector<match::BoardView>& views) {
  for (const match::BoardView& view : views)
    if (!view.detections[kCameraDevice].observations.empty()) return;
  const Diagnostics& diagnostics = views.front().detections[kCameraDevice].diagnostics;
  const Diagnostic* reason = nullptr;
  for (const char* code : {"board_counts_differ", "board_dictionary_differs", "board_ids_differ",
                           "board_layout_differs", "board_not_found"})
    if (reason == nullptr) reason = diagnostics.find(code);
  throw Error(
      ErrorKind::kInput, "board " + io::format_board(plan.board),
      "no view shows it" +
          (reason != nullptr ? " (" + views.front().name + ": " + reason->message + ")" : ""),
      "give --board as it is printed (of a chessboard the inner corners a row, then the rows), and light "
      "the whole board");
}

}  // namespace

SessionPlan open_session(const fs::path& folder, const io::Session& stated) {
  const io::Session stored = io::load_session(folder).value_or(io::Session{});
  const auto ask = [&](const std::string& what, const std::string& flag) {
    return Error(ErrorKind::kInput, folder.string(), "neither a flag nor session.json states the " + what,
                 "give " + flag);
  };
  SessionPlan plan;
  const auto size = stated.projector_size ? stated.projector_size : stored.projector_size;
  if (!size) throw ask("projector's size", "--projector-size 1024x768");
  plan.projector_size = *size;
  const auto board = stated.board ? stated.board : stored.board;
  if (!board) throw ask("board", "--board chessboard:7x9:75mm");
  plan.board = *board;
  plan.step = (stated.step ? stated.step : stored.step).value_or(1);
  const std::string pattern = !stated.pattern.empty()   ? stated.pattern
                              : !stored.pattern.empty() ? stored.pattern
                                                        : "gray";
  plan.pattern = make_pattern(pattern, plan.projector_size, plan.step);
  plan.views = io::list_views(folder);
  return plan;
}

SessionContents read_session(const SessionPlan& plan, const ReadingProgress& progress) {
  SessionContents contents;
  std::vector<match::BoardView> views;
  ImageSize camera_size;
  for (std::size_t i = 0; i < plan.views.size(); ++i) {
    const std::string name = plan.views[i].filename().string();
    if (progress) progress(name, int(i), int(plan.views.size()));
    try {
      ImageSize size;
      views.push_back(read_view(plan, plan.views[i], contents.inputs, size));
      if (i > 0 && size != camera_size)
        throw Error(ErrorKind::kInput, "its frames",
                    "they are " + io::format_size(size) + ", those of the other views " +
                        io::format_size(camera_size),
                    "capture all views with one camera in one mode");
      camera_size = size;
    } catch (const Error& error) {
      throw Error(error.kind(), "view " + name + ", " + error.subject(), error.why(), error.next());
    }
    if (views.size() == kViewsBeforeGivingUp) require_board_somewhere(plan, views);
  }
  require_board_somewhere(plan, views);
  contents.correspondences =
      match::join(plan.board, session_devices(camera_size, plan.projector_size), views);
  return contents;
}

std::vector<Device> session_devices(ImageSize camera_size, ImageSize projector_size) {
  return {{"camera", DeviceKind::kCamera, camera_size},
          {"projector", DeviceKind::kProjector, projector_size}};
}

}  // namespace procam::tools
