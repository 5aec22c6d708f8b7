// A projector is bumped after its calibration, and one view of the board refreshes the rig (docs/calibration.md):
//
//   12_update BEFORE/truth.json AFTER/truth.json rig.json fresh.json picture.png OUT
//
// rig.json is the calibration before the bump, fresh.json what calibrate-projector --update made of it with one view after it;
// examples/run.sh makes all four files from simulated captures. A show on a wall is drawn twice: with rig.json to the end, and
// with fresh.json after the view was taken. OUT/update.mp4 has both side by side, OUT/update.png its end, OUT/update_error.svg the
// true error over time. The program fails unless the bump is worse than 3 mm, and the refreshed rig at most 0.5 mm worse than
// rig.json was before it.
#include <array>
#include <cstdio>
#include <iostream>

#include "../common/error_plot.hpp"
#include "../common/stage.hpp"
#include "procam/io/rig_file.hpp"

using namespace procam;

namespace {

constexpr double kFramesPerSecond = 10, kBump = 3, kPatterns = 6, kFresh = 8, kEnd = 11;  // seconds
const Vec2 kPoster(0.66, 0.44);                                                           // metres

/// Where the projector's light falls before the bump, askew; x right, y down. The rig stands still in the world.
Pose rig_from_middle(const Rig& truth) {
  const RigProjector& projector = truth.projector();
  const ImageSize size = projector.projector.size();
  const std::optional<Ray> ray = projector.projector.emit(Vec2(0.5 * size.width, 0.5 * size.height));
  if (!ray)
    throw Error(ErrorKind::kDegenerate, "true projector", "its centre pixel emits no ray", "check its lens");
  return Pose(so3_exp(Vec3(0.08, 0.3, 0)), projector.rig_from_projector * Vec3(2.0 * ray->direction));
}

simulate::Room room(const Pose& middle) {
  simulate::Room room;
  room.ambient = 0.05;
  room.bodies.push_back(examples::sheet("wall", {-2, -1.5}, {2, 1.5}, 0.75, middle));
  examples::add_tape(room, kPoster, 0.01, middle, 0.75);
  return room;
}

/// The show, drawn for a rig that stands before the wall.
ImageU8 frame_for(const Rig& rig, const Pose& middle, const ImageU8& picture) {
  show::ProjectionOptions options;
  options.projector_from_world = rig.projector().rig_from_projector.inverse();
  show::Projection projection(rig, options);
  projection.set_show(examples::one_surface("poster", "world", middle, kPoster, picture));
  ImageU8 frame(projection.frame_size(), 3);
  projection.draw(1, 1, frame);
  return frame;
}

/// One of the stripes of a Gray code.
ImageU8 stripes(ImageSize size, int bit) {
  ImageU8 frame(size, 3);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      std::fill_n(frame.view().row(y) + 3 * x, 3, std::uint8_t((((x ^ (x >> 1)) >> bit) & 1) != 0 ? 255 : 0));
  return frame;
}

double error_of(const Rig& rig, const Rig& truth, const Pose& middle) {
  const RigProjector &model = rig.projector(), &lamp = truth.projector();
  return std::sqrt(examples::squared_error(model.projector, model.rig_from_projector.inverse() * middle,
                                           lamp.projector, lamp.rig_from_projector.inverse() * middle,
                                           kPoster));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 7) {
    std::cerr << "usage: 12_update BEFORE/truth.json AFTER/truth.json rig.json fresh.json picture.png OUT\n";
    return 2;
  }
  const Rig before = io::load_rig(argv[1]), after = io::load_rig(argv[2]);
  const std::array<Rig, 2> rigs{io::load_rig(argv[3]), io::load_rig(argv[4])};
  const ImageU8 picture = io::load_image(argv[5]).image;
  const std::filesystem::path out = argv[6];
  const Pose middle = rig_from_middle(before);
  const simulate::Room wall = room(middle);
  const std::array<ImageU8, 2> frames{frame_for(rigs[0], middle, picture),
                                      frame_for(rigs[1], middle, picture)};

  examples::Spectator spectator;
  spectator.room_from_eye = middle * Pose(so3_exp(Vec3(-0.05, -0.2, 0)), Vec3(0.30, -0.18, -1.0));
  examples::SideBySide video(out / "update.mp4", spectator.eye.size, kFramesPerSecond);
  examples::ErrorPlot plot{"rig.json", "refreshed by --update", {}, {}, {}, {}};
  plot.events = {{kBump, "bump"}, {kPatterns, "one view"}, {kFresh, "fresh.json"}};
  for (int i = 0; i < int(kEnd * kFramesPerSecond); ++i) {
    const double time = i / kFramesPerSecond;
    const Rig& truth = time < kBump ? before : after;
    const std::size_t fresh = time < kFresh ? 0 : 1;
    const bool captures = time >= kPatterns && time < kFresh;
    plot.add(time, error_of(rigs[0], truth, middle), error_of(rigs[fresh], truth, middle));
    const auto seen = [&](const ImageU8& frame) {
      const RigProjector& lamp = truth.projector();
      return spectator.view(wall, lamp.projector, lamp.rig_from_projector, frame);
    };
    char words[64];
    std::snprintf(words, sizeof words, "rig.json: %.1f mm off", plot.without_mm.back());
    video.put(0, seen(frames[0]), words);
    if (captures) {
      const int pattern = int((time - kPatterns) * 5);
      video.put(1, seen(stripes(frames[0].size(), 9 - pattern)), "a view of the board is captured");
    } else {
      std::snprintf(words, sizeof words, "%s: %.1f mm off", fresh == 1 ? "fresh.json" : "rig.json",
                    plot.with_mm.back());
      video.put(1, seen(frames[fresh]), words);
    }
    video.add();
  }
  video.save(out / "update.png");
  video.finish();
  plot.save(out / "update_error.svg");
  std::printf("true error before the bump %.2f mm, after it %.2f mm, with the refreshed rig %.2f mm\n",
              plot.with_mm.front(), plot.without_mm.back(), plot.with_mm.back());
  return plot.without_mm.back() > 3 && plot.with_mm.back() < plot.with_mm.front() + 0.5 ? 0 : 1;
} catch (const Error& error) {
  std::cerr << error.what() << "\n";
  return 3;
}
