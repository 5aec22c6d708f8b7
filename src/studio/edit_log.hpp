#pragma once
/// Who has changed what, so that of two pages neither overwrites the other's change without noticing.
///
/// Each state has a revision. A page sends with its edit the revision that it had when the person began (took hold of a
/// corner, went into a field). If another page has changed the same thing since, the edit is not made: it is held, and the
/// person chooses on the page that sent it. Edits of scripts, which have no page, are made always.
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "page.hpp"

namespace procam::studio {

/// What a command changes, in words: "corner 3 of 'wall 1'", "the number of poses"; empty for a command that edits nothing.
/// A removed surface takes several.
std::vector<std::string> edited_things(const StudioCommand& command);

class EditLog {
 public:
  std::uint64_t revision() const { return revision_; }

  /// The first thing of the command that another page has changed since the person began.
  std::optional<std::string> conflict(const StudioCommand& command) const;
  /// The command has been executed.
  void record(const StudioCommand& command);

  /// Kept until the page that sent it decides; a page has one at a time.
  struct Held {
    StudioCommand command;
    std::string thing;
  };
  void hold(const StudioCommand& command, const std::string& thing);
  /// Removes and returns it.
  std::optional<Held> take_held(const std::string& page);
  const std::map<std::string, Held>& held() const { return held_; }

  /// The newest edit of all.
  struct Edit {
    std::uint64_t revision = 0;
    std::string page, thing;
  };
  const Edit& newest() const { return newest_; }

 private:
  std::uint64_t revision_ = 1;
  /// Of each thing the newest revision by each page.
  std::map<std::string, std::map<std::string, std::uint64_t>> changed_;
  std::map<std::string, Held> held_;
  Edit newest_;
};

}  // namespace procam::studio
