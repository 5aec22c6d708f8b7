#include "procam/session/mount_light.hpp"

#include <algorithm>
#include <map>
#include <variant>

#include "board_patterns.hpp"
#include "procam/core/base/parallel.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "procam/detect/detect_board.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/detect/shown_board.hpp"
#include "procam/io/image/images.hpp"
#include "procam/pattern/projected_board.hpp"
#include "timed_images.hpp"

namespace procam::session {
namespace {

/// Edges of light are made of pixels, as in detect_projected_board().
constexpr double kRasterSigmaPx = 0.005;

pattern::ProjectedBoard still_board(const std::string& pattern, ImageSize projector_size) {
  pattern::ProjectedBoard board = projected_board_of(pattern, projector_size);
  if (board.colour)
    throw Error(ErrorKind::kInput, "pattern '" + pattern + "'", "its frame is in colour",
                "show its board frame without colour, e.g. markers");
  return board;
}

/// The squared corner sigma of a marker, the mean of its axes.
double variance_of(const SeenMarker& marker) {
  return marker.covariance.diagonal().mean();
}

/// Markers across a crease of two surfaces fit worse than their neighbours in the grid. Their corners are on neither surface.
bool is_across_a_crease(const SeenMarker& marker, const std::map<int, const SeenMarker*>& by_id,
                        const MarkerGrid& grid) {
  constexpr double kWorseThanNeighbours = 1.4 * 1.4;
  std::vector<double> variances;
  const int row = marker.id / grid.columns, column = marker.id % grid.columns;
  for (int r = row - 1; r <= row + 1; ++r)
    for (int c = column - 1; c <= column + 1; ++c) {
      if (c < 0 || c >= grid.columns || (r == row && c == column)) continue;
      if (const auto at = by_id.find(r * grid.columns + c); at != by_id.end())
        variances.push_back(variance_of(*at->second));
    }
  return !variances.empty() && variance_of(marker) > kWorseThanNeighbours * median(std::move(variances));
}

/// The corners of the markers, each marker fitted by itself: in a corner of a room and on furniture the board is not flat.
Detections corners_of_markers(const ImageU8& grey, const MarkerGrid& grid, const Camera& camera) {
  // Blotches of paint and the projector's pixels, in each marker's corners.
  constexpr double kSurfaceSigmaPx = 0.045;
  const MarkerDetections seen =
      detect::detect_marker_edges(grey, detect::marker_cells(grid.dictionary), {camera});
  std::map<int, const SeenMarker*> by_id;
  for (const SeenMarker& marker : seen.markers)
    if (!marker.coarse && marker.id < grid.marker_count()) by_id[marker.id] = &marker;
  Detections found{grey.size(), {}, seen.diagnostics};
  for (const auto& [id, marker] : by_id) {
    if (is_across_a_crease(*marker, by_id, grid)) continue;
    for (int i = 0; i < 4; ++i)
      found.observations.push_back({4 * id + i, marker->corners[std::size_t(i)],
                                    Mat2(marker->covariance.block<2, 2>(2 * i, 2 * i)) +
                                        kSurfaceSigmaPx * kSurfaceSigmaPx * Mat2::Identity()});
  }
  return found;
}

/// The points of the board in an image of it alone.
std::vector<LightPoint> points_in(const ImageU8& grey, const pattern::ProjectedBoard& board,
                                  const Camera& camera, Diagnostics& remarks) {
  const auto* const grid = std::get_if<MarkerGrid>(&board.layout);
  Detections found =
      grid != nullptr ? corners_of_markers(grey, *grid, camera) : detect::detect_board(grey, board.layout);
  if (board.upright) detect::number_upright(found, std::get<Chessboard>(board.layout));
  remarks = found.diagnostics;
  const Points2 pixels = pattern::point_pixels(board);
  std::vector<LightPoint> points;
  for (const Observation& seen : found.observations) {
    LightPoint point;
    point.projector_pixel = pixels[std::size_t(seen.point)];
    point.camera_pixel = seen.pixel;
    point.camera_covariance = seen.covariance + kRasterSigmaPx * kRasterSigmaPx * Mat2::Identity();
    point.point = seen.point;
    points.push_back(point);
  }
  return points;
}

/// Why images are skipped, counted by the remedy, as the causes have numbers in them.
class Causes {
 public:
  void add(const std::string& remedy, const std::string& cause) {
    ++counts_.try_emplace(remedy, Count{0, cause}).first->second.images;
  }
  std::string most_frequent() const {
    const auto at = std::max_element(counts_.begin(), counts_.end(), [](const auto& a, const auto& b) {
      return a.second.images < b.second.images;
    });
    return at == counts_.end() ? "" : at->second.first_cause;
  }

 private:
  struct Count {
    int images = 0;
    std::string first_cause;
  };
  std::map<std::string, Count> counts_;
};

struct LitImage {
  std::vector<track::PlaneSighting> planes;
  bool shows_board = false;
  std::string cause, remedy;  ///< without planes
};

LitImage read_light(const std::filesystem::path& file, const pattern::ProjectedBoard& board,
                    const RigCamera& camera, const RigProjector& projector, const LightImages& images) {
  const ImageU8 grey = io::green_channel(io::load_image(file).image);
  if (grey.size() != camera.camera.size)
    throw Error(ErrorKind::kInput, file.string(), "it is not of the size of the rig's camera",
                "use images of that camera in the mode in which it was calibrated");
  LitImage lit;
  Diagnostics remarks;
  const std::vector<LightPoint> points = points_in(grey, board, camera.camera, remarks);
  if (int(points.size()) < images.min_points) {
    lit.cause = points.empty() && !remarks.items.empty() ? remarks.items.front().message
                                                         : "few of the board's points are found";
    return lit;
  }
  lit.shows_board = true;
  track::SightPlaneOptions options = images.plane;
  options.min_points = images.min_points;
  try {
    lit.planes = track::sight_planes(points, camera, projector, options);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kDegenerate && error.kind() != ErrorKind::kNotEnoughData) throw;
    lit.cause = error.why() + "; " + error.next();
    lit.remedy = error.next();
  }
  return lit;
}

std::string skipped(std::size_t without_board, std::size_t without_plane) {
  std::vector<std::string> parts;
  if (without_board > 0) parts.push_back(std::to_string(without_board) + " show too little of the board");
  if (without_plane > 0) parts.push_back(std::to_string(without_plane) + " do not show one plane");
  return and_list(parts);
}

}  // namespace

PlaneSightings planes_in_light(const LightImages& images, const RigCamera& camera,
                               const RigProjector& projector, const ReadingProgress& progress) {
  require(images.min_points >= 4, "planes_in_light: min_points is below 4");
  const pattern::ProjectedBoard board = still_board(images.pattern, projector.projector.size());
  PlaneSightings result;
  std::size_t without_board = 0, without_plane = 0;
  Causes causes;
  const auto files = timed_images(images.folder, {".png", ".jpg", ".jpeg", ".pgm"});
  const int count = int(files.size()), together = thread_count(0);
  for (int begin = 0; begin < count; begin += together) {
    if (progress) progress(files[std::size_t(begin)].second.filename().string(), begin, count);
    std::vector<LitImage> lit(std::size_t(std::min(together, count - begin)));
    parallel_each(int(lit.size()), 0, [&](int i) {
      lit[std::size_t(i)] =
          read_light(files[std::size_t(begin + i)].second, board, camera, projector, images);
    });
    for (std::size_t i = 0; i < lit.size(); ++i) {
      ++result.images;
      for (const track::PlaneSighting& plane : lit[i].planes)
        result.sightings.push_back({files[std::size_t(begin) + i].first, "", plane.plane_from_rig, true});
      if (!lit[i].planes.empty()) continue;
      ++(lit[i].shows_board ? without_plane : without_board);
      causes.add(lit[i].remedy, lit[i].cause);
    }
  }
  result.images_without_plane = without_board + without_plane;
  const std::string counts = skipped(without_board, without_plane);
  if (result.sightings.empty())
    throw Error(
        ErrorKind::kNotEnoughData, images.folder.string(),
        counted(result.images, "image") + " without a plane in the light of " + images.pattern +
            (counts.empty() ? "" : ": " + counts) +
            (counts.empty() ? "" : " (most often: " + causes.most_frequent() + ")"),
        "show the board frame of the pattern all the time, sharp and bright, on a blank wall or on the floor "
        "1 to 3 m away, and let the camera see it");
  if (!counts.empty())
    result.diagnostics.note("images_skipped", images.folder.string() + ": of " +
                                                  counted(result.images, "image") + " " + counts +
                                                  " (most often: " + causes.most_frequent() + ")");
  return result;
}

ImageU8 still_frame(const std::string& pattern, ImageSize projector_size) {
  return pattern::frames(still_board(pattern, projector_size))[1];
}

}  // namespace procam::session
