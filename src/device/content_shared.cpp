/// Another program's frames as content.
#include <chrono>
#include <thread>

#include "content_files.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/device/shared_frame.hpp"

namespace procam::device {
namespace {

class SharedContent : public ContentSource {
 public:
  SharedContent(const std::string& name, const ContentOptions& options)
      : name_(name), reader_(std::make_unique<SharedFrameReader>(name)) {
    const double end = now_s() + options.camera_patience_s;
    while (!reader_->read_newest(0, shown_)) {
      if (now_s() >= end || reader_->is_orphan())
        throw fault_of("no frame has been written to it", "look at what its writer says");
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    next_ = shown_;  // both have their memory
    looked_ = now_s();
  }

  ContentFrame at(double) override {
    if (reader_->read_newest(shown_.number, next_)) {
      std::swap(shown_, next_);
      ++revision_;
    }
    if (const double now = now_s(); now - looked_ >= 1) {
      looked_ = now;
      look_for_another();
    }
    return {shown_.image.view(), revision_};
  }

  std::optional<Error> fault() const override { return fault_; }

 private:
  Error fault_of(const std::string& why, const std::string& next) const {
    return Error(ErrorKind::kDevice, "shared memory '" + name_ + "'", why, next);
  }

  /// A writer that was started again has new memory.
  void look_for_another() {
    if (!reader_->is_orphan()) return fault_.reset();
    try {
      auto other = std::make_unique<SharedFrameReader>(name_);
      if (other->size() != shown_.image.size()) {
        fault_ = fault_of("its writer came back with frames of another size", "start this program again");
        return;
      }
      reader_ = std::move(other);
      shown_.number = 0;
      fault_.reset();
    } catch (const Error&) {
      fault_ = fault_of("its writer is gone, or its memory was cut short",
                        "start the writer again; the last frame stays until then");
    }
  }

  const std::string name_;
  std::unique_ptr<SharedFrameReader> reader_;
  SharedFrameReader::Frame shown_, next_;
  std::uint64_t revision_ = 0;
  double looked_ = 0;
  std::optional<Error> fault_;
};

}  // namespace

std::unique_ptr<ContentSource> internal::open_shared_content(const std::string& name,
                                                             const ContentOptions& options) {
  return std::make_unique<SharedContent>(name, options);
}

}  // namespace procam::device
