#pragma once

#include <sys/types.h>

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "common/result.h"

namespace diaphane::api::load {

/// A program that was started here and ends with this.
class Child {
 public:
  /// Output goes to the end of `log`. kUnavailable when it cannot be started.
  static Result<Child> start(const std::string& program, const std::vector<std::string>& arguments,
                             const std::map<std::string, std::string>& environment,
                             const std::string& log);
  Child(Child&& other) noexcept;
  Child& operator=(Child&& other) noexcept;
  ~Child();

  pid_t pid() const { return pid_; }
  bool running();
  /// SIGTERM, and SIGKILL when it has not ended within `grace`.
  void stop(std::chrono::milliseconds grace);

 private:
  explicit Child(pid_t pid) : pid_(pid) {}
  pid_t pid_ = -1;
};

/// Processor time of a process and all its threads, seconds; 0 when it is gone.
double processor_seconds(pid_t pid);

}  // namespace diaphane::api::load
