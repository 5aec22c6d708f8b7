#include "graph.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <optional>

#include "dds/ddsrt/log.h"
#include "names.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "security.hpp"

namespace procam::dds::internal {
namespace {

/// What Cyclone writes to stderr otherwise. A sample that is no CDR of its type is known from there alone.
class Log {
 public:
  static Log& of_process() {
    static Log* log = new Log;  // Cyclone's threads outlive statics
    return *log;
  }
  DroppedSamples dropped(const std::string& topic) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = dropped_.find(topic);
    return found == dropped_.end() ? DroppedSamples() : found->second;
  }
  std::string last() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return last_;
  }

 private:
  Log() {
    dds_set_log_sink([](void* log, const dds_log_data_t* data) { static_cast<Log*>(log)->take(*data); },
                     this);
  }
  void take(const dds_log_data_t& data) {
    std::string line(data.message, data.size);
    while (!line.empty() && line.back() == '\n') line.pop_back();
    const std::lock_guard<std::mutex> lock(mutex_);
    // Few topics have readers here, and only these are decoded and put together. "... deserialization TOPIC/TYPE failed
    // (...)"; "dropping oversize (... > ...) sample ... from remote writer GUID TOPIC/TYPE"; a type has no slash.
    const std::string undecodable = "deserialization ", oversized = "dropping oversize ";
    if (const std::size_t begin = line.find(undecodable), end = line.find(" failed");
        begin != line.npos && end != line.npos && begin < end)
      count(line.substr(begin + undecodable.size(), end - begin - undecodable.size()),
            &DroppedSamples::undecodable);
    if (line.find(oversized) != line.npos && line.find(" remote writer ") != line.npos)
      count(line.substr(line.rfind(' ') + 1), &DroppedSamples::oversized);
    last_ = std::move(line);
  }

  void count(const std::string& topic_and_type, std::uint64_t DroppedSamples::*which) {
    const std::size_t slash = topic_and_type.rfind('/');
    if (slash != topic_and_type.npos && slash > 0) ++(dropped_[topic_and_type.substr(0, slash)].*which);
  }

  std::mutex mutex_;
  std::map<std::string, DroppedSamples> dropped_;
  std::string last_;
};

/// Deleted after the last participant of procam; the sources of a process share it.
struct Domain {
  dds_entity_t entity = 0;
  std::string network;  ///< "eth0 (192.0.2.2)"
  ~Domain() {
    if (entity > 0) dds_delete(entity);
  }
};

/// The interfaces that Cyclone chooses are in its trace of the start alone: "selected interfaces: eth0 (index 4 ...) ...",
/// then "ownip: udp/192.0.2.2".
class StartTrace {
 public:
  StartTrace() {
    dds_set_trace_sink(
        [](void* trace, const dds_log_data_t* data) {
          static_cast<StartTrace*>(trace)->take({data->message, data->size});
        },
        this);
  }
  ~StartTrace() { dds_set_trace_sink(nullptr, nullptr); }
  std::string network() const {
    return names_ + (names_.empty() || address_.empty() ? "" : " (" + address_ + ")");
  }

 private:
  void take(const std::string& line) {
    const std::string selected = "selected interfaces: ", own = "ownip: ";
    if (line.compare(0, selected.size(), selected) == 0) {
      std::size_t begin = selected.size();
      for (std::size_t end; (end = line.find(" (", begin)) != line.npos;
           begin = line.find_first_not_of(" ,)", end)) {
        names_ += (names_.empty() ? "" : ", ") + line.substr(begin, end - begin);
        end = line.find(')', end);
        if (end == line.npos) break;
      }
    } else if (line.compare(0, own.size(), own) == 0) {
      address_ = line.substr(own.size(), line.find_last_not_of(" \n") + 1 - own.size());
      if (const std::size_t slash = address_.find('/'); slash != address_.npos) address_.erase(0, slash + 1);
    }
  }
  std::string names_, address_;
};

/// What procam sets; what CYCLONEDDS_URI says comes after it and counts more.
std::string configuration() {
  std::string text = "<CycloneDDS><Domain>";
  if (is_localhost_only())
    text +=
        "<General><Interfaces><NetworkInterface address=\"127.0.0.1\" multicast=\"false\"/></Interfaces>"
        "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
        "<MaxAutoParticipantIndex>32</MaxAutoParticipantIndex><Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery>";
  text += "<Internal><MaxSampleSize>" + std::to_string(limits::kDdsSampleBytes) + " B</MaxSampleSize>";
  // Asked for; the system gives what it allows. An image comes as hundreds of packets at once.
  text += "<SocketReceiveBufferSize max=\"8 MiB\"/></Internal>";
  text +=
      "<Tracing><Category>config</Category><OutputFile>/dev/null</OutputFile></Tracing></Domain></CycloneDDS>";
  if (const char* uri = std::getenv("CYCLONEDDS_URI"); uri != nullptr && *uri != '\0')
    text += std::string(",") + uri;
  return text;
}

std::shared_ptr<Domain> domain_of(int id) {
  static std::mutex mutex;
  static std::map<int, std::weak_ptr<Domain>> domains;
  const std::lock_guard<std::mutex> lock(mutex);
  std::shared_ptr<Domain> domain = domains[id].lock();
  if (domain) return domain;
  domain = std::make_shared<Domain>();
  {
    StartTrace trace;
    domain->entity = dds_create_domain(dds_domainid_t(id), configuration().c_str());
    domain->network = trace.network();
  }
  // Another part of the program has the domain: it is used as it is, and stays.
  if (domain->entity < 0 && domain->entity != DDS_RETCODE_PRECONDITION_NOT_MET) {
    const std::string last = Log::of_process().last();
    throw Error(ErrorKind::kDevice, "ROS 2, domain " + std::to_string(id),
                "DDS does not start" + (last.empty() ? "" : ": " + last),
                "check the network and CYCLONEDDS_URI");
  }
  domains[id] = domain;
  return domain;
}

std::unique_ptr<dds_qos_t, QosDelete> qos_of(Reliability reliability, Durability durability, int depth) {
  std::unique_ptr<dds_qos_t, QosDelete> qos(dds_create_qos());
  dds_qset_reliability(
      qos.get(),
      reliability == Reliability::kReliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
      DDS_MSECS(100));
  dds_qset_durability(qos.get(), durability == Durability::kVolatile ? DDS_DURABILITY_VOLATILE
                                                                     : DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth);
  return qos;
}

/// Deleted with its last owner.
std::shared_ptr<const dds_entity_t> participant_of(int domain, const dds_qos_t* qos) {
  return {new dds_entity_t(dds_create_participant(dds_domainid_t(domain), qos, nullptr)),
          [](const dds_entity_t* entity) {
            if (*entity > 0) dds_delete(*entity);
            delete entity;
          }};
}

std::shared_ptr<const dds_entity_t> secured_participant(int domain, const Security& security) {
  static std::mutex mutex;
  static std::map<std::pair<int, std::string>, std::weak_ptr<const dds_entity_t>> participants;
  const std::lock_guard<std::mutex> lock(mutex);
  auto& known = participants[{domain, security.folder}];
  std::shared_ptr<const dds_entity_t> participant = known.lock();
  if (!participant) known = participant = participant_of(domain, security.qos.get());
  return participant;
}

dds_entity_t checked(dds_entity_t entity, const std::string& topic) {
  if (entity == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY)
    throw Error(ErrorKind::kDevice, "ROS 2 topic " + topic,
                "DDS Security does not allow it: " + Log::of_process().last(),
                "allow the topic " + dds_topic(topic) + " in the permissions");
  if (entity < 0)
    throw Error(ErrorKind::kDevice, "ROS 2 topic " + topic,
                std::string("DDS refuses it: ") + dds_strretcode(entity),
                "another part of this program may use it with another type");
  return entity;
}

}  // namespace

Participant::Participant() : domain_(domain_of_environment()) {
  Log::of_process();
  const std::shared_ptr<Domain> kept = domain_of(domain_);
  domain_kept_ = kept;
  network_ = kept->network;
  const Security security = security_of_process();
  security_ = security.folder;
  entity_ = security_.empty() ? participant_of(domain_, nullptr) : secured_participant(domain_, security);
  if (*entity_ < 0 && !security_.empty())
    throw Error(
        ErrorKind::kDevice, "DDS Security, folder '" + security_ + "'",
        "DDS refuses it: " + Log::of_process().last(),
        "check that its certificates are of one authority and not expired, and that its permissions name this "
        "certificate and domain " +
            std::to_string(domain_));
  if (*entity_ < 0)
    throw Error(ErrorKind::kDevice, "ROS 2, domain " + std::to_string(domain_),
                std::string("DDS gives no participant: ") + dds_strretcode(*entity_),
                "check the network and CYCLONEDDS_URI");
}

Participant::~Participant() {
  for (auto entity = kept_.rbegin(); entity != kept_.rend(); ++entity) dds_delete(*entity);
}

dds_entity_t Participant::create_reader(const dds_topic_descriptor_t& type, const std::string& topic,
                                        Reliability reliability, Durability durability, int depth) const {
  const auto qos = qos_of(reliability, durability, depth);
  const dds_entity_t entity =
      kept(checked(dds_create_topic(*entity_, &type, dds_topic(topic).c_str(), nullptr, nullptr), topic));
  return kept(checked(dds_create_reader(*entity_, entity, qos.get(), nullptr), topic));
}

dds_entity_t Participant::create_writer(const dds_topic_descriptor_t& type, const std::string& topic,
                                        Reliability reliability, Durability durability, int depth) const {
  const auto qos = qos_of(reliability, durability, depth);
  const dds_entity_t entity =
      kept(checked(dds_create_topic(*entity_, &type, dds_topic(topic).c_str(), nullptr, nullptr), topic));
  return kept(checked(dds_create_writer(*entity_, entity, qos.get(), nullptr), topic));
}

DroppedSamples dropped_samples(const std::string& topic) {
  return Log::of_process().dropped(dds_topic(topic));
}

}  // namespace procam::dds::internal
