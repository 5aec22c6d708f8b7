#include "procam/session/reader.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <iterator>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "folder_name.hpp"
#include "identical_files.hpp"
#include "photographed_views.hpp"
#include "preview.hpp"
#include "procam/core/base/parallel.hpp"
#include "procam/detect/board_artwork.hpp"
#include "procam/detect/detect_board.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/session/decoded_view.hpp"
#include "procam/io/text.hpp"
#include "procam/pattern/board_light.hpp"
#include "procam/pattern/decoded_pixels.hpp"

namespace procam::session {
namespace {

namespace fs = std::filesystem;

constexpr int kViewsBeforeGivingUp = 3;
constexpr int kViewsAtATime = 4;  // a view of 42 frames of 18 megapixels takes 0.8 GB

/// Sizes of the cameras' frames as they become known.
using CameraSizes = std::vector<std::optional<ImageSize>>;

int camera_of(const SessionPlan& plan, const io::Stack& stack) {
  if (stack.camera.empty()) return 0;
  return int(std::find(plan.cameras.begin(), plan.cameras.end(), stack.camera) - plan.cameras.begin());
}

template <typename T>
void turn_rows(Image<T>& image) {
  const int channels = image.channels();
  for (int y = 0; y < image.height(); ++y)
    for (int left = 0, right = image.width() - 1; left < right; ++left, --right)
      std::swap_ranges(image.row(y) + left * channels, image.row(y) + (left + 1) * channels,
                       image.row(y) + right * channels);
}

/// What one view holds, or why it cannot be read.
struct ReadView {
  std::vector<Reading> readings;
  std::vector<InputFile> inputs;
  std::vector<ViewImage> images;  ///< by camera
  CameraSizes sizes;
  std::exception_ptr error;
};

/// The first stack of a camera in a view gives its image.
void add_image(const std::string& view, const std::string& camera, const std::vector<ViewU8>& frames,
               ImageF decoded, std::vector<ViewImage>& images) {
  for (const ViewImage& image : images)
    if (image.camera == camera) return;
  images.push_back(preview(view, camera, frames));
  images.back().decoded = std::move(decoded);
}

/// What another program has decoded, in place of frames.
void read_decoded(const SessionPlan& plan, const std::string& view_name, const io::Stack& stack,
                  ImageSize projector_size, ReadView& read, Reading& reading) {
  std::optional<ImageSize>& size = read.sizes[std::size_t(reading.camera)];
  io::DecodedView view = io::load_decoded_view(stack.folder);
  if (!size) size = view.white.size();
  reading.in_camera.image_size = *size;
  reading.in_projector.image_size = projector_size;
  if (view.white.size() != *size) {
    reading.in_camera.diagnostics.warn("image_size_differs",
                                       view.files.front().filename().string() + " is rejected: it is " +
                                           io::format_size(view.white.size()) + ", the other images are " +
                                           io::format_size(*size));
    return;
  }
  if (plan.through_mirror) {
    turn_left_to_right(view.white);
    turn_left_to_right(view.pixels);
  }
  for (const fs::path& file : view.files)
    read.inputs.push_back({file.lexically_relative(plan.folder).generic_string(), io::sha256_of_file(file)});
  const LightMap light = pattern::light_map(view.pixels, view.white, projector_size);
  add_image(view_name, plan.cameras[std::size_t(reading.camera)], {view.white}, decoded_preview(light),
            read.images);
  reading.in_camera = detect::detect_board(view.white, plan.board);
  if (!reading.in_camera.observations.empty())
    reading.in_projector =
        pattern::project_board(reading.in_camera, plan.board, detect::board_artwork(plan.board), light);
  reading.in_camera.diagnostics.append(light.diagnostics);
  reading.in_camera.diagnostics.append(view.diagnostics);
}

/// A session's remarks name view and camera, so that those of many views are alike.
void remove_folder(const fs::path& folder, Diagnostics& remarks) {
  const std::string before = folder.string() + ": ";
  for (Diagnostic& remark : remarks.items)
    if (remark.message.compare(0, before.size(), before) == 0) remark.message.erase(0, before.size());
}

Reading read_stack(const SessionPlan& plan, const PlannedView& view, const io::Stack& stack, ReadView& read) {
  const auto by_name = [&](const PlannedProjector& p) {
    return stack.projector.empty() || p.name == stack.projector;
  };
  const auto projector = std::find_if(plan.projectors.begin(), plan.projectors.end(), by_name);
  Reading reading;
  reading.camera = camera_of(plan, stack);
  reading.projector = int(plan.cameras.size()) + int(projector - plan.projectors.begin());
  std::optional<ImageSize>& size = read.sizes[std::size_t(reading.camera)];
  if (plan.decoded) {
    read_decoded(plan, view.name, stack, projector->size, read, reading);
    return reading;
  }
  io::CaptureFolder captures = io::load_capture_folder(stack.folder, projector->pattern->frame_count(),
                                                       projector->pattern->channels(), size);
  remove_folder(stack.folder, captures.diagnostics);
  reading.in_camera.diagnostics = captures.diagnostics;
  if (captures.frames.empty()) {  // of another size, and named in the diagnostics
    reading.in_camera.image_size = size.value();
    reading.in_projector.image_size = projector->size;
    return reading;
  }
  if (plan.through_mirror)
    for (ImageU8& frame : captures.frames) turn_left_to_right(frame);
  for (const fs::path& file : captures.files)
    read.inputs.push_back({file.lexically_relative(plan.folder).generic_string(), io::sha256_of_file(file)});
  const std::vector<ViewU8> frames(captures.frames.begin(), captures.frames.end());
  BoardView seen = projector->pattern->read(view.name, frames, plan.board);
  add_image(view.name, plan.cameras[std::size_t(reading.camera)], frames, std::move(seen.decoded),
            read.images);
  reading.in_camera = std::move(seen.detections[kCameraDevice]);
  reading.in_projector = std::move(seen.detections[kProjectorDevice]);
  reading.light_points = std::move(seen.light_points);
  reading.in_camera.diagnostics.append(captures.diagnostics);
  size = frames.front().size();
  return reading;
}

/// The size of most of each camera's images.
CameraSizes common_sizes(const SessionPlan& plan) {
  std::vector<std::vector<fs::path>> folders(plan.cameras.size());
  for (const PlannedView& view : plan.views)
    for (const io::Stack& stack : view.stacks)
      folders[std::size_t(camera_of(plan, stack))].push_back(stack.folder);
  CameraSizes sizes;
  for (const auto& of_camera : folders) sizes.push_back(io::common_image_size(of_camera));
  return sizes;
}

/// The first photograph's size is the camera's; others are rejected and named.
Reading read_photograph(const SessionPlan& plan, const PhotographedView& view, ReadView& read) {
  std::optional<ImageSize>& size = read.sizes.front();
  Reading reading;
  reading.projector = 1;
  reading.in_projector.image_size = plan.projectors.front().size;
  std::vector<ImageU8> images;
  for (const fs::path& file : {view.photograph, view.unlit}) {
    if (file.empty()) continue;
    images.push_back(io::green_channel(io::load_image(file).image));
    if (plan.through_mirror) turn_left_to_right(images.back());
    if (!size) size = images.back().size();
    if (images.back().size() != *size) {
      reading.in_camera.image_size = *size;
      reading.in_camera.diagnostics.warn(
          "image_size_differs", file.filename().string() + " is rejected: it is " +
                                    io::format_size(images.back().size()) + ", the other images are " +
                                    io::format_size(*size));
      return reading;
    }
    read.inputs.push_back({file.lexically_relative(plan.folder).generic_string(), io::sha256_of_file(file)});
  }
  add_image(view.name, plan.cameras.front(), {images.front()}, {}, read.images);
  BoardView seen = read_shown_view(*plan.shown, view, images.front(),
                                   images.size() > 1 ? images.back() : ImageU8(), plan.board);
  reading.in_camera = std::move(seen.detections[kCameraDevice]);
  reading.in_projector = std::move(seen.detections[kProjectorDevice]);
  reading.light_points = std::move(seen.light_points);
  return reading;
}

/// A board missed in one view is a warning; one found nowhere is a wrong --board or no board at all.
void require_board_somewhere(const SessionPlan& plan, const std::vector<std::vector<Reading>>& views) {
  for (const auto& readings : views)
    for (const Reading& reading : readings)
      if (!reading.in_camera.observations.empty() ||
          reading.in_camera.diagnostics.find("image_size_differs") != nullptr)  // it was not looked at
        return;
  const Diagnostics& diagnostics = views.front().front().in_camera.diagnostics;
  const Diagnostic* reason = nullptr;
  for (const char* code : {"board_counts_differ", "board_dictionary_differs", "board_ids_differ",
                           "board_layout_differs", "board_not_found"})
    if (reason == nullptr) reason = diagnostics.find(code);
  throw Error(
      ErrorKind::kInput, "board " + io::format_board(plan.board),
      "no view shows it" +
          (reason != nullptr ? " (" + plan.views.front().name + ": " + reason->message + ")" : ""),
      "give --board as it is printed (of a chessboard the inner corners a row, then the rows), and light "
      "the whole board");
}

/// The session's cameras by their folders; "camera" where frames lie in the views themselves.
std::vector<std::string> cameras_of(const SessionPlan& plan) {
  std::vector<std::string> names;
  for (const PlannedView& view : plan.views)
    for (const io::Stack& stack : view.stacks) {
      if (std::count(names.begin(), names.end(), stack.camera) == 0) names.push_back(stack.camera);
      if (stack.projector.empty() && plan.projectors.size() > 1)
        throw Error(
            ErrorKind::kInput, stack.folder.string(),
            "the session has several projectors, and the folder does not tell whose patterns it holds",
            "put the frames into a folder with the projector's name, e.g. " + view.name + "/" +
                plan.projectors.front().name);
      for (const PlannedProjector& projector : plan.projectors)
        if (projector.name == stack.camera)
          throw Error(ErrorKind::kInput, stack.folder.string(), "a camera and a projector have the same name",
                      "rename the folders of one of them");
    }
  std::sort(names.begin(), names.end(), io::natural_less);
  if (names.size() > 1 && names.front().empty())
    throw Error(ErrorKind::kInput, plan.folder.string(),
                "some views have a folder for each camera (" + names.back() + "), others have none",
                "give every view's frames a folder with their camera's name");
  if (names.front().empty()) names.front() = "camera";
  return names;
}

std::vector<Device> devices_of(const SessionPlan& plan, const CameraSizes& sizes) {
  std::vector<Device> devices;
  for (std::size_t c = 0; c < plan.cameras.size(); ++c)
    devices.push_back({plan.cameras[c], DeviceKind::kCamera, *sizes[c]});
  for (const PlannedProjector& projector : plan.projectors)
    devices.push_back({projector.name, DeviceKind::kProjector, projector.size});
  return devices;
}

ReadView read_view(const SessionPlan& plan, std::size_t number, const CameraSizes& sizes) {
  const PlannedView& view = plan.views[number];
  ReadView read;
  read.sizes = sizes;
  try {
    if (plan.shown) try {
        read.readings.push_back(read_photograph(plan, plan.shown->views[number], read));
      } catch (const Error& error) {
        throw Error(error.kind(), "view " + view.name + ", " + error.subject(), error.why(), error.next());
      }
    for (const io::Stack& stack : view.stacks) try {
        read.readings.push_back(read_stack(plan, view, stack, read));
      } catch (const Error& error) {
        const std::string place = stack.folder.lexically_relative(plan.folder).generic_string();
        throw Error(error.kind(), "view " + place + ", " + error.subject(), error.why(), error.next());
      }
  } catch (...) {
    read.error = std::current_exception();
  }
  return read;
}

/// The views [begin, end), several at a time: none depends on another, so that the result is the same on any
/// number of cores. A view that cannot be read ends the reading.
std::vector<ReadView> read_views(const SessionPlan& plan, int begin, int end, const CameraSizes& sizes,
                                 const ReadingProgress& progress) {
  std::vector<ReadView> views(std::size_t(end - begin));
  std::mutex reporting;
  std::atomic<bool> failed{false};
  parallel_each(end - begin, std::min(thread_count(0), kViewsAtATime), [&](int at) {
    if (failed) return;
    const auto i = std::size_t(begin + at);
    if (progress) {
      const std::lock_guard<std::mutex> lock(reporting);
      progress(plan.views[i].name, int(i), int(plan.views.size()));
    }
    ReadView& read = views[std::size_t(at)] = read_view(plan, i, sizes);
    if (read.error) failed = true;
  });
  return views;
}

/// Two plain boards are the same in a mirror. All pixels then fit a rig whose projector stands on the other side.
/// Projected boards at other places beside each other contradict a mirrored frame.
bool places_show_mirror(const std::vector<BoardView>& views) {
  constexpr double kBesidePx = 20;
  std::map<int, std::pair<double, double>> columns;  // by point: the leftmost and the rightmost
  for (const BoardView& view : views)
    for (const LightPoint& point : view.light_points) {
      const double x = point.projector_pixel.x();
      auto& [low, high] = columns.try_emplace(point.point, x, x).first->second;
      low = std::min(low, x), high = std::max(high, x);
      if (high - low > kBesidePx) return true;
    }
  return false;
}

void tell_what_a_mirror_hides(const SessionPlan& plan, const std::vector<BoardView>& views,
                              Diagnostics& remarks) {
  if (is_coded(plan.board) || plan.decoded) return;
  if (plan.shown && places_show_mirror(views)) return;
  for (const PlannedProjector& projector : plan.projectors)
    if (!plan.shown && (!projector.pattern || !projector.pattern->looks_same_mirrored())) return;
  remarks.note(
      "mirror_not_seen",
      "two plain boards look the same in a mirror: check that words read normally in the camera's images, and "
      "on the wall when the projector shows them. Else the projector is put on the wrong side, and no residual "
      "changes; switch off the mirroring of camera or projector, or use a board or pattern with markers");
}

}  // namespace

void turn_left_to_right(ImageU8& image) {
  turn_rows(image);
}

void turn_left_to_right(ImageF& image) {
  turn_rows(image);
}

SessionPlan open(const fs::path& folder, const OpenOptions& options) {
  const io::SessionInfo& stated = options.stated;
  const ShownFlags& shown = options.shown;
  if (!fs::is_directory(folder))
    throw Error(ErrorKind::kInput, folder.string(), "there is no such folder",
                "check the name; capture-session and simulate-captures write one");
  const io::SessionInfo stored = io::load_session(folder).value_or(io::SessionInfo{});
  const auto ask = [&](const std::string& what, const std::string& flag) {
    return Error(ErrorKind::kInput, folder.string(), "neither a flag nor session.json states the " + what,
                 "give " + flag);
  };
  SessionPlan plan;
  plan.folder = folder;
  const bool flags_say = stated.projector_size || !stated.projectors.empty();
  const io::SessionInfo& says_size = flags_say ? stated : stored;
  std::map<std::string, ImageSize> sizes = says_size.projectors;
  if (says_size.projector_size) sizes["projector"] = *says_size.projector_size;
  const auto board = stated.board ? stated.board : stored.board;
  if (board && sizes.size() < 2) {
    plan.shown = plan_shown_views(
        folder, shown, sizes.empty() ? std::nullopt : std::optional(sizes.begin()->second), *board);
    if (plan.shown && sizes.empty()) sizes["projector"] = plan.shown->projector_size;
  }
  if (!plan.shown && shown.upright)
    throw Error(ErrorKind::kInput, "--upright", "it has no effect on sessions of several frames a view",
                "leave it out, or name what was shown in each photograph with --shown");
  if (plan.shown && (!stated.pattern.empty() || stated.step))
    throw Error(ErrorKind::kInput, "--pattern, --step", "they have no effect on sessions of photographs",
                "leave them out: shown.json names what was shown");
  if (sizes.empty()) throw ask("projector's size", "--projector-size 1024x768");
  if (!board && options.needs_board) throw ask("board", "--board chessboard:7x9:75mm");
  if (board) plan.board = *board;
  if (plan.shown) {
    plan.projectors.push_back({sizes.begin()->first, sizes.begin()->second, nullptr});
    for (const PhotographedView& view : plan.shown->views) plan.views.push_back({view.name, {}});
    plan.cameras = {"camera"};
    return plan;
  }
  plan.step = (stated.step ? stated.step : stored.step).value_or(1);
  std::string pattern = !stated.pattern.empty()   ? stated.pattern
                        : !stored.pattern.empty() ? stored.pattern
                                                  : "gray";
  // session.json names a file beside it.
  if (stated.pattern.empty() && fs::path(pattern).extension() == ".json")
    pattern = (folder / pattern).string();
  if (fs::path(pattern).extension() == ".json") plan.pattern_file = pattern;
  plan.decoded = pattern == kDecodedMaps;
  std::vector<std::string> projector_names;
  for (const auto& [name, size] : sizes) {
    plan.projectors.push_back({name, size, plan.decoded ? nullptr : make_pattern(pattern, size, plan.step)});
    projector_names.push_back(name);
  }
  for (const fs::path& view : io::list_views(folder))
    plan.views.push_back({view.filename().string(), io::list_stacks(view, projector_names)});
  plan.cameras = cameras_of(plan);
  return plan;
}

SessionContents read(const SessionPlan& plan, const ReadingProgress& progress) {
  SessionContents contents;
  if (!plan.pattern_file.empty())
    contents.inputs.push_back({plan.pattern_file.filename().string(), io::sha256_of_file(plan.pattern_file)});
  std::vector<std::vector<Reading>> readings;
  CameraSizes sizes = plan.shown ? CameraSizes(1) : common_sizes(plan);
  const int count = int(plan.views.size()), first = std::min(count, kViewsBeforeGivingUp);
  const int alone = plan.shown ? std::min(count, 1) : 0;  // the first photograph fixes the size of all
  for (const auto& [begin, end] : {std::pair(0, alone), std::pair(alone, first), std::pair(first, count)}) {
    for (ReadView& view : read_views(plan, begin, end, sizes, progress)) {
      if (view.error) std::rethrow_exception(view.error);
      readings.push_back(std::move(view.readings));
      contents.inputs.insert(contents.inputs.end(), view.inputs.begin(), view.inputs.end());
      std::move(view.images.begin(), view.images.end(), std::back_inserter(contents.view_images));
      for (std::size_t c = 0; c < sizes.size(); ++c)
        if (view.sizes[c]) sizes[c] = view.sizes[c];
    }
    if (end == kViewsBeforeGivingUp) require_board_somewhere(plan, readings);
  }
  require_board_somewhere(plan, readings);
  const std::vector<Device> devices = devices_of(plan, sizes);
  std::vector<BoardView> views;
  for (std::size_t i = 0; i < plan.views.size(); ++i)
    views.push_back(combine(plan.views[i].name, devices, readings[i]));
  contents.correspondences = join(plan.board, devices, views);
  warn_of_identical_files(contents.inputs, contents.correspondences.diagnostics);
  tell_what_a_mirror_hides(plan, views, contents.correspondences.diagnostics);
  std::string projector_sizes;
  for (const PlannedProjector& projector : plan.projectors)
    projector_sizes += (projector_sizes.empty() ? "" : " ") +
                       (plan.projectors.size() > 1 ? projector.name + "=" : "") +
                       io::format_size(projector.size);
  contents.options = {{"pattern", pattern_text(plan)},
                      {"projector-size", projector_sizes},
                      {"step", std::to_string(plan.step)},
                      {"board", io::format_board(plan.board)}};
  contents.views = int(plan.views.size());
  contents.title = folder_name(plan.folder);
  return contents;
}

std::string pattern_text(const SessionPlan& plan) {
  return plan.shown ? "shown" : plan.decoded ? kDecodedMaps : plan.projectors.front().pattern->text();
}

std::vector<Device> session_devices(ImageSize camera_size, ImageSize projector_size) {
  return {{"camera", DeviceKind::kCamera, camera_size},
          {"projector", DeviceKind::kProjector, projector_size}};
}

}  // namespace procam::session
