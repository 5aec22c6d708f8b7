#pragma once
/// The loop of a running show as a class (see loop.hpp for the rules it follows). Its members are implemented by topic:
/// loop.cpp (time and frames), loop_blend.cpp (the blend), loop_commands.cpp (commands, keys and the group), loop_surfaces.cpp (surfaces, contents
/// and corrections) and loop_status.cpp (messages, faults and the control page).
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "light_check.hpp"
#include "loop.hpp"

namespace procam::show {

class FrameLoop {
 public:
  FrameLoop(const LoopParts& parts, const LoopOptions& options);

  Metrics run();

 private:
  // Time and frames: loop.cpp.
  void draw_frames();
  /// Commands that the page has accepted since the last frame are executed, and unsaved edits saved where that is asked.
  void finish();
  void tick();
  /// Sleeps, and listens to the window's keys.
  void wait_until(double due);
  /// People and files.
  void poll_inputs();
  void take_poses();
  void take_poses(track::PoseSource& source);
  /// As it is logged and drawn with: of a localiser that is corrected, what the correction makes of it.
  void take_pose(const track::StampedPose& message);
  /// Of the surfaces that move on their own.
  void take_sightings();
  void draw(double now, double free_since);
  void draw_new(double now, ImageU8& frame);
  /// The further screens', after the first one's.
  void draw_sides(double light_time);
  static void make_black(ImageU8& frame);
  /// Surfaces that other robots of a fleet light are dark from the next frame on, also while the picture is frozen.
  void follow_fleet();
  /// To the fleet: what the frame that was just shown has light on.
  void tell_fleet(double light_time);
  /// A frame that neither the page holds nor is shown while the picture is frozen.
  std::shared_ptr<ImageU8>& unheld_frame();

  // The blend with other projectors: loop_blend.cpp.
  void begin_blend();
  void follow_blend(double now);
  ProjectorNames own_projectors() const;
  BlendTurn turn_of_blend(double light_time);
  BlendScene blend_scene(ProjectorNames projectors) const;
  void use_blend(const std::shared_ptr<const MadeBlend>& made);

  // Commands, keys and the group: loop_commands.cpp.
  void handle_window_events(device::FrameSink& sink);
  void ask_picture(TestPattern picture);
  void turn_to(TestPattern picture);
  void take_commands();
  /// Of a person here: in a group the leader executes it.
  void accept(const Command& command);
  /// A point or a surface that somebody holds on the control page: for a moment the light of the paged screen marks it.
  void mark(const Command& command);
  void draw_mark(double now, ImageView<std::uint8_t> frame) const;
  void execute(const Command& command);
  void require_content(const Command& command) const;
  /// A page is not to open any file or device of this machine.
  bool may_be_shown(const std::string& content) const;
  void change_correction(const std::string& text);
  void choose_screen(const std::string& name);
  /// Of the screen whose frame the page shows.
  const Projection& paged_projection() const;
  void freeze();
  double content_time(double now) const;
  bool is_unsaved() const { return parts_.editor != nullptr && parts_.editor->is_unsaved(); }
  void autosave();
  void save();
  void follow_group();
  /// The state of the group's leader.
  void take(SharedShow show);

  // Surfaces, contents and corrections: loop_surfaces.cpp.
  void take(LoadedShow loaded);
  bool same_names(const SurfaceSet& surfaces) const;
  bool show(Show next);
  void set_show(Show next);
  const SurfaceSet& surfaces_now() const;
  /// The edited surfaces with the contents at hand; others are opened in the background.
  bool show_edited() { return show_of(parts_.editor->surfaces()); }
  bool show_of(const SurfaceSet& surfaces);
  /// A content that has stopped keeps its last image: that is counted and reported once, and so is its return.
  void check_contents();
  /// Surfaces as the depth camera sees them now.
  void watch_room();
  /// The shape that the depth camera sees, as it will be at the frame's light.
  void move_shape(double light_time);
  void take_watch();
  /// What its images tell of the rig's place.
  void correct_pose(const std::vector<track::PoseSight>& sights);
  /// A corrected projector comes to its place slowly, so that the light does not jump.
  void move_projector(double now);
  /// Surfaces that were found elsewhere. What was edited meanwhile stays; the end is a step that can be undone.
  void move_surfaces(double now);

  // Messages, faults and the control page: loop_status.cpp.
  void say(const std::string& message);
  void count_fault(const char* name, const std::string& sentence);
  void check_parts();
  /// A sender that goes and a camera that is unplugged; a log that ends without a fault is none.
  void check_source(std::size_t i);
  void tell_state();
  /// Surfaces that are seen, lost and seen again.
  void tell_moving(double now);
  void gather_sights(const SurfaceSights::Surface& seen);
  void publish(double now);
  void gather_counts();

  /// Runs a step whose failure must not end the show. Returns whether it succeeded.
  template <typename Step>
  bool guarded(const char* name, const Step& step) {
    try {
      step();
      return true;
    } catch (const std::exception& error) {
      count_fault(name, error.what());
      return false;
    }
  }
  template <typename Record>
  void record(const Record& what) {
    if (recorder_ == nullptr || guarded("record", [&] { recorder_->record(what); })) return;
    recorder_ = nullptr;
    say("recording has stopped; the show continues");
  }

  const LoopParts& parts_;
  const LoopOptions options_;
  RunRecorder* recorder_ = parts_.recorder;  ///< null once it failed
  Metrics metrics_;
  struct Reported {
    std::string sentence;
    double time_s = 0;
  };
  std::map<std::string, Reported> reported_;  ///< faults by name
  std::deque<std::shared_ptr<ImageU8>> frames_;
  std::shared_ptr<ImageU8> shown_, held_;
  std::vector<track::StampedPose> arrived_;
  std::deque<std::string> messages_;
  std::map<std::string, std::shared_ptr<device::ContentSource>> of_room_;  ///< null: opening, or failed
  std::set<std::string> seen_in_room_;
  std::map<std::string, std::string> stopped_contents_;  ///< by surface, why
  std::vector<bool> connected_;                          ///< one a source
  bool sees_ = false;                                    ///< the camera of the moving surfaces is there
  double moving_told_ = 0;
  DrawnFrame drawn_;
  std::optional<track::PoseCorrection> pose_correction_;
  std::optional<watch::Glide> glide_;  ///< of the projector, to its corrected place
  SurfaceGlides surface_glides_;
  LightCheck light_;
  track::TrackState told_ = track::TrackState::kNone;
  double begin_ = 0, newest_arrival_ = 0, published_ = 0, ticked_ = 0, autosaved_ = 0, parts_checked_ = 0,
         gathered_ = 0;
  double frames_per_s_ = 0, poses_per_s_ = 0;
  std::uint64_t frames_then_ = 0, poses_then_ = 0;
  std::vector<std::string> fleet_dark_;                  ///< surfaces
  bool is_new_ = false, is_drawn_ = false;               ///< of the frame that was shown last
  SharedShow shared_;                                    ///< of a group, without surfaces
  bool surfaces_changed_ = true, draws_frozen_ = false;  ///< of a group
  std::shared_ptr<const MadeBlend> blend_;               ///< that frames are drawn with
  std::vector<ProjectorNames> blend_sets_;               ///< whose maps are wanted
  std::uint64_t placed_ = 1,
                blend_version_ = 0;  ///< count where surfaces and projector are placed; of those maps
  double blend_changed_ = 0;
  std::optional<double> lit_from_;  ///< group time
  std::size_t paged_ = 0;           ///< the screen that the page shows: 0, or one of the sides from 1
  bool closed_ = false, frozen_ = false, help_ = false, waiting_ = false;
  struct Marked {
    std::string surface;
    int point = -1;  ///< -1: the outline
    double until_s = 0;
  };
  Marked marked_;
};

}  // namespace procam::show
