/// procam-studio: a page in the browser that leads from nothing to a checked image on the wall.
#include "procam/studio/studio.hpp"

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>

#include "common/cli.hpp"
#include "procam/io/text.hpp"

namespace procam::tools {
namespace {

struct Flags {
  studio::StudioOptions studio;
  bool simulate = false;
  studio::SimulatedRoom room;
};

void declare(CLI::App& app, Flags& flags) {
  app.add_option("project", flags.studio.project,
                 "Folder of the project; it is made, or continued where it was left (default: this folder)");
  app.add_option(
         "--control", flags.studio.control,
         "Where the page is served: [ADDRESS:]PORT. 0.0.0.0:8737 for other computers, port 0 for a free one")
      ->capture_default_str();
  app.add_option("--token", flags.studio.token,
                 "The page's secret, 8 to 256 letters of a-z A-Z 0-9 - _ (default: a random one)");
  auto* simulate = app.add_flag("--simulate", flags.simulate,
                                "A simulated projector, camera, room and person instead of devices");
  app.add_option("--seed", flags.room.seed, "Of the simulated room")->needs(simulate)->capture_default_str();
  app.add_option("--level", flags.room.level, "Of the simulated room")
      ->needs(simulate)
      ->capture_default_str();
  add_parsed(
      app, "--camera-size", [&](const std::string& text) { flags.room.camera_size = io::parse_size(text); },
      "Of the simulated camera")
      ->needs(simulate)
      ->default_str("1280x720");
  add_parsed(
      app, "--latency", [&](const std::string& text) { flags.room.latency_s = io::parse_delay(text); },
      "From showing a frame to the simulated camera's image of it")
      ->needs(simulate)
      ->default_str("50ms");
  app.add_option("--projectors", flags.room.projectors, "Simulated projectors: 1 or 2, whose light overlaps")
      ->needs(simulate)
      ->check(CLI::Range(1, 2))
      ->capture_default_str();
  app.add_option("--camera-rate", flags.room.frames_per_s, "Images a second of the simulated camera")
      ->needs(simulate)
      ->check(within(1, 240))
      ->capture_default_str();
}

class Follower : public studio::StudioListener {
 public:
  explicit Follower(Console& console) : console_(console) {}
  void on_start(const std::string& sentence) override { say(sentence); }
  void on_event(const std::string& sentence) override { say(sentence); }
  void on_tick() override { console_.stop_if_requested(); }

 private:
  /// At once, also into a pipe.
  void say(const std::string& sentence) {
    console_.say(sentence);
    std::fflush(stdout);
  }
  Console& console_;
};

ExitCode run(Flags& flags, Console& console) {
  std::signal(SIGPIPE, SIG_IGN);
  if (flags.simulate) flags.studio.simulate = flags.room;
  Follower follower(console);
  studio::run(flags.studio, &follower);
  return ExitCode::kOk;
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"procam-studio",
       "Opens one page in the browser that leads from nothing to a checked image on the wall: display, camera, "
       "board, capture, calibration, surfaces, content, show.",
       true},
      [&](CLI::App& app) { declare(app, flags); }, [&](Console& console) { return run(flags, console); });
}
