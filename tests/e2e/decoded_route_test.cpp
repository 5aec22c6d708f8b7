/// Patterns of other programs: maps that they have decoded, and their frames by a description -> rig.json.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "e2e/small_session.hpp"
#include "e2e/tool_runner.hpp"
#include "image/npy.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/image/pfm.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/io/session/pattern_file.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;

constexpr int kBits = 10;  // 1024x768
const double kNaN = std::numeric_limits<double>::quiet_NaN();

/// As the plainest of other programs does: the brighter of a frame and its inverse is the bit, no threshold
/// but white minus black.
io::NpyArray plain_decoding(const std::vector<ImageU8>& frames) {
  const ImageU8 &white = frames[4 * kBits], &black = frames[4 * kBits + 1];
  io::NpyArray map{{std::size_t(white.height()), std::size_t(white.width()), 2}, {}, {}};
  for (int y = 0; y < white.height(); ++y)
    for (int x = 0; x < white.width(); ++x)
      for (int axis = 0; axis < 2; ++axis) {
        int code = 0, bit = 0;
        for (int i = 0; i < kBits; ++i) {
          const std::size_t pair = std::size_t(2 * (axis * kBits + i));
          bit ^= frames[pair].at(x, y) > frames[pair + 1].at(x, y);
          code = 2 * code + bit;
        }
        map.values.push_back(white.at(x, y) - black.at(x, y) < 10 ? kNaN : code);
      }
  return map;
}

io::NpyArray channel(const io::NpyArray& map, std::size_t which) {
  io::NpyArray one{{map.shape[0], map.shape[1]}, {}, {}};
  for (std::size_t i = which; i < map.values.size(); i += 2) one.values.push_back(map.values[i]);
  return one;
}

ImageF image_of(const io::NpyArray& map) {
  ImageF image(int(map.shape[1]), int(map.shape[0]));
  std::copy(map.values.begin(), map.values.end(), image.data());
  return image;
}

io::NpyArray changed(io::NpyArray map, const std::function<double(double, std::size_t)>& change) {
  for (std::size_t i = 0; i < map.values.size(); ++i) map.values[i] = change(map.values[i], i);
  return map;
}

struct Decoded {
  ScratchFolder folder;
  std::vector<io::NpyArray> maps;

  Decoded() {
    for (const fs::path& view : io::list_views(kSession)) {
      const io::CaptureFolder captures = io::load_capture_folder(view, 4 * kBits + 2);
      maps.push_back(plain_decoding(captures.frames));
      fs::create_directories(place(int(maps.size()) - 1));
      io::save_image(place(int(maps.size()) - 1) / "white.png", captures.frames[4 * kBits]);
    }
  }
  fs::path place(int view) const { return folder / "maps" / fs::path("view_0" + std::to_string(view)); }
  void write(int view, const std::string& name, const io::NpyArray& array) const {
    io::write_file_atomically(place(view) / name, io::format_npy(array));
  }
  /// Each of the three ways to store a map.
  void write_all() const {
    for (int view = 0; view < int(maps.size()); ++view) {
      const io::NpyArray& map = maps[std::size_t(view)];
      if (view == 0) {
        write(view, "map.npy", map);
      } else if (view == 1) {
        io::save_pfm(place(view) / "columns.pfm", image_of(channel(map, 0)));
        io::save_pfm(place(view) / "rows.pfm", image_of(channel(map, 1)));
      } else {
        write(view, "columns.npy", channel(map, 0));
        write(view, "rows.npy", channel(map, 1));
      }
    }
  }
  ToolRun calibrate(const std::string& more) const {
    return run_tool("calibrate-projector", "--decoded " + (folder / "maps").string() + " " + more + " -o " +
                                               (folder / "rig.json").string());
  }
};

const char* const kDevices = "--projector-size 1024x768 --board chessboard:10x7:30mm ";

/// Whole codes of a plain decoder, against the same frames read by procam.
TEST(DecodedRoute, IsCloseToProcamsOwnReadingOfTheFrames) {
  const Decoded decoded;
  decoded.write_all();
  const std::string truth = "--json --truth " + (kSession / "truth.json").string();
  const ToolRun maps = decoded.calibrate(kDevices + truth);
  ASSERT_EQ(maps.exit_code, 0) << maps.err;
  const ToolRun frames =
      run_tool("calibrate-projector", "--captures " + kSession.string() + " " + truth + " -o " +
                                          (decoded.folder / "frames.json").string());
  const auto figure = [](const ToolRun& run, const char* name) {
    return run.json().at(nlohmann::json::json_pointer(name)).get<double>();
  };
  // 0.0081 px where the stripe edges of the frames give 0.0064: the smooth map averages the codes' rounding.
  EXPECT_LT(figure(maps, "/rms_px/projector"), 0.02);
  // 0.033 against 0.013 mm: of one session, either may be smaller.
  EXPECT_LT(figure(maps, "/truth/by_camera/rms_mm"), 4 * figure(frames, "/truth/by_camera/rms_mm"));
  EXPECT_LT(figure(maps, "/truth/rms_mm"), 3 * figure(maps, "/wall/rms_mm"));
  EXPECT_EQ(figure(maps, "/views_used"), figure(frames, "/views_used"));

  // The same by session.json.
  std::ofstream(decoded.folder / "maps/session.json")
      << R"({"format": "procam-session", "version": 1, "pattern": "decoded", "projector_size": [1024, 768],
             "board": "chessboard:10x7:30mm"})";
  const ToolRun session =
      run_tool("calibrate-projector", "--captures " + (decoded.folder / "maps").string() + " " + truth +
                                          " -o " + (decoded.folder / "b.json").string());
  ASSERT_EQ(session.exit_code, 0) << session.err;
  EXPECT_EQ(figure(session, "/truth/rms_mm"), figure(maps, "/truth/rms_mm"));
}

/// What a user may get wrong: each is named, with the view and the next step.
TEST(DecodedRoute, NamesWhatIsWrongWithAMap) {
  const Decoded decoded;
  decoded.write_all();
  const io::NpyArray good = decoded.maps[0];
  const auto expect = [&](const io::NpyArray& map, const std::string& words,
                          const std::string& next = "next:") {
    decoded.write(0, "map.npy", map);
    const ToolRun run = decoded.calibrate(kDevices);
    EXPECT_EQ(run.exit_code, 3) << words;
    for (const std::string& part : {std::string("view_00"), words, next})
      EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
  };
  expect(changed(good, [](double v, std::size_t i) { return (v + 0.5) / (i % 2 == 0 ? 1024 : 768); }),
         "between 0 and 1", "times width");
  expect(changed(good, [](double, std::size_t) { return kNaN; }), "no pixel of it is decoded");
  expect(changed(good, [](double v, std::size_t) { return 3 * v; }), "beyond the projector's width",
         "--projector-size");
  io::NpyArray other = good;
  std::swap(other.shape[0], other.shape[1]);
  expect(other, "x and y are exchanged", "transposed");
  other = good;
  other.shape = {2, good.shape[0], good.shape[1]};
  expect(other, "its shape is 2x", "moveaxis");
  expect(channel(good, 0), "height x width x 2");
  decoded.write(0, "map.npy", good);
  decoded.write(0, "rows.npy", channel(good, 1));
  EXPECT_NE(decoded.calibrate(kDevices).err.find("rows.npy as well"), std::string::npos);
  fs::remove(decoded.place(0) / "map.npy");
  EXPECT_NE(decoded.calibrate(kDevices).err.find("rows.npy alone"), std::string::npos);
  EXPECT_EQ(decoded.calibrate(std::string(kDevices) + "--step 2").exit_code, 2);
}

/// Procam's own frames by a description, whole and as another program would have fewer of them.
TEST(PatternRoute, ADescriptionOfProcamsOwnFramesGivesTheSameRig) {
  const ScratchFolder folder;
  FrameSequence sequence;
  for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow})
    for (int bit = kBits; bit-- > 0;)
      for (const bool inverse : {false, true})
        sequence.frames.push_back({SequenceFrame::Kind::kGray, axis, bit, inverse});
  sequence.frames.push_back({SequenceFrame::Kind::kWhite});
  sequence.frames.push_back({SequenceFrame::Kind::kBlack});
  io::save_pattern(folder / "other.json", sequence);
  const auto calibrate = [&](const std::string& more, const std::string& rig) {
    return run_tool("calibrate-projector",
                    "--captures " + kSession.string() + " --json " + more + " -o " + (folder / rig).string());
  };
  const ToolRun own = calibrate("", "own.json");
  ASSERT_EQ(own.exit_code, 0) << own.err;
  const ToolRun described = calibrate("--pattern " + (folder / "other.json").string(), "described.json");
  ASSERT_EQ(described.exit_code, 0) << described.err;
  const auto same = [](const nlohmann::json& a, const nlohmann::json& b, const char* at) {
    EXPECT_EQ(a.at(nlohmann::json::json_pointer(at)), b.at(nlohmann::json::json_pointer(at))) << at;
  };
  for (const char* figure : {"/wall/rms_mm", "/rms_px/joint", "/views_used"})
    same(own.json(), described.json(), figure);

  // make-patterns shows them, and leaves a session that knows its pattern wherever it is moved.
  const ToolRun made =
      run_tool("make-patterns", "--pattern " + (folder / "other.json").string() +
                                    " --projector-size 1024x768 --json -o " + (folder / "session").string());
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(io::load_session(folder / "session")->pattern, "pattern.json");
  EXPECT_EQ(io::load_pattern(folder / "session/pattern.json").frames.size(), 42u);
  const ImageU8 shown = io::load_image(folder / "session/show_03.png").image;  // column bit 8, inverse
  EXPECT_TRUE(shown.at(100, 5) == 255 && shown.at(300, 5) == 0 && shown.at(700, 5) == 0 &&
              shown.at(900, 5) == 255);

  sequence.frames.pop_back();
  sequence.frames[4].bit = 9;
  io::save_pattern(folder / "wrong.json", sequence);
  const ToolRun wrong = calibrate("--pattern " + (folder / "wrong.json").string(), "wrong_rig.json");
  EXPECT_EQ(wrong.exit_code, 3);
  for (const char* part : {"wrong.json", "frames 0 and 4 are both columns bit 9", "next:"})
    EXPECT_NE(wrong.err.find(part), std::string::npos) << wrong.err;
}

}  // namespace
}  // namespace procam::test
