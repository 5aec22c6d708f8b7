#pragma once
/// What the control page's server reads and writes, without sockets.
#include <optional>
#include <string>
#include <string_view>

#include "control_page.hpp"

namespace procam::show {

/// 128 random bits in hexadecimal digits.
std::string random_token();

/// Takes the same time wherever they differ.
bool same_secret(std::string_view a, std::string_view b);

/// The token of a request: "Authorization: Bearer", or ?token= of its target; empty: none.
std::string token_of(std::string_view target, std::string_view authorization);

std::string to_json_text(const PageStatus& status);

/// nullopt for what is no command.
std::optional<Command> to_command(std::string_view text);
/// The text that to_command() reads.
std::string to_message(const Command& command);

}  // namespace procam::show
