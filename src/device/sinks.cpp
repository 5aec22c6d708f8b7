#include "sinks.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "procam/io/image/images.hpp"

namespace procam::device {

namespace internal {

void require_frame(ViewU8 picture, ImageSize size) {
  require(picture.size() == size && (picture.channels == 1 || picture.channels == 3),
          "FrameSink: the picture has not the sink's size, or neither 1 nor 3 channels");
}

void copy_rgb(ViewU8 picture, std::uint8_t* out) {
  for (int y = 0; y < picture.height; ++y, out += 3 * picture.width) {
    const std::uint8_t* row = picture.row(y);
    if (picture.channels == 3)
      std::memcpy(out, row, std::size_t(3 * picture.width));
    else
      for (int x = 0; x < picture.width; ++x) std::memset(out + 3 * x, row[x], 3);
  }
}

}  // namespace internal

namespace {

class FolderSink : public FrameSink {
 public:
  FolderSink(const std::string& folder, const SinkOptions& options) : folder_(folder), options_(options) {
    std::error_code failed;
    std::filesystem::create_directories(folder_, failed);
    if (failed) throw Error(ErrorKind::kIo, folder, failed.message(), "give a folder that can be written");
  }
  ImageSize size() const override { return options_.size; }
  double show(ViewU8 picture) override {
    internal::require_frame(picture, options_.size);
    char name[32];
    std::snprintf(name, sizeof name, "frame_%06lld.png", number_++);
    io::save_image(folder_ / name, picture);
    return now_s();
  }

 private:
  std::filesystem::path folder_;
  SinkOptions options_;
  long long number_ = 0;
};

class StreamSink : public FrameSink {
 public:
  explicit StreamSink(const SinkOptions& options)
      : size_(options.size), bytes_(std::size_t(3 * size_.width) * std::size_t(size_.height)) {
    if (isatty(STDOUT_FILENO) != 0)
      throw Error(ErrorKind::kDevice, "stdout", "it is a terminal, which shows no frames",
                  "pipe it into a program");
    // A reader that goes away is told by write(), not by a signal that ends the program.
    std::signal(SIGPIPE, SIG_IGN);
  }
  ImageSize size() const override { return size_; }
  double show(ViewU8 picture) override {
    internal::require_frame(picture, size_);
    internal::copy_rgb(picture, bytes_.data());
    for (std::size_t done = 0; done < bytes_.size();) {
      const ssize_t wrote = write(STDOUT_FILENO, bytes_.data() + done, bytes_.size() - done);
      if (wrote < 0 && errno == EINTR) continue;
      if (wrote <= 0)
        throw Error(ErrorKind::kDevice, "stdout", std::string("its reader is gone: ") + std::strerror(errno),
                    "start both again");
      done += std::size_t(wrote);
    }
    return now_s();
  }

 private:
  ImageSize size_;
  std::vector<std::uint8_t> bytes_;
};

class NoSink : public FrameSink {
 public:
  explicit NoSink(ImageSize size) : size_(size) {}
  ImageSize size() const override { return size_; }
  double show(ViewU8 picture) override {
    internal::require_frame(picture, size_);
    return now_s();
  }

 private:
  ImageSize size_;
};

}  // namespace

std::unique_ptr<FrameSink> open_sink(const std::string& text, const SinkOptions& options) {
  require(options.size.width > 0 && options.size.height > 0 && options.fps > 0, "open_sink: no size or rate");
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon),
                    rest = colon == std::string::npos ? "" : text.substr(colon + 1);
  if (kind == "frames" && !rest.empty()) return std::make_unique<FolderSink>(rest, options);
  if (kind == "video" && !rest.empty()) return internal::open_video(rest, options);
  if (kind == "shm" && !rest.empty()) return internal::open_shared(rest, options);
  if (text == "stdout") return std::make_unique<StreamSink>(options);
  if (text == "none") return std::make_unique<NoSink>(options.size);
  throw Error(ErrorKind::kInput, "output '" + text + "'", "it names no place for frames",
              "use frames:FOLDER, video:FILE, stdout, shm:NAME or none");
}

const Display& find_display(const std::vector<Display>& list, const std::string& text) {
  std::string known;
  for (const Display& display : list)
    known += (known.empty() ? "" : ", ") + std::to_string(display.number) + " (" + display.name + ", " +
             std::to_string(display.size.width) + "x" + std::to_string(display.size.height) + " at " +
             std::to_string(display.x) + "," + std::to_string(display.y) + ")";
  const auto refuse = [&](const std::string& why) {
    return Error(ErrorKind::kInput, "display '" + text + "'", why,
                 known.empty() ? "connect one" : "choose one of: " + known);
  };
  if (text.empty()) throw refuse("no display is named so");
  if (text.find_first_not_of("0123456789") == std::string::npos) {
    for (const Display& display : list)
      if (std::to_string(display.number) == text) return display;
    throw refuse("there is no display of this number");
  }
  int x = 0, y = 0, end = 0;
  if (std::sscanf(text.c_str(), "%d,%d%n", &x, &y, &end) == 2 && std::size_t(end) == text.size()) {
    for (const Display& display : list)
      if (x >= display.x && x < display.x + display.size.width && y >= display.y &&
          y < display.y + display.size.height)
        return display;
    throw refuse("no display shows this place");
  }
  const Display* found = nullptr;
  for (const Display& display : list) {
    if (display.name == text) return display;
    if (display.name.find(text) == std::string::npos) continue;
    if (found != nullptr) throw refuse("several displays have it in their names");
    found = &display;
  }
  if (found == nullptr) throw refuse("no display is named so");
  return *found;
}

const Display& choose_display(const std::vector<Display>& list, const std::optional<std::string>& wanted) {
  if (list.empty())
    throw Error(ErrorKind::kDevice, "display", "there is none",
                "connect the projector, and check the graphics driver");
  if (wanted) return find_display(list, *wanted);
  for (const Display& display : list)
    if (!display.is_primary) return display;
  return list.front();
}

}  // namespace procam::device
