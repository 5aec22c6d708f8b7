#pragma once
/// The true error of two shows over time, as an SVG picture.
#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "procam/io/files.hpp"

namespace procam::examples {

struct ErrorPlot {
  std::string without, with;  ///< names of the two lines
  std::vector<double> time;   ///< seconds
  std::vector<double> without_mm, with_mm;
  std::vector<std::pair<double, std::string>> events;  ///< upright lines with words
  std::string heading = "true error of the light, mm RMS";

  void add(double at, double error_without, double error_with) {
    time.push_back(at);
    without_mm.push_back(1e3 * error_without);
    with_mm.push_back(1e3 * error_with);
  }

  void save(const std::filesystem::path& file) const {
    constexpr double kWidth = 860, kHeight = 300, kLeft = 56, kTop = 40, kRight = 16, kBottom = 44;
    double top = 1;
    for (const std::vector<double>* line : {&without_mm, &with_mm})
      for (const double mm : *line) top = std::max(top, 1.1 * mm);
    const double end = time.back();
    const auto number = [](double value) {
      char text[24];
      std::snprintf(text, sizeof text, "%.1f", value);
      return std::string(text);
    };
    const auto x = [&](double t) { return number(kLeft + (kWidth - kLeft - kRight) * t / end); };
    const auto y = [&](double mm) {
      return number(kHeight - kBottom - (kHeight - kTop - kBottom) * mm / top);
    };
    std::string svg =
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 860 300\" font-family=\"sans-serif\" "
        "font-size=\"13\">\n<rect width=\"860\" height=\"300\" fill=\"#ffffff\"/>\n";
    double step = 1;
    while (top / step > 8) step *= step == 1 || step == 10 ? 2 : step == 2 || step == 20 ? 2.5 : 2;
    for (double mm = 0; mm <= top; mm += step)
      svg += "<path d=\"M" + x(0) + " " + y(mm) + "H" + x(end) +
             "\" stroke=\"#00000022\"/><text x=\"48\" y=\"" + y(mm - 0.014 * top) +
             "\" text-anchor=\"end\">" + std::to_string(int(mm)) + "</text>\n";
    for (int t = 0; t <= int(end); t += end > 12 ? 5 : 1)
      svg += "<text x=\"" + x(t) + "\" y=\"274\" text-anchor=\"middle\">" + std::to_string(t) + "</text>\n";
    for (const auto& [at, words] : events)
      svg += "<path d=\"M" + x(at) + " " + y(0) + "V" + y(top) +
             "\" stroke=\"#888888\" stroke-dasharray=\"3 3\"/><text x=\"" + x(at + 0.005 * end) +
             "\" y=\"54\" fill=\"#666666\">" + words + "</text>\n";
    svg += line(without_mm, "#b8442f", x, y) + line(with_mm, "#1f5fa8", x, y);
    svg += "<text x=\"16\" y=\"16\">" + heading + "</text><text x=\"56\" y=\"294\">time, s</text>\n";
    svg += legend(330, "#b8442f", without) + legend(600, "#1f5fa8", with) + "</svg>\n";
    io::write_file_atomically(file, svg);
  }

 private:
  template <typename X, typename Y>
  std::string line(const std::vector<double>& mm, const std::string& colour, const X& x, const Y& y) const {
    std::string points;
    for (std::size_t i = 0; i < mm.size(); ++i) points += x(time[i]) + "," + y(mm[i]) + " ";
    return "<polyline points=\"" + points + "\" fill=\"none\" stroke=\"" + colour +
           "\" stroke-width=\"1.8\"/>\n";
  }
  static std::string legend(int at, const std::string& colour, const std::string& words) {
    const std::string left = std::to_string(at), right = std::to_string(at + 28);
    return "<path d=\"M" + left + " 12h22\" stroke=\"" + colour + "\" stroke-width=\"2\"/><text x=\"" +
           right + "\" y=\"16\">" + words + "</text>\n";
  }
};

}  // namespace procam::examples
