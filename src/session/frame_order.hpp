#pragma once
/// Private to session: captures of Gray code that another program showed in another order.
#include <optional>
#include <string>
#include <vector>

#include "procam/pattern/gray_code.hpp"

namespace procam::session {

/// The order of the axes alone.
inline constexpr const char* kRowsFirst = "rows come before columns";

/// In which of the usual orders the captures decode to a continuous image of the projector, while they do not in the one of
/// make-patterns, in words: "rows come before columns, and each inverse before its pattern". nullopt where the order is as
/// expected or none of the others explains them. `captures` as pattern::decode() takes them.
std::optional<std::string> other_frame_order(const std::vector<ViewU8>& captures,
                                             const pattern::GrayCode& gray_code);

}  // namespace procam::session
