/// project-live: rig + surfaces + contents + poses -> frames on a projector, until the show is ended.
#include <CLI/CLI.hpp>
#include <csignal>

#include "common/cli.hpp"
#include "common/service_notify.hpp"
#include "common/show_flags.hpp"
#include "common/show_lines.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/show/run.hpp"

namespace procam::tools {
namespace {

struct Flags {
  std::string rig, replay, save;
  bool list_displays = false, identify = false;
  show::ShowOptions show;
};

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--rig", flags.rig,
                 "rig.json of calibrate-projector. Without a rig, surfaces are in projector pixels and their "
                 "corners are dragged on the control page");
  declare_show(app, flags.show);
  app.add_option("--replay", flags.replay, "Show a recorded run again and compare each frame");
  app.add_option("--save-show", flags.save, "Write the options into a show.json, for --show, and end");
  app.add_flag("--list-displays", flags.list_displays, "List the displays and end");
  app.add_flag("--identify", flags.identify, "Show each display its number for three seconds and end");
}

ExitCode list_displays(Console& console) {
  std::vector<std::string> lines;
  for (const device::Display& display : device::displays()) {
    lines.push_back(format("%d: %s, %dx%d at %d,%d, %.0f Hz%s", display.number, display.name.c_str(),
                           display.size.width, display.size.height, display.x, display.y, display.refresh_hz,
                           display.is_primary ? ", primary" : ""));
    console.say("display " + lines.back());
  }
  console.summary().set("/displays", lines);
  return ExitCode::kOk;
}

/// Prints what happens, and keeps the newest report for a show that is interrupted.
class Follower : public show::ShowListener {
 public:
  explicit Follower(Console& console) : console_(console) {}
  void on_start(const std::string& sentence) override { console_.say(sentence); }
  void on_load(int done, int total) override { console_.progress("surface", done, total); }
  void on_event(const std::string& sentence) override { console_.log(sentence); }
  void on_frame(const show::ShowReport& report) override {
    newest_ = report;
    if (report.metrics.frames > 0) service_.frame_shown();
    console_.stop_if_requested();
    if (report.metrics.frames % 16 == 0) console_.progress("frame", int(report.metrics.frames), 0);
  }
  const show::ShowReport& newest() const { return newest_; }

 private:
  Console& console_;
  ServiceNotifier service_;
  show::ShowReport newest_;
};

void print_durations(const char* name, const show::Durations& durations, Console& console) {
  const std::pair<const char*, double> columns[] = {{"p50", 1e3 * durations.quantile(0.5)},
                                                    {"p90", 1e3 * durations.quantile(0.9)},
                                                    {"p99", 1e3 * durations.quantile(0.99)},
                                                    {"largest", 1e3 * durations.largest()}};
  std::string line = format("%-14s", name);
  for (const auto& [column, ms] : columns) {
    line += format(" %9.2f", ms);
    console.summary().set(std::string("/") + name + "_ms/" + column, ms);
  }
  console.say(line);
}

void print_people(const show::PeopleCounts& people, Console& console) {
  console.say(
      format("people: %llu frames of skeletons taken, %llu malformed, %llu refused, %llu repeated or late, "
             "%llu joints that jumped; %llu sent to contents",
             (unsigned long long)people.frames, (unsigned long long)people.malformed,
             (unsigned long long)people.refused, (unsigned long long)people.repeated,
             (unsigned long long)people.teleports, (unsigned long long)people.sent));
  Summary& summary = console.summary();
  summary.set("/people/frames", double(people.frames));
  summary.set("/people/malformed", double(people.malformed));
  summary.set("/people/refused", double(people.refused));
  summary.set("/people/teleports", double(people.teleports));
  summary.set("/people/sent", double(people.sent));
}

/// What failed while the show went on.
void print_faults(const show::Metrics& metrics, Console& console) {
  std::string words;
  for (const auto& [name, count] : metrics.faults) {
    console.summary().set("/faults/" + name, double(count));
    words += format("%s%s %llu", words.empty() ? "" : ", ", name.c_str(), (unsigned long long)count);
  }
  if (!words.empty()) console.say("faults: " + words);
}

void print(const show::ShowReport& report, const show::ShowOptions& options, Console& console) {
  const show::Metrics& m = report.metrics;
  console.say(format("%llu frames, %llu skipped as too late, %llu black without a pose",
                     (unsigned long long)m.frames, (unsigned long long)m.dropped,
                     (unsigned long long)m.blanked));
  console.say(format("%-14s %9s %9s %9s %9s", "ms", "p50", "p90", "p99", "largest"));
  print_durations("draw", m.draw, console);
  print_durations("render", m.render, console);
  print_durations("jitter", m.jitter, console);
  print_durations("pose_age", m.pose_age, console);
  print_durations("pose_to_frame", m.pose_to_frame, console);
  print_faults(m, console);
  const std::pair<const char*, std::uint64_t> counts[] = {
      {"frames", m.frames},       {"dropped", m.dropped},
      {"blanked", m.blanked},     {"waiting", m.waiting},
      {"checked", m.checked},     {"dark", m.dark},
      {"reloads", m.reloads},     {"failed_reloads", m.failed_reloads},
      {"poses/arrived", m.poses}, {"poses/malformed", m.malformed}};
  for (const auto& [name, count] : counts) console.summary().set(std::string("/") + name, double(count));
  std::string words;
  for (const auto& [name, count] : named_counts(report.poses)) {
    console.summary().set(std::string("/poses/") + name, double(count));
    if (count > 0) words += format("%s%s %llu", words.empty() ? "" : ", ", name, (unsigned long long)count);
  }
  if (!words.empty())
    console.say("poses: " + words + format(", malformed %llu", (unsigned long long)m.malformed));
  if (m.group) print_group(*m.group, console);
  if (m.fleet) print_fleet(*m.fleet, console);
  print_tracked(m.moving, console);
  if (report.people) print_people(*report.people, console);
  console.report(show::darkness(report, options));
}

ExitCode replay(const Flags& flags, const Rig& rig, Console& console) {
  Follower follower(console);
  const show::ReplayReport report = show::replay(rig, flags.show, flags.replay, &follower);
  console.say(format("%llu frames, %llu of them equal to the recorded ones bit for bit",
                     (unsigned long long)report.frames, (unsigned long long)report.equal));
  console.summary().set("/frames", double(report.frames));
  console.summary().set("/equal", double(report.equal));
  return report.frames == report.equal ? ExitCode::kOk : ExitCode::kGateFailed;
}

ExitCode run(const Flags& flags, Console& console) {
  Follower follower(console);
  if (flags.list_displays) return list_displays(console);
  if (flags.identify) return show::identify_displays(&follower), ExitCode::kOk;
  const auto need = [](const std::string& value, const char* flag) {
    if (value.empty())
      throw Error(ErrorKind::kInput, flag, "it is not given", "see project-live --help for a line to try");
  };
  need(flags.show.surfaces, "--surfaces");
  if (!flags.save.empty()) return show::save_options(flags.save, flags.show), ExitCode::kOk;
  if (!flags.replay.empty()) need(flags.rig, "--rig");
  const std::optional<Rig> rig = flags.rig.empty() ? std::nullopt : std::optional(io::load_rig(flags.rig));
  if (!flags.replay.empty()) return replay(flags, *rig, console);
  try {
    // A reader of the messages that goes away does not end the show.
    std::signal(SIGPIPE, SIG_IGN);
    print(rig ? show::run(*rig, flags.show, &follower) : show::run(flags.show, &follower), flags.show,
          console);
  } catch (...) {  // Ctrl-C, SIGTERM, a pipe that broke: what was measured is printed all the same
    if (follower.newest().metrics.frames > 0) print(follower.newest(), flags.show, console);
    throw;
  }
  return ExitCode::kOk;
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"project-live",
       "Projects onto surfaces while the robot moves: poses arrive over the network, are predicted "
       "to the time of light, and every frame is drawn for that pose. A control page shows the frame "
       "and moves corners.",
       true},
      [&](CLI::App& app) { declare(app, flags); }, [&](Console& console) { return run(flags, console); });
}
