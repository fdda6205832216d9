#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>

namespace diaphane::render {

/// What one viewer's connection carries, estimated from when messages left and when they were
/// acknowledged. Only the server's steady clock counts: nothing that the viewer says of times. An
/// acknowledgement that comes too early or too late changes that viewer's own pictures alone. Plain
/// data and arithmetic.
///
/// The model is a pipe: a message of S bytes that leaves at t is acknowledged at
/// max(a, t + r) + S / B, where a is the acknowledgement before it. B is the bytes by the time that
/// the pipe was busy with them, both forgotten within half a second; r is the shortest time that a
/// message took, less its S / B. What the pipe was not full with says too little: then B is an
/// underestimate, so it grows by itself as long as nothing waits in the pipe longer than the model
/// says.
class LinkEstimate {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `seq` rises with every message.
  void sent(std::uint64_t seq, std::size_t bytes, Time now);
  /// For all up to `seq`. What was never sent, or acknowledged before, is ignored.
  void acknowledged(std::uint64_t seq, Time now);

  bool known() const { return busy_ > 0; }
  /// Less than at the last acknowledgement while what is under way is overdue. 0: not known.
  double bytes_per_second(Time now) const;
  /// Seconds from sending to acknowledgement of a message without size.
  double round_trip() const { return round_trip_; }
  std::size_t bytes_in_flight() const { return in_flight_; }

 private:
  struct Message {
    std::uint64_t seq = 0;
    std::size_t bytes = 0;
    Time sent;
  };
  struct Shortest {
    double seconds = 0;
    std::size_t bytes = 0;
    Time since{};  ///< of the period that it is the shortest of
  };

  void note_round_trip(double seconds, std::size_t bytes, Time now);
  double estimate() const { return busy_ > 0 ? bytes_ / busy_ : 0; }

  std::deque<Message> under_way_;
  std::size_t in_flight_ = 0;
  double bytes_ = 0;  // acknowledged of late, and
  double busy_ = 0;   // the seconds that they took
  double round_trip_ = 0;
  std::array<Shortest, 2> shortest_{};  // of this period and of the one before
  Time acknowledged_at_{};
};

}  // namespace diaphane::render
