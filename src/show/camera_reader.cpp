#include "camera_reader.hpp"

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include "procam/core/base/error.hpp"
#include "rejected_counts.hpp"

namespace procam::show {

void require_size(const device::SeenFrame& frame, const RigCamera& camera) {
  if (frame.image.size() != camera.camera.size)
    throw Error(ErrorKind::kInput, "camera", "its frames are not of the size it was calibrated with",
                "set its mode to that of the rig file");
}

struct CameraReader::State {
  std::unique_ptr<device::FrameSource> frames;
  std::string description;  ///< of the first
  Open reopen;
  Look look;
  RejectedCounts rejected;
  std::atomic<bool> ends{false};
  mutable std::mutex mutex;  ///< of the next
  bool is_connected = true;
  std::uint64_t failures = 0;
  std::string why;  ///< of the last failure
  std::thread thread;

  void run() {
    double after = 0;
    while (!ends) {
      try {
        if (!frames) {
          frames = reopen();
          set_connected(true);
        }
        // Only the newest is of use: what arrived while the last one was looked at is passed over.
        std::optional<device::SeenFrame> frame = frames->next(after, 0.1);
        while (auto newer = frame && !ends ? frames->next(frame->time_s, 0) : std::nullopt)
          frame = std::move(newer);
        rejected.note(frames->rejected());
        if (!frame) continue;
        after = frame->time_s;
        look(*frame);
      } catch (const std::exception& error) {
        fail(error.what());
        // A frame without a result is followed by others; a camera that is gone has to be opened again.
        const auto* known = dynamic_cast<const Error*>(&error);
        if (frames && (known == nullptr || known->kind() != ErrorKind::kDevice)) continue;
        set_connected(false);
        if (!reopen) return;
        if (frames) rejected.note(frames->rejected());
        frames.reset();
        rejected.closed();
        for (int i = 0; i < 20 && !ends; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
      }
    }
  }

  void set_connected(bool connected) {
    const std::lock_guard<std::mutex> lock(mutex);
    is_connected = connected;
  }
  void fail(const std::string& cause) {
    const std::lock_guard<std::mutex> lock(mutex);
    ++failures;
    why = cause;
  }
};

CameraReader::CameraReader(std::unique_ptr<device::FrameSource> frames, Open reopen, Look look)
    : state_(std::make_unique<State>()) {
  require(frames != nullptr, "CameraReader: no frames");
  state_->description = frames->description();
  state_->frames = std::move(frames);
  state_->reopen = std::move(reopen);
  state_->look = std::move(look);
  state_->thread = std::thread([state = state_.get()] { state->run(); });
}

CameraReader::~CameraReader() {
  state_->ends = true;
  state_->thread.join();
}

track::SourceStatus CameraReader::status(track::SourceStatus of_queue) const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  of_queue.connected = state_->is_connected;
  of_queue.malformed += state_->failures;
  if (!state_->why.empty()) of_queue.last_error = state_->why;
  return of_queue;
}

std::map<std::string, std::uint64_t> CameraReader::rejected() const {
  return state_->rejected.counts();
}

std::string CameraReader::description() const {
  return state_->description;
}

}  // namespace procam::show
