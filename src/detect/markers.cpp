#include "markers.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

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

namespace {

using Quad = std::vector<cv::Point2f>;

cv::Ptr<cv::aruco::DetectorParameters> parameters_for(const cv::Mat& pixels, const MarkerCodes& codes) {
  auto parameters = cv::aruco::DetectorParameters::create();
  // Modules of two pixels can be read, however large the picture is.
  const double smallest_perimeter = 4 * 2.0 * codes.modules();
  parameters->minMarkerPerimeterRate =
      std::min(0.03, smallest_perimeter / std::max(pixels.cols, pixels.rows));
  parameters->markerBorderBits = codes.border;
  return parameters;
}

FoundMarker found_at(int id, const Quad& quad) {
  FoundMarker marker;
  marker.id = id;
  for (std::size_t c = 0; c < 4; ++c) marker.corners[c] = Vec2(quad[c].x, quad[c].y);
  return marker;
}

/// By OpenCV's outlines of dark areas.
std::vector<FoundMarker> find_outlined(const cv::Mat& pixels, const MarkerCodes& codes) {
  std::vector<Quad> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(pixels, as_opencv(codes), corners, ids, parameters_for(pixels, codes));
  std::vector<FoundMarker> found;
  for (std::size_t i = 0; i < ids.size(); ++i) found.push_back(found_at(ids[i], corners[i]));
  return found;
}

/// The marker that fills a quadrilateral, its corners from the marker's own top left; nullopt where none
/// does.
std::optional<FoundMarker> read_marker(const cv::Mat& pixels, Quad quad, const MarkerCodes& codes,
                                       const cv::aruco::Dictionary& dictionary) {
  constexpr int kCell = 6;
  constexpr double kWrongBorder = 0.1, kCorrected = 0.6;  // shares; the second of what the code can correct
  const float side = float(kCell * codes.modules());
  const Quad upright{{0, 0}, {side, 0}, {side, side}, {0, side}};
  cv::Mat patch, cells;
  cv::warpPerspective(pixels, patch, cv::getPerspectiveTransform(quad, upright),
                      cv::Size(int(side), int(side)), cv::INTER_LINEAR);
  const double threshold = cv::threshold(patch, cells, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  cv::resize(patch, cells, cv::Size(codes.modules(), codes.modules()), 0, 0, cv::INTER_AREA);
  cv::Mat bits(codes.bits, codes.bits, CV_8U);
  int light_border = 0, border = 0;
  for (int y = 0; y < codes.modules(); ++y)
    for (int x = 0; x < codes.modules(); ++x) {
      const bool light = cells.at<unsigned char>(y, x) > threshold;
      const int column = x - codes.border, row = y - codes.border;
      if (column >= 0 && row >= 0 && column < codes.bits && row < codes.bits)
        bits.at<unsigned char>(row, column) = light;
      else
        ++border, light_border += light;
    }
  int id = 0, rotation = 0;
  if (light_border > kWrongBorder * border || !dictionary.identify(bits, id, rotation, kCorrected))
    return std::nullopt;
  std::rotate(quad.begin(), quad.begin() + (4 - rotation) % 4, quad.end());
  return found_at(id, quad);
}

/// Dark areas that touch at their corners have one outline. Each is made smaller by some pixels, until blur
/// no longer joins them; its outline is made larger again and read in the image as it is. A marker that
/// several radii show is taken once.
std::vector<FoundMarker> find_touching(const cv::Mat& pixels, const MarkerCodes& codes) {
  const cv::Ptr<cv::aruco::Dictionary> dictionary = as_opencv(codes);
  std::vector<FoundMarker> all;
  for (const int radius : {1, 2, 3, 5}) {
    cv::Mat smaller;
    cv::dilate(pixels, smaller,
               cv::getStructuringElement(cv::MORPH_ELLIPSE, cv::Size(2 * radius + 1, 2 * radius + 1)));
    std::vector<Quad> quads, others;
    std::vector<int> ids;
    cv::aruco::detectMarkers(smaller, dictionary, quads, ids, parameters_for(smaller, codes), others);
    quads.insert(quads.end(), others.begin(), others.end());
    for (Quad& quad : quads) {
      const cv::Point2f middle = 0.25f * (quad[0] + quad[1] + quad[2] + quad[3]);
      // Both edges of a corner move by the radius, the corner by sqrt(2) of it.
      for (cv::Point2f& corner : quad)
        corner +=
            float(std::sqrt(2.0) * radius / std::max(cv::norm(corner - middle), 1.0)) * (corner - middle);
      const auto marker = read_marker(pixels, quad, codes, *dictionary);
      if (marker &&
          std::none_of(all.begin(), all.end(), [&](const FoundMarker& m) { return m.id == marker->id; }))
        all.push_back(*marker);
    }
  }
  return all;
}

}  // namespace

std::vector<FoundMarker> find_markers(const ViewU8& image, const MarkerCodes& codes) {
  const cv::Mat pixels(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
                       std::size_t(image.stride));
  std::vector<FoundMarker> found =
      codes.corners_touched ? find_touching(pixels, codes) : find_outlined(pixels, codes);
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
  // pixel has no information on the edge, and light that changes over the window would move it.
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
  around.modules = codes.modules();
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
