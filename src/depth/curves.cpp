#include <algorithm>
#include <numeric>
#include <utility>

#include "curve_fit.hpp"

namespace procam::depth::internal {
namespace {

/// A shape must turn by this much over what is seen of it: less is a plane with a distorted depth.
constexpr double kMinTurn = 12 * kDegree;
/// A cell within this many of those sigmas lies on the shape.
constexpr double kOnShape = 3;

/// The search for curves among the regions. Members of a group are numbers of regions.
class CurveSearch {
 public:
  CurveSearch(const CellGrid& grid, const PlaneOptions& options, Regions& all)
      : grid_(grid),
        threshold_(options.curvature_threshold),
        all_(all),
        regions_(all.regions),
        gone_(all.regions.size()),
        beside_(all.regions.size()) {}

  std::vector<Curve> run() {
    if (std::none_of(regions_.begin(), regions_.end(), [](const Region& r) { return r.bend > 0; })) return {};
    alone_ = alone_cells(grid_, all_.owner);
    std::vector<Curve> curves;
    for (const std::size_t first : largest_first()) {
      if (gone_[first] || !(regions_[first].bend > threshold_)) continue;
      Group group{first};
      take_neighbours(group, [&](std::size_t k) { return !gone_[k] && regions_[k].bend > threshold_; });
      std::optional<Fit> fit = fit_group(group, first);
      if (!fit) continue;
      take_regions_on_shape(group, *fit);
      const std::vector<int> cells = cells_of(group);
      curves.push_back({curve_of(*fit, points_of(grid_, cells)), cells});
      for (const std::size_t k : group) gone_[k] = 1;
      for (const int at : cells) all_.owner[std::size_t(at)] = kCurveOwner - int(curves.size() - 1);
    }
    remove_unexplained();
    return curves;
  }

 private:
  using Group = std::vector<std::size_t>;

  Group largest_first() const {
    Group order(regions_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return regions_[a].cells.size() > regions_[b].cells.size();
    });
    return order;
  }

  /// The regions beside region k, across a gap of up to three cells; found when they are asked for.
  const std::vector<char>& beside(std::size_t k) {
    if (!beside_[k].empty()) return beside_[k];
    beside_[k].resize(regions_.size());
    constexpr int kReach = 3;
    for (const int at : regions_[k].cells) {
      if (alone_[std::size_t(at)]) continue;  // nothing is nearer to it than to the border
      const int column = at % grid_.columns, row = at / grid_.columns;
      const int right = std::min(column + kReach, grid_.columns - 1),
                low = std::min(row + kReach, grid_.rows - 1);
      for (int y = std::max(row - kReach, 0); y <= low; ++y)
        for (int x = std::max(column - kReach, 0); x <= right; ++x) {
          const int other = all_.owner[std::size_t(grid_.index(x, y))];
          if (other >= 0) beside_[k][std::size_t(other)] = 1;
        }
    }
    return beside_[k];
  }

  template <typename Wanted>
  void take_neighbours(Group& group, const Wanted& wanted) {
    for (std::size_t head = 0; head < group.size(); ++head) {
      const std::vector<char>& near = beside(group[head]);
      for (std::size_t k = 0; k < regions_.size(); ++k)
        if (near[k] && std::find(group.begin(), group.end(), k) == group.end() && wanted(k))
          group.push_back(k);
    }
  }

  std::vector<int> cells_of(const Group& group) const {
    std::vector<int> cells;
    for (const std::size_t k : group)
      cells.insert(cells.end(), regions_[k].cells.begin(), regions_[k].cells.end());
    return cells;
  }

  std::optional<Fit> fit_of(const Group& members) const {
    const std::vector<Sample> samples = samples_of(grid_, cells_of(members));
    std::optional<Fit> best;
    for (const bool cylinder : {true, false}) {
      const auto found = fit_shape(samples, cylinder);
      if (found && found->turn > kMinTurn && (!best || found->rms_sigmas < 0.8 * best->rms_sigmas))
        best = found;
    }
    return best;
  }

  /// All members together. Where no shape explains them, the first alone; and, where noise averages and limits are
  /// so narrow that no shape explains a column with a ball before it, the first with one other. Of these the fit
  /// that most of the group's cells lie on; `group` becomes its members.
  std::optional<Fit> fit_group(Group& group, std::size_t first) const {
    std::optional<Fit> best = fit_of(group);
    if (best || group.size() == 1) return best;
    const std::vector<Sample> samples = points_of(grid_, cells_of(group));
    const Group all_of_group = std::exchange(group, {first});
    std::ptrdiff_t most = -1;
    for (std::size_t k = 0; k < (grid_.averages ? all_of_group.size() : 1); ++k) {
      Group members{first};
      if (k > 0) members.push_back(all_of_group[k]);
      const std::optional<Fit> fit = fit_of(members);
      if (!fit) continue;
      const auto count = std::count_if(samples.begin(), samples.end(), [&](const Sample& s) {
        return std::abs(fit->shape.residual(s)) < kOnShape;
      });
      if (count <= most) continue;
      most = count, best = fit, group = members;
    }
    return best;
  }

  bool lies_on(std::size_t k, const Shape& shape) const {
    const std::vector<int>& cells = regions_[k].cells;
    const std::size_t step = cells.size() / kSamples + 1;
    std::size_t count = 0;
    for (std::size_t i = 0; i < cells.size(); i += step)
      count += std::abs(shape.residual(sample_of(grid_.cells[std::size_t(cells[i])]))) < kOnShape;
    return double(count * step) > 0.7 * double(cells.size());
  }

  /// Regions beside the group that lie on its shape belong to it, curved by themselves or not.
  void take_regions_on_shape(Group& group, Fit& fit) {
    for (;;) {
      const std::size_t before = group.size();
      take_neighbours(group, [&](std::size_t k) { return !gone_[k] && lies_on(k, fit.shape); });
      if (group.size() == before) return;
      const auto again = fit_from(points_of(grid_, cells_of(group)), fit.shape);
      if (again) fit = *again;
    }
  }

  /// Regions too bent for a plane; and those that became part of a curve.
  void remove_unexplained() {
    for (std::size_t k = 0; k < regions_.size(); ++k)
      if (!gone_[k] && regions_[k].bend > 3 * threshold_) {
        gone_[k] = 1;
        for (const int at : regions_[k].cells) all_.owner[std::size_t(at)] = kUnexplained;
      }
    for (std::size_t k = 0; k < regions_.size(); ++k)
      if (gone_[k]) regions_[k].cells.clear();
  }

  const CellGrid& grid_;
  double threshold_;
  Regions& all_;
  std::vector<Region>& regions_;
  std::vector<char> gone_, alone_;
  std::vector<std::vector<char>> beside_;
};

}  // namespace

std::vector<Curve> take_curves(const CellGrid& grid, const PlaneOptions& options, Regions& all) {
  return CurveSearch(grid, options, all).run();
}

}  // namespace procam::depth::internal
