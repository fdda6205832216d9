#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/load/recording.h"
#include "bench/load/viewer.h"

namespace diaphane::api::load {

/// Returns the scene with its eye rotated about the camera's up axis by `degrees`.
diaphane::v1::Scene turned(const diaphane::v1::Scene& scene, double degrees);

/// What one user saw between two moments.
struct Measurements {
  std::vector<double> input_to_frame;  ///< seconds, for every input
  /// For frames that were the first to show an input: the time since the oldest such input, and its
  /// parts.
  std::vector<double> answer_seconds, render_seconds, encode_seconds;
  std::size_t inputs = 0;
  std::size_t frames = 0, bytes = 0;                ///< number of all frames, and their bytes
  std::size_t moving_frames = 0, moving_bytes = 0;  ///< number of frames during movement, and their
                                                    ///< bytes
  double moving_seconds = 0;
  double pixels = 0;  ///< sum over the moving frames
};

/// A simulated user of a session, who drags on request and measures the answers: around the scan
/// with 60 inputs per second, or as in a recording.
class Person final : public ViewerEvents, public std::enable_shared_from_this<Person> {
 public:
  Person(boost::asio::io_context& io, ViewerOptions options, std::string preset);
  /// Plays the recording again and again, from its input number `first` on. To be called before
  /// enter().
  void play(std::shared_ptr<const Recording> recording, std::size_t first);

  /// Opens the stream. `ready` is called once: with true at the first picture, or with false if the
  /// stream closed.
  void enter(const std::string& ticket, std::function<void(bool)> ready);
  /// Drags for `seconds`, then calls `done`. A recorded gesture may be shorter.
  void drag(double seconds, std::function<void()> done);
  /// Counts inputs that are sent between `from` and `until`.
  void measure(TimePoint from, TimePoint until);
  void leave();
  /// Drops the connection without a closing handshake.
  void cut();
  /// Shows or hides the page.
  void show(bool visible);
  void resize(std::uint32_t width, std::uint32_t height);
  /// Calls `done` on the viewer's strand after `seconds`.
  void after(double seconds, std::function<void()> done);

  // Must be read on the viewer's strand, or after everything has stopped.
  const Measurements& measurements() const { return measurements_; }
  /// Counts the inputs that no frame has answered, with their ages.
  void give_up(TimePoint now);
  std::optional<double> opening_seconds() const { return opening_; }
  int close_code() const { return code_; }  ///< -1 while the stream is open
  std::size_t problems() const { return problems_; }
  std::size_t frames() const { return frames_; }  ///< since the stream was opened

  void on_config(const diaphane::v1::Config& config) override;
  void on_frame(const ReceivedFrame& frame) override;
  void on_message(const diaphane::v1::ServerMessage& message) override;
  void on_closed(int code) override;

 private:
  void input();
  /// Returns the scene of the next input.
  diaphane::v1::Scene next_scene();
  /// Returns when the next input is due, or nullopt if the gesture has ended.
  std::optional<TimePoint> time_after(TimePoint now);
  void end_drag(TimePoint now);
  bool measured(TimePoint at) const { return at >= from_ && at < until_; }

  boost::asio::io_context& io_;
  const ViewerOptions options_;
  const std::string preset_;
  std::shared_ptr<const Recording> recording_;  ///< null: turns around the scan
  std::size_t recorded_ = 0;                    ///< index of its next input
  std::unique_ptr<Viewer> viewer_;
  std::function<void(bool)> ready_;
  std::function<void()> done_;
  diaphane::v1::Scene scene_;
  std::uint64_t input_seq_ = 0;
  OpenInputs open_;
  bool leaving_ = false;

  // State of the current drag.
  bool moving_ = false;
  double degrees_ = 0;
  TimePoint drag_began_{}, drag_ends_{}, next_input_{};

  TimePoint entered_{}, from_ = TimePoint::max(), until_ = TimePoint::max();
  std::optional<double> opening_;
  int code_ = -1;
  std::size_t problems_ = 0;
  std::size_t frames_ = 0;
  Measurements measurements_;
};

}  // namespace diaphane::api::load
