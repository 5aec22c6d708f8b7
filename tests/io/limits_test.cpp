// The table of limits in docs/security.md is the header.
#include "procam/core/base/limits.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <thread>

#include "procam/core/base/parallel.hpp"
#include "procam/io/files.hpp"
#include "support/sanitizer.hpp"

namespace procam::limits {
namespace {

/// As the table has it: bytes in MiB where they are whole, seconds and metres with their unit.
std::string in_words(const std::string& name, double value) {
  const auto ends = [&](const std::string& end) {
    return name.size() > end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0;
  };
  const auto count = static_cast<long long>(value);
  EXPECT_EQ(double(count), value) << name;
  if (ends("Bytes") && count % (1 << 20) == 0) return std::to_string(count >> 20) + " MiB";
  if (name == "kLengthM") return std::to_string(count) + " m";
  if (ends("S")) return std::to_string(count) + " s";
  return std::to_string(count);
}

#define LIMIT(name) \
  { #name, double(name) }
const std::map<std::string, double> kAll = {
    LIMIT(kFileBytes),         LIMIT(kDocumentBytes),    LIMIT(kDocumentValues),
    LIMIT(kDocumentDepth),     LIMIT(kGroupFields),      LIMIT(kListBytes),
    LIMIT(kMatrixNumbers),     LIMIT(kImagePixels),      LIMIT(kImageBytes),
    LIMIT(kSizeSide),          LIMIT(kFrameSide),        LIMIT(kContentPixels),
    LIMIT(kSurfaces),          LIMIT(kMeshTriangles),    LIMIT(kTableBytes),
    LIMIT(kTableRows),         LIMIT(kPointPairsBytes),  LIMIT(kArrayHeaderBytes),
    LIMIT(kArrayValues),       LIMIT(kArchiveMembers),   LIMIT(kRegions),
    LIMIT(kSkeletonFileBytes), LIMIT(kSenders),          LIMIT(kTakeoverSilenceS),
    LIMIT(kSenderSilenceS),    LIMIT(kMessageBytes),     LIMIT(kMalformedPerDatagram),
    LIMIT(kFrameNameBytes),    LIMIT(kOscDepth),         LIMIT(kRosbridgeBytes),
    LIMIT(kRosbridgeDepth),    LIMIT(kTransforms),       LIMIT(kSkeletonLineBytes),
    LIMIT(kSkeletonDepth),     LIMIT(kPeople),           LIMIT(kThreads),
    LIMIT(kDurationS),         LIMIT(kDelayS),           LIMIT(kLengthM),
    LIMIT(kLogLineBytes),      LIMIT(kLogChunkBytes),    LIMIT(kLogSummaryBytes),
    LIMIT(kLogTopics),         LIMIT(kLogPoses),         LIMIT(kPageHeaderBytes),
    LIMIT(kPageBodyBytes),     LIMIT(kPageConnections),  LIMIT(kPageCommands),
    LIMIT(kPageHeadS),         LIMIT(kPageRequestS),     LIMIT(kMinTokenBytes),
    LIMIT(kMaxTokenBytes),     LIMIT(kDdsSampleBytes),   LIMIT(kTransformFrames),
    LIMIT(kTransformStamps),   LIMIT(kSurfaceNameBytes), LIMIT(kEditedSurfaces),
    LIMIT(kEditSteps)};
#undef LIMIT

TEST(Limits, AreAllInTheTableOfTheDocuments) {
  const std::string root = PROCAM_SOURCE_DIR;
  const std::string header = io::read_file(root + "/include/procam/core/base/limits.hpp");
  std::set<std::string> declared, listed;
  const std::regex constant("inline constexpr [a-z0-9_:]+ (k[A-Za-z]+) =");
  for (std::sregex_iterator found(header.begin(), header.end(), constant), end; found != end; ++found)
    declared.insert((*found)[1]);
  for (const auto& [name, value] : kAll) listed.insert(name);
  EXPECT_EQ(declared, listed) << "the list above lacks a limit of the header";

  std::map<std::string, std::string> table;
  const std::string page = io::read_file(root + "/docs/security.md");
  const std::regex row("\\| `(k[A-Za-z]+)` \\| ([^|]+) \\|");
  for (std::sregex_iterator found(page.begin(), page.end(), row), end; found != end; ++found)
    table[(*found)[1]] = (*found)[2];
  for (const auto& [name, value] : kAll) EXPECT_EQ(table[name], in_words(name, value)) << name;
  EXPECT_EQ(table.size(), kAll.size()) << "the table has a limit that the header lacks";
}

#if !defined(PROCAM_ADDRESS_SANITIZER) && !defined(PROCAM_THREAD_SANITIZER)
// With room for few stacks, the system refuses most threads: those that there are do the work.
TEST(Limits, TheWorkIsDoneByTheThreadsThatTheSystemGrants) {
  const auto work_with_little_memory = [] {
    std::ifstream pages("/proc/self/statm");
    rlim_t used = 0;
    pages >> used;
    const rlim_t limit = used * rlim_t(sysconf(_SC_PAGESIZE)) + (rlim_t(64) << 20);
    const rlimit both{limit, limit};
    if (setrlimit(RLIMIT_AS, &both) != 0) _exit(1);
    std::atomic<int> calls{0};
    parallel_each(5000, 1000, [&](int) {
      ++calls;
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    });
    _exit(calls == 5000 ? 0 : 2);
  };
  EXPECT_EXIT(work_with_little_memory(), testing::ExitedWithCode(0), "");
}
#endif

}  // namespace
}  // namespace procam::limits
