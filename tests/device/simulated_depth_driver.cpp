/// A driver for OpenNI2 whose sensor shows what a test writes (support/simulated_sensor.hpp says how). Like
/// real ones it mirrors its pictures unless told not to, has several modes, and can be unplugged.
#include <sys/stat.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

// The export macro below wants these two of OpenNI2's own build.
#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(pointer) delete (pointer)
#include <Driver/OniDriverAPI.h>

namespace {

constexpr const char* kUri = "simulated/depth";

OniVideoMode kModes[] = {{ONI_PIXEL_FORMAT_SHIFT_9_2, 320, 240, 60},
                         {ONI_PIXEL_FORMAT_DEPTH_1_MM, 320, 240, 30},
                         {ONI_PIXEL_FORMAT_DEPTH_100_UM, 320, 240, 30},
                         {ONI_PIXEL_FORMAT_DEPTH_1_MM, 160, 120, 30},
                         {ONI_PIXEL_FORMAT_DEPTH_1_MM, 640, 480, 30}};

template <typename Value>
OniStatus put(const Value& value, void* data, int* size) {
  if (*size < int(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &value, sizeof value);
  *size = int(sizeof value);
  return ONI_STATUS_OK;
}

struct Picture {
  int width = 0, height = 0;
  unsigned long long stamp_us = 0;
  std::vector<std::uint16_t> tenths;  ///< of a millimetre
};

class Stream : public oni::driver::StreamBase {
 public:
  OniStatus start() override {
    runs_ = true;
    return ONI_STATUS_OK;
  }
  void stop() override { runs_ = false; }
  OniBool isPropertySupported(int id) override {
    char value[64];
    int size = sizeof value;
    return getProperty(id, value, &size) == ONI_STATUS_OK ? TRUE : FALSE;
  }
  OniStatus getProperty(int id, void* data, int* size) override {
    if (id == ONI_STREAM_PROPERTY_VIDEO_MODE) return put(mode_, data, size);
    if (id == ONI_STREAM_PROPERTY_MIRRORING) return put(mirrored_, data, size);
    if (id == ONI_STREAM_PROPERTY_STRIDE) return put(2 * mode_.resolutionX, data, size);
    if (id == ONI_STREAM_PROPERTY_CROPPING) return put(OniCropping{}, data, size);
    if (id == ONI_STREAM_PROPERTY_MAX_VALUE) return put(int(10000), data, size);
    if (id == ONI_STREAM_PROPERTY_HORIZONTAL_FOV) return put(1.0f, data, size);
    if (id == ONI_STREAM_PROPERTY_VERTICAL_FOV) return put(0.8f, data, size);
    return ONI_STATUS_NOT_IMPLEMENTED;
  }
  OniStatus setProperty(int id, const void* data, int size) override {
    if (id == ONI_STREAM_PROPERTY_MIRRORING && size == int(sizeof mirrored_)) {
      std::memcpy(&mirrored_, data, sizeof mirrored_);
      return ONI_STATUS_OK;
    }
    if (id == ONI_STREAM_PROPERTY_VIDEO_MODE && size == int(sizeof mode_)) {
      OniVideoMode wanted;
      std::memcpy(&wanted, data, sizeof wanted);
      for (const OniVideoMode& mode : kModes)
        if (std::memcmp(&mode, &wanted, sizeof mode) == 0) {
          mode_ = mode;
          return ONI_STATUS_OK;
        }
      return ONI_STATUS_BAD_PARAMETER;
    }
    return ONI_STATUS_NOT_IMPLEMENTED;
  }

  /// What a recording holds of a stream besides its pictures.
  void notifyAllProperties() override {
    for (const int id : {ONI_STREAM_PROPERTY_VIDEO_MODE, ONI_STREAM_PROPERTY_STRIDE,
                         ONI_STREAM_PROPERTY_CROPPING, ONI_STREAM_PROPERTY_MIRRORING}) {
      char value[64];
      int size = sizeof value;
      if (getProperty(id, value, &size) == ONI_STATUS_OK) raisePropertyChanged(id, value, size);
    }
  }

  void show(const Picture& picture) {
    if (!runs_ || picture.width != mode_.resolutionX || picture.height != mode_.resolutionY) return;
    OniFrame* frame = getServices().acquireFrame();
    if (frame == nullptr) return;
    frame->sensorType = ONI_SENSOR_DEPTH;
    frame->videoMode = mode_;
    frame->width = picture.width;
    frame->height = picture.height;
    frame->stride = 2 * picture.width;
    frame->dataSize = frame->stride * picture.height;
    frame->croppingEnabled = FALSE;
    frame->cropOriginX = frame->cropOriginY = 0;
    frame->timestamp = picture.stamp_us;
    frame->frameIndex = ++index_;
    auto* to = static_cast<std::uint16_t*>(frame->data);
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x) {
        const int from = mirrored_ ? picture.width - 1 - x : x;
        const std::uint16_t value = picture.tenths[std::size_t(y * picture.width + from)];
        *to++ = mode_.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_1_MM ? std::uint16_t((value + 5) / 10) : value;
      }
    raiseNewFrame(frame);
    getServices().releaseFrame(frame);
  }

 private:
  std::atomic<bool> runs_{false};
  OniVideoMode mode_ = kModes[3];
  OniBool mirrored_ = TRUE;
  int index_ = 0;
};

class Device : public oni::driver::DeviceBase {
 public:
  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override {
    *sensors = &info_;
    *count = 1;
    return ONI_STATUS_OK;
  }
  oni::driver::StreamBase* createStream(OniSensorType) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    auto* stream = new Stream;
    streams_.insert(stream);
    return stream;
  }
  void destroyStream(oni::driver::StreamBase* stream) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    streams_.erase(static_cast<Stream*>(stream));
    delete stream;
  }
  void show(const Picture& picture) {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (Stream* stream : streams_) stream->show(picture);
  }

 private:
  OniSensorInfo info_{ONI_SENSOR_DEPTH, int(std::size(kModes)), kModes};
  std::mutex mutex_;
  std::set<Stream*> streams_;
};

class Driver : public oni::driver::DriverBase {
 public:
  explicit Driver(OniDriverServices* services) : DriverBase(services) {
    std::snprintf(info_.uri, sizeof info_.uri, "%s", kUri);
    std::snprintf(info_.vendor, sizeof info_.vendor, "procam");
    std::snprintf(info_.name, sizeof info_.name, "simulated");
  }
  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    const OniStatus status = DriverBase::initialize(connected, disconnected, changed, cookie);
    const char* folder = std::getenv("PROCAM_SIMULATED_SENSOR");
    if (status != ONI_STATUS_OK || folder == nullptr) return status;
    folder_ = folder;
    look();
    thread_ = std::thread([this] {
      while (!ends_) {
        look();
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
      }
    });
    return status;
  }
  oni::driver::DeviceBase* deviceOpen(const char*, const char*) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return device_ = new Device;
  }
  void deviceClose(oni::driver::DeviceBase* device) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (device == device_) device_ = nullptr;
    delete device;
  }
  OniStatus tryDevice(const char*) override { return ONI_STATUS_NO_DEVICE; }
  void shutdown() override {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  void look() {
    struct stat file {};
    const bool is_plugged = stat((folder_ + "/plugged").c_str(), &file) == 0;
    if (is_plugged != was_plugged_) {
      was_plugged_ = is_plugged;
      if (is_plugged)
        deviceConnected(&info_);
      else
        deviceDisconnected(&info_);
    }
    const std::string name = folder_ + "/picture";
    if (!is_plugged || stat(name.c_str(), &file) != 0) return;
    if (file.st_ino == last_.st_ino && file.st_mtim.tv_sec == last_.st_mtim.tv_sec &&
        file.st_mtim.tv_nsec == last_.st_mtim.tv_nsec)
      return;
    last_ = file;
    std::ifstream in(name, std::ios::binary);
    Picture picture;
    in >> picture.width >> picture.height >> picture.stamp_us;
    in.ignore(1);
    picture.tenths.resize(std::size_t(picture.width) * std::size_t(picture.height));
    in.read(reinterpret_cast<char*>(picture.tenths.data()), std::streamsize(2 * picture.tenths.size()));
    if (!in) return;
    const std::lock_guard<std::mutex> lock(mutex_);
    if (device_ != nullptr) device_->show(picture);
  }

  OniDeviceInfo info_{};
  std::string folder_;
  bool was_plugged_ = false;
  struct stat last_ {};
  std::mutex mutex_;
  Device* device_ = nullptr;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace

ONI_EXPORT_DRIVER(Driver)
