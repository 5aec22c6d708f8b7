#include <algorithm>
#include <array>
#include <deque>
#include <string>

#include "procam/device/frame_sink.hpp"
// GLFW brings OpenGL's header with it.
#include <GLFW/glfw3.h>

namespace procam::device {
namespace {

Error display_error(const std::string& why, const std::string& next) {
  return Error(ErrorKind::kDevice, "display", why, next);
}

std::string last_glfw_error() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text != nullptr ? text : "no reason was given";
}

/// GLFW is set up once and stays so: displays() and a window may be used one after the other.
void start_glfw() {
  static const bool started = [] {
    if (glfwInit() != GLFW_TRUE)
      throw display_error("no graphics: " + last_glfw_error(),
                          "run it where windows can be opened (DISPLAY set)");
    return true;
  }();
  (void)started;
}

std::vector<GLFWmonitor*> monitors() {
  start_glfw();
  int count = 0;
  GLFWmonitor** list = glfwGetMonitors(&count);
  return {list, list + count};
}

class Window : public FrameSink {
 public:
  explicit Window(GLFWmonitor* monitor) {
    const GLFWvidmode* mode = glfwGetVideoMode(monitor);
    if (mode == nullptr)
      throw display_error("its mode is unknown: " + last_glfw_error(), "try another display");
    // The mode stays as it is: a change would move the other windows, and the projector's lens may depend on
    // it.
    glfwWindowHint(GLFW_RED_BITS, mode->redBits);
    glfwWindowHint(GLFW_GREEN_BITS, mode->greenBits);
    glfwWindowHint(GLFW_BLUE_BITS, mode->blueBits);
    glfwWindowHint(GLFW_REFRESH_RATE, mode->refreshRate);
    glfwWindowHint(GLFW_AUTO_ICONIFY, GLFW_FALSE);
    window_ = glfwCreateWindow(mode->width, mode->height, "procam", monitor, nullptr);
    if (window_ == nullptr)
      throw display_error("no window: " + last_glfw_error(), "check the OpenGL driver (glxinfo)");
    glfwSetWindowUserPointer(window_, this);
    glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int) {
      if (action != GLFW_PRESS) return;
      auto* self = static_cast<Window*>(glfwGetWindowUserPointer(window));
      self->close_ = self->close_ || key == GLFW_KEY_ESCAPE;
      const WindowEvent wish = wish_of(key);
      // A key that is hit twice before anybody listened is one wish.
      if (wish != WindowEvent::kNone && (self->wishes_.empty() || self->wishes_.back() != wish))
        self->wishes_.push_back(wish);
    });
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
    glfwSetInputMode(window_, GLFW_CURSOR, GLFW_CURSOR_HIDDEN);
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    size_ = {width, height};
    GLint largest = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    if (std::max(width, height) > largest) {
      glfwDestroyWindow(window_);
      throw display_error("the OpenGL driver holds no texture of its size", "use another graphics driver");
    }
    glViewport(0, 0, width, height);
    glDisable(GL_DITHER);
    glEnable(GL_TEXTURE_2D);
    glGenTextures(1, &texture_);
    glBindTexture(GL_TEXTURE_2D, texture_);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  }
  ~Window() override { glfwDestroyWindow(window_); }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  ImageSize size() const override { return size_; }

  double show(ViewU8 picture) override {
    upload(picture);
    // Both buffers: whatever the driver shows next is this picture.
    for (int buffer = 0; buffer < 2; ++buffer) {
      draw();
      glfwSwapBuffers(window_);
    }
    return shown();
  }

  double show_next(ViewU8 picture) override {
    upload(picture);
    draw();
    glfwSwapBuffers(window_);
    return shown();
  }

  double show_soon(ViewU8 picture) override {
    upload(picture);
    draw();
    glfwSwapBuffers(window_);
    return now_s();
  }

  WindowEvent poll() override {
    glfwPollEvents();
    if (close_ || glfwWindowShouldClose(window_) == GLFW_TRUE) return WindowEvent::kClose;
    if (wishes_.empty()) return WindowEvent::kNone;
    const WindowEvent wish = wishes_.front();
    wishes_.pop_front();
    return wish;
  }

  bool is_down(Key key) const override {
    static constexpr std::array<int, 8> kCodes = {GLFW_KEY_W,    GLFW_KEY_A,     GLFW_KEY_S,  GLFW_KEY_D,
                                                  GLFW_KEY_LEFT, GLFW_KEY_RIGHT, GLFW_KEY_UP, GLFW_KEY_DOWN};
    return glfwGetKey(window_, kCodes[std::size_t(key)]) == GLFW_PRESS;
  }

 private:
  static WindowEvent wish_of(int key) {
    switch (key) {
      case GLFW_KEY_ENTER:
      case GLFW_KEY_KP_ENTER:
      case GLFW_KEY_SPACE:
      case GLFW_KEY_N:
        return WindowEvent::kGoOn;
      case GLFW_KEY_H:
      case GLFW_KEY_F1:
      case GLFW_KEY_SLASH:
        return WindowEvent::kHelp;
      case GLFW_KEY_G:
        return WindowEvent::kGrid;
      case GLFW_KEY_M:
        return WindowEvent::kMask;
      case GLFW_KEY_F:
        return WindowEvent::kFreeze;
      default:
        return WindowEvent::kNone;
    }
  }

  void upload(ViewU8 picture) {
    require(picture.size() == size_ && (picture.channels == 1 || picture.channels == 3),
            "FrameSink: the picture has not the screen's size, or neither 1 nor 3 channels");
    if (glfwGetCurrentContext() != window_)
      glfwMakeContextCurrent(window_);  // another window was shown since
    const bool grey = picture.channels == 1;
    const GLenum format = grey ? GL_LUMINANCE : GL_RGB;
    glPixelStorei(GL_UNPACK_ROW_LENGTH, GLint(picture.stride / picture.channels));
    // Its memory is taken once: a new texture a frame costs half of the frame.
    if (texture_format_ != format)
      glTexImage2D(GL_TEXTURE_2D, 0, grey ? GL_LUMINANCE8 : GL_RGB8, size_.width, size_.height, 0, format,
                   GL_UNSIGNED_BYTE, nullptr);
    texture_format_ = format;
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size_.width, size_.height, format, GL_UNSIGNED_BYTE,
                    picture.data);
  }

  double shown() {
    glFinish();
    const double time = now_s();
    if (glGetError() != GL_NO_ERROR)
      throw display_error("OpenGL could not show the picture", "check the OpenGL driver");
    glfwPollEvents();
    return time;
  }

  /// The texture's first row is the picture's top one.
  static void draw() {
    glClear(GL_COLOR_BUFFER_BIT);
    glBegin(GL_QUADS);
    glTexCoord2i(0, 1), glVertex2i(-1, -1);
    glTexCoord2i(1, 1), glVertex2i(1, -1);
    glTexCoord2i(1, 0), glVertex2i(1, 1);
    glTexCoord2i(0, 0), glVertex2i(-1, 1);
    glEnd();
  }

  GLFWwindow* window_ = nullptr;
  ImageSize size_;
  GLuint texture_ = 0;
  GLenum texture_format_ = 0;  ///< of the memory it has
  bool close_ = false;
  std::deque<WindowEvent> wishes_;
};

}  // namespace

std::vector<Display> displays() {
  std::vector<Display> found;
  const std::vector<GLFWmonitor*> list = monitors();
  for (std::size_t number = 0; number < list.size(); ++number) {
    GLFWmonitor* monitor = list[number];
    const GLFWvidmode* mode = glfwGetVideoMode(monitor);
    if (mode == nullptr) continue;
    Display display;
    display.number = int(number);
    const char* name = glfwGetMonitorName(monitor);
    display.name = name != nullptr ? name : "";
    glfwGetMonitorPos(monitor, &display.x, &display.y);
    display.size = display.largest = {mode->width, mode->height};
    display.refresh_hz = mode->refreshRate;
    display.is_primary = monitor == glfwGetPrimaryMonitor();
    int count = 0;
    const GLFWvidmode* modes = glfwGetVideoModes(monitor, &count);
    for (int i = 0; i < count; ++i)
      if (modes[i].width * modes[i].height > display.largest.width * display.largest.height)
        display.largest = {modes[i].width, modes[i].height};
    found.push_back(display);
  }
  return found;
}

std::unique_ptr<FrameSink> open_window(int display_number) {
  const std::vector<GLFWmonitor*> list = monitors();
  if (display_number < 0 || std::size_t(display_number) >= list.size())
    throw display_error(
        "there is no display " + std::to_string(display_number) + " among " + std::to_string(list.size()),
        "choose one that is listed");
  return std::make_unique<Window>(list[std::size_t(display_number)]);
}

}  // namespace procam::device
