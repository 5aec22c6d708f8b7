/// make-board: a board's text -> a sheet to print, true to scale, and the board file of what was printed.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>

#include "common/cli.hpp"
#include "procam/detect/board_artwork.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/sheet/board_sheet.hpp"
#include "procam/io/text.hpp"

namespace procam::tools {
namespace {

struct Flags {
  std::optional<Board> board;
  std::string output, save_board;
  io::Paper paper = io::parse_paper("a4");
  double dpi = 300;
  std::optional<double> measured;  ///< metres
};

void declare(CLI::App& app, Flags& flags) {
  add_parsed(
      app, "--board", [&](const std::string& text) { flags.board = io::read_board(text); },
      "What to print: chessboard:7x9:20mm (inner corners), charuco:5x7:34mm:25mm:5x5_100,\n"
      "markers:4x5:38mm:10mm:apriltag_36h11, circles:7x9:24mm:14mm, asymmetric-circles:4x11:20mm:14mm,\n"
      "or a board file (.json)")
      ->required();
  app.add_option("-o,--output", flags.output, "Sheet to write: .pdf or .svg (true to scale), or .png");
  app.add_option("--save-board", flags.save_board, "Board file to write, for --board of the other tools");
  add_parsed(
      app, "--paper", [&](const std::string& text) { flags.paper = io::parse_paper(text); },
      "a0 to a5, letter, legal or tabloid; turned where the board fits better")
      ->default_str(flags.paper.name);
  app.add_option("--dpi", flags.dpi, "Pixels an inch of a .png")
      ->check(CLI::Range(36, 2400))
      ->capture_default_str();
  add_parsed(
      app, "--measured", [&](const std::string& text) { flags.measured = io::parse_length(text); },
      "Measured length of the printed 100 mm ruler, e.g. 99.2mm: every size is scaled by it");
}

ExitCode make_board(const Flags& flags, Console& console) {
  if (flags.output.empty() && flags.save_board.empty())
    throw CLI::RequiredError("a file to write: -o board.pdf or --save-board board.json");
  const Board board = flags.measured ? io::board_as_measured(*flags.board, *flags.measured) : *flags.board;
  const std::string text = io::format_board(board);
  console.summary().set("/board", text);
  if (flags.measured)
    console.say("the printed ruler is " + io::format_length(*flags.measured) + " long, so the board is " +
                text);
  if (!flags.output.empty()) {
    const io::BoardSheet sheet = io::board_sheet(board, detect::board_artwork(board), flags.paper);
    io::save_sheet(flags.output, sheet, flags.dpi);
    console.say(
        "wrote " + flags.output + ": " + text + " on " + flags.paper.name +
        (flags.measured
             ? ""
             : "; print it at 100 %, measure the ruler, and give --measured if it is not 100 mm long"));
    console.summary().set("/sheet/file", flags.output);
    console.summary().set("/sheet/size", std::vector<double>{sheet.size.x(), sheet.size.y()});
  }
  if (!flags.save_board.empty()) {
    io::save_board(flags.save_board, board);
    console.say("wrote " + flags.save_board + ": give it to --board");
    console.summary().set("/board_file", flags.save_board);
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
      {"make-board", "Draws a calibration board to print, true to scale, with a ruler to check it."},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return make_board(flags, console); });
}
