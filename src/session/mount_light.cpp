#include "procam/session/mount_light.hpp"

#include <algorithm>
#include <map>
#include <variant>

#include "board_patterns.hpp"
#include "procam/core/base/words.hpp"
#include "procam/detect/detect_board.hpp"
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

/// The points of the board in an image of it alone.
std::vector<LightPoint> points_in(const ImageU8& grey, const pattern::ProjectedBoard& board,
                                  Diagnostics& remarks) {
  Detections found = detect::detect_board(grey, board.layout);
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
  track::SightPlaneOptions options = images.plane;
  options.min_points = images.min_points;
  PlaneSightings result;
  std::size_t without_board = 0, without_plane = 0;
  Causes causes;
  const auto files = timed_images(images.folder, {".png", ".jpg", ".jpeg", ".pgm"});
  for (const auto& [time, file] : files) {
    if (progress) progress(file.filename().string(), int(result.images), int(files.size()));
    ++result.images;
    const ImageU8 grey = io::green_channel(io::load_image(file).image);
    if (grey.size() != camera.camera.size)
      throw Error(ErrorKind::kInput, file.string(), "it is not of the size of the rig's camera",
                  "use images of that camera in the mode in which it was calibrated");
    Diagnostics remarks;
    const std::vector<LightPoint> points = points_in(grey, board, remarks);
    if (int(points.size()) < images.min_points) {
      ++without_board;
      causes.add("", points.empty() && !remarks.items.empty() ? remarks.items.front().message
                                                              : "few of the board's points are found");
      continue;
    }
    try {
      for (const track::PlaneSighting& plane : track::sight_planes(points, camera, projector, options))
        result.sightings.push_back({time, "", plane.plane_from_rig, true});
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kDegenerate && error.kind() != ErrorKind::kNotEnoughData) throw;
      causes.add(error.next(), error.why() + "; " + error.next());
      ++without_plane;
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
