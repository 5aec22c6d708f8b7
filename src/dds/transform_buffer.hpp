#pragma once
/// The frames of a robot over time: what /tf and /tf_static say of them, for any chain of frames.
///
/// Each frame has one parent at a time. A transform between two stamps of an edge is interpolated: its position along
/// the straight line, its rotation along the shorter arc (slerp), as tf2 does. There is no extrapolation: outside of
/// the stamps of any edge of the chain there is no answer. Stamps are those of the senders, which in one ROS graph share
/// one clock.
#include <deque>
#include <map>
#include <optional>
#include <string>

#include "procam/track/stamped_pose.hpp"

namespace procam::dds::internal {

class TransformBuffer {
 public:
  /// `span`: seconds that an edge remembers.
  explicit TransformBuffer(double span = 10) : span_(span) {}

  /// Takes frame_from_child at its stamp; a static one counts for all times. nullptr, or why it is refused: a loop, an
  /// edge that is older than what is remembered, too many frames. Stamps more than `span` behind the newest begin the
  /// edge anew: the sender's clock was set back.
  const char* set(const track::StampedPose& edge, bool is_static);

  /// The latest time at which the whole chain is known; infinity when all of it is static; nullopt when the frames are
  /// not connected.
  std::optional<double> latest(const std::string& frame, const std::string& child) const;

  /// frame_from_child at a time; nullopt when the frames are not connected, or were not known at this time.
  std::optional<Pose> lookup(const std::string& frame, const std::string& child, double time) const;

  /// The frame of the odometry between a frame and a child below it: the one named "odom" ("robot1/odom", "robot1_odom"), in
  /// which the child moves without jumps (REP 105, "Coordinate frames for mobile platforms"). nullopt: there is none.
  std::optional<std::string> odometry_frame(const std::string& frame, const std::string& child) const;

  /// The child's twist in its own frame, [rotation, translation], at a time up to latest(): by three places h apart, h = 0.05 s
  /// or the last interval between stamps, as the end of a parabola through them. nullopt where they are not known, and with
  /// stamps half a second apart or more.
  std::optional<Vec6> twist(const std::string& frame, const std::string& child, double time) const;

  /// Time has jumped: what is not static counts no longer.
  void forget_moving();

  std::size_t size() const { return edges_.size(); }

 private:
  struct Sample {
    double stamp = 0;
    Pose parent_from_child;
  };
  struct Edge {
    std::string parent;
    bool is_static = false;
    std::deque<Sample> samples;  ///< by stamp; of a static edge: one
  };

  /// The longest one between the last two stamps of a moving edge; infinity where an edge has one stamp.
  double last_interval(const std::string& frame, const std::string& child) const;
  bool reaches(const std::string& from, const std::string& ancestor) const;
  template <typename Visit>
  bool walk(const std::string& frame, const std::string& child, Visit visit) const;

  double span_;
  std::map<std::string, Edge> edges_;  ///< by child
};

}  // namespace procam::dds::internal
