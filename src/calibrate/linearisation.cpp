#include "linearisation.hpp"

#include <cmath>

#include "procam/calibrate/costs/se3_manifold.hpp"
#include "residual_blocks.hpp"

namespace procam::calibrate {
namespace {

using Block = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;

std::vector<double> block_of(const Pose& pose) {
  std::vector<double> block(kPoseBlockSize);
  pose_to_block(pose, block.data());
  return block;
}

}  // namespace

/// A block's derivative and where its columns go: position in the block -> row of the common vector.
struct Linearisation::Part {
  Block derivative;
  const double* parameters;
  std::vector<std::pair<int, int>> columns;
};

Linearisation::Linearisation(const BundleState& state, const CommonParameters& common)
    : state_(state), common_(common) {
  for (const Camera& lens : state.lenses) lenses_.push_back(parameters_of(lens));
  for (const Pose& pose : state.device_from_rig) devices_.push_back(block_of(pose));
  for (const Pose& pose : state.rig_from_board) boards_.push_back(block_of(pose));
}

void Linearisation::add_device(std::size_t d, std::vector<Part>& parts) const {
  parts.push_back({Block(2, lenses_[d].size()), lenses_[d].data(), {}});
  for (std::size_t i = 0; i < common_.free_of_lens[d].size() && common_.lens_at[d] >= 0; ++i)
    parts.back().columns.emplace_back(common_.free_of_lens[d][i], common_.lens_at[d] + int(i));
  parts.push_back({Block(2, kPoseBlockSize), devices_[d].data(), {}});
  for (int i = 0; i < 6 && common_.pose_at[d] >= 0; ++i)
    parts.back().columns.emplace_back(i, common_.pose_at[d] + i);
}

std::optional<Linearised> Linearisation::operator()(const Measurement& m,
                                                    const BundleOptions& options) const {
  const auto d = std::size_t(m.device);
  const auto cost = measurement_cost(state_, m, options.noise[d]);
  if (cost == nullptr) return std::nullopt;
  std::vector<Part> parts;
  std::vector<std::pair<int, std::size_t>> lens_of;  // device, position in `parts`
  const auto add = [&](int device) {
    lens_of.emplace_back(device, parts.size());
    add_device(std::size_t(device), parts);
  };
  if (m.light != nullptr || read_at_corner(m)) add(m.camera());
  add(m.device);
  const std::size_t pose = parts.size();
  parts.push_back({Block(2, kPoseBlockSize), boards_[std::size_t(m.view)].data(), {}});
  if (m.observation != nullptr) {
    const auto point = std::size_t(m.observation->point);
    parts.push_back({Block(2, 3), state_.points_in_board[point].data(), {}});
    for (int i = 0; i < 3 && common_.point_at[point] >= 0; ++i)
      parts.back().columns.emplace_back(i, common_.point_at[point] + i);
  } else {
    parts.push_back({Block(2, 3), state_.sheet.curvature.data(), {}});
    for (int i = 0; i < 3 && common_.sheet_at >= 0; ++i)
      parts.back().columns.emplace_back(i, common_.sheet_at + i);
  }
  const std::size_t flex = parts.size();
  if (!state_.flex.empty()) parts.push_back({Block(2, 3), state_.flex[std::size_t(m.view)].data(), {}});
  const std::size_t change = parts.size();
  const int camera = changed_camera(state_, m);
  if (camera >= 0)
    parts.push_back({Block(2, 3), state_.image_changes[std::size_t(m.view)][std::size_t(camera)].data(), {}});
  std::vector<const double*> parameters;
  std::vector<double*> derivatives;
  std::size_t count = 0;
  for (Part& part : parts) {
    parameters.push_back(part.parameters);
    derivatives.push_back(part.derivative.data());
    count += part.columns.size();
  }
  Linearised out;
  if (!cost->Evaluate(parameters.data(), out.residual.data(), derivatives.data())) return std::nullopt;
  // Huber's weight: residuals beyond the limit pull linearly.
  const double length = out.residual.norm();
  const double weight =
      options.huber_sigmas > 0 && length > options.huber_sigmas ? options.huber_sigmas / length : 1;
  out.residual *= std::sqrt(weight);
  const OwnOfView own = own_of_view(options, state_.lenses.size());
  out.by_view = Block::Zero(2, own.size);
  out.by_view.leftCols<6>() = std::sqrt(weight) * parts[pose].derivative.leftCols<6>();
  if (own.flex_at >= 0) out.by_view.middleCols<3>(own.flex_at) = std::sqrt(weight) * parts[flex].derivative;
  if (own.images_at >= 0 && camera >= 0)
    out.by_view.middleCols<3>(own.images_at + 3 * camera) = std::sqrt(weight) * parts[change].derivative;
  out.by_common.resize(2, Eigen::Index(count));
  for (const Part& part : parts)
    for (const auto& [from, to] : part.columns) {
      out.by_common.col(Eigen::Index(out.columns.size())) = std::sqrt(weight) * part.derivative.col(from);
      out.columns.push_back(to);
    }
  for (const auto& [device, part] : lens_of)
    out.by_shift.emplace_back(device, std::sqrt(weight) * parts[part].derivative.middleCols<2>(kCx));
  return out;
}

}  // namespace procam::calibrate
