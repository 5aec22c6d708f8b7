#pragma once
/// The studio's page between the server's thread and the desk's: state, images and files out, commands in.
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "procam/show/page_server.hpp"
#include "project.hpp"

namespace procam::studio {

/// What a person did on the page: {"do": "corner", "name": "wall", "text": "", "numbers": [2, 512.5, 300], "page": "k3x", "seen": 7}
struct StudioCommand {
  std::string verb, name, text;
  std::vector<double> numbers;
  std::string page = {};  ///< of the page that sends it, a random word; empty: a script
  std::optional<double> seen =
      {};  ///< revision of the state that the person saw when the edit began (edit_log.hpp)
};

/// nullopt for what is no command.
std::optional<StudioCommand> to_studio_command(const std::string& text);

class StudioPage : public show::ServedPage {
 public:
  explicit StudioPage(const Project& project)
      : board_sheet_(project.board_sheet()), report_(project.report()) {}

  const char* html() override;
  bool take(const std::string& message) override;
  void update_state(show::PageData& state) override;
  void update_image(show::PageData& image) override;
  std::optional<show::PageFile> file(const std::string& path) override;

  std::vector<StudioCommand> take_commands();
  void publish(std::string state);
  void publish(std::shared_ptr<const ImageU8> image);
  /// What a projector shows: GET /projector.png of the first, /projector_2.png of the second.
  void publish_frame(std::size_t projector, std::shared_ptr<const ImageU8> frame);
  /// Of a camera of the list: GET /camera_1.jpg of the first.
  void publish_preview(std::size_t camera, std::shared_ptr<const ImageU8> image);

 private:
  std::shared_ptr<const ImageU8> newest(const std::vector<std::shared_ptr<const ImageU8>>& of,
                                        std::size_t device);

  const std::filesystem::path board_sheet_, report_;
  std::mutex mutex_;
  std::vector<StudioCommand> commands_;
  std::string state_ = "{}";
  std::uint64_t state_number_ = 1;
  std::shared_ptr<const ImageU8> image_;
  std::vector<std::shared_ptr<const ImageU8>> frames_;    ///< one a projector
  std::vector<std::shared_ptr<const ImageU8>> previews_;  ///< one a camera of the list
  std::uint64_t image_number_ = 0;
};

}  // namespace procam::studio
