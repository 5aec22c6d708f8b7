#include "procam/session/delay.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "delay_code.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/stats.hpp"

namespace procam::session {
namespace {

constexpr double kMinCorrelation = 0.8, kMinLead = 0.15;
constexpr std::size_t kMinFrames = 16, kMinSwitches = 6;
/// A frame is settled when its brightness is within this share of the step from the level it should have.
constexpr double kSettledShare = 0.12;

bool white_at(const std::vector<LightSwitch>& switches, double time) {
  const auto later = std::upper_bound(switches.begin(), switches.end(), time,
                                      [](double t, const LightSwitch& s) { return t < s.time_s; });
  return later == switches.begin() ? !switches.front().white : std::prev(later)->white;
}

double correlation(const std::vector<LightSwitch>& switches, const std::vector<BrightnessSample>& seen,
                   double lag) {
  double y = 0, c = 0, yy = 0, cc = 0, yc = 0;
  for (const BrightnessSample& frame : seen) {
    const double code = white_at(switches, frame.time_s - lag) ? 1 : 0;
    y += frame.level, c += code;
    yy += frame.level * frame.level, cc += code * code, yc += frame.level * code;
  }
  const double n = double(seen.size());
  const double variance = (yy - y * y / n) * (cc - c * c / n);
  return variance > 0 ? (yc - y * c / n) / std::sqrt(variance) : 0;
}

double frame_interval(const std::vector<BrightnessSample>& seen) {
  std::vector<double> gaps;
  for (std::size_t k = 1; k < seen.size(); ++k) gaps.push_back(seen[k].time_s - seen[k - 1].time_s);
  return median(gaps);
}

/// The latest age, since its switch, of a frame that was not yet all new.
double settled_after(const std::vector<LightSwitch>& switches, const std::vector<BrightnessSample>& seen,
                     double delay) {
  std::vector<double> dark, bright;
  for (const BrightnessSample& frame : seen)
    (white_at(switches, frame.time_s - delay) ? bright : dark).push_back(frame.level);
  if (dark.empty() || bright.empty()) return delay;
  const double low = median(dark), high = median(bright);
  double latest = delay;
  for (const BrightnessSample& frame : seen) {
    const double expected = white_at(switches, frame.time_s - delay) ? high : low;
    if (std::abs(frame.level - expected) <= kSettledShare * (high - low)) continue;
    const auto nearest =
        std::min_element(switches.begin(), switches.end(), [&](const LightSwitch& a, const LightSwitch& b) {
          const double t = frame.time_s - delay;
          return std::abs(t - a.time_s) < std::abs(t - b.time_s);
        });
    latest = std::max(latest, frame.time_s - nearest->time_s);
  }
  return latest;
}

/// White time up to t, in seconds: the code's integral.
class WhiteTime {
 public:
  explicit WhiteTime(const std::vector<LightSwitch>& switches) : switches_(switches) {
    double sum = 0;
    for (std::size_t i = 0; i < switches.size(); ++i) {
      if (i > 0 && switches[i - 1].white) sum += switches[i].time_s - switches[i - 1].time_s;
      before_.push_back(sum);
    }
  }
  double operator()(double t) const {
    const auto later = std::upper_bound(switches_.begin(), switches_.end(), t,
                                        [](double time, const LightSwitch& s) { return time < s.time_s; });
    if (later == switches_.begin()) return switches_.front().white ? 0 : t - switches_.front().time_s;
    const auto i = std::size_t(later - switches_.begin()) - 1;
    return before_[i] + (switches_[i].white ? t - switches_[i].time_s : 0);
  }

 private:
  const std::vector<LightSwitch>& switches_;
  std::vector<double> before_;
};

/// The delay to a fraction of a frame. A frame sums up light over its exposure e, so one that spans a switch
/// is grey, and tells when:
///   y_k = dark + step * share of white in [t_k - tau - e / 2, t_k - tau + e / 2].
/// The (tau, e) of the least squares over all frames, dark and step being linear; the middle of the best tau
/// where several are equally good.
double refine(const std::vector<LightSwitch>& switches, const std::vector<BrightnessSample>& seen,
              double coarse, double interval) {
  const WhiteTime white(switches);
  double y = 0, yy = 0;
  for (const BrightnessSample& frame : seen) y += frame.level, yy += frame.level * frame.level;
  const double n = double(seen.size());
  constexpr int kSteps = 96, kExposures = 12;
  double best = -1, sum = 0;
  int count = 0;
  for (int x = 1; x <= kExposures; ++x) {
    const double exposure = interval * x / kExposures;
    for (int i = -kSteps; i <= kSteps; ++i) {
      const double tau = coarse + interval * i / kSteps;
      double c = 0, cc = 0, yc = 0;
      for (const BrightnessSample& frame : seen) {
        const double middle = frame.time_s - tau;
        const double share = (white(middle + exposure / 2) - white(middle - exposure / 2)) / exposure;
        c += share, cc += share * share, yc += frame.level * share;
      }
      const double spread = (cc - c * c / n) * (yy - y * y / n);
      const double explained = spread > 0 ? (yc - y * c / n) * (yc - y * c / n) / spread : 0;
      if (explained < best - 1e-6) continue;
      if (explained > best + 1e-6) best = explained, sum = 0, count = 0;
      sum += tau;
      ++count;
    }
  }
  return count > 0 ? std::max(0.0, sum / count) : coarse;
}

}  // namespace

std::optional<Delay> find_delay(const std::vector<LightSwitch>& switches,
                                const std::vector<BrightnessSample>& seen, double longest_s) {
  require(longest_s > 0, "find_delay: the longest delay must be positive");
  if (seen.size() < kMinFrames || switches.size() < kMinSwitches) return std::nullopt;
  Delay found;
  found.frame_interval_s = frame_interval(seen);
  const double step = std::min(found.frame_interval_s / 16, longest_s / 64);
  if (!(step > 0)) return std::nullopt;
  std::vector<double> scores;
  for (double lag = 0; lag <= longest_s; lag += step) scores.push_back(correlation(switches, seen, lag));
  const auto best = std::max_element(scores.begin(), scores.end());
  found.correlation = *best;
  if (!(found.correlation >= kMinCorrelation)) return std::nullopt;
  constexpr double kEqual = 1e-9;
  auto last = best;
  while (std::next(last) != scores.end() && *std::next(last) > *best - kEqual) ++last;
  found.delay_s = 0.5 * step * double((best - scores.begin()) + (last - scores.begin()));
  // A shifted code agrees with itself over the length of its shortest part: rivals lie farther away.
  double shortest = longest_s;
  for (std::size_t i = 1; i < switches.size(); ++i)
    shortest = std::min(shortest, switches[i].time_s - switches[i - 1].time_s);
  for (std::size_t i = 0; i < scores.size(); ++i)
    if (std::abs(double(i) * step - found.delay_s) > shortest && scores[i] > *best - kMinLead)
      return std::nullopt;
  found.delay_s = refine(switches, seen, found.delay_s, found.frame_interval_s);
  found.settled_s = settled_after(switches, seen, found.delay_s);
  return found;
}

std::vector<double> code_durations(int count, double unit_s, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<double> durations(std::size_t(std::max(count, 0)));
  for (double& duration : durations) duration = unit_s * (2 + 2 * double(random()) / 4294967296.0);
  return durations;
}

}  // namespace procam::session
