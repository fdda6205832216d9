#include "renderd/serve/grpc_server.h"

#include <grpc/support/log.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <list>
#include <mutex>
#include <optional>

#include "api/proto/worker.grpc.pb.h"
#include "common/connect.h"
#include "common/log.h"
#include "common/try.h"
#include "common/wire/grpc_credentials.h"
#include "common/wire/limited_listener.h"
#include "renderd/serve/assist_reactor.h"
#include "renderd/serve/reply_queue.h"

namespace diaphane::render {
namespace {

using std::chrono::steady_clock;

// Acknowledgements limit a viewer's frames. This many other unread messages mean that the client
// does not read.
constexpr std::size_t kMostQueued = 64;
constexpr std::chrono::seconds kFlushTime{2};
// Time limit for TLS and the start of HTTP/2. gRPC's default is two minutes.
constexpr int kHandshakeMs = 10'000;
// Limits of unauthenticated connections: far more than gateways, apis and other workers need when
// they all reconnect at once, and few enough for a limit of 1,024 open files.
constexpr std::size_t kMostUnfinished = 256;
constexpr std::size_t kMostUnfinishedPerAddress = 32;

struct StatusName {
  grpc::StatusCode code;
  const char* name;
};

StatusName status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalid:
    case ErrorCode::kTooLarge:
    case ErrorCode::kUnsupported:
      return {grpc::StatusCode::INVALID_ARGUMENT, "invalid_argument"};
    case ErrorCode::kUnauthenticated:
      return {grpc::StatusCode::UNAUTHENTICATED, "unauthenticated"};
    case ErrorCode::kForbidden:
      return {grpc::StatusCode::PERMISSION_DENIED, "permission_denied"};
    case ErrorCode::kNotFound:
      return {grpc::StatusCode::NOT_FOUND, "not_found"};
    case ErrorCode::kConflict:
      return {grpc::StatusCode::ABORTED, "aborted"};
    case ErrorCode::kTooMany:
    case ErrorCode::kOutOfMemory:
      return {grpc::StatusCode::RESOURCE_EXHAUSTED, "resource_exhausted"};
    case ErrorCode::kUnavailable:
    case ErrorCode::kOutcomeUnknown:
    case ErrorCode::kDeviceLost:
      return {grpc::StatusCode::UNAVAILABLE, "unavailable"};
    case ErrorCode::kInternal:
      break;
  }
  return {grpc::StatusCode::INTERNAL, "internal"};
}

grpc::Status status_for(const Error& error, Metrics& metrics) {
  const StatusName status = status_of(error.code);
  metrics.grpc_error(status.name);
  v1::Refusal why;
  why.set_no_memory(error.code == ErrorCode::kOutOfMemory);
  why.set_displaced(is_displaced(error));
  if (!why.no_memory() && !why.displaced()) return {status.code, error.message};
  return {status.code, error.message, why.SerializeAsString()};
}

// Writes gRPC's own errors to this program's log.
void log_line(gpr_log_func_args* line) {
  if (line->severity == GPR_LOG_SEVERITY_ERROR) log::error("grpc", {{"message", line->message}});
}

class StreamLink final : public ClientLink, public ReplyQueue<v1::AttachRequest, v1::AttachReply> {
 public:
  StreamLink(Reactor* reactor, grpc::CallbackServerContext* context, Metrics& metrics)
      : ReplyQueue(reactor), context_(context), metrics_(metrics) {}

  void send(std::string server_message) override {
    const std::lock_guard lock(mutex_);
    if (!open()) return;
    if (queue_.size() >= kMostQueued) {
      flush(status_for({ErrorCode::kTooMany, "The viewer has stopped reading.", {}}, metrics_));
      queue_.clear();
      context_->TryCancel();
      return;
    }
    v1::AttachReply reply;
    reply.set_server_message(std::move(server_message));
    push(std::move(reply));
  }

  void finish(const Error& why) override { finish(status_for(why, metrics_)); }

  void finish(grpc::Status status) {
    const std::lock_guard lock(mutex_);
    if (!ending_) flush(std::move(status));
  }

  void cancel_if_stuck(steady_clock::time_point now) {
    const std::lock_guard lock(mutex_);
    if (reactor_ && ending_ && !finished_ && now - ending_since_ > kFlushTime)
      context_->TryCancel();
  }

 private:
  void flush(grpc::Status status) {
    ending_since_ = steady_clock::now();
    end(std::move(status));
  }

  grpc::CallbackServerContext* context_;  // valid while the call is not over
  Metrics& metrics_;
  steady_clock::time_point ending_since_{};
};

// The current connections, for the sweep.
class Links {
 public:
  void add(const std::shared_ptr<StreamLink>& link) {
    const std::lock_guard lock(mutex_);
    std::erase_if(links_, [](const auto& known) { return known.expired(); });
    links_.push_back(link);
  }
  void sweep() {
    const auto now = steady_clock::now();
    std::vector<std::shared_ptr<StreamLink>> links;
    {
      const std::lock_guard lock(mutex_);
      for (const auto& known : links_) {
        if (auto link = known.lock()) links.push_back(std::move(link));
      }
    }
    for (const auto& link : links) link->cancel_if_stuck(now);
  }

 private:
  std::mutex mutex_;
  std::list<std::weak_ptr<StreamLink>> links_;
};

// One Attach call. Deletes itself when gRPC is done with it.
class AttachReactor final : public StreamLink::Reactor {
 public:
  AttachReactor(SessionHost& host, Links& links, Metrics& metrics,
                grpc::CallbackServerContext* context)
      : host_(host), link_(std::make_shared<StreamLink>(this, context, metrics)) {
    links.add(link_);
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    if (!ok) {
      if (attachment_) attachment_->closed();
      link_->finish(grpc::Status::OK);
      return;
    }
    if (attachment_ && request_.body_case() == v1::AttachRequest::kClientMessage) {
      attachment_->receive(request_.client_message());
    } else if (!attachment_ && request_.body_case() == v1::AttachRequest::kOpen) {
      auto opened = host_.open(request_.open(), link_);
      if (opened) {
        attachment_.emplace(std::move(*opened));
      } else {
        link_->finish(opened.error());
      }
    } else {
      link_->finish(
          {ErrorCode::kInvalid, "An Attach stream must start with exactly one Open message.", {}});
    }
    // Reads even after a refusal, because only reading reveals the end of the call.
    StartRead(&request_);
  }

  void OnWriteDone(bool ok) override { link_->written(ok); }

  void OnDone() override {
    link_->over();
    delete this;
  }

 private:
  SessionHost& host_;
  std::shared_ptr<StreamLink> link_;
  v1::AttachRequest request_;
  std::optional<Attachment> attachment_;
};

// One RenderStill call. The answer may come after the caller left and the call ended.
class StillReactor final : public grpc::ServerUnaryReactor {
 public:
  StillReactor(StillService& stills, const v1::StillRequest& request, v1::StillReply* reply,
               Metrics& metrics)
      : cancelled_(std::make_shared<std::atomic<bool>>(false)) {
    stills.render(request, cancelled_, [this, reply, &metrics](Result<v1::StillReply> rendered) {
      if (!rendered) return Finish(status_for(rendered.error(), metrics));
      *reply = std::move(*rendered);
      Finish(grpc::Status::OK);
    });
  }
  // The order still answers soon, and only its answer calls Finish.
  void OnCancel() override { *cancelled_ = true; }
  void OnDone() override { delete this; }

 private:
  const std::shared_ptr<std::atomic<bool>> cancelled_;
};

// Ends a streaming call at once. Deletes itself when gRPC is done with it.
template <typename Request, typename Reply>
class RefusingReactor final : public grpc::ServerBidiReactor<Request, Reply> {
 public:
  explicit RefusingReactor(const grpc::Status& why) { this->Finish(why); }
  void OnDone() override { delete this; }
};

// Each method first checks that its caller has the required role.
class Service final : public v1::RenderWorker::CallbackService {
 public:
  Service(SessionHost& host, StillService& stills, Metrics& metrics, AssistHost* assists,
          const wire::InnerTls& tls)
      : host_(host), stills_(stills), metrics_(metrics), assists_(assists), tls_(tls) {}

  grpc::ServerBidiReactor<v1::AttachRequest, v1::AttachReply>* Attach(
      grpc::CallbackServerContext* context) override {
    if (const auto allowed = require(wire::Role::kGateway, *context, "Attach"); !allowed.ok()) {
      return new RefusingReactor<v1::AttachRequest, v1::AttachReply>(allowed);
    }
    return new AttachReactor(host_, links_, metrics_, context);
  }

  grpc::ServerUnaryReactor* RenderStill(grpc::CallbackServerContext* context,
                                        const v1::StillRequest* request,
                                        v1::StillReply* reply) override {
    if (const auto allowed = require(wire::Role::kApi, *context, "RenderStill"); !allowed.ok()) {
      grpc::ServerUnaryReactor* refusal = context->DefaultReactor();
      refusal->Finish(allowed);
      return refusal;
    }
    return new StillReactor(stills_, *request, reply, metrics_);
  }

  grpc::ServerUnaryReactor* GetErrorCurve(grpc::CallbackServerContext* context,
                                          const v1::ErrorCurveRequest* request,
                                          v1::ErrorCurve* reply) override {
    grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
    grpc::Status status = require(wire::Role::kApi, *context, "GetErrorCurve");
    if (status.ok()) {
      if (auto curve = host_.error_curve(request->session_id())) {
        *reply = std::move(*curve);
      } else {
        status = {grpc::StatusCode::NOT_FOUND, "this worker has no such session"};
      }
    }
    reactor->Finish(status);
    return reactor;
  }

  grpc::ServerBidiReactor<v1::AssistRequest, v1::AssistReply>* Assist(
      grpc::CallbackServerContext* context) override {
    if (const auto allowed = require(wire::Role::kRenderd, *context, "Assist"); !allowed.ok()) {
      return new RefusingReactor<v1::AssistRequest, v1::AssistReply>(allowed);
    }
    return new AssistReactor(assists_);
  }

  Links& links() { return links_; }
  /// Sets the listener, which then learns the addresses of authenticated callers.
  void set_listener(wire::LimitedListener* listener) { listener_ = listener; }

 private:
  grpc::Status require(wire::Role role, const grpc::CallbackServerContext& context,
                       const char* method) {
    grpc::Status allowed = wire::require_role(context, role, tls_, method);
    if (!allowed.ok()) {
      metrics_.grpc_error("permission_denied");
    } else if (listener_ != nullptr && tls_.on()) {
      listener_->know(context.peer());
    }
    return allowed;
  }

  SessionHost& host_;
  StillService& stills_;
  Metrics& metrics_;
  AssistHost* assists_;
  const wire::InnerTls tls_;
  wire::LimitedListener* listener_ = nullptr;
  Links links_;
};

}  // namespace

struct GrpcServer::Impl {
  Impl(SessionHost& host, StillService& stills, Metrics& metrics, AssistHost* assists,
       const wire::InnerTls& tls)
      : service(host, stills, metrics, assists, tls) {}
  // Null on a Unix socket, to which only users with write access to its folder can connect.
  std::unique_ptr<wire::LimitedListener> listener;
  Service service;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> acceptor;
  std::unique_ptr<grpc::Server> server;
};

Result<std::unique_ptr<GrpcServer>> GrpcServer::start(Options options, SessionHost& host,
                                                      StillService& stills, Metrics& metrics,
                                                      AssistHost* assists) {
  auto impl = std::make_unique<Impl>(host, stills, metrics, assists, options.tls);
  gpr_set_log_function(log_line);
  grpc::EnableDefaultHealthCheckService(true);
  grpc::ServerBuilder builder;
  builder.SetMaxReceiveMessageSize(options.most_message_bytes);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, options.most_streams);
  // Detects a gateway that vanished without closing the connection within 15 s.
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 10'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5'000);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshakeMs);
  // Gateways ping every 5 s and assisted workers every 10 s, even when no messages are sent.
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 2'000);
  const std::string path = unix_path(options.address);
  // gRPC would take the socket from another process that listens on it.
  if (!path.empty() && connect_unix(path)) {
    return fail(ErrorCode::kUnavailable, "another process is already listening on " + path);
  }
  const auto credentials = wire::server_credentials(options.tls);
  if (path.empty()) {
    auto listener = wire::LimitedListener::open(
        options.address, options.port,
        {kMostUnfinished, kMostUnfinishedPerAddress, std::chrono::milliseconds(kHandshakeMs)});
    DIAPHANE_TRY(listener);
    impl->listener = std::move(*listener);
    impl->service.set_listener(impl->listener.get());
    impl->acceptor = builder.experimental().AddExternalConnectionAcceptor(
        grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD, credentials);
  } else {
    builder.AddListeningPort(options.address, credentials);
  }
  builder.RegisterService(&impl->service);
  impl->server = builder.BuildAndStart();
  if (!impl->server) {
    return fail(ErrorCode::kUnavailable,
                "the gRPC address " + options.address + " cannot be opened");
  }
  if (impl->listener) {
    impl->listener->start([acceptor = impl->acceptor.get()](int socket) {
      grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters connection;
      connection.fd = socket;
      acceptor->HandleNewConnection(&connection);
    });
  }
  return std::unique_ptr<GrpcServer>(new GrpcServer(std::move(impl)));
}

GrpcServer::GrpcServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GrpcServer::~GrpcServer() { stop(std::chrono::milliseconds(0)); }

std::uint16_t GrpcServer::port() const { return impl_->listener ? impl_->listener->port() : 0; }

void GrpcServer::set_not_serving() {
  impl_->server->GetHealthCheckService()->SetServingStatus(false);
}

void GrpcServer::sweep() { impl_->service.links().sweep(); }

void GrpcServer::stop(std::chrono::milliseconds grace) {
  // After its shutdown, gRPC would neither accept nor close a connection.
  if (impl_->listener) impl_->listener->stop();
  impl_->server->Shutdown(std::chrono::system_clock::now() + grace);
}

}  // namespace diaphane::render
