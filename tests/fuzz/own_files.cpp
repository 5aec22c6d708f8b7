// procam's own files from any bytes: what is accepted is written, and reads back as it was.
#include <cmath>

#include "fuzz_target.hpp"
#include "io/examples.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/io/session/pattern_file.hpp"
#include "procam/io/session/shown_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/show/show_options.hpp"
#include "targets.hpp"

namespace procam::fuzz {
namespace {

/// The mesh that the example surfaces name, beside them.
void store_roof() {
  static const std::filesystem::path roof = store("roof.obj", test::kRoof);
}

void check_surfaces_file(const std::string& name, std::string_view bytes) {
  store_roof();
  check_file(name, bytes, io::load_surfaces, io::save_surfaces);
}

/// A text as it is typed: what parse() gives, format() writes so that parse() gives it again.
template <typename Parse, typename Format>
void check_typed(const std::string& text, const Parse& parse, const Format& format) {
  try {
    const auto value = parse(text);
    const std::string written = must("formatting what was typed", [&] { return format(value); });
    const auto again = must("parsing what was formatted", [&] { return parse(written); });
    check(again == value, "'" + text + "' is another value when written as '" + written + "'");
  } catch (const Error&) {
    return;
  }
}

template <typename Parse>
void check_number(const std::string& text, const Parse& parse) {
  try {
    check(std::isfinite(parse(text)), "'" + text + "' is not finite");
  } catch (const Error&) {
    return;
  }
}

}  // namespace

void rig(std::string_view bytes) {
  check_file("rig.json", bytes, io::load_rig, io::save_rig);
}

void surfaces_json(std::string_view bytes) {
  check_surfaces_file("surfaces.json", bytes);
}

void surfaces_xml(std::string_view bytes) {
  check_surfaces_file("surfaces.xml", bytes);
}

/// XML begins with a bracket, after a byte order mark or blanks.
void solved_surfaces(std::string_view bytes) {
  store_roof();
  const bool is_xml = bytes.substr(0, 16).find('<') != std::string_view::npos;
  check_file(is_xml ? "solved.xml" : "solved.json", bytes, io::load_solved_surfaces,
             io::save_solved_surfaces);
}

void show(std::string_view bytes) {
  check_file("show.json", bytes, show::load_options, show::save_options);
}

void session(std::string_view bytes) {
  const auto load = [](const std::filesystem::path& file) {
    return io::load_session(file.parent_path()).value();
  };
  const auto save = [](const std::filesystem::path& file, const io::SessionInfo& info) {
    io::save_session(file.parent_path(), info);
  };
  check_file("session.json", bytes, load, save);
}

void board(std::string_view bytes) {
  const bool is_json = bytes.substr(0, 16).find('{') != std::string_view::npos;
  if (is_json) return check_file("board.json", bytes, io::load_board, io::save_board);
  io::read_board(store("target.yaml", bytes).string());
}

void markers(std::string_view bytes) {
  check_file("markers.json", bytes, io::load_marker_map, io::save_marker_map);
}

void pose(std::string_view bytes) {
  check_file("pose.json", bytes, io::load_pose, io::save_pose);
}

void pattern(std::string_view bytes) {
  check_file("pattern.json", bytes, io::load_pattern, io::save_pattern);
}

void shown(std::string_view bytes) {
  check_file("shown.json", bytes, io::load_shown, io::save_shown);
}

void typed(std::string_view bytes) {
  const std::string text(bytes.substr(0, 256));
  check_typed(text, io::parse_size, io::format_size);
  check_typed(text, io::parse_length, io::format_length);
  for (const io::BoardUnit unit : {io::BoardUnit::kMetric, io::BoardUnit::kPixel})
    check_typed(
        text, [&](const std::string& typed) { return io::parse_board(typed, unit); },
        [&](const Board& board) { return io::format_board(board, unit); });
  for (const auto parse : {io::parse_angle, io::parse_pixels, io::parse_share, io::parse_duration})
    check_number(text, parse);
  check_number(text, [](const std::string& typed) { return io::parse_length_and_angle(typed).length; });
  check_number(text, [](const std::string& typed) { return io::parse_speed(typed).angle; });
  check_number(text, [](const std::string& typed) { return io::parse_uncertain(typed).sigma; });
  check_number(text, [](const std::string& typed) { return io::parse_marker(typed).markers.at(0).size; });
  check_number(text, [](const std::string& typed) {
    return double(io::parse_device(typed, DeviceKind::kCamera).size.width);
  });
}

}  // namespace procam::fuzz
