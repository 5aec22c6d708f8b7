/// The control page in a real browser, and before people who should not be there.
#include "control_page.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio.hpp>
#include <deque>
#include <nlohmann/json.hpp>
#include <thread>

#include "io/scratch.hpp"
#include "kept_page.hpp"
#include "live_world.hpp"
#include "loop.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/surface_file.hpp"
#include "support/browser.hpp"

namespace procam::show {
namespace {

using boost::asio::ip::tcp;

struct Address {
  std::string host, port, token;
  explicit Address(const std::string& url) {
    const std::size_t slashes = url.find("//") + 2, slash = url.find('/', slashes),
                      colon = url.rfind(':', slash);
    host = url.substr(slashes, slash - slashes);
    port = url.substr(colon + 1, slash - colon - 1);
    token = url.substr(url.find("token=") + 6);
  }
};

/// Sends bytes as they are; the answer as it comes.
std::string talk(const Address& to, const std::string& bytes) {
  boost::asio::io_context io;
  tcp::socket socket(io);
  socket.connect(
      {boost::asio::ip::make_address("127.0.0.1"), static_cast<unsigned short>(std::stoi(to.port))});
  boost::system::error_code ignored;
  boost::asio::write(socket, boost::asio::buffer(bytes), ignored);
  std::string answer;
  boost::asio::read(socket, boost::asio::dynamic_buffer(answer), ignored);
  return answer;
}
int status_of(const std::string& answer) {
  return answer.size() > 12 ? std::atoi(answer.c_str() + 9) : 0;
}
std::string get(const Address& to, const std::string& path, const std::string& more = "") {
  return "GET " + path + " HTTP/1.1\r\nHost: " + to.host + "\r\n" + more + "\r\n";
}

TEST(ControlPage, RefusesWhoHasNoBusinessHere) {
  ControlOptions options;
  options.port = 0;
  ControlPage page(options);
  const Address at(page.url());
  EXPECT_EQ(at.token.size(), 32u);
  const std::string with = "?token=" + at.token, bearer = "Authorization: Bearer " + at.token + "\r\n";
  EXPECT_EQ(status_of(talk(at, get(at, "/" + with))), 200);
  EXPECT_EQ(status_of(talk(at, get(at, "/", bearer))), 200);
  EXPECT_EQ(status_of(talk(at, get(at, "/status" + with, "Origin: http://" + at.host + "\r\n"))), 200);
  EXPECT_EQ(status_of(talk(at, get(at, "/nothing" + with))), 404);
  EXPECT_EQ(status_of(talk(at, get(at, "/frame.jpg" + with))), 503);

  for (const char* path : {"/", "/status", "/metrics", "/frame.jpg", "/ws", "/command", "/nothing"}) {
    EXPECT_EQ(status_of(talk(at, get(at, path))), 403) << path;
    EXPECT_EQ(status_of(talk(at, get(at, std::string(path) + "?token=" + at.token.substr(1)))), 403) << path;
    EXPECT_EQ(status_of(talk(at, get(at, path + with, "Origin: http://evil.example\r\n"))), 403) << path;
    EXPECT_EQ(status_of(talk(
                  at, "GET " + (path + with) + " HTTP/1.1\r\nHost: evil.example:" + at.port + "\r\n\r\n")),
              403)
        << path;
  }
  const auto post = [&](const std::string& body, const std::string& more = "") {
    return talk(at, "POST /command" + with + " HTTP/1.1\r\nHost: " + at.host + "\r\n" + more +
                        "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  };
  EXPECT_EQ(status_of(post("{\"do\":\"undo\"}")), 202);
  EXPECT_EQ(status_of(post("{\"do\":\"move\",\"surface\":\"a\",\"point\":1,\"pixels\":[1.5,2]}")), 202);
  const std::vector<Command> taken = page.take();
  ASSERT_EQ(taken.size(), 2u);
  EXPECT_EQ(taken[1].pixels, Vec2(1.5, 2));
  for (const char* body :
       {"", "{}", "[]", "{\"do\":5}", "{\"do\":\"move\",\"point\":1e99}", "{\"do\":\"x\",\"pixels\":[1]}",
        "{\"do\":\"x\",\"other\":1}", "{\"do\":\"x\",\"pixels\":[1,1e999]}", "\xff\xfe", "{\"do\":\"x\""})
    EXPECT_EQ(status_of(post(body)), 400) << body;
  EXPECT_TRUE(page.take().empty());
  const std::string undo = "{\"do\":\"undo\"}";
  EXPECT_EQ(status_of(post(undo + std::string(limits::kPageBodyBytes - undo.size(), ' '))), 202);
  EXPECT_EQ(page.take().size(), 1u);
  EXPECT_EQ(status_of(post(undo + std::string(limits::kPageBodyBytes - undo.size() + 1, ' '))), 413);
  EXPECT_EQ(status_of(talk(at, get(at, "/command" + with))), 405);
  const auto with_head_of = [&](std::size_t bytes) {
    const std::size_t rest = get(at, "/" + with, "X: \r\n").size();
    return get(at, "/" + with, "X: " + std::string(bytes - rest, 'x') + "\r\n");
  };
  EXPECT_EQ(status_of(talk(at, with_head_of(limits::kPageHeaderBytes))), 200);
  EXPECT_EQ(status_of(talk(at, with_head_of(limits::kPageHeaderBytes + 1))), 431);
  EXPECT_EQ(status_of(talk(at, "nonsense\r\n\r\n")), 400);
  // A thousand commands that nobody takes, and no more.
  for (std::size_t i = 0; i < limits::kPageCommands; ++i)
    ASSERT_EQ(status_of(post("{\"do\":\"undo\"}")), 202);
  EXPECT_EQ(status_of(post("{\"do\":\"undo\"}")), 400);
  EXPECT_THROW(ControlPage(ControlOptions{"127.0.0.1", std::stoi(at.port), ""}), Error);
  EXPECT_THROW(ControlPage(ControlOptions{"localhost.example", 0, ""}), Error);
  EXPECT_THROW(ControlPage(ControlOptions{"127.0.0.1", 0, "a b c d e"}), Error);
  // What can be guessed is no secret.
  const auto page_with_token = [](std::size_t letters) {
    ControlPage(ControlOptions{"127.0.0.1", 0, std::string(letters, 'a')});
  };
  EXPECT_THROW(page_with_token(limits::kMinTokenBytes - 1), Error);
  EXPECT_NO_THROW(page_with_token(limits::kMinTokenBytes));
  EXPECT_NO_THROW(page_with_token(limits::kMaxTokenBytes));
  EXPECT_THROW(page_with_token(limits::kMaxTokenBytes + 1), Error);
  EXPECT_EQ(page.faults().failed, 0u);
  EXPECT_EQ(page.faults().refused, 7 * 4 + 10 + 5u) << "all of the above but what is not found or not ready";
}

/// A connection that sends half of a request.
class HalfOpen {
 public:
  HalfOpen(const Address& to, const std::string& bytes) : socket_(io_) {
    socket_.connect(
        {boost::asio::ip::make_address("127.0.0.1"), static_cast<unsigned short>(std::stoi(to.port))});
    boost::asio::write(socket_, boost::asio::buffer(bytes));
  }
  /// Waits until the server closes it; what it sent.
  std::string wait_for_end() {
    std::string answer;
    boost::system::error_code ignored;
    boost::asio::read(socket_, boost::asio::dynamic_buffer(answer), ignored);
    return answer;
  }
  void send(const std::string& bytes) {
    boost::system::error_code ignored;
    boost::asio::write(socket_, boost::asio::buffer(bytes), ignored);
  }
  /// Sends the rest and waits for the answer.
  std::string finish(const std::string& bytes) {
    send(bytes);
    return wait_for_end();
  }

 private:
  boost::asio::io_context io_;
  tcp::socket socket_;
};

TEST(ControlPage, HalfOpenRequestsDoNotLockTheOwnerOut) {
  ControlOptions options;
  options.port = 0;
  ControlPage page(options);
  const Address at(page.url());
  const std::string bearer = "Authorization: Bearer " + at.token + "\r\n";
  // The owner's command is on its way when strangers come: its place is kept.
  HalfOpen owner(
      at, "POST /command HTTP/1.1\r\nHost: " + at.host + "\r\n" + bearer + "Content-Length: 13\r\n\r\n");
  EXPECT_EQ(status_of(talk(at, get(at, "/", bearer))), 200);  // the server has read the head by then
  std::deque<HalfOpen> strangers;
  for (int i = 0; i < 40; ++i) strangers.emplace_back(at, i % 2 == 0 ? "" : "GET / HTTP/1.1\r\nHost: ");
  EXPECT_EQ(status_of(talk(at, get(at, "/", bearer))), 200);
  EXPECT_EQ(status_of(owner.finish("{\"do\":\"undo\"}")), 202);
  EXPECT_GE(page.faults().evicted, 8u);
  // And none stays for ever.
  strangers.back().wait_for_end();
  // The server counts it after it has closed the connection.
  for (int i = 0; i < 100 && page.faults().refused == 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_GE(page.faults().refused, 1u) << "a request that was never complete";
}

struct SlowRequest {
  int status = 0;      ///< of the answer; 0: none
  double sent_s = 0;   ///< from before the connection to the moment in which all was sent
  double ended_s = 0;  ///< from before the connection to the moment in which the server had closed it
};
/// Sends `first`, and `rest` after so many seconds (negative: never).
SlowRequest slow_request(const Address& to, const std::string& first, double after_s,
                         const std::string& rest) {
  SlowRequest request;
  const auto begin = std::chrono::steady_clock::now();
  const auto elapsed = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  HalfOpen connection(to, first);
  if (after_s >= 0) {
    std::this_thread::sleep_for(std::chrono::duration<double>(after_s));
    connection.send(rest);
    request.sent_s = elapsed();
  }
  request.status = status_of(connection.wait_for_end());
  request.ended_s = elapsed();
  return request;
}

TEST(ControlPage, SlowRequestsHaveTheirTimeAndNotMore) {
  ControlOptions options;
  options.port = 0;
  ControlPage page(options);
  const Address at(page.url());
  const std::string line = "POST /command HTTP/1.1\r\nHost: " + at.host + "\r\n";
  const std::string body = "{\"do\":\"undo\"}";
  const std::string rest_of_head =
      "Authorization: Bearer " + at.token + "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n";
  const double margin_s = 0.5;
  struct Case {
    double limit_s;
    std::string first, rest;
    SlowRequest in_time, never;
  };
  Case cases[] = {{limits::kPageHeadS, line, rest_of_head + body, {}, {}},
                  {limits::kPageRequestS, line + rest_of_head, body, {}, {}}};
  std::vector<std::thread> threads;
  for (Case& c : cases) {
    threads.emplace_back([&] {
      // On a busy machine the rest may be sent too late by ourselves: only what was sent in time is judged.
      do c.in_time = slow_request(at, c.first, c.limit_s - margin_s, c.rest);
      while (c.in_time.sent_s > c.limit_s - margin_s / 4);
    });
    threads.emplace_back([&] { c.never = slow_request(at, c.first, -1, ""); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const Case& c : cases) {
    EXPECT_EQ(c.in_time.status, 202) << "limit " << c.limit_s << " s, sent after " << c.in_time.sent_s
                                     << " s";
    EXPECT_EQ(c.never.status, 0);
    EXPECT_GE(c.never.ended_s, c.limit_s);
  }
  // The connection ends before it is counted.
  for (int i = 0; i < 500 && page.faults().refused < 2; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(page.faults().refused, 2u);
}

/// A loop on a thread of its own, as project-live runs it, and the page before it.
class RunningShow {
 public:
  explicit RunningShow(Show show = small_show())
      : projection_(small_rig(), standing()), sink_(projection_.frame_size()), editor_(show.surfaces) {
    projection_.set_show(std::move(show));
    ControlOptions control;
    control.port = 0;
    page_ = std::make_unique<ControlPage>(control);
    parts_.editor = &editor_;
    parts_.page = page_.get();
    parts_.loader = &loader_;
    LoopOptions options;
    options.fps = 50;
    thread_ = std::thread([this, options] { metrics_ = run_loop(parts_, options); });
  }
  ~RunningShow() { end(); }
  void end() {
    sink_.wish(device::WindowEvent::kClose);
    if (thread_.joinable()) thread_.join();
  }
  std::string url() const { return page_->url(); }
  KeptFrames& sink() { return sink_; }
  SurfaceSet saved() const { return io::load_surfaces(folder_ / "surfaces.json"); }
  const Metrics& metrics() const { return metrics_; }
  const SurfaceSet& surfaces() const { return editor_.surfaces(); }

 private:
  static ShowLoaderOptions loading(const std::filesystem::path& surfaces) {
    ShowLoaderOptions options;
    options.surfaces = surfaces;
    return options;
  }
  static ProjectionOptions standing() {
    ProjectionOptions options;
    options.projector_from_world = Pose();
    return options;
  }
  Projection projection_;
  KeptFrames sink_;
  Editor editor_;
  std::unique_ptr<ControlPage> page_;
  LoopParts parts_{projection_, sink_};
  test::Scratch folder_;
  ShowLoader loader_{loading(folder_ / "surfaces.json")};
  Metrics metrics_;
  std::thread thread_;
};

TEST(ControlPage, ACornerDraggedInABrowserMovesTheLight) {
  RunningShow show;
  test::Browser browser(1100, 760);
  ASSERT_TRUE(browser.is_running()) << "chromium must be installed (scripts/common.sh names the package)";
  browser.open(show.url());
  ASSERT_TRUE(
      browser.wait_for("document.querySelectorAll('circle').length === 4 && $('frame').naturalWidth === 320"))
      << browser.console();
  ASSERT_TRUE(browser.wait_for("$('state').textContent === 'fixed projector'"));
  // The sign, in the projector's own pixels.
  browser.evaluate(
      "[...document.querySelectorAll('#list button')].find(b => b.textContent.includes('sign')).click()");
  const auto circle = [&](int i) {
    const std::string box = "(() => { const b = document.querySelectorAll('circle')[" + std::to_string(i) +
                            "].getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()";
    return nlohmann::json::parse(browser.evaluate(box)).get<std::vector<double>>();
  };
  const ImageU8 before = show.sink().last();
  const int x = 125, y = 178;  // just outside of the sign, inside after the drag
  EXPECT_EQ(before.at(x, y, 2), 0);
  const std::vector<double> from = circle(2);
  browser.mouse("mousePressed", from[0] + 3, from[1] - 2);
  for (int i = 1; i <= 10; ++i) browser.mouse("mouseMoved", from[0] + 3 + 6 * i, from[1] - 2 + 4 * i);
  browser.mouse("mouseReleased", from[0] + 63, from[1] + 38);
  const double scale =
      nlohmann::json::parse(browser.evaluate("$('view').getBoundingClientRect().width")).get<double>() / 320;
  // Where it was dropped on the page is where it is in the frame.
  ASSERT_TRUE(browser.wait_for("status.unsaved && Math.abs(status.surfaces[2].points[2][0] - " +
                               std::to_string(131 + 60 / scale) + ") < 0.1"))
      << browser.evaluate("status");
  const auto now =
      nlohmann::json::parse(browser.evaluate("status.surfaces[2].points[2]")).get<std::vector<double>>();
  EXPECT_NEAR(now[1], 170 + 40 / scale, 0.1);
  EXPECT_NE(show.sink().last().at(x, y, 2), 0) << "the light has not moved";
  keep_page(browser, "control_page.png");

  // A nudge by a tenth of a pixel, undone; then all of the drag, which is one step.
  browser.press("ArrowLeft");
  ASSERT_TRUE(browser.wait_for("Math.abs(status.surfaces[2].points[2][0] - " + std::to_string(now[0] - 0.1) +
                               ") < 1e-4"));
  browser.evaluate("$('undo').click()");
  ASSERT_TRUE(
      browser.wait_for("Math.abs(status.surfaces[2].points[2][0] - " + std::to_string(now[0]) + ") < 1e-4"));
  browser.evaluate("$('save').click()");
  ASSERT_TRUE(browser.wait_for("!status.unsaved"));
  ASSERT_EQ(show.saved().surfaces.size(), 3u);
  EXPECT_NEAR(std::get<PixelSurface>(show.saved().surfaces[2].geometry).pixels[2].x(), now[0], 1e-9);
  browser.evaluate("$('undo').click()");
  ASSERT_TRUE(browser.wait_for("status.surfaces[2].points[2][0] === 131"));
  ASSERT_TRUE(browser.wait_for("!status.can_undo"));

  browser.evaluate("$('name').value = 'new one'; $('add').click()");
  ASSERT_TRUE(browser.wait_for("status.surfaces.length === 4 && status.surfaces[3].name === 'new one'"));
  browser.evaluate("$('name').value = 'sign'; $('rename').click()");  // there is one already
  ASSERT_TRUE(browser.wait_for("status.messages.some(m => m.includes('sign'))"));
  browser.evaluate("send({do: 'content', surface: 'new one', text: '/etc/passwd'})");
  ASSERT_TRUE(browser.wait_for("status.messages.some(m => m.includes('/etc/passwd'))"));
  browser.evaluate("document.querySelector('[data-picture=mask]').click()");
  ASSERT_TRUE(browser.wait_for("status.picture === 'mask'"));
  EXPECT_EQ(browser.console(), "");
  show.end();
  EXPECT_GT(show.metrics().frames, 50u);
}

/// A cross beside the corner of the sign, in light that was not there, and gone after three seconds.
TEST(ControlPage, TheLightMarksTheChosenCorner) {
  RunningShow show;
  test::Browser browser(1100, 760);
  ASSERT_TRUE(browser.is_running()) << "chromium must be installed (scripts/common.sh names the package)";
  browser.open(show.url());
  ASSERT_TRUE(browser.wait_for("document.querySelectorAll('circle').length === 4"));
  browser.evaluate(
      "[...document.querySelectorAll('#list button')].find(b => b.textContent.includes('sign')).click()");
  const int beside = 139, below = 178;  // of the corner at 131, 170; the frame is 240 pixels high
  const auto level = [&](int x, int y) { return int(show.sink().last().at(x, y, 1)); };
  const auto wait = [&](auto&& condition, double seconds) {
    for (const double end = device::now_s() + seconds; device::now_s() < end;) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  };
  ASSERT_TRUE(wait([&] { return level(beside, 170) == 0 && level(131, below) == 0; }, 5));
  const std::string box =
      "(() => { const b = document.querySelectorAll('circle')[2].getBoundingClientRect();"
      " return [b.x + b.width / 2, b.y + b.height / 2]; })()";
  const auto at = nlohmann::json::parse(browser.evaluate(box)).get<std::vector<double>>();
  browser.mouse("mousePressed", at[0], at[1]);
  browser.mouse("mouseReleased", at[0], at[1]);
  EXPECT_TRUE(wait([&] { return level(beside, 170) > 200 && level(131, below) > 200; }, 3));
  EXPECT_TRUE(wait([&] { return level(beside, 170) == 0 && level(131, below) == 0; }, 10));
  EXPECT_EQ(browser.evaluate("status.unsaved"), "false");
  browser.evaluate("send({do: 'point', surface: 'none of these'})");
  EXPECT_TRUE(browser.wait_for("status.messages.some(m => m.includes('none of these'))"));
}

/// Five points, the last in the middle: the outline has the content's four corners, and a drag states the fit.
TEST(ControlPage, MorePointsThanFourKeepTheOutlineAndStateTheFit) {
  Show five = small_show();
  auto& plane = std::get<PlanarSurface>(five.surfaces.surfaces[0].geometry);
  plane.content.emplace_back(0.5, 0.5);
  plane.points.emplace_back(0.34, 0.21);
  RunningShow show(std::move(five));
  test::Browser browser(1100, 760);
  ASSERT_TRUE(browser.is_running());
  browser.open(show.url());
  ASSERT_TRUE(
      browser.wait_for("document.querySelectorAll('circle').length === 5 && $('frame').naturalWidth === 320"))
      << browser.console();
  const std::string outline = "document.querySelector('polygon.chosen').getAttribute('points')";
  EXPECT_EQ(browser.evaluate(outline + ".split(' ').length"), "4");
  const auto from = nlohmann::json::parse(
      browser.evaluate("(() => { const b = document.querySelectorAll('circle')[4].getBoundingClientRect(); "
                       "return [b.x + b.width / 2, b.y + b.height / 2]; })()"));
  const double x = from[0], y = from[1];
  browser.mouse("mousePressed", x, y);
  for (int i = 1; i <= 5; ++i) browser.mouse("mouseMoved", x + 10 * i, y + 5 * i);
  browser.mouse("mouseReleased", x + 50, y + 25);
  EXPECT_TRUE(
      browser.wait_for("/^5 points: fitted, up to [1-9][0-9]*[.][0-9] mm off$/.test($('fit').textContent)"))
      << browser.evaluate("$('fit').textContent");
  EXPECT_TRUE(browser.wait_for("$('place').textContent.includes('left, point 5')"));
  // The outline is where the content is: a little off from the points.
  EXPECT_TRUE(
      browser.wait_for("drag === null && Math.hypot(status.surfaces[0].outline[2][0] - "
                       "status.surfaces[0].points[2][0], status.surfaces[0].outline[2][1] - "
                       "status.surfaces[0].points[2][1]) > 0.5"));
  EXPECT_EQ(browser.evaluate(outline + " === status.surfaces[0].outline.map(p => p.join(',')).join(' ')"),
            "true");
  keep_page(browser, "control_five_points.png");
  browser.evaluate(
      "[...document.querySelectorAll('#list button')].find(b => b.textContent.includes('sign')).click()");
  EXPECT_TRUE(browser.wait_for("$('fit').textContent === ''"));
  EXPECT_EQ(browser.console(), "");
}

/// Text that no file can hold is refused, and the show goes on.
TEST(ControlPage, ANameThatCannotBeSavedDoesNotEndTheShow) {
  RunningShow show;
  const Address at(show.url());
  const auto post = [&](const std::string& body) {
    return status_of(talk(at, "POST /command?token=" + at.token + " HTTP/1.1\r\nHost: " + at.host +
                                  "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body));
  };
  EXPECT_EQ(post("{\"do\":\"rename\",\"surface\":\"sign\",\"text\":\"a\\ufffe\"}"), 202);
  EXPECT_EQ(post("{\"do\":\"add\",\"surface\":\"b\\uffff\"}"), 202);
  EXPECT_EQ(post("{\"do\":\"rename\",\"surface\":\"sign\",\"text\":\"good\"}"), 202);
  const auto status = [&] {
    const std::string answer = talk(at, get(at, "/status?token=" + at.token));
    return nlohmann::json::parse(answer.substr(answer.find("\r\n\r\n") + 4));
  };
  // Before its first frame the show reports no surfaces.
  const auto is_renamed = [&] {
    const nlohmann::json surfaces = status()["surfaces"];
    return surfaces.size() == 3 && surfaces[2]["name"] == "good";
  };
  for (int i = 0; i < 1000 && !is_renamed(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  ASSERT_TRUE(is_renamed());
  // What was accepted is done, also when the show ends at once.
  EXPECT_EQ(post("{\"do\":\"save\"}"), 202);
  show.end();
  EXPECT_EQ(show.metrics().faults.at("command"), 2u);
  EXPECT_EQ(show.saved().surfaces.size(), 3u);
}

TEST(ControlPage, KeysOfTheWindow) {
  RunningShow show;
  const auto wait = [&](auto condition) {
    for (int i = 0; i < 300 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return condition();
  };
  ASSERT_TRUE(wait([&] { return show.sink().count() > 2; }));
  const ImageU8 content = show.sink().last();
  const auto changed = [&] {
    const ImageU8 now = show.sink().last();
    return !std::equal(now.data(), now.data() + 320 * 200 * 3, content.data());
  };
  for (const device::WindowEvent wish :
       {device::WindowEvent::kGrid, device::WindowEvent::kMask, device::WindowEvent::kHelp}) {
    show.sink().wish(wish);
    EXPECT_TRUE(wait(changed));
    if (wish == device::WindowEvent::kMask)
      EXPECT_TRUE(wait([&] { return show.sink().last().at(70, 140, 0) == 255; }));
    show.sink().wish(wish);
    EXPECT_TRUE(wait([&] { return !changed(); }));
  }
}

}  // namespace
}  // namespace procam::show
