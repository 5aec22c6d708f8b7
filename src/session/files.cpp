#include "procam/session/files.hpp"

#include <system_error>
#include <utility>

#include "procam/io/image/images.hpp"
#include "procam/io/text.hpp"

namespace procam::session {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void cannot(const std::string& verb, const fs::path& path, const std::error_code& error) {
  throw Error(ErrorKind::kIo, path.string(), "cannot " + verb + " it: " + error.message(),
              "check the disk and whether you may write there");
}

void move_to(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) cannot("rename", from, error);
}

/// stem0, stem1, ...: the first that is not there.
fs::path first_free(const fs::path& stem) {
  for (int number = 0;; ++number) {
    fs::path path = stem;
    path += std::to_string(number);
    std::error_code ignored;
    if (!fs::exists(path, ignored)) return path;
  }
}

}  // namespace

std::string numbered(const std::string& stem, std::size_t number, const std::string& extension) {
  return stem + (number < 10 ? "_0" : "_") + std::to_string(number) + extension;
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder, error)) cannot("make", folder, error);
}

io::SessionInfo describe_session(const SessionPattern& pattern, ImageSize projector_size,
                                 const std::optional<Board>& board, int step) {
  io::SessionInfo session;
  session.pattern = pattern.text();
  session.projector_size = projector_size;
  session.board = board;
  if (step != 1) session.step = step;
  return session;
}

void require_same_session(const fs::path& folder, const io::SessionInfo& session) {
  const std::optional<io::SessionInfo> there = io::load_session(folder);
  if (!there) return;
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorKind::kInput, (folder / "session.json").string(), "it is a session with another " + what,
                "give the same flags to go on with it, or another folder");
  };
  if (there->pattern != session.pattern) refuse("pattern (" + there->pattern + ")");
  if (there->projector_size != session.projector_size) refuse("projector size");
  if (there->projectors != session.projectors) refuse("set of projectors");
  if (there->step.value_or(1) != session.step.value_or(1)) refuse("stripe width");
  if (there->board && session.board && !(*there->board == *session.board))
    refuse("board (" + io::format_board(*there->board) + ")");
}

ViewWriter::ViewWriter(const fs::path& session, std::size_t view, std::vector<std::string> stacks)
    : session_(session), place_(session / numbered("view", view)), stacks_(std::move(stacks)) {
  work_ = session / ("." + place_.filename().string() + ".partial");
  begin();
}

void ViewWriter::begin() {
  kept_.assign(stacks_.size(), 0);
  for (std::size_t stack = 0; stack < stacks_.size(); ++stack) {
    make_folder(work_ / stacks_[stack]);
    std::error_code ignored;
    while (fs::exists(frame_file(kept_[stack], stack), ignored)) ++kept_[stack];
  }
}

fs::path ViewWriter::frame_file(int frame, std::size_t stack) const {
  return work_ / stacks_[stack] / numbered("frame", std::size_t(frame), ".png");
}

void ViewWriter::keep(ViewU8 frame, std::size_t stack) {
  io::save_image(frame_file(kept_[stack], stack), frame);
  ++kept_[stack];
}

void ViewWriter::keep_rejected(ViewU8 frame, const std::string& why, std::size_t stack) {
  const fs::path folder = work_ / stacks_[stack] / "rejected";
  make_folder(folder);
  for (int number = 0;; ++number) {
    const fs::path file = folder / (numbered("frame", std::size_t(kept_[stack])) + "_" + why +
                                    numbered("", std::size_t(number)) + ".png");
    std::error_code ignored;
    if (fs::exists(file, ignored)) continue;
    io::save_image(file, frame);
    return;
  }
}

void ViewWriter::finish() {
  move_to(work_, place_);
}

void ViewWriter::set_aside() {
  move_to(work_, first_free(session_ / ("." + place_.filename().string() + ".set_aside_")));
  begin();
}

bool is_complete(const fs::path& session, std::size_t view) {
  std::error_code ignored;
  return fs::is_directory(session / numbered("view", view), ignored);
}

fs::path make_checks_folder(const fs::path& session) {
  const fs::path folder = first_free(session / ".checks_");
  make_folder(folder);
  return folder;
}

}  // namespace procam::session
