#pragma once
/// The projectors of a project: their windows, with a copy of each frame for the page.
#include <memory>
#include <string>
#include <vector>

#include "page.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"
#include "procam/device/frame_sink.hpp"
#include "project.hpp"
#include "simulated_stage.hpp"

namespace procam::studio {

/// Grey values of a guide's lines and of the light round them: half of the lines' light at gamma 2.2, enough for a camera whose
/// exposure is right for white.
inline constexpr std::uint8_t kGuideLine = 255, kGuideGround = 186;

/// A closed ring as bright lines on dimmer light; points in pixels.
ImageU8 guide_frame(ImageSize size, const std::vector<Vec2>& ring);

class ProjectorScreens {
 public:
  explicit ProjectorScreens(StudioPage& page);
  ~ProjectorScreens();

  /// Those that were open are closed first. `stage`: the simulated ones, instead of windows. Throws as device::find_display()
  /// and device::open_window() do; then none is open.
  void open(const std::vector<ChosenProjector>& chosen, SimulatedStage* stage);
  void close();

  bool is_open() const { return !screens_.empty(); }
  std::size_t size() const { return screens_.size(); }
  /// In the session and the rig; empty: the only one.
  const std::string& name(std::size_t i) const { return screens_.at(i).name; }
  /// Throws Error(kInput) where none is open.
  device::FrameSink& at(std::size_t i = 0);
  ImageSize frame_size(std::size_t i) const;

  void poll();
  /// All show this grey value. White of several is darkened, so that a place that all light is as bright as one would make
  /// it.
  void show_flat(int level);
  /// A frame's border, its diagonals and one-pixel squares: keystone, scaling and cut edges can be seen.
  void show_test_card();
  /// The surfaces' sides as light, to see on the wall what is dragged in the frame.
  void show_outlines(const SurfaceSet& surfaces, const Rig& rig);
  /// The ring, in pixels of frame i, as bright lines on dimmer light: for whoever holds a board in it. The other projectors
  /// show the dimmer light alone.
  void show_guide(std::size_t i, const std::vector<Vec2>& ring);
  /// The others turn black.
  void darken_others(std::size_t i);

 private:
  class Screen;
  struct Opened {
    std::string name;
    std::unique_ptr<device::FrameSink> window;  ///< null: simulated
    std::unique_ptr<Screen> screen;
  };
  StudioPage& page_;
  std::vector<Opened> screens_;
};

}  // namespace procam::studio
