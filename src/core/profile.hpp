// Wall time per stage of the step: `Stage stage(profile, "p2g");` times its scope.
#pragma once

#include <chrono>
#include <cstring>
#include <string>
#include <vector>

#include "core/types.hpp"

namespace matpoint {

class Profile {
 public:
  struct Entry {
    const char* label;
    double seconds = 0;
    Index calls = 0;
  };

  void add(const char* label, double seconds) {
    for (Entry& entry : entries_) {
      if (entry.label == label || std::strcmp(entry.label, label) == 0) {
        entry.seconds += seconds;
        ++entry.calls;
        return;
      }
    }
    entries_.push_back({label, seconds, 1});
  }
  const std::vector<Entry>& entries() const { return entries_; }

 private:
  std::vector<Entry> entries_;  // a handful of stages: a linear search beats a map
};

class Stage {
 public:
  Stage(Profile& profile, const char* label) : profile_(profile), label_(label), start_(Clock::now()) {}
  ~Stage() { profile_.add(label_, std::chrono::duration<double>(Clock::now() - start_).count()); }
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

 private:
  using Clock = std::chrono::steady_clock;
  Profile& profile_;
  const char* label_;
  Clock::time_point start_;
};

}  // namespace matpoint
