#include "procam/report/files.hpp"

#include <map>
#include <optional>
#include <regex>
#include <system_error>

#include "csv.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/io/csv_table.hpp"
#include "procam/io/files.hpp"
#include "style.hpp"

namespace procam::report {
namespace {

/// "--ink: #1d2327; ..." of the light theme, which the style sheet states first.
std::map<std::string, std::string> light_colors() {
  const std::string style = kReportStyle;
  const std::string root = style.substr(style.find(":root {"), style.find('}') - style.find(":root {"));
  static const std::regex entry("(--[a-z]+): (#[0-9a-fA-F]+)");
  std::map<std::string, std::string> colors;
  for (std::sregex_iterator at(root.begin(), root.end(), entry), end; at != end; ++at)
    colors[(*at)[1]] = (*at)[2];
  return colors;
}

std::string with_colors(const std::string& text) {
  static const std::map<std::string, std::string> colors = light_colors();
  std::string out;
  for (std::size_t from = 0;;) {
    const std::size_t at = text.find("var(", from), end = text.find(')', at);
    out += text.substr(from, at - from);
    if (at == std::string::npos || end == std::string::npos) return out;
    const auto color = colors.find(text.substr(at + 4, end - at - 4));
    out += color != colors.end() ? color->second : "#000000";
    from = end + 1;
  }
}

/// The style sheet's rules for figures.
const std::string& figure_style() {
  static const std::string style = [] {
    const std::string all = kReportStyle;
    static const std::regex rule("(svg[^{}]*)\\{([^{}]*)\\}");
    std::string out =
        "text { font-family: system-ui, 'DejaVu Sans', sans-serif; font-size: 11px; fill: var(--ink); }\n";
    for (std::sregex_iterator at(all.begin(), all.end(), rule), end; at != end; ++at) {
      if ((*at)[1] == "svg ") continue;  // the size and the background in the page
      out += (*at)[1].str() + "{" + (*at)[2].str() + "}\n";
    }
    return with_colors(out);
  }();
  return style;
}

/// The value of an attribute in a tag; empty where it has none.
std::string attribute(const std::string& tag, const std::string& name) {
  const std::size_t at = tag.find(" " + name + "=\"");
  if (at == std::string::npos) return "";
  const std::size_t begin = at + name.size() + 3;
  return tag.substr(begin, tag.find('"', begin) - begin);
}

/// Letters and digits of a description, the rest as "_".
std::string file_name(const std::string& description) {
  std::string name;
  for (const char c : description) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    const bool capital = c >= 'A' && c <= 'Z';
    if (plain || capital)
      name += capital ? char(c - 'A' + 'a') : c;
    else if (!name.empty() && name.back() != '_')
      name += '_';
    if (name.size() >= 60) break;
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  return name.empty() ? "figure" : name;
}

std::string as_file(const std::string& tag, const std::string& content) {
  const std::string view_box = attribute(tag, "viewBox");
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"" +
         view_box + "\">\n<title>" + attribute(tag, "aria-label") + "</title>\n<style>\n" + figure_style() +
         "</style>\n" + with_colors(content) + "</svg>\n";
}

std::vector<std::string> pose_cells(const Pose& pose) {
  const Vec3 rotation = so3_log(pose.rotation);
  std::vector<std::string> cells;
  for (const Vec3& part : {rotation, pose.translation})
    for (int i = 0; i < 3; ++i) cells.push_back(csv_number(part[i]));
  return cells;
}

std::string parameters_table(const Rig& rig) {
  std::string table = "name,value,sigma\n";
  const auto add = [&](const std::string& name, double value, const std::string& sigma_of) {
    const std::optional<Eigen::Index> known = rig.covariance.index_of(sigma_of);
    add_csv_row(table, {csv_quoted(name), csv_number(value),
                        known ? csv_number(rig.covariance.sigma(sigma_of)) : ""});
  };
  const auto add_device = [&](const std::string& device, const Camera& lens, const Pose& rig_from_device) {
    const std::vector<std::string> names = parameter_names(lens);
    const VecX values = parameters_of(lens);
    for (std::size_t i = 0; i < names.size(); ++i)
      add(device + "." + names[i], values[Eigen::Index(i)], device + "." + names[i]);
    const std::vector<std::string> increments = pose_increment_names("rig_from_" + device);
    const Vec3 rotation = so3_log(rig_from_device.rotation);
    for (int i = 0; i < 6; ++i)
      add(increments[std::size_t(i)], i < 3 ? rotation[i] : rig_from_device.translation[i - 3],
          increments[std::size_t(i)]);
  };
  for (const RigCamera& camera : rig.cameras) add_device(camera.name, camera.camera, camera.rig_from_camera);
  for (const RigProjector& projector : rig.projectors)
    add_device(projector.name, projector.projector.inverse_camera, projector.rig_from_projector);
  return table;
}

std::string covariance_table(const NamedCovariance& covariance) {
  std::string table = "name";
  for (const std::string& name : covariance.names) table += "," + csv_quoted(name);
  table += "\n";
  for (Eigen::Index i = 0; i < covariance.matrix.rows(); ++i) {
    std::vector<std::string> cells{csv_quoted(covariance.names[std::size_t(i)])};
    for (Eigen::Index j = 0; j < covariance.matrix.cols(); ++j)
      cells.push_back(csv_number(covariance.matrix(i, j)));
    add_csv_row(table, cells);
  }
  return table;
}

std::string views_table(const calibrate::CalibrationResult& result) {
  std::string table = "view,used,rx,ry,rz,tx,ty,tz";
  for (const Device& device : result.devices) table += "," + csv_quoted("rms_px " + device.name);
  table += ",share,note\n";
  for (const calibrate::ViewResult& view : result.views) {
    std::vector<std::string> cells{csv_quoted(view.name), view.used ? "1" : "0"};
    for (const std::string& cell : pose_cells(view.rig_from_board)) cells.push_back(view.used ? cell : "");
    for (std::size_t d = 0; d < result.devices.size(); ++d)
      cells.push_back(d < view.rms_px.size() ? csv_number(view.rms_px[d]) : "");
    cells.push_back(csv_number(view.share));
    cells.push_back(csv_quoted(view.note));
    add_csv_row(table, cells);
  }
  return table;
}

std::string residuals_table(const calibrate::CalibrationResult& result) {
  std::string table = "view,device,point,x,y,residual_x,residual_y,used,reason\n";
  for (const calibrate::Residual& r : result.residuals)
    add_csv_row(table, {csv_quoted(result.views[std::size_t(r.view)].name),
                        csv_quoted(result.devices[std::size_t(r.device)].name), std::to_string(r.point),
                        csv_number(r.pixel.x()), csv_number(r.pixel.y()), csv_number(r.residual.x()),
                        csv_number(r.residual.y()), r.used ? "1" : "0", csv_quoted(r.reason)});
  return table;
}

}  // namespace

std::vector<TextFile> figures(const std::string& page) {
  std::vector<TextFile> files;
  std::map<std::string, int> times;
  for (std::size_t at = 0; (at = page.find("<svg ", at)) != std::string::npos;) {
    const std::size_t tag_end = page.find('>', at), end = page.find("</svg>", at);
    if (tag_end == std::string::npos || end == std::string::npos || tag_end > end) break;
    const std::string tag = page.substr(at, tag_end - at);
    const std::string name = file_name(attribute(tag, "aria-label"));
    const int time = ++times[name];
    files.push_back({name + (time > 1 ? "_" + std::to_string(time) : "") + ".svg",
                     as_file(tag, page.substr(tag_end + 1, end - tag_end - 1))});
    at = end;
  }
  return files;
}

void require_folder(const std::filesystem::path& folder) {
  io::require_writable(std::filesystem::is_directory(folder) ? folder / "files" : folder);
}

void save_files(const std::filesystem::path& folder, const std::vector<TextFile>& files) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw Error(ErrorKind::kIo, folder.string(), "the folder cannot be made: " + error.message(),
                "name a folder that can be written");
  for (const TextFile& file : files) {
    const std::filesystem::path path = folder / file.name;
    io::write_file_atomically(path, file.text);
    if (path.extension() == ".csv")
      io::write_file_atomically(std::filesystem::path(path).replace_extension(".npy"),
                                io::npy_of_csv(file.text));
  }
}

std::vector<TextFile> calibration_tables(const calibrate::CalibrationResult& result) {
  std::vector<TextFile> files{{"parameters.csv", parameters_table(result.rig)},
                              {"views.csv", views_table(result)},
                              {"residuals.csv", residuals_table(result)}};
  if (!result.rig.covariance.empty())
    files.push_back({"covariance.csv", covariance_table(result.rig.covariance)});
  return files;
}

}  // namespace procam::report
