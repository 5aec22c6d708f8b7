#include "procam/session/shown_views.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <system_error>

#include "photographed_views.hpp"
#include "procam/detect/detect_board.hpp"
#include "procam/detect/shown_board.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/io/session/shown_file.hpp"
#include "procam/io/text.hpp"
#include "procam/pattern/sequence_check.hpp"

namespace procam::session {
namespace {

namespace fs = std::filesystem;

const char* const kUnlitEnding = "_unlit";

std::string counts(const Chessboard& board) {
  return std::to_string(board.columns) + "x" + std::to_string(board.rows);
}

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

bool is_unlit(const fs::path& image) {
  const std::string stem = image.stem().string(), ending = kUnlitEnding;
  return stem.size() > ending.size() &&
         stem.compare(stem.size() - ending.size(), std::string::npos, ending) == 0;
}

detect::ShownBoardOptions options_for(const pattern::ShownBoard& board, bool upright) {
  detect::ShownBoardOptions options;
  options.light_first = board.light_first;
  options.upright = upright;
  options.chessboard.counts_advice = "state in --shown that this view shows a board of ";
  return options;
}

/// In the same photograph as the projected board of that layout.
detect::BoardOptions print_beside(const Chessboard& shown) {
  detect::BoardOptions options;
  options.chessboard.others = {shown};
  return options;
}

/// Camera pixels of both boards.
Points2 points_of(const Detections& print, const Detections& light) {
  Points2 points;
  for (const Detections* board : {&print, &light})
    for (const Observation& corner : board->observations) points.push_back(corner.pixel);
  return points;
}

/// Boards by what shown.json calls them, each read once.
class Boards {
 public:
  Boards(const io::ShownInViews& stated, const fs::path& folder, ShownViews& shown)
      : stated_(stated), folder_(folder), shown_(shown) {}

  /// Frames first: they may be what tells the projector's size.
  std::size_t index_of(const std::string& name) {
    const auto [found, is_new] = indices_.try_emplace(name, shown_.boards.size());
    if (!is_new) return found->second;
    const auto numbers = stated_.boards.find(name);
    if (numbers != stated_.boards.end())
      shown_.boards.push_back(from_numbers(name, numbers->second));
    else
      shown_.boards.push_back(from_frame(folder_ / name));
    return found->second;
  }

 private:
  pattern::ShownBoard from_numbers(const std::string& name, const io::StatedBoard& board) const {
    if (shown_.projector_size.width == 0)
      throw Error(ErrorKind::kInput, "shown board '" + name + "'", "the projector's size is not known",
                  "give --projector-size 1024x768");
    return pattern::shown_board({board.columns, board.rows, board.step}, board.first_corner,
                                shown_.projector_size, "shown board '" + name + "'");
  }
  pattern::ShownBoard from_frame(const fs::path& file) {
    if (!is_there(file))
      throw Error(ErrorKind::kInput, file.string(),
                  "shown.json names it, and it is neither a file nor one of its boards",
                  "put the frame that was shown beside shown.json, or describe it under \"boards\"");
    const ImageU8 frame = io::to_gray(io::load_image(file).image);
    if (shown_.projector_size.width == 0) shown_.projector_size = frame.size();
    if (frame.size() != shown_.projector_size)
      throw Error(ErrorKind::kInput, file.string(),
                  "it is " + io::format_size(frame.size()) + ", the projector's frame " +
                      io::format_size(shown_.projector_size),
                  "give the frame as it was sent to the projector, and --projector-size accordingly");
    shown_.files.push_back(file);
    return pattern::read_shown_board(frame, file.string());
  }

  const io::ShownInViews& stated_;
  const fs::path folder_;
  ShownViews& shown_;
  std::map<std::string, std::size_t> indices_;
};

/// The photograph that a view of shown.json names, with or without its extension.
fs::path photograph_of(const fs::path& folder, const std::vector<fs::path>& images, const std::string& view) {
  std::vector<fs::path> fitting;
  for (const fs::path& image : images)
    if (image.filename() == view || image.stem() == view) fitting.push_back(image);
  if (fitting.empty())
    throw Error(ErrorKind::kInput, (folder / view).string(),
                "shown.json names this view, and it has no photograph",
                "check the name in shown.json, or put the photograph into the folder");
  if (fitting.size() > 1)
    throw Error(ErrorKind::kInput, (folder / view).string(),
                "two photographs have that name: " + fitting[0].filename().string() + " and " +
                    fitting[1].filename().string(),
                "name it with its extension in shown.json");
  return fitting.front();
}

fs::path unlit_of(const fs::path& photograph, const std::vector<fs::path>& images) {
  const std::string stem = photograph.stem().string() + kUnlitEnding;
  const auto found =
      std::find_if(images.begin(), images.end(), [&](const fs::path& image) { return image.stem() == stem; });
  return found == images.end() ? fs::path() : *found;
}

void require_order_settled(const ShownViews& shown) {
  for (const pattern::ShownBoard& board : shown.boards)
    if (!detect::order_is_settled(board.layout, options_for(board, shown.upright)))
      throw Error(
          ErrorKind::kInput, "projected chessboard of " + counts(board.layout) + " inner corners",
          (board.layout.columns + board.layout.rows) % 2 == 0
              ? "it looks the same after half a turn, so a photograph cannot show which corner is the "
                "first"
              : "its numbers do not include the colours of its squares, so a photograph cannot show "
                "which corner is the first",
          "if the projector's frame appears upright in the photographs, give --upright (or \"upright\": "
          "true in shown.json); else show a board with one odd and one even count, as a frame");
}

void require_distinct_counts(const ShownViews& shown, const Board& printed) {
  const auto* print = std::get_if<Chessboard>(&printed);
  if (print == nullptr) return;
  for (const pattern::ShownBoard& board : shown.boards)
    if (std::minmax(board.layout.columns, board.layout.rows) == std::minmax(print->columns, print->rows))
      throw Error(ErrorKind::kInput, "projected chessboard of " + counts(board.layout) + " inner corners",
                  "the printed board has the same counts, so that one photograph cannot show which is which",
                  "show or print a board with other counts");
}

}  // namespace

std::optional<ShownViews> plan_shown_views(const fs::path& folder, const ShownFlags& flags,
                                           std::optional<ImageSize> projector_size, const Board& printed) {
  const fs::path file = flags.shown.empty() ? folder / "shown.json" : flags.shown;
  if (flags.shown.empty() && !is_there(file)) return std::nullopt;
  ShownViews shown;
  if (projector_size) shown.projector_size = *projector_size;
  io::ShownInViews stated;
  if (file.extension() == ".json") {
    stated = io::load_shown(file);
    shown.files.push_back(file);
  } else {
    stated.all_views = file.filename().string();
  }
  shown.upright = flags.upright || stated.upright;

  Boards boards(stated, file.parent_path(), shown);
  std::set<fs::path> frames;
  for (const auto& [view, name] : stated.views)
    if (stated.boards.count(name) == 0) boards.index_of(name);
  const std::vector<fs::path> images = io::list_images(folder);
  const auto add = [&](const fs::path& photograph, const std::string& name) {
    shown.views.push_back(
        {photograph.stem().string(), photograph, unlit_of(photograph, images), boards.index_of(name)});
  };
  for (const auto& [view, name] : stated.views) add(photograph_of(folder, images, view), name);
  if (!stated.all_views.empty()) {
    boards.index_of(stated.all_views);
    for (const fs::path& image : images)
      if (!is_unlit(image) && image.filename() != stated.all_views) add(image, stated.all_views);
  }
  std::sort(shown.views.begin(), shown.views.end(), [](const auto& a, const auto& b) {
    return io::natural_less(a.photograph.filename().string(), b.photograph.filename().string());
  });
  if (shown.views.empty())
    throw Error(ErrorKind::kInput, folder.string(), "it holds no photograph",
                "give a folder with one photograph a view");
  require_order_settled(shown);
  require_distinct_counts(shown, printed);
  return shown;
}

session::BoardView read_shown_view(const ShownViews& shown, const PhotographedView& view,
                                   const ImageU8& photograph, const ImageU8& unlit, const Board& printed) {
  session::BoardView seen{view.name, {{}, {}}};
  Detections& print = seen.detections[kCameraDevice];
  const pattern::ShownBoard& board = shown.boards[view.board];
  if (!unlit.empty()) print = detect::detect_board(unlit, printed);
  if (print.observations.empty())
    print = detect::detect_board(photograph, printed, print_beside(board.layout));
  Detections& light = seen.detections[kProjectorDevice];
  light.image_size = shown.projector_size;

  detect::ShownBoardOptions options = options_for(board, shown.upright);
  if (const auto* chessboard = std::get_if<Chessboard>(&printed)) options.chessboard.others = {*chessboard};
  const Detections found = detect::detect_shown_board(photograph, board.layout, options);
  for (Diagnostic remark : found.diagnostics.items) {
    remark.message = "the projected chessboard: " + remark.message;
    light.diagnostics.items.push_back(remark);
  }
  for (const Observation& corner : found.observations)
    seen.light_points.push_back({kProjectorDevice, board.corners[std::size_t(corner.point)], kCameraDevice,
                                 corner.pixel, corner.covariance, corner.point});
  print.diagnostics.append(pattern::check_photograph(photograph, points_of(print, found)).diagnostics);
  return seen;
}

}  // namespace procam::session
