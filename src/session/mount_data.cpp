#include "procam/session/mount_data.hpp"

#include <algorithm>
#include <fstream>

#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/track/head_angles.hpp"
#include "procam/track/locate.hpp"
#include "procam/track/pose_log.hpp"
#include "procam/track/trajectory_file.hpp"
#include "timed_images.hpp"

namespace procam::session {
namespace {

namespace fs = std::filesystem;

bool is_pose_log(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return stream.get() == '{';
}

/// Stamps if every message has one, else arrivals.
class MessageTime {
 public:
  MessageTime(const std::vector<track::StampedPose>& messages, const std::string& file,
              Diagnostics& diagnostics)
      : stamped_(std::all_of(messages.begin(), messages.end(),
                             [](const track::StampedPose& message) { return message.stamp.has_value(); })) {
    if (!stamped_)
      diagnostics.note("arrival_times",
                       file + ": not every message has a stamp, so that the times of arrival are used");
  }
  double operator()(const track::StampedPose& message) const {
    return stamped_ ? *message.stamp : message.arrival;
  }

 private:
  bool stamped_;
};

/// Stamps that jump against the arrivals: a clock was set. Medians of the messages before and after.
template <typename Message>
void remark_on_clock(const std::vector<Message>& messages, const std::string& file,
                     Diagnostics& diagnostics) {
  constexpr std::size_t kSide = 10;
  constexpr double kMinJump = 0.03;  // s: more than the scatter of a median of ten
  constexpr double kWrong = 0.1;     // s: no delay of a network, and 50 mm of a robot at 0.5 m/s
  std::vector<double> ages;
  for (const Message& message : messages)
    if (message.stamp) ages.push_back(message.arrival - *message.stamp);
  if (ages.size() != messages.size()) return;
  const auto spread = [](const std::vector<double>& side) {
    const auto [low, high] = std::minmax_element(side.begin(), side.end());
    return *high - *low;
  };
  double largest = 0, at = 0;
  for (std::size_t i = kSide; i + kSide <= ages.size(); ++i) {
    const auto middle = ages.begin() + std::ptrdiff_t(i);
    const std::vector<double> before(middle - kSide, middle), after(middle, middle + kSide);
    const double jump = median(before) - median(after);
    if (std::abs(jump) <= std::max(std::abs(largest), 2 * std::max(spread(before), spread(after)))) continue;
    largest = jump, at = *messages[i].stamp;
  }
  if (std::abs(largest) < kMinJump) return;
  const std::string text = file + ": the stamps jump by " + fixed(1e3 * largest, 0) +
                           " ms against the arrivals at " + fixed(at, 2) +
                           " s: a clock was set. Use the part before or after alone";
  if (std::abs(largest) < kWrong)
    diagnostics.warn("clock_jumped", text);
  else
    diagnostics.fail("clock_jumped", text);
}

void add_input(MountRecording& recording, const std::string& file) {
  if (fs::is_regular_file(file)) recording.inputs.push_back({file, io::sha256_of_file(file)});
}

/// Messages of one child; the names of the others are counted.
std::vector<track::StampedPose> messages_of(std::vector<track::StampedPose> messages,
                                            const std::string& child, const std::string& file,
                                            const std::string& flag) {
  std::vector<std::string> others;
  std::vector<track::StampedPose> kept;
  for (track::StampedPose& message : messages) {
    if (message.child == child)
      kept.push_back(std::move(message));
    else if (std::find(others.begin(), others.end(), message.child) == others.end())
      others.push_back(message.child);
  }
  if (kept.empty())
    throw Error(ErrorKind::kInput, file, "no message is of the frame '" + child + "'",
                others.empty() ? "give a log that holds poses"
                               : "it holds " + and_list(others) + ": name the right one with " + flag);
  return kept;
}

/// Where most poses equal the one before, bit for bit, the localiser sends its last one again with a new stamp.
void drop_repeats(const std::string& file, MountRecording& recording) {
  std::vector<BasePose>& base = recording.data.base;
  const auto repeats = [](const BasePose& one, const BasePose& next) {
    return one.world_from_base.translation == next.world_from_base.translation &&
           one.world_from_base.rotation.coeffs() == next.world_from_base.rotation.coeffs();
  };
  std::vector<BasePose> kept;
  for (std::size_t i = 0; i < base.size(); ++i)
    if (i == 0 || !repeats(base[i - 1], base[i])) kept.push_back(base[i]);
  const std::size_t repeated = base.size() - kept.size();
  if (2 * repeated < base.size() || kept.size() < 2) return;
  recording.diagnostics.note("poses_repeated", file + ": " + std::to_string(repeated) + " of " +
                                                   std::to_string(base.size()) +
                                                   " poses repeat the one before and are skipped");
  base = std::move(kept);
}

void read_base(const MountFiles& files, MountRecording& recording) {
  std::vector<track::StampedPose> messages;
  if (is_pose_log(files.base))
    messages = messages_of(track::read_pose_log(files.base), files.child, files.base, "--child");
  else
    messages = track::read_trajectory(files.base).poses;
  add_input(recording, files.base);
  const MessageTime time(messages, files.base, recording.diagnostics);
  recording.world = messages.front().frame;
  std::size_t dropped = 0;
  for (const track::StampedPose& message : messages) {
    if (message.frame != recording.world)
      throw Error(ErrorKind::kInput, files.base,
                  "the poses of '" + files.child + "' are in the frames '" + recording.world + "' and '" +
                      message.frame + "'",
                  "record one localiser alone");
    std::vector<BasePose>& base = recording.data.base;
    if (!base.empty() && !(time(message) > base.back().time))
      ++dropped;
    else
      base.push_back({time(message), message.frame_from_child});
  }
  remark_on_clock(messages, files.base, recording.diagnostics);
  drop_repeats(files.base, recording);
  if (dropped > 0)
    recording.diagnostics.note("poses_out_of_order",
                               files.base + ": " + std::to_string(dropped) + " of " +
                                   std::to_string(messages.size()) +
                                   " poses are not later than those before them and are skipped");
}

void read_angles(const MountFiles& files, MountRecording& recording) {
  const std::vector<track::StampedAngles> log = track::read_angle_log(files.angles);
  add_input(recording, files.angles);
  std::size_t dropped = 0;
  std::vector<HeadAngles>& angles = recording.data.angles;
  for (const track::StampedAngles& message : log) {
    const double time = message.stamp.value_or(message.arrival);
    if (!angles.empty() && !(time > angles.back().time))
      ++dropped;
    else
      angles.push_back({time, message.pan, message.tilt});
  }
  remark_on_clock(log, files.angles, recording.diagnostics);
  if (dropped > 0)
    recording.diagnostics.note("poses_out_of_order",
                               files.angles + ": " + std::to_string(dropped) + " of " +
                                   std::to_string(log.size()) +
                                   " angles are not later than those before them and are skipped");
}

void read_sightings(const MountFiles& files, MountRecording& recording) {
  if (!is_pose_log(files.sightings))
    throw Error(ErrorKind::kInput, files.sightings, "it is no pose log",
                "give a log whose messages have the marker as frame and the rig as child, with covariance "
                "(docs/mount.md)");
  const std::vector<track::StampedPose> messages =
      messages_of(track::read_pose_log(files.sightings), files.rig, files.sightings, "--rig-frame");
  if (files.sightings != files.base) add_input(recording, files.sightings);
  const MessageTime time(messages, files.sightings, recording.diagnostics);
  remark_on_clock(messages, files.sightings, recording.diagnostics);
  for (const track::StampedPose& message : messages) {
    if (!message.covariance)
      throw Error(ErrorKind::kInput, files.sightings,
                  "a sighting of '" + message.frame + "' at " + fixed(time(message), 3) +
                      " s has no covariance: how much it counts is unknown",
                  "write the covariance that the marker's pose was located with");
    recording.data.sightings.push_back({time(message),
                                        message.frame,
                                        {message.frame_from_child, *message.covariance},
                                        message.frame.rfind("plane_", 0) == 0});
  }
}

/// nullopt if the marker's pose is not certain.
std::optional<PoseWithCovariance> marker_from_rig(const SeenMarker& seen, ImageSize size,
                                                  const RigCamera& camera, const SightingImages& images) {
  MarkerMap alone;
  alone.dictionary = images.dictionary;
  alone.markers = {{seen.id, images.size, Pose()}};
  MarkerDetections detections;
  detections.image_size = size;
  detections.markers = {seen};
  try {
    const track::LocateResult located = track::locate(detections, camera.camera, alone);
    return inverse(
        compose({camera.rig_from_camera, Mat6::Zero()}, {located.camera_from_world, located.covariance}));
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kDegenerate && error.kind() != ErrorKind::kNotConverged) throw;
    return std::nullopt;  // a flat view whose mirror image fits as well
  }
}

}  // namespace

MountRecording read_mount_data(const MountFiles& files) {
  MountRecording recording;
  if (files.angles.empty())
    read_base(files, recording);
  else
    read_angles(files, recording);
  if (!files.sightings.empty()) read_sightings(files, recording);
  return recording;
}

std::vector<MarkerSighting> sightings_in_images(const SightingImages& images, const RigCamera& camera) {
  require(images.size > 0, "sightings_in_images: the marker's size is not positive");
  const MarkerCells cells = detect::marker_cells(images.dictionary);
  std::vector<MarkerSighting> sightings;
  const auto files = timed_images(images.folder, {".png", ".jpg", ".jpeg", ".pgm"});
  for (const auto& [time, file] : files) {
    const ImageU8 grey = io::green_channel(io::load_image(file).image);
    if (grey.size() != camera.camera.size)
      throw Error(ErrorKind::kInput, file.string(), "it is not of the size of the rig's camera",
                  "use images of that camera in the mode in which it was calibrated");
    const MarkerDetections seen = detect::detect_marker_edges(grey, cells, {camera.camera});
    for (const SeenMarker& marker : seen.markers)
      if (const auto pose = marker_from_rig(marker, grey.size(), camera, images))
        sightings.push_back({time, "marker_" + std::to_string(marker.id), *pose});
  }
  if (sightings.empty())
    throw Error(ErrorKind::kNotEnoughData, images.folder.string(),
                std::to_string(files.size()) + " images show no marker of " + info_of(images.dictionary).name,
                "check the dictionary, and that markers are 30 pixels wide or more");
  return sightings;
}

}  // namespace procam::session
