// procam.track: poses that arrive and leave
#include "bind.hpp"
#include "components.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/track.hpp"

namespace procam::python {

namespace {

void bind_wire(py::module_& m) {
  Record<track::Parsed> parsed(m, "Parsed",
                               "What a piece of bytes held. Arrivals are zero: the source sets them.");
  parsed.fields_init()
      .field("poses", &track::Parsed::poses, "")
      .field("malformed", &track::Parsed::malformed, "")
      .field("why", &track::Parsed::why, "of the last malformed one");

  function(m, "parse_poses", &track::parse_poses,
           "JSON lines and binary messages, in any mixture: one datagram.", py::arg("datagram"));
  function(m, "to_json_line", &track::to_json_line,
           "What the parsers read back. JSON ends in a newline. OSC: without twist or\n"
           "covariance.",
           py::arg("message"));
  function(
      m, Gil::kHeld, "to_binary",
      [](const track::StampedPose& message) { return py::bytes(track::to_binary(message)); },
      "The message in procam's binary format.", py::arg("message"));
  function(
      m, Gil::kHeld, "to_osc",
      [](const track::StampedPose& message) { return py::bytes(track::to_osc(message)); },
      "The message as an OSC packet.", py::arg("message"));
  function(
      m, Gil::kHeld, "to_psn",
      [](const track::StampedPose& message) { return py::bytes(track::to_psn(message)); },
      "Several trackers make one packet; IDs are taken from children named \"tracker ID\",\n"
      "else 0.",
      py::arg("message"));
  m.attr("kFarthest") = track::kFarthest;
}

void bind_pose_sources(py::module_& m) {
  Record<track::SourceOptions> source_options(m, "SourceOptions",
                                              "How a source of poses listens: sizes, times, frames.");
  source_options.fields_init().field(
      "queue", &track::SourceOptions::queue,
      "messages held between two polls; beyond, the oldest are dropped and counted");

  Record<track::SourceStatus> source_status(m, "SourceStatus", "What a source has seen since it was opened.");
  source_status.fields_init()
      .field("connected", &track::SourceStatus::connected,
             "A datagram socket is bound, a stream has a peer, a log has messages left.")
      .field("messages", &track::SourceStatus::messages, "well-formed poses")
      .field("malformed", &track::SourceStatus::malformed,
             "messages, or stretches of a stream, that are none")
      .field("dropped", &track::SourceStatus::dropped, "well-formed poses that nobody fetched in time")
      .field("bytes", &track::SourceStatus::bytes, "received")
      .field("connections", &track::SourceStatus::connections, "made or accepted")
      .field("last_error", &track::SourceStatus::last_error,
             "of the last malformed message or failed connection; empty when none");

  Record<track::PoseSource> pose_source(m, "PoseSource", "Poses as they come in.");
  pose_source
      .method(
          "poll",
          [](track::PoseSource& self) {
            std::vector<track::StampedPose> arrived;
            self.poll(arrived);
            return arrived;
          },
          "What came since the last call, in order of arrival. Never waits.")
      .method(
          "wait",
          [](track::PoseSource& self, double seconds) {
            const py::gil_scoped_release released;
            self.wait(seconds);
          },
          "For programs that answer a pose at once: returns when poll() has a message, at the\n"
          "latest after `seconds` (an hour at most), and may return earlier. Sources that do not\n"
          "know when a message comes (recorded ones) return after 1 ms.",
          py::arg("seconds"))
      .method("status", &track::PoseSource::status, "Is it connected, and what did it receive?")
      .method("rejected", &track::PoseSource::rejected,
              "SourceStatus.malformed by cause, where the source names them.")
      .method("description", &track::PoseSource::description,
              "What was opened, where the text does not tell.");

  Record<track::PoseQueue, track::PoseSource> pose_queue(
      m, "PoseQueue", "For whoever has poses in the program: pushes them, from any thread.");
  pose_queue
      .init([](const track::SourceOptions& options) { return std::make_unique<track::PoseQueue>(options); },
            "", py::arg_v("options", track::SourceOptions{}, "SourceOptions()"))
      .method("push", &track::PoseQueue::push,
              "A pose that is not finite or whose quaternion is no rotation is counted as\n"
              "malformed. Returns whether it was taken.",
              py::arg("message"));

  function(m, "open_pose_source", &dds::open_pose_source,
           "Opens a source by its text. Raises Error(kInput) for a text that names none or a log\n"
           "that is none, Error(kDevice) for a port that cannot be bound. A peer that is not\n"
           "there yet is no error: the source tries again after 0.1 s, 0.2 s, ... 3 s.",
           py::arg("text"), py::arg_v("options", track::SourceOptions{}, "SourceOptions()"));
}

void bind_head_angles(py::module_& m) {
  Record<track::StampedAngles> stamped_angles(m, "StampedAngles", "Angles of a pan-tilt head.");
  Record<track::ParsedAngles> parsed_angles(
      m, "ParsedAngles", "The angles of a pan-tilt head in one message, or why there are none.");
  Record<track::PlacedHead> placed_head(m, "PlacedHead", "A head that stands in the world.");
  stamped_angles.fields_init()
      .field("stamp", &track::StampedAngles::stamp, "head's clock, seconds")
      .field("arrival", &track::StampedAngles::arrival, "local steady clock, seconds")
      .field("pan", &track::StampedAngles::pan, "radians")
      .field("tilt", &track::StampedAngles::tilt, "radians")
      .field("sequence", &track::StampedAngles::sequence, "");
  parsed_angles.fields_init()
      .field("angles", &track::ParsedAngles::angles, "")
      .field("malformed", &track::ParsedAngles::malformed, "")
      .field("why", &track::ParsedAngles::why, "of the last malformed one");
  placed_head.fields_init()
      .field("axes", &track::PlacedHead::axes, "")
      .field("world_from_head", &track::PlacedHead::world_from_head, "")
      .field("frame", &track::PlacedHead::frame, "of the poses")
      .field("child", &track::PlacedHead::child, "of the poses");
  function(m, "parse_angles", &track::parse_angles,
           "JSON lines with pan_deg and tilt_deg; what is none is counted with its reason.",
           py::arg("lines"));
  function(m, "angles_to_json_line", &track::angles_to_json_line, "What parse_angles() reads.",
           py::arg("angles"));
  function(m, "read_angle_log", &track::read_angle_log, "Raises Error(kIo), Error(kInput) with the line.",
           py::arg("path"));
  function(m, "write_angle_log", &track::write_angle_log, "Raises Error(kIo).", py::arg("path"),
           py::arg("angles"));
  function(m, "pose_of", &track::pose_of, "The tilting part's pose by the angles.", py::arg("angles"),
           py::arg("head"));
  function(m, "open_head_source", &track::open_head_source,
           "Poses of the tilting part by the angles that arrive: udp:PORT, tcp:HOST:PORT,\n"
           "tcp-listen:PORT or log:FILE. Errors as of open_pose_source().",
           py::arg("text"), py::arg("head"), py::arg_v("options", track::SourceOptions{}, "SourceOptions()"));
}

void bind_pose_sender(py::module_& m) {
  Record<track::PoseSender> pose_sender(m, "PoseSender", "Sends poses.");
  pose_sender
      .method(
          "send", [](track::PoseSender& self, const py::bytes& bytes) { self.send(std::string(bytes)); },
          "Sends bytes as they are. Raises Error of kind kDevice.", py::arg("bytes"))
      .method(
          "encoded",
          [](const track::PoseSender& self, const track::StampedPose& message) {
            return py::bytes(self.encoded(message));
          },
          "The message's bytes in the format of this sender.", py::arg("message"))
      .method("has_receiver", &track::PoseSender::has_receiver, "Is somebody connected?");

  function(m, "open_pose_sender", &track::open_pose_sender,
           "\"udp:HOST:PORT\", \"osc:HOST:PORT\", \"psn:[GROUP:]PORT\", \"tcp:HOST:PORT\" (connects,\n"
           "again when it ends), \"tcp-listen:PORT\" (everybody who connects gets all). `binary`:\n"
           "udp and tcp send the binary form. Raises Error(kInput), Error(kDevice).",
           py::arg("text"), py::arg("binary"));
}

}  // namespace

void bind_track_wire(py::module_& m) {
  bind_wire(m);
  bind_pose_sources(m);
  bind_head_angles(m);
  bind_pose_sender(m);
}

}  // namespace procam::python
