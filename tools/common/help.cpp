#include "common/help.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <sstream>

#include "procam/core/base/detail/edit_distance.hpp"

namespace procam::tools {
namespace {

constexpr std::size_t kColumn = 30;  ///< where explanations begin
constexpr std::size_t kMinWidth = 60, kMaxWidth = 120, kUsualWidth = 100;

struct ValueType {
  const char* type;
  const char* options;  ///< their names without "--", with blanks around; "tool:option" where tools differ
};

struct OptionGroup {
  const char *tool, *title;
  const char* options;  ///< as of ValueType
};

/// Of tools with many options that do not declare their groups (declare_group()).
constexpr OptionGroup kGroups[] = {
    {"project-live", "Rig and surfaces", " rig "},
    {"project-live", "Display and timing", " list-displays identify "},
    {"project-live", "Running", " replay save-show "},
    {"simulate-robot", "Drive", " path speed duration seed "},
    {"simulate-robot", "Messages", " to binary frame child covariance twist gyro no-stamp "},
    {"simulate-robot", "Localiser and network",
     " rate noise delay jitter loss reorder duplicate garbage clock-offset clock-drift "},
    {"simulate-robot", "Truth", " truth sightings see "},
    {"render-to-image", "Input", " rig surfaces content fit crop "},
    {"render-to-image", "Several frames", " time duration fps "},
    {"render-to-image", "Virtual objects", " viewer virtual "},
    {"render-to-image", "Light", " blend-with brightness black compensate one-level reflectance gamma "},
    {"render-to-image", "Drawing", " threads renderer average-numbers "},
    {"predict-error", "Input", " rig surfaces pose projector "},
    {"predict-error", "Errors of pose and map", " pose-sigma map-sigma whole-pixels "},
    {"predict-error", "Motion", " speed speed-sigma forward up delay delay-sigma with-prediction "},
    {"predict-error", "Monte Carlo", " monte-carlo seed shard draws "},
    {"calibrate-mount", "Input", " base arm pan-tilt child rig-frame sightings noise "},
    {"calibrate-mount", "Images of the rig",
     " images rig camera-name dictionary marker-size light pattern projector depth depth-camera intrinsics depth-scale sensor-model "},
    {"calibrate-mount", "Known values",
     " stations height floor plane-sensor-sigma prior prior-sigma markers motion time-offset same-clock "},
    {"scan-surfaces", "Input", " captures rig view pattern projector-size step "},
    {"scan-surfaces", "Surface", " deviation nearest farthest viewer "},
    {"scan-surfaces", "Several stations", " station-pose pose-sigma keep-poses max-move max-turn "},
    {"scan-surfaces", "Checks", " truth "},
    {"calibrate-room", "Input", " captures pattern projector-size step "},
    {"calibrate-room", "Lenses", " known-camera lens-sigma throw-ratio lens-shift "},
    {"calibrate-room", "Scale", " distance marker board "},
    {"calibrate-room", "Calibration", " points-per-view truth "},
};

// A flag that another tool has with another type stands first, with that tool's name.
constexpr ValueType kValueTypes[] = {
    {"FOLDER",
     " simulate-captures:output capture-session:output make-patterns:output calibrate-camera:images calibrate-mount:depth calibrate-mount:images calibrate-mount:light simulate-robot:save-depth simulate-robot:save-light "},
    {"FILE", " section_v:measured section_v:corners "},
    {"{opencv,opencv-stereo,ros,kalibr,mrcal,colmap,urdf,sdf,gltf,procam}", " format "},
    {"{markers,planes,both}", " simulate-robot:see "},
    {"LENGTH+-LENGTH", " calibrate-mount:height calibrate-mount:floor "},
    {"MOTION", " motion "},
    {"DICTIONARY", " dictionary "},
    {"ROOM", " simulate-captures:room "},
    {"BOARD", " simulate-captures:check-board "},
    {"LENGTH", " plan-projection:viewer-distance "},
    {"FILE",
     " align-maps:map arm base blend-with check compare depth draws image into intrinsics known-camera markers mount observations output pan-tilt points pose prior "
     "preview record replay report rig save-board save-depth save-draws save-markers save-points save-poses save-mount save-show show shown sightings station-pose surfaces truth update video virtual watch-markers watch-save weights "
     "write-moved write-observations sensor mirror-view INPUT "},
    {"FOLDER", " captures data dds-security decoded figures images project watch-folder "},
    {"LENGTH",
     " accept depth-scale deviation distance far farthest focal-length measured marker-size max-move mirror-depth near nearest scale text-height unit wall "},
    {"ANGLE", " bump max-turn pitch roll yaw "},
    {"ANGLE,...", " angles "},
    {"LENGTH,...", " distances "},
    {"TIME",
     " blank-on-stale camera-delay clock-offset delay delay-sigma depth-delay duration freeze-on-stale hold interval "
     "jitter latency sensor-delay source-delay time time-offset track-delay track-readout watch-delay watch-pose-time "},
    {"WxH", " camera-size grid projector-size resolution size target "},
    {"BOARD", " board mirror-board "},
    {"MARKER", " marker "},
    {"NAME",
     " camera-name child depth-camera device fleet frame group marker-camera-name projector rig-frame robot surface "
     "track-camera-name view watch-name "},
    {"SHARE,ANGLE", " plane-sensor-sigma "},
    {"SHARE", " duplicate garbage lens-sigma loss reorder "},
    {"SURFACE=VALUE", " content crop fit reflectance track track-hinge "},
    {"PROJECTOR", " blend "},
    {"PROJECTOR=DISPLAY", " screen "},
    {"PROJECTOR=NUMBER", " black brightness "},
    {"X,Y,Z", " forward gravity target-at up viewer "},
    {"LENGTH,ANGLE",
     " map-sigma marker-sigma noise pose-sigma prior-sigma sigma-bump surface-sigma watch-pose "},
    {"SPEED", " speed speed-sigma "},
    {"ADDRESS", " control people people-to pose-source publish to "},
    {"CAMERA", " camera marker-camera track-camera watch "},
    {"DISPLAY", " display "},
    {"PAPER", " paper "},
    {"PATTERN", " pattern "},
    {"LENS", " camera-model projector-model "},
    {"{easy,paper,hard}", " level "},
    {"AXIS", " world-up "},
    {"{unity,unreal,godot,blender,splash,sgct,opengl}", " for "},
    {"PROFILE", " profile "},
    {"CHANGE", " changed "},
    {"RULE", " predict "},
    {"KEY=VALUE", " set "},
    {"TOKEN", " token "},
    {"PATH", " path "},
    {"SHIFT", " lens-shift "},
    {"K/N", " shard "},
    {"RATIO", " throw-ratio zoom "},
};

/// Files that a tool writes beside its one result.
constexpr const char* kResults =
    " data figures json output preview record report save-board save-depth save-draws save-light save-markers save-mount save-points save-poses save-show video watch-save weights write-moved write-observations ";

bool is_listed(const char* list, const std::string& name) {
  return std::string(list).find(" " + name + " ") != std::string::npos;
}

/// "rig" of --rig; of a positional argument its own.
std::string name_of(const CLI::Option& option) {
  return option.get_lnames().empty() ? option.get_name(true) : option.get_lnames().front();
}

const char* type_of(const std::string& tool, const std::string& option) {
  for (const std::string& name : {tool + ":" + option, option})
    for (const ValueType& entry : kValueTypes)
      if (is_listed(entry.options, name)) return entry.type;
  return nullptr;
}

/// CLI11 writes the names after "needs:" and "not with:" in the order of addresses, which may differ from run to run.
std::string with_sorted_names(const std::string& text) {
  std::istringstream words(text);
  std::vector<std::string> names;
  std::string sorted, word;
  const auto flush = [&] {
    std::sort(names.begin(), names.end());
    for (const std::string& name : names) sorted += " " + name;
    names.clear();
  };
  while (words >> word) {
    if (word.rfind("--", 0) == 0) {
      names.push_back(word);
      continue;
    }
    flush();
    sorted += " " + word;
  }
  flush();
  return sorted;
}

std::size_t terminal_width() {
  winsize size = {};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0)
    return std::clamp<std::size_t>(size.ws_col, kMinWidth, kMaxWidth);
  const char* const columns = std::getenv("COLUMNS");
  const int stated = columns != nullptr ? std::atoi(columns) : 0;
  return stated > 0 ? std::clamp<std::size_t>(std::size_t(stated), kMinWidth, kMaxWidth) : kUsualWidth;
}

class WrappedHelp : public CLI::Formatter {
 public:
  WrappedHelp() {
    column_width(kColumn);
    label("REQUIRED", "(required)");
    label("Needs", "needs");
    label("Excludes", "not with");
  }

  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    const std::string left = "  " + make_option_name(option, is_positional) +
                             in_words(with_sorted_names(make_option_opts(option)));
    const std::string right = make_option_desc(option);
    if (right.empty()) return left + "\n";
    const bool is_beside = left.size() + 2 <= kColumn;
    return left + (is_beside ? std::string(kColumn - left.size(), ' ') : "\n" + std::string(kColumn, ' ')) +
           wrapped(right, width_, kColumn, kColumn) + "\n";
  }

  /// As CLI11's, but for the order of the groups. No tool has subcommands.
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode) const override {
    return make_description(app) + make_usage(app, std::move(name)) + make_positionals(app) + groups_of(app) +
           "\n" + make_footer(app);
  }

  std::string make_description(const CLI::App* app) const override {
    return wrapped(app->get_description(), width_, 0, 0) + "\n";
  }

 private:
  /// The tool's own options first, then its results, then what all tools have.
  std::string groups_of(const CLI::App* app) const {
    std::vector<std::string> groups = app->get_groups();
    const auto rank = [](const std::string& group) {
      return group == "General" ? 2 : group == "Results" ? 1 : 0;
    };
    std::stable_sort(groups.begin(), groups.end(),
                     [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
    std::string text;
    for (const std::string& group : groups) {
      const std::vector<const CLI::Option*> options = app->get_options(
          [&](const CLI::Option* option) { return option->get_group() == group && option->nonpositional(); });
      if (!group.empty() && !options.empty()) text += make_group(group, false, options);
    }
    return text;
  }

  /// Numbers and choices as people call them: "INT:INT in [2 - 64]" is "INTEGER in [2 - 64]".
  static std::string in_words(std::string text) {
    constexpr std::array<std::array<const char*, 2>, 8> kWords{{{"TEXT:{", "{"},
                                                                {"UINT:", ""},
                                                                {"INT:", ""},
                                                                {"FLOAT:", ""},
                                                                {"UINT", "INTEGER"},
                                                                {" INT", " INTEGER"},
                                                                {"INTEGEREGER", "INTEGER"},
                                                                {"FLOAT", "NUMBER"}}};
    for (const auto& [word, instead] : kWords)
      for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos;) {
        text.replace(at, std::string(word).size(), instead);
        at += std::string(instead).size();
      }
    return text;
  }

  const std::size_t width_ = terminal_width();
};

}  // namespace

std::string wrapped(const std::string& text, std::size_t width, std::size_t indent, std::size_t used) {
  std::string result;
  for (std::size_t at = 0; at < text.size();) {
    if (text[at] == '\n') {
      result += '\n';
      used = 0;
      ++at;
      // A command stays one line, so that it can be copied.
      const std::size_t line_end = std::min(text.find('\n', at), text.size());
      if (text.compare(at, 2, "  ") != 0) {
        result += std::string(indent, ' ');
        used = indent;
      } else {
        result.append(text, at, line_end - at);
        at = line_end;
      }
      continue;
    }
    const std::size_t end = std::min(text.find_first_of(" \n", at), text.size());
    const std::string word = text.substr(at, end - at);
    const bool begins_line = result.empty() || result.back() == '\n' || result.back() == ' ';
    if (!begins_line && used + 1 + word.size() > width) {
      result += "\n" + std::string(indent, ' ');
      used = indent;
    } else if (!begins_line) {
      result += ' ';
      ++used;
    }
    result += word;
    used += word.size();
    at = end < text.size() && text[end] == ' ' ? end + 1 : end;
  }
  return result;
}

void declare_group(CLI::App& app, const std::string& title, const std::function<void()>& declare) {
  const std::vector<CLI::Option*> before = app.get_options();
  declare();
  for (CLI::Option* option : app.get_options())
    if (std::find(before.begin(), before.end(), option) == before.end()) option->group(title);
}

void arrange_help(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    const std::string name = name_of(*option);
    for (const OptionGroup& group : kGroups)
      if (app.get_name() == group.tool && is_listed(group.options, name)) option->group(group.title);
    if (name == "help" || name == "version")
      option->group("General");
    else if (is_listed(kResults, name))
      option->group("Results");
    // Choices are listed by their validator.
    const char* const type = type_of(app.get_name(), name);
    if (type != nullptr && option->get_type_name() == "TEXT") option->type_name(type);
  }
  app.formatter(std::make_shared<WrappedHelp>());
}

std::vector<std::string> named_files(const CLI::App& app, NamedFiles which) {
  std::vector<std::string> files;
  for (const CLI::Option* option : app.get_options()) {
    const std::string type = option->get_type_name();
    const bool is_result = option->get_group() == "Results";
    if (is_result != (which == NamedFiles::kResults) || (type != "FILE" && type != "FOLDER")) continue;
    for (const std::string& file : option->results()) files.push_back(file);
  }
  return files;
}

std::string nearest_option(const CLI::App& app, const std::string& typed) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back(name);
  const std::size_t begin = typed.find_first_not_of('-');
  if (begin == 0 || begin == std::string::npos) return "";
  // Dashes, which all options have, would make short names alike.
  const std::string nearest = internal::nearest_name(typed.substr(begin, typed.find('=') - begin), names);
  return nearest.empty() ? "" : "--" + nearest;
}

}  // namespace procam::tools
