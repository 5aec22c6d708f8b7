#pragma once
/// The files that scan-surfaces writes.
#include <string>
#include <vector>

#include "procam/report/scan.hpp"

namespace procam::tools {

struct NamedMesh {
  std::string name;
  const Mesh* mesh = nullptr;
};

/// "scan", or with several cameras or projectors "scan_CAMERA_PROJECTOR".
std::string scan_name(const std::string& camera, const std::string& projector, std::size_t count);

/// Surface definitions, and each mesh beside them. Appends the names of the files.
void save_scan_meshes(const std::string& output, const std::vector<NamedMesh>& meshes,
                      const std::string& frame, std::vector<std::string>& files);

struct ScanFiles {
  std::string points, depth, preview;  ///< empty: not wanted
};

/// FILE.EXT, of several scans FILE_SCAN.EXT; the points in one file. Appends the names of the files.
void save_scan_files(const ScanFiles& wanted, const std::vector<report::ScannedSurface>& surfaces,
                     std::vector<std::string>& files);

}  // namespace procam::tools
