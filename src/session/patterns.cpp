#include "procam/session/patterns.hpp"
#include "preview.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <regex>

#include "board_patterns.hpp"
#include "frame_order.hpp"
#include "pattern_table.hpp"
#include "procam/core/base/detail/edit_distance.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "procam/detect/board_artwork.hpp"
#include "procam/detect/detect_board.hpp"
#include "procam/io/session/pattern_file.hpp"
#include "procam/io/text.hpp"
#include "procam/pattern/board_light.hpp"
#include "procam/pattern/frame_sequence.hpp"
#include "procam/pattern/gray_code.hpp"
#include "procam/pattern/phase_shift.hpp"
#include "procam/pattern/sequence_check.hpp"
#include "procam/pattern/stripe_edges.hpp"
#include "procam/pattern/stripe_map.hpp"

namespace procam::session {

[[noreturn]] void refuse(const std::string& text, const std::string& why, const std::string& next) {
  throw Error(ErrorKind::kInput, "pattern '" + text + "'", why, next);
}

void add_remarks(const pattern::SequenceCheck& sequence, Detections& in_camera) {
  in_camera.diagnostics.append(sequence.diagnostics);
  if (sequence.decoding_is_wrong && !in_camera.observations.empty())
    in_camera.diagnostics.note(
        "projector_rejected",
        "its frames do not belong together, so that only the camera's corners are used");
}

Points2 pixels_of(const Detections& detections) {
  Points2 pixels;
  for (const Observation& corner : detections.observations) pixels.push_back(corner.pixel);
  return pixels;
}

namespace {

const char* const kPatternFile = "pattern.json";

/// Lamps that flicker write codes into pixels that the projector does not light: these tell nothing about its size.
void forgive_codes_of_flicker(const pattern::SequenceCheck& sequence, DecodedMap& decoded) {
  if (sequence.diagnostics.find("flicker") == nullptr) return;
  auto& items = decoded.diagnostics.items;
  items.erase(std::remove_if(items.begin(), items.end(),
                             [](const Diagnostic& remark) { return remark.code == "projector_size"; }),
              items.end());
}

/// Frames in the order of another program make codes beyond the frame.
void require_usual_order(const std::vector<ViewU8>& captures, const pattern::GrayCode& gray_code) {
  const std::optional<std::string> order = other_frame_order(captures, gray_code);
  if (!order) return;
  const std::string next =
      "number the files in the order of make-patterns: columns from the coarsest stripes, each frame before its "
      "inverse, rows likewise, white, black; or describe the order in a pattern.json (docs/patterns.md)";
  // The codes are the same when width and height are exchanged.
  if (*order == kRowsFirst)
    throw Error(ErrorKind::kInput, "projector size " + io::format_size(gray_code.projector_size),
                "width and height are exchanged, or " + *order,
                "give the size of the picture that was shown; if it is right, " + next);
  throw Error(ErrorKind::kInput, "Gray-code captures", "their frames are in another order: " + *order, next);
}

/// The reader of a map must have the projector's true size, or every coordinate is wrong by a scale.
void require_size_fits(const DecodedMap& decoded, const std::vector<ViewU8>& captures,
                       const pattern::GrayCode& gray_code) {
  if (decoded.diagnostics.find("projector_size") != nullptr) require_usual_order(captures, gray_code);
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
  const int bright = std::max(quantile(sums, 0.999), 1);
  ImageU8 image(first.width, first.height);
  for (int y = 0; y < first.height; ++y)
    for (int x = 0; x < first.width; ++x)
      image.at(x, y) = std::uint8_t(
          std::min(255, 255 * sums[std::size_t(y) * std::size_t(first.width) + std::size_t(x)] / bright));
  return image;
}

/// The check of the sequence names the cause of what decode() remarks on: the whole image's contrast, where
/// the wall counts as much as the board, and pairs that do not complement each other.
bool is_replaced_by(const pattern::SequenceCheck& sequence, const std::string& code) {
  // White and black are frames of the sequence as well: where these are not what they should be, their
  // difference is no measure of the light.
  if (sequence.decoding_is_wrong && (code == "unlit" || code == "hardly_decoded")) return true;
  if (code == "low_contrast" || code == "saturated") return sequence.has_lit_board;
  return code == "pair_not_complementary" && !sequence.diagnostics.items.empty();
}

/// More light does not help where the stripes are out of focus.
void name_blur(const Diagnostics& decoded, Diagnostic& remark) {
  const Diagnostic* blurred = decoded.find("stripes_blurred");
  if (blurred == nullptr || blurred->severity == Severity::kNote) return;
  if (remark.code == "board_not_lit")
    remark.message = "too few stripes are read on the board: " + blurred->message;
  else if (remark.code == "corners_not_lit")
    remark.message += "; " + blurred->message;
}

/// How captures of Gray code are read that were not shown by procam.
struct GrayReading {
  /// Pattern and inverse are two measurements: else nothing of the sequence can be checked by their sum.
  bool has_inverses = true;
  std::array<int, 2> offset = {0, 0};  ///< of the codes, projector pixels
  ImageSize projector_size;
};

/// Where white is no brighter than black the sequence may tell why.
DecodedMap decode(const std::vector<ViewU8>& captures, const pattern::GrayCode& gray_code,
                  const pattern::DecodeOptions& options, const GrayReading& how) {
  try {
    return pattern::decode(captures, gray_code, options);
  } catch (const Error& error) {
    if (!how.has_inverses || int(captures.size()) != pattern::frame_count(gray_code)) throw;
    require_usual_order(captures, gray_code);
    const pattern::SequenceCheck sequence = pattern::check_sequence(captures, gray_code, {});
    if (sequence.diagnostics.items.empty()) throw;
    throw Error(error.kind(), "Gray-code captures", sequence.diagnostics.items.front().message,
                "capture this view again");
  }
}

session::BoardView read_gray(const std::string& view_name, const std::vector<ViewU8>& captures,
                             const pattern::GrayCode& gray_code, const Board& board, const GrayReading& how) {
  pattern::StripeEdgeOptions options;
  if (!how.has_inverses) {
    // P - (white + black - P) has three times the variance of P - inverse.
    options.decode.bit_sigmas *= std::sqrt(3.0);
    options.min_step_sigmas *= std::sqrt(3.0);
  }
  DecodedMap decoded = decode(captures, gray_code, options.decode, how);
  const ViewU8& white = captures[captures.size() - 2];
  Detections in_camera = detect::detect_board(white, board), in_projector;
  in_projector.image_size = how.projector_size;
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
  pattern::SequenceCheck sequence;
  if (how.has_inverses) sequence = pattern::check_sequence(captures, gray_code, pixels_of(in_camera));
  forgive_codes_of_flicker(sequence, decoded);
  // Codes of a view whose frames do not belong together say nothing about the projector.
  if (!sequence.decoding_is_wrong) require_size_fits(decoded, captures, gray_code);
  if (!in_camera.observations.empty() && !sequence.decoding_is_wrong) {
    const BoardArtwork artwork = detect::board_artwork(board);
    const ImageU8 area = pattern::readable_area(in_camera, board, artwork);
    options.area = area;
    std::vector<StripeEdge> edges = pattern::stripe_edges(captures, decoded, gray_code, options);
    for (StripeEdge& edge : edges)
      edge.projector_coordinate -= how.offset[edge.axis == StripeAxis::kColumn ? 0 : 1];
    decoded.projector_size = how.projector_size;
    in_projector = pattern::project_board(in_camera, board, artwork, decoded, edges);
    for (Diagnostic& remark : in_projector.diagnostics.items) name_blur(decoded.diagnostics, remark);
  }
  const auto projector_pixel = [&](int x, int y) -> std::optional<Vec2> {
    if (!decoded.decoded(x, y)) return std::nullopt;
    const Vec2 code(decoded.columns.at(x, y), decoded.rows.at(x, y));
    return (decoded.step * (code.array() + 0.5) - 0.5 - Eigen::Array2d(how.offset[0], how.offset[1]))
        .matrix();
  };
  // Out of focus few pixels read every bit, and the board's points are read all the same.
  const bool board_read = !in_camera.observations.empty() &&
                          2 * in_projector.observations.size() >= in_camera.observations.size();
  for (const Diagnostic& remark : decoded.diagnostics.items)
    if (!is_replaced_by(sequence, remark.code) && !(remark.code == "hardly_decoded" && board_read))
      in_camera.diagnostics.items.push_back(remark);
  add_remarks(sequence, in_camera);
  return {view_name, {in_camera, in_projector}, {}, decoded_preview(decoded.camera_size(), projector_pixel)};
}

/// Every pixel's light from Gray code: the edges of stripes, joined along each line of the image.
PatternLight gray_light(const std::vector<ViewU8>& captures, const pattern::GrayCode& gray_code,
                        const GrayReading& how) {
  pattern::StripeEdgeOptions options;
  // Few edges on dark surfaces (12 grey levels) stand out by 5 deviations. Each counts by its own deviation here.
  options.min_step_sigmas = 2;
  if (!how.has_inverses) {
    options.decode.bit_sigmas *= std::sqrt(3.0);
    options.min_step_sigmas *= std::sqrt(3.0);
  }
  DecodedMap decoded = decode(captures, gray_code, options.decode, how);
  require_size_fits(decoded, captures, gray_code);
  PatternLight read;
  read.light = pattern::light_map(decoded, pattern::stripe_edges(captures, decoded, gray_code, options));
  read.light.projector_size = how.projector_size;
  for (int y = 0; y < read.light.pixel.height(); ++y)
    for (int x = 0; x < read.light.pixel.width(); ++x)
      for (int c = 0; c < 2; ++c) read.light.pixel.at(x, y, c) -= float(how.offset[std::size_t(c)]);
  if (how.has_inverses)
    read.light.diagnostics.append(pattern::check_sequence(captures, gray_code, {}).diagnostics);
  const ViewU8& white = captures[captures.size() - 2];
  read.flat_lit = ImageU8(white.size());
  for (int y = 0; y < white.height; ++y) std::copy_n(white.row(y), white.width, read.flat_lit.row(y));
  return read;
}

class GrayPattern : public SessionPattern {
 public:
  explicit GrayPattern(const pattern::GrayCode& gray_code) : gray_code_(gray_code) {}

  std::string text() const override { return "gray"; }
  std::string describe() const override { return pattern::describe(gray_code_); }
  std::vector<ImageU8> frames() const override { return pattern::frames(gray_code_); }
  int frame_count() const override { return pattern::frame_count(gray_code_); }

  session::BoardView read(const std::string& view_name, const std::vector<ViewU8>& captures,
                          const Board& board) const override {
    return read_gray(view_name, captures, gray_code_, board, {true, {0, 0}, gray_code_.projector_size});
  }
  std::optional<PatternLight> read_light_map(const std::vector<ViewU8>& captures) const override {
    return gray_light(captures, gray_code_, {true, {0, 0}, gray_code_.projector_size});
  }

 private:
  pattern::GrayCode gray_code_;
};

std::unique_ptr<SessionPattern> make_gray(const std::string& parameters, ImageSize projector_size, int step) {
  if (!parameters.empty())
    refuse("gray:" + parameters, "Gray code takes no parameters", "give --pattern gray, and --step");
  return std::make_unique<GrayPattern>(pattern::GrayCode{projector_size, step});
}

/// Flat light by the last two pairs of frames alone, before which a board may have moved.
ImageU8 last_light(const std::vector<ViewU8>& captures, const pattern::ComplementaryFrames& frames) {
  ImageU8 mean(captures.front().size());
  const auto &a = frames.pairs[frames.pairs.size() - 2], &b = frames.pairs.back();
  for (int y = 0; y < mean.height(); ++y)
    for (int x = 0; x < mean.width(); ++x) {
      int sum = 2;
      for (const int frame : {a[0], a[1], b[0], b[1]}) sum += captures[std::size_t(frame)].at(x, y);
      mean.at(x, y) = std::uint8_t(sum / 4);
    }
  return mean;
}

session::BoardView read_board_by_map(const std::string& view_name, const std::vector<ViewU8>& captures,
                                     const pattern::ComplementaryFrames& frames, const LightMap& light,
                                     const ViewU8& flat_lit, const Board& board) {
  Detections in_camera = detect::detect_board(flat_lit, board), in_projector;
  in_projector.image_size = light.projector_size;
  // Exchanged captures are two wrong frames as well.
  const bool is_exchanged = light.diagnostics.find("frames_exchanged") != nullptr;
  const pattern::SequenceCheck sequence =
      is_exchanged ? pattern::SequenceCheck{}
                   : pattern::check_sequence(captures, frames, pixels_of(in_camera));
  if (sequence.decoding_is_wrong) in_camera = detect::detect_board(last_light(captures, frames), board);
  const bool is_readable =
      !is_exchanged && !sequence.decoding_is_wrong && light.diagnostics.find("waves_disagree") == nullptr;
  if (!in_camera.observations.empty() && is_readable)
    in_projector = pattern::project_board(in_camera, board, detect::board_artwork(board), light);
  for (const Diagnostic& remark : light.diagnostics.items)
    if (remark.code != "pair_not_complementary" || sequence.diagnostics.items.empty())
      in_camera.diagnostics.items.push_back(remark);
  add_remarks(sequence, in_camera);
  return {view_name, {in_camera, in_projector}, {}, decoded_preview(light)};
}

/// Phase shift, its waves numbered by coarser waves or by Gray code.
class PhasePattern : public SessionPattern {
 public:
  explicit PhasePattern(const pattern::PhaseShift& shown)
      : shown_(shown), complementary_(pattern::complementary_frames(pattern::frames(shown))) {}

  std::string text() const override {
    const bool gray = shown_.wave_number == pattern::WaveNumber::kGrayCode;
    return (gray ? "gray+phase:" : "phase:") + std::to_string(shown_.period) + "px";
  }
  std::string describe() const override { return pattern::describe(shown_); }
  std::vector<ImageU8> frames() const override { return pattern::frames(shown_); }
  int frame_count() const override { return pattern::frame_count(shown_); }

  session::BoardView read(const std::string& view_name, const std::vector<ViewU8>& captures,
                          const Board& board) const override {
    return read_board_by_map(view_name, captures, complementary_, pattern::decode(captures, shown_),
                             pattern::flat_light(captures, shown_), board);
  }
  std::optional<PatternLight> read_light_map(const std::vector<ViewU8>& captures) const override {
    return PatternLight{pattern::decode(captures, shown_), pattern::flat_light(captures, shown_)};
  }

 private:
  pattern::PhaseShift shown_;
  pattern::ComplementaryFrames complementary_;
};

/// Another program's frames, by their description.
class DescribedPattern : public SessionPattern {
 public:
  DescribedPattern(const FrameSequence& sequence, ImageSize projector_size)
      : sequence_(sequence), projector_size_(projector_size) {
    pattern::require_decodable(sequence, projector_size);
  }

  std::string text() const override { return kPatternFile; }
  std::string describe() const override { return pattern::describe(sequence_, projector_size_); }
  std::vector<ImageU8> frames() const override { return pattern::frames(sequence_, projector_size_); }
  int frame_count() const override { return int(sequence_.frames.size()); }
  void save_files(const std::filesystem::path& session_folder) const override {
    io::save_pattern(session_folder / kPatternFile, sequence_);
  }

  session::BoardView read(const std::string& view_name, const std::vector<ViewU8>& captures,
                          const Board& board) const override {
    if (!pattern::is_gray_code(sequence_))
      return read_board_by_map(view_name, captures, pattern::complementary_frames(frames()),
                               pattern::decode(captures, sequence_, projector_size_),
                               pattern::flat_light(captures, sequence_, projector_size_), board);
    const pattern::GrayCaptures ordered = pattern::gray_captures(captures, sequence_, projector_size_);
    session::BoardView view =
        read_gray(view_name, ordered.captures, ordered.gray_code, board, gray_reading(ordered));
    for (Detections& detections : view.detections)
      for (Diagnostic& remark : detections.diagnostics.items)
        remark.message = with_original_numbers(remark.message, ordered.original);
    return view;
  }
  std::optional<PatternLight> read_light_map(const std::vector<ViewU8>& captures) const override {
    if (!pattern::is_gray_code(sequence_))
      return PatternLight{pattern::decode(captures, sequence_, projector_size_),
                          pattern::flat_light(captures, sequence_, projector_size_)};
    const pattern::GrayCaptures ordered = pattern::gray_captures(captures, sequence_, projector_size_);
    return gray_light(ordered.captures, ordered.gray_code, gray_reading(ordered));
  }

 private:
  GrayReading gray_reading(const pattern::GrayCaptures& ordered) const {
    return {ordered.has_all_inverses,
            {sequence_.offset[0] * sequence_.step, sequence_.offset[1] * sequence_.step},
            projector_size_};
  }

  /// "frame 20 (row bit 9)": the number in procam's order becomes that of the capture.
  static std::string with_original_numbers(const std::string& text, const std::vector<int>& original) {
    static const std::regex number("frame ([0-9]+) \\(");
    std::string renumbered;
    auto rest = text.cbegin();
    for (std::sregex_iterator match(text.begin(), text.end(), number), end; match != end; ++match) {
      const std::size_t shown = std::size_t(std::stoul((*match)[1]));
      renumbered.append(rest, text.cbegin() + match->position());
      renumbered += "frame ";
      if (shown < original.size() && original[shown] >= 0)
        renumbered += std::to_string(original[shown]) + " ";
      renumbered += "(";
      rest = text.cbegin() + match->position() + match->length();
    }
    return renumbered.append(rest, text.cend());
  }

  FrameSequence sequence_;
  ImageSize projector_size_;
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

}  // namespace

const std::vector<PatternRow>& pattern_table() {
  static const std::vector<PatternRow> table{
      {"gray", "stripes in black and white, 42 frames for 1024x768; the most robust", make_gray},
      {"phase", "cosine waves, 32 frames for 1024x768; needs a projector or camera without clipped greys",
       make_phase},
      {"gray+phase", "both, 46 frames for 1024x768; where phase unwrapping is ambiguous", make_gray_phase},
      {"chessboard", "a projected chessboard next to the printed one, 2 frames, or 1 with chessboard:colour",
       make_chessboard},
      {"charuco", "the same with markers: a part of it on the paper is enough", make_charuco},
      {"markers", "a projected grid of markers next to the print; a part is enough", make_markers},
      {"circles", "projected staggered discs next to the print, all on the paper", make_circles},
  };
  return table;
}

std::unique_ptr<SessionPattern> make_pattern(const std::string& text, ImageSize projector_size, int step) {
  if (const std::filesystem::path file(text); file.extension() == ".json") try {
      return std::make_unique<DescribedPattern>(io::load_pattern(file), projector_size);
    } catch (const Error& error) {
      if (error.subject().find(file.string()) == 0) throw;
      throw Error(error.kind(), file.string() + ", " + error.subject(), error.why(), error.next());
    }
  const std::size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  for (const PatternRow& row : pattern_table())
    if (name == row.name)
      return row.make(colon == std::string::npos ? "" : text.substr(colon + 1), projector_size, step);
  std::vector<std::string> known;
  for (const PatternRow& row : pattern_table()) known.emplace_back(row.name);
  refuse(text, "there is no such pattern",
         internal::did_you_mean(name, known) + "the patterns are " + comma_list(known) +
             ", or a pattern file (.json)");
}

std::string pattern_help() {
  std::string help;
  for (const PatternRow& row : pattern_table())
    help += (help.empty() ? "" : " | ") + std::string(row.name) + " (" + row.about + ")";
  return help + " | FILE.json (another program's frames, described: docs/patterns.md)";
}

}  // namespace procam::session
