#include "names.hpp"

#include <algorithm>
#include <cstdlib>

#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::dds::internal {
namespace {

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Tokens of letters, digits and underscores that begin with no digit, divided by single slashes.
bool is_topic_name(const std::string& name) {
  if (name.empty() || name.size() > limits::kFrameNameBytes || name.back() == '/') return false;
  char before = '/';
  for (std::size_t i = name.front() == '/' ? 1 : 0; i < name.size(); before = name[i++]) {
    const char c = name[i];
    if (c == '/' ? before == '/' : !is_letter(c) && (!is_digit(c) || before == '/')) return false;
  }
  return true;
}

std::string joined(const std::string& node_namespace, const std::string& name) {
  if (!name.empty() && name.front() == '/') return name;
  return (node_namespace == "/" ? "" : node_namespace) + "/" + name;
}

/// Parts divided by commas; remaps and the namespace go into `names`, the others are returned.
std::vector<std::string> take_parts(const std::string& rest, GraphNames& names,
                                    const std::string& kind = "ros2:") {
  std::vector<std::string> plain;
  for (std::size_t begin = 0; !rest.empty() && begin <= rest.size();) {
    const std::size_t end = std::min(rest.find(',', begin), rest.size());
    const std::string part = rest.substr(begin, end - begin);
    begin = end + 1;
    const std::size_t remap = part.find(":=");
    if (remap == part.npos) {
      plain.push_back(part);
      continue;
    }
    const std::string from = part.substr(0, remap), to = part.substr(remap + 2);
    const std::string what = kind + rest;
    if (from == "__ns") {
      if (to != "/") require_topic_name(to, what);
      names.node_namespace = to.front() == '/' ? to : "/" + to;
    } else if (from == "use_sim_time") {
      if (to != "true" && to != "false")
        throw Error(ErrorKind::kInput, what, "use_sim_time is true or false", "write use_sim_time:=true");
      names.use_sim_time = to == "true";
    } else {
      require_topic_name(from, what);
      require_topic_name(to, what);
      names.remaps.emplace_back(from, to);
    }
  }
  return plain;
}

void refuse_sim_time(const GraphNames& names, const std::string& what) {
  if (names.use_sim_time)
    throw Error(ErrorKind::kInput, what, "use_sim_time is for poses of the graph alone", "remove it");
}

/// A remap of a name that is not read would change nothing, unseen: a mistyped one. `read`: names as they are resolved.
void require_remaps_used(const GraphNames& names, const std::vector<std::string>& read,
                         const std::string& what) {
  for (const auto& [from, to] : names.remaps) {
    const std::string full = joined(names.node_namespace, from);
    std::string known;
    bool is_used = false;
    for (const std::string& name : read) {
      const std::string one = joined(names.node_namespace, name);
      is_used = is_used || one == full;
      known += (known.empty() ? "" : ", ") + one;
    }
    if (!is_used)
      throw Error(ErrorKind::kInput, what, "the remap of '" + from + "' changes no name that is read",
                  "remap one of: " + known);
  }
}

}  // namespace

void require_topic_name(const std::string& name, const std::string& what) {
  if (!is_topic_name(name))
    throw Error(ErrorKind::kInput, what, "'" + name + "' is no name of a topic",
                "use letters, digits, '_' and single '/', e.g. /odom");
}

std::string GraphNames::resolve(const std::string& name) const {
  const std::string full = joined(node_namespace, name);
  for (const auto& [from, to] : remaps)
    if (joined(node_namespace, from) == full) return joined(node_namespace, to);
  return full;
}

Ros2Source parse_ros2_source(const std::string& rest, const std::string& kind) {
  GraphNames names;
  const std::vector<std::string> plain = take_parts(rest, names, kind);
  Ros2Source source;
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorKind::kInput, "pose source '" + kind + rest + "'", why,
                "give two frames (" + kind + "map,base_link) or a topic (" + kind + "/odom)");
  };
  if (names.use_sim_time) source.clock = names.resolve("/clock");
  const auto require_used = [&](std::vector<std::string> read) {
    if (names.use_sim_time) read.push_back("/clock");
    require_remaps_used(names, read, "pose source '" + kind + rest + "'");
  };
  for (const std::string& part : plain)
    if (part.empty() || part.size() > limits::kFrameNameBytes) refuse("a part of it is empty or too long");
  if (plain.size() > 2) refuse("it has more than two names");
  if (plain.size() == 1) {
    if (plain.front().front() != '/')
      refuse("'" + plain.front() + "' is one frame of two, or a topic without '/'");
    require_topic_name(plain.front(), "pose source '" + kind + rest + "'");
    require_used({plain.front()});
    source.topic = names.resolve(plain.front());
    return source;
  }
  source.frame = plain.empty() ? "map" : plain[0];
  source.child = plain.empty() ? "base_link" : plain[1];
  // tf2 has no names with a slash in front; tf had.
  for (std::string* frame : {&source.frame, &source.child})
    if (frame->front() == '/') frame->erase(0, 1);
  if (source.frame.empty() || source.frame == source.child) refuse("its frames are not two");
  require_used({"/tf", "/tf_static"});
  source.tf = names.resolve("/tf");
  source.tf_static = names.resolve("/tf_static");
  return source;
}

Ros2Topic parse_ros2_topic(const std::string& rest, const std::string& what, const std::string& kind) {
  GraphNames names;
  const std::vector<std::string> plain = take_parts(rest, names, kind);
  refuse_sim_time(names, what + " '" + kind + rest + "'");
  if (plain.size() != 1 || plain.front().empty())
    throw Error(ErrorKind::kInput, what + " '" + kind + rest + "'", "it names no topic, or several",
                "give one topic, e.g. " + kind + "/camera/image_raw");
  require_topic_name(plain.front(), what + " '" + kind + rest + "'");
  const std::string given = joined(names.node_namespace, plain.front());
  const std::string info = given.substr(0, given.rfind('/')) + "/camera_info";
  require_remaps_used(names, {given, info}, what + " '" + kind + rest + "'");
  return {names.resolve(given), names.resolve(info)};
}

GraphNames parse_ros2_output(const std::string& text) {
  const std::string kind = "ros2:";
  if (text.compare(0, kind.size(), kind) != 0)
    throw Error(ErrorKind::kInput, "'" + text + "'",
                "it does not begin with ros2:", "give e.g. ros2:/procam");
  GraphNames names;
  const std::vector<std::string> plain = take_parts(text.substr(kind.size()), names);
  refuse_sim_time(names, "'" + text + "'");
  if (plain.size() > 1)
    throw Error(ErrorKind::kInput, "'" + text + "'", "it has more than one namespace",
                "give e.g. ros2:/procam");
  if (!plain.empty() && plain.front() != "/") {
    require_topic_name(plain.front(), "'" + text + "'");
    names.node_namespace = (plain.front().front() == '/' ? "" : "/") + plain.front();
  }
  return names;
}

int domain_of_environment() {
  const char* text = std::getenv("ROS_DOMAIN_ID");
  if (text == nullptr || *text == '\0') return 0;
  char* end = nullptr;
  const long domain = std::strtol(text, &end, 10);
  // Ports of domain 233 are above 65535.
  if (!is_digit(*text) || *end != '\0' || domain > 232)
    throw Error(ErrorKind::kInput, "ROS_DOMAIN_ID", std::string("'") + text + "' is no domain",
                "set it to a number from 0 to 232");
  return int(domain);
}

bool is_localhost_only() {
  const auto is = [](const char* name, const char* value) {
    const char* text = std::getenv(name);
    return text != nullptr && std::string(text) == value;
  };
  return is("ROS_LOCALHOST_ONLY", "1") || is("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST");
}

}  // namespace procam::dds::internal
