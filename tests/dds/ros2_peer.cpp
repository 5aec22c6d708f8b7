#include "ros2_peer.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <random>

namespace procam::test {

std::string LoopbackDomain::configuration(const std::string& discovery, int lost_per_mille,
                                          const std::string& capture) {
  return "<CycloneDDS><Domain><General><Interfaces><NetworkInterface address=\"127.0.0.1\" multicast=\"false\"/>"
         "</Interfaces><AllowMulticast>false</AllowMulticast></General><Discovery>" +
         discovery +
         "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>10</MaxAutoParticipantIndex>"
         "<Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery><Internal><Test><XmitLossiness>" +
         std::to_string(lost_per_mille) + "</XmitLossiness></Test></Internal>" +
         (capture.empty() ? ""
                          : "<Tracing><PacketCaptureFile>" + capture + "</PacketCaptureFile></Tracing>") +
         "</Domain></CycloneDDS>";
}

LoopbackDomain::LoopbackDomain() {
  // Below 100: ports of higher ones are in the range from which the system gives ports away.
  std::random_device random;
  const unsigned first = random();
  for (unsigned i = 0; i < 99 && lock_ < 0; ++i) {
    number_ = 1 + int((first + i) % 99);
    lock_ = ::open(("/tmp/procam-test-domain-" + std::to_string(number_)).c_str(),
                   O_CREAT | O_RDWR | O_CLOEXEC, 0666);
    if (lock_ >= 0 && ::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
      ::close(lock_);
      lock_ = -1;
    }
  }
  EXPECT_GE(lock_, 0) << "no domain is free";
  ::setenv("ROS_DOMAIN_ID", std::to_string(number_).c_str(), 1);
  ::setenv("CYCLONEDDS_URI", configuration().c_str(), 1);
}

LoopbackDomain::~LoopbackDomain() {
  ::unsetenv("ROS_DOMAIN_ID");
  ::unsetenv("CYCLONEDDS_URI");
  if (lock_ >= 0) ::close(lock_);
}

Ros2Peer::Ros2Peer(const LoopbackDomain& domain, int lost_per_mille, const dds_qos_t* qos,
                   const std::string& capture) {
  static std::atomic<int> others{120};
  const auto id = dds_domainid_t(others++);
  domain_ = dds_create_domain(
      id, LoopbackDomain::configuration(
              "<ExternalDomainId>" + std::to_string(domain.number()) + "</ExternalDomainId>", lost_per_mille,
              capture)
              .c_str());
  participant_ = dds_create_participant(id, qos, nullptr);
  EXPECT_GT(domain_, 0);
  EXPECT_GT(participant_, 0);
}

Ros2Peer::~Ros2Peer() {
  dds_delete(domain_);
}

namespace {

dds_qos_t* qos_of(bool reliable, bool transient_local) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_MSECS(100));
  dds_qset_durability(qos, transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 100);
  return qos;
}

}  // namespace

dds_entity_t Ros2Peer::writer(const dds_topic_descriptor_t& type, const std::string& topic, bool reliable,
                              bool transient_local) const {
  dds_qos_t* qos = qos_of(reliable, transient_local);
  const dds_entity_t entity = dds_create_topic(participant_, &type, topic.c_str(), nullptr, nullptr);
  const dds_entity_t writer = dds_create_writer(participant_, entity, qos, nullptr);
  dds_delete_qos(qos);
  EXPECT_GT(writer, 0) << dds_strretcode(writer);
  return writer;
}

dds_entity_t Ros2Peer::reader(const dds_topic_descriptor_t& type, const std::string& topic, bool reliable,
                              bool transient_local) const {
  dds_qos_t* qos = qos_of(reliable, transient_local);
  const dds_entity_t entity = dds_create_topic(participant_, &type, topic.c_str(), nullptr, nullptr);
  const dds_entity_t reader = dds_create_reader(participant_, entity, qos, nullptr);
  dds_delete_qos(qos);
  EXPECT_GT(reader, 0) << dds_strretcode(reader);
  return reader;
}

}  // namespace procam::test
