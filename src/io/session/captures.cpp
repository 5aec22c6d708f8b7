#include "procam/io/session/captures.hpp"

#include <algorithm>
#include <set>

#include "procam/core/base/parallel.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/text.hpp"

namespace procam::io {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& why, const std::string& next) {
  throw Error(ErrorKind::kInput, path.string(), why, next);
}

/// A file's name taken apart round its number: "graycode_" 07 ".png".
struct NumberedName {
  std::string before, digits, after;

  /// The digits without leading zeros: of any length, so no conversion can overflow.
  std::string number() const {
    const std::size_t first = std::min(digits.find_first_not_of('0'), digits.size() - 1);
    return digits.substr(first);
  }
};

/// By the last run of digits before the extension; no digits: none.
NumberedName take_apart(const fs::path& file) {
  const std::string name = file.filename().string(), stem = file.stem().string();
  const std::size_t last = stem.find_last_of("0123456789");
  if (last == std::string::npos) return {name, "", ""};
  const std::size_t first = stem.find_last_not_of("0123456789", last) + 1;  // npos + 1 == 0
  return {stem.substr(0, first), stem.substr(first, last + 1 - first), name.substr(last + 1)};
}

bool has_image_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return char(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
  static const std::set<std::string> known{".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff"};
  return known.count(extension) != 0;
}

/// Files or folders of a folder that fulfil a condition, in natural order; hidden ones are skipped.
template <typename Condition>
std::vector<fs::path> list(const fs::path& folder, Condition condition) {
  std::vector<fs::path> found;
  try {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
      if (entry.path().filename().string().front() != '.' && condition(entry)) found.push_back(entry.path());
  } catch (const fs::filesystem_error& error) {
    throw Error(ErrorKind::kIo, folder.string(), "cannot read the folder: " + error.code().message(),
                "check the name and whether you may read it");
  }
  std::sort(found.begin(), found.end(), [](const fs::path& a, const fs::path& b) {
    return natural_less(a.filename().string(), b.filename().string());
  });
  return found;
}

std::vector<fs::path> images_in(const fs::path& folder) {
  return list(folder, [](const fs::directory_entry& entry) {
    return entry.is_regular_file() && has_image_extension(entry.path());
  });
}

/// Where further stacks may be; capture-session keeps frames that it did not take in "rejected".
std::vector<fs::path> stack_folders(const fs::path& folder) {
  return list(folder, [](const fs::directory_entry& entry) {
    return entry.is_directory() && entry.path().filename() != "rejected";
  });
}

std::string successor(std::string number) {
  for (std::size_t i = number.size(); i-- > 0;) {
    if (number[i] != '9') return ++number[i], number;
    number[i] = '0';
  }
  return "1" + number;
}

/// The series must be one, its numbers unique and without a gap.
void check_numbering(const fs::path& folder, const std::vector<fs::path>& files) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    const NumberedName name = take_apart(files[i]);
    if (name.digits.empty())
      fail(files[i], "the image has no number in its name, so its place among the frames is unknown",
           "number it, or move it out of the folder");
    if (i == 0) continue;
    const NumberedName before = take_apart(files[i - 1]);
    if (name.before != before.before || name.after != before.after) {
      if (name.before == before.before && name.number() == before.number())
        fail(folder,
             "two files have number " + name.number() + ": " + files[i - 1].filename().string() + " and " +
                 files[i].filename().string(),
             "keep one of them");
      fail(folder,
           "it holds images of two series: " + files[i - 1].filename().string() + " and " +
               files[i].filename().string(),
           "keep the frames of one pattern stack in a folder, named alike but for their numbers");
    }
    if (name.number() == before.number())
      fail(folder,
           "two files have number " + name.number() + ": " + files[i - 1].filename().string() + " and " +
               files[i].filename().string(),
           "keep one of them");
    const std::string expected = successor(before.number());
    if (name.number() != expected) {
      const std::size_t width = before.digits.size();
      const std::string padded =
          expected.size() < width ? std::string(width - expected.size(), '0') + expected : expected;
      fail(folder,
           "frame " + name.before + padded + name.after + " is missing: " + files[i - 1].filename().string() +
               " is followed by " + files[i].filename().string(),
           "capture the pose again or restore the file");
    }
  }
}

/// Of pixels of 16 bits that are below 2^14 all, reduced to 8.
constexpr int kGreyOf14Bits = 64;

int largest_grey(const std::vector<ImageU8>& frames) {
  int largest = 0;
  for (const ImageU8& frame : frames)
    for (int y = 0; y < frame.height(); ++y)
      largest = std::max<int>(
          largest,
          *std::max_element(frame.row(y), frame.row(y) + std::ptrdiff_t(frame.width()) * frame.channels()));
  return largest;
}

ImageU8 without_alpha(ImageU8 image) {
  if (image.channels() == 3) return image;
  ImageU8 rgb(image.size(), 3);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      for (int c = 0; c < 3; ++c) rgb.at(x, y, c) = image.at(x, y, c);
  return rgb;
}

}  // namespace

std::optional<ImageSize> common_image_size(const std::vector<fs::path>& folders) {
  std::vector<std::pair<ImageSize, int>> counts;
  for (const fs::path& folder : folders)
    for (const fs::path& file : images_in(folder)) {
      const std::optional<ImageSize> size = image_size(file);
      if (!size) continue;
      auto at = std::find_if(counts.begin(), counts.end(), [&](const auto& c) { return c.first == *size; });
      if (at == counts.end()) at = counts.insert(at, {*size, 0});
      ++at->second;
    }
  if (counts.empty()) return std::nullopt;
  return std::max_element(counts.begin(), counts.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

/// Moves images of another size from `files` into one warning.
static void reject_sizes(const fs::path& folder, ImageSize size, std::vector<fs::path>& files,
                         Diagnostics& diagnostics) {
  std::string names;
  int count = 0;
  const auto other = [&](const fs::path& file) {
    const std::optional<ImageSize> found = image_size(file);
    if (!found || *found == size) return false;
    constexpr int kMaxNames = 3;
    if (++count <= kMaxNames)
      names += (names.empty() ? "" : ", ") + file.filename().string() + " (" + format_size(*found) + ")";
    return true;
  };
  files.erase(std::remove_if(files.begin(), files.end(), other), files.end());
  if (count == 0) return;
  const std::string more = count > 3 ? " and " + std::to_string(count - 3) + " more" : "";
  diagnostics.warn("image_size_differs", folder.string() + ": rejected for their size: " + names + more +
                                             "; the camera's other images are " + format_size(size));
}

CaptureFolder load_capture_folder(const fs::path& folder, int expected_frames, int channels,
                                  const std::optional<ImageSize>& common_size) {
  require(expected_frames > 0, "load_capture_folder: no frames are expected");
  require(channels == 1 || channels == 3, "load_capture_folder: frames have one channel or three");
  CaptureFolder captures;
  captures.files = images_in(folder);
  if (common_size) reject_sizes(folder, *common_size, captures.files, captures.diagnostics);
  if (!captures.diagnostics.items.empty() && int(captures.files.size()) < expected_frames) {
    captures.files.clear();
    return captures;
  }
  const std::vector<fs::path>& files = captures.files;
  if (files.empty())
    fail(folder, "there is no image in the folder", "give a folder of numbered png, jpg, bmp or tif files");
  check_numbering(folder, files);
  if (int(files.size()) != expected_frames)
    fail(folder,
         std::to_string(files.size()) + " frames where the pattern has " + std::to_string(expected_frames) +
             " (" + files.front().filename().string() + " to " + files.back().filename().string() + ")",
         "check the pattern, the projector size and whether frames are missing at the begin or the end");

  std::vector<LoadedImage> images(files.size());
  parallel_for(int(files.size()), 0, [&](int begin, int end) {
    for (int i = begin; i < end; ++i) images[std::size_t(i)] = load_image(files[std::size_t(i)]);
  });
  bool reduced = false, colour = false;
  for (std::size_t i = 0; i < files.size(); ++i) {
    const fs::path& file = files[i];
    LoadedImage& loaded = images[i];
    reduced |= loaded.diagnostics.find("reduced_to_8_bit") != nullptr;
    if (channels == 3) {
      if (loaded.image.channels() < 3)
        fail(file, "it is grey where the pattern needs colour",
             "capture in colour, or show the pattern without ':colour'");
      captures.frames.push_back(without_alpha(std::move(loaded.image)));
    } else {
      colour |= loaded.image.channels() > 1;
      captures.frames.push_back(loaded.image.channels() > 1 ? green_channel(loaded.image)
                                                            : std::move(loaded.image));
    }
    const ImageSize size = captures.frames.back().size(), first = captures.frames.front().size();
    if (size != first)
      fail(folder,
           "its frames have two sizes: " + files.front().filename().string() + " is " + format_size(first) +
               " and " + file.filename().string() + " is " + format_size(size),
           "keep the frames of one capture in a folder");
  }
  if (reduced)
    captures.diagnostics.note("reduced_to_8_bit", folder.string() + ": frames of 16 bits were reduced to 8");
  if (reduced && largest_grey(captures.frames) < kGreyOf14Bits)
    captures.diagnostics.warn(
        "bits_unused",
        folder.string() +
            ": frames of 16 bits use less than 14 of them, as a camera of 10 or 12 bits writes "
            "them: multiply by 64 or 16, so that full scale is 65535, or save 8 bits");
  if (colour)
    captures.diagnostics.note("reduced_to_gray",
                              folder.string() + ": of colour frames the green channel was measured");
  return captures;
}

/// A stack, or folders of stacks, no deeper than projector/camera.
static bool holds_frames(const fs::path& folder, int levels) {
  if (!images_in(folder).empty()) return true;
  for (const fs::path& inner : stack_folders(folder))
    if (levels > 0 && holds_frames(inner, levels - 1)) return true;
  return false;
}

std::vector<Stack> list_stacks(const fs::path& view_folder, const std::vector<std::string>& projectors) {
  const auto below = [](const fs::path& folder) {
    std::vector<fs::path> inner;
    for (const fs::path& stack : stack_folders(folder))
      if (holds_frames(stack, 1)) inner.push_back(stack);
    if (!inner.empty() && !images_in(folder).empty())
      fail(folder, "it holds images beside folders of images (" + inner.front().filename().string() + ")",
           "put one camera's frames into the view's folder, or each camera's into a folder of its own");
    return inner;
  };
  std::vector<Stack> stacks;
  if (below(view_folder).empty()) stacks.push_back({"", "", view_folder});
  for (const fs::path& first : below(view_folder)) {
    const std::string name = first.filename().string();
    if (std::count(projectors.begin(), projectors.end(), name) == 0) {
      if (!below(first).empty())
        fail(first, "it holds folders of images, and no projector of that name is known",
             "state the projectors by the names of their folders: --projector-size " + name + "=1024x768");
      stacks.push_back({"", name, first});
      continue;
    }
    const std::vector<fs::path> cameras = below(first);
    if (cameras.empty()) stacks.push_back({name, "", first});
    for (const fs::path& camera : cameras) stacks.push_back({name, camera.filename().string(), camera});
  }
  return stacks;
}

std::vector<fs::path> list_images(const fs::path& folder) {
  return images_in(folder);
}

std::vector<fs::path> list_views(const fs::path& session_folder) {
  const std::vector<fs::path> views = list(session_folder, [](const fs::directory_entry& entry) {
    return entry.is_directory() && holds_frames(entry.path(), 2);
  });
  if (views.empty()) {
    const std::size_t images = images_in(session_folder).size();
    fail(
        session_folder,
        images > 0 ? "it holds " + std::to_string(images) +
                         " images itself, and none of its sub-folders holds images"
                   : "none of its sub-folders holds images",
        "give a session folder with one sub-folder of numbered images a board pose; for one photograph a "
        "view that shows a printed and a projected board, give --shown (docs/patterns.md); for photographs of a "
        "printed board alone, use calibrate-camera --images");
  }
  return views;
}

}  // namespace procam::io
