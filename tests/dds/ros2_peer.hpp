#pragma once
/// Another process of the ROS 2 graph, as far as the network is concerned: a Cyclone domain of its own with the same
/// domain number on the wire, so that samples go through sockets of the loopback interface.
#include <string>

#include "dds/dds.h"
#include "ros2_messages.h"

namespace procam::test {

/// Keeps a test on the loopback interface, in a domain that no other test uses at the time; until it is destroyed.
class LoopbackDomain {
 public:
  LoopbackDomain();
  ~LoopbackDomain();
  int number() const { return number_; }
  /// What the environment says to any other program that is to take part.
  /// `capture`: a file for every packet of the program (pcap); empty: none.
  static std::string configuration(const std::string& discovery = "", int lost_per_mille = 0,
                                   const std::string& capture = "");

 private:
  int number_ = 0, lock_ = -1;
};

class Ros2Peer {
 public:
  /// `lost_per_mille`: packets that it does not send. `qos`: of its participant; `capture`: as above.
  explicit Ros2Peer(const LoopbackDomain& domain, int lost_per_mille = 0, const dds_qos_t* qos = nullptr,
                    const std::string& capture = "");
  ~Ros2Peer();
  Ros2Peer(const Ros2Peer&) = delete;
  Ros2Peer& operator=(const Ros2Peer&) = delete;

  dds_entity_t participant() const { return participant_; }
  dds_entity_t writer(const dds_topic_descriptor_t& type, const std::string& topic, bool reliable = true,
                      bool transient_local = false) const;
  dds_entity_t reader(const dds_topic_descriptor_t& type, const std::string& topic, bool reliable = true,
                      bool transient_local = false) const;

 private:
  dds_entity_t domain_ = 0, participant_ = 0;
};

}  // namespace procam::test
