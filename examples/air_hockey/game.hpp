#pragma once
/// A match with its players, step by step, and how it is written down.
#include <filesystem>
#include <memory>

#include "match.hpp"
#include "players.hpp"

namespace hockey {

/// What a match depends on, and what came of it. Numbers are written digit by digit (hexadecimal), so the
/// same program plays the same match again, bit for bit.
struct Recording {
  std::uint64_t seed = 1;
  Table table;
  std::vector<Match::Hands> steps;
  std::uint64_t fingerprint = 0;  ///< of the puck, paddles and score after every step
};
/// Throws procam::Error naming the line.
Recording load_recording(const std::filesystem::path& file);
void save_recording(const std::filesystem::path& file, const Recording& recording);
bool operator==(const Table& a, const Table& b);

struct GameOptions {
  std::uint64_t seed = 1;
  bool bots_stand_in = false;  ///< a bot plays for a hand that is not there, instead of a pause
  bool records = false;
};

class Game {
 public:
  Game(Table table, std::unique_ptr<Players> players, const GameOptions& options);

  /// To `time`, seconds since the begin; hands are taken where they will be at `light_time`.
  void advance(double time, double light_time);

  const Match& match() const { return match_; }
  const Players& players() const { return *players_; }
  bool is_over() const { return match_.phase() == Phase::kOver || players_->are_gone(); }
  /// What was played so far; its steps only when it is recorded.
  const Recording& recording() const { return recording_; }

 private:
  Match match_;
  std::unique_ptr<Players> players_;
  GameOptions options_;
  Bot stand_ins_[2];
  Recording recording_;
};

/// The hands of a recording, one pair a step.
std::unique_ptr<Players> recorded_hands(std::vector<Match::Hands> steps);

}  // namespace hockey
