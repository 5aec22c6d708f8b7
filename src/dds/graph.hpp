#pragma once
/// Cyclone DDS, as far as procam needs it: a participant in the ROS 2 graph, its topics and QoS, what it logs.
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "dds/dds.h"

namespace procam::dds::internal {

/// QoS of ROS 2's topics.
enum class Reliability { kReliable, kBestEffort };
enum class Durability { kVolatile, kTransientLocal };

/// A part of the graph in the domain of the environment. Deleted with all that was created from it. The secured parts of one
/// process are one participant of DDS: each would prove its identity to each peer, and two of them in one process bring
/// Cyclone DDS 0.10 down when they meet a secured peer of Fast DDS.
class Participant {
 public:
  /// Throws Error(kInput) for an environment that names no domain, Error(kDevice) where DDS cannot be started
  /// or its security refuses the certificates.
  Participant();
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  dds_entity_t entity() const { return *entity_; }
  /// What was created from entity(), to be deleted with this part; an error code is given back as it is.
  dds_entity_t kept(dds_entity_t entity) const {
    if (entity > 0) kept_.push_back(entity);
    return entity;
  }
  int domain() const { return domain_; }
  /// Its domain, network and security, in words: "ROS 2 domain 0, network eth0 (192.0.2.2)".
  std::string description() const {
    return "ROS 2 domain " + std::to_string(domain_) + (network_.empty() ? "" : ", network " + network_) +
           (security_.empty() ? "" : ", DDS Security by " + security_);
  }

  /// Of an absolute ROS 2 topic; throw Error(kDevice).
  dds_entity_t create_reader(const dds_topic_descriptor_t& type, const std::string& topic,
                             Reliability reliability, Durability durability, int depth) const;
  dds_entity_t create_writer(const dds_topic_descriptor_t& type, const std::string& topic,
                             Reliability reliability, Durability durability, int depth) const;

 private:
  std::shared_ptr<void> domain_kept_;
  std::shared_ptr<const dds_entity_t> entity_;
  mutable std::vector<dds_entity_t> kept_;
  int domain_ = 0;
  std::string network_;
  std::string security_;  ///< folder of its certificates
};

/// Samples of a ROS 2 topic that Cyclone dropped and logged, in this process.
struct DroppedSamples {
  std::uint64_t undecodable = 0;  ///< no CDR of the type
  std::uint64_t oversized = 0;    ///< above limits::kDdsSampleBytes
};
DroppedSamples dropped_samples(const std::string& topic);

}  // namespace procam::dds::internal
