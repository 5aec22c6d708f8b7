// A cart moves to and fro before a rig that stands still, and its picture stays on it (docs/tracked-surfaces.md):
//
//   08_cart picture.png OUT
//
// A camera of the rig finds two printed markers on the cart's board. Its images arrive 30 ms after their exposure, and the
// light of a frame comes 35 ms after it is drawn. Drawn twice: where the cart was seen last, and where it will be when the light
// comes. OUT/cart.mp4 has both side by side, OUT/cart.png the moment at which the first is worst, OUT/cart_error.svg the true error
// over time. The program fails unless predicting brings the error below 2 mm RMS, and ten times less.
#include <array>
#include <cstdio>
#include <deque>
#include <iostream>

#include "../common/error_plot.hpp"
#include "../common/stage.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/track/pose_chooser.hpp"
#include "procam/track/sight_surface.hpp"

using namespace procam;

namespace {

constexpr double kFramesPerSecond = 30, kEnd = 5, kSettled = 1;  // seconds; the filter has to begin
constexpr double kCameraDelay = 0.030, kLooking = 0.012, kDisplayDelay = 0.035;
const Vec2 kPicture(0.6, 0.4);  // metres; the board is a little larger

Rig calibrated_rig() {
  Rig rig;
  Vec6 place;
  place << -0.06, -0.05, 0.02, 0.31, 0.05, 0.03;
  rig.cameras.push_back(
      {"camera",
       {{640, 480}, {626, 621, 316.5, 245.5, 0.2}, BrownConrady{{0.06, -0.12, 0.001, -0.0007, 0}}},
       Pose(so3_exp(Vec3(0.01, -0.02, 0.03)), Vec3(-0.02, 0.01, 0))});
  rig.projectors.push_back(
      {"projector",
       {{{640, 480}, {650, 644, 330, 381, -0.5}, BrownConrady{{-0.03, 0.01, -0.0005, 0.0006, 0}}}},
       se3_exp(place)});
  return rig;
}

/// The middle of the board, in the rig: at most 0.3 m/s.
Pose cart(double time) {
  const double way = 0.36 * std::sin(0.83 * time);
  return Pose(so3_exp(Vec3(0.03, 0.22, 0.02)), Vec3(0.05 + 0.97 * way, 0.02, 1.9 + 0.25 * way));
}

/// Two markers within the picture, in the frame of its middle.
MarkerMap markers() {
  MarkerMap map;
  map.dictionary = MarkerDictionary::kAprilTag36h11;
  map.markers = {{5, 0.1, Pose(Eigen::Quaterniond::Identity(), Vec3(-0.215, -0.115, 0))},
                 {9, 0.1, Pose(so3_exp(Vec3(0, 0, 0.4)), Vec3(0.2, 0.1, 0))}};
  return map;
}

simulate::Room room(const MarkerMap& map, const MarkerCells& cells, const Pose& rig_from_middle) {
  simulate::Room room;
  room.ambient = 0.05;
  room.bodies.push_back(
      examples::sheet("wall", {-4, -3}, {4, 3}, 0.5, Pose(so3_exp(Vec3(0.02, -0.03, 0)), Vec3(0, 0, 3.2))));
  const Vec2 board = 0.5 * kPicture + Vec2(0.04, 0.04);
  room.bodies.push_back(examples::sheet("board", -board, board, 0.7, rig_from_middle));
  examples::add_tape(room, kPicture, 0.008, rig_from_middle, 0.7);
  for (const PlacedMarker& marker : map.markers)
    room.bodies.push_back(simulate::marker_sheet(marker, cells, rig_from_middle, 1));
  return room;
}

show::Projection projection(const Rig& rig, const ImageU8& picture, track::Prediction prediction) {
  show::ProjectionOptions options;
  options.moving.surfaces = {{{"cart"}, markers()}};
  options.moving.track.delay = kCameraDelay;
  options.moving.track.prediction = prediction;
  options.moving.marker_light = 200;
  show::Projection projection(rig, options);
  projection.set_show(examples::one_surface("cart", "rig", cart(0), kPicture, picture));
  return projection;
}

/// From the rig's camera to poses of the cart.
class CartCamera {
 public:
  CartCamera(const Rig& rig, const MarkerMap& map)
      : rig_(rig), map_(map), cells_(detect::marker_cells(map.dictionary)) {}

  ImageU8 image(const simulate::Room& room, const ImageU8& frame, std::uint64_t number) {
    simulate::RoomViewOptions view;
    view.exposure = exposure_;
    view.brightest_grey = 210;
    view.camera_blur_px = 0.7;
    view.gamma = 2.2;
    view.noise = {2, 0.02};
    view.seed = number;
    view.adaptive = true;
    simulate::RoomLight light{rig_.projector().projector, rig_.projector().rig_from_projector, {frame}};
    light.gamma = simulate::kSrgb;
    const simulate::RoomView seen =
        simulate::room_view(room, rig_.camera().camera, rig_.camera().rig_from_camera, {light}, view);
    exposure_ = seen.exposure;
    return seen.image();
  }

  /// Nothing where the markers are not found.
  std::optional<track::StampedPose> sight(const ImageU8& image, double arrival) {
    const MarkerDetections found = detect::detect_marker_edges(image, cells_, {rig_.camera().camera});
    if (found.markers.empty()) return std::nullopt;
    const track::SurfaceSighting seen = track::sight_surface(found, rig_.camera(), map_);
    const track::ChosenPose chosen = chooser_.choose(arrival, seen.poses);
    if (chosen.odds > 0.05) return std::nullopt;
    track::StampedPose message;
    message.arrival = arrival;
    message.frame = "rig";
    message.child = "cart";
    message.frame_from_child = seen.poses[chosen.index].pose.pose;
    message.covariance = seen.poses[chosen.index].pose.covariance;
    return message;
  }

  const MarkerCells& cells() const { return cells_; }

 private:
  const Rig& rig_;
  const MarkerMap& map_;
  MarkerCells cells_;
  track::PoseChooser chooser_;
  double exposure_ = 0;
};

/// Of the light, on the board where it truly is.
double squared_error(const Rig& rig, const show::Projection& projection, const Pose& rig_from_middle) {
  const auto& drawn = std::get<PlacedPlane>(projection.solved().surfaces[0].placement);
  return examples::squared_error(rig.projector().projector, drawn.projector_from_surface,
                                 rig.projector().projector,
                                 rig.projector().rig_from_projector.inverse() * rig_from_middle, kPicture);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::cerr << "usage: 08_cart picture.png OUT\n";
    return 2;
  }
  const std::filesystem::path out = argv[2];
  const ImageU8 picture = io::load_image(argv[1]).image;
  const Rig rig = calibrated_rig();
  const MarkerMap map = markers();
  CartCamera camera(rig, map);
  std::array<show::Projection, 2> shows{projection(rig, picture, track::Prediction::kNone),
                                        projection(rig, picture, track::Prediction::kAuto)};
  const std::array<const char*, 2> names{"where it was seen", "predicted to the light"};
  examples::Spectator spectator;
  spectator.eye.intrinsics = {700, 700, 239.5, 179.5};
  spectator.room_from_eye = Pose(so3_exp(Vec3(0.06, 0.12, 0)), Vec3(-0.2, 0.12, 0.4));
  examples::SideBySide video(out / "cart.mp4", spectator.eye.size, kFramesPerSecond / 2);
  examples::ErrorPlot plot{"drawn where it was seen", "predicted to the light", {}, {}, {}, {}};
  std::deque<track::StampedPose> under_way;
  ImageU8 frame(shows[0].frame_size(), 3);
  std::array<double, 2> sums{0, 0};
  int judged = 0;
  double worst = 0;
  for (int k = 0; k < int(kEnd * kFramesPerSecond); ++k) {
    const double light = 10 + k / kFramesPerSecond;
    for (; !under_way.empty() && under_way.front().arrival + kLooking <= light - kDisplayDelay;
         under_way.pop_front())
      for (show::Projection& show : shows) show.add_sighting(under_way.front());
    const Pose truth = cart(light);
    const simulate::Room place = room(map, camera.cells(), truth);
    std::array<double, 2> errors{0, 0};
    for (int i = 0; i < 2; ++i) {
      shows[std::size_t(i)].draw(light, light, frame);
      errors[std::size_t(i)] = squared_error(rig, shows[std::size_t(i)], truth);
      if (k % 2 != 0) continue;
      char words[64];
      std::snprintf(words, sizeof words, "%s: %.1f mm off", names[std::size_t(i)],
                    1e3 * std::sqrt(errors[std::size_t(i)]));
      const bool is_dark = shows[std::size_t(i)].moving()[0].is_dark;
      video.put(i,
                spectator.view(place, rig.projector().projector, rig.projector().rig_from_projector, frame),
                is_dark ? "not seen yet" : words);
    }
    if (k % 2 == 0) {  // 15 images a second
      video.add();
      if (const auto seen = camera.sight(camera.image(place, frame, std::uint64_t(k)), light + kCameraDelay))
        under_way.push_back(*seen);
    }
    if (light - 10 < kSettled) continue;
    plot.add(light - 10, std::sqrt(errors[0]), std::sqrt(errors[1]));
    for (std::size_t i = 0; i < 2; ++i) sums[i] += errors[i];
    ++judged;
    if (k % 2 == 0 && errors[0] > worst) worst = errors[0], video.save(out / "cart.png");
  }
  video.finish();
  plot.save(out / "cart_error.svg");
  const double seen_mm = 1e3 * std::sqrt(sums[0] / judged), predicted_mm = 1e3 * std::sqrt(sums[1] / judged);
  std::printf("on the cart, RMS of %d frames: where it was seen %.1f mm, predicted to the light %.2f mm\n",
              judged, seen_mm, predicted_mm);
  return predicted_mm < 2 && predicted_mm < seen_mm / 10 ? 0 : 1;
} catch (const Error& error) {
  std::cerr << error.what() << "\n";
  return 3;
}
