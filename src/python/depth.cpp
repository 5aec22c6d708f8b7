// procam.depth
#include "procam/depth.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_depth_noise(py::module_& m) {
  Record<depth::DepthNoise> depth_noise(
      m, "DepthNoise",
      "Standard deviation of one reading at depth z: sigma(z) = a + b z + c z^2, metres,\n"
      "never below a tenth of a millimetre.\n"
      "\n"
      "Averaging does not improve all of it: neighbouring pixels share an error (quantised\n"
      "disparities form bands, lens models are off). The error of the mean of a patch,\n"
      "independent of its size, is\n"
      "\n"
      "  correlated_sigma(z)^2 = (correlated_share sigma(z))^2 + correlated_floor^2");
  depth_noise.fields_init()
      .field("a", &depth::DepthNoise::a, "metres")
      .field("b", &depth::DepthNoise::b, "without unit")
      .field("c", &depth::DepthNoise::c, "1/metre")
      .field("correlated_share", &depth::DepthNoise::correlated_share,
             "share of the noise that neighbours have in common, 0 .. 1")
      .field("correlated_floor", &depth::DepthNoise::correlated_floor, "metres")
      .method("sigma", &depth::DepthNoise::sigma,
              "Standard deviation at depth z (metres) of one pixel, metres.", py::arg("z"))
      .method("correlated_sigma", &depth::DepthNoise::correlated_sigma,
              "The part of it that neighbouring pixels have in common, metres.", py::arg("z"))
      .static_method("kinect_v1", &depth::DepthNoise::kinect_v1,
                     "Structured light of the first Kinect: disparities of sigma 1/2 unit make 1.425e-3\n"
                     "z^2 (K. Khoshelham, S. O. Elberink, \"Accuracy and resolution of Kinect depth data\n"
                     "for indoor mapping applications\", Sensors 12, 2012, equation 11), with what remains\n"
                     "near the camera by C. V. Nguyen, S. Izadi, D. Lovell, \"Modeling Kinect sensor\n"
                     "noise\", 3DIMPVT 2012, whose 0.0012 + 0.0019 (z - 0.4)^2 this is, multiplied out.")
      .static_method(
          "scan", &depth::DepthNoise::scan,
          "Depths of scan-surfaces, Gray code or phase shift of a megapixel projector, as simulated at\n"
          "level paper: between edges of stripes they are interpolated, so that neighbours vary less\n"
          "(0.2 mm at 1.3 m) than what they share.")
      .static_method("time_of_flight", &depth::DepthNoise::time_of_flight,
                     "Time of flight, facing the camera (P. Fankhauser et al., \"Kinect v2 for mobile robot\n"
                     "navigation: evaluation and modeling\", ICAR 2015).")
      .static_method("stereo", &depth::DepthNoise::stereo,
                     "Any stereo pair: sigma = z^2 disparity_sigma / (focal_px baseline).",
                     py::arg("focal_px"), py::arg("baseline"), py::arg("disparity_sigma_px"));
}

void bind_depth_image(py::module_& m) {
  Record<depth::DepthImage> depth_image(m, "DepthImage",
                                        "A depth image, looked at in place: 16-bit units or float metres.");
  depth_image.type.def(py::init([](const py::array& pixels, double metres_per_unit) {
                         const py::array& array = pixels;
                         const Where where{"DepthImage", "pixels"};
                         if (!is_image_in_place(array))
                           refuse_type(where, "array of shape (h, w), each row without gaps", array);
                         if (py::isinstance<py::array_t<float, 0>>(array))
                           return depth::DepthImage(Loader<ViewF>::from(array, where));
                         return depth::DepthImage(Loader<ImageView<const std::uint16_t>>::from(array, where),
                                                  metres_per_unit);
                       }),
                       "float32 metres or uint16 units, (h, w), looked at in place: rows must be without\n"
                       "gaps.",
                       py::arg("pixels"), py::arg("metres_per_unit") = 0.001, py::keep_alive<1, 2>());
  depth_image.method("size", &depth::DepthImage::size, "Width and height, pixels.")
      .method(
          "at",
          [](const depth::DepthImage& self, int x, int y) {
            require_pixel(self.size(), x, y, "DepthImage.at");
            return self.at(x, y);
          },
          "Metres; 0 where nothing was measured.", py::arg("x"), py::arg("y"));
}

void bind_ray_table(py::module_& m) {
  Record<depth::RayTable> ray_table(m, "RayTable", "The rays of a camera's pixels, made once for a camera.");
  Record<depth::RayTable::CellRays> cell_rays(ray_table.type, "CellRays",
                                              "A cell's pixels about its middle.");
  cell_rays.field("u", &depth::RayTable::CellRays::u, "of the middle")
      .field("v", &depth::RayTable::CellRays::v, "of the middle")
      .field("whole", &depth::RayTable::CellRays::whole, "");
  ray_table.init([](const Camera& camera) { return depth::RayTable(camera); }, "", py::arg("camera"))
      .method("camera", &depth::RayTable::camera, "The camera that the rays belong to, a copy.")
      .method("size", &depth::RayTable::size, "Width and height, pixels.")
      .method("columns", &depth::RayTable::columns, "Cells; those at the right edge may be cut.")
      .method("rows", &depth::RayTable::rows, "Cells; those at the lower edge may be cut.")
      .method(
          "u",
          [](const depth::RayTable& self, int x, int y) {
            require_pixel(self.size(), x, y, "RayTable.u");
            return self.u(x, y);
          },
          "x / z of a pixel's ray.", py::arg("x"), py::arg("y"))
      .method(
          "v",
          [](const depth::RayTable& self, int x, int y) {
            require_pixel(self.size(), x, y, "RayTable.v");
            return self.v(x, y);
          },
          "y / z of a pixel's ray.", py::arg("x"), py::arg("y"))
      .method(
          "cell",
          [](const depth::RayTable& self, int column, int row) {
            require_pixel({self.columns(), self.rows()}, column, row, "RayTable.cell");
            return self.cell(column, row);
          },
          "The rays of one cell of the table.", py::arg("column"), py::arg("row"))
      .method("is_pinhole", &depth::RayTable::is_pinhole, "Is the lens without distortion?")
      .method("pixel_of", &depth::RayTable::pixel_of, "The pixel of a ray, through the lens.", py::arg("u"),
              py::arg("v"));
}

void bind_plane_types(py::module_& m) {
  Record<depth::PlaneEstimate> plane_estimate(
      m, "PlaneEstimate",
      "A plane and the covariance of (normal, offset). It has rank 3, nothing along the\n"
      "normal: two directions of the normal (radians) and the offset (metres).");
  plane_estimate.fields_init()
      .field("plane", &depth::PlaneEstimate::plane, "")
      .field("covariance", &depth::PlaneEstimate::covariance,
             "of normal (three numbers) and offset (metres)");

  Record<depth::PlaneOptions> plane_options(m, "PlaneOptions", "Which planes find_planes() keeps.");
  plane_options.fields_init()
      .field("noise", &depth::PlaneOptions::noise, "")
      .field("nearest", &depth::PlaneOptions::nearest, "readings outside are ignored, metres")
      .field("farthest", &depth::PlaneOptions::farthest, "readings outside are ignored, metres")
      .field("min_area", &depth::PlaneOptions::min_area,
             "square metres; what is smaller is no surface to project on")
      .field("min_cells", &depth::PlaneOptions::min_cells,
             "of 8 x 8 pixels: fewer do not determine the normal")
      .field("curvature_threshold", &depth::PlaneOptions::curvature_threshold,
             "RMS of a region's second-order residual, in sigmas of what readings share\n"
             "(DepthNoise), from which it may be curved: it is where a cylinder or sphere that\n"
             "turns by 12 degrees or more explains it better. Three times as much is curved in any\n"
             "case. Lower finds flatter curves, and then takes the depth camera's own distortion\n"
             "for one.");

  Record<depth::DetectedPlane> detected_plane(m, "DetectedPlane",
                                              "One plane of a depth image, with covariance and pixels.");
  detected_plane.fields_init()
      .field("estimate", &depth::DetectedPlane::estimate,
             "camera frame, the normal towards the camera (offset > 0)")
      .field("pixels", &depth::DetectedPlane::pixels, "that bear its label")
      .field("area", &depth::DetectedPlane::area, "square metres that these cover")
      .field("rms", &depth::DetectedPlane::rms, "of the readings, perpendicular to the plane, metres")
      .field("noise_rms", &depth::DetectedPlane::noise_rms,
             "The part of `rms` that the sensor's noise explains: as predicted by the model, or as\n"
             "measured where the readings vary more than it predicts (Planes::noise_ratio).")
      .field("noise_factor", &depth::DetectedPlane::noise_factor,
             "Variance found over variance assumed, already part of the covariance. Far above 1:\n"
             "the surface is not flat, or its readings share errors.")
      .field("middle", &depth::DetectedPlane::middle, "of its pixels, on the plane");

  Record<depth::DetectedCurve> detected_curve(
      m, "DetectedCurve",
      "A part of a cylinder or of a sphere, in the camera's frame; `frame` of the surface\n"
      "is left at its default.");
  detected_curve.fields_init()
      .field("shape", &depth::DetectedCurve::shape, "")
      .field("pixels", &depth::DetectedCurve::pixels, "")
      .field("rms", &depth::DetectedCurve::rms, "of cells of pixels, perpendicular, metres");
}

void bind_planes(py::module_& m) {
  Record<depth::Planes> planes(m, "Planes", "The planes of a depth image, and which pixel belongs to which.");
  planes.fields_init()
      .field("planes", &depth::Planes::planes, "the largest in pixels first")
      .field("curves", &depth::Planes::curves, "")
      .field("labels", &depth::Planes::labels,
             "Places in `planes`, then planes.size() + places in `curves`; kCurved: curved, but no\n"
             "simple shape fits; kNone: no surface; kNothing: no reading.")
      .field("noise_ratio", &depth::Planes::noise_ratio,
             "Measured noise over that of PlaneOptions::noise: the residual RMS of cells of 8 x 8\n"
             "pixels about their own planes, in sigmas, at the lower quartile over the image\n"
             "(scaled to 1 for white noise), so that edges and clutter do not count. 0.6 to 1.1\n"
             "when the model suits the sensor: quantised readings vary less within a cell. Above\n"
             "1.2 the planes were found with the measured noise. 0: not enough readings.");

  function(m, "squared_sigmas", &depth::squared_sigmas,
           "How far `truth` is from the estimate: e^T C^-1 e over the three directions,\n"
           "chi-square with 3 degrees of freedom when the covariance is right (7.81 bounds 95\n"
           "%).",
           py::arg("estimate"), py::arg("truth"));
  function(m, "find_planes", &depth::find_planes,
           "Raises ValueError for an image that is not of the camera's size or\n"
           "options out of range. An image without a reading has no planes.",
           py::arg("image"), py::arg("rays"), py::arg_v("options", depth::PlaneOptions{}, "PlaneOptions()"));
  function(m, "noise_ratio", &depth::noise_ratio,
           "Planes::noise_ratio of the image for another noise model: which kind of sensor took\n"
           "it.",
           py::arg("image"), py::arg("rays"), py::arg("noise"));
}

void bind_plane_areas(py::module_& m) {
  Record<depth::PlaneRaster> plane_raster(
      m, "PlaneRaster",
      "A raster over a plane, in its frame: cell (i, j) covers `low` + `cell` * [i, i+1] x\n"
      "[j, j+1], metres.");
  plane_raster.fields_init()
      .field("low", &depth::PlaneRaster::low, "the corner with the smaller x and y, metres")
      .field("cell", &depth::PlaneRaster::cell, "side of a cell, metres")
      .field("free", &depth::PlaneRaster::free, "1: the plane is seen there")
      .method("corner", &depth::PlaneRaster::corner,
              "The corner (2,) of cell (i, j) with the smaller x and y, metres on the plane.", py::arg("i"),
              py::arg("j"));

  Record<depth::FreeRectangle> free_rectangle(m, "FreeRectangle",
                                              "A rectangle on a plane in which nothing is in the way.");
  free_rectangle.fields_init()
      .field("low", &depth::FreeRectangle::low, "metres in the plane's frame")
      .field("high", &depth::FreeRectangle::high, "metres in the plane's frame")
      .method("size", &depth::FreeRectangle::size, "Width and height (2,), metres.")
      .method("area", &depth::FreeRectangle::area, "Square metres.");

  Record<depth::PlaneOutline> plane_outline(
      m, "PlaneOutline", "One connected part: clockwise as seen by the reader, holes the other way round.");
  plane_outline.fields_init()
      .field("outer", &depth::PlaneOutline::outer, "corners on the plane, metres")
      .field("holes", &depth::PlaneOutline::holes, "corners on the plane, metres");

  Record<depth::AreaOptions> area_options(m, "AreaOptions", "How areas of planes are outlined.");
  area_options.fields_init()
      .field("cell", &depth::AreaOptions::cell,
             "metres; made larger where a plane would have more than 2^18 cells")
      .field("margin", &depth::AreaOptions::margin, "metres that the rectangle stays away from everything")
      .field("min_side", &depth::AreaOptions::min_side,
             "metres; rectangles that are narrower hold no content")
      .field("min_part", &depth::AreaOptions::min_part,
             "square metres: smaller parts and holes are not part of the outline");

  Record<depth::PlaneArea> plane_area(
      m, "PlaneArea", "The area of a plane that was seen: outline, holes, largest rectangle; metres.");
  plane_area.fields_init()
      .field("camera_from_plane", &depth::PlaneArea::camera_from_plane, "")
      .field("raster", &depth::PlaneArea::raster, "")
      .field("area", &depth::PlaneArea::area, "square metres, of the free cells")
      .field("outlines", &depth::PlaneArea::outlines, "")
      .field("rectangle", &depth::PlaneArea::rectangle, "None where none is large enough");

  function(m, "area_of", &depth::area_of,
           "Of the plane's labels as the camera sees them. Single pixels without a label do not\n"
           "make holes.",
           py::arg("planes"), py::arg("plane"), py::arg("rays"), py::arg("up"),
           py::arg_v("options", depth::AreaOptions{}, "AreaOptions()"));
  function(m, "largest_rectangle", &depth::largest_rectangle,
           "The largest rectangle of free cells, by the largest rectangle under the histogram\n"
           "that ends in each row (a stack, time linear in the cells: D. Vandevoorde, \"The\n"
           "maximal rectangle problem\", Dr. Dobb's, 1998). Of those with both sides `min_side`\n"
           "long or longer; `margin` is taken off each side after.",
           py::arg("raster"), py::arg("min_side") = 0, py::arg("margin") = 0);
  function(m, "outlines_of", &depth::outlines_of,
           "Borders of the free cells, straightened by Douglas and Peucker's rule to one and a\n"
           "half cells.",
           py::arg("raster"), py::arg("min_part"));
}

void bind_main_planes(py::module_& m) {
  Record<depth::MainPlaneOptions> main_plane_options(m, "MainPlaneOptions",
                                                     "How the floor and the walls are chosen.");
  main_plane_options.fields_init()
      .field("band_floor", &depth::MainPlaneOptions::band_floor,
             "metres: half of the steps that one plane may have, near the camera")
      .field("band_square", &depth::MainPlaneOptions::band_square, "per metre, times z^2")
      .field("farthest", &depth::MainPlaneOptions::farthest, "metres: beyond, the band holds anything")
      .field("min_share", &depth::MainPlaneOptions::min_share,
             "Of the readings: a main plane has at least so many. Where the parts are smaller,\n"
             "bands find planes in any clutter.");

  Record<depth::MainPlanes> main_planes(m, "MainPlanes", "Floor, ceiling and walls.");
  main_planes.fields_init()
      .field("planes", &depth::MainPlanes::planes,
             "As find_planes() returns them, main planes in the place of what they are made of. A\n"
             "fine plane stays where no main plane took more than half of its pixels.")
      .field("members", &depth::MainPlanes::members,
             "What each of `planes.planes` is made of: places in the fine result's planes, then\n"
             "its planes.size() + places in its curves, of which a quarter or more lies in the\n"
             "band. A plane that stayed: itself.");

  function(m, "main_planes", &depth::main_planes,
           "`fine` is of the same image and camera. Takes ten milliseconds or more: it is no\n"
           "part of find_planes(). Raises ValueError where sizes differ or options\n"
           "are out of range.",
           py::arg("fine"), py::arg("image"), py::arg("rays"),
           py::arg_v("options", depth::MainPlaneOptions{}, "MainPlaneOptions()"));
}

void bind_plane_kinds(py::module_& m) {
  Enum<depth::PlaneKind>(m, "PlaneKind", "What a plane is by its direction and height.")
      .value("kUnknown", depth::PlaneKind::kUnknown)
      .value("kWall", depth::PlaneKind::kWall)
      .value("kFloor", depth::PlaneKind::kFloor)
      .value("kCeiling", depth::PlaneKind::kCeiling)
      .value("kTable", depth::PlaneKind::kTable)
      .value("kSlope", depth::PlaneKind::kSlope);

  Enum<depth::PlaneState>(
      m, "PlaneState",
      "What a plane is good for. Beyond 20 mm of RMS a warning is due: where projector and\n"
      "camera look at a surface under 45 degrees to each other, light lands as far from its\n"
      "place as the surface is from its plane.")
      .value("kFree", depth::PlaneState::kFree, "it has a free rectangle")
      .value("kUneven", depth::PlaneState::kUneven,
             "likewise, but its RMS is above 20 mm, and more than twice what the noise explains")
      .value("kNoisy", depth::PlaneState::kNoisy,
             "likewise, but its RMS is above 20 mm because of the noise: unevenness cannot be seen")
      .value("kNoFreeRectangle", depth::PlaneState::kNoFreeRectangle,
             "narrower than AreaOptions::min_side, or covered: no surface");

  function(m, "to_string", py::overload_cast<depth::PlaneKind>(&depth::to_string),
           "\"plane\", \"wall\", \"floor\", \"ceiling\", \"table\", \"slope\".", py::arg("kind"));
  function(m, "to_string", py::overload_cast<depth::PlaneState>(&depth::to_string),
           "\"free\", \"uneven\", \"noisy\", \"no_free_rectangle\".", py::arg("state"));
}

void bind_room_surfaces(py::module_& m) {
  Record<depth::CornerLine> corner_line(m, "CornerLine",
                                        "Where two planes meet, as far as both are seen there.");
  corner_line.fields_init()
      .field("first", &depth::CornerLine::first, "places in Planes::planes")
      .field("second", &depth::CornerLine::second, "places in Planes::planes")
      .field("from_", &depth::CornerLine::from, "camera frame")
      .field("to", &depth::CornerLine::to, "camera frame")
      .field("angle", &depth::CornerLine::angle,
             "between the two seen sides, radians: pi/2 in a room's corner, 3 pi/2 on a box's edge");

  Record<depth::SurfaceOptions> surface_options(m, "SurfaceOptions", "Which areas become surfaces.");
  surface_options.fields_init()
      .field("up_in_camera", &depth::SurfaceOptions::up_in_camera,
             "The camera's up: minus gravity. Without it nothing is called wall or floor, and the\n"
             "camera counts as level.")
      .field("frame", &depth::SurfaceOptions::frame,
             "\"world\", \"rig\" or \"projector\": the frame of the surfaces")
      .field("frame_from_camera", &depth::SurfaceOptions::frame_from_camera, "")
      .field("area", &depth::SurfaceOptions::area, "");

  Record<depth::SurfaceArea> surface_area(m, "SurfaceArea", "An area that becomes a surface.");
  surface_area.fields_init()
      .field("name", &depth::SurfaceArea::name, "as in the set")
      .field("kind", &depth::SurfaceArea::kind, "")
      .field("plane", &depth::SurfaceArea::plane, "place in Planes::planes")
      .field("area", &depth::SurfaceArea::area, "");

  Record<depth::RoomSurfaces> room_surfaces(m, "RoomSurfaces", "Surfaces of a room, by a depth image.");
  room_surfaces.fields_init()
      .field("set", &depth::RoomSurfaces::set,
             "Planes by their free rectangle, content (0, 0) .. (1, 1) on it, read upright; then\n"
             "curves.")
      .field("areas", &depth::RoomSurfaces::areas, "of the planes in the set, in its order")
      .field("kinds", &depth::RoomSurfaces::kinds, "of every plane")
      .field("states", &depth::RoomSurfaces::states, "of every plane")
      .field("corners", &depth::RoomSurfaces::corners, "");

  function(m, "surfaces_from_planes", &depth::surfaces_from_planes,
           "Names count from the camera's left to its right: wall_1, wall_2, table_1, floor;\n"
           "column_1 and ball_1 are curves seen from outside, niche_1 and dome_1 from inside.",
           py::arg("planes"), py::arg("image"), py::arg("rays"),
           py::arg_v("options", depth::SurfaceOptions{}, "SurfaceOptions()"));
}

void bind_plane_map(py::module_& m) {
  Record<depth::PlaneMapOptions> plane_map_options(m, "PlaneMapOptions",
                                                   "When planes are added to a map, moved and dropped.");
  plane_map_options.fields_init()
      .field("up_in_world", &depth::PlaneMapOptions::up_in_world, "unit vector")
      .field("noise", &depth::PlaneMapOptions::noise, "as for find_planes()")
      .field("min_observations", &depth::PlaneMapOptions::min_observations,
             "A plane gets its name after this many frames, and only where it was free for about a\n"
             "third of `free_space_tau`: a person's back is no surface.")
      .field("max_corner_sigma", &depth::PlaneMapOptions::max_corner_sigma,
             "Metres. Largest sigma of the content's corners along the normal for a plane to get\n"
             "its name; after ten times `min_observations` frames it gets it anyway. Less certain\n"
             "content would move.")
      .field("free_space_tau", &depth::PlaneMapOptions::free_space_tau,
             "seconds in which a cell's free share follows by 63 %")
      .field("process_noise", &depth::PlaneMapOptions::process_noise,
             "metres and radians a square root second that a plane may be off more")
      .field("largest_angle", &depth::PlaneMapOptions::largest_angle,
             "between detection and map, beside three sigmas")
      .field("largest_gap", &depth::PlaneMapOptions::largest_gap, "metres, likewise")
      .field("cell", &depth::PlaneMapOptions::cell, "metres, of the rasters")
      .field("margin", &depth::PlaneMapOptions::margin, "metres, as in AreaOptions")
      .field("min_side", &depth::PlaneMapOptions::min_side, "metres, as in AreaOptions");

  Record<depth::MapPlane> map_plane(m, "MapPlane", "One plane of the map, with covariance and age.");
  map_plane.fields_init()
      .field("name", &depth::MapPlane::name, "empty until it is believed; then it never changes")
      .field("kind", &depth::MapPlane::kind, "")
      .field("in_world", &depth::MapPlane::in_world, "")
      .field("world_from_plane", &depth::MapPlane::world_from_plane,
             "upright as first read; follows the estimate, turns no more than it must")
      .field("raster", &depth::MapPlane::raster, "free: 1 where content may be")
      .field("free_share", &depth::MapPlane::free_share, "of each cell, 0..1; negative: never seen")
      .field("home", &depth::MapPlane::home, "the content's first place")
      .field("content", &depth::MapPlane::content, "what of it is free now")
      .field("seen", &depth::MapPlane::seen, "frames")
      .field("last_seen", &depth::MapPlane::last_seen, "seconds");

  Record<depth::PlaneMap> plane_map(m, "PlaneMap", "Planes that many depth images have in common.");
  plane_map
      .init([](const depth::PlaneMapOptions& options) { return depth::PlaneMap(options); },
            "Raises ValueError for options out of range.",
            py::arg_v("options", depth::PlaneMapOptions{}, "PlaneMapOptions()"))
      .method("update", &depth::PlaneMap::update,
              "One frame at `time`, seconds, which must not go back. Raises ValueError\n"
              "for images of another size than the camera's or a pose that is not finite.",
              py::arg("planes"), py::arg("image"), py::arg("rays"), py::arg("world_from_camera"),
              py::arg("time"))
      .method("planes", &depth::PlaneMap::planes, "The planes of the map, copies.")
      .method("surfaces", &depth::PlaneMap::surfaces,
              "Of all named planes with content, in the frame \"world\".")
      .method("replan", &depth::PlaneMap::replan,
              "Content may move: each plane's home becomes the largest rectangle that is free now.");
}

void bind_sensor_check(py::module_& m) {
  Record<depth::SensorKind> sensor_kind(m, "SensorKind", "A kind of sensor by its noise.");
  sensor_kind.fields_init()
      .field("name", &depth::SensorKind::name,
             "\"kinect-v1\" (structured light, stereo), \"tof\" (time of flight), \"scan\" (scan-surfaces)")
      .field("noise", &depth::SensorKind::noise, "");

  Record<depth::SensorCheck> sensor_check(
      m, "SensorCheck",
      "The noise of the image against the model of a sensor, and against the other sensors'\n"
      "where it does not fit.");
  sensor_check.fields_init()
      .field("ratio", &depth::SensorCheck::ratio, "measured over predicted")
      .field("fault", &depth::SensorCheck::fault, "empty where the model fits")
      .field("next", &depth::SensorCheck::next, "");

  function(m, "sensor_kinds", &depth::sensor_kinds, "Known depth sensors and their noise.");
  function(m, "sensor_kind", &depth::sensor_kind, "Raises Error(kInput) for an unknown name.",
           py::arg("name"));
  function(m, "median_depth", &depth::median_depth, "The median of the readings, metres; 0 without readings.",
           py::arg("image"));
  function(m, "check_sensor", &depth::check_sensor, "`planes` were found with the sensor's noise.",
           py::arg("planes"), py::arg("image"), py::arg("rays"), py::arg("sensor"));
  function(m, "check_intrinsics", &depth::check_intrinsics,
           "Warning \"principal_point\": it lies outside the central half of the image, so that\n"
           "the intrinsics are those of another stream (the colour camera's) or of another\n"
           "resolution.",
           py::arg("depth_camera"));
  function(m, "flatness", &depth::flatness,
           "Warnings for surfaces that are less flat than is usual: surface_uneven,\n"
           "surface_noisy.",
           py::arg("planes"), py::arg("room"));
}

void bind_room_depth(py::module_& m) {
  Record<depth::RoomDepthOptions> room_depth_options(m, "RoomDepthOptions",
                                                     "How room_depth() fills and smooths.");
  room_depth_options.fields_init()
      .field("within", &depth::RoomDepthOptions::within,
             "metres along the axis between a reading and the plane that it lies on")
      .field("min_wall", &depth::RoomDepthOptions::min_wall, "square metres seen of a wall or slope")
      .field("min_level", &depth::RoomDepthOptions::min_level, "of floor, ceiling or a table")
      .field("rim", &depth::RoomDepthOptions::rim, "metres, about, around what was seen of a plane");

  function(m, "room_depth", &depth::room_depth,
           "Metres along the optical axis; 0: nothing is known there. Exact within a plane, to 4\n"
           "pixels where planes end. Raises ValueError for an image that is not of\n"
           "the camera's size or options out of range.",
           py::arg("map"), py::arg("image"), py::arg("rays"), py::arg("world_from_camera"),
           py::arg_v("options", depth::RoomDepthOptions{}, "RoomDepthOptions()"));
}

}  // namespace

void bind_depth(py::module_& m) {
  bind_depth_noise(m);
  bind_depth_image(m);
  bind_ray_table(m);
  bind_plane_types(m);
  bind_planes(m);
  bind_plane_areas(m);
  bind_main_planes(m);
  bind_plane_kinds(m);
  bind_room_surfaces(m);
  bind_plane_map(m);
  bind_sensor_check(m);
  bind_room_depth(m);
}

}  // namespace procam::python
