#include "playback.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <thread>

namespace procam::device::internal {

namespace {

using Number = std::int64_t;  ///< of a picture, counted on through all repetitions

/// Pictures w .. w + kAhead - 1 are wanted at hand while w is shown. One more slot holds what the caller
/// looks at, and one what was decoded before the time had gone on.
constexpr Number kAhead = 3;
constexpr std::size_t kSlots = std::size_t(kAhead) + 2;

/// A decoder that falls behind still shows one picture in so many that it passes over.
constexpr Number kMaxUnseen = 16;

/// 3 / 25 s * 25 / s must be picture 3, whatever the rounding.
constexpr double kRounding = 1e-6;

/// After a fault.
constexpr std::chrono::seconds kBetweenTries{1};

class Playback : public ContentSource {
 public:
  Playback(std::unique_ptr<PictureReader> reader, double rate_hz, const ContentOptions& options)
      : reader_(std::move(reader)), rate_hz_(rate_hz), options_(options) {
    Slot& first = slots_[0];
    if (!reader_->read(first.picture)) throw no_picture();
    remarks_ = reader_->remarks();
    position_ = 1;
    shape_ = first.picture.view();
    first.number = 0;
    shown_ = &first;
    thread_ = std::thread([this] { decode(); });
  }
  ~Playback() override {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  ContentFrame at(double time_s) override {
    std::unique_lock<std::mutex> lock(mutex_);
    const double number = std::floor(time_s * rate_hz_ + kRounding);
    constexpr double kMax = 9e15;                               // whole numbers beyond are not exact
    wanted_ = number > 0 ? Number(std::min(number, kMax)) : 0;  // NaN: 0
    changed_.notify_all();
    if (options_.pace == Pace::kExact) {
      changed_.wait(lock, [&] { return find(last_wanted()) != nullptr || fault_; });
      if (!find(last_wanted())) throw *fault_;
    }
    if (Slot* const best = newest()) shown_ = best;
    const Number in_file = length_ > 0 ? shown_->number % length_ : shown_->number;
    return {shown_->picture.view(), std::uint64_t(in_file) + 1};
  }

  std::optional<Error> fault() const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return fault_;
  }
  double rate_hz() const override { return rate_hz_; }
  Diagnostics diagnostics() const override { return remarks_; }

 private:
  static constexpr Number kEmpty = -1, kLost = std::numeric_limits<Number>::max();
  struct Slot {
    ImageU8 picture;
    Number number = kEmpty;
  };

  Error no_picture() const {
    return Error(ErrorKind::kInput, reader_->name(), "it holds no picture that can be read",
                 "play it with another program, or convert it");
  }

  /// What wanted_ means once the end is known.
  Number last_wanted() const {
    return !options_.loop && length_ > 0 ? std::min(wanted_, length_ - 1) : wanted_;
  }
  Slot* find(Number number) {
    for (Slot& slot : slots_)
      if (slot.number == number) return &slot;
    return nullptr;
  }
  /// Not after its time; nullptr when there is none.
  Slot* newest() {
    Slot* best = nullptr;
    for (Slot& slot : slots_)
      if (slot.number != kEmpty && slot.number <= wanted_ && (!best || slot.number > best->number))
        best = &slot;
    return best;
  }
  /// The first picture that is wanted and not there; kEmpty when all are.
  Number missing() {
    const Number first = last_wanted(),
                 end = !options_.loop && length_ > 0 ? std::min(first + kAhead, length_) : first + kAhead;
    for (Number n = first; n < end; ++n)
      if (!find(n)) return n;
    return kEmpty;
  }
  /// A slot that is neither looked at nor wanted, emptied.
  Slot& free_slot() {
    const Slot* const best = newest();
    for (Slot& slot : slots_) {
      if (&slot == shown_ || &slot == best) continue;
      if (slot.number >= last_wanted() && slot.number < last_wanted() + kAhead) continue;
      slot.number = kEmpty;
      return slot;
    }
    // One is missing of kAhead, so at most kAhead - 1 are held for them, one is shown and one is the newest.
    throw std::logic_error("Playback: no free slot");
  }

  /// A file that cannot be read is tried again every second: it may be replaced while it is shown.
  void decode() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (!stop_) {
      try {
        decode_missing(lock);
        continue;
      } catch (const Error& error) {
        if (!lock.owns_lock()) lock.lock();
        fault_ = error;
      } catch (const std::exception& error) {
        if (!lock.owns_lock()) lock.lock();
        fault_ = Error(ErrorKind::kInput, reader_->name(), error.what(), "play it with another program");
      }
      changed_.notify_all();
      changed_.wait_for(lock, kBetweenTries, [this] { return stop_; });
      position_ = kLost;
    }
  }

  void decode_missing(std::unique_lock<std::mutex>& lock) {
    Number number = missing();
    if (number == kEmpty) {
      changed_.wait(lock);
      return;
    }
    Slot& slot = free_slot();
    const Number length_before = length_;
    lock.unlock();
    const bool there = read(number, slot.picture);
    lock.lock();
    if (there) {
      slot.number = number;
      fault_.reset();
    }
    if (there || length_ != length_before) changed_.notify_all();
  }

  /// Goes to the picture and reads it; false when the end came before it and there is no repetition. Where
  /// the way is long, `number` becomes that of a picture on the way.
  bool read(Number& number, ImageU8& picture) {
    const Number asked = number;
    for (;;) {
      if (!options_.loop && length_ > 0 && asked >= length_) return false;
      const Number target = length_ > 0 ? asked % length_ : asked;
      if (target < position_) {
        position_ = kLost;  // also if this throws
        reader_->rewind();
        position_ = 0;
      }
      bool more = true;
      for (Number passed = 0; more && position_ < target; ++passed) {
        if (options_.pace == Pace::kLive && passed == kMaxUnseen) break;
        more = reader_->skip();
        position_ += more;
      }
      const Number number_here = asked - (target - position_);
      if (more && reader_->read(picture)) {
        ++position_;
        if (picture.size() != shape_.size() || picture.channels() != shape_.channels)
          throw Error(ErrorKind::kInput,
                      reader_->name() + ", picture " + std::to_string(position_ - 1) + " (from 0)",
                      "it has another size or number of channels than the first",
                      "bring all pictures to one size and kind");
        number = number_here;
        return true;
      }
      if (position_ == 0) throw no_picture();
      const std::lock_guard<std::mutex> lock(mutex_);
      length_ = position_;
    }
  }

  std::unique_ptr<PictureReader> reader_;
  const double rate_hz_;
  const ContentOptions options_;
  Diagnostics remarks_;  ///< of the first picture
  ViewU8 shape_;         ///< of the first picture; its pixels are not looked at
  /// Of what the reader reads next, in the file; kLost after a fault.
  Number position_ = 0;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::array<Slot, kSlots> slots_;
  Slot* shown_ = nullptr;
  Number wanted_ = 0;
  Number length_ =
      0;  ///< pictures in the file; 0 until its end was met. Written by the thread, under the lock
  std::optional<Error> fault_;
  bool stop_ = false;
  std::thread thread_;  // last: it uses all the others
};

}  // namespace

std::unique_ptr<ContentSource> play(std::unique_ptr<PictureReader> reader, double rate_hz,
                                    const ContentOptions& options) {
  return std::make_unique<Playback>(std::move(reader), rate_hz, options);
}

}  // namespace procam::device::internal
