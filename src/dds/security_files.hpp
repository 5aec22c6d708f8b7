#pragma once
/// The files of DDS Security, without DDS.
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace procam::dds::internal {

/// Properties of a participant that name the files of an enclave: name, value. Throws Error(kInput) for a missing file.
std::vector<std::pair<std::string, std::string>> security_files(const std::filesystem::path& folder);

/// The enclave that ROS 2's variables name; nullopt where they do not ask for security. Throws Error(kInput) where security is
/// asked for without a keystore: a graph that is open although its user believes it closed would be worse.
std::optional<std::filesystem::path> security_folder_of_environment();

}  // namespace procam::dds::internal
