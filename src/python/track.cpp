// procam.track
#include "procam/track.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_clock(py::module_& m) {
  Enum<track::ClockVerdict>(m, "ClockVerdict", "What observe() made of a message.")
      .value("kTaken", track::ClockVerdict::kTaken, "its time is to be believed")
      .value("kDoubtful", track::ClockVerdict::kDoubtful, "its stamp contradicts the others; wait for more")
      .value("kJumped", track::ClockVerdict::kJumped,
             "the sender's clock was set: this message confirmed it, and its time is to be\n"
             "believed");

  Record<track::ClockOptions> clock_options(m, "ClockOptions", "How a sender's clock is followed.");
  clock_options.fields_init()
      .field("window", &track::ClockOptions::window,
             "seconds of the sender's clock that the line is fitted to")
      .field("max_drift", &track::ClockOptions::max_drift,
             "500 ppm: NTP slews no faster, crystals are ten times better")
      .field("jump", &track::ClockOptions::jump,
             "A message that is later than the fastest by more than this is doubtful. After\n"
             "`confirm` of them that agree over 2 * jump seconds the clock was set back by as\n"
             "much. Steps back by less are absorbed after three bins (1/20 of the window) whose\n"
             "messages all stay above the line. Steps forward show as messages faster than any:\n"
             "from 10 ms on, `confirm` of them are enough.")
      .field("confirm", &track::ClockOptions::confirm, "messages in a row")
      .field("known_offset", &track::ClockOptions::known_offset,
             "local - sender, for clocks that are known to agree (one machine, PTP):\n"
             "local_from_unix() when stamps are Unix time. Nothing is estimated then, and no\n"
             "constant delay is hidden.");

  Record<track::Clock> clock(m, "Clock",
                             "Estimates a sender's clock against the local one, from stamps and arrivals in\n"
                             "seconds.");
  Record<track::Clock::Estimate> estimate(clock.type, "Estimate",
                                          "Offset of the sender's clock, and how well it is known.");
  clock
      .init([](const track::ClockOptions& options) { return track::Clock(options); }, "",
            py::arg_v("options", track::ClockOptions{}, "ClockOptions()"))
      .method("observe", &track::Clock::observe, "Takes one (stamp, arrival); both finite (ValueError).",
              py::arg("stamp"), py::arg("arrival"))
      .method("time", &track::Clock::time,
              "The local moment that a stamp speaks of, later by the shortest delay. Before the\n"
              "first message: the stamp plus the known offset, or plus zero.",
              py::arg("stamp"))
      .method("estimate", &track::Clock::estimate, "The present estimate; seconds.");
  estimate.fields_init()
      .field("offset", &track::Clock::Estimate::offset,
             "local - sender at the last stamp, seconds, with the shortest delay in it")
      .field("drift", &track::Clock::Estimate::drift, "local seconds a sender's second, less one")
      .field("sigma", &track::Clock::Estimate::sigma, "standard deviation of the offset, seconds")
      .field("jitter", &track::Clock::Estimate::jitter, "mean of arrival - time, seconds")
      .field("jumps", &track::Clock::Estimate::jumps, "");

  function(m, "local_from_unix", &track::local_from_unix,
           "steady_now() less the system clock's Unix time, now: ClockOptions::known_offset for\n"
           "stamps in Unix time of this machine, or of one that PTP keeps with it. It changes\n"
           "when the system clock is set.");
  m.attr("steady_now") = py::module_::import("procam").attr("steady_now");
}

void bind_locate(py::module_& m) {
  Record<track::LocateOptions> locate_options(m, "LocateOptions",
                                              "How locate() weighs corners, and which poses it refuses.");
  locate_options.fields_init()
      .field("outlier_px", &track::LocateOptions::outlier_px,
             "A marker whose corners lie further than this from where the others put it (and three\n"
             "sigmas of the map and of the image) was moved or measured wrong: it is rejected and\n"
             "named.")
      .field("largest_odds", &track::LocateOptions::largest_odds,
             "Odds of the second pose from which no pose is given.");

  Record<track::LocatedMarker> located_marker(m, "LocatedMarker", "One marker of the map in the image.");
  located_marker.fields_init()
      .field("id", &track::LocatedMarker::id, "")
      .field("used", &track::LocatedMarker::used, "")
      .field("edge_rms_px", &track::LocatedMarker::edge_rms_px, "of its edges from the fit")
      .field("error_px", &track::LocatedMarker::error_px,
             "rms distance of its corners from where the fit puts them")
      .field("reason", &track::LocatedMarker::reason, "why it was rejected; empty when used");

  Record<track::LocateResult> locate_result(m, "LocateResult",
                                            "The camera's pose by markers, with covariance.");
  locate_result.fields_init()
      .field("camera_from_world", &track::LocateResult::camera_from_world, "")
      .field("covariance", &track::LocateResult::covariance,
             "Of the left increment: image noise and the map's sigmas, scaled up when the\n"
             "residuals exceed them. The lens is taken as exact here.")
      .field("jacobian_lens", &track::LocateResult::jacobian_lens,
             "What the lens adds: d increment / d camera parameters, 6 rows, columns in the order\n"
             "of parameter_names(camera).")
      .field("other", &track::LocateResult::other, "the second pose that fits, if there is one")
      .field("other_covariance", &track::LocateResult::other_covariance, "its, as `covariance`")
      .field("other_chi2", &track::LocateResult::other_chi2,
             "its chi-square above that of the first, scaled as the covariance")
      .field("other_odds", &track::LocateResult::other_odds, "that it is the true one, 0 .. 1/2")
      .field("chi2_per_dof", &track::LocateResult::chi2_per_dof, "about 1 when noise and map are as stated")
      .field("markers", &track::LocateResult::markers, "")
      .field("diagnostics", &track::LocateResult::diagnostics, "");

  Record<track::Chain> chain(m, "Chain", "projector_from_world = projector_from_camera * camera_from_world.");
  chain.fields_init()
      .field("links", &track::Chain::links, "in the order of multiplication, each with its own covariance")
      .field("total", &track::Chain::total, "");

  function(m, "locate", &track::locate,
           "Remarks: \"marker_left_out\" names a moved marker, \"second_pose\" gives odds above\n"
           "1/1000, \"map_disagrees\" says that the residuals are above what image and map\n"
           "promise, \"marker_coarse\" that neither edges nor pixels of a marker could be fitted\n"
           "and the detector's corners are used.\n"
           "\n"
           "Raises Error kNotEnoughData when no marker of the map is seen, kDegenerate when the\n"
           "markers contradict each other without a majority or when the second pose cannot be\n"
           "excluded, kNotConverged; and ValueError when the image's size is not the\n"
           "camera's or the map's sizes are not positive.",
           py::arg("detections"), py::arg("camera"), py::arg("map"),
           py::arg_v("options", track::LocateOptions{}, "LocateOptions()"));
  function(m, "projector_chain", &track::projector_chain,
           "The covariance of the total counts what the rig file says of the lens and of both\n"
           "devices' places once, with its correlations: the links' own covariances overlap\n"
           "where the lens takes part in both.",
           py::arg("rig"), py::arg("projector"), py::arg("camera"), py::arg("seen"));
}

void bind_align_maps(py::module_& m) {
  Enum<track::MapElementKind>(m, "MapElementKind", "Plane or pose.")
      .value("kPlane", track::MapElementKind::kPlane)
      .value("kPose", track::MapElementKind::kPose);
  Record<track::MapElement>(m, "MapElement", "Something that a map holds.")
      .fields_init()
      .field("name", &track::MapElement::name, "\"floor\", \"marker 3\"")
      .field("kind", &track::MapElement::kind, "")
      .field("map_from_element", &track::MapElement::map_from_element,
             "of a plane: its origin lies on it, z is its normal")
      .field(
          "covariance", &track::MapElement::covariance,
          "Of the right increment [rotation, translation]; of a plane the rows rx, ry and tz\ncount. rad^2, rad m, m^2.");
  Record<track::PlacedSigma>(m, "PlacedSigma", "One standard deviation an axis.")
      .fields_init()
      .field("position", &track::PlacedSigma::position, "metres")
      .field("angle", &track::PlacedSigma::angle, "radians");
  Record<track::AlignMapsOptions>(m, "AlignMapsOptions", "How align_maps() pairs and weighs elements.")
      .fields_init()
      .field("planes_by_geometry", &track::AlignMapsOptions::planes_by_geometry,
             "Planes are matched by where they are, whatever their names are.")
      .field("largest_sigma", &track::AlignMapsOptions::largest_sigma,
             "An alignment that is known less well in any direction is refused.");
  Record<track::AlignedPair>(m, "AlignedPair",
                             "An element of map A and one of map B that were taken for the same.")
      .fields_init()
      .field("name_in_a", &track::AlignedPair::name_in_a, "")
      .field("name_in_b", &track::AlignedPair::name_in_b, "")
      .field("used", &track::AlignedPair::used, "false: rejected, because the others contradict it")
      .field("distance", &track::AlignedPair::distance,
             "metres, between the poses or from B's origin of the plane to the plane of A")
      .field("angle", &track::AlignedPair::angle, "radians, between the poses or the normals")
      .field("chi2", &track::AlignedPair::chi2, "about 3 for a plane and 6 for a pose");
  Record<track::AlignMapsResult>(m, "AlignMapsResult", "The pose between two maps, with covariance.")
      .fields_init()
      .field("map_a_from_map_b", &track::AlignMapsResult::map_a_from_map_b, "")
      .field("pairs", &track::AlignMapsResult::pairs, "")
      .field("only_in_a", &track::AlignMapsResult::only_in_a, "")
      .field("only_in_b", &track::AlignMapsResult::only_in_b, "")
      .field("chi2", &track::AlignMapsResult::chi2, "of the used pairs")
      .field("degrees_of_freedom", &track::AlignMapsResult::degrees_of_freedom, "")
      .field("diagnostics", &track::AlignMapsResult::diagnostics, "");
  function(
      m, "elements_of", py::overload_cast<const SurfaceSet&, const track::PlacedSigma&>(&track::elements_of),
      "The planar surfaces that are placed in the world, each with its origin at the mean of\nits points; others are "
      "omitted.",
      py::arg("surfaces"), py::arg("sigma"));
  function(
      m, "elements_of", py::overload_cast<const MarkerMap&, const track::PlacedSigma&>(&track::elements_of),
      "The markers, by \"marker ID\", with the sigmas of the map, or with `otherwise` where\nthe map states none.",
      py::arg("map"), py::arg("otherwise"));
  function(
      m, "align_maps", &track::align_maps,
      "Two maps of one place, joined through what both hold. Raises Error kNotEnoughData when\nno element is in both "
      "maps, kDegenerate when a direction is poorly constrained, when two\nalignments agree with equally many "
      "elements, or when pairs by name contradict each other\nwithout a majority.",
      py::arg("map_a"), py::arg("map_b"),
      py::arg_v("options", track::AlignMapsOptions{}, "AlignMapsOptions()"));
  function(m, "moved", py::overload_cast<SurfaceSet, const Pose&>(&track::moved),
           "Surfaces in the frame of map A, where they were placed in map B.", py::arg("surfaces"),
           py::arg("map_a_from_map_b"));
  function(m, "moved", py::overload_cast<MarkerMap, const PoseWithCovariance&>(&track::moved),
           "The markers in the frame of map A. Their sigmas grow by those of the alignment.", py::arg("map"),
           py::arg("map_a_from_map_b"));
}

void bind_stamped_pose(py::module_& m) {
  Record<track::StampedPose> stamped_pose(
      m, "StampedPose", "A pose message: frames, stamp and arrival in seconds, pose, covariance.");
  stamped_pose.fields_init()
      .field("stamp", &track::StampedPose::stamp,
             "sender's clock, seconds; None when the format or the sender has none")
      .field("arrival", &track::StampedPose::arrival, "local steady clock, seconds")
      .field("frame", &track::StampedPose::frame, "the parent: \"map\"")
      .field("child", &track::StampedPose::child, "what moves: \"base\"")
      .field("frame_from_child", &track::StampedPose::frame_from_child, "")
      .field("covariance", &track::StampedPose::covariance,
             "Of the left increment [rotation, translation] in `frame`: frame_from_child =\n"
             "se3_exp(xi) * mean.")
      .field("twist", &track::StampedPose::twist,
             "[rotation, translation] of the child in its own frame, rad/s and m/s: d/dt T = T\n"
             "hat(twist).")
      .field("angular_rate", &track::StampedPose::angular_rate, "a gyro's, in the child's own frame, rad/s")
      .field("sequence", &track::StampedPose::sequence, "counts the sender's messages by one, wraps at 2^32");
}

void bind_pose_log(py::module_& m) {
  Record<track::PoseLogWriter> pose_log_writer(
      m, "PoseLogWriter",
      "Appends as messages come; what was written survives a crash of the program up to the\n"
      "last flush().");
  pose_log_writer
      .init([](const std::filesystem::path& path) { return track::PoseLogWriter(path); },
            "Raises Error(kIo).", py::arg("path"))
      .method("write", &track::PoseLogWriter::write, "Appends one message to the log.", py::arg("message"))
      .method("flush", &track::PoseLogWriter::flush,
              "To the operating system. Raises Error(kIo) when the disk is full.");

  function(m, "read_pose_log", &track::read_pose_log,
           "The whole log, in its order; of a run (`project-live --record`) the poses. A last\n"
           "line that was cut is skipped. Raises Error(kIo), Error(kInput) with the line.",
           py::arg("path"));
}

void bind_track_options(py::module_& m) {
  Enum<track::Prediction>(m, "Prediction", "How poses are continued between and beyond messages.")
      .value("kAuto", track::Prediction::kAuto,
             "all of them, weighted by how well each predicts the messages")
      .value("kConstantTwist", track::Prediction::kConstantTwist, "arcs and straight lines")
      .value("kConstantAcceleration", track::Prediction::kConstantAcceleration, "speeding up and braking")
      .value("kNone", track::Prediction::kNone,
             "the newest pose as it came: for comparison, and for what is already predicted");

  Record<track::TrackOptions> track_options(m, "TrackOptions",
                                            "How PoseTrack() predicts, and when poses are stale.");
  track_options.fields_init()
      .field("frame", &track::TrackOptions::frame,
             "Which messages are meant; empty takes the names of the first message.")
      .field("child", &track::TrackOptions::child,
             "Which messages are meant; empty takes the names of the first message.")
      .field("prediction", &track::TrackOptions::prediction, "")
      .field("clock", &track::TrackOptions::clock, "")
      .field("delay", &track::TrackOptions::delay,
             "From the moment that a message speaks of to its arrival at the fastest (sensor,\n"
             "localiser, network), seconds: what no clock can tell (clock.hpp). With\n"
             "ClockOptions::known_offset: zero, if stamps are right. Messages without a stamp are\n"
             "taken to be this old.")
      .field("position_sigma", &track::TrackOptions::position_sigma,
             "Of a message that states no covariance, until the track has measured it, and where\n"
             "it cannot: one sigma, metres and radians.")
      .field("rotation_sigma", &track::TrackOptions::rotation_sigma,
             "Of a message that states no covariance, until the track has measured it, and where\n"
             "it cannot: one sigma, metres and radians.")
      .field("speed_sigma", &track::TrackOptions::speed_sigma,
             "Of a stated twist and a gyro's rate (its bias included), m/s and rad/s.")
      .field("turn_sigma", &track::TrackOptions::turn_sigma,
             "Of a stated twist and a gyro's rate (its bias included), m/s and rad/s.")
      .field("acceleration", &track::TrackOptions::acceleration,
             "What the robot can do, one sigma: m/s^2, rad/s^2. Larger follows quicker and smooths\n"
             "less.")
      .field("turn_acceleration", &track::TrackOptions::turn_acceleration,
             "What the robot can do, one sigma: m/s^2, rad/s^2. Larger follows quicker and smooths\n"
             "less.")
      .field("max_speed", &track::TrackOptions::max_speed,
             "No pose moves faster; what seems to, jumps. m/s, rad/s.")
      .field("max_turn", &track::TrackOptions::max_turn,
             "No pose moves faster; what seems to, jumps. m/s, rad/s.")
      .field("stale_after", &track::TrackOptions::stale_after,
             "seconds without news, after which the state is kStale and the pose frozen")
      .field("confirm", &track::TrackOptions::confirm,
             "messages in a row that agree on another place, before it is believed")
      .field("blend", &track::TrackOptions::blend, "seconds in which the picture moves there");

  function(m, "parse_prediction", &track::parse_prediction,
           "\"auto\", \"twist\", \"acceleration\", \"none\". Raises Error(kInput).", py::arg("text"));
  function(m, "to_string", py::overload_cast<track::Prediction>(&track::to_string),
           "As in options: \"auto\".", py::arg("prediction"));
}

void bind_tracked_pose(py::module_& m) {
  Enum<track::TrackState>(m, "TrackState", "Nothing received, fresh, or stale.")
      .value("kNone", track::TrackState::kNone, "no message yet")
      .value("kFresh", track::TrackState::kFresh)
      .value("kStale", track::TrackState::kStale,
             "the newest pose is older than stale_after at the time asked for");

  Record<track::TrackedPose> tracked_pose(m, "TrackedPose",
                                          "The pose for one moment, with its state and age.");
  tracked_pose.fields_init()
      .field("state", &track::TrackedPose::state, "")
      .field("frame_from_child", &track::TrackedPose::frame_from_child, "")
      .field("covariance", &track::TrackedPose::covariance,
             "Of the left increment [rotation, translation] in `frame`; grows with age. Not told\n"
             "by it: what is left of a blend.")
      .field("twist", &track::TrackedPose::twist, "at the time asked for, in the child's own frame")
      .field("age", &track::TrackedPose::age,
             "time asked for less that of the newest pose, seconds; negative in the past")
      .field("blend_left", &track::TrackedPose::blend_left,
             "1 right after the map jumped, 0 when the pose is where the messages say");

  Record<track::Faults> faults(
      m, "Faults",
      "Every message that add() got is counted in exactly one of `taken` .. `pending`; a\n"
      "refused message leaves no trace in the pose. The last five are events.");
  faults.fields_init()
      .field("taken", &track::Faults::taken, "in order and believed")
      .field("reordered", &track::Faults::reordered,
             "overtaken by a newer one, put in its place and believed")
      .field("late", &track::Faults::late, "older than all that is kept: refused")
      .field("duplicated", &track::Faults::duplicated, "the same sequence number or stamp again: refused")
      .field("outliers", &track::Faults::outliers, "a place the child cannot be at, not confirmed: refused")
      .field("doubtful", &track::Faults::doubtful, "a stamp that contradicts the clock: refused (clock.hpp)")
      .field("invalid", &track::Faults::invalid, "not finite, no rotation: refused")
      .field("foreign", &track::Faults::foreign, "of other frames: refused")
      .field("pending", &track::Faults::pending,
             "of another place, not decided yet; moves to `outliers` or `taken`")
      .field("map_jumps", &track::Faults::map_jumps, "other places that were confirmed")
      .field("clock_jumps", &track::Faults::clock_jumps, "times the sender's clock was set")
      .field("stale", &track::Faults::stale, "gaps longer than stale_after, when they ended")
      .field("lost", &track::Faults::lost, "sequence numbers that never came")
      .field("twists_ignored", &track::Faults::twists_ignored,
             "messages taken without their twist: over a second it contradicts their poses");

  function(m, "to_string", py::overload_cast<track::TrackState>(&track::to_string), "As in logs: \"fresh\".",
           py::arg("state"));
}

void bind_pose_track(py::module_& m) {
  Record<track::PoseTrack> pose_track(m, "PoseTrack", "Pose messages in, the pose for any moment out.");
  pose_track
      .init([](const track::TrackOptions& options) { return track::PoseTrack(options); },
            "Raises ValueError for options that are not positive where they must be.",
            py::arg_v("options", track::TrackOptions{}, "TrackOptions()"))
      .method("add", &track::PoseTrack::add, "Takes a message, whatever is in it.", py::arg("message"))
      .method("at", &track::PoseTrack::at,
              "frame_from_child at a local time: between kept poses interpolated (a cubic through\n"
              "both with their twists), after the newest predicted, no further than stale_after;\n"
              "before the oldest kept, the oldest.",
              py::arg("time"))
      .method("faults", &track::PoseTrack::faults, "Numbers of messages that were rejected, by reason.")
      .method("clock", &track::PoseTrack::clock, "The sender's clock against the local one; seconds.")
      .method("frame", &track::PoseTrack::frame,
              "The names this track follows; empty before the first message when the options give\n"
              "none.")
      .method("child", &track::PoseTrack::child, "Name of the frame that moves.")
      .method("noise", &track::PoseTrack::noise,
              "What the messages scatter by, measured from their third differences, or as stated\n"
              "where that is not known yet: sigmas of [rotation, translation] in the child's frame.")
      .method("newest_time", &track::PoseTrack::newest_time, "Local time of the newest pose, seconds.");
}

void bind_pose_correction(py::module_& m) {
  Record<track::PoseCorrectionOptions>(m, "PoseCorrectionOptions",
                                       "How quickly PoseCorrection() follows, and what it rejects.")
      .fields_init()
      .field("track", &track::PoseCorrectionOptions::track,
             "of the localiser's messages; `delay` also of those that are returned")
      .field("child_from_rig", &track::PoseCorrectionOptions::child_from_rig,
             "the rig's place on what the poses tell of")
      .field("position_sigma", &track::PoseCorrectionOptions::position_sigma,
             "Standard deviation of the localiser's error along the floor (x, y of the world), metres.")
      .field("rotation_sigma", &track::PoseCorrectionOptions::rotation_sigma,
             "Standard deviation of the localiser's error about the world's z axis, radians.")
      .field("height_sigma", &track::PoseCorrectionOptions::height_sigma, "in z, metres")
      .field("tilt_sigma", &track::PoseCorrectionOptions::tilt_sigma, "about x and y, radians")
      .field("correlation", &track::PoseCorrectionOptions::correlation,
             "correlation time of the error, seconds")
      .field("max_chi2", &track::PoseCorrectionOptions::max_chi2,
             "of an image, 6 degrees of freedom at most: 1 in 25 000 by chance")
      .field("believe_after", &track::PoseCorrectionOptions::believe_after, "refused images")
      .field("alone_after", &track::PoseCorrectionOptions::alone_after,
             "seconds without an image, after which the localiser's messages are handed on");
  Record<track::PoseSight>(
      m, "PoseSight",
      "One image's evidence: for rig_from_world = exp(x) * world_from_rig^-1, information A and\n"
      "score A x.")
      .fields_init()
      .field("time", &track::PoseSight::time, "of exposure, local clock")
      .field("world_from_rig", &track::PoseSight::world_from_rig,
             "the place that the image was compared with")
      .field("information", &track::PoseSight::information,
             "of the increment: rotation (radians), translation (metres)")
      .field("score", &track::PoseSight::score, "information times increment");
  Record<track::PoseCorrectionStatus>(m, "PoseCorrectionStatus",
                                      "The localiser's error as it is estimated now.")
      .fields_init()
      .field("error", &track::PoseCorrectionStatus::error,
             "at the last image: [rotation, translation], axes of the world")
      .field("sigma", &track::PoseCorrectionStatus::sigma, "its standard deviations")
      .field("time", &track::PoseCorrectionStatus::time, "of that image; 0: none yet")
      .field("chi2", &track::PoseCorrectionStatus::chi2, "of the last image")
      .field("taken", &track::PoseCorrectionStatus::taken, "")
      .field("refused", &track::PoseCorrectionStatus::refused, "");
  Record<track::PoseCorrection>(
      m, "PoseCorrection",
      "Poses of a localiser, corrected by what a camera of the rig sees on known surfaces.")
      .init([](const track::PoseCorrectionOptions& options) { return track::PoseCorrection(options); },
            "Raises ValueError for sigmas and times that are not positive.",
            py::arg_v("options", track::PoseCorrectionOptions{}, "PoseCorrectionOptions()"))
      .method("add", py::overload_cast<const track::StampedPose&>(&track::PoseCorrection::add),
              "A localiser's message. Gives the corrected pose of its moment; while images come, its\n"
              "twist alone, if it states one.",
              py::arg("message"))
      .method("add", py::overload_cast<const track::PoseSight&>(&track::PoseCorrection::add),
              "An image's evidence. Gives the corrected pose at its exposure; None: refused, or no\n"
              "message has come yet.",
              py::arg("sight"))
      .method("add", py::overload_cast<const std::vector<track::PoseSight>&>(&track::PoseCorrection::add),
              "All of an image, or of several, oldest first: one pose, of the last exposure.",
              py::arg("sights"))
      .method("status", &track::PoseCorrection::status, "The estimate after the last image.");
}

void bind_trajectory(py::module_& m) {
  Record<track::Trajectory> trajectory(m, "Trajectory", "Poses of another program's trajectory file.");
  trajectory.fields_init()
      .field("format", &track::Trajectory::format, "\"TUM\", \"EuRoC\", \"KITTI\", \"rosbag\"")
      .field("poses", &track::Trajectory::poses,
             "Stamps increase; arrival is the stamp. Frames are \"map\" and \"base\" where the file\n"
             "names none.");

  function(m, "read_trajectory", &track::read_trajectory,
           "`file`: a path, or of KITTI \"poses+times\". Raises Error(kIo), Error(kInput) with the\n"
           "line, Error(kNotEnoughData) for a file without poses.",
           py::arg("file"));
  function(m, "read_waypoints", &track::read_waypoints,
           "Waypoints in a plane: lines of \"time x y yaw_deg\" between blanks or commas, seconds\n"
           "and metres; '#' begins a comment. Errors as above.",
           py::arg("file"));
}

}  // namespace

void bind_track(py::module_& m) {
  bind_clock(m);
  bind_locate(m);
  bind_align_maps(m);
  bind_stamped_pose(m);
  bind_pose_log(m);
  bind_track_options(m);
  bind_tracked_pose(m);
  bind_pose_track(m);
  bind_pose_correction(m);
  bind_trajectory(m);
  bind_track_wire(m);
}

}  // namespace procam::python
