#pragma once
/// The shows of the chaos test with all that feeds them, and the faults that are done to them.
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "chaos_senders.hpp"
#include "chaos_show.hpp"
#include "procam/device/frame_sink.hpp"

namespace procam::test {

/// Three shows on one machine:
///   "show"    poses by UDP, TCP and OSC; images, videos, another program's frames and a network camera as content; edits
///             at the control page, saved automatically; a log
///   "room"    surfaces of a depth camera; people
///   "marker"  poses of a camera that sees a marker
class ChaosStage {
 public:
  explicit ChaosStage(std::uint64_t seed);
  ~ChaosStage();
  ChaosStage(const ChaosStage&) = delete;
  ChaosStage& operator=(const ChaosStage&) = delete;

  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  void write(const std::string& name, const std::string& bytes) const;
  /// The file is replaced as editors do: by renaming.
  void replace(const std::string& name, const std::string& bytes) const;
  void open_shared_writer();
  std::string shared_name() const { return "procam_chaos_" + std::to_string(getpid()); }
  /// Ends all faults and restores all files, until the shows have recovered: the surfaces that they began with, fresh
  /// poses, contents that play. What has not recovered after 30 s; empty: all has.
  std::string repair();

  std::mt19937_64 random;
  std::unique_ptr<ChaosShow> show, room, marker;
  std::unique_ptr<PoseSender> poses;
  std::unique_ptr<NetworkCamera> camera, marker_camera;
  std::unique_ptr<Repeated> depth, people, shared_frames;
  int pose_port = 0, tcp_port = 0, osc_port = 0, people_port = 0;

 private:
  void make_files();
  void start_feeds(std::uint64_t seed);
  void start_shows();
  /// Returns whether the surfaces file was written.
  bool repair_files() const;
  std::string unrecovered() const;

  ScratchFolder folder_;
  std::map<std::string, std::string> files_;  ///< as they should be
  nlohmann::json first_surfaces_;             ///< names and contents
  std::vector<std::string> depth_images_;
  std::mutex shared_mutex_;
  std::unique_ptr<device::FrameSink> shared_;
};

struct ChaosStep {
  std::string name;
  ChaosShow* show;  ///< at whom it is aimed
  /// Counters of which one must rise; empty: nothing is to be counted, and `act` itself says what went wrong.
  std::vector<std::string> counters;
  /// Does the fault; the step's failure in words, or nothing.
  std::function<std::string()> act;
  /// Ends the fault, once it was counted.
  std::function<void()> end = [] {};
};

std::vector<ChaosStep> chaos_steps(ChaosStage& stage);

}  // namespace procam::test
