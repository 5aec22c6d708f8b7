#include "procam/show/show_loader.hpp"

#include <sys/stat.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <thread>

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

}  // namespace

struct ShowLoader::State {
  ShowLoaderOptions options;
  std::mutex mutex;  ///< of all below but `opened`
  std::condition_variable woken;
  bool ends = false;
  FileState known;
  std::optional<SurfaceSet> requested;
  std::deque<LoadedShow> ready;
  std::mutex opening;  ///< of `opened`: load_now() and the thread
  std::map<std::string, std::weak_ptr<device::ContentSource>> opened;
  std::thread thread;

  /// One camera or video that two surfaces show, or that stays, is opened once.
  std::shared_ptr<device::ContentSource> open(const std::string& content) {
    if (auto source = opened[content].lock()) return source;
    auto source = options.open(content);
    opened[content] = source;
    return source;
  }

  LoadedShow prepare(SurfaceSet surfaces) {
    const std::lock_guard<std::mutex> lock(opening);
    LoadedShow loaded;
    Show show;
    for (const Surface& surface : surfaces.surfaces) {
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

  LoadedShow load() {
    LoadedShow loaded;
    try {
      loaded = prepare(options.load(options.surfaces));
    } catch (const std::exception& error) {
      loaded.faults.push_back(error.what());
    }
    loaded.from_file = true;
    return loaded;
  }

  void run() {
    std::unique_lock<std::mutex> lock(mutex);
    FileState seen = known;
    while (!ends) {
      woken.wait_for(lock, std::chrono::duration<double>(options.period_s),
                     [&] { return ends || requested; });
      if (ends) return;
      if (requested) {
        SurfaceSet surfaces = std::move(*requested);
        requested.reset();
        lock.unlock();
        LoadedShow loaded = prepare(std::move(surfaces));
        lock.lock();
        ready.push_back(std::move(loaded));
        continue;
      }
      const FileState now = look_at(options.surfaces);
      // Changed, and not changing any more: a writer that does not rename is let finish.
      const bool settled = now == seen;
      seen = now;
      if (now == known || !settled || !now.exists) continue;
      known = now;
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

LoadedShow ShowLoader::load_now() {
  return state_->load();
}

void ShowLoader::request(SurfaceSet surfaces) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  state_->requested = std::move(surfaces);
  state_->woken.notify_all();
}

void ShowLoader::expect(const std::function<void()>& write) {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  write();
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
