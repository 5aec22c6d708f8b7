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
         "script-src 'unsafe-inline'\">\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n" +
         element("title", "", escaped(title)) + "\n" + element("style", "", kReportStyle) + "\n";
}

}  // namespace

std::string section(const std::string& title, const std::string& content) {
  if (content.empty()) return "";
  return element("section", "", "\n" + element("h2", "", title) + "\n" + content) + "\n";
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
