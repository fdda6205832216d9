#include "common/service/admin_server.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/text_serializer.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <list>
#include <nlohmann/json.hpp>
#include <thread>

namespace diaphane::service {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using asio::ip::tcp;

/// Timeout for receiving a request and for sending its response.
constexpr auto kPatience = std::chrono::seconds(2);
/// Maximum number of connections. A further one closes the oldest connection whose request has not
/// arrived, so that unfinished requests never block a probe.
constexpr std::size_t kMostConnections = 64;
constexpr std::size_t kMostHeaderBytes = 8192;
/// Number of threads for checks and metrics, because a check may wait for a store.
constexpr std::size_t kAnswering = 2;

using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;

Response make_response(http::status status, const char* type, std::string body) {
  Response response(status, 11);
  response.set(http::field::content_type, type);
  response.set(http::field::cache_control, "no-store");
  response.keep_alive(false);
  response.body() = std::move(body);
  response.prepare_payload();
  return response;
}

}  // namespace

struct AdminServer::Impl {
  /// One request and its response.
  struct Exchange {
    explicit Exchange(tcp::socket socket) : stream(std::move(socket)) {
      parser.header_limit(kMostHeaderBytes);
      parser.body_limit(0);
    }
    beast::tcp_stream stream;
    beast::flat_buffer buffer{kMostHeaderBytes};
    http::request_parser<http::empty_body> parser;
    Response response;
    bool arrived = false;
  };
  using Exchanges = std::list<std::shared_ptr<Exchange>>;

  explicit Impl(Options given) : options(std::move(given)) {}

  void accept();
  void begin(tcp::socket socket);
  void answer(const std::shared_ptr<Exchange>& exchange);
  void send(const std::shared_ptr<Exchange>& exchange);
  void end(const std::shared_ptr<Exchange>& exchange);
  void make_room();
  Response response_to(const Request& request) const;
  Response readiness() const;

  const Options options;
  std::shared_ptr<prometheus::Registry> registry = std::make_shared<prometheus::Registry>();
  std::atomic<bool> draining{false};
  asio::io_context io{1};
  tcp::acceptor acceptor{io};
  Exchanges exchanges;  ///< used only on the I/O thread, oldest first
  asio::thread_pool answering{kAnswering};
  std::jthread thread;
};

void AdminServer::Impl::accept() {
  acceptor.async_accept([this](beast::error_code error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    // Accepting fails if no descriptor is free. Retries after a pause instead of busy-waiting.
    if (error) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    if (!error) begin(std::move(socket));
    accept();
  });
}

void AdminServer::Impl::make_room() {
  if (exchanges.size() < kMostConnections) return;
  const auto oldest = std::find_if(exchanges.begin(), exchanges.end(),
                                   [](const auto& exchange) { return !exchange->arrived; });
  const auto ended = *(oldest == exchanges.end() ? exchanges.begin() : oldest);
  end(ended);
}

void AdminServer::Impl::begin(tcp::socket socket) {
  make_room();
  const auto exchange = std::make_shared<Exchange>(std::move(socket));
  exchanges.push_back(exchange);
  exchange->stream.expires_after(kPatience);
  http::async_read(exchange->stream, exchange->buffer, exchange->parser,
                   [this, exchange](beast::error_code error, std::size_t) {
                     if (error) return end(exchange);
                     exchange->arrived = true;
                     exchange->stream.expires_never();
                     asio::post(answering, [this, exchange] { answer(exchange); });
                   });
}

void AdminServer::Impl::answer(const std::shared_ptr<Exchange>& exchange) {
  try {
    exchange->response = response_to(exchange->parser.get());
  } catch (const std::exception&) {
    exchange->response = make_response(http::status::internal_server_error, "text/plain", "");
  }
  asio::post(io, [this, exchange] { send(exchange); });
}

void AdminServer::Impl::send(const std::shared_ptr<Exchange>& exchange) {
  exchange->stream.expires_after(kPatience);
  http::async_write(exchange->stream, exchange->response,
                    [this, exchange](beast::error_code, std::size_t) { end(exchange); });
}

void AdminServer::Impl::end(const std::shared_ptr<Exchange>& exchange) {
  beast::error_code ignored;
  exchange->stream.socket().shutdown(tcp::socket::shutdown_send, ignored);
  exchange->stream.close();
  exchanges.remove(exchange);
}

Response AdminServer::Impl::response_to(const Request& request) const {
  const std::string_view target(request.target().data(), request.target().size());
  const std::string_view path = target.substr(0, target.find('?'));
  if (request.method() != http::verb::get) {
    return make_response(http::status::method_not_allowed, "text/plain", "");
  }
  if (path == "/metrics") {
    return make_response(http::status::ok, "text/plain; version=0.0.4; charset=utf-8",
                         prometheus::TextSerializer().Serialize(registry->Collect()));
  }
  if (path == "/healthz") {
    const nlohmann::json body{{"program", options.program}, {"pid", getpid()}};
    return make_response(http::status::ok, "application/json", body.dump() + "\n");
  }
  if (path == "/readyz") return readiness();
  return make_response(http::status::not_found, "text/plain", "");
}

Response AdminServer::Impl::readiness() const {
  nlohmann::json body = nlohmann::json::object();
  if (options.details) {
    body = nlohmann::json::parse(options.details(), nullptr, false);
    if (!body.is_object()) body = nlohmann::json::object();
  }
  bool ready = !draining;
  body["program"] = options.program;
  body["draining"] = draining.load();
  body["checks"] = nlohmann::json::object();
  for (const ReadyCheck& check : options.checks) {
    const bool ok = check.ok();
    body["checks"][check.name] = ok;
    ready = ready && ok;
  }
  body["ready"] = ready;
  return make_response(ready ? http::status::ok : http::status::service_unavailable,
                       "application/json", body.dump() + "\n");
}

AdminServer::Options read_admin_options(ConfigReader& in, std::string program) {
  AdminServer::Options options;
  options.port = in.port("admin-port", "port of the admin server (/metrics, /healthz, /readyz)");
  options.address =
      in.text("admin-address", "address that the admin server listens on", options.address);
  options.program = std::move(program);
  return options;
}

Result<std::unique_ptr<AdminServer>> AdminServer::start(Options options) {
  auto impl = std::make_unique<Impl>(std::move(options));
  auto& up = prometheus::BuildGauge()
                 .Name("diaphane_start_time_seconds")
                 .Help("Start time of the process, in seconds since the Unix epoch.")
                 .Register(*impl->registry)
                 .Add({{"program", impl->options.program}});
  up.Set(static_cast<double>(std::chrono::duration_cast<std::chrono::seconds>(
                                 std::chrono::system_clock::now().time_since_epoch())
                                 .count()));

  beast::error_code error;
  const auto address = asio::ip::make_address(impl->options.address, error);
  const tcp::endpoint endpoint(address, impl->options.port);
  if (!error) impl->acceptor.open(endpoint.protocol(), error);
  if (!error) impl->acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) impl->acceptor.bind(endpoint, error);
  if (!error) impl->acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) {
    return fail(ErrorCode::kUnavailable,
                "the admin port " + std::to_string(impl->options.port) + " cannot be opened");
  }
  impl->accept();
  impl->thread = std::jthread([raw = impl.get()] { raw->io.run(); });
  return std::unique_ptr<AdminServer>(new AdminServer(std::move(impl)));
}

AdminServer::AdminServer(std::unique_ptr<Impl> impl)
    : impl_(std::move(impl)), registry_(impl_->registry) {}

AdminServer::~AdminServer() {
  // Stops the checks first, because their dependencies may be destroyed next. Their responses are
  // dropped.
  impl_->answering.stop();
  impl_->answering.join();
  impl_->io.stop();
  impl_->thread.join();
}

void AdminServer::set_draining() { impl_->draining = true; }

}  // namespace diaphane::service
