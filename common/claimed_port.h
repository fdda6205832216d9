#pragma once

#include <cstdint>

#include "common/result.h"

namespace diaphane {

/// A port of the loopback that nobody listens on, for a program that is about to be started. As
/// long as this lives no other start of Diaphane on this machine is given it (the mark is that of
/// tools/house/ports.py), and no outgoing connection: it is below the range of which the kernel
/// takes their ports.
class ClaimedPort {
 public:
  /// kUnavailable when none is free.
  static Result<ClaimedPort> take();
  ClaimedPort(ClaimedPort&& other) noexcept;
  ClaimedPort& operator=(ClaimedPort&& other) noexcept;
  ~ClaimedPort();

  std::uint16_t number() const { return number_; }

 private:
  ClaimedPort(std::uint16_t number, int mark) : number_(number), mark_(mark) {}
  std::uint16_t number_ = 0;
  int mark_ = -1;  ///< a socket that is bound to the mark's address
};

}  // namespace diaphane
