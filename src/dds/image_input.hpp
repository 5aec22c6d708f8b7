#pragma once
/// Where images come from: the graph, or a log.
#include <memory>
#include <string>

#include "procam/dds/image_source.hpp"

namespace procam::dds::internal {

/// next_...() are for one thread, the others for any.
class ImageInput {
 public:
  virtual ~ImageInput() = default;
  virtual bool has_publisher() const = 0;
  virtual std::string last_error() const = 0;
  virtual std::map<std::string, std::uint64_t> rejected() const = 0;
  virtual std::string description() const = 0;
  virtual std::optional<ReceivedImage> next_image(double timeout_s) = 0;
  virtual std::optional<ReceivedDepth> next_depth(double timeout_s) = 0;
};

enum class ImageKind { kImage, kDepth };
/// A topic, with remaps.
std::unique_ptr<ImageInput> open_graph_images(const std::string& topic, ImageKind kind);
/// What follows "log:".
std::unique_ptr<ImageInput> open_log_images(const std::string& rest, ImageKind kind);

}  // namespace procam::dds::internal
