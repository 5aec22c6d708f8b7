#pragma once
/// Frames of a show as images in the ROS 2 graph, sent by a thread of their own: a frame of 1920 x 1080 pixels is 6 MB, and the
/// next one must not wait for it. Nothing is copied or sent while no node reads them.
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "procam/core/base/image.hpp"
#include "procam/dds/projector_publisher.hpp"

namespace procam::show {

class FrameImages {
 public:
  /// `publisher` outlives it. Throws Error where DDS refuses the topic.
  FrameImages(dds::ProjectorPublisher& publisher, std::string projector);
  ~FrameImages();
  FrameImages(const FrameImages&) = delete;
  FrameImages& operator=(const FrameImages&) = delete;

  /// A frame that is shown, with the steady time of its light: sent where one is due (5 a second), somebody reads, and the one
  /// before is sent. Throws Error with what became of the last one.
  void shown(const std::shared_ptr<const ImageU8>& frame, double light_time);

 private:
  void run();

  dds::ProjectorPublisher& publisher_;
  const std::string projector_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::shared_ptr<const ImageU8> next_;  ///< null: the one before is sent
  double next_time_ = 0;                 ///< Unix time of its light
  std::string fault_;
  bool is_ending_ = false;
  double sent_ = -1e9;  ///< steady time at which the last one was due
  std::thread thread_;
};

}  // namespace procam::show
