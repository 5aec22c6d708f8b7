#include "recorder_devices.hpp"

#include <algorithm>
#include <set>

#include "procam/io/text.hpp"
#include "procam/session/files.hpp"
#include "same_picture.hpp"

namespace procam::session {
namespace {

/// Names become folders of a view, beside which the writer keeps "rejected".
void require_names(const std::vector<std::string>& names, const char* kind) {
  std::set<std::string> known;
  for (const std::string& name : names) {
    const auto refuse = [&](const std::string& why) {
      throw Error(ErrorKind::kInput, std::string(kind) + " '" + name + "'", why,
                  "name each of several devices once, such as left=0 and right=1");
    };
    if (name.empty()) refuse("it has no name, and there are several");
    if (name.front() == '.' || name.find_first_of("/\\") != std::string::npos || name == "rejected")
      refuse("it cannot be the name of a folder of frames");
    if (!known.insert(name).second) refuse("two have this name");
  }
}

void require_names(const RecorderDevices& devices) {
  std::vector<std::string> projectors, cameras;
  for (const RecorderDevices::Projector& projector : devices.projectors) projectors.push_back(projector.name);
  for (const RecorderDevices::Camera& camera : devices.cameras) cameras.push_back(camera.name);
  if (projectors.size() > 1) require_names(projectors, "projector");
  if (cameras.size() > 1) require_names(cameras, "camera");
  if (projectors.size() < 2 || cameras.size() < 2) return;
  for (const std::string& name : cameras)
    if (std::count(projectors.begin(), projectors.end(), name) != 0)
      throw Error(ErrorKind::kInput, "camera '" + name + "'", "a projector has the same name",
                  "give each device a name of its own");
}

}  // namespace

io::SessionInfo RecorderDevices::session(const std::optional<Board>& board, int step) const {
  require(!projectors.empty(), "RecorderDevices: no projector");
  io::SessionInfo session = describe_session(projectors[0].pattern, projectors[0].screen.size(), board, step);
  if (projectors.size() == 1) return session;
  session.projector_size.reset();
  for (const Projector& projector : projectors) session.projectors[projector.name] = projector.screen.size();
  return session;
}

double SharedScreen::show(ViewU8 picture) {
  ShownBy& own = all_[projector_];
  for (ShownBy& other : all_) {
    if (&other == &own) continue;
    const ImageU8 black(other.device.screen.size(), 1, 0);
    if (same_picture(black, other.shown)) continue;
    other.shown_s = other.device.screen.show(black);
    other.shown = black;
    own.shown = ImageU8();  // its light was mixed with the other's
  }
  if (same_picture(picture, own.shown)) return own.shown_s;
  own.shown_s = own.device.screen.show(picture);
  own.shown = copy_of(picture);
  return own.shown_s;
}

DeviceTable::DeviceTable(const RecorderDevices& devices, const std::function<void()>& tick)
    : devices_(devices), cameras_(devices.cameras.size()) {
  require(!devices.projectors.empty() && !devices.cameras.empty(),
          "RecorderDevices: no projector, or no camera");
  require_names(devices);
  for (const RecorderDevices::Projector& projector : devices.projectors) {
    require(projector.pattern.text() == devices.projectors[0].pattern.text(),
            "RecorderDevices: projectors with different patterns");
    projectors_.emplace_back(projector);
    if (const ImageSize pictures = projectors_.back().pictures[0].size(); projector.screen.size() != pictures)
      throw Error(ErrorKind::kDevice, "window",
                  "it has " + io::format_size(projector.screen.size()) + " pixels, and the pattern " +
                      io::format_size(pictures),
                  "turn off the desktop's scaling of that display");
  }
  for (std::size_t p = 0; p < devices.projectors.size(); ++p)
    for (std::size_t c = 0; c < devices.cameras.size(); ++c) {
      std::vector<std::string> names;
      if (devices.projectors.size() > 1) names.push_back(devices.projectors[p].name);
      if (devices.cameras.size() > 1) names.push_back(devices.cameras[c].name);
      std::string folder, title;
      for (const std::string& name : names) {
        folder += (folder.empty() ? "" : "/") + name;
        title += (title.empty() ? "" : ", ") + name;
      }
      pairs_.emplace_back(projectors_, p, devices.cameras[c].source, c, folder, tick);
      if (!title.empty()) pairs_.back().title = title + ": ";
    }
}

}  // namespace procam::session
