#include "board_spotter.hpp"

#include <algorithm>
#include <exception>
#include <map>
#include <utility>

#include "procam/detect/detect_board.hpp"

namespace procam::studio {

BoardSpotter::BoardSpotter() {
  thread_ = std::thread([this] { work(); });
}

BoardSpotter::~BoardSpotter() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ended_ = true;
  }
  given_.notify_all();
  thread_.join();
}

void BoardSpotter::look_for(const std::optional<Board>& board) {
  const std::lock_guard<std::mutex> lock(mutex_);
  board_ = board;
  newest_.reset();
}

bool BoardSpotter::is_free() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return board_ && !busy_;
}

void BoardSpotter::give(const ImageU8& image, double time_s) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!board_ || busy_) return;
    image_ = image;
    time_s_ = time_s;
    busy_ = true;
  }
  given_.notify_all();
}

std::optional<SpottedBoard> BoardSpotter::newest() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return newest_;
}

void BoardSpotter::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    given_.wait(lock, [&] { return ended_ || image_; });
    if (ended_) return;
    const ImageU8 image = std::move(*image_);
    image_.reset();
    const Board board = *board_;
    SpottedBoard spotted;
    spotted.time_s = time_s_;
    lock.unlock();
    try {
      spotted.found = detect::detect_board(image, board);
    } catch (const std::exception& error) {
      spotted.found.diagnostics.fail("not_looked_at", error.what());
    }
    lock.lock();
    busy_ = false;
    if (!board_ || !(*board_ == board)) continue;  // another one was asked for meanwhile
    if (newest_) {
      const std::optional<double> moved = largest_move(newest_->found, spotted.found);
      if (moved && *moved < kStillPx) spotted.still_s = newest_->still_s + spotted.time_s - newest_->time_s;
    }
    newest_ = std::move(spotted);
  }
}

std::optional<double> largest_move(const Detections& a, const Detections& b) {
  std::map<int, Vec2> before;
  for (const Observation& point : a.observations) before[point.point] = point.pixel;
  std::size_t common = 0;
  double largest = 0;
  for (const Observation& point : b.observations) {
    const auto known = before.find(point.point);
    if (known == before.end()) continue;
    ++common;
    largest = std::max(largest, (point.pixel - known->second).norm());
  }
  if (common == 0 || 2 * common < std::max(a.observations.size(), b.observations.size())) return std::nullopt;
  return largest;
}

}  // namespace procam::studio
