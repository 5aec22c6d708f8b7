#include "group_messages.hpp"

#include <algorithm>
#include <cmath>

#include "group_limits.hpp"
#include "procam/core/base/detail/plain_text.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::dds::internal {
namespace {

void require_good(bool good, const char* why) {
  if (!good) throw Refusal{"group_invalid", why};
}

std::string text_of(const char* text, std::size_t max_bytes, const char* why) {
  const std::string read = text == nullptr ? "" : text;
  require_good(read.size() <= max_bytes && procam::internal::is_plain_text(read), why);
  return read;
}

template <int Size>
std::optional<Eigen::Matrix<double, Size, 1>> numbers_of(const dds_sequence_double& sequence) {
  if (sequence._length == 0) return std::nullopt;
  require_good(sequence._length == std::uint32_t(Size), "a pose has a wrong count of numbers");
  const Eigen::Matrix<double, Size, 1> numbers =
      Eigen::Map<const Eigen::Matrix<double, Size, 1>>(sequence._buffer);
  require_good(numbers.allFinite(), "a pose has numbers that are not finite");
  return numbers;
}

dds_sequence_double borrow(double* numbers, std::size_t count) {
  return {std::uint32_t(count), std::uint32_t(count), numbers, false};
}

}  // namespace

OrderedState read_group_state(const procam_group_State& message) {
  OrderedState read;
  read.leader = message.leader;
  read.term = message.term;
  read.sequence = message.sequence_number;
  GroupState& state = read.state;
  state.surfaces =
      text_of(message.surfaces, limits::kGroupStateBytes, "its surfaces are no text, or too long");
  require_good(std::isfinite(message.content_epoch) && std::isfinite(message.frozen_at),
               "its times are not finite");
  require_good(message.picture <= 2, "it has an unknown picture");
  require_good(message.applied._length <= limits::kGroupMembers, "it has too many members");
  state.content_epoch = message.content_epoch;
  state.picture = message.picture;
  state.frozen = message.frozen;
  state.frozen_at = message.frozen_at;
  state.unsaved = message.unsaved;
  state.can_undo = message.can_undo;
  state.can_redo = message.can_redo;
  state.saves = message.saves;
  for (std::uint32_t i = 0; i < message.applied._length; ++i) {
    const procam_group_Applied& one = message.applied._buffer[i];
    read.applied[one.member] = {one.number,
                                text_of(one.refusal, limits::kPageBodyBytes, "a refusal is no text")};
  }
  return read;
}

dds_return_t write_group_state(dds_entity_t writer, const std::string& group, OrderedState written) {
  GroupState& state = written.state;
  std::string name = group;  // C structures point to texts that may be written
  std::vector<procam_group_Applied> applied;
  for (auto& [member, one] : written.applied) applied.push_back({member, one.number, one.refusal.data()});
  procam_group_State message{};
  message.group = name.data();
  message.leader = written.leader;
  message.term = written.term;
  message.sequence_number = written.sequence;
  message.content_epoch = state.content_epoch;
  message.picture = std::uint8_t(state.picture);
  message.frozen = state.frozen;
  message.frozen_at = state.frozen_at;
  message.unsaved = state.unsaved;
  message.can_undo = state.can_undo;
  message.can_redo = state.can_redo;
  message.saves = state.saves;
  message.surfaces = state.surfaces.data();
  message.applied._buffer = applied.data();
  message.applied._length = message.applied._maximum = std::uint32_t(applied.size());
  return dds_write(writer, &message);
}

MemberBeat read_beat(const procam_group_Beat& message) {
  MemberBeat beat;
  beat.member = message.member;
  beat.host = text_of(message.host, limits::kFrameNameBytes, "the name of a host is no text, or too long");
  beat.machine = message.machine;
  beat.strength = message.strength;
  beat.leads = message.leads;
  beat.has_state = message.has_state;
  beat.term = message.term;
  beat.settled = message.settled;
  beat.sent = message.sent;
  beat.group_offset = message.group_offset;
  require_good(message.projectors._length <= limits::kGroupProjectors, "it has too many projectors");
  for (std::uint32_t i = 0; i < message.projectors._length; ++i)
    beat.projectors.push_back(text_of(message.projectors._buffer[i], limits::kFrameNameBytes,
                                      "the name of a projector is no text, or too long"));
  beat.lit = message.lit;
  beat.lit_from = message.lit_from;
  require_good(std::isfinite(beat.lit_from) && (!beat.lit || !beat.projectors.empty()),
               "its light has no time or no projector");
  require_good(beat.member != 0, "a member has no number");
  require_good(std::isfinite(beat.sent) && std::isfinite(beat.group_offset), "its times are not finite");
  require_good(message.offsets._length <= limits::kGroupMembers, "it has too many members");
  for (std::uint32_t i = 0; i < message.offsets._length; ++i) {
    const procam_group_ClockOffset& one = message.offsets._buffer[i];
    require_good(std::isfinite(one.offset) && std::isfinite(one.sigma), "its clocks are not finite");
    beat.offsets.push_back({one.member, one.offset, one.sigma});
  }
  return beat;
}

dds_return_t write_beat(dds_entity_t writer, MemberBeat beat) {
  std::vector<procam_group_ClockOffset> offsets;
  for (const MemberOffset& one : beat.offsets) offsets.push_back({one.member, one.offset, one.sigma});
  std::vector<char*> projectors;
  for (std::string& one : beat.projectors) projectors.push_back(one.data());
  procam_group_Beat message{};
  message.member = beat.member;
  message.host = beat.host.data();
  message.machine = beat.machine;
  message.strength = beat.strength;
  message.leads = beat.leads;
  message.has_state = beat.has_state;
  message.term = beat.term;
  message.settled = beat.settled;
  message.sent = beat.sent;
  message.group_offset = beat.group_offset;
  message.projectors._buffer = projectors.data();
  message.projectors._length = message.projectors._maximum = std::uint32_t(projectors.size());
  message.lit = beat.lit;
  message.lit_from = beat.lit_from;
  message.offsets._buffer = offsets.data();
  message.offsets._length = message.offsets._maximum = std::uint32_t(offsets.size());
  return dds_write(writer, &message);
}

GroupRequest read_request(const procam_group_Request& message) {
  require_good(message.member != 0 && message.number != 0, "a request has no number");
  return {message.member, message.number,
          text_of(message.command, limits::kPageBodyBytes, "a request is no text, or too long")};
}

dds_return_t write_request(dds_entity_t writer, GroupRequest request) {
  procam_group_Request message{request.member, request.number, request.command.data()};
  return dds_write(writer, &message);
}

track::StampedPose read_group_pose(const procam_group_Pose& message) {
  track::StampedPose pose;
  pose.arrival = message.arrival;
  require_good(std::isfinite(pose.arrival), "a pose has no time of arrival");
  if (const auto stamp = numbers_of<1>(message.stamp)) pose.stamp = (*stamp)[0];
  pose.frame = text_of(message.frame, limits::kFrameNameBytes, "the name of a frame is no text, or too long");
  pose.child = text_of(message.child, limits::kFrameNameBytes, "the name of a frame is no text, or too long");
  const double* const q = message.rotation;
  pose.frame_from_child.rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  pose.frame_from_child.translation = Vec3(message.translation);
  require_good(pose.frame_from_child.translation.allFinite() &&
                   std::abs(pose.frame_from_child.rotation.norm() - 1) < 1e-6,
               "a pose is not finite, or no rotation");
  if (const auto covariance = numbers_of<36>(message.covariance))
    pose.covariance = Eigen::Map<const Mat6>(covariance->data());
  pose.twist = numbers_of<6>(message.twist);
  pose.angular_rate = numbers_of<3>(message.angular_rate);
  require_good(message.sequence_number._length <= 1, "a pose has several sequence numbers");
  if (message.sequence_number._length == 1) pose.sequence = message.sequence_number._buffer[0];
  return pose;
}

dds_return_t write_group_pose(dds_entity_t writer, const std::string& group, std::uint64_t member,
                              track::StampedPose pose) {
  std::string name = group;  // C structures point to texts that may be written
  procam_group_Pose message{};
  message.group = name.data();
  message.member = member;
  message.arrival = pose.arrival;
  if (pose.stamp) message.stamp = borrow(&*pose.stamp, 1);
  message.frame = pose.frame.data();
  message.child = pose.child.data();
  const Eigen::Quaterniond& q = pose.frame_from_child.rotation;
  const double rotation[] = {q.w(), q.x(), q.y(), q.z()};
  std::copy_n(rotation, 4, message.rotation);
  std::copy_n(pose.frame_from_child.translation.data(), 3, message.translation);
  if (pose.covariance) message.covariance = borrow(pose.covariance->data(), 36);
  if (pose.twist) message.twist = borrow(pose.twist->data(), 6);
  if (pose.angular_rate) message.angular_rate = borrow(pose.angular_rate->data(), 3);
  if (pose.sequence) message.sequence_number = {1, 1, &*pose.sequence, false};
  return dds_write(writer, &message);
}

}  // namespace procam::dds::internal
