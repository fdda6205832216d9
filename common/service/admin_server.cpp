#include "common/service/admin_server.h"

#include <CivetServer.h>
#include <arpa/inet.h>
#include <netinet/in.h>
#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/text_serializer.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

namespace diaphane::service {
namespace {

void reply(mg_connection* connection, int status, const char* reason, const char* type,
           const std::string& body) {
  mg_printf(connection,
            "HTTP/1.1 %d %s\r\nContent-Type: %s\r\nContent-Length: %zu\r\n"
            "Cache-Control: no-store\r\nConnection: close\r\n\r\n",
            status, reason, type, body.size());
  mg_write(connection, body.data(), body.size());
}

class Handler final : public CivetHandler {
 public:
  using Answer = std::function<void(mg_connection*)>;
  explicit Handler(Answer answer) : answer_(std::move(answer)) {}
  bool handleGet(CivetServer*, mg_connection* connection) override {
    answer_(connection);
    return true;
  }

 private:
  Answer answer_;
};

/// Opens a connection and closes it. Whether anybody took it makes no difference.
void knock(const std::string& address, std::uint16_t port) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  if (inet_pton(AF_INET, address.c_str(), &to.sin_addr) != 1) return;
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0) return;
  static_cast<void>(connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof to));
  close(fd);
}

}  // namespace

struct AdminServer::Impl {
  Options options;
  std::shared_ptr<prometheus::Registry> registry = std::make_shared<prometheus::Registry>();
  std::atomic<bool> draining{false};
  std::unique_ptr<Handler> metrics;
  std::unique_ptr<Handler> health;
  std::unique_ptr<Handler> ready;
  std::unique_ptr<CivetServer> server;  // last: its threads use the handlers
};

Result<std::unique_ptr<AdminServer>> AdminServer::start(Options options) {
  auto impl = std::make_unique<Impl>();
  impl->options = std::move(options);
  Impl* self = impl.get();

  auto& up = prometheus::BuildGauge()
                 .Name("diaphane_start_time_seconds")
                 .Help("When this program started, seconds since the epoch.")
                 .Register(*self->registry)
                 .Add({{"program", self->options.program}});
  up.Set(static_cast<double>(std::chrono::duration_cast<std::chrono::seconds>(
                                 std::chrono::system_clock::now().time_since_epoch())
                                 .count()));

  self->metrics = std::make_unique<Handler>([self](mg_connection* connection) {
    reply(connection, 200, "OK", "text/plain; version=0.0.4; charset=utf-8",
          prometheus::TextSerializer().Serialize(self->registry->Collect()));
  });
  self->health = std::make_unique<Handler>([self](mg_connection* connection) {
    nlohmann::json body{{"program", self->options.program}, {"pid", getpid()}};
    reply(connection, 200, "OK", "application/json", body.dump() + "\n");
  });
  self->ready = std::make_unique<Handler>([self](mg_connection* connection) {
    nlohmann::json body = nlohmann::json::object();
    if (self->options.details) {
      body = nlohmann::json::parse(self->options.details(), nullptr, false);
      if (!body.is_object()) body = nlohmann::json::object();
    }
    bool ready = !self->draining;
    body["program"] = self->options.program;
    body["draining"] = self->draining.load();
    body["checks"] = nlohmann::json::object();
    for (const ReadyCheck& check : self->options.checks) {
      const bool ok = check.ok();
      body["checks"][check.name] = ok;
      ready = ready && ok;
    }
    body["ready"] = ready;
    reply(connection, ready ? 200 : 503, ready ? "OK" : "Service Unavailable", "application/json",
          body.dump() + "\n");
  });

  try {
    self->server = std::make_unique<CivetServer>(std::vector<std::string>{
        "listening_ports", self->options.address + ":" + std::to_string(self->options.port),
        "num_threads", "2", "request_timeout_ms", "5000", "keep_alive_timeout_ms", "0"});
  } catch (const CivetException&) {
    return fail(ErrorCode::kUnavailable,
                "the admin port " + std::to_string(self->options.port) + " cannot be opened");
  }
  self->server->addHandler("/metrics", *self->metrics);
  self->server->addHandler("/healthz", *self->health);
  self->server->addHandler("/readyz", *self->ready);
  return std::unique_ptr<AdminServer>(new AdminServer(std::move(impl)));
}

AdminServer::AdminServer(std::unique_ptr<Impl> impl)
    : impl_(std::move(impl)), registry_(impl_->registry) {}

AdminServer::~AdminServer() {
  // civetweb's listening thread looks only every 2 s whether it should end, a constant of that
  // library; a connection makes it look at once. Repeated, because the first may come before it is
  // told to end.
  const std::jthread waker([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      knock(impl_->options.address, impl_->options.port);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  });
  impl_->server->close();
}

void AdminServer::set_draining() { impl_->draining = true; }

}  // namespace diaphane::service
