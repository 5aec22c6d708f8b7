// make-board as a program: what it draws is found again, and what it measured lands in the board file.
#include <gtest/gtest.h>

#include "procam/detect/detect_board.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/image/images.hpp"
#include "tool_runner.hpp"

namespace procam {
namespace {

using test::run_tool;
using test::ScratchFolder;

/// A lens' blur of one pixel: no camera sees edges that end between two pixels.
ImageU8 blurred(const ImageU8& image) {
  ImageU8 out = image;
  for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(0, 1), std::pair(1, 0), std::pair(0, 1)}) {
    const ImageU8 in = out;
    for (int y = 1; y + 1 < in.height(); ++y)
      for (int x = 1; x + 1 < in.width(); ++x)
        out.at(x, y) =
            std::uint8_t((in.at(x - dx, y - dy) + 2 * in.at(x, y) + in.at(x + dx, y + dy) + 2) / 4);
  }
  return out;
}

TEST(MakeBoard, DrawsWhatTheDetectorsFindWhereItStands) {
  const ScratchFolder folder;
  for (const char* text :
       {"chessboard:7x6:20mm", "charuco:5x7:30mm:22mm:5x5_100", "markers:4x5:30mm:10mm:apriltag_36h11",
        "circles:6x8:24mm:14mm", "asymmetric-circles:4x11:18mm:12mm"}) {
    const std::string png = (folder / "board.png").string();
    const auto run =
        run_tool("make-board", std::string("--board ") + text + " --dpi 100 -o " + png + " --json");
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Board board = io::read_board(text);
    const ImageU8 image = blurred(io::load_image(png).image);
    const Detections found = detect::detect_board(image, board);
    const Points3 points = points_in_board(board);
    ASSERT_EQ(found.observations.size(), points.size()) << text;
    // Distances on paper: a pixel is 0.254 mm; a twentieth of it is allowed.
    const Observation& first = found.observations.front();
    for (const Observation& o : found.observations) {
      const double drawn = 0.254e-3 * (o.pixel - first.pixel).norm();
      EXPECT_NEAR(drawn, (points[std::size_t(o.point)] - points[std::size_t(first.point)]).norm(), 0.03e-3)
          << text;
    }
  }
}

TEST(MakeBoard, WritesTheBoardThatTheMeasuredRulerImplies) {
  const ScratchFolder folder;
  const std::string file = (folder / "board.json").string(), pdf = (folder / "board.pdf").string();
  const std::string board = "--board charuco:5x7:30mm:20mm:5x5_100 --save-board " + file;
  ASSERT_EQ(run_tool("make-board", board + " --measured 99.2mm -o " + pdf).exit_code, 0);
  EXPECT_EQ(io::read_board(file), io::read_board("charuco:5x7:29.76mm:19.84mm:5x5_100"));
  EXPECT_NE(test::slurp(pdf).find("(charuco:5x7:29.76mm:19.84mm:5x5_100; glue"), std::string::npos);
  EXPECT_EQ(run_tool("make-board", board + " --measured 50mm").exit_code, 3);
  EXPECT_EQ(run_tool("make-board", "--board charuco:5x7:30mm:20mm:5x5_100").exit_code, 2);
  const auto large = run_tool("make-board", "--board chessboard:7x9:75mm -o " + pdf);
  EXPECT_EQ(large.exit_code, 3);
  EXPECT_NE(large.err.find("a4 has 210 x 297 mm"), std::string::npos) << large.err;
}

}  // namespace
}  // namespace procam
