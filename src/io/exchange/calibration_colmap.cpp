#include <algorithm>
#include <sstream>

#include "document/number.hpp"
#include "exchange/calibration_readers.hpp"
#include "procam/io/text.hpp"

namespace procam::io {
namespace {

/// How a model's parameters are procam's: one focal length or two, the principal point, then coefficients.
struct Model {
  const char* name;
  int focal_lengths;
  std::size_t coefficients;
  Distortion lens;
};
const std::vector<Model>& models() {
  static const std::vector<Model> known{{"SIMPLE_PINHOLE", 1, 0, NoDistortion{}},
                                        {"PINHOLE", 2, 0, NoDistortion{}},
                                        {"SIMPLE_RADIAL", 1, 1, BrownConrady{}},
                                        {"RADIAL", 1, 2, BrownConrady{}},
                                        {"OPENCV", 2, 4, BrownConrady{}},
                                        {"FULL_OPENCV", 2, 8, RationalDistortion{}},
                                        {"OPENCV_FISHEYE", 2, 4, FisheyeDistortion{}},
                                        // theta (1 + k1 theta^2 + k2 theta^4), as the first terms of it.
                                        {"SIMPLE_RADIAL_FISHEYE", 1, 1, FisheyeDistortion{}},
                                        {"RADIAL_FISHEYE", 1, 2, FisheyeDistortion{}}};
  return known;
}

std::vector<std::string> words_in(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; words.size() < 100 && stream >> word;) words.push_back(word);
  return words;
}

bool is_whole(const std::string& word) {
  return !word.empty() && word.size() < 10 && word.find_first_not_of("0123456789") == std::string::npos;
}

/// The lines that are no comments, with their numbers; not more than two.
std::vector<std::pair<int, std::vector<std::string>>> lines_of(std::string_view bytes) {
  std::istringstream stream{std::string(bytes)};
  std::vector<std::pair<int, std::vector<std::string>>> lines;
  int number = 0;
  for (std::string line; lines.size() < 2 && std::getline(stream, line);) {
    ++number;
    std::vector<std::string> words = words_in(line);
    if (!words.empty() && words[0][0] != '#') lines.emplace_back(number, std::move(words));
  }
  return lines;
}

}  // namespace

bool is_colmap(std::string_view bytes) {
  const auto lines = lines_of(bytes);
  if (lines.empty() || lines[0].second.size() < 5) return false;
  const std::vector<std::string>& words = lines[0].second;
  return is_whole(words[0]) && is_whole(words[2]) && is_whole(words[3]) &&
         words[1].find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ_") == std::string::npos;
}

Rig read_colmap(std::string_view bytes, const std::string& file) {
  const auto lines = lines_of(bytes);
  const auto& [number, words] = lines.front();
  const auto fail = [&, line = number](const std::string& why, const std::string& next,
                                       ErrorKind kind = ErrorKind::kInput) {
    return Error(kind, file + ":" + std::to_string(line), why, next);
  };
  if (lines.size() > 1)
    throw fail("it lists several cameras, and cameras.txt holds no poses", "keep the line of one camera");
  const auto model = std::find_if(models().begin(), models().end(),
                                  [name = &words[1]](const Model& m) { return *name == m.name; });
  if (model == models().end()) {
    std::vector<std::string> names;
    for (const Model& known : models()) names.emplace_back(known.name);
    throw fail("procam has no camera model '" + words[1].substr(0, 40) + "'", suggest(words[1], names),
               ErrorKind::kUnsupported);
  }
  std::vector<double> values;
  for (std::size_t i = 4; i < words.size(); ++i) {
    const std::optional<double> value = parse_number(words[i]);
    if (!value)
      throw fail("'" + words[i].substr(0, 40) + "' is no number", "give the file as COLMAP writes it");
    values.push_back(*value);
  }
  const std::size_t before = std::size_t(model->focal_lengths) + 2;
  if (values.size() != before + model->coefficients)
    throw fail(words[1] + " has " + std::to_string(before + model->coefficients) + " parameters, not " +
                   std::to_string(values.size()),
               "give the file as COLMAP writes it");
  if (model->focal_lengths == 1) values.insert(values.begin(), values.front());
  if (!(values[0] > 0 && values[1] > 0))
    throw fail("its focal lengths are not positive", "give the file as COLMAP writes it");

  RigCamera camera;
  camera.camera.size = parse_size(words[2] + "x" + words[3]);
  camera.camera.intrinsics = {values[0], values[1], values[2] - 0.5, values[3] - 0.5, 0};
  values.resize(4 + coefficients_of(model->lens).size(), 0.0);
  camera.camera.distortion = with_coefficients(model->lens, {values.begin() + 4, values.end()});
  Rig rig;
  rig.provenance.tool = "COLMAP";
  rig.cameras.push_back(camera);
  return rig;
}

}  // namespace procam::io
