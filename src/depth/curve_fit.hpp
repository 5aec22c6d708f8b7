#pragma once
/// Cylinders and spheres through the cells of a depth image.
#include <optional>
#include <vector>

#include "regions.hpp"

namespace procam::depth::internal {

/// So many cells say what a shape is as well as all of them, sooner.
inline constexpr std::size_t kSamples = 120;

/// A cell as a point, and what it may be off along its ray.
struct Sample {
  Vec3 point, ray;
  double sigma = 0;
  Vec3 normal = Vec3::Zero();  ///< towards the camera; zero where too little is known
};

Sample sample_of(const Cell& cell);

/// One of two: with an axis a cylinder, without a sphere.
struct Shape {
  bool cylinder = true;
  Vec3 middle = Vec3::Zero(), axis = Vec3::UnitY();
  double radius = 0;

  Vec3 from_axis(const Vec3& point) const {
    const Vec3 d = point - middle;
    return cylinder ? Vec3(d - axis * axis.dot(d)) : d;
  }
  /// In sigmas along the ray.
  double residual(const Sample& s) const {
    const Vec3 out = from_axis(s.point);
    const double length = out.norm();
    if (!(length > 1e-9)) return 1e3;
    const double cosine = std::max(std::abs(out.dot(s.ray)) / length, 0.2);
    return (length - radius) / (s.sigma * cosine);
  }
};

struct Fit {
  Shape shape;
  double rms_sigmas = 0, rms = 0, turn = 0;
  bool outside = true;
};

/// The shape refined on the samples; nothing where no such shape explains them.
std::optional<Fit> fit_from(const std::vector<Sample>& samples, Shape shape);

/// From nothing but the samples, which have normals.
std::optional<Fit> fit_shape(const std::vector<Sample>& samples, bool cylinder);

/// The part of the shape that the samples lie on, in a frame that is read upright by the camera.
DetectedCurve curve_of(const Fit& fit, const std::vector<Sample>& samples);

/// Samples of the cells, without normals.
std::vector<Sample> points_of(const CellGrid& grid, const std::vector<int>& cells);

/// And with normals of blocks of 5 x 5 cells.
std::vector<Sample> samples_of(const CellGrid& grid, const std::vector<int>& cells);

}  // namespace procam::depth::internal
