#include "regions.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>

namespace procam::depth::internal {
namespace {

constexpr int kNone = -1;

/// A region whose normal is less certain is dropped.
constexpr double kLargestDoubt = 12 * kDegree;
/// Cells without a border that a region has whose normal is believed by the measured noise.
constexpr int kInnerCells = 4;
/// Of a chi-square over its 24 or more degrees of freedom 2.5 is five sigmas away.
constexpr double kBetweenCells = 2.5;

struct Seed {
  float flatness;
  int first;  ///< the block's upper left cell
};

/// Blocks of cells that regions start from: those that say most first, then what fits into narrow surfaces.
struct Block {
  int columns, rows, step;
};
constexpr Block kBlocks[] = {{3, 3, 2}, {3, 3, 1}, {4, 1, 1}, {1, 4, 1}};

/// A block of cells that agree with one plane, or nothing.
std::optional<Seed> seed_at(const CellGrid& grid, const Block& size, int column, int row) {
  Moments block;
  double own_errors = 0;
  for (int j = 0; j < size.rows; ++j)
    for (int i = 0; i < size.columns; ++i) {
      const Cell& cell = grid.at(column + i, row + j);
      block += cell.moments;
      own_errors += double(cell.error);
    }
  const InverseDepthPlane plane = fit(block);
  for (int j = 0; j < size.rows; ++j)
    for (int i = 0; i < size.columns; ++i)
      if (!agrees(grid.at(column + i, row + j), plane.t)) return std::nullopt;
  const double freedom = 3 * (size.rows * size.columns - 1);
  return Seed{float((plane.error - own_errors) / freedom), grid.index(column, row)};
}

/// How far what readings share may turn the region's plane, radians: half of it over the region's extent in
/// its narrower direction.
double doubt(const CellGrid& grid, const Region& region, float Cell::*sigma) {
  const double shared = double(grid.cells[std::size_t(region.cells.front())].*sigma);
  return 0.5 * shared / (narrow_extent(region.moments) * region.plane.t.norm());
}

class Grower {
 public:
  Grower(const CellGrid& grid, const PlaneOptions& options) : grid_(grid), options_(options) {
    regions_.owner.assign(grid.cells.size(), kNone);
    flat_.reserve(grid.cells.size());
    for (const Cell& cell : grid.cells) flat_.push_back(cell.flat);
  }

  Regions run() {
    for (const Block& block : kBlocks) grow_from(block);
    return std::move(regions_);
  }

 private:
  /// Where blocks begin of which all cells are flat and free. Plain loops, which compilers turn into vectors.
  std::vector<char> free_blocks(const Block& block) const {
    std::vector<char> out(flat_.size());
    for (std::size_t at = 0; at < out.size(); ++at) out[at] = char(flat_[at] & (regions_.owner[at] == kNone));
    const auto and_with_next = [&](int steps, std::size_t stride) {
      // In place: what lies ahead has not been changed yet.
      for (int i = 1; i < steps; ++i)
        for (std::size_t at = 0; at + stride < out.size(); ++at) out[at] = char(out[at] & out[at + stride]);
    };
    and_with_next(block.columns, 1);
    and_with_next(block.rows, std::size_t(grid_.columns));
    return out;
  }

  void grow_from(const Block& block) {
    std::vector<Seed> seeds;
    const std::vector<char> is_free = free_blocks(block);
    for (int row = 0; row + block.rows <= grid_.rows; row += block.step)
      for (int column = 0; column + block.columns <= grid_.columns; column += block.step) {
        if (!is_free[std::size_t(grid_.index(column, row))]) continue;
        if (const auto seed = seed_at(grid_, block, column, row)) seeds.push_back(*seed);
      }
    std::sort(seeds.begin(), seeds.end(), [](const Seed& a, const Seed& b) {
      return a.flatness != b.flatness ? a.flatness < b.flatness : a.first < b.first;
    });
    for (const Seed& seed : seeds) grow(block, seed.first);
  }

  void grow(const Block& block, int first) {
    Region region;
    const int id = int(regions_.regions.size());
    for (int j = 0; j < block.rows; ++j)
      for (int i = 0; i < block.columns; ++i)
        if (regions_.owner[std::size_t(first + grid_.index(i, j))] != kNone) return;
    for (int j = 0; j < block.rows; ++j)
      for (int i = 0; i < block.columns; ++i) take(region, first + grid_.index(i, j), id);
    region.plane = fit(region.moments);
    flood(region, id);
    // The plane of all cells knows better than that of the first which of them belong.
    // Its moments are the sum over its cells in their order, until some are released.
    region.plane = fit(region.moments);
    for (int round = 0; round < 2; ++round) {
      const std::size_t before = region.cells.size();
      release(region, [&](const Cell& cell) { return !agrees(cell, region.plane.t); });
      const bool same = region.cells.size() == before;
      const InverseDepthPlane plane = region.plane;
      if (!same) refit(grid_, region.cells, region.moments, region.plane);
      // What joins next is judged by the plane that the others were.
      region.plane = plane;
      flood(region, id);
      region.plane = fit(region.moments);
      if (same && region.cells.size() == before) break;
    }
    if (int(region.cells.size()) < options_.min_cells || is_doubtful(region)) {
      release(region, [](const Cell&) { return true; });
      return;
    }
    regions_.regions.push_back(std::move(region));
  }

  /// Where the image shows that its noise averages, that is believed of regions that show the same, and not
  /// of strips: cells at a border mix the depths of both sides, and a strip of them is a plane that is not
  /// there.
  bool is_doubtful(const Region& region) const {
    if (!(doubt(grid_, region, &Cell::shared_model) > kLargestDoubt)) return false;
    return doubt(grid_, region, &Cell::shared) > kLargestDoubt || inner_cells(region) < kInnerCells ||
           between_cells(region) > kBetweenCells;
  }
  /// Mean square of what the cells' own planes are off the region's, in units of what noise that averages
  /// makes of it.
  double between_cells(const Region& region) const {
    double within = 0;
    for (const int at : region.cells) within += double(grid_.cells[std::size_t(at)].error);
    return (region.plane.error - within) / (3.0 * double(region.cells.size() - 1));
  }
  /// Cells that have only the region's own on their four sides.
  int inner_cells(const Region& region) const {
    const int id = regions_.owner[std::size_t(region.cells.front())];
    int count = 0;
    for (const int at : region.cells) {
      const int column = grid_.cells[std::size_t(at)].column;
      const auto own = [&](bool inside, int neighbour) {
        return inside && regions_.owner[std::size_t(neighbour)] == id;
      };
      count += own(column > 0, at - 1) && own(column + 1 < grid_.columns, at + 1) &&
               own(at >= grid_.columns, at - grid_.columns) &&
               own(at + grid_.columns < int(grid_.cells.size()), at + grid_.columns);
    }
    return count;
  }

  void take(Region& region, int at, int id) {
    regions_.owner[std::size_t(at)] = id;
    region.cells.push_back(at);
    region.moments += grid_.cells[std::size_t(at)].moments;
  }

  template <typename Leaves>
  void release(Region& region, const Leaves& leaves) {
    region.cells.erase(std::remove_if(region.cells.begin(), region.cells.end(),
                                      [&](int at) {
                                        if (!leaves(grid_.cells[std::size_t(at)])) return false;
                                        regions_.owner[std::size_t(at)] = kNone;
                                        return true;
                                      }),
                       region.cells.end());
  }

  void flood(Region& region, int id) {
    std::size_t next_fit = region.cells.size() + region.cells.size() / 2;
    for (std::size_t head = 0; head < region.cells.size(); ++head) {
      const int at = region.cells[head], column = grid_.cells[std::size_t(at)].column;
      const auto visit = [&](int neighbour) {
        if (regions_.owner[std::size_t(neighbour)] != kNone) return;
        if (flat_[std::size_t(neighbour)] && agrees(grid_.cells[std::size_t(neighbour)], region.plane.t))
          take(region, neighbour, id);
      };
      if (column > 0) visit(at - 1);
      if (column + 1 < grid_.columns) visit(at + 1);
      if (at >= grid_.columns) visit(at - grid_.columns);
      if (at + grid_.columns < int(grid_.cells.size())) visit(at + grid_.columns);
      if (region.cells.size() >= next_fit) {
        region.plane = fit(region.moments);
        next_fit = region.cells.size() + region.cells.size() / 2;
      }
    }
  }

  const CellGrid& grid_;
  const PlaneOptions& options_;
  std::vector<char> flat_;  ///< of each cell, where they lie close together
  Regions regions_;
};

/// RMS of the second-order part of the cells' residuals, in sigmas of what readings share; 0 where it is no
/// more than their scatter.
double second_order(const CellGrid& grid, const Region& region) {
  const Moments& m = region.moments;
  const double u0 = m.wu / m.w, v0 = m.wv / m.w;
  const double scale = 1 / std::sqrt(std::max((m.wuu + m.wvv) / m.w - u0 * u0 - v0 * v0, 1e-12));
  using Mat66 = Eigen::Matrix<double, 6, 6>;
  // Sums of n x^i y^j, by their names, and of n r x^i y^j.
  double s = 0, x1 = 0, y1 = 0, xx = 0, xy = 0, yy = 0, xxx = 0, xxy = 0, xyy = 0, yyy = 0;
  double x4 = 0, x3y = 0, xxyy = 0, xy3 = 0, y4 = 0;
  Vec6 b = Vec6::Zero();
  double total = 0;
  for (const int at : region.cells) {
    const Cell& cell = grid.cells[std::size_t(at)];
    const double x = scale * (double(cell.u) - u0), y = scale * (double(cell.v) - v0), n = cell.n;
    const double r = (double(cell.q) - region.plane.at(double(cell.u), double(cell.v))) / double(cell.shared);
    const double nx = n * x, ny = n * y, nxx = nx * x, nxy = nx * y, nyy = ny * y;
    s += n, x1 += nx, y1 += ny, xx += nxx, xy += nxy, yy += nyy;
    xxx += nxx * x, xxy += nxx * y, xyy += nyy * x, yyy += nyy * y;
    x4 += nxx * x * x, x3y += nxx * x * y, xxyy += nxx * y * y, xy3 += nyy * y * x, y4 += nyy * y * y;
    b[0] += n * r, b[1] += nx * r, b[2] += ny * r, b[3] += nxx * r, b[4] += nxy * r, b[5] += nyy * r;
    total += n * r * r;
  }
  Mat66 a;
  a << s, x1, y1, xx, xy, yy,        //
      x1, xx, xy, xxx, xxy, xyy,     //
      y1, xy, yy, xxy, xyy, yyy,     //
      xx, xxx, xxy, x4, x3y, xxyy,   //
      xy, xxy, xyy, x3y, xxyy, xy3,  //
      yy, xyy, yyy, xxyy, xy3, y4;
  const double n = std::max(m.n, 1.0);
  const Mat3 a3 = a.topLeftCorner<3, 3>();
  const Vec3 b3 = b.head<3>();
  const double linear = total - b3.dot(a3.ldlt().solve(b3));
  const double quadratic = total - b.dot(Mat66(a + 1e-9 * n * Mat66::Identity()).ldlt().solve(b));
  const double freedom = std::max<double>(double(region.cells.size()) - 6, 3);
  const double explained = linear - quadratic, scatter = std::max(quadratic / freedom, 1.0);
  // F statistic of three parameters: 10 is beyond 1 in 10000 from 20 degrees of freedom.
  return explained > 10 * 3 * scatter ? std::sqrt(explained / n) : 0;
}

/// [i][j]: do the regions i and j touch?
std::vector<std::vector<char>> neighbours(const CellGrid& grid, const Regions& all) {
  std::vector<std::vector<char>> beside(all.regions.size(), std::vector<char>(all.regions.size()));
  const auto touch = [&](std::size_t a, std::size_t b) {
    const int i = all.owner[a], j = all.owner[b];
    if (i >= 0 && j >= 0 && i != j)
      beside[std::size_t(i)][std::size_t(j)] = beside[std::size_t(j)][std::size_t(i)] = 1;
  };
  for (int row = 0; row + 1 < grid.rows; ++row)
    for (int column = 0; column + 1 < grid.columns; ++column) {
      const auto at = std::size_t(grid.index(column, row));
      touch(at, at + 1);
      touch(at, at + std::size_t(grid.columns));
    }
  return beside;
}

/// Two parts of one plane: together they lie as flat as each alone. What is beside each other may differ by
/// what neighbours share.
void join(const CellGrid& grid, const PlaneOptions& options, Regions& all) {
  constexpr double kBeside = 4;  ///< twice the RMS
  /// Of chi-square with the 3 degrees of freedom that a plane has, 1 in 10000 is above.
  constexpr double kSamePlane = 21.1;
  auto& regions = all.regions;
  std::vector<std::vector<char>> beside = neighbours(grid, all);
  std::vector<std::vector<char>> refused(regions.size(), std::vector<char>(regions.size()));  // [i][j], i < j
  for (bool joined = true; joined;) {
    joined = false;
    for (std::size_t i = 0; i < regions.size() && !joined; ++i)
      for (std::size_t j = i + 1; j < regions.size() && !joined; ++j) {
        if (refused[i][j]) continue;
        refused[i][j] = 1;  // unless they are joined: then all is forgotten about the one that they become
        Moments both = regions[i].moments;
        both += regions[j].moments;
        const InverseDepthPlane plane = fit(both);
        const double more = plane.error - regions[i].plane.error - regions[j].plane.error;
        const Region& smaller = regions[i].moments.n < regions[j].moments.n ? regions[i] : regions[j];
        // Mean square of what readings share over that of their noise, where the smaller part is.
        const Cell& there = grid.cells[std::size_t(smaller.cells[smaller.cells.size() / 2])];
        const double limit = double(there.shared * there.shared / (there.sigma * there.sigma));
        double allowed = (beside[i][j] ? kBeside : 1) * limit * smaller.moments.n;
        // Parts in different places, of noise that averages: one plane where their covariances say so, beside
        // the floor.
        if (grid.averages && !beside[i][j]) {
          const double floor =
              options.noise.correlated_floor * double(there.q) * double(there.q) / double(there.sigma);
          allowed = std::min(allowed, kSamePlane + floor * floor * smaller.moments.n);
        }
        if (more > allowed) continue;
        Region candidate{regions[i].cells, both, plane};
        candidate.cells.insert(candidate.cells.end(), regions[j].cells.begin(), regions[j].cells.end());
        candidate.bend = second_order(grid, candidate);
        if (candidate.bend > std::max({options.curvature_threshold, regions[i].bend, regions[j].bend}))
          continue;
        regions[i] = std::move(candidate);
        regions.erase(regions.begin() + std::ptrdiff_t(j));
        for (std::size_t k = 0; k < beside.size(); ++k) {
          if (beside[j][k]) beside[i][k] = beside[k][i] = true;
          refused[i][k] = refused[k][i] = 0;
        }
        for (auto* const matrix : {&beside, &refused}) {
          matrix->erase(matrix->begin() + std::ptrdiff_t(j));
          for (auto& row : *matrix) row.erase(row.begin() + std::ptrdiff_t(j));
        }
        joined = true;
      }
  }
  std::fill(all.owner.begin(), all.owner.end(), kNone);
  for (std::size_t i = 0; i < regions.size(); ++i)
    for (const int at : regions[i].cells) all.owner[std::size_t(at)] = int(i);
}

/// Where two planes meet, the first grown took cells that lie nearer to the other: the border moves to where
/// they cross.
void settle_borders(const CellGrid& grid, Regions& all) {
  const auto off = [&](const Cell& cell, int id) {
    return std::abs(double(cell.q) - all.regions[std::size_t(id)].plane.at(double(cell.u), double(cell.v)));
  };
  // Cells that have another beside them; after a sweep these, and those beside a cell that moved.
  std::vector<int> borders;
  std::vector<char> listed(all.owner.size());
  const auto list = [&](int at) {
    if (listed[std::size_t(at)]) return;
    listed[std::size_t(at)] = 1;
    borders.push_back(at);
  };
  const std::vector<char> alone = alone_cells(grid, all.owner);
  for (std::size_t at = 0; at < all.owner.size(); ++at)
    if (all.owner[at] >= 0 && !alone[at]) list(int(at));
  for (int sweep = 0; sweep < 4; ++sweep) {
    std::vector<std::pair<int, int>> moves;
    for (const int at : borders) {
      if (all.owner[std::size_t(at)] < 0) continue;
      const int column = grid.cells[std::size_t(at)].column, row = at / grid.columns,
                own = all.owner[std::size_t(at)];
      const Cell& cell = grid.cells[std::size_t(at)];
      int best = own;
      double least = -1;
      const auto visit = [&](bool inside, int neighbour) {
        if (!inside) return;
        const int other = all.owner[std::size_t(neighbour)];
        if (other < 0 || other == own) return;
        if (least < 0) least = off(cell, own);
        const double d = off(cell, other);
        if (d < least) least = d, best = other;
      };
      visit(column > 0, at - 1);
      visit(column + 1 < grid.columns, at + 1);
      visit(row > 0, at - grid.columns);
      visit(row + 1 < grid.rows, at + grid.columns);
      if (best != own) moves.emplace_back(at, best);
    }
    if (moves.empty()) break;
    std::vector<char> changed(all.regions.size());
    for (const auto& [at, to] : moves) {
      int& of = all.owner[std::size_t(at)];
      changed[std::size_t(of)] = changed[std::size_t(to)] = 1;
      of = to;
      const int column = grid.cells[std::size_t(at)].column;
      if (column > 0) list(at - 1);
      if (column + 1 < grid.columns) list(at + 1);
      if (at >= grid.columns) list(at - grid.columns);
      if (at + grid.columns < int(all.owner.size())) list(at + grid.columns);
    }
    for (std::size_t i = 0; i < changed.size(); ++i)
      if (changed[i]) all.regions[i].cells.clear();
    for (std::size_t at = 0; at < all.owner.size(); ++at)
      if (all.owner[at] >= 0 && changed[std::size_t(all.owner[at])])
        all.regions[std::size_t(all.owner[at])].cells.push_back(int(at));
    for (std::size_t i = 0; i < changed.size(); ++i)
      if (changed[i]) refit(grid, all.regions[i].cells, all.regions[i].moments, all.regions[i].plane);
  }
}

}  // namespace

std::vector<char> alone_cells(const CellGrid& grid, const std::vector<int>& owner) {
  const auto columns = std::size_t(grid.columns), rows = std::size_t(grid.rows);
  // Along rows first, then across; plain loops over rows, which compilers turn into vectors.
  std::vector<char> along(columns * rows), out(columns * rows);
  for (std::size_t row = 0; row < rows; ++row) {
    const int* const own = owner.data() + row * columns;
    char* const to = along.data() + row * columns;
    const auto joined = [own](std::size_t x) { return int(own[x] == own[x + 1]); };
    to[0] = char(columns < 2 ? 1 : joined(0));
    for (std::size_t x = 1; x + 1 < columns; ++x) to[x] = char(joined(x - 1) & joined(x));
    if (columns > 1) to[columns - 1] = char(joined(columns - 2));
  }
  for (std::size_t row = 0; row < rows; ++row) {
    const std::size_t up = row > 0 ? row - 1 : row, down = row + 1 < rows ? row + 1 : row;
    const int *const own = owner.data() + row * columns, *const above = owner.data() + up * columns,
                     *const below = owner.data() + down * columns;
    const char *const here = along.data() + row * columns, *const at_above = along.data() + up * columns,
                      *const at_below = along.data() + down * columns;
    char* const to = out.data() + row * columns;
    for (std::size_t x = 0; x < columns; ++x)
      to[x] = char(here[x] & at_above[x] & at_below[x] & char(own[x] == above[x]) & char(own[x] == below[x]));
  }
  return out;
}

void refit(const CellGrid& grid, const std::vector<int>& cells, Moments& moments, InverseDepthPlane& plane) {
  moments = {};
  for (const int at : cells) moments += grid.cells[std::size_t(at)].moments;
  plane = fit(moments);
}

Regions grow_regions(const CellGrid& grid, const PlaneOptions& options) {
  Regions all = Grower(grid, options).run();
  settle_borders(grid, all);
  for (Region& region : all.regions) region.bend = second_order(grid, region);
  join(grid, options, all);
  return all;
}

}  // namespace procam::depth::internal
