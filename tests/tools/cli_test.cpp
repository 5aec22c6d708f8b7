#include "common/cli.hpp"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <limits>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "common/examples.hpp"
#include "common/help.hpp"
#include "common/renamed_options.hpp"
#include "support/json_schema.hpp"

namespace procam::tools {
namespace {

struct ToolRun {
  int code = -1;
  std::string out, err;
};

const ToolInfo kTool{"measure-wall", "Measures a wall."};

ToolRun run_with(
    std::vector<const char*> arguments, const std::function<ExitCode(Console&)>& body,
    const std::function<void(CLI::App&)>& declare = [](CLI::App&) {}, const ToolInfo& tool = kTool) {
  arguments.insert(arguments.begin(), tool.name.c_str());
  ToolRun run;
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  run.code = run_tool(int(arguments.size()), arguments.data(), tool, declare, body);
  run.out = testing::internal::GetCapturedStdout();
  run.err = testing::internal::GetCapturedStderr();
  return run;
}

ExitCode nothing(Console&) {
  return ExitCode::kOk;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Cli, HelpOpensWithWhatTheToolDoesAndItsExamples) {
  const ToolRun run = run_with({"--help"}, nothing);
  EXPECT_EQ(run.code, 0);
  EXPECT_EQ(run.out.rfind("measure-wall: Measures a wall.\n\nUsage:", 0), 0u) << run.out;
  const ToolRun known = run_with({"--help"}, nothing, [](CLI::App&) {}, {"make-board", "Measures a wall."});
  const std::vector<Example>& lines = examples("make-board");
  ASSERT_EQ(lines.size(), 3u);
  const std::string opening =
      "make-board: Measures a wall.\n\nTry:\n  # " + lines[0].purpose + "\n  " + lines[0].command + "\n";
  EXPECT_EQ(known.out.rfind(opening, 0), 0u) << known.out;
}

TEST(Cli, HelpNamesTypesAndGroups) {
  const auto declare = [](CLI::App& app) {
    static std::string rig, output;
    static int threads = 0;
    app.add_option("--rig", rig,
                   "the rig's file, with so many words that they need more than one line of the help text")
        ->required();
    app.add_option("-o,--output", output, "the result");
    app.add_option("--threads", threads, "as many at a time")->check(CLI::Range(0, 8));
  };
  const ToolRun run = run_with({"--help"}, nothing, declare);
  const std::size_t rig = run.out.find("  --rig FILE (required)"), results = run.out.find("Results:\n"),
                    output = run.out.find("  -o,--output FILE"), general = run.out.find("General:\n");
  EXPECT_LT(rig, results) << run.out;
  EXPECT_LT(results, output);
  EXPECT_LT(output, general) << run.out;
  EXPECT_NE(general, std::string::npos);
  EXPECT_TRUE(contains(run.out, "--threads INTEGER in [0 - 8]") ||
              contains(run.out, "--threads INT in [0 - 8]"))
      << run.out;
}

TEST(Cli, OptionsOfOneTopicAreAGroup) {
  const auto declare = [](CLI::App& app) {
    static std::string rig, pose, output;
    app.add_option("--rig", rig, "the rig");
    declare_group(app, "Poses", [&] {
      app.add_option("--pose", pose, "the pose");
      app.add_option("-o,--output", output, "the result");
    });
  };
  const ToolRun run = run_with({"--help"}, nothing, declare);
  const std::size_t rig = run.out.find("  --rig FILE"), group = run.out.find("\nPoses:\n"),
                    pose = run.out.find("  --pose FILE"), results = run.out.find("\nResults:\n"),
                    output = run.out.find("  -o,--output FILE");
  EXPECT_LT(rig, group) << run.out;
  EXPECT_LT(group, pose) << run.out;
  EXPECT_LT(pose, results) << run.out;
  EXPECT_LT(results, output) << run.out;
  EXPECT_NE(output, std::string::npos);
}

void declare_files_and_seed(CLI::App& app) {
  static std::string rig, output;
  static int seed = 4;
  app.add_option("--rig", rig, "the rig");
  app.add_option("-o,--output", output, "the result");
  app.add_option("--seed", seed, "of noise")->capture_default_str();
}

TEST(Cli, TheSummaryNamesInputsAndSeed) {
  const ToolRun run =
      run_with({"--json", "--rig", "a/rig.json", "-o", "out.json"}, nothing, declare_files_and_seed);
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["inputs"], nlohmann::json::array({"a/rig.json"}));
  EXPECT_EQ(json["outputs"], nlohmann::json::array({"out.json"}));
  EXPECT_EQ(json["seed"], "4");
  const ToolRun other = run_with({"--json", "--seed", "12"}, nothing, declare_files_and_seed);
  EXPECT_EQ(nlohmann::json::parse(other.out)["seed"], "12");
  EXPECT_FALSE(nlohmann::json::parse(other.out).contains("inputs"));
}

TEST(Cli, SummariesAgreeWithTheirSchema) {
  const nlohmann::json schema = test::schema_of("summary");
  test::Validator validator(schema);
  const auto disagreement = [&](const std::vector<const char*>& arguments,
                                const std::function<ExitCode(Console&)>& body) {
    const ToolRun run = run_with(arguments, body, declare_files_and_seed);
    return validator.disagreement(nlohmann::json::parse(run.out));
  };
  const auto report = [](Console& console) {
    Diagnostics diagnostics;
    diagnostics.note("a", "as expected");
    diagnostics.warn("b", "look again");
    diagnostics.fail("c", "wrong");
    console.report(diagnostics);
    console.summary().set("/wall/rms_mm", 0.3);
    return exit_code(diagnostics);
  };
  const auto fail = [](Console&) -> ExitCode {
    throw Error(ErrorKind::kDegenerate, "views", "they are alike", "tilt the board");
  };
  EXPECT_EQ(disagreement({"--json", "--rig", "rig.json", "-o", "out.json"}, report), "");
  EXPECT_EQ(disagreement({"--json"}, fail), "");
  EXPECT_EQ(disagreement({"--json", "--seed", "x"}, nothing), "");
  EXPECT_TRUE(validator.never_met().empty()) << *validator.never_met().begin();
}

TEST(Cli, WrapsAtTheWidthAndKeepsLines) {
  EXPECT_EQ(wrapped("one two three four", 9, 2, 0), "one two\n  three\n  four");
  EXPECT_EQ(wrapped("one two", 20, 4, 15), "one\n    two");
  EXPECT_EQ(wrapped("unbreakable", 4, 2, 0), "unbreakable");
  EXPECT_EQ(wrapped("Try:\n  a command stays one line\n", 9, 0, 0), "Try:\n  a command stays one line\n");
  EXPECT_EQ(wrapped("markers\nor a file", 80, 4, 10), "markers\n    or a file");
  EXPECT_EQ(wrapped("", 80, 0, 0), "");
}

TEST(Cli, SuggestsTheOptionThatWasMeant) {
  const auto declare = [](CLI::App& app) {
    static std::string captures, rig;
    app.add_option("--captures", captures, "folder")->required();
    app.add_option("--rig", rig, "file");
  };
  ToolRun run = run_with({"--capture", "folder"}, nothing, declare);
  EXPECT_EQ(run.code, int(ExitCode::kUsage));
  EXPECT_TRUE(contains(run.err, "'--capture'")) << run.err;
  EXPECT_TRUE(contains(run.err, "did you mean --captures? see measure-wall --help")) << run.err;
  run = run_with({"--captures", "folder", "--nothing-alike=7"}, nothing, declare);
  EXPECT_EQ(run.code, int(ExitCode::kUsage));
  EXPECT_FALSE(contains(run.err, "did you mean")) << run.err;
  const std::string long_word(100000, 'x');
  run = run_with({"--captures=a", long_word.c_str()}, nothing, declare);
  EXPECT_EQ(run.code, int(ExitCode::kUsage));
  EXPECT_LT(run.err.size(), 1000u);
}

TEST(Cli, VersionNamesToolAndLibrary) {
  const ToolRun run = run_with({"--version"}, nothing);
  EXPECT_EQ(run.code, 0);
  EXPECT_TRUE(contains(run.out, "measure-wall (procam ")) << run.out;
}

TEST(Cli, KeepsStdoutForTheSummaryUnderJson) {
  const auto body = [](Console& console) {
    console.say("two metres");
    console.summary().set("/wall/width", 2.0);
    console.summary().set("/wall/flat", true);
    return ExitCode::kOk;
  };
  const ToolRun json = run_with({"--json"}, body);
  EXPECT_EQ(json.err, "two metres\n");
  EXPECT_EQ(json.out.front(), '{');
  EXPECT_TRUE(contains(json.out, "\"exit_code\": 0")) << json.out;
  EXPECT_TRUE(contains(json.out, "\"wall\": {\n    \"width\": 2.0,\n    \"flat\": true\n  }")) << json.out;

  const ToolRun plain = run_with({}, body);
  EXPECT_EQ(plain.out, "two metres\n");
  EXPECT_EQ(plain.err, "");
}

TEST(Cli, TellsErrorsInThreePartsWithTheCodeOfTheirKind) {
  const std::vector<std::pair<ErrorKind, int>> codes = {
      {ErrorKind::kInput, 3},         {ErrorKind::kUnsupported, 3}, {ErrorKind::kIo, 3},
      {ErrorKind::kNotEnoughData, 4}, {ErrorKind::kDegenerate, 4},  {ErrorKind::kNotConverged, 4},
      {ErrorKind::kDevice, 6}};
  for (const auto& [kind, code] : codes) {
    const auto fail = [kind = kind](Console&) -> ExitCode {
      throw Error(kind, "views/3", "it has no corners", "take it again");
    };
    const ToolRun run = run_with({"--json"}, fail);
    EXPECT_EQ(run.code, code) << to_string(kind);
    EXPECT_EQ(run.err, "measure-wall: views/3\n  why:  it has no corners\n  next: take it again\n");
    EXPECT_TRUE(contains(run.out, std::string("\"kind\": \"") + to_string(kind) + '"')) << run.out;
    EXPECT_TRUE(contains(run.out, "\"next\": \"take it again\"")) << run.out;
    EXPECT_EQ(run_with({}, fail).out, "");
  }
}

TEST(Cli, CallsAnythingElseABug) {
  const ToolRun precondition =
      run_with({}, [](Console&) -> ExitCode { throw std::invalid_argument("w <= 0"); });
  EXPECT_EQ(precondition.code, 1);
  EXPECT_TRUE(contains(precondition.err, "this is a bug in procam")) << precondition.err;
  EXPECT_EQ(run_with({}, [](Console&) -> ExitCode { throw 7; }).code, 1);
}

TEST(Cli, RefusesFlagsItDoesNotKnow) {
  const ToolRun run = run_with({"--json", "--hight", "2"}, nothing);
  EXPECT_EQ(run.code, 2);
  EXPECT_TRUE(contains(run.err, "--hight")) << run.err;
  EXPECT_TRUE(contains(run.out, "\"kind\": \"usage\"")) << run.out;
}

TEST(Cli, NamesTheFlagWhoseTextDoesNotParse) {
  double width = 0;
  const auto declare = [&width](CLI::App& app) {
    add_parsed(
        app, "--width",
        [&width](const std::string& text) {
          if (text != "2m") throw Error(ErrorKind::kInput, "length '" + text + "'", "no unit", "write 2m");
          width = 2;
        },
        "Width of the wall");
  };
  EXPECT_EQ(run_with({"--width", "2m"}, nothing, declare).code, 0);
  EXPECT_EQ(width, 2);
  const ToolRun bad = run_with({"--width", "2"}, nothing, declare);
  EXPECT_EQ(bad.code, 2);
  EXPECT_TRUE(contains(bad.err, "measure-wall: --width: length '2'\n  why:  no unit\n  next: write 2m"))
      << bad.err;
}

TEST(Cli, NumbersHaveBoundsThatNanDoesNotPass) {
  double rate = 0;
  const auto declare = [&rate](CLI::App& app) { app.add_option("--rate", rate)->check(within(0.5, 1000)); };
  for (const char* good : {"0.5", "1000", "25.5"})
    EXPECT_EQ(run_with({"--rate", good}, nothing, declare).code, 0) << good;
  for (const char* bad : {"0.49", "1000.1", "-1", "nan", "inf", "1e308", "1e309", "25x", ""}) {
    const ToolRun run = run_with({"--rate", bad}, nothing, declare);
    EXPECT_EQ(run.code, 2) << bad;
    EXPECT_TRUE(contains(run.err, "is not a number from 0.5 to 1000")) << run.err;
  }
}

TEST(Cli, TooLittleMemoryIsNoBug) {
  const ToolRun run = run_with({}, [](Console&) -> ExitCode { throw std::bad_alloc(); });
  EXPECT_EQ(run.code, 3);
  EXPECT_TRUE(contains(run.err, "not enough of it")) << run.err;
}

TEST(Cli, EndsWith130WhenInterruptedBetweenSteps) {
  const ToolRun run = run_with({}, [](Console& console) {
    console.progress("measuring", 0, 2);
    std::raise(SIGINT);
    console.progress("measuring", 1, 2);
    return ExitCode::kOk;
  });
  EXPECT_EQ(run.code, 130);
  EXPECT_TRUE(contains(run.err, "interrupted")) << run.err;
}

/// A service manager and a terminal that closes end a tool as Ctrl-C does; what was measured is printed.
TEST(Cli, SigtermAndSighupEndAToolAsCtrlCDoes) {
  const auto with = [](int signal) {
    return run_with({"--json"}, [signal](Console& console) {
      console.summary().set("/frames", 17);
      std::raise(signal);
      console.stop_if_requested();
      return ExitCode::kOk;
    });
  };
  const std::pair<int, const char*> signals[] = {
      {SIGINT, "Ctrl-C"}, {SIGTERM, "SIGTERM"}, {SIGHUP, "SIGHUP"}};
  for (const auto& [signal, name] : signals) {
    const ToolRun run = with(signal);
    EXPECT_EQ(run.code, 130) << name;
    EXPECT_TRUE(contains(run.err, name)) << run.err;
    EXPECT_TRUE(contains(run.out, "\"frames\": 17")) << run.out;
    EXPECT_TRUE(contains(run.out, "\"kind\": \"interrupted\"")) << run.out;
  }
}

/// nohup keeps a tool running when its terminal closes.
TEST(Cli, AnIgnoredSighupStaysIgnored) {
  const auto before = std::signal(SIGHUP, SIG_IGN);
  const ToolRun run = run_with({}, [](Console& console) {
    std::raise(SIGHUP);
    console.stop_if_requested();
    return ExitCode::kOk;
  });
  std::signal(SIGHUP, before);
  EXPECT_EQ(run.code, 0);
}

TEST(Cli, ShowsNoProgressWhereStderrIsNoTerminal) {
  const ToolRun run = run_with({}, [](Console& console) {
    console.progress("measuring", 1, 2);
    return ExitCode::kOk;
  });
  EXPECT_EQ(run.err, "");
}

TEST(Cli, FailedGatesEndWith5AndStandInTheSummary) {
  const ToolRun run = run_with({"--json"}, [](Console& console) {
    Diagnostics diagnostics;
    diagnostics.warn("few_views", "only four views; take more");
    diagnostics.fail("rms_too_high", "RMS 0.9 px, limit 0.5; look at the views");
    console.report(diagnostics);
    return exit_code(diagnostics);
  });
  EXPECT_EQ(run.code, 5);
  EXPECT_EQ(run.err,
            "warning: only four views; take more\nfailure: RMS 0.9 px, limit 0.5; look at the views\n");
  EXPECT_TRUE(contains(run.out, "\"code\": \"rms_too_high\"")) << run.out;
  EXPECT_TRUE(contains(run.out, "\"severity\": \"failure\"")) << run.out;
}

/// As of thirty views: a line a kind with the medians; the view that differs is named, and of warnings every
/// view. Warnings that are not of views stay whole: "k1 of camera" and "k2 of camera" are two matters.
TEST(Cli, SummarisesNotesOfOneKindAndNamesTheOddOnes) {
  const ToolRun run = run_with({"--json"}, [](Console& console) {
    Diagnostics diagnostics;
    for (int i = 0; i < 10; ++i) {
      const std::string subject = "view 'pose " + std::to_string(i) + "', projector: ";
      diagnostics.note("share", subject + std::to_string(i == 7 ? 3.5 : 41.5 + 0.25 * i).substr(0, 4) +
                                    " % of the pixels decoded");
      diagnostics.note("range", subject + "decoded rows " + std::to_string(2 + i % 2) + "..763 of 0..767");
      diagnostics.warn("dark", subject + "too dark by " + std::to_string(i));
      if (i < 3) diagnostics.warn("weak", "k" + std::to_string(i) + " of camera is poorly constrained");
    }
    diagnostics.note("lens", "camera: k3 helps");
    diagnostics.note("lens", "projector: k3 helps");
    diagnostics.note("rows", "two rows");
    console.report(diagnostics);
    return ExitCode::kOk;
  });
  EXPECT_EQ(run.err.rfind(
                "note: 10 views: 42.5 % of the pixels decoded (medians); far from them: view 'pose 7', "
                "projector: 3.50 % of the pixels decoded\n"
                "note: 10 views: decoded rows 3..763 of 0..767 (medians)\n"
                "warning: 10 views (pose 0, pose 1, pose 2, pose 3, pose 4, pose 5, pose 6, pose 7, pose 8, "
                "pose 9): too dark by 5 (medians)\n"
                "warning: k0 of camera is poorly constrained\n"
                "warning: k1 of camera is poorly constrained\n"
                "warning: k2 of camera is poorly constrained\n"
                "note: camera: k3 helps\nnote: projector: k3 helps\nnote: two rows\n",
                0),
            0u)
      << run.err;
  // The summary holds every one.
  EXPECT_TRUE(contains(run.out, "'pose 4', projector: 42.5 % of")) << run.out;
  EXPECT_TRUE(contains(run.out, "'pose 8', projector: decoded rows 2..763")) << run.out;
}

/// Names with digits stay what they are: no line names "view_5" for view_03, view_05 and view_09.
TEST(Cli, TakesNoMedianOfNames) {
  const ToolRun run = run_with({}, [](Console& console) {
    Diagnostics diagnostics;
    for (const char* name : {"view_03", "view_05", "view_09"})
      diagnostics.warn("stale",
                       std::string("view ") + name + ": its light is that of frame_" + (name + 5) + ".png");
    for (const char* term : {"k1", "k2", "k3"}) diagnostics.note("term", std::string(term) + " helps");
    console.report(diagnostics);
    return ExitCode::kOk;
  });
  for (const char* words : {"view_05: its light is that of frame_05.png",
                            "view_09: its light is that of frame_09.png", "note: k1 helps", "note: k3 helps"})
    EXPECT_TRUE(contains(run.err, words)) << run.err;
  EXPECT_FALSE(contains(run.err, "medians")) << run.err;
}

TEST(Cli, TwoDigits) {
  EXPECT_EQ(two_digits(0.00623), "0.0062");
  EXPECT_EQ(two_digits(0.38956), "0.39");
  EXPECT_EQ(two_digits(1.57), "1.6");
  EXPECT_EQ(two_digits(29.31), "29");
  EXPECT_EQ(two_digits(1234.5), "1234");
}

TEST(Summary, WritesNullForWhatIsNotFinite) {
  Summary summary;
  summary.set("/sigma", std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(summary.to_json(), "{\n  \"sigma\": null\n}");
}

TEST(Summary, SurvivesFileNamesThatAreNoUtf8) {
  Summary summary;
  summary.set("/file", "wall\xff.png");
  EXPECT_TRUE(contains(summary.to_json(), "wall\xEF\xBF\xBD.png"));
}

TEST(RenamedOptions, OldSpellingsAreAcceptedWithANote) {
  const CurrentArguments now =
      with_current_names("render-to-image", {"--seconds", "10", "--seconds=0.5", "--fps", "25"});
  EXPECT_EQ(now.arguments, (std::vector<std::string>{"--duration", "10s", "--duration=0.5s", "--fps", "25"}));
  EXPECT_EQ(now.notes.size(), 2u);
}

TEST(RenamedOptions, OnlyOfTheToolThatHadThem) {
  EXPECT_EQ(with_current_names("capture-session", {"--camera", "0"}).arguments,
            (std::vector<std::string>{"--camera", "0"}));
  const CurrentArguments now =
      with_current_names("locate-projector", {"--camera", "left", "--annotate=seen.png"});
  EXPECT_EQ(now.arguments, (std::vector<std::string>{"--camera-name", "left", "--preview=seen.png"}));
  ASSERT_EQ(now.notes.size(), 2u);
  EXPECT_EQ(now.notes[1], "--annotate is now --preview; the old name is accepted for one more version");
}

TEST(RenamedOptions, ReachTheTool) {
  std::string name;
  const char* const arguments[] = {"locate-projector", "--camera", "left"};
  const int code = run_tool(
      3, arguments, {"locate-projector", "Finds a projector."},
      [&](CLI::App& app) { app.add_option("--camera-name", name, "its name"); },
      [](Console&) { return ExitCode::kOk; });
  EXPECT_EQ(code, 0);
  EXPECT_EQ(name, "left");
}

}  // namespace
}  // namespace procam::tools
