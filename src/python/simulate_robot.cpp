// procam.simulate: localisers and robots
#include "procam/simulate.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_localiser(py::module_& m) {
  Record<simulate::Localiser> localiser(m, "Localiser", "How a localiser errs: rate, delay, noise, drift.");
  localiser.fields_init()
      .field("rate", &simulate::Localiser::rate, "messages a second")
      .field("delay", &simulate::Localiser::delay,
             "from the moment that a message speaks of to its arrival, seconds")
      .field("jitter", &simulate::Localiser::jitter,
             "sigma of the delay, seconds; no message arrives before its stamp")
      .field("position_sigma", &simulate::Localiser::position_sigma, "metres, each axis of the world")
      .field("rotation_sigma", &simulate::Localiser::rotation_sigma, "radians, about each axis of the rig")
      .field("dropped", &simulate::Localiser::dropped, "share of messages that never arrive")
      .field("seed", &simulate::Localiser::seed, "");

  Record<simulate::LocalisedPose> localised_pose(m, "LocalisedPose",
                                                 "One message of a localiser, with the true pose.");
  localised_pose.fields_init()
      .field("stamp", &simulate::LocalisedPose::stamp, "the moment it speaks of, seconds")
      .field("arrival", &simulate::LocalisedPose::arrival, "when it is known, seconds")
      .field("measured", &simulate::LocalisedPose::measured,
             "world_from_rig: (R exp(rotation noise), t + position noise)")
      .field("truth", &simulate::LocalisedPose::truth, "");

  function(m, "localise", &simulate::localise,
           "Messages stamped start, start + 1 / rate, ... up to the drive's end, in the order of\n"
           "arrival (jitter above the period lets them overtake each other). Equal seeds give\n"
           "equal messages, and dropping some changes nothing in the others. Raises\n"
           "ValueError for numbers out of range.",
           py::arg("drive"), py::arg("localiser"));
}

void bind_robot(py::module_& m) {
  Record<simulate::RobotOptions> robot_options(m, "RobotOptions",
                                               "How a robot's messages are sent, delayed, lost and damaged.");
  robot_options.fields_init()
      .field("localiser", &simulate::RobotOptions::localiser, "")
      .field("duration", &simulate::RobotOptions::duration, "messages of later moments are omitted, seconds")
      .field("frame", &simulate::RobotOptions::frame, "")
      .field("child", &simulate::RobotOptions::child, "")
      .field("with_covariance", &simulate::RobotOptions::with_covariance,
             "messages state the covariance of the noise")
      .field("with_twist", &simulate::RobotOptions::with_twist, "they state the true twist")
      .field("with_rate", &simulate::RobotOptions::with_rate, "they state the true angular rate")
      .field("jitter", &simulate::RobotOptions::jitter,
             "mean of an exponential delay in the network, seconds")
      .field("reordered", &simulate::RobotOptions::reordered, "share of messages that the next two overtake")
      .field("duplicated", &simulate::RobotOptions::duplicated, "share that arrives twice")
      .field("malformed", &simulate::RobotOptions::malformed, "malformed messages, as a share");

  Record<simulate::RobotEvent> robot_event(m, "RobotEvent", "What arrives at a time.");
  robot_event.fields_init()
      .field("time", &simulate::RobotEvent::time, "of arrival, seconds since the start")
      .field("moment", &simulate::RobotEvent::moment, "that the message speaks of, likewise")
      .field("malformed", &simulate::RobotEvent::malformed, "")
      .field("message", &simulate::RobotEvent::message,
             "without stamp and arrival: they are in the receiver's clocks");

  Record<simulate::RobotMessages> robot_messages(
      m, "RobotMessages", "A robot's messages in the order of their arrival, with the truth.");
  robot_messages.fields_init()
      .field("events", &simulate::RobotMessages::events, "in the order of arrival")
      .field("made", &simulate::RobotMessages::made, "")
      .field("messages", &simulate::RobotMessages::messages, "")
      .field("reordered", &simulate::RobotMessages::reordered, "")
      .field("duplicated", &simulate::RobotMessages::duplicated, "")
      .field("malformed", &simulate::RobotMessages::malformed, "")
      .field("lost", &simulate::RobotMessages::lost, "");

  function(m, "robot_messages", &simulate::robot_messages, "Raises ValueError as localise() does.",
           py::arg("drive"), py::arg("options"));
  function(m, "random_walk", &simulate::random_walk,
           "Arcs of 0.3 to 1.5 m from rest to rest in the x-y plane, at `speed` at most (m/s),\n"
           "for `duration` seconds at least.",
           py::arg("speed"), py::arg("duration"), py::arg("seed"));
  function(m, "drive_along", &simulate::drive_along,
           "Along recorded poses at their times, from one to the next along a screw: resting at\n"
           "each, or at constant twist. Raises Error(kNotEnoughData) for fewer than two.",
           py::arg("poses"), py::arg("rest_at_each"));
}

}  // namespace

void bind_simulate_robot(py::module_& m) {
  bind_localiser(m);
  bind_robot(m);
}

}  // namespace procam::python
