// Sessions that need no pattern: tables of observations, and images of a board by one camera.
#include <utility>

#include "folder_name.hpp"
#include "identical_files.hpp"
#include "preview.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/detect/detect_board.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/session/observations_file.hpp"
#include "procam/io/text.hpp"
#include "procam/session/join.hpp"
#include "procam/session/reader.hpp"

namespace procam::session {
namespace {

namespace fs = std::filesystem;

/// The size of most images of the folder. An image whose header cannot be read is named when it is read.
ImageSize size_of_most(const fs::path& folder, const std::vector<fs::path>& files) {
  const auto size = io::common_image_size({folder});
  return size ? *size : io::load_image(files.front()).image.size();
}

}  // namespace

SessionContents read_observations(const fs::path& file, const std::vector<Device>& devices,
                                  const std::optional<Board>& board) {
  const Correspondences found = io::load_observations(file, {board, devices});
  std::vector<BoardView> views;
  for (const View& view : found.views) {
    BoardView& same = views.emplace_back();
    same.name = view.name;
    same.light_points = view.light_points;
    for (std::size_t d = 0; d < found.devices.size(); ++d)
      same.detections.push_back({found.devices[d].size, view.observations[d], {}});
  }
  SessionContents contents;
  contents.correspondences = join(found.board, found.devices, views);
  contents.inputs = {{file.filename().string(), io::sha256_of_file(file)}};
  contents.options["board"] = io::format_board(found.board);
  for (const Device& device : found.devices)
    contents.options["size of " + device.name] = io::format_size(device.size);
  contents.views = int(views.size());
  contents.title = file.stem().string();
  return contents;
}

Detections read_board_image(const fs::path& file, const Board& board) {
  return detect::detect_board(io::green_channel(io::load_image(file).image), board);
}

SessionContents read_board_images(const fs::path& folder, const Board& board,
                                  const ReadingProgress& progress) {
  const std::vector<fs::path> files = io::list_images(folder);
  if (files.empty())
    throw Error(ErrorKind::kInput, folder.string(), "it holds no image",
                "give a folder of photographs (png, jpg, bmp, tif), one a board pose");
  const ImageSize size = size_of_most(folder, files);
  SessionContents contents;
  std::vector<BoardView> views;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::string name = files[i].filename().string();
    if (progress) progress(name, int(i), int(files.size()));
    const ImageU8 grey = io::green_channel(io::load_image(files[i]).image);
    BoardView& view = views.emplace_back();
    view.name = name;
    if (grey.size() == size) {
      contents.inputs.push_back({name, io::sha256_of_file(files[i])});
      view.detections = {detect::detect_board(grey, board)};
      contents.view_images.push_back(preview(name, "camera", {grey}));
      continue;
    }
    Detections rejected{size, {}, {}};
    rejected.diagnostics.warn("image_size_differs", name + " is rejected: it is " +
                                                        io::format_size(grey.size()) +
                                                        ", the other images are " + io::format_size(size));
    view.detections = {rejected};
  }
  contents.correspondences = join(board, {{"camera", DeviceKind::kCamera, size}}, views);
  warn_of_identical_files(contents.inputs, contents.correspondences.diagnostics);
  contents.options["board"] = io::format_board(board);
  contents.views = int(files.size());
  contents.title = folder_name(folder);
  return contents;
}

Provenance provenance(const SessionContents& contents, const std::string& program) {
  Provenance of;
  of.tool = program;
  of.version = PROCAM_VERSION;
  of.created = utc_now();
  of.options = contents.options;
  of.inputs = contents.inputs;
  return of;
}

}  // namespace procam::session
