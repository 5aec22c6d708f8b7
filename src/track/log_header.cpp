#include "log_header.hpp"

#include <nlohmann/json.hpp>

#include "procam/core/base/limits.hpp"
#include "procam/track/detail/json_depth.hpp"

namespace procam::track {

std::string internal::log_header_fault(std::string_view line, std::string_view format) {
  using nlohmann::json;
  constexpr int kDeepest = 8;
  const bool fits = line.size() <= limits::kMessageBytes && is_shallow(line, kDeepest);
  const json header = fits ? json::parse(line.begin(), line.end(), nullptr, false) : json();
  if (!header.is_object()) return "its first line is not a JSON object";
  const auto name = header.find("format"), version = header.find("version");
  if (name == header.end() || !name->is_string()) return "its first line has no \"format\"";
  if (const auto& text = name->get_ref<const std::string&>(); text != format)
    // Of an unknown file: only its beginning, without control characters.
    return "its format is " + json(text.substr(0, 40)).dump(-1, ' ', true, json::error_handler_t::replace) +
           ", not \"" + std::string(format) + "\"";
  if (version == header.end()) return "its first line has no \"version\"";
  if (!version->is_number() || *version != 1) return "its version is not 1, the only one that is read";
  return {};
}

}  // namespace procam::track
