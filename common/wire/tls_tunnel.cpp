#include "common/wire/tls_tunnel.h"

#include <openssl/ssl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <boost/asio/connect.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/write.hpp>
#include <future>
#include <thread>
#include <utility>

namespace diaphane::wire {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using Fault = boost::system::error_code;
using Local = asio::local::stream_protocol::socket;

class Tunnel : public std::enable_shared_from_this<Tunnel> {
 public:
  Tunnel(asio::io_context& io, const TlsFiles& files)
      : context_(asio::ssl::context::tls_client),
        resolver_(io),
        outer_(io, use(files)),
        inner_(io) {}

  void open(const std::string& host, int port) {
    outer_.set_verify_mode(asio::ssl::verify_peer);
    outer_.set_verify_callback(asio::ssl::host_name_verification(host));
    // Some servers select their certificate by SNI, which must be a host name and not an address.
    Fault no_address;
    (void)asio::ip::make_address(host, no_address);
    if (no_address) {
      // The same as SSL_set_tlsext_host_name, but without the C cast of its macro.
      SSL_ctrl(outer_.native_handle(), SSL_CTRL_SET_TLSEXT_HOSTNAME, TLSEXT_NAMETYPE_host_name,
               const_cast<char*>(host.c_str()));
    }
    resolver_.async_resolve(
        host, std::to_string(port), tcp::resolver::numeric_service,
        [self = shared_from_this()](const Fault& fault, const tcp::resolver::results_type& found) {
          if (fault) return self->opened(fault);
          asio::async_connect(self->outer_.next_layer(), found,
                              [self](const Fault& unreachable, const tcp::endpoint&) {
                                if (unreachable) return self->opened(unreachable);
                                self->shake_hands();
                              });
        });
  }

  std::future<Fault> when_open() { return open_.get_future(); }

  /// Starts relaying. `local` is this end of the socket pair.
  void carry(int local) {
    inner_.assign(asio::local::stream_protocol(), local);
    // With TLS 1.3, the server may refuse our certificate after our side of the handshake is
    // complete. Then the first read returns the end of the stream.
    upwards();
    downwards();
  }

  void close() {
    Fault ignored;
    resolver_.cancel();
    outer_.next_layer().close(ignored);
    inner_.close(ignored);
  }

 private:
  asio::ssl::context& use(const TlsFiles& files) {
    context_.set_options(asio::ssl::context::no_tlsv1 | asio::ssl::context::no_tlsv1_1);
    context_.load_verify_file(files.ca);
    context_.use_certificate_chain_file(files.certificate);
    context_.use_private_key_file(files.key, asio::ssl::context::pem);
    return context_;
  }

  void shake_hands() {
    Fault ignored;
    outer_.next_layer().set_option(tcp::no_delay(true), ignored);
    outer_.next_layer().set_option(asio::socket_base::keep_alive(true), ignored);
    outer_.async_handshake(
        asio::ssl::stream_base::client,
        [self = shared_from_this()](const Fault& fault) { self->opened(fault); });
  }

  void opened(const Fault& fault) {
    if (fault) close();
    open_.set_value(fault);
  }

  void upwards() {
    inner_.async_read_some(asio::buffer(up_),
                           [self = shared_from_this()](const Fault& end, std::size_t bytes) {
                             if (end) return self->close();
                             asio::async_write(self->outer_, asio::buffer(self->up_.data(), bytes),
                                               [self](const Fault& broken, std::size_t) {
                                                 if (broken) return self->close();
                                                 self->upwards();
                                               });
                           });
  }

  void downwards() {
    outer_.async_read_some(
        asio::buffer(down_), [self = shared_from_this()](const Fault& end, std::size_t bytes) {
          if (end) return self->close();
          asio::async_write(self->inner_, asio::buffer(self->down_.data(), bytes),
                            [self](const Fault& broken, std::size_t) {
                              if (broken) return self->close();
                              self->downwards();
                            });
        });
  }

  asio::ssl::context context_;
  tcp::resolver resolver_;
  asio::ssl::stream<tcp::socket> outer_;
  Local inner_;
  std::promise<Fault> open_;
  std::array<char, 16384> up_{}, down_{};
};

}  // namespace

struct TlsTunnels::Impl {
  explicit Impl(TlsFiles given) : files(std::move(given)) {}

  const TlsFiles files;
  asio::io_context io{1};
  asio::executor_work_guard<asio::io_context::executor_type> work{io.get_executor()};
  std::thread thread{[this] { io.run(); }};
};

TlsTunnels::TlsTunnels(TlsFiles files) : impl_(std::make_unique<Impl>(std::move(files))) {}

TlsTunnels::~TlsTunnels() {
  // Pending operations are destroyed with the context, which closes their sockets.
  impl_->io.stop();
  impl_->thread.join();
}

Result<int> TlsTunnels::open(const std::string& host, int port, std::chrono::milliseconds timeout) {
  std::shared_ptr<Tunnel> tunnel;
  try {
    tunnel = std::make_shared<Tunnel>(impl_->io, impl_->files);
  } catch (const boost::system::system_error& unusable) {
    return fail(ErrorCode::kUnavailable, std::string("TLS: ") + unusable.what());
  }
  std::future<Fault> open = tunnel->when_open();
  asio::post(impl_->io, [tunnel, host, port] { tunnel->open(host, port); });
  if (open.wait_for(timeout) != std::future_status::ready) {
    asio::post(impl_->io, [tunnel] { tunnel->close(); });
    return fail(ErrorCode::kUnavailable, "TLS: no response");
  }
  if (const Fault fault = open.get()) {
    return fail(ErrorCode::kUnavailable, "TLS: " + fault.message());
  }
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    asio::post(impl_->io, [tunnel] { tunnel->close(); });
    return fail(ErrorCode::kUnavailable, "TLS: cannot create a socket");
  }
  asio::post(impl_->io, [tunnel, ours = ends[0]] { tunnel->carry(ours); });
  return ends[1];
}

}  // namespace diaphane::wire
