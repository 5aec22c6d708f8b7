#pragma once
/// Images of pages for the documents.
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "support/browser.hpp"

namespace procam::show {

/// Into the folder that the environment's PROCAM_KEEP_PAGES names; nothing without it.
inline void keep_page(test::Browser& browser, const char* name) {
  const char* kept = std::getenv("PROCAM_KEEP_PAGES");
  if (kept == nullptr) return;
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  browser.screenshot(std::filesystem::path(kept) / name);
}

}  // namespace procam::show
