// Files of nouns: written and read back, in both syntaxes, and every way in which one can be wrong.
#include <gtest/gtest.h>

#include <limits>

#include "document/document.hpp"
#include "examples.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "scratch.hpp"

namespace procam::io {
namespace {

using test::Scratch;

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// The file of an example noun, its text changed in one place.
struct Files {
  Scratch scratch;
  std::string rig_text, surfaces_json, surfaces_xml;

  Files() {
    save_rig(scratch / "rig.json", test::example_rig());
    scratch.write("roof.obj", test::kRoof);
    save_image(scratch / "leaves.png", ImageU8(5, 3, 3, 200));
    save_surfaces(scratch / "s.json", test::example_surfaces());
    save_surfaces(scratch / "s.xml", test::example_surfaces());
    rig_text = read_file(scratch / "rig.json");
    surfaces_json = read_file(scratch / "s.json");
    surfaces_xml = read_file(scratch / "s.xml");
  }
  Rig rig(const std::string& from, const std::string& to) const {
    return load_rig(scratch.write("rig.json", replaced(rig_text, from, to)));
  }
  SurfaceSet surfaces(const std::string& name, const std::string& from, const std::string& to) const {
    const std::string& text = name == "s.xml" ? surfaces_xml : surfaces_json;
    return load_surfaces(scratch.write(name, replaced(text, from, to)));
  }
};

// The text of a file holds every field to the last digit, so two files are equal when their nouns are.
TEST(RigFile, ReadsBackEveryFieldToTheLastDigit) {
  const Scratch scratch;
  const Rig rig = test::example_rig();
  save_rig(scratch / "a.json", rig);
  const Rig loaded = load_rig(scratch / "a.json");
  ASSERT_EQ(loaded.projectors.size(), 2u);
  EXPECT_EQ(parameters_of(loaded.camera("left").camera), parameters_of(rig.camera("left").camera));
  EXPECT_EQ(parameters_of(loaded.projector("second").projector.inverse_camera),
            parameters_of(rig.projector("second").projector.inverse_camera));
  EXPECT_EQ(loaded.projector("beamer").rig_from_projector.matrix(),
            rig.projector("beamer").rig_from_projector.matrix());
  EXPECT_EQ(loaded.camera("wide").camera.size, rig.camera("wide").camera.size);
  EXPECT_EQ(loaded.covariance.names, rig.covariance.names);
  EXPECT_EQ(loaded.covariance.matrix, rig.covariance.matrix);
  EXPECT_EQ(loaded.quality.rms_px, rig.quality.rms_px);
  EXPECT_EQ(loaded.quality.holdout_px, rig.quality.holdout_px);
  EXPECT_EQ(loaded.quality.expected_holdout_px, rig.quality.expected_holdout_px);
  EXPECT_FALSE(loaded.quality.passed());
  EXPECT_EQ(loaded.provenance.options, rig.provenance.options);
  EXPECT_EQ(loaded.provenance.inputs[0].sha256, rig.provenance.inputs[0].sha256);
  save_rig(scratch / "b.json", loaded);
  EXPECT_EQ(read_file(scratch / "b.json"), read_file(scratch / "a.json"));
}

TEST(RigFile, ReadsBackARigWithNothingKnownOfItsQuality) {
  const Scratch scratch;
  Rig rig;
  rig.cameras = {{"camera", {{3, 2}, {1, 2, 3, 4, -0.0}, {}}, {}}};
  save_rig(scratch / "a.json", rig);
  const Rig loaded = load_rig(scratch / "a.json");
  EXPECT_TRUE(loaded.covariance.empty());
  EXPECT_TRUE(std::signbit(loaded.camera().camera.intrinsics.skew)) << "the sign of zero is kept";
}

// The order, the indentation and the digits are a promise to those who compare files.
TEST(RigFile, IsLaidOutAsTheGoldenFile) {
  const Files files;
  const std::filesystem::path golden = std::filesystem::path(PROCAM_SOURCE_DIR) / "tests/io/golden";
  EXPECT_EQ(files.rig_text, read_file(golden / "rig.json"));
  EXPECT_EQ(files.surfaces_json, read_file(golden / "surfaces.json"));
  EXPECT_EQ(files.surfaces_xml, read_file(golden / "surfaces.xml"));
}

TEST(RigFile, NamesFileLineAndFieldOfWhatIsWrong) {
  const Files f;
  EXPECT_ERROR(f.rig("\"fx\": 1701.25", "\"fx\": \"wide\""), kInput,
               "rig.json:9: cameras[0].intrinsics.fx: it is a text where a number is expected");
  EXPECT_ERROR(f.rig("\"fx\": 1701.25", "\"fx\": 0"), kInput,
               ":9: cameras[0].intrinsics.fx: the focal length");
  EXPECT_ERROR(f.rig("\"fx\": 1701.25", "\"fx\": null"), kInput, ":9: cameras[0].intrinsics.fx: it is null");
  EXPECT_ERROR(f.rig("\"fx\": 1701.25,", ""), kInput, "cameras[0].intrinsics: the field 'fx' is missing");
  EXPECT_ERROR(
      f.rig("\"fx\": 1701.25", "\"fxx\": 1701.25"), kInput,
      ":9: cameras[0].intrinsics.fxx: unknown field 'fxx'; did you mean 'fx'? known here: fx, fy, cx");
  EXPECT_ERROR(f.rig("\"fx\": 1701.25", "\"fx\": 1, \"fx\": 2"), kInput,
               "rig.json:9: cameras[0].intrinsics: the field 'fx' is given twice");
  EXPECT_ERROR(f.rig("\"views_used\": 5", "\"views_used\": 5.5"), kInput,
               "quality.views_used: it is no whole number");
  EXPECT_ERROR(f.rig("[1280, 1024]", "[1280]"), kInput, ":7: cameras[0].size: it has 1 numbers; give 2");
  EXPECT_ERROR(f.rig("[1280, 1024]", "[1280, -1024]"), kInput,
               "cameras[0].size: a side is not a whole number");
  EXPECT_ERROR(
      f.rig("brown_conrady", "brown_conradi"), kInput,
      "cameras[0].distortion.model: there is no 'brown_conradi' here; did you mean 'brown_conrady'?");
  EXPECT_ERROR(f.rig("\"rotation_xyzw\": [0, 0, 0, 1]", "\"rotation_xyzw\": [0, 0, 0, 1.00001]"), kInput,
               "cameras[0].rig_from_camera.rotation_xyzw: the quaternion has length 1.00001");
  EXPECT_ERROR(f.rig("\"name\": \"wide\"", "\"name\": \"left\""), kInput,
               "cameras: two devices are named 'left'");
}

TEST(RigFile, RefusesNumbersThatAreNotFinite) {
  const Files f;
  for (const char* word : {"NaN", "nan", "Infinity", "-Infinity", "1e999", "-1e999"})
    EXPECT_ERROR(f.rig("\"fx\": 1701.25", std::string("\"fx\": ") + word), kInput,
                 "rig.json:9: cameras[0].intrinsics.fx: ");
  Rig rig = test::example_rig();
  rig.cameras[0].camera.intrinsics.cx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(save_rig(f.scratch / "nan.json", rig), std::invalid_argument);
  EXPECT_FALSE(std::filesystem::exists(f.scratch / "nan.json"));
}

TEST(RigFile, RefusesOtherFormatsAndLaterVersions) {
  const Files f;
  EXPECT_ERROR(f.rig("\"version\": 1", "\"version\": 2"), kUnsupported,
               "rig.json:3: version: version 2 was written by a newer procam");
  EXPECT_ERROR(f.rig("\"version\": 1", "\"version\": 0"), kInput, "version: there is no version 0");
  EXPECT_ERROR(f.rig("procam-rig", "procam-surfaces"), kInput,
               "the file is a 'procam-surfaces' and not a 'procam-rig'");
  EXPECT_ERROR(load_rig(f.scratch.write("x.json", "[1, 2]")), kInput,
               "x.json:1: it is a list where a group of fields");
  EXPECT_ERROR(load_rig(f.scratch.write("x.json", "")), kInput, "x.json:1: it is not valid JSON");
  EXPECT_ERROR(load_rig(f.scratch.write("x.json", "{\n  \"format\": \"procam-rig\",\n  \"version\" 1}")),
               kInput, "x.json:3: version: it is not valid JSON at column 13");
  EXPECT_ERROR(load_rig(f.scratch.write("x.json", std::string(100000, '['))), kInput, "nested deeper");
  const auto nested = [](int depth) {
    return std::string(std::size_t(depth), '[') + std::string(std::size_t(depth), ']');
  };
  EXPECT_NO_THROW(parse_json(nested(limits::kDocumentDepth), "x.json"));
  EXPECT_ERROR(parse_json(nested(limits::kDocumentDepth + 1), "x.json"), kInput, "deeper than 32 levels");
  EXPECT_ERROR(load_rig(f.scratch / "absent.json"), kIo, "absent.json");
  EXPECT_ERROR(save_rig(f.scratch / "rig.json/rig.json", test::example_rig()), kIo, "cannot write");
}

TEST(RigFile, RefusesACovarianceThatIsNone) {
  const Scratch scratch;
  const auto refused = [&](auto change) {
    Rig rig = test::example_rig();
    change(rig.covariance);
    // What cannot be read is not written either.
    EXPECT_THROW(save_rig(scratch / "rig.json", rig), std::invalid_argument);
  };
  refused([](NamedCovariance& c) { c.matrix(0, 1) += 0.1 * std::sqrt(c.matrix(0, 0) * c.matrix(1, 1)); });
  refused([](NamedCovariance& c) { c.matrix(2, 2) *= -1; });
  refused([](NamedCovariance& c) { c.matrix(3, 3) = 0; });
  refused([](NamedCovariance& c) {  // each pair is possible, the three together are not
    const VecX sigmas = c.matrix.diagonal().cwiseSqrt();
    for (const auto& [i, j, correlation] :
         {std::tuple(0, 1, 0.9), std::tuple(1, 2, 0.9), std::tuple(0, 2, -0.9)})
      c.matrix(i, j) = c.matrix(j, i) = correlation * sigmas[i] * sigmas[j];
  });
  refused([](NamedCovariance& c) { c.names.pop_back(); });
  refused([](NamedCovariance& c) { c.names[0] = "left.fz"; });
  refused([](NamedCovariance& c) { c.names[1] = c.names[0]; });
  const Files f;
  EXPECT_ERROR(f.rig("\"left.fx\"", "\"left.fz\""), kInput,
               "covariance: the rig has no parameter 'left.fz'; did you mean 'left.fx'?");
}

class SurfaceFile : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(BothSyntaxes, SurfaceFile, testing::Values("s.json", "s.xml"),
                         [](const auto& syntax) { return std::string(syntax.param).substr(2); });

TEST_P(SurfaceFile, ReadsBackEveryFieldToTheLastDigit) {
  const Scratch scratch;
  const SurfaceSet set = test::example_surfaces();
  scratch.write("roof.obj", test::kRoof);
  save_image(scratch / "leaves.png", ImageU8(5, 3, 3, 200));
  save_surfaces(scratch / GetParam(), set);
  const SurfaceSet loaded = load_surfaces(scratch / GetParam());
  ASSERT_EQ(loaded.surfaces.size(), set.surfaces.size());
  const auto& planar = std::get<PlanarSurface>(set.surfaces[0].geometry);
  const auto& loaded_planar = std::get<PlanarSurface>(loaded.surfaces[0].geometry);
  EXPECT_EQ(loaded.surfaces[0].name, "wall");
  EXPECT_EQ(loaded.surfaces[0].content, set.surfaces[0].content);
  EXPECT_EQ(loaded.surfaces[0].weights, set.surfaces[0].weights);
  EXPECT_EQ(loaded_planar.frame, "rig");
  EXPECT_EQ(loaded_planar.content, planar.content);
  EXPECT_EQ(loaded_planar.points, planar.points);
  EXPECT_EQ(loaded_planar.frame_from_surface.matrix(), planar.frame_from_surface.matrix());
  EXPECT_EQ(std::get<PixelSurface>(loaded.surfaces[1].geometry).pixels,
            std::get<PixelSurface>(set.surfaces[1].geometry).pixels);
  EXPECT_EQ(std::get<GridSurface>(loaded.surfaces[2].geometry).points,
            std::get<GridSurface>(set.surfaces[2].geometry).points);
  EXPECT_EQ(std::get<BezierSurface>(loaded.surfaces[3].geometry).rows, 3);
  EXPECT_EQ(std::get<CylinderSurface>(loaded.surfaces[4].geometry).right, 71 * kDegree);
  EXPECT_EQ(std::get<SphereSurface>(loaded.surfaces[5].geometry).seen_from, SeenFrom::kInside);
  const auto roof = std::get<MeshSurface>(loaded.surfaces[6].geometry);
  ASSERT_TRUE(roof.mesh);
  EXPECT_LT((roof.mesh->vertices.at(1) - Vec3(0.7, 0.03, 0)).norm(), 1e-15);
  EXPECT_EQ(roof.mesh->uv.at(2), Vec2(0.25, 1));
  for (const std::size_t i : {7u, 8u}) {
    const auto& bent = std::get<PixelSurface>(set.surfaces[i].geometry);
    const auto& loaded_bent = std::get<PixelSurface>(loaded.surfaces.at(i).geometry);
    EXPECT_EQ(loaded_bent.shape, bent.shape);
    EXPECT_EQ(loaded_bent.pixels, bent.pixels);
    EXPECT_EQ(loaded_bent.columns, bent.columns);
    EXPECT_EQ(loaded_bent.rows, bent.rows);
    EXPECT_TRUE(loaded_bent.content.empty());
  }
  const Surface &wall = set.surfaces[0], &loaded_wall = loaded.surfaces[0];
  EXPECT_EQ(loaded_wall.layout.fit, Fit::kCover);
  EXPECT_EQ(loaded_wall.layout.crop_from, wall.layout.crop_from);
  EXPECT_EQ(loaded_wall.layout.crop_to, wall.layout.crop_to);
  EXPECT_EQ(loaded_wall.shape.outline, wall.shape.outline);
  EXPECT_EQ(loaded_wall.shape.holes, wall.shape.holes);
  EXPECT_EQ(loaded.surfaces[1].layout.fit, Fit::kContain);
  EXPECT_TRUE(loaded.surfaces[2].shape.is_whole());
  ASSERT_TRUE(loaded.surfaces[6].shape.mask);
  EXPECT_EQ(loaded.surfaces[6].shape.mask->size(), (ImageSize{5, 3}));
  EXPECT_EQ(loaded.surfaces[6].shape.mask->channels(), 1);
  // The other syntax holds the same data.
  save_surfaces(scratch / "again.json", loaded);
  save_surfaces(scratch / "direct.json", set);
  EXPECT_EQ(read_file(scratch / "again.json"), read_file(scratch / "direct.json"));
}

TEST_P(SurfaceFile, ReadsBackSolvedSurfaces) {
  const Scratch scratch;
  const SolvedSurfaceSet set = test::example_solved_surfaces();
  scratch.write("roof.obj", test::kRoof);
  save_image(scratch / "leaves.png", ImageU8(5, 3, 3, 200));
  save_solved_surfaces(scratch / GetParam(), set);
  const SolvedSurfaceSet loaded = load_solved_surfaces(scratch / GetParam());
  ASSERT_EQ(loaded.surfaces.size(), set.surfaces.size());
  for (std::size_t i : {7u, 8u}) {
    const std::shared_ptr<const Mesh> mesh = std::get<PlacedPixels>(loaded.surfaces.at(i).placement).mesh;
    ASSERT_TRUE(mesh) << "drawn as triangles again";
    EXPECT_EQ(mesh->vertices[0].head<2>(), Vec2(31.5, 40));
  }
  for (std::size_t i = 2; i < 7; ++i)
    EXPECT_TRUE(std::get<PlacedMesh>(loaded.surfaces[i].placement).mesh) << "drawn as triangles again";
  EXPECT_EQ(std::get<PlacedPlane>(loaded.surfaces[0].placement).plane_from_content,
            std::get<PlacedPlane>(set.surfaces[0].placement).plane_from_content);
  EXPECT_EQ(loaded.surfaces[0].corners_px, set.surfaces[0].corners_px);
  EXPECT_FALSE(loaded.surfaces[1].corners_px.has_value());
  EXPECT_EQ(loaded.surfaces[0].diagnostics.items[0].severity, Severity::kWarning);
  EXPECT_FALSE(loaded.surfaces[1].visibility.facing);
  save_solved_surfaces(scratch / "again.json", loaded);
  save_solved_surfaces(scratch / "direct.json", set);
  EXPECT_EQ(read_file(scratch / "again.json"), read_file(scratch / "direct.json"));
}

TEST(SurfaceJson, RefusesShapesThatCannotBe) {
  const Files f;
  const auto refuses = [&](const std::string& from, const std::string& to, const std::string& why) {
    EXPECT_ERROR(f.surfaces("s.json", from, to), kInput, why);
  };
  refuses("\"radius_m\": 0.43", "\"radius_m\": -0.43", "surfaces[4].kind: its radius is not positive");
  refuses("[-50, 71]", "[71, -50]", "surfaces[4].kind: its angles do not grow");
  refuses("[41, -67]", "[91, -67]", "surfaces[5].kind: its latitudes");
  refuses("\"columns\": 3", "\"columns\": 4", "surfaces[2].kind: it does not have columns x rows points");
  refuses("\"metres_per_unit\": 0.001", "\"metres_per_unit\": 0",
          "surfaces[6].metres_per_unit: it is not positive");
  refuses("\"inside\"", "\"insight\"",
          "surfaces[5].seen_from: there is no 'insight' here; did you mean 'inside'?");
  refuses("\"columns\": 4", "\"columns\": 5",
          "surfaces[7].points_px: it does not have columns x rows points");
  refuses("\"columns\": 4", "\"columns\": 1",
          "surfaces[7].points_px: it has fewer than 2 or more than 16 columns or rows");
  refuses("\"rows\": 4", "\"rows\": 17",
          "surfaces[8].points_px: it has fewer than 2 or more than 16 columns or rows");
  refuses("\"shape\": \"bezier\"", "\"shape\": \"bezir\"",
          "surfaces[8].shape: there is no 'bezir' here; did you mean 'bezier'?");
  refuses("\"shape\": \"grid\"", "\"shape\": \"flat\"", "surfaces[7].shape: there is no 'flat'");
  EXPECT_ERROR(f.surfaces("s.json", "leaves.png", "twigs.png"), kIo, "twigs.png");
  EXPECT_ERROR(f.surfaces("s.json", "\"cover\"", "\"covers\""), kInput, "there is no 'covers' here");
  EXPECT_ERROR(f.surfaces("s.json", "[0.125, 0.25, 1, 0.875]", "[0.125, 0.25, 1]"), kInput,
               "surfaces[0].layout.crop: it does not have 4 numbers");
  EXPECT_ERROR(f.surfaces("s.json", "[0.125, 0.25, 1, 0.875]", "[0.125, 0.9, 1, 0.875]"), kInput,
               "surfaces[0].layout.crop: it has no area");
  EXPECT_ERROR(f.surfaces("s.json", "[0.75, 1]", "[0.25, 0]"), kInput,
               "surfaces[0].layout.outline: the outline crosses or touches itself");
  EXPECT_ERROR(f.surfaces("s.json", "[0.375, 0.3]", "[0.375, 1.3]"), kInput,
               "surfaces[0].layout.outline: hole 0 has a corner outside 0 .. 1");
  EXPECT_ERROR(f.surfaces("s.json", "roof.obj", "wall.obj"), kIo, "wall.obj");
}

TEST_P(SurfaceFile, NamesFileLineAndField) {
  const Files f;
  const std::string name = GetParam();
  const bool xml = name == "s.xml";
  const auto loads = [&](const std::string& json, const std::string& xml_text, const std::string& json_to,
                         const std::string& xml_to) {
    return f.surfaces(name, xml ? xml_text : json, xml ? xml_to : json_to);
  };
  EXPECT_ERROR(
      loads("\"version\": 1", "version=\"1\"", "\"version\": 7", "version=\"7\""), kUnsupported,
      xml ? "s.xml:2: version: version 7 was written by a newer procam" : "s.json:3: version: version 7");
  EXPECT_ERROR(loads("[1.25, 0.01]", "1.25 0.01", "[1.25]", "1.25"), kInput,
               xml ? "s.xml:32: surfaces[0].points[1].at_m: it has 1 numbers"
                   : "s.json:42: surfaces[0].points[1].at_m: it has 1 numbers");
  EXPECT_ERROR(loads("\"weight\": 2", "weight=\"2\"", "\"wieght\": 2", "wieght=\"2\""), kInput,
               "surfaces[0].points[1].wieght: unknown field 'wieght'; did you mean 'weight'?");
  EXPECT_ERROR(loads(", \"weight\": 2", " weight=\"2\"", "", ""), kInput, "4 of 5 points have a weight");
  EXPECT_ERROR(loads("\"weight\": 2", "weight=\"2\"", "\"weight\": 0", "weight=\"0\""), kInput,
               "weight: it is not positive");
  EXPECT_ERROR(loads("\"planar\"", "\"planar\"", "\"planer\"", "\"planer\""), kInput,
               "surfaces[0].kind: there is no 'planer' here; did you mean 'planar'?");
  EXPECT_ERROR(loads("\"rig\"", "\"rig\"", "\"wrold\"", "\"wrold\""), kInput,
               "surfaces[0].frame: there is no 'wrold'");
  EXPECT_ERROR(loads("[1.25, 0.01]", "1.25 0.01", "[1e999, 0]", "1e999 0"), kInput, "finite");
  EXPECT_ERROR(loads("[1.25, 0.01]", "1.25 0.01", "[NaN, 0]", "NaN 0"), kInput, "finite");
  EXPECT_ERROR(loads("hand placed", "hand placed", "wall", "wall"), kInput, "two surfaces are named 'wall'");
  EXPECT_ERROR(load_solved_surfaces(f.scratch / name), kInput, "the file is a 'procam-surfaces'");
  EXPECT_ERROR(load_solved_surfaces(f.scratch / name), kInput, "run solve-surfaces on it first");
}

TEST(SurfaceJson, TheLimitIsOfSurfaces) {
  SurfaceSet set;
  Surface surface;
  PixelSurface pixels;
  pixels.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  pixels.pixels = {{10, 20}, {200, 30}, {210, 190}, {15, 180}};
  surface.geometry = pixels;
  for (std::size_t i = 0; i < limits::kSurfaces; ++i) {
    surface.name = "area " + std::to_string(i);
    set.surfaces.push_back(surface);
  }
  const std::string largest = surfaces_to_text(set);
  EXPECT_EQ(surfaces_from_text(largest, "s.json").surfaces.size(), limits::kSurfaces);
  std::string larger = largest;
  const std::size_t second = larger.find("\"name\": \"area 0\"");
  const std::size_t begin = larger.rfind('{', second), end = larger.find("\"name\": \"area 1\"");
  std::string first = larger.substr(begin, larger.rfind('{', end) - begin);
  first.replace(first.find("area 0"), 6, "one more");
  larger.insert(begin, first);
  EXPECT_ERROR(surfaces_from_text(larger, "s.json"), kInput, "it has 1001 surfaces, and a set at most 1000");
}

TEST(SurfaceXml, IsReadAsPeopleWriteIt) {
  const Scratch scratch;
  const SurfaceSet set = load_surfaces(scratch.write("s.xml", R"(<!-- by hand -->
<procam-surfaces>
  <version>1</version>
  <surfaces>
    <surface kind="pixels">
      <name>floor &amp; <![CDATA[door]]></name>
      <points>
        <point><content>0 0</content><at_px> 1.5
           2 </at_px></point>
      </points>
    </surface>
  </surfaces>
</procam-surfaces>)"));
  EXPECT_EQ(set.surfaces.at(0).name, "floor & door");
  EXPECT_EQ(std::get<PixelSurface>(set.surfaces[0].geometry).pixels.at(0), Vec2(1.5, 2));
  const auto load = [&](const std::string& text) { return load_surfaces(scratch.write("s.xml", text)); };
  EXPECT_TRUE(load("<procam-surfaces version='1'><surfaces/></procam-surfaces>").surfaces.empty());
  EXPECT_ERROR(load("<procam-surfaces version='1'><surfaces><surfac/></surfaces></procam-surfaces>"), kInput,
               "surfaces[0]: there is 'surfac' in a list of 'surface'");
  EXPECT_ERROR(load("<procam-surfaces version='1' version='1'><surfaces/></procam-surfaces>"), kInput,
               "given twice");
  EXPECT_ERROR(load("<procam-surfaces version='1'>\n stray <surfaces/></procam-surfaces>"), kInput,
               "text stands beside");
  EXPECT_ERROR(load("<!DOCTYPE x [<!ENTITY a 'b'>]><procam-surfaces/>"), kInput, "document type");
  EXPECT_ERROR(load("<a/><b/>"), kInput, "second root");
  EXPECT_ERROR(load("<procam-surfaces version='1'>\n<surfaces>"), kInput, "it is not valid XML");
  EXPECT_ERROR(load("<procam-surfaces version='1' x='&#1;'/>"), kInput, "control characters");
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "<a b='1'>";
  for (int i = 0; i < 100000; ++i) deep += "</a>";
  EXPECT_ERROR(load(deep), kInput, "nested deeper");
  EXPECT_ERROR(load_surfaces(scratch / "s.yaml"), kUnsupported, ".json or .xml");
}

TEST(PoseFile, ReadsBackWithAndWithoutCovariance) {
  const Scratch scratch;
  FrameTree::Link pose = test::example_pose();
  save_pose(scratch / "p.json", pose);
  const FrameTree::Link loaded = load_pose(scratch / "p.json");
  EXPECT_EQ(loaded.target, "projector");
  EXPECT_EQ(loaded.source, "world");
  EXPECT_EQ(loaded.target_from_source.pose.matrix(), pose.target_from_source.pose.matrix());
  EXPECT_EQ(loaded.target_from_source.covariance, pose.target_from_source.covariance);
  pose.target_from_source.covariance.setZero();
  save_pose(scratch / "p.json", pose);
  EXPECT_EQ(read_file(scratch / "p.json").find("covariance"), std::string::npos);
  EXPECT_TRUE(load_pose(scratch / "p.json").target_from_source.covariance.isZero(0));
  const std::string text = read_file(scratch / "p.json");
  EXPECT_ERROR(load_pose(scratch.write("p.json", replaced(text, "\"world\"", "\"projector\""))), kInput,
               "p.json:5: source: target and source are not the names of two frames");
}

}  // namespace
}  // namespace procam::io
