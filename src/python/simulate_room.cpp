// procam.simulate: rooms, and what moves in them
#include "procam/simulate.hpp"

#include "bind.hpp"
#include "components.hpp"
#include "scene.hpp"

namespace procam::python {

namespace {

void bind_shapes(py::module_& m) {
  Record<simulate::Rectangle> rectangle(m, "Rectangle",
                                        "A rectangle in the plane z = 0 of its body; metres.");
  rectangle.fields_init()
      .field("low", &simulate::Rectangle::low, "metres")
      .field("high", &simulate::Rectangle::high, "metres");

  Record<simulate::Polygon> polygon(m, "Polygon",
                                    "Any simple polygon, three corners at least, either sense.");
  polygon.fields_init().field("corners", &simulate::Polygon::corners, "metres");

  Record<simulate::Arc> arc(m, "Arc", "A range of angles, radians, from < to <= from + 2 pi.");
  arc.fields_init()
      .field("from_", &simulate::Arc::from, "radians")
      .field("to", &simulate::Arc::to, "radians");

  Record<simulate::Sphere> sphere(
      m, "Sphere", "A sphere, or the part of it within two ranges (a dome: latitude 0 .. pi/2).");
  sphere.fields_init()
      .field("radius", &simulate::Sphere::radius, "metres")
      .field("longitude", &simulate::Sphere::longitude, "")
      .field("latitude", &simulate::Sphere::latitude, "");

  Record<simulate::Cylinder> cylinder(
      m, "Cylinder", "A tube without lids, or a part of its turn (a column, a niche, a curved screen).");
  cylinder.fields_init()
      .field("radius", &simulate::Cylinder::radius, "metres")
      .field("low", &simulate::Cylinder::low, "along its axis, metres")
      .field("high", &simulate::Cylinder::high, "along its axis, metres")
      .field("longitude", &simulate::Cylinder::longitude, "");

  Record<simulate::Texture> texture(
      m, "Texture",
      "A picture, grey or red, green, blue, stretched over a body's u, v, its texels square\n"
      "tiles of one albedo: black + (white - black) * value / 255. The texel (0, 0) begins\n"
      "at u = v = 0. At most 2^24 texels.");
  texture.fields_init()
      .field("image", &simulate::Texture::image, "grey or RGB")
      .field("white", &simulate::Texture::white, "share of the light that is reflected, 0 .. 1")
      .field("black", &simulate::Texture::black, "share of the light that is reflected, 0 .. 1");

  Record<simulate::Cutout> cutout(
      m, "Cutout",
      "Holes and an outline: the body is there where the mask, one channel, linear between\n"
      "the middles of its texels, is one half or more.");
  cutout.fields_init()
      .field("mask", &simulate::Cutout::mask, "")
      .field("mask_from_uv", &simulate::Cutout::mask_from_uv,
             "A homography from the shape's u, v to those of the mask, (0, 0) .. (1, 1) from\n"
             "corner to corner; nothing is there where its third number is not positive.");
}

void bind_bodies(py::module_& m) {
  Record<simulate::TriangleMesh> triangle_mesh(m, "TriangleMesh", "Triangles, both sides of which are seen.");
  triangle_mesh
      .init([](const Mesh& mesh) { return simulate::TriangleMesh(std::make_shared<const Mesh>(mesh)); },
            "Raises Error(kInput) with the fault of a mesh that cannot be.", py::arg("mesh"))
      .method("mesh", &simulate::TriangleMesh::mesh, "Its triangles, a copy; metres.");

  Record<simulate::Gloss> gloss(m, "Gloss",
                                "The polish of a flat body, beside its paint: a lacquered table, a screen.");
  gloss.fields_init()
      .field("share", &simulate::Gloss::share, "of the light that it mirrors, whatever the angle; 0: none")
      .field(
          "spread", &simulate::Gloss::spread,
          "standard deviation of the mirrored directions, radians: the highlight's width; images are sharp");

  Record<simulate::Body> body(m, "Body", "One thing in a room: shape, pose, paint and gloss.");
  body.fields_init()
      .field("name", &simulate::Body::name, "")
      .field("shape", &simulate::Body::shape, "")
      .field("room_from_body", &simulate::Body::room_from_body, "")
      .field("paint", &simulate::Body::paint, "share of the light that is reflected, a texture, or a board")
      .field("back_albedo", &simulate::Body::back_albedo,
             "Albedo of the other side: of planes the side z > 0, of spheres and cylinders the\n"
             "inner one. None: as this side.")
      .field("cutout", &simulate::Body::cutout, "")
      .field("backdrop", &simulate::Body::backdrop,
             "Behind everything, at any distance: seen and lit where eye and light meet nothing\n"
             "else, it hides nothing. The wall around a sheet, of unknown size.")
      .field("gloss", &simulate::Body::gloss,
             "of the front of a Rectangle or Polygon; seen with Room.indirect");

  Record<simulate::Room> room(m, "Room", "Bodies and light.");
  room.fields_init()
      .field("bodies", &simulate::Room::bodies, "")
      .field("indirect", &simulate::Room::indirect,
             "Surfaces light each other. Not with surfaces that have colour, nor with devices that move.")
      .field("ambient", &simulate::Room::ambient,
             "irradiance on everything, in units of a projector's full light at one metre")
      .method("index_of", &simulate::Room::index_of,
              "The place in the list; throws Error(kInput) with the names there are.", py::arg("name"));

  function(m, "point_at", &simulate::point_at,
           "A body's point at u, v: the other way round. Raises ValueError outside\n"
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
           "Its frame is the marker's. Raises ValueError for a size that is not\n"
           "positive or an id that the codes lack.",
           py::arg("marker"), py::arg("codes"), py::arg_v("room_from_world", Pose{}, "Pose()"),
           py::arg("rim_cells") = 2);
}

void bind_drive(py::module_& m) {
  Record<simulate::Leg> leg(
      m, "Leg",
      "One leg: a screw motion by `increment` = [rotation, translation] in the rig's frame\n"
      "at its start.");
  leg.fields_init()
      .field("increment", &simulate::Leg::increment,
             "rotation (radians), translation (metres), in the rig's frame at its start")
      .field("duration", &simulate::Leg::duration, "seconds")
      .field("rest_to_rest", &simulate::Leg::rest_to_rest,
             "From rest to rest: share(x) = 10 x^3 - 15 x^4 + 6 x^5, the motion of least jerk (T.\n"
             "Flash, N. Hogan, \"The coordination of arm movements\", J. Neuroscience 5(7), 1985).\n"
             "Else share(x) = x, a constant twist.");

  Record<simulate::Drive> drive(m, "Drive", "A robot's motion: the true pose at any time.");
  drive
      .init([](const Pose& world_from_rig_at_start, const std::vector<simulate::Leg>& legs,
               double start_time) { return simulate::Drive(world_from_rig_at_start, legs, start_time); },
            "Raises ValueError for a duration that is not positive or a number that is\n"
            "not finite.",
            py::arg("world_from_rig_at_start"), py::arg("legs"), py::arg("start_time") = 0)
      .method("start_time", &simulate::Drive::start_time, "Seconds.")
      .method("end_time", &simulate::Drive::end_time, "Seconds.")
      .method("world_from_rig", &simulate::Drive::world_from_rig,
              "It stands still before its start and after its end.", py::arg("time"))
      .method("twist", &simulate::Drive::twist,
              "[rotation, translation] in the rig's frame, rad/s and m/s; at a joint, of the leg\n"
              "that begins.",
              py::arg("time"))
      .method("__call__", &simulate::Drive::operator(), "world_from_rig at a time in seconds.",
              py::arg("time"));

  Record<simulate::Waypoint> waypoint(m, "Waypoint", "A pose and the time of arrival there.");
  waypoint.fields_init()
      .field("world_from_rig", &simulate::Waypoint::world_from_rig, "")
      .field("time", &simulate::Waypoint::time, "of arrival, seconds");

  function(m, "constant_twist", &simulate::constant_twist, "The same twist all along.", py::arg("twist"),
           py::arg("duration"));
  function(m, "circle", &simulate::circle,
           "Once round a circle in the rig's x-y plane, x ahead (a robot's base, z up): a\n"
           "positive radius turns left, a negative one right. `turns` may be any number above\n"
           "zero. Speed in m/s, above zero.",
           py::arg("radius"), py::arg("speed"), py::arg("turns") = 1);
  function(m, "drive_through", &simulate::drive_through,
           "From waypoint to waypoint along screws, resting at each; the first gives start and\n"
           "start time. Raises ValueError for fewer than two, or times that do not\n"
           "grow.",
           py::arg("waypoints"));
}

void bind_motion(py::module_& m) {
  Record<simulate::Motion> motion(
      m, "Motion", "target_from_source over time, seconds: one pose for ever, or a function of the time.");
  motion
      .init([](const Pose& target_from_source) { return simulate::Motion(target_from_source); },
            "Stands still.", py::arg_v("target_from_source", Pose(), "Pose()"))
      .init([](const simulate::Drive& drive) { return simulate::Motion(drive); }, "Drives.", py::arg("drive"))
      .method("is_still", &simulate::Motion::is_still, "Does nothing move?")
      .method("__call__", &simulate::Motion::operator(), "The pose at a time in seconds.", py::arg("time"))
      .method(
          "__mul__",
          [](const simulate::Motion& self, const Pose& middle_from_source) {
            return self * middle_from_source;
          },
          "For a device that rides on another.", py::arg("middle_from_source"));

  py::implicitly_convertible<Pose, simulate::Motion>();
  py::implicitly_convertible<simulate::Drive, simulate::Motion>();
}

void bind_room_light(py::module_& m) {
  Record<simulate::RoomLight> room_light(m, "RoomLight", "A projector's light in the room.");
  room_light.fields_init()
      .field("projector", &simulate::RoomLight::projector, "")
      .field("room_from_projector", &simulate::RoomLight::room_from_projector, "a Pose or a Motion")
      .field("frames", &simulate::RoomLight::frames, "grey, or red, green, blue; the projector's size")
      .field("intensity", &simulate::RoomLight::intensity,
             "irradiance of full light at one metre, straight on")
      .field("lens", &simulate::RoomLight::lens, "")
      .field("blur_px", &simulate::RoomLight::blur_px, "standard deviation of the camera's blur, pixels")
      .field("gamma", &simulate::RoomLight::gamma, "light = value^gamma")
      .field("black", &simulate::RoomLight::black, "light of a black pixel, share of full light, 0 .. 1");

  m.attr("kSrgb") = simulate::kSrgb;
}

void bind_room_view(py::module_& m) {
  Record<simulate::RoomViewOptions> room_view_options(m, "RoomViewOptions",
                                                      "The camera of room_view(): exposure, noise, blur.");
  room_view_options.fields_init()
      .field("exposure", &simulate::RoomViewOptions::exposure,
             "Grey levels per unit of albedo * irradiance. 0: such that the brightest pixel reads\n"
             "`brightest_grey` (before vignetting and gamma) under the full light of all\n"
             "projectors.")
      .field("brightest_grey", &simulate::RoomViewOptions::brightest_grey,
             "grey level of full light, 0 .. 255")
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

  Record<simulate::RoomTruth> room_truth(m, "RoomTruth", "What the centre of each pixel sees.");
  room_truth.fields_init()
      .field("body", &simulate::RoomTruth::body, "number in the room; -1: nothing")
      .field("depth", &simulate::RoomTruth::depth, "z in the camera's frame, metres; 0: nothing")
      .field("point_in_room", &simulate::RoomTruth::point_in_room, "three channels, metres")
      .field("light", &simulate::RoomTruth::light, "by light: the projector pixel that lights the point");

  Record<simulate::RoomView> room_view(m, "RoomView", "A camera's view of a room, and what each pixel sees.");
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
          "The only capture, uint8 (h, w) or (h, w, 3).");

  function(m, "room_view", &simulate::room_view,
           "All lights show the same number of frames, at the same time; noise differs from\n"
           "frame to frame. Raises ValueError for frames of another size or number,\n"
           "options out of range, bodies that cannot be, or (exposure 0) a view without any\n"
           "light.",
           py::arg("room"), py::arg("camera"), py::arg("room_from_camera"), py::arg("lights"),
           py::arg_v("options", simulate::RoomViewOptions{}, "RoomViewOptions()"));
}

void bind_depth_view(py::module_& m) {
  Record<simulate::DepthSensor> depth_sensor(m, "DepthSensor", "A depth sensor: its camera and noise.");
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

  Record<simulate::DepthView> depth_view(m, "DepthView", "A depth image and its truth; metres.");
  depth_view.fields_init()
      .field("metres", &simulate::DepthView::metres, "z in the camera's frame, measured; 0: hole")
      .field("mm", &simulate::DepthView::mm, "the same, rounded to millimetres; 0: hole")
      .field("true_metres", &simulate::DepthView::true_metres, "without noise and holes; 0: nothing there")
      .field("body", &simulate::DepthView::body, "of the pixel's centre, number in the room; -1: nothing")
      .field("angle", &simulate::DepthView::angle, "theta, radians; 0 where there is nothing")
      .field("shadowed", &simulate::DepthView::shadowed, "1 where the emitter's light does not arrive");

  function(m, "axial_sigma", &simulate::axial_sigma,
           "The standard deviation of an axial reading at depth z of a surface turned by theta,\n"
           "metres.",
           py::arg("z"), py::arg("theta"));
  function(m, "lateral_sigma", &simulate::lateral_sigma, "Of a place along each axis of the image, pixels.",
           py::arg("theta"));
  function(m, "depth_view", &simulate::depth_view,
           "Equal seeds give equal views. Raises ValueError for numbers out of range\n"
           "or bodies that cannot be.",
           py::arg("room"), py::arg("sensor"), py::arg("room_from_camera"), py::arg("seed"),
           py::arg("threads") = 0);
  function(m, "read_again", &simulate::read_again,
           "The view with the noise of another seed: a sensor's next image of a room that\n"
           "stays as it is. Raises ValueError for a view of another sensor's size.",
           py::arg("view"), py::arg("sensor"), py::arg("seed"));
}

void bind_fleet(py::module_& m) {
  Record<simulate::Fleet> fleet(m, "Fleet",
                                "Several cameras and projectors that see one board, with the truth.");
  Record<simulate::Fleet::View> view_(
      fleet.type, "View",
      "A board pose, and the devices (by number in the rig) that take part: the whole print\n"
      "lies before them.");
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

  function(m, "make_fleet",
           py::overload_cast<simulate::Level, std::uint64_t, int, int>(&simulate::make_fleet),
           "The level's lenses, board and noise; four views a camera, eight at least. Equal\n"
           "seeds give equal fleets. Raises ValueError unless there is one of each at\n"
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
}

void bind_scan_view(py::module_& m) {
  function(m, "room_from_rig", &simulate::room_from_rig,
           "Where the whole rig stands at a station of a room to scan.", py::arg("station"));
  function(m, "scan_scenes", &simulate::scan_scenes, "The names of the rooms to scan.");
  function(m, "moved_camera", &simulate::moved_camera,
           "Where somebody stands a camera for the views of calibrate_room: `view` 0 is where the\n"
           "rig has it, the others are half a metre to its sides, above and below, and look at the\n"
           "same part of the room.",
           py::arg("rig_from_camera"), py::arg("view"));
  function(m, "scan_scene", &simulate::scan_scene,
           "In the frame of the rig's camera. Raises Error(kUnsupported) with the names there are.",
           py::arg("name"));
  function(m, "scan_view",
           py::overload_cast<const simulate::SimulatedSession&, const simulate::Room&,
                             const std::vector<ImageU8>&>(&simulate::scan_view),
           "What the session's rig records while its projector shows `frames` on the room.",
           py::arg("session"), py::arg("room"), py::arg("frames"));
  function(m, "scan_view",
           py::overload_cast<const simulate::CaptureOptions&, const simulate::Room&, const RigCamera&,
                             const RigProjector&, const std::vector<ImageU8>&>(&simulate::scan_view),
           "The same by one camera and one projector of several.", py::arg("capture"), py::arg("room"),
           py::arg("camera"), py::arg("projector"), py::arg("frames"));
}

void bind_marker_view(py::module_& m) {
  Record<simulate::MarkerViewOptions> marker_view_options(
      m, "MarkerViewOptions", "The camera of marker_view(): exposure, noise, blur.");
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

  Record<simulate::HungMarkers> hung_markers(m, "HungMarkers", "Markers with their true places.");
  hung_markers.fields_init()
      .field("map", &simulate::HungMarkers::map, "")
      .field("rig_from_world", &simulate::HungMarkers::rig_from_world,
             "the world is the frame of the first marker");

  function(m, "marker_view", &simulate::marker_view,
           "The camera's image of the markers; where sheets overlap in the image the first one\n"
           "shows. Raises ValueError for a size that is not positive, an id that the\n"
           "codes lack, or options out of range.",
           py::arg("camera"), py::arg("camera_from_world"), py::arg("markers"), py::arg("codes"),
           py::arg_v("options", simulate::MarkerViewOptions{}, "MarkerViewOptions()"));
  function(m, "hang_markers", &simulate::hang_markers,
           "Four markers (ids 3, 7, 11, 20 of apriltag_36h11; sides of a tenth of the camera's\n"
           "distance and less) on the wall of the world, round the point that the camera's axis\n"
           "meets, each turned a little in its plane. Raises ValueError when the\n"
           "camera does not face the wall.",
           py::arg("world"));
}

void bind_preview(py::module_& m) {
  Record<simulate::PreviewOptions> preview_options(m, "PreviewOptions",
                                                   "Size and point of view of preview().");
  preview_options.fields_init()
      .field("ambient", &simulate::PreviewOptions::ambient,
             "The room's own light, over the light of full projection that is shown as white. 0:\n"
             "the room's as it is.")
      .field("threads", &simulate::PreviewOptions::threads,
             "0: as many as the machine has. The result does not depend on it");

  function(m, "preview", &simulate::preview,
           "The eye's picture, RGB, sRGB. Of each light the first frame is shown. Raises\n"
           "ValueError as room_view().",
           py::arg("room"), py::arg("lights"), py::arg("eye"), py::arg("room_from_eye"),
           py::arg_v("options", simulate::PreviewOptions{}, "PreviewOptions()"));
  function(
      m, Gil::kHeld, "room_of", [](const HeldScene& scene) { return simulate::room_of(scene_of(scene)); },
      "The scene's surfaces as matt white bodies, in the scene's frame, named by their\n"
      "places \"0\", \"1\", ...: a plane's content area, a mesh's triangles, less where the\n"
      "item's mask is below one half. Round every plane a backdrop of a fifth of its size\n"
      "on each side: most are part of a wall. Contents are not looked at; pixel surfaces\n"
      "have no place in the room.",
      py::arg("scene"));
}

}  // namespace

void bind_simulate_room(py::module_& m) {
  bind_shapes(m);
  bind_bodies(m);
  bind_drive(m);
  bind_motion(m);
  bind_room_light(m);
  bind_room_view(m);
  bind_depth_view(m);
  bind_fleet(m);
  bind_scan_view(m);
  bind_marker_view(m);
  bind_preview(m);
}

}  // namespace procam::python
