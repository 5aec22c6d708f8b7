#pragma once
/// The frame of every report: one page that is complete in itself.
#include <string>

namespace procam::report {

/// A headed section; nothing when there is no content.
std::string section(const std::string& title, const std::string& content);

/// Links to the sections of a text that section() made; nothing for less than four.
std::string table_of_contents(const std::string& sections);

/// A result's JSON text as a block of data that a script or another program finds by the name "result".
std::string data(const std::string& json);

/// The whole document round its body. Its policy lets it load nothing from anywhere.
std::string page(const std::string& title, const std::string& body);

}  // namespace procam::report
