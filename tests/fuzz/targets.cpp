#include "targets.hpp"

#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "fuzz_target.hpp"

namespace procam::fuzz {
namespace {

namespace fs = std::filesystem;

class OwnFolder {
 public:
  OwnFolder() {
    std::error_code ignored;
    const fs::path memory = "/dev/shm";
    const fs::path parent = fs::is_directory(memory, ignored) ? memory : fs::temp_directory_path();
    std::string name = (parent / "procam-fuzz-XXXXXX").string();
    check(::mkdtemp(name.data()) != nullptr, "no temporary folder can be made");
    path = name;
  }
  OwnFolder(const OwnFolder&) = delete;
  OwnFolder& operator=(const OwnFolder&) = delete;
  ~OwnFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  fs::path path;
};

}  // namespace

const std::vector<Target>& targets() {
  static const std::vector<Target> all = {
      {"json", json, true},
      {"xml", xml},
      {"yaml", yaml},
      {"rig", rig, true},
      {"rig_fields", rig_fields},
      {"surfaces_json", surfaces_json, true},
      {"surfaces_xml", surfaces_xml},
      {"surfaces_fields", surfaces_fields},
      {"solved_surfaces", solved_surfaces, true},
      {"show", show, true},
      {"show_fields", show_fields},
      {"session", session, true},
      {"board", board, true},
      {"markers", markers, true},
      {"pose", pose, true},
      {"pattern", pattern, true},
      {"shown", shown, true},
      {"typed", typed},
      {"calibration", calibration},
      {"mpcdi", mpcdi},
      {"mesh_obj", mesh_obj},
      {"mesh_ply", mesh_ply},
      {"pfm", pfm},
      {"npy", npy},
      {"image", image},
      {"observations", observations},
      {"point_pairs", point_pairs},
      {"trajectory", trajectory},
      {"pose_log", pose_log},
      {"run_log", run_log},
      {"mcap", mcap},
      {"poses", poses, true},
      {"pose_stream", pose_stream},
      {"osc", osc},
      {"psn", psn},
      {"rosbridge", rosbridge, true},
      {"wire_fields", wire_fields},
      {"skeletons", skeletons, true},
      {"skeleton_stream", skeleton_stream},
      {"skeleton_csv", skeleton_csv},
      {"foreign_skeletons", foreign_skeletons, true},
      {"vmc", vmc},
      {"http", http},
      {"editor", editor},
      {"kernels", kernels},
      {"vector_widths", vector_widths},
      {"renderers", renderers},
      {"replay", replay},
  };
  return all;
}

const Target* find_target(std::string_view name) {
  for (const Target& target : targets())
    if (name == target.name) return &target;
  return nullptr;
}

void run(const Target& target, std::string_view bytes) {
  try {
    target.run(bytes);
  } catch (const Error&) {
    return;  // refused with its reason
  }
}

void check_same(const std::string& once, const std::string& twice, const std::string& what) {
  if (once == twice) return;
  const auto differ = std::mismatch(once.begin(), once.end(), twice.begin(), twice.end());
  const std::size_t at = std::size_t(differ.first - once.begin()), from = at - std::min<std::size_t>(at, 20);
  throw std::logic_error(what + " reads back as another: '" + once.substr(from, 60) + "', then '" +
                         twice.substr(from, 60) + "'");
}

const fs::path& folder() {
  static const OwnFolder own;
  return own.path;
}

fs::path store(const std::string& name, std::string_view bytes) {
  const fs::path file = folder() / name;
  std::ofstream(file, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
  return file;
}

}  // namespace procam::fuzz
