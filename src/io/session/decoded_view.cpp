#include "procam/io/session/decoded_view.hpp"

#include <algorithm>
#include <system_error>

#include "image/npy.hpp"
#include "image/pfm_bytes.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/image/pfm.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/io/text.hpp"
#include "session/white_image.hpp"

namespace procam::io {
namespace {

namespace fs = std::filesystem;

const char* const kFiles = "give columns and rows (.npy or .pfm), or map.npy of height x width x 2";

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

std::string shape_text(const std::vector<std::size_t>& shape) {
  std::string text;
  for (const std::size_t n : shape) text += (text.empty() ? "" : "x") + std::to_string(n);
  return text;
}

/// "columns.npy" or "columns.pfm"; empty where there is neither.
fs::path map_file(const fs::path& folder, const std::string& name) {
  const fs::path npy = folder / (name + ".npy"), pfm = folder / (name + ".pfm");
  if (is_there(npy) && is_there(pfm))
    throw Error(ErrorKind::kInput, npy.string(), "there is " + pfm.filename().string() + " as well",
                "keep one of them");
  return is_there(npy) ? npy : is_there(pfm) ? pfm : fs::path();
}

void require_size(const fs::path& file, ImageSize found, ImageSize white) {
  if (found == white) return;
  const bool is_transposed = found.width == white.height && found.height == white.width;
  throw Error(ErrorKind::kInput, file.string(),
              "it has " + format_size(found) + " pixels, the white image " + format_size(white) +
                  (is_transposed ? ": x and y are exchanged" : ""),
              is_transposed ? "save the transposed array: one row of it for each row of the image"
                            : "give the map at the full size of the camera's image");
}

ImageF from_array(const fs::path& file, const NpyArray& array, std::size_t channels) {
  const std::size_t dimensions = channels == 1 ? 2 : 3;
  const bool fits = array.columns.empty() && array.shape.size() == dimensions &&
                    (channels == 1 || array.shape[2] == channels);
  if (!fits) {
    const bool channels_first = channels == 2 && array.shape.size() == 3 && array.shape[0] == 2;
    throw Error(ErrorKind::kInput, file.string(),
                !array.columns.empty()
                    ? std::string("it is a table, not an array")
                    : "its shape is " + shape_text(array.shape) + " where " +
                          (channels == 1 ? "height x width" : "height x width x 2") + " is expected",
                channels_first ? "save np.moveaxis(map, 0, -1)" : kFiles);
  }
  ImageF image(int(array.shape[1]), int(array.shape[0]), int(channels));
  std::transform(array.values.begin(), array.values.end(), image.data(), [](double v) { return float(v); });
  return image;
}

ImageF load_map(const fs::path& file) {
  if (file.extension() == ".npy") return from_array(file, load_npy(file), 1);
  ImageF image = load_pfm(file);
  if (image.channels() != 1)
    throw Error(ErrorKind::kInput, file.string(), "it has three channels where one is expected", kFiles);
  return image;
}

}  // namespace

fs::path white_image(const fs::path& folder) {
  const std::vector<fs::path> images = list_images(folder);
  for (const fs::path& image : images)
    if (image.stem() == "white") return image;
  if (images.size() == 1) return images.front();
  throw Error(ErrorKind::kInput, folder.string(),
              images.empty()
                  ? "it holds no image of the board"
                  : "it holds " + std::to_string(images.size()) + " images, and none is called white",
              "add white.png, the board under the projector's full light");
}

DecodedView load_decoded_view(const fs::path& folder) {
  DecodedView view;
  const fs::path white = white_image(folder);
  LoadedImage loaded = load_image(white);
  view.white = green_channel(loaded.image);
  view.diagnostics = std::move(loaded.diagnostics);
  view.files.push_back(white);

  const fs::path both = folder / "map.npy", columns = map_file(folder, "columns"),
                 rows = map_file(folder, "rows");
  if (is_there(both)) {
    if (!columns.empty() || !rows.empty())
      throw Error(ErrorKind::kInput, both.string(),
                  "there is " + (columns.empty() ? rows : columns).filename().string() + " as well",
                  "keep the array of both, or one of columns and one of rows");
    view.pixels = from_array(both, load_npy(both), 2);
    require_size(both, view.pixels.size(), view.white.size());
    view.files.push_back(both);
    return view;
  }
  if (columns.empty() || rows.empty())
    throw Error(ErrorKind::kInput, folder.string(),
                columns.empty() && rows.empty()
                    ? std::string("it holds no decoded map")
                    : "it holds " + (columns.empty() ? rows : columns).filename().string() + " alone",
                kFiles);
  view.pixels = ImageF(view.white.size(), 2);
  for (int channel = 0; channel < 2; ++channel) {
    const fs::path& file = channel == 0 ? columns : rows;
    const ImageF map = load_map(file);
    require_size(file, map.size(), view.white.size());
    for (int y = 0; y < map.height(); ++y)
      for (int x = 0; x < map.width(); ++x) view.pixels.at(x, y, channel) = map.at(x, y);
    view.files.push_back(file);
  }
  return view;
}

}  // namespace procam::io
