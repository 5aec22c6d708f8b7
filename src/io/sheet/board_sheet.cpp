#include "procam/io/sheet/board_sheet.hpp"

#include <algorithm>
#include <cmath>

#include "procam/io/files.hpp"
#include "procam/io/text.hpp"
#include "sheet/sheet_formats.hpp"
#include "sheet/sheet_number.hpp"

namespace procam::io {
namespace {

constexpr double kMargin = 0.005;  ///< what printers leave white
constexpr double kFooter = 0.016;  ///< ruler and text, below the board's light rim
constexpr double kTextHeight = 0.003;

const Paper kPapers[] = {{"a5", {0.148, 0.210}},      {"letter", {0.2159, 0.2794}},  {"a4", {0.210, 0.297}},
                         {"legal", {0.2159, 0.3556}}, {"tabloid", {0.2794, 0.4318}}, {"a3", {0.297, 0.420}},
                         {"a2", {0.420, 0.594}},      {"a1", {0.594, 0.841}},        {"a0", {0.841, 1.189}}};

/// What the board needs of the paper. Its light rim may lie where printers print nothing.
Vec2 needed(const BoardArtwork& artwork) {
  const Vec2 rim = artwork.sheet.high - artwork.sheet.low;
  return Vec2(std::max(rim.x(), kRulerLength + 2 * kMargin), rim.y() + kFooter + kMargin);
}

bool fits(const Vec2& size, const Vec2& paper) {
  return size.x() <= paper.x() + 1e-9 && size.y() <= paper.y() + 1e-9;
}

bool fits_turned(const Vec2& size, const Vec2& paper) {
  return fits(size, Vec2(paper.y(), paper.x()));
}

std::string in_millimetres(const Vec2& size) {
  return millimetres(std::ceil(size.x() * 1e4 - 1e-6) / 1e4) + " x " +
         millimetres(std::ceil(size.y() * 1e4 - 1e-6) / 1e4) + " mm";
}

/// A bar with a tick every 10 mm, longer ones at both ends and in the middle; lengths count from the ends'
/// outer edges.
void add_ruler(BoardSheet& sheet, const Vec2& at) {
  constexpr double kLine = 0.0003;
  sheet.rectangles.push_back({at, at + Vec2(kRulerLength, kLine)});
  for (int i = 0; i <= 10; ++i) {
    const double x = at.x() + (i == 10 ? kRulerLength - kLine : i == 0 ? 0 : i * 0.01 - 0.5 * kLine);
    const double length = i % 5 == 0 ? 0.003 : 0.0018;
    sheet.rectangles.push_back({Vec2(x, at.y() - length), Vec2(x + kLine, at.y())});
  }
}

}  // namespace

Paper parse_paper(const std::string& name) {
  std::string known;
  for (const Paper& paper : kPapers) {
    if (paper.name == name) return paper;
    known += (known.empty() ? "" : ", ") + paper.name;
  }
  throw Error(ErrorKind::kInput, "paper '" + name + "'", "there is no such paper here",
              "give one of " + known);
}

BoardSheet board_sheet(const Board& board, const BoardArtwork& artwork, const Paper& paper) {
  const Vec2 size = needed(artwork);
  BoardSheet sheet;
  sheet.size = paper.size;
  if (!fits(size, paper.size)) {
    if (!fits_turned(size, paper.size)) {
      std::string next = "make the board smaller";
      for (const Paper& larger : kPapers)
        if (fits(size, larger.size) || fits_turned(size, larger.size)) {
          next += ", or print on " + larger.name + " (--paper " + larger.name + ")";
          break;
        }
      throw Error(ErrorKind::kInput, "board " + format_board(board),
                  "with its white margin and the ruler it takes " + in_millimetres(size) + ", and " +
                      paper.name + " has " + in_millimetres(paper.size),
                  next);
    }
    std::swap(sheet.size.x(), sheet.size.y());
  }

  const Vec2 rim = artwork.sheet.high - artwork.sheet.low;
  const double spare = sheet.size.y() - rim.y() - kFooter - kMargin;
  sheet.board_origin = Vec2(0.5 * (sheet.size.x() - rim.x()), 0.5 * spare) - artwork.sheet.low;
  for (const ArtworkRectangle& r : artwork.rectangles)
    sheet.rectangles.push_back({r.low + sheet.board_origin, r.high + sheet.board_origin});
  for (const ArtworkDisc& d : artwork.discs) sheet.discs.push_back({d.centre + sheet.board_origin, d.radius});

  const double left = 0.5 * (sheet.size.x() - kRulerLength), top = sheet.size.y() - kMargin - kFooter;
  add_ruler(sheet, Vec2(left, top + 0.005));
  sheet.texts.push_back(
      {Vec2(left, top + 0.009), kTextHeight, "100 mm from end to end: print at 100 %, then measure"});
  sheet.texts.push_back({Vec2(left, top + 0.0135), kTextHeight,
                         format_board(board) + "; glue it to a flat plate, this edge down"});
  return sheet;
}

std::string sheet_svg(const BoardSheet& sheet) {
  const auto xy = [](const Vec2& p) { return millimetres(p.x()) + " " + millimetres(p.y()); };
  const std::string width = millimetres(sheet.size.x()), height = millimetres(sheet.size.y());
  std::string svg =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" "
      "version=\"1.1\" width=\"" +
      width + "mm\" height=\"" + height + "mm\" viewBox=\"0 0 " + width + " " + height + "\">\n";
  svg += "<rect width=\"" + width + "\" height=\"" + height + "\" fill=\"white\"/>\n";
  // One path: where rectangles touch, no seam is drawn.
  svg += "<path fill=\"black\" d=\"";
  for (const ArtworkRectangle& r : sheet.rectangles)
    svg += "M" + xy(r.low) + "H" + millimetres(r.high.x()) + "V" + millimetres(r.high.y()) + "H" +
           millimetres(r.low.x()) + "Z\n";
  svg += "\"/>\n";
  for (const ArtworkDisc& d : sheet.discs)
    svg += "<circle cx=\"" + millimetres(d.centre.x()) + "\" cy=\"" + millimetres(d.centre.y()) + "\" r=\"" +
           millimetres(d.radius) + "\"/>\n";
  for (const BoardSheet::Text& t : sheet.texts)
    svg += "<text x=\"" + millimetres(t.at.x()) + "\" y=\"" + millimetres(t.at.y()) +
           "\" font-family=\"Helvetica, Arial, sans-serif\" font-size=\"" + millimetres(t.height) + "\">" +
           t.text + "</text>\n";
  return svg + "</svg>\n";
}

void save_sheet(const std::filesystem::path& path, const BoardSheet& sheet, double dots_per_inch) {
  const std::string extension = path.extension().string();
  if (extension == ".pdf") return write_file_atomically(path, sheet_pdf(sheet));
  if (extension == ".svg") return write_file_atomically(path, sheet_svg(sheet));
  if (extension == ".png") return write_file_atomically(path, sheet_png(sheet, dots_per_inch));
  throw Error(ErrorKind::kUnsupported, path.string(), "boards are written as PDF, SVG or PNG",
              "give it a name that ends in .pdf, .svg or .png");
}

namespace {

/// Whole tenths of a micrometre, far below any ruler: 37.696mm rather than 37.69599999999999mm.
double rounded(double metres) {
  return std::round(metres * 1e7) / 1e7;
}

Board rounded(const Board& board) {
  struct Visitor {
    Board operator()(const Chessboard& b) const {
      return Chessboard{b.columns, b.rows, rounded(b.square_size)};
    }
    Board operator()(CharucoBoard b) const {
      b.square_size = rounded(b.square_size);
      b.marker_size = rounded(b.marker_size);
      return b;
    }
    Board operator()(MarkerGrid b) const {
      b.marker_size = rounded(b.marker_size);
      b.gap = rounded(b.gap);
      return b;
    }
    Board operator()(CircleGrid b) const {
      b.spacing = rounded(b.spacing);
      b.diameter = rounded(b.diameter);
      return b;
    }
    Board operator()(AprilGrid b) const {
      b.tag_size = rounded(b.tag_size);
      return b;
    }
  };
  return std::visit(Visitor(), board);
}

}  // namespace

Board board_as_measured(const Board& board, double ruler) {
  const double factor = ruler / kRulerLength;
  if (!(factor > 0.9 && factor < 1.1))
    throw Error(ErrorKind::kInput, "measured ruler " + format_length(ruler),
                "the ruler is 100 mm, and no printer is wrong by a tenth",
                "measure the printed ruler from end to end; if it is that long, print again at 100 %");
  return rounded(scaled(board, factor));
}

}  // namespace procam::io
