#pragma once
/// In which directions the common surfaces do not fix the stations.
#include "joint_solve.hpp"

namespace procam::scan {

Unobservable unobservable_directions(const JointProblem& problem, const std::vector<JointRow>& rows,
                                     const RowWeights& weights);

/// Square over the unknowns of the poses: removes the unobservable directions of each station from a gradient.
MatX observable_projection(const JointProblem& problem, const Unobservable& open);

}  // namespace procam::scan
