// procam.pattern
#include "procam/pattern.hpp"

#include "bind.hpp"
#include "components.hpp"

namespace procam::python {

namespace {

void bind_board_light(py::module_& m) {
  Record<pattern::BoardLightOptions> board_light_options(m, "BoardLightOptions",
                                                         "How a projected board is read.");
  board_light_options.fields_init()
      .field("knot_pitches", &pattern::BoardLightOptions::knot_pitches,
             "distance of the spline's knots, in pitches of the board (pitch_of)")
      .field("border_px", &pattern::BoardLightOptions::border_px,
             "Edges nearer than this to a printed border are rejected, camera pixels; half of it\n"
             "on the light side of boards with markers, which leave little clear paper.");

  function(m, "readable_area", &pattern::readable_area,
           "Where project_board() looks for stripe edges: 1 at the camera pixels on the board\n"
           "from which an edge clear of printed borders may begin, 0 elsewhere. As\n"
           "StripeEdgeOptions::area it saves the edges that would be dropped. All zero if\n"
           "`in_camera` holds fewer than four points.",
           py::arg("in_camera"), py::arg("board"), py::arg("artwork"),
           py::arg_v("options", pattern::BoardLightOptions{}, "BoardLightOptions()"));
  function(m, "project_board",
           py::overload_cast<const Detections&, const Board&, const BoardArtwork&, const DecodedMap&,
                             const std::vector<StripeEdge>&, const pattern::BoardLightOptions&>(
               &pattern::project_board),
           "The projector pixels of the board's points, as if the projector had seen the board:\n"
           "image_size is the projector's, point indices those of `in_camera`. The covariance is\n"
           "that of the map at the corner (from the scatter of whole stripes, since neighbouring\n"
           "edge points err together) plus the camera corner's own through the map's Jacobian.\n"
           "\n"
           "`artwork` is what is dark on the board (detect::board_artwork). A point gets no\n"
           "observation unless light with stripe edges of both axes surrounds it;\n"
           "\"corners_not_lit\" counts the rejected, \"board_not_lit\" means too little light on the\n"
           "board for any map. Raises ValueError if `in_camera` and `decoded` differ\n"
           "in size.",
           py::arg("in_camera"), py::arg("board"), py::arg("artwork"), py::arg("decoded"), py::arg("edges"),
           py::arg_v("options", pattern::BoardLightOptions{}, "BoardLightOptions()"));
  function(m, "project_board",
           py::overload_cast<const Detections&, const Board&, const BoardArtwork&, const LightMap&,
                             const pattern::BoardLightOptions&>(&pattern::project_board),
           "The same from a map that is known to a fraction of a pixel: every decoded pixel of\n"
           "the print counts as its own measurement with its own sigma, those of one wave in one\n"
           "square as erring together.",
           py::arg("in_camera"), py::arg("board"), py::arg("artwork"), py::arg("light"),
           py::arg_v("options", pattern::BoardLightOptions{}, "BoardLightOptions()"));
}

void bind_decoding(py::module_& m) {
  function(m, "light_map", py::overload_cast<const ImageF&, const ViewU8&, ImageSize>(&pattern::light_map),
           "`white`: the scene under the projector's full light, for the classes of brightness.\n"
           "\n"
           "Raises Error(kInput) when no pixel is decoded, when all values are between 0 and 1\n"
           "(shares of the frame), or when most are beyond the frame. Remarks: \"projector_size\"\n"
           "(a part is beyond the frame), \"map_mirrored\" (columns and rows are exchanged, or one\n"
           "of them runs backwards; a print cannot be seen so), \"zeros_undecoded\" and\n"
           "\"decoded_share\". Raises ValueError unless `pixels` has two channels and\n"
           "the size of `white`.",
           py::arg("pixels"), py::arg("white"), py::arg("projector_size"));
}

void bind_gray_code(py::module_& m) {
  Record<pattern::GrayCode> gray_code(m, "GrayCode",
                                      "What is shown: everything else follows from these two.");
  gray_code.fields_init()
      .field("projector_size", &pattern::GrayCode::projector_size, "")
      .field("step", &pattern::GrayCode::step, "");

  Record<pattern::DecodeOptions> decode_options(
      m, "DecodeOptions", "How a Gray code is read: which pixels are lit, and which bits are certain.");
  decode_options.fields_init()
      .field("min_contrast", &pattern::DecodeOptions::min_contrast,
             "White minus black, in grey levels, below which a pixel counts as unlit (shadow, or\n"
             "too dark to read).")
      .field("bit_sigmas", &pattern::DecodeOptions::bit_sigmas,
             "A bit is decided when pattern and inverse differ by this many standard deviations of\n"
             "their difference. Noise alone passes all of six fine bits in one pixel of a\n"
             "thousand, while an error on a stripe's edge costs one stripe; higher values leave\n"
             "gaps along the stripes' edges.");

  function(m, "frame_count", py::overload_cast<const pattern::GrayCode&>(&pattern::frame_count),
           "2 * (column bits + row bits) + 2.", py::arg("gray_code"));
  function(m, "frame_name", &pattern::frame_name, "For people, e.g. \"frame 21 (row bit 9, inverse)\".",
           py::arg("gray_code"), py::arg("index"));
  function(m, "frame", &pattern::frame,
           "The picture for the projector: 0 and 255, one channel, projector_size.", py::arg("gray_code"),
           py::arg("index"));
  function(m, "frames", py::overload_cast<const pattern::GrayCode&>(&pattern::frames),
           "All of them in order.", py::arg("gray_code"));
  function(m, "describe", py::overload_cast<const pattern::GrayCode&>(&pattern::describe),
           "\"42 frames for 1024x768 (columns 10 bits, rows 10 bits, white, black)\".", py::arg("gray_code"));
  function(m, "decode",
           py::overload_cast<const std::vector<ViewU8>&, const pattern::GrayCode&,
                             const pattern::DecodeOptions&, DecodedMap>(&pattern::decode),
           "Reads the stripe codes back: bit = pattern brighter than inverse. A coordinate is\n"
           "undecoded where the pixel is unlit, where one of its bits is undecided, or where the\n"
           "code lies beyond the projector.\n"
           "\n"
           "The noise is measured: pattern + inverse of every pair is the same light, so their\n"
           "differences are noise alone. Raises Error (kInput), naming the frame, if the\n"
           "number of captures, their sizes or channels are wrong, or if white is darker than\n"
           "black. Remarks (low contrast, saturation, wrong projector size, frames out of order)\n"
           "are in the result's diagnostics.\n"
           "\n"
           "`reuse` is an unused map whose memory is used again: fresh memory costs as much time\n"
           "as the decoding.",
           py::arg("captures"), py::arg("gray_code"),
           py::arg_v("options", pattern::DecodeOptions{}, "DecodeOptions()"),
           py::arg_v("reuse", DecodedMap{}, "DecodedMap()"));
}

void bind_pattern_sequence(py::module_& m) {
  Record<pattern::PhaseOptions> phase_options(
      m, "PhaseOptions", "How phases are read: which pixels are lit, and how phases become pixels.");
  phase_options.fields_init()
      .field("min_modulation", &pattern::PhaseOptions::min_modulation,
             "grey levels of B below which a pixel counts as unlit")
      .field("max_sigma_px", &pattern::PhaseOptions::max_sigma_px,
             "projector pixels; what is less certain is rejected")
      .field("wave_sigmas", &pattern::PhaseOptions::wave_sigmas,
             "A wave's number counts as known when the coarser estimate is certain to this many\n"
             "standard deviations: 1 in 15000 of the faintest pixels that pass is wrong by a wave.")
      .field("saturated", &pattern::PhaseOptions::saturated,
             "a pixel that reaches this grey in any step is rejected: its wave is cut off");

  function(m, "require_decodable", &pattern::require_decodable,
           "Raises Error(kInput), naming the frame or the bit, unless both axes can be decoded:\n"
           "both by Gray code whose bits are complete, or both by waves of three phases or more\n"
           "whose number is known over the whole frame.",
           py::arg("sequence"), py::arg("projector_size"));
  function(m, "is_gray_code", &pattern::is_gray_code,
           "Is it Gray code alone? Then gray_captures() serves; else decode().", py::arg("sequence"));
  function(m, "frames", py::overload_cast<const FrameSequence&, ImageSize>(&pattern::frames),
           "All of them in order, one channel; ignored frames are black.", py::arg("sequence"),
           py::arg("projector_size"));
  function(m, "describe", py::overload_cast<const FrameSequence&, ImageSize>(&pattern::describe),
           "\"30 frames for 1024x768 (12 Gray code, 18 phase, 2 other)\".", py::arg("sequence"),
           py::arg("projector_size"));
  function(m, "decode",
           py::overload_cast<const std::vector<ViewU8>&, const FrameSequence&, ImageSize,
                             const pattern::PhaseOptions&>(&pattern::decode),
           "The map of phases. The noise is measured: from eight or more equal steps by their\n"
           "highest harmonic, else from second differences of the phase between neighbouring\n"
           "pixels. Raises as gray_captures() does. Remarks: \"low_modulation\", \"saturated\", and\n"
           "those of the Gray code.",
           py::arg("captures"), py::arg("sequence"), py::arg("projector_size"),
           py::arg_v("options", pattern::PhaseOptions{}, "PhaseOptions()"));
  function(
      m, "flat_light",
      py::overload_cast<const std::vector<ViewU8>&, const FrameSequence&, ImageSize>(&pattern::flat_light),
      "The scene under flat light, for the board's corners: the mean of the waves, else\n"
      "white.",
      py::arg("captures"), py::arg("sequence"), py::arg("projector_size"));
}

void bind_phase_shift(py::module_& m) {
  Enum<pattern::WaveNumber>(m, "WaveNumber",
                            "What tells the number of the wave: coarser waves, or a Gray code.")
      .value("kCoarserWaves", pattern::WaveNumber::kCoarserWaves)
      .value("kGrayCode", pattern::WaveNumber::kGrayCode);

  Record<pattern::PhaseShift> phase_shift(m, "PhaseShift", "A pattern of cosine waves in steps of phase.");
  phase_shift.fields_init()
      .field("projector_size", &pattern::PhaseShift::projector_size, "")
      .field("period", &pattern::PhaseShift::period,
             "Finest wave in projector pixels, even. Short waves are more precise until blur or\n"
             "the camera's resolution takes their contrast: it should span five camera pixels or\n"
             "more.")
      .field("wave_number", &pattern::PhaseShift::wave_number, "");

  function(m, "sequence", &pattern::sequence,
           "The frames as a list, which is decoded by pattern/frame_sequence.hpp. Raises\n"
           "ValueError for a period that is odd, below 4, or longer than the frame,\n"
           "as do the functions below.",
           py::arg("phase_shift"));
  function(m, "frame_count", py::overload_cast<const pattern::PhaseShift&>(&pattern::frame_count),
           "Number of frames.", py::arg("phase_shift"));
  function(m, "frames", py::overload_cast<const pattern::PhaseShift&>(&pattern::frames),
           "One channel, projector_size.", py::arg("phase_shift"));
  function(m, "describe", py::overload_cast<const pattern::PhaseShift&>(&pattern::describe),
           "\"32 frames for 1024x768 (8 steps of 16 px waves, 4 steps each of 2 coarser waves)\".",
           py::arg("phase_shift"));
  function(
      m, "decode",
      py::overload_cast<const std::vector<ViewU8>&, const pattern::PhaseShift&, const pattern::PhaseOptions&>(
          &pattern::decode),
      "Reads the map back. The noise is measured: the fourth harmonic of the eight steps is\n"
      "noise alone. Raises Error (kInput) if the number of captures, their sizes or\n"
      "channels are wrong. Remarks: \"low_modulation\", \"saturated\", and those of the Gray\n"
      "code.",
      py::arg("captures"), py::arg("phase_shift"),
      py::arg_v("options", pattern::PhaseOptions{}, "PhaseOptions()"));
  function(m, "flat_light",
           py::overload_cast<const std::vector<ViewU8>&, const pattern::PhaseShift&>(&pattern::flat_light),
           "The captures' mean: the scene under flat light of half the power, for the board's\n"
           "corners.",
           py::arg("captures"), py::arg("phase_shift"));
}

void bind_projected_board(py::module_& m) {
  Record<pattern::ProjectedBoard> projected_board(
      m, "ProjectedBoard", "A board in the projector's frame, its lengths in projector pixels.");
  projected_board.fields_init()
      .field("projector_size", &pattern::ProjectedBoard::projector_size, "")
      .field("layout", &pattern::ProjectedBoard::layout, "every length in projector pixels")
      .field("artwork", &pattern::ProjectedBoard::artwork, "what is dark of it")
      .field("origin", &pattern::ProjectedBoard::origin, "the projector pixel of the layout's origin")
      .field("colour", &pattern::ProjectedBoard::colour, "")
      .field("upright", &pattern::ProjectedBoard::upright,
             "the frame appears upright in the images, within 90 degrees (equal counts: 45)");

  function(m, "projected_board", &pattern::projected_board,
           "In the middle of the picture. `artwork` is detect::board_artwork(layout). Raises\n"
           "Error(kInput) when half a pitch of light (a gap and a module at least round markers)\n"
           "does not fit round it, when it looks the same turned and is no upright chessboard,\n"
           "or when its edges do not fall between pixels.",
           py::arg("projector_size"), py::arg("layout"), py::arg("artwork"), py::arg("colour") = false,
           py::arg("upright") = false);
  function(m, "point_pixels", &pattern::point_pixels,
           "The projector pixels of the layout's points, by point index.", py::arg("board"));
  function(m, "area_needed", &pattern::area_needed,
           "The part of the picture that must land on the sheet, so that all of it can be read:\n"
           "the dark shapes and half a pitch of light round them.",
           py::arg("board"));
  function(m, "frames", py::overload_cast<const pattern::ProjectedBoard&>(&pattern::frames),
           "Flat and board, one channel; or one frame of three.", py::arg("board"));
  function(m, "frame_count", py::overload_cast<const pattern::ProjectedBoard&>(&pattern::frame_count),
           "Number of frames.", py::arg("board"));
}

void bind_filling_boards(py::module_& m) {
  function(m, "chessboard_filling", &pattern::chessboard_filling,
           "Boards that fill the picture, of a sixteenth of its longer side a pitch (circles:\n"
           "two, staggered): for 1024x768 12x9 corners; 15x11 squares; 10x7 markers; 7x11 discs.",
           py::arg("projector_size"));
  function(m, "charuco_filling", &pattern::charuco_filling,
           "The ChArUco board that fills a projector's frame; lengths are projector pixels.",
           py::arg("projector_size"));
  function(m, "markers_filling", &pattern::markers_filling,
           "The grid of markers that fills a projector's frame; lengths are projector\n"
           "pixels.",
           py::arg("projector_size"));
  function(m, "circles_filling", &pattern::circles_filling,
           "The grid of circles that fills a projector's frame; lengths are projector\n"
           "pixels.",
           py::arg("projector_size"));
}

void bind_sequence_check(py::module_& m) {
  Record<pattern::SequenceCheck> sequence_check(m, "SequenceCheck",
                                                "What is wrong with a view's captures, in warnings.");
  sequence_check.fields_init()
      .field(
          "diagnostics", &pattern::SequenceCheck::diagnostics,
          "At most one warning that names the cause, the strongest first:\n"
          "  \"frame_missing\", \"stale_frame\", \"torn_frame\", \"overexposed\", \"board_moved\", \"camera_moved\",\n"
          "  \"camera_shake\", \"camera_drift\", \"projector_moved\", \"focus_drift\", \"lag\", \"exposure_changes\", \"flicker\",\n"
          "  \"noisy\", \"highlight\", \"low_contrast\", \"scattered_light\".")
      .field("decoding_is_wrong", &pattern::SequenceCheck::decoding_is_wrong,
             "The frames do not belong to one position or order: what is decoded from them is\n"
             "wrong.")
      .field("has_lit_board", &pattern::SequenceCheck::has_lit_board,
             "Enough of the board is lit for these remarks to be about it: then they replace those\n"
             "of decode(), which are about the whole image.")
      .field("noise", &pattern::SequenceCheck::noise,
             "of white stripes, share of the contrast in linear light")
      .field("scattered", &pattern::SequenceCheck::scattered,
             "light that black stripes receive, share of white ones")
      .field("gamma", &pattern::SequenceCheck::gamma, "of the camera, as estimated; 1 if unknown");

  Record<pattern::ComplementaryFrames> complementary_frames(
      m, "ComplementaryFrames",
      "Of a pattern's frames, two that sum to full light at every pixel, in the order of\n"
      "the first one's number, and the frames that are white and black all over.");
  complementary_frames.fields_init()
      .field("pairs", &pattern::ComplementaryFrames::pairs, "")
      .field("white", &pattern::ComplementaryFrames::white, "")
      .field("black", &pattern::ComplementaryFrames::black, "")
      .field("frames", &pattern::ComplementaryFrames::frames, "number of the pattern's frames");

  function(m, "check_sequence",
           py::overload_cast<const std::vector<ViewU8>&, const pattern::GrayCode&, const Points2&>(
               &pattern::check_sequence),
           "Raises as decode() for captures of wrong number or size. `on_board`: camera pixels\n"
           "of points of the board; empty: the board was not found, and print is not separated\n"
           "from background.",
           py::arg("captures"), py::arg("gray_code"), py::arg("on_board"));
  function(m, "complementary_frames", &pattern::complementary_frames,
           "Which of the frames (uint8, (h, w) or (h, w, 3)) are pairs of a pattern and its\n"
           "inverse, and which are white and black.",
           py::arg("frames"));
  function(m, "check_sequence",
           py::overload_cast<const std::vector<ViewU8>&, const pattern::ComplementaryFrames&, const Points2&>(
               &pattern::check_sequence),
           "The same for any pattern; without frame_missing, noisy and scattered_light, which\n"
           "need Gray code. Nothing is found with fewer than six pairs. Raises\n"
           "ValueError for captures of another number, size or number of channels.",
           py::arg("captures"), py::arg("frames"), py::arg("on_board"));
}

void bind_flat_checks(py::module_& m) {
  function(m, "check_flat_and_board", &pattern::check_flat_and_board,
           "The two captures of a projected board, under flat light and under the board\n"
           "(pattern/projected_board.hpp): the print is in the same light in both, so that it\n"
           "looks the same. \"stale_frame\", \"overexposed\", \"board_moved\", \"camera_moved\",\n"
           "\"exposure_changes\". Raises ValueError unless both have one channel and\n"
           "one size.",
           py::arg("flat_lit"), py::arg("board_lit"), py::arg("on_board"));
  function(m, "check_photograph", &pattern::check_photograph,
           "One photograph of printed and projected boards, `on_boards` the camera pixels of the\n"
           "points of both; empty: no board was found, and the whole image is judged.\n"
           "\"overexposed\" where the paper is at full scale over more than a tenth of the boards:\n"
           "half of a chessboard is paper, and only edges that are not clipped are where they\n"
           "seem. Raises ValueError unless the photograph has one channel.",
           py::arg("photograph"), py::arg("on_boards"));
}

void bind_shown_board_pattern(py::module_& m) {
  Record<pattern::ShownBoard> shown_board(
      m, "ShownBoard",
      "A chessboard found in a frame that was shown, with its corners in projector\n"
      "pixels.");
  shown_board.fields_init()
      .field("layout", &pattern::ShownBoard::layout, "square_size in projector pixels")
      .field("corners", &pattern::ShownBoard::corners, "row by row, as the frame has them")
      .field("light_first", &pattern::ShownBoard::light_first,
             "Is the square outside the first corner (up and left of it) light? Unknown for boards\n"
             "given by numbers.");

  function(m, "shown_board", &pattern::shown_board,
           "From its numbers. Raises Error(kInput), `name` in front, when a corner is outside\n"
           "the frame.",
           py::arg("layout"), py::arg("first_corner"), py::arg("projector_size"), py::arg("name"));
  function(m, "read_shown_board", &pattern::read_shown_board,
           "From the frame itself, one channel: exact for squares that are aligned with the\n"
           "pixels and whose edges are between pixels. Raises Error(kInput), `name` in front,\n"
           "when the frame does not show one such chessboard of 3x3 inner corners or more.",
           py::arg("frame"), py::arg("name"));
}

void bind_stripe_edges(py::module_& m) {
  Record<pattern::StripeEdgeOptions> stripe_edge_options(m, "StripeEdgeOptions",
                                                         "How the boundaries of stripes are found.");
  stripe_edge_options.fields_init()
      .field("decode", &pattern::StripeEdgeOptions::decode, "")
      .field("max_code_jump", &pattern::StripeEdgeOptions::max_code_jump, "")
      .field("min_step_sigmas", &pattern::StripeEdgeOptions::min_step_sigmas,
             "smallest step of grey at a boundary, standard deviations of the noise")
      .field("max_sigma_px", &pattern::StripeEdgeOptions::max_sigma_px,
             "largest standard deviation of a boundary, camera pixels")
      .field("camera_blur_px", &pattern::StripeEdgeOptions::camera_blur_px,
             "standard deviation of the camera's blur, camera pixels");

  function(m, "stripe_edges", &pattern::stripe_edges,
           "All edges of both axes, row-major in the camera for the columns, then for the rows.\n"
           "Each axis is scanned along the camera direction in which its codes vary faster;\n"
           "mirrored and turned projectors are read like any other. `captures` are those that\n"
           "`decoded` came from: raises Error as decode() does, and\n"
           "ValueError if sizes or steps of the three do not belong together.",
           py::arg("captures"), py::arg("decoded"), py::arg("gray_code"),
           py::arg_v("options", pattern::StripeEdgeOptions{}, "StripeEdgeOptions()"));
  function(
      m, "stripe_edges",
      [](const std::vector<ViewU8>& captures, const DecodedMap& decoded, const pattern::GrayCode& gray_code,
         const pattern::StripeEdgeOptions& options, const ViewU8& area) {
        pattern::StripeEdgeOptions within = options;
        within.area = area;
        return pattern::stripe_edges(captures, decoded, gray_code, within);
      },
      "As without `area`, but only where its pixels, uint8 (h, w), are not zero.", py::arg("captures"),
      py::arg("decoded"), py::arg("gray_code"), py::arg("options"), py::arg("area"));
}

}  // namespace

void bind_pattern(py::module_& m) {
  bind_board_light(m);
  bind_decoding(m);
  bind_gray_code(m);
  bind_pattern_sequence(m);
  bind_phase_shift(m);
  bind_projected_board(m);
  bind_filling_boards(m);
  bind_sequence_check(m);
  bind_flat_checks(m);
  bind_shown_board_pattern(m);
  bind_stripe_edges(m);
}

}  // namespace procam::python
