#pragma once
/// The further projectors of a show that drives several from one process (ShowOptions::screens).
///
/// They show what the first one shows: the same surfaces with the pictures that its Projection drew last, for the same pose and
/// time of light, each in its own frame and with its own share of the light.
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "procam/core/base/image.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/show/projection.hpp"
#include "show_blend.hpp"

namespace procam::show {

struct SideScreen {
  std::string name;  ///< of the projector in the rig
  Projection& projection;
  device::FrameSink& sink;
  BlendMaker* blend = nullptr;  ///< null: it is not blended
};

class SideScreens {
 public:
  /// `first`: the projection of the first screen, with its show.
  SideScreens(const Projection& first, std::vector<SideScreen> screens);
  ~SideScreens();

  std::size_t size() const { return screens_.size(); }
  const SideScreen& at(std::size_t i) const { return screens_[i]; }

  /// The first projection has another show. Throws as Projection::set_show() does.
  void take_show();
  void add(const track::StampedPose& message);
  void set_picture(TestPattern picture);

  /// After the first one was drawn. `say_fault` gets what failed: that frame is black.
  void draw(double light_time, const std::function<void(const std::string&)>& say_fault);
  /// Hands the frames to the screens, without waiting for their displays.
  void show();
  /// The frame that was drawn last; not written to while somebody holds it.
  std::shared_ptr<const ImageU8> frame(std::size_t i) const;
  /// The same between draw() and show(), to draw over.
  ImageView<std::uint8_t> drawn(std::size_t i) { return frames_[i].shown->view(); }

  // The blend with the other screens, and projectors of other processes.
  void begin_blend(const ProjectorNames& set);
  void want_blend(std::uint64_t version, const std::vector<ProjectorNames>& sets);
  /// Are all maps of the newest version made?
  bool is_blend_ready(const ProjectorNames& set) const;
  void use_blend(const ProjectorNames& set);

 private:
  class DrawnPicture;
  struct Frames {
    std::deque<std::shared_ptr<ImageU8>> all;
    std::shared_ptr<ImageU8> shown;
  };

  BlendScene scene_of(const SideScreen& screen, const ProjectorNames& set) const;

  const Projection& first_;
  std::vector<SideScreen> screens_;
  std::vector<Frames> frames_;  ///< one a screen
  /// By the first one's content, so that pictures of one that stays are known again.
  std::map<const device::ContentSource*, std::shared_ptr<DrawnPicture>> pictures_;
};

}  // namespace procam::show
