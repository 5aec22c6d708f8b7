#pragma once
/// mpcdi.xml <-> the regions it describes and the files it names.
#include <string>
#include <string_view>
#include <vector>

#include "procam/io/exchange/mpcdi.hpp"

namespace procam::io {

/// The files of one region; a name is empty where there is none.
struct MpcdiFiles {
  std::string warp, distortion, alpha;
  double metres_per_unit = 1;  ///< of a three-dimensional warp
};

struct MpcdiDocument {
  Mpcdi mpcdi;                    ///< without the maps
  std::vector<MpcdiFiles> files;  ///< one a region
};

MpcdiDocument parse_mpcdi_xml(std::string_view bytes, const std::string& file);
/// `files`: one a region.
std::string to_mpcdi_xml(const Mpcdi& mpcdi, const std::vector<MpcdiFiles>& files);

}  // namespace procam::io
