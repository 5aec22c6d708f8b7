#pragma once
/// Lopsided example nouns that use every field of their files.
#include <vector>

#include "procam/core/board/board.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/core/geometry/frame_tree.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::test {

/// A unit quaternion in few digits, so that the golden files are the same on every machine.
inline Pose lopsided_pose(double shift) {
  return Pose(Eigen::Quaterniond(-0.7, 0.1, 0.5, -0.5), Vec3(0.1 + shift, -1.0 / 3, 2.7));
}

/// Whole numbers over powers of two: the product is exact on every machine.
inline Mat6 lopsided_covariance() {
  Mat6 root;
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) root(r, c) = (r == c ? 12 + r : (7 * r + 3 * c) % 5 - 2) / 1024.0;
  return root * root.transpose();
}

/// One of each kind at least, without whole sizes.
inline std::vector<Board> example_boards() {
  return {Chessboard{7, 9, 0.075},
          CharucoBoard{5, 7, 0.0397, 0.03 / 1.01, MarkerDictionary::k5x5_100, false},
          CharucoBoard{6, 4, 0.025, 0.018, MarkerDictionary::kArucoOriginal, true},
          MarkerGrid{4, 5, 0.03, 1.0 / 128, MarkerDictionary::kAprilTag36h11},
          CircleGrid{7, 9, 0.025, 0.0151, false},
          CircleGrid{4, 11, 0.02, 0.012, true},
          AprilGrid{6, 5, 0.088, 0.3}};
}

inline Rig example_rig() {
  Rig rig;
  RigCamera left{"left", {{1280, 1024}, {1701.25, 1699.5, 633.1, 1.0 / 3, -0.7}, {}}, Pose()};
  left.camera.distortion = BrownConrady{{-0.2, 0.1, 1e-4, -3e-5, 0.02}};
  RigCamera wide{"wide", {{641, 479}, {300.5, 301, 320, 239, 0.25}, {}}, lopsided_pose(0.2)};
  wide.camera.distortion = FisheyeDistortion{{0.01, -0.002, 3e-4, -4e-5}};
  RigProjector beamer{"beamer", {{{1024, 768}, {1891.5, 1895.7, 501.7, 854.1, 0.3}, {}}}, lopsided_pose(0)};
  RigProjector second{"second", {{{800, 1280}, {1000, 1001, 400, -20, 0}, {}}}, lopsided_pose(-0.3)};
  second.projector.inverse_camera.distortion =
      RationalDistortion{{0.1, 0.2, 1e-3, 2e-3, 0.3, 0.01, 0.02, 1.2345678901234567e-5}};
  rig.cameras = {left, wide};
  rig.projectors = {beamer, second};
  rig.covariance.names = {"left.fx",          "left.k1",  "beamer.cy", "rig_from_beamer.rx",
                          "rig_from_wide.tz", "second.k6"};
  rig.covariance.matrix = lopsided_covariance();
  rig.quality.views_used = 5;
  rig.quality.rms_px = {{"left", 0.21}, {"beamer", 0.25}};
  rig.quality.holdout_px = {{"beamer", 0.28}};
  rig.quality.expected_holdout_px = {{"beamer", 0.31}};
  rig.quality.gates = {
      {"camera_rms", true, "0.21 px, at most 0.30 px"},
      {"views", false, "5 views, at least 6: show the board in more places, nearer and farther, and turned"}};
  rig.provenance = {"calibrate-projector",
                    "0.1.0",
                    "2026-01-02T03:04:05Z",
                    {{"board", "chessboard:7x9:75mm"}, {"captures", "a \"quoted\" path\\with ünïcode"}},
                    {{"pose_1/graycode_00.png", std::string(64, 'a')}}};
  return rig;
}

inline SurfaceSet example_surfaces() {
  PlanarSurface planar;
  planar.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.25}};
  planar.points = {{0, 0}, {1.25, 0.01}, {1.2, 1.0 / 3}, {-0.01, 0.7}, {0.6, 0.1}};
  planar.frame = "rig";
  planar.frame_from_surface = lopsided_pose(0.1);
  PixelSurface pixels;
  pixels.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  pixels.pixels = {{10.5, 20}, {900, 33}, {870.25, 700}, {-5, 650}};
  SurfaceSet set;
  set.surfaces = {{"wall", planar, {1, 2, 0.5, 1e-3, 4}, "bilder/<wand> & \"tür\".png"},
                  {"hand placed", pixels, {}, ""}};
  set.surfaces[0].layout = {Fit::kCover, {0.125, 0.25}, {1, 0.875}};
  set.surfaces[0].shape.outline = {{0, 0.1}, {0.5, 0}, {1, 1.0 / 3}, {0.75, 1}};
  set.surfaces[0].shape.holes = {{{0.25, 0.25}, {0.5, 0.25}, {0.375, 0.3}},
                                 {{0.6, 0.5}, {0.7, 0.5}, {0.7, 0.75}}};
  set.surfaces[1].layout.fit = Fit::kContain;
  const auto add = [&](const std::string& name, auto shape) {
    shape.frame_from_surface = lopsided_pose(0.2);
    set.surfaces.push_back({name, shape, {}, name + ".png"});
    set.surfaces.back().layout.crop_to = {0.5, 0.75};
  };
  GridSurface curtain;
  curtain.columns = 3;
  curtain.rows = 2;
  curtain.points = {{0, 0, 0.1},   {0.4, 0, 1.0 / 3}, {0.9, 0.1, 0},
                    {0, 0.7, 0.1}, {0.5, 0.6, 0.2},   {1, 0.8, 0}};
  add("curtain", curtain);
  BezierSurface patch;
  patch.columns = 2;
  patch.rows = 3;
  patch.control_points = curtain.points;
  add("patch", patch);
  CylinderSurface column;
  column.radius = 0.43;
  column.left = -50 * kDegree;
  column.right = 71 * kDegree;
  column.top = -0.2;
  column.bottom = 0.9;
  add("column", column);
  SphereSurface dome;
  dome.radius = 1.3;
  dome.left = -80 * kDegree;
  dome.right = 62.5 * kDegree;
  dome.top = 41 * kDegree;
  dome.bottom = -67 * kDegree;
  dome.seen_from = SeenFrom::kInside;
  add("dome", dome);
  MeshSurface roof;
  roof.file = "roof.obj";
  roof.metres_per_unit = 0.001;
  add("roof", roof);
  set.surfaces.back().shape.mask_file = "leaves.png";
  PixelSurface bent;
  bent.shape = PixelShape::kGrid;
  bent.columns = 4;
  bent.rows = 2;
  bent.pixels = {{31.5, 40}, {200, 1.0 / 3}, {410, 22},  {600, 35},
                 {28, 300},  {190, 333},     {400, 311}, {622, 290}};
  set.surfaces.push_back({"hand bent", bent, {}, ""});
  bent.shape = PixelShape::kBezier;
  bent.columns = 2;
  bent.rows = 4;
  set.surfaces.push_back({"hand curved", bent, {}, "#ff8000"});
  set.surfaces.back().shape.holes = {{{0.1, 0.2}, {0.4, 0.25}, {0.3, 0.5}}};
  return set;
}

/// The file that the surface "roof" names, in mm.
inline const char* const kRoof =
    "v 0 0 200\nv 700 30 0\nv 0 900 200\nvt 0 1\nvt 1 1\nvt 0.25 0\nf 1/1 2/2 3/3\n";

inline SolvedSurfaceSet example_solved_surfaces() {
  const SurfaceSet set = example_surfaces();
  SolvedSurface wall{
      set.surfaces[0], PlacedPlane{}, 1.5e-4, {1e-4, 2e-4, 0, 1e-5, 3e-4}, std::nullopt, {}, {}};
  Mat3 homography;
  homography << 1.25, -0.01, 0.1, 1.0 / 7, 0.7, -0.2, 0.01, -0.03, 1;
  wall.placement = PlacedPlane{homography, lopsided_pose(0.4)};
  wall.corners_px = Points2{{1, 2}, {800, 3.5}, {810, 600}, {-4, 590.125}};
  wall.visibility = {0.97, true, 47.5, 0.8, 1.9};
  wall.diagnostics.warn("partly_outside", "3 % of the surface lies outside the picture");
  SolvedSurface placed{set.surfaces[1], PlacedPixels{homography}, 0, {},
                       std::nullopt,    {0, false, 0, 0, 0},      {}};
  SolvedSurfaceSet solved;
  solved.projector = "beamer";
  solved.projector_from_world = lopsided_pose(-0.1);
  solved.surfaces = {wall, placed};
  for (std::size_t i = 2; i < set.surfaces.size(); ++i)
    solved.surfaces.push_back({set.surfaces[i],
                               set.surfaces[i].geometry.index() == 1
                                   ? Placement(PlacedPixels{})
                                   : Placement(PlacedMesh{nullptr, lopsided_pose(0.3)}),
                               0,
                               {},
                               std::nullopt,
                               {0.4, true, 31.5, 0.8, 1.9},
                               {}});
  return solved;
}

inline MarkerMap example_markers() {
  MarkerMap map;
  map.dictionary = MarkerDictionary::kAprilTag36h11;
  map.position_sigma = 0.002;
  map.angle_sigma = 1.0 / 300;
  map.markers = {{3, 0.16, lopsided_pose(0)}, {586, 0.1415, lopsided_pose(0.7)}};
  return map;
}

inline FrameTree::Link example_pose() {
  return {"projector", "world", {lopsided_pose(0.3), lopsided_covariance()}};
}

}  // namespace procam::test
