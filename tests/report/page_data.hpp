#pragma once
/// The data that a page carries, read back.
#include <nlohmann/json.hpp>
#include <string>

namespace procam::test {

inline nlohmann::json page_data(const std::string& page) {
  const std::string open = "<script type=\"application/json\" id=\"result\">";
  const std::size_t begin = page.find(open), end = page.find("</script>", begin);
  if (begin == std::string::npos || end == std::string::npos) return {};
  return nlohmann::json::parse(page.substr(begin + open.size(), end - begin - open.size()));
}

}  // namespace procam::test
