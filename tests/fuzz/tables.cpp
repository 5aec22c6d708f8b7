// Tables and logs: correspondences, points, trajectories, runs.
#include <cmath>

#include "fuzz_target.hpp"
#include "image/npy.hpp"
#include "procam/io/session/observations_file.hpp"
#include "procam/track/pose_log.hpp"
#include "procam/track/trajectory_file.hpp"
#include "session/observations_text.hpp"
#include "session/point_pairs_text.hpp"
#include "show/run_log.hpp"
#include "targets.hpp"
#include "wire_checks.hpp"

namespace procam::fuzz {
namespace {

std::string rewritten_run(const std::filesystem::path& from, const std::filesystem::path& to) {
  show::RunReader reader(from, folder() / "surfaces.json");
  const auto first = reader.next();
  if (!first) return "";
  {
    show::RunRecorder recorder(to, std::get<show::RunConditions>(*first).text);
    while (const std::optional<show::RunRecord> next = reader.next())
      std::visit(
          [&](const auto& record) {
            using Record = std::decay_t<decltype(record)>;
            if constexpr (!std::is_same_v<Record, show::RunConditions> &&
                          !std::is_same_v<Record, show::MissingParts>)
              recorder.record(record);
          },
          *next);
  }
  return io::read_file(to);
}

}  // namespace

/// CSV, or NumPy's array where it begins as one.
void observations(std::string_view bytes) {
  io::ObservationsContext context;
  context.board = Board(Chessboard{7, 9, 0.075});
  context.devices = {{"camera", DeviceKind::kCamera, {1280, 1024}},
                     {"projector", DeviceKind::kProjector, {1024, 768}}};
  if (bytes.substr(0, 6) == "\x93NUMPY") {
    io::load_observations(store("o.npy", bytes), context);
    return;
  }
  const Correspondences read = io::parse_observations(std::string(bytes), "o.csv", context);
  const std::string text = io::format_observations(read);
  const Correspondences again =
      must("reading what was written", [&] { return io::parse_observations(text, "p.csv"); });
  check_same(text, io::format_observations(again), "a table");
}

void point_pairs(std::string_view bytes) {
  for (const PointPair& pair : io::parse_point_pairs(std::string(bytes), "points.csv"))
    check(pair.point_in_world.allFinite() && pair.pixel.allFinite(),
          "a point was accepted that is not finite");
}

/// With a form feed: KITTI's poses, then their times.
void trajectory(std::string_view bytes) {
  std::string file = store("t.txt", bytes.substr(0, bytes.find('\f'))).string();
  if (const std::size_t cut = bytes.find('\f'); cut != std::string_view::npos)
    file += "+" + store("times.txt", bytes.substr(cut + 1)).string();
  const track::Trajectory read = track::read_trajectory(file);
  check(!read.poses.empty(), "a trajectory without poses was accepted");
  double before = -HUGE_VAL;
  for (const track::StampedPose& pose : read.poses) {
    check_message(pose);
    check(pose.stamp && *pose.stamp > before, "stamps do not increase");
    before = *pose.stamp;
  }
}

void pose_log(std::string_view bytes) {
  for (const track::StampedPose& pose : track::read_pose_log(store("poses.log", bytes))) check_message(pose);
}

/// A run is recorded again from what was read; recorded twice it is the same file.
void run_log(std::string_view bytes) {
  const std::filesystem::path first = store("run.log", bytes), once = folder() / "once.log";
  const std::string text = rewritten_run(first, once);
  if (text.empty()) return;
  const std::string twice =
      must("replaying what was recorded", [&] { return rewritten_run(once, folder() / "twice.log"); });
  check_same(text, twice, "a run");
}

}  // namespace procam::fuzz
