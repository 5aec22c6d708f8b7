#include "procam/detect/marker_edges.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <opencv2/aruco.hpp>

#include "marker_model.hpp"
#include "marker_warp.hpp"
#include "procam/core/base/detail/regular_file.hpp"

namespace procam::detect {
namespace {

cv::aruco::PREDEFINED_DICTIONARY_NAME opencv_name(MarkerDictionary dictionary) {
  // OpenCV's enumerators follow the order of procam's; a test compares every one.
  return cv::aruco::PREDEFINED_DICTIONARY_NAME(int(dictionary));
}

/// Cells wrong up to which AprilTag's families stay certain: half their Hamming distance, as OpenCV's own
/// numbers are for the ArUco ones. It leaves them at 0.
int correctable_bits(MarkerDictionary dictionary, int by_opencv) {
  switch (dictionary) {
    case MarkerDictionary::kAprilTag25h9:
    case MarkerDictionary::kAprilTag36h10:
      return 4;
    case MarkerDictionary::kAprilTag36h11:
      return 5;
    default:
      return by_opencv;
  }
}

MarkerCells codes_of(const cv::aruco::Dictionary& dictionary) {
  MarkerCells codes{dictionary.markerSize, dictionary.maxCorrectionBits, {}};
  for (int id = 0; id < dictionary.bytesList.rows; ++id) {
    const cv::Mat bits =
        cv::aruco::Dictionary::getBitsFromByteList(dictionary.bytesList.row(id), codes.per_side);
    codes.white.emplace_back(bits.begin<uchar>(), bits.end<uchar>());
  }
  return codes;
}

cv::Ptr<cv::aruco::Dictionary> dictionary_of(const MarkerCells& codes) {
  cv::Mat bytes;
  for (const std::vector<std::uint8_t>& white : codes.white) {
    require(white.size() == std::size_t(codes.per_side * codes.per_side),
            "detect_marker_edges: a marker has another number of cells than its dictionary");
    cv::Mat bits(codes.per_side, codes.per_side, CV_8U);
    std::copy(white.begin(), white.end(), bits.begin<uchar>());
    bytes.push_back(cv::aruco::Dictionary::getByteListFromBits(bits));
  }
  return cv::makePtr<cv::aruco::Dictionary>(bytes, codes.per_side, codes.correctable_bits);
}

using Corners = std::array<Vec2, 4>;

double area(const Corners& c) {
  const Vec2 a = c[2] - c[0], b = c[3] - c[1];
  return 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
}

/// A marker of cells too small for edges: all of its pixels at once. The detector's corners where that fails.
SeenMarker refine_small(const ViewU8& image, const MarkerCells& codes, int id, const Corners& start,
                        const Camera* lens) {
  constexpr double kCoarseSigma = 1;  // pixels: a detector's corners, with its bias
  if (const auto fit = fit_model(image, codes, id, start, lens))
    return {id, fit->corners, fit->covariance, {}, false};
  return {id, start, Eigen::Matrix<double, 8, 8>::Identity() * kCoarseSigma * kCoarseSigma, {}, true};
}

/// Pixels a cell, on the shortest side.
double cell_px(const MarkerCells& codes, const Corners& c) {
  double side = (c[3] - c[0]).norm();
  for (std::size_t i = 0; i < 3; ++i) side = std::min(side, (c[i + 1] - c[i]).norm());
  return side / (codes.per_side + 2);
}

/// The edges where the warp expects them, the warp that they imply, and again from there.
SeenMarker refine(const ViewU8& image, const MarkerCells& codes, int id, const Corners& start,
                  const Camera* lens) {
  // Below, few edges keep clear of their neighbours' blur, and those that do say little.
  constexpr double kEnoughForEdges = 4.5;
  if (cell_px(codes, start) < kEnoughForEdges)
    if (SeenMarker small = refine_small(image, codes, id, start, lens); !small.coarse) return small;
  SeenMarker marker;
  marker.id = id;
  std::optional<MarkerWarp> warp = MarkerWarp::through(start, lens);
  for (int round = 0; round < 2 && warp; ++round) {
    FoundEdges found = find_edges(image, codes, id, *warp);
    const std::optional<WarpFit> fit = fit_warp(found.edges, *warp);
    if (!fit) return refine_small(image, codes, id, start, lens);
    warp = fit->warp;
    if (round == 0) continue;
    believe_misfit(*fit, found.blur, found.edges);
    marker.edges = std::move(found.edges);
    marker.covariance = fit->corner_covariance;
    for (std::size_t i = 0; i < 4; ++i) marker.corners[i] = *fit->warp(marker_corners()[i]);
  }
  return warp ? marker : refine_small(image, codes, id, start, lens);
}

}  // namespace

MarkerCells marker_cells(MarkerDictionary dictionary) {
  MarkerCells codes = codes_of(*cv::aruco::getPredefinedDictionary(opencv_name(dictionary)));
  codes.correctable_bits = correctable_bits(dictionary, codes.correctable_bits);
  // OpenCV has AprilTags half a turn from the pictures that their authors publish and people print.
  if (dictionary >= MarkerDictionary::kAprilTag16h5)
    for (std::vector<std::uint8_t>& white : codes.white) std::reverse(white.begin(), white.end());
  return codes;
}

MarkerCells load_marker_cells(const std::filesystem::path& path) {
  const auto no_dictionary = [&](const std::string& why) {
    return Error(ErrorKind::kInput, path.string(), why,
                 "give OpenCV's form: nmarkers, markersize, marker_0: \"0110...\" row by row");
  };
  // Read here, since OpenCV prints when it cannot open a file.
  procam::internal::require_regular_file(path);
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Error(ErrorKind::kIo, path.string(), "it cannot be read", "check the name");
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  cv::aruco::Dictionary dictionary;
  try {
    const cv::FileStorage file(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    if (text.empty() || !file.isOpened()) throw no_dictionary("it is empty or no such file");
    const int cells = int(file["markersize"]), count = int(file["nmarkers"]);
    if (cells < 1 || cells > 16 || count < 1 || count > 100000)
      throw no_dictionary("it states no size or number of markers");
    for (int id = 0; id < count; ++id)
      if (std::string(file["marker_" + std::to_string(id)]).size() != std::size_t(cells * cells))
        throw no_dictionary("marker_" + std::to_string(id) + " is not a text of " +
                            std::to_string(cells * cells) + " cells");
    dictionary.readDictionary(file.root());
  } catch (const cv::Exception&) {
    throw no_dictionary("it is no such file");
  }
  return codes_of(dictionary);
}

MarkerDetections detect_marker_edges(const ViewU8& image, const MarkerCells& codes,
                                     const MarkerEdgeOptions& options) {
  require(!image.empty() && image.channels == 1, "detect_marker_edges: a one-channel image is needed");
  require(!options.camera || options.camera->size == image.size(),
          "detect_marker_edges: the image's size is not the camera's");
  const Camera* const lens = options.camera ? &*options.camera : nullptr;
  const cv::Mat pixels(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
                       std::size_t(image.stride));
  std::vector<std::vector<cv::Point2f>> found;
  std::vector<int> ids;
  const cv::Ptr<cv::aruco::DetectorParameters> parameters = cv::aruco::DetectorParameters::create();
  // Of two outlines that are nearer to each other than this share of the perimeter, OpenCV keeps the larger. On a dark wall
  // that is the outline of a white rim: one cell of an AprilTag is 4.4 %, and OpenCV's own value 5 %.
  parameters->minMarkerDistanceRate = 0.03;
  cv::aruco::detectMarkers(pixels, dictionary_of(codes), found, ids, parameters);

  MarkerDetections detections;
  detections.image_size = image.size();
  for (std::size_t i = 0; i < ids.size(); ++i) {
    Corners corners;
    for (std::size_t k = 0; k < 4; ++k) corners[k] = Vec2(found[i][k].x, found[i][k].y);
    const auto same = std::find_if(detections.markers.begin(), detections.markers.end(),
                                   [&](const SeenMarker& m) { return m.id == ids[i]; });
    if (same == detections.markers.end()) {
      detections.markers.push_back(refine(image, codes, ids[i], corners, lens));
      continue;
    }
    detections.diagnostics.warn("marker_twice", "marker " + std::to_string(ids[i]) +
                                                    " is in the image twice and the larger one is taken; "
                                                    "cover a reflection, or use another id");
    if (area(corners) > area(same->corners)) *same = refine(image, codes, ids[i], corners, lens);
  }
  std::sort(detections.markers.begin(), detections.markers.end(),
            [](const SeenMarker& a, const SeenMarker& b) { return a.id < b.id; });
  if (detections.markers.empty())
    detections.diagnostics.warn("markers_not_found",
                                "no marker of the dictionary is in the image; check the dictionary's name, "
                                "focus and light, and keep a white rim of one cell round every marker");
  return detections;
}

}  // namespace procam::detect
