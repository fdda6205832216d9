#include "operator/kube/informer.h"

#include <condition_variable>
#include <mutex>

#include "common/log.h"
#include "operator/kube/api.h"
#include "operator/kube/fields.h"

namespace diaphane::kube {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;
using std::chrono::seconds;
using std::chrono::steady_clock;

constexpr milliseconds kListTimeout{30000};
/// A watch that ends sooner without an event counts as a failure, to avoid a busy loop.
constexpr milliseconds kTooShort{1000};

std::string metadata(const json& object, const char* key) {
  return text(part(object, "metadata"), key);
}

/// URL-encodes a token for the next page.
std::string encoded(const std::string& text) {
  static constexpr char kHex[] = "0123456789ABCDEF";
  std::string out;
  for (const char one : text) {
    const auto byte = static_cast<unsigned char>(one);
    if (std::isalnum(byte) || one == '-' || one == '_' || one == '.' || one == '~') {
      out += one;
    } else {
      out += {'%', kHex[byte >> 4U], kHex[byte & 15U]};
    }
  }
  return out;
}

}  // namespace

std::string key_of(const json& object, const std::string& home) {
  const std::string space = metadata(object, "namespace");
  std::string name = metadata(object, "name");
  return space.empty() || space == home ? name : space + "/" + name;
}

std::string version_of(const json& object) { return metadata(object, "resourceVersion"); }

Reflector::Reflector(Options options, Transport& transport, Sink& sink)
    : options_(std::move(options)),
      transport_(transport),
      sink_(sink),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

double Reflector::random() { return std::uniform_real_distribution<double>(0, 1)(random_); }

void Reflector::run(const std::stop_token& stop) {
  Backoff backoff(options_.backoff);
  std::mutex mutex;
  std::condition_variable_any wake;
  std::unique_lock lock(mutex);
  std::string version;
  bool known = false;
  while (!stop.stop_requested()) {
    const Outcome outcome = known ? watch(version) : list(version);
    if (outcome == Outcome::kContinue) {
      known = true;
      continue;
    }
    if (outcome == Outcome::kListAgain) {
      ++counts_.expired;
      log::info("relist", {{"kind", options_.kind}});
      known = false;
    }
    ++counts_.failures;
    wake.wait_for(lock, stop, backoff.next(steady_clock::now(), random()), [] { return false; });
  }
}

Reflector::Outcome Reflector::list(std::string& version) {
  ++counts_.lists;
  sink_.list_begins();
  std::string next;
  do {
    Request request{.path = options_.path, .query = "limit=" + std::to_string(options_.page)};
    if (!options_.selector.empty()) request.query += "&" + options_.selector;
    if (!next.empty()) request.query += "&continue=" + encoded(next);
    const auto answer = transport_.call(request, kListTimeout);
    const json body = answer ? json::parse(answer->body, nullptr, false) : json();
    if (!answer || answer->status != 200 || !body.is_object()) {
      connected_ = false;
      if (answer && must_list_again(answer->status, body)) return Outcome::kListAgain;
      log::warning("list_failed", {{"kind", options_.kind},
                                   {"message", answer ? error_of(answer->status, body).message
                                                      : answer.error().message}});
      return Outcome::kFailed;
    }
    if (const auto items = body.find("items"); items != body.end() && items->is_array()) {
      for (const json& item : *items) sink_.listed(item);
    }
    next = metadata(body, "continue");
    version = metadata(body, "resourceVersion");
  } while (!next.empty());
  connected_ = true;
  sink_.list_ends(version);
  return Outcome::kContinue;
}

Reflector::Outcome Reflector::watch(std::string& version) {
  ++counts_.watches;
  const auto span = std::chrono::duration_cast<seconds>(
      options_.shortest_watch + (options_.longest_watch - options_.shortest_watch) * random());
  Request request{.path = options_.path,
                  .query = "watch=1&allowWatchBookmarks=true&resourceVersion=" + encoded(version) +
                           "&timeoutSeconds=" + std::to_string(span.count())};
  if (!options_.selector.empty()) request.query += "&" + options_.selector;
  WatchReader reader;
  Outcome outcome = Outcome::kContinue;
  bool any = false;
  bool answered = false;
  const auto begun = steady_clock::now();
  auto last_data = begun;
  const auto answer = transport_.stream(request, options_.silence, [&](std::string_view bytes) {
    connected_ = answered = true;
    last_data = steady_clock::now();
    for (const WatchEvent& event : reader.feed(bytes)) {
      if (event.type == WatchEvent::Type::kExpired) {
        outcome = Outcome::kListAgain;
      } else if (event.type == WatchEvent::Type::kError) {
        outcome = Outcome::kFailed;
      }
      if (outcome != Outcome::kContinue) return false;
      any = true;
      ++counts_.events;
      if (auto now = metadata(event.object, "resourceVersion"); !now.empty()) {
        version = std::move(now);
      }
      sink_.event(event);
    }
    return true;
  });
  if (outcome != Outcome::kContinue) return outcome;
  if (!answer && answered && steady_clock::now() - last_data >= options_.silence / 2) {
    // The connection is broken, or the server sends no bookmarks. This is not known to be a
    // failure, so the next watch starts at once over another connection.
    connected_ = false;
    ++counts_.silent;
    log::warning("watch_silent", {{"kind", options_.kind}});
    return Outcome::kContinue;
  }
  if (!answer || answer->status != 200) {
    connected_ = false;
    const json body = answer ? json::parse(answer->body, nullptr, false) : json();
    if (answer && must_list_again(answer->status, body)) return Outcome::kListAgain;
    log::warning("watch_failed", {{"kind", options_.kind},
                                  {"message", answer ? error_of(answer->status, body).message
                                                     : answer.error().message}});
    return Outcome::kFailed;
  }
  connected_ = true;
  const bool too_short = !any && steady_clock::now() - begun < kTooShort;
  return too_short ? Outcome::kFailed : Outcome::kContinue;
}

}  // namespace diaphane::kube
