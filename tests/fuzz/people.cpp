// Skeletons from sockets and logs.
#include <cmath>

#include "draws.hpp"
#include "fuzz_target.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/people/skeleton_reader.hpp"
#include "skeleton_csv.hpp"
#include "skeleton_stream.hpp"
#include "targets.hpp"
#include "vmc.hpp"

namespace procam::fuzz {
namespace {

void check_people(const people::ParsedSkeletons& parsed) {
  check(parsed.malformed == 0 || !parsed.why.empty(), "a malformed frame without a reason");
  for (const people::SkeletonFrame& frame : parsed.frames) {
    check(people::why_refused(frame) == nullptr, "a frame was accepted that is to be refused");
    check(!frame.stamp || std::isfinite(*frame.stamp), "a stamp is not finite");
    const std::string line = people::to_json_line(frame);
    if (line.size() > limits::kSkeletonLineBytes) continue;
    const people::ParsedSkeletons again = people::parse_skeletons(line);
    check(again.frames.size() == 1 && again.malformed == 0,
          "the line of an accepted frame is refused: " + again.why);
    check(again.frames[0].people.size() == frame.people.size(), "the line has other people");
    for (const people::Skeleton& person : frame.people)
      for (const auto& joint : person.joints)
        check(!joint || joint->position.allFinite(), "a joint is not finite");
  }
}

}  // namespace

void skeletons(std::string_view bytes) {
  check_people(people::parse_skeletons(bytes));
}

void skeleton_stream(std::string_view bytes) {
  Draws draws(bytes.substr(0, 8));
  bytes.remove_prefix(std::min<std::size_t>(8, bytes.size()));
  people::SkeletonStream in_pieces, at_once;
  std::size_t frames = 0, malformed = 0;
  for (std::string_view rest = bytes; !rest.empty();) {
    const std::size_t size = draws.empty() ? rest.size() : 1 + draws.below(256);
    const people::ParsedSkeletons parsed = in_pieces.parse(rest.substr(0, size));
    rest.remove_prefix(std::min(size, rest.size()));
    check_people(parsed);
    frames += parsed.frames.size();
    malformed += parsed.malformed;
  }
  const people::ParsedSkeletons whole = at_once.parse(bytes);
  check(whole.frames.size() == frames, "a stream in pieces holds another number of frames");
  check(whole.malformed == malformed, "a stream in pieces holds another number of malformed frames");
}

void skeleton_csv(std::string_view bytes) {
  check_people(people::parse_skeleton_csv(bytes));
}

/// OpenPose, MediaPipe and Azure Kinect: each takes what is not its own as well.
void foreign_skeletons(std::string_view bytes) {
  check_people(people::parse_azure_kinect(bytes));
  const Camera camera{{1280, 960}, {1000, 990, 640, 480, 0}, {}};
  for (const people::PixelSkeleton& seen : people::parse_openpose(bytes).people) {
    const people::Skeleton person =
        people::lifted(seen, camera, [](const Vec2& at) { return 1 + at.x() / 1e5; });
    for (const auto& joint : person.joints)
      check(!joint || joint->position.allFinite(), "a lifted joint is not finite");
  }
  for (const people::HipCentredPerson& person : people::parse_mediapipe(bytes).people) {
    const Plane floor{Vec3(0, -1, 0), 1.2};
    const auto anchored = people::anchored_on_floor(person.about_hips, Vec3(0.1, -0.1, 1), floor);
    if (!anchored) continue;
    for (const auto& joint : anchored->joints)
      check(!joint || joint->position.allFinite(), "an anchored joint is not finite");
  }
}

/// Datagrams, each after a byte that states its length in words of four bytes.
void vmc(std::string_view bytes) {
  people::VmcReader reader;
  Draws draws(bytes);
  for (int i = 0; i < 100 && !draws.empty(); ++i)
    check_people(reader.parse(draws.bytes(4 * draws.below(256))));
}

}  // namespace procam::fuzz
