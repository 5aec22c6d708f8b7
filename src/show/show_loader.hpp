#pragma once
/// Shows made ready in the background: the surfaces file read again when it changes, contents opened, so that
/// the loop never waits for a disk or a camera.
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "procam/show/projection.hpp"

namespace procam::show {

struct ShowLoaderOptions {
  std::filesystem::path surfaces;  ///< the file that is watched (io::load_surfaces); empty: none
  /// By surface, instead of the file's own content.
  std::map<std::string, std::string> contents = {};
  /// Relative files that `content` names are in it (device::content_beside); empty: the folder of `surfaces`.
  std::filesystem::path folder = {};
  device::Pace pace = device::Pace::kLive;  ///< of contents
  bool pixels_only = false;                 ///< no rig: surfaces that are placed in metres are refused
  double period_s = 0.2;                    ///< between two looks at the file
};

struct LoadedShow {
  std::optional<Show> show;  ///< nullopt: it failed as a whole, and what was shown goes on
  bool from_file = false;    ///< the file had changed; else it was asked for
  /// What went wrong, a sentence each: the file, or contents that could not be opened (their surfaces stay
  /// dark).
  std::vector<std::string> faults;
};

/// The file's surfaces with the given contents. Throws Error as io::load_surfaces does, and Error(kInput) for
/// a content whose surface is not in the file, and for surfaces that the options refuse. An empty `surfaces` gives no surface.
SurfaceSet load_surfaces(const ShowLoaderOptions& options);

class ShowLoader {
 public:
  /// Begins to watch; the file as it is now counts as known.
  explicit ShowLoader(ShowLoaderOptions options);
  ~ShowLoader();
  ShowLoader(const ShowLoader&) = delete;
  ShowLoader& operator=(const ShowLoader&) = delete;

  /// The same in this thread, once: for the first show. `progress` is called before each surface; what it throws
  /// is thrown.
  LoadedShow load_now(const std::function<void(int done, int total)>& progress = {});
  /// Asks for these surfaces with their contents; replaces what was asked for and not yet begun.
  void request(SurfaceSet surfaces);
  /// Writes the watched file; what is in it afterwards is known, and is not read again. Contents in the file's folder are
  /// named relative to it. Throws Error.
  void save(SurfaceSet surfaces);
  /// What is ready, if anything; never waits.
  std::optional<LoadedShow> take();
  /// Ends contents in the background: a camera that has stopped sending takes seconds to end.
  void retire(std::vector<std::shared_ptr<device::ContentSource>> contents);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::show
