#pragma once
/// A simulated room at the level of devices: one or two projectors and a camera in front of a slanted wall with a round column, and
/// a person who holds a printed board. The camera sees the frames that the projector shows, later and through both lenses
/// (simulate/live_view.hpp).
#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "procam/core/board/board.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/device/depth_source.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/device/frame_source.hpp"
#include "procam/simulate/live_view.hpp"
#include "procam/simulate/session.hpp"
#include "procam/studio/studio.hpp"
#include "project.hpp"

namespace procam::studio {

class SimulatedStage {
 public:
  explicit SimulatedStage(const SimulatedRoom& options);
  ~SimulatedStage();
  SimulatedStage(const SimulatedStage&) = delete;
  SimulatedStage& operator=(const SimulatedStage&) = delete;

  device::FrameSink& projector(std::size_t i = 0);
  /// As they are chosen: "simulated", and with two "simulated 2".
  std::vector<ChosenProjector> all_projectors() const;
  device::FrameSource& camera();
  /// Registered to the camera: the same lens at the same place, with the noise of a Kinect (simulate/depth_view.hpp).
  device::DepthSource& depth_camera();

  /// The person takes a print of this board, or puts it away.
  void take_board(const std::optional<Board>& board);
  /// Moves it to the pose nearest to the given one that camera and that projector both cover; the move takes a moment.
  /// false: there is none near it, and the board stays.
  bool hold_at(const Pose& wished, std::size_t projector = 0);
  void put_board_away();
  /// Somebody glues the marker flat to the wall, left of the column, or takes it off.
  void hang_marker(const std::optional<PlacedMarker>& marker, MarkerDictionary dictionary);
  /// Somebody knocks against the first projector: 0.2 degrees.
  void bump_projector();
  bool is_moving() const { return moving_; }

  /// With the names of projectors() of a project.
  const Rig& truth() const { return rig_; }
  /// The point of the wall or the column that a camera or projector ray in the rig's frame meets first.
  std::optional<Vec3> on_wall(const Ray& ray_in_rig) const;

 private:
  class Sink;
  class Source;
  class Depth;
  struct Shown {
    double time_s;
    std::shared_ptr<const ImageU8> frame;
  };

  simulate::Room room(const std::optional<Pose>& rig_from_board) const;
  std::shared_ptr<const simulate::LiveView> trace(const std::optional<Pose>& rig_from_board) const;
  bool is_usable(const Pose& rig_from_board, const RigProjector& projector) const;
  void add_projector();
  void move_boards();
  void expose_images();
  std::shared_ptr<const ImageU8> frame_at(std::size_t projector, double time_s);

  const SimulatedRoom options_;
  Rig rig_;
  simulate::CaptureOptions capture_;
  Pose rig_from_wall_, rig_from_column_;  ///< of the column, z is the axis
  std::vector<std::unique_ptr<Sink>> sinks_;
  std::unique_ptr<Source> source_;
  std::unique_ptr<Depth> depth_;

  std::mutex mutex_;  ///< of all below
  std::condition_variable changed_;
  std::vector<std::deque<Shown>> shown_;  ///< by projector, the newest last
  std::deque<device::SeenFrame> seen_;
  std::optional<simulate::PrintedBoard> board_;
  std::optional<simulate::Body> marker_;
  struct Wish {
    std::optional<Pose> rig_from_board;  ///< nullopt: no board
  };
  std::optional<Wish> wish_;
  std::optional<Pose> held_;
  std::shared_ptr<const simulate::LiveView> view_;
  std::atomic<bool> moving_{false}, ended_{false};
  std::thread person_, sensor_;
};

}  // namespace procam::studio
