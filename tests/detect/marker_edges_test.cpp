#include "procam/detect/marker_edges.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <fstream>
#include <map>
#include <opencv2/aruco.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <sstream>

#include "procam/core/geometry/se3.hpp"
#include "procam/simulate/marker_view.hpp"
#include "support/test_data.hpp"

namespace procam::detect {
namespace {

constexpr double kSize = 0.16;
constexpr int kId = 3;

Camera lopsided_camera() {
  return {{360, 300}, {905, 893, 171, 166, 0.7}, BrownConrady{{-0.18, 0.07, 0.0011, -0.0008, 0}}};
}

const MarkerCells& apriltag() {
  static const MarkerCells codes = marker_cells(MarkerDictionary::kAprilTag36h11);
  return codes;
}

/// Turned any way round, tilted by up to 40 degrees, its middle somewhere near the image's.
Pose random_pose(std::mt19937_64& random, double distance = 1.1) {
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const Vec3 tilt(uniform(-0.5, 0.5), uniform(-0.5, 0.5), 0);
  return Pose(so3_exp(tilt) * so3_exp(Vec3(0, 0, uniform(-3.1, 3.1))),
              Vec3(uniform(-0.05, 0.05), uniform(-0.05, 0.03), distance));
}

std::array<Vec2, 4> true_corners(const Camera& camera, const Pose& pose) {
  std::array<Vec2, 4> corners;
  for (std::size_t i = 0; i < 4; ++i)
    corners[i] =
        *camera.project(pose * Vec3(marker_corners()[i].x() * kSize, marker_corners()[i].y() * kSize, 0));
  return corners;
}

ImageU8 render(const Camera& camera, const Pose& pose, double blur, std::uint64_t seed) {
  simulate::MarkerViewOptions options;
  options.blur_px = blur;
  options.seed = seed;
  return simulate::marker_view(camera, pose, {{kId, kSize, Pose()}}, apriltag(), options);
}

cv::Mat as_mat(ImageU8& image) {
  return cv::Mat(image.height(), image.width(), CV_8U, image.row(0));
}

ImageU8 load_gray(const std::filesystem::path& path) {
  const cv::Mat mat = cv::imread(path.string(), cv::IMREAD_GRAYSCALE);
  ImageU8 image(mat.cols, mat.rows);
  mat.copyTo(as_mat(image));
  return image;
}

/// Errors over many renders: procam's corners and cornerSubPix's, started from the truth.
struct Errors {
  Vec2 mean = Vec2::Zero();
  double rms = 0, inwards = 0;  ///< rms a coordinate
  double chi2 = 0;
  double subpix_rms = 0, subpix_inwards = 0;
};

Errors errors_over(int images, double blur, double gamma) {
  const Camera camera = lopsided_camera();
  std::mt19937_64 random(17);
  Errors sum;
  for (int i = 0; i < images; ++i) {
    const Pose pose = random_pose(random);
    ImageU8 image = render(camera, pose, blur, std::uint64_t(i));
    if (gamma != 1)
      for (int y = 0; y < image.height(); ++y)
        for (int x = 0; x < image.width(); ++x)
          image.at(x, y) = std::uint8_t(std::lround(255 * std::pow(image.at(x, y) / 255.0, gamma)));
    const MarkerDetections found = detect_marker_edges(image, apriltag(), {camera});
    EXPECT_EQ(found.markers.size(), 1u) << i;
    if (found.markers.size() != 1 || found.markers[0].edges.empty()) {
      ADD_FAILURE() << "image " << i << ": no edges";
      continue;
    }
    const SeenMarker& marker = found.markers[0];
    EXPECT_EQ(marker.id, kId);
    const std::array<Vec2, 4> truth = true_corners(camera, pose);
    const Vec2 middle = *camera.project(pose.translation);
    Eigen::Matrix<double, 8, 1> error;
    std::vector<cv::Point2f> subpix;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec2 e = marker.corners[k] - truth[k];
      error.segment<2>(2 * Eigen::Index(k)) = e;
      sum.mean += e / (4.0 * images);
      sum.rms += e.squaredNorm() / (8.0 * images);
      sum.inwards += e.dot((middle - truth[k]).normalized()) / (4.0 * images);
      subpix.push_back({float(truth[k].x()), float(truth[k].y())});
    }
    cv::cornerSubPix(as_mat(image), subpix, {5, 5}, {-1, -1},
                     {cv::TermCriteria::EPS + cv::TermCriteria::COUNT, 50, 1e-4});
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec2 e = Vec2(subpix[k].x, subpix[k].y) - truth[k];
      sum.subpix_rms += e.squaredNorm() / (8.0 * images);
      sum.subpix_inwards += e.dot((middle - truth[k]).normalized()) / (4.0 * images);
    }
    sum.chi2 += error.dot(marker.covariance.ldlt().solve(error));
  }
  sum.rms = std::sqrt(sum.rms);
  sum.subpix_rms = std::sqrt(sum.subpix_rms);
  return sum;
}

TEST(MarkerCells, AreThoseOfEveryDictionary) {
  for (const MarkerDictionaryInfo& row : kMarkerDictionaries) {
    const MarkerCells codes = marker_cells(row.dictionary);
    EXPECT_EQ(codes.per_side, row.bits) << row.name;
    EXPECT_EQ(int(codes.white.size()), row.count) << row.name;
    // As drawn: one pixel a cell, the black border round them.
    cv::Mat drawn;
    const int id = row.count - 1;
    cv::aruco::drawMarker(cv::aruco::getPredefinedDictionary(int(row.dictionary)), id, row.bits + 2, drawn);
    for (int r = 0; r < row.bits + 2; ++r)
      for (int c = 0; c < row.bits + 2; ++c) {
        // OpenCV draws AprilTags half a turn from their authors' pictures.
        const bool turned = row.dictionary >= MarkerDictionary::kAprilTag16h5;
        const int last = row.bits + 1;
        EXPECT_EQ(codes.is_white(id, r - 1, c - 1),
                  drawn.at<uchar>(turned ? last - r : r, turned ? last - c : c) > 127)
            << row.name;
      }
  }
}

TEST(MarkerDictionary, IsKnownByName) {
  for (const MarkerDictionaryInfo& row : kMarkerDictionaries)
    EXPECT_EQ(marker_dictionary_named(row.name), row.dictionary);
  EXPECT_FALSE(marker_dictionary_named("april"));
}

TEST(Markers, CornersKeepThePixelConventionTurnedAnyWay) {
  for (const double blur : {0.6, 1.1}) {
    const Errors errors = errors_over(24, blur, 1);
    EXPECT_LT(errors.mean.norm(), 0.004) << blur;
    EXPECT_LT(std::abs(errors.inwards), 0.004) << blur;
    EXPECT_LT(errors.rms, 0.012) << blur;
    EXPECT_GT(errors.subpix_rms, 8 * errors.rms) << blur;
    // 192 coordinates: chi-square with sigma 19.6. Upper bound at 4 sigma (false alarm 1e-4 with the skew),
    // lower bound a third: the noise is estimated from residuals that hold a little of everything.
    EXPECT_LT(errors.chi2, 192 + 4 * 19.6) << blur;
    EXPECT_GT(errors.chi2, 192 / 3.) << blur;
  }
}

TEST(Markers, GammaMovesNoCorner) {
  const Errors errors = errors_over(16, 0.8, 0.45);
  EXPECT_GT(errors.subpix_inwards, 0.3);  // so much a blurred corner shrinks
  EXPECT_LT(std::abs(errors.inwards), 0.01);
  EXPECT_LT(errors.rms, 0.02);
}

TEST(Markers, WhatAHandCoversIsLeftOut) {
  const Camera camera = lopsided_camera();
  std::mt19937_64 random(3);
  for (int i = 0; i < 6; ++i) {
    const Pose pose = random_pose(random);
    ImageU8 image = render(camera, pose, 0.7, std::uint64_t(i));
    // A grey finger over a third of one side from outside, its tip on the border.
    cv::Mat mat = as_mat(image);
    const auto at = [&](double x, double y) {
      const Vec2 p = *camera.project(pose * Vec3(x * kSize, y * kSize, 0));
      return cv::Point(int(p.x()), int(p.y()));
    };
    const std::vector<cv::Point> finger{at(-0.1, -0.62), at(0.12, -0.62), at(0.12, -0.44), at(-0.1, -0.44)};
    cv::fillConvexPoly(mat, finger, cv::Scalar(90), cv::LINE_AA);
    const MarkerDetections found = detect_marker_edges(image, apriltag(), {camera});
    ASSERT_EQ(found.markers.size(), 1u) << i;
    ASSERT_FALSE(found.markers[0].edges.empty()) << i;
    const std::array<Vec2, 4> truth = true_corners(camera, pose);
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_LT((found.markers[0].corners[k] - truth[k]).norm(), 0.05) << i << ' ' << k;
  }
}

TEST(Markers, OneTooSmallForEdgesIsFittedAsAWhole) {
  const Camera camera = lopsided_camera();
  std::mt19937_64 random(5);
  int read = 0;
  double chi2 = 0;
  for (int i = 0; i < 8; ++i) {
    const Pose pose = random_pose(random, 5.5);  // 26 px wide, cells of 3 px
    const MarkerDetections found =
        detect_marker_edges(render(camera, pose, 1.0, std::uint64_t(i)), apriltag(), {camera});
    if (found.markers.empty()) continue;
    ++read;
    const SeenMarker& marker = found.markers[0];
    EXPECT_TRUE(marker.edges.empty() && !marker.coarse);
    Eigen::Matrix<double, 8, 1> error;
    for (std::size_t k = 0; k < 4; ++k) {
      error.segment<2>(2 * Eigen::Index(k)) = marker.corners[k] - true_corners(camera, pose)[k];
      EXPECT_LT(error.segment<2>(2 * Eigen::Index(k)).norm(), 0.2);  // the detector's are off by 0.5
    }
    chi2 += error.dot(marker.covariance.ldlt().solve(error));
  }
  ASSERT_GE(read, 4);
  // 8 numbers each: chi-square, mean 8 and sigma 4 a marker; 5 sigma (false alarm 1e-5 with the skew).
  EXPECT_LT(chi2, 8 * read + 5 * 4 * std::sqrt(read));
}

TEST(Markers, AWhiteRimOfOneCellSufficesOnADarkWall) {
  const MarkerCells cells = apriltag();
  for (int side = 5; side <= 20; ++side) {  // pixels of a cell
    const int across = side * (cells.per_side + 4);
    ImageU8 image(across + 61, across + 74, 1);
    std::mt19937_64 random(static_cast<std::uint64_t>(side));
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x) {
        int white = 0;  // of nine: the blur of a lens
        const auto cell = [&](int pixel) { return (pixel + 4 * side) / side - 6; };
        for (int k = 0; k < 9; ++k) {
          const int px = x - 31 + k % 3, py = y - 39 + k / 3;
          const bool in_rim = px >= 0 && py >= 0 && px < across && py < across;
          white += in_rim ? (cells.is_white(kId, cell(py), cell(px)) ? 210 : 25) : 90;
        }
        image.at(x, y) = std::uint8_t(white / 9 + int(random() % 5));
      }
    const MarkerDetections found = detect_marker_edges(image, cells);
    ASSERT_EQ(found.markers.size(), 1u) << side;
    EXPECT_EQ(found.markers[0].id, kId);
    EXPECT_NEAR((found.markers[0].corners[0] - Vec2(29.5 + side, 37.5 + side)).norm(), 0, 2.0) << side;
  }
}

TEST(Markers, NothingFoundIsSaid) {
  const MarkerDetections found = detect_marker_edges(ImageU8(64, 50, 1, 128), apriltag());
  EXPECT_TRUE(found.markers.empty());
  EXPECT_NE(found.diagnostics.find("markers_not_found"), nullptr);
  EXPECT_EQ(found.image_size, (ImageSize{64, 50}));
  EXPECT_THROW(detect_marker_edges(ImageU8(64, 50, 3), apriltag()), std::invalid_argument);
  EXPECT_THROW(detect_marker_edges(ImageU8(64, 50), apriltag(), {lopsided_camera()}), std::invalid_argument);
}

TEST(Markers, RefusesAFileThatIsNoDictionary) {
  const std::filesystem::path path = std::filesystem::temp_directory_path() / "procam_no_dictionary.yml";
  for (const std::string text :
       {"", "%YAML:1.0\nnmarkers: 2\nmarkersize: 4\nmarker_0: \"01\"\n", "\x01\x02"}) {
    std::ofstream(path, std::ios::binary) << text;
    EXPECT_THROW(load_marker_cells(path), Error) << text;
  }
  std::filesystem::remove(path);
  EXPECT_THROW(load_marker_cells(path), Error);
}

/// Rows of gold_corners.csv: the corners of OpenCV's own tutorial test, whole pixels.
TEST(MarkersOnPhotographs, FindsAll71GoldMarkers) {
  PROCAM_REQUIRE_TEST_DATA("aruco/gold_corners.csv");
  const std::filesystem::path folder = test::test_data() / "aruco";
  struct Gold {
    int id;
    std::array<Vec2, 4> corners;
  };
  std::map<std::pair<std::string, std::string>, std::vector<Gold>> images;
  std::ifstream file(folder / "gold_corners.csv");
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::stringstream row(line);
    std::string image, dictionary, number;
    std::getline(row, image, ',');
    std::getline(row, dictionary, ',');
    Gold gold;
    std::getline(row, number, ',');
    gold.id = std::stoi(number);
    for (Vec2& corner : gold.corners)
      for (int axis = 0; axis < 2; ++axis) {
        std::getline(row, number, ',');
        corner[axis] = std::stod(number);
      }
    images[{image, dictionary}].push_back(gold);
  }
  int found = 0, total = 0, with_edges = 0, fitted = 0;
  double worst = 0;
  Vec2 mean = Vec2::Zero();
  for (const auto& [name, golds] : images) {
    const std::string stem = name.first == "chocclusion" ? "chocclusion_original" : name.first;
    std::string dictionary = name.second;
    for (char& c : dictionary) c = c == 'X' ? 'x' : c;
    const bool own = dictionary.rfind("DICT_", 0) != 0;
    const MarkerCells codes = own ? load_marker_cells(folder / "tutorial_dict.yml")
                                  : marker_cells(*marker_dictionary_named(dictionary.substr(5)));
    const MarkerDetections detections = detect_marker_edges(load_gray(folder / (stem + ".jpg")), codes);
    for (const Gold& gold : golds) {
      ++total;
      for (const SeenMarker& marker : detections.markers) {
        if (marker.id != gold.id) continue;
        ++found;
        with_edges += !marker.edges.empty();
        fitted += !marker.coarse;
        for (std::size_t k = 0; k < 4; ++k) {
          worst = std::max(worst, (marker.corners[k] - gold.corners[k]).norm());
          mean += (marker.corners[k] - gold.corners[k]) / (4 * 71.0);
        }
      }
    }
  }
  EXPECT_EQ(total, 71);
  EXPECT_EQ(found, 71);
  std::cout << found << " of " << total << " found, " << with_edges << " by edges, " << fitted
            << " fitted, worst corner " << worst << " px, mean offset " << mean.transpose() << " px\n";
  EXPECT_GE(fitted, 60);  // to edges, or where cells are small to all pixels
  // Theirs are whole pixels of the contour inside the black: up to 0.7 px inwards, 0.7 px by rounding, and
  // their own tolerance of 1 px.
  EXPECT_LT(worst, 2.4);
  EXPECT_LT(mean.norm(), 0.2);
}

/// AprilTag's own detections, in its convention: pixel corners at integers, so half a pixel more than ours.
/// Several tags of one id hang in each photograph, of which we give the largest.
TEST(MarkersOnPhotographs, AgreesWithAprilTagBesideTheConvention) {
  PROCAM_REQUIRE_TEST_DATA("apriltag");
  const std::filesystem::path folder = test::test_data() / "apriltag";
  int images = 0;
  for (const char* stem :
       {"33369213973_9d9bb4cc96_c", "34085369442_304b6bafd9_c", "34139872896_defdb2f8d9_c"}) {
    const MarkerDetections detections =
        detect_marker_edges(load_gray(folder / (std::string(stem) + ".jpg")), apriltag());
    std::vector<Vec2> theirs;
    std::ifstream file(folder / (std::string(stem) + ".txt"));
    std::string line;
    while (std::getline(file, line)) {
      for (char& c : line)
        if (c == ',' || c == '(' || c == ')') c = ' ';
      std::stringstream row(line);
      int id = 0;
      Vec2 corner;
      row >> id;
      while (row >> corner.x() >> corner.y()) theirs.push_back(corner);
    }
    for (const SeenMarker& marker : detections.markers) {
      Vec2 offset = Vec2::Zero();
      for (const Vec2& ours : marker.corners) {
        Vec2 best(1e9, 0);
        for (const Vec2& corner : theirs)
          if ((corner - ours).norm() < best.norm()) best = corner - ours;
        offset += best / 4;
      }
      // Theirs begin at the print's bottom left and run counter-clockwise: the fourth is the top left.
      double nearest = 1e9;
      for (std::size_t i = 0; i + 3 < theirs.size(); i += 4)
        nearest = std::min(nearest, (theirs[i + 3] - marker.corners[0]).norm());
      EXPECT_LT(nearest, 3) << stem;
      std::cout << stem << ": marker " << marker.id << ", " << marker.edges.size() << " edges, offset "
                << offset.transpose() << " px\n";
      if (marker.edges.empty()) continue;
      EXPECT_LT((offset - Vec2(0.5, 0.5)).norm(), 0.3) << stem;
      ++images;
    }
  }
  EXPECT_GE(images, 1);
}

}  // namespace
}  // namespace procam::detect
