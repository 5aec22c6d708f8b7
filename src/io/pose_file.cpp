#include "procam/io/pose_file.hpp"

#include <Eigen/Eigenvalues>

#include "document/shared_fields.hpp"

namespace procam::io {

/// Of the six directions, how many does a covariance leave without any error though their parts have some?
/// Exactly known parts (rows of zeros) do not count.
static int exact_combinations(const Mat6& covariance) {
  constexpr double kNothing = 1e-9;  // of a correlation's eigenvalue: files carry 15 digits
  std::vector<Eigen::Index> uncertain;
  for (Eigen::Index i = 0; i < 6; ++i)
    if (covariance(i, i) > 0) uncertain.push_back(i);
  const auto n = Eigen::Index(uncertain.size());
  MatX correlation(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::Index a = uncertain[std::size_t(i)], b = uncertain[std::size_t(j)];
      correlation(i, j) = covariance(a, b) / std::sqrt(covariance(a, a) * covariance(b, b));
    }
  if (n == 0) return 0;
  return int((Eigen::SelfAdjointEigenSolver<MatX>(correlation, Eigen::EigenvaluesOnly).eigenvalues().array() <
              kNothing)
                 .count());
}

static void fields(Fields& f, FrameTree::Link& link) {
  header(f, "procam-pose", 1);
  f.field("target", link.target);
  f.field("source", link.source);
  f.check(!link.target.empty() && !link.source.empty() && link.target != link.source, "source",
          "target and source are not the names of two frames",
          "name the frames so that x_target = pose * x_source, e.g. target projector, source world");
  fields(f, link.target_from_source.pose);
  Mat6& covariance = link.target_from_source.covariance;
  auto maybe_covariance = covariance.isZero(0) ? std::nullopt : std::optional(covariance);
  f.optional("covariance", maybe_covariance);
  if (!maybe_covariance) return;
  covariance = *maybe_covariance;
  check_covariance(f, "covariance", covariance);
  if (!f.reading()) return;
  const int exact = exact_combinations(covariance);
  f.check(
      exact == 0, "covariance",
      "it is singular: " + std::to_string(exact) +
          " combinations of its directions have no error at all, as no measured pose has",
      "give the localiser's covariance as it is, and rows and columns of zeros for what is exactly known");
}

FrameTree::Link load_pose(const std::filesystem::path& path) {
  return load_noun<FrameTree::Link>(path, Syntax::kJson);
}

void save_pose(const std::filesystem::path& path, const FrameTree::Link& pose) {
  save_noun(path, Syntax::kJson, pose);
}

}  // namespace procam::io
