/// A build without SQLite.
#include "message_log.hpp"
#include "procam/core/base/error.hpp"

namespace procam::dds::internal {

std::unique_ptr<MessageLog> open_db3(const std::filesystem::path& path) {
  throw Error(ErrorKind::kUnsupported, path.string(), "procam was built without SQLite",
              "install libsqlite3-dev and build procam again, or convert the bag to MCAP");
}

}  // namespace procam::dds::internal
