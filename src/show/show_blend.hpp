#pragma once
/// The blend of a running show: which projectors of the rig light its surfaces, and the map of this one.
///
///   BlendMaker maker(plan);
///   maker.want(version, scene, {{"left", "right"}, {"left"}});
///   if (const auto made = maker.find({"left", "right"})) projection.set_blend(made->blend);
///
/// The other projectors stand in the rig where its file has them, and show the same surfaces. Surfaces in the frame of a
/// projector are that projector's alone, and are not blended; nor are surfaces in the world of a rig that moves.
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"
#include "procam/dds/group.hpp"
#include "procam/show/projection.hpp"
#include "procam/show/show_options.hpp"
#include "procam/surface/blend.hpp"

namespace procam::show {

/// Names of projectors in the rig, sorted.
using ProjectorNames = std::vector<std::string>;

/// What stays the same while a show runs.
struct BlendPlan {
  Rig rig;
  std::string projector;               ///< this one's name
  std::optional<Pose> rig_from_world;  ///< of a rig that stands still
  BlendSettings settings;
  ProjectorNames fixed;  ///< that blend, this one among them; empty: those that the hosts of a group announce
  int threads = 0;
};

/// What a map depends on besides.
struct BlendScene {
  ProjectorNames projectors;  ///< with light, this one among them; none: this one is dark
  Pose rig_from_projector;    ///< this one's, which may be corrected
  SurfaceSet surfaces;
};

struct MadeBlend {
  BlendScene scene;
  std::shared_ptr<const surface::FrameBlend> blend;  ///< null: frames stay as they are drawn
  ProjectorNames neighbours;                         ///< that light places of this projector
  Diagnostics diagnostics;
};

/// What a recorded run was blended with: the plan without the projectors.
BlendPlan blend_basis(const ShowOptions& options, const Rig& rig, const ProjectionOptions& projection);

/// The plan of a show's options; nullopt: it does not blend. Throws Error(kInput) for names that the rig does not have,
/// and for surfaces in the world of a rig that moves, unless it blends in a group, where these are not blended.
std::optional<BlendPlan> plan_blend(const ShowOptions& options, const Rig& rig,
                                    const ProjectionOptions& projection, const SurfaceSet& surfaces);

/// Are there surfaces in the world of a rig that moves?
bool has_moving_surfaces(const BlendPlan& plan, const SurfaceSet& surfaces);

/// The same inputs give the same map, bit for bit. Throws Error as surface::solve_surfaces() does.
MadeBlend make_blend(const BlendPlan& plan, BlendScene scene);

/// Which projectors light at a time, and which may next.
struct BlendTurn {
  bool is_dark = false;              ///< those of this process, before their first light
  ProjectorNames now;                ///< with those of this process
  ProjectorNames announced;          ///< and those whose light comes later
  std::vector<ProjectorNames> next;  ///< sets that may follow, the likely ones first
};

/// `own`: the projectors of this process. `own_from`: group time of their first light; nullopt: it is not announced.
/// `light_time` is group time.
BlendTurn blend_turn(const ProjectorNames& own, const std::optional<double>& own_from,
                     const std::vector<dds::GroupLight>& others, double light_time);

/// Makes maps on a thread of its own. Nothing waits for it but make_now().
class BlendMaker {
 public:
  explicit BlendMaker(BlendPlan plan);
  ~BlendMaker();
  BlendMaker(const BlendMaker&) = delete;
  BlendMaker& operator=(const BlendMaker&) = delete;

  const BlendPlan& plan() const { return plan_; }
  /// Maps for these sets of projectors, the most urgent first; others are forgotten. The scene's surfaces are looked at where
  /// `version` differs from that of the last call.
  void want(std::uint64_t version, const BlendScene& scene, std::vector<ProjectorNames> sets);
  /// Is the map of a set made, and of the newest version?
  bool is_ready(const ProjectorNames& set) const;
  /// The newest map that is made for a set that is wanted; null: none yet. It may be of the surfaces before.
  std::shared_ptr<const MadeBlend> find(const ProjectorNames& set) const;
  /// In this thread.
  std::shared_ptr<const MadeBlend> make_now(BlendScene scene) const;
  /// Why the last map could not be made, since the last call.
  std::optional<std::string> take_fault();

 private:
  struct Made {
    std::uint64_t version = 0;
    std::shared_ptr<const MadeBlend> made;  ///< null: it failed, and there is none from before
  };
  void run();
  /// The most urgent set whose map is not of the newest surfaces.
  const ProjectorNames* next_set() const;
  void keep(std::uint64_t version, const std::shared_ptr<const MadeBlend>& made);

  const BlendPlan plan_;
  mutable std::mutex mutex_;  ///< of all below
  std::condition_variable woken_;
  bool ends_ = false;
  std::uint64_t version_ = 0;
  BlendScene scene_;
  std::vector<ProjectorNames> sets_;
  std::map<ProjectorNames, Made> made_;
  std::optional<std::string> fault_;
  std::thread thread_;  ///< the last: it uses all above
};

/// A map that leaves no light.
std::shared_ptr<const surface::FrameBlend> dark_blend(ImageSize size);

}  // namespace procam::show
