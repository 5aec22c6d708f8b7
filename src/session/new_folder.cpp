#include "new_folder.hpp"

#include <system_error>

#include "procam/core/base/error.hpp"

namespace procam::session {
namespace fs = std::filesystem;
namespace {

Error cannot_write(const fs::path& path, const std::string& why) {
  return Error(ErrorKind::kIo, "output folder " + path.string(), why, "choose another folder with -o");
}

}  // namespace

NewFolder::NewFolder(fs::path place, bool replace) : place_(std::move(place)) {
  if (place_.filename().empty()) place_ = place_.parent_path();  // "DIR/"
  std::error_code error;
  const bool occupied =
      fs::exists(place_, error) && !(fs::is_directory(place_, error) && fs::is_empty(place_, error));
  if (occupied && !replace)
    throw Error(ErrorKind::kIo, "output folder " + place_.string(), "it exists and is not empty",
                "choose another folder with -o, or replace it with --force");
  // Only a simulated session is ever removed.
  if (occupied && !(fs::is_regular_file(place_ / "session.json", error) &&
                    fs::is_regular_file(place_ / "truth.json", error)))
    throw cannot_write(place_,
                       "it exists and is no simulated session (session.json and truth.json), so it is not "
                       "replaced");
  work_ = place_;
  work_ += ".partial";
  if (!place_.parent_path().empty()) fs::create_directories(place_.parent_path(), error);
  if (error) throw cannot_write(place_, error.message());
  if (!fs::create_directory(work_, error))
    throw cannot_write(place_, error ? error.message()
                                     : work_.string() +
                                           " is there: another run is at work, or was killed (then "
                                           "remove it)");
}

NewFolder::~NewFolder() {
  std::error_code ignored;
  if (!work_.empty()) fs::remove_all(work_, ignored);
}

void NewFolder::finish() {
  std::error_code error;
  fs::remove_all(place_, error);
  if (!error) fs::rename(work_, place_, error);
  if (error) throw cannot_write(place_, error.message());
  work_.clear();
}

}  // namespace procam::session
