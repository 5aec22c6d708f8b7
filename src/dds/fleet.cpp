#include "procam/dds/fleet.hpp"

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>
#include <utility>

#include "fleet_announcement.hpp"
#include "fleet_checks.hpp"
#include "fleet_turns.hpp"
#include "graph.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/base/error.hpp"
#include "topic_reader.hpp"

namespace procam::dds {
namespace {

constexpr double kFleetPeriod = 0.005;       ///< of decisions, when nothing comes, seconds
constexpr double kRepeatAnnouncement = 0.5;  ///< of one that does not change, seconds
/// A robot whose program or network is gone. DDS renews it while the program lives, also when its show is stuck: the light of
/// its last frame is on the wall then.
constexpr auto kRobotLease = DDS_MSECS(400);

double unix_time() {
  return 1e-6 * double(std::chrono::duration_cast<std::chrono::microseconds>(
                           std::chrono::system_clock::now().time_since_epoch())
                           .count());
}

/// The participant and the topic of a fleet.
class FleetTopic {
 public:
  explicit FleetTopic(const FleetOptions& options) : name_(options.name) {
    const std::unique_ptr<dds_qos_t, void (*)(dds_qos_t*)> qos(dds_create_qos(), dds_delete_qos);
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(20));
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
    dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, kRobotLease);
    dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
    waitset_ = create(dds_create_waitset(participant_.entity()));
    const dds_entity_t topic = create(dds_create_topic(participant_.entity(), &procam_fleet_Announcement_desc,
                                                       topic_name().c_str(), nullptr, nullptr));
    reader_ = create(dds_create_reader(participant_.entity(), topic, qos.get(), nullptr));
    writer_ = create(dds_create_writer(participant_.entity(), topic, qos.get(), nullptr));
    dds_set_status_mask(reader_, DDS_DATA_AVAILABLE_STATUS);
    checked(dds_waitset_attach(waitset_, reader_, 0));
  }

  dds_entity_t reader() const { return reader_; }
  dds_entity_t writer() const { return writer_; }
  void wait(double seconds) const {
    dds_attach_t woken[2];
    dds_waitset_wait(waitset_, woken, 2, dds_duration_t(1e9 * seconds));
  }
  std::string description() const {
    return participant_.description() + ": fleet " + name_ + ", topic " + topic_name();
  }

 private:
  static dds_entity_t checked(dds_entity_t entity) {
    if (entity < 0)
      throw Error(ErrorKind::kDevice, "fleet", std::string("DDS refuses it: ") + dds_strretcode(entity),
                  "check the network and CYCLONEDDS_URI");
    return entity;
  }
  dds_entity_t create(dds_entity_t entity) const { return participant_.kept(checked(entity)); }
  std::string topic_name() const { return "procam/fleet/" + name_ + "/robot"; }

  internal::Participant participant_;
  std::string name_;
  dds_entity_t waitset_ = 0, reader_ = 0, writer_ = 0;
};

}  // namespace

struct RobotFleet::Impl {
  explicit Impl(const FleetOptions& given)
      : options(given),
        topic(given),
        turns(given, std::uint64_t(1e6 * unix_time()), steady_now() + kFirstWait),
        thread([this] { run(); }) {}
  ~Impl() {
    ends = true;
    thread.join();
  }

  void run() {
    double sent = 0;
    while (!ends) {
      topic.wait(kFleetPeriod);
      const std::lock_guard<std::mutex> lock(mutex);
      read();
      const double now = steady_now();
      const bool is_news = turns.step(now);
      if (turns.is_superseded() || (!is_news && now - sent < kRepeatAnnouncement)) continue;
      sent = now;
      internal::write_announcement(topic.writer(), options.name, turns.announce(unix_time()));
    }
  }

  void read() {
    internal::take_all(topic.reader(), [&](const void* sample, const dds_sample_info_t& info, double now) {
      const auto& message = *static_cast<const procam_fleet_Announcement*>(sample);
      try {
        if (info.valid_data &&
            turns.take(internal::read_announcement(message, options.name)) == internal::Taken::kRefused)
          ++rejected;
      } catch (const internal::Refusal&) {
        ++rejected;
      }
      // The key is valid in each sample. Its last writer has ended or lost its liveliness.
      if (info.instance_state != DDS_IST_ALIVE && message.robot != nullptr)
        turns.forget(message.robot, now + kFirstWait);
    });
  }

  const FleetOptions options;
  FleetTopic topic;
  mutable std::mutex mutex;  ///< of all below
  internal::FleetTurns turns;
  std::uint64_t rejected = 0;
  std::atomic<bool> ends{false};
  std::thread thread;  ///< the last: it uses all above
};

RobotFleet::RobotFleet(const FleetOptions& options) {
  internal::require_fleet(options);
  impl_ = std::make_unique<Impl>(options);
}
RobotFleet::~RobotFleet() = default;

void RobotFleet::claim(const std::vector<FleetClaim>& claims) {
  if (const char* const fault = internal::fault_of_claims(claims))
    throw Error(ErrorKind::kInput, "fleet " + impl_->options.name, fault, "see procam/dds/fleet.hpp");
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  impl_->turns.claim(claims);
}

std::vector<std::string> RobotFleet::lit() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->turns.lit();
}

void RobotFleet::shown(const std::vector<std::string>& surfaces, double light_time) {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  impl_->turns.shown(surfaces, light_time);
}

FleetStatus RobotFleet::status() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  FleetStatus status = impl_->turns.status();
  status.rejected = impl_->rejected;
  return status;
}

std::string RobotFleet::description() const {
  return impl_->topic.description();
}

}  // namespace procam::dds
