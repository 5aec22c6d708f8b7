#pragma once
/// Shows made ready in the background: the surfaces file read again when it changes, contents opened, so that
/// the loop never waits for a disk or a camera.
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "procam/show/projection.hpp"

namespace procam::show {

struct ShowLoaderOptions {
  std::filesystem::path surfaces;  ///< the file that is watched; empty: none
  /// Reads it (io::load_surfaces); throws Error.
  std::function<SurfaceSet(const std::filesystem::path&)> load;
  /// Opens what a surface's `content` says (device::open_content); throws Error.
  std::function<std::shared_ptr<device::ContentSource>(const std::string& content)> open;
  double period_s = 0.2;  ///< between two looks at the file
};

struct LoadedShow {
  std::optional<Show> show;  ///< nullopt: it failed as a whole, and what was shown goes on
  bool from_file = false;    ///< the file had changed; else it was asked for
  /// What went wrong, a sentence each: the file, or contents that could not be opened (their surfaces stay
  /// dark).
  std::vector<std::string> faults;
};

class ShowLoader {
 public:
  /// Begins to watch; the file as it is now counts as known.
  explicit ShowLoader(ShowLoaderOptions options);
  ~ShowLoader();
  ShowLoader(const ShowLoader&) = delete;
  ShowLoader& operator=(const ShowLoader&) = delete;

  /// The same in this thread, once: for the first show.
  LoadedShow load_now();
  /// Asks for these surfaces with their contents; replaces what was asked for and not yet begun.
  void request(SurfaceSet surfaces);
  /// The file is about to be written by this program: what is in it afterwards is known.
  void expect(const std::function<void()>& write);
  /// What is ready, if anything; never waits.
  std::optional<LoadedShow> take();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::show
