#pragma once
/// A show that begins when its person logs in: a systemd unit of the user, beside the project's files.
#include <filesystem>
#include <string>

namespace procam::studio {

/// systemd.unit(5), systemd.service(5). The show is started again when it ends or hangs. Throws Error(kInput) for a folder
/// whose name has a line break.
std::string service_file(const std::filesystem::path& project);

}  // namespace procam::studio
