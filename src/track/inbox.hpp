#pragma once
/// Where a source's thread leaves what arrived, and whoever polls fetches it.
#include <mutex>
#include <string>
#include <vector>

#include "procam/track/pose_source.hpp"
#include "procam/track/wire.hpp"

namespace procam::track::internal {

class Inbox {
 public:
  explicit Inbox(const SourceOptions& options);

  /// What `bytes` bytes held that arrived at `arrival`.
  void put(Parsed&& parsed, double arrival, std::size_t bytes);
  void put(StampedPose&& message);
  void refuse(const std::string& why);
  void poll(std::vector<StampedPose>& arrived);

  SourceStatus status() const;
  /// A peer came or went; the last one that goes says why.
  void connected();
  void disconnected(const std::string& why);
  void failed(const std::string& why);

 private:
  void keep(StampedPose&& message);

  mutable std::mutex mutex_;
  std::vector<StampedPose> ring_;
  std::size_t first_ = 0, count_ = 0;
  SourceStatus status_;
  int peers_ = 0;
};

}  // namespace procam::track::internal
