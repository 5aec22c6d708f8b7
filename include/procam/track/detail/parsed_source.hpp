#pragma once
/// A byte source and a parser make a source of messages.
#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "procam/core/base/limits.hpp"
#include "procam/track/byte_source.hpp"
#include "procam/track/detail/inbox.hpp"

namespace procam::track::internal {

/// A parser of datagrams without state.
template <auto function>
struct Stateless {
  auto parse(std::string_view bytes) const { return function(bytes); }
};

/// Parser::parse(bytes) returns a struct with malformed, why and the list of messages `messages` (a pointer to
/// member). Each stream has its own parser. Parsing runs on the byte source's thread, where the bytes arrive.
template <typename Source, typename Message, typename Parser, auto messages>
class ParsedSource final : public Source, private ByteHandler {
 public:
  ParsedSource(const std::string& text, const SourceOptions& options)
      : inbox_(options), bytes_(open_byte_source(text, *this)) {}
  void poll(std::vector<Message>& arrived) override { inbox_.poll(arrived); }
  void wait(double seconds) override { inbox_.wait(seconds); }
  SourceStatus status() const override { return inbox_.status(); }

 private:
  void received(int peer, std::string_view bytes, double arrival) override {
    auto parsed = parsers_[std::size_t(peer)].parse(bytes);
    inbox_.put(parsed, parsed.*messages, arrival, bytes.size());
  }
  void connected(int peer) override {
    parsers_[std::size_t(peer)] = Parser();
    inbox_.connected();
  }
  void disconnected(int, const std::string& why) override { inbox_.disconnected(why); }
  void failed(const std::string& why) override { inbox_.failed(why); }

  InboxOf<Message> inbox_;
  std::array<Parser, limits::kSenders> parsers_;
  std::unique_ptr<ByteSource> bytes_;  ///< last: its thread uses the others until it is destroyed
};

}  // namespace procam::track::internal
