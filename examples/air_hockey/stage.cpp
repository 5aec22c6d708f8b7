#include "stage.hpp"

#include "draw.hpp"
#include "procam/device/content_source.hpp"
#include "procam/people/eye_safe.hpp"
#include "procam/render/cpu.hpp"
#include "procam/show/projection.hpp"

namespace hockey {
namespace {

using namespace procam;

/// How fine the projector shows the table: no content needs more pixels a metre.
double pixels_per_metre(const Projector& projector, const Pose& projector_from_table, const Table& table) {
  double finest = 300;
  for (const double u : {0.0, 0.5, 1.0})
    for (const double v : {0.0, 0.5, 1.0}) {
      const Vec3 p(u * table.length, v * table.width, 0);
      const auto at = projector.inverse_camera.project(projector_from_table * p);
      const auto right = projector.inverse_camera.project(projector_from_table * (p + Vec3(1e-3, 0, 0)));
      const auto below = projector.inverse_camera.project(projector_from_table * (p + Vec3(0, 1e-3, 0)));
      if (at && right && below)
        finest = std::max({finest, 1e3 * (*right - *at).norm(), 1e3 * (*below - *at).norm()});
    }
  return std::min(finest, 1500.0);
}

class ProjectedStage : public Stage {
 public:
  ProjectedStage(const Wall& wall, const Rig& rig, render::Filter filter,
                 std::unique_ptr<device::FrameSink> sink)
      : sink_(std::move(sink)) {
    show::ProjectionOptions drawing;
    drawing.projector_from_world = rig.projector().rig_from_projector.inverse();
    drawing.renderer = std::make_shared<render::CpuRenderer>(rendering(filter));
    // Over everything that is lit: nobody looks into the lamp.
    drawing.over = [this](const show::Projection& projection, double light_time, Picture frame) {
      if (const people::PeopleTrack* people = game_->players().people())
        people::darken_heads(
            frame, projection.projector(),
            *projection.projector_from_world(light_time) * game_->players().world_from_sensor(), *people,
            light_time);
    };
    const Pose projector_from_table = *drawing.projector_from_world * wall.world_from_table;
    projection_ = std::make_unique<show::Projection>(rig, drawing);

    // The content of the surfaces: whoever asks for the table's picture gets the match as it stands.
    const double scale = pixels_per_metre(projection_->projector(), projector_from_table, wall.table);
    const ImageSize size = table_size(wall.table, scale);
    artist_ = std::make_unique<TableArtist>(wall.table, size);
    show::Show show;
    show.surfaces = wall.lit;
    for (const Surface& surface : wall.lit.surfaces) {
      if (surface.name == "table")
        show.contents.push_back(device::drawn_content(size, 3, [this](double, Picture picture) {
          artist_->draw(game_->match(), picture);
          return true;
        }));
      else
        show.contents.push_back(device::drawn_content(kScoreboard, 3, [this](double, Picture picture) {
          return scoreboard_.draw(game_->match(), picture);
        }));
    }
    projection_->set_show(std::move(show));

    frame_ = ImageU8(projection_->frame_size(), 3);
  }

  void show(const Game& game, double light_time) override {
    game_ = &game;
    projection_->draw(light_time, light_time, frame_.view());
    sink_->show_next(frame_);
  }
  bool is_closed() override { return sink_->poll() == device::WindowEvent::kClose; }
  const ImageU8& picture() const override { return frame_; }
  void finish() override { sink_->finish(); }

 private:
  static render::RenderOptions rendering(render::Filter filter) {
    render::RenderOptions options;
    options.filter = filter;
    return options;
  }

  std::unique_ptr<TableArtist> artist_;
  ScoreboardArtist scoreboard_;
  std::unique_ptr<show::Projection> projection_;
  std::unique_ptr<device::FrameSink> sink_;
  ImageU8 frame_;
  const Game* game_ = nullptr;
};

class ContentStage : public Stage {
 public:
  ContentStage(const std::string& name, const Wall& wall)
      : table_(table_size(wall.table, 700), 3),
        scoreboard_(kScoreboard, 3),
        artist_(wall.table, table_.size()) {
    device::SinkOptions options;
    options.size = table_.size();
    table_sink_ = device::open_sink("shm:" + name + "_table", options);
    options.size = scoreboard_.size();
    scoreboard_sink_ = device::open_sink("shm:" + name + "_scoreboard", options);
  }
  void show(const Game& game, double) override {
    artist_.draw(game.match(), table_.view());
    table_sink_->show(table_);
    if (board_.draw(game.match(), scoreboard_.view())) scoreboard_sink_->show(scoreboard_);
  }
  const ImageU8& picture() const override { return table_; }

 private:
  ImageU8 table_, scoreboard_;
  TableArtist artist_;
  ScoreboardArtist board_;
  std::unique_ptr<device::FrameSink> table_sink_, scoreboard_sink_;
};

}  // namespace

std::unique_ptr<Stage> projected_stage(const Wall& wall, const Rig& rig, render::Filter filter,
                                       std::unique_ptr<device::FrameSink> sink) {
  return std::make_unique<ProjectedStage>(wall, rig, filter, std::move(sink));
}
std::unique_ptr<Stage> content_stage(const std::string& name, const Wall& wall) {
  return std::make_unique<ContentStage>(name, wall);
}

}  // namespace hockey
