#include "procam/dds/image_source.hpp"

#include "image_input.hpp"

namespace procam::dds {

struct ImageTopic::Impl {
  std::unique_ptr<internal::ImageInput> input;

  static std::unique_ptr<Impl> open(const std::string& text, internal::ImageKind kind) {
    const std::string log = "log:";
    return std::make_unique<Impl>(Impl{text.compare(0, log.size(), log) == 0
                                           ? internal::open_log_images(text.substr(log.size()), kind)
                                           : internal::open_graph_images(text, kind)});
  }
};

ImageTopic::ImageTopic(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ImageTopic::ImageTopic(ImageTopic&&) noexcept = default;
ImageTopic& ImageTopic::operator=(ImageTopic&&) noexcept = default;
ImageTopic::~ImageTopic() = default;

bool ImageTopic::has_publisher() const {
  return impl_->input->has_publisher();
}
std::string ImageTopic::last_error() const {
  return impl_->input->last_error();
}
std::map<std::string, std::uint64_t> ImageTopic::rejected() const {
  return impl_->input->rejected();
}
std::string ImageTopic::description() const {
  return impl_->input->description();
}

ImageSource::ImageSource(const std::string& text)
    : ImageTopic(Impl::open(text, internal::ImageKind::kImage)) {}
std::optional<ReceivedImage> ImageSource::next(double timeout_s) {
  return impl_->input->next_image(timeout_s);
}

DepthImageSource::DepthImageSource(const std::string& text)
    : ImageTopic(Impl::open(text, internal::ImageKind::kDepth)) {}
std::optional<ReceivedDepth> DepthImageSource::next(double timeout_s) {
  return impl_->input->next_depth(timeout_s);
}

}  // namespace procam::dds
