#include "common/session_patterns.hpp"

#include <algorithm>
#include <cstdio>

#include "procam/detect/board_artwork.hpp"
#include "procam/detect/detect_board.hpp"
#include "procam/detect/projected_board.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/text.hpp"
#include "procam/match/board_light.hpp"
#include "procam/pattern/gray_code.hpp"
#include "procam/pattern/phase_shift.hpp"
#include "procam/pattern/projected_board.hpp"
#include "procam/pattern/sequence_check.hpp"
#include "procam/pattern/stripe_edges.hpp"

namespace procam::tools {
namespace {

[[noreturn]] void refuse(const std::string& text, const std::string& why, const std::string& next) {
  throw Error(ErrorKind::kInput, "pattern '" + text + "'", why, next);
}

/// The reader of a map must have the projector's true size, or every coordinate is wrong by a scale.
void require_size_fits(const DecodedMap& decoded) {
  if (const Diagnostic* wrong_size = decoded.diagnostics.find("projector_size"))
    throw Error(ErrorKind::kInput, "projector size " + io::format_size(decoded.projector_size),
                wrong_size->message, "give the size of the picture that was shown");
}

/// What Gray code's frames show without the projector's light, stretched to all grey levels: of a bit's frame
/// and its inverse one at least leaves a pixel unlit. The darker of the two, over all bits.
ImageU8 in_room_light(const std::vector<ViewU8>& captures) {
  const ViewU8& first = captures.front();
  std::vector<int> sums(std::size_t(first.width) * std::size_t(first.height));
  for (std::size_t i = 0; i + 3 < captures.size(); i += 2)
    for (int y = 0; y < first.height; ++y) {
      const std::uint8_t *frame = captures[i].row(y), *inverse = captures[i + 1].row(y);
      int* sum = &sums[std::size_t(y) * std::size_t(first.width)];
      for (int x = 0; x < first.width; ++x) sum[x] += std::min(frame[x], inverse[x]);
    }
  std::vector<int> sorted = sums;
  const auto bright = sorted.begin() + long(0.999 * double(sorted.size() - 1));
  std::nth_element(sorted.begin(), bright, sorted.end());
  ImageU8 image(first.width, first.height);
  for (int y = 0; y < first.height; ++y)
    for (int x = 0; x < first.width; ++x)
      image.at(x, y) =
          std::uint8_t(std::min(255, 255 * sums[std::size_t(y) * std::size_t(first.width) + std::size_t(x)] /
                                         std::max(*bright, 1)));
  return image;
}

/// The check of the sequence names the cause of what decode() remarks on: the whole image's contrast, where
/// the wall counts as much as the board, and pairs that do not complement each other.
bool is_replaced_by(const pattern::SequenceCheck& sequence, const std::string& code) {
  if (code == "low_contrast" || code == "saturated") return sequence.has_lit_board;
  return code == "pair_not_complementary" && !sequence.diagnostics.items.empty();
}

class GrayPattern : public SessionPattern {
 public:
  explicit GrayPattern(const pattern::GrayCode& gray_code) : gray_code_(gray_code) {}

  std::string text() const override { return "gray"; }
  std::string describe() const override { return pattern::describe(gray_code_); }
  std::vector<ImageU8> frames() const override { return pattern::frames(gray_code_); }
  int frame_count() const override { return pattern::frame_count(gray_code_); }

  match::BoardView read(const std::string& view_name, const std::vector<ViewU8>& captures,
                        const Board& board) const override {
    const DecodedMap decoded = pattern::decode(captures, gray_code_);
    require_size_fits(decoded);
    const ViewU8& white = captures[captures.size() - 2];
    Detections in_camera = detect::detect_board(white, board), in_projector;
    in_projector.image_size = gray_code_.projector_size;
    if (in_camera.observations.empty()) {
      // Light that ends on the board is an edge through its print, many times as bright on one side.
      Detections unlit = detect::detect_board(in_room_light(captures), board);
      if (!unlit.observations.empty()) {
        in_camera = std::move(unlit);
        in_camera.diagnostics.note("board_in_room_light",
                                   "the board was found by the room's light alone: the projector's lights "
                                   "a part of it");
      }
    }
    Points2 corners;
    for (const Observation& corner : in_camera.observations) corners.push_back(corner.pixel);
    const pattern::SequenceCheck sequence = pattern::check_sequence(captures, gray_code_, corners);
    if (!in_camera.observations.empty() && !sequence.decoding_is_wrong) {
      const BoardArtwork artwork = detect::board_artwork(board);
      const ImageU8 area = match::readable_area(in_camera, board, artwork);
      pattern::StripeEdgeOptions options;
      options.area = area;
      in_projector = match::project_board(in_camera, board, artwork, decoded,
                                          pattern::stripe_edges(captures, decoded, gray_code_, options));
      for (Diagnostic& remark : in_projector.diagnostics.items) name_blur(decoded.diagnostics, remark);
    }
    for (const Diagnostic& remark : decoded.diagnostics.items)
      if (!is_replaced_by(sequence, remark.code)) in_camera.diagnostics.items.push_back(remark);
    in_camera.diagnostics.append(sequence.diagnostics);
    if (sequence.decoding_is_wrong && !in_camera.observations.empty())
      in_camera.diagnostics.note(
          "projector_rejected",
          "its frames do not belong together, so that only the camera's corners are used");
    return {view_name, {in_camera, in_projector}};
  }

 private:
  /// More light does not help where the stripes are out of focus.
  static void name_blur(const Diagnostics& decoded, Diagnostic& remark) {
    const Diagnostic* blurred = decoded.find("stripes_blurred");
    if (blurred == nullptr || blurred->severity == Severity::kNote) return;
    if (remark.code == "board_not_lit")
      remark.message = "too few stripes are read on the board: " + blurred->message;
    else if (remark.code == "corners_not_lit")
      remark.message += "; " + blurred->message;
  }

  pattern::GrayCode gray_code_;
};

std::unique_ptr<SessionPattern> make_gray(const std::string& parameters, ImageSize projector_size, int step) {
  if (!parameters.empty())
    refuse("gray:" + parameters, "Gray code takes no parameters", "give --pattern gray, and --step");
  return std::make_unique<GrayPattern>(pattern::GrayCode{projector_size, step});
}

/// Phase shift, its waves numbered by coarser waves or by Gray code.
class PhasePattern : public SessionPattern {
 public:
  explicit PhasePattern(const pattern::PhaseShift& shown) : shown_(shown) {}

  std::string text() const override {
    const bool gray = shown_.wave_number == pattern::WaveNumber::kGrayCode;
    return (gray ? "gray+phase:" : "phase:") + std::to_string(shown_.period) + "px";
  }
  std::string describe() const override { return pattern::describe(shown_); }
  std::vector<ImageU8> frames() const override { return pattern::frames(shown_); }
  int frame_count() const override { return pattern::frame_count(shown_); }

  match::BoardView read(const std::string& view_name, const std::vector<ViewU8>& captures,
                        const Board& board) const override {
    const LightMap light = pattern::decode(captures, shown_);
    Detections in_camera = detect::detect_board(pattern::flat_light(captures, shown_), board), in_projector;
    in_projector.image_size = shown_.projector_size;
    if (!in_camera.observations.empty())
      in_projector = match::project_board(in_camera, board, detect::board_artwork(board), light);
    in_camera.diagnostics.append(light.diagnostics);
    return {view_name, {in_camera, in_projector}};
  }

 private:
  pattern::PhaseShift shown_;
};

std::unique_ptr<SessionPattern> make_waves(const std::string& name, const std::string& parameters,
                                           ImageSize projector_size, pattern::WaveNumber wave_number) {
  pattern::PhaseShift shown{projector_size};
  shown.wave_number = wave_number;
  int used = 0;
  const bool read =
      parameters.empty() || (std::sscanf(parameters.c_str(), "%dpx%n", &shown.period, &used) == 1 &&
                             std::size_t(used) == parameters.size());
  if (!read || shown.period < 4 || shown.period % 2 != 0 ||
      shown.period > std::min(projector_size.width, projector_size.height))
    refuse(name + ":" + parameters, "its wave is no even number of pixels, 4px up to the picture's height",
           "give e.g. " + name + ":16px, or " + name + " alone");
  return std::make_unique<PhasePattern>(shown);
}

std::unique_ptr<SessionPattern> make_phase(const std::string& parameters, ImageSize projector_size, int) {
  return make_waves("phase", parameters, projector_size, pattern::WaveNumber::kCoarserWaves);
}

std::unique_ptr<SessionPattern> make_gray_phase(const std::string& parameters, ImageSize projector_size,
                                                int) {
  return make_waves("gray+phase", parameters, projector_size, pattern::WaveNumber::kGrayCode);
}

/// A board's counts and lengths as they are typed after the pattern's name.
std::string layout_text(const Board& layout) {
  const std::string text = io::format_board(layout, io::BoardUnit::kPixel);
  return text.substr(text.find(':') + 1);
}

/// A board of light beside the print.
class BoardOfLight : public SessionPattern {
 public:
  BoardOfLight(const char* name, const pattern::ProjectedBoard& shown) : name_(name), shown_(shown) {}

  std::string text() const override {
    return std::string(name_) + ":" + layout_text(shown_.layout) + (shown_.colour ? ":colour" : "");
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

  match::BoardView read(const std::string& view_name, const std::vector<ViewU8>& captures,
                        const Board& board) const override {
    const SeenLight light = light_of(captures);
    match::BoardView view{view_name, {detect::detect_board(light.flat_lit, board), {}}, light.points};
    view.detections[kProjectorDevice].image_size = shown_.projector_size;
    view.detections[kProjectorDevice].diagnostics = light.diagnostics;
    return view;
  }
  std::optional<SeenLight> read_light(const std::vector<ViewU8>& captures) const override {
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
    constexpr double kLeastShare = 1e-3;
    int darker = 0, brighter = 0;
    for (int y = 0; y < flat_lit.height; ++y)
      for (int x = 0; x < flat_lit.width; ++x) {
        const int change = int(flat_lit.at(x, y)) - int(board_lit.at(x, y));
        darker += change > kChange;
        brighter += -change > kChange;
      }
    const double pixels = double(flat_lit.width) * flat_lit.height;
    if (std::max(darker, brighter) < kLeastShare * pixels)
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
  SeenLight light_of(const std::vector<ViewU8>& captures) const {
    SeenLight light;
    light.flat_lit = channel_of(captures[0], 0);
    find_points(shown_.colour ? channel_of(captures[0], 2) : channel_of(captures[1], 0), light);
    return light;
  }
  void find_points(const ViewU8& board_lit, SeenLight& light) const {
    const Detections found = detect::detect_projected_board(board_lit, light.flat_lit, shown_.layout);
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

/// "12x9:64px" as the board of that kind, projector pixels for metres; without parameters the one that fills
/// the picture. A last part "colour" makes one colour frame of two.
std::unique_ptr<SessionPattern> make_light(const char* name, const std::string& kind,
                                           const std::string& parameters, ImageSize projector_size,
                                           const Board& filling) {
  std::string typed = parameters;
  const std::string colour = "colour";
  const bool in_colour = typed == colour || (typed.size() > colour.size() &&
                                             typed.substr(typed.size() - colour.size() - 1) == ":" + colour);
  if (in_colour) typed.resize(typed == colour ? 0 : typed.size() - colour.size() - 1);
  const std::string next =
      std::string("give e.g. ") + name + ":" + layout_text(filling) + ", or " + name + " alone";
  Board layout = filling;
  try {
    if (!typed.empty()) layout = io::parse_board(kind + ":" + typed, io::BoardUnit::kPixel);
  } catch (const Error& error) {
    refuse(name + (":" + parameters), error.why(), next);
  }
  try {
    return std::make_unique<BoardOfLight>(
        name, pattern::projected_board(projector_size, layout, detect::board_artwork(layout), in_colour));
  } catch (const Error& error) {
    refuse(name + (":" + parameters), error.why(), error.next());
  }
}

std::unique_ptr<SessionPattern> make_chessboard(const std::string& parameters, ImageSize size, int) {
  return make_light("chessboard", "chessboard", parameters, size, pattern::chessboard_filling(size));
}
std::unique_ptr<SessionPattern> make_charuco(const std::string& parameters, ImageSize size, int) {
  return make_light("charuco", "charuco", parameters, size, pattern::charuco_filling(size));
}
std::unique_ptr<SessionPattern> make_markers(const std::string& parameters, ImageSize size, int) {
  return make_light("markers", "markers", parameters, size, pattern::markers_filling(size));
}
std::unique_ptr<SessionPattern> make_circles(const std::string& parameters, ImageSize size, int) {
  return make_light("circles", "asymmetric-circles", parameters, size, pattern::circles_filling(size));
}

}  // namespace

const std::vector<PatternRow>& pattern_table() {
  static const std::vector<PatternRow> table{
      {"gray", "stripes in black and white, 42 frames for 1024x768; the most robust", make_gray},
      {"phase", "cosine waves, 32 frames for 1024x768; needs a projector or camera without clipped greys",
       make_phase},
      {"gray+phase", "both, 46 frames for 1024x768; for cameras that cannot tell the waves' number otherwise",
       make_gray_phase},
      {"chessboard", "a chessboard of light beside the print, 2 frames, or 1 with chessboard:colour",
       make_chessboard},
      {"charuco", "the same with markers: a part of it on the paper is enough", make_charuco},
      {"markers", "a grid of markers of light beside the print; a part is enough", make_markers},
      {"circles", "staggered discs of light beside the print, all on the paper", make_circles},
  };
  return table;
}

std::unique_ptr<SessionPattern> make_pattern(const std::string& text, ImageSize projector_size, int step) {
  const std::size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  for (const PatternRow& row : pattern_table())
    if (name == row.name)
      return row.make(colon == std::string::npos ? "" : text.substr(colon + 1), projector_size, step);
  std::string known;
  for (const PatternRow& row : pattern_table()) known += (known.empty() ? "" : ", ") + std::string(row.name);
  refuse(text, "there is no such pattern", "use one of: " + known);
}

std::string pattern_help() {
  std::string help;
  for (const PatternRow& row : pattern_table())
    help += (help.empty() ? "" : " | ") + std::string(row.name) + " (" + row.about + ")";
  return help;
}

}  // namespace procam::tools
