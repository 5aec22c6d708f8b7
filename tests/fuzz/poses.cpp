// Poses from sockets.
#include "draws.hpp"
#include "fuzz_target.hpp"
#include "procam/core/geometry/se3.hpp"
#include "targets.hpp"
#include "wire_checks.hpp"
#include "wire_parsers.hpp"

namespace procam::fuzz {
namespace {

/// A value within what messages may hold.
double bounded(Draws& draws) {
  return std::clamp(draws.number(), -1e5, 1e5);
}

track::StampedPose drawn_message(Draws& draws) {
  track::StampedPose message;
  message.frame = draws.yes() ? "map" : "map \"nörth\"";
  message.child = "tracker " + std::to_string(draws.below(3));
  const auto vector = [&] { return Vec3(bounded(draws), bounded(draws), bounded(draws)); };
  const Vec3 turn = vector() / 1e5;
  message.frame_from_child = Pose(so3_exp(turn), vector());
  if (draws.yes()) message.stamp = 1.7e9 + bounded(draws);
  if (draws.yes()) {
    Mat6 root = Mat6::Identity() * 1e-3;
    for (int i = 0; i < 6; ++i) root(i, 5 - i) += std::clamp(draws.number(), -10.0, 10.0);
    message.covariance = root * root.transpose();
  }
  if (draws.yes()) message.twist = (Vec6() << vector(), vector()).finished();
  if (draws.yes()) message.angular_rate = vector();
  if (draws.yes()) message.sequence = std::uint32_t(draws.below(65536)) << 16;
  return message;
}

/// Bytes replaced, inserted, removed and cut.
void damage(std::string& bytes, Draws& draws) {
  for (int i = 0; i < 8 && !draws.empty() && !bytes.empty(); ++i) {
    const std::size_t at = draws.below(std::min<std::size_t>(bytes.size(), 65536));
    switch (draws.below(4)) {
      case 0:
        bytes[at] = char(draws.below(256));
        break;
      case 1:
        bytes.insert(at, draws.piece());
        break;
      case 2:
        bytes.erase(at, 1 + draws.below(8));
        break;
      default:
        bytes.resize(at);
    }
  }
}

}  // namespace

void poses(std::string_view bytes) {
  check_messages(track::parse_poses(bytes));
}

/// However a stream is cut into pieces, it holds the same messages.
void pose_stream(std::string_view bytes) {
  Draws draws(bytes.substr(0, 8));
  bytes.remove_prefix(std::min<std::size_t>(8, bytes.size()));
  track::StreamParser in_pieces, at_once;
  track::Parsed all;
  for (std::string_view rest = bytes; !rest.empty();) {
    const std::size_t size = draws.empty() ? rest.size() : 1 + draws.below(256);
    track::Parsed parsed = in_pieces.parse(rest.substr(0, size));
    rest.remove_prefix(std::min(size, rest.size()));
    check_messages(parsed);
    for (track::StampedPose& pose : parsed.poses) all.poses.push_back(std::move(pose));
    all.malformed += parsed.malformed;
  }
  const track::Parsed whole = at_once.parse(bytes);
  check(whole.poses.size() == all.poses.size(), "a stream in pieces holds another number of messages");
  for (std::size_t i = 0; i < whole.poses.size(); ++i)
    check(track::to_json_line(whole.poses[i]) == track::to_json_line(all.poses[i]),
          "a stream in pieces holds other messages");
}

void osc(std::string_view bytes) {
  check_messages(track::parse_osc(bytes));
}

void psn(std::string_view bytes) {
  check_messages(track::parse_psn(bytes));
}

void rosbridge(std::string_view bytes) {
  check_messages(track::parse_rosbridge(bytes));
}

void wire_fields(std::string_view bytes) {
  Draws draws(bytes);
  const std::size_t form = draws.below(4);
  const track::StampedPose message = drawn_message(draws);
  std::string wire = form == 0   ? track::to_json_line(message)
                     : form == 1 ? track::to_binary(message)
                     : form == 2 ? track::to_osc(message)
                                 : track::to_psn(message);
  const auto parse = [&] {
    return form < 2 ? track::parse_poses(wire) : form == 2 ? track::parse_osc(wire) : track::parse_psn(wire);
  };
  const track::Parsed valid = parse();
  check(valid.poses.size() == 1 && valid.malformed == 0, "a valid message is refused: " + valid.why);
  check_messages(valid);
  damage(wire, draws);
  check_messages(parse());
}

}  // namespace procam::fuzz
