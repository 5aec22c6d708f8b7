#include "procam/io/session/observations_file.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>
#include <set>
#include <tuple>

#include "image/npy.hpp"
#include "scratch.hpp"
#include "session/observations_text.hpp"

namespace procam::io {
namespace {

const std::string kText =
    "# made by hand\n"
    "# board: chessboard:4x3:20mm\n"
    "# camera: left 640x480\n"
    "# projector: beamer 1024x768\n"
    "u, v, view, device, point, sigma\r\n"
    "100.25, 50.5, second, left, 7, 0.05\n"
    "\n"
    "900.5;700;second;beamer;7;0.2  # a comment\n"
    "-0.5\t479.5\tfirst\tleft\t11\t0.1\n"
    "12, 13, first, beamer, -4, 1\n"
    "14, 15, first, left, -4, 0.5\n";

TEST(Observations, AreReadByTheNamesOfTheirColumns) {
  const Correspondences data = parse_observations(kText, "o.csv");
  EXPECT_TRUE(data.board == Board(Chessboard{4, 3, 0.02}));
  ASSERT_EQ(data.devices.size(), 2u);
  EXPECT_EQ(data.devices[0].name, "left");
  EXPECT_EQ(data.devices[1].kind, DeviceKind::kProjector);
  EXPECT_EQ(data.devices[1].size, (ImageSize{1024, 768}));
  ASSERT_EQ(data.views.size(), 2u);
  EXPECT_EQ(data.views[0].name, "second");  // in the order of their first rows
  ASSERT_EQ(data.views[0].observations[0].size(), 1u);
  const Observation& corner = data.views[0].observations[0][0];
  EXPECT_EQ(corner.point, 7);
  EXPECT_EQ(corner.pixel, Vec2(100.25, 50.5));
  EXPECT_EQ(corner.covariance, Mat2(0.05 * 0.05 * Mat2::Identity()));
  EXPECT_EQ(data.views[0].observations[1][0].pixel, Vec2(900.5, 700));
  ASSERT_EQ(data.views[1].light_points.size(), 1u);
  const LightPoint& light = data.views[1].light_points[0];
  EXPECT_EQ(light.projector, 1);
  EXPECT_EQ(light.projector_pixel, Vec2(12, 13));
  EXPECT_EQ(light.point, 3);  // -4 in the file
  EXPECT_EQ(light.camera_pixel, Vec2(14, 15));
  EXPECT_EQ(light.camera_covariance, Mat2(0.25 * Mat2::Identity()));
}

TEST(Observations, TheCallerGoesBeforeTheFile) {
  const Correspondences data = parse_observations(
      kText, "o.csv", {Chessboard{5, 9, 0.01}, {{"beamer", DeviceKind::kProjector, {1280, 800}}}});
  EXPECT_TRUE(data.board == Board(Chessboard{5, 9, 0.01}));
  EXPECT_EQ(data.devices[0].name, "left");
  EXPECT_EQ(data.devices[1].size, (ImageSize{1280, 800}));
}

/// A board of 4 x 3 points 20 mm apart, as positions: with and without a board to compare with.
TEST(Observations, FindPointsByPosition) {
  std::string text = "view,device,x,y,z,u,v\n";
  for (int i = 0; i < 12; ++i)
    text += "0,0," + std::to_string(0.02 * (i % 4)) + "," + std::to_string(0.02 * (i / 4)) + ",0," +
            std::to_string(100 + 3 * i) + ",77\n";
  const std::vector<Device> devices{{"camera", DeviceKind::kCamera, {640, 480}}};
  const Correspondences grid = parse_observations(text, "o.csv", {{}, devices});
  EXPECT_TRUE(std::holds_alternative<Chessboard>(grid.board));
  EXPECT_EQ(std::get<Chessboard>(grid.board).columns, 4);
  EXPECT_EQ(std::get<Chessboard>(grid.board).rows, 3);
  EXPECT_NEAR(std::get<Chessboard>(grid.board).square_size, 0.02, 1e-12);
  const Correspondences given = parse_observations(text, "o.csv", {Chessboard{7, 5, 0.02}, devices});
  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ(grid.views[0].observations[0][std::size_t(i)].point, i);
    EXPECT_EQ(given.views[0].observations[0][std::size_t(i)].point, i % 4 + 7 * (i / 4));
  }
  EXPECT_ERROR(parse_observations(text, "o.csv", {Chessboard{7, 5, 0.021}, devices}), kInput,
               "line 3: the board has no point at its x, y, z");
  EXPECT_ERROR(parse_observations(text + "0,0,0.031,0,0,9,9\n", "o.csv", {{}, devices}), kInput,
               "no square grid");
  // A target of several planes: each is a board of its own.
  EXPECT_ERROR(parse_observations(text + "0,0,0.02,0.02,0.05,9,9\n", "o.csv", {{}, devices}), kInput,
               "line 14: its z is 0.05 m, and boards are flat; give each plane");
}

/// Views are compared by the points of the pattern (a stale frame shows those of another view): their numbers
/// survive a file, also where two cameras see the same point and views show different parts of the pattern.
TEST(Observations, KeepTheNumbersOfThePatternsPoints) {
  Correspondences data;
  data.board = Chessboard{4, 3, 0.02};
  data.devices = {{"left", DeviceKind::kCamera, {640, 480}},
                  {"right", DeviceKind::kCamera, {640, 480}},
                  {"beamer", DeviceKind::kProjector, {1024, 768}}};
  const auto light = [](int camera, int point) {
    return LightPoint{2,    Vec2(10 + point, 20), camera, Vec2(30 + camera, 40 + point), Mat2::Identity(),
                      point};
  };
  data.views = {{"a", {{}, {}, {}}, {light(0, 7), light(1, 7), light(1, 2)}},
                {"b", {{}, {}, {}}, {light(0, 2)}}};
  const Correspondences read = parse_observations(format_observations(data), "o.csv");
  std::set<std::tuple<std::size_t, int, int, double>> expected, found;  // view, camera, point, pixel
  for (const bool original : {true, false}) {
    const Correspondences& one = original ? data : read;
    for (std::size_t v = 0; v < one.views.size(); ++v)
      for (const LightPoint& l : one.views[v].light_points)
        (original ? expected : found).insert({v, l.camera, l.point, l.camera_pixel.y()});
  }
  EXPECT_EQ(found, expected);
}

/// Two projectors that show points of the same numbers: the file has others, which stay from then on.
TEST(Observations, NumberThePointsOfTwoProjectorsOnce) {
  const std::string head =
      "# board: chessboard:4x3:20mm\n# camera: camera 640x480\n# projector: beamer 1024x768\n"
      "# projector: lamp 800x600\n# projector: third 800x600\nview, device, point, u, v\n";
  // Far numbers must not overflow.
  const std::string rows =
      "a, camera, -1, 1, 2\na, beamer, -1, 3, 4\nb, camera, -1, 5, 6\nb, lamp, -1, 7, 8\n"
      "b, camera, -1000000000, 7, 8\nb, third, -1000000000, 9, 10\n";
  const std::string once = format_observations(parse_observations(head + rows, "o.csv"));
  EXPECT_EQ(format_observations(parse_observations(once, "p.csv")), once);
  EXPECT_NE(once.find("a, beamer, camera, -1, 3, 4"), std::string::npos) << once;
  EXPECT_NE(once.find("b, lamp, camera, -2, 7, 8"), std::string::npos) << once;
  EXPECT_NE(once.find("b, third, camera, -3, 9, 10"), std::string::npos) << once;
}

/// Two cameras, two projectors, light points, covariances that are no circles.
Correspondences lopsided() {
  Correspondences data{Chessboard{3, 2, 1.0 / 30}, {}, {}, {}};
  data.devices = {{"left", DeviceKind::kCamera, {640, 480}},
                  {"right eye", DeviceKind::kCamera, {1280, 1024}},
                  {"beamer", DeviceKind::kProjector, {1024, 768}},
                  {"lamp", DeviceKind::kProjector, {800, 1280}}};
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int v = 0; v < 3; ++v) {
    View view{"pose " + std::to_string(v), {{}, {}, {}, {}}, {}};
    for (int d = 0; d < 4; ++d)
      for (int camera = 0; camera < (d < 2 ? 1 : 2); ++camera)
        for (int point = v; point < 6; ++point) {
          Observation o{point, Vec2(600 * unit(random), 400 * unit(random)), Mat2::Zero(), camera};
          const double a = unit(random), b = unit(random), c = 0.1 + unit(random);
          o.covariance << a * a + 0.01, a * b, a * b, b * b + c;
          view.observations[std::size_t(d)].push_back(o);
        }
    view.light_points.push_back({3, Vec2(unit(random), 1000 / 3.0), 1, Vec2(400 * unit(random), 5),
                                 Mat2(0.01 * unit(random) * Mat2::Identity())});
    data.views.push_back(view);
  }
  return data;
}

void expect_same(const Correspondences& a, const Correspondences& b) {
  ASSERT_EQ(a.views.size(), b.views.size());
  ASSERT_EQ(a.devices.size(), b.devices.size());
  for (std::size_t v = 0; v < a.views.size(); ++v) {
    for (std::size_t d = 0; d < a.devices.size(); ++d) {
      ASSERT_EQ(a.views[v].observations[d].size(), b.views[v].observations[d].size());
      for (std::size_t i = 0; i < a.views[v].observations[d].size(); ++i) {
        const Observation &p = a.views[v].observations[d][i], &q = b.views[v].observations[d][i];
        EXPECT_EQ(p.point, q.point);
        EXPECT_EQ(p.camera, q.camera);
        EXPECT_EQ(p.pixel, q.pixel);
        EXPECT_EQ(p.covariance, q.covariance);
      }
    }
    ASSERT_EQ(a.views[v].light_points.size(), b.views[v].light_points.size());
    for (std::size_t i = 0; i < a.views[v].light_points.size(); ++i) {
      const LightPoint &p = a.views[v].light_points[i], &q = b.views[v].light_points[i];
      EXPECT_EQ(p.projector, q.projector);
      EXPECT_EQ(p.camera, q.camera);
      EXPECT_EQ(p.projector_pixel, q.projector_pixel);
      EXPECT_EQ(p.camera_pixel, q.camera_pixel);
      EXPECT_EQ(p.camera_covariance, q.camera_covariance);
    }
  }
}

TEST(Observations, ReadBackAsTheyWereWritten) {
  const test::Scratch scratch;
  const Correspondences data = lopsided();
  save_observations(scratch / "o.csv", data);
  const Correspondences text = load_observations(scratch / "o.csv");
  expect_same(data, text);
  EXPECT_TRUE(text.board == data.board);
  EXPECT_EQ(text.devices[1].name, "right eye");
  EXPECT_EQ(text.views[2].name, "pose 2");

  save_observations(scratch / "o.npy", data);
  expect_same(data, load_observations(scratch / "o.npy", {data.board, data.devices}));
}

/// The table as np.save() writes a plain array of view, device, x, y, z, u, v.
TEST(Observations, ReadAnArrayWithoutNames) {
  const test::Scratch scratch;
  NpyArray array{{2, 7}, {0, 1, 0.02, 0.04, 0, 5, 6, 3, 0, 0, 0, 0, 7, 8}, {}};
  scratch.write("a.npy", format_npy(array));
  const ObservationsContext context{
      Chessboard{4, 3, 0.02},
      {{"beamer", DeviceKind::kProjector, {1024, 768}}, {"camera", DeviceKind::kCamera, {640, 480}}}};
  const Correspondences data = load_observations(scratch / "a.npy", context);
  ASSERT_EQ(data.views.size(), 2u);
  EXPECT_EQ(data.views[0].observations[1][0].point, 9);
  EXPECT_EQ(data.views[1].observations[0][0].pixel, Vec2(7, 8));
  array.values[0] = 0.5;
  scratch.write("a.npy", format_npy(array));
  EXPECT_ERROR(load_observations(scratch / "a.npy", context), kInput, "row 0: column view");
}

TEST(Observations, NameFileLineAndColumnOfAMistake) {
  const auto with = [](const std::string& from, const std::string& to) {
    std::string text = kText;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  const auto parse = [](const std::string& text) { return parse_observations(text, "o.csv"); };
  EXPECT_ERROR(parse(with("100.25", "100,25")), kInput, "o.csv, line 6: it has 7 columns");
  EXPECT_ERROR(parse(with("100.25", "1e999")), kInput, "line 6: column u is no number");
  EXPECT_ERROR(parse(with("left, 7", "left, 7.5")), kInput, "column point is no whole number");
  EXPECT_ERROR(parse(with("left, 7", "left, 12")), kInput, "point 12 is not on the board");
  EXPECT_ERROR(parse(with("second, left, 7", "second, rigth, 7")), kInput,
               "the device 'rigth' (known: left, beamer)");
  EXPECT_ERROR(parse(with("100.25", "800")), kInput, "800, 50.5 is outside left's 640x480");
  EXPECT_ERROR(parse(with("0.05", "0")), kInput, "column sigma is not between");
  EXPECT_ERROR(parse(with("sigma", "sgima")), kInput, "did you mean 'sigma'");
  EXPECT_ERROR(parse(with(", sigma", ", u")), kInput, "'u' stands there twice");
  EXPECT_ERROR(parse(with("640x480", "640")), kInput, "line 3: ");
  EXPECT_ERROR(parse(with("# camera: left 640x480", "")), kInput, "give --camera-size");
  EXPECT_ERROR(parse(with("# board: chessboard:4x3:20mm", "")), kInput, "give --board");
  EXPECT_ERROR(parse(with("first\tleft\t11", "second\tleft\t7")), kInput,
               "this point of this device already");
  EXPECT_ERROR(parse(with("14, 15, first, left, -4, 0.5\n", "")), kInput,
               "line 10: point -4 of the pattern needs a row");
  EXPECT_ERROR(parse("view, device, u, v\n"), kInput, "a point is named by");
  EXPECT_ERROR(parse("view, device, point, u, v\n"), kInput, "no row");
  EXPECT_ERROR(parse("view, device, point, u, v, var_u, cov_uv, var_v\n1,0,0,5,5,1,2,1\n"), kInput,
               "positive definite");
}

TEST(Observations, AreReadAsSpreadsheetsAndDataFramesWriteThem) {
  const Correspondences expected = parse_observations(kText, "o.csv");
  const auto same = [&](const std::string& text) {
    const Correspondences data = parse_observations(text, "o.csv");
    EXPECT_EQ(format_observations(data), format_observations(expected)) << text;
  };
  same("\xef\xbb\xbf" + kText);  // Excel: a byte order mark
  const std::string statements =
      "# board: chessboard:4x3:20mm\n# camera: left 640x480\n# projector: beamer 1024x768\n";
  same(statements +
       "u;v;view;device;point;sigma\r\n"  // decimal commas
       "100,25;50,5;second;left;7;0,05\r\n900,5;700;second;beamer;7;0,2\r\n-0,5;479,5;first;left;11;0,1\r\n"
       "12;13;first;beamer;-4;1\r\n14;15;first;left;-4;0,5\r\n");
  same(statements +
       "\"\",\"U\",\"V\",\"View\",\"Device\",\"Point\",\"Sigma\"\n"  // R: row numbers, quotes
       "\"1\",100.25,50.5,\"second\",\"left\",7,0.05\n\"2\",900.5,700,\"second\",\"beamer\",7,0.2\n"
       "\"3\",-0.5,479.5,\"first\",\"left\",11,0.1\n\"4\",12,13,\"first\",\"beamer\",-4,1\n"
       "\"5\",14,15,\"first\",\"left\",-4,0.5\n");
}

TEST(Observations, NameTheCauseOfTablesOfOtherPrograms) {
  const std::string statements =
      "# board: chessboard:4x3:20mm\n# camera: left 640x480\n# projector: beamer 1024x768\n";
  const auto parse = [](const std::string& text) { return parse_observations(text, "o.csv"); };
  EXPECT_ERROR(parse(statements + "a,left,7,100,50\n"), kInput, "begins with the names of its columns");
  EXPECT_ERROR(parse(statements + "view,device,point,u,v\na,left,7,NaN,50\n"), kInput,
               "leave out the rows of points that were not found");
  EXPECT_ERROR(parse(std::string("\xff\xfev\0i\0e\0w\0,\0", 12)), kInput, "it is not UTF-8 text");
  std::string shares = statements + "view,device,point,u,v\n",
              millimetres = statements.substr(29) + "view,device,x,y,z,u,v\n";
  for (int i = 0; i < 12; ++i) {
    shares += "a,left," + std::to_string(i) + "," + std::to_string(100 + i) + ",50\na,beamer," +
              std::to_string(i) + ",0." + std::to_string(10 + i) + ",0.5\n";
    millimetres +=
        "a,left," + std::to_string(20 * (i % 4)) + "," + std::to_string(20 * (i / 4)) + ",0,100,50\n";
  }
  EXPECT_ERROR(parse(shares), kInput, "the pixels of beamer are shares of its image");
  EXPECT_ERROR(parse(millimetres), kInput, "squares of 20 m");
}

TEST(Observations, SurviveDamage) {
  const std::string written = format_observations(lopsided());
  std::mt19937 random(6);
  for (int trial = 0; trial < 4000; ++trial) {
    std::string text = trial % 2 == 0 ? kText : written;
    for (int hit = 0; hit < 1 + trial % 6; ++hit) text[random() % text.size()] = char(random() % 256);
    if (trial % 3 == 0) text.resize(random() % text.size());
    try {
      for (const View& view : parse_observations(text, "damaged").views)
        for (const auto& device : view.observations)
          for (const Observation& o : device)
            EXPECT_TRUE(o.pixel.allFinite() && o.covariance.determinant() > 0 && o.point >= 0);
    } catch (const Error&) {
    }
  }
}

}  // namespace
}  // namespace procam::io
