/// The figures of the calibration report, by what their SVG holds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <regex>

#include "procam/core/base/words.hpp"
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

}  // namespace
}  // namespace procam::report
