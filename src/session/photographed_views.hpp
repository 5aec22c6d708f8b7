#pragma once
/// Sessions of one photograph a view.
#include "procam/session/shown_views.hpp"

namespace procam::session {

/// What the flags name, else shown.json of the folder; nullopt where there is neither. `projector_size` may
/// come from the frames. Throws Error(kInput) for a view without a photograph, for photographs that nothing
/// is known of, for boards whose first corner is not settled, and for a printed board that cannot be told
/// from the projected ones.
std::optional<ShownViews> plan_shown_views(const std::filesystem::path& folder, const ShownFlags& flags,
                                           std::optional<ImageSize> projector_size, const Board& printed);

/// The two boards of one view; `unlit` may be empty.
session::BoardView read_shown_view(const ShownViews& shown, const PhotographedView& view,
                                   const ImageU8& photograph, const ImageU8& unlit, const Board& printed);

}  // namespace procam::session
