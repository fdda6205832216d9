#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/load/viewer.h"

namespace diaphane::api::load {

/// The scene, its eye turned about the camera's up axis by `degrees`.
diaphane::v1::Scene turned(const diaphane::v1::Scene& scene, double degrees);

/// What one person saw between two moments.
struct Seen {
  std::vector<double> input_to_frame;  ///< seconds, of every input
  /// Frames that were the first to show an input: from the oldest such input, and of that.
  std::vector<double> answer_seconds, render_seconds, encode_seconds;
  std::size_t inputs = 0;
  std::size_t frames = 0, bytes = 0;                ///< all that came
  std::size_t moving_frames = 0, moving_bytes = 0;  ///< while a hand moved
  double moving_seconds = 0;
  double pixels = 0;  ///< of the moving frames, summed
};

/// Somebody at a session: drags when told to, an input every sixtieth of a second, and measures.
class Person final : public ViewerEvents, public std::enable_shared_from_this<Person> {
 public:
  Person(boost::asio::io_context& io, ViewerOptions options, std::string preset);

  /// Opens the stream. `ready` is called once: true with the first picture, false when it closed.
  void enter(const std::string& ticket, std::function<void(bool)> ready);
  /// Drags for `seconds`, then calls `done`.
  void drag(double seconds, std::function<void()> done);
  /// Inputs from `from` on count; what is sent from `until` on does not.
  void measure(TimePoint from, TimePoint until);
  void leave();
  /// Without a word to the other side.
  void cut();
  /// The page is looked at, or another is.
  void show(bool visible);
  void resize(std::uint32_t width, std::uint32_t height);
  /// Calls `done` on the viewer's strand.
  void after(double seconds, std::function<void()> done);

  // Read when nothing runs any more, or on the viewer's strand.
  const Seen& seen() const { return seen_; }
  /// Inputs that never got a frame count with their age.
  void give_up(TimePoint now);
  std::optional<double> opening_seconds() const { return opening_; }
  int close_code() const { return code_; }  ///< -1 while it is open
  std::size_t problems() const { return problems_; }
  std::size_t frames() const { return frames_; }  ///< since it was entered

  void on_config(const diaphane::v1::Config& config) override;
  void on_frame(const FrameSeen& frame) override;
  void on_message(const diaphane::v1::ServerMessage& message) override;
  void on_closed(int code) override;

 private:
  void input();
  void end_drag(TimePoint now);
  bool measured(TimePoint at) const { return at >= from_ && at < until_; }

  boost::asio::io_context& io_;
  const ViewerOptions options_;
  const std::string preset_;
  std::unique_ptr<Viewer> viewer_;
  std::function<void(bool)> ready_;
  std::function<void()> done_;
  diaphane::v1::Scene scene_;
  std::uint64_t input_seq_ = 0;
  OpenInputs open_;
  bool leaving_ = false;

  // Of the drag under way.
  bool moving_ = false;
  double degrees_ = 0;
  TimePoint drag_began_{}, drag_ends_{}, next_input_{};

  TimePoint entered_{}, from_ = TimePoint::max(), until_ = TimePoint::max();
  std::optional<double> opening_;
  int code_ = -1;
  std::size_t problems_ = 0;
  std::size_t frames_ = 0;
  Seen seen_;
};

}  // namespace diaphane::api::load
