#include "show_loader.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "procam/io/surface_file.hpp"
#include "uncalibrated.hpp"

namespace procam::show {
namespace {

/// What tells one state of a file from another without reading it.
struct FileState {
  bool exists = false;
  ino_t inode = 0;
  off_t size = 0;
  timespec modified{};

  bool operator==(const FileState& other) const {
    return exists == other.exists && inode == other.inode && size == other.size &&
           modified.tv_sec == other.modified.tv_sec && modified.tv_nsec == other.modified.tv_nsec;
  }
};

FileState look_at(const std::filesystem::path& path) {
  struct stat about {};
  FileState state;
  if (path.empty() || stat(path.c_str(), &about) != 0) return state;
  state.exists = true;
  state.inode = about.st_ino;
  state.size = about.st_size;
  state.modified = about.st_mtim;
  return state;
}

/// A file in the folder that contents are relative to.
std::filesystem::path folder_file(const ShowLoaderOptions& options) {
  return options.folder.empty() ? std::filesystem::absolute(options.surfaces)
                                : options.folder / "surfaces.json";
}

/// The content with its file named from the folder, if the file is in the folder.
std::string beside(const std::filesystem::path& folder, const std::string& content) {
  const auto file = device::content_file(content);
  if (!file || !std::filesystem::path(*file).is_absolute()) return content;
  const std::filesystem::path relative = std::filesystem::path(*file).lexically_relative(folder);
  if (relative.empty() || *relative.begin() == "..") return content;
  return device::with_content_file(content, relative.string());
}

}  // namespace

SurfaceSet load_surfaces(const ShowLoaderOptions& options) {
  if (options.surfaces.empty()) return {};
  SurfaceSet set = io::load_surfaces(options.surfaces);
  if (options.pixels_only) require_pixel_surfaces(set, options.surfaces.string());
  for (const auto& [name, content] : options.contents) {
    const auto named = std::find_if(set.surfaces.begin(), set.surfaces.end(),
                                    [name = &name](const Surface& surface) { return surface.name == *name; });
    if (named == set.surfaces.end())
      throw Error(ErrorKind::kInput, "content of '" + name + "'", "no surface has this name",
                  "name a surface of " + options.surfaces.string());
    named->content = beside(folder_file(options).parent_path(), content);
  }
  return set;
}

struct ShowLoader::State {
  using Progress = std::function<void(int done, int total)>;
  ShowLoaderOptions options;
  std::mutex mutex;  ///< of all below but `opened`
  std::condition_variable woken;
  bool ends = false;
  FileState known;
  std::optional<SurfaceSet> requested;
  std::vector<std::shared_ptr<device::ContentSource>> retired;
  std::deque<LoadedShow> ready;
  std::mutex opening;  ///< of `opened`: load_now() and the thread
  std::map<std::string, std::weak_ptr<device::ContentSource>> opened;
  std::thread thread;

  /// One camera or video that two surfaces show, or that stays, is opened once.
  std::shared_ptr<device::ContentSource> open(const std::string& content) {
    std::shared_ptr<device::ContentSource> source = opened[content].lock();
    if (source) return source;
    device::ContentOptions how;
    how.pace = options.pace;
    source = device::open_content(device::content_beside(folder_file(options), content), how);
    opened[content] = source;
    return source;
  }

  LoadedShow prepare(SurfaceSet surfaces, const Progress& progress) {
    const std::lock_guard<std::mutex> lock(opening);
    LoadedShow loaded;
    Show show;
    for (const Surface& surface : surfaces.surfaces) {
      if (progress) progress(int(show.contents.size()), int(surfaces.surfaces.size()));
      std::shared_ptr<device::ContentSource> source;
      try {
        if (!surface.content.empty()) source = open(surface.content);
      } catch (const std::exception& error) {
        loaded.faults.push_back("surface '" + surface.name + "' stays dark: " + error.what());
      }
      show.contents.push_back(std::move(source));
    }
    show.surfaces = std::move(surfaces);
    loaded.show = std::move(show);
    return loaded;
  }

  LoadedShow load(const Progress& progress = {}) {
    LoadedShow loaded;
    std::optional<SurfaceSet> surfaces;
    try {
      surfaces = load_surfaces(options);
    } catch (const std::exception& error) {
      loaded.faults.push_back(error.what());
    }
    if (surfaces) loaded = prepare(std::move(*surfaces), progress);
    loaded.from_file = true;
    return loaded;
  }

  void run() {
    std::unique_lock<std::mutex> lock(mutex);
    FileState seen = known;
    while (!ends) {
      woken.wait_for(lock, std::chrono::duration<double>(options.period_s),
                     [&] { return ends || requested || !retired.empty(); });
      if (ends) return;
      if (!retired.empty()) {
        auto ended = std::exchange(retired, {});
        lock.unlock();
        ended.clear();
        lock.lock();
        continue;
      }
      if (requested) {
        SurfaceSet surfaces = std::move(*requested);
        requested.reset();
        lock.unlock();
        LoadedShow loaded = prepare(std::move(surfaces), {});
        lock.lock();
        ready.push_back(std::move(loaded));
        continue;
      }
      const FileState now = look_at(options.surfaces);
      // Changed, and not changing any more: a writer that does not rename is let finish.
      const bool settled = now == seen;
      seen = now;
      if (now == known || !settled) continue;
      known = now;
      if (!now.exists) {
        LoadedShow gone;
        gone.from_file = true;
        gone.faults.push_back(options.surfaces.string() + ": it was removed; write it again, or save");
        ready.push_back(std::move(gone));
        continue;
      }
      lock.unlock();
      LoadedShow loaded = load();
      lock.lock();
      ready.push_back(std::move(loaded));
    }
  }
};

ShowLoader::ShowLoader(ShowLoaderOptions options) : state_(std::make_unique<State>()) {
  state_->options = std::move(options);
  state_->known = look_at(state_->options.surfaces);
  state_->thread = std::thread([state = state_.get()] { state->run(); });
}

ShowLoader::~ShowLoader() {
  {
    const std::lock_guard<std::mutex> lock(state_->mutex);
    state_->ends = true;
  }
  state_->woken.notify_all();
  state_->thread.join();
}

LoadedShow ShowLoader::load_now(const std::function<void(int, int)>& progress) {
  return state_->load(progress);
}

void ShowLoader::request(SurfaceSet surfaces) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->requested = std::move(surfaces);
  state_->woken.notify_all();
}

void ShowLoader::retire(std::vector<std::shared_ptr<device::ContentSource>> contents) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  for (auto& content : contents) state_->retired.push_back(std::move(content));
  state_->woken.notify_all();
}

void ShowLoader::save(SurfaceSet surfaces) {
  require(!state_->options.surfaces.empty(), "ShowLoader: no file is watched");
  const std::lock_guard<std::mutex> lock(state_->mutex);
  // A folder with the surfaces and their contents can be moved to another computer.
  const std::filesystem::path folder = std::filesystem::absolute(state_->options.surfaces).parent_path();
  for (Surface& surface : surfaces.surfaces) surface.content = beside(folder, surface.content);
  io::save_surfaces(state_->options.surfaces, surfaces);
  state_->known = look_at(state_->options.surfaces);
}

std::optional<LoadedShow> ShowLoader::take() {
  std::unique_lock<std::mutex> lock(state_->mutex, std::try_to_lock);
  if (!lock || state_->ready.empty()) return std::nullopt;
  LoadedShow loaded = std::move(state_->ready.front());
  state_->ready.pop_front();
  return loaded;
}

}  // namespace procam::show
