#pragma once
/// People before a wall, lit by the projector: they show the content displaced, each part of a body by its own distance, and
/// throw shadows. Coordinates are those of the wall, metres; a depth is a distance before it.
#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "procam/core/base/types.hpp"

namespace procam::watch::test {

/// A body as an elliptic cylinder with a narrower head.
struct Person {
  double offset = 0;  ///< of the group's place along the wall
  double depth = 0.5, half_depth = 0.13, half_width = 0.22;
  double head = 0.2;  ///< its top, below that of the content
  double albedo = 0.4;
  double phase = 0;  ///< of the folds
};

struct Touched {
  Eigen::Vector2f point;  ///< its x, y
  float depth = 0, albedo = 0;
};

class PeopleBeforeWall {
 public:
  /// One person, or a group that hides all of a content of 1.15 m.
  PeopleBeforeWall(std::mt19937& random, bool is_group) {
    const auto uniform = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
    const double near = 0.25 + 0.65 * uniform(), albedo = 0.1 + 0.6 * uniform();
    for (int k = 0; k < (is_group ? 5 : 1); ++k) {
      Person one;
      one.offset = is_group ? 0.36 * (k - 2) : 0;
      one.depth = near + (is_group ? 0.2 * uniform() : 0);
      one.half_width = (is_group ? 0.22 : 0.18) + 0.08 * uniform();
      one.head = is_group ? -0.3 - 0.1 * uniform() : -0.1 + 0.5 * uniform();
      one.albedo = is_group ? 0.1 + 0.6 * uniform() : albedo;
      one.phase = 6 * uniform();
      people_.push_back(one);
    }
    stands_ = is_group ? 0.57 : 1.15 * uniform();
    phase_ = 14 * uniform();
  }

  /// Places them at a time. They walk in, stand for six seconds, walk out, and are away for three.
  void move_to(double time) {
    const double t = std::fmod(time + phase_, 14), speed = 0.8;
    is_there_ = t < 11;
    at_ = float(stands_);
    if (t < 2.5)
      at_ = float(stands_ - speed * (2.5 - t));
    else if (t < 8.5)
      at_ = float(stands_ + 0.004 * std::sin(2.1 * t));
    else
      at_ = float(stands_ + speed * (t - 8.5));
  }

  /// What a line to a point of the wall touches first; it comes from `eye` (x, y, depth).
  std::optional<Touched> first(const Eigen::Vector2f& on_wall, const Eigen::Vector3f& eye) const {
    std::optional<Touched> result;
    if (!is_there_) return result;
    const Eigen::Vector2f slope = (eye.head<2>() - on_wall) / eye.z();
    for (const Person& one : people_)
      if (const auto hit = touched(one, on_wall, slope); hit && (!result || hit->depth > result->depth))
        result = hit;
    return result;
  }

 private:
  std::optional<Touched> touched(const Person& one, const Eigen::Vector2f& on_wall,
                                 const Eigen::Vector2f& slope) const {
    Touched hit;
    hit.depth = float(one.depth + one.half_depth);
    for (int step = 0; step < 3; ++step) {
      hit.point = on_wall + hit.depth * slope;
      const float below = hit.point.y() - float(one.head);
      if (below < 0) return std::nullopt;
      const float share = below < 0.24f ? 0.45f : 1;
      const float u = (hit.point.x() - at_ - float(one.offset)) / (share * float(one.half_width));
      if (std::abs(u) >= 1) return std::nullopt;
      const float folds = 0.015f * std::sin(40 * u * share + float(one.phase)) + 0.03f * std::sin(9 * below);
      hit.depth = float(one.depth) + float(one.half_depth) * share * std::sqrt(1 - u * u) + folds;
      // Lit from the front: darker at the sides.
      hit.albedo = float(one.albedo) * (0.3f + 0.7f * std::sqrt(1 - u * u));
    }
    return hit;
  }

  std::vector<Person> people_;
  double stands_ = 0.5, phase_ = 0;
  float at_ = 0;
  bool is_there_ = false;
};

}  // namespace procam::watch::test
