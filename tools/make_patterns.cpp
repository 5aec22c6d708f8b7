// make-patterns: the pictures a projector shows for a calibration session, as files.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "common/cli.hpp"
#include "procam/device/video_file.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/io/text.hpp"
#include "procam/session/files.hpp"
#include "procam/session/patterns.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

struct Flags {
  std::string pattern = "gray";
  ImageSize projector_size;
  int step = 1;
  std::optional<Board> board;
  fs::path output, video;
  double hold_s = 1;
};

constexpr double kVideoRate = 10;  // a second: players show slower videos with gaps

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--pattern", flags.pattern, "What is projected: " + session::pattern_help())
      ->capture_default_str();
  add_parsed(
      app, "--projector-size", [&](const std::string& text) { flags.projector_size = io::parse_size(text); },
      "Native resolution of the projector, e.g. 1024x768")
      ->required();
  app.add_option("--step", flags.step, "Stripe width of Gray code in projector pixels")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  add_parsed(
      app, "--board", [&](const std::string& text) { flags.board = io::read_board(text); },
      "The printed board, for session.json, e.g. charuco:5x7:34mm:25mm:5x5_100");
  app.add_option("-o,--output", flags.output, "Folder for show_00.png ... and session.json")->required();
  CLI::Option* video = app.add_option(
      "--video", flags.video,
      "Also write the frames as a video for a player: .mkv (lossless) or .mp4; show it pixel by pixel");
  add_parsed(
      app, "--hold", [&](const std::string& text) { flags.hold_s = io::parse_duration(text); },
      "Time for which the video shows each frame, e.g. 2s (default: 1s)")
      ->needs(video);
}

void write_video(const Flags& flags, const std::vector<ImageU8>& frames, Console& console) {
  const int repeats = std::max(1, int(std::lround(flags.hold_s * kVideoRate)));
  device::VideoFile video(flags.video, flags.projector_size, kVideoRate);
  ImageU8 colour(flags.projector_size, 3);
  for (const ImageU8& frame : frames) {
    for (int y = 0; y < frame.height(); ++y)
      for (int x = 0; x < frame.width(); ++x)
        for (int c = 0; c < 3; ++c) colour.at(x, y, c) = frame.at(x, y, frame.channels() == 3 ? c : 0);
    for (int i = 0; i < repeats; ++i) video.add(colour);
  }
  video.finish();
  console.say(format("each frame for %.1f s: ", repeats / kVideoRate) + flags.video.string());
}

ExitCode make_patterns(const Flags& flags, Console& console) {
  if (!flags.video.empty()) io::require_writable(flags.video);
  const auto pattern = session::make_pattern(flags.pattern, flags.projector_size, flags.step);
  const io::SessionInfo session =
      session::describe_session(*pattern, flags.projector_size, flags.board, flags.step);
  session::make_folder(flags.output);
  session::require_same_session(flags.output, session);
  const std::vector<ImageU8> frames = pattern->frames();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    console.progress("frames", int(i), int(frames.size()));
    io::save_image(flags.output / session::numbered("show", i, ".png"), frames[i]);
  }
  pattern->save_files(flags.output);
  io::save_session(flags.output, session);
  if (!flags.video.empty()) write_video(flags, frames, console);
  console.say(pattern->describe() + ": " + flags.output.string());
  console.say(
      "show them pixel by pixel (no scaling), and put each pose's captures into a folder beside them: " +
      (flags.output / "view_00" / "frame_00.png").string() + " ...");
  console.summary().set("/output", flags.output.string());
  console.summary().set("/pattern", pattern->text());
  console.summary().set("/frames", int(frames.size()));
  console.summary().set("/projector_size", io::format_size(flags.projector_size));
  return ExitCode::kOk;
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"make-patterns",
       "Writes the frames that a projector shows in a calibration session, for other programs than "
       "capture-session."},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return make_patterns(flags, console); });
}
