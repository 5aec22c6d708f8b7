// procam.people: skeletons over time, what content asks of them, and light kept off people
#include "procam/people/people.hpp"

#include "bind.hpp"
#include "components.hpp"
#include "procam/people/eye_safe.hpp"
#include "procam/people/interaction.hpp"
#include "procam/people/silhouette.hpp"
#include "procam/people/skeleton_reader.hpp"
#include "procam/people/skeleton_source.hpp"

namespace procam::python {
namespace {

using people::Joint;

void bind_joints(py::module_& m) {
  Enum<Joint> joint(m, "Joint", "Left is the person's own left.");
  const std::array<const char*, people::kJointCount> names = {
      "kHead",        "kNose",         "kLeftEye",   "kRightEye",   "kLeftEar",      "kRightEar",
      "kNeck",        "kChest",        "kNavel",     "kPelvis",     "kLeftShoulder", "kRightShoulder",
      "kLeftElbow",   "kRightElbow",   "kLeftWrist", "kRightWrist", "kLeftHand",     "kRightHand",
      "kLeftHandTip", "kRightHandTip", "kLeftThumb", "kRightThumb", "kLeftHip",      "kRightHip",
      "kLeftKnee",    "kRightKnee",    "kLeftAnkle", "kRightAnkle", "kLeftFoot",     "kRightFoot"};
  for (std::size_t i = 0; i < names.size(); ++i) joint.value(names[i], Joint(i));
  Enum<people::Side>(m, "Side", "Left or right.")
      .value("kLeft", people::Side::kLeft)
      .value("kRight", people::Side::kRight);
  function(m, "to_string", py::overload_cast<Joint>(&people::to_string), "As in files: \"left_wrist\".",
           py::arg("joint"));
  function(m, "joint_of", &people::joint_of, "None for another name.", py::arg("name"));
  function(
      m, "of_side", [](Joint left, people::Side side) { return people::of_side(left, side); },
      "The joint of that side; `left` is one of the left joints.", py::arg("left"), py::arg("side"));
}

template <typename Point>
void bind_skeleton_of(py::module_& m, const char* joint, const char* skeleton, const char* doc) {
  using Seen = people::SeenJoint<Point>;
  using Skeleton = people::SkeletonT<Point>;
  Record<Seen>(m, joint, "One joint of a person, and how sure it is.")
      .fields_init()
      .field("position", &Seen::position, doc)
      .field("confidence", &Seen::confidence, "0..1, as the tracker states; 1 when it states none");
  Record<Skeleton>(m, skeleton, "Joints as skeleton[Joint]: None where one was not seen.")
      .fields_init()
      .field("id", &Skeleton::id, "the sender's number for the person")
      .method(
          "__getitem__", [](const Skeleton& self, Joint wanted) { return self[wanted]; },
          "The joint, or None.", py::arg("joint"))
      .method(
          "__setitem__",
          [](Skeleton& self, Joint wanted, const std::optional<Seen>& seen) { self[wanted] = seen; }, "",
          py::arg("joint"), py::arg("seen"))
      .method("position", &Skeleton::position,
              "Position (3,) of a joint, metres in the sensor's frame, or None.", py::arg("joint"))
      .method(
          "first_of",
          [](const Skeleton& self, const std::vector<Joint>& wanted) {
            for (const Joint one : wanted)
              if (const auto seen = self.position(one)) return seen;
            return std::optional<Point>();
          },
          "The position of the first that was seen.", py::arg("joints"));
}

void bind_skeletons(py::module_& m) {
  bind_skeleton_of<Vec3>(m, "SeenJoint", "Skeleton", "metres, sensor's optical frame");
  bind_skeleton_of<Vec2>(m, "SeenPixelJoint", "PixelSkeleton", "pixels");
  Record<people::SkeletonFrame>(m, "SkeletonFrame", "Everybody that the sensor saw at one moment.")
      .fields_init()
      .field("stamp", &people::SkeletonFrame::stamp, "sender's clock, seconds")
      .field("arrival", &people::SkeletonFrame::arrival, "local steady clock, seconds")
      .field("frame", &people::SkeletonFrame::frame, "the sensor's; may be empty")
      .field("people", &people::SkeletonFrame::people, "");
  m.attr("kJointCount") = people::kJointCount;
  m.attr("kFarthestJoint") = people::kFarthestJoint;
  function(
      m, "why_refused",
      [](const people::SkeletonFrame& frame) {
        const char* const why = people::why_refused(frame);
        return why != nullptr ? std::optional<std::string>(why) : std::nullopt;
      },
      "None for a valid frame; else why it is refused.", py::arg("frame"));
  function(m, "hand_of", &people::hand_of, "Palm, else wrist, else the tip of the fingers.",
           py::arg("person"), py::arg("side"));
  function(m, "head_of", &people::head_of,
           "Position (3,) of the head, metres in the sensor's frame, or None.", py::arg("person"));
  function(m, "body_of", &people::body_of, "Where the person stands.", py::arg("person"));
}

void bind_readers(py::module_& m) {
  Record<people::ParsedSkeletons>(m, "ParsedSkeletons", "People of one message, or why there are none.")
      .fields_init()
      .field("frames", &people::ParsedSkeletons::frames, "")
      .field("malformed", &people::ParsedSkeletons::malformed, "")
      .field("why", &people::ParsedSkeletons::why, "of the last malformed one");
  Record<people::PixelPeople>(m, "PixelPeople", "People of one image, in pixels.")
      .fields_init()
      .field("people", &people::PixelPeople::people, "")
      .field("why", &people::PixelPeople::why, "empty unless the text was refused");
  Record<people::HipCentredPerson>(m, "HipCentredPerson", "A person whose joints count from the hip; metres.")
      .fields_init()
      .field("about_hips", &people::HipCentredPerson::about_hips, "metres about the middle of the hips")
      .field("hips_in_picture", &people::HipCentredPerson::hips_in_picture, "fractions of the picture");
  Record<people::HipCentredPeople>(m, "HipCentredPeople", "People whose joints count from the hip; metres.")
      .fields_init()
      .field("people", &people::HipCentredPeople::people, "")
      .field("why", &people::HipCentredPeople::why, "empty unless the text was refused");
  Enum<people::JointSet>(m, "JointSet", "Whose numbers of joints a message uses.")
      .value("kAzureKinect", people::JointSet::kAzureKinect, "32 joints, millimetres")
      .value("kKinectV2", people::JointSet::kKinectV2, "25 joints, metres, x to the sensor's left, y up");
  Record<people::ForeignJoint>(m, "ForeignJoint", "One joint by its number in another program's set.")
      .fields_init()
      .field("position", &people::ForeignJoint::position, "in the units and axes of the set")
      .field("confidence", &people::ForeignJoint::confidence, "the set's own level");
  function(m, "parse_skeletons", &people::parse_skeletons, "JSON lines, one frame a line (docs/people.md).",
           py::arg("lines"));
  function(m, "to_json_line", &people::to_json_line, "A line that parse_skeletons() reads.",
           py::arg("frame"));
  function(m, "read_skeleton_log", &people::read_skeleton_log,
           "A file of JSON lines or CSV. Error for a file without a single frame.", py::arg("file"));
  function(m, "parse_openpose", &people::parse_openpose, "OpenPose's JSON of one picture (BODY_25).",
           py::arg("text"));
  function(
      m, Gil::kHeld, "lifted",
      [](const people::PixelSkeleton& seen, const Camera& camera,
         const std::function<std::optional<double>(const Vec2&)>& depth_at) {
        return people::lifted(seen, camera, depth_at);
      },
      "Pixels to metres where depth_at(pixel), metres along the optical axis, is not None.", py::arg("seen"),
      py::arg("camera"), py::arg("depth_at"));
  function(m, "parse_mediapipe", &people::parse_mediapipe, "MediaPipe's pose landmarks.", py::arg("text"));
  function(m, "anchored", &people::anchored, "The hips are where a depth camera sees them.",
           py::arg("about_hips"), py::arg("hips_in_sensor"));
  function(m, "anchored_on_floor", &people::anchored_on_floor,
           "The hips lie along `bearing`, so far that the lowest ankle or foot is on the floor.",
           py::arg("about_hips"), py::arg("bearing"), py::arg("floor_in_sensor"));
  function(m, "from_joint_set", &people::from_joint_set, "ValueError for a list of another length.",
           py::arg("set"), py::arg("joints"));
  function(m, "parse_azure_kinect", &people::parse_azure_kinect, "Azure Kinect's recorded JSON.",
           py::arg("text"));
  Record<people::SkeletonSource, std::unique_ptr<people::SkeletonSource>>(m, "SkeletonSource",
                                                                          "Skeletons as they come in.")
      .method(
          "poll",
          [](people::SkeletonSource& self) {
            std::vector<people::SkeletonFrame> arrived;
            self.poll(arrived);
            return arrived;
          },
          "Frames since the last call, in order of arrival. Never waits.")
      .method(
          "wait",
          [](people::SkeletonSource& self, double seconds) {
            const py::gil_scoped_release released;
            self.wait(seconds);
          },
          "As PoseSource.wait().", py::arg("seconds"))
      .method("status", &people::SkeletonSource::status, "Is it connected, and what did it receive?");
  function(
      m, "open_skeleton_source", &people::open_skeleton_source,
      "udp:9100, tcp:HOST:PORT, tcp-listen:PORT, vmc:39539, log:FILE[@SPEED]. Error for a text that names\n"
      "no source, a log that is none, a port that cannot be bound.",
      py::arg("text"), py::arg_v("options", track::SourceOptions{}, "SourceOptions()"));
}

void bind_track_of_people(py::module_& m) {
  Record<people::PeopleOptions>(m, "PeopleOptions", "How people are followed and predicted.")
      .fields_init()
      .field("noise", &people::PeopleOptions::noise, "of a joint along each axis, metres")
      .field("acceleration_sigma", &people::PeopleOptions::acceleration_sigma, "m/s^2")
      .field("acceleration_tau", &people::PeopleOptions::acceleration_tau, "seconds")
      .field("max_speed", &people::PeopleOptions::max_speed, "m/s")
      .field("confirm", &people::PeopleOptions::confirm, "jumps in a row that agree are believed")
      .field("longest_step", &people::PeopleOptions::longest_step, "seconds that a joint is predicted for")
      .field("forget_joint", &people::PeopleOptions::forget_joint, "seconds")
      .field("forget_person", &people::PeopleOptions::forget_person, "seconds")
      .field("gate", &people::PeopleOptions::gate, "metres that a person may be from the prediction")
      .field("clock", &people::PeopleOptions::clock, "")
      .field("delay", &people::PeopleOptions::delay, "seconds from a frame's moment to its fastest arrival");
  Record<people::TrackedPerson>(m, "TrackedPerson", "A person at one moment: number, skeleton, velocities.")
      .fields_init()
      .field("number", &people::TrackedPerson::number, "never given again")
      .field("skeleton", &people::TrackedPerson::skeleton, "at the requested time")
      .field("sigma", &people::TrackedPerson::sigma, "of each joint that is there, metres an axis")
      .field("age", &people::TrackedPerson::age, "seconds since it was seen")
      .field("sightings", &people::TrackedPerson::sightings, "frames that saw it");
  Record<people::PeopleFaults>(m, "PeopleFaults", "Numbers of messages that were rejected, by reason.")
      .fields_init()
      .field("refused", &people::PeopleFaults::refused, "frames")
      .field("repeated", &people::PeopleFaults::repeated, "frames with a repeated stamp")
      .field("late", &people::PeopleFaults::late, "frames")
      .field("teleports", &people::PeopleFaults::teleports, "joints refused")
      .field("why", &people::PeopleFaults::why, "of the last refused frame");
  Record<people::PeopleTrack>(m, "PeopleTrack", "Who is where at any moment, from noisy and late skeletons.")
      .init([](const people::PeopleOptions& options) { return people::PeopleTrack(options); },
            "ValueError for options that are not positive.",
            py::arg_v("options", people::PeopleOptions{}, "PeopleOptions()"))
      .method("add", &people::PeopleTrack::add, "Was the frame taken?", py::arg("frame"))
      .method("at", &people::PeopleTrack::at, "Everybody at a moment of the local clock, by number.",
              py::arg("time"))
      .method("newest", &people::PeopleTrack::newest,
              "The moment of the newest frame; None before the first.")
      .method("faults", &people::PeopleTrack::faults, "Numbers of messages that were rejected, by reason.");
  Record<people::Players>(m, "Players", "Who plays on which side of a surface.")
      .fields_init()
      .field("left", &people::Players::left, "TrackedPerson.number")
      .field("right", &people::Players::right, "");
  Record<people::SeatOptions>(m, "SeatOptions", "When players take and lose their side.")
      .fields_init()
      .field("middle", &people::SeatOptions::middle, "x on the surface between the sides, metres")
      .field("cross", &people::SeatOptions::cross, "metres beyond the middle")
      .field("sightings", &people::SeatOptions::sightings, "a person seen less often takes no seat");
  function(m, "seat_players", &people::seat_players, "Who plays on which side of a surface.",
           py::arg("people"), py::arg("surface_from_sensor"), py::arg("before"),
           py::arg_v("options", people::SeatOptions{}, "SeatOptions()"));
  function(
      m, "find_person",
      [](const std::vector<people::TrackedPerson>& all, std::optional<int> number) {
        const people::TrackedPerson* const found = people::find_person(all, number);
        return found != nullptr ? std::optional<people::TrackedPerson>(*found) : std::nullopt;
      },
      "None when nobody has that number.", py::arg("people"), py::arg("number"));
}

void bind_interaction(py::module_& m) {
  Record<people::SurfacePoint>(m, "SurfacePoint", "A point on a surface, and its distance from it; metres.")
      .fields_init()
      .field("point", &people::SurfacePoint::point, "the foot of the perpendicular, metres on the surface")
      .field("distance", &people::SurfacePoint::distance, "in front of the surface, metres");
  function(m, "on_surface", &people::on_surface,
           "The point (3,), metres in the sensor's frame, on the surface and its distance\n"
           "from it.",
           py::arg("point_in_sensor"), py::arg("surface_from_sensor"));
  function(m, "pointing_ray", &people::pointing_ray, "From the head through the hand; None without both.",
           py::arg("person"), py::arg("side"));
  function(m, "hit_on_surface", &people::hit_on_surface, "None when the ray leads away from it.",
           py::arg("ray_in_sensor"), py::arg("surface_from_sensor"));
  Record<people::ZoneOptions>(m, "ZoneOptions", "When a zone is entered and left.")
      .fields_init()
      .field("margin", &people::ZoneOptions::margin, "metres: entered that far inside, left that far outside")
      .field("dwell", &people::ZoneOptions::dwell, "seconds inside until it counts as meant")
      .field("patience", &people::ZoneOptions::patience, "seconds without a point until it is left");
  Record<people::Zone> zone(m, "Zone", "Enter, dwell and leave, each reported once.");
  Enum<people::Zone::Event>(zone.type, "Event", "Nothing, entered, dwelled, left.")
      .value("kNone", people::Zone::Event::kNone)
      .value("kEntered", people::Zone::Event::kEntered)
      .value("kDwelled", people::Zone::Event::kDwelled)
      .value("kLeft", people::Zone::Event::kLeft);
  zone.init([](Points2 polygon,
               const people::ZoneOptions& options) { return people::Zone(std::move(polygon), options); },
            "", py::arg("polygon"), py::arg_v("options", people::ZoneOptions{}, "ZoneOptions()"))
      .method("update", &people::Zone::update, "Times do not go back; None: nothing was seen.",
              py::arg("point"), py::arg("time"))
      .method("is_inside", &people::Zone::is_inside, "Is somebody in the zone?")
      .method("progress", &people::Zone::progress, "share of the dwell, 0..1", py::arg("time"));
  Record<people::TouchOptions>(m, "TouchOptions", "When a hand touches a surface.")
      .fields_init()
      .field("near", &people::TouchOptions::near, "metres from the surface at which a touch begins")
      .field("far", &people::TouchOptions::far, "and at which it ends");
  Record<people::Touch>(m, "Touch", "Whether a hand touches, with hysteresis.")
      .init([](const people::TouchOptions& options) { return people::Touch(options); }, "",
            py::arg_v("options", people::TouchOptions{}, "TouchOptions()"))
      .method("update", &people::Touch::update, "None (not seen) ends a touch.", py::arg("hand"));
  function(m, "trespass", &people::trespass,
           "The first joint of anybody inside the polygon and nearer to the surface than `height`.",
           py::arg("people"), py::arg("surface_from_sensor"), py::arg("polygon"), py::arg("height"));
}

void bind_masks(py::module_& m) {
  Record<people::EyeSafeOptions>(m, "EyeSafeOptions",
                                 "How large the dark area about a head is, and when all is dark.")
      .fields_init()
      .field("radius", &people::EyeSafeOptions::radius, "of a head with its hair, metres")
      .field("margin", &people::EyeSafeOptions::margin, "metres")
      .field("speed", &people::EyeSafeOptions::speed, "m/s that a head moves unseen")
      .field("fresh", &people::EyeSafeOptions::fresh,
             "seconds without news of people after which the frame is dark")
      .field("dark_without_news", &people::EyeSafeOptions::dark_without_news, "");
  Record<people::MaskResult>(m, "MaskResult", "What was darkened.")
      .fields_init()
      .field("blanked", &people::MaskResult::blanked, "the whole frame")
      .field("masked", &people::MaskResult::masked, "heads; of silhouettes, blocks of readings")
      .constant("reason", &people::MaskResult::reason, "why the whole frame is dark");
  function(m, "darken_heads",
           py::overload_cast<ImageView<std::uint8_t>, const Projector&, const Pose&,
                             const std::vector<people::TrackedPerson>&, const std::optional<double>&, double,
                             const people::EyeSafeOptions&>(&people::darken_heads),
           "Blackens the heads in a frame of the projector's size. A courtesy to eyes, not a safety device.",
           py::arg("frame"), py::arg("projector"), py::arg("projector_from_sensor"), py::arg("people"),
           py::arg("newest"), py::arg("light_time"),
           py::arg_v("options", people::EyeSafeOptions{}, "EyeSafeOptions()"));
  function(
      m, "darken_heads",
      py::overload_cast<ImageView<std::uint8_t>, const Projector&, const Pose&, const people::PeopleTrack&,
                        double, const people::EyeSafeOptions&>(&people::darken_heads),
      "The same, with the track.", py::arg("frame"), py::arg("projector"), py::arg("projector_from_sensor"),
      py::arg("track"), py::arg("light_time"),
      py::arg_v("options", people::EyeSafeOptions{}, "EyeSafeOptions()"));
  Record<people::SilhouetteOptions>(m, "SilhouetteOptions", "How people are cut out of a depth image.")
      .fields_init()
      .field("nearer", &people::SilhouetteOptions::nearer, "metres before the background")
      .field("margin", &people::SilhouetteOptions::margin, "metres around every reading")
      .field("speed", &people::SilhouetteOptions::speed, "m/s")
      .field("fresh", &people::SilhouetteOptions::fresh, "seconds after which depth is no news")
      .field("nearest", &people::SilhouetteOptions::nearest, "metres")
      .field("head", &people::SilhouetteOptions::head, "metres: half the breadth of the slimmest head");
  Record<people::Silhouettes> silhouettes(m, "Silhouettes",
                                          "What may be somebody, in the depth camera's frame.");
  Record<people::Silhouettes::Seen>(silhouettes.type, "Seen", "Somebody's surface is within `radius` of it.")
      .fields_init()
      .field("middle", &people::Silhouettes::Seen::middle, "metres")
      .field("radius", &people::Silhouettes::Seen::radius, "metres");
  Record<people::Silhouettes::Unseen>(silhouettes.type, "Unseen", "A block without readings.")
      .fields_init()
      .field("way", &people::Silhouettes::Unseen::way, "unit vector")
      .field("from_", &people::Silhouettes::Unseen::from, "metres along it")
      .field("to", &people::Silhouettes::Unseen::to, "metres along it")
      .field("radius_per_metre", &people::Silhouettes::Unseen::radius_per_metre,
             "radius a metre of distance, without unit");
  silhouettes.fields_init()
      .field("seen", &people::Silhouettes::seen, "")
      .field("unseen", &people::Silhouettes::unseen, "");
  function(
      m, "find_silhouettes",
      [](const Camera& camera, ViewF depth, ViewF background, const people::SilhouetteOptions& options) {
        return people::find_silhouettes({camera, depth, background}, options);
      },
      "Whatever has come before the empty room: depth images in metres, of the camera's size.",
      py::arg("camera"), py::arg("depth"), py::arg("background"),
      py::arg_v("options", people::SilhouetteOptions{}, "SilhouetteOptions()"));
  function(m, "darken_silhouettes", &people::darken_silhouettes,
           "`age`: seconds from the moment of the depth image to the light.", py::arg("frame"),
           py::arg("projector"), py::arg("projector_from_camera"), py::arg("silhouettes"), py::arg("age"),
           py::arg_v("options", people::SilhouetteOptions{}, "SilhouetteOptions()"));
}

}  // namespace

void bind_people(py::module_& m) {
  bind_joints(m);
  bind_skeletons(m);
  bind_readers(m);
  bind_track_of_people(m);
  bind_interaction(m);
  bind_masks(m);
}

}  // namespace procam::python
