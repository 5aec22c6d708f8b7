#include <zip.h>

#include <array>

#include "exchange/archive.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::io {
namespace {

constexpr zip_uint64_t kLargestMember = std::size_t(1) << 40;  // of a sum that must not overflow
const char* const kNextArchive = "get the archive again from the program that made it";

[[noreturn]] void fail_archive(const std::string& file, const std::string& why) {
  throw Error(ErrorKind::kInput, file, why, kNextArchive);
}

struct CloseNewZip {
  void operator()(zip_t* zip) const { zip_discard(zip); }
};
struct CloseZipMember {
  void operator()(zip_file_t* member) const { zip_fclose(member); }
};
struct FreeZipSource {
  void operator()(zip_source_t* source) const { zip_source_free(source); }
};
using ZipSource = std::unique_ptr<zip_source_t, FreeZipSource>;

std::string text_of(zip_error_t* error) {
  std::string text = zip_error_strerror(error);
  zip_error_fini(error);
  return text;
}

}  // namespace

struct Archive::Body {
  struct CloseZip {
    void operator()(zip_t* open) const { zip_discard(open); }
  };
  std::string bytes, file;
  std::unique_ptr<zip_t, CloseZip> zip;
};

Archive::Archive(std::string bytes, std::string file, std::size_t largest_unpacked)
    : body_(std::make_unique<Body>()) {
  body_->bytes = std::move(bytes);
  body_->file = std::move(file);
  zip_error_t error;
  zip_error_init(&error);
  ZipSource source(zip_source_buffer_create(body_->bytes.data(), body_->bytes.size(), 0, &error));
  if (source) body_->zip.reset(zip_open_from_source(source.get(), ZIP_RDONLY | ZIP_CHECKCONS, &error));
  if (!body_->zip) fail_archive(body_->file, "it is not a whole zip archive: " + text_of(&error));
  (void)source.release();  // the archive owns it now

  const zip_int64_t members = zip_get_num_entries(body_->zip.get(), 0);
  if (members > limits::kArchiveMembers)
    fail_archive(body_->file, "it has " + std::to_string(members) + " members");
  zip_uint64_t unpacked = 0;
  for (zip_int64_t i = 0; i < members; ++i) {
    zip_stat_t about;
    zip_stat_init(&about);
    constexpr zip_uint64_t kNeeded = ZIP_STAT_NAME | ZIP_STAT_SIZE;
    if (zip_stat_index(body_->zip.get(), zip_uint64_t(i), ZIP_FL_ENC_RAW, &about) != 0 ||
        (about.valid & kNeeded) != kNeeded)
      fail_archive(body_->file, "its member " + std::to_string(i) + " has no name or size");
    const std::string name = about.name;
    if (leads_outside(name)) fail_archive(body_->file, "its member '" + name + "' leads out of the archive");
    unpacked += std::min(about.size, kLargestMember);
    if (unpacked > largest_unpacked)
      fail_archive(body_->file, "it unpacks to more than the " + std::to_string(largest_unpacked) +
                                    " bytes that such an archive may have");
  }
}

Archive::~Archive() = default;

std::vector<std::string> Archive::names() const {
  std::vector<std::string> names;
  const zip_int64_t members = zip_get_num_entries(body_->zip.get(), 0);
  for (zip_int64_t i = 0; i < members; ++i)
    names.emplace_back(zip_get_name(body_->zip.get(), zip_uint64_t(i), ZIP_FL_ENC_RAW));
  return names;
}

std::string Archive::read(const std::string& name) const {
  zip_t* const zip = body_->zip.get();
  const std::string what = body_->file + ": " + name;
  zip_int64_t index = zip_name_locate(zip, name.c_str(), ZIP_FL_ENC_RAW);
  if (index < 0) index = zip_name_locate(zip, name.c_str(), ZIP_FL_NOCASE);
  if (index < 0) fail_archive(what, "the archive has no such member");
  zip_stat_t about;
  zip_stat_init(&about);
  const std::unique_ptr<zip_file_t, CloseZipMember> member(zip_fopen_index(zip, zip_uint64_t(index), 0));
  if (!member || zip_stat_index(zip, zip_uint64_t(index), 0, &about) != 0)
    fail_archive(what, std::string("it cannot be unpacked: ") + zip_strerror(zip));
  std::string bytes;
  std::array<char, 65536> block;
  for (;;) {
    const zip_int64_t count = zip_fread(member.get(), block.data(), block.size());
    if (count < 0)
      fail_archive(what, std::string("it cannot be unpacked: ") + zip_file_strerror(member.get()));
    if (zip_uint64_t(count) > about.size - bytes.size())
      fail_archive(what, "it unpacks to more than the " + std::to_string(about.size) + " bytes it declares");
    if (count == 0) break;
    bytes.append(block.data(), std::size_t(count));
  }
  if (bytes.size() != about.size)
    fail_archive(what, "it unpacks to " + std::to_string(bytes.size()) + " bytes and declares " +
                           std::to_string(about.size));
  return bytes;
}

std::string make_archive(const std::vector<std::pair<std::string, std::string>>& members) {
  const auto fail_to_pack = [](const std::string& why) {
    throw Error(ErrorKind::kIo, "MPCDI archive", "it cannot be packed: " + why,
                "report this with the maps' sizes");
  };
  zip_error_t error;
  zip_error_init(&error);
  ZipSource target(zip_source_buffer_create(nullptr, 0, 0, &error));
  if (!target) fail_to_pack(text_of(&error));
  std::unique_ptr<zip_t, CloseNewZip> zip(zip_open_from_source(target.get(), ZIP_TRUNCATE, &error));
  if (!zip) fail_to_pack(text_of(&error));
  zip_source_keep(target.get());                 // the archive's reference goes when it is closed, ours stays
  constexpr time_t kAlwaysTheSame = 1577880000;  // 2020-01-01 noon UTC
  for (const auto& [name, bytes] : members) {
    ZipSource from(zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error));
    const zip_int64_t index =
        from ? zip_file_add(zip.get(), name.c_str(), from.get(), ZIP_FL_ENC_UTF_8) : zip_int64_t(-1);
    if (index < 0) fail_to_pack(zip_strerror(zip.get()));
    (void)from.release();  // the archive owns it now
    zip_file_set_mtime(zip.get(), zip_uint64_t(index), kAlwaysTheSame, 0);
  }
  if (zip_close(zip.get()) != 0) fail_to_pack(zip_strerror(zip.get()));
  (void)zip.release();

  zip_stat_t about;
  zip_stat_init(&about);
  if (zip_source_open(target.get()) != 0 || zip_source_stat(target.get(), &about) != 0)
    fail_to_pack(zip_error_strerror(zip_source_error(target.get())));
  std::string packed(about.size, '\0');
  const zip_int64_t count = zip_source_read(target.get(), packed.data(), packed.size());
  zip_source_close(target.get());
  if (count != zip_int64_t(packed.size())) fail_to_pack("its bytes cannot be read back");
  return packed;
}

}  // namespace procam::io
