#include "project.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <system_error>

#include "procam/core/base/error.hpp"
#include "procam/io/files.hpp"
#include "procam/session/files.hpp"

namespace procam::studio {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::array<const char*, kSteps> kStepNames = {"display",   "camera",   "board",   "capture",
                                                        "calibrate", "surfaces", "content", "show"};
constexpr std::size_t kLargestFile = 65536, kMaxDisplays = 16;

/// One field of studio.json in both directions.
class Fields {
 public:
  Fields(json& document, bool reading, std::string file)
      : document_(document), reading_(reading), file_(std::move(file)) {}

  void field(const char* name, std::string& value) {
    if (!reading_) {
      document_[name] = value;
    } else if (const json* found = take(name)) {
      if (!found->is_string() || found->get<std::string>().size() > 4096) refuse(name, "it is no short text");
      value = found->get<std::string>();
    }
  }
  /// Absent where it is empty.
  void field(const char* name, std::vector<std::string>& values) {
    if (!reading_) {
      if (!values.empty()) document_[name] = values;
    } else if (const json* found = take(name)) {
      if (!found->is_array() || found->size() > kMaxDisplays) refuse(name, "it is no short list");
      values.clear();
      for (const json& one : *found) {
        if (!one.is_string() || one.get<std::string>().empty() || one.get<std::string>().size() > 4096)
          refuse(name, "it holds something else than short texts");
        values.push_back(one.get<std::string>());
      }
    }
  }
  template <typename Number>
  void field(const char* name, Number& value, Number low, Number high) {
    if (!reading_) {
      document_[name] = value;
    } else if (const json* found = take(name)) {
      if (!found->is_number()) refuse(name, "it is no number");
      const double number = found->get<double>();
      if (!(number >= double(low) && number <= double(high))) refuse(name, "it is out of range");
      value = Number(number);
    }
  }
  void end() const {
    if (reading_ && !document_.empty())
      refuse(document_.begin().key().c_str(), "there is no such field in a studio file of this version");
  }
  [[noreturn]] void refuse(const std::string& name, const std::string& why) const {
    throw Error(ErrorKind::kInput, file_ + ": " + name, why,
                "correct it, or move studio.json away: the results beside it stay");
  }

 private:
  /// Removes it from the document, so that what is left is unknown.
  const json* take(const char* name) {
    const auto found = document_.find(name);
    if (found == document_.end()) return nullptr;
    taken_ = *found;
    document_.erase(found);
    return &taken_;
  }

  json& document_;
  json taken_;
  bool reading_;
  std::string file_;
};

void list_fields(Fields& fields, Choices& choices) {
  std::string step = to_string(choices.step);
  fields.field("step", step);
  if (const auto known = step_named(step))
    choices.step = *known;
  else
    fields.refuse("step", "'" + step + "' is no step");
  fields.field("display", choices.display);
  fields.field("further_displays", choices.further_displays);
  fields.field("camera", choices.camera);
  fields.field("camera_size", choices.camera_size);
  fields.field("exposure", choices.exposure);
  fields.field("paper", choices.paper);
  fields.field("board", choices.board);
  fields.field("measured", choices.measured);
  fields.field("pattern", choices.pattern);
  fields.field("views", choices.views, 3, 100);
  fields.field("accept_mm", choices.accept_mm, 1e-3, 1e4);
  fields.field("measure_by", choices.measure_by);
  fields.field("depth", choices.depth);
  fields.field("marker", choices.marker);
  fields.field("camera_checked", choices.camera_checked, 0, 1);
  fields.end();
}

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

}  // namespace

const char* to_string(Step step) {
  return kStepNames[std::size_t(step)];
}
std::optional<Step> step_named(const std::string& name) {
  for (int i = 0; i < kSteps; ++i)
    if (name == kStepNames[std::size_t(i)]) return Step(i);
  return std::nullopt;
}

std::vector<ChosenProjector> Choices::projectors() const {
  if (display.empty()) return {};
  if (further_displays.empty()) return {{"", display}};
  std::vector<ChosenProjector> all = {{"projector_1", display}};
  for (const std::string& one : further_displays)
    all.push_back({"projector_" + std::to_string(all.size() + 1), one});
  return all;
}

Project::Project(const fs::path& folder) : folder_(fs::absolute(folder).lexically_normal()) {
  session::make_folder(folder_);
  const fs::path file = folder_ / "studio.json";
  if (!is_there(file)) return;
  json document = json::parse(io::read_file(file, kLargestFile), nullptr, false);
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorKind::kInput, file.string(), why, "move it away: the results beside it stay");
  };
  if (!document.is_object() || document.value("format", json()) != "procam-studio")
    refuse("it is no studio file");
  if (document.value("version", json()) != 1) refuse("it is of another version");
  document.erase("format");
  document.erase("version");
  Fields fields(document, true, file.string());
  list_fields(fields, choices);
}

void Project::save() const {
  nlohmann::json document = {{"format", "procam-studio"}, {"version", 1}};
  Fields fields(document, false, (folder_ / "studio.json").string());
  Choices written = choices;
  list_fields(fields, written);
  io::write_file_atomically(folder_ / "studio.json", document.dump(2) + "\n");
}

int Project::views_captured() const {
  int count = 0;
  while (count < choices.views && session::is_complete(session(), std::size_t(count))) ++count;
  return count;
}

std::vector<std::string> Project::surface_files() const {
  constexpr std::size_t kMaxFiles = 200;
  const std::vector<fs::path> own = {"studio.json", board().filename(), rig().filename(),
                                     surfaces().filename(), show().filename()};
  std::vector<std::string> names;
  std::error_code ignored;
  for (fs::directory_iterator file(folder_, ignored), end; file != end && names.size() < kMaxFiles;
       file.increment(ignored)) {
    const fs::path name = file->path().filename();
    if (name.extension() == ".json" && file->is_regular_file(ignored) &&
        std::find(own.begin(), own.end(), name) == own.end())
      names.push_back(name.string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool Project::is_wall_measured() const {
  if (choices.measure_by == "size") return true;
  return is_there(choices.measure_by == "depth"    ? wall_depth()
                  : choices.measure_by == "marker" ? wall_marker()
                                                   : scan() / "view_00");
}

bool Project::is_done(Step step) const {
  switch (step) {
    case Step::kDisplay:
      return !choices.display.empty();
    case Step::kCamera:
      return !choices.camera.empty() && choices.camera_checked == 1;
    case Step::kBoard:
      return is_there(board());
    case Step::kCapture:
      return views_captured() >= choices.views;
    case Step::kCalibrate:
      return is_there(rig());
    case Step::kSurfaces:
    case Step::kContent:
      return is_there(surfaces());
    case Step::kShow:
      return is_there(show());
  }
  return false;
}

}  // namespace procam::studio
