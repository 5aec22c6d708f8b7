#include <algorithm>
#include <array>
#include <cmath>

#include "html.hpp"
#include "pictures.hpp"

namespace procam::report {
namespace {

constexpr int kBinsPerSigma = 4, kSigmas = 4, kBins = 2 * kSigmas * kBinsPerSigma;
constexpr double kHistogramWidth = 480, kHistogramHeight = 200;

/// Coordinates of whitened residuals; the outermost bins hold everything beyond them.
struct Histogram {
  std::array<int, kBins> used{}, rejected{};
  int count = 0, beyond_3 = 0;
  double squares = 0;
};

Histogram histogram_of(const calibrate::CalibrationResult& result, int device) {
  Histogram histogram;
  for (const calibrate::Residual& r : result.residuals) {
    if (r.device != device || !r.whitened.allFinite() || r.whitened.isZero()) continue;
    for (const double sigmas : {r.whitened.x(), r.whitened.y()}) {
      const double limited = std::clamp(sigmas, -double(kSigmas), double(kSigmas));
      const int bin = std::min(int((limited + kSigmas) * kBinsPerSigma), kBins - 1);
      ++(r.used ? histogram.used : histogram.rejected)[std::size_t(bin)];
      if (!r.used) continue;
      ++histogram.count;
      histogram.squares += sigmas * sigmas;
      histogram.beyond_3 += std::abs(sigmas) > 3;
    }
  }
  return histogram;
}

double normal_density(double sigmas) {
  return std::exp(-0.5 * sigmas * sigmas) / std::sqrt(2 * kPi);
}

}  // namespace

std::string residual_histogram(const calibrate::CalibrationResult& result, int device) {
  const Histogram histogram = histogram_of(result, device);
  if (histogram.count == 0) return "";
  const double in_bin = double(histogram.count) / kBinsPerSigma;  // times the density
  double top = in_bin * normal_density(0);
  for (std::size_t b = 0; b < kBins; ++b)
    top = std::max(top, double(histogram.used[b] + histogram.rejected[b]));
  const double bin_width = kHistogramWidth / kBins, unit = kHistogramHeight / (1.05 * top);
  std::string content;
  const auto bar = [&](std::size_t bin, double from, double count, const std::string& attributes) {
    if (count <= 0) return;
    content += element("path",
                       attributes + " fill=\"currentColor\" d=\"M" +
                           position(Vec2(double(bin) * bin_width + 1, kHistogramHeight - unit * from)) + "v" +
                           coordinate(-unit * count) + "h" + coordinate(bin_width - 2) + "v" +
                           coordinate(unit * count) + "Z\"",
                       element("title", "", fixed(count, 0)));
  };
  for (std::size_t b = 0; b < kBins; ++b) {
    bar(b, 0, histogram.used[b], "class=\"rms\"");
    bar(b, histogram.used[b], histogram.rejected[b], "class=\"rms bad\"");
  }
  std::string curve;
  for (int i = 0; i <= 4 * kBins; ++i) {
    const double sigmas = 2.0 * kSigmas * i / (4 * kBins) - kSigmas;
    curve += (i == 0 ? "M" : "L") +
             position(Vec2(i * bin_width / 4, kHistogramHeight - unit * in_bin * normal_density(sigmas)));
  }
  content +=
      element("path", "class=\"principal\" d=\"" + curve + "\"", element("title", "", "normal distribution"));
  Marks axis;
  axis.line(Vec2(0, kHistogramHeight), Vec2(kHistogramWidth, kHistogramHeight));
  content += axis.path("class=\"bar\"");
  for (int s = -kSigmas; s <= kSigmas; ++s)
    content += label(Vec2(kHistogramWidth * (s + kSigmas) / (2.0 * kSigmas), kHistogramHeight + 15),
                     "class=\"tick\" text-anchor=\"middle\"", s == 0 ? "0" : std::to_string(s) + " σ");
  const std::string& name = result.devices[std::size_t(device)].name;
  return figure(svg(box(Vec2(-14, -6), Vec2(kHistogramWidth + 28, kHistogramHeight + 28)),
                    "Histogram of residuals of " + name, content),
                element("b", "", escaped(name)) +
                    ": residuals over their standard deviation, x and y, with the normal curve. "
                    "Standard deviation " +
                    fixed(std::sqrt(histogram.squares / histogram.count), 2) +
                    " (expected: 1 or a little less); " +
                    fixed(100.0 * histogram.beyond_3 / histogram.count, 2) +
                    " % beyond 3 σ (normal: 0.27 %). Red: rejected; the outermost "
                    "bars hold everything beyond them.");
}

}  // namespace procam::report
