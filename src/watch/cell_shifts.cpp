#include "procam/watch/cell_shifts.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "predicted_image.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::watch {
namespace {

constexpr int kCoarse = 4, kCoarseReach = 8;  ///< of the coarse search: working pixels a pixel, and +- pixels
constexpr double kEnough = 0.35;              ///< share of textured cells that must agree with the start
constexpr double kManyMore = 0.5;             ///< share that must agree with another start
constexpr double kClippedGrey = 253, kMaxClipped = 0.05;
constexpr double kMinGain = 5;  ///< sigmas of a cell's gain: with less it may be noise
constexpr double kDimGain =
    0.75;  ///< of the median gain: a cell with less shows an edge at its border, or a shadow
constexpr double kSteady = 0.005;  ///< working pixels: the iteration has settled
constexpr double kDamping = 1e-3;  ///< of the trace of the structure tensor

/// What is expected in the working image.
struct Prediction {
  ImageF tone;                   ///< T, smoothed
  std::optional<ImageF> change;  ///< dT/dt per second; none for a frame that stands still
};

bool is_same(const ViewU8& a, const ViewU8& b) {
  return a.data == b.data && a.size() == b.size();
}

ImageF toned(const ImageF& light, const CameraTone& tone) {
  ImageF result(light.size());
  // A table: pow() of each pixel would take longer than all the rest.
  constexpr int kSteps = 1024;
  std::array<float, kSteps + 2> table;
  for (int i = 0; i < kSteps + 2; ++i)
    table[std::size_t(i)] = float(std::pow(tone.ambient + double(i) / kSteps, 1 / tone.gamma));
  for (int y = 0; y < light.height(); ++y)
    for (int x = 0; x < light.width(); ++x) {
      const float place = std::clamp(light.at(x, y), 0.f, 1.f) * kSteps;
      const int below = int(place);
      const float more = place - float(below);
      result.at(x, y) = (1 - more) * table[std::size_t(below)] + more * table[std::size_t(below + 1)];
    }
  return smoothed(result);
}

ImageF seen_light(const LightGeometry& geometry, ViewU8 frame) {
  const int k = std::max(1, int(geometry.projector_px_per_px + 0.3));
  return light_in_camera(geometry, frame_light(frame, k), k);
}

/// (1 - share) a + share b.
ImageF mixed(const ImageF& a, const ImageF& b, double share) {
  ImageF result = a;
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width(); ++x) result.at(x, y) += float(share) * (b.at(x, y) - a.at(x, y));
  return result;
}

/// Light at the shown moment and at the next frame's.
struct SeenLight {
  ImageF now;
  std::optional<ImageF> first, next;  ///< of light that changes
};

SeenLight seen(const LightGeometry& geometry, const ShownLight& light) {
  SeenLight result;
  result.now = seen_light(geometry, light.frame);
  if (is_same(light.frame, light.next)) return result;
  result.next = seen_light(geometry, light.next);
  result.first = result.now;
  result.now = mixed(*result.first, *result.next, light.share);
  return result;
}

Prediction predict(const SeenLight& light, double interval, const CameraTone& tone) {
  Prediction prediction{toned(light.now, tone), {}};
  if (!light.next || !(interval > 0)) return prediction;
  ImageF change = toned(*light.next, tone);
  const ImageF first = toned(*light.first, tone);
  for (int y = 0; y < change.height(); ++y)
    for (int x = 0; x < change.width(); ++x)
      change.at(x, y) = (change.at(x, y) - first.at(x, y)) / float(interval);
  prediction.change = std::move(change);
  return prediction;
}

/// Template of one cell: T and its derivatives, their means subtracted.
class CellTemplate {
 public:
  CellTemplate(const ImageF& tone, int x, int y, int half) : x_(x), y_(y), half_(half) {
    const int side = 2 * half + 1;
    basis_.resize(side * side, 3);
    Eigen::Index n = 0;
    for (int j = y - half; j <= y + half; ++j) {
      const float *row = tone.row(j), *above = tone.row(j - 1), *below = tone.row(j + 1);
      for (int i = x - half; i <= x + half; ++i, ++n)
        basis_.row(n) << row[i], 0.5f * (row[i + 1] - row[i - 1]), 0.5f * (below[i] - above[i]);
    }
    const Eigen::RowVector3f means = basis_.colwise().mean();
    basis_.rowwise() -= means;
    mean_ = double(means[0]);
    gram_ = (basis_.transpose() * basis_).cast<double>();
  }

  /// Structure tensor, less what T itself explains.
  Mat2 structure() const {
    const Mat2 all = gram_.bottomRightCorner<2, 2>();
    if (!(gram_(0, 0) > 0)) return all;
    return all - gram_.bottomLeftCorner<2, 1>() * gram_.topRightCorner<1, 2>() / gram_(0, 0);
  }
  double mean() const { return mean_; }  ///< of T
  double variance() const { return gram_(0, 0) / double(basis_.rows()); }
  Eigen::Index pixels() const { return basis_.rows(); }

  struct Products {
    Vec3 by_basis;
    double square = 0, mean = 0;
  };
  /// With the image at the cell, displaced; nullopt beside it.
  std::optional<Products> products(const ImageF& image, const Vec2& shift) const {
    const double left = x_ - half_ + shift.x(), top = y_ - half_ + shift.y();
    const int side = 2 * half_ + 1, column = int(std::floor(left)), row = int(std::floor(top));
    if (column < 0 || row < 0 || column + side >= image.width() || row + side >= image.height())
      return std::nullopt;
    const float fx = float(left - column), fy = float(top - row);
    const float w00 = (1 - fx) * (1 - fy), w10 = fx * (1 - fy), w01 = (1 - fx) * fy, w11 = fx * fy;
    thread_local Eigen::VectorXf values;
    values.resize(side * side);
    float* out = values.data();
    for (int j = 0; j < side; ++j) {
      const float *upper = image.row(row + j) + column, *lower = image.row(row + j + 1) + column;
      for (int i = 0; i < side; ++i)
        *out++ = w00 * upper[i] + w10 * upper[i + 1] + w01 * lower[i] + w11 * lower[i + 1];
    }
    Products result;
    const float mean = values.mean();
    values.array() -= mean;
    result.by_basis = (basis_.transpose() * values).cast<double>();
    result.square = double(values.squaredNorm());
    result.mean = mean;
    return result;
  }

  const Mat3& gram() const { return gram_; }

 private:
  int x_, y_, half_;
  Eigen::Matrix<float, Eigen::Dynamic, 3> basis_;
  Mat3 gram_ = Mat3::Zero();
  double mean_ = 0;
};

struct Search {
  const LightGeometry& geometry;
  const Prediction& prediction;
  const ImageF& image;   ///< averaged
  const ImageF& smooth;  ///< and smoothed
  const CompareOptions& options;
  double noise = 1;  ///< variance of a smoothed working pixel

  CellTemplate cell_template(const LitCell& cell) const {
    return {prediction.tone, int(cell.pixel.x()), int(cell.pixel.y()), geometry.half_cell};
  }

  bool is_clipped(const LitCell& cell) const {
    const int half = geometry.half_cell, x = int(cell.pixel.x()), y = int(cell.pixel.y());
    int clipped = 0;
    for (int j = y - half; j <= y + half; ++j)
      for (int i = x - half; i <= x + half; ++i) clipped += image.at(i, j) >= kClippedGrey;
    return clipped > kMaxClipped * double((2 * half + 1) * (2 * half + 1));
  }

  /// Fills in all but `cell`.
  void measure(const LitCell& cell, const CellTemplate& shape, const Vec2& start, CellShift& result) const {
    result.state = CellState::kMismatch;
    Mat3 damped = shape.gram();
    const double damping = kDamping * (damped(1, 1) + damped(2, 2));
    damped(0, 0) *= 1 + 1e-9;
    damped(1, 1) += damping;
    damped(2, 2) += damping;
    const Eigen::LDLT<Mat3> factors(damped);
    Vec2 shift = start;
    for (int step = 0; step < options.max_steps; ++step) {
      const auto products = shape.products(smooth, shift);
      if (!products) return;
      const Vec3 fitted = factors.solve(products->by_basis);
      if (!(fitted.x() > 0)) return;
      const Vec2 back = (fitted.tail<2>() / fitted.x()).cwiseMax(-2).cwiseMin(2);
      shift -= back;
      if ((shift - start).norm() > options.max_shift) return;
      if (back.norm() < kSteady) break;
    }
    const auto products = shape.products(smooth, shift);
    if (!products) return;
    const double gain = products->by_basis.x() / shape.gram()(0, 0);
    const double rest = std::max(0.0, products->square - gain * products->by_basis.x());
    const double freedom = double(shape.pixels()) / kNoiseArea;  // independent values in smoothed noise
    const double variance =
        std::max(noise, rest / double(shape.pixels()) * freedom / std::max(1.0, freedom - 4));
    result.shift = shift;
    result.gain = gain;
    result.offset = products->mean - gain * shape.mean();
    result.misfit = std::sqrt(rest / std::max(1e-30, gain * gain * shape.gram()(0, 0)));
    result.information = gain * gain / (kNoiseArea * variance) * shape.structure();
    if (prediction.change) result.by_delay = apparent_shift(cell, factors);
    // A weak texture may drown in noise, and yet tell something in many cells.
    const double allowed =
        options.max_misfit * options.max_misfit * gain * gain * shape.variance() + 2 * noise;
    const bool is_seen = gain * gain * shape.gram()(0, 0) > kMinGain * kMinGain * kNoiseArea * variance;
    if (gain > 0 && is_seen && rest / double(shape.pixels()) <= allowed) result.state = CellState::kMeasured;
  }

 private:
  Vec2 apparent_shift(const LitCell& cell, const Eigen::LDLT<Mat3>& factors) const {
    const CellTemplate shape = cell_template(cell);
    const auto change = shape.products(*prediction.change, Vec2::Zero());
    if (!change) return Vec2::Zero();
    return -Vec3(factors.solve(change->by_basis)).tail<2>();
  }
};

/// Mean correlation of the textured cells for each common shift, on coarse images; the best shift.
Vec2 coarse_start(const Search& search, const std::vector<int>& textured) {
  const auto reduced = [](const ImageF& image) {
    ImageF result(image.width() / kCoarse, image.height() / kCoarse);
    for (int y = 0; y < result.height(); ++y)
      for (int x = 0; x < result.width(); ++x) {
        float sum = 0;
        for (int j = 0; j < kCoarse; ++j)
          for (int i = 0; i < kCoarse; ++i) sum += image.at(x * kCoarse + i, y * kCoarse + j);
        result.at(x, y) = sum / (kCoarse * kCoarse);
      }
    return result;
  };
  const ImageF image = reduced(search.smooth), tone = reduced(search.prediction.tone);
  constexpr int kHalf = 3, kSide = 2 * kHalf + 1, kShifts = 2 * kCoarseReach + 1;
  std::array<double, kShifts * kShifts> score{};
  std::array<int, kShifts * kShifts> count{};
  for (const int number : textured) {
    const LitCell& cell = search.geometry.cells[std::size_t(number)];
    const int x = int(cell.pixel.x()) / kCoarse, y = int(cell.pixel.y()) / kCoarse;
    if (x < kHalf || y < kHalf || x + kHalf >= tone.width() || y + kHalf >= tone.height()) continue;
    std::array<float, kSide * kSide> expected;
    float mean = 0, square = 0;
    for (int k = 0; k < kSide * kSide; ++k)
      mean += expected[std::size_t(k)] = tone.at(x - kHalf + k % kSide, y - kHalf + k / kSide);
    for (float& value : expected) {
      value -= mean / (kSide * kSide);
      square += value * value;
    }
    if (!(square > 0)) continue;
    for (int dy = -kCoarseReach; dy <= kCoarseReach; ++dy)
      for (int dx = -kCoarseReach; dx <= kCoarseReach; ++dx) {
        if (x + dx < kHalf || y + dy < kHalf || x + dx + kHalf >= image.width() ||
            y + dy + kHalf >= image.height())
          continue;
        float product = 0, sum = 0, squares = 0;
        for (int k = 0; k < kSide * kSide; ++k) {
          const float value = image.at(x + dx - kHalf + k % kSide, y + dy - kHalf + k / kSide);
          product += value * expected[std::size_t(k)], sum += value, squares += value * value;
        }
        const float spread = squares - sum * sum / (kSide * kSide);
        const auto shift = std::size_t((dy + kCoarseReach) * kShifts + dx + kCoarseReach);
        ++count[shift];
        if (spread > 0) score[shift] += double(product / std::sqrt(spread * square));
      }
  }
  double best = 0;
  Vec2 start = Vec2::Zero();
  for (int k = 0; k < kShifts * kShifts; ++k) {
    const auto shift = std::size_t(k);
    if (2 * count[shift] < int(textured.size()) || !(score[shift] > best * count[shift])) continue;
    best = score[shift] / count[shift];
    start = kCoarse * Vec2(k % kShifts - kCoarseReach, k / kShifts - kCoarseReach);
  }
  return start;
}

double measure_all(const Search& search, const std::vector<int>& textured,
                   const std::vector<CellTemplate>& shapes, const Vec2& start, ImageComparison& result) {
  result.measured = 0;
  result.start = start;
  for (const int number : textured) {
    CellShift& one = result.cells[std::size_t(number)];
    if (one.state == CellState::kClipped) continue;
    const auto place = std::size_t(number);
    search.measure(search.geometry.cells[place], shapes[place], start, one);
    result.measured += one.state == CellState::kMeasured;
  }
  return textured.empty() ? 1 : double(result.measured) / double(textured.size());
}

/// Do cells of the surface on which most fit another start stay where they should be? Then the others show light on something
/// before the surface, a person: all of it is displaced alike, and a surface that moves takes all of its cells along. Two that
/// agree by chance are rare.
bool some_stayed(const LightGeometry& geometry, const ImageComparison& here, const ImageComparison& there) {
  constexpr double kStayed = 1, kMaxSigma = 0.3;  // working pixels
  constexpr int kFew = 2;
  std::vector<int> fitting(geometry.surfaces.size()), stayed(geometry.surfaces.size());
  for (std::size_t i = 0; i < there.cells.size(); ++i) {
    const auto surface = std::size_t(geometry.cells[i].surface);
    fitting[surface] += there.cells[i].state == CellState::kMeasured;
    const CellShift& cell = here.cells[i];
    stayed[surface] += cell.state == CellState::kMeasured &&
                       (cell.shift - here.start).lpNorm<Eigen::Infinity>() < kStayed &&
                       cell.information.trace() * kMaxSigma * kMaxSigma > 1;
  }
  const auto most = std::max_element(fitting.begin(), fitting.end()) - fitting.begin();
  return stayed[std::size_t(most)] >= kFew;
}

void add_image_statistics(const LightGeometry& geometry, const ImageF& image, ImageComparison& result) {
  double sum = 0, squares = 0;
  int count = 0;
  for (int y = 0; y < image.height(); y += 2)
    for (int x = 0; x < image.width(); x += 2) {
      if (!geometry.is_lit(x, y)) continue;
      sum += double(image.at(x, y));
      squares += double(image.at(x, y)) * double(image.at(x, y));
      ++count;
    }
  if (count == 0) return;
  result.image_mean = sum / count;
  result.image_deviation = std::sqrt(std::max(0.0, squares / count - result.image_mean * result.image_mean));
}

/// Gain and correlation over all cells, without a search: which cells have enough texture depends on them.
void add_common_gain(const ImageF& smooth, const std::vector<CellTemplate>& shapes, const Vec2& start,
                     ImageComparison& result) {
  double product = 0, square = 0, expected = 0;
  for (const CellTemplate& shape : shapes) {
    const auto products = shape.products(smooth, start);
    if (!products) continue;
    product += products->by_basis.x();
    square += products->square;
    expected += shape.gram()(0, 0);
  }
  if (!(expected > 0) || !(square > 0)) return;
  result.gain = product / expected;
  result.correlation = product / std::sqrt(expected * square);
}

/// The shift of a cell with a small gain is biased. At least half of the measured cells remain.
void reject_dim_cells(ImageComparison& result) {
  std::vector<double> gains;
  for (const CellShift& one : result.cells)
    if (one.state == CellState::kMeasured) gains.push_back(one.gain);
  const double least = kDimGain * median_or(std::move(gains), 0.0);
  for (CellShift& one : result.cells)
    if (one.state == CellState::kMeasured && one.gain < least) {
      one.state = CellState::kMismatch;
      --result.measured;
    }
}

void check(const LightGeometry& geometry, const ShownLight& light, ViewU8 image) {
  require(image.size() == geometry.camera_size && image.channels == 1,
          "compare: an image of another size than the camera's, or with several channels");
  require(light.frame.size() == geometry.projector_size && light.next.size() == geometry.projector_size,
          "compare: a frame of another size than the projector's");
}

ImageComparison compare(const LightGeometry& geometry, const SeenLight& light, double interval,
                        const ImageF& image, const Vec2& start, const CompareOptions& options) {
  const ImageF smooth = smoothed(image);
  const Prediction prediction = predict(light, interval, options.tone);
  const double noise = options.noise * options.noise / (geometry.average * geometry.average) / kNoiseArea;
  const Search search{geometry, prediction, image, smooth, options, noise};
  ImageComparison result;
  add_image_statistics(geometry, image, result);
  std::vector<CellTemplate> shapes;
  for (const LitCell& cell : geometry.cells) {
    shapes.push_back(search.cell_template(cell));
    result.cells.emplace_back().cell = int(shapes.size()) - 1;
  }
  add_common_gain(smooth, shapes, start, result);
  // The gain of a view in which nothing agrees says nothing: then half of the image's range is assumed.
  const double gain = result.correlation > 0.3 ? result.gain : std::max(result.gain, 100.0);
  std::vector<int> textured;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const Mat2 structure = shapes[i].structure();
    const double most =
        0.5 * structure.trace() +
        std::sqrt(std::max(0.0, 0.25 * structure.trace() * structure.trace() - structure.determinant()));
    if (!(gain * gain * most * options.max_sigma * options.max_sigma > kNoiseArea * noise * 4)) continue;
    textured.push_back(int(i));
    result.cells[i].state = search.is_clipped(geometry.cells[i]) ? CellState::kClipped : CellState::kMismatch;
  }
  result.textured = int(textured.size());
  if (measure_all(search, textured, shapes, start, result) < kEnough && textured.size() >= 8) {
    const Vec2 other = coarse_start(search, textured);
    const int before = result.measured;
    if ((other - start).norm() > 1) {
      ImageComparison again = result;
      measure_all(search, textured, shapes, other, again);
      if (again.measured >= 2 * before && again.measured >= kManyMore * double(textured.size()) &&
          !some_stayed(geometry, result, again))
        result = std::move(again);
    }
  }
  reject_dim_cells(result);
  std::vector<double> offsets;
  for (const CellShift& one : result.cells)
    if (one.state == CellState::kMeasured) offsets.push_back(one.offset);
  result.offset = median_or(offsets, 0.0);
  return result;
}

}  // namespace

ImageComparison compare(const LightGeometry& geometry, const ShownLight& light, ViewU8 image,
                        const Vec2& start, const CompareOptions& options) {
  check(geometry, light, image);
  return compare(geometry, seen(geometry, light), light.interval, averaged(image, geometry.average), start,
                 options);
}

CameraTone fit_tone(const LightGeometry& geometry, const ShownLight& light, ViewU8 image, const Vec2& start,
                    const CompareOptions& options) {
  check(geometry, light, image);
  const SeenLight seen_now = seen(geometry, light);
  const ImageF grey = averaged(image, geometry.average);
  CameraTone best = options.tone;
  double least = INFINITY;
  for (const double gamma : {1.0, 1.5, 2.2})
    for (const double ambient : {0.02, 0.1, 0.3}) {
      if (gamma == 1.0 && ambient > 0.02) continue;  // the offset takes it
      CompareOptions candidate = options;
      candidate.tone = {gamma, ambient};
      const ImageComparison compared = compare(geometry, seen_now, light.interval, grey, start, candidate);
      std::vector<double> misfits;
      for (const CellShift& cell : compared.cells)
        if (cell.state == CellState::kMeasured) misfits.push_back(cell.misfit);
      if (misfits.size() < 4) continue;
      if (const double misfit = median(misfits); misfit < least) {
        least = misfit;
        best = candidate.tone;
      }
    }
  return best;
}

}  // namespace procam::watch
