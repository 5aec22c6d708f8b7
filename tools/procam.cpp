/// procam: one command in front of the tools. Lists the tasks, and runs the tool that is named.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

namespace {

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
        {"calibrate-mount", "the rig on its robot base, from a drive past markers"}}},
      {"Place",
       {{"locate-projector", "the projector's pose in the room, from markers"},
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

void print_tasks(std::FILE* to) {
  std::fputs("procam TOOL [OPTIONS]     runs a tool; procam TOOL --help lists its options\n", to);
  for (const Group& group : groups()) {
    std::fprintf(to, "\n%s\n", group.title);
    for (const Task& task : group.tasks) std::fprintf(to, "  %-20s %s\n", task.tool, task.purpose);
  }
  std::fputs(
      "\nTo try without a projector:\n"
      "  procam simulate-captures --seed 7 --level easy -o session\n"
      "  procam calibrate-projector --captures session -o rig.json --report report.html\n"
      "A first picture, without calibration:\n"
      "  procam project-live --display 1 --surfaces wall.json --content wall=picture.png\n",
      to);
}

/// Three parts, as all tools print errors; returns the exit code of wrong usage.
int refuse(const std::string& what, const std::string& why, const std::string& next) {
  std::fprintf(stderr, "procam: %s\n  why:  %s\n  next: %s\n", what.c_str(), why.c_str(), next.c_str());
  return 2;
}

bool is_tool(const std::string& name) {
  return std::any_of(groups().begin(), groups().end(), [&](const Group& group) {
    return std::any_of(group.tasks.begin(), group.tasks.end(),
                       [&](const Task& task) { return name == task.tool; });
  });
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

}  // namespace

int main(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "";
  if (name.empty() || name == "--help" || name == "-h" || name == "help") {
    print_tasks(stdout);
    return 0;
  }
  if (name == "--version") {
    std::puts("procam " PROCAM_VERSION);
    return 0;
  }
  if (!is_tool(name)) {
    const std::string similar = similar_tools(name);
    return refuse("'" + name + "'", "no tool has this name",
                  (similar.empty() ? "" : "did you mean " + similar + "? ") + "'procam' lists the tools");
  }
  std::error_code error;
  const std::filesystem::path here = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  // A general word is no name for a program: "procam studio" runs procam-studio.
  for (const std::string& program : {name, "procam-" + name}) {
    const std::string beside = (here / program).string();
    if (!error) execv(beside.c_str(), argv + 1);
  }
  for (const std::string& program : {"procam-" + name, name}) execvp(program.c_str(), argv + 1);
  return refuse(name, std::string("it cannot be started: ") + std::strerror(errno),
                "install the tools together, or put them on the PATH");
}
