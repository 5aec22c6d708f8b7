#include "procam/session/calibration_input.hpp"

#include <algorithm>
#include <utility>

#include "procam/io/files.hpp"
#include "procam/io/session/observations_file.hpp"
#include "procam/io/text.hpp"
#include "procam/session/join.hpp"

namespace procam::session {

CalibrationInput read_observations(const std::filesystem::path& file, const std::vector<Device>& devices,
                                   const std::optional<Board>& board) {
  const Correspondences found = io::load_observations(file, {board, devices});
  std::vector<session::BoardView> views;
  for (const View& view : found.views) {
    session::BoardView& same = views.emplace_back();
    same.name = view.name;
    same.light_points = view.light_points;
    for (std::size_t d = 0; d < found.devices.size(); ++d)
      same.detections.push_back({found.devices[d].size, view.observations[d], {}});
  }
  CalibrationInput input;
  input.correspondences = session::join(found.board, found.devices, views);
  input.inputs = {{file.filename().string(), io::sha256_of_file(file)}};
  input.options["board"] = io::format_board(found.board);
  for (const Device& device : found.devices)
    input.options["size of " + device.name] = io::format_size(device.size);
  input.views = int(views.size());
  input.title = file.stem().string();
  return input;
}

Device parse_device(const std::string& text, DeviceKind kind) {
  const std::size_t equals = text.find('=');
  const std::string name = equals == std::string::npos
                               ? (kind == DeviceKind::kCamera ? "camera" : "projector")
                               : text.substr(0, equals);
  if (name.empty())
    throw Error(ErrorKind::kInput, "'" + text + "'", "the device's name is empty",
                "give e.g. left=1280x1024");
  return {name, kind, io::parse_size(equals == std::string::npos ? text : text.substr(equals + 1))};
}

}  // namespace procam::session
