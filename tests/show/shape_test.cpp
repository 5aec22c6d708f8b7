/// From depth images of sand to light on it: contour lines where they belong, and none on a hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "height_content.hpp"
#include "procam/io/image/images.hpp"
#include "procam/simulate/room_view.hpp"
#include "room_watch.hpp"
#include "support/expect_error.hpp"
#include "support/sand.hpp"

namespace procam::show {
namespace {

using procam::test::sand;
using procam::test::SandBox;

constexpr double kPeriod = 1.0 / 30, kDelay = 0.05;

/// A depth camera and a projector beside it over sand; the rig is the depth camera's frame.
struct SandShow {
  SandBox box{1};
  Rig rig;
  RoomOptions options;
  std::optional<DepthSurfaceTracker> tracker;
  std::optional<Projection> projection;
  std::shared_ptr<ShownHeights> shown = std::make_shared<ShownHeights>();
  double time = 10;
  std::uint64_t images = 0;

  SandShow() {
    RigProjector lamp;
    lamp.name = "lamp";
    lamp.projector.inverse_camera = {{960, 600}, {1010, 996, 471.3, 322.9, 0.7}, NoDistortion{}};
    lamp.rig_from_projector = Pose(so3_exp(Vec3(0.04, -0.17, 0.03)), Vec3(0.19, -0.05, 0.04));
    rig.projectors.push_back(lamp);
    RigCamera eye;
    eye.name = "depth";
    eye.camera = box.sensor.camera;
    rig.cameras.push_back(eye);
    options.camera = eye;
    options.delay = kDelay;
    options.world_from_rig = Pose();
    options.shape.emplace();
    options.silhouettes = shape_silhouettes();
    tracker.emplace(options);
    ProjectionOptions drawing;
    drawing.projector_from_world = lamp.rig_from_projector.inverse();
    projection.emplace(rig, drawing);
  }
  /// An image that was exposed at `time`.
  void see(const simulate::Room& room) {
    const auto surfaces = tracker->look({box.seen(room, ++images), time + kDelay});
    if (!surfaces) return;
    shown->map = tracker->shape()->field.at(time);
    Show show;
    show.surfaces = *surfaces;
    show.contents.push_back(height_content("height:colours,range=-60mm..60mm,contours=15mm", shown));
    projection->set_show(show);
  }
  ImageU8 frame(double light) {
    shown->map = tracker->shape()->field.at(light);
    EXPECT_TRUE(projection->set_mesh(kShapeName, depth::mesh_of(shown->map)));
    ImageU8 drawn(projection->frame_size(), 3);
    projection->draw(light, 0, drawn.view());
    darken_before_room(drawn.view(), *projection, light, tracker->silhouettes().get(), shape_silhouettes());
    return drawn;
  }
  Pose room_from_reference() const { return box.room_from_camera * tracker->shape()->world_from_reference; }
  /// What a camera beside sees of the light.
  simulate::RoomView photo(const simulate::Room& room, const ImageU8& frame) const {
    simulate::RoomLight light;
    light.projector = rig.projectors[0].projector;
    light.room_from_projector = box.room_from_camera * rig.projectors[0].rig_from_projector;
    light.frames = {frame};
    light.gamma = simulate::kSrgb;
    const Camera camera{{900, 560}, {980, 975, 455, 339, 0}, NoDistortion{}};
    const Pose room_from_camera =
        box.room_from_camera * Pose(so3_exp(Vec3(-0.2, 0.1, 0.06)), Vec3(-0.12, -0.22, 0));
    simulate::RoomViewOptions viewing;
    viewing.colour = true;
    viewing.gamma = simulate::kSrgb;
    viewing.threads = 2;
    return simulate::room_view(room, camera, room_from_camera, {light}, viewing);
  }
};

int brightness(const ImageU8& picture, int x, int y) {
  return std::max({picture.at(x, y, 0), picture.at(x, y, 1), picture.at(x, y, 2)});
}

TEST(LiveShape, ContoursOnMovingSandLieAtTheirTrueHeights) {
  SandShow show;
  constexpr double kSpeed = 0.2;
  const auto shift = [&](double time) { return kSpeed * (time - 10); };
  for (int i = 0; i < 25; ++i, show.time += kPeriod) show.see(show.box.room(shift(show.time), 0));
  const double light = show.time + kDelay;
  const simulate::RoomView seen = show.photo(show.box.room(shift(light), 0), show.frame(light));
  const ImageU8& photo = seen.image();
  if (const char* folder = std::getenv("PROCAM_SHAPE_PICTURE"))
    io::save_image(std::string(folder) + "/sandbox.png", photo);
  // Heights are counted from the plane that was fitted.
  const Pose reference_from_room = show.room_from_reference().inverse();
  const auto height_at = [&](int x, int y) {
    const auto& point = seen.truth.point_in_room;
    return -(reference_from_room * Vec3(point.at(x, y, 0), point.at(x, y, 1), point.at(x, y, 2))).z();
  };
  // The middle of a dark run between lit pixels of a row is on a line.
  std::vector<double> errors;
  for (int y = 60; y < photo.height() - 60; y += 3)
    for (int x = 120; x < photo.width() - 120; ++x) {
      if (brightness(photo, x, y) > 60 || brightness(photo, x - 1, y) <= 60) continue;
      int end = x;
      while (end < photo.width() - 1 && brightness(photo, end, y) <= 60) ++end;
      if (end - x > 12) continue;  // along a line, or a flat place
      const double height = height_at((x + end - 1) / 2, y);
      errors.push_back(std::abs(height - 0.015 * std::round(height / 0.015)));
    }
  ASSERT_GT(errors.size(), 300u);
  std::sort(errors.begin(), errors.end());
  std::printf("%zu places on lines, off by %.2f mm (median), %.2f mm (95 %%)\n", errors.size(),
              1e3 * errors[errors.size() / 2], 1e3 * errors[errors.size() * 95 / 100]);
  EXPECT_LT(errors[errors.size() / 2], 0.001);
  EXPECT_LT(errors[errors.size() * 95 / 100], 0.003);
}

TEST(LiveShape, AHandOverTheSandStaysDark) {
  SandShow show;
  for (int i = 0; i < 10; ++i, show.time += kPeriod) show.see(show.box.room(0, 0));
  const auto hand_at = [](double time) { return Vec2(0.02 + 0.1 * (time - 10.3), -0.03); };
  for (int i = 0; i < 10; ++i, show.time += kPeriod)
    show.see(SandBox::with_hand(show.box.room(0, 0), hand_at(show.time), 0.22));
  const double light = show.time + kDelay - kPeriod;
  const simulate::Room now = SandBox::with_hand(show.box.room(0, 0), hand_at(light), 0.22);
  const simulate::RoomView seen = show.photo(now, show.frame(light));
  int on_hand = 0, lit_on_hand = 0, on_sand = 0, lit_on_sand = 0;
  for (int y = 100; y < seen.image().height() - 100; ++y)
    for (int x = 150; x < seen.image().width() - 150; ++x) {
      const int body = seen.truth.body.at(x, y);
      const bool lit = brightness(seen.image(), x, y) > 20;
      if (body == 1) ++on_hand, lit_on_hand += lit;
      if (body == 0) ++on_sand, lit_on_sand += lit;
    }
  EXPECT_GT(on_hand, 3000);
  EXPECT_EQ(lit_on_hand, 0);
  EXPECT_GT(lit_on_sand, on_sand * 2 / 5);  // the camera sees sand around the field too
}

TEST(LiveShape, ItIsToldOnceAndMovesFromThen) {
  SandShow show;
  const simulate::Room room = show.box.room(0, 0);
  const auto first = show.tracker->look({show.box.seen(room, 1), 1});
  ASSERT_TRUE(first);
  ASSERT_EQ(first->surfaces.size(), 1u);
  EXPECT_EQ(first->surfaces[0].name, "shape");
  EXPECT_FALSE(show.tracker->look({show.box.seen(room, 2), 1 + kPeriod}));
  const Image<std::uint16_t> nothing(640, 480);
  DepthSurfaceTracker blind(show.options);
  EXPECT_ERROR(blind.look({nothing, 1}), kNotEnoughData, "readings in 0 of");
}

TEST(HeightContent, TextsThatAreNoneAreRefusedWithTheirReason) {
  const depth::HeightColours colours = parse_height_content("height:colours,range=-50mm..80mm,contours=2cm");
  EXPECT_DOUBLE_EQ(colours.lowest, -0.05);
  EXPECT_DOUBLE_EQ(colours.highest, 0.08);
  EXPECT_DOUBLE_EQ(colours.contours, 0.02);
  EXPECT_ERROR(parse_height_content("height:colours,range=80mm..-50mm"), kInput, "no width");
  EXPECT_ERROR(parse_height_content("height:colours,contours=20"), kInput, "20");
  EXPECT_ERROR(parse_height_content("height:grey"), kInput, "height:colours");
  EXPECT_ERROR(parse_height_content("height:colours,lines=2"), kInput, "'lines=2' is not known");
}

}  // namespace
}  // namespace procam::show
