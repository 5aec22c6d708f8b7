// procam.depth: the height of a bed of sand
#include "procam/depth.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_reference_plane(py::module_& m) {
  Record<depth::PixelRegion> pixel_region(m, "PixelRegion", "A rectangle of a depth camera's pixels.");
  pixel_region.fields_init()
      .field("x", &depth::PixelRegion::x, "")
      .field("y", &depth::PixelRegion::y, "")
      .field("width", &depth::PixelRegion::width, "")
      .field("height", &depth::PixelRegion::height, "");

  Record<depth::ReferencePlane> reference_plane(m, "ReferencePlane", "Where heights are counted from.");
  reference_plane.fields_init()
      .field("camera_from_reference", &depth::ReferencePlane::camera_from_reference, "")
      .field("size", &depth::ReferencePlane::size, "metres");

  function(m, "fit_reference_plane", &depth::fit_reference_plane,
           "The plane that fits the readings of a region best, and on it the largest upright\n"
           "rectangle whose corners the region sees. Raises Error(kInput), Error(kNotEnoughData)\n"
           "and Error(kDegenerate).",
           py::arg("image"), py::arg("rays"), py::arg("region") = std::nullopt);
}

void bind_height_map(py::module_& m) {
  Record<depth::HeightFieldOptions> height_field_options(m, "HeightFieldOptions",
                                                         "Cells, noise and memory of a height field.");
  height_field_options.fields_init()
      .field("noise", &depth::HeightFieldOptions::noise, "")
      .field("cell", &depth::HeightFieldOptions::cell, "metres, the side of a cell")
      .field("acceleration", &depth::HeightFieldOptions::acceleration, "spectral density q, m^2/s^3")
      .field("max_height", &depth::HeightFieldOptions::max_height,
             "metres; what is higher is no part of the surface")
      .field("max_jump", &depth::HeightFieldOptions::max_jump, "metres from one image to the next")
      .field("settle_after", &depth::HeightFieldOptions::settle_after, "seconds")
      .field("margin", &depth::HeightFieldOptions::margin, "metres around what covers the surface")
      .field("max_sigma", &depth::HeightFieldOptions::max_sigma,
             "metres; a cell that is less certain is a hole")
      .field("max_gap", &depth::HeightFieldOptions::max_gap,
             "metres; narrower holes without readings are bridged");

  Record<depth::HeightMap> height_map(m, "HeightMap",
                                      "Heights at a moment, row by row, at the middles of the cells.");
  height_map.fields_init()
      .field("cell", &depth::HeightMap::cell, "metres")
      .field("height", &depth::HeightMap::height, "metres; 0 in a hole")
      .field("sigma", &depth::HeightMap::sigma, "standard deviation, metres; 0 in a hole")
      .method(
          "is_known",
          [](const depth::HeightMap& self, int column, int row) {
            require_pixel(self.sigma.size(), column, row, "HeightMap.is_known");
            return self.is_known(column, row);
          },
          "Is the height of this cell known?", py::arg("column"), py::arg("row"));

  function(m, "mesh_of", &depth::mesh_of,
           "Triangles between the middles of cells, in the reference frame; without a triangle\n"
           "where a corner is a hole.",
           py::arg("map"));
}

void bind_height_field(py::module_& m) {
  Record<depth::HeightField> height_field(
      m, "HeightField",
      "A surface that moves and deforms before a depth camera, as heights over a reference\n"
      "plane: a Kalman filter of height and rate for every cell.");
  height_field
      .init([](const Vec2& size,
               const depth::HeightFieldOptions& options) { return depth::HeightField(size, options); },
            "Raises ValueError for a size under two cells or above 1000 a side, and for\n"
            "options out of range.",
            py::arg("size"), py::arg_v("options", depth::HeightFieldOptions{}, "HeightFieldOptions()"))
      .method("columns", &depth::HeightField::columns, "Number of columns of cells.")
      .method("rows", &depth::HeightField::rows, "Number of rows of cells.")
      .method("size", &depth::HeightField::size, "metres")
      .method("update", &depth::HeightField::update,
              "One image, exposed at `time` (seconds); images that are older than the last are\n"
              "omitted. Raises ValueError for another size than the rays' and a pose or time\n"
              "that is not finite.",
              py::arg("image"), py::arg("rays"), py::arg("reference_from_camera"), py::arg("time"))
      .method("at", &depth::HeightField::at,
              "The surface at a time, at most 0.2 s after the last image: later times are that one.",
              py::arg("time"))
      .method(
          "is_covered",
          [](const depth::HeightField& self, int column, int row) {
            require_pixel({self.columns(), self.rows()}, column, row, "HeightField.is_covered");
            return self.is_covered(column, row);
          },
          "Is something before the surface there, in the last image?", py::arg("column"), py::arg("row"))
      .method("background", &depth::HeightField::background,
              "Depth along the optical axis that the camera would see were nobody there, metres; 0 in\n"
              "holes that nothing was ever seen in.",
              py::arg("image"), py::arg("rays"), py::arg("reference_from_camera"));
}

void bind_height_picture(py::module_& m) {
  Record<depth::HeightColours> height_colours(m, "HeightColours",
                                              "Colours of heights, and contour lines; metres.");
  height_colours.fields_init()
      .field("lowest", &depth::HeightColours::lowest, "metres")
      .field("highest", &depth::HeightColours::highest, "metres")
      .field("contours", &depth::HeightColours::contours, "metres between two lines; 0: none")
      .field("line_width", &depth::HeightColours::line_width, "metres, along the reference plane");

  function(m, "colour_of", &depth::colour_of, "RGB of a height, limited to the range.", py::arg("height"),
           py::arg("colours"));
  function(
      m, "draw_heights",
      [](const depth::HeightMap& map, const depth::HeightColours& colours, ImageSize size) {
        ImageU8 picture(size, 3);
        depth::draw_heights(map, colours, picture.view());
        return picture;
      },
      "A picture of that size with the heights' colours; black in holes.", py::arg("map"), py::arg("colours"),
      py::arg("size"));
}

}  // namespace

void bind_depth_heights(py::module_& m) {
  bind_reference_plane(m);
  bind_height_map(m);
  bind_height_field(m);
  bind_height_picture(m);
}

}  // namespace procam::python
