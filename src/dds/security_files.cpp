#include "security_files.hpp"

#include <cstdlib>

#include "procam/core/base/error.hpp"

namespace procam::dds::internal {
namespace {

constexpr const char* kWhere = "name an enclave, as `ros2 security create_enclave KEYSTORE NAME` writes it";

std::string variable(const char* name) {
  const char* text = std::getenv(name);
  return text == nullptr ? "" : text;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> security_files(const std::filesystem::path& folder) {
  constexpr struct {
    const char *property, *file;
  } kFiles[] = {{"dds.sec.auth.identity_ca", "identity_ca.cert.pem"},
                {"dds.sec.auth.identity_certificate", "cert.pem"},
                {"dds.sec.auth.private_key", "key.pem"},
                {"dds.sec.access.permissions_ca", "permissions_ca.cert.pem"},
                {"dds.sec.access.governance", "governance.p7s"},
                {"dds.sec.access.permissions", "permissions.p7s"},
                {"org.eclipse.cyclonedds.sec.auth.crl", "crl.pem"}};
  const std::string what = "DDS Security, folder '" + folder.string() + "'";
  if (!std::filesystem::is_directory(folder)) throw Error(ErrorKind::kInput, what, "it is no folder", kWhere);
  std::vector<std::pair<std::string, std::string>> properties;
  for (const auto& [property, name] : kFiles) {
    const std::filesystem::path file = std::filesystem::absolute(folder / name).lexically_normal();
    if (std::filesystem::is_regular_file(file))
      properties.emplace_back(property, "file:" + file.string());
    else if (name != std::string("crl.pem"))
      throw Error(ErrorKind::kInput, what, std::string("it has no file ") + name, kWhere);
  }
  return properties;
}

std::optional<std::filesystem::path> security_folder_of_environment() {
  if (variable("ROS_SECURITY_ENABLE") != "true") return std::nullopt;
  const std::string keystore = variable("ROS_SECURITY_KEYSTORE");
  if (keystore.empty())
    throw Error(ErrorKind::kInput, "ROS_SECURITY_ENABLE=true", "ROS_SECURITY_KEYSTORE names no folder",
                "set it to the keystore, or unset ROS_SECURITY_ENABLE");
  const std::string enclave = variable("ROS_SECURITY_ENCLAVE_OVERRIDE");
  return std::filesystem::path(keystore) / "enclaves" /
         std::filesystem::path(enclave).relative_path().lexically_normal();
}

}  // namespace procam::dds::internal
