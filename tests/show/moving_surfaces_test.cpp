/// Surfaces that move on their own: where a frame has them, when they are dark, and a whole show with a camera that sees them.
#include <gtest/gtest.h>

#include <atomic>
#include <nlohmann/json.hpp>
#include <thread>

#include "control_messages.hpp"
#include "io/scratch.hpp"
#include "live_world.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/show/run.hpp"
#include "procam/simulate/marker_view.hpp"
#include "prometheus.hpp"
#include "run_log.hpp"
#include "run_options.hpp"
#include "support/expect_error.hpp"
#include "surface_source.hpp"

namespace procam::show {
namespace {

PlacedMarker marker_at(int id, double size, const Vec3& middle) {
  return {id, size, Pose(so3_exp(Vec3(0, 0, 0.3)), middle)};
}

Surface in_rig(const std::string& name, const Pose& rig_from_surface) {
  Surface surface = wall(name, {0, 0});
  auto& plane = std::get<PlanarSurface>(surface.geometry);
  plane.frame = "rig";
  plane.frame_from_surface = rig_from_surface;
  return surface;
}

Show show_of(std::vector<Surface> surfaces) {
  Show show;
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    show.contents.push_back(device::still_content(colourful(61, 47, int(i))));
  show.surfaces.surfaces = std::move(surfaces);
  return show;
}

Pose cart_place() {
  return Pose(so3_exp(Vec3(0.1, 0.3, -0.07)), Vec3(-0.5, -0.35, 2.1));
}

track::StampedPose sighting(double time, const Pose& rig_from_surface) {
  track::StampedPose message;
  message.arrival = time;
  message.frame = "rig";
  message.child = "cart";
  message.frame_from_child = rig_from_surface;
  message.covariance = 1e-6 * Mat6::Identity();
  return message;
}

ProjectionOptions tracking(std::vector<std::string> surfaces) {
  ProjectionOptions options;
  MovingSurface moving;
  moving.surfaces = std::move(surfaces);
  moving.markers.dictionary = MarkerDictionary::kAprilTag36h11;
  moving.markers.markers = {marker_at(5, 0.1, Vec3(0.2, 0.15, 0))};
  options.moving.surfaces = {moving};
  return options;
}

ImageU8 frame_of(Projection& projection, double time) {
  ImageU8 frame(projection.frame_size(), 3);
  projection.draw(time, 0, frame);
  return frame;
}

/// The frame of surfaces that stand where they are given.
ImageU8 frame_of(std::vector<Surface> surfaces) {
  Projection projection(small_rig(), {});
  projection.set_show(show_of(std::move(surfaces)));
  return frame_of(projection, 1);
}

TEST(MovingSurfaces, AreDrawnWhereTheyAreSeen) {
  Projection projection(small_rig(), tracking({"cart"}));
  const Pose elsewhere(so3_exp(Vec3(0, 0, 0)), Vec3(0, 0, 5));
  projection.set_show(show_of({in_rig("cart", elsewhere)}));
  ImageU8 frame(projection.frame_size(), 3);
  const DrawnFrame before = projection.draw(100, 0, frame);
  EXPECT_EQ(before.unseen, 1);
  EXPECT_EQ(fingerprint(frame), fingerprint(ImageU8(frame.size(), 3))) << "never seen: dark";
  ASSERT_EQ(projection.moving().size(), 1u);
  EXPECT_TRUE(projection.moving()[0].is_dark);

  projection.add_sighting(sighting(100, cart_place()));
  EXPECT_EQ(projection.draw(100, 0, frame).unseen, 0);
  EXPECT_EQ(fingerprint(frame), fingerprint(frame_of({in_rig("cart", cart_place())})));
  EXPECT_GT(projection.moving()[0].error, 0.0005);
  EXPECT_LT(projection.moving()[0].error, 0.01);
  // The pose of the projector in its rig takes part.
  const Pose bumped =
      small_rig().projector().rig_from_projector * Pose(so3_exp(Vec3(0.01, -0.02, 0)), Vec3(0, 0, 0));
  projection.move_projector(bumped);
  const auto& placed = std::get<PlacedPlane>(projection.solved().surfaces[0].placement);
  frame_of(projection, 100);
  EXPECT_LT(se3_log(Pose(placed.projector_from_surface.inverse() * bumped.inverse() * cart_place())).norm(),
            1e-9);
}

TEST(MovingSurfaces, ArePredictedToTheLight) {
  Projection projection(small_rig(), tracking({"cart"}));
  projection.set_show(show_of({in_rig("cart", cart_place())}));
  Vec6 twist;
  twist << 0, 0.3, 0, 0.3, 0.02, -0.1;
  const auto truth = [&](double time) { return cart_place() * se3_exp(Vec6((time - 100) * twist)); };
  for (int i = 0; i < 45; ++i) projection.add_sighting(sighting(100 + i / 30.0, truth(100 + i / 30.0)));
  const double light = 100 + 44 / 30.0 + 0.09;
  frame_of(projection, light);
  const auto& placed = std::get<PlacedPlane>(projection.solved().surfaces[0].placement);
  const Pose projector_from_true = small_rig().projector().rig_from_projector.inverse() * truth(light);
  const Vec3 corner(0.68, 0.42, 0);
  EXPECT_LT((placed.projector_from_surface * corner - projector_from_true * corner).norm(), 0.001);
  EXPECT_GT((placed.projector_from_surface * corner -
             small_rig().projector().rig_from_projector.inverse() * truth(light - 0.09) * corner)
                .norm(),
            0.02)
      << "without prediction";
}

TEST(MovingSurfaces, StayOrAreDarkWhenTheyAreLost) {
  for (const bool blank : {false, true}) {
    ProjectionOptions options = tracking({"cart"});
    options.blank_on_stale = blank;
    options.moving.track.stale_after = 0.3;
    Projection projection(small_rig(), options);
    projection.set_show(show_of({in_rig("cart", cart_place()), pixel_area("sign")}));
    projection.add_sighting(sighting(100, cart_place()));
    frame_of(projection, 100.2);
    EXPECT_FALSE(projection.moving()[0].is_dark);
    const ImageU8 lost = frame_of(projection, 101);
    EXPECT_EQ(projection.moving()[0].is_dark, blank);
    EXPECT_EQ(projection.moving()[0].seen.state, track::TrackState::kStale);
    EXPECT_EQ(projection.light(0), blank ? SurfaceLight::kNone : SurfaceLight::kShown);
    // The other surface goes on.
    EXPECT_EQ(projection.light(1), SurfaceLight::kShown);
    EXPECT_NE(fingerprint(lost), fingerprint(ImageU8(lost.size(), 3)));
  }
}

TEST(MovingSurfaces, JoinedOnesKeepTheirPlaceBesideTheFirst) {
  const Pose first_from_sign(so3_exp(Vec3(0, 0.5, 0)), Vec3(0.75, 0.05, 0.03));
  const Pose drawn_at(so3_exp(Vec3(0.2, 0, 0)), Vec3(3, 2, 5));
  Projection projection(small_rig(), tracking({"cart", "sign"}));
  projection.set_show(show_of({in_rig("sign", drawn_at * first_from_sign), in_rig("cart", drawn_at)}));
  projection.add_sighting(sighting(100, cart_place()));
  EXPECT_EQ(
      fingerprint(frame_of(projection, 100)),
      fingerprint(frame_of({in_rig("sign", cart_place() * first_from_sign), in_rig("cart", cart_place())})));
  // A sighting of the second one, and of what is not tracked, changes nothing.
  track::StampedPose other = sighting(100.1, Pose());
  other.child = "sign";
  projection.add_sighting(other);
  EXPECT_EQ(projection.moving()[0].seen.age, 0);

  Surface in_world = in_rig("sign", Pose());
  place_of(in_world.geometry)->frame = "world";
  EXPECT_ERROR(projection.set_show(show_of({in_rig("cart", Pose()), in_world})), kInput, "another frame");
  Projection pixels(small_rig(), tracking({"sign"}));
  EXPECT_ERROR(pixels.set_show(show_of({pixel_area("sign")})), kInput, "projector pixels");
}

TEST(MovingSurfaces, TheirMarkersAreLitEvenly) {
  ProjectionOptions options = tracking({"cart"});
  options.moving.marker_light = 0;
  Projection projection(small_rig(), options);
  projection.set_show(show_of({in_rig("cart", cart_place())}));
  projection.add_sighting(sighting(100, cart_place()));
  const ImageU8 frame = frame_of(projection, 100), plain = frame_of({in_rig("cart", cart_place())});
  const Pose projector_from_marker = small_rig().projector().rig_from_projector.inverse() * cart_place() *
                                     options.moving.surfaces[0].markers.markers[0].world_from_marker;
  const auto at = [&](double share) {
    const Vec2 pixel =
        *projection.projector().project(projector_from_marker * Vec3(0.1 * share, -0.1 * share, 0));
    return std::pair(int(frame.at(int(std::lround(pixel.x())), int(std::lround(pixel.y())))),
                     int(plain.at(int(std::lround(pixel.x())), int(std::lround(pixel.y())))));
  };
  for (const double share : {-0.65, 0.0, 0.5, 0.65}) {
    EXPECT_EQ(at(share).first, 0) << share;
    EXPECT_GT(at(share).second, 30) << share;
  }
  EXPECT_EQ(at(0.95).first, at(0.95).second);
}

TEST(MovingSurfaces, ASearchLightShinesUntilAllAreSeen) {
  ProjectionOptions options = tracking({"cart"});
  options.moving.search_light = 90;
  options.blank_on_stale = true;
  Projection projection(small_rig(), options);
  projection.set_show(show_of({in_rig("cart", cart_place()), pixel_area("sign")}));
  ImageU8 before = frame_of(projection, 100);
  EXPECT_EQ(before.at(0, 0), 90) << "around the surfaces";
  Projection dark(small_rig(), tracking({"cart"}));
  dark.set_show(show_of({in_rig("cart", cart_place()), pixel_area("sign")}));
  const ImageU8 without = frame_of(dark, 100);
  EXPECT_EQ(without.at(0, 0), 0);
  int shown = 0, changed = 0;  // the border of a surface is mixed with what is around it
  for (int y = 0; y < without.height(); ++y)
    for (int x = 0; x < without.width(); ++x)
      if (without.at(x, y) > 0) ++shown, changed += before.at(x, y) != without.at(x, y);
  EXPECT_GT(shown, 1000);
  EXPECT_LT(changed, shown / 10) << "other surfaces are shown as ever";

  projection.add_sighting(sighting(100, cart_place()));
  const ImageU8 seen = frame_of(projection, 100);
  EXPECT_EQ(seen.at(0, 0), 0);
  const Pose projector_from_marker = small_rig().projector().rig_from_projector.inverse() * cart_place() *
                                     options.moving.surfaces[0].markers.markers[0].world_from_marker;
  const Vec2 middle = *projection.projector().project(projector_from_marker * Vec3(0, 0, 0));
  EXPECT_EQ(seen.at(int(std::lround(middle.x())), int(std::lround(middle.y()))), 90)
      << "markers that are found stay lit";
  EXPECT_EQ(frame_of(projection, 102).at(0, 0), 90) << "lost";

  // Alone, and not while the pose of the rig is stale.
  Projection alone(small_rig(), options);
  alone.set_show(show_of({in_rig("cart", cart_place())}));
  EXPECT_EQ(frame_of(alone, 100).at(5, 7), 90);
}

TEST(MovingSurfaces, ARunIsShownAgain) {
  test::Scratch folder;
  const ProjectionOptions options = tracking({"cart"});
  std::vector<std::uint64_t> shown;
  {
    Projection projection(small_rig(), options);
    projection.set_show(show_of({in_rig("cart", cart_place())}));
    RunRecorder recorder(folder / "run.log", "now");
    for (int i = 0; i < 20; ++i) {
      const SightedSurface sighted{
          sighting(100 + i / 30.0, cart_place() * Pose(so3_exp(Vec3(0, 0.01 * i, 0)), Vec3(0.01 * i, 0, 0)))};
      recorder.record(sighted);
      projection.add_sighting(sighted.message);
      shown.push_back(fingerprint(frame_of(projection, 100.05 + i / 30.0)));
    }
  }
  Projection again(small_rig(), options);
  again.set_show(show_of({in_rig("cart", cart_place())}));
  RunReader reader(folder / "run.log");
  std::size_t i = 0;
  while (const auto record = reader.next()) {
    EXPECT_FALSE(std::holds_alternative<track::StampedPose>(*record));
    const auto* sighted = std::get_if<SightedSurface>(&*record);
    if (sighted == nullptr) continue;
    again.add_sighting(sighted->message);
    EXPECT_EQ(fingerprint(frame_of(again, 100.05 + double(i) / 30.0)), shown.at(i)) << i;
    ++i;
  }
  EXPECT_EQ(i, 20u);
}

TEST(MovingSurfaces, StatusAndMetricsShowThem) {
  MovingMetrics cart;
  cart.surface = "the \"cart\"";
  cart.state = "stale";
  cart.sightings = 41;
  cart.losses = 2;
  cart.lost_s = 1.5;
  cart.error_mm = 2.25;
  Metrics metrics;
  EXPECT_EQ(to_prometheus(metrics, {}).find("procam_tracked"), std::string::npos);
  metrics.moving = {cart};
  const std::string text = to_prometheus(metrics, {});
  for (const char* line : {"procam_tracked_sightings_total{surface=\"the \\\"cart\\\"\"} 41\n",
                           "procam_tracked_losses_total{surface=\"the \\\"cart\\\"\"} 2\n",
                           "procam_tracked_lost_seconds_total{surface=\"the \\\"cart\\\"\"} 1.5\n",
                           "procam_tracked_fresh{surface=\"the \\\"cart\\\"\"} 0\n",
                           "procam_tracked_error_metres{surface=\"the \\\"cart\\\"\"} 0.00225\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line << text;
  PageStatus page;
  page.moving = {cart};
  const nlohmann::json tracked = nlohmann::json::parse(to_json_text(page)).at("tracked").at(0);
  EXPECT_EQ(tracked.at("state"), "stale");
  EXPECT_EQ(tracked.at("dark"), true);
  EXPECT_EQ(tracked.at("error_mm"), 2.25);
}

TEST(MovingSurfaces, WhatCannotBeTrackedIsRefused) {
  ShowOptions options;
  options.surfaces = "surfaces.json";
  options.track.emplace().camera = "0";
  EXPECT_ERROR(check_combination(options), kInput, "no surface is named");
  options.track->surfaces = {{"cart,sign", "apriltag_36h11:5:100mm"}, {"door", "markers.json"}};
  EXPECT_NO_THROW(check_combination(options));
  options.track->surfaces["sign"] = "apriltag_36h11:6:100mm";
  EXPECT_ERROR(check_combination(options), kInput, "tracked twice");
  options.track->surfaces.erase("sign");
  options.track->hinges["door"] = "middle";
  EXPECT_ERROR(check_combination(options), kInput, "no edge of its content");
  options.track->hinges = {{"gate", "left"}};
  EXPECT_ERROR(check_combination(options), kInput, "no such surface is tracked");
  options.track->hinges.clear();
  options.group = "foyer";
  EXPECT_ERROR(check_combination(options), kInput, "other hosts");
  options.group.clear();
  options.watch.emplace().camera = "1";
  EXPECT_ERROR(check_combination(options), kInput, "leave out --watch");
}

/// The rig with a camera that looks where its projector shines.
Rig rig_with_camera() {
  Rig rig = small_rig();
  RigCamera camera;
  camera.name = "eye";
  camera.camera = {{640, 480}, {620, 611, 331, 228, 1.1}, {}};
  camera.rig_from_camera = Pose(so3_exp(Vec3(0.02, -0.05, 0.01)), Vec3(-0.1, 0.02, 0));
  rig.cameras.push_back(camera);
  return rig;
}

TEST(SurfaceSights, AHingeKeepsTheDoorOnItsAxis) {
  const Rig rig = rig_with_camera();
  track::Hinge hinge;
  hinge.rig_from_closed = cart_place();
  SurfaceSourceOptions options;
  options.camera = rig.camera();
  options.surfaces = {{"cart", tracking({"cart"}).moving.surfaces[0].markers, hinge}};
  options.readout_s = 0.02;
  const MarkerCells cells = detect::marker_cells(MarkerDictionary::kAprilTag36h11);
  SurfaceSights sights(options);
  const auto image_of = [&](const Pose& rig_from_surface) {
    return simulate::marker_view(rig.camera().camera,
                                 rig.camera().rig_from_camera.inverse() * rig_from_surface,
                                 options.surfaces[0].map.markers, cells, {});
  };
  const Pose open = cart_place() * Pose(so3_exp(Vec3(0, 0.4, 0)), Vec3::Zero());
  const std::vector<track::StampedPose> seen = sights.look_at({image_of(open), 100});
  ASSERT_EQ(seen.size(), 1u) << sights.surfaces()[0].why;
  EXPECT_LT((seen[0].frame_from_child.translation - cart_place().translation).norm(), 1e-9)
      << "the axis stays";
  EXPECT_LT(seen[0].frame_from_child.rotation.angularDistance(open.rotation), 0.02);
  const double row = rig.camera()
                         .camera
                         .project(rig.camera().rig_from_camera.inverse() * open *
                                  options.surfaces[0].map.markers[0].world_from_marker.translation)
                         ->y();
  EXPECT_NEAR(seen[0].arrival, 100 + 0.02 * (row / 479 - 0.5), 1e-4);
  EXPECT_TRUE(sights.look_at({image_of(Pose(Eigen::Quaterniond::Identity(), Vec3(0.2, 0, 0)) * open), 100.1})
                  .empty());
  EXPECT_EQ(sights.surfaces()[0].refused, 1u);
  EXPECT_NE(sights.surfaces()[0].why.find("hinge"), std::string::npos);
  EXPECT_TRUE(sights.look_at({ImageU8(640, 480, 1, 90), 100.2}).empty());
  EXPECT_ERROR(sights.look_at({ImageU8(320, 240, 1, 90), 100.3}), kInput, "size");
}

/// A show as a user starts it, with a camera's images in a folder: the marker moves after a while, and is gone at the end.
class CartShow : public ShowListener {
 public:
  void on_event(const std::string& sentence) override { events += sentence + "\n"; }
  void on_frame(const ShowReport& report) override {
    if (!report.metrics.moving.empty()) newest = report.metrics.moving[0];
    state = newest.state == "fresh" ? 1 : newest.state == "stale" ? 2 : 0;
  }
  std::string events;
  MovingMetrics newest;
  std::atomic<int> state{0};
};

/// Mean absolute difference of two frames, grey levels.
double difference(const ImageU8& a, const ImageU8& b) {
  double sum = 0;
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width(); ++x)
      for (int c = 0; c < 3; ++c) sum += std::abs(int(a.at(x, y, c)) - int(b.at(x, y, c)));
  return sum / (3.0 * a.width() * a.height());
}

/// With a hinge the surface file has the closed place, and the surface is seen open.
void follow_and_replay(const Surface& cart_in_file, const Pose& rig_from_cart, const std::string& hinge) {
  test::Scratch folder;
  const Rig rig = rig_with_camera();
  io::save_image(folder / "content.png", colourful(61, 47, 0));
  Surface cart = cart_in_file;
  cart.content = "content.png";
  SurfaceSet set;
  set.surfaces = {cart};
  io::save_surfaces(folder / "surfaces.json", set);
  std::filesystem::create_directory(folder / "camera");
  ShowOptions options;
  options.surfaces = (folder / "surfaces.json").string();
  options.control = "off";
  options.fps = 20;
  options.duration_s = 60;
  options.blank_on_stale_s = 0.4;
  options.record = (folder / "run.log").string();
  TrackInput& track = options.track.emplace();
  track.camera = "watch:" + (folder / "camera").string();
  track.surfaces = {{"cart", "apriltag_36h11:5:120mm"}};
  if (!hinge.empty()) {
    MarkerMap beside_axis;
    beside_axis.dictionary = MarkerDictionary::kAprilTag36h11;
    beside_axis.markers = {marker_at(5, 0.12, Vec3(0.4, 0.2, 0))};
    io::save_marker_map(folder / "markers.json", beside_axis);
    track.surfaces["cart"] = (folder / "markers.json").string();
    track.hinges["cart"] = hinge;
  }
  const MarkerMap map = projection_options(options, rig).moving.surfaces.at(0).markers;
  const MarkerCells cells = detect::marker_cells(map.dictionary);

  KeptFrames screen(rig.projector().projector.size());
  CartShow listener;
  ImageU8 last;
  std::thread camera([&] {
    const double begin = device::now_s();
    // On a busy machine, images with markers wait their turn while the surface counts as lost already.
    constexpr int kEnough = 15;
    int gone = 0;
    for (int i = 0; device::now_s() < begin + 50; ++i) {
      const bool is_gone = i > 12 && listener.state > 0;
      gone += is_gone;
      if (gone > kEnough && listener.state == 2) break;
      if (!is_gone && listener.state == 1) last = screen.last();
      simulate::MarkerViewOptions view;
      view.seed = std::uint64_t(i);
      const ImageU8 image =
          is_gone ? ImageU8(640, 480, 1, 90)
                  : simulate::marker_view(rig.camera().camera,
                                          rig.camera().rig_from_camera.inverse() * rig_from_cart, map.markers,
                                          cells, view);
      const auto part = folder / "part.png";
      io::save_image(part, image);
      std::filesystem::rename(part, folder / "camera" / ("image_" + std::to_string(1000 + i) + ".png"));
      std::this_thread::sleep_for(std::chrono::milliseconds(60));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    screen.wish(device::WindowEvent::kClose);
  });
  const ShowReport report = run(rig, options, screen, &listener);
  camera.join();
  EXPECT_GT(report.metrics.moving.at(0).sightings, 5u) << listener.events;
  EXPECT_GE(report.metrics.moving[0].losses, 1u) << listener.events;
  EXPECT_TRUE(report.metrics.moving[0].is_dark);
  EXPECT_GT(report.metrics.moving[0].lost_s, 0.1);
  EXPECT_NE(listener.events.find("'cart': its markers are seen\n"), std::string::npos) << listener.events;
  EXPECT_NE(listener.events.find("'cart': its markers are not seen; it is dark until"), std::string::npos);
  const ImageU8 dark = screen.last();
  EXPECT_EQ(fingerprint(dark), fingerprint(ImageU8(dark.size(), 3)));
  EXPECT_LT(difference(last, frame_of({in_rig("cart", rig_from_cart)})),
            0.2 * difference(last, frame_of({in_rig("cart", rig_from_cart * Pose(so3_exp(Vec3(0, 0.2, 0)),
                                                                                 Vec3(0.03, 0, 0)))})))
      << "the content lies on it";

  ShowOptions again = options;
  again.record.clear();
  again.output = "none";
  CartShow events;
  const ReplayReport replayed = replay(rig, again, options.record, &events);
  EXPECT_EQ(replayed.equal, replayed.frames);
  EXPECT_GT(replayed.frames, 15u);
  EXPECT_EQ(events.events, "");
}

TEST(MovingSurfaces, AShowFollowsThemAndReplays) {
  // The place in the file has no meaning; the marker is the surface's frame.
  follow_and_replay(in_rig("cart", Pose(Eigen::Quaterniond::Identity(), Vec3(0, 0, 4))),
                    cart_place() * Pose(Eigen::Quaterniond::Identity(), Vec3(0.25, 0.2, 0)), "");
}

TEST(MovingSurfaces, AShowFollowsADoorOnItsHinge) {
  // The left edge of its content, as wall() has it.
  const Vec3 axis = Vec3(-0.03, 0.4, 0).normalized();
  follow_and_replay(in_rig("cart", cart_place()),
                    cart_place() * Pose(so3_exp(Vec3(-0.5 * axis)), Vec3::Zero()), "left");
}

}  // namespace
}  // namespace procam::show
