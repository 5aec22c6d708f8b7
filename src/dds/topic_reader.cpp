#include "topic_reader.hpp"

#include <algorithm>
#include <utility>

#include "names.hpp"
#include "procam/core/base/detail/plain_text.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::dds::internal {

void attach_data(dds_entity_t waitset, dds_entity_t reader) {
  dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS);
  dds_waitset_attach(waitset, reader, 0);
}

std::string ros_type(std::string type) {
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"::dds_::", "/"}, {"::", "/"}})
    for (std::size_t at; (at = type.find(from)) != type.npos;) type.replace(at, from.size(), to);
  if (!type.empty() && type.back() == '_') type.pop_back();
  return procam::internal::to_plain_text(type.substr(0, 200));
}

TopicReader::TopicReader(const Participant& participant, dds_entity_t waitset, std::string topic, Types types,
                         int depth)
    : participant_(participant),
      waitset_(waitset),
      topic_(std::move(topic)),
      types_(std::move(types)),
      depth_(depth) {}

std::string TopicReader::discovered(const dds_builtintopic_endpoint_t& endpoint,
                                    const dds_sample_info_t& info) {
  Key key;
  std::copy_n(endpoint.key.v, key.size(), key.begin());
  if (!info.valid_data || info.instance_state != DDS_IST_ALIVE) {
    if (publishers_.erase(key) > 0) follow();
    return {};
  }
  if (endpoint.topic_name == nullptr || endpoint.topic_name != dds_topic(topic_)) return {};
  const std::string type = endpoint.type_name == nullptr ? "" : endpoint.type_name;
  const auto known =
      std::find_if(types_.begin(), types_.end(), [&](const auto* one) { return type == one->m_typename; });
  const auto sentence = [&] {
    return info.view_state != DDS_VST_NEW
               ? std::string()
               : topic_ + " is published as " + ros_type(type) + ", which is not read here";
  };
  if (known == types_.end()) return sentence();
  if (publishers_.size() >= limits::kRos2Publishers && publishers_.count(key) == 0) return {};
  Publisher& publisher = publishers_[key];
  publisher.type = *known;
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  dds_qget_reliability(endpoint.qos, &reliability, nullptr);
  dds_qget_durability(endpoint.qos, &durability);
  publisher.reliability =
      reliability == DDS_RELIABILITY_RELIABLE ? Reliability::kReliable : Reliability::kBestEffort;
  publisher.durability =
      durability == DDS_DURABILITY_VOLATILE ? Durability::kVolatile : Durability::kTransientLocal;
  follow();
  return *known == type_ ? std::string() : sentence();
}

std::size_t TopicReader::publishers() const {
  return std::size_t(std::count_if(publishers_.begin(), publishers_.end(),
                                   [&](const auto& one) { return one.second.type == type_; }));
}

void TopicReader::follow() {
  if (publishers_.empty()) return;  // one that comes back finds the reader
  // A second type is read once the first has no publisher.
  Publisher wanted{type_, Reliability::kReliable, Durability::kTransientLocal};
  if (publishers() == 0) wanted.type = publishers_.begin()->second.type;
  for (const auto& [key, publisher] : publishers_) {
    if (publisher.type != wanted.type) continue;
    if (publisher.reliability == Reliability::kBestEffort) wanted.reliability = Reliability::kBestEffort;
    if (publisher.durability == Durability::kVolatile) wanted.durability = Durability::kVolatile;
  }
  // What a publisher keeps for late readers is sent again only to a reliable one.
  if (wanted.reliability == Reliability::kBestEffort) wanted.durability = Durability::kVolatile;
  if (reader_ > 0 && type_ == wanted.type && reliability_ == wanted.reliability &&
      durability_ == wanted.durability)
    return;
  if (reader_ > 0) {
    const dds_entity_t topic = dds_get_topic(reader_);
    dds_waitset_detach(waitset_, reader_);
    dds_delete(std::exchange(reader_, 0));
    dds_delete(topic);  // another type can have it then
  }
  reader_ = participant_.create_reader(*wanted.type, topic_, wanted.reliability, wanted.durability, depth_);
  type_ = wanted.type;
  reliability_ = wanted.reliability;
  durability_ = wanted.durability;
  attach_data(waitset_, reader_);
}

}  // namespace procam::dds::internal
