#include "height_content.hpp"

#include <algorithm>

#include "procam/core/base/error.hpp"
#include "procam/io/text.hpp"

namespace procam::show {
namespace {

constexpr int kTexelsPerCell = 5;  // lines of a few millimetres stay smooth on cells of ten
constexpr int kLargest = 2000;     // texels a side

[[noreturn]] void refuse(const std::string& text, const std::string& why) {
  throw Error(ErrorKind::kInput, "content '" + text + "'", why,
              "write e.g. height:colours,range=-50mm..80mm,contours=20mm");
}

/// A length with its sign.
double parse_height(const std::string& text) {
  return !text.empty() && text[0] == '-' ? -io::parse_length(text.substr(1)) : io::parse_length(text);
}

void parse_part(const std::string& text, const std::string& part, depth::HeightColours& colours) {
  if (part.rfind("range=", 0) == 0) {
    const std::size_t dots = part.find("..");
    if (dots == std::string::npos) refuse(text, "its range does not read LOWEST..HIGHEST");
    colours.lowest = parse_height(part.substr(6, dots - 6));
    colours.highest = parse_height(part.substr(dots + 2));
    if (!(colours.highest > colours.lowest)) refuse(text, "the range has no width");
  } else if (part.rfind("contours=", 0) == 0) {
    colours.contours = io::parse_length(part.substr(9));
    if (!(colours.contours >= 1e-3)) refuse(text, "contours are less than 1 mm from each other");
  } else {
    refuse(text, "'" + part + "' is not known");
  }
}

}  // namespace

depth::HeightColours parse_height_content(const std::string& text) {
  const std::string kBegin = "height:colours";
  if (text.rfind(kBegin, 0) != 0) refuse(text, "it does not begin with height:colours");
  depth::HeightColours colours;
  for (std::size_t at = kBegin.size(); at < text.size();) {
    if (text[at] != ',') refuse(text, "it does not begin with height:colours");
    const std::size_t end = std::min(text.find(',', at + 1), text.size());
    parse_part(text, text.substr(at + 1, end - at - 1), colours);
    at = end;
  }
  return colours;
}

std::unique_ptr<device::ContentSource> height_content(const std::string& text,
                                                      std::shared_ptr<const ShownHeights> shown) {
  const depth::HeightColours colours = parse_height_content(text);
  const ImageSize cells = shown->map.height.size();
  require(cells.width >= 2 && cells.height >= 2, "height_content: the map has no cells");
  const int texels = std::clamp(kLargest / std::max(cells.width, cells.height), 1, kTexelsPerCell);
  return device::drawn_content({texels * cells.width, texels * cells.height}, 3,
                               [colours, shown = std::move(shown)](double, ImageView<std::uint8_t> picture) {
                                 depth::draw_heights(shown->map, colours, picture);
                                 return true;
                               });
}

}  // namespace procam::show
