#include "directory/client.h"

#include <hiredis/hiredis.h>

#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>

#include "common/log.h"
#include "common/wire/redis_address.h"
#include "common/wire/tls_tunnel.h"

namespace diaphane::directory {
namespace {

using std::chrono::milliseconds;
using SteadyTime = std::chrono::steady_clock::time_point;

struct FreeContext {
  void operator()(redisContext* context) const { redisFree(context); }
};
struct FreeReply {
  void operator()(redisReply* reply) const { freeReplyObject(reply); }
};
using Context = std::unique_ptr<redisContext, FreeContext>;
using RawReply = std::unique_ptr<redisReply, FreeReply>;

timeval to_timeval(milliseconds time) {
  const auto count = time.count();
  return {static_cast<time_t>(count / 1000), static_cast<suseconds_t>(count % 1000 * 1000)};
}

tl::unexpected<Error> away() {
  return fail(ErrorCode::kUnavailable,
              "The session store is unavailable. Please try again in a moment.");
}

Reply to_reply(const redisReply& raw) {
  Reply reply;
  switch (raw.type) {
    case REDIS_REPLY_INTEGER:
      reply.kind = Reply::Kind::kInteger;
      reply.integer = raw.integer;
      break;
    case REDIS_REPLY_STRING:
    case REDIS_REPLY_STATUS:
      reply.kind = Reply::Kind::kText;
      reply.text.assign(raw.str, raw.len);
      break;
    case REDIS_REPLY_ARRAY:
      reply.kind = Reply::Kind::kList;
      reply.list.reserve(raw.elements);
      for (std::size_t i = 0; i < raw.elements; ++i) {
        reply.list.push_back(to_reply(*raw.element[i]));
      }
      break;
    default:
      break;
  }
  return reply;
}

/// The meaning of a Redis error for the caller.
enum class Fault {
  kRefused,        ///< the command is invalid, which is a bug in Diaphane
  kTemporary,      ///< Redis cannot serve requests at the moment
  kReplica,        ///< like kTemporary, and another server has become the primary
  kUnknownScript,  ///< EVALSHA of a script that Redis does not have
};

Fault fault_of(std::string_view error) {
  static constexpr std::pair<std::string_view, Fault> kFaults[] = {
      {"NOSCRIPT", Fault::kUnknownScript}, {"READONLY", Fault::kReplica},
      {"MASTERDOWN", Fault::kReplica},     {"LOADING", Fault::kTemporary},
      {"BUSY", Fault::kTemporary},         {"OOM", Fault::kTemporary},
      {"CLUSTERDOWN", Fault::kTemporary},  {"MISCONF", Fault::kTemporary},
      {"NOREPLICAS", Fault::kTemporary},   {"TRYAGAIN", Fault::kTemporary},
  };
  for (const auto& [prefix, fault] : kFaults) {
    if (error.starts_with(prefix)) return fault;
  }
  return Fault::kRefused;
}

std::optional<Fault> fault_of(const redisReply& reply) {
  if (reply.type != REDIS_REPLY_ERROR) return std::nullopt;
  return fault_of(std::string_view(reply.str, reply.len));
}

/// Returns the reply, or an error for `what` (a command or a script).
Result<Reply> checked(const redisReply& reply, std::string_view what) {
  const std::optional<Fault> fault = fault_of(reply);
  if (!fault) return to_reply(reply);
  if (*fault == Fault::kTemporary || *fault == Fault::kReplica) return away();
  return fail(ErrorCode::kInternal,
              "Redis refused " + std::string(what) + ": " + std::string(reply.str, reply.len));
}

}  // namespace

struct Client::Impl {
  Options options;
  wire::RedisAddress address;
  std::unique_ptr<wire::TlsTunnels> tunnels;  ///< only with TLS; must outlive the connections

  std::mutex mutex;
  std::condition_variable returned;
  std::vector<Context> idle;
  std::size_t lent = 0;

  /// A connection leased to one call and returned to the pool if it is still usable.
  class Lease {
   public:
    Lease(Impl& pool, Context context) : pool_(pool), context_(std::move(context)) {}
    ~Lease() { pool_.take_back(std::move(context_)); }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    redisContext* get() const { return context_.get(); }
    void replace(Context context) { context_ = std::move(context); }

   private:
    Impl& pool_;
    Context context_;
  };

  Context connect(milliseconds connect_limit, milliseconds command_limit) const {
    Context context;
    if (tunnels) {
      const auto local = tunnels->open(address.host, address.port, connect_limit);
      if (!local) {
        log::warning("redis", {{"reason", local.error().message}});
        return nullptr;
      }
      context.reset(redisConnectFd(*local));
    } else if (!address.path.empty()) {
      context.reset(redisConnectUnixWithTimeout(address.path.c_str(), to_timeval(connect_limit)));
    } else {
      context.reset(
          redisConnectWithTimeout(address.host.c_str(), address.port, to_timeval(connect_limit)));
    }
    if (!context || context->err != 0) return nullptr;
    redisSetTimeout(context.get(), to_timeval(command_limit));
    if (!tunnels && address.path.empty()) redisEnableKeepAlive(context.get());
    return context;
  }

  /// Returns an idle connection, or a null one that must be connected, or nothing if all stay busy
  /// until `deadline`.
  std::optional<Context> borrow(SteadyTime deadline) {
    std::unique_lock lock(mutex);
    if (!returned.wait_until(lock, deadline, [&] { return lent < options.connections; })) {
      return std::nullopt;
    }
    ++lent;
    if (idle.empty()) return Context();
    Context context = std::move(idle.back());
    idle.pop_back();
    return context;
  }

  void take_back(Context context) {
    {
      std::lock_guard lock(mutex);
      --lent;
      if (context && context->err == 0) idle.push_back(std::move(context));
    }
    returned.notify_one();
  }

  void forget_idle() {
    std::lock_guard lock(mutex);
    idle.clear();
  }

  static RawReply send(redisContext* context, const Arguments& command_line) {
    std::vector<const char*> starts;
    std::vector<std::size_t> lengths;
    for (std::string_view word : command_line) {
      starts.push_back(word.data());
      lengths.push_back(word.size());
    }
    return RawReply(static_cast<redisReply*>(redisCommandArgv(
        context, static_cast<int>(command_line.size()), starts.data(), lengths.data())));
  }

  Result<RawReply> call(const Arguments& command_line) {
    std::optional<Context> context =
        borrow(std::chrono::steady_clock::now() + options.command_timeout);
    if (!context) return away();
    const bool reused = *context != nullptr;
    if (!reused) *context = connect(options.connect_timeout, options.command_timeout);
    Lease lease(*this, std::move(*context));
    if (lease.get() == nullptr) return away();
    RawReply reply = send(lease.get(), command_line);
    // An idle connection may have died with its Redis. Running a script twice is safe, because each
    // is idempotent. If the reply to consuming a ticket was lost, the page requests a new ticket.
    if (!reply && reused && lease.get()->err == REDIS_ERR_EOF) {
      forget_idle();
      lease.replace(connect(options.connect_timeout, options.command_timeout));
      if (lease.get() == nullptr) return away();
      reply = send(lease.get(), command_line);
    }
    if (!reply) return away();
    if (fault_of(*reply) == Fault::kReplica) {
      // Another server may have become the primary behind the same address, so the next call
      // reconnects.
      lease.replace(nullptr);
      forget_idle();
    }
    return reply;
  }
};

Result<std::unique_ptr<Client>> Client::create(Options options) {
  auto impl = std::make_unique<Impl>();
  auto address = wire::parse_redis_address(options.address);
  if (!address) return fail(ErrorCode::kInvalid, address.error().message, "redis");
  if (address->with_tls) {
    if (!options.tls.on()) {
      return fail(ErrorCode::kInvalid,
                  "rediss:// requires --inner-tls-ca, --inner-tls-certificate and --inner-tls-key",
                  "redis");
    }
    impl->tunnels = std::make_unique<wire::TlsTunnels>(options.tls.files);
  } else if (auto plain = wire::may_be_plain(options.address, options.tls); !plain) {
    return fail(ErrorCode::kInvalid, plain.error().message, "redis");
  }
  impl->address = *std::move(address);
  if (options.connections == 0)
    return fail(ErrorCode::kInvalid, "at least one connection is required");
  impl->options = std::move(options);
  return std::unique_ptr<Client>(new Client(std::move(impl)));
}

Client::Client(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Client::~Client() = default;

Result<Reply> Client::command(const Arguments& command_line) {
  const Result<RawReply> raw = impl_->call(command_line);
  if (!raw) return tl::unexpected(raw.error());
  return checked(**raw, "a command");
}

Result<Reply> Client::run(const Script& script, const Arguments& arguments) {
  Arguments command_line{"EVALSHA", script.sha1, "0"};
  command_line.insert(command_line.end(), arguments.begin(), arguments.end());
  Result<RawReply> raw = impl_->call(command_line);
  if (raw && fault_of(**raw) == Fault::kUnknownScript) {
    command_line[0] = "EVAL";
    command_line[1] = script.source;
    raw = impl_->call(command_line);
  }
  if (!raw) return tl::unexpected(raw.error());
  return checked(**raw, std::string(script.name) + ".lua");
}

bool Client::answers(std::chrono::milliseconds timeout) {
  // Uses a separate connection, because those of the pool may be dead or busy.
  const Context probe = impl_->connect(timeout / 2, timeout / 2);
  if (!probe) return false;
  const RawReply reply = Impl::send(probe.get(), {"PING"});
  return reply && reply->type == REDIS_REPLY_STATUS;
}

}  // namespace diaphane::directory
