#pragma once
/// DDS Security: who may take part in the graph, and what others on the network can read (docs/ros2.md).
///
///   dds::use_security("keystore/enclaves/projector");   // before the first source, publisher, group or fleet
///
/// The folder is an enclave of ROS 2, as `ros2 security create_enclave` writes it: identity_ca.cert.pem, cert.pem, key.pem,
/// permissions_ca.cert.pem, governance.p7s, permissions.p7s, and where certificates are revoked crl.pem. What is
/// encrypted is in governance.p7s (OMG DDS Security 1.1).
#include <filesystem>

#include "procam/core/base/export.hpp"

namespace procam::dds {

/// Everything that this process opens in the graph from here on authenticates itself with these files, and talks only to
/// those whose certificates are of the same authority, as the governance states. It counts more than ROS_SECURITY_ENABLE,
/// ROS_SECURITY_KEYSTORE and ROS_SECURITY_ENCLAVE_OVERRIDE. Empty: as these variables state. Throws Error(kInput) where a
/// file is missing, Error(kUnsupported) in a build without DDS. Files that do not fit each other are an Error(kDevice) of what is
/// opened.
PROCAM_EXPORT void use_security(const std::filesystem::path& folder);

}  // namespace procam::dds
