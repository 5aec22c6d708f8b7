/// Rows of a table of observations -> correspondences: devices, the board's points and the pattern's points.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "document/number.hpp"
#include "procam/core/board/board_artwork.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/text.hpp"
#include "session/observations_table.hpp"

namespace procam::io::observations {
namespace {

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
  constexpr double kLargestSquare = 2;
  if (step > kLargestSquare)
    fail_table(table.name, "its positions make squares of " + format_number(step) + " m",
               "give positions in metres, not in millimetres, or --board for a board as large as that");
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
    fail_table(
        where, "the board has no point at its x, y, z",
        "give positions in metres (not millimetres), x along a row from the board's first point, z = 0");
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

/// Pixels as shares of the image (0 to 1) lie within the first pixel, all of them.
void check_unit_of_pixels(const Table& table, const std::vector<Device>& devices) {
  constexpr int kEnough = 6;
  for (std::size_t d = 0; d < devices.size(); ++d) {
    int rows = 0;
    bool is_small = true;
    for (const Row& row : table.rows) {
      if (row.device != devices[d].name && row.device != std::to_string(d)) continue;
      ++rows;
      is_small = is_small && row.pixel.minCoeff() > -0.5 && row.pixel.maxCoeff() < 1.5;
    }
    if (rows >= kEnough && is_small)
      fail_table(
          table.name, "the pixels of " + devices[d].name + " are shares of its image (0 to 1)",
          "multiply u by the width and v by the height, and subtract 0.5 from both: pixel 0, 0 is the centre of the top-left one");
  }
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

}  // namespace

Correspondences correspondences_of(const Table& table, const ObservationsContext& context) {
  if (table.rows.empty()) fail_table(table.name, "it has no row");
  std::vector<Device> devices = devices_of(table, context);
  check_unit_of_pixels(table, devices);
  RowsToCorrespondences out(std::move(devices), board_of(table, context));
  for (const Row& row : table.rows) out.add(row, table.by_position);
  return out.take();
}

}  // namespace procam::io::observations
