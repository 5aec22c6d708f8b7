// Rendered captures of an independent world (worlds/gray_hard): defocused, dark, with camera gamma, glare and
// noise, the truth beside them.
#include <gtest/gtest.h>

#include <opencv2/core/persistence.hpp>
#include <opencv2/imgcodecs.hpp>

#include "procam/detect/board_artwork.hpp"
#include "procam/detect/chessboard.hpp"
#include "procam/pattern/board_light.hpp"
#include "procam/pattern/stripe_edges.hpp"
#include "support/test_data.hpp"

namespace procam {
namespace {

const pattern::GrayCode kGrayCode{{1024, 768}, 1};
const Chessboard kWorldBoard{10, 7, 0.05};

struct Capture {
  std::vector<cv::Mat> images;
  std::vector<ViewU8> frames;
  Vec2 crop_origin;
  Points2 camera_corners, projector_corners;
};

Points2 points_of(const cv::FileNode& node) {
  Points2 points;
  for (const cv::FileNode& p : node) points.emplace_back(double(p[0]), double(p[1]));
  return points;
}

Capture load(const std::string& folder) {
  const std::string root = (test::test_data() / "worlds/gray_hard").string();
  Capture capture;
  for (int i = 0; i < 42; ++i) {
    const std::string number = (i < 10 ? "0" : "") + std::to_string(i);
    capture.images.push_back(
        cv::imread(root + "/" + folder + "/graycode_" + number + ".png", cv::IMREAD_GRAYSCALE));
    capture.frames.emplace_back(capture.images.back().data, capture.images.back().cols,
                                capture.images.back().rows);
  }
  const cv::FileStorage truth(root + "/truth.json", cv::FileStorage::READ | cv::FileStorage::FORMAT_JSON);
  for (const cv::FileNode& view : truth["views"]) {
    if (std::string(view["folder"]) != folder) continue;
    capture.crop_origin = Vec2(double(view["crop_origin"][0]), double(view["crop_origin"][1]));
    capture.camera_corners = points_of(view["true_camera_corners"]);
    capture.projector_corners = points_of(view["true_projector_corners"]);
  }
  return capture;
}

class DefocusedCaptures : public testing::TestWithParam<const char*> {};

TEST_P(DefocusedCaptures, GiveEveryLitCornerItsProjectorPixel) {
  PROCAM_REQUIRE_TEST_DATA("worlds/gray_hard");
  const Capture capture = load(GetParam());
  const DecodedMap decoded = pattern::decode(capture.frames, kGrayCode);
  EXPECT_EQ(decoded.diagnostics.find("pair_not_complementary"), nullptr);
  const Detections seen = detect::detect_chessboard(capture.frames[40], kWorldBoard);
  ASSERT_GE(seen.observations.size(), 60u);
  const Detections projected =
      pattern::project_board(seen, kWorldBoard, detect::board_artwork(kWorldBoard), decoded,
                             pattern::stripe_edges(capture.frames, decoded, kGrayCode));

  // The board has two orders of its corners.
  const Observation& any = seen.observations.front();
  const int last = int(capture.camera_corners.size()) - 1;
  const bool turned =
      (any.pixel + capture.crop_origin - capture.camera_corners[std::size_t(any.point)]).norm() > 5;
  const auto truth = [&](int point) {
    return capture.projector_corners[std::size_t(turned ? last - point : point)];
  };
  double squares = 0, largest = 0;
  for (const Observation& o : projected.observations) {
    const double error = (o.pixel - truth(o.point)).norm();
    squares += 0.5 * error * error, largest = std::max(largest, error);
  }
  const double rms = std::sqrt(squares / double(projected.observations.size()));
  RecordProperty("rms_px", std::to_string(rms));
  RecordProperty("largest_px", std::to_string(largest));
  EXPECT_LT(rms, 0.06);  // a coordinate; the camera's corners, at 0.02 px, are most of it
  EXPECT_LT(largest, 0.25);
  // Nearer to the rim of the projector's picture the light ends within the corner's own squares.
  for (const Observation& o : seen.observations) {
    const Vec2 p = truth(o.point);
    if (std::min({p.x(), p.y(), 1023 - p.x(), 767 - p.y()}) < 12) continue;
    EXPECT_TRUE(std::any_of(projected.observations.begin(), projected.observations.end(),
                            [&](const Observation& q) { return q.point == o.point; }))
        << o.point << " at " << p.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(Worlds, DefocusedCaptures, testing::Values("capture_03", "capture_05", "capture_09"),
                         [](const auto& info) { return std::string(info.param); });

TEST(MovedBoard, FailsAsPairsThatAreNotComplementary) {
  PROCAM_REQUIRE_TEST_DATA("worlds/gray_hard");
  const Capture capture = load("capture_00");
  EXPECT_TRUE(pattern::decode(capture.frames, kGrayCode).diagnostics.failed());
}

}  // namespace
}  // namespace procam
