#pragma once
#include <filesystem>

namespace procam::session {

/// A folder under a temporary name beside its place: moved there whole, or removed.
class NewFolder {
 public:
  /// Throws Error(kIo) for a place that is not empty, unless `replace` and a simulated session is there.
  NewFolder(std::filesystem::path place, bool replace);
  ~NewFolder();
  NewFolder(const NewFolder&) = delete;
  NewFolder& operator=(const NewFolder&) = delete;

  const std::filesystem::path& path() const { return work_; }
  void finish();

 private:
  std::filesystem::path place_, work_;
};

}  // namespace procam::session
