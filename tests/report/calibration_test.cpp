#include "procam/report/calibration.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <clocale>
#include <cmath>
#include <cstdio>
#include <limits>
#include <locale>
#include <regex>
#include <vector>

#include "procam/core/base/words.hpp"
#include "report/calibrated_session.hpp"
#include "report/page_data.hpp"

namespace procam::report {
namespace {

using analyze::LightErrors;
using analyze::NextView;
using analyze::predicted_error_check;
using analyze::SurfaceLocated;
using calibrate::CalibrationResult;

using Session = test::CalibratedSession;

const Session& good_session() {
  return test::calibrated_session();
}

std::string page_of(const Session& session) {
  return session.page();
}

bool holds(const std::string& page, const std::string& text) {
  return page.find(text) != std::string::npos;
}

std::string with_decimals(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

/// The page without the bodies of <script> and <style>, whose '<' opens no tag.
std::string without_code(const std::string& page) {
  std::string out = page;
  for (const std::string name : {"script", "style"}) {
    EXPECT_NE(out.find("<" + name), std::string::npos);
    for (std::size_t at = out.find("<" + name); at != std::string::npos; at = out.find("<" + name, at + 1)) {
      const std::size_t begin = out.find('>', at) + 1, end = out.find("</" + name + ">", begin);
      EXPECT_NE(end, std::string::npos);
      out.erase(begin, end - begin);
    }
  }
  return out;
}

/// Empty when every tag is closed by its own end tag, in order; else what is wrong.
std::string imbalance(const std::string& page) {
  std::vector<std::string> open;
  const std::string html = without_code(page);
  for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    if (end == std::string::npos) return "unfinished tag";
    const std::string tag = html.substr(at + 1, end - at - 1);
    if (tag.find('<') != std::string::npos) return "a '<' inside <" + tag + ">";
    const std::string name = tag.substr(0, tag.find_first_of(" \n"));
    if (name == "!doctype" || name == "meta" || tag.back() == '/') continue;
    if (name[0] != '/') {
      open.push_back(name);
    } else if (open.empty() || "/" + open.back() != name) {
      return "<" + name + "> closes " + (open.empty() ? "nothing" : "<" + open.back() + ">");
    } else {
      open.pop_back();
    }
  }
  return open.empty() ? "" : "<" + open.back() + "> stays open";
}

bool prints_nan(const std::string& page) {
  return std::regex_search(without_code(page),
                           std::regex("(^|[^a-z])-?(nan|inf)([^a-z]|$)", std::regex::icase));
}

TEST(Report, OpensWithTheVerdict) {
  const std::string page = page_of(good_session());
  ASSERT_TRUE(good_session().result.rig.quality.passed());
  EXPECT_TRUE(holds(page, "Passed.</strong> All " +
                              std::to_string(good_session().result.rig.quality.gates.size()) +
                              " quality checks passed"));
  EXPECT_LT(page.find("Passed."), page.find("<table"));
  EXPECT_FALSE(holds(page, "class=\"verdict failed\""));
}

TEST(Report, OfAFailedGateSaysWhyAndWhatToDo) {
  Session session = good_session();
  session.result.rig.quality.gates[3].passed = false;
  session.result.rig.quality.gates[3].detail = "fx/fy 1.3 > 1.04: switch <keystone> off";
  const std::string page = page_of(session);
  EXPECT_TRUE(holds(page, "Failed.</strong> 1 of " + std::to_string(session.result.rig.quality.gates.size()) +
                              " quality checks failed."));
  EXPECT_TRUE(holds(page, "<b>" + session.result.rig.quality.gates[3].name +
                              "</b>: fx/fy 1.3 &gt; 1.04: switch &lt;keystone&gt; off</li>"));
  EXPECT_FALSE(holds(page, "Passed."));
}

/// The rig's numbers are sound, the error is too large: amber, with the way out.
TEST(Report, OfAnImpreciseRigSaysThatItIsUsableAndNamesTheNextView) {
  Session session = good_session();
  session.input.accepted.rms_mm = 0.01;
  session.result.rig.quality.gates.push_back(
      predicted_error_check(session.result.rig, session.input.predicted.front(), session.input.accepted));
  session.input.next_view =
      NextView{Pose(), 0.9, "0.90 m away", session.input.predicted.front(), session.input.predicted.front()};
  const std::string page = page_of(session);
  EXPECT_TRUE(holds(page, "Usable, but imprecise.</strong>"));
  EXPECT_TRUE(holds(page, "(accepted: 0.01 mm). Add the view below."));
  EXPECT_TRUE(holds(page, "class=\"verdict imprecise\""));
  EXPECT_FALSE(holds(page, "Passed."));
  EXPECT_FALSE(holds(page, "Failed."));
  session.result.rig.quality.gates[3].passed = false;  // now its numbers are suspect
  EXPECT_TRUE(holds(page_of(session), "Failed.</strong> 2 of"));
}

/// Both kinds are there; the first figure of the page is the one that was selected.
TEST(Report, LeadsWithTheErrorThatWasSelected) {
  Session session = good_session();
  const auto first_figure = [](const std::string& page) {
    const std::size_t key = page.find("class=\"key\""), from = page.find("<span>", key) + 6;
    return page.substr(from, page.find("</span>", from) - from);
  };
  EXPECT_EQ(first_figure(page_of(session)), "predicted error at 2\u00a0m (RMS), surface located externally");
  session.input.accepted.located = SurfaceLocated::kByCamera;
  EXPECT_EQ(first_figure(page_of(session)), "predicted error at 2\u00a0m (RMS), surface located by camera");
}

/// Thirty notes do not push the figures down: they come after, folded, every one of them.
TEST(Report, FoldsNotes) {
  Session session = good_session();
  for (int i = 0; i < 30; ++i)
    session.result.diagnostics.note("row_range", "decoded row codes 2.." + std::to_string(700 + i));
  session.result.diagnostics.warn("saturated", "too bright");
  const std::string page = page_of(session);
  const std::size_t figure = page.find("<figure"), warning = page.find("too bright"),
                    folded = page.find("<details>"), note = page.find("decoded row codes 2..700");
  EXPECT_LT(figure, warning);
  EXPECT_LT(warning, folded);
  EXPECT_LT(folded, note);
  EXPECT_LT(page.find("decoded row codes 2..729"), page.find("</details>", folded));
}

TEST(Report, OfASolveThatDidNotConvergeFails) {
  Session session = good_session();
  session.result.converged = false;
  EXPECT_TRUE(holds(page_of(session), "did not converge"));
  EXPECT_FALSE(holds(page_of(session), "Passed."));
}

/// "name | value | sigma": the row of that name in a device's table.
std::string row_of(const std::string& name, double value, double sigma, int decimals) {
  return "<tr><td>" + name + "</td><td class=\"n\">" + with_decimals(value, decimals) +
         "</td><td class=\"n\">" + with_decimals(sigma, decimals) + "</td>";
}

TEST(Report, HasEveryNumberWithItsSigma) {
  const Session& session = good_session();
  const std::string page = page_of(session);
  const Rig& rig = session.result.rig;
  const auto decimals = [](double sigma) { return std::max(0, 1 - int(std::floor(std::log10(sigma)))); };
  int rows = 0;
  for (const auto& [device, lens] : {std::pair("camera", rig.camera().camera),
                                     std::pair("projector", rig.projector().projector.inverse_camera)}) {
    const std::vector<std::string> names = parameter_names(lens);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const double sigma = rig.covariance.sigma(device + ("." + names[i]));
      if (sigma == 0) continue;  // held
      EXPECT_TRUE(holds(page, row_of(names[i], parameters_of(lens)[Eigen::Index(i)], sigma, decimals(sigma))))
          << device << " " << names[i];
      ++rows;
    }
  }
  EXPECT_EQ(rows, 20);  // fx fy cx cy skew k1 k2 p1 p2 k3 of both

  const Projector& projector = rig.projector().projector;
  const double sigma_throw = rig.covariance.sigma("projector.fx") / 1024,
               sigma_shift = 100 * rig.covariance.sigma("projector.cy") / 768;
  EXPECT_TRUE(
      holds(page, row_of("throw ratio", projector.throw_ratio(), sigma_throw, decimals(sigma_throw))));
  EXPECT_TRUE(holds(
      page, row_of("lens shift down", 100 * projector.lens_shift().y(), sigma_shift, decimals(sigma_shift))));
  const auto px = [](double value) { return with_decimals(value, 3); };
  const auto mm = [](double value) { return with_decimals(value, 1 - int(std::floor(std::log10(value)))); };
  for (std::size_t d = 0; d < 2; ++d) {
    EXPECT_TRUE(holds(page, "<td class=\"n\">" + px(session.result.rms_px[d]) + "</td><td class=\"n\">" +
                                px(session.result.holdout_px[d]) + "</td>"));
  }
  EXPECT_TRUE(holds(page, "<b>" + px(session.result.joint_rms_px) + " px</b>"));
  for (const LightErrors& errors : {session.input.predicted[0], session.input.truth[0]}) {
    EXPECT_TRUE(holds(page, "<b>" + mm(errors.externally.rms_mm) + " mm</b>"));
    EXPECT_TRUE(holds(page, "<b>" + mm(errors.by_camera.value().rms_mm) + " mm</b>"));
  }
}

/// The page's sigmas of the rotation vector and the origin are the spread of rigs drawn from the covariance,
/// here by central differences of what the page shows.
TEST(Report, PoseSigmasAreThoseOfTheNumbersShown) {
  const Session& session = good_session();
  const Rig& rig = session.result.rig;
  const Pose& pose = rig.projector().rig_from_projector;
  const Mat6 c = rig.covariance.block(pose_increment_names("rig_from_projector"));
  Mat6 shown_by_increment;  // [rotation vector, origin] by the left increment
  const double h = 1e-5;
  for (int i = 0; i < 6; ++i) {
    Vec6 xi = Vec6::Zero();
    xi[i] = h;
    const Pose a = se3_exp<double>(xi) * pose, b = se3_exp<double>(-xi) * pose;
    shown_by_increment.col(i) << (so3_log(a.rotation) - so3_log(b.rotation)) / (2 * h),
        (a.translation - b.translation) / (2 * h);
  }
  const Mat6 shown = shown_by_increment * c * shown_by_increment.transpose();
  const std::string page = page_of(session);
  const auto decimals = [](double sigma) { return std::max(0, 1 - int(std::floor(std::log10(sigma)))); };
  const double degrees = 1 / kDegree;
  const std::string axes[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    const double turn = degrees * std::sqrt(shown(i, i)), shift = 1e3 * std::sqrt(shown(3 + i, 3 + i));
    EXPECT_TRUE(holds(page, row_of("rotation about " + axes[i], degrees * so3_log(pose.rotation)[i], turn,
                                   decimals(turn))));
    EXPECT_TRUE(
        holds(page, row_of("position " + axes[i], 1e3 * pose.translation[i], shift, decimals(shift))));
  }
}

TEST(Report, LoadsNothingFromAnywhere) {
  const std::string page = page_of(good_session());
  for (const std::string outside : {"http:", "https:", "src=", "@import", "url("})
    EXPECT_FALSE(holds(page, outside)) << outside;
  // A link leads within the page, an image stands in its own address.
  for (std::size_t at = page.find("href="); at != std::string::npos; at = page.find("href=", at + 1))
    EXPECT_TRUE(std::regex_search(page.substr(at, 40), std::regex("^href=\"(#|data:image/jpeg;base64,)")));
  EXPECT_TRUE(holds(page, "default-src 'none'"));
}

TEST(Report, LinksToItsSections) {
  const std::string page = page_of(good_session());
  const std::regex heading("<section id=\"([^\"]*)\">\n<h2>([^<]*)</h2>");
  int sections = 0;
  for (std::sregex_iterator at(page.begin(), page.end(), heading), end; at != end; ++at, ++sections)
    EXPECT_TRUE(holds(page, "<a href=\"#" + (*at)[1].str() + "\">" + (*at)[2].str() + "</a>"));
  EXPECT_GT(sections, 8);
  std::size_t links = 0;
  for (std::size_t at = page.find("<a href="); at != std::string::npos; at = page.find("<a href=", at + 1))
    ++links;
  EXPECT_EQ(int(links), sections);
  EXPECT_LT(page.find("<nav"), page.find("<section id="));
}

TEST(Report, EscapesWhatPeopleNamed) {
  const std::string page = page_of(good_session());
  EXPECT_TRUE(holds(page, "&lt;b&gt;&amp;&quot;x&quot;"));
  EXPECT_FALSE(holds(page, R"(<b>&"x")"));
  EXPECT_TRUE(holds(page, "<h1>wall &amp; floor</h1>"));
  EXPECT_TRUE(holds(page, "a/&lt;1&gt;.png"));
}

TEST(Report, BalancesItsTags) {
  EXPECT_EQ(imbalance(page_of(good_session())), "");
  EXPECT_NE(imbalance("<style></style><script></script><p><b></p></b>"), "");  // the check can fail
}

/// A German decimal comma for C++ streams, whatever locales the machine has.
struct DecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
};

TEST(Report, IsTheSameTextInEveryLocale) {
  const std::string page = page_of(good_session());
  EXPECT_EQ(page, page_of(good_session()));
  const std::locale before = std::locale::global(std::locale(std::locale(), new DecimalComma));
  const std::string c_before = std::setlocale(LC_ALL, nullptr);
  std::setlocale(LC_ALL, "de_DE.UTF-8");  // for printf, where it is installed
  const std::string german = page_of(good_session());
  std::locale::global(before);
  std::setlocale(LC_ALL, c_before.c_str());
  EXPECT_EQ(page, german);
}

TEST(Report, KeepsOutliersVisible) {
  const std::string page = page_of(good_session());
  EXPECT_TRUE(holds(page, "<title>view_2, point 7: "));
  EXPECT_TRUE(holds(page, "<title>view_3, point 20: "));
  EXPECT_TRUE(holds(page, "53 (1 rejected)"));
}

TEST(Report, DrawsEveryUsedBoardOnce) {
  const std::string page = page_of(good_session());
  std::size_t sheets = 0;
  for (std::size_t at = page.find("class=\"sheet\""); at != std::string::npos;
       at = page.find("class=\"sheet\"", at + 1))
    ++sheets;
  EXPECT_EQ(sheets, good_session().data.views.size());
}

TEST(Report, PrintsADashForWhatIsNotANumber) {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  Session session = good_session();
  session.result.rms_px[1] = nan;
  session.result.joint_rms_px = inf;
  session.result.views[0].rig_from_board.translation.x() = nan;
  session.result.views[0].rms_px[0] = nan;
  session.result.residuals[5].residual.x() = nan;
  session.result.residuals[6].pixel.y() = inf;
  session.result.rig.covariance.matrix.setConstant(nan);
  session.result.rig.projectors[0].projector.inverse_camera.intrinsics.cx = nan;
  session.input.predicted = {{{2.0, 0, nan, nan}, std::nullopt}};
  const std::string page = page_of(session);
  EXPECT_FALSE(prints_nan(page));
  EXPECT_TRUE(holds(page, "<b>- px</b>"));
  EXPECT_EQ(imbalance(page), "");
  EXPECT_TRUE(prints_nan("<style></style><script></script><p>M1 nan</p>"));  // the check can fail
}

TEST(Report, OfAViewLeftOutStillShowsIt) {
  Session session = good_session();
  calibrate::ViewResult& view = session.result.views[4];
  view.used = false;
  view.note = "rejected: too few corners";
  auto& residuals = session.result.residuals;
  residuals.erase(
      std::remove_if(residuals.begin(), residuals.end(), [](const auto& r) { return r.view == 4; }),
      residuals.end());
  const std::string page = page_of(session);
  EXPECT_TRUE(holds(page, "<td>rejected: too few corners</td>"));
  EXPECT_TRUE(holds(page, "class=\"unused\""));
  EXPECT_FALSE(holds(page_of(good_session()), "class=\"unused\""));
}

TEST(Report, OfACameraAloneHasNoProjector) {
  const Session& session = good_session();
  const CalibrationResult camera = calibrate::calibrate_camera(session.data);
  const std::string page = calibration_report(camera, session.data);
  EXPECT_FALSE(holds(page, "throw ratio"));
  EXPECT_EQ(imbalance(page), "");
  EXPECT_FALSE(prints_nan(page));
}

TEST(Report, RefusesCorrespondencesOfAnotherSession) {
  Session session = good_session();
  session.data.views[0].name = "elsewhere";
  EXPECT_THROW(page_of(session), std::invalid_argument);
  session = good_session();
  session.data.views.pop_back();
  EXPECT_THROW(page_of(session), std::invalid_argument);
  session = good_session();
  session.result.residuals[0].device = 2;
  EXPECT_THROW(page_of(session), std::invalid_argument);
}

TEST(Report, OfTwentyViewsIsBelowAMegabyte) {
  const std::string page = page_of(test::calibrate_session(20, false));
  EXPECT_LT(page.size(), 1000000u);
  EXPECT_EQ(imbalance(page), "");
}

TEST(CalibrationJson, HasTheFiguresOfTheResult) {
  Session session = good_session();
  session.input.views = 9;
  session.input.within_truth = {20, 21};
  session.result.holdout_px[1] = std::nan("");
  const auto json = nlohmann::json::parse(to_json(session.result, session.input));
  const std::string camera = session.result.devices[0].name, projector = session.result.devices[1].name;
  EXPECT_EQ(json.at("result"), session.result.rig.quality.passed() ? "passed" : "failed");
  EXPECT_EQ(json.at("views"), 9);
  EXPECT_EQ(json.at("views_used"), session.result.rig.quality.views_used);
  EXPECT_EQ(json.at("rms_px").at(camera), session.result.rms_px[0]);
  EXPECT_EQ(json.at("rms_px").at("joint"), session.result.joint_rms_px);
  EXPECT_TRUE(json.at("holdout_px").at(projector).is_null());
  const DeviceCounts counts = device_counts(session.result, 0);
  EXPECT_EQ(json.at("points_used").at(camera), counts.points_used);
  EXPECT_LT(counts.points_used, counts.points_found);  // an outlier is among them
  EXPECT_EQ(json.at("wall").at("rms_mm"), session.input.predicted[0].externally.rms_mm);
  EXPECT_EQ(json.at("truth").at("by_camera").at("worst_mm"), session.input.truth[0].by_camera->worst_mm);
  EXPECT_EQ(json.at("truth").at("parameters"), 21);
  const Camera& lens = session.result.rig.projectors[0].projector.inverse_camera;
  EXPECT_EQ(json.at(projector).at("fx"), lens.intrinsics.fx);
  EXPECT_EQ(json.at(projector).at("sigma").at("fx"), session.result.rig.covariance.sigma(projector + ".fx"));
  EXPECT_EQ(json.at("gates").at("total"), session.result.rig.quality.gates.size());
  EXPECT_EQ(json.at("view_verdicts").size(), session.result.views.size());
}

TEST(CalibrationJson, NamesEachOfSeveralProjectors) {
  Session session = good_session();
  Rig& rig = session.result.rig;
  rig.projectors.push_back(rig.projectors[0]);
  rig.projectors[1].name = "second";
  session.input.predicted.push_back(session.input.predicted[0]);
  session.input.predicted[1].externally.rms_mm = 77;
  const auto json = nlohmann::json::parse(to_json(rig, rig.quality, session.input));
  EXPECT_EQ(json.at("wall").at("second").at("rms_mm"), 77);
  EXPECT_EQ(json.at("wall").at("projector").at("rms_mm"), session.input.predicted[0].externally.rms_mm);
  EXPECT_FALSE(json.at("wall").contains("rms_mm"));
}

TEST(CalibrationReport, CarriesTheJsonOfItsResult) {
  const Session& session = good_session();
  EXPECT_EQ(test::page_data(page_of(session)), nlohmann::json::parse(to_json(session.result, session.input)));
}

TEST(CalibrationLines, BeginWithTheVerdict) {
  const Session& session = good_session();
  const auto head = headline(session.result, session.input);
  EXPECT_EQ(head.at(0).rfind("result     ", 0), 0u) << head[0];
  EXPECT_NE(head[0].find("predicted error"), std::string::npos) << head[0];
  const analyze::LightErrors& predicted = session.input.predicted.at(0);
  const std::string limit =
      "with 95 % confidence below " + significant(predicted.externally.rms95_mm, 2) + " mm, ";
  EXPECT_NE(head.back().find(limit), std::string::npos) << head.back();
  const auto wall = nlohmann::json::parse(to_json(session.result, session.input)).at("wall");
  EXPECT_EQ(wall.at("rms95_mm"), predicted.externally.rms95_mm);
  EXPECT_GT(wall.at("rms95_mm"), wall.at("rms_mm"));
  EXPECT_EQ(wall.at("by_camera").at("rms95_mm"), predicted.by_camera.value().rms95_mm);
  const auto below = lines(session.result, session.input);
  EXPECT_NE(below.at(0).find("of " + std::to_string(session.input.views) + " used"), std::string::npos);
  EXPECT_EQ(below.back().rfind("check", 0), 0u) << below.back();
}

}  // namespace
}  // namespace procam::report
