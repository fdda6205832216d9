#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>

namespace diaphane::render {

/// Estimates the capacity of one viewer's connection from the times at which messages were sent and
/// acknowledged. It uses only the server's steady clock and no times from the viewer.
/// Acknowledgements that come too early or too late affect only that viewer's own pictures. Plain
/// data and arithmetic.
///
/// The model is a pipe: a message of S bytes that is sent at t is acknowledged at max(a, t + r) + S
/// / B, where a is the previous acknowledgement. B is the number of bytes divided by the time that
/// the pipe was busy with them, and both decay within half a second. r is the shortest time that a
/// message took, less its S / B. A pipe that is not full reveals too little, so that B is an
/// underestimate. It therefore grows by itself as long as nothing queues in the pipe for longer
/// than the model predicts, and faster if the pipe was empty. The first acknowledgement says little
/// about B, because it also waits until the viewer's decoder has started.
class LinkEstimate {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Records a sent message. `seq` rises with each message.
  void sent(std::uint64_t seq, std::size_t bytes, Time now);
  /// Records that the viewer acknowledged all messages up to `seq`. Ignores a number that was never
  /// sent or was acknowledged before.
  void acknowledged(std::uint64_t seq, Time now);

  bool known() const { return busy_ > 0; }
  /// Returns the estimated capacity, 0 if unknown. It falls while messages are overdue.
  double bytes_per_second(Time now) const;
  /// Returns the seconds from sending to acknowledgement for a message of size zero.
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
    Time since{};  ///< start of the period of this minimum
  };

  void note_round_trip(double seconds, std::size_t bytes, Time now);
  double estimate() const { return busy_ > 0 ? bytes_ / busy_ : 0; }

  std::deque<Message> under_way_;
  std::size_t in_flight_ = 0;
  double bytes_ = 0;  // recently acknowledged bytes
  double busy_ = 0;   // seconds that they took
  double round_trip_ = 0;
  std::array<Shortest, 2> shortest_{};  // of the current and the previous period
  Time acknowledged_at_{};
};

}  // namespace diaphane::render
