#include "procam/dds/group.hpp"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <mutex>
#include <random>
#include <thread>
#include <utility>

#include "graph.hpp"
#include "group_limits.hpp"
#include "group_messages.hpp"
#include "group_name.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "topic_reader.hpp"

namespace procam::dds {
namespace {

using internal::OrderedState;

constexpr double kBeatPeriod = 0.05;    ///< seconds
constexpr double kStatePeriod = 1;      ///< of a state that does not change, seconds
constexpr double kRepeatRequest = 0.3;  ///< seconds
constexpr auto kOwnerLease = DDS_MSECS(400);

/// FNV-1a, 64 bits.
std::uint64_t text_number(const std::string& text) {
  std::uint64_t number = 14695981039346656037u;
  for (const char c : text) number = (number ^ std::uint8_t(c)) * 1099511628211u;
  return number;
}

/// Equal for all that share one steady clock: of one start of one machine, and of one time namespace of it (containers may
/// have their own).
std::string boot_identifier() {
  std::string text;
  std::ifstream("/proc/sys/kernel/random/boot_id") >> text;
  std::error_code none;
  return text + std::filesystem::read_symlink("/proc/self/ns/time", none).string();
}

std::string host_and_process() {
  char name[256] = {};
  ::gethostname(name, sizeof name - 1);
  return std::string(name) + ":" + std::to_string(::getpid());
}

internal::MemberBeat first_beat(const GroupOptions& options) {
  std::random_device random;
  internal::MemberBeat own;
  own.member = (std::uint64_t(random()) << 32 | random()) | 1;
  own.host = host_and_process();
  own.machine = text_number(options.machine.empty() ? boot_identifier() : options.machine);
  own.projectors = options.projectors;
  own.strength = options.strength * 65536 + int(random() % 65536);  // of equal ones, chance decides
  return own;
}

enum class Owner { kShared, kExclusive };

/// The participant and the topics of a group.
class GroupTopics {
 public:
  GroupTopics(const std::string& name, int strength) : name_(name), strength_(strength) {
    const bool is_kept = true, is_reliable = true;
    waitset_ = create(dds_create_waitset(participant_.entity()));
    open(procam_group_State_desc, "state", {is_reliable, is_kept, Owner::kExclusive}, state);
    open(procam_group_Request_desc, "request", {is_reliable, false, Owner::kShared}, request);
    open(procam_group_Pose_desc, "pose", {is_reliable, false, Owner::kExclusive}, pose);
    open(procam_group_Beat_desc, "member", {false, false, Owner::kShared}, member);
  }

  struct Ends {
    dds_entity_t reader = 0, writer = 0;
  };
  Ends state, request, pose, member;

  void wait(double seconds) const {
    dds_attach_t woken[8];
    dds_waitset_wait(waitset_, woken, 8, dds_duration_t(1e9 * seconds));
  }
  std::string topic(const std::string& what) const { return "procam/group/" + name_ + "/" + what; }
  std::string description() const {
    return participant_.description() + ": group " + name_ + ", topics " + topic("*");
  }

 private:
  struct Quality {
    bool is_reliable, is_kept;
    Owner owner;
  };
  static dds_entity_t checked(dds_entity_t entity) {
    if (entity < 0)
      throw Error(ErrorKind::kDevice, "group", std::string("DDS refuses it: ") + dds_strretcode(entity),
                  "check the network and CYCLONEDDS_URI");
    return entity;
  }
  dds_entity_t create(dds_entity_t entity) const { return participant_.kept(checked(entity)); }
  void open(const dds_topic_descriptor_t& type, const std::string& what, Quality quality, Ends& ends) {
    const std::unique_ptr<dds_qos_t, void (*)(dds_qos_t*)> qos(dds_create_qos(), dds_delete_qos);
    dds_qset_reliability(qos.get(),
                         quality.is_reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                         DDS_MSECS(20));
    dds_qset_durability(qos.get(),
                        quality.is_kept ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST,
                     quality.is_kept ? 1 : std::int32_t(limits::kGroupRequests));
    if (quality.owner == Owner::kExclusive) {
      dds_qset_ownership(qos.get(), DDS_OWNERSHIP_EXCLUSIVE);
      dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, kOwnerLease);
    }
    dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
    const dds_entity_t entity =
        create(dds_create_topic(participant_.entity(), &type, topic(what).c_str(), nullptr, nullptr));
    ends.reader = create(dds_create_reader(participant_.entity(), entity, qos.get(), nullptr));
    if (quality.owner == Owner::kExclusive) dds_qset_ownership_strength(qos.get(), strength_);
    dds_qset_writer_data_lifecycle(qos.get(), false);
    ends.writer = create(dds_create_writer(participant_.entity(), entity, qos.get(), nullptr));
    dds_set_status_mask(ends.reader, DDS_DATA_AVAILABLE_STATUS);
    checked(dds_waitset_attach(waitset_, ends.reader, 0));
  }

  internal::Participant participant_;
  std::string name_;
  int strength_;
  dds_entity_t waitset_ = 0;
};

}  // namespace

struct Group::Impl {
  explicit Impl(const GroupOptions& options) : Impl(options, first_beat(options)) {}
  Impl(const GroupOptions& options, const internal::MemberBeat& first)
      : name(options.name),
        own(first),
        topics(options.name, first.strength),
        members(first, steady_now(), kLease, kFirstWait),
        thread([this] { run(); }) {}
  ~Impl() {
    ends = true;
    thread.join();
    // The others blend without this light at once.
    if (!own.projectors.empty()) internal::write_beat(topics.member.writer, members.last_beat(steady_now()));
  }

  void run() {
    double beaten = 0;
    while (!ends) {
      topics.wait(kBeatPeriod / 5);
      const std::lock_guard<std::mutex> lock(mutex);
      read();
      const bool led = members.leads();
      const double now = steady_now();
      members.decide(now);
      // It may have been stopped since: what it would send is of the past.
      if (steady_now() - now > kLease / 2) continue;
      if (members.leads() && !led) lead();
      if (!members.leads() && led) follow();
      send_requests(now);
      if (members.leads() && has_state && (now - written > kStatePeriod || newest.term != members.term()))
        write_state(now);
      if (now - beaten < kBeatPeriod && members.leads() == led) continue;
      beaten = now;
      internal::write_beat(topics.member.writer, members.beat(steady_now()));
    }
  }

  /// Calls take(message, arrival) for all that has come; invalid messages are counted.
  template <typename Message, typename Take>
  void take_each(dds_entity_t reader, Take take) {
    internal::take_all(reader, [&](const void* sample, const dds_sample_info_t& info, double arrival) {
      if (!info.valid_data) return;
      try {
        take(*static_cast<const Message*>(sample), arrival);
      } catch (const internal::Refusal&) {
        ++rejected;
      }
    });
  }

  void read() {
    take_each<procam_group_Beat>(topics.member.reader, [this](const auto& message, double arrival) {
      members.take(internal::read_beat(message), arrival);
    });
    take_each<procam_group_State>(topics.state.reader, [this](const auto& message, double) {
      OrderedState read = internal::read_group_state(message);
      if (members.leads() || !members.may_follow(read.leader)) return;
      if (has_state && !read.is_newer_than(newest)) return;
      newest = std::move(read);
      has_state = is_news = true;
      members.set_state(newest.term);
      take_answers();
    });
    take_each<procam_group_Request>(topics.request.reader, [this](const auto& message, double) {
      GroupRequest request = internal::read_request(message);
      if (members.leads()) enqueue(std::move(request));
    });
    take_each<procam_group_Pose>(topics.pose.reader, [this](const auto& message, double) {
      poses.push_back(internal::read_group_pose(message));
      if (poses.size() > limits::kGroupPoses) poses.pop_front();
    });
  }

  /// Continues from the newest state: at once, so that it has an owner.
  void lead() {
    inbox.clear();
    queued.clear();
    for (const auto& [member, one] : newest.applied) queued[member] = one.number;
    if (has_state) write_state(steady_now());
  }
  void follow() {
    inbox.clear();
    // The state of the other leader must not lose against this writer, which may be stronger.
    procam_group_State key{};
    key.group = name.data();
    dds_unregister_instance(topics.state.writer, &key);
  }

  void write_state(double now) {
    // The list of members that restart again and again stays short.
    if (newest.applied.size() >= limits::kGroupMembers) forget_gone(newest.applied);
    newest.leader = own.member;
    newest.term = members.term();
    ++newest.sequence;
    members.set_state(newest.term);
    written = now;
    internal::write_group_state(topics.state.writer, name, newest);
  }

  template <typename ByMember>
  void forget_gone(ByMember& list) const {
    for (auto one = list.begin(); one != list.end();)
      one = members.has(one->first) ? std::next(one) : list.erase(one);
  }

  /// The next one of its member; others are sent again.
  void enqueue(GroupRequest request) {
    if (queued.size() >= limits::kGroupMembers && queued.count(request.member) == 0) forget_gone(queued);
    if (queued.size() >= limits::kGroupMembers && queued.count(request.member) == 0) return;
    std::uint64_t& last = queued[request.member];
    if (request.number != last + 1) return;
    last = request.number;
    inbox.push_back(std::move(request));
  }

  void send_requests(double now) {
    if (waiting.empty() || now - sent < kRepeatRequest) return;
    for (const GroupRequest& request : waiting) send(request);
    sent = now;
  }
  void send(const GroupRequest& request) {
    if (members.leads())
      enqueue(request);
    else
      internal::write_request(topics.request.writer, request);
  }

  /// Which requests the state has, and which it refused.
  void take_answers() {
    const auto mine = newest.applied.find(own.member);
    const std::uint64_t done = mine == newest.applied.end() ? 0 : mine->second.number;
    while (!waiting.empty() && waiting.front().number <= done) {
      if (waiting.front().number == done && !mine->second.refusal.empty())
        refusals.push_back(mine->second.refusal);
      waiting.pop_front();
    }
    // A leader that does not know what another one executed, as of another half of the network, awaits the numbers after those
    // that it knows.
    if (waiting.empty() ? numbered <= done : waiting.front().number <= done + 1) return;
    numbered = done;
    for (GroupRequest& request : waiting) request.number = ++numbered;
  }

  std::string name;
  internal::MemberBeat own;
  GroupTopics topics;
  mutable std::mutex mutex;  ///< of all below
  internal::GroupMembers members;
  OrderedState newest;
  bool has_state = false, is_news = false;
  double written = 0, sent = 0;
  std::deque<GroupRequest> inbox;                 ///< of the leader
  std::map<std::uint64_t, std::uint64_t> queued;  ///< by member: the last number in the inbox or done
  std::deque<GroupRequest> waiting;               ///< of this member, not in the state yet
  std::uint64_t numbered = 0, rejected = 0;
  std::vector<std::string> refusals;
  std::deque<track::StampedPose> poses;
  std::atomic<bool> ends{false};
  std::thread thread;  ///< the last: it uses all above
};

Group::Group(const GroupOptions& options) {
  internal::require_group(options);
  impl_ = std::make_unique<Impl>(options);
}
Group::~Group() = default;

bool Group::joined() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->members.leads() || (impl_->has_state && impl_->members.clock_known());
}

bool Group::leads() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->members.leads();
}

double Group::time_offset() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->members.group_offset();
}

void Group::light(double from) {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  impl_->members.light(from);
}

std::optional<GroupState> Group::take() {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  if (!std::exchange(impl_->is_news, false)) return std::nullopt;
  return impl_->newest.state;
}

bool Group::publish(const GroupState& state) {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  if (!impl_->members.leads()) return false;
  impl_->newest.state = state;
  impl_->has_state = true;
  impl_->write_state(steady_now());
  impl_->take_answers();
  return true;
}

void Group::request(const std::string& command) {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  if (impl_->waiting.size() >= limits::kGroupRequests)
    throw Error(ErrorKind::kDevice, "group " + impl_->name, "no leader takes the requests of this member",
                "check the network between the hosts");
  impl_->waiting.push_back({impl_->own.member, ++impl_->numbered, command});
  impl_->send(impl_->waiting.back());
}

std::vector<GroupRequest> Group::take_requests() {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  std::vector<GroupRequest> taken(impl_->inbox.begin(), impl_->inbox.end());
  impl_->inbox.clear();
  return taken;
}

void Group::finish(const GroupRequest& request, const std::string& refusal) {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  if (impl_->members.leads())
    impl_->newest.applied[request.member] = {request.number, refusal.substr(0, limits::kPageBodyBytes)};
}

std::vector<std::string> Group::take_refusals() {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return std::exchange(impl_->refusals, {});
}

void Group::publish_pose(const track::StampedPose& pose) {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  track::StampedPose sent = pose;
  sent.arrival += impl_->members.group_offset();
  const dds_return_t result =
      internal::write_group_pose(impl_->topics.pose.writer, impl_->name, impl_->own.member, std::move(sent));
  if (result != DDS_RETCODE_OK)
    throw Error(ErrorKind::kDevice, "group " + impl_->name,
                std::string("DDS does not take a pose: ") + dds_strretcode(result), "check the network");
}

std::vector<track::StampedPose> Group::take_poses() {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  std::vector<track::StampedPose> taken(impl_->poses.begin(), impl_->poses.end());
  impl_->poses.clear();
  for (track::StampedPose& pose : taken) pose.arrival -= impl_->members.group_offset();
  return taken;
}

GroupStatus Group::status() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  const internal::GroupMembers& members = impl_->members;
  GroupStatus status;
  status.leads = members.leads();
  const internal::MemberBeat* const leader = members.leader();
  if (status.leads)
    status.leader = impl_->own.host;
  else if (leader != nullptr)
    status.leader = leader->host;
  status.members = members.count();
  status.clock_error = members.clock_error();
  status.clock_is_shared = members.clock_is_shared();
  status.takeovers = members.takeovers();
  status.last_takeover = members.last_takeover();
  status.rejected = impl_->rejected;
  status.waiting = impl_->waiting.size();
  status.lights = members.lights();
  return status;
}

std::string Group::description() const {
  return impl_->topics.description();
}

}  // namespace procam::dds
