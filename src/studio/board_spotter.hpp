#pragma once
/// Looks for the board in the camera's newest image, in a thread of its own, so that the live image does not wait for it.
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "procam/core/base/image.hpp"
#include "procam/core/board/board.hpp"
#include "procam/core/rig/observation.hpp"

namespace procam::studio {

/// What was found in one image. Its corners are those that a calibration would use: detect::detect_board().
struct SpottedBoard {
  double time_s = 0;  ///< of the image
  Detections found;
  double still_s = 0;  ///< for how long no corner has moved by more than BoardSpotter::kStillPx
};

class BoardSpotter {
 public:
  /// Corners of two images that differ by less: the board is still.
  static constexpr double kStillPx = 0.6;

  BoardSpotter();
  ~BoardSpotter();
  BoardSpotter(const BoardSpotter&) = delete;
  BoardSpotter& operator=(const BoardSpotter&) = delete;

  /// The board to look for; nullopt: none.
  void look_for(const std::optional<Board>& board);
  /// Is it ready for the next image?
  bool is_free() const;
  void give(const ImageU8& image, double time_s);
  /// Of the newest image that was looked at; nullopt before the first.
  std::optional<SpottedBoard> newest() const;

 private:
  void work();

  mutable std::mutex mutex_;
  std::condition_variable given_;
  std::optional<Board> board_;
  std::optional<ImageU8> image_;
  double time_s_ = 0;
  bool busy_ = false, ended_ = false;
  std::optional<SpottedBoard> newest_;
  std::thread thread_;
};

/// The largest distance between the same points of two detections, pixels; nullopt when fewer than half of them are in
/// both.
std::optional<double> largest_move(const Detections& a, const Detections& b);

}  // namespace procam::studio
