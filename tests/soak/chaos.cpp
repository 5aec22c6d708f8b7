/// The chaos test: the real tool, and everything done to it that a year on a shared network may bring.
///
///   chaos --minutes 10 [--seed 7] [--memory-mib 3] [--dropped 0.02] [--only "full disk"] [--log FOLDER]
///
/// Calm first, then one fault after the other, every kind once and then by chance, with calm times in between. After
/// each: the shows still run and answer, and the fault was counted by its name. At the end a table and a verdict; exit
/// code 1 when something failed.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "chaos_steps.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::test {
namespace {

struct Options {
  double minutes = 10;
  std::uint64_t seed = std::random_device()();
  double memory_mib = 3;
  double dropped = 0.02;  ///< share of frames above that of calm times
  std::string only;       ///< steps whose name contains it
  std::string log;        ///< folder that the shows' messages are copied to
};

/// Frames of one show over some time.
struct Frames {
  double shown = 0, dropped = 0;
  double dropped_share() const { return dropped / std::max(1.0, shown + dropped); }
};

class Chaos {
 public:
  explicit Chaos(const Options& options)
      : options_(options),
        stage_(options.seed),
        shows_{stage_.show.get(), stage_.room.get(), stage_.marker.get()} {}

  int run() {
    begin_ = device::now_s();
    if (!is_ready()) return 1;
    if (const std::string missing = stage_.repair(); !missing.empty()) fail("at the start " + missing);
    calm(is_short() ? 5 : 15);
    std::vector<ChaosStep> steps = chaos_steps(stage_);
    steps.erase(std::remove_if(steps.begin(), steps.end(),
                               [&](const ChaosStep& s) { return s.name.find(options_.only) == s.name.npos; }),
                steps.end());
    std::shuffle(steps.begin(), steps.end(), stage_.random);
    const double end = begin_ + 60 * options_.minutes;
    const std::size_t in_a_row = 12;
    for (std::size_t i = 0; device::now_s() < end && is_alive_; ++i) {
      do_step(i < steps.size() ? steps[i] : steps[stage_.random() % steps.size()]);
      if (i + 1 == steps.size()) {
        note_resources(first_);
        memory_.clear();
      }
      if (i % in_a_row == in_a_row - 1 && is_alive_) calm(is_short() ? 1 : 5);
    }
    stage_.repair();
    if (is_alive_) calm(is_short() ? 3 : 10);
    if (first_.empty()) note_resources(first_);
    note_resources(last_);
    end_shows();
    return report();
  }

 private:
  bool is_short() const { return options_.minutes < 5; }

  void fail(const std::string& what) {
    failures_.push_back(what);
    std::printf("FAILED at %.0f s: %s\n", device::now_s() - begin_, what.c_str());
    std::fflush(stdout);
  }

  template <typename Condition>
  bool wait_for(double seconds, const Condition& holds) {
    for (const double end = device::now_s() + seconds; device::now_s() < end;) {
      if (holds()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return holds();
  }

  bool is_ready() {
    for (ChaosShow* show : shows_)
      if (!wait_for(60, [&] { return !show->is_running() || show->metric("frames") > 5; }) ||
          !show->is_running()) {
        fail(show->name() + " does not start: " + show->log());
        return false;
      }
    return true;
  }

  Frames frames_of(const ChaosShow& show) const {
    const auto metrics = show.metrics();
    const auto value = [&](const char* name) { return metrics.count(name) == 0 ? 0 : metrics.at(name); };
    return {value("frames"), value("frames_dropped")};
  }

  /// Frames since the last call belong to what has happened since.
  void add_frames(std::array<Frames, 3>& sum) {
    for (std::size_t i = 0; i < shows_.size(); ++i) {
      const Frames now = frames_of(*shows_[i]);
      if (now.shown == 0) continue;  // no answer; found by check_alive()
      sum[i].shown += now.shown - seen_[i].shown;
      sum[i].dropped += now.dropped - seen_[i].dropped;
      seen_[i] = now;
    }
  }

  void calm(double seconds) {
    std::this_thread::sleep_for(std::chrono::seconds(1));  // recovery belongs to the fault
    add_frames(chaos_);
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    add_frames(calm_);
    check_alive("in a calm time");
    const auto is_fresh = [&] {
      const nlohmann::json status = stage_.show->status();
      return status.is_object() && status.value("pose_state", "") == "fresh";
    };
    if (!wait_for(10, is_fresh)) fail("the pose is not fresh in a calm time");
  }

  void check_alive(const std::string& when) {
    for (std::size_t i = 0; i < shows_.size(); ++i) {
      ChaosShow& show = *shows_[i];
      if (!show.is_running()) {
        fail(show.name() + " has ended " + when + "\n" + show.log());
        is_alive_ = false;
        return;
      }
      const double before = show.metric("frames");
      if (!wait_for(20, [&] { return show.metric("frames") > before && !show.status().is_discarded(); })) {
        fail(show.name() + " hangs " + when);
        is_alive_ = false;
      }
    }
  }

  void do_step(const ChaosStep& step) {
    const auto counted = [&] {
      const auto metrics = step.show->metrics();
      double sum = 0;
      for (const std::string& counter : step.counters)
        sum += metrics.count(counter) == 0 ? 0 : metrics.at(counter);
      return sum;
    };
    const double before = counted(), begin = device::now_s();
    const std::string failure = step.act();
    if (!failure.empty()) fail(step.name + ": " + failure);
    double faults = 0;
    // Longer than the patience of what reads cameras and files.
    if (!step.counters.empty() && !wait_for(25, [&] { return (faults = counted() - before) > 0; }))
      fail(step.name + ": not counted as " + step.counters.front());
    step.end();
    if (const std::string missing = stage_.repair(); !missing.empty()) fail(step.name + ": " + missing);
    check_alive("after " + step.name);
    add_frames(chaos_);
    std::array<double, 3> memory{};
    for (std::size_t i = 0; i < shows_.size(); ++i) memory[i] = shows_[i]->resources().memory_mib;
    memory_.push_back(memory);
    Done& done = done_[step.name];
    ++done.times;
    done.faults += faults;
    done.seconds += device::now_s() - begin;
    done.counter = step.counters.empty() ? "-" : step.show->name() + " " + step.counters.front();
    ++steps_;
  }

  void note_resources(std::vector<Resources>& into) {
    // Connections of the last step are closed within the patience of both sides.
    std::this_thread::sleep_for(std::chrono::seconds(is_short() ? 1 : 12));
    into.clear();
    for (ChaosShow* show : shows_) into.push_back(held_resources(*show));
  }

  /// A file that is just being read has a descriptor: the fewest of several samples are held all the time.
  static Resources held_resources(const ChaosShow& show) {
    constexpr int kSamples = 20;
    Resources held = show.resources();
    for (int i = 1; i < kSamples; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(37));  // beside the rates of the shows
      const Resources now = show.resources();
      held.descriptors = std::min(held.descriptors, now.descriptors);
      held.threads = std::min(held.threads, now.threads);
    }
    return held;
  }

  void end_shows() {
    for (std::size_t i = 0; i < shows_.size(); ++i) {
      int exit_code = 0;
      summaries_[i] = shows_[i]->end(exit_code);
      if (exit_code != 130)
        fail(shows_[i]->name() + " ended with " + std::to_string(exit_code) + "\n" + shows_[i]->log());
      if (!options_.log.empty())
        std::ofstream(options_.log + "/" + shows_[i]->name() + ".log") << shows_[i]->log();
      if (!summaries_[i].is_object()) fail(shows_[i]->name() + " printed no statistics");
    }
  }

  int report() {
    std::printf("\n%-32s %6s %9s %8s  %s\n", "fault", "times", "counted", "seconds", "as");
    for (const auto& [name, done] : done_)
      std::printf("%-32s %6d %9.0f %8.1f  %s\n", name.c_str(), done.times, done.faults, done.seconds,
                  done.counter.c_str());
    std::printf("\n%-8s %9s %9s %12s %12s %15s %13s %9s %16s\n", "show", "frames", "dropped", "calm share",
                "chaos share", "memory MiB", "descriptors", "threads", "pose age max ms");
    for (std::size_t i = 0; i < shows_.size(); ++i) report_show(i);
    if (steps_ < 1) fail("no step was done");
    std::printf("\nseed %llu, %.1f minutes, %d steps of %zu kinds, %zu failures: %s\n",
                (unsigned long long)options_.seed, (device::now_s() - begin_) / 60, steps_, done_.size(),
                failures_.size(), failures_.empty() ? "PASSED" : "FAILED");
    for (const std::string& failure : failures_)
      std::printf("  %s\n", failure.substr(0, failure.find('\n')).c_str());
    return failures_.empty() ? 0 : 1;
  }

  void report_show(std::size_t i) {
    const std::string& name = shows_[i]->name();
    const nlohmann::json& summary = summaries_[i];
    const Resources &first = first_[i], &last = last_[i];
    const double age = summary.is_object() && summary.contains("pose_age_ms")
                           ? summary["pose_age_ms"].value("largest", 0.0)
                           : 0;
    std::printf("%-8s %9.0f %9.0f %11.2f%% %11.2f%% %7.1f %7.1f %6d %6d %4d %4d %16.1f\n", name.c_str(),
                calm_[i].shown + chaos_[i].shown, calm_[i].dropped + chaos_[i].dropped,
                100 * calm_[i].dropped_share(), 100 * chaos_[i].dropped_share(), first.memory_mib,
                last.memory_mib, first.descriptors, last.descriptors, first.threads, last.threads, age);
    if (summary.is_object() && summary.contains("faults"))
      std::printf("         faults %s\n", summary["faults"].dump().c_str());
    if (chaos_[i].dropped_share() > calm_[i].dropped_share() + options_.dropped)
      fail(name + ": more frames dropped than in calm times");
    report_memory(i);
    if (last.descriptors != first.descriptors) fail(name + ": the number of descriptors changes");
    if (last.threads != first.threads) fail(name + ": the number of threads changes");
    const double bound = i == 0 ? 300.1 : 1000.1;  // --blank-on-stale
    if (age > bound) fail(name + ": a frame was drawn for a pose that is too old");
  }

  /// Memory after a step depends on the contents of the moment, so medians of tenths of the run are compared.
  void report_memory(std::size_t show) {
    const std::size_t count = memory_.size(), parts = std::min<std::size_t>(10, count);
    if (count == 0) return;
    std::vector<double> medians;
    for (std::size_t k = 0; k < parts; ++k) {
      std::vector<double> part;
      for (std::size_t i = k * count / parts; i < (k + 1) * count / parts; ++i)
        part.push_back(memory_[i][show]);
      medians.push_back(median(std::move(part)));
    }
    std::printf("         medians of memory over the run, MiB:");
    for (const double median : medians) std::printf(" %.1f", median);
    std::printf("\n");
    if (medians.back() > medians.front() + options_.memory_mib) fail(shows_[show]->name() + ": memory grows");
  }

  struct Done {
    int times = 0;
    double faults = 0, seconds = 0;
    std::string counter;
  };

  const Options options_;
  ChaosStage stage_;
  std::array<ChaosShow*, 3> shows_;
  std::array<Frames, 3> seen_, calm_, chaos_;
  std::array<nlohmann::json, 3> summaries_;
  std::vector<Resources> first_, last_;
  std::vector<std::array<double, 3>>
      memory_;  ///< of the shows, MiB, after each step since every kind was done once
  std::map<std::string, Done> done_;
  std::vector<std::string> failures_;
  double begin_ = 0;
  int steps_ = 0;
  bool is_alive_ = true;
};

}  // namespace
}  // namespace procam::test

int main(int argc, char** argv) {
  procam::test::Options options;
  const std::map<std::string, std::function<void(const char*)>> flags = {
      {"--minutes", [&](const char* text) { options.minutes = std::atof(text); }},
      {"--seed", [&](const char* text) { options.seed = std::strtoull(text, nullptr, 10); }},
      {"--memory-mib", [&](const char* text) { options.memory_mib = std::atof(text); }},
      {"--dropped", [&](const char* text) { options.dropped = std::atof(text); }},
      {"--only", [&](const char* text) { options.only = text; }},
      {"--log", [&](const char* text) { options.log = text; }}};
  for (int i = 1; i < argc; i += 2) {
    const auto flag = flags.find(argv[i]);
    if (flag == flags.end() || i + 1 == argc) {
      std::fprintf(
          stderr,
          "usage: chaos [--minutes M] [--seed N] [--memory-mib L] [--dropped SHARE] [--only STEP] [--log FOLDER]\n");
      return 2;
    }
    flag->second(argv[i + 1]);
  }
  // glibc keeps some 20 MiB of what was freed once a large block was (mallopt(3), M_MMAP_THRESHOLD). What is measured is
  // the memory in use, so a fixed threshold gives it back.
  setenv("MALLOC_MMAP_THRESHOLD_", "131072", 1);
  std::printf("seed %llu\n", (unsigned long long)options.seed);
  std::fflush(stdout);
  return procam::test::Chaos(options).run();
}
