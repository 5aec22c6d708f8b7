// procam.simulate
#include "procam/simulate.hpp"

#include "bind.hpp"
#include "components.hpp"

#include "scene.hpp"

namespace procam::python {

void bind_simulate(py::module_& m) {
  Enum<simulate::Level>(m, "Level", "")
      .value("kEasy", simulate::Level::kEasy)
      .value("kPaper", simulate::Level::kPaper)
      .value("kHard", simulate::Level::kHard);
  Record<simulate::ThinLens> thin_lens(
      m, "ThinLens",
      "A lens of which one distance is in focus. A point at depth z along the axis becomes\n"
      "a disc of\n"
      "\n"
      "  diameter = aperture f |1/z - 1/focus|   pixels,   f = sqrt(fx fy)\n"
      "\n"
      "As f = image distance / pixel, this is exact for the thin lens. Discs of more than\n"
      "48 pixels are drawn with 48.");
  Record<simulate::PrintedBoard> printed_board(
      m, "PrintedBoard", "A board printed on a white sheet. The back of the sheet is white.");
  Record<simulate::World> world(m, "World", "");
  Record<simulate::ProjectorMap> projector_map(
      m, "ProjectorMap", "projector_pixel_seen_at() for the centres of all camera pixels.");
  Record<simulate::FrameFault> frame_fault(m, "FrameFault", "What one capture of a sequence suffers.");
  Record<simulate::CaptureOptions> capture_options(m, "CaptureOptions", "");
  Record<simulate::Range> range(m, "Range", "");
  Record<simulate::Conditions> conditions(m, "Conditions", "");
  Record<simulate::ViewDefects> view_defects(m, "ViewDefects", "What is wrong with one view.");
  Record<simulate::ViewDefects::Move> move(
      view_defects.type, "Move",
      "At `share` of the sequence, 0 .. 1, the board moves to rig_from_board *\n"
      "board_from_moved.");
  Record<simulate::SimulatedSession> simulated_session(m, "SimulatedSession", "");
  Record<simulate::BoardPrint> board_print(
      m, "BoardPrint", "A board and its drawing (detect::board_artwork; a chessboard needs none).");
  Record<simulate::Rectangle> rectangle(m, "Rectangle", "");
  Record<simulate::Polygon> polygon(m, "Polygon",
                                    "Any simple polygon, three corners at least, either sense.");
  Record<simulate::Arc> arc(m, "Arc", "A range of angles, radians, from < to <= from + 2 pi.");
  Record<simulate::Sphere> sphere(
      m, "Sphere", "A sphere, or the part of it within two ranges (a dome: latitude 0 .. pi/2).");
  Record<simulate::Cylinder> cylinder(
      m, "Cylinder", "A tube without lids, or a part of its turn (a column, a niche, a curved screen).");
  Record<simulate::Texture> texture(
      m, "Texture",
      "A picture, grey or red, green, blue, stretched over a body's u, v, its texels square\n"
      "tiles of one albedo: black + (white - black) * value / 255. The texel (0, 0) begins\n"
      "at u = v = 0. At most 2^24 texels.");
  Record<simulate::Cutout> cutout(
      m, "Cutout",
      "Holes and an outline: the body is there where the mask, one channel, linear between\n"
      "the middles of its texels, is one half or more.");
  Record<simulate::Body> body(m, "Body", "");
  Record<simulate::Room> room(m, "Room", "");
  Record<simulate::RoomViewOptions> room_view_options(m, "RoomViewOptions", "");
  Record<simulate::RoomTruth> room_truth(m, "RoomTruth", "What the centre of each pixel sees.");
  Record<simulate::RoomView> room_view(m, "RoomView", "");
  Record<simulate::DepthSensor> depth_sensor(m, "DepthSensor", "");
  Record<simulate::DepthView> depth_view(m, "DepthView", "");
  Record<simulate::Leg> leg(
      m, "Leg",
      "One leg: a screw motion by `increment` = [rotation, translation] in the rig's frame\n"
      "at its start.");
  Record<simulate::Drive> drive(m, "Drive", "");
  Record<simulate::Waypoint> waypoint(m, "Waypoint", "");
  Record<simulate::Localiser> localiser(m, "Localiser", "");
  Record<simulate::LocalisedPose> localised_pose(m, "LocalisedPose", "");
  Record<simulate::Fleet> fleet(m, "Fleet", "");
  Record<simulate::Fleet::View> view_(
      fleet.type, "View",
      "A board pose, and the devices (by number in the rig) that take part: the whole print\n"
      "lies before them.");
  Record<simulate::MarkerViewOptions> marker_view_options(m, "MarkerViewOptions", "");
  Record<simulate::HungMarkers> hung_markers(m, "HungMarkers", "Markers with their true places.");
  Record<simulate::PreviewOptions> preview_options(m, "PreviewOptions", "");
  Record<simulate::RobotOptions> robot_options(m, "RobotOptions", "");
  Record<simulate::RobotEvent> robot_event(m, "RobotEvent", "What arrives at a time.");
  Record<simulate::RobotMessages> robot_messages(m, "RobotMessages", "");
  Record<simulate::Motion> motion(
      m, "Motion", "target_from_source over time, seconds: one pose for ever, or a function of the time.");
  Record<simulate::TriangleMesh> triangle_mesh(m, "TriangleMesh", "Triangles, both sides of which are seen.");
  Record<simulate::RoomLight> room_light(m, "RoomLight", "A projector's light in the room.");

  thin_lens.fields_init()
      .field("aperture", &simulate::ThinLens::aperture,
             "diameter, metres: focal length / f-number; 0: all is in focus")
      .field("focus", &simulate::ThinLens::focus, "depth of the plane in focus, metres");
  printed_board.fields_init()
      .field("layout", &simulate::PrintedBoard::layout, "")
      .field("margin", &simulate::PrintedBoard::margin, "white paper round the print, metres")
      .field("white_albedo", &simulate::PrintedBoard::white_albedo, "0..1")
      .field("black_albedo", &simulate::PrintedBoard::black_albedo, "")
      .field("blank", &simulate::PrintedBoard::blank, "more white paper to the right and below, metres")
      .field("artwork", &simulate::PrintedBoard::artwork,
             "What is black (detect::board_artwork). A chessboard's squares need none.");
  world.fields_init()
      .field("rig", &simulate::World::rig, "one camera, one projector")
      .field("board", &simulate::World::board, "")
      .field("rig_from_board", &simulate::World::rig_from_board, "")
      .field("wall_in_rig", &simulate::World::wall_in_rig, "")
      .field("wall_albedo", &simulate::World::wall_albedo, "")
      .field("ambient", &simulate::World::ambient, "irradiance, in units of the projector's at one metre");
  projector_map.fields_init()
      .field("pixel", &simulate::ProjectorMap::pixel, "two channels, x and y; 0 where not lit")
      .field("lit", &simulate::ProjectorMap::lit, "1 where projector light arrives, else 0");
  frame_fault.fields_init()
      .field("gain", &simulate::FrameFault::gain, "on the exposure")
      .field("shift_px", &simulate::FrameFault::shift_px, "of the whole image")
      .field("blur_px", &simulate::FrameFault::blur_px, "sigma, beside camera_blur_px")
      .field("ripple", &simulate::FrameFault::ripple,
             "Brightness over the rows, 1 + amplitude sin(2 pi (row / rows + phase)): mains light\n"
             "and a rolling shutter.")
      .field("ripple_rows", &simulate::FrameFault::ripple_rows,
             "Brightness over the rows, 1 + amplitude sin(2 pi (row / rows + phase)): mains light\n"
             "and a rolling shutter.")
      .field("ripple_phase", &simulate::FrameFault::ripple_phase,
             "Brightness over the rows, 1 + amplitude sin(2 pi (row / rows + phase)): mains light\n"
             "and a rolling shutter.");
  capture_options.fields_init()
      .field("brightest_grey", &simulate::CaptureOptions::brightest_grey,
             "Grey level of the brightest corner of the sheet under full projector light: sets the\n"
             "exposure of the view.")
      .field("camera_blur_px", &simulate::CaptureOptions::camera_blur_px,
             "sigma of the camera's lens, camera pixels")
      .field("projector_blur_px", &simulate::CaptureOptions::projector_blur_px,
             "sigma of the projector's lens, projector pixels")
      .field("projector_lens", &simulate::CaptureOptions::projector_lens, "")
      .field("indirect", &simulate::CaptureOptions::indirect,
             "light that surfaces reflect onto each other, share")
      .field("glare", &simulate::CaptureOptions::glare,
             "light that the camera's lens scatters over its image, share")
      .field("vignetting", &simulate::CaptureOptions::vignetting,
             "power of the cosine of the field angle; 4: the natural law of a simple lens")
      .field("gamma", &simulate::CaptureOptions::gamma, "of the camera; 1: linear")
      .field("noise", &simulate::CaptureOptions::noise, "Gaussian; variance of the linear grey value")
      .field("faults", &simulate::CaptureOptions::faults, "one a frame; empty: none")
      .field("spot", &simulate::CaptureOptions::spot,
             "A lamp's reflection, a Gaussian: `spot` times full scale in its middle.")
      .field("spot_radius_px", &simulate::CaptureOptions::spot_radius_px,
             "A lamp's reflection, a Gaussian: `spot` times full scale in its middle.")
      .field("spot_at", &simulate::CaptureOptions::spot_at, "camera pixel")
      .field("crosstalk", &simulate::CaptureOptions::crosstalk,
             "share of a neighbouring colour's light, colour frames only")
      .field("seed", &simulate::CaptureOptions::seed, "of the noise")
      .field("samples_per_axis", &simulate::CaptureOptions::samples_per_axis, "rays a camera pixel, squared")
      .field("threads", &simulate::CaptureOptions::threads,
             "0: as many as the machine has. The result does not depend on it");
  range.fields_init()
      .field("low", &simulate::Range::low, "")
      .field("high", &simulate::Range::high, "")
      .field("either_sign", &simulate::Range::either_sign, "low .. high or -high .. -low");
  conditions.fields_init()
      .field("camera_skew_px", &simulate::Conditions::camera_skew_px, "K(0, 1)")
      .field("projector_skew_px", &simulate::Conditions::projector_skew_px, "K(0, 1)")
      .field("camera_k3", &simulate::Conditions::camera_k3, "of the Brown-Conrady lens")
      .field("projector_k3", &simulate::Conditions::projector_k3, "of the Brown-Conrady lens")
      .field("gamma", &simulate::Conditions::gamma, "of the camera")
      .field("vignetting", &simulate::Conditions::vignetting, "power of the cosine of the field angle")
      .field("indirect", &simulate::Conditions::indirect,
             "light that surfaces reflect onto each other, share of the mean light around")
      .field("glare", &simulate::Conditions::glare,
             "light that the camera's lens scatters over its image, share")
      .field("finest_contrast", &simulate::Conditions::finest_contrast,
             "Contrast of projected stripes of two pixels (Gray code's finest) where the projector\n"
             "is most out of focus within the level's working distances: (max - min) / (max +\n"
             "min). 1: in focus everywhere.")
      .field("noise", &simulate::Conditions::noise,
             "of the linear grey value; none: as in the level's recipe")
      .field("noise_factor", &simulate::Conditions::noise_factor, "on the standard deviation of the noise")
      .field("views", &simulate::Conditions::views, "0: as in the level's recipe")
      .field("dark_views", &simulate::Conditions::dark_views, "underexposed ones")
      .field("white", &simulate::Conditions::white, "their white paper, share of full scale in linear light")
      .field("overexposed_views", &simulate::Conditions::overexposed_views, "")
      .field("overexposure", &simulate::Conditions::overexposure,
             "their white paper, as a multiple of full scale")
      .field("moved_views", &simulate::Conditions::moved_views, "the board moves once during the sequence")
      .field("moved_by", &simulate::Conditions::moved_by,
             "metres; it rotates by 0.1 degrees a millimetre as well")
      .field("stale_views", &simulate::Conditions::stale_views, "one capture still shows the frame before")
      .field("missing_views", &simulate::Conditions::missing_views,
             "one frame is missing, so that all later captures show the next frame")
      .field("torn_views", &simulate::Conditions::torn_views,
             "one capture shows the next frame in its lower rows")
      .field("auto_exposure", &simulate::Conditions::auto_exposure,
             "1: the exposure keeps the image's mean; less: this power of it")
      .field("flicker", &simulate::Conditions::flicker, "amplitude over the rows, and from frame to frame")
      .field("shake_px", &simulate::Conditions::shake_px, "sigma of each frame's shift, an axis")
      .field("drift_px", &simulate::Conditions::drift_px,
             "of the camera's image over the sequence (stabiliser, soft tripod)")
      .field("projector_drift_px", &simulate::Conditions::projector_drift_px,
             "of the projected frame over the sequence, projector pixels")
      .field("focus_drift_px", &simulate::Conditions::focus_drift_px,
             "sigma of the camera's blur at the start, none at the end")
      .field("spot", &simulate::Conditions::spot, "reflection of a lamp on the board, multiple of full scale")
      .field("print_scale", &simulate::Conditions::print_scale,
             "true size of the print / size that the session states");
  view_defects.fields_init()
      .field("white", &simulate::ViewDefects::white,
             "share of full scale of the brightest corner of the sheet, linear light")
      .field("moved", &simulate::ViewDefects::moved, "")
      .field("stale", &simulate::ViewDefects::stale, "at this share of the sequence")
      .field("missing", &simulate::ViewDefects::missing, "at this share of the sequence")
      .field("torn", &simulate::ViewDefects::torn, "at this share of the sequence")
      .method("empty", &simulate::ViewDefects::empty, "");
  move.fields_init()
      .field("share", &simulate::ViewDefects::Move::share, "")
      .field("board_from_moved", &simulate::ViewDefects::Move::board_from_moved, "");
  simulated_session.fields_init()
      .field("level", &simulate::SimulatedSession::level, "")
      .field("views", &simulate::SimulatedSession::views,
             "one a board pose; the same rig, board and wall in each")
      .field("capture", &simulate::SimulatedSession::capture, "")
      .field("defects", &simulate::SimulatedSession::defects, "of each view; empty: none has any")
      .field("conditions", &simulate::SimulatedSession::conditions, "that it was made with")
      .field("stated_board", &simulate::SimulatedSession::stated_board,
             "as its user believes it to be: print_scale is not in it")
      .method(
          "rig",
          [](const simulate::SimulatedSession& self) {
            require(!self.views.empty(), "SimulatedSession.rig: no views");
            return self.rig();
          },
          "")
      .method(
          "board",
          [](const simulate::SimulatedSession& self) {
            require(!self.views.empty(), "SimulatedSession.board: no views");
            return self.board();
          },
          "");
  board_print.fields_init()
      .field("layout", &simulate::BoardPrint::layout, "")
      .field("artwork", &simulate::BoardPrint::artwork, "");
  rectangle.fields_init()
      .field("low", &simulate::Rectangle::low, "metres")
      .field("high", &simulate::Rectangle::high, "metres");
  polygon.fields_init().field("corners", &simulate::Polygon::corners, "metres");
  arc.fields_init().field("from_", &simulate::Arc::from, "").field("to", &simulate::Arc::to, "");
  sphere.fields_init()
      .field("radius", &simulate::Sphere::radius, "")
      .field("longitude", &simulate::Sphere::longitude, "")
      .field("latitude", &simulate::Sphere::latitude, "");
  cylinder.fields_init()
      .field("radius", &simulate::Cylinder::radius, "")
      .field("low", &simulate::Cylinder::low, "")
      .field("high", &simulate::Cylinder::high, "")
      .field("longitude", &simulate::Cylinder::longitude, "");
  texture.fields_init()
      .field("image", &simulate::Texture::image, "")
      .field("white", &simulate::Texture::white, "")
      .field("black", &simulate::Texture::black, "");
  cutout.fields_init()
      .field("mask", &simulate::Cutout::mask, "")
      .field("mask_from_uv", &simulate::Cutout::mask_from_uv,
             "A homography from the shape's u, v to those of the mask, (0, 0) .. (1, 1) from\n"
             "corner to corner; nothing is there where its third number is not positive.");
  body.fields_init()
      .field("name", &simulate::Body::name, "")
      .field("shape", &simulate::Body::shape, "")
      .field("room_from_body", &simulate::Body::room_from_body, "")
      .field("paint", &simulate::Body::paint, "")
      .field("back_albedo", &simulate::Body::back_albedo,
             "Albedo of the other side: of planes the side z > 0, of spheres and cylinders the\n"
             "inner one. None: as this side.")
      .field("cutout", &simulate::Body::cutout, "")
      .field("backdrop", &simulate::Body::backdrop,
             "Behind everything, at any distance: seen and lit where eye and light meet nothing\n"
             "else, it hides nothing. The wall around a sheet, of unknown size.");
  room.fields_init()
      .field("bodies", &simulate::Room::bodies, "")
      .field("ambient", &simulate::Room::ambient,
             "irradiance on everything, in units of a projector's full light at one metre")
      .method("index_of", &simulate::Room::index_of,
              "The place in the list; throws Error(kInput) with the names there are.", py::arg("name"));
  room_view_options.fields_init()
      .field("exposure", &simulate::RoomViewOptions::exposure,
             "Grey levels per unit of albedo * irradiance. 0: such that the brightest pixel reads\n"
             "`brightest_grey` (before vignetting and gamma) under the full light of all\n"
             "projectors.")
      .field("brightest_grey", &simulate::RoomViewOptions::brightest_grey, "")
      .field("colour", &simulate::RoomViewOptions::colour, "captures of three channels")
      .field("crosstalk", &simulate::RoomViewOptions::crosstalk,
             "share of a neighbouring colour's light, colour captures only")
      .field("lens", &simulate::RoomViewOptions::lens, "of the camera")
      .field("camera_blur_px", &simulate::RoomViewOptions::camera_blur_px,
             "sigma of the camera's lens in focus, camera pixels")
      .field("vignetting", &simulate::RoomViewOptions::vignetting,
             "power of the cosine of the field angle; 4: the natural law of a simple lens")
      .field("gamma", &simulate::RoomViewOptions::gamma, "of the camera; 1: linear; kSrgb")
      .field("noise", &simulate::RoomViewOptions::noise, "Gaussian; variance of the linear grey value")
      .field("seed", &simulate::RoomViewOptions::seed, "of the noise")
      .field("samples_per_axis", &simulate::RoomViewOptions::samples_per_axis, "rays a camera pixel, squared")
      .field("adaptive", &simulate::RoomViewOptions::adaptive,
             "Cast all rays only where a neighbouring pixel sees another body, bend or light;\n"
             "elsewhere one, and the others are followed on the plane that it meets. With bodies\n"
             "that are not flat several times as fast; what is thinner than a pixel may be missed.\n"
             "Not with a rolling shutter.")
      .field("threads", &simulate::RoomViewOptions::threads,
             "0: as many as the machine has. The result does not depend on it")
      .field("time", &simulate::RoomViewOptions::time, "of the first row, seconds")
      .field("row_time", &simulate::RoomViewOptions::row_time,
             "from one row to the next, seconds; 0: all rows at once");
  room_truth.fields_init()
      .field("body", &simulate::RoomTruth::body, "number in the room; -1: nothing")
      .field("depth", &simulate::RoomTruth::depth, "z in the camera's frame, metres; 0: nothing")
      .field("point_in_room", &simulate::RoomTruth::point_in_room, "three channels, metres")
      .field("light", &simulate::RoomTruth::light, "by light: the projector pixel that lights the point");
  room_view.fields_init()
      .field("captures", &simulate::RoomView::captures, "one a frame; one without projectors")
      .field("exposure", &simulate::RoomView::exposure, "the one used")
      .field("truth", &simulate::RoomView::truth, "")
      .method(
          "image",
          [](const simulate::RoomView& self) {
            require(!self.captures.empty(), "RoomView.image: no captures");
            return self.image();
          },
          "");
  depth_sensor.fields_init()
      .field("camera", &simulate::DepthSensor::camera, "")
      .field("emitter_in_camera", &simulate::DepthSensor::emitter_in_camera,
             "Where the emitter stands: its baseline and its shadows.")
      .field("nearest", &simulate::DepthSensor::nearest, "metres")
      .field("farthest", &simulate::DepthSensor::farthest, "metres")
      .field("grazing", &simulate::DepthSensor::grazing, "radians between ray and normal")
      .field("disparity_step", &simulate::DepthSensor::disparity_step, "pixels; 0: no rounding")
      .field("edge_noise", &simulate::DepthSensor::edge_noise, "factors of the laws above")
      .field("axial_noise", &simulate::DepthSensor::axial_noise, "factors of the laws above")
      .field("dropout", &simulate::DepthSensor::dropout, "share of pixels lost for no reason");
  depth_view.fields_init()
      .field("metres", &simulate::DepthView::metres, "z in the camera's frame, measured; 0: hole")
      .field("mm", &simulate::DepthView::mm, "the same, rounded to millimetres; 0: hole")
      .field("true_metres", &simulate::DepthView::true_metres, "without noise and holes; 0: nothing there")
      .field("body", &simulate::DepthView::body, "of the pixel's centre, number in the room; -1: nothing")
      .field("angle", &simulate::DepthView::angle, "theta, radians; 0 where there is nothing");
  leg.fields_init()
      .field("increment", &simulate::Leg::increment, "")
      .field("duration", &simulate::Leg::duration, "seconds")
      .field("rest_to_rest", &simulate::Leg::rest_to_rest,
             "From rest to rest: share(x) = 10 x^3 - 15 x^4 + 6 x^5, the motion of least jerk (T.\n"
             "Flash, N. Hogan, \"The coordination of arm movements\", J. Neuroscience 5(7), 1985).\n"
             "Else share(x) = x, a constant twist.");
  drive
      .init([](const Pose& world_from_rig_at_start, const std::vector<simulate::Leg>& legs,
               double start_time) { return simulate::Drive(world_from_rig_at_start, legs, start_time); },
            "Throws std::invalid_argument for a duration that is not positive or a number that is\n"
            "not finite.",
            py::arg("world_from_rig_at_start"), py::arg("legs"), py::arg("start_time") = 0)
      .method("start_time", &simulate::Drive::start_time, "")
      .method("end_time", &simulate::Drive::end_time, "")
      .method("world_from_rig", &simulate::Drive::world_from_rig,
              "It stands still before its start and after its end.", py::arg("time"))
      .method("twist", &simulate::Drive::twist,
              "[rotation, translation] in the rig's frame, rad/s and m/s; at a joint, of the leg\n"
              "that begins.",
              py::arg("time"))
      .method("__call__", &simulate::Drive::operator(), "", py::arg("time"));
  waypoint.fields_init()
      .field("world_from_rig", &simulate::Waypoint::world_from_rig, "")
      .field("time", &simulate::Waypoint::time, "of arrival, seconds");
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
  localised_pose.fields_init()
      .field("stamp", &simulate::LocalisedPose::stamp, "the moment it speaks of, seconds")
      .field("arrival", &simulate::LocalisedPose::arrival, "when it is known, seconds")
      .field("measured", &simulate::LocalisedPose::measured,
             "world_from_rig: (R exp(rotation noise), t + position noise)")
      .field("truth", &simulate::LocalisedPose::truth, "");
  fleet.fields_init()
      .field("rig", &simulate::Fleet::rig, "the first camera's frame is the rig's")
      .field("world", &simulate::Fleet::world,
             "board, wall and light; its rig is to be replaced by a pair of devices")
      .field("capture", &simulate::Fleet::capture, "")
      .field("views", &simulate::Fleet::views, "");
  view_.fields_init()
      .field("rig_from_board", &simulate::Fleet::View::rig_from_board, "")
      .field("cameras", &simulate::Fleet::View::cameras, "")
      .field("projectors", &simulate::Fleet::View::projectors, "");
  marker_view_options.fields_init()
      .field("white_grey", &simulate::MarkerViewOptions::white_grey, "in the image's middle")
      .field("black_grey", &simulate::MarkerViewOptions::black_grey, "in the image's middle")
      .field("wall_grey", &simulate::MarkerViewOptions::wall_grey, "in the image's middle")
      .field("falloff", &simulate::MarkerViewOptions::falloff,
             "Light falls off to the right and to the bottom by this share over the image.")
      .field("rim_cells", &simulate::MarkerViewOptions::rim_cells,
             "white paper round the black square, cells")
      .field("blur_px", &simulate::MarkerViewOptions::blur_px, "sigma of the lens")
      .field("noise", &simulate::MarkerViewOptions::noise, "of the linear level")
      .field("gamma", &simulate::MarkerViewOptions::gamma, "of the camera; the greys above are linear")
      .field("glare", &simulate::MarkerViewOptions::glare,
             "light that the lens scatters over the image, share")
      .field("seed", &simulate::MarkerViewOptions::seed, "");
  hung_markers.fields_init()
      .field("map", &simulate::HungMarkers::map, "")
      .field("rig_from_world", &simulate::HungMarkers::rig_from_world,
             "the world is the frame of the first marker");
  preview_options.fields_init()
      .field("ambient", &simulate::PreviewOptions::ambient,
             "The room's own light, over the light of full projection that is shown as white. 0:\n"
             "the room's as it is.")
      .field("threads", &simulate::PreviewOptions::threads,
             "0: as many as the machine has. The result does not depend on it");
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
  robot_event.fields_init()
      .field("time", &simulate::RobotEvent::time, "of arrival, seconds since the start")
      .field("moment", &simulate::RobotEvent::moment, "that the message speaks of, likewise")
      .field("malformed", &simulate::RobotEvent::malformed, "")
      .field("message", &simulate::RobotEvent::message,
             "without stamp and arrival: they are in the receiver's clocks");
  robot_messages.fields_init()
      .field("events", &simulate::RobotMessages::events, "in the order of arrival")
      .field("made", &simulate::RobotMessages::made, "")
      .field("messages", &simulate::RobotMessages::messages, "")
      .field("reordered", &simulate::RobotMessages::reordered, "")
      .field("duplicated", &simulate::RobotMessages::duplicated, "")
      .field("malformed", &simulate::RobotMessages::malformed, "")
      .field("lost", &simulate::RobotMessages::lost, "");

  motion
      .init([](const Pose& target_from_source) { return simulate::Motion(target_from_source); },
            "Stands still.", py::arg_v("target_from_source", Pose(), "Pose()"))
      .init([](const simulate::Drive& drive) { return simulate::Motion(drive); }, "Drives.", py::arg("drive"))
      .method("is_still", &simulate::Motion::is_still, "")
      .method("__call__", &simulate::Motion::operator(), "The pose at a time in seconds.", py::arg("time"))
      .method(
          "__mul__",
          [](const simulate::Motion& self, const Pose& middle_from_source) {
            return self * middle_from_source;
          },
          "For a device that rides on another.", py::arg("middle_from_source"));
  py::implicitly_convertible<Pose, simulate::Motion>();
  py::implicitly_convertible<simulate::Drive, simulate::Motion>();
  triangle_mesh
      .init([](const Mesh& mesh) { return simulate::TriangleMesh(std::make_shared<const Mesh>(mesh)); },
            "Throws Error(kInput) with the fault of a mesh that cannot be.", py::arg("mesh"))
      .method("mesh", &simulate::TriangleMesh::mesh, "");
  room_light.fields_init()
      .field("projector", &simulate::RoomLight::projector, "")
      .field("room_from_projector", &simulate::RoomLight::room_from_projector, "a Pose or a Motion")
      .field("frames", &simulate::RoomLight::frames, "grey, or red, green, blue; the projector's size")
      .field("intensity", &simulate::RoomLight::intensity,
             "irradiance of full light at one metre, straight on")
      .field("lens", &simulate::RoomLight::lens, "")
      .field("blur_px", &simulate::RoomLight::blur_px, "")
      .field("gamma", &simulate::RoomLight::gamma, "")
      .field("black", &simulate::RoomLight::black, "");

  function(m, "rig_from_wall", &simulate::rig_from_wall,
           "A surface frame on the wall: origin where the camera's axis meets it, x as the\n"
           "camera's, z into the wall. Throws std::invalid_argument when the camera does not\n"
           "face the wall.",
           py::arg("world"));
  function(m, "with_bare_wall", &simulate::with_bare_wall,
           "The world before its wall alone: the sheet is behind the camera, as far away as the\n"
           "wall (so that captures are exposed as for a sheet on the wall).",
           py::arg("world"));
  function(m, "sheet_corners_in_board", &simulate::sheet_corners_in_board,
           "The sheet's corners in the board's frame, clockwise from the origin's, metres.",
           py::arg("board"));
  function(m, "board_in_camera", &simulate::board_in_camera,
           "The board's points that fall on the camera's image / that the projector's picture\n"
           "covers, at their exact pixels. Occlusion is ignored: nothing stands before the\n"
           "board.",
           py::arg("world"));
  function(m, "board_in_projector", &simulate::board_in_projector, "", py::arg("world"));
  function(m, "camera_pixel_of_light", &simulate::camera_pixel_of_light,
           "Where the camera sees that light; nullopt where it falls outside the sheet or the\n"
           "image.",
           py::arg("world"), py::arg("projector_pixel"));
  function(m, "projector_pixel_seen_at", &simulate::projector_pixel_seen_at,
           "The projector pixel whose light falls on the surface point that a camera pixel sees;\n"
           "nullopt where the camera sees nothing, or where no projector light arrives (outside\n"
           "its picture, in the board's shadow, from behind).",
           py::arg("world"), py::arg("camera_pixel"));
  function(m, "projector_map", &simulate::projector_map, "", py::arg("world"));
  function(m, "capture", &simulate::capture,
           "One capture a projector frame (one channel or three, all alike; the projector's\n"
           "size, 0 dark .. 255 full light). Throws std::invalid_argument for frames of another\n"
           "size, options out of range, or a sheet that no light reaches.",
           py::arg("world"), py::arg("projector_frames"),
           py::arg_v("options", simulate::CaptureOptions{}, "CaptureOptions()"));
  function(m, "plain_conditions", &simulate::plain_conditions,
           "None of these effects: a linear camera without scattered light, lenses and views as\n"
           "in the recipe.");
  function(m, "frame_at", &simulate::frame_at,
           "The frame at a share of a sequence, 1 .. frames - 1; 0 for a single frame.", py::arg("share"),
           py::arg("frames"));
  function(m, "description", &simulate::description,
           "\"white at 27 % of full scale, board moved by 7.1 mm before frame 12\"; empty for\n"
           "none.",
           py::arg("defects"), py::arg("frames"));
  function(m, "to_string", &simulate::to_string, "", py::arg("level"));
  function(m, "level_named", &simulate::level_named, "Throws Error(kUnsupported) for an unknown name.",
           py::arg("name"));
  function(m, "projector_size", &simulate::projector_size, "The size of the level's projector picture.",
           py::arg("level"));
  function(m, "level_conditions", &simulate::level_conditions,
           "The level's departures from what calibration assumes: none for easy.", py::arg("level"));
  function(m, "make_session",
           py::overload_cast<simulate::Level, std::uint64_t, const std::optional<Eigen::AlignedBox2d>&,
                             const std::optional<simulate::BoardPrint>&>(&simulate::make_session),
           "`on_blank_paper` is the part of the projector's picture that lands on blank paper in\n"
           "every view. Throws Error(kNotConverged) when no poses are found that camera and\n"
           "projector both cover, std::invalid_argument for conditions out of range. Without\n"
           "conditions: those of the level.",
           py::arg("level"), py::arg("seed"), py::arg("on_blank_paper") = py::none(),
           py::arg("print") = py::none());
  function(m, "make_session",
           py::overload_cast<simulate::Level, std::uint64_t, const std::optional<Eigen::AlignedBox2d>&,
                             const std::optional<simulate::BoardPrint>&, const simulate::Conditions&>(
               &simulate::make_session),
           "", py::arg("level"), py::arg("seed"), py::arg("on_blank_paper"), py::arg("print"),
           py::arg("conditions"));
  function(m, "capture_view", &simulate::capture_view,
           "The captures of one view while the projector shows `frames`. Noise differs from view\n"
           "to view.",
           py::arg("session"), py::arg("view"), py::arg("frames"));
  function(m, "point_at", &simulate::point_at,
           "A body's point at u, v: the other way round. Throws std::invalid_argument outside\n"
           "[0, 1], and where no triangle of a mesh has them.",
           py::arg("body"), py::arg("uv"));
  function(m, "box", &simulate::box,
           "The six faces of a block from the origin of its frame to `size`, \"NAME -x\" .. \"NAME\n"
           "+z\", printed sides outwards.",
           py::arg("name"), py::arg("room_from_box"), py::arg("size"), py::arg("paint"));
  function(m, "printed_sheet", &simulate::printed_sheet,
           "The sheet with its margin, placed by the board's frame.", py::arg("name"), py::arg("board"),
           py::arg("room_from_board"));
  function(m, "marker_sheet", &simulate::marker_sheet,
           "A marker's sheet: the black square, and round it white paper of `rim_cells` cells.\n"
           "Its frame is the marker's. Throws std::invalid_argument for a size that is not\n"
           "positive or an id that the codes lack.",
           py::arg("marker"), py::arg("codes"), py::arg_v("room_from_world", Pose{}, "Pose()"),
           py::arg("rim_cells") = 2);
  function(m, "room_view", &simulate::room_view,
           "All lights show the same number of frames, at the same time; noise differs from\n"
           "frame to frame. Throws std::invalid_argument for frames of another size or number,\n"
           "options out of range, bodies that cannot be, or (exposure 0) a view without any\n"
           "light.",
           py::arg("room"), py::arg("camera"), py::arg("room_from_camera"), py::arg("lights"),
           py::arg_v("options", simulate::RoomViewOptions{}, "RoomViewOptions()"));
  function(m, "axial_sigma", &simulate::axial_sigma,
           "The standard deviation of an axial reading at depth z of a surface turned by theta,\n"
           "metres.",
           py::arg("z"), py::arg("theta"));
  function(m, "lateral_sigma", &simulate::lateral_sigma, "Of a place along each axis of the image, pixels.",
           py::arg("theta"));
  function(m, "depth_view", &simulate::depth_view,
           "Equal seeds give equal views. Throws std::invalid_argument for numbers out of range\n"
           "or bodies that cannot be.",
           py::arg("room"), py::arg("sensor"), py::arg("room_from_camera"), py::arg("seed"),
           py::arg("threads") = 0);
  function(m, "constant_twist", &simulate::constant_twist, "The same twist all along.", py::arg("twist"),
           py::arg("duration"));
  function(m, "circle", &simulate::circle,
           "Once round a circle in the rig's x-y plane, x ahead (a robot's base, z up): a\n"
           "positive radius turns left, a negative one right. `turns` may be any number above\n"
           "zero. Speed in m/s, above zero.",
           py::arg("radius"), py::arg("speed"), py::arg("turns") = 1);
  function(m, "drive_through", &simulate::drive_through,
           "From waypoint to waypoint along screws, resting at each; the first gives start and\n"
           "start time. Throws std::invalid_argument for fewer than two, or times that do not\n"
           "grow.",
           py::arg("waypoints"));
  function(m, "localise", &simulate::localise,
           "Messages stamped start, start + 1 / rate, ... up to the drive's end, in the order of\n"
           "arrival (jitter above the period lets them overtake each other). Equal seeds give\n"
           "equal messages, and dropping some changes nothing in the others. Throws\n"
           "std::invalid_argument for numbers out of range.",
           py::arg("drive"), py::arg("localiser"));
  function(m, "make_fleet",
           py::overload_cast<simulate::Level, std::uint64_t, int, int>(&simulate::make_fleet),
           "The level's lenses, board and noise; four views a camera, eight at least. Equal\n"
           "seeds give equal fleets. Throws std::invalid_argument unless there is one of each at\n"
           "least, Error(kNotConverged) when no board pose is found that the devices cover.",
           py::arg("level"), py::arg("seed"), py::arg("cameras"), py::arg("projectors"));
  function(m, "make_fleet",
           py::overload_cast<simulate::Level, std::uint64_t, int, int, const simulate::Conditions&>(
               &simulate::make_fleet),
           "Under other conditions than the level's; no view has defects of its own.", py::arg("level"),
           py::arg("seed"), py::arg("cameras"), py::arg("projectors"), py::arg("conditions"));
  function(m, "capture_pair", &simulate::capture_pair,
           "What one camera records of one projector's frames in one view.", py::arg("fleet"),
           py::arg("view"), py::arg("camera"), py::arg("projector"), py::arg("frames"));
  function(m, "scan_scenes", &simulate::scan_scenes, "The names of the rooms to scan.");
  function(m, "scan_scene", &simulate::scan_scene,
           "In the frame of the rig's camera. Throws Error(kUnsupported) with the names there are.",
           py::arg("name"));
  function(m, "scan_view",
           py::overload_cast<const simulate::SimulatedSession&, const simulate::Room&,
                             const std::vector<ImageU8>&>(&simulate::scan_view),
           "What the session's rig records while its projector shows `frames` on the room.",
           py::arg("session"), py::arg("room"), py::arg("frames"));
  function(m, "marker_view", &simulate::marker_view,
           "The camera's image of the markers; where sheets overlap in the image the first one\n"
           "shows. Throws std::invalid_argument for a size that is not positive, an id that the\n"
           "codes lack, or options out of range.",
           py::arg("camera"), py::arg("camera_from_world"), py::arg("markers"), py::arg("codes"),
           py::arg_v("options", simulate::MarkerViewOptions{}, "MarkerViewOptions()"));
  function(m, "hang_markers", &simulate::hang_markers,
           "Four markers (ids 3, 7, 11, 20 of apriltag_36h11; sides of a tenth of the camera's\n"
           "distance and less) on the wall of the world, round the point that the camera's axis\n"
           "meets, each turned a little in its plane. Throws std::invalid_argument when the\n"
           "camera does not face the wall.",
           py::arg("world"));
  function(m, "preview", &simulate::preview,
           "The eye's picture, RGB, sRGB. Of each light the first frame is shown. Throws\n"
           "std::invalid_argument as room_view().",
           py::arg("room"), py::arg("lights"), py::arg("eye"), py::arg("room_from_eye"),
           py::arg_v("options", simulate::PreviewOptions{}, "PreviewOptions()"));
  function(m, "robot_messages", &simulate::robot_messages, "Throws std::invalid_argument as localise() does.",
           py::arg("drive"), py::arg("options"));
  function(m, "random_walk", &simulate::random_walk,
           "Arcs of 0.3 to 1.5 m from rest to rest in the x-y plane, at `speed` at most (m/s),\n"
           "for `duration` seconds at least.",
           py::arg("speed"), py::arg("duration"), py::arg("seed"));
  function(m, "drive_along", &simulate::drive_along,
           "Along recorded poses at their times, from one to the next along a screw: resting at\n"
           "each, or at constant twist. Throws Error(kNotEnoughData) for fewer than two.",
           py::arg("poses"), py::arg("rest_at_each"));

  function(
      m, Gil::kHeld, "room_of", [](const HeldScene& scene) { return simulate::room_of(scene_of(scene)); },
      "The scene's surfaces as matt white bodies, in the scene's frame, named by their\n"
      "places \"0\", \"1\", ...: a plane's content area, a mesh's triangles, less where the\n"
      "item's mask is below one half. Round every plane a backdrop of a fifth of its size\n"
      "on each side: most are part of a wall. Contents are not looked at; pixel surfaces\n"
      "have no place in the room.",
      py::arg("scene"));

  m.attr("kSrgb") = simulate::kSrgb;
}

}  // namespace procam::python
