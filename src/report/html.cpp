#include "html.hpp"

#include <algorithm>
#include <cmath>

namespace procam::report {
std::string escaped(const std::string& text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  return out;
}

std::string pixels(double value) {
  return std::abs(value) >= 0.001 || value == 0 ? fixed(value, 3) : significant(value, 2);
}

int decimals_for(double sigma, int otherwise) {
  if (!std::isfinite(sigma) || sigma <= 0) return otherwise;
  return std::clamp(1 - int(std::floor(std::log10(sigma))), 0, 9);
}

double round_step(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  const double lead = value / power;
  return power * (lead >= 5 ? 5 : lead >= 2 ? 2 : 1);
}

std::string element(const std::string& name, const std::string& attributes, const std::string& content) {
  return "<" + name + (attributes.empty() ? "" : " " + attributes) + ">" + content + "</" + name + ">";
}

std::string coordinate(double value) {
  std::string text = fixed(value, 1);
  if (text.size() > 2 && text.compare(text.size() - 2, 2, ".0") == 0) text.resize(text.size() - 2);
  return text;
}

std::string position(const Vec2& point) {
  return coordinate(point.x()) + " " + coordinate(point.y());
}

std::string Marks::path(const std::string& attributes, const std::string& tip) const {
  if (d.empty()) return "";
  const std::string open = "<path " + attributes + " d=\"" + d + "\"";
  return tip.empty() ? open + "/>\n" : open + ">" + element("title", "", escaped(tip)) + "</path>\n";
}

std::string label(const Vec2& at, const std::string& attributes, const std::string& words) {
  return element("text",
                 "x=\"" + coordinate(at.x()) + "\" y=\"" + coordinate(at.y()) + "\"" +
                     (attributes.empty() ? "" : " " + attributes),
                 escaped(words));
}

std::string figure(const std::string& svg, const std::string& caption, const std::string& attributes) {
  return element("figure", attributes, "\n" + svg + element("figcaption", "", caption)) + "\n";
}

std::string svg(const std::string& view_box, const std::string& description, const std::string& content) {
  return element("svg",
                 "viewBox=\"" + view_box + "\" role=\"img\" aria-label=\"" + escaped(description) + "\"",
                 "\n" + content) +
         "\n";
}

std::string box(const Vec2& corner, const Vec2& size) {
  return position(corner) + " " + position(size);
}

std::string rectangle(const std::string& attributes, const Vec2& corner, const Vec2& size) {
  return "<rect " + attributes + " x=\"" + coordinate(corner.x()) + "\" y=\"" + coordinate(corner.y()) +
         "\" width=\"" + coordinate(size.x()) + "\" height=\"" + coordinate(size.y()) + "\"/>\n";
}

std::string circle(const std::string& attributes, const Vec2& at, double radius) {
  return "<circle " + attributes + " cx=\"" + coordinate(at.x()) + "\" cy=\"" + coordinate(at.y()) +
         "\" r=\"" + coordinate(radius) + "\"/>\n";
}

}  // namespace procam::report
