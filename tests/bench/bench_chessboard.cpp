/// Corners of a chessboard in one image: detect_chessboard() against OpenCV's findChessboardCorners() with
/// cornerSubPix(), as users call them, in one run, on one thread. Photographs of a wide-angle camera from 0.3
/// to 18 megapixels, and of real cameras where the test data are. Prints times, their ratio, and the RMS
/// distance from the true corners (of photographs: from each other). An argument selects photographs by name.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "detect/rendered_board.hpp"
#include "procam/detect/chessboard.hpp"
#include "support/test_data.hpp"

namespace {

using namespace procam;

struct Photograph {
  std::string name;
  cv::Mat image;
  Chessboard board;
  Points2 truth;  ///< of photographs: empty
};

/// 95 degrees wide, rendered at `scale` times less and enlarged: a blur of 0.7 * scale pixels, and noise.
Photograph wide_angle(const char* name, ImageSize size, int scale) {
  const ImageSize small{size.width / scale, size.height / scale};
  const double f = 0.46 * small.width;
  test::BoardScene scene;
  scene.board = {9, 6, 0.03};
  scene.camera = {small,
                  {f, 1.004 * f, 0.51 * small.width, 0.485 * small.height, 0.3},
                  BrownConrady{{-0.19, 0.035, 0.0006, -0.0004, 0}}};
  scene.camera_from_board = scene.facing(Vec3(0.31, -0.42, 0.13), Vec3(0.02, -0.015, 0.24));
  scene.blur_px = 0.7;
  scene.noise = 0;
  const ImageU8 rendered = test::render(scene);
  Photograph photograph{name, {}, scene.board, test::true_corners(scene)};
  cv::resize(cv::Mat(small.height, small.width, CV_8U, const_cast<std::uint8_t*>(rendered.data())),
             photograph.image, {size.width, size.height}, 0, 0, cv::INTER_CUBIC);
  cv::Mat noise(photograph.image.size(), CV_16S);
  cv::RNG(7).fill(noise, cv::RNG::NORMAL, 0, 2);
  cv::add(photograph.image, noise, photograph.image, cv::noArray(), CV_8U);
  for (Vec2& corner : photograph.truth) corner = scale * corner + 0.5 * (scale - 1) * Vec2::Ones();
  return photograph;
}

std::vector<Photograph> photographs(const std::string& selected) {
  std::vector<Photograph> all;
  const auto wanted = [&](const std::string& name) { return name.find(selected) != std::string::npos; };
  const std::tuple<const char*, ImageSize, int> rendered[] = {{"wide angle, 640x480", {640, 480}, 1},
                                                              {"wide angle, 1280x960", {1280, 960}, 1},
                                                              {"wide angle, 1920x1280", {1920, 1280}, 2},
                                                              {"wide angle, 5184x3456", {5184, 3456}, 3}};
  for (const auto& [name, size, scale] : rendered)
    if (wanted(name)) all.push_back(wide_angle(name, size, scale));
  const std::pair<const char*, Chessboard> files[] = {{"chessboard/left01.jpg", {9, 6, 1}},
                                                      {"chessboard/left04.jpg", {9, 6, 1}},
                                                      {"chessboard/left12.jpg", {9, 6, 1}},
                                                      {"graycode/capture_0/graycode_40.png", {7, 9, 1}},
                                                      {"graycode/capture_3/graycode_40.png", {7, 9, 1}}};
  for (const auto& [file, board] : files) {
    const cv::Mat image =
        wanted(file) ? cv::imread((test::test_data() / file).string(), cv::IMREAD_GRAYSCALE) : cv::Mat();
    if (!image.empty()) all.push_back({file, image, board, {}});
  }
  return all;
}

/// Shortest processor time of a call, over a second or ten calls.
template <typename Call>
double milliseconds(const Call& call) {
  double best = 1e30, total = 0;
  for (int i = 0; i < 10 && total < 1000; ++i) {
    const std::clock_t begin = std::clock();
    call();
    const double took = 1e3 * double(std::clock() - begin) / CLOCKS_PER_SEC;
    best = std::min(best, took), total += took;
  }
  return best;
}

/// To the nearest of the other corners; NaN without any.
double rms(const Points2& corners, const Points2& others) {
  double sum = 0;
  for (const Vec2& corner : corners) {
    double nearest = 1e30;
    for (const Vec2& other : others) nearest = std::min(nearest, (corner - other).squaredNorm());
    sum += nearest;
  }
  return std::sqrt(sum / double(corners.size()));
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  std::printf("%-36s %10s %10s %7s   RMS: procam, OpenCV\n", "", "procam ms", "OpenCV ms", "ratio");
  for (const Photograph& photograph : photographs(argc > 1 ? argv[1] : "")) {
    const ViewU8 view{photograph.image.data, photograph.image.cols, photograph.image.rows, 1,
                      std::ptrdiff_t(photograph.image.step[0])};
    Points2 own;
    const double own_ms = milliseconds([&] {
      own.clear();
      for (const Observation& corner : detect::detect_chessboard(view, photograph.board).observations)
        own.push_back(corner.pixel);
    });
    std::vector<cv::Point2f> found;
    const double peer_ms = milliseconds([&] {
      found.clear();
      if (cv::findChessboardCorners(photograph.image, {photograph.board.columns, photograph.board.rows},
                                    found))
        cv::cornerSubPix(photograph.image, found, {11, 11}, {-1, -1},
                         {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.001});
    });
    Points2 peer;
    for (const cv::Point2f& corner : found) peer.emplace_back(corner.x, corner.y);
    const Points2& truth = photograph.truth.empty() ? peer : photograph.truth;
    std::printf("%-36s %10.1f %10.1f %7.2f   %.3f (%zu), %.3f (%zu)\n", photograph.name.c_str(), own_ms,
                peer_ms, own_ms / peer_ms, rms(own, truth), own.size(), rms(peer, truth), peer.size());
  }
}
