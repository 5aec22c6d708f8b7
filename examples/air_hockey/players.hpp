#pragma once
/// Who moves the paddles.
#include <functional>
#include <memory>
#include <string>

#include "match.hpp"
#include "procam/core/geometry/pose.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/people/people.hpp"
#include "procam/people/skeleton_source.hpp"

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
  /// No more hands come.
  virtual bool are_gone() const { return false; }
  /// Those who may not be blinded; null: there is nobody.
  virtual const procam::people::PeopleTrack* people() const { return nullptr; }
  virtual procam::Pose world_from_sensor() const { return {}; }
};

/// The keys that are down now: those of FrameSink::is_down().
using KeyIsDown = std::function<bool(procam::device::Key)>;

/// Where skeletons are told from.
struct Seat {
  procam::Pose world_from_table;
  /// Of a sensor; absent: skeletons are told in the table's own metres already (project-live --people-to).
  std::optional<procam::Pose> world_from_sensor;
  procam::people::PeopleOptions people;  ///< of what is seen by it
};

/// As a simulated sensor above the table would see the people who face it.
procam::Pose example_world_from_sensor(const procam::Pose& world_from_table);

std::unique_ptr<Players> bots(std::uint64_t seed);
/// Bots whose hands go through a simulated skeleton tracker.
std::unique_ptr<Players> simulated_people(const procam::Pose& world_from_table, std::uint64_t seed);
/// W A S D move the left hand, the arrows the right one; a hand is there from its first key on.
std::unique_ptr<Players> keyboard(KeyIsDown is_down);
/// A log of skeletons (docs/people.md); it begins anew at its end.
std::unique_ptr<Players> recorded_people(const std::string& file, const Seat& seat);
/// Skeletons as they arrive, `begin` being 0 of the match by the clock of their arrivals.
std::unique_ptr<Players> live_people(std::unique_ptr<procam::people::SkeletonSource> source, const Seat& seat,
                                     double begin);

}  // namespace hockey
