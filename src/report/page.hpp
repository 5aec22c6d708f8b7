#pragma once
/// The frame of every report: one page that is complete in itself.
#include <string>

namespace procam::report {

/// A headed section; nothing when there is no content.
std::string section(const std::string& title, const std::string& content);

/// The whole document round its body. Its policy lets it load nothing from anywhere.
std::string page(const std::string& title, const std::string& body);

}  // namespace procam::report
