#pragma once
/// Virtual Motion Capture protocol -> skeletons: what avatar programs send by OSC (https://protocol.vmc.info,
/// the messages from performer to marionette).
///
///   /VMC/Ext/Root/Pos  name, position, quaternion x y z w      the avatar's root in the sender's world
///   /VMC/Ext/Bone/Pos  bone, position, quaternion x y z w      a bone in its parent's frame, Unity's
///   humanoid bones /VMC/Ext/OK        loaded                                   0: nobody is there
///
/// Metres in Unity's axes (x right, y up, z forward, left-handed). With the local poses chained from the
/// root,
///
///   p_bone = T_root T_hips ... T_bone 0,      p_sensor = (x, -y, z),
///
/// which is the same place in a right-handed optical frame at the sender's origin. An optional bone that is
/// not sent (Chest, UpperChest, Neck, Shoulder) is passed over, as Unity does. Bone lengths are the avatar's:
/// a person of another size is elsewhere by the difference.
///
/// Messages of one frame come in any number of datagrams. The first frame ends where a bone comes again;
/// later ones as soon as all bones have come that the frame before had.
#include <array>
#include <bitset>
#include <string_view>

#include "procam/core/geometry/pose.hpp"
#include "procam/people/skeleton_reader.hpp"

namespace procam::people {

class VmcReader {
 public:
  static constexpr std::size_t kBones = 26;

  /// A datagram, any bytes. Frames have no stamp: their arrival counts. Refused and counted: what is no OSC,
  /// another address, other types, a bone that is not finite, farther from its parent than kFarthestJoint or
  /// turned by no rotation, and frames whose bones all lie in one place (senders that know rotations alone).
  ParsedSkeletons parse(std::string_view datagram);

 private:
  void read(std::string_view bytes, int depth, ParsedSkeletons& parsed);
  void read_message(std::string_view bytes, ParsedSkeletons& parsed);
  void end_frame(ParsedSkeletons& parsed);

  Pose root_;
  std::array<Pose, kBones> bones_;       ///< parent_from_bone, in Unity's axes
  std::bitset<kBones> known_, arrived_;  ///< of the frame before, and of this one
};

}  // namespace procam::people
