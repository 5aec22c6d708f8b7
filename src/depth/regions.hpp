#pragma once
/// Connected cells that lie on one plane, and how far they are from being curved.
#include "cells.hpp"

namespace procam::depth::internal {

struct Region {
  std::vector<int> cells;
  Moments moments;
  InverseDepthPlane plane;
  double bend = 0;  ///< RMS of the second-order part of its residuals, in sigmas of what readings share
};

struct Regions {
  std::vector<Region> regions;
  std::vector<int> owner;  ///< of every cell; -1: none
};

/// Grown, with parts of one plane joined, each classified as plane or curved.
Regions grow_regions(const CellGrid& grid, const PlaneOptions& options);

/// For every cell: are it and all its neighbours of one owner? Edges of the image are no neighbours.
std::vector<char> alone_cells(const CellGrid& grid, const std::vector<int>& owner);

/// The region's plane and moments from these cells.
void refit(const CellGrid& grid, const std::vector<int>& cells, Moments& moments, InverseDepthPlane& plane);

/// The curves that curved regions make; regions they explain are taken out of `regions` (their cells' owner
/// becomes kCurveOwner - place in the list), the rest of the curved ones owned by kUnexplained.
struct Curve {
  DetectedCurve curve;
  std::vector<int> cells;
};
inline constexpr int kUnexplained = -2, kCurveOwner = -3;
std::vector<Curve> take_curves(const CellGrid& grid, const PlaneOptions& options, Regions& regions);

}  // namespace procam::depth::internal
