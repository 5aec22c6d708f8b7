#include <OpenNI.h>

#include <array>
#include <cstring>

#include "depth_listener.hpp"
#include "procam/device/frame_sink.hpp"

namespace procam::device::internal {
namespace {

constexpr int kWait_ms = 100;            ///< for a picture, before asking whether to end
constexpr double kSensorPatience_s = 5;  ///< without a picture: sensors that hang are opened anew
constexpr const char* kLook = "check its cable and power, and that no other program uses it";

std::string words_of_openni2() {
  std::string words = openni::OpenNI::getExtendedError();
  while (!words.empty() && std::isspace(static_cast<unsigned char>(words.back())) != 0) words.pop_back();
  for (char& c : words)
    if (c == '\n' || c == '\t') c = ' ';
  return words.empty() ? "OpenNI2 does not say why" : words;
}

/// Started once, for the rest of the process: starting looks for drivers in the process' working folder and
/// changes it for that long, which other threads would notice. Sensors that come and go are told by drivers.
void start_openni2() {
  struct Library {
    openni::Status status = openni::OpenNI::initialize();
    Library() = default;
    Library(const Library&) = delete;
    Library& operator=(const Library&) = delete;
    ~Library() { openni::OpenNI::shutdown(); }
  };
  static const Library library;
  if (library.status != openni::STATUS_OK)
    throw depth_error("openni2:", "OpenNI2 does not start: " + words_of_openni2(),
                      "see to its drivers (libopenni2-0 brings those of PrimeSense's sensors)");
}

std::string sensors_there() {
  openni::Array<openni::DeviceInfo> sensors;
  openni::OpenNI::enumerateDevices(&sensors);
  std::string names;
  for (int i = 0; i < sensors.getSize(); ++i)
    names += std::string(names.empty() ? "there is " : ", ") + sensors[i].getUri() + " (" +
             sensors[i].getName() + ")";
  return names.empty() ? "no sensor is there" : names;
}

std::optional<double> unit_of(openni::PixelFormat format) {
  if (format == openni::PIXEL_FORMAT_DEPTH_1_MM) return 1e-3;
  if (format == openni::PIXEL_FORMAT_DEPTH_100_UM) return 1e-4;
  return std::nullopt;
}

class Openni2Depth : public DepthListener,
                     openni::OpenNI::DeviceDisconnectedListener,
                     openni::OpenNI::DeviceStateChangedListener {
 public:
  Openni2Depth(const std::string& uri, const DepthOptions& options) : name_("openni2:" + uri) {
    start_openni2();
    // Before it is opened, so that its loss is never missed.
    openni::OpenNI::addDeviceDisconnectedListener(this);
    openni::OpenNI::addDeviceStateChangedListener(this);
    try {
      open(uri, options);
    } catch (...) {
      close();
      throw;
    }
    listen([this] { read(); });
  }
  ~Openni2Depth() override {
    end();
    close();
  }

 private:
  void open(const std::string& uri, const DepthOptions& options) {
    if (device_.open(uri.empty() ? openni::ANY_DEVICE : uri.c_str()) != openni::STATUS_OK) {
      if (uri.size() > 4 && uri.compare(uri.size() - 4, 4, ".oni") == 0)
        throw depth_error(name_, "the recording cannot be opened (" + words_of_openni2() + ")",
                          "check its name, and that OpenNI2 wrote it to its end");
      throw depth_error(name_, "it cannot be opened (" + words_of_openni2() + "); " + sensors_there(), kLook);
    }
    uri_ = device_.getDeviceInfo().getUri();
    if (stream_.create(device_, openni::SENSOR_DEPTH) != openni::STATUS_OK)
      throw depth_error(name_, "it has no depth stream: " + words_of_openni2(), "name another sensor");
    if (device_.isFile()) {
      if (auto* playback = device_.getPlaybackControl()) playback->setRepeatEnabled(false);
    } else {
      choose_mode(options.size);
      // Depth as its own lens sees it: not mirrored, and not resampled into the colour camera's view.
      stream_.setMirroringEnabled(false);
      if (stream_.getMirroringEnabled())
        throw depth_error(name_, "its pictures are mirrored, and it refuses to stop that",
                          "turn mirroring off in the driver's own settings");
      device_.setImageRegistrationMode(openni::IMAGE_REGISTRATION_OFF);
    }
    if (stream_.start() != openni::STATUS_OK)
      throw depth_error(name_, "its depth stream does not start: " + words_of_openni2(), kLook);
  }

  /// The fastest mode of that size whose pixels are lengths; of equals the finer unit.
  void choose_mode(const std::optional<ImageSize>& size) {
    const openni::VideoMode now = stream_.getVideoMode();
    const ImageSize wanted = size.value_or(ImageSize{now.getResolutionX(), now.getResolutionY()});
    const openni::Array<openni::VideoMode>& modes = stream_.getSensorInfo().getSupportedVideoModes();
    const openni::VideoMode* best = nullptr;
    std::string others;
    for (int i = 0; i < modes.getSize(); ++i) {
      const openni::VideoMode& mode = modes[i];
      const auto unit = unit_of(mode.getPixelFormat());
      if (!unit) continue;
      const std::string text =
          std::to_string(mode.getResolutionX()) + "x" + std::to_string(mode.getResolutionY());
      if (others.find(text) == std::string::npos) others += (others.empty() ? "" : ", ") + text;
      if (mode.getResolutionX() != wanted.width || mode.getResolutionY() != wanted.height) continue;
      if (best == nullptr || mode.getFps() > best->getFps() ||
          (mode.getFps() == best->getFps() && *unit < *unit_of(best->getPixelFormat())))
        best = &mode;
    }
    if (best == nullptr)
      throw depth_error(name_,
                        "it has no mode of " + std::to_string(wanted.width) + "x" +
                            std::to_string(wanted.height) + " pixels" +
                            (others.empty() ? "" : "; it has " + others),
                        "calibrate the depth camera in one of its modes");
    // Another program that shares the sensor fixes its mode.
    const bool is_so = now.getPixelFormat() == best->getPixelFormat() && now.getFps() == best->getFps() &&
                       now.getResolutionX() == best->getResolutionX() &&
                       now.getResolutionY() == best->getResolutionY();
    if (!is_so && stream_.setVideoMode(*best) != openni::STATUS_OK)
      throw depth_error(name_, "it does not take its mode: " + words_of_openni2(), kLook);
  }

  void read() {
    double last = now_s();
    openni::VideoStream* const streams[] = {&stream_};
    while (!ends_) {
      // What has come before it was lost is handed out.
      int index = 0;
      const openni::Status waited =
          openni::OpenNI::waitForAnyStream(const_cast<openni::VideoStream**>(streams), 1, &index, kWait_ms);
      if (waited == openni::STATUS_TIME_OUT) {
        if (gone_) throw depth_error(name_, "it was unplugged", "plug it in again");
        if (at_end_) throw depth_error(name_, "its last picture was shown", "record more, or start again");
        if (now_s() - last > kSensorPatience_s) throw depth_error(name_, "it sends no pictures", kLook);
        continue;
      }
      openni::VideoFrameRef frame;
      if (waited != openni::STATUS_OK || stream_.readFrame(&frame) != openni::STATUS_OK || !frame.isValid())
        throw depth_error(name_, "no more pictures come from it: " + words_of_openni2(), kLook);
      last = now_s();
      queue_.push(picture_of(frame, last));
    }
  }

  SeenDepth picture_of(const openni::VideoFrameRef& frame, double arrival) const {
    const auto unit = unit_of(frame.getVideoMode().getPixelFormat());
    const int width = frame.getWidth(), height = frame.getHeight(), stride = frame.getStrideInBytes();
    if (!unit || frame.getCroppingEnabled())
      throw depth_error(name_,
                        unit ? "its pictures are cropped" : "its pictures are no lengths but raw shifts",
                        "choose whole pictures of 1 mm or 0.1 mm in the driver's settings, or record so");
    if (width < 1 || height < 1 || stride < width * 2 || frame.getDataSize() / stride < height)
      throw depth_error(name_, "a picture is not as large as it says", "update its driver");
    Image<std::uint16_t> units(width, height);
    const char* from = static_cast<const char*>(frame.getData());
    for (int y = 0; y < height; ++y, from += stride) std::memcpy(units.row(y), from, std::size_t(width) * 2);
    return {std::move(units), arrival, 1e-6 * double(frame.getTimestamp()), unit};
  }

  void close() {
    // OpenNI2's player of recordings (2.2, PlayerDevice::MainLoop) goes through its list of streams on a thread of its own,
    // without a lock. At the end of a recording it does nothing else, and destroying a stream beside it crashes: there the
    // device is closed first, which ends the thread. While pictures come, closing it first crashes: they outlive their buffers.
    if (at_end_) device_.close();
    stream_.destroy();
    device_.close();
    openni::OpenNI::removeDeviceDisconnectedListener(this);
    openni::OpenNI::removeDeviceStateChangedListener(this);
  }
  // On a thread of the driver's. Before the device is open, nothing can be said of it.
  void onDeviceDisconnected(const openni::DeviceInfo* sensor) override {
    if (uri_ == sensor->getUri()) gone_ = true;
  }
  void onDeviceStateChanged(const openni::DeviceInfo* sensor, openni::DeviceState state) override {
    if (uri_ == sensor->getUri() && state == openni::DEVICE_STATE_EOF) at_end_ = true;
  }

  std::string name_, uri_;
  openni::Device device_;
  openni::VideoStream stream_;
  std::atomic<bool> gone_{false}, at_end_{false};
};

}  // namespace

std::unique_ptr<DepthSource> open_openni2(const std::string& uri, const DepthOptions& options) {
  return std::make_unique<Openni2Depth>(uri, options);
}

}  // namespace procam::device::internal
