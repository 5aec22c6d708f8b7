#include "depth_listener.hpp"

namespace procam::device::internal {

std::unique_ptr<DepthSource> open_openni2(const std::string& uri, const DepthOptions&) {
  throw Error(ErrorKind::kUnsupported, "depth camera openni2:" + uri, "procam was built without OpenNI2",
              "install libopenni2-dev and pkg-config and build again, or let the sensor's own program write "
              "pictures into a folder, and name that by depth:watch:FOLDER");
}

}  // namespace procam::device::internal
