#include "common/capture_flags.hpp"

#include "common/cli.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/text.hpp"
#include "procam/session/patterns.hpp"

namespace procam::tools {
namespace {

/// What stands before the first '=', if it can be a name: of "http://host/?a=b" it cannot.
std::optional<std::string> name_in(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) return std::nullopt;
  const std::string name = text.substr(0, equals);
  if (name.find_first_of("/\\:?") != std::string::npos) return std::nullopt;
  return name;
}

void declare_devices(CLI::App& app, CaptureFlags& flags) {
  auto* camera =
      app.add_option("--camera", flags.cameras,
                     "Camera: its number, device or URL, or ros2:/TOPIC; of several cameras one for each, "
                     "with its name: --camera left=0 --camera right=1")
          ->expected(1)
          ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  auto* watch =
      app.add_option("--watch-folder", flags.watch, "Folder into which a separate camera writes its images");
  camera->excludes(watch);
  add_parsed(
      app, "--camera-size",
      [&](const std::string& text) { flags.camera_options.size = io::parse_size(text); },
      "Image size of the cameras, e.g. 1280x720 (default: the driver's)")
      ->needs(camera);
  app.add_option(
         "--dds-security", flags.dds_security,
         "Folder with the certificates of DDS Security, as ros2 security create_enclave writes it: for cameras "
         "ros2:/TOPIC")
      ->needs(camera);
  app.add_option("--exposure", flags.camera_options.exposure,
                 "Exposure in the unit of the camera driver; switches automatic exposure off")
      ->needs(camera);
  app.add_option(
         "--display", flags.displays,
         "Display of the projector: number, name or a part of it, or position on the desktop such as "
         "1920,0 (default: the display that is not primary); of several projectors one for each, with its "
         "name: --display lamp=1 --display beamer=2")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_flag("--list-displays", flags.list_displays, "List the displays and end");
}

}  // namespace

void declare_capture(CLI::App& app, CaptureFlags& flags) {
  declare_devices(app, flags);
  app.add_option("--pattern", flags.pattern, "What is projected: " + session::pattern_help())
      ->capture_default_str();
  app.add_option("--step", flags.recorder.step, "Stripe width of Gray code in projector pixels")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  add_parsed(
      app, "--board", [&](const std::string& text) { flags.board = io::read_board(text); },
      "The printed board, e.g. charuco:5x7:34mm:25mm:5x5_100, or a board file (without one: a room for "
      "calibrate-room and scan-surfaces)");
  app.add_option(
         "--views", flags.views,
         "Number of poses of the board (default 8), or without a board of places of the camera (default 2; "
         "of several cameras 1)")
      ->check(CLI::Range(1, 1000));
  add_parsed(
      app, "--interval",
      [&](const std::string& text) {
        if (!((flags.recorder.interval_s = io::parse_duration(text)) > 0))
          throw Error(ErrorKind::kInput, "--interval " + text, "a time must be positive", "give e.g. 8s");
      },
      "Time to move the board, or the camera, between views, e.g. 8s (default: wait for Enter)");
  app.add_flag("--single-shot", flags.recorder.single_shot,
               "For a camera that is triggered by hand: one image for each frame, without checks");
  app.add_flag("--despite-checks", flags.recorder.despite_checks, "Continue when a check of the light fails");
  app.add_option("-o,--output", flags.recorder.folder, "Session folder; an existing session is continued");
}

std::vector<std::pair<std::string, std::string>> named_places(const std::string& flag,
                                                              const std::vector<std::string>& typed) {
  if (typed.size() == 1) {
    const std::optional<std::string> name = name_in(typed[0]);
    return {{"", name ? typed[0].substr(name->size() + 1) : typed[0]}};
  }
  std::vector<std::pair<std::string, std::string>> places;
  for (const std::string& text : typed) {
    const std::optional<std::string> name = name_in(text);
    if (!name)
      throw Error(ErrorKind::kInput, flag + " " + text, "of several, each needs a name: NAME=PLACE",
                  "give e.g. " + flag + " left=0 " + flag + " right=1");
    places.emplace_back(*name, text.substr(name->size() + 1));
  }
  return places;
}

int default_views(const CaptureFlags& flags) {
  if (flags.board) return 8;
  return flags.cameras.size() > 1 ? 1 : 2;
}

}  // namespace procam::tools
