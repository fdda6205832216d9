#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "api/load/latency.h"
#include "api/proto/stream.pb.h"

namespace boost::asio {
class io_context;
}

namespace diaphane::api::load {

/// What came, without the picture's bytes.
struct FrameSeen {
  TimePoint at;  ///< all of it was here
  std::uint64_t input_seq = 0;
  std::uint64_t epoch = 0;
  std::uint64_t iteration = 0;
  double render_seconds = 0;  ///< since the epoch began
  double encode_seconds = 0;
  std::size_t bytes = 0;  ///< of the whole message
  std::uint32_t width = 0, height = 0;
};

/// Called on the viewer's strand.
class ViewerEvents {
 public:
  virtual ~ViewerEvents() = default;
  virtual void on_config(const diaphane::v1::Config& config) = 0;
  virtual void on_frame(const FrameSeen& frame) = 0;
  /// Anything else that was said.
  virtual void on_message(const diaphane::v1::ServerMessage&) {}
  /// Last of all: the WebSocket's close code; 1006 when it broke off, 0 when it never began.
  virtual void on_closed(int code) = 0;
};

struct ViewerOptions {
  std::string host = "127.0.0.1";
  std::uint16_t port = 0;  ///< of the gateway
  std::string origin;      ///< of the page that the gateway takes it for
  std::uint32_t width = 1280, height = 720;
  std::vector<diaphane::v1::Codec> codecs{diaphane::v1::JPEG};
  /// Between two reads: a slow computer, or a slow line.
  std::chrono::milliseconds read_pause{0};
};

/// A page's side of the stream: one WebSocket, greets, acknowledges every frame as it comes. All
/// that happens to it happens on a strand of its own; its functions may be called from anywhere.
/// The stream lives until it is left, cut or ended by the other side, also when this is gone.
class Viewer {
 public:
  Viewer(boost::asio::io_context& io, ViewerOptions options, std::weak_ptr<ViewerEvents> events);

  void enter(const std::string& ticket);
  void send(const diaphane::v1::ClientMessage& message);
  /// With a closing handshake, as a page that is left.
  void leave();
  /// Without a word, as a cable that is pulled.
  void cut();

  /// Work on its strand, now or after a time.
  void post(std::function<void()> work);
  void after(std::chrono::nanoseconds time, std::function<void()> work);

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace diaphane::api::load
