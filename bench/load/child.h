#pragma once

#include <sys/types.h>

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "common/result.h"

namespace diaphane::api::load {

/// A child process that ends with this object.
class Child {
 public:
  /// Appends the output to `log`. Fails with kUnavailable if the program cannot be started.
  static Result<Child> start(const std::string& program, const std::vector<std::string>& arguments,
                             const std::map<std::string, std::string>& environment,
                             const std::string& log);
  Child(Child&& other) noexcept;
  Child& operator=(Child&& other) noexcept;
  ~Child();

  pid_t pid() const { return pid_; }
  bool running();
  /// Sends SIGTERM, and SIGKILL if the process has not ended within `grace`.
  void stop(std::chrono::milliseconds grace);

 private:
  explicit Child(pid_t pid) : pid_(pid) {}
  pid_t pid_ = -1;
};

/// Returns the CPU seconds of a process and all its threads, or 0 if it no longer exists.
double processor_seconds(pid_t pid);

}  // namespace diaphane::api::load
