#include "fields.hpp"

#include <cstdarg>
#include <cstdio>

namespace procam::report {

std::string format(const char* pattern, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

}  // namespace procam::report
