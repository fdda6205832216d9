#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "api/proto/stream.pb.h"
#include "bench/load/latency.h"

namespace boost::asio {
class io_context;
}

namespace diaphane::api::load {

/// A received frame without the picture's bytes.
struct ReceivedFrame {
  TimePoint at;  ///< time at which it was complete
  std::uint64_t input_seq = 0;
  std::uint64_t epoch = 0;
  std::uint64_t iteration = 0;
  double render_seconds = 0;  ///< since the start of the epoch
  double encode_seconds = 0;
  std::size_t bytes = 0;  ///< size of the whole message
  std::uint32_t width = 0, height = 0;
};

/// Receives the events of a viewer on the viewer's strand.
class ViewerEvents {
 public:
  virtual ~ViewerEvents() = default;
  virtual void on_config(const diaphane::v1::Config& config) = 0;
  virtual void on_frame(const ReceivedFrame& frame) = 0;
  /// Called for each message other than Config and Frame.
  virtual void on_message(const diaphane::v1::ServerMessage&) {}
  /// Called as the last event. `code` is the WebSocket close code, 1006 for a lost connection, or 0
  /// if the stream never began.
  virtual void on_closed(int code) = 0;
};

struct ViewerOptions {
  std::string host = "127.0.0.1";
  std::uint16_t port = 0;  ///< port of the gateway
  std::string origin;      ///< origin of the page that the gateway expects
  std::uint32_t width = 1280, height = 720;
  std::vector<diaphane::v1::Codec> codecs{diaphane::v1::JPEG};
  /// Pause between two reads, which simulates a slow computer or connection.
  std::chrono::milliseconds read_pause{0};
};

/// The page's side of a stream: one WebSocket that sends the greeting and acknowledges every frame
/// on arrival. Each viewer has its own strand, and its functions can be called from any thread. The
/// stream lives until it is left, cut, or ended by the other side, even if this object is
/// destroyed.
class Viewer {
 public:
  Viewer(boost::asio::io_context& io, ViewerOptions options, std::weak_ptr<ViewerEvents> events);

  void enter(const std::string& ticket);
  void send(const diaphane::v1::ClientMessage& message);
  /// Closes with a handshake, like a page that is left.
  void leave();
  /// Drops the connection without a handshake, like an unplugged cable.
  void cut();

  /// Run `work` on the viewer's strand, at once or after `time`.
  void post(std::function<void()> work);
  void after(std::chrono::nanoseconds time, std::function<void()> work);

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace diaphane::api::load
