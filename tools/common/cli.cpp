#include "common/cli.hpp"

#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <limits>
#include <new>
#include <nlohmann/json.hpp>

#include "common/examples.hpp"
#include "common/help.hpp"
#include "common/note_groups.hpp"
#include "common/renamed_options.hpp"

namespace procam::tools {
namespace {

using Json = nlohmann::ordered_json;

/// Raised by Console::stop_if_requested() after a signal.
struct Interrupted {};

volatile std::sig_atomic_t stop_signal = 0;

extern "C" void on_stop_signal(int signal) {
  // The same signal again does not wait for the next step. A terminal that closes may send SIGHUP twice.
  if (stop_signal == signal && signal != SIGHUP) _exit(static_cast<int>(ExitCode::kInterrupted));
  stop_signal = signal;
}

/// Takes the signals that end a program for the time of the run, and gives them back. A signal that was
/// ignored before (nohup) stays so. A limit of file sizes becomes an error of the write, as a full disk is.
class SignalScope {
 public:
  SignalScope() {
    stop_signal = 0;
    for (std::size_t i = 0; i < std::size(kStopSignals); ++i) {
      sigaction(kStopSignals[i], nullptr, &previous_[i]);
      if (previous_[i].sa_handler == SIG_IGN && kStopSignals[i] != SIGINT) continue;
      struct sigaction action = {};
      action.sa_handler = on_stop_signal;
      sigaction(kStopSignals[i], &action, nullptr);
    }
    struct sigaction ignored = {};
    ignored.sa_handler = SIG_IGN;
    sigaction(SIGXFSZ, &ignored, &file_size_);
  }
  ~SignalScope() {
    for (std::size_t i = 0; i < std::size(kStopSignals); ++i)
      sigaction(kStopSignals[i], &previous_[i], nullptr);
    sigaction(SIGXFSZ, &file_size_, nullptr);
  }
  SignalScope(const SignalScope&) = delete;
  SignalScope& operator=(const SignalScope&) = delete;

 private:
  static constexpr int kStopSignals[] = {SIGINT, SIGTERM, SIGHUP};
  struct sigaction previous_[std::size(kStopSignals)] = {};
  struct sigaction file_size_ = {};
};

const char* stop_reason() {
  return stop_signal == SIGTERM  ? "the signal SIGTERM came"
         : stop_signal == SIGHUP ? "the terminal was closed (SIGHUP)"
                                 : "Ctrl-C was pressed";
}

/// An option that the tool does not have, or a word where none is expected.
struct UnknownArgument {
  std::string typed, nearest;
};

/// An option whose value cannot be used.
struct BadValue {
  std::string flag;
  Error error;
};

/// The report of a failure, for people and for programs.
struct Failure {
  ExitCode code;
  std::string kind, what, why, next;
};

Failure describe_current_exception(const ToolInfo& info) {
  const std::string next_for_bug = "this is a bug in procam; please report it with the command and its input";
  try {
    throw;
  } catch (const Interrupted&) {
    return {ExitCode::kInterrupted, "interrupted", info.runs_until_stopped ? "stopped" : "interrupted",
            stop_reason(),
            info.runs_until_stopped
                ? "no action is needed; the same command starts again"
                : "files that were already complete are kept; run the command again for the rest"};
  } catch (const Error& error) {
    return {exit_code(error.kind()), procam::to_string(error.kind()), error.subject(), error.why(),
            error.next()};
  } catch (const UnknownArgument& unknown) {
    return {ExitCode::kUsage, "usage", "'" + unknown.typed.substr(0, 80) + "'",
            unknown.typed.rfind("-", 0) == 0
                ? "the tool has no such option"
                : "it stands without an option, and the tool takes no such value",
            (unknown.nearest.empty() ? "" : "did you mean " + unknown.nearest + "? ") + "see " + info.name +
                " --help"};
  } catch (const BadValue& bad) {
    return {ExitCode::kUsage, "usage", bad.flag + ": " + bad.error.subject(), bad.error.why(),
            bad.error.next()};
  } catch (const CLI::ParseError& error) {
    return {ExitCode::kUsage, "usage", "command line", error.what(), "see " + info.name + " --help"};
  } catch (const std::bad_alloc&) {
    return {ExitCode::kBadInput, "io", "memory", "this machine has not enough of it for this input",
            "give smaller images or fewer of them, or end other programs"};
  } catch (const std::exception& error) {
    return {ExitCode::kInternal, "internal", "internal error", error.what(), next_for_bug};
  } catch (...) {
    return {ExitCode::kInternal, "internal", "internal error", "an exception of unknown type", next_for_bug};
  }
}

int finish(const ToolInfo& info, bool json, Console& console, const Failure& failure) {
  console.log(info.name + ": " + failure.what + "\n  why:  " + failure.why + "\n  next: " + failure.next);
  if (json) {
    Summary& summary =
        console.summary();  // with what was known by then: the statistics of a show that was ended
    summary.set("/tool", info.name);
    summary.set("/version", PROCAM_VERSION);
    summary.set("/exit_code", static_cast<int>(failure.code));
    summary.set("/error/kind", failure.kind);
    summary.set("/error/what", failure.what);
    summary.set("/error/why", failure.why);
    summary.set("/error/next", failure.next);
    std::cout << summary.to_json() << std::endl;
  }
  return static_cast<int>(failure.code);
}

void require_written(const std::ostream& out) {
  if (!out)
    throw Error(ErrorKind::kIo, "standard output", "it cannot be written",
                "check the pipe or the disk it goes to");
}

std::string help_opening(const ToolInfo& info) {
  std::string text = info.name + ": " + info.about + "\n";
  const std::vector<Example>& lines = examples(info.name);
  if (!lines.empty()) text += "\nTry:\n";
  for (const Example& one : lines) text += "  # " + one.purpose + "\n  " + one.command + "\n";
  return text;
}

constexpr const char* kHelpFooter =
    "\nExit codes: 0 ok, 1 internal, 2 usage, 3 bad input, 4 data insufficient or degenerate,\n"
    "  5 solved but a quality check failed (files written, marked so), 6 device or network, 130 interrupted.";

}  // namespace

ExitCode exit_code(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kInput:
    case ErrorKind::kUnsupported:
    case ErrorKind::kIo:
      return ExitCode::kBadInput;
    case ErrorKind::kNotEnoughData:
    case ErrorKind::kDegenerate:
    case ErrorKind::kNotConverged:
      return ExitCode::kInsufficientData;
    case ErrorKind::kDevice:
      return ExitCode::kDevice;
  }
  return ExitCode::kInternal;
}

ExitCode exit_code(const Diagnostics& diagnostics) {
  return diagnostics.failed() ? ExitCode::kGateFailed : ExitCode::kOk;
}

struct Summary::Fields {
  Json json = Json::object();

  template <typename Value>
  void set(const std::string& pointer, const Value& value) {
    json[Json::json_pointer(pointer)] = value;
  }
};

Summary::Summary() : fields_(std::make_unique<Fields>()) {}
Summary::~Summary() = default;
void Summary::set(const std::string& pointer, double value) {
  fields_->set(pointer, value);
}
void Summary::set(const std::string& pointer, int value) {
  fields_->set(pointer, value);
}
void Summary::set(const std::string& pointer, bool value) {
  fields_->set(pointer, value);
}
void Summary::set(const std::string& pointer, const std::string& value) {
  fields_->set(pointer, value);
}
void Summary::set(const std::string& pointer, const char* value) {
  fields_->set(pointer, std::string(value));
}
void Summary::set(const std::string& pointer, const std::vector<double>& values) {
  fields_->set(pointer, values);
}
void Summary::set(const std::string& pointer, const std::vector<std::string>& values) {
  fields_->set(pointer, values);
}

void Summary::add(const Diagnostics& diagnostics) {
  Json& list = fields_->json["diagnostics"];
  if (list.is_null()) list = Json::array();
  for (const Diagnostic& item : diagnostics.items)
    list.push_back({{"severity", to_string(item.severity)}, {"code", item.code}, {"message", item.message}});
}

void Summary::merge(const std::string& json_object) {
  fields_->json.update(Json::parse(json_object));
}

std::string Summary::to_json() const {
  // File names may hold bytes that are no UTF-8; a summary with a replaced letter beats none.
  return fields_->json.dump(2, ' ', false, Json::error_handler_t::replace);
}

Console::Console(bool json) : json_(json), stderr_is_terminal_(isatty(STDERR_FILENO) == 1) {}

void Console::say(const std::string& line) {
  clear_progress();
  std::cerr.clear();                                     // a full disk may have room again
  (json_ ? std::cerr : std::cout) << line << std::endl;  // a pipe gets it at once
}

void Console::say(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) say(line);
}

void Console::log(const std::string& line) {
  clear_progress();
  std::cout.flush();  // where both go to one terminal, they keep their order
  std::cerr.clear();
  std::cerr << line << '\n';
}

void Console::report(const Diagnostics& diagnostics) {
  Diagnostics remarks;
  for (const Diagnostic& item : diagnostics.items)
    if (item.code != "gate_failed") remarks.items.push_back(item);
  for (const std::string& line : lines_for_people(remarks)) log(line);
  summary_.add(diagnostics);
}

void Console::stop_if_requested() {
  if (stop_signal != 0) throw Interrupted();
}

void Console::progress(const std::string& step, int done, int total) {
  stop_if_requested();
  if (!stderr_is_terminal_) return;
  constexpr const char* kReturnAndEraseLine = "\r\033[K";
  std::cout.flush();
  std::cerr << kReturnAndEraseLine << step << ' ' << done << '/' << total << std::flush;
  progress_shown_ = true;
}

void Console::clear_progress() {
  if (!progress_shown_) return;
  std::cerr << "\r\033[K" << std::flush;
  progress_shown_ = false;
}

std::string two_digits(double value) {
  const double size = std::abs(value);
  if (!(size >= 1e-4 && size < 1e6)) return format("%.2g", value);
  return format("%.*f", std::max(1 - int(std::floor(std::log10(size))), 0), value);
}

CLI::Option* add_parsed(CLI::App& app, const std::string& flag,
                        const std::function<void(const std::string&)>& parse, const std::string& help) {
  return app.add_option_function<std::string>(
      flag,
      [flag, parse](const std::string& text) {
        try {
          parse(text);
        } catch (const Error& error) {
          throw BadValue{flag, error};
        }
      },
      help);
}

std::function<std::string(const std::string&)> within(double min, double max) {
  return [min, max](const std::string& text) -> std::string {
    double number = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, failure] = std::from_chars(text.data(), end, number);
    // Written so that NaN fails the comparison.
    if (failure == std::errc() && stop == end && number >= min && number <= max) return "";
    return format("'%s' is not a number from %g to %g", text.substr(0, 40).c_str(), min, max);
  };
}

namespace {

/// Images are allocated and freed by the hundred. glibc returns each large block to the system and fetches zeroed pages for
/// the next, which took a third of simulate-captures' CPU time. (mallopt(3); blocks above 32 MiB are returned still.)
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  mallopt(M_TOP_PAD, 16 << 20);
#endif
}

}  // namespace

int run_tool(int argc, const char* const* argv, const ToolInfo& info,
             const std::function<void(CLI::App&)>& declare, const std::function<ExitCode(Console&)>& run) {
  keep_freed_memory();
  // Known before parsing, so that a usage error is told in the form that was asked for.
  bool json =
      std::any_of(argv + 1, argv + argc, [](const char* text) { return std::strcmp(text, "--json") == 0; });
  Console console(json);
  const SignalScope signals;
  try {
    const CurrentArguments now =
        with_current_names(info.name, std::vector<std::string>(argv + std::min(argc, 1), argv + argc));
    for (const std::string& note : now.notes) console.log("note: " + note);
    CLI::App app(help_opening(info), info.name);
    app.set_version_flag("--version", info.name + " (procam " PROCAM_VERSION ")");
    app.add_flag("--json", json, "Print a machine-readable summary on stdout; sentences go to stderr");
    app.footer(kHelpFooter);
    declare(app);
    arrange_help(app);
    try {
      // CLI11 takes them in reverse order.
      std::vector<std::string> arguments(now.arguments.rbegin(), now.arguments.rend());
      app.parse(std::move(arguments));
    } catch (const CLI::Success& asked) {  // --help, --version
      app.exit(asked);
      require_written(std::cout.flush());
      return static_cast<int>(ExitCode::kOk);
    } catch (const CLI::ParseError&) {
      // A mistyped option is the cause where a required one is missing.
      const std::vector<std::string> unknown = app.remaining();
      if (unknown.empty()) throw;
      throw UnknownArgument{unknown.front(), nearest_option(app, unknown.front())};
    }

    console.summary().set("/tool", info.name);
    console.summary().set("/version", PROCAM_VERSION);
    if (const auto files = named_files(app, NamedFiles::kInputs); !files.empty())
      console.summary().set("/inputs", files);
    if (const CLI::Option* seed = app.get_option_no_throw("--seed"))
      console.summary().set("/seed", seed->count() > 0 ? seed->results().back() : seed->get_default_str());
    const ExitCode code = run(console);
    if (const auto files = named_files(app, NamedFiles::kResults); !files.empty())
      console.summary().set("/outputs", files);
    console.summary().set("/exit_code", static_cast<int>(code));
    if (json) std::cout << console.summary().to_json() << '\n';
    require_written(std::cout.flush());
    return static_cast<int>(code);
  } catch (...) {
    return finish(info, json, console, describe_current_exception(info));
  }
}

}  // namespace procam::tools
