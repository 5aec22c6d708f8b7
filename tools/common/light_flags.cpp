#include "common/light_flags.hpp"

#include <CLI/CLI.hpp>

#include "common/cli.hpp"
#include "procam/io/text.hpp"

namespace procam::tools {

void declare_light(CLI::App& app, session::OpenOptions& open) {
  open.needs_board = false;
  app.add_option(
      "--pattern", open.stated.pattern,
      "What was projected, if session.json does not state it (default gray): gray, phase, gray+phase, a pattern.json");
  add_parsed(
      app, "--projector-size",
      [&](const std::string& text) { open.stated.projector_size = io::parse_size(text); },
      "Size of the projected image, if session.json does not state it, e.g. 1024x768");
  app.add_option("--step", open.stated.step,
                 "Projector pixels a stripe of Gray code, if session.json does not state it (default 1)")
      ->check(CLI::Range(1, 1024));
}

}  // namespace procam::tools
