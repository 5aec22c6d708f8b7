/// Patterns that project a board beside the print.
#include "board_patterns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "procam/core/base/stats.hpp"
#include "procam/detect/board_artwork.hpp"
#include "procam/detect/detect_board.hpp"
#include "procam/detect/projected_board.hpp"
#include "procam/detect/shown_board.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/text.hpp"
#include "procam/pattern/projected_board.hpp"

namespace procam::session {
namespace {

/// A board's counts and lengths as they are typed after the pattern's name.
std::string layout_text(const Board& layout) {
  const std::string text = io::format_board(layout, io::BoardUnit::kPixel);
  return text.substr(text.find(':') + 1);
}

/// Half the distance from a point of the projected board to the next one, camera pixels (median); 0 without two points.
double half_pitch(const std::vector<LightPoint>& points) {
  std::vector<double> nearest;
  for (const LightPoint& point : points) {
    double least = std::numeric_limits<double>::infinity();
    for (const LightPoint& other : points)
      if (&other != &point) least = std::min(least, (other.camera_pixel - point.camera_pixel).norm());
    if (std::isfinite(least)) nearest.push_back(0.5 * least);
  }
  return nearest.empty() ? 0 : median(std::move(nearest));
}

/// Standard deviation of the greys around a pixel over their mean; nullopt at the image's rim.
std::optional<double> contrast_around(const ViewU8& image, const Vec2& pixel, double radius) {
  constexpr int kSamples = 7;  // each way
  double sum = 0, squares = 0, count = 0;
  for (int j = -kSamples; j <= kSamples; ++j)
    for (int i = -kSamples; i <= kSamples; ++i) {
      const int x = int(std::lround(pixel.x() + radius * i / kSamples)),
                y = int(std::lround(pixel.y() + radius * j / kSamples));
      if (x < 0 || y < 0 || x >= image.width || y >= image.height) return std::nullopt;
      const double grey = image.at(x, y);
      sum += grey, squares += grey * grey, ++count;
    }
  const double mean = sum / count;
  return std::sqrt(std::max(0.0, squares / count - mean * mean)) / std::max(mean, 1.0);
}

/// Do the found points have their contrast in the capture of flat light? In order they have it in the board's.
bool is_board_in_flat_light(const ProjectedBoardPoints& light, const ViewU8& board_lit) {
  constexpr double kClearly = 2;
  const double radius = std::clamp(half_pitch(light.points), 3.0, 40.0);
  std::vector<double> ratios;
  for (const LightPoint& point : light.points) {
    const auto flat = contrast_around(light.flat_lit, point.camera_pixel, radius),
               board = contrast_around(board_lit, point.camera_pixel, radius);
    if (flat && board) ratios.push_back(*flat / std::max(*board, 1e-3));
  }
  return !ratios.empty() && median(std::move(ratios)) > kClearly;
}

/// A projected board beside the print.
class BoardOfLight : public SessionPattern {
 public:
  BoardOfLight(const char* name, const pattern::ProjectedBoard& shown) : name_(name), shown_(shown) {}

  std::string text() const override {
    return std::string(name_) + ":" + layout_text(shown_.layout) + (shown_.upright ? ":upright" : "") +
           (shown_.colour ? ":colour" : "");
  }
  std::string describe() const override {
    return std::to_string(frame_count()) + " frames for " + io::format_size(shown_.projector_size) +
           (shown_.colour ? " (flat light in red, " : " (flat, ") + name_ + " of " +
           layout_text(shown_.layout) + (shown_.colour ? " in blue)" : ")");
  }
  std::vector<ImageU8> frames() const override { return pattern::frames(shown_); }
  int frame_count() const override { return pattern::frame_count(shown_); }
  int channels() const override { return shown_.colour ? 3 : 1; }
  std::optional<Eigen::AlignedBox2d> on_blank_paper() const override {
    Eigen::AlignedBox2d area = pattern::area_needed(shown_);
    if (!is_coded(shown_.layout)) return area;
    // Any part will do: most of it makes a good view.
    const Vec2 less = 0.5 * (1 - kShareOnPaper) * area.sizes();
    return Eigen::AlignedBox2d(area.min() + less, area.max() - less);
  }
  bool looks_same_mirrored() const override { return !is_coded(shown_.layout); }

  session::BoardView read(const std::string& view_name, const std::vector<ViewU8>& captures,
                          const Board& board) const override {
    const ProjectedBoardPoints light = light_of(captures);
    session::BoardView view{view_name, {detect::detect_board(light.flat_lit, board), {}}, light.points};
    view.detections[kProjectorDevice].image_size = shown_.projector_size;
    view.detections[kProjectorDevice].diagnostics = light.diagnostics;
    Detections& in_camera = view.detections[kCameraDevice];
    pattern::SequenceCheck sequence = check_exchange(captures, light);
    if (!sequence.decoding_is_wrong && !shown_.colour)
      sequence = pattern::check_flat_and_board(captures[0], captures[1], pixels_of(in_camera));
    add_remarks(sequence, in_camera);
    if (sequence.decoding_is_wrong) {
      view.light_points.clear();
      view.detections[kProjectorDevice].diagnostics = {};  // what was not found in the light has that cause
    }
    return view;
  }
  std::optional<ProjectedBoardPoints> read_light(const std::vector<ViewU8>& captures) const override {
    if (!shown_.colour) require_light_in_order(captures[0], captures[1]);
    return light_of(captures);
  }

 private:
  static constexpr double kShareOnPaper = 0.8;

  static ImageU8 channel_of(const ViewU8& image, int channel) {
    ImageU8 one(image.size());
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) one.at(x, y) = image.at(x, y, channel);
    return one;
  }
  /// Of the pair flat, board: the dark shapes take light away and nothing adds any.
  static void require_light_in_order(const ViewU8& flat_lit, const ViewU8& board_lit) {
    constexpr int kChange = 12;  // grey levels, well above a camera's noise
    constexpr double kMinShare = 1e-3;
    int darker = 0, brighter = 0;
    for (int y = 0; y < flat_lit.height; ++y)
      for (int x = 0; x < flat_lit.width; ++x) {
        const int change = int(flat_lit.at(x, y)) - int(board_lit.at(x, y));
        darker += change > kChange;
        brighter += -change > kChange;
      }
    const double pixels = double(flat_lit.width) * flat_lit.height;
    if (std::max(darker, brighter) < kMinShare * pixels)
      throw Error(ErrorKind::kInput, "the captures",
                  "both pictures show the same light: none of the pattern's",
                  "check that the projector is on and shows it, that the camera sees it, and the exposure");
    if (brighter > darker)
      throw Error(
          ErrorKind::kInput, "the captures",
          "the second picture is brighter than the first, which shows flat light: they are swapped, or "
          "the room's light has changed",
          "keep the order of make-patterns' pictures (flat first), and the room's light as it is");
  }
  /// Exchanged, the squares of light are dark ones: they are found all the same, and numbered from the other end.
  pattern::SequenceCheck check_exchange(const std::vector<ViewU8>& captures,
                                        const ProjectedBoardPoints& light) const {
    pattern::SequenceCheck check;
    const ImageU8 board_lit = shown_.colour ? channel_of(captures[0], 2) : channel_of(captures[1], 0);
    if (!is_board_in_flat_light(light, board_lit)) return check;
    check.decoding_is_wrong = true;
    if (shown_.colour)
      check.diagnostics.warn(
          "frames_exchanged",
          "The red channel shows the projected board and the blue one flat light: red and blue are "
          "exchanged; save the images as RGB, and show the frame of make-patterns unchanged");
    else
      check.diagnostics.warn(
          "frames_exchanged",
          "The first capture shows the projected board and the second one flat light: they are "
          "exchanged; name them in the order of make-patterns, flat light first");
    return check;
  }
  ProjectedBoardPoints light_of(const std::vector<ViewU8>& captures) const {
    ProjectedBoardPoints light;
    light.flat_lit = channel_of(captures[0], 0);
    find_points(shown_.colour ? channel_of(captures[0], 2) : channel_of(captures[1], 0), light);
    return light;
  }
  void find_points(const ViewU8& board_lit, ProjectedBoardPoints& light) const {
    Detections found = detect::detect_projected_board(board_lit, light.flat_lit, shown_.layout);
    if (shown_.upright) detect::number_upright(found, std::get<Chessboard>(shown_.layout));
    for (Diagnostic remark : found.diagnostics.items) {
      remark.message = std::string("the projected ") + name_ + ": " + remark.message;
      light.diagnostics.items.push_back(remark);
    }
    const Points2 pixels = pattern::point_pixels(shown_);
    for (const Observation& point : found.observations)
      light.points.push_back(
          {kProjectorDevice, pixels[std::size_t(point.point)], kCameraDevice, point.pixel, point.covariance});
  }

  const char* name_;
  pattern::ProjectedBoard shown_;
};

/// A kind of projected board: the pattern's name, the board's in files, and the one that fills the frame.
struct LightKind {
  const char* name;
  const char* board;
  Board (*filling)(ImageSize projector_size);
};

const LightKind kChessboard{"chessboard", "chessboard",
                            [](ImageSize size) -> Board { return pattern::chessboard_filling(size); }};
const LightKind kCharuco{"charuco", "charuco",
                         [](ImageSize size) -> Board { return pattern::charuco_filling(size); }};
const LightKind kMarkers{"markers", "markers",
                         [](ImageSize size) -> Board { return pattern::markers_filling(size); }};
const LightKind kCircles{"circles", "asymmetric-circles",
                         [](ImageSize size) -> Board { return pattern::circles_filling(size); }};

/// "12x9:64px" as the board of that kind, projector pixels for metres; without parameters the one that fills
/// the picture. A last part "colour" makes one colour frame of two; "upright" before it states that the frame
/// appears upright in the images.
pattern::ProjectedBoard light_board(const LightKind& kind, const std::string& parameters,
                                    ImageSize projector_size) {
  std::string typed = parameters;
  const auto take_last = [&](const std::string& word) {
    const bool has = typed == word || (typed.size() > word.size() &&
                                       typed.substr(typed.size() - word.size() - 1) == ":" + word);
    if (has) typed.resize(typed == word ? 0 : typed.size() - word.size() - 1);
    return has;
  };
  const bool in_colour = take_last("colour"), upright = take_last("upright");
  const std::string name = kind.name;
  Board layout = kind.filling(projector_size);
  const std::string next = "give e.g. " + name + ":" + layout_text(layout) + ", or " + name + " alone";
  try {
    if (!typed.empty()) layout = io::parse_board(kind.board + (":" + typed), io::BoardUnit::kPixel);
  } catch (const Error& error) {
    refuse(name + ":" + parameters, error.why(), next);
  }
  try {
    return pattern::projected_board(projector_size, layout, detect::board_artwork(layout), in_colour,
                                    upright);
  } catch (const Error& error) {
    refuse(name + ":" + parameters, error.why(), error.next());
  }
}

std::unique_ptr<SessionPattern> make_light(const LightKind& kind, const std::string& parameters,
                                           ImageSize projector_size) {
  return std::make_unique<BoardOfLight>(kind.name, light_board(kind, parameters, projector_size));
}

}  // namespace

pattern::ProjectedBoard projected_board_of(const std::string& text, ImageSize projector_size) {
  const std::size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  for (const LightKind* kind : {&kChessboard, &kCharuco, &kMarkers, &kCircles})
    if (name == kind->name)
      return light_board(*kind, colon == std::string::npos ? "" : text.substr(colon + 1), projector_size);
  refuse(text, "it is not a projected board", "show one of chessboard, charuco, markers, circles");
}

std::unique_ptr<SessionPattern> make_chessboard(const std::string& parameters, ImageSize size, int) {
  return make_light(kChessboard, parameters, size);
}
std::unique_ptr<SessionPattern> make_charuco(const std::string& parameters, ImageSize size, int) {
  return make_light(kCharuco, parameters, size);
}
std::unique_ptr<SessionPattern> make_markers(const std::string& parameters, ImageSize size, int) {
  return make_light(kMarkers, parameters, size);
}
std::unique_ptr<SessionPattern> make_circles(const std::string& parameters, ImageSize size, int) {
  return make_light(kCircles, parameters, size);
}

}  // namespace procam::session
