#pragma once

#include <cstdint>

#include "common/result.h"

namespace diaphane {

/// Reserves a free loopback port for a program that is about to start. While this object exists,
/// no other start of Diaphane on this machine gets the same port (tools/devtool/ports.py uses the
/// same mark). No outgoing connection gets it either, because it is below the kernel's range of
/// ephemeral ports.
class ClaimedPort {
 public:
  /// Returns kUnavailable if no port is free.
  static Result<ClaimedPort> take();
  ClaimedPort(ClaimedPort&& other) noexcept;
  ClaimedPort& operator=(ClaimedPort&& other) noexcept;
  ~ClaimedPort();

  std::uint16_t number() const { return number_; }

 private:
  ClaimedPort(std::uint16_t number, int mark) : number_(number), mark_(mark) {}
  std::uint16_t number_ = 0;
  int mark_ = -1;  ///< socket bound to the address of the mark
};

}  // namespace diaphane
