#include "api/stream/connection.h"

#include <boost/asio/dispatch.hpp>
#include <boost/asio/post.hpp>
#include <utility>

#include "api/stream/handshake.h"
#include "common/log.h"

namespace diaphane::api::stream {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace websocket = boost::beast::websocket;
using std::chrono::steady_clock;

namespace {

// Holds two frames on a slow connection. A larger buffer would only add latency.
constexpr int kSendBufferBytes = 512 * 1024;

// Limits for discarding the client's remaining bytes, so that it receives the refusal (see linger).
constexpr std::size_t kLingerBytes = 256 * 1024;
constexpr std::chrono::seconds kLingerTime{2};

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

/// Returns the reason why an overloaded worker ended an Attach, or an empty message if unknown.
v1::Refusal refusal_of(const grpc::Status& status) {
  v1::Refusal why;
  if (!why.ParseFromString(status.error_details())) why.Clear();
  return why;
}

bool is_request_id(std::string_view text) {
  return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

}  // namespace

Connection::Connection(std::shared_ptr<Hub> hub, asio::ip::tcp::socket socket)
    : presence_{std::move(hub), this},
      hub_(*presence_.hub),
      socket_(std::move(socket)),
      write_timer_(socket_.get_executor()),
      link_timer_(socket_.get_executor()),
      buffer_(2 * hub_.limits.header_bytes),
      began_(steady_clock::now()),
      second_began_(began_) {}

template <typename Work>
void Connection::on_strand(Work work) {
  asio::post(socket_.get_executor(),
             [self = shared_from_this(), work = std::move(work)]() mutable { work(*self); });
}

// ---- Handshake ----

void Connection::start() {
  on_strand([](Connection& self) {
    ErrorCodeOf ignored;
    auto& tcp = beast::get_lowest_layer(self.socket_).socket();
    tcp.set_option(asio::ip::tcp::no_delay(true), ignored);
    tcp.set_option(asio::socket_base::send_buffer_size(kSendBufferBytes), ignored);
    self.read_handshake();
  });
}

void Connection::refuse_busy() {
  hub_.metrics.refused("busy");
  on_strand([](Connection& self) {
    ErrorCodeOf ignored;
    beast::get_lowest_layer(self.socket_).socket().close(ignored);
  });
}

void Connection::read_handshake() {
  parser_.emplace();
  parser_->header_limit(static_cast<std::uint32_t>(hub_.limits.header_bytes));
  parser_->body_limit(0);
  beast::get_lowest_layer(socket_).expires_after(hub_.limits.handshake);
  http::async_read_header(
      socket_.next_layer(), buffer_, *parser_,
      [self = shared_from_this()](ErrorCodeOf error, std::size_t) { self->on_handshake(error); });
}

void Connection::on_handshake(ErrorCodeOf error) {
  if (error) {
    if (error == http::error::header_limit || error == http::error::buffer_overflow) {
      return answer_plainly(http::status::request_header_fields_too_large,
                            "The request headers are too large.", "handshake");
    }
    const bool is_http =
        error.category() == http::make_error_code(http::error::bad_version).category();
    if (is_http && error != http::error::end_of_stream && error != http::error::partial_message) {
      return answer_plainly(http::status::bad_request, "The request is malformed.", "handshake");
    }
    return hub_.metrics.refused("handshake");  // the client was too slow or has left
  }
  const Request& request = parser_->get();
  // A browser never sends bytes before our response.
  if (!websocket::is_upgrade(request) || !parser_->is_done() || buffer_.size() != 0) {
    return answer_plainly(http::status::upgrade_required,
                          "This URL accepts only WebSocket connections.", "handshake");
  }
  const std::string_view id = view(request["X-Request-Id"]);
  if (is_request_id(id)) request_id_ = id;
  auto ticket = check_handshake({view(request.target()), view(request[http::field::origin]),
                                 view(request[http::field::sec_websocket_protocol])},
                                hub_.public_origin);
  if (!ticket) {
    const bool origin = ticket.error().code == ErrorCode::kForbidden;
    return answer_plainly(origin ? http::status::forbidden : http::status::bad_request,
                          ticket.error().message, origin ? "origin" : "handshake");
  }
  ticket_ = std::move(*ticket);
  accept(request);
}

void Connection::answer_plainly(http::status status, std::string_view sentence,
                                const std::string& reason) {
  if (!reason.empty()) hub_.metrics.refused(reason);
  auto answer = std::make_shared<http::response<http::string_body>>(status, 11);
  answer->set(http::field::content_type, "text/plain; charset=utf-8");
  answer->set(http::field::connection, "close");
  if (status == http::status::upgrade_required) answer->set(http::field::upgrade, "websocket");
  answer->body() = std::string(sentence) + "\n";
  answer->prepare_payload();
  beast::get_lowest_layer(socket_).expires_after(hub_.limits.handshake);
  http::async_write(socket_.next_layer(), *answer,
                    [self = shared_from_this(), answer](ErrorCodeOf failed, std::size_t) {
                      if (!failed) self->linger(kLingerBytes);
                    });
}

// Discards the client's bytes, because closing with unread bytes would reset the connection.
void Connection::linger(std::size_t left) {
  ErrorCodeOf ignored;
  auto& tcp = beast::get_lowest_layer(socket_);
  if (left == kLingerBytes) {
    tcp.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
    tcp.expires_after(kLingerTime);
  }
  buffer_.clear();
  tcp.async_read_some(buffer_.prepare(buffer_.max_size() / 2),
                      [self = shared_from_this(), left](ErrorCodeOf over, std::size_t bytes) {
                        if (!over && bytes < left) self->linger(left - bytes);
                      });
}

void Connection::accept(const Request& request) {
  beast::get_lowest_layer(socket_).expires_never();  // from here, the timeouts of WebSocket apply
  socket_.set_option(
      websocket::stream_base::timeout{hub_.limits.handshake, hub_.limits.idle, true});
  socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& answer) {
    answer.set(http::field::sec_websocket_protocol,
               beast::string_view(kSubprotocol.data(), kSubprotocol.size()));
  }));
  socket_.read_message_max(hub_.limits.message_bytes);
  socket_.auto_fragment(false);
  socket_.binary(true);
  socket_.async_accept(request, [self = shared_from_this()](ErrorCodeOf error) {
    self->parser_.reset();
    if (error) return self->hub_.metrics.refused("handshake");
    self->accepted_ = true;
    // The buffer exceeds the message limit, so that the limit applies first and sends a close code.
    self->buffer_ = beast::flat_buffer(2 * self->hub_.limits.message_bytes);
    self->redeem_ticket();
  });
}

// ---- Ticket and worker ----

void Connection::redeem_ticket() {
  const bool taken = hub_.run_blocking([self = shared_from_this()] {
    auto redeemed = self->hub_.tickets.consume(self->ticket_);
    self->on_strand([redeemed = std::move(redeemed)](Connection& on) mutable {
      on.on_ticket(std::move(redeemed));
    });
  });
  if (!taken) {
    hub_.metrics.refused("busy");
    close(CloseCode::kBusy, "The server is busy. Please try again in a moment.");
  }
}

void Connection::on_ticket(Result<Attachment> redeemed) {
  if (closing_ || ended_) return;
  if (!redeemed) {
    const Error& error = redeemed.error();
    switch (error.code) {
      case ErrorCode::kUnauthenticated:
        hub_.metrics.refused("ticket");
        return close(CloseCode::kTicket, error.message);
      case ErrorCode::kNotFound:
        hub_.metrics.refused("session");
        return close(CloseCode::kSessionGone, error.message);
      case ErrorCode::kUnavailable:
        hub_.metrics.refused("unavailable");
        return close(CloseCode::kWorkerLost, error.message);
      default:
        hub_.metrics.refused("internal");
        log::error("ticket_failed", {{"message", error.message}});
        return close(CloseCode::kInternal,
                     "Something went wrong on our side. The error has been logged.");
    }
  }
  if (!hub_.enter_user(*redeemed)) {
    hub_.metrics.refused("too_many");
    return close(CloseCode::kTooMany, "You have too many open sessions. Close one of them.");
  }
  counted_for_user_ = true;
  attach(std::move(*redeemed));
}

void Connection::attach(Attachment attachment) {
  attachment_ = std::move(attachment);
  alive_ = shared_from_this();
  hub_.metrics.stream_attached();
  {
    const std::lock_guard lock(key_mutex_);
    link_hash_ = attachment_->link;
    worker_key_ = attachment_->session.worker_id + "|" + attachment_->incarnation;
  }
  link_ = WorkerLink::open(hub_.channels.to(attachment_->address, attachment_->incarnation),
                           *attachment_, weak_from_this());
  attachment_->scene.clear();
  link_timer_.expires_after(hub_.limits.attach);
  link_timer_.async_wait([self = shared_from_this()](ErrorCodeOf error) {
    if (error || self->link_open_ || self->link_over_) return;
    self->attach_timed_out_ = true;
    self->link_->cancel();
  });
  read_next();
}

void Connection::on_link_open() {
  on_strand([](Connection& self) {
    self.link_open_ = true;
    if (!self.ended_) self.link_timer_.cancel();
  });
}

// ---- Messages ----

void Connection::read_next() {
  if (reading_ || closing_ || ended_) return;
  reading_ = true;
  buffer_.consume(buffer_.size());
  socket_.async_read(buffer_, [self = shared_from_this()](ErrorCodeOf error, std::size_t) {
    self->on_read(error);
  });
}

void Connection::on_read(ErrorCodeOf error) {
  reading_ = false;
  if (error) {
    if (error == websocket::error::message_too_big) hub_.metrics.closed(CloseCode::kTooLarge);
    return ended();  // the viewer left, was idle too long, or broke the protocol (Beast has
                     // answered that)
  }
  if (closing_ || ended_) return;
  if (!socket_.got_binary()) return close(CloseCode::kMalformed, "Messages must be binary.");
  if (too_fast()) return close(CloseCode::kTooMany, "Too many messages.");
  const std::size_t bytes = buffer_.size();
  ++messages_in_;
  bytes_in_ += bytes;
  hub_.metrics.message(Direction::kToWorker, bytes);
  if (link_->send(beast::buffers_to_string(buffer_.data()))) read_next();
}

bool Connection::too_fast() {
  const auto now = steady_clock::now();
  if (now - second_began_ >= std::chrono::seconds(1)) {
    second_began_ = now;
    messages_this_second_ = 0;
  }
  return ++messages_this_second_ > hub_.limits.messages_per_second;
}

void Connection::on_link_writable() {
  on_strand([](Connection& self) { self.read_next(); });
}

void Connection::on_link_message(std::string message) {
  on_strand([message = std::move(message)](Connection& self) mutable {
    if (self.ended_ || self.close_begun_) return self.link_->delivered();
    self.outgoing_.push_back(std::move(message));
    self.write_next();
  });
}

void Connection::write_next() {
  if (writing_ || ended_) return;
  if (outgoing_.empty()) {
    if (closing_) begin_close();
    return;
  }
  writing_ = true;
  write_timer_.expires_after(hub_.limits.write);
  write_timer_.async_wait([self = shared_from_this()](ErrorCodeOf error) {
    if (error || !self->writing_) return;
    self->hub_.metrics.slow_viewer();
    self->abort();
  });
  socket_.async_write(
      asio::buffer(outgoing_.front()),
      [self = shared_from_this()](ErrorCodeOf error, std::size_t) { self->on_write(error); });
}

void Connection::on_write(ErrorCodeOf error) {
  writing_ = false;
  write_timer_.cancel();
  if (error || ended_) return ended();
  ++messages_out_;
  bytes_out_ += outgoing_.front().size();
  hub_.metrics.message(Direction::kToViewer, outgoing_.front().size());
  outgoing_.pop_front();
  link_->delivered();
  write_next();
}

// ---- The end ----

void Connection::on_link_ended(const grpc::Status& status) {
  on_strand([status](Connection& self) { self.link_ended(status); });
}

void Connection::link_ended(const grpc::Status& status) {
  link_over_ = true;
  link_timer_.cancel();
  if (closing_ || ended_) return;
  if (attach_timed_out_) return worker_broke_off();
  switch (status.error_code()) {
    case grpc::StatusCode::OK:
      return close(CloseCode::kDone, "");
    case grpc::StatusCode::INVALID_ARGUMENT:
      return close(CloseCode::kMalformed, "The renderer rejected a message.");
    case grpc::StatusCode::NOT_FOUND:
      return close(CloseCode::kSessionGone, "This scan is no longer available.");
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
      // Another worker may have enough memory. Other resources are exhausted everywhere.
      if (refusal_of(status).no_memory()) return worker_has_no_memory();
      if (refusal_of(status).displaced()) {
        return close(CloseCode::kDisplaced, "Your place was given to a signed-in user.");
      }
      return close(CloseCode::kTooMany, "The renderer is full. Please try again in a moment.");
    case grpc::StatusCode::ABORTED:
      return session_was_taken();
    case grpc::StatusCode::UNAVAILABLE:
    case grpc::StatusCode::CANCELLED:
    case grpc::StatusCode::UNKNOWN:
    case grpc::StatusCode::INTERNAL:
      return worker_broke_off();
    case grpc::StatusCode::PERMISSION_DENIED:
      // The worker's message describes a problem with certificates.
      log::error("attach_refused", {{"message", status.error_message()}});
      return close(CloseCode::kInternal,
                   "Something went wrong on our side. The error has been logged.");
    default:
      log::error("attach_failed", {{"status", static_cast<int>(status.error_code())},
                                   {"session", attachment_->session.id}});
      return close(CloseCode::kInternal,
                   "Something went wrong on our side. The error has been logged.");
  }
}

// The session may continue in another window, on another worker, or not at all. Redis knows which.
void Connection::session_was_taken() {
  const bool taken = hub_.run_blocking([self = shared_from_this()] {
    const auto found = self->hub_.placement.find(self->attachment_->session.id);
    const bool gone = !found && found.error().code == ErrorCode::kNotFound;
    const bool moved = found && found->worker_id != self->attachment_->session.worker_id;
    self->on_strand([gone, moved](Connection& on) {
      if (gone) return on.close(CloseCode::kSessionGone, "This session was closed.");
      if (moved)
        return on.close(CloseCode::kWorkerLost, "This session is moving to another renderer.");
      on.close(CloseCode::kTakenOver, "This session was opened in another window.");
    });
  });
  if (!taken) close(CloseCode::kTakenOver, "This session was opened in another window.");
}

// Closes only after Redis is updated: the viewer's next ticket must not lead to the same worker.
void Connection::worker_broke_off() {
  const bool taken = hub_.run_blocking([self = shared_from_this()] {
    self->hub_.worker_broke_off(*self->attachment_);
    self->on_strand([](Connection& on) {
      on.close(CloseCode::kWorkerLost, "The connection to the renderer was lost.");
    });
  });
  if (!taken) close(CloseCode::kWorkerLost, "The connection to the renderer was lost.");
}

// Closes only after Redis is updated, as worker_broke_off does.
void Connection::worker_has_no_memory() {
  const bool taken = hub_.run_blocking([self = shared_from_this()] {
    const Attachment& attached = *self->attachment_;
    const bool noted =
        self->hub_.placement
            .refused(attached.session.id, attached.session.worker_id, attached.placement)
            .has_value();
    self->on_strand([noted](Connection& on) {
      if (noted)
        return on.close(CloseCode::kWorkerLost, "This session is moving to another renderer.");
      on.close(CloseCode::kTooMany, "The renderer is full. Please try again in a moment.");
    });
  });
  if (!taken) close(CloseCode::kTooMany, "The renderer is full. Please try again in a moment.");
}

void Connection::on_worker_heartbeat(bool alive) {
  on_strand([alive](Connection& self) {
    if (!self.attachment_ || self.closing_ || self.ended_) return;
    self.misses_ = alive ? 0 : self.misses_ + 1;
    if (self.misses_ < 2) return;
    self.close(CloseCode::kWorkerLost, "The renderer is not responding.");
    self.link_->cancel();
  });
}

std::string Connection::worker_key() const {
  const std::lock_guard lock(key_mutex_);
  return worker_key_;
}

std::string Connection::link_hash() const {
  const std::lock_guard lock(key_mutex_);
  return link_hash_;
}

void Connection::close(CloseCode code, std::string_view reason) {
  on_strand([code, text = std::string(reason)](Connection& self) mutable {
    if (self.closing_ || self.ended_) return;
    if (!self.accepted_) return self.abort();
    self.closing_ = code;
    self.close_reason_ = std::move(text);
    self.hub_.metrics.closed(code);
    self.write_next();
  });
}

void Connection::begin_close() {
  if (close_begun_) return;
  close_begun_ = true;
  websocket::close_reason reason;
  reason.code = static_cast<std::uint16_t>(*closing_);
  reason.reason = close_reason_.substr(0, 123);  // maximum of a close frame (RFC 6455)
  socket_.async_close(reason, [self = shared_from_this()](ErrorCodeOf) { self->ended(); });
}

void Connection::abort() {
  on_strand([](Connection& self) {
    ErrorCodeOf ignored;
    beast::get_lowest_layer(self.socket_).socket().close(ignored);
    if (self.link_) self.link_->cancel();
    self.ended();
  });
}

void Connection::ended() {
  if (ended_) return;
  ended_ = true;
  const std::shared_ptr<Connection> alive = std::move(alive_);
  write_timer_.cancel();
  ErrorCodeOf ignored;
  if (!writing_) beast::get_lowest_layer(socket_).socket().close(ignored);
  if (link_ && !link_over_) {
    // The viewer's last messages (such as a scene before a reload) still reach the worker.
    link_->finish();
    link_timer_.expires_after(hub_.limits.goodbye);
    link_timer_.async_wait([self = shared_from_this()](ErrorCodeOf error) {
      if (!error && !self->link_over_) self->link_->cancel();
    });
  }
  if (counted_for_user_) hub_.leave_user(*attachment_);
  if (!attachment_) return;
  hub_.metrics.stream_detached();
  const std::chrono::duration<double> lasted = steady_clock::now() - began_;
  log::info("stream_closed", {{"request_id", request_id_},
                              {"session", attachment_->session.id},
                              {"worker", attachment_->session.worker_id},
                              {"code", closing_ ? static_cast<int>(*closing_) : 0},
                              {"seconds", lasted.count()},
                              {"messages_in", messages_in_},
                              {"messages_out", messages_out_},
                              {"bytes_in", bytes_in_},
                              {"bytes_out", bytes_out_}});
}

}  // namespace diaphane::api::stream
