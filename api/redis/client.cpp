#include "api/redis/client.h"

#include <hiredis/hiredis.h>

#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>

#include "common/log.h"
#include "common/wire/redis_address.h"
#include "common/wire/tls_tunnel.h"

namespace diaphane::api::redis {
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
              "The session store is not available; try again in a moment.");
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

/// Redis's own refusals that pass by themselves.
bool is_temporary(std::string_view error) {
  for (std::string_view prefix : {"LOADING", "BUSY", "OOM", "READONLY", "MASTERDOWN", "CLUSTERDOWN",
                                  "MISCONF", "NOREPLICAS", "TRYAGAIN"}) {
    if (error.starts_with(prefix)) return true;
  }
  return false;
}

}  // namespace

struct Client::Impl {
  Options options;
  wire::RedisAddress address;
  std::unique_ptr<wire::TlsTunnels> tunnels;  ///< where there is TLS; outlives the connections

  std::mutex mutex;
  std::condition_variable returned;
  std::vector<Context> idle;
  std::size_t lent = 0;

  /// One connection, lent to one call; given back when it is still sound.
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

  /// An idle connection, or a null one to be connected; nothing when all were busy until
  /// `deadline`.
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

  static RawReply send(redisContext* context, const Arguments& words) {
    std::vector<const char*> starts;
    std::vector<std::size_t> lengths;
    for (std::string_view word : words) {
      starts.push_back(word.data());
      lengths.push_back(word.size());
    }
    return RawReply(static_cast<redisReply*>(
        redisCommandArgv(context, static_cast<int>(words.size()), starts.data(), lengths.data())));
  }

  Result<RawReply> call(const Arguments& words) {
    std::optional<Context> context =
        borrow(std::chrono::steady_clock::now() + options.command_timeout);
    if (!context) return away();
    const bool reused = *context != nullptr;
    if (!reused) *context = connect(options.connect_timeout, options.command_timeout);
    Lease lease(*this, std::move(*context));
    if (lease.get() == nullptr) return away();
    RawReply reply = send(lease.get(), words);
    // An idle connection may have died with its Redis. A script that was run twice does no harm:
    // each is idempotent, and a ticket used up by a lost answer is asked for again.
    if (!reply && reused && lease.get()->err == REDIS_ERR_EOF) {
      forget_idle();
      lease.replace(connect(options.connect_timeout, options.command_timeout));
      if (lease.get() == nullptr) return away();
      reply = send(lease.get(), words);
    }
    if (!reply) return away();
    return reply;
  }
};

Result<std::unique_ptr<Client>> Client::create(Options options) {
  auto impl = std::make_unique<Impl>();
  auto address = wire::parse_redis_address(options.address);
  if (!address) return fail(ErrorCode::kInvalid, address.error().message, "redis");
  if (address->with_tls) {
    if (!options.tls.on()) {
      return fail(ErrorCode::kInvalid, "rediss:// needs --inner-tls-ca and those with it", "redis");
    }
    impl->tunnels = std::make_unique<wire::TlsTunnels>(options.tls.files);
  } else if (auto plain = wire::may_be_plain(options.address, options.tls); !plain) {
    return fail(ErrorCode::kInvalid, plain.error().message, "redis");
  }
  impl->address = *std::move(address);
  if (options.connections == 0) return fail(ErrorCode::kInvalid, "needs at least one connection");
  impl->options = std::move(options);
  return std::unique_ptr<Client>(new Client(std::move(impl)));
}

Client::Client(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Client::~Client() = default;

Result<Reply> Client::command(const Arguments& words) {
  Result<RawReply> raw = impl_->call(words);
  if (!raw) return tl::unexpected(raw.error());
  if ((*raw)->type == REDIS_REPLY_ERROR) {
    const std::string_view text((*raw)->str, (*raw)->len);
    if (is_temporary(text)) return away();
    return fail(ErrorCode::kInternal, "Redis refused a command: " + std::string(text));
  }
  return to_reply(**raw);
}

Result<Reply> Client::run(const Script& script, const Arguments& arguments) {
  Arguments words{"EVALSHA", script.sha1, "0"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  Result<RawReply> raw = impl_->call(words);
  if (raw && (*raw)->type == REDIS_REPLY_ERROR &&
      std::string_view((*raw)->str, (*raw)->len).starts_with("NOSCRIPT")) {
    words[0] = "EVAL";
    words[1] = script.source;
  } else if (!raw) {
    return tl::unexpected(raw.error());
  } else if ((*raw)->type != REDIS_REPLY_ERROR) {
    return to_reply(**raw);
  } else if (is_temporary(std::string_view((*raw)->str, (*raw)->len))) {
    return away();
  } else {
    return fail(ErrorCode::kInternal, "Redis refused " + std::string(script.name) +
                                          ".lua: " + std::string((*raw)->str, (*raw)->len));
  }
  return command(words);
}

bool Client::answers(std::chrono::milliseconds timeout) {
  // A connection of its own: one of the pool may have died, and all may be busy.
  const Context probe = impl_->connect(timeout / 2, timeout / 2);
  if (!probe) return false;
  const RawReply reply = Impl::send(probe.get(), {"PING"});
  return reply && reply->type == REDIS_REPLY_STATUS;
}

}  // namespace diaphane::api::redis
