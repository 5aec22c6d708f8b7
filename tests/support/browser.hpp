#pragma once
/// Chromium without a window, driven through its DevTools protocol: a page is opened, looked at, clicked and
/// dragged on as by a person.
#include <filesystem>
#include <memory>
#include <string>

namespace procam::test {

class Browser {
 public:
  /// Starts it with a window of this size. is_running() is false when Chromium is not installed.
  Browser(int width, int height);
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  bool is_running() const;
  void open(const std::string& url);
  /// The expression's value as JSON; "null" when it has none or throws.
  std::string evaluate(const std::string& expression);
  /// Waits until the expression is true, or ten seconds. Returns whether it is.
  bool wait_for(const std::string& expression);
  /// "mousePressed", "mouseMoved", "mouseReleased", in pixels of the page.
  void mouse(const std::string& what, double x, double y);
  /// "ArrowLeft", ...
  void press(const std::string& key);
  /// Inserts text where the focus is, as if it were pasted.
  void type(const std::string& text);
  void screenshot(const std::filesystem::path& png);
  /// What the page wrote to its console, and exceptions.
  const std::string& console() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::test
