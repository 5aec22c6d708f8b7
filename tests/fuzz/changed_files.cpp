// procam's own files with the structure kept: a valid document in which drawn fields are changed, removed,
// doubled and exchanged, so that the search reaches the checks behind the syntax.
#include "document/document.hpp"
#include "draws.hpp"
#include "fuzz_target.hpp"
#include "io/examples.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/show/show_options.hpp"
#include "targets.hpp"

namespace procam::fuzz {
namespace {

/// A node below the root, and the list that it is in.
struct Spot {
  std::vector<io::Node>* siblings = nullptr;
  std::size_t index = 0;
  io::Node& node() const { return (*siblings)[index]; }
};

Spot drawn_spot(io::Node& document, Draws& draws) {
  Spot spot{&document.children, draws.below(document.children.size())};
  while (!spot.node().children.empty() && draws.below(4) != 0) {
    std::vector<io::Node>& inner = spot.node().children;
    spot = {&inner, draws.below(inner.size())};
  }
  return spot;
}

void change_value(io::Node& node, Draws& draws) {
  using Kind = io::Node::Kind;
  switch (draws.below(4)) {
    case 0:
      node.kind = Kind::kNumber;
      node.number = draws.number();
      break;
    case 1:
      node.kind = Kind::kString;
      node.text = std::string(draws.piece());
      if (!io::is_plain_text(node.text)) node.text = "ü";
      break;
    case 2:
      node.kind = Kind::kBool;
      node.number = draws.yes() ? 1 : 0;
      break;
    default:
      node.kind = draws.yes() ? Kind::kList : Kind::kObject;
  }
  if (node.kind != Kind::kList && node.kind != Kind::kObject) node.children.clear();
}

/// A list of numbers in one text (XML) must stay one of numbers.
bool is_row(const io::Node& node) {
  return node.kind == io::Node::Kind::kList && node.item_name.empty() && !node.children.empty();
}

void change(io::Node& document, Draws& draws) {
  const Spot spot = drawn_spot(document, draws);
  io::Node& node = spot.node();
  switch (draws.below(6)) {
    case 0:
      if (is_row(node)) node.children[draws.below(node.children.size())].number = draws.number();
      if (node.kind == io::Node::Kind::kNumber) node.number = draws.number();
      break;
    case 1:
      if (spot.siblings->size() > 1 && spot.siblings->size() < 1000)
        spot.siblings->erase(spot.siblings->begin() + std::ptrdiff_t(spot.index));
      break;
    case 2:
      if (spot.siblings->size() < 1000) spot.siblings->push_back(io::Node(node));
      break;
    case 3: {
      io::Node& other = (*spot.siblings)[draws.below(spot.siblings->size())];
      std::swap(node.name, other.name);
      break;
    }
    case 4: {
      const io::Node copy = drawn_spot(document, draws).node();
      const std::string name = node.name;
      node = copy;
      node.name = name;
      break;
    }
    default:
      change_value(node, draws);
  }
}

io::Node changed(io::Node document, Draws& draws) {
  for (int i = 0; i < 12 && !draws.empty() && !document.children.empty(); ++i) change(document, draws);
  return document;
}

template <typename Save>
io::Node document_of(const std::string& name, const Save& save) {
  const std::filesystem::path file = folder() / name;
  save(file);
  return io::parse_json(io::read_file(file), name);
}

show::ShowOptions example_options() {
  show::ShowOptions options;
  options.projector = "beamer";
  options.surfaces = "depth:watch:frames";
  options.contents = {{"wall", "clip.mp4@30"}, {"floor", "#ff8000"}};
  options.marker = show::MarkerInput{"0", "left", "apriltag_36h11:3:160mm", ""};
  options.pose = "pose.json";
  options.mount = "mount.json";
  options.blank_on_stale_s = 0.5;
  options.freeze_on_stale_s = 0.25;
  options.display = "HDMI-1";
  options.fps = 59.94;
  options.depth = {"left", 0.002, 0.03, Vec3(0, 0.1, 1), true};
  options.people = show::PeopleInput{"udp:9100", "sensor.json", 0.03, {"wall=udp:127.0.0.1:9200"}};
  options.renderer = "gl";
  options.threads = 3;
  return options;
}

}  // namespace

std::string changed_document(std::string_view bytes, std::string_view draws) {
  try {
    Draws from(draws);
    std::string text = io::to_json(changed(io::parse_json(bytes, "f.json"), from));
    if (bytes.substr(0, bytes.size() - 1).find('\n') == bytes.npos)
      std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
  } catch (const Error&) {
    return "";
  }
}

void rig_fields(std::string_view bytes) {
  static const io::Node valid = document_of(
      "valid.json", [](const std::filesystem::path& file) { io::save_rig(file, test::example_rig()); });
  Draws draws(bytes);
  rig(io::to_json(changed(valid, draws)));
}

void surfaces_fields(std::string_view bytes) {
  const auto save = [](const std::filesystem::path& file) {
    io::save_surfaces(file, test::example_surfaces());
  };
  store("roof.obj", test::kRoof);
  static const io::Node valid = document_of("valid.json", save);
  Draws draws(bytes);
  surfaces_json(io::to_json(changed(valid, draws)));
}

void show_fields(std::string_view bytes) {
  static const io::Node valid = document_of(
      "valid.json", [](const std::filesystem::path& file) { show::save_options(file, example_options()); });
  Draws draws(bytes);
  show(io::to_json(changed(valid, draws)));
}

}  // namespace procam::fuzz
