#pragma once
/// A keystore of ROS 2 as `ros2 security` writes it, by the openssl program: a certificate authority, and enclaves that it signed.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "io/scratch.hpp"

namespace procam::test {

class Keystore {
 public:
  Keystore() { make_authority(at("ca.key.pem"), at("ca.cert.pem")); }

  /// `topics`: that may be published and read, as expressions of DDS names ("rt/tf*").
  std::filesystem::path enclave(const std::string& name, const std::string& topics = "*") const {
    namespace fs = std::filesystem;
    const fs::path folder = folder_ / "enclaves" / name;
    fs::create_directories(folder);
    const auto file = [&](const char* part) { return " " + (folder / part).string(); };
    make_key(file("key.pem"));
    run("openssl req -new -key" + file("key.pem") + " -subj /CN=" + name + " -out" + file("request"));
    run("openssl x509 -req -in" + file("request") + " -CA " + at("ca.cert.pem") + " -CAkey " +
        at("ca.key.pem") + " -CAcreateserial -days 30 -out" + file("cert.pem"));
    for (const char* const ca : {"identity_ca.cert.pem", "permissions_ca.cert.pem"})
      fs::copy_file(folder_ / "ca.cert.pem", folder / ca, fs::copy_options::overwrite_existing);
    std::ofstream(folder / "governance.xml") << governance();
    std::ofstream(folder / "permissions.xml") << permissions(name, topics);
    for (const char* const document : {"governance", "permissions"})
      run("openssl smime -sign -text -in" + file(document) + ".xml -out" + file(document) + ".p7s -signer " +
          at("ca.cert.pem") + " -inkey " + at("ca.key.pem"));
    return folder;
  }
  std::filesystem::path folder() const { return folder_.path(); }

 private:
  std::string at(const char* file) const { return (folder_ / file).string(); }
  static void run(const std::string& command) {
    EXPECT_EQ(std::system((command + " >/dev/null 2>&1").c_str()), 0) << command;
  }
  static void make_key(const std::string& file) {
    run("openssl ecparam -name prime256v1 -genkey -noout -out " + file);
  }
  static void make_authority(const std::string& key, const std::string& certificate) {
    make_key(key);
    run("openssl req -x509 -new -key " + key + " -days 30 -subj /CN=authority -out " + certificate);
  }
  static std::string document(const std::string& kind, const std::string& inside) {
    return R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_)" +
           kind + ".xsd\">\n" + inside + "\n</dds>\n";
  }
  /// As that of ROS 2's keystores.
  static std::string governance() {
    return document("governance", R"(<domain_access_rules><domain_rule>
<domains><id_range><min>0</min><max>230</max></id_range></domains>
<allow_unauthenticated_participants>false</allow_unauthenticated_participants>
<enable_join_access_control>true</enable_join_access_control>
<discovery_protection_kind>ENCRYPT</discovery_protection_kind>
<liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
<rtps_protection_kind>SIGN</rtps_protection_kind>
<topic_access_rules><topic_rule><topic_expression>*</topic_expression>
<enable_discovery_protection>true</enable_discovery_protection>
<enable_liveliness_protection>true</enable_liveliness_protection>
<enable_read_access_control>true</enable_read_access_control>
<enable_write_access_control>true</enable_write_access_control>
<metadata_protection_kind>ENCRYPT</metadata_protection_kind>
<data_protection_kind>ENCRYPT</data_protection_kind>
</topic_rule></topic_access_rules></domain_rule></domain_access_rules>)");
  }
  static std::string permissions(const std::string& name, const std::string& topics) {
    const std::string allowed = "<topics><topic>" + topics + "</topic></topics>";
    return document("permissions",
                    "<permissions><grant name=\"" + name + "\"><subject_name>CN=" + name +
                        R"(</subject_name>
<validity><not_before>2013-10-26T00:00:00</not_before><not_after>2053-10-26T22:45:30</not_after></validity>
<allow_rule><domains><id_range><min>0</min><max>230</max></id_range></domains>
<publish>)" + allowed + "</publish><subscribe>" +
                        allowed + "</subscribe></allow_rule><default>DENY</default></grant></permissions>");
  }
  Scratch folder_;
};

}  // namespace procam::test
