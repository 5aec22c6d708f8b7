#include "procam/io/session/observations_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "document/number.hpp"
#include "document/table.hpp"
#include "document/value.hpp"
#include "extension.hpp"
#include "image/npy.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/core/board/board_artwork.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/text.hpp"
#include "session/observations_text.hpp"

namespace procam::io {
namespace {

constexpr double kDefaultSigma = 0.1;  // pixels, as Observation::covariance begins
constexpr const char* kNextTable =
    "give the columns view, device, point (or x, y, z), u, v and, where known, sigma; see "
    "docs/file-formats.md";

enum Column {
  kView,
  kDevice,
  kPoint,
  kX,
  kY,
  kZ,
  kU,
  kV,
  kSigma,
  kVarU,
  kCovUV,
  kVarV,
  kCamera,
  kCorrelated,
  kColumns
};
const std::array<const char*, kColumns> kNames{"view",   "device", "point",  "x",         "y",
                                               "z",      "u",      "v",      "sigma",     "var_u",
                                               "cov_uv", "var_v",  "camera", "correlated"};

/// One row before its device and point are known.
struct Row {
  std::string where;  ///< "file, line 7"
  std::string view, device, camera;
  int point = 0;
  Vec3 position = Vec3::Zero();
  Vec2 pixel = Vec2::Zero();
  Mat2 covariance = kDefaultSigma * kDefaultSigma * Mat2::Identity();
  bool correlated = true;  ///< with the camera's corner; of a projector's pixel
};

struct Table {
  std::string name;
  bool by_position = false;  ///< x, y, z instead of point
  std::vector<Row> rows;
  ObservationsContext stated;  ///< by the file itself
};

[[noreturn]] void fail_table(const std::string& where, const std::string& why,
                             const std::string& next = kNextTable) {
  throw Error(ErrorKind::kInput, where, why, next);
}

/// Position of every column in the file; -1 for those that are absent.
std::array<int, kColumns> find_columns(const std::vector<std::string>& names, const std::string& where) {
  std::array<int, kColumns> at{};
  at.fill(-1);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto known = std::find(kNames.begin(), kNames.end(), names[i]);
    if (known == kNames.end())
      fail_table(where, "there is no column '" + names[i].substr(0, 40) + "'",
                 suggest(names[i], {kNames.begin(), kNames.end()}));
    int& place = at[std::size_t(known - kNames.begin())];
    if (place >= 0) fail_table(where, "the column '" + names[i] + "' stands there twice");
    place = int(i);
  }
  for (const Column column : {kView, kDevice, kU, kV})
    if (at[column] < 0) fail_table(where, std::string("the column '") + kNames[column] + "' is missing");
  const int positions = (at[kX] >= 0) + (at[kY] >= 0) + (at[kZ] >= 0);
  const int covariances = (at[kVarU] >= 0) + (at[kCovUV] >= 0) + (at[kVarV] >= 0);
  if ((at[kPoint] >= 0) == (positions > 0) || (positions != 0 && positions != 3))
    fail_table(where, "a point is named by the column 'point' or by the columns x, y and z");
  if ((covariances != 0 && covariances != 3) || (covariances > 0 && at[kSigma] >= 0))
    fail_table(where, "the uncertainty is the column 'sigma' or the columns var_u, cov_uv and var_v");
  return at;
}

/// Numbers of one row by column, wherever they come from, with their checks.
template <typename Number>
Row read_row(const std::array<int, kColumns>& at, const std::string& where, Number number) {
  Row row;
  row.where = where;
  row.pixel = Vec2(number(kU), number(kV));
  if (at[kPoint] >= 0) {
    const double point = number(kPoint);
    if (point != std::floor(point) || std::abs(point) > 1e9)
      fail_table(where, "column point is no whole number");
    row.point = int(point);
  } else {
    row.position = Vec3(number(kX), number(kY), number(kZ));
  }
  if (at[kSigma] >= 0) {
    const double sigma = number(kSigma);
    if (!(sigma > 1e-6 && sigma < 1e3))
      fail_table(where, "column sigma is not between 0.000001 and 1000 pixels");
    row.covariance = sigma * sigma * Mat2::Identity();
  }
  if (at[kCorrelated] >= 0) {
    const double correlated = number(kCorrelated);
    if (correlated != 0 && correlated != 1) fail_table(where, "column correlated is neither 0 nor 1");
    row.correlated = correlated == 1;
  }
  if (at[kVarU] >= 0) {
    const double uu = number(kVarU), uv = number(kCovUV), vv = number(kVarV);
    row.covariance << uu, uv, uv, vv;
    if (!(uu > 1e-12 && vv > 1e-12 && uu < 1e6 && vv < 1e6 && uu * vv - uv * uv > 1e-9 * uu * vv))
      fail_table(where, "var_u, cov_uv, var_v are no covariance of pixels: it is to be positive definite");
  }
  return row;
}

/// "# camera: left 1280x1024".
void read_statement(const std::string& comment, const std::string& where, ObservationsContext& stated) {
  const std::size_t colon = comment.find(':');
  if (colon == std::string::npos) return;
  const std::string keyword = trimmed(comment.substr(0, colon)), value = trimmed(comment.substr(colon + 1));
  if (keyword != "board" && keyword != "camera" && keyword != "projector") return;
  try {
    if (keyword == "board") {
      stated.board = parse_board(value);
      return;
    }
    const std::size_t blank = value.find_last_of(" \t");
    if (blank == std::string::npos)
      fail_table(where, "it does not give a name and a size", "write e.g. # camera: left 1280x1024");
    stated.devices.push_back({trimmed(value.substr(0, blank)),
                              keyword == "camera" ? DeviceKind::kCamera : DeviceKind::kProjector,
                              parse_size(value.substr(blank + 1))});
  } catch (const Error& error) {
    throw Error(error.kind(), where, error.subject() + ": " + error.why(), error.next());
  }
}

Table table_of_csv(const std::string& text, const std::string& name) {
  Table table{name, false, {}, {}};
  std::array<int, kColumns> at{};
  std::size_t columns = 0;
  int line = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string content = trimmed(text.substr(begin, end - begin));
    begin = end + 1;
    ++line;
    const std::size_t hash = content.find('#');
    const std::string where = name + ", line " + std::to_string(line);
    if (hash == 0) {
      read_statement(content.substr(1), where, table.stated);
      continue;
    }
    const std::string values = trimmed(content.substr(0, hash));
    if (values.empty()) continue;
    const std::vector<std::string> cells = cells_of(values);
    if (columns == 0) {
      columns = cells.size();
      at = find_columns(cells, where);
      table.by_position = at[kX] >= 0;
      continue;
    }
    if (cells.size() != columns)
      fail_table(where, "it has " + std::to_string(cells.size()) + " columns where the first line names " +
                            std::to_string(columns));
    if (table.rows.size() >= limits::kTableRows)
      fail_table(name, "it has more than " + std::to_string(limits::kTableRows) + " rows",
                 "give one session a file");
    const auto number = [&](Column column) {
      const std::string& cell = cells[std::size_t(at[column])];
      const auto value = parse_number(cell);
      if (!value)
        fail_table(where,
                   std::string("column ") + kNames[column] + " is no number: '" + cell.substr(0, 40) + "'");
      return *value;
    };
    Row row = read_row(at, where, number);
    row.view = cells[std::size_t(at[kView])];
    row.device = cells[std::size_t(at[kDevice])];
    if (at[kCamera] >= 0) row.camera = cells[std::size_t(at[kCamera])];
    for (const Column column : {kView, kDevice})
      if (cells[std::size_t(at[column])].empty())
        fail_table(where, std::string("column ") + kNames[column] + " is empty");
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table table_of_npy(const NpyArray& array, const std::string& name) {
  if (array.shape.size() != 2)
    fail_table(name, "it is no table: it has " + std::to_string(array.shape.size()) + " dimensions");
  const std::size_t columns = array.shape[1], rows = array.shape[0];
  std::vector<std::string> names = array.columns;
  if (names.empty()) {
    if (columns < 5 || columns > 8)
      fail_table(name, "an array of " + std::to_string(columns) + " columns has no meaning here",
                 "give view, device, point, u, v [, sigma] or view, device, x, y, z, u, v [, sigma]");
    names = {"view", "device"};
    if (columns <= 6)
      names.emplace_back("point");
    else
      names.insert(names.end(), {"x", "y", "z"});
    names.insert(names.end(), {"u", "v"});
    if (columns % 2 == 0) names.emplace_back("sigma");
  }
  if (rows > limits::kTableRows)
    fail_table(name, "it has more than " + std::to_string(limits::kTableRows) + " rows");
  const std::array<int, kColumns> at = find_columns(names, name);
  Table table{name, at[kX] >= 0, {}, {}};
  for (std::size_t r = 0; r < rows; ++r) {
    const std::string where = name + ", row " + std::to_string(r);
    const auto number = [&](Column column) {
      const double value = array.values[r * columns + std::size_t(at[column])];
      if (!std::isfinite(value))
        fail_table(where, std::string("column ") + kNames[column] + " is not finite");
      return value;
    };
    const auto index = [&](Column column) -> std::string {
      const double value = number(column);
      if (value != std::floor(value) || value < 0 || value > 1e6)
        fail_table(where, std::string("column ") + kNames[column] + " is no whole number from 0");
      return std::to_string(int(value));
    };
    Row row = read_row(at, where, number);
    row.view = index(kView);
    row.device = index(kDevice);
    if (at[kCamera] >= 0) row.camera = index(kCamera);
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// Cameras first, then projectors.
std::vector<Device> devices_of(const Table& table, const ObservationsContext& context) {
  std::vector<Device> all = context.devices;
  for (const Device& device : table.stated.devices)
    if (std::none_of(all.begin(), all.end(), [&](const Device& d) { return d.name == device.name; }))
      all.push_back(device);
  std::stable_sort(all.begin(), all.end(), [](const Device& a, const Device& b) {
    return a.kind == DeviceKind::kCamera && b.kind == DeviceKind::kProjector;
  });
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (all[i].name == all[j].name) fail_table(table.name, "two devices are called '" + all[i].name + "'");
  if (all.empty() || all.front().kind != DeviceKind::kCamera)
    fail_table(table.name, "the size of the camera's images is not given",
               "give --camera-size 1280x1024, or the line \"# camera: camera 1280x1024\"");
  return all;
}

/// By name, else by number.
int device_index(const std::vector<Device>& devices, const std::string& text, const std::string& where) {
  std::string names;
  for (std::size_t d = 0; d < devices.size(); ++d) {
    if (devices[d].name == text) return int(d);
    names += (d > 0 ? ", " : "") + devices[d].name;
  }
  const auto number = parse_number(text);
  if (number && *number == std::floor(*number) && *number >= 0 && *number < double(devices.size()))
    return int(*number);
  fail_table(where, "no size is given for the device '" + text.substr(0, 40) + "' (known: " + names + ")",
             "give --camera-size or --projector-size " + text.substr(0, 40) +
                 "=1024x768, or a line \"# projector: " + text.substr(0, 40) + " 1024x768\"");
}

/// Values of one coordinate, sorted, each once (to a micrometre).
std::vector<double> grid_lines(const std::vector<Row>& rows, int axis) {
  std::vector<double> values;
  for (const Row& row : rows) values.push_back(row.position[axis]);
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end(), [](double a, double b) { return b - a < 1e-6; }),
               values.end());
  return values;
}

/// The chessboard whose corners the positions are.
Board board_of_grid(const Table& table) {
  const std::string next = "give --board, e.g. chessboard:7x9:75mm, and points by their index or position";
  const std::vector<double> x = grid_lines(table.rows, 0), y = grid_lines(table.rows, 1);
  if (x.size() < 2 || y.size() < 2 || x.size() > 1000 || y.size() > 1000)
    fail_table(table.name, "its positions are no grid of rows and columns", next);
  const double step = (x.back() - x.front()) / double(x.size() - 1);
  for (const auto* lines : {&x, &y})
    for (std::size_t i = 0; i < lines->size(); ++i)
      if (std::abs((*lines)[i] - double(i) * step) > 0.01 * step)
        fail_table(table.name, "its positions are no square grid that begins at 0, 0", next);
  return Chessboard{int(x.size()), int(y.size()), step};
}

/// Index of the board's point at a position; the nearest is taken when it is within 1 % of the pitch.
class PointFinder {
 public:
  explicit PointFinder(const Board& board) : points_(points_in_board(board)), pitch_(pitch_of(board)) {
    for (std::size_t i = 0; i < points_.size(); ++i) by_cell_[cell_of(points_[i])].push_back(int(i));
  }
  int index_of(const Vec3& position, const std::string& where) const {
    if (std::abs(position.z()) > 0.01 * pitch_)
      fail_table(
          where, "its z is " + format_number(position.z()) + " m, and boards are flat",
          "give each plane of a target with several planes as a view of its own, with positions in that "
          "plane (z = 0)");
    const auto [cx, cy] = cell_of(position);
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const auto cell = by_cell_.find({cx + dx, cy + dy});
        if (cell == by_cell_.end()) continue;
        for (const int i : cell->second)
          if ((points_[std::size_t(i)] - position).norm() < 0.01 * pitch_) return i;
      }
    fail_table(where, "the board has no point at its x, y, z",
               "give positions in metres, x along a row from the board's first point, z = 0");
  }

 private:
  Points3 points_;
  double pitch_;
  std::map<std::pair<long, long>, std::vector<int>> by_cell_;

  std::pair<long, long> cell_of(const Vec3& p) const {
    const auto cell = [&](double v) { return long(std::floor(std::clamp(v / pitch_, -1e9, 1e9))); };
    return {cell(p.x()), cell(p.y())};
  }
};

void check_pixel(const Row& row, const Device& device) {
  constexpr double kRim = 1;  // a corner on the image's border may come out a little outside
  const double right = device.size.width - 0.5, bottom = device.size.height - 0.5;
  if (row.pixel.x() >= -0.5 - kRim && row.pixel.x() <= right + kRim && row.pixel.y() >= -0.5 - kRim &&
      row.pixel.y() <= bottom + kRim)
    return;
  fail_table(row.where,
             "its pixel " + format_number(row.pixel.x()) + ", " + format_number(row.pixel.y()) +
                 " is outside " + device.name + "'s " + format_size(device.size),
             "check the sizes, and that u runs to the right and v downwards");
}

/// Numbers of the pattern's points in files, -1, -2, ..., and in memory, 0, 1, ...: each is the other's.
int pattern_point(int number) {
  return -1 - number;
}

Board board_of(const Table& table, const ObservationsContext& context) {
  if (context.board) return *context.board;
  if (table.stated.board) return *table.stated.board;
  if (table.by_position) return board_of_grid(table);
  fail_table(table.name, "the board is not given", "give --board, e.g. chessboard:7x9:75mm");
}

/// Takes the rows of a table one by one.
class RowsToCorrespondences {
 public:
  RowsToCorrespondences(std::vector<Device> devices, const Board& board)
      : finder_(board), points_(int(points_in_board(board).size())) {
    data_.devices = std::move(devices);
    data_.board = board;
    cameras_ = std::count_if(data_.devices.begin(), data_.devices.end(),
                             [](const Device& d) { return d.kind == DeviceKind::kCamera; });
  }

  /// `row` must live until take(). `by_position`: its point is given by its place on the board.
  void add(const Row& row, bool by_position) {
    const std::size_t v = view_of(row.view);
    const int d = device_index(data_.devices, row.device, row.where);
    check_pixel(row, data_.devices[std::size_t(d)]);
    const Observation o = observation_of(row, d, by_position);
    if (!seen_.insert({v, d, o.camera, o.point}).second)
      fail_table(row.where, "the view has this point of this device already", "give every point once");
    if (o.point >= 0)
      data_.views[v].observations[std::size_t(d)].push_back(o);
    else
      add_shown(shown_[v][o.point], row, d);
  }

  Correspondences take() {
    for (std::size_t v = 0; v < shown_.size(); ++v)
      for (auto at = shown_[v].rbegin(); at != shown_[v].rend(); ++at)
        add_light(data_.views[v], at->first, at->second);
    return std::move(data_);
  }

 private:
  /// A point of the pattern, row by row.
  struct Shown {
    const Row* projector = nullptr;
    int device = 0;
    std::vector<std::pair<int, const Row*>> cameras;
  };

  std::size_t view_of(const std::string& name) {
    const auto [at, is_new] = views_.emplace(name, data_.views.size());
    if (is_new) {
      data_.views.push_back({name, std::vector<std::vector<Observation>>(data_.devices.size()), {}});
      shown_.emplace_back();
    }
    return at->second;
  }

  Observation observation_of(const Row& row, int device, bool by_position) const {
    Observation o;
    o.point = by_position ? finder_.index_of(row.position, row.where) : row.point;
    o.pixel = row.pixel;
    o.covariance = row.covariance;
    if (o.point >= points_)
      fail_table(row.where,
                 "point " + std::to_string(o.point) + " is not on the board " + format_board(data_.board) +
                     " of " + std::to_string(points_) + " points",
                 "points count from 0, row by row");
    if (data_.devices[std::size_t(device)].kind != DeviceKind::kProjector || o.point < 0) return o;
    if (!row.camera.empty())
      o.camera = device_index(data_.devices, row.camera, row.where);
    else if (cameras_ > 1)
      fail_table(row.where, "there are several cameras, and the row does not name the one that read it",
                 "add the column 'camera'");
    if (data_.devices[std::size_t(o.camera)].kind != DeviceKind::kCamera)
      fail_table(row.where, "'" + row.camera + "' is no camera");
    o.correlated_with_camera = row.correlated;
    return o;
  }

  void add_shown(Shown& point, const Row& row, int device) const {
    if (data_.devices[std::size_t(device)].kind == DeviceKind::kCamera) {
      point.cameras.emplace_back(device, &row);
      return;
    }
    if (point.projector != nullptr)
      fail_table(row.where, "two projectors show this point",
                 "give points of each projector numbers of their own");
    point.projector = &row;
    point.device = device;
  }

  static void add_light(View& view, int number, const Shown& point) {
    if (point.projector == nullptr || point.cameras.empty())
      fail_table(point.projector != nullptr ? point.projector->where : point.cameras.front().second->where,
                 "point " + std::to_string(number) +
                     " of the pattern needs a row of the projector and one of a camera in its view");
    for (const auto& [camera, row] : point.cameras)
      view.light_points.push_back(
          {point.device, point.projector->pixel, camera, row->pixel, row->covariance, pattern_point(number)});
  }

  Correspondences data_;
  PointFinder finder_;
  int points_ = 0;
  std::ptrdiff_t cameras_ = 0;
  std::map<std::string, std::size_t> views_;
  std::set<std::tuple<std::size_t, int, int, int>> seen_;  // view, device, camera, point
  std::vector<std::map<int, Shown>> shown_;                // by view, by negative point
};

Correspondences correspondences_of(const Table& table, const ObservationsContext& context) {
  if (table.rows.empty()) fail_table(table.name, "it has no row");
  std::vector<Device> devices = devices_of(table, context);
  RowsToCorrespondences out(std::move(devices), board_of(table, context));
  for (const Row& row : table.rows) out.add(row, table.by_position);
  return out.take();
}

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
    numbers.push_back(pattern_point(number));
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
               Mat2(kDefaultSigma * kDefaultSigma * Mat2::Identity()), false});
      write({v, light.camera, light.camera, numbers[i], light.camera_pixel, light.camera_covariance, false});
    }
  }
}

}  // namespace

Correspondences parse_observations(const std::string& text, const std::string& name,
                                   const ObservationsContext& context) {
  return correspondences_of(table_of_csv(text, name), context);
}

Correspondences load_observations(const std::filesystem::path& path, const ObservationsContext& context) {
  const std::string bytes = read_file(path, limits::kTableBytes);
  if (lower_extension(path) == ".npy")
    return correspondences_of(table_of_npy(parse_npy(bytes, path.string()), path.string()), context);
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
