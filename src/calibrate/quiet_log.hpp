#pragma once
/// Private to calibrate.
#include <glog/logging.h>

namespace procam::calibrate {

/// Libraries never print: what the solver would log of a failed step is in its summary, and in our errors.
class QuietLog {
 public:
  QuietLog() : before_(FLAGS_minloglevel) { FLAGS_minloglevel = google::GLOG_FATAL; }
  ~QuietLog() { FLAGS_minloglevel = before_; }
  QuietLog(const QuietLog&) = delete;
  QuietLog& operator=(const QuietLog&) = delete;

 private:
  int before_;
};

}  // namespace procam::calibrate
