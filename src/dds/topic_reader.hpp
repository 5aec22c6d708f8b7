#pragma once
/// A reader of one ROS 2 topic, of the type that is published and with the QoS of its publishers.
///
/// A reliable reader gets nothing of a publisher that is best effort, and one that is transient local nothing of a volatile
/// one: the reader is each only while all publishers are. When they change (a camera's node that is started again with
/// "sensor data" QoS), the reader is made anew.
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "graph.hpp"
#include "procam/core/base/clock.hpp"

namespace procam::dds::internal {

constexpr int kTaken = 32;  ///< samples at once

/// Calls visit(sample, info, arrival) for all that a reader has.
template <typename Visit>
void take_all(dds_entity_t reader, Visit visit) {
  for (int count = kTaken; count == kTaken;) {
    void* samples[kTaken] = {};
    dds_sample_info_t infos[kTaken];
    count = dds_take(reader, samples, infos, kTaken, kTaken);
    const double arrival = steady_now();  // after the samples, so that none arrived before it was sent
    for (int i = 0; i < count; ++i) visit(samples[i], infos[i], arrival);
    if (count > 0) dds_return_loan(reader, samples, count);
  }
}

/// Samples wake the waitset, and nothing else does: any other status stays set until it is read, and a waitset with a status that
/// is set never waits.
void attach_data(dds_entity_t waitset, dds_entity_t reader);

/// "nav_msgs::msg::dds_::Odometry_" as ROS writes it: "nav_msgs/msg/Odometry".
std::string ros_type(std::string type);

class TopicReader {
 public:
  using Types = std::vector<const dds_topic_descriptor_t*>;
  /// `depth`: samples that are kept. They wake `waitset`; publishers that come or go do by DDS' discovery.
  TopicReader(const Participant& participant, dds_entity_t waitset, std::string topic, Types types,
              int depth);

  /// A publisher of any topic, as DDS' discovery tells of it. "", or the sentence for a new one whose type is not read. Throws
  /// Error(kDevice).
  std::string discovered(const dds_builtintopic_endpoint_t& endpoint, const dds_sample_info_t& info);

  const std::string& topic() const { return topic_; }
  dds_entity_t entity() const { return reader_; }               ///< 0 before there is a publisher
  const dds_topic_descriptor_t* type() const { return type_; }  ///< nullptr before
  std::size_t publishers() const;                               ///< of this type, at present

 private:
  using Key = std::array<std::uint8_t, 16>;
  struct Publisher {
    const dds_topic_descriptor_t* type = nullptr;
    Reliability reliability = Reliability::kBestEffort;
    Durability durability = Durability::kVolatile;
  };
  void follow();

  const Participant& participant_;
  dds_entity_t waitset_, reader_ = 0;
  std::string topic_;
  Types types_;
  int depth_;
  std::map<Key, Publisher> publishers_;
  const dds_topic_descriptor_t* type_ = nullptr;
  Reliability reliability_ = Reliability::kBestEffort;
  Durability durability_ = Durability::kVolatile;
};

}  // namespace procam::dds::internal
