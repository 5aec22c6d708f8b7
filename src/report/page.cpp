#include "page.hpp"

#include "html.hpp"
#include "style.hpp"

namespace procam::report {
namespace {

std::string head(const std::string& title) {
  // The policy makes the browser itself hold the page to its word: nothing is loaded from anywhere.
  return "<meta charset=\"utf-8\">\n"
         "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
         "'unsafe-inline'; "
         "script-src 'unsafe-inline'; img-src data:\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n" +
         element("title", "", escaped(title)) + "\n" + element("style", "", kReportStyle) + "\n";
}

/// A section's name in links: "s-" and the title's letters and digits, the rest as "-".
std::string anchor(const std::string& title) {
  std::string name = "s";
  for (const char c : title) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    const bool capital = c >= 'A' && c <= 'Z';
    if (plain || capital) {
      if (name == "s") name += '-';
      name += capital ? char(c - 'A' + 'a') : c;
    } else if (name.back() != '-') {
      name += '-';
    }
  }
  return name;
}

}  // namespace

std::string section(const std::string& title, const std::string& content) {
  if (content.empty()) return "";
  return element("section", "id=\"" + anchor(title) + "\"",
                 "\n" + element("h2", "", title) + "\n" + content) +
         "\n";
}

std::string table_of_contents(const std::string& sections) {
  constexpr int kManySections = 4;
  const std::string open = "<section id=\"", title = "\">\n<h2>";
  std::string links;
  int count = 0;
  for (std::size_t at = sections.find(open); at != std::string::npos; at = sections.find(open, at + 1)) {
    const std::size_t name = at + open.size(), name_end = sections.find(title, name),
                      begin = name_end + title.size(), end = sections.find("</h2>", begin);
    if (name_end == std::string::npos || end == std::string::npos) break;
    links += element("a", "href=\"#" + sections.substr(name, name_end - name) + "\"",
                     sections.substr(begin, end - begin)) +
             "\n";
    ++count;
  }
  if (count < kManySections) return "";
  return element("nav", "class=\"contents\" aria-label=\"Contents\"", "\n" + links) + "\n";
}

std::string data(const std::string& json) {
  std::string text;
  for (const char c : json) {
    // No tag may end the block, whatever names the result holds.
    if (c == '<')
      text += "\\u003c";
    else
      text += c;
  }
  return element("script", "type=\"application/json\" id=\"result\"", "\n" + text + "\n") + "\n";
}

std::string page(const std::string& title, const std::string& body) {
  return "<!doctype html>\n" +
         element("html", "lang=\"en\"",
                 "\n" + element("head", "", "\n" + head(title)) + "\n" + element("body", "", "\n" + body) +
                     "\n") +
         "\n";
}

}  // namespace procam::report
