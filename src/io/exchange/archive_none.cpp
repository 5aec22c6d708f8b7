// procam without libzip: archives are refused with what to do.
#include "exchange/archive.hpp"
#include "procam/core/base/error.hpp"

namespace procam::io {
namespace {

[[noreturn]] void refuse_archive(const std::string& file) {
  throw Error(ErrorKind::kUnsupported, file,
              "procam was built without libzip, which reads and writes archives",
              "install libzip-dev and build procam again");
}

}  // namespace

struct Archive::Body {};

Archive::Archive(std::string, std::string file, std::size_t) {
  refuse_archive(file);
}
Archive::~Archive() = default;
std::vector<std::string> Archive::names() const {
  return {};
}
std::string Archive::read(const std::string& name) const {
  refuse_archive(name);
}

std::string make_archive(const std::vector<std::pair<std::string, std::string>>&) {
  refuse_archive("MPCDI archive");
}

}  // namespace procam::io
