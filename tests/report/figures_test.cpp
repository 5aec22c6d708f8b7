/// The figures of the calibration report, by what their SVG holds.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <regex>

#include "procam/core/base/words.hpp"
#include "procam/io/image/images.hpp"
#include "report/calibrated_session.hpp"
#include "support/expect_error.hpp"

namespace procam::report {
namespace {

using test::CalibratedSession;
using test::contains;

/// The page's figure of this description, from <svg to its caption's end; empty when it has none.
std::string figure_of(const std::string& page, const std::string& description) {
  const std::size_t name = page.find("aria-label=\"" + description + "\"");
  if (name == std::string::npos) return "";
  const std::size_t begin = page.rfind("<svg ", name), end = page.find("</figcaption>", name);
  return page.substr(begin, end - begin);
}

std::string bytes_of_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = (bits << 6 | unsigned(digits.find(c))) & 0xffffu;
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += char(bits >> count & 0xffu);
  }
  return bytes;
}

TEST(ViewBars, AreSortedAndHaveTheirNumbers) {
  const CalibratedSession& session = test::calibrated_session();
  const std::string bars = figure_of(session.page(), "RMS by view of projector");
  ASSERT_FALSE(bars.empty());
  const std::regex tip("<title>[^<]*: ([0-9.]+) px RMS, held-out");
  std::vector<double> rms;
  for (std::sregex_iterator at(bars.begin(), bars.end(), tip), end; at != end; ++at)
    rms.push_back(std::atof((*at)[1].str().c_str()));
  ASSERT_EQ(rms.size(), session.result.views.size());
  EXPECT_TRUE(std::is_sorted(rms.rbegin(), rms.rend()));
  EXPECT_TRUE(contains(bars, "No view stands out."));
  EXPECT_FALSE(contains(bars, "class=\"rms warn\""));
}

TEST(ViewBars, ColourWhatIsSuspicious) {
  CalibratedSession session = test::calibrated_session();
  session.result.views[0].rms_px[1] *= 4;
  // A view as noisy as expected does not stand out.
  EXPECT_TRUE(contains(figure_of(session.page(), "RMS by view of projector"), "No view stands out."));
  for (calibrate::Residual& r : session.result.residuals)
    if (r.view == 0 && r.device == 1) r.whitened *= 4;
  session.result.views[2].used = false;
  session.result.views[2].note = "rejected: stale frame";
  const std::string bars = figure_of(session.page(), "RMS by view of projector");
  EXPECT_TRUE(std::regex_search(bars, std::regex("class=\"tick warn\">[^<]*view_0")));
  EXPECT_TRUE(std::regex_search(bars, std::regex("class=\"tick warn\">[0-9.]+ · [34][.0-9]* × median")));
  EXPECT_TRUE(contains(bars, "class=\"tick bad\">view_2<"));
  EXPECT_TRUE(contains(bars, "view rejected"));
  EXPECT_TRUE(contains(bars, "rejected: stale frame"));
  EXPECT_TRUE(contains(bars, "Coloured: 2 of 8 views"));
  EXPECT_FALSE(contains(figure_of(session.page(), "RMS by view of camera"), "class=\"rms warn\""));
}

/// A cell for each pixel of the grid that counts; the caption has the headline's number.
TEST(ErrorMaps, ShowBothPredictedErrors) {
  const CalibratedSession& session = test::calibrated_session();
  const std::string page = session.page();
  const analyze::LightErrors& errors = session.input.predicted.at(0);
  for (const analyze::LightError* error : {&errors.externally, &*errors.by_camera}) {
    const std::string map =
        figure_of(page, std::string("Predicted error of projector located ") + to_string(error->located));
    ASSERT_FALSE(map.empty());
    EXPECT_TRUE(contains(map, "<b>" + significant(error->rms_mm, 2) + " mm RMS</b>"));
    const std::string tip = "<title>pixel (";
    int cells = 0;
    for (std::size_t at = map.find(tip); at != std::string::npos; at = map.find(tip, at + 1)) ++cells;
    EXPECT_EQ(cells, int(std::lround(error->share * 17 * 13)));
  }
}

TEST(CorrelationMatrix, HasACellForEachVisiblePair) {
  const CalibratedSession& session = test::calibrated_session();
  const NamedCovariance& covariance = session.result.rig.covariance;
  const std::string matrix = figure_of(session.page(), "Correlation of the parameters");
  for (const std::string& name : covariance.names)
    EXPECT_TRUE(contains(matrix, ">" + name + "</text>")) << name;
  const auto n = covariance.matrix.rows();
  int visible = 0;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < i; ++j) {
      const double r = covariance.matrix(i, j) / std::sqrt(covariance.matrix(i, i) * covariance.matrix(j, j));
      if (std::abs(r) < 0.05) continue;
      ++visible;
      EXPECT_TRUE(contains(matrix, "<title>" + covariance.names[std::size_t(i)] + ", " +
                                       covariance.names[std::size_t(j)] + ": " + fixed(r, 2) + "</title>"));
    }
  int cells = 0;
  for (std::size_t at = matrix.find("<title>"); at != std::string::npos; at = matrix.find("<title>", at + 1))
    ++cells;
  EXPECT_EQ(cells, visible);
  EXPECT_GT(visible, 20);
}

/// The bars hold two numbers of every residual, and their standard deviation is near 1: the noise is estimated from them.
TEST(ResidualHistogram, CountsEveryWhitenedResidual) {
  const CalibratedSession& session = test::calibrated_session();
  double squares = 0;
  int used = 0, rejected = 0;
  for (const calibrate::Residual& r : session.result.residuals) {
    if (r.device != 1) continue;
    (r.used ? used : rejected) += 2;
    if (r.used) squares += r.whitened.squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(squares / used), 1, 0.15);
  const std::string histogram = figure_of(session.page(), "Histogram of residuals of projector");
  const auto total = [&](const std::string& bars) {
    int sum = 0;
    const std::regex bar("class=\"" + bars + "\"[^>]*><title>([0-9]+)");
    for (std::sregex_iterator at(histogram.begin(), histogram.end(), bar), end; at != end; ++at)
      sum += std::atoi((*at)[1].str().c_str());
    return sum;
  };
  EXPECT_EQ(total("rms"), used);
  EXPECT_EQ(total("rms bad"), rejected);
  EXPECT_GT(rejected, 0);
  EXPECT_TRUE(contains(histogram, "Standard deviation " + fixed(std::sqrt(squares / used), 2)));
}

/// k1 alone displaces a corner by fx k1 r^2 x; a lens without distortion has no figure.
TEST(LensDistortion, StatesItsLargestDisplacement) {
  CalibratedSession session = test::calibrated_session();
  Camera& camera = session.result.rig.cameras[0].camera;
  const double width = camera.size.width, height = camera.size.height;
  camera.intrinsics = {1000, 1000, 0.5 * (width - 1), 0.5 * (height - 1), 0};
  camera.distortion = BrownConrady{{-0.1, 0, 0, 0, 0}};
  const double r = std::hypot(width, height) / 2000;
  const std::string grid = figure_of(session.page(), "Lens distortion of camera");
  EXPECT_TRUE(contains(grid, "Max " + significant(1000 * 0.1 * r * r * r, 2) + " px"))
      << grid.substr(grid.size() - 300);
  EXPECT_TRUE(contains(grid, "class=\"arrow\""));
  camera.distortion = NoDistortion{};
  EXPECT_EQ(figure_of(session.page(), "Lens distortion of camera"), "");
}

/// Images of three views of twice the usual scale, one of a camera that the result does not have.
CalibratedSession with_images() {
  CalibratedSession session = test::calibrated_session();
  const ImageSize size = session.result.devices[0].size;
  for (const int v : {0, 2, 4}) {
    ImageU8 image(size.width / 4, size.height / 4);
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x) image.at(x, y) = std::uint8_t(x + y);
    session.input.images.push_back({session.result.views[std::size_t(v)].name, "camera", image, 4});
  }
  session.input.images.push_back({session.result.views[1].name, "unknown", ImageU8(8, 8), 4});
  return session;
}

TEST(Captures, ShowFoundAndRejectedPoints) {
  const CalibratedSession session = with_images();
  const std::string page = session.page();
  EXPECT_EQ(test::calibrated_session().page().find("Capture of"), std::string::npos);
  int found = 0;
  for (const calibrate::Residual& r : session.result.residuals)
    found += r.view == 2 && r.device == 0 && r.used;
  const std::string capture = figure_of(page, "Capture of camera in view_2");
  int circles = 0;
  for (std::size_t at = capture.find("<circle"); at != std::string::npos;
       at = capture.find("<circle", at + 1))
    ++circles;
  EXPECT_EQ(circles, found);
  EXPECT_TRUE(contains(capture, "class=\"rejected\""));
  EXPECT_TRUE(contains(capture, std::to_string(found) + " points, 1 rejected"));
  EXPECT_FALSE(contains(figure_of(page, "Capture of camera in view_4"), "class=\"rejected\""));
  EXPECT_EQ(page.find("Capture of unknown"), std::string::npos);
}

/// The image in the page is the JPEG of the preview, and fills the camera's pixels.
TEST(Captures, HoldTheImageItself) {
  const CalibratedSession session = with_images();
  const std::string capture = figure_of(session.page(), "Capture of camera in view_4");
  const ImageSize size = session.result.devices[0].size;
  EXPECT_TRUE(contains(capture, "width=\"" + std::to_string(size.width) + "\" height=\"" +
                                    std::to_string(size.height) + "\""));
  const std::string open = "data:image/jpeg;base64,";
  const std::size_t begin = capture.find(open) + open.size();
  const ImageU8 image =
      io::read_image(bytes_of_base64(capture.substr(begin, capture.find('"', begin) - begin)),
                     "the page's image")
          .image;
  const ImageU8& given = session.input.images[2].image;
  ASSERT_EQ(image.size(), given.size());
  EXPECT_NEAR(image.at(10, 20), given.at(10, 20), 4);
  EXPECT_NEAR(image.at(60, 40), given.at(60, 40), 4);
}

/// Columns left, from blue over green to red; rows right; grey where nothing was decoded.
TEST(Captures, ShowDecodedPixelsInFalseColour) {
  CalibratedSession session = with_images();
  EXPECT_FALSE(contains(session.page(), "Decoded columns"));
  ViewImage& image = session.input.images[2];
  const int width = image.image.width(), height = image.image.height();
  const ImageSize projector = session.result.devices[1].size;
  image.decoded = ImageF(width, height, 2, -1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width / 2; ++x) {
      image.decoded.at(x, y, 0) = float(projector.width) * (x < width / 4 ? 0.02F : 0.52F);
      image.decoded.at(x, y, 1) = float(projector.height) * 0.9F;
    }
  const std::string page = session.page();
  EXPECT_TRUE(contains(page, "grey where nothing was decoded"));
  EXPECT_EQ(page.find("Decoded columns and rows of camera in view_2"), std::string::npos);
  const std::string figure = figure_of(page, "Decoded columns and rows of camera in view_4");
  const std::string open = "data:image/jpeg;base64,";
  const std::size_t begin = figure.find(open) + open.size();
  const ImageU8 shown = io::read_image(bytes_of_base64(figure.substr(begin, figure.find('"', begin) - begin)),
                                       "the page's image")
                            .image;
  ASSERT_EQ(shown.size(), (ImageSize{2 * width, height}));
  const auto channels = [&](int x, int y) {
    return std::array<int, 3>{shown.at(x, y, 0), shown.at(x, y, 1), shown.at(x, y, 2)};
  };
  const auto blue = channels(width / 8, height / 2), green = channels(3 * width / 8, height / 2),
             none = channels(3 * width / 4, height / 2), red = channels(width + width / 4, height / 2);
  EXPECT_TRUE(blue[2] > 200 && blue[0] < 60 && blue[1] < 80) << blue[0] << " " << blue[1] << " " << blue[2];
  EXPECT_TRUE(green[1] > 200 && green[0] < 90 && green[2] < 60) << green[0] << " " << green[1];
  EXPECT_NEAR(none[0], none[1], 6);
  EXPECT_NEAR(none[0], 60, 10);
  EXPECT_TRUE(red[0] > 150 && red[1] < 120 && red[2] < 60) << red[0] << " " << red[1] << " " << red[2];
}

TEST(Captures, AreTwelveAtMostTheRejectedFirst) {
  CalibratedSession session = test::calibrated_session();
  session.result.views[5].used = false;
  for (int copy = 0; copy < 2; ++copy)
    for (const calibrate::ViewResult& view : session.result.views)
      session.input.images.push_back({view.name, "camera", ImageU8(40, 30, 1, 90), 32});
  const std::string page = session.page();
  int captures = 0;
  for (std::size_t at = page.find("Capture of"); at != std::string::npos;
       at = page.find("Capture of", at + 1))
    ++captures;
  EXPECT_EQ(captures, 12);
  EXPECT_EQ(page.find("Capture of"), page.find("Capture of camera in view_5"));
  EXPECT_TRUE(contains(page, " 4 images of better views are not shown."));
}

/// A projector that moved by 3 mm along the wall: 3 mm at every pixel; a principal point 2 px off: 2 px.
TEST(RigChange, MapsTheLightAndTheLenses) {
  CalibratedSession session = test::calibrated_session();
  EXPECT_FALSE(contains(session.page(), "Change from the earlier rig"));
  session.input.earlier = session.result.rig;
  RigProjector& moved = session.input.earlier->projectors[0];
  moved.rig_from_projector.translation += moved.rig_from_projector.rotate(Vec3(3e-3, 0, 0));
  session.input.earlier->cameras[0].camera.intrinsics.cx += 2;
  const std::string page = session.page();
  const std::string light = figure_of(page, "Change of the light of projector");
  EXPECT_TRUE(contains(light, "<b>3.0 mm RMS</b> on a wall at 2\u00a0m"));
  EXPECT_TRUE(contains(light, "pixel (0, 0): 3.0 mm"));
  EXPECT_TRUE(contains(figure_of(page, "Change of the lens of camera"), "<b>2.0 px RMS</b>"));
  session.input.earlier->projectors.clear();
  session.input.earlier->cameras[0].name = "other";
  EXPECT_TRUE(contains(session.page(), "no device of the same name and size"));
}

}  // namespace
}  // namespace procam::report
