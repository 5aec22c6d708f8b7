/// procam: one command in front of the tools. Lists the tasks, and runs the tool that is named, by its first argument
/// ("procam make-board ...") or by the link that it was started through ("make-board ..."). It answers --version for all
/// of them: the tools' own programs load many libraries first.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "procam/core/base/detail/edit_distance.hpp"

namespace {

namespace fs = std::filesystem;

struct Task {
  const char *tool, *purpose;
};
struct Group {
  const char* title;
  std::vector<Task> tasks;
};

const std::vector<Group>& groups() {
  static const std::vector<Group> all = {
      {"Guided",
       {{"studio",
         "one page in the browser from nothing to a checked image on the wall; --simulate without hardware"}}},
      {"Prepare",
       {{"plan-projection", "predict the image on a wall from the projector's data sheet and position"},
        {"make-board", "draw a calibration board to print"},
        {"make-patterns", "write the frames of a calibration session for another player"}}},
      {"Calibrate",
       {{"capture-session", "show patterns on the projector and capture them with a camera"},
        {"calibrate-projector", "projector and camera together, from a session"},
        {"calibrate-camera", "cameras alone, from photographs of a printed board"},
        {"calibrate-room", "projectors and cameras from structured light on a room, without a board"},
        {"calibrate-mount", "the rig on its robot base, from a drive past markers or walls"}}},
      {"Place",
       {{"locate-projector", "the projector's pose in the room, from markers"},
        {"align-maps", "two maps of one place, joined by what both hold"},
        {"detect-surfaces", "walls, floor and tables in a depth image"},
        {"scan-surfaces", "the shape of any room, from structured light and a rig"},
        {"solve-surfaces", "where surfaces lie in the projector's frame, and the light on them"}}},
      {"Show",
       {{"project-live", "a running show; without a rig, corners are dragged by hand"},
        {"render-to-image", "the frames that a projector must show, as files"},
        {"export-warp", "a surface's warp for another program"},
        {"export-camera", "the projector as a rendering camera of another program"},
        {"convert", "calibrations from and for OpenCV, ROS, Kalibr, mrcal, COLMAP, URDF, glTF"}}},
      {"Judge",
       {{"predict-error", "the error of the light in millimetres, and its causes"},
        {"verify-projection", "measure whether the light still agrees with the rig"}}},
      {"Simulate",
       {{"simulate-captures", "a calibration session with its true rig"},
        {"simulate-robot", "poses of a driving robot, to a socket or a log"}}}};
  return all;
}

void print_tasks() {
  std::fputs("procam TOOL [OPTIONS]     runs a tool; procam TOOL --help lists its options\n", stdout);
  for (const Group& group : groups()) {
    std::printf("\n%s\n", group.title);
    for (const Task& task : group.tasks) std::printf("  %-20s %s\n", task.tool, task.purpose);
  }
  std::fputs(
      "\nTo try without a projector:\n"
      "  procam simulate-captures --seed 7 --level easy -o session\n"
      "  procam calibrate-projector --captures session -o rig.json --report report.html\n"
      "A first picture, without calibration:\n"
      "  procam project-live --display 1 --surfaces wall.json --content wall=picture.png\n",
      stdout);
}

// The tools' codes: tools/common/cli.hpp.
constexpr int kUsage = 2, kBadInput = 3;

/// Three parts, as all tools print errors; returns the exit code.
int refuse(int code, const std::string& what, const std::string& why, const std::string& next) {
  std::fprintf(stderr, "procam: %s\n  why:  %s\n  next: %s\n", what.c_str(), why.c_str(), next.c_str());
  return code;
}

/// The exit code after the last line on stdout.
int written() {
  if (std::fflush(stdout) == 0) return 0;
  return refuse(kBadInput, "standard output", "it cannot be written",
                "check the pipe or the disk it goes to");
}

bool is_tool(const std::string& name) {
  return std::any_of(groups().begin(), groups().end(), [&](const Group& group) {
    return std::any_of(group.tasks.begin(), group.tasks.end(),
                       [&](const Task& task) { return name == task.tool; });
  });
}

std::vector<std::string> tool_names() {
  std::vector<std::string> names;
  for (const Group& group : groups())
    for (const Task& task : group.tasks) names.emplace_back(task.tool);
  return names;
}

/// Tools that share a word with the name: "calibrate" and "projector-calibrate" have calibrate-projector.
std::string similar_tools(const std::string& name) {
  std::string found;
  for (const Group& group : groups())
    for (const Task& task : group.tasks) {
      const std::string tool = task.tool, first = tool.substr(0, tool.find('-')),
                        last = tool.substr(tool.rfind('-') + 1);
      const auto begins_alike = [&](const std::string& word) {
        return name.find(word.substr(0, std::min<std::size_t>(word.size(), 5))) != std::string::npos;
      };
      if (begins_alike(first) || begins_alike(last)) found += (found.empty() ? "" : ", ") + tool;
    }
  return found;
}

/// The program of a tool. A general word is no name for a program: "procam studio" runs procam-studio.
std::string program_name(const std::string& tool) {
  return (tool.find('-') == std::string::npos ? "procam-" : "") + tool;
}

/// The tool whose program has this name; empty where none has.
std::string tool_of_program(const std::string& program) {
  for (const Group& group : groups())
    for (const Task& task : group.tasks)
      if (program == program_name(task.tool)) return task.tool;
  return "";
}

/// `argv`: the tool's own, its name first. Returns only if the program cannot be started.
int run(const std::string& tool, int argc, char** argv) {
  const std::string program = program_name(tool);
  if (argc == 2 && std::strcmp(argv[1], "--version") == 0) {
    std::printf("%s (procam " PROCAM_VERSION ")\n", program.c_str());
    return written();
  }
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path() / PROCAM_PROGRAMS;
  const std::string path = (folder / program).lexically_normal().string();
  execv(path.c_str(), argv);
  return refuse(kBadInput, program, path + " cannot be started: " + std::strerror(errno),
                "install the tools together, by 'cmake --install' or the package procam-tools");
}

}  // namespace

int main(int argc, char** argv) {
  const std::string started_as = argc > 0 ? fs::path(argv[0]).filename().string() : "";
  if (const std::string tool = tool_of_program(started_as); !tool.empty()) return run(tool, argc, argv);
  const std::string name = argc > 1 ? argv[1] : "";
  if (name.empty() || name == "--help" || name == "-h" || name == "help") {
    print_tasks();
    return written();
  }
  if (name == "--version") {
    std::puts("procam " PROCAM_VERSION);
    return written();
  }
  if (is_tool(name)) return run(name, argc - 1, argv + 1);
  std::string similar = similar_tools(name);
  if (similar.empty()) similar = procam::internal::nearest_name(name, tool_names());
  return refuse(kUsage, "'" + name + "'", "no tool has this name",
                (similar.empty() ? "" : "did you mean " + similar + "? ") + "'procam' lists the tools");
}
