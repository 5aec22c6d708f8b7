#include "common/renamed_options.hpp"

#include <cstring>

namespace procam::tools {
namespace {

struct RenamedOption {
  const char *tool, *before, *now;
  const char* unit = "";  ///< of the old value, which was a number alone
};

/// Remove a row in the version after the one that renamed it (docs/stability.md).
constexpr RenamedOption kRenamedIn0_2[] = {
    {"calibrate-room", "--points", "--save-points"},     {"capture-session", "--watch", "--watch-folder"},
    {"detect-surfaces", "--camera", "--camera-name"},    {"detect-surfaces", "--sensor", "--sensor-model"},
    {"export-warp", "--blend", "--blend-with"},          {"procam-convert", "--to", "--format"},
    {"render-to-image", "--blend", "--blend-with"},      {"locate-projector", "--annotate", "--preview"},
    {"locate-projector", "--camera", "--camera-name"},   {"plan-projection", "--viewer", "--viewer-distance"},
    {"predict-error", "--predict", "--with-prediction"}, {"render-to-image", "--seconds", "--duration", "s"},
    {"scan-surfaces", "--depth", "--save-depth"},        {"scan-surfaces", "--points", "--save-points"},
    {"simulate-captures", "--check", "--check-board"},   {"simulate-captures", "--markers", "--marker-view"},
    {"verify-projection", "--camera", "--camera-name"},  {"verify-projection", "--picture", "--preview"},
};

const RenamedOption* find_renamed(const std::string& tool, const std::string& name) {
  for (const RenamedOption& option : kRenamedIn0_2)
    if (tool == option.tool && name == option.before) return &option;
  return nullptr;
}

/// "10" with its unit; a value that has one is left alone.
std::string with_unit(const std::string& value, const char* unit) {
  return !value.empty() && std::strchr("0123456789.", value.back()) != nullptr ? value + unit : value;
}

}  // namespace

CurrentArguments with_current_names(const std::string& tool, const std::vector<std::string>& arguments) {
  CurrentArguments out;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    const std::size_t equals = argument.find('=');
    const RenamedOption* const option = find_renamed(tool, argument.substr(0, equals));
    if (option == nullptr) {
      out.arguments.push_back(argument);
      continue;
    }
    out.notes.push_back(std::string(option->before) + " is now " + option->now +
                        "; the old name is accepted for one more version");
    if (equals != std::string::npos) {
      out.arguments.push_back(option->now + ("=" + with_unit(argument.substr(equals + 1), option->unit)));
      continue;
    }
    out.arguments.push_back(option->now);
    if (*option->unit != '\0' && i + 1 < arguments.size())
      out.arguments.push_back(with_unit(arguments[++i], option->unit));
  }
  return out;
}

}  // namespace procam::tools
