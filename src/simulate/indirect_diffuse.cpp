#include <algorithm>
#include <array>
#include <cmath>

#include "caster.hpp"
#include "indirect.hpp"
#include "procam/core/base/parallel.hpp"
#include "room_hit.hpp"

namespace procam::simulate::internal {
namespace {

constexpr int kBlockPixels = 16;  ///< projector pixels a side, of the smallest blocks
constexpr int kBlockSizes = 4;    ///< of blocks; each is twice as large as the one before
constexpr double kFarSides = 4;   ///< a block is used from this many of its sides away

/// What a block of projector pixels lights, as one small surface.
struct Block {
  bool is_one = false;  ///< on one body, in one direction; else its parts count
  bool is_lit = false;
  Vec3 point = Vec3::Zero(), normal = Vec3::Zero();
  int body = 0;
  double area = 0;       ///< square metres
  double reflected = 0;  ///< flux at full light, times the albedo
};

/// The blocks of one light at all sizes, and how bright each is in each frame.
class LitBlocks {
 public:
  LitBlocks(const PreparedRoom& prepared, const RoomLight& light) : frames_(light.frames.size()) {
    const ImageSize size = light.projector.size();
    columns_[0] = (size.width + kBlockPixels - 1) / kBlockPixels;
    rows_[0] = (size.height + kBlockPixels - 1) / kBlockPixels;
    for (int level = 0; level < kBlockSizes; ++level) {
      const std::size_t at = std::size_t(level);
      if (level > 0) {
        columns_[at] = (columns_[at - 1] + 1) / 2;
        rows_[at] = (rows_[at - 1] + 1) / 2;
      }
      blocks_[at].resize(std::size_t(columns_[at]) * std::size_t(rows_[at]));
      flux_[at].resize(blocks_[at].size() * frames_);
    }
    const Caster eye(prepared, light.room_from_projector(0));
    for (int row = 0; row < rows_[0]; ++row)
      for (int column = 0; column < columns_[0]; ++column) light_block(prepared, eye, light, column, row);
    for (int level = 1; level < kBlockSizes; ++level)
      for (int row = 0; row < rows_[std::size_t(level)]; ++row)
        for (int column = 0; column < columns_[std::size_t(level)]; ++column) join(level, column, row);
  }

  /// Adds the irradiance at a point to that of each frame.
  void add_received(const Vec3& point, const Vec3& normal, const Caster& eye, const Candidates& all,
                    std::vector<double>& by_frame) const {
    for (int row = 0; row < rows_[kBlockSizes - 1]; ++row)
      for (int column = 0; column < columns_[kBlockSizes - 1]; ++column)
        add(kBlockSizes - 1, column, row, {point, normal, eye, all}, by_frame);
  }

 private:
  struct Receiver {
    const Vec3 &point, &normal;
    const Caster& eye;
    const Candidates& all;
  };

  std::size_t index(int level, int column, int row) const {
    return std::size_t(row) * std::size_t(columns_[std::size_t(level)]) + std::size_t(column);
  }

  void light_block(const PreparedRoom& prepared, const Caster& eye, const RoomLight& light, int column,
                   int row) {
    const ImageSize size = light.projector.size();
    const int x = column * kBlockPixels, y = row * kBlockPixels;
    const int x_end = std::min(x + kBlockPixels, size.width), y_end = std::min(y + kBlockPixels, size.height);
    const auto ray = [&](double u, double v) { return light.projector.emit(Vec2(u, v)); };
    const auto middle = ray(0.5 * (x + x_end - 1), 0.5 * (y + y_end - 1));
    const auto corner = ray(x - 0.5, y - 0.5), right = ray(x_end - 0.5, y - 0.5),
               below = ray(x - 0.5, y_end - 0.5);
    if (!middle || !corner || !right || !below) return;
    const BodyHit hit = eye.nearest(middle->direction, prepared.all);
    if (hit.body < 0) return;
    const double solid_angle =
        std::abs((right->direction.normalized() - corner->direction.normalized())
                     .cross(below->direction.normalized() - corner->direction.normalized())
                     .dot(middle->direction.normalized()));
    const Body& body = prepared.room->bodies[std::size_t(hit.body)];
    const Vec3 outwards = smooth_outward(body.shape, hit.spot_in_body);
    const Vec3 direction = eye.in_body(hit.body, middle->direction).normalized();
    const bool front = outwards.dot(direction) < 0;
    Block& block = blocks_[0][index(0, column, row)];
    block.is_one = block.is_lit = true;
    block.body = hit.body;
    block.point = body.room_from_body * hit.spot_in_body.point;
    block.normal = body.room_from_body.rotate(front ? outwards : Vec3(-outwards));
    const double distance = (hit.s * middle->direction).norm();
    block.area = solid_angle * distance * distance / std::max(std::abs(outwards.dot(direction)), 0.05);
    block.reflected = light.intensity * solid_angle *
                      prepared.paints[std::size_t(hit.body)].albedo(front, hit.spot_in_body, Footprint{})[0];
    for (std::size_t frame = 0; frame < frames_; ++frame) {
      double sum = 0;
      for (int v = y; v < y_end; ++v)
        for (int u = x; u < x_end; ++u)
          sum += light_of_value(light.frames[frame].at(u, v) / 255.0, light.gamma);
      const double mean = sum / ((x_end - x) * (y_end - y));
      flux_[0][index(0, column, row) * frames_ + frame] =
          float(block.reflected * (light.black + (1 - light.black) * mean));
    }
  }

  template <typename Visit>
  void each_part(int level, int column, int row, const Visit& visit) const {
    const std::size_t below = std::size_t(level - 1);
    for (int j = 2 * row; j < std::min(2 * row + 2, rows_[below]); ++j)
      for (int i = 2 * column; i < std::min(2 * column + 2, columns_[below]); ++i) visit(i, j);
  }

  /// A block of its four parts: one surface where they are on one body, and look one way.
  void join(int level, int column, int row) {
    const std::size_t at = std::size_t(level), here = index(level, column, row);
    Block& block = blocks_[at][here];
    bool first = true;
    each_part(level, column, row, [&](int i, int j) {
      const Block& part = blocks_[at - 1][index(level - 1, i, j)];
      block.is_lit = block.is_lit || part.is_lit;
      if (first) {
        block.is_one = part.is_one;
        block.body = part.body;
        block.normal = part.normal;
      }
      first = false;
      constexpr double kOneWay = 0.99;
      block.is_one =
          block.is_one && part.is_one && part.body == block.body && part.normal.dot(block.normal) > kOneWay;
      block.point += part.reflected * part.point;
      block.reflected += part.reflected;
      block.area += part.area;
      for (std::size_t frame = 0; frame < frames_; ++frame)
        flux_[at][here * frames_ + frame] += flux_[at - 1][index(level - 1, i, j) * frames_ + frame];
    });
    if (block.reflected > 0)
      block.point /= block.reflected;
    else
      block.is_lit = false;
  }

  void add(int level, int column, int row, const Receiver& receiver, std::vector<double>& by_frame) const {
    const std::size_t at = std::size_t(level), here = index(level, column, row);
    const Block& block = blocks_[at][here];
    if (!block.is_lit) return;
    const Vec3 to_block = block.point - receiver.point;
    const double distance2 = to_block.squaredNorm();
    if (level > 0 && (!block.is_one || distance2 < kFarSides * kFarSides * block.area)) {
      each_part(level, column, row, [&](int i, int j) { add(level - 1, i, j, receiver, by_frame); });
      return;
    }
    const double distance = std::sqrt(distance2);
    const double arriving = receiver.normal.dot(to_block), leaving = -block.normal.dot(to_block);
    if (!(arriving > 0 && leaving > 0 && distance > 0)) return;
    if (receiver.eye.is_hidden(to_block, block.body, receiver.all)) return;
    const double factor = arriving * leaving / (distance2 * (kPi * distance2 + block.area));
    for (std::size_t frame = 0; frame < frames_; ++frame)
      by_frame[frame] += factor * double(flux_[at][here * frames_ + frame]);
  }

  std::size_t frames_;
  std::array<int, kBlockSizes> columns_{}, rows_{};
  std::array<std::vector<Block>, kBlockSizes> blocks_;
  std::array<std::vector<float>, kBlockSizes> flux_;  ///< by block and frame
};

}  // namespace

void add_diffuse_light(const Room& room, const Camera& camera, const Pose& room_from_camera,
                       const std::vector<RoomLight>& lights, int threads, RoomSamples& samples) {
  if (lights.empty()) return;
  const PreparedRoom prepared(room);
  std::vector<LitBlocks> blocks;
  for (const RoomLight& light : lights) blocks.emplace_back(prepared, light);
  const std::size_t frames = lights.front().frames.size();
  ReceivedLight& received = samples.view.received;
  const int columns = received_nodes(camera.size.width), rows = received_nodes(camera.size.height);
  received.body = samples.truth.body;
  received.node_body = Image<std::int16_t>(columns, rows, 1, std::int16_t(-1));
  received.by_frame.assign(frames, ImageF(columns, rows));
  parallel_each(rows, threads, [&](int row) {
    for (int column = 0; column < columns; ++column) {
      const auto bearing = camera.unproject(Vec2(column * kReceivedStep, row * kReceivedStep));
      if (!bearing) continue;
      const auto hit = nearest_hit(room, {room_from_camera.translation, room_from_camera.rotate(*bearing)});
      if (!hit) continue;
      received.node_body.at(column, row) = std::int16_t(hit->body);
      const Vec3 point = hit->point_in_room + kBeforeSurface * hit->normal_in_room;
      const Caster eye(prepared, Pose(Eigen::Quaterniond::Identity(), point));
      std::vector<double> by_frame(frames, 0.0);
      for (const LitBlocks& of_light : blocks)
        of_light.add_received(point, hit->normal_in_room, eye, prepared.all, by_frame);
      for (std::size_t frame = 0; frame < frames; ++frame)
        received.by_frame[frame].at(column, row) = float(by_frame[frame]);
    }
  });
}

}  // namespace procam::simulate::internal
