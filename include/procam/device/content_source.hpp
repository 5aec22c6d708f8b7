#pragma once
/// What is shown on a surface, as time goes by: a colour, a picture, a sequence of pictures, a video, a
/// camera, another program, or whatever a function draws.
///
///   const std::unique_ptr<ContentSource> content = open_content("clip.mp4");
///   while (showing) {
///     const ContentFrame frame = content->at(now_s() - begin_s);
///     scene.items[0].content = frame.view;
///     scene.items[0].content_revision = frame.revision;
///     renderer.render(scene, projector, picture);
///   }
///
/// Laws that every source keeps: - An opened source has a picture: faults of a file or a camera are
/// reported at opening. - All pictures of a source have one size and one number of channels: 1 (grey), 3
/// (RGB) or 4 (RGBA, straight
///   alpha), 8 bits. A picture's orientation note is not applied (as in io/image/images.hpp).
/// - The view is valid until the next call of at() or the end of the source.
/// - The same view with the same revision holds the same pixels; other pixels in the same memory come with
///   another revision. This is what a renderer needs to keep pictures from one frame to the next.
/// - What is recorded depends on the time alone, forwards and backwards: picture floor(time_s * rate), the
///   first before 0; after the end from the beginning again (loop), or the last for ever. What is live is the
///   newest that has arrived, whatever the time.
/// - at() allocates nothing and, with Pace::kLive, waits for nothing: threads of the source's own decode
/// ahead
///   and listen. With Pace::kExact it waits for the picture that belongs to the time.
/// - A source is used by one thread.
///
/// Image files are decoded by io; videos and cameras are OpenCV's videoio.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"

namespace procam::device {

struct ContentFrame {
  ViewU8 view;
  std::uint64_t revision = 0;
};

class PROCAM_EXPORT ContentSource {
 public:
  virtual ~ContentSource() = default;

  /// The picture for `time_s` seconds since the content began. With Pace::kLive it never throws what fault()
  /// tells; with Pace::kExact it throws it as Error, naming the file.
  virtual ContentFrame at(double time_s) = 0;

  /// Why new pictures have stopped coming, if they have: at() keeps giving the last one. Files are read and cameras
  /// opened again every second, and fault() is gone when they are back.
  virtual std::optional<Error> fault() const { return std::nullopt; }

  /// Messages that were dropped, by cause ("ros2_invalid_image").
  virtual std::map<std::string, std::uint64_t> rejected() const { return {}; }

  /// Pictures a second of what is recorded; 0 for what does not move or is live.
  virtual double rate_hz() const { return 0; }

  /// Remarks of io::load_image() on the file that was read when the source was opened.
  virtual Diagnostics diagnostics() const { return {}; }
};

enum class Pace {
  kLive,   ///< the newest picture not after its time that is decoded: a show must go on
  kExact,  ///< each picture at its time, however long it takes: for files written from it
};

struct ContentOptions {
  Pace pace = Pace::kLive;
  bool loop = true;               ///< off: a video or sequence that has ended shows its last picture
  double camera_patience_s = 10;  ///< how long a camera may take to its first picture
};

/// Opens by what the text looks like, or by the kind before a colon ("video:clip.bin"):
///
///   color   #rrggbb, #rrggbbaa
///   image   wall.png (png, jpg, jpeg, bmp, tif, tiff)
///   images  FOLDER, shot_%04d.png, shots/*.png: a folder's and a pattern's files come in natural order (9
///           before 10); numbered ones begin with the lowest number and may have no gap
///   video   any other file, as OpenCV's videoio (FFmpeg) reads it: upright, without alpha or sound
///   camera  camera:0, camera:/dev/video2, rtsp://..., http://...
///   ros2    ros2:/TOPIC, images of the ROS 2 graph (dds/image_source.hpp): live, the newest image
///   log     log:run.mcap+/TOPIC[@SPEED], images of a log of ROS 2 in their time, once through
///   shm     shm:NAME, what another program writes there (shared_frame.hpp): live, the newest frame. A writer
///           that was started again is found again within a second, if its frames have the same size
///   height  height:colours[,range=-50mm..80mm][,contours=20mm]: heights of a live shape; only in a show with
///           surfaces depth-shape:SOURCE (docs/depth.md)
///
/// @RATE behind images and videos is their pictures a second: shots/*.png@12.5. Else it is 25 for images and
/// the mean rate in the header of a video.
///
/// Throws Error: kInput for text or a file that is wrong, kIo for a file that cannot be read, kDevice for a
/// camera that cannot be opened or shows nothing, kUnsupported for ros2: in a build without DDS.
PROCAM_EXPORT std::unique_ptr<ContentSource> open_content(const std::string& what,
                                                          const ContentOptions& options = {});

/// The kinds that open_content() knows, for help texts.
struct ContentKind {
  std::string name;
  std::string example;
};
PROCAM_EXPORT std::vector<ContentKind> content_kinds();

/// The file or pattern that a content's text names, with its rate ("clip.bin@30" in "video:clip.bin@30");
/// nullopt for colours, cameras, addresses, topics and shared memory, and for an empty text.
PROCAM_EXPORT std::optional<std::string> content_file(const std::string& what);

/// The text with another file's name in the place of content_file(). Throws std::invalid_argument where it
/// names none.
PROCAM_EXPORT std::string with_content_file(const std::string& what, const std::string& file);

/// The text as seen from the working directory, of a content that is named in the file `named_in`: a relative
/// file name is taken relative to that file's folder. What names no file stays as it is.
PROCAM_EXPORT std::string content_beside(const std::filesystem::path& named_in, const std::string& what);

/// The names of a folder's pictures and videos, by their extensions, in natural order (9 before 10), at most
/// `max_count`; hidden files are omitted. Empty for a folder that cannot be read.
PROCAM_EXPORT std::vector<std::string> content_files(const std::filesystem::path& folder,
                                                     std::size_t max_count);

/// One picture, for ever.
PROCAM_EXPORT std::unique_ptr<ContentSource> still_content(ImageU8 picture);

/// Draws the picture for a time into memory that is kept (its first value is 0) and says whether it changed
/// anything. Another scene's render is content this way:
///
///   drawn_content(projector.size(), 3, [&](double, ImageView<std::uint8_t> picture) {
///     renderer.render(scene, projector, picture);
///     return true;
///   });
///
/// It is called once by at(), for every at(), in its thread; what it throws passes through.
using DrawContent = std::function<bool(double time_s, ImageView<std::uint8_t> picture)>;
PROCAM_EXPORT std::unique_ptr<ContentSource> drawn_content(ImageSize size, int channels, DrawContent draw);

}  // namespace procam::device
