#pragma once
/// Who moves the paddles.
#include <memory>
#include <string>

#include "match.hpp"
#include "procam/core/pose.hpp"
#include "procam/track/people.hpp"

namespace hockey {

class Players {
 public:
  virtual ~Players() = default;
  /// Where the hands are over the table at a time that does not go back; nullopt: nobody plays there.
  virtual Match::Hands hands(const Match& match, double time) = 0;
  /// Asked at every step of the match rather than every frame.
  virtual bool is_bot() const { return false; }
  /// Their time is the clock's.
  virtual bool is_live() const { return false; }
  /// Those who may not be blinded; null: there is nobody.
  virtual const procam::track::PeopleTrack* people() const { return nullptr; }
  virtual procam::Pose world_from_sensor() const { return {}; }
};

/// "bots", "people", "log:FILE", or a source of track/skeleton_source.hpp ("udp:9100"); throws procam::Error.
std::unique_ptr<Players> open_players(const std::string& text, const procam::Pose& world_from_table,
                                      std::uint64_t seed);

}  // namespace hockey
