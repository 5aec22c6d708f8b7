#include <algorithm>
#include <charconv>
#include <set>

#include "content_files.hpp"
#include "playback.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"

namespace procam::device::internal {

namespace {

namespace fs = std::filesystem;

constexpr double kUsualRate = 25;  // pictures a second

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// Does `*` stand for any text, `?` for one character?
bool matches(const char* pattern, const char* text) {
  for (; *pattern != '\0'; ++pattern, ++text) {
    if (*pattern == '*') {
      for (const char* rest = text;; ++rest) {
        if (matches(pattern + 1, rest)) return true;
        if (*rest == '\0') return false;
      }
    }
    if (*text == '\0' || (*pattern != '?' && *pattern != *text)) return false;
  }
  return *text == '\0';
}

/// shot_%04d.png
struct Numbered {
  std::string before, after;
  std::size_t digits = 0;  ///< at least so many, with zeros before

  static std::optional<Numbered> parse(const std::string& name) {
    const std::size_t percent = name.find('%');
    if (percent == std::string::npos) return std::nullopt;
    std::size_t at = percent + 1;
    Numbered result;
    if (at < name.size() && name[at] == '0') ++at;
    for (; at < name.size() && is_digit(name[at]) && result.digits < 20; ++at)
      result.digits = 10 * result.digits + std::size_t(name[at] - '0');
    if (at >= name.size() || name[at] != 'd') return std::nullopt;
    result.before = name.substr(0, percent);
    result.after = name.substr(at + 1);
    return result;
  }
  std::optional<long long> number_of(const std::string& name) const {
    if (name.size() <= before.size() + after.size() || name.compare(0, before.size(), before) != 0 ||
        name.compare(name.size() - after.size(), after.size(), after) != 0)
      return std::nullopt;
    const char *const begin = name.data() + before.size(), *const end =
                                                               name.data() + name.size() - after.size();
    const auto width = std::size_t(end - begin);
    if (!std::all_of(begin, end, is_digit) || width < digits ||
        (width > std::max<std::size_t>(digits, 1) && *begin == '0'))
      return std::nullopt;
    long long number = 0;
    const auto [stop, error] = std::from_chars(begin, end, number);
    return error == std::errc() && stop == end ? std::optional(number) : std::nullopt;
  }
};

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder.empty() ? fs::path(".") : folder, error), end;
       !error && entry != end; entry.increment(error))
    files.push_back(folder / entry->path().filename());
  if (error)
    throw Error(ErrorKind::kIo, "folder " + folder.string(), "cannot read it: " + error.message(),
                "name the folder that holds the pictures");
  return files;
}

std::vector<fs::path> numbered_files(const fs::path& folder, const Numbered& pattern) {
  std::vector<std::pair<long long, fs::path>> found;
  for (fs::path& file : files_in(folder))
    if (const auto number = pattern.number_of(file.filename().string()))
      found.emplace_back(*number, std::move(file));
  std::sort(found.begin(), found.end());
  std::vector<fs::path> files;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (i > 0 && found[i].first != found[i - 1].first + 1)
      throw Error(ErrorKind::kInput, files.back().string(),
                  "the next picture of the sequence is missing, and number " +
                      std::to_string(found[i].first) + " is there",
                  "give all pictures, or name them by a pattern with * that may have gaps");
    files.push_back(std::move(found[i].second));
  }
  return files;
}

std::vector<fs::path> files_of(const std::string& what) {
  const fs::path path = what;
  std::error_code ignored;
  std::vector<fs::path> files;
  if (fs::is_directory(path, ignored)) {
    files = files_in(path);
    files.erase(std::remove_if(files.begin(), files.end(), [](const fs::path& f) { return !is_picture(f); }),
                files.end());
  } else if (const auto pattern = Numbered::parse(path.filename().string())) {
    return numbered_files(path.parent_path(), *pattern);
  } else {
    files = files_in(path.parent_path());
    const std::string wanted = path.filename().string();
    files.erase(
        std::remove_if(files.begin(), files.end(),
                       [&](const fs::path& f) { return !matches(wanted.c_str(), f.filename().c_str()); }),
        files.end());
  }
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return io::natural_less(a.filename().string(), b.filename().string());
  });
  return files;
}

class Sequence : public PictureReader {
 public:
  explicit Sequence(std::string what) : name_(std::move(what)) {
    files_ = files_of(name_);
    if (files_.empty())
      throw Error(ErrorKind::kInput, name_, "there is no picture", "name a folder of pictures, or a pattern");
  }
  const std::string& name() const override { return name_; }
  bool read(ImageU8& picture) override {
    if (next_ == files_.size()) return false;
    io::LoadedImage loaded = io::load_image(files_[next_]);
    if (next_++ == 0) remarks_ = std::move(loaded.diagnostics);
    picture = std::move(loaded.image);
    return true;
  }
  bool skip() override {
    if (next_ == files_.size()) return false;
    ++next_;
    return true;
  }
  void rewind() override { next_ = 0; }
  const Diagnostics& remarks() const override { return remarks_; }

 private:
  std::string name_;
  Diagnostics remarks_;
  std::vector<fs::path> files_;
  std::size_t next_ = 0;
};

}  // namespace

static bool has_extension(const fs::path& file, const std::set<std::string>& known) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return char(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
  return known.count(extension) != 0 && file.filename().string().front() != '.';
}

bool is_picture(const fs::path& file) {
  static const std::set<std::string> known{".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff"};
  return has_extension(file, known);
}

bool is_video(const fs::path& file) {
  static const std::set<std::string> known{".mp4", ".mkv", ".avi", ".mov", ".webm"};
  return has_extension(file, known);
}

std::unique_ptr<ContentSource> open_sequence(const std::string& what, double rate_hz,
                                             const ContentOptions& options) {
  return play(std::make_unique<Sequence>(what), rate_hz > 0 ? rate_hz : kUsualRate, options);
}

}  // namespace procam::device::internal
