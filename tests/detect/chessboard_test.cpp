#include "procam/detect/chessboard.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <tuple>

#include "procam/detect/detect_board.hpp"
#include "procam/simulate/session.hpp"
#include "rendered_board.hpp"
#include "support/test_data.hpp"

namespace procam {
namespace {

using detect::detect_chessboard;
using test::BoardScene;

cv::Mat as_mat(const ImageU8& image) {
  return cv::Mat(image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.data())).clone();
}

/// RMS a coordinate against the nearest true corner.
double rms_to_nearest(const std::vector<cv::Point2f>& found, const Points2& truth) {
  double sum = 0;
  for (const cv::Point2f& c : found) {
    double nearest = 1e9;
    for (const Vec2& t : truth) nearest = std::min(nearest, (t - Vec2(c.x, c.y)).squaredNorm());
    sum += nearest;
  }
  return std::sqrt(sum / (2 * double(found.size())));
}

/// Does the order run right-handed in the image everywhere?
bool right_handed(const Detections& d, const Chessboard& board) {
  for (int r = 0; r + 1 < board.rows; ++r)
    for (int c = 0; c + 1 < board.columns; ++c) {
      const Vec2 o = d.observations[std::size_t(r * board.columns + c)].pixel;
      const Vec2 x = d.observations[std::size_t(r * board.columns + c + 1)].pixel - o;
      const Vec2 y = d.observations[std::size_t((r + 1) * board.columns + c)].pixel - o;
      if (x.x() * y.y() - x.y() * y.x() <= 0) return false;
    }
  return true;
}

TEST(Chessboard, CornersAreRightToHundredthsWithAnHonestSigma) {
  // 126 coordinates a scene: the standard deviation of the mean of e^T C^-1 e / 2 is 0.13; outside
  // (1/2.25, 2.25), i.e. 1.5 in sigma, only if sigma is wrong (false alarm rate below 1e-6).
  for (const auto& [blur, noise] : {std::pair(0.6, 2.0), std::pair(1.5, 3.0)}) {
    BoardScene scene;
    scene.blur_px = blur;
    scene.noise = noise;
    const ImageU8 image = test::render(scene);
    const Points2 truth = test::true_corners(scene);
    const Detections found = detect_chessboard(image, scene.board);
    ASSERT_EQ(found.observations.size(), 63u);
    Vec2 bias = Vec2::Zero();
    double rms = 0, chi2 = 0;
    for (const Observation& o : found.observations) {
      const Vec2 e = o.pixel - truth[std::size_t(o.point)];
      bias += e / 63;
      rms += e.squaredNorm() / 126;
      chi2 += e.dot(o.covariance.inverse() * e) / 126;
    }
    rms = std::sqrt(rms);
    EXPECT_LT(bias.norm(), 0.005);
    EXPECT_LT(rms, 0.02);
    EXPECT_GT(chi2, 1 / 2.25);
    EXPECT_LT(chi2, 2.25);

    std::vector<cv::Point2f> peer;
    ASSERT_TRUE(cv::findChessboardCornersSB(as_mat(image), cv::Size(7, 9), peer,
                                            cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_ACCURACY));
    const double sector = rms_to_nearest(peer, truth);
    cv::cornerSubPix(as_mat(image), peer, cv::Size(5, 5), cv::Size(-1, -1), cv::TermCriteria(3, 100, 1e-4));
    const double subpix = rms_to_nearest(peer, truth);
    EXPECT_LT(2 * rms, std::min(sector, subpix))
        << "own " << rms << ", SB " << sector << ", cornerSubPix " << subpix;
  }
}

/// RMS a coordinate of the corners on the grid's rim, their mean squared error in units of its covariance, and the
/// farthest of all, pixels.
struct RimErrors {
  double rms = 0, chi2 = 0, farthest = 0;
  int count = 0;  ///< of all corners
};

RimErrors rim_errors(const BoardScene& scene) {
  const Detections found = detect_chessboard(test::render(scene), scene.board);
  const Points2 truth = test::true_corners(scene);
  RimErrors errors;
  errors.count = int(found.observations.size());
  int on_rim = 0;
  for (const Observation& o : found.observations) {
    const int column = o.point % scene.board.columns, row = o.point / scene.board.columns;
    const Vec2 e = o.pixel - truth[std::size_t(o.point)];
    errors.farthest = std::max(errors.farthest, e.norm());
    if (column > 0 && row > 0 && column < scene.board.columns - 1 && row < scene.board.rows - 1) continue;
    errors.rms += e.squaredNorm() / 2;
    errors.chi2 += e.dot(o.covariance.inverse() * e) / 2;
    ++on_rim;
  }
  errors.rms = std::sqrt(errors.rms / on_rim);
  errors.chi2 /= on_rim;
  return errors;
}

TEST(Chessboard, WithFewLargeSquaresUnderAWideLensHasItsRimAsRightAsItsSigma) {
  // The lens bends the edges by pixels, and differently one square further: bends by the neighbours alone leave rim
  // corners 0.011 px off, four times their sigma. Of 20 coordinates, chi2 above 6 has a
  // rate below 1e-9; what the renderer and the model of blur leave counts too.
  for (const double turn : {0.1, 0.2}) {
    BoardScene scene;
    scene.board = {4, 3, 0.08};
    scene.camera = {
        {640, 480}, {294.4, 296, 326, 233, 0.3}, BrownConrady{{-0.19, 0.035, 0.0006, -0.0004, 0}}};
    scene.camera_from_board = scene.facing(Vec3(0.31 + turn, -0.42, 0.13), Vec3(0.02, -0.015, 0.36));
    scene.blur_px = 0.7;
    scene.noise = 0.5;
    const RimErrors errors = rim_errors(scene);
    EXPECT_LT(errors.rms, 0.008);
    EXPECT_LT(errors.chi2, 6);
  }
}

TEST(Chessboard, ACornerAtTheImageRimDoesNotPullItsNeighbours) {
  // The first corner lies 1 px outside the image: its position is known from the search alone, and bends by it would move
  // the neighbours by 0.02 px and more. The second, 13.6 px inside, has a smaller window.
  BoardScene scene;
  scene.camera = {{640, 480}, {700, 695, 325, 235, 0.7}, BrownConrady{{-0.18, 0.07, 0.0011, -0.0008, 0}}};
  scene.camera_from_board = scene.facing(Vec3(0.43, -0.30, 0.25), Vec3(0.02, -0.015, 1.1));
  scene.blur_px = 0.8;
  scene.noise = 1;
  scene.seed = 5;
  const RimErrors errors = rim_errors(scene);
  EXPECT_EQ(errors.count, 62);
  EXPECT_LT(errors.farthest, 0.015);
}

TEST(Chessboard, CornersBesideTheBorderOfTheLightAreFittedClearOfIt) {
  // Light to the left of a border only, which crosses the windows of a column at different distances.
  BoardScene scene;
  scene.noise = 1;
  scene.camera_from_board = scene.facing(Vec3(0.12, -0.15, 0.03), Vec3(0.02, -0.015, 1.1));
  const Points2 truth = test::true_corners(scene);
  const auto at = [&](int column, int row) { return truth[std::size_t(row * scene.board.columns + column)]; };
  const double border = at(4, 4).x() + 0.38 * (at(5, 4).x() - at(4, 4).x());
  ImageU8 image = test::render(scene);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      image.at(x, y) = std::uint8_t(
          std::lround(image.at(x, y) * (0.6 - 0.4 * std::erf((x - border) / (std::sqrt(2.0) * 1.5)))));
  const Detections found = detect_chessboard(image, scene.board);
  double farthest = 0;
  int beside = 0;
  for (const Observation& o : found.observations) {
    if (o.point % scene.board.columns != 4) continue;
    farthest = std::max(farthest, (o.pixel - truth[std::size_t(o.point)]).norm());
    ++beside;
  }
  EXPECT_GE(beside, 6);  // 4 without the smaller windows
  EXPECT_LT(farthest, 0.02);
}

/// Interpolated colours displace edges by their place among the pixels, green least; a lens with lateral colour shows
/// red and blue elsewhere.
TEST(Chessboard, TheGreenOfAColourSensorKeepsCornersInPlace) {
  simulate::Conditions conditions = simulate::plain_conditions();
  conditions.colour_sensor = true;
  conditions.lateral_colour = 8e-4;
  simulate::SimulatedSession session = simulate::make_session(simulate::Level::kEasy, 3, {}, {}, conditions);
  session.capture.camera_blur_px = 0.3;  // a sharp lens
  const ImageU8 colour =
      simulate::capture_view(session, 0, {ImageU8(session.rig().projector().projector.size(), 1, 255)})
          .front();
  ASSERT_EQ(colour.channels(), 3);
  ImageU8 green(colour.size()), luma(colour.size());
  for (int y = 0; y < colour.height(); ++y)
    for (int x = 0; x < colour.width(); ++x) {
      green.at(x, y) = colour.at(x, y, 1);
      luma.at(x, y) = std::uint8_t(0.299 * colour.at(x, y, 0) + 0.587 * colour.at(x, y, 1) +
                                   0.114 * colour.at(x, y, 2) + 0.5);
    }
  std::map<int, Vec2> truth;
  for (const Observation& corner : simulate::board_in_camera(session.views.front()))
    truth[corner.point] = corner.pixel;
  const auto rms = [&](const ImageU8& image) {
    const Detections found = detect::detect_board(image, session.stated_board);
    EXPECT_EQ(found.observations.size(), truth.size());
    double sum = 0;
    for (const Observation& o : found.observations) sum += (o.pixel - truth.at(o.point)).squaredNorm();
    return std::sqrt(sum / (2 * double(found.observations.size())));
  };
  const double by_green = rms(green), by_luma = rms(luma);
  RecordProperty("green", std::to_string(by_green));
  RecordProperty("luma", std::to_string(by_luma));
  EXPECT_LT(by_green, 0.015);
  EXPECT_LT(by_green, 0.8 * by_luma);
}

/// As a camera's sharpening (unsharp mask) leaves an image: halos beside the edges, clipped where they leave the range.
ImageU8 sharpened(const ImageU8& image) {
  constexpr double kAmount = 1.5, kSigma = 1.5;
  cv::Mat grey, blurred, sharp;
  as_mat(image).convertTo(grey, CV_32F);
  cv::GaussianBlur(grey, blurred, cv::Size(), kSigma);
  cv::Mat(grey + kAmount * (grey - blurred)).convertTo(sharp, CV_8U);
  ImageU8 out(image.size());
  for (int y = 0; y < out.height(); ++y) std::copy_n(sharp.ptr<std::uint8_t>(y), out.width(), out.row(y));
  return out;
}

TEST(Chessboard, InASharpenedImageKeepsItsCornersAndTheirPrecision) {
  BoardScene scene;
  scene.blur_px = 0.6;
  scene.noise = 0.5;
  const Points2 truth = test::true_corners(scene);
  const Detections found = detect_chessboard(sharpened(test::render(scene)), scene.board);
  ASSERT_EQ(found.observations.size(), 63u);
  double rms = 0;
  for (const Observation& o : found.observations)
    rms += (o.pixel - truth[std::size_t(o.point)]).squaredNorm() / 126;
  EXPECT_LT(std::sqrt(rms), 0.015);
}

TEST(Chessboard, OfOddAndEvenCountsKeepsItsFirstCornerUnderAnyTurn) {
  for (const double turn : {0.2, 1.7, 3.1, -1.4}) {
    BoardScene scene;
    scene.board = {7, 6, 0.075};
    scene.camera_from_board = scene.facing(Vec3(0.1, -0.05, turn), Vec3(0.02, -0.015, 1.5));
    const Detections found = detect_chessboard(test::render(scene), scene.board);
    ASSERT_EQ(found.observations.size(), 42u) << turn;
    const Points2 truth = test::true_corners(scene);
    for (const Observation& o : found.observations)
      EXPECT_LT((o.pixel - truth[std::size_t(o.point)]).norm(), 0.1) << turn;
  }
}

TEST(Chessboard, ThatLooksTheSameTurnedStartsAtTheTopLeftAndIsNeverMirrored) {
  for (const Chessboard& board : {Chessboard{7, 9, 0.06}, Chessboard{6, 6, 0.075}})
    for (const double turn : {0.1, 1.8, 3.3}) {
      BoardScene scene;
      scene.board = board;
      scene.camera_from_board = scene.facing(Vec3(0.1, -0.05, turn), Vec3(0.02, -0.015, 1.5));
      const Detections found = detect_chessboard(test::render(scene), board);
      ASSERT_EQ(int(found.observations.size()), board.size()) << turn;
      EXPECT_TRUE(right_handed(found, board)) << turn;
      EXPECT_LT(found.observations.front().pixel.sum(), found.observations.back().pixel.sum()) << turn;
      const Points2 truth = test::true_corners(scene);
      double nearest = 1e9;
      for (const Vec2& t : truth) nearest = std::min(nearest, (t - found.observations.front().pixel).norm());
      EXPECT_LT(nearest, 0.1);
    }
}

TEST(Chessboard, NamesTheCountsThatAreThere) {
  const BoardScene scene;
  const ImageU8 image = test::render(scene);
  for (const Chessboard& asked :
       {Chessboard{6, 8, 0.075}, Chessboard{8, 9, 0.075}, Chessboard{5, 9, 0.075}}) {
    const Detections found = detect_chessboard(image, asked);
    EXPECT_TRUE(found.observations.empty());
    const Diagnostic* remark = found.diagnostics.find("board_counts_differ");
    ASSERT_NE(remark, nullptr) << asked.columns << "x" << asked.rows;
    EXPECT_NE(remark->message.find("7x9"), std::string::npos) << remark->message;
  }
  EXPECT_EQ(detect_chessboard(image, {9, 7, 0.075}).observations.size(), 63u)
      << "a quarter turn is the same print";
}

TEST(Chessboard, IsFoundWhereTheProjectorLightsOnlyAPartOfIt) {
  BoardScene scene;
  scene.noise = 0;
  ImageU8 image = test::render(scene);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      if (3 * x + y > 1230) image.at(x, y) = std::uint8_t(image.at(x, y) / 9);  // room light alone
  const Detections found = detect_chessboard(image, scene.board);
  EXPECT_GE(found.observations.size(), 50u);  // those on the light's border are rejected
  const Diagnostic* rejected = found.diagnostics.find("corners_left_out");
  ASSERT_NE(rejected, nullptr);  // usual, and no reason to take the view again
  EXPECT_EQ(rejected->severity, Severity::kNote);
  EXPECT_NE(rejected->message.find("border of the projected light"), std::string::npos) << rejected->message;
  const Points2 truth = test::true_corners(scene);
  for (const Observation& o : found.observations) {
    double nearest = 1e9;  // 7x9 may be read from either end
    for (const Vec2& t : truth) nearest = std::min(nearest, (t - o.pixel).norm());
    EXPECT_LT(nearest, 1.0);
  }
}

/// One half of the image in projector light, the other in room light of that share; the border runs through
/// `point` along `angle`, as sharp as the scene's blur.
ImageU8 with_frame_border(const ImageU8& image, const BoardScene& scene, const Vec2& point, double angle,
                          double room_share, double noise, std::mt19937& random) {
  std::normal_distribution<double> normal(0, noise);
  const Vec2 across(std::cos(angle), std::sin(angle));
  ImageU8 lit = image;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const double side = std::erf(across.dot(Vec2(x, y) - point) / (std::sqrt(2.) * scene.blur_px));
      const double light = 0.5 * (1 + side) + 0.5 * (1 - side) * room_share;
      lit.at(x, y) = std::uint8_t(std::lround(std::clamp(image.at(x, y) * light + normal(random), 0., 255.)));
    }
  return lit;
}

struct BorderScene {
  BoardScene scene;
  ImageU8 evenly_lit;
};

std::vector<BorderScene> border_scenes() {
  std::vector<BorderScene> scenes;
  for (const auto& [columns, rows, turn] : {std::tuple(9, 6, 0.1), std::tuple(7, 9, 1.3)}) {
    BoardScene scene;
    scene.board = {columns, rows, 0.06};
    scene.camera_from_board = scene.facing(Vec3(0.35, -0.3, turn), Vec3(0.02, -0.015, 1.4));
    scene.noise = 0;
    scenes.push_back({scene, test::render(scene)});
  }
  return scenes;
}

/// Borders of every direction through every part of the board, room light of 5 to 50 %, noise of 0.5 to 2.5
/// grey levels. Returns how many times the board was found; fails where other counts were reported.
int found_across_borders(int borders, unsigned seed) {
  const std::vector<BorderScene> scenes = border_scenes();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  int found_all = 0;
  for (int i = 0; i < borders; ++i) {
    const auto& [scene, evenly_lit] = scenes[std::size_t(i) % scenes.size()];
    const Chessboard& board = scene.board;
    // Every second border is parallel to a rim of the print and near it, where a line of crossings of light
    // and print is most alike a line of corners.
    const bool at_rim = i / 2 % 2 == 0;
    const double along = (board.columns + 1) * unit(random) - 1, down = (board.rows + 1) * unit(random) - 1;
    const double beyond = unit(random) * 2 - 1.5;  // of the rim corners, in squares
    const Vec3 in_board =
        board.square_size * (at_rim ? Vec3(along, board.rows - 1 + beyond, 0) : Vec3(along, down, 0));
    const Vec3 next = in_board + board.square_size * Vec3(1, 0, 0);
    const Vec2 point = *scene.camera.project(scene.camera_from_board * in_board),
               row = *scene.camera.project(scene.camera_from_board * next) - point;
    double angle = 2 * M_PI * unit(random);
    if (at_rim) angle = std::atan2(row.y(), row.x()) + (unit(random) < 0.5 ? 0.5 : -0.5) * M_PI;
    const double room_share = std::exp(std::log(0.05) + unit(random) * std::log(10.)),
                 noise = 0.5 + 2 * unit(random);
    const ImageU8 image = with_frame_border(evenly_lit, scene, point, angle, room_share, noise, random);
    const Detections found = detect_chessboard(image, board);
    const Diagnostic* other_counts = found.diagnostics.find("board_counts_differ");
    // In room light of a few grey levels a part of the board may not be found, and is reported as dark.
    const bool too_dark = other_counts != nullptr &&
                          other_counts->message.find(" inner corners show: light") != std::string::npos;
    EXPECT_TRUE(other_counts == nullptr || too_dark) << "border " << i << ": " << other_counts->message;
    found_all += !found.observations.empty();
  }
  return found_all;
}

TEST(Chessboard, IsFoundWithItsCountsAcrossTheBorderOfAProjectedFrame) {
  EXPECT_GE(found_across_borders(40, 5), 39);
}

/// In the long run.
TEST(ThousandBorders, LeaveTheCountsOfTheBoardAsTheyAre) {
  EXPECT_GE(found_across_borders(1000, 6), 990);
}

TEST(Chessboard, ThatIsLargerIsReportedAcrossTheBorderOfAProjectedFrame) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const auto& [scene, evenly_lit] : border_scenes()) {
    const Chessboard smaller{scene.board.columns, scene.board.rows - 1, scene.board.square_size};
    for (int i = 0; i < 8; ++i) {
      const Vec2 middle = *scene.camera.project(scene.camera_from_board *
                                                (scene.board.square_size * Vec3(3 + unit(random), 2.5, 0)));
      const ImageU8 image =
          with_frame_border(evenly_lit, scene, middle, 2 * M_PI * unit(random), 0.3, 1, random);
      const Detections found = detect_chessboard(image, smaller);
      EXPECT_TRUE(found.observations.empty()) << i;
      EXPECT_NE(found.diagnostics.find("board_counts_differ"), nullptr) << i;
    }
  }
}

TEST(Chessboard, SaysHowMuchOfItShows) {
  const BoardScene scene;
  ImageU8 image = test::render(scene);
  const Vec2 edge = 0.5 * (test::true_corners(scene)[3 * 7] + test::true_corners(scene)[4 * 7]);
  for (int y = int(edge.y()); y < image.height(); ++y)
    std::fill_n(image.row(y), image.width(), std::uint8_t(90));
  const Detections found = detect_chessboard(image, scene.board);
  EXPECT_TRUE(found.observations.empty());
  const Diagnostic* remark = found.diagnostics.find("board_counts_differ");
  ASSERT_NE(remark, nullptr);
  EXPECT_NE(remark->message.find(" of its 7x9 inner corners show"), std::string::npos) << remark->message;
}

/// A dark, tilted board at level hard: in the reduced image that is searched first its squares have 5 pixels, and false
/// crossings make a grid of the board's counts. That grid put a corner 43 px off, with a standard deviation of 0.04 px.
TEST(Chessboard, IsNotFoundInFalseCrossingsOfASmallPicture) {
  const simulate::SimulatedSession session = simulate::make_session(simulate::Level::kHard, 5);
  constexpr std::size_t kView = 6;
  const ImageSize projector = session.rig().projector().projector.size();
  const std::vector<ImageU8> captures =
      simulate::capture_view(session, kView, {ImageU8(projector, 1, 255), ImageU8(projector)});
  const Detections found = detect::detect_board(captures.front(), session.stated_board);
  std::map<int, Vec2> truth;
  for (const Observation& corner : simulate::board_in_camera(session.views[kView]))
    truth[corner.point] = corner.pixel;
  EXPECT_GT(found.observations.size(), 50u);
  for (const Observation& corner : found.observations)
    EXPECT_LT((corner.pixel - truth.at(corner.point)).norm(), 0.5) << corner.point;
}

TEST(Chessboard, SaysThatThereIsNone) {
  const ImageU8 grey(320, 240, 1, 128);
  const Detections found = detect_chessboard(grey, {7, 9, 0.075});
  EXPECT_TRUE(found.observations.empty());
  EXPECT_NE(found.diagnostics.find("board_not_found"), nullptr);
  EXPECT_THROW(detect_chessboard(ViewU8(), {7, 9, 0.075}), std::invalid_argument);
  EXPECT_THROW(detect_chessboard(grey, {2, 9, 0.075}), std::invalid_argument);
}

TEST(Chessboard, FindsEveryCornerOfRealBoards) {
  PROCAM_REQUIRE_TEST_DATA("graycode/capture_0");
  const Chessboard board{7, 9, 0.075};
  for (int i = 0; i < 5; ++i) {
    const auto file = test::test_data() / ("graycode/capture_" + std::to_string(i)) / "graycode_40.png";
    const cv::Mat image = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
    const Detections found = detect_chessboard(ViewU8(image.data, image.cols, image.rows), board);
    ASSERT_EQ(found.observations.size(), 63u) << file;
    EXPECT_TRUE(right_handed(found, board)) << file;
    EXPECT_TRUE(found.diagnostics.items.empty()) << file;
  }
}

TEST(Chessboard, CalibratesARealCameraBetterThanItsFinder) {
  PROCAM_REQUIRE_TEST_DATA("chessboard/left01.jpg");
  const Chessboard board{9, 6, 1};
  std::vector<cv::Point3f> points;
  for (const Vec3& p : points_in_board(board)) points.emplace_back(float(p.x()), float(p.y()), 0.f);
  std::vector<std::vector<cv::Point3f>> objects;
  std::vector<std::vector<cv::Point2f>> own, peer;
  for (int i = 1; i <= 14; ++i) {
    if (i == 10) continue;  // there is none
    const std::string name =
        std::string("chessboard/left") + (i < 10 ? "0" : "") + std::to_string(i) + ".jpg";
    const cv::Mat image = cv::imread((test::test_data() / name).string(), cv::IMREAD_GRAYSCALE);
    const Detections found = detect_chessboard(ViewU8(image.data, image.cols, image.rows), board);
    ASSERT_EQ(found.observations.size(), 54u) << name;
    std::vector<cv::Point2f> pixels;
    for (const Observation& o : found.observations)
      pixels.emplace_back(float(o.pixel.x()), float(o.pixel.y()));
    std::vector<cv::Point2f> by_peer;
    const int flags = cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE | cv::CALIB_CB_ACCURACY;
    if (!cv::findChessboardCornersSB(image, cv::Size(9, 6), by_peer, flags)) continue;
    objects.push_back(points), own.push_back(pixels), peer.push_back(by_peer);
  }
  ASSERT_GE(objects.size(), 10u);
  const auto rms = [&](const std::vector<std::vector<cv::Point2f>>& pixels) {
    cv::Mat k, d;
    std::vector<cv::Mat> r, t;
    return cv::calibrateCamera(objects, pixels, cv::Size(640, 480), k, d, r, t);
  };
  const double with_own = rms(own), with_peer = rms(peer);
  RecordProperty("rms_px", std::to_string(with_own));
  RecordProperty("finder_rms_px", std::to_string(with_peer));
  EXPECT_LT(with_own, with_peer);
}

}  // namespace
}  // namespace procam
