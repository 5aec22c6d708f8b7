#include "procam/io/pose_file.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

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

static void fields(Fields& f, PanTiltAxes& axes) {
  f.field("offset", axes.offset);
  double degrees = axes.angle / kDegree;
  f.field("angle_deg", degrees);
  f.check(std::isfinite(axes.offset) && std::abs(degrees) > 1 && std::abs(degrees) < 179, "angle_deg",
          "the axes of a head are not parallel", "give the angle between them, about 90");
  axes.angle = degrees * kDegree;
}

static void fields(Fields& f, Mount& mount) {
  fields(f, mount.pose);
  f.optional("pan_tilt", mount.axes);
  f.optional("world_from_base", mount.world_from_base);
  auto joint = mount.joint_covariance.size() > 0 ? std::optional(mount.joint_covariance) : std::nullopt;
  f.optional("joint_covariance", joint);
  if (!joint) return;
  mount.joint_covariance = *joint;
  const Eigen::Index size = 6 + (mount.axes ? 2 : 0) + (mount.world_from_base ? 6 : 0);
  f.check(joint->rows() == size, "joint_covariance", "it has not " + std::to_string(size) + " rows",
          "give that of the pose, the axes and world_from_base, or leave it out");
  check_covariance(f, "joint_covariance", *joint);
}

Mount load_mount(const std::filesystem::path& path) {
  return load_noun<Mount>(path, Syntax::kJson);
}

void save_mount(const std::filesystem::path& path, const Mount& mount) {
  save_noun(path, Syntax::kJson, mount);
}

FrameTree::Link load_pose(const std::filesystem::path& path) {
  return load_noun<FrameTree::Link>(path, Syntax::kJson);
}

void save_pose(const std::filesystem::path& path, const FrameTree::Link& pose) {
  save_noun(path, Syntax::kJson, pose);
}

}  // namespace procam::io
