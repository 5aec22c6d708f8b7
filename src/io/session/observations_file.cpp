#include "procam/io/session/observations_file.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "document/number.hpp"
#include "document/trimmed.hpp"
#include "extension.hpp"
#include "image/npy.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/text.hpp"
#include "session/observations_table.hpp"
#include "session/observations_text.hpp"

namespace procam::io {
namespace {

/// The number that each point (projector, point) of the pattern has in a file, in all views, so that views can
/// be compared by it: its own, unless two projectors share one; then they are counted.
using PatternNumbers = std::map<std::pair<int, int>, int>;

PatternNumbers pattern_numbers(const Correspondences& data) {
  PatternNumbers numbers;
  std::set<int> points;
  bool is_shared = false;
  for (const View& view : data.views)
    for (const LightPoint& light : view.light_points)
      if (light.point >= 0 && numbers.emplace(std::pair(light.projector, light.point), light.point).second)
        is_shared = !points.insert(light.point).second || is_shared;
  if (!is_shared) return numbers;
  int next = 0;
  for (auto& [point, number] : numbers) number = next++;
  return numbers;
}

/// The numbers of a view's light points in a file; those without a number of their own follow. Cameras that
/// see the same point share its number.
std::vector<int> light_numbers(const View& view, const PatternNumbers& pattern) {
  std::set<std::pair<int, int>> taken;  // number and camera
  std::map<int, Vec2> shown;            // the projector's pixel by number
  std::vector<int> numbers;
  int next = 0;
  for (const auto& [point, number] : pattern) next = std::max(next, number + 1);
  for (const LightPoint& light : view.light_points) {
    const auto own = pattern.find({light.projector, light.point});
    int number = own == pattern.end() ? next : own->second;
    const auto before = shown.find(number);
    const bool is_free = own != pattern.end() && taken.count({number, light.camera}) == 0 &&
                         (before == shown.end() || before->second == light.projector_pixel);
    if (!is_free) number = next++;
    taken.insert({number, light.camera});
    shown[number] = light.projector_pixel;
    numbers.push_back(observations::pattern_point(number));
  }
  return numbers;
}

/// A name that a cell can hold.
std::string cell_text(const std::string& text) {
  std::string out = trimmed(text);
  for (char& c : out)
    if (c == ',' || c == ';' || c == '\t' || c == '#' || c == '\n' || c == '\r') c = '_';
  return out.empty() ? "_" : out;
}

/// A file has the column "correlated" when not every projector pixel was read at a camera's corner.
bool has_uncorrelated_pixel(const Correspondences& data) {
  for (const View& view : data.views)
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      for (const Observation& o : view.observations[d])
        if (data.devices[d].kind == DeviceKind::kProjector && !o.correlated_with_camera) return true;
  return false;
}

/// One row of a file. View, device and camera are indices.
struct WrittenRow {
  std::size_t view;
  int device, camera, point;
  Vec2 pixel;
  Mat2 covariance;
  bool correlated;
};

/// What both syntaxes write, row by row: write(WrittenRow).
template <typename Write>
void for_each_row(const Correspondences& data, const Write& write) {
  const PatternNumbers pattern = pattern_numbers(data);
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      for (const Observation& o : data.views[v].observations[d])
        write({v, int(d), data.devices[d].kind == DeviceKind::kCamera ? int(d) : o.camera, o.point, o.pixel,
               o.covariance, o.correlated_with_camera});
    const std::vector<int> numbers = light_numbers(data.views[v], pattern);
    std::set<int> written;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const LightPoint& light = data.views[v].light_points[i];
      if (written.insert(numbers[i]).second)
        write({v, light.projector, light.camera, numbers[i], light.projector_pixel,
               Mat2(observations::kDefaultSigma * observations::kDefaultSigma * Mat2::Identity()), false});
      write({v, light.camera, light.camera, numbers[i], light.camera_pixel, light.camera_covariance, false});
    }
  }
}

}  // namespace

Correspondences parse_observations(const std::string& text, const std::string& name,
                                   const ObservationsContext& context) {
  return observations::correspondences_of(observations::table_of_csv(text, name), context);
}

Correspondences load_observations(const std::filesystem::path& path, const ObservationsContext& context) {
  const std::string bytes = read_file(path, limits::kTableBytes);
  if (lower_extension(path) == ".npy")
    return observations::correspondences_of(
        observations::table_of_npy(parse_npy(bytes, path.string()), path.string()), context);
  return parse_observations(bytes, path.string(), context);
}

std::string format_observations(const Correspondences& data) {
  std::string text = "# board: " + format_board(data.board) + "\n";
  std::vector<std::string> devices, views;
  for (const Device& device : data.devices) {
    devices.push_back(cell_text(device.name));
    text += (device.kind == DeviceKind::kCamera ? "# camera: " : "# projector: ") + devices.back() + " " +
            format_size(device.size) + "\n";
  }
  for (const View& view : data.views) {
    views.push_back(cell_text(view.name));
    if (std::count(views.begin(), views.end(), views.back()) > 1)
      views.back() += "_" + std::to_string(views.size());
  }
  const bool with_correlation = has_uncorrelated_pixel(data);
  text += std::string("view, device, camera, point, u, v, var_u, cov_uv, var_v") +
          (with_correlation ? ", correlated\n" : "\n");
  for_each_row(data, [&](const WrittenRow& row) {
    text += views[row.view] + ", " + devices[std::size_t(row.device)] + ", " +
            devices[std::size_t(row.camera)] + ", " + std::to_string(row.point);
    for (const double number :
         {row.pixel.x(), row.pixel.y(), row.covariance(0, 0), row.covariance(0, 1), row.covariance(1, 1)})
      text += ", " + format_number(number);
    if (with_correlation) text += row.correlated ? ", 1" : ", 0";
    text += "\n";
  });
  return text;
}

void save_observations(const std::filesystem::path& path, const Correspondences& data) {
  if (lower_extension(path) != ".npy") return write_file_atomically(path, format_observations(data));
  NpyArray array;
  array.columns = {"view", "device", "camera", "point", "u", "v", "var_u", "cov_uv", "var_v"};
  const bool with_correlation = has_uncorrelated_pixel(data);
  if (with_correlation) array.columns.emplace_back("correlated");
  for_each_row(data, [&](const WrittenRow& row) {
    array.values.insert(
        array.values.end(),
        {double(row.view), double(row.device), double(row.camera), double(row.point), row.pixel.x(),
         row.pixel.y(), row.covariance(0, 0), row.covariance(0, 1), row.covariance(1, 1)});
    if (with_correlation) array.values.push_back(row.correlated);
  });
  array.shape = {array.values.size() / array.columns.size(), array.columns.size()};
  write_file_atomically(path, format_npy(array));
}

}  // namespace procam::io
