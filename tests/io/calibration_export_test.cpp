// Rigs written for other programs: read back by procam, by OpenCV, and by the formats' own formulas.
#include "procam/io/exchange/calibration_export.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <regex>

#include "procam/core/geometry/se3.hpp"
#include "procam/io/exchange/calibration_file.hpp"
#include "procam/io/files.hpp"
#include "scratch.hpp"
#include "support/expect_error.hpp"
#include "support/lopsided.hpp"

namespace procam::io {
namespace {

using test::Scratch;

Rig lopsided_rig(double skew, const Distortion& lens) {
  Rig rig;
  RigCamera camera;
  camera.name = "left";
  camera.camera = {{1280, 960}, {1401.125, 1398.75, 633.3, 501.7, skew}, lens};
  camera.rig_from_camera = test::other_lopsided_pose();
  RigProjector projector;
  projector.name = "beamer";
  projector.projector.inverse_camera = {{1024, 768}, {1880.7, 1846.2, 497.3, 751.6, skew}, lens};
  projector.rig_from_projector = test::lopsided_pose();
  rig.cameras = {camera};
  rig.projectors = {projector};
  return rig;
}

const BrownConrady kBrown{{-0.21, 0.06, 0.0013, -0.0005, 0.016}};
const RationalDistortion kRational{{-0.21, 0.06, 0.0013, -0.0005, 0.016, 0.11, -0.02, 0.003}};
const FisheyeDistortion kFisheye{{-0.03, 0.007, -0.002, 0.0004}};

Rig read_back(const std::string& text) {
  Scratch folder;
  write_file_atomically(folder / "calibration", text);
  return load_calibration(folder / "calibration");
}

void expect_same_lens(const Camera& a, const Camera& b, double pixels = 0) {
  EXPECT_EQ(a.size, b.size);
  EXPECT_EQ(a.distortion.index(), b.distortion.index());
  EXPECT_LE((parameters_of(a) - parameters_of(b)).cwiseAbs().maxCoeff(), pixels);
}
void expect_same_pose(const Pose& a, const Pose& b) {
  EXPECT_LT((a.matrix() - b.matrix()).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(CalibrationExport, OpencvAndRosReadBackExactly) {
  for (const Distortion& lens :
       {Distortion(kBrown), Distortion(kRational), Distortion(kFisheye), Distortion(NoDistortion{})}) {
    const Rig rig = lopsided_rig(2.7, lens);
    for (const CalibrationFormat format : {CalibrationFormat::kOpenCv, CalibrationFormat::kRos}) {
      expect_same_lens(read_back(export_calibration(format, rig, "left").text).camera().camera,
                       rig.camera().camera);
      const ForeignCalibration beamer = export_calibration(format, rig, "beamer");
      expect_same_lens(read_back(beamer.text).camera().camera, rig.projector().projector.inverse_camera);
      EXPECT_TRUE(beamer.diagnostics.find("poses_lost"));
      EXPECT_TRUE(beamer.diagnostics.find("skew_ignored"));
    }
  }
  EXPECT_FALSE(export_calibration(CalibrationFormat::kRos, lopsided_rig(0, kBrown), "left")
                   .diagnostics.find("skew_ignored"));
}

TEST(CalibrationExport, OpencvsOwnReaderTakesIt) {
  const Rig rig = lopsided_rig(2.7, kRational);
  cv::FileStorage camera(export_calibration(CalibrationFormat::kOpenCv, rig, "left").text,
                         cv::FileStorage::READ | cv::FileStorage::MEMORY);
  cv::Mat k, d;
  camera["camera_matrix"] >> k;
  camera["distortion_coefficients"] >> d;
  EXPECT_EQ(int(camera["image_width"]), 1280);
  ASSERT_EQ(k.size(), cv::Size(3, 3));
  EXPECT_EQ(k.at<double>(0, 1), 2.7);
  EXPECT_EQ(k.at<double>(1, 2), 501.7);
  ASSERT_EQ(d.total(), 8u);
  EXPECT_EQ(d.at<double>(7), 0.003);

  cv::FileStorage pair(export_calibration(CalibrationFormat::kOpenCvStereo, rig).text,
                       cv::FileStorage::READ | cv::FileStorage::MEMORY);
  cv::Mat r, t;
  pair["R"] >> r;
  pair["T"] >> t;
  const Pose second_from_first = rig.projector_from_camera();
  EXPECT_EQ(r.at<double>(2, 0), second_from_first.rotation_matrix()(2, 0));
  EXPECT_EQ(t.at<double>(1), second_from_first.translation.y());
}

TEST(CalibrationExport, StereoPairsReadBackWithSizesAndPose) {
  const Rig rig = lopsided_rig(2.7, kBrown);
  const Rig back = read_back(export_calibration(CalibrationFormat::kOpenCvStereo, rig).text);
  expect_same_lens(back.camera().camera, rig.camera().camera);
  expect_same_lens(back.projector().projector.inverse_camera, rig.projector().projector.inverse_camera);
  expect_same_pose(back.projector_from_camera(), rig.projector_from_camera());
  Rig two = rig;
  two.cameras.push_back(two.cameras[0]);
  EXPECT_ERROR(export_calibration(CalibrationFormat::kOpenCvStereo, two), kInput, "kalibr");
  EXPECT_ERROR(export_calibration(CalibrationFormat::kOpenCvStereo, lopsided_rig(0, kFisheye)), kUnsupported,
               "export each device by itself");
}

TEST(CalibrationExport, KalibrReadsBackWithItsChain) {
  const BrownConrady four{{-0.21, 0.06, 0.0013, -0.0005, 0}};
  for (const Distortion& lens : {Distortion(four), Distortion(kFisheye), Distortion(NoDistortion{})}) {
    const Rig rig = lopsided_rig(0, lens);
    const ForeignCalibration chain = export_calibration(CalibrationFormat::kKalibr, rig);
    EXPECT_FALSE(chain.diagnostics.find("lens_lost"));
    EXPECT_FALSE(chain.diagnostics.find("skew_lost"));
    const Rig back = read_back(chain.text);
    ASSERT_EQ(back.cameras.size(), 2u);
    expect_same_lens(back.cameras[0].camera, rig.camera().camera);
    expect_same_lens(back.cameras[1].camera, rig.projector().projector.inverse_camera);
    expect_same_pose(back.cameras[1].rig_from_camera.inverse() * back.cameras[0].rig_from_camera,
                     rig.projector_from_camera());
  }
}

/// Kalibr's reader wants floats, all four coefficients, and the cameras that see the same; Python's YAML reads "500" as
/// an integer and "1e-05" as a text.
TEST(CalibrationExport, KalibrAndRosGetFloats) {
  Rig rig = lopsided_rig(0, BrownConrady{{-0.25, 0, 1e-5, -2e-7, 0}});
  rig.cameras[0].camera.intrinsics = {500, 501, 633.25, 400, 0};
  const std::string chain = export_calibration(CalibrationFormat::kKalibr, rig).text;
  EXPECT_TRUE(test::contains(chain,
                             "  cam_overlaps: [1]\n  camera_model: pinhole\n"
                             "  distortion_coeffs: [-0.25, 0.0, 1.0e-05, -2.0e-07]\n"
                             "  distortion_model: radtan\n  intrinsics: [500.0, 501.0, 633.25, 400.0]\n"
                             "  resolution: [1280, 960]\n"))
      << chain;
  EXPECT_TRUE(test::contains(chain, "  - [0.0, 0.0, 0.0, 1.0]\n  cam_overlaps: [0]\n")) << chain;
  const std::string info = export_calibration(CalibrationFormat::kRos, rig, "left").text;
  EXPECT_TRUE(test::contains(info, "data: [500.0, 0.0, 633.25, 0.0, 501.0, 400.0, 0.0, 0.0, 1.0]\n")) << info;
  EXPECT_TRUE(test::contains(info, "data: [-0.25, 0.0, 1.0e-05, -2.0e-07, 0.0]\n")) << info;
  // Without distortion: Kalibr makes no camera of its model "none".
  rig.cameras[0].camera.distortion = NoDistortion{};
  rig.cameras[0].camera.intrinsics.cy = -20.5;
  rig.projectors.clear();
  const ForeignCalibration alone = export_calibration(CalibrationFormat::kKalibr, rig);
  EXPECT_TRUE(test::contains(alone.text,
                             "  cam_overlaps: []\n  camera_model: pinhole\n"
                             "  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]\n"
                             "  distortion_model: radtan\n"))
      << alone.text;
  EXPECT_TRUE(alone.diagnostics.find("kalibr_refuses_centre"));
  expect_same_lens(read_back(alone.text).camera().camera, rig.camera().camera);
}

TEST(CalibrationExport, MrcalReadsBackWithItsPose) {
  for (const Distortion& lens : {Distortion(kBrown), Distortion(kRational), Distortion(NoDistortion{})}) {
    const Rig rig = lopsided_rig(0, lens);
    const Rig back = read_back(export_calibration(CalibrationFormat::kMrcal, rig, "beamer").text);
    expect_same_lens(back.camera().camera, rig.projector().projector.inverse_camera);
    expect_same_pose(back.camera().rig_from_camera, rig.projector().rig_from_projector);
  }
  EXPECT_ERROR(export_calibration(CalibrationFormat::kMrcal, lopsided_rig(0, kFisheye), "left"), kUnsupported,
               "export to kalibr");
}

TEST(CalibrationExport, ColmapReadsBackAndCountsFromTheCorner) {
  for (const Distortion& lens : {Distortion(kRational), Distortion(kFisheye), Distortion(NoDistortion{})}) {
    Rig rig = lopsided_rig(0, lens);
    rig.projectors.clear();
    const std::string text = export_calibration(CalibrationFormat::kColmap, rig).text;
    EXPECT_TRUE(test::contains(text, " 1280 960 1401.125 1398.75 633.8 502.2")) << text;
    expect_same_lens(read_back(text).camera().camera, rig.camera().camera, 1e-12);
  }
}

/// Poses and lenses that look along the middle of their image, as glTF's do: exactly, with names and sizes.
TEST(CalibrationExport, GltfReadsBackWithPosesAndSizes) {
  Rig rig = lopsided_rig(0, NoDistortion{});
  Intrinsics& k = rig.cameras[0].camera.intrinsics;
  k.cx = 639.5;
  k.cy = 479.5;
  const Rig back = read_back(export_calibration(CalibrationFormat::kGltf, rig).text);
  ASSERT_EQ(back.cameras.size(), 2u);
  EXPECT_EQ(back.cameras[0].name, "left");
  EXPECT_EQ(back.cameras[1].name, "beamer");
  EXPECT_EQ(back.cameras[1].camera.size, (ImageSize{1024, 768}));
  expect_same_lens(back.cameras[0].camera, rig.cameras[0].camera, 1e-9);
  expect_same_pose(back.cameras[0].rig_from_camera, rig.cameras[0].rig_from_camera);
  expect_same_pose(back.cameras[1].rig_from_camera, rig.projectors[0].rig_from_projector);
}

TEST(CalibrationExport, OneOfSeveralDevicesIsWrittenAlone) {
  const Rig rig = lopsided_rig(0, NoDistortion{});
  for (const CalibrationFormat format :
       {CalibrationFormat::kKalibr, CalibrationFormat::kColmap, CalibrationFormat::kGltf}) {
    const Rig back = read_back(export_calibration(format, rig, "beamer").text);
    ASSERT_EQ(back.cameras.size(), 1u);
    EXPECT_EQ(back.cameras[0].camera.size, (ImageSize{1024, 768}));
  }
  EXPECT_FALSE(test::contains(export_calibration(CalibrationFormat::kUrdf, rig, "beamer").text, "left"));
  EXPECT_ERROR(export_calibration(CalibrationFormat::kSdf, rig, "right"), kInput,
               "name one of: left, beamer");
}

TEST(CalibrationExport, NamesThatRosDoesNotHaveAreChangedWithANote) {
  Rig rig = lopsided_rig(0, kBrown);
  rig.cameras[0].name = "a: b # \"c\"";
  for (const CalibrationFormat format : {CalibrationFormat::kRos, CalibrationFormat::kKalibr}) {
    const ForeignCalibration file = export_calibration(format, rig, rig.cameras[0].name);
    EXPECT_TRUE(test::contains(file.text, "a__b____c_")) << file.text;
    EXPECT_FALSE(test::contains(file.text, "a: b"));
    EXPECT_TRUE(file.diagnostics.find("name_changed"));
  }
  rig.cameras[0].name = "2";
  EXPECT_TRUE(
      test::contains(export_calibration(CalibrationFormat::kRos, rig, "2").text, "camera_name: camera_2\n"));
  EXPECT_FALSE(export_calibration(CalibrationFormat::kRos, rig, "beamer").diagnostics.find("name_changed"));
}

TEST(CalibrationExport, TwoCamerasAreAStereoPair) {
  Rig rig = lopsided_rig(0, kBrown);
  rig.cameras.push_back(
      {"right", rig.projectors[0].projector.inverse_camera, rig.projectors[0].rig_from_projector});
  rig.projectors.clear();
  const ForeignCalibration pair = export_calibration(CalibrationFormat::kOpenCvStereo, rig);
  EXPECT_TRUE(pair.diagnostics.find("kinds_lost"));
  const Rig back = read_back(pair.text);
  expect_same_lens(back.projector().projector.inverse_camera, rig.cameras[1].camera);
  expect_same_pose(back.projector_from_camera(),
                   rig.cameras[1].rig_from_camera.inverse() * rig.cameras[0].rig_from_camera);
}

/// What OpenCV itself writes, in its three syntaxes.
TEST(CalibrationExport, OpencvsOwnFilesAreRead) {
  Scratch folder;
  const Camera camera = lopsided_rig(0, kBrown).camera().camera;
  for (const char* const name : {"camera.yml", "camera.xml", "camera.json"}) {
    cv::FileStorage file((folder / name).string(), cv::FileStorage::WRITE);
    const Intrinsics& k = camera.intrinsics;
    file << "image_width" << camera.size.width << "image_height" << camera.size.height << "camera_matrix"
         << cv::Mat(cv::Matx33d(k.fx, 0, k.cx, 0, k.fy, k.cy, 0, 0, 1)) << "distortion_coefficients"
         << cv::Mat(std::vector<double>(coefficients_of(camera.distortion)), true);
    file.release();
    expect_same_lens(load_calibration(folder / name).camera().camera, camera);
  }
}

/// The largest distance over the image's 17 x 17 pixels, by the lens's own projection.
double distance(const Camera& from, const Camera& to) {
  double largest = 0;
  for (int j = 0; j <= 16; ++j)
    for (int i = 0; i <= 16; ++i) {
      const Vec2 pixel(i * (from.size.width - 1) / 16.0, j * (from.size.height - 1) / 16.0);
      largest = std::max(largest, (*to.project(*from.unproject(pixel)) - pixel).norm());
    }
  return largest;
}

TEST(CalibrationExport, LossesAreNamedWithTheirPixels) {
  Rig rig = lopsided_rig(5, kBrown);
  rig.projectors.clear();
  const ForeignCalibration chain = export_calibration(CalibrationFormat::kKalibr, rig);
  const Camera &lens = rig.camera().camera, back = read_back(chain.text).camera().camera;
  EXPECT_EQ(back.intrinsics.skew, 0);
  EXPECT_EQ(coefficients_of(back.distortion)[4], 0);
  const auto stated = [&](const char* code) {
    const Diagnostic* found = chain.diagnostics.find(code);
    EXPECT_TRUE(found) << code;
    std::smatch number;
    const std::string message = found ? found->message : "";
    EXPECT_TRUE(std::regex_search(message, number, std::regex("up to ([0-9.]+) pixels"))) << message;
    return number.empty() ? 0 : std::stod(number[1]);
  };
  Camera without_skew = lens, without_k3 = lens;
  without_skew.intrinsics.skew = 0;
  without_k3.distortion = back.distortion;
  EXPECT_NEAR(stated("skew_lost"), distance(lens, without_skew), 0.006);
  EXPECT_NEAR(stated("lens_lost"), distance(lens, without_k3), 0.006);
  EXPECT_GT(stated("skew_lost"), 1.5);
  EXPECT_GT(stated("lens_lost"), 0.1);
  rig.covariance.names = {"left.fx"};
  rig.covariance.matrix = MatX::Identity(1, 1);
  EXPECT_TRUE(export_calibration(CalibrationFormat::kUrdf, rig).diagnostics.find("covariance_lost"));
  EXPECT_TRUE(export_calibration(CalibrationFormat::kUrdf, rig).diagnostics.find("intrinsics_lost"));
}

/// URDF's rpy: about the fixed axes x, then y, then z.
Pose pose_of_urdf(const std::string& text, const std::string& xyz, const std::string& rpy) {
  double t[3], a[3];
  EXPECT_EQ(std::sscanf(xyz.c_str(), "%lf %lf %lf", &t[0], &t[1], &t[2]), 3) << text;
  EXPECT_EQ(std::sscanf(rpy.c_str(), "%lf %lf %lf", &a[0], &a[1], &a[2]), 3) << text;
  const Mat3 r = (Eigen::AngleAxisd(a[2], Vec3::UnitZ()) * Eigen::AngleAxisd(a[1], Vec3::UnitY()) *
                  Eigen::AngleAxisd(a[0], Vec3::UnitX()))
                     .toRotationMatrix();
  return Pose(r, Vec3(t[0], t[1], t[2]));
}

TEST(CalibrationExport, UrdfAndSdfHoldTheFrames) {
  Rig rig = lopsided_rig(2.7, kBrown);
  // A pitch of 90 degrees: roll and yaw are one.
  rig.cameras[0].rig_from_camera = Pose(
      (Eigen::AngleAxisd(kPi / 2, Vec3::UnitY()) * Eigen::AngleAxisd(0.7, Vec3::UnitX())).toRotationMatrix(),
      Vec3(0.1, 0.2, -0.3));
  const std::string urdf = export_calibration(CalibrationFormat::kUrdf, rig).text;
  const std::string sdf = export_calibration(CalibrationFormat::kSdf, rig).text;
  const auto pose_in_urdf = [&](const std::string& child) {
    std::smatch found;
    EXPECT_TRUE(std::regex_search(
        urdf, found,
        std::regex("<child link=\"" + child + "\"/>\\s*<origin xyz=\"([^\"]*)\" rpy=\"([^\"]*)\"/>")))
        << urdf;
    return pose_of_urdf(urdf, found[1], found[2]);
  };
  expect_same_pose(pose_in_urdf("left_optical_frame"), rig.camera().rig_from_camera);
  expect_same_pose(pose_in_urdf("beamer_optical_frame"), rig.projector().rig_from_projector);
  std::smatch found;
  ASSERT_TRUE(std::regex_search(
      sdf, found,
      std::regex(
          "name=\"beamer_optical_frame\" attached_to=\"rig\">\\s*<pose>(\\S+ \\S+ \\S+) ([^<]*)</pose>")))
      << sdf;
  expect_same_pose(pose_of_urdf(sdf, found[1], found[2]), rig.projector().rig_from_projector);
  rig.cameras[0].name = "<\"&>";
  EXPECT_TRUE(
      test::contains(export_calibration(CalibrationFormat::kUrdf, rig).text, "&lt;&quot;&amp;&gt;_optical"));
}

/// The pose of a link in its root by a URDF's joints, those that turn at `angles` (by name).
Pose root_from_link(const std::string& urdf, std::string link,
                    const std::map<std::string, double>& angles = {}) {
  const std::regex joint(
      "<joint name=\"([^\"]*)\" type=\"([^\"]*)\">\\s*<parent link=\"([^\"]*)\"/>\\s*<child link=\"([^\"]*)\"/>\\s*"
      "<origin xyz=\"([^\"]*)\" rpy=\"([^\"]*)\"/>");
  Pose pose;
  for (bool found = true; found;) {
    found = false;
    for (std::sregex_iterator at(urdf.begin(), urdf.end(), joint), end; at != end; ++at) {
      const std::smatch& m = *at;
      if (m[4] != link) continue;
      const double angle = angles.count(m[1]) ? angles.at(m[1]) : 0;
      pose = pose_of_urdf(urdf, m[5], m[6]) * Pose(so3_exp(Vec3(0, 0, angle)), Vec3::Zero()) * pose;
      link = m[3];
      found = true;
      break;
    }
  }
  return pose;
}

TEST(CalibrationExport, UrdfHoldsTheMountOnABase) {
  const Rig rig = lopsided_rig(2.7, kBrown);
  Mount mount;
  mount.pose = {"base", "rig", {test::other_lopsided_pose() * test::lopsided_pose(), Mat6::Zero()}};
  const Pose base_from_beamer = mount.pose.target_from_source.pose * rig.projector().rig_from_projector;
  const std::string urdf = export_calibration(CalibrationFormat::kUrdf, rig, "", mount).text;
  expect_same_pose(root_from_link(urdf, "beamer_optical_frame"), base_from_beamer);
  EXPECT_TRUE(test::contains(urdf, "<link name=\"base\"/>"));
  // The same by the mount of one device.
  Mount of_device;
  of_device.pose = {"base", "beamer", {base_from_beamer, Mat6::Identity()}};
  const ForeignCalibration same = export_calibration(CalibrationFormat::kUrdf, rig, "left", of_device);
  expect_same_pose(root_from_link(same.text, "left_optical_frame"),
                   mount.pose.target_from_source.pose * rig.camera().rig_from_camera);
  EXPECT_TRUE(same.diagnostics.find("covariance_lost"));
  const std::string sdf = export_calibration(CalibrationFormat::kSdf, rig, "", mount).text;
  EXPECT_TRUE(test::contains(sdf, "<link name=\"base\"/>"));
  EXPECT_TRUE(test::contains(sdf, "<frame name=\"rig\" attached_to=\"base\">"));
  EXPECT_TRUE(test::contains(sdf, "<frame name=\"beamer_optical_frame\" attached_to=\"rig\">"));
  mount.pose.source = "other";
  EXPECT_ERROR(export_calibration(CalibrationFormat::kUrdf, rig, "", mount), kInput,
               "neither the rig nor a device");
  EXPECT_ERROR(export_calibration(CalibrationFormat::kKalibr, rig, "", mount), kInput,
               "the format has no frames");
}

TEST(CalibrationExport, UrdfHoldsTheJointsOfAHead) {
  const Rig rig = lopsided_rig(0, kBrown);
  Mount mount;
  mount.pose = {"tilt", "rig", {test::other_lopsided_pose() * test::lopsided_pose(), Mat6::Zero()}};
  mount.axes = PanTiltAxes{0.021, 91 * kDegree};
  mount.world_from_base = test::lopsided_pose();
  EXPECT_TRUE(export_calibration(CalibrationFormat::kUrdf, rig, "", mount).diagnostics.find("world_lost"));
  const std::string urdf = export_calibration(CalibrationFormat::kUrdf, rig, "", mount).text;
  expect_same_pose(root_from_link(urdf, "rig", {{"pan_joint", 0.4}, {"tilt_joint", -0.7}}),
                   head_from_tilt(*mount.axes, 0.4, -0.7) * mount.pose.target_from_source.pose);
  EXPECT_TRUE(test::contains(urdf, "<axis xyz=\"0 0 1\"/>"));
  EXPECT_TRUE(test::contains(export_calibration(CalibrationFormat::kSdf, rig, "", mount).text,
                             "<joint name=\"tilt_joint\" type=\"revolute\">"));
  EXPECT_FALSE(std::regex_search(urdf, std::regex("[ \"]-0(\\.0)?[ \"]"))) << urdf;
}

// glTF 2.0, 3.10.3.3: clip x = x / (aspectRatio tan(yfov / 2)) / -z, and the camera looks along -z.
TEST(CalibrationExport, GltfCamerasSeeWhatTheRigSees) {
  Rig rig = lopsided_rig(0, NoDistortion{});
  Intrinsics& k = rig.projectors[0].projector.inverse_camera.intrinsics;
  k.cx = 511.5;
  k.cy = 383.5;
  const ForeignCalibration scene = export_calibration(CalibrationFormat::kGltf, rig);
  const nlohmann::json gltf = nlohmann::json::parse(scene.text);
  EXPECT_EQ(gltf["asset"]["version"], "2.0");
  EXPECT_EQ(gltf["nodes"][0]["children"], nlohmann::json({1, 2}));
  const nlohmann::json node = gltf["nodes"][2], lens = gltf["cameras"][int(node["camera"])]["perspective"];
  EXPECT_EQ(node["name"], "beamer");
  const auto q = node["rotation"].get<std::vector<double>>(),
             t = node["translation"].get<std::vector<double>>();
  const Vec3 in_camera(0.4, -0.3, 2.1);
  const Vec3 in_rig = rig.projector().rig_from_projector * in_camera;
  const Vec3 local =
      Eigen::Quaterniond(q[3], q[0], q[1], q[2]).conjugate() * (in_rig - Vec3(t[0], t[1], t[2]));
  const double half = std::tan(0.5 * double(lens["yfov"]));
  const Vec2 clip(local.x() / (double(lens["aspectRatio"]) * half) / -local.z(),
                  local.y() / half / -local.z());
  const Vec2 pixel((clip.x() + 1) / 2 * 1024 - 0.5, (1 - clip.y()) / 2 * 768 - 0.5);
  EXPECT_LT((pixel - *rig.projector().projector.inverse_camera.project(in_camera)).norm(), 1e-9);
  ASSERT_TRUE(scene.diagnostics.find("frustum_centred"));
  EXPECT_TRUE(test::contains(scene.diagnostics.find("frustum_centred")->message, "left: "));
}

TEST(CalibrationExport, OneDeviceIsNamedAndFormatsAreKnown) {
  const Rig rig = lopsided_rig(0, kBrown);
  EXPECT_ERROR(export_calibration(CalibrationFormat::kRos, rig), kInput, "name one of: left, beamer");
  EXPECT_ERROR(export_calibration(CalibrationFormat::kRos, rig, "right"), kInput,
               "name one of: left, beamer");
  EXPECT_ERROR(export_calibration(CalibrationFormat::kMrcal, Rig{}), kInput, "the rig has none");
  EXPECT_ERROR(parse_calibration_format("kalib"), kInput, "kalibr");
  EXPECT_EQ(parse_calibration_format("gltf"), CalibrationFormat::kGltf);
  EXPECT_EQ(parse_calibration_format("opencv-stereo"), CalibrationFormat::kOpenCvStereo);
}

}  // namespace
}  // namespace procam::io
