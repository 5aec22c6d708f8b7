#include "common/note_groups.hpp"
#include "procam/core/base/stats.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <set>
#include <sstream>
#include <utility>

namespace procam::tools {
namespace {

constexpr std::size_t kMinGroup = 3, kMaxNamed = 3, kMaxViews = 20;
constexpr double kFarDeviations = 5, kFarShare = 0.1;

/// A text taken apart: the words around its numbers, and these.
struct Template {
  std::string subject;             ///< "view 'a', projector: "; may be empty
  std::vector<std::string> words;  ///< one more than numbers
  std::vector<double> numbers;

  bool same_kind(const Template& other) const { return words == other.words; }
};

Template taken_apart(const std::string& message) {
  Template text;
  std::size_t at = 0;
  if (message.rfind("view ", 0) == 0 && message.find(": ") != std::string::npos) at = message.find(": ") + 2;
  text.subject = message.substr(0, at);
  text.words.emplace_back();
  const auto digit = [&](std::size_t i) { return i < message.size() && std::isdigit(message[i]) != 0; };
  // Digits of a name ("frame_07.png", "k1") are no number: a mean of names is the name of nothing.
  const auto in_name = [&](std::size_t i) {
    return i > 0 && (std::isalpha(static_cast<unsigned char>(message[i - 1])) != 0 || message[i - 1] == '_');
  };
  while (at < message.size()) {
    if (!digit(at)) {
      text.words.back() += message[at++];
      continue;
    }
    if (in_name(at)) {
      while (digit(at)) text.words.back() += message[at++];
      continue;
    }
    std::size_t end = at;
    while (digit(end) || (message[end] == '.' && digit(end + 1))) ++end;
    text.numbers.push_back(std::strtod(message.substr(at, end - at).c_str(), nullptr));
    text.words.emplace_back();
    at = end;
  }
  return text;
}

std::string line(const Diagnostic& item) {
  return std::string(to_string(item.severity)) + ": " + item.message;
}

/// "view_00" of "view 'view_00', camera: " and of "view view_00: ".
std::string view_name(const std::string& subject) {
  const std::size_t quote = subject.find('\''), end = subject.find('\'', quote + 1);
  if (end != std::string::npos) return subject.substr(quote + 1, end - quote - 1);
  return subject.size() > 7 ? subject.substr(5, subject.size() - 7) : "";
}

/// " (view_00, view_03)": of warnings, each of which asks for something to be done about its view.
std::string names_of_views(const std::vector<Template>& texts) {
  std::string names;
  for (std::size_t i = 0; i < texts.size() && i < kMaxViews; ++i)
    names += (i > 0 ? ", " : " (") + view_name(texts[i].subject);
  if (texts.size() > kMaxViews) names += " and " + std::to_string(texts.size() - kMaxViews) + " more";
  return names + ")";
}

std::string group_line(const std::vector<const Diagnostic*>& group, const std::vector<Template>& texts) {
  const std::size_t numbers = texts.front().numbers.size();
  std::vector<double> middles;
  double largest = 0;
  for (std::size_t n = 0; n < numbers; ++n) {
    std::vector<double> values;
    for (const Template& text : texts) values.push_back(text.numbers[n]);
    middles.push_back(median(values));
    largest = std::max(largest, middles.back());
  }
  std::set<std::size_t> far;
  bool alike = true;
  for (std::size_t n = 0; n < numbers; ++n) {
    std::vector<double> deviations;
    for (const Template& text : texts) deviations.push_back(std::abs(text.numbers[n] - middles[n]));
    const double limit = std::max(kFarDeviations * median(deviations), kFarShare * largest);
    for (std::size_t i = 0; i < deviations.size(); ++i) {
      alike = alike && deviations[i] == 0;
      if (deviations[i] > limit) far.insert(i);
    }
  }
  std::ostringstream out;
  const Severity severity = group.front()->severity;
  const bool of_views = !texts.front().subject.empty();
  out << to_string(severity) << ": " << group.size() << (of_views ? " views" : " times")
      << (of_views && severity == Severity::kWarning ? names_of_views(texts) : "") << ": ";
  for (std::size_t n = 0; n <= numbers; ++n) {
    out << texts.front().words[n];
    if (n < numbers) out << middles[n];
  }
  if (!alike) out << " (medians)";
  std::size_t named = 0;
  for (const std::size_t i : far) {
    if (named == kMaxNamed) {
      out << "; and " << far.size() - named << " more";
      break;
    }
    out << (named++ == 0 ? "; far from them: " : "; ") << group[i]->message;
  }
  return out.str();
}

}  // namespace

const char* to_string(Severity severity) {
  switch (severity) {
    case Severity::kNote:
      return "note";
    case Severity::kWarning:
      return "warning";
    case Severity::kFailure:
      return "failure";
  }
  return "unknown";
}

std::vector<std::string> lines_for_people(const Diagnostics& diagnostics) {
  const std::vector<Diagnostic>& items = diagnostics.items;
  std::vector<Template> texts;
  for (const Diagnostic& item : items) texts.push_back(taken_apart(item.message));
  std::vector<std::string> lines;
  std::vector<char> done(items.size(), 0);
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (done[i]) continue;
    std::vector<std::size_t> members{i};
    const bool may_have_others = items[i].severity == Severity::kNote ||
                                 (items[i].severity == Severity::kWarning && !texts[i].subject.empty());
    for (std::size_t j = i + 1; may_have_others && j < items.size(); ++j)
      if (items[j].severity == items[i].severity && items[j].code == items[i].code &&
          texts[j].same_kind(texts[i]))
        members.push_back(j);
    if (members.size() < kMinGroup) {
      lines.push_back(line(items[i]));
      continue;
    }
    std::vector<const Diagnostic*> group;
    std::vector<Template> of_group;
    for (const std::size_t member : members) {
      done[member] = 1;
      group.push_back(&items[member]);
      of_group.push_back(texts[member]);
    }
    lines.push_back(group_line(group, of_group));
  }
  return lines;
}

}  // namespace procam::tools
