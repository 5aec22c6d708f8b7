#include "common/session_patterns.hpp"

#include <algorithm>
#include <cstdio>

#include "procam/detect/board_artwork.hpp"
#include "procam/detect/detect_board.hpp"
#include "procam/detect/projected_chessboard.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/text.hpp"
#include "procam/match/board_light.hpp"
#include "procam/pattern/chessboard_pattern.hpp"
#include "procam/pattern/gray_code.hpp"
#include "procam/pattern/phase_shift.hpp"
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
    if (!in_camera.observations.empty())
      in_projector = match::project_board(in_camera, board, detect::board_artwork(board), decoded,
                                          pattern::stripe_edges(captures, decoded, gray_code_));
    in_camera.diagnostics.append(decoded.diagnostics);
    return {view_name, {in_camera, in_projector}};
  }

 private:
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

class ChessboardPair : public SessionPattern {
 public:
  ChessboardPair(const pattern::ChessboardPattern& shown) : shown_(shown) {}

  std::string text() const override {
    return "chessboard:" + std::to_string(shown_.columns) + "x" + std::to_string(shown_.rows) + ":" +
           std::to_string(shown_.square_px) + "px";
  }
  std::string describe() const override { return pattern::describe(shown_); }
  std::vector<ImageU8> frames() const override { return pattern::frames(shown_); }
  int frame_count() const override { return 2; }
  std::optional<Eigen::AlignedBox2d> on_blank_paper() const override { return pattern::area_needed(shown_); }

  match::BoardView read(const std::string& view_name, const std::vector<ViewU8>& captures,
                        const Board& board) const override {
    match::BoardView view{view_name, {detect::detect_board(captures[0], board), {}}};
    Detections& in_projector = view.detections[kProjectorDevice];
    in_projector.image_size = shown_.projector_size;
    const Detections light = detect::detect_projected_chessboard(captures[1], captures[0],
                                                                 Chessboard{shown_.columns, shown_.rows, 1});
    for (Diagnostic remark : light.diagnostics.items) {
      remark.message = "the projected chessboard: " + remark.message;
      in_projector.diagnostics.items.push_back(remark);
    }
    const Points2 pixels = pattern::corner_pixels(shown_);
    for (const Observation& corner : light.observations)
      view.light_points.push_back({kProjectorDevice, pixels[std::size_t(corner.point)], kCameraDevice,
                                   corner.pixel, corner.covariance});
    return view;
  }

 private:
  pattern::ChessboardPattern shown_;
};

std::unique_ptr<SessionPattern> make_chessboard(const std::string& parameters, ImageSize projector_size,
                                                int) {
  if (parameters.empty())
    return std::make_unique<ChessboardPair>(pattern::chessboard_pattern(projector_size));
  int columns = 0, rows = 0, square_px = 0, used = 0;
  if (std::sscanf(parameters.c_str(), "%dx%d:%dpx%n", &columns, &rows, &square_px, &used) != 3 ||
      std::size_t(used) != parameters.size())
    refuse("chessboard:" + parameters, "its parameters are not COLUMNSxROWS:SQUARE in pixels",
           "give inner corners and square, e.g. chessboard:12x9:64px, or chessboard alone");
  return std::make_unique<ChessboardPair>(
      pattern::chessboard_pattern(projector_size, columns, rows, square_px));
}

}  // namespace

const std::vector<PatternRow>& pattern_table() {
  static const std::vector<PatternRow> table{
      {"gray", "stripes in black and white, 42 frames for 1024x768; the most robust", make_gray},
      {"phase", "cosine waves, 32 frames for 1024x768; needs a projector or camera without clipped greys",
       make_phase},
      {"gray+phase", "both, 46 frames for 1024x768; for cameras that cannot tell the waves' number otherwise",
       make_gray_phase},
      {"chessboard", "a chessboard of light beside the printed one, 2 frames", make_chessboard},
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
