#include "depth_surfaces.hpp"

#include <cstdio>

#include "procam/core/base/error.hpp"
#include "procam/show/show_options.hpp"

namespace procam::show {

DepthSurfaces parse_depth_surfaces(const std::string& text) {
  require(is_depth_source(text), "parse_depth_surfaces: no depth camera is named");
  DepthSurfaces named;
  named.is_shape = is_shape_source(text);
  named.source = text.substr(text.find(':') + 1);
  const std::string kRegion = ",region=";
  const std::size_t at = named.is_shape ? named.source.rfind(kRegion) : std::string::npos;
  if (at == std::string::npos) return named;
  const std::string region = named.source.substr(at + kRegion.size());
  named.source.resize(at);
  depth::PixelRegion r;
  int read = 0;
  if (std::sscanf(region.c_str(), "%6d:%6d:%6dx%6d%n", &r.x, &r.y, &r.width, &r.height, &read) != 4 ||
      std::size_t(read) != region.size())
    throw Error(ErrorKind::kInput, "region '" + region + "'", "it does not read X:Y:WIDTHxHEIGHT",
                "give pixels of the depth camera, e.g. region=100:80:440x320");
  named.region = r;
  return named;
}

bool is_height_content(const std::string& content) {
  return content.rfind("height:", 0) == 0;
}

}  // namespace procam::show
