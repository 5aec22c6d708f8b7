/// `procam`: the command in front of the tools.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "e2e/tool_runner.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;

/// The tools by their sources: a tool that is added must be listed.
std::set<std::string> tool_names() {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(fs::path(PROCAM_SOURCE_DIR) / "tools")) {
    std::string name = entry.path().stem().string();
    if (entry.path().extension() != ".cpp" || name == "procam") continue;
    std::replace(name.begin(), name.end(), '_', '-');
    names.insert(name);
  }
  return names;
}

TEST(FrontCommand, ListsEveryTool) {
  const ToolRun run = run_tool("procam", "");
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_GE(tool_names().size(), 17u);
  std::set<std::string> listed;
  std::istringstream lines(run.out);
  for (std::string line; std::getline(lines, line);)
    if (line.rfind("  ", 0) == 0 && line.rfind("  procam", 0) != 0)
      listed.insert(line.substr(2, line.find(' ', 2) - 2));
  EXPECT_EQ(listed, tool_names());
  EXPECT_EQ(run_tool("procam", "--help").out, run.out);
}

/// The names of other options are sorted: in the order of addresses, the manual pages would differ from build to build.
TEST(FrontCommand, HelpIsTheSameInEachRun) {
  const ToolRun run = run_tool("calibrate-mount", "--help");
  EXPECT_NE(run.out.find("needs: --marker-size --rig"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("not with: --arm --pan-tilt"), std::string::npos) << run.out;
}

TEST(FrontCommand, RunsATool) {
  const ToolRun direct = run_tool("make-board", "--help"), through = run_tool("procam", "make-board --help");
  EXPECT_EQ(through.exit_code, 0);
  EXPECT_EQ(through.out, direct.out);
  const ToolRun wrong = run_tool("procam", "make-board --board chessboard:7x9");
  EXPECT_EQ(wrong.exit_code, run_tool("make-board", "--board chessboard:7x9").exit_code);
  EXPECT_NE(wrong.exit_code, 0);
  EXPECT_NE(wrong.err.find("make-board: "), std::string::npos) << wrong.err;
}

/// The programs behind load OpenCV, which takes 60 to 230 ms of CPU time. A copy of the front alone shows that --version
/// needs none of them.
TEST(FrontCommand, AnswersVersionWithoutTheProgramsBehind) {
  const ScratchFolder folder;
  const fs::path tools = PROCAM_TOOLS;
  fs::copy_file(tools / "procam", folder / "procam");
  for (const std::string& tool : tool_names()) {
    const std::string name = tool.find('-') == std::string::npos ? "procam-" + tool : tool;
    ASSERT_TRUE(fs::is_symlink(tools / name)) << name;
    fs::create_symlink("procam", folder / name);
    const std::string version = name + " (procam ";
    const ToolRun alone = run_program((folder / name).string(), "--version");
    EXPECT_EQ(alone.exit_code, 0) << alone.err;
    EXPECT_EQ(alone.out.rfind(version, 0), 0u) << alone.out;
    EXPECT_EQ(run_program((folder / "procam").string(), tool + " --version").out, alone.out);
    // The program behind, by the order of the arguments.
    EXPECT_EQ(run_tool(name, "--json --version").out, alone.out);
    const ToolRun libraries = run_tool(name, "--version", "LD_TRACE_LOADED_OBJECTS=1");
    EXPECT_NE(libraries.out.find("libc.so"), std::string::npos) << libraries.out;
    EXPECT_LE(std::count(libraries.out.begin(), libraries.out.end(), '\n'), 6) << name << "\n"
                                                                               << libraries.out;

    const ToolRun help = run_program((folder / name).string(), "--help");
    EXPECT_EQ(help.exit_code, 3);
    EXPECT_NE(help.err.find("next: install the tools together"), std::string::npos) << help.err;
  }
}

TEST(FrontCommand, SaysSoOnAFullDisk) {
  EXPECT_EQ(run_program("/bin/sh", "-c '" + std::string(PROCAM_TOOLS) + "/make-board --version >/dev/full'")
                .exit_code,
            3);
}

TEST(FrontCommand, HelpOfEveryToolIsTypedAndFitsTheTerminal) {
  for (const std::string& tool : tool_names()) {
    const ToolRun run = run_tool("procam", tool + " --help");
    EXPECT_EQ(run.exit_code, 0) << tool;
    EXPECT_EQ(run.out.find(" TEXT"), std::string::npos)
        << tool << ": name the option's type in the table of tools/common/help.cpp\n"
        << run.out.substr(run.out.find(" TEXT") > 60 ? run.out.find(" TEXT") - 60 : 0, 120);
    std::istringstream lines(run.out);
    bool in_examples = false;  // a command stays one line, so that it can be copied
    int options = 0;
    for (std::string line; std::getline(lines, line);) {
      options += line.rfind("  -", 0) == 0;
      in_examples = line == "Try:" || (in_examples && !line.empty());
      if (!in_examples) EXPECT_LE(line.size(), 104u) << tool << ": " << line;
    }
    // A long list is in groups: tools/common/help.cpp.
    EXPECT_TRUE(options < 20 || run.out.find("\nOptions:\n") == std::string::npos) << run.out;
  }
}

TEST(FrontCommand, SuggestsATool) {
  const ToolRun run = run_tool("procam", "calibrate");
  EXPECT_EQ(run.exit_code, 2);
  for (const char* part : {"'calibrate'", "why:", "next:", "calibrate-projector", "calibrate-camera"})
    EXPECT_NE(run.err.find(part), std::string::npos) << part << " is not in " << run.err;
  EXPECT_EQ(run.err.find("make-board"), std::string::npos) << run.err;
  EXPECT_EQ(run_tool("procam", "../../bin/sh").exit_code, 2);
  EXPECT_NE(run_tool("procam", "studoi").err.find("did you mean studio?"), std::string::npos);
}

TEST(FrontCommand, SuggestsPatternsBoardsAndDictionaries) {
  const std::string patterns = "--projector-size 100x60 -o " + std::string("/nowhere/session --pattern ");
  EXPECT_NE(run_tool("make-patterns", patterns + "grey").err.find("did you mean 'gray'?"), std::string::npos);
  const ToolRun board = run_tool("make-board", "-o board.pdf --board chesboard:9x6:24mm");
  EXPECT_EQ(board.exit_code, 2);
  EXPECT_NE(board.err.find("did you mean 'chessboard'?"), std::string::npos) << board.err;
  EXPECT_NE(run_tool("make-board", "-o board.pdf --board charuco:5x7:34mm:25mm:5x5_1000x")
                .err.find("did you mean '5x5_1000'?"),
            std::string::npos);
}

}  // namespace
}  // namespace procam::test
