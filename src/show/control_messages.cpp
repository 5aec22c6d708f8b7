#include "control_messages.hpp"
#include "picture_names.hpp"

#include "procam/show/page_server.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

namespace procam::show {
namespace {

using nlohmann::json;

json finite(double value) {
  return std::isfinite(value) ? json(value) : json(nullptr);
}

json to_json(const WatchStatus& watch) {
  json history = json::array();
  for (const double error_mm : watch.history_mm) history.push_back(finite(error_mm));
  return {{"state", watch.state},
          {"sentence", watch.sentence},
          {"alarm", watch.is_alarm},
          {"checks", watch.checks},
          {"alarms", watch.alarms},
          {"corrections", watch.corrections},
          {"corrects", watch.corrects},
          {"corrected", watch.is_corrected},
          {"faults", watch.faults},
          {"error_mm", finite(watch.error_mm)},
          {"error_sigma_mm", finite(watch.error_sigma_mm)},
          {"probability", finite(watch.probability)},
          {"textured", watch.textured},
          {"measured", watch.measured},
          {"history_mm", std::move(history)},
          {"corrects_pose", watch.corrects_pose},
          {"pose_off_mm", finite(watch.pose_off_mm)},
          {"pose_off_deg", finite(watch.pose_off_deg)},
          {"pose_sigma_mm", finite(watch.pose_sigma_mm)},
          {"pose_images", watch.pose_images},
          {"pose_refused", watch.pose_refused}};
}

json to_json(const MovingMetrics& moving) {
  return {{"surface", moving.surface},
          {"state", moving.state},
          {"dark", moving.is_dark},
          {"sightings", moving.sightings},
          {"refused", moving.refused},
          {"refusal", moving.refusal},
          {"losses", moving.losses},
          {"lost_s", finite(moving.lost_s)},
          {"age_ms", finite(1e3 * moving.age_s)},
          {"error_mm", finite(moving.error_mm)}};
}

json to_json(const BlendMetrics& blend) {
  return {{"projectors", blend.projectors},
          {"dark", blend.is_dark},
          {"changes", blend.changes},
          {"last_change_s", finite(blend.last_change_s)}};
}

json to_json(const std::vector<std::optional<Vec2>>& points) {
  json list = json::array();
  for (const auto& point : points)
    list.push_back(point && point->allFinite() ? json{point->x(), point->y()} : json(nullptr));
  return list;
}

json to_json(const PageStatus& status) {
  json surfaces = json::array();
  for (const PageSurface& surface : status.surfaces) {
    json masks = json::array();
    for (const auto& mask : surface.masks) masks.push_back(to_json(mask));
    surfaces.push_back({{"name", surface.name},
                        {"content", surface.content},
                        {"points", to_json(surface.points)},
                        {"outline", to_json(surface.outline)},
                        {"masks", std::move(masks)},
                        {"shape", surface.shape},
                        {"fit", surface.fit}});
  }
  json moving = json::array();
  for (const MovingMetrics& one : status.moving) moving.push_back(to_json(one));
  return {{"frame", {status.frame.width, status.frame.height}},
          {"screens", status.screens},
          {"screen", status.screen},
          {"surfaces", std::move(surfaces)},
          {"contents", status.contents},
          {"picture", kPictureNames[int(status.picture)]},
          {"frozen", status.frozen},
          {"blanked", status.blanked},
          {"unsaved", status.unsaved},
          {"can_undo", status.can_undo},
          {"can_redo", status.can_redo},
          {"frames_per_s", finite(status.frames_per_s)},
          {"frame_ms", finite(status.frame_ms)},
          {"pose_state", status.pose_state},
          {"waiting", status.waiting},
          {"poses_per_s", finite(status.poses_per_s)},
          {"pose_age_ms", finite(status.pose_age_ms)},
          {"delay_ms", finite(status.delay_ms)},
          {"pose_error_mm", finite(status.pose_error_mm)},
          {"watch", status.watch ? to_json(*status.watch) : json(nullptr)},
          {"tracked", std::move(moving)},
          {"blend", status.blend ? to_json(*status.blend) : json(nullptr)},
          {"messages", status.messages}};
}

std::optional<Vec2> to_point(const json& value) {
  if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number())
    return std::nullopt;
  const Vec2 point(value[0].get<double>(), value[1].get<double>());
  return point.allFinite() ? std::optional(point) : std::nullopt;
}

std::optional<Points2> to_ring(const json& value) {
  if (!value.is_array() || value.size() > kMaskCorners) return std::nullopt;
  Points2 ring;
  for (const json& corner : value) {
    const std::optional<Vec2> point = to_point(corner);
    if (!point) return std::nullopt;
    ring.push_back(*point);
  }
  return ring;
}

}  // namespace

std::string random_token() {
  std::random_device random;
  std::string token;
  for (int i = 0; i < 32; ++i) token += "0123456789abcdef"[random() % 16];
  return token;
}

bool same_secret(std::string_view a, std::string_view b) {
  unsigned different = unsigned(a.size() != b.size());
  for (std::size_t i = 0; i < a.size(); ++i) different |= unsigned(a[i] ^ (i < b.size() ? b[i] : 0));
  return different == 0;
}

std::string token_of(std::string_view target, std::string_view authorization) {
  constexpr std::string_view kBearer = "Bearer ";
  if (authorization.substr(0, kBearer.size()) == kBearer)
    return std::string(authorization.substr(kBearer.size()));
  for (std::size_t at = target.find('?'); at != std::string_view::npos; at = target.find('&', at)) {
    const std::string_view rest = target.substr(++at);
    if (rest.substr(0, 6) == "token=") return std::string(rest.substr(6, rest.find('&') - 6));
  }
  return "";
}

std::optional<Command> to_command(std::string_view text) {
  const json document = json::parse(text.begin(), text.end(), nullptr, false);
  if (!document.is_object()) return std::nullopt;
  Command command;
  for (const auto& [key, value] : document.items()) {
    const auto take = [&value = value](std::string& into) {
      if (!value.is_string()) return false;
      into = value.get<std::string>();
      return into.size() <= 1024;
    };
    bool good = false;
    if (key == "do") good = take(command.verb);
    if (key == "surface") good = take(command.surface);
    if (key == "text") good = take(command.text);
    if (key == "gesture") good = take(command.gesture);
    if (key == "point" && value.is_number_integer()) {
      const auto point = value.get<std::int64_t>();
      good = point >= -1 && point < 100000;
      command.point = good ? int(point) : -1;
    }
    if (key == "pixels") {
      const auto pixels = to_point(value);
      good = pixels.has_value();
      if (good) command.pixels = *pixels;
    }
    if (key == "ring") {
      const auto ring = to_ring(value);
      good = ring.has_value();
      if (good) command.ring = *ring;
    }
    if (!good) return std::nullopt;
  }
  if (command.verb.empty()) return std::nullopt;
  return command;
}

std::string to_message(const Command& command) {
  json message = {{"do", command.verb}};
  if (!command.surface.empty()) message["surface"] = command.surface;
  if (!command.text.empty()) message["text"] = command.text;
  if (!command.gesture.empty()) message["gesture"] = command.gesture;
  if (command.point >= 0) message["point"] = command.point;
  if (command.pixels != Vec2::Zero()) message["pixels"] = {command.pixels.x(), command.pixels.y()};
  for (const Vec2& corner : command.ring) message["ring"].push_back({corner.x(), corner.y()});
  return message.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string to_jpeg(ViewU8 frame, int max_width) {
  const cv::Mat rgb(frame.height, frame.width, frame.channels == 3 ? CV_8UC3 : CV_8UC1,
                    const_cast<std::uint8_t*>(frame.data), std::size_t(frame.stride));
  cv::Mat small = rgb, bgr;
  if (frame.width > max_width)
    cv::resize(
        rgb, small,
        cv::Size(max_width, std::max(1, int(std::lround(double(frame.height) * max_width / frame.width)))), 0,
        0, cv::INTER_AREA);
  if (frame.channels == 3)
    cv::cvtColor(small, bgr, cv::COLOR_RGB2BGR);
  else
    bgr = small;
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, 82});
  return {bytes.begin(), bytes.end()};
}

std::string to_json_text(const PageStatus& status) {
  // Text of files and people: what is no UTF-8 is replaced.
  return to_json(status).dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace procam::show
