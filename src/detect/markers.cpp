#include "procam/detect/markers.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/aruco.hpp>

#include "marker_finder.hpp"

namespace procam::detect {
namespace {

/// An edge that fits worse than this share of its contrast is covered in part, or is none.
constexpr double kWorstShare = 0.15;
/// The same, where the windows still stand a pixel beside the edges.
constexpr double kWorstFirstShare = 0.35;
/// Beyond this many blurs from an edge, erf is flat to 1e-3.
constexpr double kReachInBlurs = 3.5;

cv::Ptr<cv::aruco::Dictionary> as_opencv(const MarkerCodes& codes) {
  cv::Mat bytes;
  for (const std::string& code : codes.codes) {
    require(int(code.size()) == codes.bits * codes.bits, "MarkerCodes: a code is no square of bits");
    cv::Mat bits(codes.bits, codes.bits, CV_8U);
    for (std::size_t i = 0; i < code.size(); ++i)
      bits.at<unsigned char>(int(i) / codes.bits, int(i) % codes.bits) = code[i] == '1' ? 1 : 0;
    bytes.push_back(cv::aruco::Dictionary::getByteListFromBits(bits));
  }
  return cv::makePtr<cv::aruco::Dictionary>(bytes, codes.bits, codes.correctable_bits);
}

double shortest_side(const std::array<Vec2, 4>& corners) {
  double shortest = 1e9;
  for (std::size_t i = 0; i < 4; ++i)
    shortest = std::min(shortest, (corners[(i + 1) % 4] - corners[i]).norm());
  return shortest;
}

}  // namespace

MarkerCodes marker_codes(MarkerDictionary dictionary) {
  // The enumeration keeps OpenCV's order.
  const cv::Ptr<cv::aruco::Dictionary> theirs = cv::aruco::Dictionary::get(int(dictionary));
  MarkerCodes codes{theirs->markerSize, theirs->maxCorrectionBits, {}};
  for (int id = 0; id < theirs->bytesList.rows; ++id) {
    const cv::Mat bits =
        cv::aruco::Dictionary::getBitsFromByteList(theirs->bytesList.rowRange(id, id + 1), codes.bits);
    std::string& code = codes.codes.emplace_back();
    for (int y = 0; y < codes.bits; ++y)
      for (int x = 0; x < codes.bits; ++x) code += bits.at<unsigned char>(y, x) != 0 ? '1' : '0';
    // OpenCV has AprilTags upside down against the pictures that their authors publish and people print.
    if (dictionary >= MarkerDictionary::kAprilTag16h5) std::reverse(code.begin(), code.end());
  }
  return codes;
}

std::vector<FoundMarker> find_markers(const ViewU8& image, const MarkerCodes& codes) {
  const cv::Mat pixels(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
                       std::size_t(image.stride));
  auto parameters = cv::aruco::DetectorParameters::create();
  // Modules of two pixels can be read, however large the picture is.
  const double smallest_perimeter = 4 * 2.0 * (codes.bits + 2);
  parameters->minMarkerPerimeterRate =
      std::min(0.03, smallest_perimeter / std::max(image.width, image.height));
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(pixels, as_opencv(codes), corners, ids, parameters);
  std::vector<FoundMarker> found;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    FoundMarker& marker = found.emplace_back();
    marker.id = ids[i];
    for (std::size_t c = 0; c < 4; ++c) marker.corners[c] = Vec2(corners[i][c].x, corners[i][c].y);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const FoundMarker& a, const FoundMarker& b) { return a.id < b.id; });
  return found;
}

std::optional<RefinedMarker> refine_marker(const ViewU8& image, const FoundMarker& found,
                                           const EdgeSurroundings& around, double max_sigma_px) {
  RefinedMarker refined;
  Marker& marker = refined.marker;
  marker.id = found.id;
  marker.corners = found.corners;
  // Each round places the windows by the last one's corners, as wide as its edges are blurred: farther away a
  // pixel says nothing about the edge, and light that changes over the window would move it.
  double reach = 1e9;
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    const double worst = round + 1 < kRounds ? kWorstFirstShare : kWorstShare;
    const double module = shortest_side(marker.corners) / around.modules;
    std::array<EdgeFit, 4> edges;
    for (std::size_t i = 0; i < 4; ++i) {
      EdgeGuess guess;
      guess.from = marker.corners[i];
      guess.to = marker.corners[(i + 1) % 4];
      guess.bend = around.bends[i];
      guess.trim = std::max(0.5 * module, 1.5);
      guess.inside = std::clamp(around.inside * module, 1.5, reach);
      guess.outside = std::clamp(around.outside * module, 1.5, reach);
      const auto fit = fit_edge(image, guess);
      if (!fit || fit->residual > worst * fit->contrast) return std::nullopt;
      edges[i] = *fit;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      const auto corner = crossing(edges[(i + 3) % 4], edges[i], marker.corners[i]);
      if (!corner || !((corner->point - found.corners[i]).norm() < std::max(1.0 * module, 3.0)))
        return std::nullopt;
      marker.corners[i] = corner->point;
      marker.covariance[i] = corner->covariance;
    }
    double blur = 0;
    refined.residual = 0;
    for (const EdgeFit& edge : edges) {
      blur = std::max(blur, edge.blur);
      refined.residual = std::max(refined.residual, edge.residual);
    }
    reach = std::max(kReachInBlurs * blur, 2.5);
  }
  for (const Mat2& covariance : marker.covariance)
    if (!(covariance.determinant() > 0) || std::sqrt(covariance.trace() / 2) > max_sigma_px)
      return std::nullopt;
  return refined;
}

std::vector<Marker> detect_markers(const ViewU8& image, const MarkerCodes& codes,
                                   const MarkerOptions& options) {
  require(!image.empty() && image.channels == 1, "detect_markers: needs an image with one channel");
  EdgeSurroundings around;
  around.modules = codes.bits + 2;
  around.inside = around.outside = options.window_modules;
  std::vector<Marker> markers;
  for (const FoundMarker& found : find_markers(image, codes))
    if (const auto refined = refine_marker(image, found, around, options.max_sigma_px))
      markers.push_back(refined->marker);
  return markers;
}

std::vector<Marker> detect_markers(const ViewU8& image, MarkerDictionary dictionary,
                                   const MarkerOptions& options) {
  return detect_markers(image, marker_codes(dictionary), options);
}

}  // namespace procam::detect
