#pragma once
/// What the mains of the larger examples share: "--name value" pairs, each with a default, a place for
/// frames, an end that loses nothing, and exit codes as the tools have them.
#include <signal.h>

#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>

#include "procam/core/base/error.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/io/image/images.hpp"

namespace procam::examples {

using Options = std::map<std::string, std::string>;

/// Throws Error(kInput), which ends with the usage.
inline Options read_options(int argc, char** argv, Options options, const std::string& usage) {
  for (int i = 1; i < argc; i += 2) {
    const std::string name = argv[i];
    if (name.rfind("--", 0) != 0 || options.count(name.substr(2)) == 0 || i + 1 == argc)
      throw Error(ErrorKind::kInput, "'" + name + "'",
                  i + 1 == argc ? "it has no value" : "there is no such option", "usage:\n" + usage);
    options[name.substr(2)] = argv[i + 1];
  }
  return options;
}

/// Throws Error(kInput) for what is no number from `least` to `most`.
inline double number(const Options& options, const std::string& name, double least, double most) {
  char* end = nullptr;
  const std::string& text = options.at(name);
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !(value >= least && value <= most))
    throw Error(ErrorKind::kInput, "--" + name + " " + text, "it is not a number that makes sense here",
                "give one from " + std::to_string(least) + " to " + std::to_string(most));
  return value;
}

/// Of two words, is it the first? Throws Error(kInput) for another.
inline bool is_first(const Options& options, const std::string& name, const std::string& first,
                     const std::string& second) {
  const std::string& text = options.at(name);
  if (text != first && text != second)
    throw Error(ErrorKind::kInput, "--" + name + " " + text, "there is no such choice",
                "use " + first + " or " + second);
  return text == first;
}

/// window:N, or what device::open_sink() takes. Throws Error(kDevice) for a screen of another size.
inline std::unique_ptr<device::FrameSink> open_sink(const std::string& where, ImageSize size, double fps) {
  device::SinkOptions options;
  options.size = size;
  options.fps = fps;
  auto sink = where.rfind("window:", 0) == 0 ? device::open_window(std::atoi(where.c_str() + 7))
                                             : device::open_sink(where, options);
  if (sink->size() != size)
    throw Error(ErrorKind::kDevice, where, "the screen has not the projector's size",
                "set the display to " + std::to_string(size.width) + "x" + std::to_string(size.height));
  return sink;
}

namespace internal {
inline volatile sig_atomic_t told_to_end = 0;
}

/// By Ctrl-C, or as a service ends a program. Loops ask it, so that videos, recordings and shared memory are
/// finished and taken away as at any other end.
inline bool is_told_to_end() {
  return internal::told_to_end != 0;
}

/// Prints the usage for --help; else calls run(options), and turns what it throws into a sentence and an exit
/// code; 130 where is_told_to_end().
template <typename Run>
int run_main(int argc, char** argv, const char* name, const char* usage, const Options& defaults,
             const Run& run) {
  try {
    if (argc == 2 && (std::string(argv[1]) == "--help" || std::string(argv[1]) == "-h")) {
      std::fputs(usage, stdout);
      return 0;
    }
    struct sigaction action {};
    action.sa_handler = [](int) { internal::told_to_end = 1; };
    action.sa_flags = int(SA_RESETHAND);  // the second one ends it at once
    for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
    const int code = run(read_options(argc, argv, defaults, usage));
    return is_told_to_end() ? 130 : code;
  } catch (const Error& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return error.kind() == ErrorKind::kDevice ? 6 : 3;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", name, error.what());
    return 1;
  }
}

}  // namespace procam::examples
