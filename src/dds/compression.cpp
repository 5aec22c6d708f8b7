#include "compression.hpp"

#include "procam/core/base/error.hpp"
#include "refusal.hpp"

#ifdef PROCAM_HAVE_ZSTD
#include <zstd.h>
#endif
#ifdef PROCAM_HAVE_LZ4
#include <lz4frame.h>
#endif

namespace procam::dds::internal {
namespace {

#if defined(PROCAM_HAVE_ZSTD) || defined(PROCAM_HAVE_LZ4)
[[noreturn]] void refuse_packed(const char* how) {
  throw Refusal{"log_damaged", std::string("a part of the log that is compressed (") + how + ") is damaged"};
}
#endif
#if !defined(PROCAM_HAVE_ZSTD) || !defined(PROCAM_HAVE_LZ4)
[[noreturn]] void not_built(const char* how, const char* package) {
  throw Error(ErrorKind::kUnsupported, std::string("a log that is compressed (") + how + ")",
              std::string("procam was built without ") + how,
              std::string("install ") + package + " and build procam again, or unpack the log");
}
#endif

}  // namespace

#ifdef PROCAM_HAVE_ZSTD
std::string unpacked_zstd(std::string_view bytes, std::size_t size) {
  std::string unpacked(size, '\0');
  if (ZSTD_decompress(unpacked.data(), size, bytes.data(), bytes.size()) != size) refuse_packed("zstd");
  return unpacked;
}
std::size_t zstd_size(std::string_view bytes) {
  const unsigned long long size = ZSTD_getFrameContentSize(bytes.data(), bytes.size());
  return size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR ? 0 : std::size_t(size);
}
std::string packed_zstd(std::string_view bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 1);
  require(ZSTD_isError(size) == 0, "packed_zstd: zstd failed");
  packed.resize(size);
  return packed;
}
bool has_zstd() {
  return true;
}
#else
std::string unpacked_zstd(std::string_view, std::size_t) {
  not_built("zstd", "libzstd-dev");
}
std::size_t zstd_size(std::string_view) {
  return 0;
}
std::string packed_zstd(std::string_view) {
  not_built("zstd", "libzstd-dev");
}
bool has_zstd() {
  return false;
}
#endif

#ifdef PROCAM_HAVE_LZ4
std::string unpacked_lz4(std::string_view bytes, std::size_t size) {
  LZ4F_dctx* context = nullptr;
  require(LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION)) == 0,
          "unpacked_lz4: no memory");
  std::string unpacked(size, '\0');
  std::size_t done = 0;
  bool is_good = true;
  // Until nothing more is made of nothing more: lz4 may keep bytes of the end for another call.
  for (std::size_t at = 0; is_good && (at < bytes.size() || done < size);) {
    std::size_t taken = bytes.size() - at, made = size - done;
    is_good = LZ4F_isError(LZ4F_decompress(context, unpacked.data() + done, &made, bytes.data() + at, &taken,
                                           nullptr)) == 0;
    if (taken == 0 && made == 0) break;
    at += taken;
    done += made;
  }
  LZ4F_freeDecompressionContext(context);
  if (!is_good || done != size) refuse_packed("lz4");
  return unpacked;
}
#else
std::string unpacked_lz4(std::string_view, std::size_t) {
  not_built("lz4", "liblz4-dev");
}
#endif

}  // namespace procam::dds::internal
