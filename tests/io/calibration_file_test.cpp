#include "procam/io/exchange/calibration_file.hpp"

#include <gtest/gtest.h>

#include <random>

#include "examples.hpp"
#include "procam/io/files.hpp"
#include "procam/io/rig_file.hpp"
#include "scratch.hpp"
#include "support/test_data.hpp"

namespace procam::io {
namespace {

using test::Scratch;

/// Written by hand as the programs write them, with one lens in all of them: fx != fy, off-centre.
std::filesystem::path golden(const std::string& name) {
  return std::filesystem::path(PROCAM_SOURCE_DIR) / "tests/io/golden" / name;
}

const std::vector<double> kTerms{-0.2125, 0.0625, 0.00125, -0.0005, 0.015625};

void expect_golden_camera(const Camera& camera, std::vector<double> coefficients, double skew = 0) {
  EXPECT_EQ(camera.size, (ImageSize{1280, 960}));
  EXPECT_EQ(camera.intrinsics.fx, 1401.125);
  EXPECT_EQ(camera.intrinsics.fy, 1398.75);
  EXPECT_EQ(camera.intrinsics.cx, 633.25);
  EXPECT_EQ(camera.intrinsics.cy, 501.5);
  EXPECT_EQ(camera.intrinsics.skew, skew);
  EXPECT_EQ(coefficients_of(camera.distortion), coefficients);
}

/// x_2 = R x_1 + T in millimetres: (1, 2, 3) m -> (-2 + 0.1, 1 - 0.6, 3 + 0.25) m.
void expect_golden_pose(const Pose& second_from_first) {
  EXPECT_LT((second_from_first * Vec3(1, 2, 3) - Vec3(-1.9, 0.4, 3.25)).norm(), 1e-12);
}

TEST(CalibrationFile, ReadsOpencvsCalibrationSample) {
  const Rig rig = load_calibration(golden("opencv_camera.yml"));
  expect_golden_camera(rig.camera().camera, kTerms);
  EXPECT_STREQ(name_of(rig.camera().camera.distortion), "brown_conrady");
  EXPECT_EQ(rig.quality.rms_px.at("camera"), 0.25);
  EXPECT_TRUE(rig.projectors.empty());
  const Rig fisheye = load_calibration(golden("opencv_tutorial.xml"));
  expect_golden_camera(fisheye.camera().camera, {-0.2125, 0.0625, 0.00125, -0.0005});
  EXPECT_STREQ(name_of(fisheye.camera().camera.distortion), "fisheye");
}

TEST(CalibrationFile, ReadsAFileThatAnEditorHasMarked) {
  const Scratch scratch;
  for (const char* name : {"opencv_camera.yml", "opencv_tutorial.xml", "plain.json"}) {
    const auto file = scratch.write(name, "\xef\xbb\xbf" + read_file(golden(name)));
    EXPECT_EQ(load_calibration(file).camera().camera.intrinsics.fx,
              load_calibration(golden(name)).camera().camera.intrinsics.fx)
        << name;
  }
}

TEST(CalibrationFile, ReadsMrcalsCameramodel) {
  const Rig rig = load_calibration(golden("mrcal.cameramodel"));
  expect_golden_camera(rig.camera().camera, {-0.2125, 0.0625, 0.00125, -0.0005, 0.015625, 0, 0.25, 0.03125});
  // rt_cam_ref: a quarter turn about z, then (0.1, -0.6, 0.25).
  expect_golden_pose(rig.camera().rig_from_camera.inverse());
  EXPECT_EQ(rig.provenance.tool, "mrcal");
  EXPECT_EQ(rig.provenance.inputs.size(), 1u);

  Scratch folder;
  const std::string good = read_file(golden("mrcal.cameramodel"));
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    write_file_atomically(folder / "changed.cameramodel", text);
    return folder / "changed.cameramodel";
  };
  EXPECT_ERROR(load_calibration(changed("'LENSMODEL_OPENCV8", "'LENSMODEL_SPLINED_STEREOGRAPHIC")),
               kUnsupported, "mrcal-convert-lensmodel");
  EXPECT_ERROR(load_calibration(changed("633.25,", "")), kInput, "it has 11 numbers, not 12");
  EXPECT_ERROR(load_calibration(changed("1401.125", "-1401.125")), kInput, "focal lengths");
  EXPECT_ERROR(load_calibration(changed("1280, 960,", "1280.5, 960")), kInput, "whole pixels");
  EXPECT_ERROR(load_calibration(changed("'imagersize'", "'size'")), kInput, "'imagersize' is missing");
  EXPECT_ERROR(load_calibration(changed("(0, 0, 1.57", "(nan, 0, 1.57")), kInput, "no number");
  EXPECT_ERROR(load_calibration(changed("b'P)h", "b'P)h\n")), kInput, "changed.cameramodel:19");
}

TEST(CalibrationFile, ReadsColmapsCameras) {
  expect_golden_camera(load_calibration(golden("colmap_cameras.txt")).camera().camera,
                       {-0.2125, 0.0625, 0.00125, -0.0005, 0});
  Scratch folder;
  const auto lines = [&](const std::string& text) {
    write_file_atomically(folder / "cameras.txt", text);
    return load_calibration(folder / "cameras.txt").camera().camera;
  };
  const Camera simple = lines("7 SIMPLE_RADIAL 640 400 500 320.5 200.25 -0.125\n");
  EXPECT_EQ(simple.intrinsics.fx, 500);
  EXPECT_EQ(simple.intrinsics.fy, 500);
  EXPECT_EQ(simple.intrinsics.cy, 199.75);
  EXPECT_EQ(coefficients_of(simple.distortion), (std::vector<double>{-0.125, 0, 0, 0, 0}));
  EXPECT_ERROR(lines("1 PINHOLE 640 400 500 501 320 200\n2 PINHOLE 640 400 500 501 320 200\n"), kInput,
               "keep the line of one camera");
  EXPECT_ERROR(lines("1 FOV 640 400 500 501 320 200 0.1\n"), kUnsupported, "no camera model 'FOV'");
  EXPECT_ERROR(lines("1 PINHOLE 640 400 500 501 320\n"), kInput, "has 4 parameters, not 3");
  EXPECT_ERROR(lines("1 PINHOLE 640 400 500 0 320 200\n"), kInput, "focal lengths");
  EXPECT_ERROR(lines("1 PINHOLE 640 400 500 nan 320 200\n"), kInput, "is no number");
  EXPECT_ERROR(lines("1 PINHOLE 640 0 500 500 320 200\n"), kInput, "640x0");
}

TEST(CalibrationFile, ReadsOpencvsStereoSampleWithItsTwoFiles) {
  CalibrationContext context;
  context.camera_size = ImageSize{1280, 960};
  context.projector_size = ImageSize{1024, 768};
  const Rig rig = load_calibration(golden("intrinsics.yml"), context);
  expect_golden_camera(rig.camera().camera, {-0.2125, 0.0625, 0, 0, 0, 0, 0, 0.125});
  EXPECT_STREQ(name_of(rig.camera().camera.distortion), "rational");
  const Camera& projector = rig.projector().projector.inverse_camera;
  EXPECT_EQ(projector.size, (ImageSize{1024, 768}));
  EXPECT_EQ(projector.intrinsics.fx, 1890.5);
  EXPECT_EQ(projector.intrinsics.cy, 850.75);
  expect_golden_pose(rig.projector_from_camera());

  EXPECT_ERROR(load_calibration(golden("intrinsics.yml")), kInput, "give --camera-size");
  const Scratch scratch;
  const auto alone = scratch.write("intrinsics.yml", read_file(golden("intrinsics.yml")));
  EXPECT_ERROR(load_calibration(alone, context), kInput, "the field 'R' is missing");
}

TEST(CalibrationFile, ReadsRosCameraInfo) {
  expect_golden_camera(load_calibration(golden("ros_camera_info.yaml")).camera().camera, kTerms);
  const Rig message = load_calibration(golden("ros_camera_info_message.yaml"));
  expect_golden_camera(message.camera().camera, {-0.2125, 0.0625, 0.00125, -0.0005});
  EXPECT_STREQ(name_of(message.camera().camera.distortion), "fisheye");
  const Scratch scratch;
  EXPECT_ERROR(load_calibration(
                   scratch.write("ost.txt", "# oST version 5.0 parameters\n\n\n[image]\n\nwidth\n1280\n")),
               kUnsupported, "give ost.yaml");
}

TEST(CalibrationFile, ReadsKalibrsChainInMetres) {
  const Rig rig = load_calibration(golden("kalibr_camchain.yaml"));
  ASSERT_EQ(rig.cameras.size(), 3u);
  expect_golden_camera(rig.camera("cam0").camera, {-0.2125, 0.0625, 0.00125, -0.0005, 0});
  EXPECT_EQ(coefficients_of(rig.camera("cam1").camera.distortion),
            (std::vector<double>{0.011, -0.022, 0.033, -0.044}));
  EXPECT_EQ(rig.camera("cam1").camera.size, (ImageSize{640, 480}));
  EXPECT_TRUE(std::holds_alternative<NoDistortion>(rig.camera("cam2").camera.distortion));
  const Pose cam1_from_rig = rig.camera("cam1").rig_from_camera.inverse(),
             cam2_from_rig = rig.camera("cam2").rig_from_camera.inverse();
  expect_golden_pose(cam1_from_rig);
  EXPECT_LT((cam2_from_rig * Vec3(1, 2, 3) - Vec3(-1.9, 0.4, 5.25)).norm(), 1e-12);
}

/// OpenVINS' chains have each camera's pose to the IMU alone, Kalibr's both.
TEST(CalibrationFile, ReadsChainsThatGoByTheImu) {
  const auto expect_chain = [](const std::filesystem::path& file) {
    const Rig rig = load_calibration(file);
    ASSERT_EQ(rig.cameras.size(), 2u);
    expect_golden_camera(rig.camera("cam0").camera, {-0.2125, 0.0625, 0.00125, -0.0005, 0});
    EXPECT_STREQ(name_of(rig.camera("cam1").camera.distortion), "fisheye");
    expect_golden_pose(rig.camera("cam1").rig_from_camera.inverse());
  };
  expect_chain(golden("kalibr_openvins.yaml"));
  const Scratch scratch;
  std::string text = read_file(golden("kalibr_openvins.yaml"));
  const auto replace = [&](const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  const std::string rows0 =
                        "[0.0, 0.0, 1.0, 0.02]\n    - [1.0, 0.0, 0.0, -0.03]\n    - [0.0, 1.0, 0.0, 0.05]",
                    rows1 =
                        "[0.0, 0.0, 1.0, -0.23]\n    - [0.0, 1.0, 0.0, 0.57]\n    - [-1.0, 0.0, 0.0, 0.15]";
  replace(rows0, "[0.0, 1.0, 0.0, 0.03]\n    - [0.0, 0.0, 1.0, -0.05]\n    - [1.0, 0.0, 0.0, -0.02]");
  replace(rows1, "[0.0, 0.0, -1.0, 0.15]\n    - [0.0, 1.0, 0.0, -0.57]\n    - [1.0, 0.0, 0.0, 0.23]");
  replace("T_imu_cam", "T_cam_imu");
  replace("T_imu_cam", "T_cam_imu");
  expect_chain(scratch.write("chain.yaml", text));
  replace("T_cam_imu", "T_cam_body");
  EXPECT_ERROR(load_calibration(scratch.write("chain.yaml", text)), kInput, "'T_cn_cnm1' is missing");
}

/// The rig is the body.
TEST(CalibrationFile, ReadsASensorOfTheEurocLayout) {
  const Rig rig = load_calibration(golden("euroc_sensor.yaml"));
  expect_golden_camera(rig.camera().camera, {-0.2125, 0.0625, 0.00125, -0.0005, 0});
  expect_golden_pose(rig.camera().rig_from_camera.inverse());
  EXPECT_EQ(rig.provenance.tool, "EuRoC");
  const Scratch scratch;
  std::string omni = read_file(golden("euroc_sensor.yaml"));
  omni.replace(omni.find("pinhole"), 7, "omni");
  EXPECT_ERROR(load_calibration(scratch.write("s.yaml", omni)), kUnsupported, "no camera model 'omni'");
}

/// Scripts around cv2.calibrateCamera call it by many names; a lens that is read without its distortion is wrong
/// everywhere.
TEST(CalibrationFile, FindsTheDistortionUnderItsManyNames) {
  const Scratch scratch;
  const auto load = [&](const std::string& fields) {
    const std::string k = R"({"camera_matrix": [[1401.125, 0, 633.25], [0, 1398.75, 501.5], [0, 0, 1]], )";
    return load_calibration(scratch.write("c.json", k + fields + "}")).camera().camera;
  };
  for (const char* const name : {"dist_coeff", "dist_coefs", "dist_coef", "distortion", "distCoeffs",
                                 "distortionCoefficients", "Dist"})
    expect_golden_camera(
        load("\"" + std::string(name) +
             R"(": [[-0.2125, 0.0625, 0.00125, -0.0005, 0.015625]], "image_size": [1280, 960])"),
        kTerms);
  const std::string terms = R"("k1": -0.2125, "k2": 0.0625, "p1": 0.00125, "p2": -0.0005, "k3": 0.015625)";
  expect_golden_camera(load(terms + R"(, "frame_w": 1280, "frame_h": 960)"), kTerms);
  expect_golden_camera(
      load("\"distortion\": {" + terms + R"(}, "resolution": {"width": 1280, "height": 960})"), kTerms);
  expect_golden_camera(load(R"("k1": -0.2125, "k2": 0.0625, "k3": 0.00125, "k4": -0.0005, "size": [1280, 960],
                                "distortion_model": "equidistant")"),
                       {-0.2125, 0.0625, 0.00125, -0.0005});
  EXPECT_ERROR(load(R"("k1": -0.2125, "k4": -0.0005, "size": [1280, 960])"), kInput,
               "which lens its k1 to k4");
  EXPECT_ERROR(load(R"("lens_distortion_terms": [-0.2125, 0.0625, 0, 0], "size": [1280, 960])"), kInput,
               "lens_distortion_terms: procam does not know this name");
  EXPECT_ERROR(load(R"("distortion_model": "plumb_bob", "size": [1280, 960])"), kInput,
               "its coefficients are missing");
  // What is no distortion is no hindrance.
  EXPECT_TRUE(std::holds_alternative<NoDistortion>(
      load(R"("distances_mm": [300, 500], "undistorted_matrix": [1, 2], "size": [1280, 960])").distortion));
}

TEST(CalibrationFile, ReadsProjectorCameraPrograms) {
  CalibrationContext context;
  context.projector_size = ImageSize{1024, 768};
  context.camera_size = ImageSize{1280, 960};
  const Rig rig = load_calibration(golden("procamcalib.yml"), context);
  expect_golden_camera(rig.camera().camera, {-0.2125, 0.0625, 0.00125, -0.0005, 0});
  expect_golden_pose(rig.projector_from_camera());
  EXPECT_EQ(rig.quality.rms_px.at("projector"), 0.25);

  const Rig plain = load_calibration(golden("plain.json"));
  expect_golden_camera(plain.camera().camera, kTerms, 0.75);
  expect_golden_pose(plain.projector_from_camera());
  EXPECT_EQ(plain.projector().projector.size(), (ImageSize{1024, 768}));
  EXPECT_EQ(plain.projector().projector.inverse_camera.intrinsics.cy, 850.75);
  context.metres_per_unit = 1;
  EXPECT_NEAR(load_calibration(golden("plain.json"), context).projector_from_camera().translation.y(), -600,
              1e-9);
}

TEST(CalibrationFile, ReadsTheFileThatCameWithTheCaptures) {
  PROCAM_REQUIRE_TEST_DATA("graycode/upstream_calibration_result.xml");
  const std::filesystem::path path = test::test_data() / "graycode/upstream_calibration_result.xml";
  CalibrationContext context;
  context.projector_size = ImageSize{1024, 768};
  const Rig rig = load_calibration(path, context);
  EXPECT_EQ(rig.camera().camera.size, (ImageSize{1280, 1024}));
  EXPECT_EQ(rig.projector().projector.inverse_camera.intrinsics.fx, 3953.6715586677710);
  EXPECT_EQ(rig.projector().projector.inverse_camera.intrinsics.cy, 1357.8282322407788);
  EXPECT_NEAR(rig.projector_from_camera().translation.y(), -0.63045718819563251, 1e-12);
  EXPECT_NEAR(rig.quality.rms_px.at("camera"), 0.8566, 1e-4);
}

/// What becomes of a file of another program.
struct OtherProgramsFile {
  const char* file;
  std::vector<double> coefficients;
  double skew = 0;
  const char* refusal = nullptr;
};
void PrintTo(const OtherProgramsFile& of, std::ostream* out) {
  *out << of.file;
}

class FilesOfOtherPrograms : public testing::TestWithParam<OtherProgramsFile> {};

TEST_P(FilesOfOtherPrograms, AreReadOrRefusedWithTheReason) {
  const auto& [file, coefficients, skew, refusal] = GetParam();
  if (refusal) {
    try {
      load_calibration(golden(file));
      ADD_FAILURE() << "it is read";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(refusal), std::string::npos) << error.what();
      EXPECT_FALSE(error.next().empty());
    }
    return;
  }
  const Rig rig = load_calibration(golden(file));
  expect_golden_camera(rig.cameras.front().camera, coefficients, skew);
  EXPECT_FALSE(rig.provenance.tool.empty());
}

const std::vector<double> kFourTerms{-0.2125, 0.0625, 0.00125, -0.0005, 0};
INSTANTIATE_TEST_SUITE_P(
    CalibrationFile, FilesOfOtherPrograms,
    testing::Values(
        OtherProgramsFile{"opencv_interactive.xml", kTerms},
        OtherProgramsFile{"opencv_filestorage.json", kTerms}, OtherProgramsFile{"orb_slam3.yaml", kTerms},
        OtherProgramsFile{"camodocal_vins.yaml", kFourTerms}, OtherProgramsFile{"open3d_intrinsic.json", {}},
        OtherProgramsFile{"nerf_transforms.json", kFourTerms}, OtherProgramsFile{"realsense.json", kTerms},
        OtherProgramsFile{"metashape.xml", kTerms, 1.5}, OtherProgramsFile{"autoware.yaml", kTerms},
        OtherProgramsFile{"kalibr_omni.yaml", {}, 0, "no camera model 'omni'"},
        OtherProgramsFile{"mrcal_splined.cameramodel", {}, 0, "no lens model 'LENSMODEL_SPLINED"},
        OtherProgramsFile{
            "calib_io.json", {}, 0, "no calibration is recognised among its fields (Calibration)"},
        OtherProgramsFile{"zed.conf", {}, 0, "'[LEFT_CAM_HD]'"},
        OtherProgramsFile{"basalt.json", {}, 0, "no calibration is recognised among its fields (value0)"},
        OtherProgramsFile{"gazebo.sdf", kFourTerms},
        OtherProgramsFile{"scene.gltf", {}, 0, "give --camera-size"},
        OtherProgramsFile{"robot.urdf", {}, 0, "a URDF model holds frames and no lens"}));

TEST(CalibrationFile, ReadsBothCamerasOfOrbSlam) {
  const Rig rig = load_calibration(golden("orb_slam3.yaml"));
  ASSERT_EQ(rig.cameras.size(), 2u);
  EXPECT_EQ(rig.camera("camera2").camera.intrinsics.fy, 703.25);
  // T_c1_c2 takes points of the second camera's frame to the first's.
  const Pose camera1_from_camera2 =
      rig.camera("camera1").rig_from_camera.inverse() * rig.camera("camera2").rig_from_camera;
  expect_golden_pose(camera1_from_camera2);
}

/// The lens models that a program has and procam has not, and those with other meanings of the same numbers.
TEST(CalibrationFile, NamedNumbersHaveTheMeaningOfTheirProgram) {
  const Scratch scratch;
  const auto load = [&](const char* name, const std::string& from, const std::string& to) {
    std::string text = read_file(golden(name));
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) text.replace(at, from.size(), to);
    return load_calibration(scratch.write("c.txt", text)).cameras.front().camera;
  };
  const Camera fisheye = load("orb_slam3.yaml", "PinHole", "KannalaBrandt8");
  EXPECT_STREQ(name_of(fisheye.distortion), "fisheye");
  EXPECT_EQ(coefficients_of(fisheye.distortion), (std::vector<double>{-0.2125, 0.0625, 0.015625, 0}));
  EXPECT_ERROR(load("orb_slam3.yaml", "PinHole", "Omni"), kUnsupported, "KannalaBrandt8 or Rectified");
  EXPECT_ERROR(load("orb_slam3.yaml", "Camera1.fy: 1398.75", "#"), kInput, "'Camera1.fy' is missing");
  EXPECT_ERROR(load("orb_slam3.yaml", "Camera1.fy: 1398.75", "Camera1.fy: 0"), kInput, "focal lengths");
  EXPECT_ERROR(load("orb_slam3.yaml", "Stereo.T_c1_c2", "Stereo.T"), kInput, "'Stereo.T_c1_c2' is missing");
  EXPECT_ERROR(load("orb_slam3.yaml", "Camera.width: 1280", "#"), kInput, "give --camera-size");
  EXPECT_ERROR(load("camodocal_vins.yaml", "PINHOLE", "MEI"), kUnsupported, "KANNALA_BRANDT");
  EXPECT_ERROR(load("nerf_transforms.json", "OPENCV", "EQUIRECTANGULAR"), kUnsupported, "OPENCV_FISHEYE");
  EXPECT_STREQ(name_of(load("nerf_transforms.json", "OPENCV", "OPENCV_FISHEYE").distortion), "fisheye");
  EXPECT_ERROR(load("open3d_intrinsic.json", "0.0,", "633.25,"), kInput, "column by column");
  const Camera ngp = load("nerf_transforms.json", "\"camera_model\": \"OPENCV\"", "\"is_fisheye\": true");
  EXPECT_STREQ(name_of(ngp.distortion), "fisheye");
  EXPECT_ERROR(load("nerf_transforms.json", "\"k1\"", "\"k4\": 0.25, \"k1\""), kUnsupported, "no such term");
  const Camera rows = load("open3d_intrinsic.json", read_file(golden("open3d_intrinsic.json")),
                           R"({"width": 1280, "height": 960,
               "intrinsic_matrix": [[1401.125, 0, 633.25], [0, 1398.75, 501.5], [0, 0, 1]]})");
  expect_golden_camera(rows, {});
  EXPECT_ERROR(load("realsense.json", "distortion.brown_conrady", "distortion.inverse_brown_conrady"),
               kUnsupported, "calibrate-camera");
  EXPECT_STREQ(name_of(load("realsense.json", "distortion.brown_conrady", "Brown Conrady").distortion),
               "brown_conrady");
  EXPECT_ERROR(load("metashape.xml", "<b1>", "<k4>0.25</k4><b1>"), kUnsupported, "no such term");
  EXPECT_ERROR(load("metashape.xml", "frame", "fisheye"), kUnsupported, "frame camera");
}

/// Editors write a mark before the text, tabs behind colons, and lines that end as on Windows.
TEST(CalibrationFile, ReadsWhatEditorsMakeOfIt) {
  const Scratch scratch;
  const std::string mark = "\xef\xbb\xbf";
  for (const char* const name : {"ros_camera_info.yaml", "kalibr_camchain.yaml", "opencv_tutorial.xml",
                                 "plain.json", "mrcal.cameramodel", "colmap_cameras.txt", "rig.json"}) {
    const std::string text = read_file(golden(name));
    const Rig whole = load_calibration(golden(name));
    const Rig marked = load_calibration(scratch.write("marked.txt", mark + text));
    EXPECT_EQ(marked.cameras.size(), whole.cameras.size()) << name;
    EXPECT_EQ(parameters_of(marked.cameras[0].camera), parameters_of(whole.cameras[0].camera)) << name;
  }
  // The first field is not lost behind the mark.
  const std::string fisheye =
      "fisheye_model: 1\nK: [500, 510, 320, 240]\nD: [0.1, 0.2, 0, 0]\nsize: [640, 480]\n";
  EXPECT_STREQ(
      name_of(load_calibration(scratch.write("f.yaml", mark + fisheye)).cameras[0].camera.distortion),
      "fisheye");
  std::string tabs = read_file(golden("ros_camera_info.yaml"));
  for (std::size_t at = 0; (at = tabs.find(": ", at)) != std::string::npos; ++at) tabs.replace(at, 2, ":\t");
  expect_golden_camera(load_calibration(scratch.write("t.yaml", tabs)).cameras[0].camera, kTerms);
}

/// OpenCV's own YAML reader takes them, and ORB-SLAM's settings for EuRoC have both.
TEST(CalibrationFile, ReadsFieldsWithoutABlankBehindTheColon) {
  const Scratch scratch;
  std::string text = read_file(golden("orb_slam3.yaml")) + "\nViewer.PointSize:2\n";
  const std::string from = "data: [0, -1";
  text.replace(text.find(from), from.size(), "data:[0, -1");
  const Rig rig = load_calibration(scratch.write("c.yaml", text));
  expect_golden_camera(rig.cameras[0].camera, kTerms);
  expect_golden_pose(rig.cameras[0].rig_from_camera.inverse() * rig.cameras[1].rig_from_camera);
  EXPECT_ERROR(load_calibration(scratch.write("c.yaml", "a photograph: of\nit is:2\n")), kInput, "no field");
}

/// Before version 1.0 mrcal had an underscore.
TEST(CalibrationFile, ReadsMrcalsOldFiles) {
  const Scratch scratch;
  std::string text = read_file(golden("mrcal.cameramodel"));
  const std::size_t at = text.find("'lensmodel'");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 11, "'lens_model'");
  const Rig rig = load_calibration(scratch.write("old.cameramodel", text));
  expect_golden_camera(rig.camera().camera, {-0.2125, 0.0625, 0.00125, -0.0005, 0.015625, 0, 0.25, 0.03125});
  expect_golden_pose(rig.camera().rig_from_camera.inverse());
}

/// A rotation of no special axis, written with five decimals.
TEST(CalibrationFile, ReadsRotationsThatWereRounded) {
  const Scratch scratch;
  std::string chain = read_file(golden("kalibr_camchain.yaml"));
  const std::string from = "[0.0, -1.0, 0.0, 0.1]\n  - [1.0, 0.0, 0.0, -0.6]\n  - [0.0, 0.0, 1.0, 0.25]";
  ASSERT_NE(chain.find(from), std::string::npos);
  chain.replace(chain.find(from), from.size(),
                "[0.97912, -0.16729, 0.11549, 0.1]\n  - [0.19952, 0.89968, -0.38829, -0.6]\n"
                "  - [-0.03895, 0.40323, 0.91427, 0.25]");
  const Pose cam1_from_rig =
      load_calibration(scratch.write("c.yaml", chain)).camera("cam1").rig_from_camera.inverse();
  const Vec3 by_hand(0.97912 + 2 * (-0.16729) + 3 * (0.11549) + 0.1,
                     0.19952 + 2 * (0.89968) + 3 * (-0.38829) - 0.6,
                     -0.03895 + 2 * (0.40323) + 3 * (0.91427) + 0.25);
  constexpr double kRounding = 5e-5;  // five decimals, times the three coordinates
  EXPECT_LT((cam1_from_rig * Vec3(1, 2, 3) - by_hand).norm(), kRounding);
}

TEST(CalibrationFile, RefusesAChainWithAGap) {
  const Scratch scratch;
  std::string chain = read_file(golden("kalibr_camchain.yaml"));
  const std::size_t at = chain.find("cam1:");
  ASSERT_NE(at, std::string::npos);
  chain.replace(at, 5, "cam7:");
  EXPECT_ERROR(load_calibration(scratch.write("c.yaml", chain)), kInput, "there is no 'cam1' before it");
}

TEST(CalibrationFile, ReadsColmapsRadialFisheyes) {
  const Scratch scratch;
  const Camera one =
      load_calibration(scratch.write("c.txt", "1 SIMPLE_RADIAL_FISHEYE 640 480 500 320.5 240.5 0.1\n"))
          .cameras[0]
          .camera;
  EXPECT_STREQ(name_of(one.distortion), "fisheye");
  EXPECT_EQ(coefficients_of(one.distortion), (std::vector<double>{0.1, 0, 0, 0}));
  EXPECT_EQ(one.intrinsics.fy, 500);
  EXPECT_EQ(one.intrinsics.cx, 320);
  const Camera two =
      load_calibration(scratch.write("c.txt", "1 RADIAL_FISHEYE 640 480 500 320.5 240.5 0.1 -0.02\n"))
          .cameras[0]
          .camera;
  EXPECT_EQ(coefficients_of(two.distortion), (std::vector<double>{0.1, -0.02, 0, 0}));
  scratch.write("cameras.bin", std::string("\1\0\0\0\0\0\0\0", 8));
  EXPECT_ERROR(load_calibration(scratch / "cameras.bin"), kUnsupported, "model_converter --output_type TXT");
}

TEST(CalibrationFile, ReadsCamerasOfScenes) {
  const Scratch scratch;
  CalibrationContext context;
  context.camera_size = ImageSize{1280, 960};
  // A node below a node that is shifted and rotated by a quarter turn about y: the camera looks along -x, and is at
  // (1, 2, 3) + (0, 0, -0.5) turned to (-0.5, 0, 0).
  const std::string scene = R"({"asset": {"version": "2.0"}, "nodes": [
    {"name": "head", "children": [1], "translation": [1, 2, 3], "rotation": [0, 0.7071067811865476, 0, 0.7071067811865476]},
    {"name": "eye", "camera": 0, "translation": [0, 0, -0.5]}],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]})";
  const auto load = [&](std::string text, const std::string& from, const std::string& to) {
    if (!from.empty()) text.replace(text.find(from), from.size(), to);
    return load_calibration(scratch.write("scene.gltf", text), context);
  };
  const Rig rig = load(scene, "", "");
  ASSERT_EQ(rig.cameras.size(), 1u);
  EXPECT_EQ(rig.cameras[0].name, "eye");
  EXPECT_LT((rig.cameras[0].rig_from_camera * Vec3(0, 0, 2) - Vec3(-1.5, 2, 3)).norm(), 1e-12);
  // y of the optical frame is down.
  EXPECT_LT((rig.cameras[0].rig_from_camera.rotate(Vec3(0, 1, 0)) - Vec3(0, -1, 0)).norm(), 1e-12);
  const Camera& camera = rig.cameras[0].camera;
  EXPECT_NEAR(camera.intrinsics.fy, 480 / std::tan(0.5), 1e-9);
  EXPECT_NEAR(camera.intrinsics.fx, camera.intrinsics.fy, 1e-9);
  EXPECT_EQ(camera.intrinsics.cx, 639.5);
  EXPECT_ERROR(load(scene, "\"yfov\": 1,", "\"yfov\": 4,"), kInput, "field of view");
  EXPECT_ERROR(load(scene, "\"yfov\": 1,", ""), kInput, "'yfov' is missing");
  EXPECT_ERROR(load(scene, "\"type\": \"perspective\"", "\"type\": \"orthographic\""), kUnsupported,
               "orthographic");
  EXPECT_ERROR(load(scene, "\"camera\": 0", "\"camera\": 7"), kInput, "nothing of this number");
  EXPECT_ERROR(load(scene, "\"children\": [1]", "\"children\": [0, 1]"), kInput, "ring");
  EXPECT_ERROR(load(scene, "\"camera\": 0, ", ""), kInput, "no node of the scene has a camera");
  // Scale moves what is below a node; how the camera sees it does not change.
  const Rig scaled = load(scene, "\"name\": \"head\",", "\"name\": \"head\", \"scale\": [2, 2, 2],");
  EXPECT_LT((scaled.cameras[0].rig_from_camera * Vec3(0, 0, 2) - Vec3(-2, 2, 3)).norm(), 1e-12);
  const Rig rounded = load(scene, "\"name\": \"eye\",", "\"name\": \"eye\", \"scale\": [1, 0.9999999, 1],");
  EXPECT_LT((rounded.cameras[0].rig_from_camera * Vec3(0, 0, 2) - Vec3(-1.5, 2, 3)).norm(), 1e-12);
  EXPECT_ERROR(load(scene, "\"name\": \"head\",", "\"name\": \"head\", \"scale\": [-2, 2, 2],"), kInput,
               "shears or mirrors");
  // An orthographic camera beside a perspective one is skipped.
  std::string two = scene;
  two.replace(two.find("\"cameras\": ["), 12,
              R"("cameras": [{"type": "orthographic", "orthographic": {}}, )");
  two.replace(two.find("\"camera\": 0"), 11, "\"camera\": 1");
  two.replace(two.find("\"translation\": [0, 0, -0.5]}"), 28,
              R"("translation": [0, 0, -0.5]}, {"name": "plan", "camera": 0})");
  const Rig one_of_two = load(two, "", "");
  ASSERT_EQ(one_of_two.cameras.size(), 1u);
  EXPECT_EQ(one_of_two.cameras[0].name, "eye");
  context.camera_size = std::nullopt;
  EXPECT_ERROR(load(scene, "", ""), kInput, "give --camera-size");
}

TEST(CalibrationFile, ReadsTheCameraOfASdfModel) {
  const Scratch scratch;
  const std::string model = read_file(golden("gazebo.sdf"));
  const auto load = [&](const std::string& from, const std::string& to) {
    std::string text = model;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) text.replace(at, from.size(), to);
    return load_calibration(scratch.write("model.sdf", text));
  };
  // Without intrinsics: by the field of view, about the middle of the image.
  const std::size_t begin = model.find("<lens>"), end = model.find("</lens>") + 7;
  const Camera plain = load(model.substr(begin, end - begin), "").cameras[0].camera;
  EXPECT_NEAR(plain.intrinsics.fx, 640 / std::tan(0.425), 1e-9);
  EXPECT_EQ(plain.intrinsics.fy, plain.intrinsics.fx);
  EXPECT_EQ(plain.intrinsics.cy, 479.5);
  // Gazebo's own models have attributes beside texts.
  expect_golden_camera(
      load("<sensor", "<pose frame=\"\">0 -0.05 0.004 0 0 0</pose><sensor").cameras[0].camera,
      {-0.2125, 0.0625, 0.00125, -0.0005, 0});
  EXPECT_EQ(load("<fx>1401.125</fx>", "<fx unit=\"px\">1401.125</fx>").cameras[0].camera.intrinsics.fx,
            1401.125);
  EXPECT_ERROR(load("<center>0.5 0.5</center>", "<center>0.4 0.5</center>"), kUnsupported,
               "centre of distortion");
  EXPECT_ERROR(load("type=\"camera\"", "type=\"gpu_lidar\""), kUnsupported, "frames and no camera");
  EXPECT_ERROR(load("type=\"camera\"", "type=\"wideanglecamera\""), kUnsupported, "wideanglecamera");
  EXPECT_ERROR(load("<fx>1401.125</fx>", "<fx>-1</fx>"), kInput, "focal lengths");
}

TEST(CalibrationFile, ReadsARigFileWhole) {
  const Scratch scratch;
  save_rig(scratch / "rig.json", test::example_rig());
  const Rig rig = load_calibration(scratch / "rig.json");
  EXPECT_EQ(rig.covariance.names, test::example_rig().covariance.names);
  EXPECT_EQ(rig.projectors.size(), test::example_rig().projectors.size());
}

TEST(CalibrationFile, NamesFileLineAndField) {
  const Scratch scratch;
  const std::string ros = read_file(golden("ros_camera_info.yaml")),
                    kalibr = read_file(golden("kalibr_camchain.yaml"));
  const auto load = [&](std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    if (at != std::string::npos) text.replace(at, from.size(), to);
    return load_calibration(scratch.write("c.yaml", text));
  };
  EXPECT_ERROR(load(ros, "1401.125", "-1401.125"), kInput, "c.yaml:4: camera_matrix");
  EXPECT_ERROR(load(ros, "1401.125", ".nan"), kInput, "camera_matrix.data[0]");
  EXPECT_ERROR(load(ros, "1401.125, ", ""), kInput, "it has 8 numbers where its rows and columns make 9");
  EXPECT_ERROR(load(ros, "plumb_bob", "plum_bob"), kUnsupported, "did you mean 'plumb_bob'");
  EXPECT_ERROR(load(ros, "cols: 5\n  data: [", "cols: 6\n  data: [0.25, "), kUnsupported,
               "rational_polynomial has 8");
  EXPECT_ERROR(load(ros, "camera_matrix", "matrix"), kInput, "no calibration is recognised");
  EXPECT_ERROR(load(ros, "image_width", "width_of_image"), kInput, "size of the camera's image");
  EXPECT_ERROR(load(ros, "cols: 5", "cols: 500000000"), kInput, "no number of rows or columns");
  EXPECT_ERROR(load(ros, "rows: 3\n", "rows: 3\n  rows: 3\n"), kInput, "c.yaml:6: the field 'rows' is given");
  EXPECT_ERROR(load("fisheye_model: 1\nK: [500, 510, 320, 240]\nsize: [640, 480]\n", "", ""), kInput,
               "an equidistant lens has 4 coefficients, not 0");
  EXPECT_ERROR(load(kalibr, "pinhole", "omni"), kUnsupported, "pinhole-radtan");
  EXPECT_ERROR(load(kalibr, "[0.0, -1.0, 0.0, 0.1]", "[0.0, -1.0, 0.1, 0.1]"), kInput,
               "c.yaml:10: cam1.T_cn_cnm1: it is not a rigid transform");
  EXPECT_ERROR(load(kalibr, "equidistant", "fov"), kUnsupported, "no lens model 'fov'");
  EXPECT_ERROR(load("", "", ""), kInput, "it is empty");
  EXPECT_ERROR(load("a photograph", "", ""), kInput, "c.yaml:1");
  EXPECT_ERROR(load("a: &x [1]\nb: *x\n", "", ""), kInput, "anchors");
  EXPECT_ERROR(load("K: [1, 2", "", ""), kInput, "does not end");
  EXPECT_ERROR(load("{\"K\": [1, 2, 3, 4, 5]}", "", ""), kInput, "c.yaml:1: K: it is not 3x3 numbers but 5");
  EXPECT_ERROR(load_calibration(scratch / "absent.xml"), kIo, "No such file");
}

/// Fixed seed. Damage is refused or still reads as finite numbers; nothing but procam::Error comes out. Deep
/// nesting and long lists are refused as well.
TEST(CalibrationFile, SurvivesDamage) {
  const Scratch scratch;
  CalibrationContext context;
  context.camera_size = context.projector_size = ImageSize{1024, 768};
  std::mt19937 random(5);
  for (const char* const name :
       {"opencv_camera.yml", "opencv_tutorial.xml", "ros_camera_info.yaml", "kalibr_camchain.yaml",
        "plain.json", "procamcalib.yml", "orb_slam3.yaml", "camodocal_vins.yaml", "nerf_transforms.json",
        "open3d_intrinsic.json", "metashape.xml", "realsense.json", "gazebo.sdf", "scene.gltf",
        "kalibr_openvins.yaml", "euroc_sensor.yaml"}) {
    const std::string whole = read_file(golden(name));
    for (int trial = 0; trial < 400; ++trial) {
      std::string damaged = whole;
      if (trial % 2 == 0)
        damaged.resize(random() % whole.size());
      else
        for (int hit = 0; hit < 1 + trial % 3; ++hit) damaged[random() % damaged.size()] = char(random());
      try {
        const Rig rig = load_calibration(scratch.write("c.yml", damaged), context);
        EXPECT_TRUE(parameters_of(rig.camera().camera).allFinite());
      } catch (const Error&) {
      }
    }
  }
  const auto load = [&](const std::string& text) { return load_calibration(scratch.write("c.yml", text)); };
  EXPECT_ERROR(load("K: " + std::string(100000, '[') + std::string(100000, ']')), kInput, "nested deeper");
  std::string nested;
  for (int i = 0; i < 100; ++i) nested += std::string(std::size_t(i), ' ') + "a:\n";
  EXPECT_ERROR(load(nested), kInput, "nested deeper");
  std::string fields;
  for (int i = 0; i < 20000; ++i) fields += "a" + std::to_string(i) + ": 1\n";
  EXPECT_ERROR(load(fields), kInput, "too many fields");
  // A few hundred bytes must not state an image that no memory holds.
  const auto of_size = [&](const std::string& width, const std::string& height) {
    return load("%YAML:1.0\n---\nimage_width: " + width + "\nimage_height: " + height +
                "\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 1000., 0., "
                "640., 0., 1000., 480., 0., 0., 1. ]\n");
  };
  EXPECT_EQ(of_size("16384", "8192").camera().camera.size, (ImageSize{16384, 8192}));
  EXPECT_ERROR(of_size("16384", "8193"), kInput, "pixels are more than");
  EXPECT_ERROR(of_size("1048576", "1048576"), kInput, "pixels are more than");
  EXPECT_ERROR(of_size("1048577", "1"), kInput, "from 1 to 1048576");
  EXPECT_ERROR(load("image_size: [1048576, 1048576]\nK: [1000, 1000, 640, 480]\n"), kInput, "are more than");
}

}  // namespace
}  // namespace procam::io
