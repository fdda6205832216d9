#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "api/shared/placement.h"
#include "api/stream/close_code.h"
#include "api/stream/hub.h"
#include "api/stream/worker_link.h"

namespace diaphane::api::stream {

/// The connection of one viewer: handshake, ticket, then messages in both directions until one side
/// ends it. Everything runs on the strand of its socket. Events from gRPC threads and from Redis
/// are posted there.
class Connection final : public LinkEvents, public std::enable_shared_from_this<Connection> {
 public:
  Connection(std::shared_ptr<Hub> hub, boost::asio::ip::tcp::socket socket);

  void start();
  /// Counts a refusal and closes the connection without a response, because the limit is reached.
  void refuse_busy();
  /// Sends the queued messages, then closes with the code. Aborts if the handshake is not complete.
  void close(CloseCode code, std::string_view reason);
  /// Closes the socket and ends the call immediately.
  void abort();
  /// Reports whether the worker of this stream is alive. Two misses in a row end the stream.
  void on_worker_heartbeat(bool alive);
  /// Worker ID and incarnation, separated by "|"; empty before attaching. Callable from any thread.
  std::string worker_key() const;
  /// The link that a guest joined with, otherwise empty. Callable from any thread.
  std::string link_hash() const;

  void on_link_open() override;
  void on_link_message(std::string message) override;
  void on_link_writable() override;
  void on_link_ended(const grpc::Status& status) override;

 private:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;
  using ErrorCodeOf = boost::beast::error_code;

  // Declared first, thus destroyed after the socket: the hub counts the connection until then.
  struct Presence {
    std::shared_ptr<Hub> hub;
    Connection* connection;
    ~Presence() { hub->leave(connection); }
  };

  template <typename Work>
  void on_strand(Work work);

  void read_handshake();
  void on_handshake(ErrorCodeOf error);
  void answer_plainly(boost::beast::http::status status, std::string_view sentence,
                      const std::string& reason);
  void linger(std::size_t left);
  void accept(const Request& request);
  void redeem_ticket();
  void on_ticket(Result<Attachment> redeemed);
  void attach(Attachment attachment);

  void read_next();
  void on_read(ErrorCodeOf error);
  bool too_fast();
  void write_next();
  void on_write(ErrorCodeOf error);

  void link_ended(const grpc::Status& status);
  void session_was_taken();
  void worker_broke_off();
  void worker_has_no_memory();
  void begin_close();
  void ended();

  Presence presence_;
  Hub& hub_;
  // Permessage-deflate is off (false), because pictures are already compressed.
  boost::beast::websocket::stream<boost::beast::tcp_stream, false> socket_;
  boost::asio::steady_timer write_timer_;
  boost::asio::steady_timer link_timer_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;

  std::string request_id_;
  std::string ticket_;
  std::optional<Attachment> attachment_;
  std::shared_ptr<WorkerLink> link_;
  // Keeps this object alive while it is attached, because with both directions paused no pending
  // operation would.
  std::shared_ptr<Connection> alive_;
  mutable std::mutex key_mutex_;
  std::string worker_key_, link_hash_;

  std::deque<std::string> outgoing_;
  bool accepted_ = false;
  bool counted_for_user_ = false;
  bool reading_ = false;
  bool writing_ = false;
  bool link_open_ = false;
  bool attach_timed_out_ = false;
  bool link_over_ = false;
  int misses_ = 0;
  std::optional<CloseCode> closing_;
  std::string close_reason_;
  bool close_begun_ = false;
  bool ended_ = false;

  std::chrono::steady_clock::time_point began_, second_began_;
  unsigned messages_this_second_ = 0;
  std::size_t messages_in_ = 0, messages_out_ = 0, bytes_in_ = 0, bytes_out_ = 0;
};

}  // namespace diaphane::api::stream
