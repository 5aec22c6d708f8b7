#include "procam/io/session/shown_file.hpp"

#include "document/fields.hpp"

namespace procam::io {

static void fields(Fields& f, StatedBoard& board) {
  f.field("columns", board.columns);
  f.field("rows", board.rows);
  f.check(board.columns >= 3 && board.rows >= 3, "columns", "a board needs 3x3 inner corners or more",
          "count the inner corners, one less than squares a side");
  f.field("first_corner", board.first_corner);
  f.field("step", board.step);
  f.check(board.step > 0, "step", "it is not positive", "give the side of a square in projector pixels");
}

static void fields(Fields& f, ShownInViews& shown) {
  header(f, "procam-shown", 1);
  if (!f.reading() || f.has("upright")) f.field("upright", shown.upright);
  if (f.reading() ? f.has("views") : !shown.views.empty()) f.map("views", shown.views);
  f.optional("all_views", shown.all_views);
  f.check(shown.views.empty() != shown.all_views.empty(), "views",
          shown.views.empty() ? "neither views nor all_views is given" : "all_views is given as well",
          "name what was shown in each view, or once what was shown in all of them");
  if (f.reading() ? f.has("boards") : !shown.boards.empty()) f.map("boards", shown.boards);
}

ShownInViews load_shown(const std::filesystem::path& path) {
  return load_noun<ShownInViews>(path, Syntax::kJson);
}

void save_shown(const std::filesystem::path& path, const ShownInViews& shown) {
  save_noun(path, Syntax::kJson, shown);
}

}  // namespace procam::io
