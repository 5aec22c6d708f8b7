#include "procam/io/opencv_calibration.hpp"

#include <gtest/gtest.h>

#include <random>

#include "procam/io/files.hpp"
#include "scratch.hpp"
#include "support/test_data.hpp"

namespace procam::io {
namespace {

using test::Scratch;

std::string matrix(const std::string& name, int rows, int cols, const std::string& data) {
  return name + ": !!opencv-matrix\n   rows: " + std::to_string(rows) + "\n   cols: " + std::to_string(cols) +
         "\n   dt: d\n   data: [ " + data + " ]\n";
}

std::string calibration(const std::string& camera_matrix = "1700., 0.5, 630., 0., 1690., 520., 0., 0., 1.",
                        const std::string& rotation = "0., -1., 0., 1., 0., 0., 0., 0., 1.") {
  return "%YAML:1.0\n---\n" + matrix("img_shape", 2, 1, "1024., 1280.") + "rms: 0.25\n" +
         matrix("cam_int", 3, 3, camera_matrix) + matrix("cam_dist", 1, 5, "-0.2, 0.1, 1e-4, 2e-4, 0.03") +
         matrix("proj_int", 3, 3, "1890., 0., 500., 0., 1895., 850., 0., 0., 1.") +
         matrix("proj_dist", 8, 1, "0.1, 0.2, 0., 0., 0.3, 0.4, 0.5, 0.6") +
         matrix("rotation", 3, 3, rotation) + matrix("translation", 3, 1, "100., -600., 250.");
}

TEST(OpencvCalibration, ReadsYamlWithUnitsAndDirection) {
  const Scratch scratch;
  const Rig rig = load_opencv_calibration(scratch.write("c.yml", calibration()), {1024, 768}, 0.001);
  EXPECT_EQ(rig.camera().camera.size, (ImageSize{1280, 1024}));
  EXPECT_EQ(rig.projector().projector.size(), (ImageSize{1024, 768}));
  EXPECT_EQ(rig.camera().camera.intrinsics.skew, 0.5);
  EXPECT_EQ(coefficients_of(rig.camera().camera.distortion),
            (std::vector<double>{-0.2, 0.1, 1e-4, 2e-4, 0.03}));
  EXPECT_STREQ(name_of(rig.projector().projector.inverse_camera.distortion), "rational");
  EXPECT_EQ(rig.quality.rms_px.at("projector"), 0.25);
  // x_projector = R x_camera + t, millimetres to metres: (1, 2, 3) m -> (-2 + 0.1, 1 - 0.6, 3 + 0.25).
  EXPECT_LT((rig.projector_from_camera() * Vec3(1, 2, 3) - Vec3(-1.9, 0.4, 3.25)).norm(), 1e-12);
}

TEST(OpencvCalibration, ReadsTheFileThatCameWithTheCaptures) {
  PROCAM_REQUIRE_TEST_DATA("graycode/upstream_calibration_result.xml");
  const std::filesystem::path path = test::test_data() / "graycode/upstream_calibration_result.xml";
  const Rig rig = load_opencv_calibration(path, {1024, 768}, 0.001);
  EXPECT_EQ(rig.camera().camera.size, (ImageSize{1280, 1024}));
  EXPECT_EQ(rig.projector().projector.inverse_camera.intrinsics.fx, 3953.6715586677710);
  EXPECT_EQ(rig.projector().projector.inverse_camera.intrinsics.cy, 1357.8282322407788);
  EXPECT_NEAR(rig.projector_from_camera().translation.y(), -0.63045718819563251, 1e-12);
  EXPECT_NEAR(rig.quality.rms_px.at("camera"), 0.8566, 1e-4);
}

TEST(OpencvCalibration, NamesTheMatrixThatIsWrong) {
  const Scratch scratch;
  const auto load = [&](const std::string& text) {
    return load_opencv_calibration(scratch.write("c.yml", text), {1024, 768}, 0.001);
  };
  EXPECT_ERROR(load(calibration("1700., 0., 630., 0., -1690., 520., 0., 0., 1.")), kInput, "cam_int");
  EXPECT_ERROR(load(calibration("1700., 0., .Nan, 0., 1690., 520., 0., 0., 1.")), kInput, "cam_int");
  EXPECT_ERROR(load(calibration("1700., 0., 630., 0., 1690., 520., 0., 0., 1.",
                                "1., 0., 0., 0., 1., 0., 0., 0., -1.")),
               kInput, "it is not a rotation");
  EXPECT_ERROR(load("%YAML:1.0\n---\nrms: 1.\n"), kInput, "img_shape: it is missing");
  const std::string huge = matrix("img_shape", 1000000000, 2, "1024., 1280.");
  EXPECT_ERROR(load("%YAML:1.0\n---\n" + huge), kInput,
               "img_shape: its number of rows is missing or not from 1");
  EXPECT_ERROR(load(""), kInput, "not OpenCV storage");
  EXPECT_ERROR(load("no storage at all"), kInput, "c.yml");
  EXPECT_ERROR(load_opencv_calibration(scratch / "absent.xml", {1024, 768}, 0.001), kIo, "No such file");
}

// Fixed seed. Damage is refused or still reads as finite numbers; nothing but procam::Error comes out.
TEST(OpencvCalibration, SurvivesDamage) {
  const Scratch scratch;
  const std::string whole = calibration();
  std::mt19937 random(5);
  for (int trial = 0; trial < 400; ++trial) {
    std::string damaged = whole;
    if (trial % 2 == 0)
      damaged.resize(random() % whole.size());
    else
      damaged[random() % damaged.size()] = char(random());
    try {
      const Rig rig = load_opencv_calibration(scratch.write("c.yml", damaged), {1024, 768}, 0.001);
      EXPECT_TRUE(parameters_of(rig.camera().camera).allFinite());
    } catch (const Error&) {
    }
  }
}

}  // namespace
}  // namespace procam::io
