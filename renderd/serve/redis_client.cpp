#include "renderd/serve/redis_client.h"

#include <hiredis/hiredis.h>
#include <sys/time.h>

#include <map>

#include "common/log.h"
#include "common/wire/tls_tunnel.h"

namespace diaphane::render {
namespace {

constexpr timeval kConnectTimeout{1, 0};
constexpr timeval kCommandTimeout{1, 0};

struct FreeContext {
  void operator()(redisContext* context) const { redisFree(context); }
};
struct FreeReply {
  void operator()(redisReply* reply) const { freeReplyObject(reply); }
};
using Reply = std::unique_ptr<redisReply, FreeReply>;

std::string text_of(const redisReply& reply) {
  return reply.str ? std::string(reply.str, static_cast<std::size_t>(reply.len)) : std::string();
}

}  // namespace

struct RedisClient::Impl {
  wire::RedisAddress address;
  std::unique_ptr<wire::TlsTunnels> tunnels;
  std::unique_ptr<redisContext, FreeContext> context;
  std::map<std::string, std::string, std::less<>> hashes;  // of scripts, by text

  Result<void> connect() {
    if (context) return {};
    if (tunnels) {
      const auto local =
          tunnels->open(address.host, address.port, std::chrono::seconds(kConnectTimeout.tv_sec));
      if (!local) {
        log::warning("redis", {{"reason", local.error().message}});
        return fail(ErrorCode::kUnavailable, "Redis does not answer.");
      }
      context.reset(redisConnectFd(*local));
    } else if (!address.path.empty()) {
      context.reset(redisConnectUnixWithTimeout(address.path.c_str(), kConnectTimeout));
    } else {
      context.reset(redisConnectWithTimeout(address.host.c_str(), address.port, kConnectTimeout));
    }
    if (!context || context->err != 0) {
      context.reset();
      return fail(ErrorCode::kUnavailable, "Redis does not answer.");
    }
    redisSetTimeout(context.get(), kCommandTimeout);
    return {};
  }

  Result<Reply> call(const std::vector<std::string>& words) {
    if (const auto ready = connect(); !ready) return tl::unexpected(ready.error());
    std::vector<const char*> texts;
    std::vector<std::size_t> lengths;
    for (const std::string& word : words) {
      texts.push_back(word.data());
      lengths.push_back(word.size());
    }
    Reply reply(static_cast<redisReply*>(redisCommandArgv(
        context.get(), static_cast<int>(words.size()), texts.data(), lengths.data())));
    if (!reply) {
      context.reset();  // the state of the conversation is unknown
      return fail(ErrorCode::kUnavailable, "Redis does not answer.");
    }
    return reply;
  }
};

RedisClient::RedisClient(wire::RedisAddress address) : impl_(std::make_unique<Impl>()) {
  if (address.with_tls) impl_->tunnels = std::make_unique<wire::TlsTunnels>(address.tls);
  impl_->address = std::move(address);
}
RedisClient::~RedisClient() = default;

bool RedisClient::connected() const { return impl_->context != nullptr; }

Result<RedisClient::Answer> RedisClient::command(const std::vector<std::string>& words) {
  const auto reply = impl_->call(words);
  if (!reply) return tl::unexpected(reply.error());
  const redisReply& got = **reply;
  if (got.type == REDIS_REPLY_ERROR) {
    const std::string text = text_of(got);
    // LOADING, READONLY, MASTERDOWN: Redis is there, but not for us yet.
    const bool later = text.starts_with("LOADING") || text.starts_with("MASTERDOWN");
    return fail(later ? ErrorCode::kUnavailable : ErrorCode::kInternal, text);
  }
  Answer answer;
  answer.number = got.integer;
  if (got.type == REDIS_REPLY_STRING || got.type == REDIS_REPLY_STATUS) {
    answer.list.push_back(text_of(got));
  }
  for (std::size_t i = 0; i < got.elements; ++i) answer.list.push_back(text_of(*got.element[i]));
  return answer;
}

Result<RedisClient::Answer> RedisClient::run(std::string_view script,
                                             const std::vector<std::string>& keys,
                                             const std::vector<std::string>& arguments) {
  auto hash = impl_->hashes.find(script);
  if (hash == impl_->hashes.end()) {
    const auto loaded = command({"SCRIPT", "LOAD", std::string(script)});
    if (!loaded) return tl::unexpected(loaded.error());
    if (loaded->list.empty()) return fail(ErrorCode::kInternal, "Redis took no script.");
    hash = impl_->hashes.emplace(script, loaded->list.front()).first;
  }
  std::vector<std::string> words{"EVALSHA", hash->second, std::to_string(keys.size())};
  words.insert(words.end(), keys.begin(), keys.end());
  words.insert(words.end(), arguments.begin(), arguments.end());
  auto answer = command(words);
  if (!answer && answer.error().message.starts_with("NOSCRIPT")) {
    // Redis was restarted and forgot it.
    words[0] = "EVAL";
    words[1] = std::string(script);
    answer = command(words);
  }
  return answer;
}

}  // namespace diaphane::render
