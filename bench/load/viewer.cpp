#include "bench/load/viewer.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>

namespace diaphane::api::load {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;

constexpr int kBroken = 1006;
// Large enough for a picture of 4096 x 4096 in one message.
constexpr std::size_t kMostMessageBytes = std::size_t{64} << 20;

std::uint64_t microseconds(TimePoint at) {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(at.time_since_epoch()).count());
}

}  // namespace

struct Viewer::Impl : std::enable_shared_from_this<Viewer::Impl> {
  Impl(asio::io_context& io, ViewerOptions o, std::weak_ptr<ViewerEvents> e)
      : options(std::move(o)),
        events(std::move(e)),
        strand(asio::make_strand(io)),
        socket(strand),
        pause(strand) {}

  void enter(const std::string& ticket) {
    auto& tcp = beast::get_lowest_layer(socket);
    tcp.expires_after(std::chrono::seconds(20));
    target = "/stream?ticket=" + ticket;
    tcp.async_connect(Tcp::endpoint(asio::ip::make_address(options.host), options.port),
                      [self = shared_from_this()](beast::error_code error) {
                        if (error) return self->closed(0);
                        self->shake_hands();
                      });
  }

  void shake_hands() {
    auto& tcp = beast::get_lowest_layer(socket);
    tcp.socket().set_option(Tcp::no_delay(true));
    tcp.expires_never();
    socket.set_option(websocket::stream_base::timeout::suggested(beast::role_type::client));
    socket.set_option(
        websocket::stream_base::decorator([origin = options.origin](websocket::request_type& r) {
          r.set(beast::http::field::origin, origin);
          r.set(beast::http::field::sec_websocket_protocol, "diaphane.v1");
        }));
    socket.read_message_max(kMostMessageBytes);
    socket.binary(true);
    socket.async_handshake("localhost", target, [self = shared_from_this()](beast::error_code e) {
      if (e) return self->closed(0);
      self->open = true;
      self->greet();
      self->read();
    });
  }

  void greet() {
    v1::ClientMessage message;
    v1::Hello& hello = *message.mutable_hello();
    hello.set_protocol(1);
    for (const v1::Codec codec : options.codecs) hello.add_codecs(codec);
    hello.set_pixel_ratio(1);
    hello.mutable_viewport()->set_width(options.width);
    hello.mutable_viewport()->set_height(options.height);
    send(message);
  }

  void read() {
    socket.async_read(buffer, [self = shared_from_this()](beast::error_code error, std::size_t) {
      if (error) {
        const int code = self->socket.reason().code;
        return self->closed(code != 0 ? code : kBroken);
      }
      self->received();
      if (self->options.read_pause.count() == 0) return self->read();
      self->pause.expires_after(self->options.read_pause);
      self->pause.async_wait([self](beast::error_code) { self->read(); });
    });
  }

  void received() {
    ReceivedFrame received;
    received.at = std::chrono::steady_clock::now();
    received.bytes = buffer.size();
    const bool sound =
        incoming.ParseFromArray(buffer.data().data(), static_cast<int>(buffer.size()));
    buffer.clear();
    const auto listener = events.lock();
    if (!sound || !listener) return;
    if (incoming.has_config()) return listener->on_config(incoming.config());
    if (incoming.has_still())
      acknowledge(incoming.still().seq(), incoming.still().epoch(), received.at);
    if (!incoming.has_frame()) return listener->on_message(incoming);
    const v1::Frame& frame = incoming.frame();
    acknowledge(frame.seq(), frame.epoch(), received.at);
    received.input_seq = frame.input_seq();
    received.epoch = frame.epoch();
    received.iteration = frame.iteration();
    received.render_seconds = static_cast<double>(frame.render_us()) * 1e-6;
    received.encode_seconds = static_cast<double>(frame.encode_us()) * 1e-6;
    received.width = frame.width();
    received.height = frame.height();
    listener->on_frame(received);
  }

  void acknowledge(std::uint64_t seq, std::uint64_t epoch, TimePoint at) {
    v1::ClientMessage answer;
    v1::Ack& ack = *answer.mutable_ack();
    ack.set_seq(seq);
    ack.set_epoch(epoch);
    ack.set_received_us(microseconds(at));
    ack.set_decoded_us(microseconds(at));
    ack.set_presented_us(microseconds(at));
    send(answer);
  }

  void send(const v1::ClientMessage& what) {
    if (!open || leaving) return;
    outgoing.push_back(what.SerializeAsString());
    if (outgoing.size() == 1) write();
  }

  void write() {
    socket.async_write(asio::buffer(outgoing.front()),
                       [self = shared_from_this()](beast::error_code error, std::size_t) {
                         if (error) return;  // the read reports the error
                         self->outgoing.pop_front();
                         if (!self->outgoing.empty()) return self->write();
                         if (self->leaving) self->say_goodbye();
                       });
  }

  void leave() {
    if (leaving) return;
    leaving = true;
    if (!open) return cut();
    if (outgoing.empty()) say_goodbye();
  }

  void say_goodbye() {
    socket.async_close(websocket::close_code::normal,
                       [self = shared_from_this()](beast::error_code) {});
  }

  void cut() {
    leaving = true;
    beast::error_code ignored;
    auto& tcp = beast::get_lowest_layer(socket).socket();
    // Sends a reset instead of the closing handshake of a page.
    tcp.set_option(asio::socket_base::linger(true, 0), ignored);
    tcp.close(ignored);
  }

  void closed(int code) {
    if (over) return;
    over = true;
    open = false;
    if (const auto listener = events.lock()) listener->on_closed(code);
  }

  const ViewerOptions options;
  const std::weak_ptr<ViewerEvents> events;
  asio::strand<asio::io_context::executor_type> strand;
  websocket::stream<beast::tcp_stream> socket;
  asio::steady_timer pause;
  beast::flat_buffer buffer;
  v1::ServerMessage incoming;  // reused to keep its memory
  std::deque<std::string> outgoing;
  std::string target;
  bool open = false;
  bool leaving = false;
  bool over = false;
};

Viewer::Viewer(asio::io_context& io, ViewerOptions options, std::weak_ptr<ViewerEvents> events)
    : impl_(std::make_shared<Impl>(io, std::move(options), std::move(events))) {}

void Viewer::enter(const std::string& ticket) {
  asio::post(impl_->strand, [impl = impl_, ticket] { impl->enter(ticket); });
}
void Viewer::send(const v1::ClientMessage& message) {
  asio::dispatch(impl_->strand, [impl = impl_, message] { impl->send(message); });
}
void Viewer::leave() {
  asio::post(impl_->strand, [impl = impl_] { impl->leave(); });
}
void Viewer::cut() {
  asio::post(impl_->strand, [impl = impl_] { impl->cut(); });
}
void Viewer::post(std::function<void()> work) { asio::post(impl_->strand, std::move(work)); }
void Viewer::after(std::chrono::nanoseconds time, std::function<void()> work) {
  auto timer = std::make_shared<asio::steady_timer>(impl_->strand, time);
  timer->async_wait([timer, work = std::move(work)](beast::error_code error) {
    if (!error) work();
  });
}

}  // namespace diaphane::api::load
