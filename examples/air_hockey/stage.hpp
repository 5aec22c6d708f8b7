#pragma once
/// Where frames go: a projector's frame, or the contents for another program to project.
#include <memory>
#include <string>

#include "game.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/render/cpu.hpp"
#include "wall.hpp"

namespace hockey {

class Stage {
 public:
  virtual ~Stage() = default;
  /// For the light of `light_time`, by the clock of the players' skeletons.
  virtual void show(const Game& game, double light_time) = 0;
  virtual bool is_closed() { return false; }
  virtual const procam::ImageU8& picture() const = 0;
  virtual void finish() {}
};

/// The frame of a projector that stands still, people's heads kept dark. The sink has its size.
std::unique_ptr<Stage> projected_stage(const Wall& wall, const procam::Rig& rig,
                                       procam::render::Filter filter,
                                       std::unique_ptr<procam::device::FrameSink> sink);
/// The contents in shared memory, NAME_table and NAME_scoreboard.
std::unique_ptr<Stage> content_stage(const std::string& name, const Wall& wall);

}  // namespace hockey
