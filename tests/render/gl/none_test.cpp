/// A build without OpenGL.
#include <gtest/gtest.h>

#include "procam/core/base/error.hpp"
#include "procam/render/gl.hpp"

namespace procam {
namespace {

TEST(GlRenderer, SaysWhatToInstallWhereItWasNotBuilt) {
  try {
    const render_gl::GlRenderer renderer;
    FAIL() << "it was built";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUnsupported);
    EXPECT_NE(error.next().find("libepoxy-dev"), std::string::npos);
  }
}

}  // namespace
}  // namespace procam
