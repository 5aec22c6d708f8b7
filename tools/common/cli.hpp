#pragma once
/// What procam's command-line tools share, so that each tool's main reads as an abstract:
///
///   int main(int argc, char** argv) {
///     Flags flags;
///     return run_tool(argc, argv, {"calibrate-projector", "Calibrates ...", "calibrate-projector ..."},
///                     [&](CLI::App& app) { declare(app, flags); },
///                     [&](Console& console) { return calibrate(flags, console); });
///   }
///
/// Every tool gets --help (what it does and one line to try, first), --version and --json; prints what went
/// wrong in three parts (what, why, next); and ends with one of the exit codes below. CLI11 and nlohmann-json
/// stay out of this header: only a tool that declares options includes CLI/CLI.hpp, in its .cpp.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/words.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace procam::tools {

/// The contract with scripts.
enum class ExitCode {
  kOk = 0,
  kInternal = 1,          ///< a bug in procam
  kUsage = 2,             ///< flags that do not parse
  kBadInput = 3,          ///< a file that cannot be read, understood or written
  kInsufficientData = 4,  ///< too few views, a degenerate layout, no convergence
  kGateFailed = 5,        ///< solved, files written and marked, but a quality check failed
  kDevice = 6,            ///< a device or the network
  kInterrupted = 130      ///< Ctrl-C, SIGTERM or SIGHUP; files already complete are kept
};

/// kInput, kUnsupported and kIo (a file cannot be read or written) are bad input; kDevice is a device; the
/// rest lack good data.
ExitCode exit_code(ErrorKind kind);
/// kGateFailed if any remark is a failure, else kOk.
ExitCode exit_code(const Diagnostics& diagnostics);

struct ToolInfo {
  std::string name;                 ///< as typed: "calibrate-projector"
  std::string about;                ///< what it does, in a sentence or two
  bool runs_until_stopped = false;  ///< Ctrl-C is its usual end
};

/// The machine's summary: one JSON object. Fields are named by JSON pointers ("/projector/fx"), which make
/// the objects in between; a number that is not finite becomes null. Setting a field again replaces it.
class Summary {
 public:
  Summary();
  ~Summary();
  Summary(const Summary&) = delete;
  Summary& operator=(const Summary&) = delete;

  void set(const std::string& pointer, double value);
  void set(const std::string& pointer, int value);
  void set(const std::string& pointer, bool value);
  void set(const std::string& pointer, const std::string& value);
  void set(const std::string& pointer, const char* value);
  void set(const std::string& pointer, const std::vector<double>& values);
  void set(const std::string& pointer, const std::vector<std::string>& values);
  /// Appends the remarks to "diagnostics": [{severity, code, message}].
  void add(const Diagnostics& diagnostics);

  /// Sets the fields of a JSON object, such as report::to_json() writes.
  void merge(const std::string& json_object);

  /// Indented by two spaces, fields in the order they were set.
  std::string to_json() const;

 private:
  struct Fields;
  std::unique_ptr<Fields> fields_;
};

/// Where a tool speaks. Sentences for people go to stdout, or to stderr under --json, where stdout carries
/// the summary alone.
class Console {
 public:
  explicit Console(bool json);

  /// A result or decision, one line.
  void say(const std::string& line);
  void say(const std::vector<std::string>& lines);
  /// One line on stderr.
  void log(const std::string& line);
  /// Logs the remarks, notes of one kind in one line (note_groups.hpp), and puts every one into the summary.
  /// Failed quality checks are logged by the list of checks alone.
  void report(const Diagnostics& diagnostics);
  /// `solve()`, whose result carries `remarks` of its input on. Where it throws, they are reported before the
  /// error: views that were lost in the reading are often the cause.
  template <typename Solve>
  auto reporting(const Diagnostics& remarks, const Solve& solve) -> decltype(solve()) {
    try {
      return solve();
    } catch (const Error&) {
      report(remarks);
      throw;
    }
  }
  /// Ends the tool after Ctrl-C, SIGTERM or SIGHUP: throws, so that files are completed or removed. What the
  /// summary holds by then is printed.
  void stop_if_requested();
  /// "step 3/5" on one line that overwrites itself; silent when stderr is no terminal. Calls
  /// stop_if_requested(); call it between the steps of long work.
  void progress(const std::string& step, int done, int total);

  Summary& summary() { return summary_; }

 private:
  void clear_progress();

  bool json_;
  bool stderr_is_terminal_;
  bool progress_shown_ = false;
  Summary summary_;
};

/// A number with two significant digits, without an exponent where it is of ordinary size: "0.0062", "120".
std::string two_digits(double value);

/// A flag whose text `parse` understands ("25mm", "1024x768"). A procam::Error from `parse` becomes a usage
/// error that names the flag. Returns the option, for ->required() and friends.
CLI::Option* add_parsed(CLI::App& app, const std::string& flag,
                        const std::function<void(const std::string&)>& parse, const std::string& help);

/// For ->check() of a plain number. NaN is refused, which CLI::Range lets pass.
std::function<std::string(const std::string&)> within(double min, double max);

/// Declares, parses, runs, reports; returns the exit code for main. `run` throws procam::Error for what a
/// person must fix.
int run_tool(int argc, const char* const* argv, const ToolInfo& info,
             const std::function<void(CLI::App&)>& declare, const std::function<ExitCode(Console&)>& run);

}  // namespace procam::tools
