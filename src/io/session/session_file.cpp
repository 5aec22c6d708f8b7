#include "document/fields.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/io/text.hpp"

namespace procam::io {

static void fields(Fields& f, SessionInfo& session) {
  header(f, "procam-session", 1);
  f.optional("pattern", session.pattern);
  f.optional("projector_size", session.projector_size);
  // The board is written as the flag is typed, so that a person can copy one to the other.
  std::string board = session.board ? format_board(*session.board) : "";
  f.optional("board", board);
  if (f.reading() && !board.empty()) {
    try {
      session.board = parse_board(board);
    } catch (const Error& error) {
      f.check(false, "board", error.subject() + ": " + error.why(), error.next());
    }
  }
  f.optional("step", session.step);
  if (f.reading() ? f.has("projectors") : !session.projectors.empty())
    f.map("projectors", session.projectors);
  f.check(session.projectors.empty() || !session.projector_size, "projectors",
          "there is a projector_size as well",
          "state the size of one projector, or those of several by name");
  for (const auto& [name, size] : session.projectors)
    f.check(!name.empty() && name.find_first_of("/\\") == std::string::npos && name.front() != '.',
            "projectors", "'" + name + "' cannot be the name of a projector's folder",
            "give names like left and right");
  f.check(!session.step || *session.step >= 1, "step", "it is not positive",
          "give the stripe width in pixels");
}

std::optional<SessionInfo> load_session(const std::filesystem::path& session_folder) {
  const std::filesystem::path path = session_folder / "session.json";
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return std::nullopt;
  return load_noun<SessionInfo>(path, Syntax::kJson);
}

void save_session(const std::filesystem::path& session_folder, const SessionInfo& session) {
  save_noun(session_folder / "session.json", Syntax::kJson, session);
}

}  // namespace procam::io
