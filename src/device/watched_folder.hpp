#pragma once
/// Pictures that appear in a folder, one file a picture.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "content_files.hpp"
#include "frame_queue.hpp"
#include "procam/device/frame_sink.hpp"

namespace procam::device::internal {

/// `Source` is the interface, `Frame` what it hands out, `read` makes its picture of a file.
template <typename Source, typename Frame, auto read>
class WatchedFolder : public Source {
 public:
  WatchedFolder(std::filesystem::path folder, double patience_s,
                bool (*is_wanted)(const std::filesystem::path&) = is_picture)
      : folder_(std::move(folder)), patience_s_(patience_s), is_wanted_(is_wanted) {
    for (const std::filesystem::path& file : pictures()) done_.insert(file);
    listener_ = std::thread([this] { listen(); });
  }
  ~WatchedFolder() override {
    stop_ = true;
    listener_.join();
  }

  std::optional<Frame> next(double after_s, double timeout_s) override {
    return queue_.next(after_s, timeout_s);
  }

 private:
  /// A file on its way.
  struct Arrival {
    double first_seen_s = 0;
    std::uintmax_t size = 0;
    std::filesystem::file_time_type written;
    double unchanged_since_s = 0;
    bool refused = false;  ///< by the reader, as it is now
    std::string why;
  };

  std::vector<std::filesystem::path> pictures() const {
    std::vector<std::filesystem::path> found;
    std::error_code error;
    for (std::filesystem::directory_iterator entry(folder_, error), end; !error && entry != end;
         entry.increment(error))
      if (is_wanted_(entry->path())) found.push_back(entry->path());
    if (error)
      throw Error(ErrorKind::kDevice, "folder " + folder_.string(), "cannot read it: " + error.message(),
                  "name the folder into which the camera's pictures come");
    return found;
  }

  void listen() {
    try {
      while (!stop_) {
        look(now_s());
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
    } catch (...) {
      queue_.fail(std::current_exception());
    }
  }

  void look(double now) {
    const std::vector<std::filesystem::path> found = pictures();
    forget_removed(found);
    for (const std::filesystem::path& file : found) {
      if (done_.count(file) != 0) continue;
      std::error_code no_size, no_time;
      const std::uintmax_t size = std::filesystem::file_size(file, no_size);
      const std::filesystem::file_time_type written = std::filesystem::last_write_time(file, no_time);
      if (no_size || no_time) continue;  // renamed or removed between the two looks
      const auto [place, is_new] = arriving_.try_emplace(file, Arrival{now, size, written, now, false, {}});
      Arrival& arrival = place->second;
      if (size != arrival.size || written != arrival.written) {
        arrival.size = size;
        arrival.written = written;
        arrival.unchanged_since_s = now;
        arrival.refused = false;
      }
    }
    // Those first seen are handed out first, even if a later one is complete earlier.
    while (!arriving_.empty()) {
      const auto oldest = std::min_element(
          arriving_.begin(), arriving_.end(),
          [](const auto& a, const auto& b) { return a.second.first_seen_s < b.second.first_seen_s; });
      if (!take(oldest->first, oldest->second, now)) return;
      done_.insert(oldest->first);
      arriving_.erase(oldest);
    }
  }

  /// What is done with and removed may come again under its name, and its name takes no more memory.
  void forget_removed(const std::vector<std::filesystem::path>& found) {
    if (done_.size() <= found.size()) return;
    std::set<std::filesystem::path> still;
    for (const std::filesystem::path& file : found)
      if (auto known = done_.extract(file)) still.insert(std::move(known));
    done_ = std::move(still);
  }

  /// True when the file is done with.
  bool take(const std::filesystem::path& file, Arrival& arrival, double now) {
    std::error_code error;
    if (!std::filesystem::exists(file, error)) return true;
    if (!(now > arrival.unchanged_since_s)) return false;  // it may still grow
    if (!arrival.refused) {
      try {
        queue_.push({read(file), arrival.first_seen_s});
        return true;
      } catch (const Error& not_yet) {
        arrival.refused = true;
        arrival.why = not_yet.why();
      }
    }
    if (now - arrival.unchanged_since_s < patience_s_) return false;
    throw Error(ErrorKind::kDevice, file.string(), "it stays unreadable: " + arrival.why,
                "let the camera write png, jpg, bmp or tif files, whole");
  }

  std::filesystem::path folder_;
  double patience_s_;
  bool (*is_wanted_)(const std::filesystem::path&);
  std::set<std::filesystem::path> done_;
  std::map<std::filesystem::path, Arrival> arriving_;
  NewestFrames<Frame> queue_;
  std::atomic<bool> stop_{false};
  std::thread listener_;  // last: it uses all the others
};

}  // namespace procam::device::internal
