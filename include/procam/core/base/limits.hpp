#pragma once
/// All limits of input in one place. Each is above any valid input; what exceeds one is refused by name (a file,
/// a flag) or counted (a message), before memory is taken for it. docs/security.md lists them in a table; a test
/// compares the table with this header.
#include <cstddef>
#include <cstdint>

namespace procam::limits {

constexpr std::size_t kMebibyte = std::size_t(1) << 20;

// --- files ---

/// Bytes of any file that is read whole: images, maps, meshes, archives and what archives unpack to.
inline constexpr std::size_t kFileBytes = 1024 * kMebibyte;
/// Bytes of a JSON, XML or YAML document: its tree takes some twenty times as much memory.
inline constexpr std::size_t kDocumentBytes = 32 * kMebibyte;
/// Values in a document, for the same reason.
inline constexpr std::size_t kDocumentValues = 1'000'000;
/// Nested groups in a document: readers are recursive, and the stack is small.
inline constexpr int kDocumentDepth = 32;
/// Fields of one group in a YAML document: names are compared pairwise.
inline constexpr std::size_t kGroupFields = 4096;
/// Bytes of one list in brackets of a YAML document: it is joined to one text.
inline constexpr std::size_t kListBytes = 4 * kMebibyte;
/// Numbers of one matrix in a calibration of another program: far above 4 x 4.
inline constexpr std::size_t kMatrixNumbers = 4096;
/// Pixels of an image: 16384 x 8192. A header that claims more is taken for damage.
inline constexpr std::int64_t kImagePixels = std::int64_t(1) << 27;
/// Bytes of an image's pixels once decoded: small files can decode to much, and the pixels are copied once.
inline constexpr std::int64_t kImageBytes = std::int64_t(512) << 20;
/// Pixels of a width or a height, as people and other programs state sizes: no device is larger.
inline constexpr int kSizeSide = 1 << 20;
/// Pixels of one side of a projector's frame: renderers keep some 32 bytes a pixel.
inline constexpr int kFrameSide = 16384;
/// Pixels of one content or mask that a renderer is given: some 2 GB of light.
inline constexpr std::int64_t kContentPixels = std::int64_t(1) << 28;
/// Surfaces in a file: each has its own maps, some megabytes.
inline constexpr std::size_t kSurfaces = 1000;
/// Triangles of a mesh: some gigabyte of maps.
inline constexpr std::size_t kMeshTriangles = std::size_t(1) << 24;
/// Bytes of a table of observations.
inline constexpr std::size_t kTableBytes = 512 * kMebibyte;
/// Rows of a table of observations: some gigabyte once read.
inline constexpr std::size_t kTableRows = 5'000'000;
/// Bytes of a file of point pairs: people measure hundreds.
inline constexpr std::size_t kPointPairsBytes = 16 * kMebibyte;
/// Bytes of a .npy file's header: numpy writes some hundred.
inline constexpr std::size_t kArrayHeaderBytes = 65536;
/// Values of a .npy file: a gigabyte of doubles.
inline constexpr std::size_t kArrayValues = std::size_t(1) << 27;
/// Members of an archive (MPCDI).
inline constexpr std::int64_t kArchiveMembers = 4096;
/// Regions of an MPCDI file: one a projector.
inline constexpr std::size_t kRegions = 1024;
/// Bytes of a recorded file of skeletons: an hour of an Azure Kinect.
inline constexpr std::size_t kSkeletonFileBytes = 256 * kMebibyte;
/// Bytes of one line of a log or a trajectory: all surfaces of a recorded run are one line.
inline constexpr std::size_t kLogLineBytes = 64 * kMebibyte;

/// Bytes of a chunk of an MCAP log, packed or unpacked: it is taken into memory as a whole. Writers make some megabytes.
inline constexpr std::size_t kLogChunkBytes = 128 * kMebibyte;
/// Bytes of the summary of an MCAP log: a larger one is not used. An hour in chunks of a megabyte has some 10 MiB.
inline constexpr std::size_t kLogSummaryBytes = 64 * kMebibyte;
/// Topics of a log of ROS 2: a robot has some hundred.
inline constexpr std::size_t kLogTopics = 4096;
/// Poses of a log of ROS 2 that are given all at once: three hours at 100 Hz.
inline constexpr std::size_t kLogPoses = std::size_t(1) << 20;

// --- network ---

/// Connections of a source that listens (tcp-listen): each has a buffer and a parser.
inline constexpr int kSenders = 8;
/// Seconds of silence after which a new connection takes the place of an old one, when all are taken.
inline constexpr double kTakeoverSilenceS = 2;
/// Seconds of silence after which a connection is closed: a localiser that lives has sent something.
inline constexpr double kSenderSilenceS = 600;
/// Bytes of one pose message, JSON or binary: the longest valid one has 2000.
inline constexpr std::size_t kMessageBytes = 8192;
/// Malformed messages that are read of one datagram: 30 000 wrong lines fit into one.
inline constexpr std::uint64_t kMalformedPerDatagram = 16;
/// Bytes of a frame's name in a message: the binary form counts them in a byte.
inline constexpr std::size_t kFrameNameBytes = 255;
/// Nested bundles of an OSC datagram: readers are recursive.
inline constexpr int kOscDepth = 4;
/// Bytes of one WebSocket message of rosbridge.
inline constexpr std::size_t kRosbridgeBytes = kMebibyte;
/// Nested groups in a message of rosbridge.
inline constexpr int kRosbridgeDepth = 16;
/// Transforms in a message of rosbridge: a robot has some dozens.
inline constexpr std::size_t kTransforms = 256;
/// Bytes of one DDS sample: an uncompressed image of 16 million pixels has 48 MiB.
inline constexpr std::size_t kDdsSampleBytes = 64 * kMebibyte;
/// Pixels of an image of a ROS 2 topic, once decoded: 4096 x 4096.
inline constexpr std::int64_t kRos2ImagePixels = std::int64_t(1) << 24;
/// Publishers of a ROS 2 topic that a reader tells apart: a topic has one, as a rule.
inline constexpr std::size_t kRos2Publishers = 64;
/// Frames that a buffer of /tf remembers: a robot has some dozens.
inline constexpr std::size_t kTransformFrames = 512;
/// Stamps that such a buffer remembers of a frame: ten seconds at 100 Hz.
inline constexpr std::size_t kTransformStamps = 1024;
/// Bytes of one line of skeletons: 16 people with all joints take 48 000.
inline constexpr std::size_t kSkeletonLineBytes = 65536;
/// Nested groups in a text of skeletons.
inline constexpr int kSkeletonDepth = 8;
/// People in one frame of skeletons.
inline constexpr std::size_t kPeople = 16;

// --- the control page and its editor ---

/// Bytes of the head of a request to the control page: browsers send some 1000.
inline constexpr std::size_t kPageHeaderBytes = 8192;
/// Bytes of a command or a WebSocket message to the control page: the longest valid one has some 1000.
inline constexpr std::size_t kPageBodyBytes = 16384;
/// Connections to the control page: an open page has one, and a few while it loads.
inline constexpr std::size_t kPageConnections = 32;
/// Commands of the control page that wait for the next frame.
inline constexpr std::size_t kPageCommands = 1000;
/// Seconds in which the head of a request must have come: half-open requests take the place of others.
inline constexpr int kPageHeadS = 3;
/// Seconds for the rest of a request, and for its answer.
inline constexpr int kPageRequestS = 10;
/// Letters of a token that is given, at least: fewer can be guessed.
inline constexpr std::size_t kMinTokenBytes = 8;
/// Letters of a token that is given, at most: it is part of an address.
inline constexpr std::size_t kMaxTokenBytes = 256;
/// Bytes of a surface's name that is given in the control page.
inline constexpr std::size_t kSurfaceNameBytes = 64;
/// Surfaces up to which the control page adds one: people arrange them by hand.
inline constexpr std::size_t kEditedSurfaces = 64;
/// Steps that can be undone in the control page: each is a copy of the surfaces.
inline constexpr std::size_t kEditSteps = 200;

// --- numbers that people state ---

/// Threads: the largest machines have some hundred cores.
inline constexpr int kThreads = 1024;
/// Seconds of a duration: 31 years.
inline constexpr double kDurationS = 1e9;
/// Seconds of a delay of a camera, a display or a localiser.
inline constexpr double kDelayS = 10;
/// Metres of a length: a thousand kilometres.
inline constexpr double kLengthM = 1e6;

}  // namespace procam::limits
