#include "control_page.hpp"

#include <atomic>
#include <mutex>
#include <utility>

#include "control_messages.hpp"
#include "control_page_html.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::show {

/// What the loop hands over, behind a mutex; the server's thread makes text and images of it.
class ControlPage::Page : public ServedPage {
 public:
  const char* html() override { return kControlPageHtml; }
  bool take(const std::string& message) override {
    std::optional<Command> command = to_command(message);
    if (!command) return false;
    const std::lock_guard<std::mutex> lock(mutex_);
    if (commands_.size() >= limits::kPageCommands) return false;
    commands_.push_back(std::move(*command));
    return true;
  }
  void update_state(PageData& state) override {
    std::optional<PageStatus> changed;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (state.number != status_number_) changed = status_;
      state.number = status_number_;
    }
    if (changed || state.bytes.empty()) state.bytes = to_json_text(changed ? *changed : PageStatus{});
  }
  void update_image(PageData& image) override {
    std::shared_ptr<const ImageU8> changed;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (image.number != frame_number_) changed = std::exchange(frame_, nullptr);
      if (changed) image.number = frame_number_;
    }
    if (changed) image.bytes = to_jpeg(*changed);
  }
  std::optional<PageFile> file(const std::string& path) override {
    if (path != "/metrics") return std::nullopt;
    const std::lock_guard<std::mutex> lock(mutex_);
    return PageFile{"text/plain; version=0.0.4", metrics_};
  }
  // A pointer ten times a second costs the loop nothing, and whoever asks for a frame gets a new one.
  void tick() override { wants_frame_ = true; }

  std::vector<Command> take_commands() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(commands_, {});
  }
  void publish(const PageStatus& status) {
    const std::lock_guard<std::mutex> lock(mutex_);
    status_ = status;
    ++status_number_;
  }
  void publish_metrics(std::string text) {
    const std::lock_guard<std::mutex> lock(mutex_);
    metrics_ = std::move(text);
  }
  void publish(std::shared_ptr<const ImageU8> frame) {
    const std::lock_guard<std::mutex> lock(mutex_);
    frame_ = std::move(frame);
    ++frame_number_;
    wants_frame_ = false;
  }
  bool wants_frame() const { return wants_frame_; }

 private:
  std::mutex mutex_;
  std::vector<Command> commands_;
  PageStatus status_;
  std::uint64_t status_number_ = 0;
  std::string metrics_;
  std::shared_ptr<const ImageU8> frame_;
  std::uint64_t frame_number_ = 0;
  std::atomic<bool> wants_frame_{true};
};

ControlPage::ControlPage(const ControlOptions& options)
    : page_(std::make_unique<Page>()), server_(std::make_unique<PageServer>(*page_, options)) {}
ControlPage::~ControlPage() = default;
std::string ControlPage::url() const {
  return server_->url();
}
std::vector<Command> ControlPage::take() {
  return page_->take_commands();
}
void ControlPage::publish(const PageStatus& status) {
  page_->publish(status);
}
void ControlPage::publish_metrics(std::string prometheus_text) {
  page_->publish_metrics(std::move(prometheus_text));
}
bool ControlPage::wants_frame() const {
  return page_->wants_frame();
}
PageFaults ControlPage::faults() const {
  return server_->faults();
}
void ControlPage::publish(std::shared_ptr<const ImageU8> frame) {
  page_->publish(std::move(frame));
}

}  // namespace procam::show
