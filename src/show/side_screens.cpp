#include "side_screens.hpp"

#include <algorithm>
#include <exception>
#include <utility>

namespace procam::show {

/// The picture of one surface that the first projection drew last. Sources that are live have a newer one at any time, which
/// would differ where two projectors overlap.
class SideScreens::DrawnPicture : public device::ContentSource {
 public:
  explicit DrawnPicture(const Projection& first) : first_(first) {}
  void is_of(std::size_t surface) { surface_ = surface; }
  device::ContentFrame at(double) override {
    const std::optional<device::ContentFrame> drawn = first_.picture_of(surface_);
    if (!drawn)
      throw Error(ErrorKind::kInput, "content", "the first screen had no picture of it", "see its message");
    return *drawn;
  }

 private:
  const Projection& first_;
  std::size_t surface_ = 0;
};

SideScreens::SideScreens(const Projection& first, std::vector<SideScreen> screens)
    : first_(first), screens_(std::move(screens)) {
  for (const SideScreen& screen : screens_) {
    Frames& frames = frames_.emplace_back();
    frames.shown = frames.all.emplace_back(std::make_shared<ImageU8>(screen.projection.frame_size(), 3));
  }
  take_show();
}

SideScreens::~SideScreens() = default;

void SideScreens::take_show() {
  const Show& show = first_.show();
  std::map<const device::ContentSource*, std::shared_ptr<DrawnPicture>> pictures;
  Show same;
  same.surfaces = show.surfaces;
  for (std::size_t i = 0; i < show.contents.size(); ++i) {
    const device::ContentSource* const content = show.contents[i].get();
    if (content == nullptr) {
      same.contents.push_back(nullptr);
      continue;
    }
    // A content on two surfaces has the same picture on both.
    std::shared_ptr<DrawnPicture>& picture = pictures[content];
    if (!picture) {
      const auto known = pictures_.find(content);
      picture = known != pictures_.end() ? known->second : std::make_shared<DrawnPicture>(first_);
    }
    picture->is_of(i);
    same.contents.push_back(picture);
  }
  for (const SideScreen& screen : screens_) screen.projection.set_show(same);
  pictures_ = std::move(pictures);
}

void SideScreens::add(const track::StampedPose& message) {
  for (const SideScreen& screen : screens_) screen.projection.add(message);
}

void SideScreens::set_picture(TestPattern picture) {
  for (const SideScreen& screen : screens_) screen.projection.set_picture(picture);
}

void SideScreens::draw(double light_time, const std::function<void(const std::string&)>& say_fault) {
  for (std::size_t i = 0; i < screens_.size(); ++i) {
    Frames& frames = frames_[i];
    frames.shown.reset();
    auto unheld = std::find_if(frames.all.begin(), frames.all.end(),
                               [](const auto& frame) { return frame.use_count() == 1; });
    if (unheld == frames.all.end()) {
      frames.all.push_back(std::make_shared<ImageU8>(screens_[i].projection.frame_size(), 3));
      unheld = std::prev(frames.all.end());
    }
    frames.shown = *unheld;
    ImageU8& frame = *frames.shown;
    try {
      const DrawnFrame drawn = screens_[i].projection.draw(light_time, 0, frame);
      if (!drawn.content_fault.empty()) say_fault(drawn.content_fault);
    } catch (const std::exception& error) {
      std::fill_n(frame.data(), std::ptrdiff_t(frame.width()) * frame.height() * 3, std::uint8_t(0));
      say_fault(screens_[i].name + ": " + error.what());
    }
  }
}

void SideScreens::show() {
  for (std::size_t i = 0; i < screens_.size(); ++i) screens_[i].sink.show_soon(*frames_[i].shown);
}

std::shared_ptr<const ImageU8> SideScreens::frame(std::size_t i) const {
  return frames_[i].shown;
}

BlendScene SideScreens::scene_of(const SideScreen& screen, const ProjectorNames& set) const {
  return {set, screen.projection.rig_from_projector(), first_.show().surfaces};
}

void SideScreens::begin_blend(const ProjectorNames& set) {
  for (const SideScreen& screen : screens_)
    if (screen.blend != nullptr)
      screen.projection.set_blend(screen.blend->make_now(scene_of(screen, set))->blend);
}

void SideScreens::want_blend(std::uint64_t version, const std::vector<ProjectorNames>& sets) {
  for (const SideScreen& screen : screens_)
    if (screen.blend != nullptr) screen.blend->want(version, scene_of(screen, {}), sets);
}

bool SideScreens::is_blend_ready(const ProjectorNames& set) const {
  return std::all_of(screens_.begin(), screens_.end(), [&](const SideScreen& screen) {
    return screen.blend == nullptr || screen.blend->is_ready(set);
  });
}

void SideScreens::use_blend(const ProjectorNames& set) {
  for (const SideScreen& screen : screens_)
    if (screen.blend != nullptr)
      if (const auto made = screen.blend->find(set)) screen.projection.set_blend(made->blend);
}

}  // namespace procam::show
