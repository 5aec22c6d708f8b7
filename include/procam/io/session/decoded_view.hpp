#pragma once
/// A view that another program has decoded: a folder with
///
///   white.png                the board under the projector's full light (or any other single image)
///   columns.npy, rows.npy    the projector's column and row that each camera pixel sees; .pfm as well
///   map.npy                  or both in one array, height x width x 2: column, row
///
/// Values are projector pixels, the centre of the top-left one is (0, 0); NaN where undecoded. The maps have
/// the size of the white image.
#include <filesystem>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"

namespace procam::io {

struct DecodedView {
  ImageU8 white;  ///< grey
  ImageF pixels;  ///< two channels: projector column and row
  std::vector<std::filesystem::path> files;
  Diagnostics diagnostics;  ///< of the white image
};

/// Throws Error(kInput), with what is expected, for maps that are missing or there twice, and for arrays of
/// another shape; Error(kIo) for files that cannot be read.
PROCAM_EXPORT DecodedView load_decoded_view(const std::filesystem::path& folder);

}  // namespace procam::io
