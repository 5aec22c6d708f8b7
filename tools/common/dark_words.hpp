#pragma once
/// Says once when the picture goes dark for people's sake, and when it is lit again.
#include <functional>
#include <string>

#include "procam/people/eye_safe.hpp"

namespace procam::tools {

class DarkWords {
 public:
  explicit DarkWords(std::function<void(const std::string&)> say) : say_(std::move(say)) {}
  void tell(const people::MaskResult& done) {
    if (done.reason == dark_for_) return;
    say_(done.blanked ? std::string("the picture is dark: ") + done.reason : "the picture is lit again");
    dark_for_ = done.reason;
  }

 private:
  std::function<void(const std::string&)> say_;
  std::string dark_for_;
};

}  // namespace procam::tools
