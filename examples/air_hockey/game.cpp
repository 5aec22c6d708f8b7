#include "game.hpp"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include "procam/core/base/error.hpp"

namespace hockey {
namespace {

using procam::Error;
using procam::ErrorKind;

constexpr char kHeader[] = "procam-air-hockey 1";

/// FNV-1a.
void mix(std::uint64_t& hash, const void* data, std::size_t size) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 0x100000001b3ull;
}

std::string digits(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%a", value);
  return text;
}
std::string digits(const std::optional<Vec2>& hand) {
  return hand ? digits(hand->x()) + " " + digits(hand->y()) : "- -";
}

class RecordedHands : public Players {
 public:
  explicit RecordedHands(std::vector<Match::Hands> steps) : steps_(std::move(steps)) {}
  Match::Hands hands(const Match&, double) override {
    return next_ < steps_.size() ? steps_[next_++] : Match::Hands{};
  }
  bool is_bot() const override { return true; }
  bool are_gone() const override { return next_ == steps_.size(); }

 private:
  std::vector<Match::Hands> steps_;
  std::size_t next_ = 0;
};

}  // namespace

bool operator==(const Table& a, const Table& b) {
  const auto same = [](const Segment& s, const Segment& t) { return s.a == t.a && s.b == t.b; };
  return a.length == b.length && a.width == b.width && a.goal == b.goal && a.puck == b.puck &&
         a.paddle == b.paddle &&
         std::equal(a.obstacles.begin(), a.obstacles.end(), b.obstacles.begin(), b.obstacles.end(), same);
}

void save_recording(const std::filesystem::path& file, const Recording& recording) {
  const std::filesystem::path written = file.string() + ".part";
  std::ofstream out(written);
  const Table& t = recording.table;
  out << kHeader << "\nseed " << recording.seed << "\ntable " << digits(t.length) << ' ' << digits(t.width)
      << ' ' << digits(t.goal) << ' ' << digits(t.puck) << ' ' << digits(t.paddle) << '\n';
  for (const Segment& s : t.obstacles) out << "obstacle " << digits(s.a) << ' ' << digits(s.b) << '\n';
  for (const Match::Hands& hands : recording.steps)
    out << "step " << digits(hands[0]) << ' ' << digits(hands[1]) << '\n';
  out << "end " << recording.fingerprint << '\n';
  out.close();
  std::error_code failed;
  if (out) std::filesystem::rename(written, file, failed);
  if (!out || failed)
    throw Error(ErrorKind::kIo, file.string(), "it cannot be written", "give a place that can");
}

Recording load_recording(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw Error(ErrorKind::kIo, file.string(), "it cannot be read", "name a recording of air_hockey");
  Recording recording;
  std::string line;
  int number = 1;
  const auto refuse = [&](const std::string& why) {
    return Error(ErrorKind::kInput, file.string() + ":" + std::to_string(number), why,
                 "record the match again with --record");
  };
  if (!std::getline(in, line) || line != kHeader) throw refuse("it is no recording of air_hockey");
  bool has_end = false, has_table = false;
  for (number = 2; std::getline(in, line); ++number) {
    std::istringstream words(line);
    std::string what, word;
    words >> what;
    std::vector<std::optional<double>> values;
    if (what == "seed" || what == "end") {
      (what == "seed" ? recording.seed : recording.fingerprint) = 0;
      if (has_end || !(words >> (what == "seed" ? recording.seed : recording.fingerprint)))
        throw refuse("'" + what + "' is followed by no number");
      has_end |= what == "end";
      continue;
    }
    while (words >> word) {
      char* end = nullptr;
      const double value = std::strtod(word.c_str(), &end);
      if (word != "-" && (*end != '\0' || !std::isfinite(value) || std::abs(value) > 1e3))
        throw refuse("'" + word + "' is no place on a table");
      values.push_back(word == "-" ? std::nullopt : std::optional<double>(value));
    }
    const auto all = [&](std::size_t count) {
      if (values.size() != count) return false;
      return std::all_of(values.begin(), values.end(), [](const auto& v) { return v.has_value(); });
    };
    const auto point = [&](std::size_t i) { return Vec2(*values[i], *values[i + 1]); };
    if (what == "table" && all(5)) {
      Table& t = recording.table;
      t.length = *values[0], t.width = *values[1], t.goal = *values[2], t.puck = *values[3],
      t.paddle = *values[4];
      has_table = true;
    } else if (what == "obstacle" && all(4)) {
      recording.table.obstacles.push_back({point(0), point(2)});
    } else if (what == "step" && values.size() == 4 && !has_end) {
      Match::Hands hands;
      for (std::size_t i = 0; i < 2; ++i) {
        if (values[2 * i].has_value() != values[2 * i + 1].has_value()) throw refuse("half a hand");
        if (values[2 * i]) hands[i] = point(2 * i);
      }
      recording.steps.push_back(hands);
    } else {
      throw refuse("the line is not understood");
    }
  }
  if (!has_table || !has_end) throw refuse("it is cut short");
  return recording;
}

std::unique_ptr<Players> recorded_hands(std::vector<Match::Hands> steps) {
  return std::make_unique<RecordedHands>(std::move(steps));
}

Game::Game(Table table, std::unique_ptr<Players> players, const GameOptions& options)
    : match_(table, {}, options.seed),
      players_(std::move(players)),
      options_(options),
      stand_ins_{Bot(0, options.seed), Bot(1, options.seed)} {
  recording_.seed = options.seed;
  recording_.table = std::move(table);
  recording_.fingerprint = 0xcbf29ce484222325ull;
}

void Game::advance(double time, double light_time) {
  Match::Hands hands;
  if (!players_->is_bot()) hands = players_->hands(match_, light_time);
  while (match_.time() + Match::kStep <= time && !is_over()) {
    if (players_->is_bot()) hands = players_->hands(match_, light_time);
    Match::Hands now = hands;
    for (std::size_t i = 0; i < 2; ++i)
      if (options_.bots_stand_in && !now[i]) now[i] = stand_ins_[i].hand(match_);
    if (options_.records) recording_.steps.push_back(now);
    match_.step(now);
    for (int side = 0; side < 2; ++side) {
      mix(recording_.fingerprint, match_.paddle(side).data(), 2 * sizeof(double));
      const int score = match_.score(side);
      mix(recording_.fingerprint, &score, sizeof score);
    }
    mix(recording_.fingerprint, match_.puck().data(), 2 * sizeof(double));
  }
}

}  // namespace hockey
