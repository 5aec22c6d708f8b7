#pragma once
/// Zip archives in memory. Two bodies: archive_libzip.cpp, and archive_none.cpp where there is no libzip.
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace procam::io {

/// A name with '/' or '\' first, a drive, a backslash or a component "..": it would lead out of the archive.
bool leads_outside(const std::string& member);

class Archive {
 public:
  /// Looks at every member's name and declared size before anything is unpacked. `file` is how errors call
  /// it. Throws Error(kInput) for what is no archive, members that lead outside, more than 4096 members or
  /// `largest_unpacked` bytes in all; Error(kUnsupported) without libzip.
  Archive(std::string bytes, std::string file, std::size_t largest_unpacked);
  ~Archive();
  Archive(const Archive&) = delete;
  Archive& operator=(const Archive&) = delete;

  std::vector<std::string> names() const;
  /// One member, by its name in any case. Throws Error(kInput) when it is missing, damaged, or not of the
  /// size that was declared.
  std::string read(const std::string& name) const;

 private:
  struct Body;
  std::unique_ptr<Body> body_;
};

/// Name and bytes of each member -> the bytes of an archive; the same members give the same bytes. Throws
/// Error(kUnsupported) without libzip.
std::string make_archive(const std::vector<std::pair<std::string, std::string>>& members);

}  // namespace procam::io
