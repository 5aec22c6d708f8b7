#include "procam/dds/security.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <mutex>

#include "security.hpp"
#include "security_files.hpp"

namespace procam::dds {
namespace {

std::mutex folder_mutex;
std::filesystem::path& chosen_folder() {
  static std::filesystem::path folder;
  return folder;
}

/// Debian keeps Cyclone's plugins in a folder beside libddsc, where the loader does not look: /usr/lib/*/libddsc0debian.
/// Elsewhere they are in the loader's path, and their name is enough.
std::string plugin(const std::string& name) {
  namespace fs = std::filesystem;
  Dl_info library{};
  if (dladdr(reinterpret_cast<const void*>(&dds_create_participant), &library) == 0 ||
      library.dli_fname == nullptr)
    return name;
  std::error_code failed;
  const fs::path folder = fs::path(library.dli_fname).parent_path();
  const std::string file = "lib" + name + ".so";
  if (fs::exists(folder / file, failed)) return (folder / file).string();
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, failed))
    if (entry.path().filename().string().rfind("libddsc", 0) == 0 && entry.is_directory(failed) &&
        fs::exists(entry.path() / file, failed))
      return (entry.path() / file).string();
  return name;
}

}  // namespace

void use_security(const std::filesystem::path& folder) {
  if (!folder.empty()) internal::security_files(folder);
  const std::lock_guard<std::mutex> lock(folder_mutex);
  chosen_folder() = folder;
}

internal::Security internal::security_of_process() {
  std::filesystem::path folder;
  {
    const std::lock_guard<std::mutex> lock(folder_mutex);
    folder = chosen_folder();
  }
  if (folder.empty()) folder = security_folder_of_environment().value_or("");
  Security security;
  if (folder.empty()) return security;
  security.folder = folder.string();
  security.qos.reset(dds_create_qos());
  const auto set = [&](const std::string& name, const std::string& value) {
    dds_qset_prop(security.qos.get(), name.c_str(), value.c_str());
  };
  for (const auto& [name, value] : security_files(folder)) set(name, value);
  constexpr struct {
    const char *kind, *library, *function;
  } kPlugins[] = {{"auth", "dds_security_auth", "authentication"},
                  {"access", "dds_security_ac", "access_control"},
                  {"crypto", "dds_security_crypto", "crypto"}};
  for (const auto& [kind, library, function] : kPlugins) {
    const std::string prefix = std::string("dds.sec.") + kind + ".library.";
    set(prefix + "path", plugin(library));
    set(prefix + "init", std::string("init_") + function);
    set(prefix + "finalize", std::string("finalize_") + function);
  }
  return security;
}

}  // namespace procam::dds
