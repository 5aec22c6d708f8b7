#pragma once
/// Names of the ROS 2 graph: namespaces, remaps, topics, the domain.
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace procam::dds::internal {

/// Where a name of the graph leads: a namespace for relative names, and remaps. As in ROS 2, a remap is compared with
/// the full name, the first that fits counts, and it is applied once.
struct GraphNames {
  std::string node_namespace = "/";
  std::vector<std::pair<std::string, std::string>> remaps;  ///< from, to: as given
  bool use_sim_time = false;

  /// The absolute name of a topic: "odom" -> "/robot1/odom", "/tf" -> what it is mapped to.
  std::string resolve(const std::string& name) const;
};

/// What follows "ros2:" in the text of a pose source; parts are divided by commas.
///
///   FRAME,CHILD     a chain of /tf and /tf_static; without any part: map,base_link
///   /TOPIC          poses of a topic
///   FROM:=TO        a remap; __ns:=NAMESPACE the namespace
///   use_sim_time:=true   stamps are of /clock
struct Ros2Source {
  std::string frame, child;                          ///< of a chain
  std::string topic;                                 ///< or a topic, resolved
  std::string tf = "/tf", tf_static = "/tf_static";  ///< resolved
  std::string clock;  ///< of simulated time, resolved; empty: stamps are of the senders
};
/// `kind`: what stands before it, for messages. Throws Error(kInput).
Ros2Source parse_ros2_source(const std::string& rest, const std::string& kind = "ros2:");

/// What follows "ros2:" in the text of an image source: one topic, and remaps. `what` and `kind` are named in the
/// message. Throws Error(kInput).
struct Ros2Topic {
  std::string topic;  ///< resolved
  std::string info;   ///< resolved: camera_info beside it, as image_transport names it
};
Ros2Topic parse_ros2_topic(const std::string& rest, const std::string& what,
                           const std::string& kind = "ros2:");

/// The text of an output: "ros2:[NAMESPACE]" and remaps. Throws Error(kInput).
GraphNames parse_ros2_output(const std::string& text);

/// Throws Error(kInput) for what is no name of a topic, relative or absolute; `what` is named in the message.
void require_topic_name(const std::string& name, const std::string& what);

/// The name of an absolute ROS 2 topic in DDS: "/tf" -> "rt/tf".
inline std::string dds_topic(const std::string& absolute) {
  return "rt" + absolute;
}

/// ROS_DOMAIN_ID, or 0. Throws Error(kInput) for what is no domain (0 to 232).
int domain_of_environment();

/// Whether ROS_LOCALHOST_ONLY or ROS_AUTOMATIC_DISCOVERY_RANGE keep the graph on this machine.
bool is_localhost_only();

}  // namespace procam::dds::internal
