/// Lenses out of focus against the closed form of an edge through a disc, and colour against views of one
/// colour.
#include <gtest/gtest.h>

#include "blur_disc.hpp"
#include "procam/simulate/room_view.hpp"
#include "rooms.hpp"

namespace procam::simulate {
namespace {

using test::hung;
using test::looking_at;
using test::lopsided_room;
using test::room_camera;
using test::room_from_camera;
using test::room_light;

/// How much of a disc about x lies on the positive side: an edge's profile.
double disc_edge(double x, double radius) {
  const double t = std::clamp(x / radius, -1.0, 1.0);
  return 0.5 + (t * std::sqrt(1 - t * t) + std::asin(t)) / M_PI;
}
/// Through a disc, then the mean over a box of pixels.
double disc_edge_in_pixel(double x, double radius, double width) {
  double sum = 0;
  for (int i = 0; i < 16; ++i) sum += disc_edge(x + width * ((i + 0.5) / 16 - 0.5), radius);
  return sum / 16;
}

Camera plain_camera() {
  Camera camera = room_camera({480, 384});
  camera.distortion = NoDistortion{};
  return camera;
}

/// Dark to the left, light to the right of the line u = 1/2, a little turned.
Body halves(const Vec3& middle, double turn) {
  Texture picture{ImageU8(2, 1), 0.9, 0.1};
  picture.image.at(1, 0) = 255;
  return {"halves", Rectangle{Vec2(-2, -2), Vec2(2, 2)}, Pose(so3_exp(Vec3(0, 0, turn)), middle), picture};
}

TEST(ThinLens, FillsADiscByTheDistanceFromItsFocus) {
  // A 25 mm lens at f/2.5 (10 mm), pixels of 5 um, in focus at 1.25 m: of a point at 2 m by similar
  // triangles.
  const Camera camera{{640, 480}, {5102.04, 5102.04, 320, 240, 0}, NoDistortion{}};
  const double image_distance = 1 / (1 / 0.025 - 1 / 1.25), of_two_metres = 1 / (1 / 0.025 - 1 / 2.0);
  const double disc = 0.01 * (image_distance - of_two_metres) / of_two_metres;
  EXPECT_NEAR(blur_disc({0.01, 1.25}, camera, 2.0), disc / 5e-6, 1e-3);
  EXPECT_NEAR(blur_disc({0.01, 1.25}, camera, 1.25), 0, 1e-12);
  EXPECT_THROW(blur_disc({0.01, 1.25}, camera, 0), std::invalid_argument);
  EXPECT_THROW(blur_disc({0.01, -1}, camera, 1), std::invalid_argument);
}

TEST(RoomView, AnEdgeBeforeOrBehindTheCamerasFocusIsThatOfADisc) {
  const Camera camera = plain_camera();
  const ThinLens lens{0.04, 1.3};
  for (const double depth : {0.85, 1.1, 1.6, 2.9}) {
    Room room;
    room.ambient = 1;
    room.bodies = {halves(Vec3(0.02, 0.01, depth), 0.07)};
    RoomViewOptions options;
    options.exposure = 250;
    options.lens = lens;
    options.samples_per_axis = 4;
    const ImageU8 image = room_view(room, camera, Pose(), {}, options).image();
    const double radius = 0.5 * lens.aperture * std::sqrt(camera.intrinsics.fx * camera.intrinsics.fy) *
                          std::abs(1 / depth - 1 / lens.focus);
    ASSERT_GT(radius, 0.7);
    const Vec2 a = *camera.project(point_at(room.bodies[0], Vec2(0.5, 0.3)));
    const Vec2 along = (*camera.project(point_at(room.bodies[0], Vec2(0.5, 0.7))) - a).normalized();
    double worst = 0, sum = 0, moment = 0, weight = 0;
    for (int y = 30; y < 354; ++y)
      for (int x = 30; x < 450; ++x) {
        const Vec2 out = Vec2(x, y) - a;
        const double distance = out.x() * along.y() - out.y() * along.x();  // to the right of the edge
        const double share = (image.at(x, y) - 25) / 200.0;
        if (std::abs(distance) > radius + 3) continue;
        const double error = share - disc_edge_in_pixel(distance, radius, 1);
        worst = std::max(worst, std::abs(error));
        sum += error;
        // Twice the integral of x (step - profile) is the variance of the edge's spread.
        moment += 2 * distance * ((distance > 0 ? 1 : 0) - share);
        weight += 1;
      }
    EXPECT_LT(worst, 0.09 / radius) << depth;  // a disc on the pixel grid is the coarser the smaller it is
    EXPECT_LT(std::abs(sum / weight), 0.001) << depth;
    const double variance = moment / weight * (2 * radius + 6);
    EXPECT_NEAR(variance, radius * radius / 4 + 1 / 12.0, 0.03 * radius * radius / 4 + 0.02) << depth;
  }
}

TEST(RoomView, AProjectorsEdgeIsThatOfADiscWhereverItFalls) {
  // The wall leaves the focus: the disc grows along it.
  RoomLight light = room_light(ImageU8(512, 390));
  for (int y = 0; y < 390; ++y)
    for (int x = 257; x < 512; ++x) light.frames[0].at(x, y) = 255;
  light.frames.push_back(ImageU8(512, 390, 1, 255));
  light.lens = {0.08, 2.2};
  Room room;
  room.bodies = {hung("wall", Vec3(0, 2.1, 1), Vec3(0.5, -1, 0.35), Vec2(9, 9), 0.6)};
  light.room_from_projector = looking_at(Vec3(0.25, -0.2, 0.95), Vec3(0.2, 2.5, 0.75), 1.3);
  const Camera camera = room_camera({960, 768});
  RoomViewOptions options;
  options.brightest_grey = 250;
  const RoomView view = room_view(room, camera, room_from_camera(), {light}, options);
  const Pose projector_from_room = light.room_from_projector(0).inverse();
  double smallest = 100, largest = 0, worst = 0;
  int count = 0;
  for (int y = 5; y < 763; y += 2)
    for (int x = 5; x < 955; x += 2) {
      if (!view.truth.light[0].lit.at(x, y) || view.captures[1].at(x, y) < 60) continue;
      const float* pixel = view.truth.light[0].pixel.row(y) + 2 * x;
      if (std::abs(pixel[0] - 256) > 16 || pixel[1] < 20 || pixel[1] > 370 || pixel[0] < 20) continue;
      const float* p = view.truth.point_in_room.row(y) + 3 * x;
      const double depth = (projector_from_room * Vec3(p[0], p[1], p[2])).z();
      const double radius = 0.5 * blur_disc(light.lens, light.projector.inverse_camera, depth);
      if (radius < 1.2) continue;  // where the pixel's own shape counts
      ++count;
      smallest = std::min(smallest, radius);
      largest = std::max(largest, radius);
      const double share = view.captures[0].at(x, y) / double(view.captures[1].at(x, y));
      // The tent's edge lies half way between the dark and the light pixel.
      worst = std::max(worst, std::abs(share - disc_edge_in_pixel(pixel[0] - 256.5, radius, std::sqrt(2.0))));
    }
  EXPECT_GT(count, 1000);
  EXPECT_LT(smallest, 1.3);
  EXPECT_GT(largest, 2.5);
  EXPECT_LT(worst, 0.04);
}

TEST(RoomView, WhatIsNearerCoversWhatIsOutOfFocus) {
  const Camera camera = plain_camera();
  const Body near{"near", Rectangle{Vec2(-1, -1), Vec2(0, 1)},
                  Pose(Eigen::Quaterniond::Identity(), Vec3(0.013, 0, 1)), 0.9};
  const Body far{"far", Rectangle{Vec2(-9, -9), Vec2(9, 9)},
                 Pose(Eigen::Quaterniond::Identity(), Vec3(0, 0, 3)), 0.2};
  const double outline = camera.project(Vec3(0.013, 0, 1))->x();
  Room room;
  room.ambient = 1;
  room.bodies = {near, far};
  RoomViewOptions options;
  options.exposure = 250;
  options.samples_per_axis = 4;
  const auto view_through = [&](const ThinLens& lens) {
    options.lens = lens;
    return room_view(room, camera, Pose(), {}, options).image();
  };
  const ImageU8 near_in_focus = view_through({0.03, 1}), far_in_focus = view_through({0.03, 3});
  const auto share = [](const ImageU8& image, int x) { return (image.at(x, 128) - 50) / 175.0; };
  for (int x = int(outline) - 9; x < int(outline) + 10; ++x) {
    // In focus it keeps its outline before the blur; out of focus the outline is an edge like any other. The
    // pixel on the outline counts for one side as a whole: half a pixel.
    if (std::abs(x - outline) > 1) {
      EXPECT_NEAR(share(near_in_focus, x), x < outline ? 1 : 0, 0.1) << x;
    }
    const double radius = 0.5 * blur_disc({0.03, 3}, camera, 1);
    EXPECT_NEAR(share(far_in_focus, x), disc_edge_in_pixel(outline - x, radius, 1), 0.2) << x;
  }
}

ImageU8 channel_of(const ImageU8& image, int channel) {
  ImageU8 one(image.size());
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) one.at(x, y) = image.at(x, y, channel);
  return one;
}

int pixels_that_differ(const ImageU8& a, const ImageU8& b, int by_more_than) {
  int count = 0;
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width(); ++x) count += std::abs(a.at(x, y) - b.at(x, y)) > by_more_than;
  return count;
}

/// Another pattern in every channel.
ImageU8 colour_frame() {
  ImageU8 frame(512, 390, 3);
  for (int y = 0; y < 390; ++y)
    for (int x = 0; x < 512; ++x) {
      frame.at(x, y, 0) = std::uint8_t(x / 2);
      frame.at(x, y, 1) = std::uint8_t((x / 20 + y / 30) % 2 ? 230 : 30);
      frame.at(x, y, 2) = std::uint8_t(255 - y / 2);
    }
  return frame;
}
Texture colour_poster() {
  Texture picture{ImageU8(30, 20, 3)};
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 30; ++x)
      for (int c = 0; c < 3; ++c)
        picture.image.at(x, y, c) = std::uint8_t(40 + (x * (c + 3) + y * 7 * c) % 200);
  return picture;
}

TEST(RoomView, EachColourOfAViewIsThatColoursPictureInThatColoursLight) {
  const Camera camera = room_camera();
  Room room = lopsided_room();
  const std::size_t poster = std::size_t(room.index_of("poster"));
  RoomLight light = room_light(colour_frame());
  light.gamma = 2.1;
  RoomViewOptions options;
  options.exposure = 2500;
  options.gamma = 1.6;
  options.colour = true;
  options.crosstalk = 0;
  for (const bool coloured_room : {false, true}) {
    if (coloured_room) room.bodies[poster].paint = colour_poster();
    const RoomView view = room_view(room, camera, room_from_camera(), {light}, options);
    ASSERT_EQ(view.image().channels(), 3);
    for (int c = 0; c < 3; ++c) {
      Room one = room;
      if (coloured_room) one.bodies[poster].paint = Texture{channel_of(colour_poster().image, c)};
      RoomLight lamp = light;
      lamp.frames = {channel_of(light.frames[0], c)};
      RoomViewOptions grey = options;
      grey.colour = false;
      const ImageU8 alone = room_view(one, camera, room_from_camera(), {lamp}, grey).image();
      EXPECT_EQ(pixels_that_differ(channel_of(view.image(), c), alone, 1), 0) << c << coloured_room;
    }
    EXPECT_GT(pixels_that_differ(channel_of(view.image(), 0), channel_of(view.image(), 1), 20), 10000);
  }
}

TEST(RoomView, FiltersOverlapAndAGreyCameraSeesTheMean) {
  const Camera camera = room_camera({320, 256});
  Room room = lopsided_room();
  room.bodies[std::size_t(room.index_of("poster"))].paint = colour_poster();
  const RoomLight light = room_light(colour_frame());
  RoomViewOptions options;
  options.exposure = 800;
  options.colour = true;
  options.crosstalk = 0;
  const ImageU8 pure = room_view(room, camera, room_from_camera(), {light}, options).image();
  options.crosstalk = 0.2;
  const ImageU8 mixed = room_view(room, camera, room_from_camera(), {light}, options).image();
  options.colour = false;
  const ImageU8 grey = room_view(room, camera, room_from_camera(), {light}, options).image();
  ASSERT_EQ(grey.channels(), 1);
  int lit = 0;
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 320; ++x) {
      const double r = pure.at(x, y, 0), g = pure.at(x, y, 1), b = pure.at(x, y, 2);
      if (std::max({r, g, b}) > 254) continue;
      lit += std::min({r, g, b}) > 20;
      ASSERT_NEAR(mixed.at(x, y, 0), (r + 0.2 * g) / 1.2, 1.2);
      ASSERT_NEAR(mixed.at(x, y, 1), (0.2 * r + g + 0.2 * b) / 1.4, 1.2);
      ASSERT_NEAR(mixed.at(x, y, 2), (0.2 * g + b) / 1.2, 1.2);
      ASSERT_NEAR(grey.at(x, y), (r + g + b) / 3, 1.2);
    }
  EXPECT_GT(lit, 10000);
}

}  // namespace
}  // namespace procam::simulate
