#pragma once
/// How procam fails.
///
/// - A caller's bug (broken precondition): std::invalid_argument, through require().
/// - No answer for this element (behind the lens, parallel ray): std::optional, no message.
/// - A person must act (file, too few views, degenerate layout): procam::Error, whose message has three parts:
///   what (with file, line or view), why, and what to do next.
/// - Success with remarks: Diagnostics travel inside the result. Libraries never print.
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "procam/core/base/export.hpp"

namespace procam {

enum class ErrorKind { kInput, kNotEnoughData, kDegenerate, kNotConverged, kUnsupported, kIo, kDevice };

inline const char* to_string(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kInput:
      return "input";
    case ErrorKind::kNotEnoughData:
      return "not_enough_data";
    case ErrorKind::kDegenerate:
      return "degenerate";
    case ErrorKind::kNotConverged:
      return "not_converged";
    case ErrorKind::kUnsupported:
      return "unsupported";
    case ErrorKind::kIo:
      return "io";
    case ErrorKind::kDevice:
      return "device";
  }
  return "unknown";
}

/// An error that a person must act on. what() reads "<what>: <why>; <next>".
class PROCAM_EXPORT Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, std::string what, std::string why, std::string next)
      : std::runtime_error(what + ": " + why + "; " + next),
        kind_(kind),
        what_(std::move(what)),
        why_(std::move(why)),
        next_(std::move(next)) {}

  ErrorKind kind() const { return kind_; }
  /// The thing that failed, with its file, line, view or field.
  const std::string& subject() const { return what_; }
  const std::string& why() const { return why_; }
  /// What the person can do about it.
  const std::string& next() const { return next_; }

 private:
  ErrorKind kind_;
  std::string what_, why_, next_;
};

/// Throws std::invalid_argument: a caller's bug, at the public entry of a stage; never in per-pixel code.
inline void require(bool condition, const std::string& message) {
  if (!condition) throw std::invalid_argument(message);
}

enum class Severity {
  kNote,     ///< a decision that the person may want to know
  kWarning,  ///< the result stands, but something deserves a look
  kFailure   ///< a quality gate failed: the result is written, marked, and the tool exits with 5
};

/// One remark about a result: a stable code for programs, a sentence for people.
struct Diagnostic {
  Severity severity = Severity::kNote;
  std::string code;     ///< snake_case, e.g. "board_flipped"
  std::string message;  ///< what, why, what to do next
};

struct Diagnostics {
  std::vector<Diagnostic> items;

  void note(std::string code, std::string message) {
    add(Severity::kNote, std::move(code), std::move(message));
  }
  void warn(std::string code, std::string message) {
    add(Severity::kWarning, std::move(code), std::move(message));
  }
  void fail(std::string code, std::string message) {
    add(Severity::kFailure, std::move(code), std::move(message));
  }
  void append(const Diagnostics& other) {
    for (const Diagnostic& item : other.items) items.push_back(item);
  }

  bool failed() const {
    for (const Diagnostic& item : items)
      if (item.severity == Severity::kFailure) return true;
    return false;
  }
  const Diagnostic* find(const std::string& code) const {
    for (const Diagnostic& item : items)
      if (item.code == code) return &item;
    return nullptr;
  }

 private:
  void add(Severity severity, std::string code, std::string message) {
    items.push_back({severity, std::move(code), std::move(message)});
  }
};

}  // namespace procam
