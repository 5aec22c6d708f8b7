#pragma once
/// Where depth pictures come from, as they are: 16-bit numbers of a stated unit (depth/depth_image.hpp says
/// what they mean).
///
///   watch:FOLDER        files that appear there from now on, written by whatever drives the sensor
///   folder:FOLDER[@HZ]  those that are there, in natural order, once through at 30 or HZ a second
///   camera:NUMBER       an OpenNI2 sensor where this OpenCV has that driver, else a camera that delivers 16
///                       bits
///
/// Every source listens on a thread of its own, so that a picture's time is that of its arrival, and holds
/// the newest few.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/image.hpp"

namespace procam::device {

struct SeenDepth {
  Image<std::uint16_t> units;
  double time_s = 0;  ///< of arrival, clock of now_s()
};

class DepthSource {
 public:
  virtual ~DepthSource() = default;

  /// The oldest picture at hand that arrived after `after_s`; waits for one up to `timeout_s`, then nullopt.
  /// Throws Error(kDevice) when the sensor is gone or its file cannot be read, and at a folder's end.
  virtual std::optional<SeenDepth> next(double after_s, double timeout_s) = 0;
};

/// Reads a whole depth picture (io::load_depth); throws Error for one that is damaged or not complete yet.
using ReadDepth = std::function<Image<std::uint16_t>(const std::filesystem::path&)>;

/// One row of the table.
struct DepthKind {
  const char* name;
  const char* form;
  std::unique_ptr<DepthSource> (*open)(const std::string& rest, const ReadDepth& read);
};
const std::vector<DepthKind>& depth_kinds();

/// Opens a source by its text. Throws Error(kInput) for a text that names none, Error(kDevice) for one that
/// cannot be opened.
std::unique_ptr<DepthSource> open_depth(const std::string& what, const ReadDepth& read);

}  // namespace procam::device
