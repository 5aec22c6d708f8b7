#pragma once
/// DDS Security of this process' participants.
#include <memory>
#include <string>

#include "dds/dds.h"

namespace procam::dds::internal {

struct QosDelete {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};

/// QoS of a participant, and the folder that secures it; without security both are empty.
struct Security {
  std::unique_ptr<dds_qos_t, QosDelete> qos;
  std::string folder;
};

/// As use_security() or the environment state. Throws Error(kInput).
Security security_of_process();

}  // namespace procam::dds::internal
