#include "procam/io/sheet/board_sheet.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <regex>
#include <sstream>

#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/text.hpp"
#include "scratch.hpp"
#include "sheet/sheet_formats.hpp"

namespace procam::io {
namespace {

using test::Scratch;

/// Two dark squares and a disc on a lopsided sheet.
BoardArtwork small_artwork() {
  BoardArtwork art;
  art.rectangles = {{Vec2(-0.02, -0.02), Vec2(0, 0)}, {Vec2(0, 0), Vec2(0.02, 0.02)}};
  art.discs = {{Vec2(0.05, 0.01), 0.006}};
  art.sheet = {Vec2(-0.03, -0.04), Vec2(0.07, 0.05)};
  return art;
}

const Board kBoard = Chessboard{3, 4, 0.02};

BoardSheet small_sheet(const char* paper = "a5") {
  return board_sheet(kBoard, small_artwork(), parse_paper(paper));
}

TEST(BoardSheet, KeepsTheBoardsSizeAndAddsARulerOf100mm) {
  const BoardSheet sheet = small_sheet();
  EXPECT_EQ(sheet.size, Vec2(0.148, 0.210));
  const BoardArtwork art = small_artwork();
  for (std::size_t i = 0; i < art.rectangles.size(); ++i) {
    EXPECT_LT((sheet.rectangles[i].low - art.rectangles[i].low - sheet.board_origin).norm(), 1e-12);
    EXPECT_LT((sheet.rectangles[i].high - art.rectangles[i].high - sheet.board_origin).norm(), 1e-12);
  }
  EXPECT_LT((sheet.discs[0].centre - Vec2(0.05, 0.01) - sheet.board_origin).norm(), 1e-12);
  EXPECT_EQ(sheet.discs[0].radius, 0.006);
  // All that is no board is the ruler: 100 mm from outer edge to outer edge, below the board's light rim.
  double left = 1, right = 0, top = 1;
  for (std::size_t i = art.rectangles.size(); i < sheet.rectangles.size(); ++i) {
    left = std::min(left, sheet.rectangles[i].low.x());
    right = std::max(right, sheet.rectangles[i].high.x());
    top = std::min(top, sheet.rectangles[i].low.y());
  }
  EXPECT_NEAR(right - left, 0.1, 1e-12);
  EXPECT_GT(top, sheet.board_origin.y() + art.sheet.high.y());
  EXPECT_EQ(sheet.texts.back().text, "chessboard:3x4:20mm; glue it to a flat plate, this edge down");
}

TEST(BoardSheet, TurnsThePaperOrRefusesIt) {
  BoardArtwork wide = small_artwork();
  wide.sheet = {Vec2(-0.1, -0.03), Vec2(0.1, 0.03)};
  EXPECT_EQ(board_sheet(kBoard, wide, parse_paper("a5")).size, Vec2(0.210, 0.148));
  wide.sheet = {Vec2(-0.2, -0.1), Vec2(0.2, 0.1)};
  EXPECT_ERROR(board_sheet(kBoard, wide, parse_paper("a4")), kInput,
               "takes 400 x 221 mm, and a4 has 210 x 297 mm");
  EXPECT_ERROR(board_sheet(kBoard, wide, parse_paper("a4")), kInput, "--paper tabloid");
  wide.sheet.high.x() = 5;
  EXPECT_ERROR(board_sheet(kBoard, wide, parse_paper("a0")), kInput, "make the board smaller");
  EXPECT_ERROR(parse_paper("a9"), kInput, "there is no such paper here; give one of a5, letter, a4");
}

TEST(BoardSheet, IsAPdfWhoseTableAndPageAreRight) {
  const std::string pdf = sheet_pdf(small_sheet());
  EXPECT_EQ(pdf.rfind("%PDF-1.4\n", 0), 0u);
  EXPECT_EQ(pdf.substr(pdf.size() - 6), "%%EOF\n");
  // The last number says where the table begins, and each of its entries where an object does.
  std::smatch match;
  ASSERT_TRUE(std::regex_search(pdf, match, std::regex("startxref\n(\\d+)\n")));
  const std::size_t table = std::stoul(match[1]);
  ASSERT_EQ(pdf.substr(table, 9), "xref\n0 6\n");
  std::size_t entry = table + 9;
  EXPECT_EQ(pdf.substr(entry, 20), "0000000000 65535 f \n");
  for (int object = 1; object < 6; ++object) {
    entry += 20;
    const std::string begin = std::to_string(object) + " 0 obj\n";
    EXPECT_EQ(pdf.substr(std::stoul(pdf.substr(entry, 10)), begin.size()), begin);
    EXPECT_EQ(pdf.substr(entry + 10, 10), " 00000 n \n");
  }
  // A5 in points of 1/72 inch.
  EXPECT_NE(pdf.find("/MediaBox [0 0 419.52756 595.27559]"), std::string::npos);
  EXPECT_NE(pdf.find("/PrintScaling /None"), std::string::npos);
  ASSERT_TRUE(std::regex_search(pdf, match, std::regex("/Length (\\d+) >>\nstream\n")));
  const std::size_t begin = std::size_t(match.position(0) + match.length(0));
  EXPECT_EQ(pdf.substr(begin + std::stoul(match[1]), 17), "endstream\nendobj\n");
  // Shapes in millimetres from the top left; a parenthesis in a text would end it.
  EXPECT_NE(pdf.find("2.8346456693 0 0 -2.8346456693 0 595.27559 cm"), std::string::npos);
  EXPECT_NE(pdf.find(" 20 20 re\n"), std::string::npos);
  EXPECT_NE(pdf.find("(chessboard:3x4:20mm; glue it to a flat plate, this edge down) Tj"), std::string::npos);
}

TEST(BoardSheet, IsAnSvgInMillimetres) {
  const std::string svg = sheet_svg(small_sheet());
  EXPECT_NE(svg.find("width=\"148mm\" height=\"210mm\" viewBox=\"0 0 148 210\""), std::string::npos);
  EXPECT_NE(svg.find("r=\"6\"/>"), std::string::npos);
  const BoardSheet sheet = small_sheet();
  const Vec2 first = 1000 * sheet.rectangles[1].low;
  std::ostringstream text;
  text << "M" << first.x() << " " << first.y() << "H" << first.x() + 20 << "V" << first.y() + 20 << "H"
       << first.x() << "Z";
  EXPECT_NE(svg.find(text.str()), std::string::npos) << text.str();
}

TEST(BoardSheet, IsAPngWithItsPitchAndTheRightAreas) {
  const Scratch scratch;
  BoardSheet sheet = small_sheet();
  sheet.texts.clear();
  save_sheet(scratch / "board.png", sheet, 254);  // ten pixels a millimetre
  const std::string png = read_file(scratch / "board.png");
  EXPECT_EQ(png.substr(33, 21),
            std::string("\0\0\0\x09pHYs\0\0\x27\x10\0\0\x27\x10\x01", 17) + png.substr(50, 4));
  const ImageU8 image = load_image(scratch / "board.png").image;  // checks every checksum
  EXPECT_EQ(image.size(), (ImageSize{1480, 2100}));
  double dark = 0, expected = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) dark += (255 - image.at(x, y)) / 255.0;
  for (const ArtworkRectangle& r : sheet.rectangles) expected += 1e8 * (r.high - r.low).prod();
  for (const ArtworkDisc& d : sheet.discs) expected += 1e8 * EIGEN_PI * d.radius * d.radius;
  EXPECT_NEAR(dark, expected, 1e-3 * expected);
  EXPECT_ERROR(save_sheet(scratch / "board.jpg", sheet, 300), kUnsupported, "PDF, SVG or PNG");
}

}  // namespace
}  // namespace procam::io
