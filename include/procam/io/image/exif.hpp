#pragma once
/// The focal length that a camera has written into its pictures: EXIF in JPEG (segment APP1) and PNG (chunk eXIf).
///
/// In pixels of the stored picture of w x h, d = sqrt(w^2 + h^2) its diagonal, by the first that is stated:
///
///   f = d F35 / 43.27 mm,         F35 FocalLengthIn35mmFilm (its frame has 36 mm x 24 mm, a diagonal of 43.27 mm)
///   f = F R max(w, h) / N         F FocalLength in mm, R FocalPlaneXResolution in pixels per mm, N the longer side
///                                 of PixelXDimension and PixelYDimension (the picture may have been made smaller)
///
/// A cropped picture, whose sides have another ratio than the stated ones, and digital zoom give none. Cameras round
/// these numbers, some use the width instead of the diagonal, and focusing changes a focal length: 10 % are common.
/// Source: CIPA DC-008-2019 (EXIF 2.32), section 4.6; PNG specification, third edition, 11.3.4.5 (eXIf).
#include <filesystem>
#include <optional>
#include <string>

#include "procam/core/base/export.hpp"

namespace procam::io {

struct ExifFocal {
  double focal_px = 0;       ///< f above
  double sigma_share = 0.1;  ///< standard deviation of f as a share of it
  double equivalent_mm = 0;  ///< F35; 0: not stated
  double focal_mm = 0;       ///< F; 0: not stated

  /// "28 mm equivalent", "6.5 mm".
  PROCAM_EXPORT std::string description() const;
};

/// nullopt for a file without these numbers, of another format, or that cannot be read.
PROCAM_EXPORT std::optional<ExifFocal> exif_focal(const std::filesystem::path& picture);

}  // namespace procam::io
