#include "projector_screens.hpp"

#include <algorithm>
#include <cmath>

#include "refused.hpp"
#include "wall.hpp"

namespace procam::studio {
namespace {

/// Sides that are longer than the frame is large are not drawn.
void draw_ring(const std::vector<Vec2>& ring, int half_width, std::uint8_t level, ImageU8& frame) {
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 from = ring[i], step = ring[(i + 1) % ring.size()] - from;
    if (!(step.norm() <= frame.width() + frame.height())) continue;
    const int steps = int(std::ceil(2 * step.norm())) + 1;
    for (int k = 0; k < steps; ++k) {
      const Vec2 point = from + k / double(steps) * step;
      const int x0 = int(std::lround(point.x())), y0 = int(std::lround(point.y()));
      for (int y = std::max(0, y0 - half_width); y <= std::min(frame.height() - 1, y0 + half_width); ++y)
        for (int x = std::max(0, x0 - half_width); x <= std::min(frame.width() - 1, x0 + half_width); ++x)
          frame.at(x, y) = level;
    }
  }
}

}  // namespace

ImageU8 guide_frame(ImageSize size, const std::vector<Vec2>& ring) {
  constexpr int kPixelsALine = 400;  // 5 pixels wide on 1024
  ImageU8 frame(size, 1, kGuideGround);
  draw_ring(ring, std::max(1, size.width / kPixelsALine), kGuideLine, frame);
  return frame;
}

/// A sink whose newest frame the page may show.
class ProjectorScreens::Screen : public device::FrameSink {
 public:
  Screen(device::FrameSink& sink, StudioPage& page, std::size_t number)
      : sink_(sink), page_(page), number_(number) {}
  ImageSize size() const override { return sink_.size(); }
  double show(ViewU8 picture) override {
    keep(picture);
    return sink_.show(picture);
  }
  double show_next(ViewU8 picture) override {
    keep(picture);
    return sink_.show_next(picture);
  }
  double show_soon(ViewU8 picture) override {
    keep(picture);
    return sink_.show_soon(picture);
  }
  device::WindowEvent poll() override { return sink_.poll(); }
  bool is_down(device::Key key) const override { return sink_.is_down(key); }

 private:
  void keep(ViewU8 picture) {
    auto frame = std::make_shared<ImageU8>(picture.width, picture.height, picture.channels);
    for (int y = 0; y < picture.height; ++y)
      std::copy_n(picture.row(y), picture.width * picture.channels, frame->row(y));
    page_.publish_frame(number_, std::move(frame));
  }
  device::FrameSink& sink_;
  StudioPage& page_;
  const std::size_t number_;
};

ProjectorScreens::ProjectorScreens(StudioPage& page) : page_(page) {}
ProjectorScreens::~ProjectorScreens() = default;

void ProjectorScreens::close() {
  screens_.clear();
}

void ProjectorScreens::open(const std::vector<ChosenProjector>& chosen, SimulatedStage* stage) {
  close();
  std::vector<Opened> opened;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    Opened one;
    one.name = chosen[i].name;
    if (stage == nullptr)
      one.window = device::open_window(device::find_display(device::displays(), chosen[i].display).number);
    one.screen = std::make_unique<Screen>(stage != nullptr ? stage->projector(i) : *one.window, page_, i);
    opened.push_back(std::move(one));
  }
  screens_ = std::move(opened);
}

device::FrameSink& ProjectorScreens::at(std::size_t i) {
  if (!is_open()) throw refused("projector", "no display is chosen", "choose one in the step 'display'");
  return *screens_.at(i).screen;
}

ImageSize ProjectorScreens::frame_size(std::size_t i) const {
  return screens_.at(i).screen->size();
}

void ProjectorScreens::poll() {
  for (const Opened& one : screens_) one.screen->poll();
}

void ProjectorScreens::show_flat(int level) {
  constexpr double kUsualGamma = 2.2;
  const double shared = level * std::pow(1.0 / double(std::max<std::size_t>(1, size())), 1 / kUsualGamma);
  for (std::size_t i = 0; i < size(); ++i)
    at(i).show(ImageU8(at(i).size(), 1, std::uint8_t(std::lround(shared))));
}

void ProjectorScreens::show_guide(std::size_t i, const std::vector<Vec2>& ring) {
  for (std::size_t number = 0; number < size(); ++number)
    at(number).show(guide_frame(at(number).size(), number == i ? ring : std::vector<Vec2>{}));
}

void ProjectorScreens::darken_others(std::size_t i) {
  for (std::size_t other = 0; other < size(); ++other)
    if (other != i) at(other).show(ImageU8(at(other).size(), 1, 0));
}

void ProjectorScreens::show_test_card() {
  for (std::size_t i = 0; i < size(); ++i) {
    ImageU8 card(at(i).size(), 1, 0);
    const int w = card.width(), h = card.height(), step = std::max(16, h / 12);
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        const bool border = x < 3 || y < 3 || x >= w - 3 || y >= h - 3;
        const bool grid = x % step == 0 || y % step == 0;
        const bool squares = std::abs(x - w / 2) < 2 * step && std::abs(y - h / 2) < step;
        card.at(x, y) = border ? 255 : squares ? ((x + y) % 2 == 0 ? 255 : 0) : grid ? 160 : 24;
      }
    at(i).show(card);
  }
}

void ProjectorScreens::show_outlines(const SurfaceSet& surfaces, const Rig& rig) {
  at();
  for (std::size_t number = 0; number < size(); ++number) {
    ImageU8 frame(at(number).size(), 1, 0);
    for (const Surface& one : surfaces.surfaces)
      draw_ring(outline_in_frame(one, rig, name(number)), 1, 255, frame);
    at(number).show(frame);
  }
}

}  // namespace procam::studio
