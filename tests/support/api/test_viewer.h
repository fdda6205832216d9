#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <optional>
#include <string>

namespace diaphane::api::stream {

/// The browser's side of the stream: a synchronous WebSocket client with timeouts.
class TestViewer {
 public:
  static constexpr const char* kOrigin = "https://scans.example";

  explicit TestViewer(std::uint16_t port, int receive_buffer = 0) : socket_(io_) {
    auto& tcp = socket_.next_layer().socket();
    tcp.open(boost::asio::ip::tcp::v4());
    if (receive_buffer != 0) {
      tcp.set_option(boost::asio::socket_base::receive_buffer_size(receive_buffer));
    }
    tcp.connect({boost::asio::ip::make_address("127.0.0.1"), port});
  }

  /// Returns whether the stream began.
  bool shake_hands(const std::string& target, const std::string& origin = kOrigin,
                   const std::string& subprotocol = "diaphane.v1") {
    namespace websocket = boost::beast::websocket;
    socket_.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
      if (!origin.empty()) request.set(boost::beast::http::field::origin, origin);
      if (!subprotocol.empty()) {
        request.set(boost::beast::http::field::sec_websocket_protocol, subprotocol);
      }
    }));
    boost::beast::error_code error;
    socket_.handshake(answer_, "scans.example", target, error);
    socket_.binary(true);
    return !error;
  }
  /// Returns the HTTP status of the response to a handshake.
  unsigned status_of_handshake(const std::string& target, const std::string& origin,
                               const std::string& subprotocol) {
    namespace http = boost::beast::http;
    http::request<http::empty_body> request(http::verb::get, target, 11);
    request.set(http::field::host, "scans.example");
    request.set(http::field::upgrade, "websocket");
    request.set(http::field::connection, "upgrade");
    request.set(http::field::sec_websocket_version, "13");
    request.set(http::field::sec_websocket_key, "dGhlIHNhbXBsZSBub25jZQ==");
    if (!origin.empty()) request.set(http::field::origin, origin);
    if (!subprotocol.empty()) request.set(http::field::sec_websocket_protocol, subprotocol);
    http::write(socket_.next_layer(), request);
    boost::beast::error_code error;
    http::response<http::string_body> response;
    http::read(socket_.next_layer(), buffer_, response, error);
    return response.result_int();
  }
  bool enter(const std::string& ticket) { return shake_hands("/stream?ticket=" + ticket); }
  std::string answered_subprotocol() const {
    return std::string(answer_[boost::beast::http::field::sec_websocket_protocol]);
  }

  bool send(const std::string& message) {
    boost::beast::error_code error;
    socket_.write(boost::asio::buffer(message), error);
    return !error;
  }
  void send_text(const std::string& message) {
    socket_.text(true);
    send(message);
  }

  /// Returns the next message, or nullopt when the stream ended or after `timeout`.
  std::optional<std::string> receive(std::chrono::milliseconds timeout = std::chrono::seconds(60)) {
    buffer_.clear();
    std::optional<boost::beast::error_code> result;
    socket_.async_read(buffer_,
                       [&](boost::beast::error_code error, std::size_t) { result = error; });
    io_.restart();
    io_.run_for(timeout);
    if (!result) {  // the read is still in progress, so this viewer is unusable
      socket_.next_layer().socket().close();
      io_.restart();
      io_.run();
      return std::nullopt;
    }
    if (*result) return std::nullopt;
    return boost::beast::buffers_to_string(buffer_.data());
  }
  /// Reads until the stream ends. Returns its close code, 0 if the connection was lost, or -1 after
  /// `timeout`.
  int close_code(std::chrono::milliseconds timeout = std::chrono::seconds(60)) {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    while (std::chrono::steady_clock::now() < deadline) {
      if (receive(std::chrono::duration_cast<std::chrono::milliseconds>(
              deadline - std::chrono::steady_clock::now()))) {
        continue;
      }
      return std::chrono::steady_clock::now() < deadline ? socket_.reason().code : -1;
    }
    return -1;
  }
  void leave() {
    boost::beast::error_code ignored;
    socket_.close(boost::beast::websocket::close_code::normal, ignored);
  }
  boost::asio::ip::tcp::socket& tcp() { return socket_.next_layer().socket(); }

 private:
  boost::asio::io_context io_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> socket_;
  boost::beast::websocket::response_type answer_;
  boost::beast::flat_buffer buffer_;
};

}  // namespace diaphane::api::stream
