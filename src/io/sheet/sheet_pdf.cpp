// The part of PDF 1.4 (ISO 32000) that one page of shapes and text needs, written by hand.
#include <cstdio>

#include "procam/io/sheet/board_sheet.hpp"
#include "sheet/sheet_formats.hpp"
#include "sheet/sheet_number.hpp"

namespace procam::io {
namespace {

constexpr double kPointsPerMetre = 72 / 0.0254;

std::string points(double metres) {
  return plain_decimal(kPointsPerMetre * metres, 5);
}

std::string xy(const Vec2& p) {
  return millimetres(p.x()) + " " + millimetres(p.y());
}

/// Four cubic arcs; their radius is right to 3e-4 of itself.
std::string disc(const ArtworkDisc& d) {
  constexpr double kHandle = 0.5522847498;
  const double r = d.radius, h = kHandle * r;
  const auto at = [&](double x, double y) { return xy(d.centre + Vec2(x, y)) + " "; };
  return at(r, 0) + "m " + at(r, h) + at(h, r) + at(0, r) + "c " + at(-h, r) + at(-r, h) + at(-r, 0) + "c " +
         at(-r, -h) + at(-h, -r) + at(0, -r) + "c " + at(h, -r) + at(r, -h) + at(r, 0) + "c h\n";
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '(' || c == ')' || c == '\\') out += '\\';
    out += c;
  }
  return out;
}

std::string page_content(const BoardSheet& sheet) {
  // Millimetres with y down, as the sheet has them; all shapes are one path, so that no seam shows where
  // rectangles touch.
  const std::string scale = plain_decimal(kPointsPerMetre / 1000, 10);
  std::string content = "q " + scale + " 0 0 -" + scale + " 0 " + points(sheet.size.y()) + " cm\n";
  for (const ArtworkRectangle& r : sheet.rectangles)
    content += xy(r.low) + " " + xy(r.high - r.low) + " re\n";
  for (const ArtworkDisc& d : sheet.discs) content += disc(d);
  content += "f Q\n";
  for (const BoardSheet::Text& t : sheet.texts)
    content += "BT /F1 " + points(t.height) + " Tf " + points(t.at.x()) + " " +
               points(sheet.size.y() - t.at.y()) + " Td (" + escaped(t.text) + ") Tj ET\n";
  return content;
}

}  // namespace

std::string sheet_pdf(const BoardSheet& sheet) {
  const std::string content = page_content(sheet);
  const std::vector<std::string> objects = {
      "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 " + points(sheet.size.x()) + " " + points(sheet.size.y()) +
          "] /Resources << /Font << /F1 5 0 R >> >> /Contents 4 0 R >>",
      "<< /Length " + std::to_string(content.size()) + " >>\nstream\n" + content + "endstream",
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>"};
  // The second line's high bytes tell file transfer programs that this is no text.
  std::string pdf = "%PDF-1.4\n%\xE2\xE3\xCF\xD3\n";
  std::vector<std::size_t> offsets;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    offsets.push_back(pdf.size());
    pdf += std::to_string(i + 1) + " 0 obj\n" + objects[i] + "\nendobj\n";
  }
  const std::size_t table = pdf.size();
  const std::string count = std::to_string(objects.size() + 1);
  pdf += "xref\n0 " + count + "\n0000000000 65535 f \n";
  for (const std::size_t offset : offsets) {
    char line[32];
    std::snprintf(line, sizeof line, "%010zu 00000 n \n", offset);
    pdf += line;
  }
  return pdf + "trailer\n<< /Size " + count + " /Root 1 0 R >>\nstartxref\n" + std::to_string(table) +
         "\n%%EOF\n";
}

}  // namespace procam::io
