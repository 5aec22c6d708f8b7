#include "procam/io/pose_file.hpp"

#include "shared_fields.hpp"

namespace procam::io {

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
}

FrameTree::Link load_pose(const std::filesystem::path& path) {
  return load_noun<FrameTree::Link>(path, Syntax::kJson);
}

void save_pose(const std::filesystem::path& path, const FrameTree::Link& pose) {
  save_noun(path, Syntax::kJson, pose);
}

}  // namespace procam::io
