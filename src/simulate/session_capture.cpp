/// What the camera of a simulated session records of a view, with the view's mistakes.
#include <algorithm>
#include <array>
#include <cmath>

#include "colour_sensor.hpp"
#include "noise.hpp"
#include "procam/simulate/session.hpp"
#include "sheet_points.hpp"

namespace procam::simulate {
namespace {

using internal::Random;

/// Light moved over the projected frame, linear between pixels; dark comes in from beyond its border.
ImageU8 moved_frame(const ImageU8& frame, const Vec2& shift) {
  ImageU8 moved(frame.size(), frame.channels());
  const int dx = int(std::floor(shift.x())), dy = int(std::floor(shift.y()));
  const double left = shift.x() - dx, top = shift.y() - dy;
  for (int y = 0; y < frame.height(); ++y)
    for (int x = 0; x < frame.width(); ++x)
      for (int channel = 0; channel < frame.channels(); ++channel) {
        const auto at = [&](int u, int v) {
          return u < 0 || v < 0 || u >= frame.width() || v >= frame.height()
                     ? 0.0
                     : double(frame.at(u, v, channel));
        };
        const int u = x - dx, v = y - dy;
        moved.at(x, y, channel) =
            std::uint8_t((1 - top) * ((1 - left) * at(u, v) + left * at(u - 1, v)) +
                         top * ((1 - left) * at(u, v - 1) + left * at(u - 1, v - 1)) + 0.5);
      }
  return moved;
}

double mean(const ImageU8& image) {
  double sum = 0;
  const std::ptrdiff_t count = std::ptrdiff_t(image.width()) * image.height() * image.channels();
  for (std::ptrdiff_t i = 0; i < count; ++i) sum += image.data()[i];
  return sum / double(count);
}

/// What the projector makes of a frame's values: light, linear as capture() takes it.
void show_frame(ImageU8& frame, const Conditions& c) {
  const double lamp = std::pow((mean(frame) / 255 + 0.05) / 1.05, c.iris);
  std::array<std::uint8_t, 256> light;
  for (std::size_t value = 0; value < light.size(); ++value)
    light[value] = std::uint8_t(255 * lamp * std::pow(double(value) / 255, c.projector_gamma) + 0.5);
  for (int y = 0; y < frame.height(); ++y) {
    std::uint8_t* row = frame.row(y);
    std::transform(row, row + frame.width() * frame.channels(), row,
                   [&](std::uint8_t value) { return light[value]; });
  }
}

/// Each frame with what is left of those before: a slow panel, or a camera that averages over time.
void add_lag(std::vector<ImageU8>& frames, double lag) {
  for (std::size_t i = 1; i < frames.size(); ++i)
    for (int y = 0; y < frames[i].height(); ++y) {
      const std::uint8_t* before = frames[i - 1].row(y);
      std::uint8_t* now = frames[i].row(y);
      const int values = frames[i].width() * frames[i].channels();
      std::transform(now, now + values, before, now, [lag](std::uint8_t n, std::uint8_t b) {
        return std::uint8_t((1 - lag) * n + lag * b + 0.5);
      });
    }
}

/// The conditions' faults of a view's sequence.
void add_faults(const SimulatedSession& session, std::size_t view, CaptureOptions& options,
                std::vector<ImageU8>& shown) {
  const Conditions& c = session.conditions;
  const World& world = session.views[view];
  Random random(session.capture.seed, view, 3);
  const auto normal = [&] {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += random.uniform(0, 1);
    return sum;
  };
  const double angle = random.uniform(0, 2 * kPi);
  const Vec2 direction(std::cos(angle), std::sin(angle));
  if (c.spot > 0) {
    options.spot = c.spot;
    const double x = random.uniform(0.3, 0.7), y = random.uniform(0.3, 0.7);
    const ArtworkRectangle print = print_of(world.board.layout);
    const Vec2 on_board = print.low + Vec2(x, y).cwiseProduct(print.high - print.low);
    const auto pixel =
        world.rig.camera().camera.project(world.rig.camera().rig_from_camera.inverse() *
                                          (world.rig_from_board * Vec3(on_board.x(), on_board.y(), 0)));
    if (pixel) options.spot_at = *pixel;
  }
  const std::size_t count = shown.size();
  if (c.auto_exposure > 0 || c.flicker > 0 || c.shake_px > 0 || c.drift_px > 0 || c.focus_drift_px > 0)
    options.faults.resize(count);
  for (std::size_t i = 0; i < options.faults.size(); ++i) {
    FrameFault& fault = options.faults[i];
    const double left = count > 1 ? 1 - double(i) / double(count - 1) : 0;
    const double shake_x = normal(), shake_y = normal();
    fault.shift_px = c.shake_px * Vec2(shake_x, shake_y) + left * c.drift_px * direction;
    fault.blur_px = left * c.focus_drift_px;
    // A frame's share of full light, and a tenth of it from the room.
    const double light = (mean(shown[i]) / 255 + 0.1) / 1.1;
    fault.gain =
        std::pow(light, -c.auto_exposure) * (1 + c.flicker * std::sin(2 * kPi * random.uniform(0, 1)));
    fault.ripple = c.flicker;
    fault.ripple_phase = random.uniform(0, 1);
  }
  if (c.projector_gamma != 1 || c.iris > 0)
    for (ImageU8& frame : shown) show_frame(frame, c);
  if (c.lag > 0) add_lag(shown, c.lag);
  if (c.projector_drift_px > 0)
    for (std::size_t i = 0; i + 1 < count; ++i)
      shown[i] =
          moved_frame(shown[i], (1 - double(i) / double(count - 1)) * c.projector_drift_px * direction);
}

std::vector<ImageU8> grey_captures(const SimulatedSession& session, std::size_t view,
                                   const std::vector<ImageU8>& frames) {
  CaptureOptions options = session.capture;
  options.seed = Random(session.capture.seed, view, 1).next();
  std::vector<ImageU8> shown = frames;
  add_faults(session, view, options, shown);
  const ViewDefects defects = session.defects.empty() ? ViewDefects{} : session.defects.at(view);
  if (defects.white) options.brightest_grey = 255 * *defects.white;
  const int count = int(frames.size());
  if (defects.missing && count > 1)
    for (int i = frame_at(*defects.missing, count); i + 1 < count; ++i)
      shown[std::size_t(i)] = shown[std::size_t(i + 1)];
  if (defects.stale && count > 1) {
    const auto stale = std::size_t(frame_at(*defects.stale, count));
    shown[stale] = shown[stale - 1];
  }
  World world = session.views[view];
  if (!session.lenses.empty()) world.rig.cameras.front().camera = session.lenses.at(view);
  if (defects.torn && count > 1) {
    std::vector<ImageU8> captures = capture(world, shown, options);
    const auto next = std::size_t(frame_at(*defects.torn, count));
    if (!options.faults.empty()) options.faults = {options.faults[next]};
    options.seed = Random(options.seed, 2, 0).next();
    const ImageU8 later = capture(world, {shown[next]}, options).front();
    // Through the board, wherever it is.
    const auto middle =
        world.rig.camera().camera.project(world.rig.camera().rig_from_camera.inverse() *
                                          (world.rig_from_board * middle_of_print(world.board.layout)));
    const int from = middle ? int(middle->y()) : later.height() / 2;
    for (int y = from; y < later.height(); ++y)
      std::copy_n(later.row(y), later.width() * later.channels(), captures[next - 1].row(y));
    return captures;
  }
  if (!defects.moved || count < 2) return capture(world, shown, options);
  const std::ptrdiff_t first_moved = frame_at(defects.moved->share, count);
  std::vector<FrameFault> later_faults;
  if (!options.faults.empty()) {
    later_faults.assign(options.faults.begin() + first_moved, options.faults.end());
    options.faults.resize(std::size_t(first_moved));
  }
  std::vector<ImageU8> captures = capture(world, {shown.begin(), shown.begin() + first_moved}, options);
  World moved = world;
  moved.rig_from_board = world.rig_from_board * defects.moved->board_from_moved;
  options.seed = Random(options.seed, 1, 0).next();
  options.faults = later_faults;
  for (ImageU8& image : capture(moved, {shown.begin() + first_moved, shown.end()}, options))
    captures.push_back(std::move(image));
  return captures;
}

}  // namespace

std::vector<ImageU8> capture_view(const SimulatedSession& session, std::size_t view,
                                  const std::vector<ImageU8>& frames) {
  require(view < session.views.size(), "capture_view: there is no view " + std::to_string(view));
  std::vector<ImageU8> captures = grey_captures(session, view, frames);
  if (session.conditions.colour_sensor)
    for (ImageU8& image : captures)
      if (image.channels() == 1)
        image = internal::through_colour_filters(image, session.conditions.lateral_colour);
  return captures;
}

}  // namespace procam::simulate
