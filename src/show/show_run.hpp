#pragma once
/// A show that runs: its parts, made ready in the order in which they depend on each other, and its loop.
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "fleet_link.hpp"
#include "group_link.hpp"
#include "loop.hpp"
#include "procam/device/content_source.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/show/projection.hpp"
#include "procam/show/run.hpp"
#include "procam/track/pose_source.hpp"
#include "rejected_counts.hpp"
#include "ros2_output.hpp"
#include "show_people.hpp"
#include "side_screens.hpp"

namespace procam::show {

/// The parts of one show, in the order in which they are made ready.
class ShowRun {
 public:
  ShowRun(const Rig& rig, bool is_calibrated, const ShowOptions& options, ShowListener& listener,
          std::vector<device::FrameSink*> sinks = {});

  ShowReport run();

 private:
  /// Of a further screen.
  struct Side {
    std::unique_ptr<Projection> projection;
    std::unique_ptr<BlendMaker> blend;
    std::unique_ptr<device::FrameSink> opened;
    device::FrameSink* sink = nullptr;
  };

  /// A message that fails does not end the show.
  void take_people();

  void publish(const Metrics& metrics);

  void publish_pose(const track::StampedPose& message);

  /// By all sources of poses, images and depth.
  Rejected rejected();

  void count_people_faults(std::map<std::string, std::uint64_t>& faults) const;

  ShowReport report(const Metrics& metrics) const;

  void load_surfaces();

  void open_group();

  void open_fleet();

  void open_blend(BlendPlan plan);

  /// Of a source of this host, for the hosts that have none.
  void share_pose(const track::StampedPose& message);

  void open_output();

  void finish_outputs();

  /// With the window or file that it names, of this size.
  std::unique_ptr<device::FrameSink> open_screen(const std::optional<std::string>& display,
                                                 const std::string& output, ImageSize size);

  std::unique_ptr<device::FrameSink> open_display(const std::optional<std::string>& wanted, ImageSize size);

  void open_sides(const ProjectionOptions& first);

  /// Domain and network of what listens in the ROS 2 graph.
  template <typename Source>
  void tell_opened(const Source& source) {
    if (const std::string opened = source.description(); !opened.empty()) listener_.on_start(opened);
  }

  /// From a frame's show() to its light on the wall, seen by a camera.
  double measured_delay();

  void open_inputs();

  const Rig& rig_;
  const bool is_calibrated_;
  const ShowOptions options_;  ///< with those of the first screen
  ShowListener& listener_;
  const std::vector<device::FrameSink*> given_sinks_;  ///< the caller's, one a screen
  device::FrameSink* sink_ = nullptr;                  ///< the first of these, or opened_sink_
  const bool in_room_;
  const std::filesystem::path folder_;
  std::string conditions_;
  BlackoutLog silhouettes_;
  std::unique_ptr<GroupLink> link_;  ///< outlives the sources
  std::uint64_t group_faults_ = 0;
  std::unique_ptr<ShowPeople> people_;
  std::uint64_t people_faults_ = 0;
  std::unique_ptr<Ros2Output> graph_;
  std::uint64_t publish_faults_ = 0;
  std::unique_ptr<DepthSurfaceSource> room_;
  std::unique_ptr<Projection> projection_;
  SurfaceSet first_;
  std::map<const device::ContentSource*, Rejected> by_content_;  ///< at the last count
  Rejected rejected_by_contents_;
  std::unique_ptr<ShowLoader> loader_;
  std::unique_ptr<BlendMaker> blend_;
  std::unique_ptr<FleetLink> fleet_;  ///< outlives the output: its claims end when the last light is gone
  std::unique_ptr<device::FrameSink> opened_sink_;
  std::vector<std::unique_ptr<Side>> side_screens_;
  std::unique_ptr<SideScreens> sides_;  ///< null with one screen
  LoopOptions loop_;
  std::vector<std::unique_ptr<track::PoseSource>> sources_;
  std::optional<RunRecorder> recorder_;
  std::unique_ptr<LightWatch> watch_;
  MovingOptions moving_;
  std::unique_ptr<SurfaceSource> sights_;
  std::unique_ptr<ControlPage> page_;
};

}  // namespace procam::show
