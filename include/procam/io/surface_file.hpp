#pragma once
/// Surface files <-> SurfaceSet and SolvedSurfaceSet, in JSON or XML by the name's extension (.json, .xml):
/// the same data in either syntax. The fields are listed in docs/file-formats.md and docs/schema/.
///
/// Loading reads the mesh files that surfaces name (beside the surface file) and refuses unusable ones.
/// Errors as for rig files (rig_file.hpp), with file, line and field in both syntaxes; another extension is
/// Error(kUnsupported).
#include <filesystem>

#include "procam/core/base/export.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::io {

PROCAM_EXPORT SurfaceSet load_surfaces(const std::filesystem::path& path);
PROCAM_EXPORT void save_surfaces(const std::filesystem::path& path, const SurfaceSet& surfaces);

/// The JSON form as text, for logs, and back; files that it names are beside the file `beside`, which need
/// not exist.
PROCAM_EXPORT std::string surfaces_to_text(SurfaceSet surfaces);
PROCAM_EXPORT SurfaceSet surfaces_from_text(const std::string& text, const std::filesystem::path& beside);

PROCAM_EXPORT SolvedSurfaceSet load_solved_surfaces(const std::filesystem::path& path);
PROCAM_EXPORT void save_solved_surfaces(const std::filesystem::path& path, const SolvedSurfaceSet& surfaces);

}  // namespace procam::io
